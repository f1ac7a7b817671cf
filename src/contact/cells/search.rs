//! Which cells touch, and with which forces: F >= 0, u = G F >= d, F.(u - d) = 0.
//!
//! G is positive definite, so there is exactly one F; at rest it is symmetric, too.
//!
//! 1. From the guess, projected conjugate gradients in single precision (module `gradients`), a few digits at a time,
//!    on the part of the window that the forces and all d > 0 are in;
//! 2. u = G F in double precision, everywhere; the end, if the conditions are met, else again from there, on a longer
//!    part if they are missed beyond it;
//!    Where the tolerance is at least [`SINGLE`], single precision is exact enough: the end is where 1. ends, if a
//!    bound of the lowering by all forces keeps the cells beyond the part off the road. u = G F is evaluated where the
//!    part is not that of the previous instant, some columns later;
//! 3. where that does not at least halve the error, not even in a restarted direction, proportioning in double
//!    precision takes over (module `proportioning`), which always ends. Uses are counted.
//!
//! With rotation, G = G_s + G_a with a small skew part, |F.G_a F'| <= (max |Im H|/Re H) |F| |F'| in the norm of G_s.
//! Products of 1. and 2. are with the whole of G: a step along t is as long as before, t.G t = t.G_s t, and r.t = 0
//! after it; directions are conjugate but for G_a. That costs no iterations where |Im H| is 0.02 of Re H, twice what
//! 512 elements have at 250 km/h, and a seventh more at 0.1 (rough roads of `search_tests`). 3. needs symmetry: it
//! solves with G_s for d - G_a F, again and again. Each sweep brings the error down by
//! max |Im H|/Re H <= 4 pi/(c q N), the rule's c and q time steps to an element of N round the tyre.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::gradients::Gradients;
use super::instant::InstantCells;
use super::proportioning::Proportioning;
use crate::counters::Work;
use crate::numeric::{largest_above, largest_or_zero};
use crate::storage::state::{Evolving, StateError, StateStream, ensure};

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

/// Work of a search over all instants.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub struct CellCounts {
    /// Instants at which forces were searched for.
    pub solves: u64,
    /// Iterations.
    pub iterations: u64,
    /// Products with G over the whole window, in double precision unless the tolerance allows single.
    pub products: u64,
    /// Products with G in single precision on the way.
    pub single_products: u64,
    /// Forces that an iteration cut at 0.
    pub cuts: u64,
    /// Instants at which the fallback took over.
    pub fallbacks: u64,
    /// Work of all products.
    pub work: Work,
}

/// Cells that are processed side by side.
const LANES: usize = 8;
/// Tolerance from which on all of a search is in single precision, u = G F included.
pub(crate) const SINGLE: f64 = 1e-6;
/// Part of such a tolerance that is aimed at: the rest is for rounding.
const SINGLE_BELOW: f64 = 0.7;
/// Columns on either side of the cells that may touch for which u is found, too. They are the next to touch.
pub(crate) const MARGIN: usize = 4;
/// Relative error to which single precision is trusted at a time.
const DIGITS: f64 = 1e-5;
/// Part of the tolerance that single precision aims at.
const BELOW: f64 = 0.3;
/// Most iterations at a time, some four times the usual number: where cells alternate between touching and not
/// touching, an exact u = G F ends it.
const MOST_ITERATIONS: u64 = 40;
/// Cells on either side that the preconditioner reaches.
const RADIUS: usize = 3;
/// Most sweeps of the fallback over the skew part of G: each takes the error down to a tenth or less.
const MOST_SWEEPS: usize = 40;
/// Stand-in for -infinity where differences are taken.
const NOWHERE: f64 = -1e30;

/// The search with its scratch; only counters, and what the next search begins with, evolve.
pub struct CellSearch {
    cells: InstantCells,
    tolerance: f64,
    counts: CellCounts,
    most: u64,
    gradients: Gradients,
    proportioning: Proportioning,
    required: Vec<f64>,
    displacement: Vec<f64>,
    /// Forces by column.
    of_columns: Vec<f64>,
    /// Forces and displacements to single precision; unused below [`SINGLE`].
    single: [Vec<f32>; 2],
    /// Cells whose `displacement` is that of the last forces; 0 elsewhere.
    found: Range<usize>,
    /// Cells whose `displacement` is that of the forces that come in as the next guess.
    known: Range<usize>,
    /// True if the last search has ended without the forces.
    is_unsettled: bool,
}

