//! Time rules: what stands for a' = lambda a + F between two steps, and how far it is from it.
//!
//! A convolution quadrature replaces s in H(s) by the rates mu/dt of its rule at zeta = exp(-s dt): one rate for a
//! multistep rule (Lubich 1988, *Numer. Math.* 52, 129 and 413), the eigenvalues of Delta(zeta) = (A + zeta/(1 - zeta)
//! 1 b^T)^-1 for a Runge-Kutta rule (Lubich & Ostermann 1993, *Math. Comp.* 60, 105; Banjai, Lubich & Melenk 2011,
//! *Numer. Math.* 119, 1). For a stiffly accurate rule they are the roots of zeta R(mu) = 1, R being the stability
//! function.

use std::f64::consts::PI;

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

/// Time rule.
///
/// x = w dt; damping relative to w, phase as relative error of the frequency, both for small x.
///
/// | rule | order | damping | phase | G0 | inverse |
/// |---|---|---|---|---|---|
/// | `bdf1` | 1 | x/2 | x^2/6 | H(1/dt) | stable |
/// | `bdf2` | 2 | x^3/4 | x^2/3 | H(1.5/dt) | stable |
/// | `trapezoidal` | 2 | 0 | x^2/12 | H(2/dt) | marginal: the force rings at half the sampling frequency |
/// | `sdirk2` | 2 | 0.0037 x^3 | 0.040 x^2 | H(3.41/dt) | stable; 2 stages |
/// | `sdirk3` | 3 | 0.026 x^3 | 0.015 x^4 | H(2.29/dt) | stable; 3 stages, one with a negative weight |
/// | `first-order-hold` | 2 in the force | 0 | 0 | mean of g | unstable where the tyre is inertia-like: refused |
///
/// Constants of the Runge-Kutta rules are measured; so is the order of all, with a smooth force on the tyre
/// (tests/suite/time_rules.rs: 0.95, 1.99, 2.00, 2.00, 2.99, 2.00).
///
/// The Runge-Kutta rules are singly diagonally implicit: every stage is one linear complementarity problem with the
/// same symmetric positive definite G0, and one cached factor serves all stages. Fully implicit ones (Radau IIA) couple
/// the stages in one problem whose matrix is not symmetric: neither its unique solution nor the end of the search would
/// be certain. Their force of a step is the stages' weighted mean: single stages have order 1 only. With `sdirk3` an
/// element's mean may be slightly negative.
///
/// `sdirk2` is the default: with a contact law that has a limit it is of second order on rough roads, too, with an
/// error two to ten times smaller than that of `bdf2` at the same step, the more the shorter it is
/// (tests/suite/convergence.rs).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum TimeRule {
    /// First-order backward differences.
    Bdf1,
    /// Second-order backward differences.
    Bdf2,
    /// Trapezoidal rule.
    Trapezoidal,
    /// Singly diagonally implicit Runge-Kutta rule of two stages, order 2 (Alexander 1977).
    #[default]
    Sdirk2,
    /// The same with three stages, order 3 (Alexander 1977, *SIAM J. Numer. Anal.* 14, 1006).
    Sdirk3,
    /// Exact modes under a force that is linear between the steps.
    FirstOrderHold,
}

/// A singly diagonally implicit, stiffly accurate Runge-Kutta rule of two or three stages.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RungeKutta {
    /// Diagonal of A.
    pub gamma: f64,
    /// Stage times c, in steps after the step's beginning; the last one is 1.
    pub nodes: &'static [f64],
    /// A below the diagonal: a21, a31, a32 (0 where there are two stages).
    pub below: [f64; 3],
}

/// The nodes of multistep rules: the end of the step.
const END: &[f64] = &[1.0];

/// Root of g^3 - 3 g^2 + 3/2 g - 1/6 between 0.4 and 0.5.
const GAMMA_3: f64 = 0.435_866_521_508_459;
/// 1 - 1/sqrt 2.
const GAMMA_2: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;

