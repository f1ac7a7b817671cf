//! The local contact law on a line of elements, at rest and periodic: its pressures on a patch.
//!
//! Pressures are q = p/E* by element, c = kappa E* \[m\], G the periodic half-space's influence of elements as wide as
//! the patch:
//!
//! ```text
//! c q = S(v),   v = h + depth - G q + c q,   mean q given;
//! ```
//!
//! h is the height of an element's highest cell. Unknown are v and the depth. Newton's method on the pieces of S: each
//! step solves (1 - s_j) delta_ij + G_ij s_j/c for v, bordered by the mean; halved as long as the residual would grow.

use std::f64::consts::PI;

use faer::Mat;
use faer::linalg::solvers::Solve;

use super::patch::PatchGrid;
use crate::road::slices::StiffnessCurve;

/// Newton steps before the search gives up: some ten are usual.
const STEPS: usize = 200;
/// Halvings of a step.
const HALVINGS: usize = 12;
/// Largest residual of a solution, relative to c.
const TOLERANCE: f64 = 1e-9;

/// A line of elements with their curves.
pub(crate) struct ElementLine {
    curves: Vec<StiffnessCurve>,
    /// Influence of an element on the one j further on, times E* \[m\].
    influence: Vec<f64>,
}

impl ElementLine {
    pub(crate) fn new(grid: PatchGrid, curves: Vec<StiffnessCurve>) -> Self {
        Self { curves, influence: influence(grid) }
    }

    /// Pressures/E* by element for c = kappa E* \[m\] under a mean pressure/E*; `None` if Newton's method does not
    /// converge.
    pub(crate) fn pressures(&self, compliance: f64, mean: f64) -> Option<Vec<f64>> {
        let mut v: Vec<f64> = self.curves.iter().map(|curve| curve.penetration_at(compliance * mean)).collect();
        let mut state = self.at(compliance, mean, &v, 0.0);
        // The depth that suits the start on average.
        let mut depth = state.residual[..v.len()].iter().sum::<f64>() / v.len() as f64;
        state = self.at(compliance, mean, &v, depth);
        for _ in 0..STEPS {
            if state.norm <= TOLERANCE * compliance {
                return Some(state.pressures);
            }
            let step = self.step(compliance, &v, &state.residual)?;
            let (mut share, mut halvings) = (1.0, 0);
            loop {
                let trial: Vec<f64> = v.iter().zip(&step).map(|(v, step)| v - share * step).collect();
                let trial_depth = depth - share * step[v.len()];
                let next = self.at(compliance, mean, &trial, trial_depth);
                if next.norm < state.norm || halvings == HALVINGS {
                    (v, depth, state) = (trial, trial_depth, next);
                    break;
                }
                share *= 0.5;
                halvings += 1;
            }
        }
        None
    }

    fn at(&self, compliance: f64, mean: f64, v: &[f64], depth: f64) -> State {
        let n = v.len();
        let displacements = self.curves.iter().zip(v).map(|(curve, &v)| curve.displacement_at(v).max(0.0));
        let pressures: Vec<f64> = displacements.map(|s| s / compliance).collect();
        let mut residual: Vec<f64> = (0..n)
            .map(|i| {
                let displacement: f64 = (0..n).map(|j| self.influence[i.abs_diff(j)] * pressures[j]).sum();
                v[i] - self.curves[i].peak - depth + displacement - compliance * pressures[i]
            })
            .collect();
        // In metres as the others.
        residual.push(compliance * (pressures.iter().sum::<f64>() / n as f64 - mean));
        let norm = residual.iter().map(|r| r * r).sum::<f64>().sqrt();
        State { pressures, residual, norm }
    }

    /// Newton's step for v and the depth; `None` for a singular matrix.
    fn step(&self, compliance: f64, v: &[f64], residual: &[f64]) -> Option<Vec<f64>> {
        let n = v.len();
        let slopes: Vec<f64> = self.curves.iter().zip(v).map(|(curve, &v)| curve.stiffness_at(v)).collect();
        let matrix = Mat::from_fn(n + 1, n + 1, |i, j| match (i < n, j < n) {
            (true, true) => {
                let diagonal = if i == j { 1.0 - slopes[j] } else { 0.0 };
                diagonal + self.influence[i.abs_diff(j)] * slopes[j] / compliance
            }
            (true, false) => -1.0,
            (false, true) => slopes[j] / n as f64,
            (false, false) => 0.0,
        });
        let right = Mat::from_fn(n + 1, 1, |i, _| residual[i]);
        let solution = matrix.partial_piv_lu().solve(&right);
        let step: Vec<f64> = (0..=n).map(|i| solution[(i, 0)]).collect();
        step.iter().all(|value| value.is_finite()).then_some(step)
    }
}