impl CellSearch {
    /// Search over the cells of a window. `tolerance` is how far u may be from d, relative to the largest d.
    pub fn new(cells: InstantCells, tolerance: f64) -> Self {
        let zeros = || vec![0.0; cells.cells()];
        let single = || vec![0.0; if tolerance < SINGLE { 0 } else { cells.cells() }];
        Self {
            tolerance,
            counts: CellCounts::default(),
            most: MOST_ITERATIONS,
            gradients: Gradients::new(&cells, RADIUS),
            proportioning: Proportioning::new(cells.cells()),
            required: zeros(),
            displacement: zeros(),
            of_columns: vec![0.0; cells.columns()],
            single: [single(), single()],
            found: 0..cells.cells(),
            known: 0..0,
            is_unsettled: false,
            cells,
        }
    }

    /// Sets the tolerance of the next searches, relative to the largest d; on the same side of [`SINGLE`] as before.
    pub(crate) fn set_tolerance(&mut self, tolerance: f64) {
        self.tolerance = tolerance;
    }

    /// G of the window.
    pub fn cells(&self) -> &InstantCells {
        &self.cells
    }

    /// G of the window, to take products with.
    pub fn cells_mut(&mut self) -> &mut InstantCells {
        &mut self.cells
    }

    /// u = G F of the last solution \[m\], where cells touch and on at least [`MARGIN`] columns on either side; 0
    /// where it is not computed.
    pub fn displacement(&self) -> &[f64] {
        &self.displacement
    }

    /// True if the last search has ended without the forces; at rest none does.
    pub fn is_unsettled(&self) -> bool {
        self.is_unsettled
    }

    /// Work counts so far.
    pub fn counts(&self) -> CellCounts {
        CellCounts { work: self.cells.work(), ..self.counts }
    }

    /// Continues after the window has moved by `cells` cells: the last solution, which has moved with it and has lost
    /// no force, is the next guess, and its displacements need not be found again.
    pub fn advance(&mut self, cells: usize) {
        if cells > 0 {
            self.displacement.copy_within(cells.., 0);
        }
        let moved = |place: usize| place.saturating_sub(cells);
        self.known = moved(self.found.start)..moved(self.found.end);
    }

    fn is_single(&self) -> bool {
        self.tolerance >= SINGLE
    }

    /// u = G F, in double precision unless the tolerance allows single.
    fn multiply(&mut self, forces: &[f64]) {
        if !self.is_single() {
            self.cells.displacement(forces, &mut self.displacement);
            return;
        }
        let [single_forces, displacement] = &mut self.single;
        single_forces.iter_mut().zip(forces).for_each(|(single, force)| *single = *force as f32);
        self.cells.single_displacement(single_forces, displacement);
        self.displacement.iter_mut().zip(displacement).for_each(|(u, single)| *u = f64::from(*single));
    }

    /// Computes u = G F; returns how far the conditions are missed.
    fn displace(&mut self, forces: &[f64], largest: f64) -> CellResiduals {
        self.counts.products += 1;
        self.multiply(forces);
        // Lane by lane and without branches, which would be mispredicted at every other cell.
        let [mut below, mut held] = [[0.0_f64; LANES]; 2];
        let larger = |a: f64, b: f64| if b > a { b } else { a };
        self.found = 0..forces.len();
        let rows = self.displacement.chunks(LANES).zip(self.required.chunks(LANES));
        for (forces, (u, d)) in forces.chunks(LANES).zip(rows) {
            for (lane, ((&force, &u), &d)) in forces.iter().zip(u).zip(d).enumerate() {
                let miss = u - d;
                below[lane] = larger(below[lane], -miss);
                held[lane] = larger(held[lane], if force > 0.0 { miss.abs() } else { 0.0 });
            }
        }
        let worst = |lanes: [f64; LANES]| lanes.into_iter().fold(0.0, larger) / largest;
        CellResiduals { tension: 0.0, penetration: worst(below), complementarity: worst(held) }
    }

