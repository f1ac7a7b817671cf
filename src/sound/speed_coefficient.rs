//! Level at a reference speed and its growth, as in UN R117 (annex 3, section 4) from a set of coast-bys.
//!
//! Least squares of L = L_ref + b lg(v/v_ref) over the speeds. With n levels L_i at x_i = lg(v_i/v_ref), s^2 = sum of
//! the squared residuals over n - 2, S = sum (x_i - mean x)^2 and t the two-sided 95 % quantile of Student's
//! distribution for n - 2 degrees of freedom, the 95 % intervals are
//!
//! ```text
//! b +- t s/sqrt(S),   L_ref +- t s sqrt(1/n + (mean x)^2/S)
//! ```
//!
//! R117 requires at least four speeds on either side of v_ref within +-10 km/h, v_ref 80 km/h for tyres of classes C1
//! and C2, 70 km/h for C3; the regression itself accepts any.

use crate::numeric::quantile_of_student;
use crate::response::SpeedExponent;

/// Growth of a level with the speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SpeedCoefficient {
    /// Slope b, its residual, and the number of speeds.
    pub slope: SpeedExponent,
    /// Half the width of the 95 % interval of b \[dB per decade\]; `None` for two levels, which leave no residual.
    pub slope_interval: Option<f64>,
    /// Level L_ref on the line at the reference speed \[dB\].
    pub reference_level: f64,
    /// Half the width of its 95 % interval \[dB\]; `None` for two levels.
    pub reference_interval: Option<f64>,
}

impl SpeedCoefficient {
    /// Fits pairs of speed and level \[dB\], speeds in the unit of `reference_speed`; pairs without a finite level do
    /// not count. `None` for fewer than two different speeds.
    pub(crate) fn fit(pairs: impl IntoIterator<Item = (f64, f64)>, reference_speed: f64) -> Option<Self> {
        let relative: Vec<(f64, f64)> = pairs
            .into_iter()
            .map(|(speed, level)| (speed / reference_speed, level))
            .filter(|(speed, level)| speed.is_finite() && *speed > 0.0 && level.is_finite())
            .collect();
        let slope = SpeedExponent::fit(relative.iter().copied())?;
        let count = relative.len() as f64;
        let mean = |value: &dyn Fn(&(f64, f64)) -> f64| relative.iter().map(value).sum::<f64>() / count;
        let (middle, level) = (mean(&|pair| pair.0.log10()), mean(&|pair| pair.1));
        let spread = count * mean(&|pair| (pair.0.log10() - middle).powi(2));
        let scatter = quantile_of_student(relative.len() - 2)
            .zip(slope.residual)
            .map(|(quantile, residual)| quantile * residual * (count / (count - 2.0)).sqrt());
        Some(Self {
            slope,
            slope_interval: scatter.map(|scatter| scatter / spread.sqrt()),
            reference_level: level - slope.decibels_per_decade * middle,
            reference_interval: scatter.map(|scatter| scatter * (1.0 / count + middle * middle / spread).sqrt()),
        })
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    #[test]
    fn a_line_is_found_and_scatter_gives_its_interval() {
        let line = |speed: f64| 70.5 + 31.0 * (speed / 80.0).log10();
        let exact = SpeedCoefficient::fit([70.0, 74.0, 83.0, 90.0].map(|v| (v, line(v))), 80.0).unwrap();
        assert!((exact.slope.decibels_per_decade - 31.0).abs() < 1e-10 && (exact.reference_level - 70.5).abs() < 1e-12);
        assert!(exact.slope_interval.unwrap() < 1e-9 && exact.reference_interval.unwrap() < 1e-11);
        // By hand: x = -1, 0, 1 and levels 0, 3, 0 have the mean 1, slope 0, residuals -1, 2, -1: s = sqrt(6), S = 2, t
        // = 12.706.
        let bent = SpeedCoefficient::fit([(8.0, 0.0), (80.0, 3.0), (800.0, 0.0)], 80.0).unwrap();
        assert!(bent.slope.decibels_per_decade.abs() < 1e-12 && (bent.reference_level - 1.0).abs() < 1e-12);
        assert!((bent.slope_interval.unwrap() - 12.706 * 3.0_f64.sqrt()).abs() < 1e-3);
        assert!((bent.reference_interval.unwrap() - 12.706 * 2.0_f64.sqrt()).abs() < 1e-3);
    }

    #[test]
    fn the_interval_holds_the_true_slope_19_times_of_20() {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let trials = 4000;
        let mut held = [0, 0];
        for _ in 0..trials {
            let levels = (0..8).map(|run| {
                let speed = 70.0 + 2.5 * f64::from(run);
                // The sum of twelve uniform numbers is nearly normal, of variance 1.
                let normal = (0..12).map(|_| random.random_range(-0.5..0.5)).sum::<f64>();
                (speed, 70.0 + 30.0 * (speed / 80.0).log10() + 0.4 * normal)
            });
            let found = SpeedCoefficient::fit(levels, 80.0).unwrap();
            let off = [found.slope.decibels_per_decade - 30.0, found.reference_level - 70.0];
            let intervals = [found.slope_interval.unwrap(), found.reference_interval.unwrap()];
            for ((held, off), interval) in held.iter_mut().zip(off).zip(intervals) {
                *held += i32::from(off.abs() < interval);
            }
        }
        // Binomial scatter of 4000 trials: 0.34 % standard deviation; four of them.
        for held in held {
            let share = f64::from(held) / f64::from(trials);
            assert!((share - 0.95).abs() < 0.014, "{share}");
        }
    }

    #[test]
    fn two_speeds_have_a_slope_but_no_interval_and_one_has_nothing() {
        let two = SpeedCoefficient::fit([(50.0, 60.0), (100.0, 69.0), (80.0, f64::NEG_INFINITY)], 80.0).unwrap();
        assert!((two.slope.decibels_per_decade - 29.897).abs() < 1e-3);
        assert_eq!((two.slope_interval, two.reference_interval), (None, None));
        assert_eq!(SpeedCoefficient::fit([(80.0, 60.0), (80.0, 61.0)], 80.0), None);
        assert_eq!(SpeedCoefficient::fit([], 80.0), None);
    }
}