const SDIRK2: RungeKutta = RungeKutta { gamma: GAMMA_2, nodes: &[GAMMA_2, 1.0], below: [1.0 - GAMMA_2, 0.0, 0.0] };
const SDIRK3: RungeKutta = RungeKutta {
    gamma: GAMMA_3,
    nodes: &[GAMMA_3, 0.5 * (1.0 + GAMMA_3), 1.0],
    below: [
        0.5 * (1.0 - GAMMA_3),
        -0.25 * (6.0 * GAMMA_3 * GAMMA_3 - 16.0 * GAMMA_3 + 1.0),
        0.25 * (6.0 * GAMMA_3 * GAMMA_3 - 20.0 * GAMMA_3 + 5.0),
    ],
};

impl RungeKutta {
    /// b, which is the last row of A: the rule is stiffly accurate.
    pub const fn weights(&self) -> [f64; 3] {
        let [a21, a31, a32] = self.below;
        if self.nodes.len() == 2 { [a21, self.gamma, 0.0] } else { [a31, a32, self.gamma] }
    }

    /// A, as many rows and columns of it as there are stages.
    pub const fn matrix(&self) -> [[f64; 3]; 3] {
        let [a21, a31, a32] = self.below;
        [[self.gamma, 0.0, 0.0], [a21, self.gamma, 0.0], [a31, a32, self.gamma]]
    }

    /// (1 - z A)^-1: what becomes of the stages of a' = lambda a, z = lambda dt. It is lower triangular as A is.
    pub fn resolvent(&self, z: Complex64) -> [[Complex64; 3]; 3] {
        let diagonal = (1.0 - self.gamma * z).inv();
        let mut inverse = [[Complex64::ZERO; 3]; 3];
        for (row, a) in self.matrix().iter().enumerate().take(self.nodes.len()) {
            let mut entries = [Complex64::ZERO; 3];
            for (column, entry) in entries[..row].iter_mut().enumerate() {
                let sum: Complex64 = a[..row].iter().zip(&inverse).map(|(a, before)| a * before[column]).sum();
                *entry = z * diagonal * sum;
            }
            entries[row] = diagonal;
            inverse[row] = entries;
        }
        inverse
    }

    /// Base values of the stages as sums of the values at the step's beginning and of the earlier stages: row i gives
    /// base_i = p_0 b_0 + p_1 b_1 + p_2 b_2, with k_j = (b_j - base_j)/(gamma dt).
    pub fn bases(&self) -> [[f64; 3]; 3] {
        let [a21, a31, a32] = self.below.map(|a| a / self.gamma);
        [[1.0, 0.0, 0.0], [1.0 - a21, a21, 0.0], [1.0 - a31 - a32 * (1.0 - a21), a31 - a32 * a21, a32]]
    }

    /// Coefficients of (1 - gamma mu)^s - zeta P(mu), constant first: the stability function is P(mu)/(1 - gamma mu)^s.
    fn characteristic(&self, zeta: Complex64) -> ([Complex64; 4], usize) {
        let g = self.gamma;
        let real = |x: f64| Complex64::new(x, 0.0);
        if self.nodes.len() == 2 {
            let p = [1.0, 1.0 - 2.0 * g];
            let d = [1.0, -2.0 * g, g * g];
            ([real(d[0]) - zeta * p[0], real(d[1]) - zeta * p[1], real(d[2]), Complex64::ZERO], 2)
        } else {
            let p = [1.0, 1.0 - 3.0 * g, 0.5 - 3.0 * g + 3.0 * g * g];
            let d = [1.0, -3.0 * g, 3.0 * g * g, -g * g * g];
            let entry = |k: usize| real(d[k]) - zeta * p[k];
            ([entry(0), entry(1), entry(2), real(d[3])], 3)
        }
    }

