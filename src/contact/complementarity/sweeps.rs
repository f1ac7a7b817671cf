//! Beginning and end of every search for the forces: displacements by forces, sweeps of projected Gauss-Seidel over
//! the points, and counts of the work.

use std::collections::BTreeMap;
use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};
use serde::{Deserialize, Serialize};

use super::factors::FactorCounts;
use crate::contact::windows::{add_windows, add_windows_in};
use crate::counters::Work;
use crate::storage::state::{Evolving, StateError, StateStream};

/// Rounds of full exchange that may fail to reduce the number of points to be exchanged.
pub(crate) const PATIENCE: u32 = 10;

/// Bins of the iteration histogram: solves per step 0, 1, ..., the last one holds everything above.
pub(crate) const HISTOGRAM_BINS: usize = 12;

/// Work of a search over all steps.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct SearchCounts {
    /// Linear solves.
    pub solves: u64,
    /// Steps in which the fallback took over.
    pub fallbacks: u64,
    /// Steps by number of solves.
    pub histogram: [u64; HISTOGRAM_BINS],
    /// The factor cache.
    pub factors: FactorCounts,
    /// Arithmetic of guesses, factorisations and solutions.
    pub work: Work,
    /// The part of `work` that factorised sets.
    pub factorisation: Work,
}

impl SearchCounts {
    /// Adds those of another search, without its factors.
    pub(crate) fn join(&mut self, other: &Self) {
        self.solves += other.solves;
        self.fallbacks += other.fallbacks;
        self.histogram.iter_mut().zip(other.histogram).for_each(|(steps, more)| *steps += more);
        self.work += other.work;
        self.factorisation += other.factorisation;
    }

    /// Number of steps by number of solves, for the numbers that occurred.
    pub fn solves_per_step(&self) -> BTreeMap<u32, u64> {
        let bins = (0..).zip(self.histogram);
        bins.filter(|(_, steps)| *steps > 0).collect()
    }
}

/// Points on the surface: their influence on each other, and what is known of their forces.
pub(super) struct Surface {
    /// G0 by distance \[m/N\], of a tyre that turns its symmetric part.
    pub influence: Vec<f64>,
    /// G0 from distance 1 - columns to columns - 1, and a block of zeros.
    row: Vec<f64>,
    /// The symmetric part likewise; empty at rest.
    symmetric: Vec<f64>,
    arch: Arch,
    /// u = G0 F of the last forces taken \[m\]; behind the columns padding to a whole block.
    pub displacement: Vec<f64>,
    /// Forces of the last step, moved with the road, then of the sweeps \[N\].
    pub estimate: Vec<f64>,
    /// Scratch for y - G0 F.
    residual: Vec<f64>,
    /// Work counts so far.
    pub counts: SearchCounts,
}

impl Surface {
    /// `columns` points at rest; `influence[j]` is G0 of points j apart.
    pub(super) fn new(influence: Vec<f64>, columns: usize) -> Self {
        let mirrored = influence[1..columns].iter().rev();
        Self {
            row: mirrored.chain(&influence[..columns]).chain(&[0.0; BLOCK]).copied().collect(),
            symmetric: Vec::new(),
            influence,
            arch: Arch::new(),
            displacement: vec![0.0; columns.next_multiple_of(BLOCK)],
            estimate: vec![0.0; columns],
            residual: Vec::with_capacity(columns.next_multiple_of(BLOCK)),
            counts: SearchCounts::default(),
        }
    }

    /// Adds a skew part of G0 by distance, of a tyre that turns; empty at rest.
    pub(super) fn add_skew(&mut self, odd: &[f64]) {
        if odd.is_empty() {
            return;
        }
        let columns = self.estimate.len();
        self.symmetric.clone_from(&self.row);
        let odd = odd[..columns].iter().skip(1);
        let (backwards, forwards) = self.row.split_at_mut(columns);
        backwards[..columns - 1].iter_mut().rev().zip(odd.clone()).for_each(|(row, odd)| *row -= odd);
        forwards.iter_mut().zip(odd).for_each(|(row, odd)| *row += odd);
    }

    pub(super) fn is_skew(&self) -> bool {
        !self.symmetric.is_empty()
    }