    /// Finds the forces \[N\] for the `required` displacements d \[m\]; -infinity marks a cell that cannot touch.
    /// `forces` comes in as the guess. A d that is NaN or +infinity gives NaN residuals and no
    /// forces.
    pub fn solve(&mut self, required: &[f64], forces: &mut [f64]) -> CellResiduals {
        self.counts.solves += 1;
        self.is_unsettled = false;
        let known = std::mem::replace(&mut self.known, 0..0);
        self.found = 0..forces.len();
        let largest = largest_or_zero(required);
        if largest.is_infinite() || required.iter().any(|d| d.is_nan()) {
            forces.fill(0.0);
            self.displacement.fill(0.0);
            return CellResiduals { tension: 0.0, penetration: f64::NAN, complementarity: f64::NAN };
        }
        if largest <= 0.0 {
            forces.fill(0.0);
            self.displacement.fill(0.0);
            return CellResiduals::default();
        }
        let mut is_same = true;
        for ((force, &d), stored) in forces.iter_mut().zip(required).zip(&mut self.required) {
            let good = (d > f64::NEG_INFINITY) & (*force >= 0.0) & (*force < f64::INFINITY);
            let clipped = if good { *force } else { 0.0 };
            is_same &= clipped.to_bits() == force.to_bits();
            *force = clipped;
            *stored = if d > NOWHERE { d } else { NOWHERE };
        }
        let (margin, d) = (if self.is_single() { MARGIN } else { 0 }, &self.required);
        let needed = self.columns_of(|cell| forces[cell] > 0.0 || d[cell] > 0.0, margin);
        let is_held = self.is_single() && self.holds(&known, &needed);
        let mut part = if is_held { known.clone() } else { self.part(&needed) };
        self.cells.restrict_to(part.start);
        if is_same && known.start <= part.start && part.end <= known.end {
            self.gradients.resume(&self.required[part.clone()], &self.displacement[part.clone()], true);
        } else {
            // The first u need not be exact.
            self.gradients.begin(&mut self.cells, &self.required[part.clone()], &forces[part.clone()]);
            self.counts.single_products += 1;
        }
        let least = if self.is_single() { SINGLE_BELOW * self.tolerance } else { BELOW * self.tolerance };
        let first_goal = if self.is_single() { least } else { DIGITS };
        let (mut missing, mut goal, mut is_fresh) = (f64::INFINITY, first_goal, true);
        loop {
            // 1. Projected conjugate gradients on the part.
            let goal_now = (goal * largest) as f32;
            let done = self.gradients.run(&mut self.cells, &mut forces[part.clone()], goal_now, self.most);
            self.counts.iterations += done.iterations;
            self.counts.single_products += done.products;
            self.counts.cuts += done.cuts;
            if self.is_single() && done.residual <= goal_now && self.is_clear_beyond(&part, forces) {
                return self.end_on(part, f64::from(done.residual) / largest);
            }
            // 2. u = G F everywhere; a longer part where the conditions are missed beyond it.
            let residuals = self.displace(forces, largest);
            let residual = residuals.penetration.max(residuals.complementarity);
            if residual <= self.tolerance {
                return residuals;
            }
            let (d, u) = (&self.required, &self.displacement);
            let needed = self.columns_of(|cell| forces[cell] > 0.0 || u[cell] < d[cell], 0);
            let is_same = self.holds(&part, &needed);
            if !is_same {
                let across = self.cells.across();
                part = self.part(&(needed.start.min(part.start / across)..needed.end.max(part.end / across)));
                self.cells.restrict_to(part.start);
            }
            // 3. Too slow even in a fresh direction: the method that always ends.
            let is_slow = residual > 0.5 * missing;
            if is_same && is_slow && is_fresh || residual.is_nan() {
                return self.prove(forces, largest);
            }
            is_fresh = !is_same || is_slow;
            missing = residual;
            goal = least.max(DIGITS * residual);
            let (d, u) = (&self.required[part.clone()], &self.displacement[part.clone()]);
            self.gradients.resume(d, u, is_fresh);
        }
    }

    /// Ends a search on a part of the window, the conditions being missed by at most `missed`.
    fn end_on(&mut self, part: Range<usize>, missed: f64) -> CellResiduals {
        self.displacement[..part.start].fill(0.0);
        self.displacement[part.end..].fill(0.0);
        self.gradients.displacement(&self.required[part.clone()], &mut self.displacement[part.clone()]);
        self.found = part;
        CellResiduals { tension: 0.0, penetration: missed, complementarity: missed }
    }

