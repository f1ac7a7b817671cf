//! Mean and variance of a stream, without keeping it and without cancellation.
//!
//! Welford's recurrence (1962, *Technometrics* 4, 419) on the differences from the first value: a signal that hardly
//! moves on a large mean keeps its variance to rounding of the movement, not of the mean.

use serde::{Deserialize, Serialize};

/// Moments so far.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub(crate) struct RunningMoments {
    count: u64,
    /// First value; 0 before there is one.
    pub(crate) shift: f64,
    /// Mean of the differences from it.
    mean: f64,
    /// Sum of squares of the differences from the mean.
    squares: f64,
}

impl RunningMoments {
    pub(crate) fn push(&mut self, value: f64) {
        if self.count == 0 {
            self.shift = value;
        }
        self.count += 1;
        let shifted = value - self.shift;
        let before = shifted - self.mean;
        self.mean += before / self.count as f64;
        self.squares += before * (shifted - self.mean);
    }

    pub(crate) fn count(&self) -> u64 {
        self.count
    }

    /// Mean less the first value.
    pub(crate) fn mean_of_shifted(&self) -> f64 {
        self.mean
    }

    /// `None` before the first value.
    pub(crate) fn mean(&self) -> Option<f64> {
        (self.count > 0).then_some(self.shift + self.mean)
    }

    /// Mean square of the values less their mean (divided by the count, not the count less 1); `None` before the first
    /// value.
    pub(crate) fn variance(&self) -> Option<f64> {
        (self.count > 0).then(|| self.squares / self.count as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tiny_movement_on_a_large_mean_keeps_its_variance() {
        // 1e-9 on 4000: sums of squares would lose all of it, two passes give it to 1e-4 (the rounding of the values
        // themselves).
        let signal: Vec<f64> = (0..10_000).map(|n| 4000.0 + 1e-9 * (0.1 * f64::from(n)).sin()).collect();
        let mut moments = RunningMoments::default();
        signal.iter().for_each(|&value| moments.push(value));
        let mean = signal.iter().map(|x| x - 4000.0).sum::<f64>() / 1e4;
        let variance = signal.iter().map(|x| (x - 4000.0 - mean).powi(2)).sum::<f64>() / 1e4;
        assert!((moments.variance().unwrap() / variance - 1.0).abs() < 1e-9);
        assert!((moments.mean().unwrap() - 4000.0).abs() < 1e-12);
        let mut constant = RunningMoments::default();
        (0..100).for_each(|_| constant.push(0.1));
        assert_eq!((constant.mean().map(f64::to_bits), constant.variance()), (Some(0.1_f64.to_bits()), Some(0.0)));
        assert_eq!(RunningMoments::default().variance(), None);
    }
}
