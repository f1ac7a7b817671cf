//! The discrete transfer function w(zeta) = sum_p w_p zeta^p from forces to displacements of one wavenumber.
//!
//! - quadratures: H(mu(zeta)/dt), for a Runge-Kutta rule the determinant of its matrix of stages, prod_i
//!   H(mu_i(zeta)/dt), whose zeros are those of the matrix;
//! - first-order hold: sum_r R_r dt (today + yesterday zeta)/(1 - exp(lambda dt) zeta).

use num_complex::Complex64;

use crate::scene::TimeRule;
use crate::tyre::poles::model::Modes;

/// Exact step of a' = lambda a + F for F linear between the steps, in units of dt, z = lambda dt:
/// a_l = exp(z) a_(l-1) + dt (yesterday F_(l-1) + today F_l).
#[derive(Clone, Copy, Debug)]
pub struct FirstOrderHold {
    /// exp(z); not below exp(-300), which is as good as zero and still has a reciprocal.
    pub decay: Complex64,
    /// (exp z - 1 - z)/z^2.
    pub today: Complex64,
    /// (exp z - 1)/z less that.
    pub yesterday: Complex64,
}

impl FirstOrderHold {
    /// For z = lambda dt, Re z < 0.
    pub fn new(z: Complex64) -> Self {
        let decay = Complex64::new(z.re.max(-300.0), z.im).exp();
        let (first, second) = if z.norm() < 0.5 {
            // Taylor: sum z^k/(k+1)!, sum z^k/(k+2)!; 0.5^16/18! is far below rounding.
            let (mut first, mut second, mut term) = (Complex64::ZERO, Complex64::ZERO, Complex64::ONE);
            for k in 0..16 {
                let order = f64::from(k);
                first += term / (order + 1.0);
                second += term / ((order + 1.0) * (order + 2.0));
                term *= z / (order + 1.0);
            }
            (first, second)
        } else {
            ((decay - 1.0) / z, (decay - 1.0 - z) / (z * z))
        };
        Self { decay, today: second, yesterday: first - second }
    }
}

/// w(zeta) of one wavenumber, ready to be evaluated.
pub struct Transfer<'a> {
    modes: Modes<'a>,
    rule: TimeRule,
    time_step: f64,
    /// The hold's steps, conjugates included, with R dt.
    holds: Vec<(FirstOrderHold, Complex64)>,
}

impl<'a> Transfer<'a> {
    /// For a rule and a time step \[s\].
    pub fn new(modes: Modes<'a>, rule: TimeRule, time_step: f64) -> Self {
        let mut holds = Vec::new();
        if rule == TimeRule::FirstOrderHold {
            for (index, (&pole, &residue)) in modes.poles.iter().zip(modes.residues).enumerate() {
                holds.push((FirstOrderHold::new(pole * time_step), residue * time_step));
                if index < modes.pairs {
                    holds.push((FirstOrderHold::new(pole.conj() * time_step), residue.conj() * time_step));
                }
            }
        }
        Self { modes, rule, time_step, holds }
    }

    /// w(zeta) \[m/N\]; for a Runge-Kutta rule of s stages the determinant of its matrix \[(m/N)^s\].
    pub fn at(&self, zeta: Complex64) -> Complex64 {
        match self.rule.rates(zeta) {
            Some(rates) => rates
                .all()
                .iter()
                .fold(Complex64::ONE, |product, rate| product * self.modes.evaluate(rate / self.time_step)),
            None => self.holds.iter().fold(Complex64::new(self.modes.constant, 0.0), |sum, (hold, residue)| {
                sum + residue * (hold.today + hold.yesterday * zeta) / (1.0 - hold.decay * zeta)
            }),
        }
    }
}

/// The first weight w_0 of one wavenumber \[m/N\]: what the points in contact feel of each other within a step, or
/// within a stage.
pub fn first_weight(modes: &Modes<'_>, rule: TimeRule, time_step: f64) -> f64 {
    match rule.runge_kutta() {
        Some(method) => modes.evaluate(Complex64::new(1.0 / (method.gamma * time_step), 0.0)).re,
        None => Transfer::new(*modes, rule, time_step).at(Complex64::ZERO).re,
    }
}