    /// Moves on by `by` elements: column i becomes column i - `by`. u moves with the forces, and is computed where
    /// columns are new, or everywhere if forces stay behind: the same bits as computed anew.
    pub(super) fn advance(&mut self, by: usize) {
        let columns = self.estimate.len();
        let by = by.min(columns);
        let leaves_forces = self.estimate[..by].iter().any(|force| *force != 0.0);
        move_on(&mut self.estimate, by);
        move_on(&mut self.displacement[..columns], by);
        for column in if leaves_forces { 0 } else { columns - by }..columns {
            let row = self.row[..columns + column].iter().rev();
            let sum = row.zip(&self.estimate).fold(0.0, |sum: f64, (row, &force)| row.mul_add(force, sum));
            self.displacement[column] = sum;
        }
    }

    #[cfg(test)]
    pub(crate) fn start_from(&mut self, forces: &[f64]) {
        self.estimate.copy_from_slice(forces);
        self.displace(forces);
    }

    /// Columns from the first to the last that may carry force, where y is the penetration without forces.
    pub(crate) fn reach(&self, y: &[f64]) -> Range<usize> {
        let may_carry = |(y, force): (&f64, &f64)| *y > 0.0 || *force > 0.0;
        let from = y.iter().zip(&self.estimate).position(may_carry).unwrap_or(0);
        let last = y.iter().zip(&self.estimate).rposition(may_carry);
        from..last.map_or(from, |last| last + 1)
    }

    /// u = G0 F.
    pub(crate) fn displace(&mut self, forces: &[f64]) {
        self.displace_blocks(forces, 0..self.displacement.len() / BLOCK);
    }

    /// u = G0 F of the columns within reach and the rest of their blocks; it is not known elsewhere.
    pub(crate) fn displace_within(&mut self, forces: &[f64], reach: &Range<usize>) {
        self.displace_blocks(forces, blocks_of(reach));
    }

    /// u = G0 F of all other columns, for the same forces.
    pub(crate) fn displace_beside(&mut self, forces: &[f64], reach: &Range<usize>) {
        let Range { start, end } = blocks_of(reach);
        self.displace_blocks(forces, 0..start);
        self.displace_blocks(forces, end..self.displacement.len() / BLOCK);
    }

    /// u = G0 F of some blocks of columns: the same bits as of all.
    fn displace_blocks(&mut self, forces: &[f64], blocks: Range<usize>) {
        let Self { row, arch, displacement, counts, .. } = self;
        let displacement = &mut displacement[BLOCK * blocks.start..BLOCK * blocks.end];
        let (from, last) = (forces.iter().position(|f| *f != 0.0), forces.iter().rposition(|f| *f != 0.0));
        let forces = from.zip(last).map_or(&forces[..0], |(from, last)| &forces[from..=last]);
        let multiply_adds = (forces.len() * displacement.len()) as u64;
        counts.work += Work { multiply_adds, bytes: 8 * multiply_adds };
        let first = (row.len() - BLOCK) / 2 + BLOCK * blocks.start - from.unwrap_or(0);
        displacement.fill(0.0);
        add_windows(*arch, displacement, row, first, forces);
    }

    /// u = G0 F of the estimate, after sweeps that did not end in a solution.
    pub(crate) fn displace_estimate(&mut self) {
        let estimate = std::mem::take(&mut self.estimate);
        self.displace(&estimate);
        self.estimate = estimate;
    }

    /// Brings the estimate of the forces nearer to the solution where y is the penetration without forces; returns
    /// them and y - G0 F of the columns within reach. The stored displacement does not belong to the estimate until it
    /// is computed again. `lagged`: the displacements by a skew part of G0 stay as they are; the sweeps then go to the
    /// minimum of a convex function, which they find from anywhere.
    pub(super) fn sweep(
        &mut self,
        law: impl PointLaw,
        sweeps: usize,
        y: &[f64],
        reach: Range<usize>,
        lagged: bool,
    ) -> (&[f64], &[f64]) {
        let Self { row, symmetric, arch, displacement, estimate, residual, counts, .. } = self;
        let row = if lagged && !symmetric.is_empty() { &*symmetric } else { &*row };
        residual.clear();
        residual.extend(y[reach.clone()].iter().zip(&displacement[reach.clone()]).map(|(y, u)| y - u));
        residual.resize(reach.len().next_multiple_of(BLOCK), 0.0);
        let middle = (row.len() - BLOCK) / 2;
        let at =
            |place: Option<usize>| -place.and_then(|place| row[..2 * middle + 1].get(place)).copied().unwrap_or(0.0);
        let near = std::array::from_fn(|c| std::array::from_fn(|other| at((middle + other).checked_sub(c))));
        let estimate = &mut estimate[reach.clone()];
        let sweeps =
            Sweeps { sweeps, law, first: reach.start, estimate: &mut *estimate, residual: &mut *residual, row, near };
        let changes = arch.dispatch(sweeps);
        let multiply_adds = (changes * residual.len()) as u64;
        counts.work += Work { multiply_adds, bytes: 8 * multiply_adds };
        (estimate, residual)
    }

