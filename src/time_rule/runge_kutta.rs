//! Singly diagonally implicit Runge-Kutta rules, and the rates of a rule.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use num_complex::Complex64;

/// The rates mu of a rule at one zeta, which replace s.
#[derive(Clone, Copy, Debug)]
pub struct Rates {
    pub(super) values: [Complex64; 3],
    pub(super) count: usize,
}

impl Rates {
    /// mu, one per stage.
    pub fn all(&self) -> &[Complex64] {
        &self.values[..self.count]
    }
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

/// Root of g^3 - 3 g^2 + 3/2 g - 1/6 between 0.4 and 0.5.
const GAMMA_3: f64 = 0.435_866_521_508_459;
/// 1 - 1/sqrt 2.
const GAMMA_2: f64 = 1.0 - FRAC_1_SQRT_2;

/// Alexander's rule of two stages.
pub(super) const SDIRK2: RungeKutta =
    RungeKutta { gamma: GAMMA_2, nodes: &[GAMMA_2, 1.0], below: [1.0 - GAMMA_2, 0.0, 0.0] };
/// Alexander's rule of three stages.
pub(super) const SDIRK3: RungeKutta = RungeKutta {
    gamma: GAMMA_3,
    nodes: &[GAMMA_3, 0.5 * (1.0 + GAMMA_3), 1.0],
    below: [
        0.5 * (1.0 - GAMMA_3),
        -0.25 * (6.0 * GAMMA_3 * GAMMA_3 - 16.0 * GAMMA_3 + 1.0),
        0.25 * (6.0 * GAMMA_3 * GAMMA_3 - 20.0 * GAMMA_3 + 5.0),
    ],
};

impl RungeKutta {
    /// b, the last row of A: the rule is stiffly accurate.
    pub const fn weights(&self) -> [f64; 3] {
        let [a21, a31, a32] = self.below;
        if self.nodes.len() == 2 { [a21, self.gamma, 0.0] } else { [a31, a32, self.gamma] }
    }

    /// A; rows and columns past the stages are not used.
    pub(crate) const fn matrix(&self) -> [[f64; 3]; 3] {
        let [a21, a31, a32] = self.below;
        [[self.gamma, 0.0, 0.0], [a21, self.gamma, 0.0], [a31, a32, self.gamma]]
    }

    /// Delta(zeta) = (A + zeta/(1 - zeta) 1 b^T)^-1, by the Sherman-Morrison identity; A's last row is b, so that b^T
    /// A^-1 picks the last stage.
    pub(super) fn symbol(&self, zeta: Complex64) -> [[Complex64; 3]; 3] {
        let stages = self.nodes.len();
        let inverse = self.inverse();
        let mut symbol = [[Complex64::ZERO; 3]; 3];
        for (row, inverse) in symbol.iter_mut().zip(&inverse).take(stages) {
            let sum: f64 = inverse.iter().sum();
            for (entry, &value) in row.iter_mut().zip(inverse) {
                *entry = value.into();
            }
            row[stages - 1] -= zeta * sum;
        }
        symbol
    }

    /// A^-1, lower triangular as A is.
    fn inverse(&self) -> [[f64; 3]; 3] {
        let mut inverse = [[0.0; 3]; 3];
        for (row, a) in self.matrix().iter().enumerate().take(self.nodes.len()) {
            let mut entries = [0.0; 3];
            for (column, entry) in entries[..row].iter_mut().enumerate() {
                let sum: f64 = a[..row].iter().zip(&inverse).map(|(a, before)| a * before[column]).sum();
                *entry = -sum / self.gamma;
            }
            entries[row] = 1.0 / self.gamma;
            inverse[row] = entries;
        }
        inverse
    }

    /// (1 - z A)^-1, lower triangular as A is: for a' = lambda a with z = lambda dt, its row sums are the values at
    /// the stages.
    pub(crate) fn resolvent(&self, z: Complex64) -> [[Complex64; 3]; 3] {
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

    /// Coefficients of the stages' bases in the values at the step's beginning and at the earlier stages: row i gives
    /// base_i = p_0 b_0 + p_1 b_1 + p_2 b_2, with k_j = (b_j - base_j)/(gamma dt).
    pub(crate) fn bases(&self) -> [[f64; 3]; 3] {
        let [a21, a31, a32] = self.below.map(|a| a / self.gamma);
        [[1.0, 0.0, 0.0], [1.0 - a21, a21, 0.0], [1.0 - a31 - a32 * (1.0 - a21), a31 - a32 * a21, a32]]
    }

    /// Coefficients of (1 - gamma mu)^s - zeta P(mu), constant first, and s: the stability function is
    /// P(mu)/(1 - gamma mu)^s.
    fn characteristic(&self, zeta: Complex64) -> ([Complex64; 4], usize) {
        let g = self.gamma;
        let (p, d) = if self.nodes.len() == 2 {
            ([1.0, 1.0 - 2.0 * g, 0.0, 0.0], [1.0, -2.0 * g, g * g, 0.0])
        } else {
            ([1.0, 1.0 - 3.0 * g, 0.5 - 3.0 * g + 3.0 * g * g, 0.0], [1.0, -3.0 * g, 3.0 * g * g, -g * g * g])
        };
        (std::array::from_fn(|k| Complex64::new(d[k], 0.0) - zeta * p[k]), self.nodes.len())
    }

    /// Roots mu of zeta R(mu) = 1 by Durand-Kerner iteration, in no certain order.
    pub(super) fn rates(&self, zeta: Complex64) -> Rates {
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
}