/// State of Newton's method: pressures/E*, residuals \[m\] and their norm.
struct State {
    pressures: Vec<f64>,
    residual: Vec<f64>,
    norm: f64,
}

/// Mean displacement of an element for a unit pressure on another, periodic, the mean left out, times E*: waves 2/k on
/// the patch's cells.
fn influence(grid: PatchGrid) -> Vec<f64> {
    let (rows, along) = (grid.rows(), grid.along);
    let of_cells: Vec<f64> = (0..rows)
        .map(|distance| {
            let wave = |i: usize| {
                let phase = 2.0 * PI * ((i * distance) % rows) as f64 / rows as f64;
                // Both signs of a wavenumber, but for the highest one.
                let signs = if 2 * i == rows { 1.0 } else { 2.0 };
                signs * 2.0 / (2.0 * PI * i as f64 / (rows as f64 * grid.dx)) * phase.cos()
            };
            (1..=rows / 2).map(wave).sum::<f64>() / rows as f64
        })
        .collect();
    (0..grid.elements)
        .map(|element| {
            let pairs = (0..along).flat_map(|a| (0..along).map(move |b| (element * along + rows + a - b) % rows));
            pairs.map(|distance| of_cells[distance]).sum::<f64>() / along as f64
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::half_space::rough::{Extent, HeightMap, IndentationLimits, PeriodicContact};

    const GRID: PatchGrid = PatchGrid { elements: 16, along: 1, columns: 2, dx: 2e-3, dy: 2e-3 };

    fn height(i: usize) -> f64 {
        1e-3 * (2.0 * PI * i as f64 / 16.0).cos() + 4e-4 * (1.7 * (i * i) as f64).sin()
    }

    #[test]
    fn level_elements_are_those_of_the_half_space() {
        let heights = (0..32).map(|place| height(place / 2)).collect();
        let map = HeightMap { heights, extent: Extent { nx: 16, ny: 2 }, dx: GRID.dx, dy: GRID.dy };
        let mut contact = PeriodicContact::new(&map).unwrap();
        let line = ElementLine::new(GRID, (0..16).map(|i| StiffnessCurve::flat(height(i))).collect());
        for mean in [0.003, 0.03, 0.3] {
            let exact = contact.press(mean, IndentationLimits::default()).unwrap();
            // S(y) = y: the compliance drops out.
            for compliance in [1e-4, 5e-3] {
                let found = line.pressures(compliance, mean).unwrap();
                for (i, q) in found.iter().enumerate() {
                    assert!(
                        (q - exact.pressure[2 * i]).abs() < 1e-6 * mean * 16.0,
                        "{q} for {}",
                        exact.pressure[2 * i]
                    );
                }
            }
        }
    }

    #[test]
    fn the_law_holds_where_elements_have_curves() {
        let curve = |i: usize| {
            let events = (1..10).map(move |k| (1e-4 * ((k * k + i) % 17 + k) as f64, 0.1));
            let mut events: Vec<(f64, f64)> = events.chain([(0.0, 0.1)]).collect();
            events.sort_by(|a, b| a.0.total_cmp(&b.0));
            StiffnessCurve::from_events(height(i), events.into_iter())
        };
        let line = ElementLine::new(GRID, (0..16).map(curve).collect());
        for mean in [1e-3, 3e-2, 0.4] {
            let compliance = 4e-3;
            let q = line.pressures(compliance, mean).unwrap();
            assert!((q.iter().sum::<f64>() / 16.0 - mean).abs() < 1e-8 * mean.max(0.1));
            // Under load S^-1(c q) - c q + G q - h is the depth, the same for all; without load there is a gap.
            let place = |i: usize| {
                let displacement: f64 = (0..16).map(|j| line.influence[usize::abs_diff(i, j)] * q[j]).sum();
                line.curves[i].penetration_at(compliance * q[i]) - compliance * q[i] + displacement
                    - line.curves[i].peak
            };
            let loaded: Vec<usize> = (0..16).filter(|&i| q[i] > 0.0).collect();
            let depth = place(loaded[0]);
            for (i, &pressure) in q.iter().enumerate() {
                let gap = place(i) - depth;
                assert!(if pressure > 0.0 { gap.abs() < 1e-10 } else { gap > -1e-10 }, "element {i}: {gap:e}");
            }
        }
    }
}
