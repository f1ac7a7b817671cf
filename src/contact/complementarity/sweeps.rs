//! What every search for the forces begins with and leaves: displacements by forces, sweeps of projected Gauss-Seidel
//! over the points, and what was done.

use pulp::{Arch, Simd, WithSimd};
use serde::{Deserialize, Serialize};

use super::factors::FactorCounts;
use crate::contact::windows::{add_row, add_windows};
use crate::counters::Work;

/// Rounds of full exchange that may fail to reduce the number of points to be exchanged.
pub(crate) const PATIENCE: u32 = 10;

/// Sweeps of the guess: each costs about half a cached solve, or a quarter of one made anew; two settle which points
/// enter and leave at the ends of the patch. Where slices yield by themselves (dense asphalt, N = 1024) an instant
/// takes 2.00 solves without them, 1.09 with one (1.03 at N = 4096, 2.4 at N = 64), 1.00 with two.
pub(crate) const SWEEPS: usize = 2;

/// Bins of the iteration histogram: solves per step 0, 1, ..., the last one holds everything above.
pub(crate) const HISTOGRAM_BINS: usize = 12;

/// What the search has done over all steps.
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
    /// The part of it that factorised sets.
    pub factorisation: Work,
}

/// Points on the surface: their influence on each other, and what is known of their forces.
pub struct Surface {
    /// G0 by distance.
    pub influence: Vec<f64>,
    /// The same from distance 1 - columns to columns - 1.
    row: Vec<f64>,
    arch: Arch,
    /// G0 F of the forces last looked at.
    pub displacement: Vec<f64>,
    /// Forces of the last step, moved with the road, then of the sweeps.
    pub estimate: Vec<f64>,
    /// What was done so far.
    pub counts: SearchCounts,
}

impl Surface {
    /// Of `columns` points at rest; `influence[j]` is G0 of points j apart.
    pub fn new(influence: Vec<f64>, columns: usize) -> Self {
        Self {
            row: influence[1..columns].iter().rev().chain(&influence[..columns]).copied().collect(),
            influence,
            arch: Arch::new(),
            displacement: vec![0.0; columns],
            estimate: vec![0.0; columns],
            counts: SearchCounts::default(),
        }
    }

    /// u = G0 F, the forces given as (point, force).
    pub(crate) fn displace(&mut self, forces: impl ExactSizeIterator<Item = (usize, f64)> + Clone) {
        self.count_windows(forces.len());
        self.displacement.fill(0.0);
        let last = self.displacement.len() - 1;
        let windows = forces.map(|(point, force)| (last - point, force));
        add_windows(self.arch, &mut self.displacement, &self.row, windows);
    }

    /// Brings the estimate of the forces nearer to the solution.
    pub fn sweep(&mut self, law: impl OwnForce, sweeps: usize) {
        let Self { row, arch, displacement, estimate, .. } = self;
        let last = displacement.len() - 1;
        let forces = estimate.iter().enumerate().filter(|(_, force)| **force != 0.0);
        let started = forces.clone().count();
        displacement.fill(0.0);
        add_windows(*arch, displacement, row, forces.map(|(point, &force)| (last - point, force)));
        let changes = arch.dispatch(Sweeps { sweeps, law, estimate, displacement, row });
        self.count_windows(started + changes);
    }

    /// Takes note that nothing touches.
    pub fn rest(&mut self) {
        self.estimate.fill(0.0);
        self.displacement.fill(0.0);
        self.counts.histogram[0] += 1;
    }

    /// Takes note of the forces that a search has found.
    pub fn found(&mut self, forces: &[f64], solves: usize, fell_back: bool) {
        self.counts.solves += solves as u64;
        self.counts.fallbacks += u64::from(fell_back);
        self.counts.histogram[solves.min(HISTOGRAM_BINS - 1)] += 1;
        self.estimate.copy_from_slice(forces);
    }

    /// Takes note of the sums of so many windows.
    fn count_windows(&mut self, windows: usize) {
        let multiply_adds = (windows * self.displacement.len()) as u64;
        self.counts.work += Work { multiply_adds, bytes: 8 * multiply_adds };
    }
}

/// Values of columns after the window has moved on by a number of elements: what was column i is column i - `by`.
pub(crate) fn move_on<T: Copy + Default>(values: &mut [T], by: usize) {
    let columns = values.len();
    let by = by.min(columns);
    values.copy_within(by.., 0);
    values[columns - by..].fill(T::default());
}

/// The law of a point by itself.
pub trait OwnForce {
    /// Its force while all others stay as they are, from its force so far and u = G0 F there.
    fn force(&mut self, column: usize, force: f64, displacement: f64) -> f64;
}

/// Sweeps of projected Gauss-Seidel.
struct Sweeps<'a, L> {
    /// How many.
    sweeps: usize,
    /// The points' law.
    law: L,
    /// Forces by column.
    estimate: &'a mut [f64],
    /// G0 times the estimate, kept so.
    displacement: &'a mut [f64],
    /// [`Surface::row`].
    row: &'a [f64],
}

impl<L: OwnForce> WithSimd for Sweeps<'_, L> {
    /// Forces changed.
    type Output = usize;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> usize {
        let Self { sweeps, mut law, estimate, displacement, row } = self;
        let mut changes = 0;
        for _ in 0..sweeps {
            for (column, estimate) in estimate.iter_mut().enumerate() {
                let force = law.force(column, *estimate, displacement[column]);
                let change = force - *estimate;
                *estimate = force;
                if change != 0.0 {
                    changes += 1;
                    add_row(simd, displacement, &row[displacement.len() - 1 - column..], change);
                }
            }
        }
        changes
    }
}
