//! Frictionless contact of a rigid rough body with an elastic half-space: a whole height map, free boundary.
//!
//! Find p >= 0 on the cells, u = G p (Love's displacements), so that the gap g = u - (z - z_plane) >= 0 and p g = 0;
//! z_plane is the body's height that the undeformed surface reaches, penetration = z_max - z_plane. Given are either
//! the penetration or the load. The minimum of a strictly convex function over a convex set: the solution exists and is
//! unique.
//!
//! 1. Nested grids: the heights are averaged over 2 x 2 cells down to some tens of cells; each level is solved to a
//!    coarse tolerance and its pressure starts the next finer one.
//! 2. Box: p >= 0 makes u > 0, so a cell with z <= z_plane never touches. Only the bounding box of the others is
//!    solved; with a given load it is guessed from the coarser level and checked, and widened if need be, afterwards.
//! 3. On each level: constrained preconditioned conjugate gradients (module `gradients`).

use super::convolution::Extent;
use super::gradients::{Boundary, Constraint, GradientOutcome, Solver};
use super::map::{HeightMap, IndentationLimits};
use crate::half_space::HalfSpaceError;

/// Grids with fewer rows or columns are not coarsened further.
const COARSEST: usize = 48;
/// Tolerance of the coarser levels: they only start the next one.
const COARSE_TOLERANCE: f64 = 1e-3;
/// Fraction of the penetration by which the box of a given load is guessed too large.
const BOX_MARGIN: f64 = 0.1;

/// Least penetration in units of the heights' rounding.
const RESOLVED: f64 = 1e4;

/// Prescribed quantity: load or penetration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum IndentationControl {
    /// Normal load \[N\].
    Load(f64),
    /// Penetration of the highest peak \[m\].
    Penetration(f64),
}

/// Solved contact.
#[derive(Clone, Debug, PartialEq)]
pub struct Indentation {
    /// Pressure \[Pa\], nx x ny row-major; exactly 0 outside the contact.
    pub pressure: Vec<f64>,
    /// Load \[N\].
    pub load: f64,
    /// Penetration of the highest peak \[m\].
    pub penetration: f64,
    /// Fraction of the cells that carry pressure.
    pub area_fraction: f64,
    /// Iterations on the finest grid, over all boxes tried.
    pub iterations: usize,
    /// Convolutions with the influence function on the finest grid, over all boxes tried.
    pub convolutions: usize,
    /// Largest violation of the contact conditions, relative to the penetration (see [`IndentationLimits::tolerance`]).
    pub residual: f64,
}

/// Presses a rigid body into the half-space of effective modulus `modulus` = E/(1 - nu^2) \[Pa\].
///
/// # Errors
/// [`HalfSpaceError::Shape`] unless there are nx ny > 0 heights; [`HalfSpaceError::NotPositive`] for a cell, modulus,
/// tolerance, load or penetration that is not a positive number; [`HalfSpaceError::Hole`] for a height that is not
/// finite; [`HalfSpaceError::Unresolved`] for a penetration that the heights' rounding hides;
/// [`HalfSpaceError::NotConverged`] after too many iterations.
pub fn indent(
    map: &HeightMap,
    modulus: f64,
    control: IndentationControl,
    limits: IndentationLimits,
) -> Result<Indentation, HalfSpaceError> {
    let pressed = match control {
        IndentationControl::Load(load) => ("load", load),
        IndentationControl::Penetration(penetration) => ("penetration", penetration),
    };
    map.check(&[("modulus", modulus), ("tolerance", limits.tolerance), pressed])?;
    let peak = map.peak();
    let area = map.dx * map.dy;
    // Twice what a load on a single cell penetrates, at most.
    let deepest = match control {
        IndentationControl::Load(load) => 2.0 * load / (modulus * area.sqrt()),
        IndentationControl::Penetration(penetration) => penetration,
    };
    let highest = map.heights.iter().fold(0.0, |most: f64, height| most.max(height.abs()));
    if deepest <= RESOLVED * f64::EPSILON * highest {
        return Err(HalfSpaceError::Unresolved { penetration: deepest, highest });
    }
    let constraint = match control {
        IndentationControl::Load(load) => Constraint::Sum(load / (modulus * area)),
        IndentationControl::Penetration(penetration) => Constraint::Plane(peak - penetration),
    };
    let (pressure, progress) = solve_level(map, constraint, limits, true)?;
    let touching = pressure.iter().filter(|&&p| p > 0.0).count();
    let sum: f64 = pressure.iter().sum();
    Ok(Indentation {
        load: sum * modulus * area,
        penetration: peak - progress.plane,
        area_fraction: touching as f64 / map.extent.cells() as f64,
        iterations: progress.iterations,
        convolutions: progress.convolutions,
        residual: progress.residual,
        pressure: pressure.into_iter().map(|p| p * modulus).collect(),
    })
}

