//! Displacement left over from past forces: direct convolution in the contact frame.
//!
//! ```text
//! u_old(e) = sum_(p >= 1) sum_e' w_p(e - e') F_(l-p)(e')
//! ```
//!
//! with e in today's window, e' in the window of p steps ago, and w_p(j) = sum over n = -N/2 ... N/2 - 1 of w_(n,p)
//! exp(2 pi i n j/N): the displacement of the element j further on, p steps after a unit force. This is the reference for every faster way.
//!
//! Cost: lags x (points in contact) x columns multiply-adds a step, read from lags x 2 columns kernel entries. The lags
//! are split into a fixed number of chunks whose sums are added in order: the same bits for any number of threads.

use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use super::PastForces;
use crate::counters::{Meter, Stage, Work};
use crate::numeric::{Ring, StateError, StateReader, StateWriter};
use crate::tyre::influence::convolution_quadrature::Weights;

/// Chunks of lags: enough to balance a many-core machine, fixed so that sums do not depend on it.
const CHUNKS: usize = 32;

/// Kernels of the direct history: influence in the contact frame, lag by lag.
#[derive(Clone, Debug)]
pub struct LagKernel {
    /// Rows by lag, see [`LagKernel::lag`].
    lags: Vec<f64>,
    /// Entries per lag.
    row: usize,
}

impl LagKernel {
    /// Transforms the weights of all wavenumbers to the elements a window of `columns` can see of itself, `substeps`
    /// steps per element.
    pub fn new(weights: &Weights, elements: usize, columns: usize, substeps: usize) -> Self {
        let mut ring = Ring::new(elements);
        let row = padded(columns) + columns + 1;
        let mut lags = vec![0.0; row * weights.lags];
        for (p, kernel) in lags.chunks_exact_mut(row).enumerate().skip(1) {
            let influence = ring.elements_of(|n| weights.of(n)[p]);
            let first = (p / substeps) as i64 - (columns as i64 - 1);
            for (i, value) in kernel.iter_mut().enumerate() {
                *value = influence[(first + i as i64).rem_euclid(elements as i64) as usize];
            }
        }
        Self { lags, row }
    }

    /// Number of lags, lag 0 included.
    fn lags(&self) -> usize {
        self.lags.len() / self.row
    }

    /// Kernel of lag p: entry r is the influence on the element r - (columns - 1) + floor(p/q) further on.
    pub fn lag(&self, p: usize) -> &[f64] {
        &self.lags[p * self.row..(p + 1) * self.row]
    }
}

/// Columns rounded up to whole vectors of eight.
fn padded(columns: usize) -> usize {
    columns.div_ceil(8) * 8
}

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
    fn displacement(&mut self, first_element: i64, out: &mut [f64], meter: &mut Meter) {
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
        meter.add_work(Stage::History, Work { multiply_adds, bytes: 8 * 3 * (lags * self.columns) as u64 });
    }

    fn push(&mut self, first_element: i64, forces: &[f64]) {
        let row = (self.steps % self.marks.len() as u64) as usize;
        self.forces[row * self.columns..(row + 1) * self.columns].copy_from_slice(forces);
        let from = forces.iter().position(|&force| force > 0.0).unwrap_or(0);
        let to = forces.iter().rposition(|&force| force > 0.0).map_or(from, |last| last + 1);
        self.marks[row] = Mark { first_element, from: from as u32, to: to as u32 };
        self.steps += 1;
    }

    fn save(&self, state: &mut StateWriter) {
        state.count(self.steps);
        state.numbers(&self.forces);
        for mark in &self.marks {
            state.whole(mark.first_element);
            state.count(u64::from(mark.from) << 32 | u64::from(mark.to));
        }
    }

    fn restore(&mut self, state: &mut StateReader<'_>) -> Result<(), StateError> {
        self.steps = state.count()?;
        state.numbers_into(&mut self.forces)?;
        for mark in &mut self.marks {
            let (first_element, columns) = (state.whole()?, state.count()?);
            *mark = Mark { first_element, from: (columns >> 32) as u32, to: columns as u32 };
            if mark.from > mark.to || mark.to as usize > self.columns {
                return Err(StateError::Value);
            }
        }
        Ok(())
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