    /// u = G0 F of the estimate from the residual that sweeps with the whole G0 left of y, within their reach; it is
    /// not known elsewhere.
    pub(crate) fn displaced_within(&mut self, y: &[f64], reach: Range<usize>) {
        let within = self.displacement[reach.clone()].iter_mut().zip(&y[reach]);
        within.zip(&self.residual).for_each(|((displacement, y), residual)| *displacement = y - residual);
    }

    /// Records that nothing touches.
    pub(super) fn rest(&mut self) {
        self.estimate.fill(0.0);
        self.displacement.fill(0.0);
        self.counts.histogram[0] += 1;
    }

    /// Records the forces that a search has found.
    pub(super) fn found(&mut self, forces: &[f64], solves: usize, fell_back: bool) {
        self.counts.solves += solves as u64;
        self.counts.fallbacks += u64::from(fell_back);
        self.counts.histogram[solves.min(HISTOGRAM_BINS - 1)] += 1;
        self.estimate.copy_from_slice(forces);
    }
}

impl Evolving for Surface {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        self.estimate.state(state)?;
        if state.is_restoring() {
            // Counted when they were displaced first.
            self.displace(&self.estimate.clone());
        }
        state.value(&mut self.counts)
    }
}

/// Blocks that hold some columns.
fn blocks_of(columns: &Range<usize>) -> Range<usize> {
    columns.start / BLOCK..columns.end.div_ceil(BLOCK)
}

/// Moves the values of columns after the window has moved on by `by` elements: column i becomes column i - `by`.
pub(crate) fn move_on<T: Copy + Default>(values: &mut [T], by: usize) {
    let columns = values.len();
    let by = by.min(columns);
    values.copy_within(by.., 0);
    values[columns - by..].fill(T::default());
}

/// The law of a point alone.
pub(super) trait PointLaw {
    /// Force of the point while all others stay as they are, from its force so far and the penetration `residual` by
    /// all of them.
    fn force(&mut self, column: usize, force: f64, residual: f64) -> f64;
}

/// Columns of a sweep whose changes reach the others together.
const BLOCK: usize = 8;

/// Sweeps of projected Gauss-Seidel.
struct Sweeps<'a, L> {
    sweeps: usize,
    law: L,
    first: usize,
    /// Forces by column.
    estimate: &'a mut [f64],
    /// y - G0 F, kept up to date.
    residual: &'a mut [f64],
    /// [`Surface::row`].
    row: &'a [f64],
    /// -G0 within a block.
    near: [[f64; BLOCK]; BLOCK],
}

impl<L: PointLaw> WithSimd for Sweeps<'_, L> {
    /// Forces changed.
    type Output = usize;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> usize {
        let Self { sweeps, mut law, first, estimate, residual, row, near } = self;
        let mut blocks = 0;
        let middle = (row.len() - BLOCK) / 2;
        for _ in 0..sweeps {
            for (number, estimate) in estimate.chunks_mut(BLOCK).enumerate() {
                let begin = BLOCK * number;
                // Within the block a change counts at once.
                let (mut current, mut changes) = ([0.0; BLOCK], [0.0; BLOCK]);
                current.copy_from_slice(&residual[begin..begin + BLOCK]);
                let mut changed = false;
                for (c, (estimate, near)) in estimate.iter_mut().zip(&near).enumerate() {
                    let force = law.force(first + begin + c, *estimate, current[c]);
                    let change = force - *estimate;
                    *estimate = force;
                    // With the sign that subtracts it.
                    changes[c] = -change;
                    changed |= change != 0.0;
                    for (current, near) in current.iter_mut().zip(near) {
                        *current = near.mul_add(change, *current);
                    }
                }
                if changed {
                    blocks += 1;
                    add_windows_in(simd, residual, row, middle - begin, &changes[..estimate.len()]);
                }
            }
        }
        BLOCK * blocks
    }
}
