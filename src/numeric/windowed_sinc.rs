//! Band-limited resampling: a Kaiser-windowed sinc, tabulated.
//!
//! 1. The kernel is h(t) = 2 c sinc(2 pi c t) K(t/T), t in samples of the coarser lattice, c its cut-off in cycles per
//!    sample (the middle of the transition), K the Kaiser window of half-width T.
//! 2. Kaiser's formulas give window and width from the attenuation A and the transition width D (cycles per sample):
//!    beta = 0.1102 (A - 8.7), 2 T = (A - 7.95) / (14.36 D).
//! 3. The kernel is tabulated once; values between are interpolated linearly (error below 2e-7 of the peak).
//!
//! Where the lattice read from is the coarser one, all positions as far from a sample of it have the same weights:
//! [`Phases`] has them by that distance.
//!
//! J. F. Kaiser, *Nonrecursive digital filter design using the I0-sinh window function* (1974).

use std::ops::{Add, Mul, Sub};

/// A symmetric interpolation and low-pass kernel. The unit of t is one sample of the coarser lattice.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct WindowedSinc {
    /// Half-width T of the support \[samples of the coarser lattice\].
    pub(crate) half_width: f64,
    table: Vec<f64>,
}

/// Table entries per unit of t.
const PER_UNIT: f64 = 2048.0;

impl WindowedSinc {
    /// A kernel that passes up to `pass` and blocks from `stop` on (cycles per sample, `pass` < `stop`) by
    /// `attenuation` \[dB\].
    pub(crate) fn new(pass: f64, stop: f64, attenuation: f64) -> Self {
        let half_width = ((attenuation - 7.95) / (14.36 * (stop - pass)) / 2.0).ceil().max(1.0);
        let beta = 0.1102 * (attenuation - 8.7);
        let cutoff = 0.5 * (pass + stop);
        let entries = (half_width * PER_UNIT) as usize;
        let peak = bessel_i0(beta);
        let value = |index: usize| {
            let t = index as f64 / PER_UNIT;
            let argument = std::f64::consts::PI * 2.0 * cutoff * t;
            let sinc = if index == 0 { 1.0 } else { argument.sin() / argument };
            let ratio = t / half_width;
            2.0 * cutoff * sinc * bessel_i0(beta * (1.0 - ratio * ratio).max(0.0).sqrt()) / peak
        };
        // One zero past the end so that interpolation needs no bounds test at the rim.
        let table = (0..=entries).map(value).chain([0.0, 0.0]).collect();
        Self { half_width, table }
    }

    /// Kernel of this project's resampling: flat to 0.8 of the coarser Nyquist wavenumber, 80 dB down from the Nyquist
    /// wavenumber on.
    pub(crate) fn resampling() -> Self {
        Self::new(0.4, 0.5, 80.0)
    }

    /// h(t); zero for |t| >= T.
    pub(crate) fn at(&self, t: f64) -> f64 {
        let place = t.abs() * PER_UNIT;
        let index = place as usize;
        if index + 1 >= self.table.len() {
            return 0.0;
        }
        let part = place - index as f64;
        self.table[index] + part * (self.table[index + 1] - self.table[index])
    }

    /// Writes the weights of the source samples around `position` (in source samples), their sum 1: `weights[i]`
    /// belongs to sample first + i; returns `first`. `ratio` >= 1 is the coarser spacing over the source's.
    pub(crate) fn weights(&self, position: f64, ratio: f64, weights: &mut Vec<f64>) -> i64 {
        let reach = self.half_width * ratio;
        let first = (position - reach).ceil() as i64;
        let last = (position + reach).floor() as i64;
        weights.clear();
        weights.extend((first..last + 1).map(|sample| self.at((sample as f64 - position) / ratio)));
        let sum: f64 = weights.iter().sum();
        for weight in weights.iter_mut() {
            *weight /= sum;
        }
        first
    }
}

/// A kernel's weights of the samples round a position, tabulated by the distance of the position from the sample
/// before.
#[derive(Clone, Debug)]
pub(crate) struct Phases<T> {
    /// Samples on either side within the kernel.
    reach: usize,
    places: usize,
    /// Rounding to the number type of the table.
    rounded: fn(f64) -> T,
    /// For each place from a sample to the next, both included, 2 `reach` weights, their sum 1.
    table: Vec<T>,
}