    /// mu of zeta R(mu) = 1: Durand-Kerner iteration.
    fn rates(&self, zeta: Complex64) -> Rates {
        let (coefficients, degree) = self.characteristic(zeta);
        let value = |x: Complex64| {
            coefficients[..=degree].iter().rev().fold(Complex64::ZERO, |sum, &c| sum * x + c) / coefficients[degree]
        };
        let mut roots = [Complex64::ZERO; 3];
        for (k, root) in roots[..degree].iter_mut().enumerate() {
            *root = Complex64::from_polar(2.0, 0.4 + 2.0 * PI * k as f64 / degree as f64);
        }
        for _ in 0..200 {
            let mut moved = 0.0_f64;
            for k in 0..degree {
                let others = (0..degree).filter(|&j| j != k).fold(Complex64::ONE, |p, j| p * (roots[k] - roots[j]));
                let change = value(roots[k]) / others;
                roots[k] -= change;
                moved = moved.max(change.norm() / (1.0 + roots[k].norm()));
            }
            if moved < 1e-15 {
                break;
            }
        }
        Rates { values: roots, count: degree }
    }
}

/// The rates mu of a rule at one zeta.
#[derive(Clone, Copy, Debug)]
pub struct Rates {
    values: [Complex64; 3],
    count: usize,
}

impl Rates {
    /// mu, one per stage.
    pub fn all(&self) -> &[Complex64] {
        &self.values[..self.count]
    }
}

impl TimeRule {
    /// All rules.
    pub const ALL: [Self; 6] =
        [Self::Bdf1, Self::Bdf2, Self::Trapezoidal, Self::Sdirk2, Self::Sdirk3, Self::FirstOrderHold];

