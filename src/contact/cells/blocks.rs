//! Blocks of the tread, each pressed by its mean pressure beside what the layers yield:
//!
//! ```text
//! u_i += (c_b/A_b) sum of the forces on the cells of i's block.
//! ```
//!
//! A matrix of rank one to each block, symmetric and positive semi-definite, without memory: a product takes two
//! additions to each cell. Blocks are material and go through the window with their cells.

use std::ops::Range;

use crate::counters::Work;
use crate::numeric::Element;
use crate::tyre::tread_pattern::blocks::{Blocks, NO_BLOCK};

/// Blocks under a window.
pub struct BlockTerm {
    /// Block of each cell round the tyre.
    of_cell: Vec<u32>,
    /// c_b/A_b \[m/N\].
    per_force: Vec<f64>,
    across: usize,
    /// Blocks of the window's cells by their numbers in `weights`.
    local: Vec<u32>,
    /// c_b/A_b of the blocks in the window, 0 behind them for cells of none; and a sum for each.
    weights: Vec<f64>,
    sums: Vec<f64>,
    /// Numbers in the window of all blocks.
    numbers: Vec<u32>,
    /// Element of the window's first column.
    first_element: i64,
    /// First cell of the part of the window that is looked at.
    start: usize,
    /// Bound of the norm \[m/N\].
    norm: f64,
}

impl BlockTerm {
    /// Makes the term of cells of a face \[m^2\], `across` to a column, in a window of so many cells.
    pub(crate) fn new(blocks: &Blocks, face: f64, across: usize, window: usize) -> Self {
        let of = |(compliance, cells): (&f64, &u32)| compliance / (f64::from(*cells) * face);
        let per_force: Vec<f64> = blocks.compliance.iter().zip(&blocks.cells).map(of).collect();
        let norms = per_force.iter().zip(&blocks.cells).map(|(weight, cells)| weight * f64::from(*cells));
        let mut term = Self {
            of_cell: blocks.of_cell.clone(),
            norm: norms.fold(0.0, f64::max),
            numbers: vec![NO_BLOCK; per_force.len()],
            per_force,
            across,
            local: vec![0; window],
            weights: Vec::with_capacity(window + 1),
            sums: Vec::with_capacity(window + 1),
            first_element: 0,
            start: 0,
        };
        term.number();
        term
    }

    /// Goes to the window that begins with an element.
    pub(super) fn place(&mut self, first_element: i64) {
        if self.first_element != first_element {
            self.first_element = first_element;
            self.number();
        }
    }

    /// Finds the blocks in the window.
    fn number(&mut self) {
        let Self { of_cell, per_force, across, local, weights, sums, numbers, first_element, .. } = self;
        numbers.fill(NO_BLOCK);
        // Number 0 is that of cells without a block.
        weights.clear();
        weights.push(0.0);
        let columns = (of_cell.len() / *across) as i64;
        for (element, cells) in (*first_element..).zip(local.chunks_exact_mut(*across)) {
            let row = element.rem_euclid(columns) as usize * *across;
            for (cell, &block) in cells.iter_mut().zip(&of_cell[row..row + *across]) {
                if block == NO_BLOCK {
                    *cell = 0;
                    continue;
                }
                let number = &mut numbers[block as usize];
                if *number == NO_BLOCK {
                    *number = weights.len() as u32;
                    weights.push(per_force[block as usize]);
                }
                *cell = *number;
            }
        }
        sums.clear();
        sums.resize(weights.len(), 0.0);
    }

    /// Looks at a part of the window that begins with a cell.
    pub(super) fn look_at(&mut self, start: usize) {
        self.start = start;
    }

    /// Returns a bound of the norm.
    pub(super) fn norm(&self) -> f64 {
        self.norm
    }

    /// Returns the cells of so many that are looked at: all of the window, whatever part was looked at, or that part.
    fn range(&self, count: usize) -> Range<usize> {
        let start = if count == self.local.len() { 0 } else { self.start };
        start..start + count
    }

    /// Returns the block of each of so many cells that are looked at, 0 for none, and c_b/A_b of these blocks \[m/N\].
    pub(super) fn looked_at(&self, count: usize) -> (&[u32], &[f64]) {
        (&self.local[self.range(count)], &self.weights)
    }

    /// Adds what forces do to a part of the window, or to all of it.
    pub(super) fn add<R: Element>(&mut self, forces: &[R], out: &mut [R]) {
        let range = self.range(forces.len());
        let Self { weights, sums, local, .. } = self;
        let local = &local[range];
        sums.fill(0.0);
        for (force, &block) in forces.iter().zip(local) {
            sums[block as usize] += force.double();
        }
        sums.iter_mut().zip(&*weights).for_each(|(sum, weight)| *sum *= weight);
        for (out, &block) in out.iter_mut().zip(local) {
            *out = R::rounded(out.double() + sums[block as usize]);
        }
    }

    /// Adds what one force does to the part of the window that is looked at.
    pub(super) fn add_one(&self, cell: usize, force: f32, out: &mut [f32]) {
        let local = &self.local[self.range(out.len())];
        let block = local[cell];
        let shift = (self.weights[block as usize] * f64::from(force)) as f32;
        if shift.abs() > 0.0 {
            let own = out.iter_mut().zip(local).filter(|(_, other)| **other == block);
            own.for_each(|(out, _)| *out += shift);
        }
    }

    /// Returns what a force on one cell of the window does to another \[m/N\].
    pub(super) fn entry(&self, a: usize, b: usize) -> f64 {
        if self.local[a] == self.local[b] { self.weights[self.local[a] as usize] } else { 0.0 }
    }

    /// Returns the work of a product over so many cells.
    pub(super) fn work(cells: usize) -> Work {
        Work { multiply_adds: 2 * cells as u64, bytes: 24 * cells as u64 }
    }
}
