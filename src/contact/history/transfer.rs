//! The discrete transfer function w(zeta) = sum_p w_p zeta^p from forces to displacements of one wavenumber:
//! H(mu(zeta)/dt), for a Runge-Kutta rule the determinant of its matrix of stages, prod_i H(mu_i(zeta)/dt), whose zeros
//! are those of the matrix.

use num_complex::Complex64;

use crate::time_rule::{Rates, TimeRule};
use crate::tyre::poles::{Direction, WaveModes};

/// w(zeta) of the waves of one direction, at rest of those of both, for a rule and a time step \[s\].
pub(crate) struct Transfer<'a> {
    pub modes: WaveModes<'a>,
    pub direction: Direction,
    pub rule: TimeRule,
    pub time_step: f64,
}

impl Transfer<'_> {
    /// H(s) of the waves.
    fn value(&self, s: Complex64) -> Complex64 {
        if self.modes.odd.is_empty() { self.modes.evaluate(s) } else { self.modes.evaluate_wave(self.direction, s) }
    }

    /// w(zeta) \[m/N\]; for a Runge-Kutta rule of s stages the determinant of its matrix \[(m/N)^s\].
    pub(crate) fn at(&self, zeta: Complex64) -> Complex64 {
        self.with_rates(&self.rule.rates(zeta))
    }

    /// [`Self::at`] where the rule's rates at zeta are known.
    pub(in crate::contact) fn with_rates(&self, rates: &Rates) -> Complex64 {
        rates.all().iter().fold(Complex64::ONE, |product, rate| product * self.value(rate / self.time_step))
    }
}

/// First weight w_0 of one wavenumber \[m/N\], the influence between the points in contact within a step, or within a
/// stage; of a tyre that turns that of the even part.
pub(crate) fn first_weight(modes: &WaveModes<'_>, rule: TimeRule, time_step: f64) -> f64 {
    modes.evaluate(Complex64::new(rule.first_rate(time_step), 0.0)).re
}

/// First weight of the odd part \[m/N\].
pub(crate) fn odd_first_weight(modes: &WaveModes<'_>, rule: TimeRule, time_step: f64) -> f64 {
    first_weight(&WaveModes { residues: modes.odd, odd: &[], constant: 0.0, ..*modes }, rule, time_step)
}

/// Adds the displacements by poles with these residues 1, 2, ... instants after a unit force at a stage, all of one
/// stage together.
pub(crate) fn add_responses(
    modes: &WaveModes<'_>,
    residues: &[Complex64],
    rule: TimeRule,
    time_step: f64,
    lags: usize,
    weights: &mut [f64],
) {
    for (index, (&pole, &residue)) in modes.poles.iter().zip(residues).enumerate() {
        let (g, w) = rule.coefficients(pole, modes.multiplicity(index) * residue, time_step);
        for (stage, response) in weights.chunks_mut(lags).enumerate() {
            rule.impulse_response([g, w], stage, response);
        }
    }
}
