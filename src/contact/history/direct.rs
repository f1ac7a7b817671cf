//! Displacement by past forces: direct convolution in the contact frame.
//!
//! ```text
//! u_old(e) = sum_(p >= 1) sum_e' w_p(e - e') F_(l-p)(e')
//! ```
//!
//! with e in today's window, e' in the window of p steps ago, and w_p(j) = sum over n = -N/2 ... N/2 - 1 of w_(n,p)
//! exp(2 pi i n j/N): the displacement of the element j further on, p steps after a unit force; of a tyre that turns
//! it differs forwards and backwards. This is the reference for every faster method.
//!
//! Cost: lags x (points in contact) x columns multiply-adds a step, read from lags x 2 columns kernel entries. The lags
//! are split into a fixed number of chunks whose sums are added in order: the same bits for any number of threads.

use pulp::Arch;
use rayon::prelude::*;

use super::ForceHistory;
use crate::contact::windows::add_windows;
use crate::counters::{Meter, Stage, Work};
use crate::numeric::Ring;
use crate::storage::state::{Evolving, StateError, StateStream, ensure, evolving};
use crate::time_rule::Advance;
use crate::tyre::influence::convolution_quadrature::Weights;

/// Chunks of lags: enough to balance a many-core machine, fixed so that sums do not depend on it.
const CHUNKS: usize = 32;

/// Kernels of the direct history: influence in the contact frame, lag by lag \[m/N\].
#[derive(Clone, Debug)]
pub struct LagKernel {
    /// Rows by lag, see [`LagKernel::lag`].
    lags: Vec<f64>,
    /// Entries per lag.
    row: usize,
}

impl LagKernel {
    /// Transforms the weights of all wavenumbers to distances between the elements of a window of `columns` columns,
    /// which moves on by `advance` in a step.
    pub fn new(weights: &Weights, elements: usize, columns: usize, advance: impl Into<Advance>) -> Self {
        let advance = advance.into();
        let mut ring = Ring::new(elements);
        let row = padded(columns) + columns + 1;
        let mut lags = vec![0.0; row * weights.lags];
        for (p, kernel) in lags.chunks_exact_mut(row).enumerate().skip(1) {
            let first = advance.elements(p as i64) - (columns as i64 - 1);
            let place = |i: usize| (first + i as i64).rem_euclid(elements as i64) as usize;
            let influence = ring.elements_of(|n| weights.of(n)[p]);
            kernel.iter_mut().enumerate().for_each(|(i, value)| *value = influence[place(i)]);
            if !weights.odd.is_empty() {
                let influence = ring.odd_elements_of(|n| weights.odd_of(n)[p]);
                kernel.iter_mut().enumerate().for_each(|(i, value)| *value += influence[place(i)]);
            }
        }
        Self { lags, row }
    }

    /// Number of lags, lag 0 included.
    fn lags(&self) -> usize {
        self.lags.len() / self.row
    }

    /// Kernel of lag p \[m/N\]: entry r is the influence on the element r - (columns - 1) + floor(p s/q)
    /// further on.
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
    advance: Advance,
    /// Past forces \[N\], row by step modulo the number of lags.
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

evolving!(Mark: first_element, from, to);

impl DirectHistory {
    /// Empty history, everything at rest.
    pub fn new(kernel: LagKernel, columns: usize, advance: impl Into<Advance>) -> Self {
        let lags = kernel.lags();
        Self {
            kernel,
            columns,
            advance: advance.into(),
            forces: vec![0.0; columns * lags],
            marks: vec![Mark::default(); lags],
            partial: vec![0.0; CHUNKS * padded(columns)],
            arch: Arch::new(),
            steps: 0,
        }
    }
}

impl ForceHistory for DirectHistory {
    fn displacement(&mut self, first_element: i64, out: &mut [f64], meter: &mut Meter) {
        let kernel = &self.kernel;
        let width = padded(self.columns);
        let lags = (self.steps as usize).min(kernel.lags() - 1);
        let chunk = (kernel.lags() - 1).div_ceil(CHUNKS).max(1);
        let used = lags.div_ceil(chunk);
        let Self { columns, advance, arch, steps, .. } = *self;
        let (forces, marks) = (&self.forces, &self.marks);
        let add_lag = |p: usize, sum: &mut [f64]| {
            let row = ((steps - p as u64) % marks.len() as u64) as usize;
            let Mark { first_element: then, from, to } = marks[row];
            // Elements that the window has moved on, less the floor(p s/q) that the kernel's row starts from: 0 or 1.
            let shift = (first_element - then - advance.elements(p as i64)) as usize;
            let points = from as usize..to as usize;
            let forces = &forces[row * columns..(row + 1) * columns];
            add_windows(arch, sum, kernel.lag(p), shift + columns - 1 - points.start, &forces[points.clone()]);
            (points.len() * columns) as u64
        };
        let multiply_adds: u64 = self.partial[..used * width]
            .par_chunks_mut(width)
            .enumerate()
            .map(|(index, sum)| {
                let from = 1 + index * chunk;
                sum.fill(0.0);
                (from..(from + chunk).min(lags + 1)).map(|p| add_lag(p, sum)).sum::<u64>()
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
}

impl Evolving for DirectHistory {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        state.all([&mut self.steps, &mut self.forces, &mut self.marks])?;
        ensure(self.marks.iter().all(|mark| mark.from <= mark.to && mark.to as usize <= self.columns))
    }
}
