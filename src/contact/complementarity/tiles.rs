//! Symmetric matrices by tiles, in memory that is taken once.
//!
//! A matrix lies in *tiles*: [`LINE`] rows of a column side by side, all columns of such a block of rows one after the
//! other, so that the data of a block of rows pass through memory in one stretch. The lower triangle determines it.

use pulp::{Simd, WithSimd};

/// Numbers to a cache line: rows of a tile.
pub const LINE: usize = 8;

/// Numbers that a matrix of `rows` rows takes, padding included.
pub const fn packed_length(rows: usize) -> usize {
    rows.next_multiple_of(LINE) * rows
}

/// First column of a block of rows in a band of `band` blocks before its own.
#[inline(always)]
pub(super) fn first_column(block: usize, band: usize) -> usize {
    LINE * block.saturating_sub(band)
}

/// G0 of some points; neighbours are copied together.
pub(super) struct Assembly<'a> {
    /// Column numbers, rising.
    pub points: &'a [usize],
    /// G0 by distance.
    pub influence: &'a [f64],
    /// Tiles of the matrix.
    pub matrix: &'a mut [f64],
    /// Blocks of columns before a block's own that count.
    pub band: usize,
}

impl WithSimd for Assembly<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { points, influence, matrix, band } = self;
        // Influence from distance -7 to 7.
        let mut both_ways = [0.0; 2 * LINE];
        for (index, value) in both_ways.iter_mut().enumerate() {
            *value = influence.get((index + 1).abs_diff(LINE)).copied().unwrap_or(0.0);
        }
        let (tiles, _) = matrix.as_chunks_mut::<LINE>();
        let blocks = tiles.chunks_exact_mut(points.len().max(1)).zip(points.chunks(LINE));
        for (number, (tiles, lines)) in blocks.enumerate() {
            let (before, corner) = tiles.split_at_mut(LINE * number);
            let begin = first_column(number, band);
            let (before, points) = (&mut before[begin..], &points[begin..]);
            let (first, last) = (lines[0], lines[lines.len() - 1]);
            if last - first + 1 == lines.len() {
                for (tile, &point) in before.iter_mut().zip(points) {
                    match influence[first - point..].first_chunk() {
                        Some(values) => *tile = *values,
                        None => gather(tile, lines, point, influence),
                    }
                }
                for (c, tile) in corner.iter_mut().enumerate().take(LINE) {
                    if let Some(values) = both_ways[LINE - 1 - c..].first_chunk() {
                        *tile = *values;
                    }
                }
            } else {
                for (tile, &point) in before.iter_mut().chain(corner.iter_mut().take(LINE)).zip(points) {
                    gather(tile, lines, point, influence);
                }
            }
        }
    }
}

/// Gathers a tile: the influence of a point on some others, zeros below them.
#[inline(always)]
fn gather(tile: &mut [f64; LINE], lines: &[usize], point: usize, influence: &[f64]) {
    for (entry, &line) in tile.iter_mut().zip(lines) {
        *entry = influence[line.abs_diff(point)];
    }
    tile[lines.len()..].fill(0.0);
}

/// Writes a matrix by its lower triangle, given as entry(row, column).
pub(crate) fn assemble_entries(rows: usize, entry: impl Fn(usize, usize) -> f64, matrix: &mut [f64]) {
    for (number, tiles) in matrix[..packed_length(rows)].chunks_exact_mut(LINE * rows.max(1)).enumerate() {
        for (column, tile) in tiles.chunks_exact_mut(LINE).enumerate() {
            for (lane, value) in tile.iter_mut().enumerate() {
                let row = LINE * number + lane;
                *value = if row < rows && column <= row { entry(row, column) } else { 0.0 };
            }
        }
    }
}

/// Adds `values`, one for each row, to the diagonal of a matrix in tiles.
pub fn add_to_diagonal(matrix: &mut [f64], values: &[f64]) {
    let rows = values.len();
    for (row, value) in values.iter().enumerate() {
        matrix[LINE * (row / LINE * rows + row) + row % LINE] += value;
    }
}
