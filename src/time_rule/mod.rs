//! Time rules: what stands for a' = lambda a + F between two steps, and how far it is from it.
//!
//! A convolution quadrature replaces s in H(s) by the rates mu/dt of its rule at zeta = exp(-s dt): one rate for a
//! multistep rule (Lubich 1988, *Numer. Math.* 52, 129 and 413), the eigenvalues of Delta(zeta) = (A + zeta/(1 - zeta)
//! 1 b^T)^-1 for a Runge-Kutta rule (Lubich & Ostermann 1993, *Math. Comp.* 60, 105; Banjai, Lubich & Melenk 2011,
//! *Numer. Math.* 119, 1). For a stiffly accurate rule they are the roots of zeta R(mu) = 1, R being the stability
//! function.
//!
//! Everything that differs from rule to rule stands here:
//!
//! - this file: the rules, their times, weights, symbols and errors;
//! - `runge_kutta`: the tableaux, and the rates of a rule at one zeta;
//! - `recursion`: one pole under a rule, step by step;
//! - `advance`: how far the tyre rolls in a step.

mod advance;
pub(crate) mod recursion;
mod runge_kutta;

use std::f64::consts::PI;

use num_complex::Complex64;

use crate::counters::catalogue::catalogue;

pub use advance::Advance;
pub(crate) use runge_kutta::{Rates, RungeKutta};
use runge_kutta::{SDIRK2, SDIRK3};

catalogue! {
    /// Time rule.
    ///
    /// x = w dt; damping relative to w, phase as relative error of the frequency, both for small x.
    ///
    /// | rule | order | damping | phase | G0 | inverse |
    /// |---|---|---|---|---|---|
    /// | `bdf1` | 1 | x/2 | x^2/6 | H(1/dt) | stable |
    /// | `bdf2` | 2 | x^3/4 | x^2/3 | H(1.5/dt) | stable |
    /// | `sdirk2` | 2 | 0.0037 x^3 | 0.040 x^2 | H(3.41/dt) | stable; 2 stages |
    /// | `sdirk3` | 3 | 0.026 x^3 | 0.015 x^4 | H(2.29/dt) | stable; 3 stages, one with a negative weight |
    ///
    /// Constants of the Runge-Kutta rules are measured; so is the order of all, with a smooth force on the tyre
    /// (tests/suite/time_rules.rs: 0.95, 1.99, 2.00, 2.99).
    ///
    /// The Runge-Kutta rules are singly diagonally implicit: every stage is one linear complementarity problem with the
    /// same symmetric positive definite G0, and one cached factor serves all stages. Fully implicit ones (Radau IIA)
    /// couple the stages in one problem whose matrix is not symmetric: neither its unique solution nor the end of the
    /// search would be certain. Their force of a step is the stages' weighted mean: single stages have order 1 only.
    /// With `sdirk3` an element's mean may be slightly negative.
    ///
    /// `sdirk2` is the default: with a contact law that has a limit it is of second order on rough roads, too, with an
    /// error two to ten times smaller than that of `bdf2` at the same step, the more the shorter it is
    /// (tests/suite/convergence.rs).
    ///
    /// Not offered: the trapezoidal rule, whose force rings at half the sampling frequency without decay, and exact
    /// modes under a piecewise linear force, whose inverse is unstable wherever the tyre is inertia-like.
    #[derive(Default)]
    pub enum TimeRule as "kebab-case",
    /// Name in a scene.
    name {
        /// First-order backward differences.
        Bdf1 => "bdf1",
        /// Second-order backward differences.
        Bdf2 => "bdf2",
        /// Singly diagonally implicit Runge-Kutta rule of two stages, order 2 (Alexander 1977).
        #[default]
        Sdirk2 => "sdirk2",
        /// Singly diagonally implicit Runge-Kutta rule of three stages, order 3 (Alexander 1977, *SIAM J. Numer. Anal.*
        /// 14, 1006).
        Sdirk3 => "sdirk3",
    }
}

/// Nodes of multistep rules: the end of the step.
const END: &[f64] = &[1.0];

impl TimeRule {
    /// The stages of a Runge-Kutta rule.
    #[doc(hidden)]
    pub const fn runge_kutta(self) -> Option<RungeKutta> {
        match self {
            Self::Sdirk2 => Some(SDIRK2),
            Self::Sdirk3 => Some(SDIRK3),
            Self::Bdf1 | Self::Bdf2 => None,
        }
    }