/// Solves one grid, the coarser ones first: pressure/E* of the whole grid, and how the run ended.
fn solve_level(
    map: &HeightMap,
    constraint: Constraint,
    limits: IndentationLimits,
    finest: bool,
) -> Result<(Vec<f64>, GradientOutcome), HalfSpaceError> {
    let Extent { nx, ny } = map.extent;
    let mut pressure = vec![0.0; nx * ny];
    let mut plane = None;
    // 1. Start value and plane from the coarser grid.
    if nx.min(ny) >= 2 * COARSEST {
        let coarse = coarsened(map);
        let coarse_constraint = match constraint {
            // The same load on cells four times as large.
            Constraint::Sum(sum) => Constraint::Sum(0.25 * sum),
            Constraint::Plane(plane) => Constraint::Plane(plane),
        };
        let coarse_limits =
            IndentationLimits { tolerance: COARSE_TOLERANCE.max(limits.tolerance), iterations: limits.iterations };
        // A coarse level that fails only costs the finer one its start.
        if let Ok((coarse_pressure, progress)) = solve_level(&coarse, coarse_constraint, coarse_limits, false) {
            plane = Some(progress.plane);
            for (i, row) in pressure.chunks_exact_mut(ny).enumerate() {
                for (j, p) in row.iter_mut().enumerate() {
                    *p = coarse_pressure[(i / 2) * coarse.extent.ny + j / 2];
                }
            }
        }
    }
    // 2. Plane of the box: cells below it are left out.
    let peak = map.peak();
    let mut reached = match (constraint, plane) {
        (Constraint::Plane(plane), _) => plane,
        (Constraint::Sum(_), Some(plane)) => plane - BOX_MARGIN * (peak - plane),
        (Constraint::Sum(_), None) => f64::NEG_INFINITY,
    };
    // 3. The box, widened until it holds every cell that the plane has reached.
    let (mut iterations, mut convolutions) = (0, 0);
    loop {
        let Some(window) = Window::above(map, reached) else {
            // Only a coarse level can be clear of the plane: averaging lowers its peaks.
            return Ok((pressure, GradientOutcome { plane: reached, iterations, convolutions, residual: 0.0 }));
        };
        let heights = window.cut(&map.heights, ny);
        let mut inside = window.cut(&pressure, ny);
        let mut solver = Solver::new(window.extent(), map.dx, map.dy, &heights, Boundary::Free);
        let progress = solver.run(constraint, limits, &mut inside)?;
        window.paste(&inside, &mut pressure, ny);
        iterations += progress.iterations;
        convolutions += progress.convolutions;
        // Every cell above the plane must have been in the box (coarse levels need not be exact).
        if !finest || progress.plane >= reached {
            return Ok((pressure, GradientOutcome { iterations, convolutions, ..progress }));
        }
        reached = progress.plane - BOX_MARGIN * (peak - progress.plane);
    }
}

/// Mean heights of 2 x 2 cells; a last odd row or column is averaged with itself.
fn coarsened(map: &HeightMap) -> HeightMap {
    let Extent { nx, ny } = map.extent;
    let extent = Extent { nx: nx.div_ceil(2), ny: ny.div_ceil(2) };
    let mut heights = Vec::with_capacity(extent.cells());
    for i in 0..extent.nx {
        let (first, second) = (2 * i * ny, (2 * i + 1).min(nx - 1) * ny);
        for j in 0..extent.ny {
            let (left, right) = (2 * j, (2 * j + 1).min(ny - 1));
            let sum = map.heights[first + left]
                + map.heights[first + right]
                + map.heights[second + left]
                + map.heights[second + right];
            heights.push(0.25 * sum);
        }
    }
    HeightMap { heights, extent, dx: 2.0 * map.dx, dy: 2.0 * map.dy }
}

