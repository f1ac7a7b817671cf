//! Blocks of the tread, each pressed in by its mean pressure, in addition to the yielding of the layers:
//!
//! ```text
//! u_i += (c_b/A_b) sum of the forces on the cells of i's block.
//! ```
//!
//! A matrix of rank one to each block, symmetric and positive semi-definite, without memory: a product takes two
//! additions to each cell. A rib has the mean of such matrices over all places of a block along it, which takes two
//! additions more to a column. Blocks are material and go through the window with their cells.

use std::ops::Range;

use crate::counters::Work;
use crate::numeric::Element;
use crate::tyre::tread_pattern::block_window::{BlockWindow, spread_from_places, sum_over_places};
use crate::tyre::tread_pattern::blocks::{TreadBlock, TreadBlocks};

/// Blocks under a window.
pub struct BlockTerm {
    window: BlockWindow,
    /// c_b/(m A_b) of all places of averaging, A_b the area there \[m/N\].
    per_force: Vec<f64>,
    /// Those in the window, block by block \[m/N\].
    weights: Vec<f64>,
    /// By number of a part: force \[N\], then displacement \[m\].
    parts: Vec<f64>,
    /// By place of averaging, of one block.
    places: Vec<f64>,
    /// First cell of the part of the window that is considered.
    start: usize,
    /// Bound of the norm \[m/N\].
    norm: f64,
}

impl BlockTerm {
    /// Term of cells with an area `face` \[m^2\], `across` to a column, in a window of `window` cells.
    pub fn new(blocks: &TreadBlocks, face: f64, across: usize, window: usize) -> Self {
        let share = |block: &TreadBlock| {
            let share = block.compliance / (f64::from(block.length) * face);
            std::iter::repeat_n(share, block.places() as usize)
        };
        let shares = blocks.blocks.iter().flat_map(share);
        // A place of a rib without cells does not yield.
        let per_force = shares.zip(blocks.averaged(&blocks.cells));
        let norms = blocks.blocks.iter().map(|block| block.compliance / face);
        let mut term = Self {
            window: BlockWindow::new(blocks, across, window / across),
            per_force: per_force.map(|(share, cells)| share / f64::from(cells.max(1))).collect(),
            weights: Vec::new(),
            parts: Vec::new(),
            places: Vec::new(),
            start: 0,
            norm: norms.fold(0.0, f64::max),
        };
        term.take_weights();
        term
    }

    /// Moves to the window that begins with an element.
    pub(super) fn place(&mut self, first_element: i64) {
        if self.window.place(first_element) {
            self.take_weights();
        }
    }

    fn take_weights(&mut self) {
        let Self { window, per_force, weights, parts, .. } = self;
        parts.clear();
        parts.resize(window.count(), 0.0);
        weights.clear();
        let places = window.spans().iter().flat_map(|span| window.places(span));
        weights.extend(places.map(|place| per_force[place]));
    }

    /// Restricts the term to the part of the window that begins with cell `start`.
    pub(super) fn restrict_to(&mut self, start: usize) {
        self.start = start;
    }

    /// Bound of the norm \[m/N\].
    pub(super) fn norm(&self) -> f64 {
        self.norm
    }

    /// Cells of the window that `count` forces stand for: all if there are as many, otherwise the part considered.
    fn range(&self, count: usize) -> Range<usize> {
        let start = if count == self.window.cells().len() { 0 } else { self.start };
        start..start + count
    }

    /// Number of the part of each of `count` cells, 0 for none.
    pub(super) fn parts(&self, count: usize) -> &[u32] {
        &self.window.cells()[self.range(count)]
    }

    /// Blocks in the window: numbers of their parts, from 1 on, how many parts yield together, and c_b/(m A_b) by
    /// place \[m/N\].
    pub(super) fn spans(&self) -> impl Iterator<Item = (Range<usize>, usize, &[f64])> {
        let mut weights = self.weights.as_slice();
        self.window.spans().iter().map(move |span| {
            let span_weights;
            (span_weights, weights) = weights.split_at(span.places());
            (span.numbers(), span.length, span_weights)
        })
    }

    /// Turns forces on parts into displacements, in place.
    fn answer(&mut self) {
        let Self { window, weights, parts, places, .. } = self;
        let mut weights = weights.as_slice();
        parts[0] = 0.0;
        for span in window.spans() {
            let span_weights;
            (span_weights, weights) = weights.split_at(span.places());
            let parts = &mut parts[span.numbers()];
            if span.length == 1 {
                parts.iter_mut().zip(span_weights).for_each(|(part, weight)| *part *= weight);
                continue;
            }
            sum_over_places(parts, span.length, places);
            places.iter_mut().zip(span_weights).for_each(|(place, weight)| *place *= weight);
            spread_from_places(places, span.length, parts);
        }
    }

    /// Adds the displacements by forces on the part considered, or on the whole window.
    pub(super) fn add<R: Element>(&mut self, forces: &[R], out: &mut [R]) {
        let range = self.range(forces.len());
        self.parts.fill(0.0);
        for (force, &part) in forces.iter().zip(&self.window.cells()[range.clone()]) {
            self.parts[part as usize] += force.double();
        }
        self.answer();
        for (out, &part) in out.iter_mut().zip(&self.window.cells()[range]) {
            *out = R::rounded(out.double() + self.parts[part as usize]);
        }
    }

    /// Adds the displacements by one force, over the part of the window that is considered.
    pub(super) fn add_one(&mut self, cell: usize, force: f32, out: &mut [f32]) {
        let range = self.range(out.len());
        let part = self.window.cells()[range.start + cell] as usize;
        self.parts.fill(0.0);
        self.parts[part] = f64::from(force);
        self.answer();
        for (out, &part) in out.iter_mut().zip(&self.window.cells()[range]) {
            *out += self.parts[part as usize] as f32;
        }
    }

    /// Displacement of one cell of the window per force on another \[m/N\].
    pub(super) fn entry(&self, a: usize, b: usize) -> f64 {
        let [a, b] = [a, b].map(|cell| self.window.cells()[cell] as usize);
        for (numbers, length, weights) in self.spans() {
            if numbers.contains(&a) && numbers.contains(&b) {
                let [a, b] = [a, b].map(|part| part - numbers.start);
                return weights.get(a.max(b)..a.min(b) + length).map_or(0.0, |both| both.iter().sum());
            }
        }
        0.0
    }

    pub(super) fn work(cells: usize) -> Work {
        Work { multiply_adds: 2 * cells as u64, bytes: 24 * cells as u64 }
    }
}
