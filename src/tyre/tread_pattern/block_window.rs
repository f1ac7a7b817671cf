//! Blocks of the tread under a window, numbered part by part.
//!
//! A rib yields like the mean over blocks of m parts wherever they begin: values by part are summed over each place of
//! such a block, weighted, and distributed to the parts. Both sums are running sums: two additions for each part.

use std::ops::Range;

use super::blocks::{NO_BLOCK, TreadBlock, TreadBlocks};

/// Parts of one block that may be in a window.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BlockSpan {
    /// Number of the first part in the window, above 0.
    first: usize,
    /// Parts, one after the other.
    parts: usize,
    /// Number of parts over which pressure is averaged.
    pub length: usize,
    /// First of these parts on the tyre, counted within the block, and the block.
    offset: usize,
    block: usize,
}

impl BlockSpan {
    pub(crate) fn numbers(&self) -> Range<usize> {
        self.first..self.first + self.parts
    }

    /// Number of places of averaging that reach the parts.
    pub(crate) fn places(&self) -> usize {
        self.parts + self.length - 1
    }
}

/// Blocks under a window of the tyre.
#[derive(Clone, Debug)]
pub(crate) struct BlockWindow {
    blocks: TreadBlocks,
    across: usize,
    /// Block of each part, and the first place of averaging of each block.
    block_of: Vec<u32>,
    first_place: Vec<usize>,
    /// Number of the part of each cell in the window, 0 for cells of none.
    cells: Vec<u32>,
    /// One more than the largest number of a part.
    count: usize,
    spans: Vec<BlockSpan>,
    /// First number by block; [`NO_BLOCK`] where it is not in the window.
    numbers: Vec<u32>,
    /// Element of the window's first column.
    first_element: i64,
}

impl BlockWindow {
    /// Window of so many columns that begins with element 0.
    pub(crate) fn new(blocks: &TreadBlocks, across: usize, columns: usize) -> Self {
        let mut next = 0;
        let place = |block: &TreadBlock| {
            next += block.places() as usize;
            next - block.places() as usize
        };
        let first_place = blocks.blocks.iter().map(place).collect();
        let of = |(number, block): (usize, &TreadBlock)| std::iter::repeat_n(number as u32, block.parts as usize);
        let mut window = Self {
            block_of: blocks.blocks.iter().enumerate().flat_map(of).collect(),
            first_place,
            cells: vec![0; columns * across],
            count: 1,
            spans: Vec::new(),
            numbers: vec![NO_BLOCK; blocks.blocks.len()],
            first_element: 0,
            blocks: blocks.clone(),
            across,
        };
        window.number();
        window
    }

    /// Moves the window to begin with an element; returns whether it began with another one.
    pub(crate) fn place(&mut self, first_element: i64) -> bool {
        let is_other = self.first_element != first_element;
        if is_other {
            self.first_element = first_element;
            self.number();
        }
        is_other
    }

    /// Numbers the parts of the blocks in the window.
    fn number(&mut self) {
        let Self { blocks, across, block_of, cells, count, spans, numbers, first_element, .. } = self;
        let columns = blocks.of_cell.len() / *across;
        let (start, wide) = (first_element.rem_euclid(columns as i64) as usize, cells.len() / *across);
        numbers.fill(NO_BLOCK);
        spans.clear();
        *count = 1;
        for (column, cells) in cells.chunks_exact_mut(*across).enumerate() {
            let row = (start + column) % columns * *across;
            for (cell, &part) in cells.iter_mut().zip(&blocks.of_cell[row..row + *across]) {
                if part == NO_BLOCK {
                    *cell = 0;
                    continue;
                }
                let number = block_of[part as usize] as usize;
                let TreadBlock { first, parts, length, is_ring, .. } = blocks.blocks[number];
                let (parts, length, within) = (parts as usize, length as usize, (part - first) as usize);
                if numbers[number] == NO_BLOCK {
                    numbers[number] = *count as u32;
                    // Of a ring the parts in the window, of a block all parts.
                    let [offset, parts] = if is_ring { [start, wide.min(parts)] } else { [0, parts] };
                    spans.push(BlockSpan { first: *count, parts, length, offset, block: number });
                    *count += parts;
                }
                let from = if is_ring { (within + parts - start) % parts } else { within };
                *cell = numbers[number] + from as u32;
            }
        }
    }

    /// Number of the part of each cell, 0 for cells of none.
    pub(crate) fn cells(&self) -> &[u32] {
        &self.cells
    }

    /// One more than the largest number of a part.
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    pub(crate) fn spans(&self) -> &[BlockSpan] {
        &self.spans
    }

    /// Places of averaging that reach the parts of a span, in the order of [`TreadBlocks::averaged`]: the first one
    /// ends with the first part.
    pub(crate) fn places(&self, span: &BlockSpan) -> impl Iterator<Item = usize> + use<> {
        let BlockSpan { length, offset, block, .. } = *span;
        let (first, count) = (self.first_place[block], self.blocks.blocks[block].places() as usize);
        let before = if self.blocks.blocks[block].is_ring { length - 1 } else { 0 };
        (0..span.places()).map(move |place| first + (offset + place + count - before) % count)
    }

    /// Parts of a span as they are counted on the tyre.
    pub(crate) fn parts(&self, span: &BlockSpan) -> impl Iterator<Item = usize> + use<> {
        let TreadBlock { first, parts, .. } = self.blocks.blocks[span.block];
        let offset = span.offset;
        (0..span.parts).map(move |part| first as usize + (offset + part) % parts as usize)
    }
}

/// Sums values over each place of `length` of them that reaches one.
pub(crate) fn sum_over_places(values: &[f64], length: usize, sums: &mut Vec<f64>) {
    let mut sum = 0.0;
    sums.clear();
    sums.extend((0..values.len() + length - 1).map(|place| {
        sum += values.get(place).copied().unwrap_or(0.0);
        if let Some(leaving) = place.checked_sub(length) {
            sum -= values[leaving];
        }
        sum
    }));
}

/// Sets each value to the sum over the places that reach it.
pub(crate) fn spread_from_places(places: &[f64], length: usize, values: &mut [f64]) {
    let mut sum: f64 = places[..length - 1].iter().sum();
    for (first, value) in values.iter_mut().enumerate() {
        sum += places[first + length - 1];
        *value = sum;
        sum -= places[first];
    }
}
