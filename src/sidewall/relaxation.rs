//! Losses of a sidewall: f(s) = 1 + sum of g_j s T_j/(1 + s T_j), positive real, 1 at rest.
//!
//! A loss factor eta that hardly depends on frequency is that of a modulus ~ s^gamma, gamma = 2 atan(eta)/pi. Terms at
//! frequencies f_j = f_0 q^j with the strengths g_j = (q^gamma - 1) q^(j gamma) follow that modulus from term to term.

use std::f64::consts::{PI, TAU};

use num_complex::Complex64;

/// Frequency of the lowest term \[Hz\], ratio of neighbouring frequencies, and number of terms: the loss factor is
/// within 10 % of that asked for from 100 Hz to 3 kHz, within 25 % from 30 Hz on, up to 0.4 (within 15 % up to 1 at 1
/// kHz). Terms at lower frequencies would stiffen what the pressure holds (by a factor of 1.24 at 100 Hz for a loss
/// factor of 0.15).
const LOWEST: f64 = 25.0;
const RATIO: f64 = 4.0;
const TERMS: i32 = 6;

/// Relaxation terms of a stiffness; none: elastic.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Relaxation {
    /// Strengths g_j and times T_j \[s\].
    pub terms: Vec<[f64; 2]>,
}

impl Relaxation {
    /// Terms of a nearly constant loss factor from 100 Hz to 3 kHz; none for 0.
    pub fn of_loss_factor(loss_factor: f64) -> Self {
        if loss_factor <= 0.0 {
            return Self::default();
        }
        let rise = RATIO.powf(2.0 * loss_factor.atan() / PI);
        let term = |j: i32| [(rise - 1.0) * rise.powi(j), 1.0 / (TAU * LOWEST * RATIO.powi(j))];
        Self { terms: (0..TERMS).map(term).collect() }
    }

    /// f(s), the factor on tension, pressure and stiffness.
    pub fn at(&self, s: Complex64) -> Complex64 {
        let sum: Complex64 = self.terms.iter().map(|&[strength, time]| s * (strength * time) / (s * time + 1.0)).sum();
        sum + 1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_loss_factor_is_that_given_over_the_range_that_matters() {
        for (wanted, highest, least) in
            [(0.02, 3e3, 0.93), (0.1, 3e3, 0.93), (0.2, 3e3, 0.93), (0.4, 3e3, 0.9), (1.0, 1e3, 0.85)]
        {
            let relaxation = Relaxation::of_loss_factor(wanted);
            let mut range = [f64::INFINITY, 0.0_f64];
            for step in 0..=60 {
                let frequency = 100.0 * (highest / 100.0_f64).powf(f64::from(step) / 60.0);
                let f = relaxation.at(Complex64::new(0.0, TAU * frequency));
                let ratio = f.im / f.re / wanted;
                range = [range[0].min(ratio), range[1].max(ratio)];
            }
            println!("loss factor {wanted}: {range:?} of it from 100 Hz to {highest} Hz");
            assert!(range[0] > least && range[1] < 1.0, "loss factor {wanted}: {range:?}");
        }
    }

    #[test]
    fn it_is_one_at_rest_and_positive_real() {
        assert_eq!(Relaxation::of_loss_factor(0.0).at(Complex64::new(3.0, 900.0)), Complex64::ONE);
        let relaxation = Relaxation::of_loss_factor(0.2);
        assert_eq!(relaxation.at(Complex64::ZERO), Complex64::ONE);
        for s in [Complex64::new(1e-3, 1e5), Complex64::new(0.0, 10.0), Complex64::new(1e4, 1e4)] {
            let f = relaxation.at(s);
            // Positive real in the sense of a stiffness: f/s, a force per velocity.
            assert!((f / s).re > 0.0 && f.re >= 1.0, "{s}: {f}");
            assert!((relaxation.at(s.conj()) - f.conj()).norm() < 1e-14 * f.norm());
        }
    }
}