    /// The rule's name in a scene.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Bdf1 => "bdf1",
            Self::Bdf2 => "bdf2",
            Self::Trapezoidal => "trapezoidal",
            Self::Sdirk2 => "sdirk2",
            Self::Sdirk3 => "sdirk3",
            Self::FirstOrderHold => "first-order-hold",
        }
    }

    /// The Runge-Kutta rule, for those that are one.
    pub const fn runge_kutta(self) -> Option<RungeKutta> {
        match self {
            Self::Sdirk2 => Some(SDIRK2),
            Self::Sdirk3 => Some(SDIRK3),
            Self::Bdf1 | Self::Bdf2 | Self::Trapezoidal | Self::FirstOrderHold => None,
        }
    }

    /// Times at which a step solves for the contact, in steps after the step's beginning.
    pub const fn nodes(self) -> &'static [f64] {
        match self.runge_kutta() {
            Some(rule) => rule.nodes,
            None => END,
        }
    }

    /// Weights of the stages' forces in the step's mean force, see [`Self::nodes`].
    pub const fn weights(self) -> [f64; 3] {
        match self.runge_kutta() {
            Some(rule) => rule.weights(),
            None => [1.0, 0.0, 0.0],
        }
    }

    /// What is left in the mean force of a step, sum_i b_i F_i, of a force that swings by an angle w dt in a step:
    /// |sum_i b_i exp(i w dt c_i)|. 1 for rules that solve once, at the step's end.
    pub fn mean_response(self, angle: f64) -> f64 {
        let parts = self.nodes().iter().zip(self.weights());
        parts.map(|(&node, weight)| Complex64::from_polar(1.0, angle * node) * weight).sum::<Complex64>().norm()
    }

    /// Whether weights exist that one real sum over past steps can use: multistep quadratures.
    pub const fn is_multistep(self) -> bool {
        matches!(self, Self::Bdf1 | Self::Bdf2 | Self::Trapezoidal)
    }

    /// mu(zeta) of the quadrature: the values at which H(mu/dt) is taken. None for the first-order hold, which is no
    /// quadrature: its modes are exact.
    pub fn rates(self, zeta: Complex64) -> Option<Rates> {
        let one = |value| Some(Rates { values: [value, Complex64::ZERO, Complex64::ZERO], count: 1 });
        match self {
            Self::Bdf1 => one(1.0 - zeta),
            Self::Bdf2 => one(zeta * zeta * 0.5 - zeta * 2.0 + 1.5),
            Self::Trapezoidal => one((1.0 - zeta) / (zeta + 1.0) * 2.0),
            Self::Sdirk2 => Some(SDIRK2.rates(zeta)),
            Self::Sdirk3 => Some(SDIRK3.rates(zeta)),
            Self::FirstOrderHold => None,
        }
    }

    /// The rate that stands for s = i w at w dt = `angle`, relative to i w dt: 1 is exact; 1 + p - i d has the relative
    /// error p in phase (frequency) and the damping d.
    pub fn relative_rate(self, angle: f64) -> Complex64 {
        let exact = Complex64::new(0.0, angle);
        let Some(rates) = self.rates((-exact).exp()) else { return Complex64::ONE };
        let nearest = rates.all().iter().copied().min_by(|a, b| (a - exact).norm().total_cmp(&(b - exact).norm()));
        nearest.map_or(Complex64::ONE, |rate| rate / exact)
    }

    /// Largest w dt up to which phase and damping stay within `bound` together, pi at most.
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
    fn runge_kutta_rules_have_their_order_and_are_stiffly_accurate() {
        for (rule, order) in [(SDIRK2, 2), (SDIRK3, 3)] {
            let s = rule.nodes.len();
            let a = rule.matrix();
            let c: Vec<f64> = a[..s].iter().map(|row| row.iter().sum()).collect();
            for (c, node) in c.iter().zip(rule.nodes) {
                assert!((c - node).abs() < 1e-15, "{c} {node}");
            }
            let b = a[s - 1];
            let sum = |f: &dyn Fn(usize) -> f64| (0..s).map(|i| b[i] * f(i)).sum::<f64>();
            assert!((sum(&|_| 1.0) - 1.0).abs() < 1e-15 && (sum(&|i| c[i]) - 0.5).abs() < 1e-15);
            if order == 3 {
                assert!((sum(&|i| c[i] * c[i]) - 1.0 / 3.0).abs() < 1e-15);
                let nested = sum(&|i| (0..s).map(|j| a[i][j] * c[j]).sum());
                assert!((nested - 1.0 / 6.0).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn a_resolvent_is_the_inverse_of_its_matrix() {
        let z = Complex64::new(-0.7, 2.3);
        for rule in [SDIRK2, SDIRK3] {
            let (matrix, inverse, s) = (rule.matrix(), rule.resolvent(z), rule.nodes.len());
            let unit = |i: usize, j: usize| if i == j { 1.0 } else { 0.0 };
            for (i, a) in matrix.iter().enumerate().take(s) {
                for j in (0..3).take(s) {
                    let rows = a.iter().zip(&inverse).enumerate();
                    let entry: Complex64 = rows.map(|(k, (a, row))| (unit(i, k) - z * a) * row[j]).sum();
                    assert!((entry - unit(i, j)).norm() < 1e-15, "{i}, {j}: {entry}");
                }
            }
        }
    }

    #[test]
    fn phase_and_damping_shrink_with_the_order_and_no_rule_gains_energy() {
        for (rule, order) in [
            (TimeRule::Bdf1, 1),
            (TimeRule::Bdf2, 2),
            (TimeRule::Trapezoidal, 2),
            (TimeRule::Sdirk2, 2),
            (TimeRule::Sdirk3, 3),
        ] {
            let error = |angle: f64| (rule.relative_rate(angle) - 1.0).norm();
            let observed = (error(0.02) / error(0.01)).log2();
            assert!((observed - f64::from(order)).abs() < 0.1, "{rule:?}: {observed}");
            for k in 1..400 {
                let zeta = Complex64::from_polar(0.9999, -PI * f64::from(k) / 400.0);
                // A-stability: the open unit disk goes to the right half-plane.
                let rates = rule.rates(zeta).unwrap();
                assert!(rates.all().iter().all(|rate| rate.re > 0.0), "{rule:?} {k}: {rates:?}");
            }
        }
        // The closed forms of the second-order backward differences.
        let found = TimeRule::Bdf2.relative_rate(0.05);
        assert!(((found.re - 1.0) / (0.05_f64.powi(2) / 3.0) - 1.0).abs() < 0.01, "{found}");
        assert!((found.im.abs() / (0.05_f64.powi(3) / 4.0) - 1.0).abs() < 0.01, "{found}");
    }
}