    /// True if no cell beyond a part of the window can touch, whatever displacements the forces within it cause there.
    fn is_clear_beyond(&mut self, part: &Range<usize>, forces: &[f64]) -> bool {
        let Self { cells, required, of_columns, .. } = self;
        let across = cells.across();
        let inside = part.start / across..part.end / across;
        let sums = forces[part.clone()].chunks_exact(across).map(|cells| cells.iter().sum::<f64>());
        of_columns[inside.clone()].iter_mut().zip(sums).for_each(|(total, sum)| *total = sum);
        let (of_columns, first) = (&of_columns[inside.clone()], inside.start);
        let mut columns = required.chunks_exact(across).enumerate();
        columns.all(|(column, d)| {
            inside.contains(&column)
                || largest_above(NOWHERE, d) <= -cells.lowering(column, (first..).zip(of_columns.iter().copied()))
        })
    }

    /// Columns with cells that belong, and `margin` more at either end.
    fn columns_of(&self, belongs: impl Fn(usize) -> bool, margin: usize) -> Range<usize> {
        let (across, mut cells) = (self.cells.across(), 0..self.required.len());
        match (cells.clone().find(|&cell| belongs(cell)), cells.rfind(|&cell| belongs(cell))) {
            (Some(first), Some(last)) => {
                (first / across).saturating_sub(margin)..(last / across + 1 + margin).min(self.cells.columns())
            }
            _ => 0..0,
        }
    }

    /// True if a part of the window is of a length that there are products for, and holds some columns.
    fn holds(&self, part: &Range<usize>, columns: &Range<usize>) -> bool {
        let (across, length) = (self.cells.across(), part.len() / self.cells.across());
        let is_held = part.start <= columns.start * across && columns.end * across <= part.end;
        (is_held || columns.is_empty()) && self.cells.part(length) == length
    }

    /// Cells of a part of the window, of a length that there are products for, that holds some columns: in its middle,
    /// or, in single precision, at its beginning, since the tyre rolls on.
    fn part(&self, needed: &Range<usize>) -> Range<usize> {
        let (across, columns) = (self.cells.across(), self.cells.columns());
        let length = self.cells.part(needed.len());
        let before = if self.is_single() { 0 } else { (length - needed.len()) / 2 };
        let start = needed.start.saturating_sub(before).min(columns - length);
        start * across..(start + length) * across
    }

    fn prove(&mut self, forces: &mut [f64], largest: f64) -> CellResiduals {
        self.counts.fallbacks += 1;
        if forces.iter().any(|force| !force.is_finite()) {
            forces.fill(0.0);
        }
        if self.cells.turns() {
            return self.prove_by_sweeps(forces, largest);
        }
        let goal = self.tolerance * largest;
        let done = self.proportioning.run(&mut self.cells, &self.required, forces, goal);
        self.counts.iterations += done.iterations;
        self.counts.products += done.products;
        self.displace(forces, largest)
    }

    /// As [`Self::prove`] for a G that is not symmetric: its skew part is taken from the previous sweep.
    fn prove_by_sweeps(&mut self, forces: &mut [f64], largest: f64) -> CellResiduals {
        let mut lagged = vec![0.0; forces.len()];
        for _ in 0..MOST_SWEEPS {
            let residuals = self.displace(forces, largest);
            if residuals.penetration.max(residuals.complementarity) <= self.tolerance {
                return residuals;
            }
            self.cells.symmetric_displacement(forces, &mut lagged);
            self.counts.products += 1;
            // d - (G F - G_s F).
            for (lagged, (d, u)) in lagged.iter_mut().zip(self.required.iter().zip(&self.displacement)) {
                *lagged = d - (u - *lagged);
            }
            let goal = BELOW * self.tolerance * largest;
            let done = self.proportioning.run(&mut self.cells, &lagged, forces, goal);
            self.counts.iterations += done.iterations;
            self.counts.products += done.products;
        }
        let residuals = self.displace(forces, largest);
        self.is_unsettled = residuals.penetration.max(residuals.complementarity) > self.tolerance;
        residuals
    }
}

/// The next search begins with this and the forces.
impl Evolving for CellSearch {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        self.counts = self.counts();
        state.value(&mut self.counts)?;
        self.cells.set_work(self.counts.work);
        state.value(&mut self.found)?;
        let (Range { start, end }, across) = (self.found.clone(), self.cells.across());
        ensure(start <= end && end <= self.displacement.len())?;
        ensure(start.is_multiple_of(across) && end.is_multiple_of(across))?;
        self.displacement.state(state)
    }
}

#[cfg(test)]
#[path = "search_tests.rs"]
mod tests;
