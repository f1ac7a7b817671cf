//! Moments of a stream, a straight line through points, Student's distribution.

use serde::{Deserialize, Serialize};

/// Mean and variance of a stream so far, without keeping it and without cancellation.
///
/// Welford's recurrence (1962, *Technometrics* 4, 419) on the differences from the first value: a signal that hardly
/// moves on a large mean keeps its variance to rounding of the movement, not of the mean.
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

/// A straight line through points, y = intercept + slope x, by least squares.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct StraightLine {
    /// Change of y per unit of x.
    pub slope: f64,
    /// y at x = 0.
    pub intercept: f64,
    /// Root mean square of the residuals.
    pub residual: f64,
}

impl StraightLine {
    /// Fits a line through at least two points of different x; `None` otherwise.
    pub(crate) fn through(points: &[(f64, f64)]) -> Option<Self> {
        let count = points.len() as f64;
        let mean = |value: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(value).sum::<f64>() / count;
        let (x, y) = (mean(&|point| point.0), mean(&|point| point.1));
        let spread = mean(&|point| (point.0 - x).powi(2));
        // Positions that agree to rounding are one.
        if points.len() < 2 || spread <= 1e-20 * (1.0 + x * x) {
            return None;
        }
        let slope = mean(&|point| (point.0 - x) * (point.1 - y)) / spread;
        let intercept = y - slope * x;
        let residual = mean(&|point| (point.1 - intercept - slope * point.0).powi(2)).sqrt();
        Some(Self { slope, intercept, residual })
    }

    /// The line through the base-10 logarithms of positive values: y ~ x^slope.
    pub(crate) fn power_law(points: &[(f64, f64)]) -> Option<Self> {
        let logarithms: Vec<_> = points.iter().map(|point| (point.0.log10(), point.1.log10())).collect();
        Self::through(&logarithms)
    }
}

/// Student's distribution: probability that |t| stays below a value for so many degrees of freedom (at least 1):
/// Abramowitz and Stegun, 26.7.3 and 26.7.4.
fn probability_of_student(value: f64, freedom: usize) -> f64 {
    let angle = (value / (freedom as f64).sqrt()).atan();
    let (sine, cosine) = angle.sin_cos();
    // cos + 2/3 cos^3 + ... + (2 4 ...)/(3 5 ...) cos^(n-2) for odd n, 1 + 1/2 cos^2 + ... for even n.
    let odd = freedom % 2;
    let mut term = if odd == 1 { cosine } else { 1.0 };
    let mut sum = 0.0;
    for power in (odd..freedom.saturating_sub(1)).step_by(2) {
        sum += term;
        term *= cosine * cosine * (power + 1) as f64 / (power + 2) as f64;
    }
    if odd == 1 { std::f64::consts::FRAC_2_PI * (angle + sine * sum) } else { sine * sum }
}

/// Two-sided 95 % quantile: |t| stays below it with a probability of 95 %; `None` without a degree of freedom.
pub(crate) fn quantile_of_student(freedom: usize) -> Option<f64> {
    if freedom == 0 {
        return None;
    }
    // 12.7 for one degree of freedom, falling to 1.96; 60 bisections end at rounding.
    let (mut low, mut high) = (1.9, 13.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if probability_of_student(middle, freedom) < 0.95 {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some(0.5 * (low + high))
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

    #[test]
    fn a_line_is_found_again_and_what_is_no_line_leaves_a_residual() {
        let line = StraightLine::through(&[(1.0, 5.0), (2.0, 7.0), (4.0, 11.0)]).expect("a line");
        assert!((line.slope - 2.0).abs() < 1e-14 && (line.intercept - 3.0).abs() < 1e-14 && line.residual < 1e-14);
        let bent = StraightLine::through(&[(0.0, 0.0), (1.0, 3.0), (2.0, 0.0)]).expect("a line");
        assert!((bent.residual - 2.0_f64.sqrt()).abs() < 1e-14, "{bent:?}");
        let cubic = StraightLine::power_law(&[(10.0, 2e3), (100.0, 2e6)]).expect("a line");
        assert!((cubic.slope - 3.0).abs() < 1e-14);
        assert_eq!(StraightLine::through(&[(1.0, 2.0), (1.0, 3.0)]), None);
        assert_eq!(StraightLine::through(&[(1.0, 2.0)]), None);
    }

    #[test]
    fn quantiles_are_those_of_the_tables() {
        // Abramowitz and Stegun, table 26.10.
        for (freedom, quantile) in
            [(1, 12.706), (2, 4.303), (3, 3.182), (4, 2.776), (5, 2.571), (6, 2.447), (10, 2.228), (30, 2.042)]
        {
            let found = quantile_of_student(freedom).unwrap();
            assert!((found - quantile).abs() < 6e-4, "{freedom}: {found}");
        }
        assert_eq!(quantile_of_student(0), None);
    }
}