    /// Times at which a step solves for the contact, in steps from the step's beginning.
    pub const fn nodes(self) -> &'static [f64] {
        match self.runge_kutta() {
            Some(rule) => rule.nodes,
            None => END,
        }
    }

    /// Number of times that a step solves for the contact.
    pub const fn stages(self) -> usize {
        self.nodes().len()
    }

    /// Time by which a step's force acts before the step's end, in steps: the mean force of a Runge-Kutta step acts in
    /// its middle.
    pub(crate) const fn force_lead(self) -> f64 {
        if self.runge_kutta().is_some() { 0.5 } else { 0.0 }
    }

    /// Weights of the stages' forces in the step's mean force, see [`Self::nodes`]; zeros past the stages.
    pub const fn weights(self) -> [f64; 3] {
        match self.runge_kutta() {
            Some(rule) => rule.weights(),
            None => [1.0, 0.0, 0.0],
        }
    }

    /// Fraction that the mean force of a step, sum_i b_i F_i, keeps of a harmonic force that advances by w
    /// dt = `angle` in a step: |sum_i b_i exp(i w dt c_i)|. 1 for rules that solve once, at the step's end.
    pub fn mean_response(self, angle: f64) -> f64 {
        let parts = self.nodes().iter().zip(self.weights());
        parts.map(|(&node, weight)| Complex64::from_polar(1.0, angle * node) * weight).sum::<Complex64>().norm()
    }

    /// True for quadratures whose weights serve one real sum over past steps.
    pub(crate) const fn is_multistep(self) -> bool {
        self.runge_kutta().is_none()
    }

    /// mu(zeta) of the quadrature: the values at which H(mu/dt) is taken.
    #[doc(hidden)]
    pub fn rates(self, zeta: Complex64) -> Rates {
        let one = |value| Rates { values: [value, Complex64::ZERO, Complex64::ZERO], count: 1 };
        match self {
            Self::Bdf1 => one(1.0 - zeta),
            Self::Bdf2 => one(zeta * zeta * 0.5 - zeta * 2.0 + 1.5),
            Self::Sdirk2 => SDIRK2.rates(zeta),
            Self::Sdirk3 => SDIRK3.rates(zeta),
        }
    }

    /// Delta(zeta) of a quadrature, as many rows and columns as there are stages, zeros beyond: H(Delta/dt) relates
    /// the forces at a step's stages to the displacements there.
    pub fn symbol_matrix(self, zeta: Complex64) -> [[Complex64; 3]; 3] {
        match self.runge_kutta() {
            Some(rule) => rule.symbol(zeta),
            None => {
                let mut matrix = [[Complex64::ZERO; 3]; 3];
                matrix[0][0] = self.symbol(zeta);
                matrix
            }
        }
    }

    /// delta(zeta) of a multistep rule; of a Runge-Kutta rule the first of the `Self::rates`.
    pub fn symbol(self, zeta: Complex64) -> Complex64 {
        self.rates(zeta).all()[0]
    }

    /// Largest |delta| for which the rule should be resolved: the value at half the sampling frequency for the
    /// backward differences, the largest rate on the unit circle for the Runge-Kutta rules.
    pub(crate) const fn resolved_symbol(self) -> f64 {
        match self {
            Self::Bdf1 => 2.0,
            Self::Bdf2 => 4.0,
            Self::Sdirk2 | Self::Sdirk3 => 8.0,
        }
    }

    /// True for rules whose steps dissipate with friction, whatever sticks and slips (algebraically stable, of one
    /// stage).
    pub(crate) const fn is_stable_with_friction(self) -> bool {
        matches!(self, Self::Bdf1 | Self::Bdf2)
    }

    /// Coefficients of a backward difference: rate times the time step from the values now and one and two steps ago.
    /// Second order for every rule but `bdf1`.
    pub(crate) const fn backward_difference(self) -> [f64; 3] {
        match self {
            Self::Bdf1 => [1.0, -1.0, 0.0],
            _ => [1.5, -2.0, 0.5],
        }
    }

    /// s = delta(0)/dt \[1/s\] at which a tyre's response to a force is that within the force's step (or stage).
    pub(crate) fn first_rate(self, time_step: f64) -> f64 {
        match self.runge_kutta() {
            Some(rule) => 1.0 / (rule.gamma * time_step),
            None => self.symbol(Complex64::ZERO).re / time_step,
        }
    }

    /// Rate that stands for s = i w at w dt = `angle`, relative to i w dt: 1 is exact; 1 + p - i d has the relative
    /// error p in phase (frequency) and the damping d. Of several rates the one nearest to i w dt.
    pub fn relative_rate(self, angle: f64) -> Complex64 {
        let exact = Complex64::new(0.0, angle);
        let rates = self.rates((-exact).exp());
        let nearest = rates.all().iter().copied().min_by(|a, b| (a - exact).norm().total_cmp(&(b - exact).norm()));
        nearest.map_or(Complex64::ONE, |rate| rate / exact)
    }

    /// Largest w dt up to which phase and damping stay within `bound` together, pi at most; found on 2000 points.
    pub fn largest_angle(self, bound: f64) -> f64 {
        const POINTS: u32 = 2000;
        let angle = |k: u32| PI * f64::from(k) / f64::from(POINTS);
        let beyond = (1..=POINTS).find(|&k| (self.relative_rate(angle(k)) - 1.0).norm() > bound);
        beyond.map_or(PI, |k| angle(k - 1).max(0.25 * angle(1)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phase_and_damping_errors_shrink_and_no_rule_gains_energy() {
        for (rule, order) in [(TimeRule::Bdf1, 1), (TimeRule::Bdf2, 2), (TimeRule::Sdirk2, 2), (TimeRule::Sdirk3, 3)] {
            let error = |angle: f64| (rule.relative_rate(angle) - 1.0).norm();
            let observed = (error(0.02) / error(0.01)).log2();
            assert!((observed - f64::from(order)).abs() < 0.1, "{rule:?}: {observed}");
            for k in 1..400 {
                let zeta = Complex64::from_polar(0.9999, -PI * f64::from(k) / 400.0);
                // A-stability: the open unit disk goes to the right half-plane.
                let rates = rule.rates(zeta);
                assert!(rates.all().iter().all(|rate| rate.re > 0.0), "{rule:?} {k}: {rates:?}");
            }
        }
        // The closed forms of the second-order backward differences.
        let found = TimeRule::Bdf2.relative_rate(0.05);
        assert!(((found.re - 1.0) / (0.05_f64.powi(2) / 3.0) - 1.0).abs() < 0.01, "{found}");
        assert!((found.im.abs() / (0.05_f64.powi(3) / 4.0) - 1.0).abs() < 0.01, "{found}");
    }
}
