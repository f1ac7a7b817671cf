//! Which cells touch, and with which forces: F >= 0, u = G F >= d, F.(u - d) = 0.
//!
//! G is symmetric positive definite, so there is exactly one F. Modified proportioning with reduced gradient
//! projections (Dostal & Schoeberl 2005, *Comput. Optim. Appl.* 30, 23).

use serde::{Deserialize, Serialize};

use super::instant::InstantCells;
use crate::numeric::largest_or_zero;

/// How far the contact conditions are missed, at worst, relative to the largest required displacement and force.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct CellResiduals {
    /// max(-F) / max F; 0 always.
    pub tension: f64,
    /// max(d - u) / max d.
    pub penetration: f64,
    /// max |u - d| / max d where F > 0.
    pub complementarity: f64,
}

impl CellResiduals {
    /// The worse of two, condition by condition.
    pub fn worst(self, other: Self) -> Self {
        Self {
            tension: self.tension.max(other.tension),
            penetration: self.penetration.max(other.penetration),
            complementarity: self.complementarity.max(other.complementarity),
        }
    }
}

/// What a search has done over all instants.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub struct CellCounts {
    /// Instants at which forces were sought.
    pub solves: u64,
    /// Iterations.
    pub iterations: u64,
    /// Products with G.
    pub products: u64,
    /// Instants at which the fallback took over.
    pub fallbacks: u64,
}

/// The search with its scratch; only its counters evolve.
pub struct CellSearch {
    cells: InstantCells,
    tolerance: f64,
    counts: CellCounts,
    displacement: Vec<f64>,
    direction: Vec<f64>,
    response: Vec<f64>,
    gradient: Vec<f64>,
}

impl CellSearch {
    /// A search over the cells of a window. `tolerance` is how far u may be from d, relative to the largest d.
    pub fn new(cells: InstantCells, tolerance: f64) -> Self {
        let zeros = || vec![0.0; cells.cells()];
        let (displacement, direction, response, gradient) = (zeros(), zeros(), zeros(), zeros());
        Self { tolerance, counts: CellCounts::default(), displacement, direction, response, gradient, cells }
    }

    /// G.
    pub fn cells(&mut self) -> &mut InstantCells {
        &mut self.cells
    }

    /// u = G F of the last solution.
    pub fn displacement(&self) -> &[f64] {
        &self.displacement
    }

    /// What was done so far.
    pub fn counts(&self) -> CellCounts {
        self.counts
    }

    /// Goes on from the counters of an equal search.
    pub fn restore(&mut self, counts: CellCounts) {
        self.counts = counts;
    }

    /// Finds the forces for the `required` displacements d; -infinity marks a cell that cannot touch. `forces` comes in
    /// as the guess. A d that is no number gives residuals that are none.
    pub fn solve(&mut self, required: &[f64], forces: &mut [f64]) -> CellResiduals {
        self.counts.solves += 1;
        let Self { cells, tolerance, counts, displacement, direction, response, gradient } = self;
        if required.iter().any(|d| d.is_nan() || *d == f64::INFINITY) {
            let missed = f64::NAN;
            return CellResiduals { tension: 0.0, penetration: missed, complementarity: missed };
        }
        let largest = largest_or_zero(required);
        displacement.fill(0.0);
        for (force, &d) in forces.iter_mut().zip(required) {
            *force = if d > f64::NEG_INFINITY && *force > 0.0 { *force } else { 0.0 };
        }
        if largest <= 0.0 {
            forces.fill(0.0);
            return CellResiduals::default();
        }
        cells.add_displacement(forces, displacement);
        counts.products += 1;
        let mut product = |v: &[f64], out: &mut [f64], counts: &mut CellCounts| {
            out.fill(0.0);
            cells.add_displacement(v, out);
            counts.products += 1;
        };
        // Half of 1 / an upper bound of the largest eigenvalue would do; the row sum bounds it.
        let ones = vec![1.0; forces.len()];
        product(&ones, response, counts);
        let step = response.iter().fold(0.0_f64, |a, &b| a.max(b)).recip();
        loop {
            let mut fresh = true;
            let mut previous = 0.0;
            for ((gradient, &u), &d) in gradient.iter_mut().zip(&*displacement).zip(required) {
                *gradient = u - d.max(-1e300);
            }
            loop {
                counts.iterations += 1;
                let mut residuals = CellResiduals::default();
                let (mut free, mut reduced, mut chopped) = (0.0, 0.0, 0.0);
                for (&force, &g) in forces.iter().zip(&*gradient) {
                    if force > 0.0 {
                        residuals.complementarity = residuals.complementarity.max(g.abs() / largest);
                        free += g * g;
                        reduced += g * (force / step).min(g);
                    } else {
                        chopped += g.min(0.0) * g.min(0.0);
                    }
                    residuals.penetration = residuals.penetration.max(-g / largest);
                }
                if residuals.complementarity <= *tolerance && residuals.penetration <= *tolerance {
                    return residuals;
                }
                if chopped <= reduced {
                    let beta = if fresh { 0.0 } else { free / previous };
                    for ((t, &force), &g) in direction.iter_mut().zip(&*forces).zip(&*gradient) {
                        *t = if force > 0.0 { beta.mul_add(*t, g) } else { 0.0 };
                    }
                    previous = free;
                    product(direction, response, counts);
                    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).fold(0.0, |sum: f64, (a, b)| a.mul_add(*b, sum));
                    let best = dot(gradient, direction) / dot(direction, response);
                    let feasible = forces
                        .iter()
                        .zip(&*direction)
                        .filter(|(_, t)| **t > 0.0)
                        .fold(f64::INFINITY, |least, (force, t)| least.min(force / t));
                    fresh = best > feasible;
                    let length = best.min(feasible);
                    for i in 0..forces.len() {
                        forces[i] = (-length).mul_add(direction[i], forces[i]).max(0.0);
                        gradient[i] = (-length).mul_add(response[i], gradient[i]);
                        displacement[i] = (-length).mul_add(response[i], displacement[i]);
                    }
                    if fresh {
                        for (force, &g) in forces.iter_mut().zip(&*gradient).filter(|(force, _)| **force > 0.0) {
                            *force = (-step).mul_add(g, *force).max(0.0);
                        }
                        break;
                    }
                } else {
                    for (force, &g) in forces.iter_mut().zip(&*gradient).filter(|(force, _)| **force <= 0.0) {
                        *force = (-step * g).max(0.0);
                    }
                    break;
                }
            }
            product(forces, displacement, counts);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_window_is_solved() {
        let toeplitz = (0..20).map(|n| (-1.2 * f64::from(n / 5 + n % 5)).exp()).collect();
        let hankel = (0..36).map(|n| 0.2 * (-f64::from(n / 9 + n % 9)).exp()).collect();
        let mut search = CellSearch::new(InstantCells::new(4, 5, toeplitz, hankel), 1e-10);
        let mut required: Vec<f64> = (0..20).map(|n| (f64::from(n) * 1.7).sin()).collect();
        required[3] = f64::NEG_INFINITY;
        let mut forces = vec![0.0; 20];
        let residuals = search.solve(&required, &mut forces);
        assert!(residuals.penetration <= 1e-10 && residuals.complementarity <= 1e-10);
        let u = search.displacement();
        for ((&force, &u), &d) in forces.iter().zip(u).zip(&required) {
            assert!(force >= 0.0 && u - d > -1e-9 && (force * (u - d).max(-1.0)).abs() < 1e-9 || force <= 0.0);
        }
    }
}