impl<T: Copy + Add<Output = T> + Sub<Output = T> + Mul<Output = T>> Phases<T> {
    /// Tabulates the kernel at `places` positions per sample, its weights `rounded` to the table's number type.
    pub(crate) fn new(kernel: &WindowedSinc, places: usize, rounded: fn(f64) -> T) -> Self {
        let reach = kernel.half_width.ceil() as usize;
        let mut table = Vec::with_capacity((places + 1) * 2 * reach);
        for place in 0..=places {
            let part = place as f64 / places as f64;
            let at = |tap: usize| kernel.at(tap as f64 - (reach as f64 - 1.0) - part);
            let sum: f64 = (0..2 * reach).map(at).sum();
            table.extend((0..2 * reach).map(|tap| rounded(at(tap) / sum)));
        }
        Self { reach, places, rounded, table }
    }

    /// Samples on either side of a position that have weights.
    pub(crate) fn reach(&self) -> usize {
        self.reach
    }

    /// Weights of the samples from floor(position) - reach + 1 on, interpolated linearly between the places before and
    /// after the position.
    pub(crate) fn weights(&self, position: f64) -> impl Iterator<Item = T> {
        let taps = 2 * self.reach;
        let fine = (position - position.floor()) * self.places as f64;
        let place = (fine as usize).min(self.places - 1);
        let (before, after) = self.table[place * taps..(place + 2) * taps].split_at(taps);
        let part = (self.rounded)(fine - place as f64);
        before.iter().zip(after).map(move |(&before, &after)| before + part * (after - before))
    }
}

/// Modified Bessel function I0 by its power series, all terms positive: full accuracy for the arguments of a window
/// (0..20).
fn bessel_i0(x: f64) -> f64 {
    let quarter = 0.25 * x * x;
    let mut term = 1.0;
    let mut sum = 1.0;
    let mut k = 1.0;
    while term > 1e-17 * sum {
        term *= quarter / (k * k);
        sum += term;
        k += 1.0;
    }
    sum
}

/// sin(x)/x; 1 at 0, by its series for |x| < 1e-4, where the next term is below rounding.
pub(crate) fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-4 { 1.0 - x * x / 6.0 } else { x.sin() / x }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bessel_matches_tabulated_values() {
        // Abramowitz and Stegun, table 9.8 (as e^x times the scaled value), and I0(0) = 1.
        for (x, expected) in
            [(0.0, 1.0), (1.0, 1.266_065_877_752_008_4), (5.0, 27.239_871_823_604_44), (10.0, 2_815.716_628_466_254)]
        {
            assert!((bessel_i0(x) / expected - 1.0).abs() < 1e-14, "I0({x})");
        }
    }

    #[test]
    fn frequency_response_passes_and_blocks_as_designed() {
        let kernel = WindowedSinc::resampling();
        let response = |wavenumber: f64| {
            let steps = 64;
            let reach = (kernel.half_width * f64::from(steps)) as i64;
            let sum: f64 = (-reach..=reach)
                .map(|i| i as f64 / f64::from(steps))
                .map(|t| kernel.at(t) * (2.0 * std::f64::consts::PI * wavenumber * t).cos())
                .sum();
            sum / f64::from(steps)
        };
        for step in 0..=40 {
            let passed = response(0.01 * f64::from(step));
            assert!((passed - 1.0).abs() < 2e-4, "{passed} at {step} hundredths");
        }
        for step in 50..=150 {
            let blocked = response(0.01 * f64::from(step));
            assert!(blocked.abs() < 2e-4, "{blocked} at {step} hundredths");
        }
    }

    #[test]
    fn weights_sum_to_one_and_keep_a_constant() {
        let kernel = WindowedSinc::resampling();
        let mut weights = Vec::new();
        for (position, ratio) in [(0.0, 1.0), (17.3, 1.0), (-4.75, 3.81), (1000.5, 100.0)] {
            let first = kernel.weights(position, ratio, &mut weights);
            assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-14);
            let centre: f64 = weights.iter().enumerate().map(|(i, w)| w * (first + i as i64) as f64).sum();
            assert!((centre - position).abs() < 2e-3 * ratio, "linear functions are kept: {centre} for {position}");
        }
    }
}
