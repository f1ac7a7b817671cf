//! Displacement left over from past forces: direct convolution in the contact frame.
//!
//! ```text
//! u_old(e) = sum_(p >= 1) sum_e' w_p(e - e') F_(l-p)(e')
//! ```
//!
//! with e in today's window and e' in the window of p steps ago. This is the reference for every faster way.
//!
//! Cost: lags x (points in contact) x columns multiply-adds a step, read from lags x 2 columns kernel entries. The lags
//! are split into a fixed number of chunks whose sums are added in order: the same bits for any number of threads.

use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use super::state::{DirectState, HistoryState};
use super::{HistoryWork, PastForces};
use crate::contact::tread::{LagKernel, padded};
use crate::counters::Work;
use crate::storage::state::{StateError, fill};

/// Chunks of lags: enough to balance a many-core machine, fixed so that sums do not depend on it.
const CHUNKS: usize = 32;

/// Ring of past forces and the sums over it.
#[derive(Clone, Debug)]
pub struct DirectHistory {
    kernel: LagKernel,
    columns: usize,
    substeps: usize,
    /// Past forces, row by step modulo the number of lags.
    forces: Vec<f64>,
    /// First element and the columns with force, by row.
    marks: Vec<Mark>,
    partial: Vec<f64>,
    arch: Arch,
    steps: u64,
}

/// Where the forces of a past step are.
#[derive(Clone, Copy, Debug, Default)]
struct Mark {
    first_element: i64,
    from: u32,
    to: u32,
}

impl DirectHistory {
    /// An empty history (everything at rest).
    pub fn new(kernel: LagKernel, columns: usize, substeps: usize) -> Self {
        let lags = kernel.lags();
        Self {
            kernel,
            columns,
            substeps,
            forces: vec![0.0; columns * lags],
            marks: vec![Mark::default(); lags],
            partial: vec![0.0; CHUNKS * padded(columns)],
            arch: Arch::new(),
            steps: 0,
        }
    }
}

impl PastForces for DirectHistory {
    fn displacement(&mut self, first_element: i64, out: &mut [f64]) -> HistoryWork {
        let kernel = &self.kernel;
        let width = padded(self.columns);
        let lags = (self.steps as usize).min(kernel.lags() - 1);
        let chunk = (kernel.lags() - 1).div_ceil(CHUNKS).max(1);
        let used = lags.div_ceil(chunk);
        let past = Past {
            columns: self.columns,
            substeps: self.substeps,
            forces: &self.forces,
            marks: &self.marks,
            steps: self.steps,
        };
        let arch = self.arch;
        let multiply_adds: u64 = self.partial[..used * width]
            .par_chunks_mut(width)
            .enumerate()
            .map(|(index, sum)| {
                let from = 1 + index * chunk;
                let to = (from + chunk).min(lags + 1);
                arch.dispatch(LagSum { past, kernel, first_element, from, to, sum })
            })
            .sum();
        out.fill(0.0);
        for sum in self.partial[..used * width].chunks_exact(width) {
            for (total, &part) in out.iter_mut().zip(sum) {
                *total += part;
            }
        }
        // Kernel rows of twice the window, and the forces.
        let sums = Work { multiply_adds, bytes: 8 * 3 * (lags * self.columns) as u64 };
        HistoryWork { sums, ..HistoryWork::default() }
    }

    fn push(&mut self, first_element: i64, forces: &[f64]) {
        let row = (self.steps % self.marks.len() as u64) as usize;
        self.forces[row * self.columns..(row + 1) * self.columns].copy_from_slice(forces);
        let from = forces.iter().position(|&force| force > 0.0).unwrap_or(0);
        let to = forces.iter().rposition(|&force| force > 0.0).map_or(from, |last| last + 1);
        self.marks[row] = Mark { first_element, from: from as u32, to: to as u32 };
        self.steps += 1;
    }

    fn save(&self) -> HistoryState {
        HistoryState::Direct(DirectState {
            steps: self.steps,
            forces: self.forces.clone(),
            marks: self.marks.iter().map(|mark| (mark.first_element, mark.from..mark.to)).collect(),
        })
    }

    fn restore(&mut self, state: HistoryState) -> Result<(), StateError> {
        let HistoryState::Direct(DirectState { steps, forces, marks }) = state else { return Err(StateError::Value) };
        self.steps = steps;
        fill(&mut self.forces, &forces)?;
        if marks.iter().any(|(_, columns)| columns.start > columns.end || columns.end as usize > self.columns) {
            return Err(StateError::Value);
        }
        let mark = |(first_element, columns): &(i64, Range<u32>)| Mark {
            first_element: *first_element,
            from: columns.start,
            to: columns.end,
        };
        fill(&mut self.marks, &marks.iter().map(mark).collect::<Vec<_>>())
    }
}

/// The ring, borrowed.
#[derive(Clone, Copy)]
struct Past<'a> {
    columns: usize,
    substeps: usize,
    forces: &'a [f64],
    marks: &'a [Mark],
    steps: u64,
}

/// The sum over the lags `from..to`.
struct LagSum<'a> {
    past: Past<'a>,
    kernel: &'a LagKernel,
    first_element: i64,
    from: usize,
    to: usize,
    sum: &'a mut [f64],
}

impl WithSimd for LagSum<'_> {
    type Output = u64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> u64 {
        let Self { past, kernel, first_element, from, to, sum } = self;
        sum.fill(0.0);
        let width = sum.len();
        let mut points = 0;
        for p in from..to {
            let row = ((past.steps - p as u64) % past.marks.len() as u64) as usize;
            let mark = past.marks[row];
            let forces = &past.forces[row * past.columns..(row + 1) * past.columns];
            // Elements that the window has moved on, less the floor(p/q) that the kernel's row starts from: 0 or 1.
            let shift = (first_element - mark.first_element) as usize - p / past.substeps;
            let kernel = &kernel.lag(p)[shift..];
            let (mut j, end) = (mark.from as usize, mark.to as usize);
            points += end - j;
            let window = |j: usize| {
                let start = past.columns - 1 - j;
                S::as_simd_f64s(&kernel[start..start + width]).0
            };
            let (total, _) = S::as_mut_simd_f64s(sum);
            while j + 4 <= end {
                let factors = [0, 1, 2, 3].map(|i| simd.splat_f64s(forces[j + i]));
                let rows = [window(j), window(j + 1), window(j + 2), window(j + 3)];
                for ((((total, &a), &b), &c), &d) in
                    total.iter_mut().zip(rows[0]).zip(rows[1]).zip(rows[2]).zip(rows[3])
                {
                    let first = simd.mul_add_e_f64s(factors[0], a, *total);
                    let second = simd.mul_add_e_f64s(factors[1], b, first);
                    let third = simd.mul_add_e_f64s(factors[2], c, second);
                    *total = simd.mul_add_e_f64s(factors[3], d, third);
                }
                j += 4;
            }
            while j < end {
                let factor = simd.splat_f64s(forces[j]);
                for (total, &a) in total.iter_mut().zip(window(j)) {
                    *total = simd.mul_add_e_f64s(factor, a, *total);
                }
                j += 1;
            }
        }
        (points * past.columns) as u64
    }
}