/// A rectangular part of a grid.
struct Window {
    rows: std::ops::Range<usize>,
    columns: std::ops::Range<usize>,
}

impl Window {
    /// Bounding box of all cells higher than `plane`; `None` if there are none.
    fn above(map: &HeightMap, plane: f64) -> Option<Self> {
        let ny = map.extent.ny;
        let (mut top, mut bottom, mut left, mut right) = (usize::MAX, 0, ny, 0);
        for (i, row) in map.heights.chunks_exact(ny).enumerate() {
            let higher = |&height: &f64| height > plane;
            if let (Some(first), Some(last)) = (row.iter().position(higher), row.iter().rposition(higher)) {
                top = top.min(i);
                bottom = i + 1;
                left = left.min(first);
                right = right.max(last + 1);
            }
        }
        (bottom > 0).then_some(Self { rows: top..bottom, columns: left..right })
    }

    fn extent(&self) -> Extent {
        Extent { nx: self.rows.len(), ny: self.columns.len() }
    }

    fn cut(&self, grid: &[f64], ny: usize) -> Vec<f64> {
        let rows = grid.chunks_exact(ny).skip(self.rows.start).take(self.rows.len());
        rows.flat_map(|row| row[self.columns.clone()].iter().copied()).collect()
    }

    fn paste(&self, part: &[f64], grid: &mut [f64], ny: usize) {
        grid.fill(0.0);
        let rows = grid.chunks_exact_mut(ny).skip(self.rows.start).zip(part.chunks_exact(self.columns.len()));
        for (row, part) in rows {
            row[self.columns.clone()].copy_from_slice(part);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::half_space::reference::Case;

    #[test]
    fn agrees_with_the_established_codes() {
        for name in ["ref_free_roughsphere_N64", "ref_free_roughsphere_N128"] {
            let case = Case::open(name);
            let (shape, heights) = case.array("h");
            let dx = case.scalar("dx");
            let map = HeightMap { heights, extent: Extent { nx: shape[0], ny: shape[1] }, dx, dy: dx };
            let modulus = case.scalar("E_star");
            let (_, penetrations) = case.array("penetration");
            let (_, loads) = case.array("load");
            let (_, areas) = case.array("area_fraction");
            let (_, pressures) = case.array("pressure");
            let solve = |control| indent(&map, modulus, control, IndentationLimits::default()).unwrap();
            for (k, &penetration) in penetrations.iter().enumerate() {
                let contact = solve(IndentationControl::Penetration(penetration));
                println!(
                    "{name} {penetration}: {} iterations, {} convolutions, {:e}, load {:e}",
                    contact.iterations,
                    contact.convolutions,
                    contact.residual,
                    contact.load / loads[k] - 1.0
                );
                assert!((contact.load / loads[k] - 1.0).abs() < 1e-7);
                assert!((contact.area_fraction - areas[k]).abs() < 1e-12);
                assert!(contact.residual <= 1e-8);
                let expected = &pressures[k * heights_of(&map)..(k + 1) * heights_of(&map)];
                let largest = expected.iter().copied().fold(0.0, f64::max);
                let error = contact.pressure.iter().zip(expected).map(|(p, e)| (p - e).abs()).fold(0.0, f64::max);
                assert!(error < 1e-5 * largest, "{:e}", error / largest);
            }
            let contact = solve(IndentationControl::Load(case.scalar("load_ctrl_F")));
            println!(
                "load: {} iterations, {} convolutions, {:e}, penetration {:e}",
                contact.iterations,
                contact.convolutions,
                contact.residual,
                contact.penetration / case.scalar("load_ctrl_penetration") - 1.0
            );
            assert!((contact.penetration / case.scalar("load_ctrl_penetration") - 1.0).abs() < 1e-7);
            assert!((contact.load / case.scalar("load_ctrl_F") - 1.0).abs() < 1e-12);
        }
    }

    fn heights_of(map: &HeightMap) -> usize {
        map.extent.cells()
    }
}
