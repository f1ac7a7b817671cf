//! The discrete transfer function w(zeta) = sum_p w_p zeta^p from forces to displacements of one wavenumber.
//!
//! - quadratures: H(mu(zeta)/dt), for a Runge-Kutta rule the determinant of its matrix of stages, prod_i
//!   H(mu_i(zeta)/dt), whose zeros are those of the matrix;
//! - first-order hold: sum_r R_r dt (today + yesterday zeta)/(1 - exp(lambda dt) zeta).

use num_complex::Complex64;

use crate::time_rule::hold::FirstOrderHold;
use crate::time_rule::{Rates, TimeRule};
use crate::tyre::poles::{Direction, Modes};

/// w(zeta) of one wavenumber, ready to be evaluated.
pub(crate) struct Transfer<'a> {
    modes: Modes<'a>,
    direction: Direction,
    rule: TimeRule,
    time_step: f64,
    /// The hold's steps, conjugates included, with R dt.
    holds: Vec<(FirstOrderHold, Complex64)>,
}

impl<'a> Transfer<'a> {
    /// Prepares the waves of one direction, at rest those of both, for a rule and a time step \[s\].
    pub(crate) fn new(modes: Modes<'a>, direction: Direction, rule: TimeRule, time_step: f64) -> Self {
        let mut holds = Vec::new();
        if !rule.is_quadrature() {
            for (index, (&pole, &residue)) in modes.poles.iter().zip(modes.residues).enumerate() {
                holds.push((FirstOrderHold::new(pole * time_step), modes.residue(direction, index) * time_step));
                if index < modes.pairs {
                    let odd = modes.odd.get(index).copied().unwrap_or_default();
                    let residue = direction.of(residue.conj(), odd.conj());
                    holds.push((FirstOrderHold::new(pole.conj() * time_step), residue * time_step));
                }
            }
        }
        Self { modes, direction, rule, time_step, holds }
    }

    /// H(s) of the waves.
    fn value(&self, s: Complex64) -> Complex64 {
        if self.modes.odd.is_empty() { self.modes.evaluate(s) } else { self.modes.evaluate_wave(self.direction, s) }
    }

    /// w(zeta) \[m/N\]; for a Runge-Kutta rule of s stages the determinant of its matrix \[(m/N)^s\].
    pub(crate) fn at(&self, zeta: Complex64) -> Complex64 {
        self.with_rates(self.rule.rates(zeta), zeta)
    }

    /// [`Self::at`] where the rule's rates at zeta are known.
    pub(in crate::contact) fn with_rates(&self, rates: Option<Rates>, zeta: Complex64) -> Complex64 {
        match rates {
            Some(rates) => {
                rates.all().iter().fold(Complex64::ONE, |product, rate| product * self.value(rate / self.time_step))
            }
            None => self.holds.iter().fold(Complex64::new(self.modes.constant, 0.0), |sum, (hold, residue)| {
                sum + residue * (hold.today + hold.yesterday * zeta) / (1.0 - hold.decay * zeta)
            }),
        }
    }
}

/// First weight w_0 of one wavenumber \[m/N\], the influence between the points in contact within a step, or within a
/// stage; of a tyre that turns that of the even part.
pub(crate) fn first_weight(modes: &Modes<'_>, rule: TimeRule, time_step: f64) -> f64 {
    match rule.first_rate(time_step) {
        Some(rate) => modes.evaluate(Complex64::new(rate, 0.0)).re,
        None => {
            let even = Modes { odd: &[], ..*modes };
            Transfer::new(even, Direction::Forwards, rule, time_step).at(Complex64::ZERO).re
        }
    }
}

/// First weight of the odd part \[m/N\].
pub(crate) fn odd_first_weight(modes: &Modes<'_>, rule: TimeRule, time_step: f64) -> f64 {
    first_weight(&Modes { residues: modes.odd, odd: &[], constant: 0.0, ..*modes }, rule, time_step)
}
