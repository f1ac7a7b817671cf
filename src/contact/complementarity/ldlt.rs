//! L D L^T of symmetric matrices of some hundred rows at most, in the place of their `tiles`.
//!
//! Four columns are done together: the contributions of all columns before them are summed up in registers. Without
//! exchanges: for matrices that are positive definite, or made of a positive and a negative definite block. Compared
//! with faer's blocks: bench `linear_solvers`. Bands are of whole tiles.

use pulp::{Arch, Simd, WithSimd};

use super::tiles::{Assembly, LINE, first_column, packed_length};
use crate::numeric::Aligned;

/// Columns that are done together; a divisor of a tile's rows.
const PANEL: usize = 4;

/// A matrix turned out singular.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Singular;

pub(super) fn finite<'a>(mut values: impl Iterator<Item = &'a f64>) -> Result<(), Singular> {
    if values.all(|value| value.is_finite()) { Ok(()) } else { Err(Singular) }
}

/// L D L^T and solutions with it, with their scratch.
pub struct Ldlt {
    arch: Arch,
    /// D and the panel's rows times D; in solutions sums of the unknowns so far, a line for each column.
    scratch: Aligned,
}

impl Ldlt {
    /// Scratch for matrices of at most `rows` rows.
    pub fn new(rows: usize) -> Self {
        Self { arch: Arch::new(), scratch: Aligned::new(LINE * rows.next_multiple_of(LINE)) }
    }

    /// Assembles G0 of some points, given by increasing column numbers, from G0 by distance: its lower triangle, which
    /// determines it; entries above it, and below the last row, do not matter.
    pub fn assemble(&self, points: &[usize], influence: &[f64], matrix: &mut [f64]) {
        self.assemble_band(points, influence, matrix, points.len());
    }

    /// Assembles a band of G0: `band` blocks of [`LINE`] columns before a block's own.
    pub fn assemble_band(&self, points: &[usize], influence: &[f64], matrix: &mut [f64], band: usize) {
        self.arch.dispatch(Assembly { points, influence, matrix, band });
    }

    /// L below the diagonal and D on it, in place.
    ///
    /// # Errors
    /// [`Singular`].
    pub fn factorise(&mut self, matrix: &mut [f64], rows: usize) -> Result<(), Singular> {
        self.factorise_band(matrix, rows, rows)
    }

    /// L D L^T of a matrix of which only `band` blocks of [`LINE`] columns before a block's own count, as if all
    /// others were zero: they are neither read nor written.
    ///
    /// # Errors
    /// [`Singular`].
    pub fn factorise_band(&mut self, matrix: &mut [f64], rows: usize, band: usize) -> Result<(), Singular> {
        if rows == 0 {
            return Ok(());
        }
        let factors = self.scratch.part(0, (PANEL + 1) * rows.next_multiple_of(LINE));
        self.arch.dispatch(ByPanels { matrix: &mut matrix[..packed_length(rows)], factors, rows, band })
    }

    /// Solves in place with such factors; right sides stand `stride` apart, whole lines.
    ///
    /// # Errors
    /// [`Singular`] unless all results are finite.
    pub fn solve(
        &mut self,
        factor: &[f64],
        right_sides: &mut [f64],
        stride: usize,
        rows: usize,
    ) -> Result<(), Singular> {
        self.solve_band(factor, right_sides, stride, rows, rows)
    }

    /// As [`Self::solve`] with the factors of a band.
    ///
    /// # Errors
    /// [`Singular`] unless all results are finite.
    pub fn solve_band(
        &mut self,
        factor: &[f64],
        right_sides: &mut [f64],
        stride: usize,
        rows: usize,
        band: usize,
    ) -> Result<(), Singular> {
        if rows == 0 {
            return Ok(());
        }
        let (padded, factor) = (rows.next_multiple_of(LINE), &factor[..packed_length(rows)]);
        for right in right_sides.chunks_exact_mut(stride) {
            let right = &mut right[..padded];
            right[rows..].fill(0.0);
            let sums = self.scratch.part(0, LINE * rows);
            self.arch.dispatch(Substitutions { factor, sums, right: &mut *right, rows, band });
            finite(right.iter())?;
        }
        Ok(())
    }
}

/// Columns of L four by four: contributions of those before are summed up in registers, two vectors of rows together.
struct ByPanels<'a> {
    matrix: &'a mut [f64],
    /// Scratch for -D, and for -D L of the rows that meet the panel.
    factors: &'a mut [f64],
    rows: usize,
    /// Blocks of columns before a block's own.
    band: usize,
}

impl WithSimd for ByPanels<'_> {
    type Output = Result<(), Singular>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let Self { matrix, factors, rows, band } = self;
        let (pivots, factors) = factors.split_at_mut(rows.next_multiple_of(LINE));
        let (factors, _) = factors.as_chunks_mut::<PANEL>();
        for j in (0..rows).step_by(PANEL) {
            let end = rows.min(j + PANEL);
            let (number, begin) = (j / LINE, first_column(j / LINE, band));
            let last = matrix.len().min((number + band).saturating_add(1).saturating_mul(LINE * rows));
            let block = &mut matrix[number * LINE * rows..last];
            let factors = &mut factors[..j];
            // 1. -D L of the panel's rows, by column before it.
            let before = factors[begin..].iter_mut().zip(block[LINE * begin..].chunks_exact(LINE));
            for ((factors, tile), &pivot) in before.zip(&pivots[begin..]) {
                let [k, l, m, n] = tile[j % LINE..j % LINE + PANEL] else { continue };
                *factors = [k * pivot, l * pivot, m * pivot, n * pivot];
            }
            let panel = Panel { simd, factors, end, rows, band };
            let streams = block.len() / LINE / rows * (LINE / S::F64_LANES);
            if end == rows {
                panel.open_last(block, streams);
                Corner::of(block, j, end)?.write(block, j, end);
                break;
            }
            // 2. The panel's rows first, then L and D of its corner.
            let mut stream = 0;
            while stream < LINE / S::F64_LANES {
                stream = panel.open(block, stream, streams);
            }
            let corner = Corner::of(block, j, end)?;
            pivots[j..end].iter_mut().zip(corner.pivots).for_each(|(stored, pivot)| *stored = -pivot);
            panel.divide(&corner, block, if end % LINE == 0 { LINE / S::F64_LANES } else { 0 }, stream);
            // 3. The rows below.
            while stream < streams {
                let next = panel.open(block, stream, streams);
                panel.divide(&corner, block, stream, next);
                stream = next;
            }
            corner.write(block, j, end);
        }
        Ok(())
    }
}

/// A panel of columns, and the factors by which all columns before it are subtracted.
#[derive(Clone, Copy)]
struct Panel<'a, S> {
    simd: S,
    /// -D L of the panel's rows, by column before it.
    factors: &'a [[f64; PANEL]],
    /// Column after its last.
    end: usize,
    /// Rows of the matrix.
    rows: usize,
    /// [`ByPanels::band`].
    band: usize,
}

impl<S: Simd> Panel<'_, S> {
    /// Where a stream of vectors of rows begins: those of a block first.
    #[inline(always)]
    fn begin(self, stream: usize) -> usize {
        let vectors = LINE / S::F64_LANES;
        stream / vectors * vectors * self.rows + stream % vectors
    }

    /// First column that a stream's rows have within the band.
    #[inline(always)]
    fn first(self, stream: usize) -> usize {
        first_column(self.factors.len() / LINE + stream * S::F64_LANES / LINE, self.band).min(self.factors.len())
    }

    /// Subtracts the columns before the panel from it, in two streams of rows where the next exists and lies in
    /// another block: vectors of the same one are interleaved. Returns the next stream.
    #[inline(always)]
    fn open(self, block: &mut [f64], stream: usize, streams: usize) -> usize {
        let next = stream + 1;
        let apart = next < streams && next.is_multiple_of(LINE / S::F64_LANES);
        if apart { self.take_off_two(block, stream) } else { self.take_off::<PANEL>(block, stream) }
    }

    /// Opens the last panel likewise: it has no more rows than columns, and may have fewer columns than the others.
    #[inline(always)]
    fn open_last(self, block: &mut [f64], streams: usize) {
        for stream in 0..streams {
            match self.end - self.factors.len() {
                1 => self.take_off::<1>(block, stream),
                2 => self.take_off::<2>(block, stream),
                3 => self.take_off::<3>(block, stream),
                _ => self.take_off::<PANEL>(block, stream),
            };
        }
    }

    /// Subtracts them in one stream, in C columns.
    #[inline(always)]
    fn take_off<const C: usize>(self, block: &mut [f64], stream: usize) -> usize {
        let Self { simd, factors, .. } = self;
        let (vectors, j) = (LINE / S::F64_LANES, factors.len());
        let (block, _) = S::as_mut_simd_f64s(block);
        let (done, panel) = block[self.begin(stream)..].split_at_mut(j * vectors);
        let first = self.first(stream);
        let mut sums = [simd.splat_f64s(0.0); C];
        for (sum, column) in sums.iter_mut().zip(panel.chunks_mut(vectors)) {
            *sum = column[0];
        }
        for (factors, l) in factors[first..].iter().zip(done[first * vectors..].chunks_exact(vectors)) {
            for (sum, &factor) in sums.iter_mut().zip(factors) {
                *sum = simd.mul_add_e_f64s(l[0], simd.splat_f64s(factor), *sum);
            }
        }
        for (sum, column) in sums.iter().zip(panel.chunks_mut(vectors)) {
            column[0] = *sum;
        }
        stream + 1
    }

    /// Subtracts them in two streams of two blocks together.
    #[inline(always)]
    fn take_off_two(self, block: &mut [f64], stream: usize) -> usize {
        let Self { simd, factors, .. } = self;
        let (vectors, j) = (LINE / S::F64_LANES, factors.len());
        let (block, _) = S::as_mut_simd_f64s(block);
        // No closures here: a processor's wider vectors do not reach into those of arrays.
        let (first, second) = block.split_at_mut(self.begin(stream + 1));
        let (one, f) = first[self.begin(stream)..].split_at_mut(j * vectors);
        let (two, g) = second.split_at_mut(j * vectors);
        let [mut a, mut b, mut c, mut d] = [f[0], f[vectors], f[2 * vectors], f[3 * vectors]];
        let [mut p, mut q, mut r, mut s] = [g[0], g[vectors], g[2 * vectors], g[3 * vectors]];
        // The second begins a block later in a band.
        let (first, both) = (self.first(stream), self.first(stream + 1));
        for (&[k, l, m, n], one) in factors[first..both].iter().zip(one[first * vectors..].chunks_exact(vectors)) {
            let [k, l, m, n] = [simd.splat_f64s(k), simd.splat_f64s(l), simd.splat_f64s(m), simd.splat_f64s(n)];
            a = simd.mul_add_e_f64s(one[0], k, a);
            b = simd.mul_add_e_f64s(one[0], l, b);
            c = simd.mul_add_e_f64s(one[0], m, c);
            d = simd.mul_add_e_f64s(one[0], n, d);
        }
        let (factors, one, two) = (&factors[both..], &one[both * vectors..], &two[both * vectors..]);
        let streams = one.chunks_exact(vectors).zip(two.chunks_exact(vectors));
        for (&[k, l, m, n], (one, two)) in factors.iter().zip(streams) {
            let (one, two) = (one[0], two[0]);
            let [k, l, m, n] = [simd.splat_f64s(k), simd.splat_f64s(l), simd.splat_f64s(m), simd.splat_f64s(n)];
            a = simd.mul_add_e_f64s(one, k, a);
            b = simd.mul_add_e_f64s(one, l, b);
            c = simd.mul_add_e_f64s(one, m, c);
            d = simd.mul_add_e_f64s(one, n, d);
            p = simd.mul_add_e_f64s(two, k, p);
            q = simd.mul_add_e_f64s(two, l, q);
            r = simd.mul_add_e_f64s(two, m, r);
            s = simd.mul_add_e_f64s(two, n, s);
        }
        [f[0], f[vectors], f[2 * vectors], f[3 * vectors]] = [a, b, c, d];
        [g[0], g[vectors], g[2 * vectors], g[3 * vectors]] = [p, q, r, s];
        stream + 2
    }

    /// L of some streams of rows, below the corner.
    #[inline(always)]
    fn divide(self, corner: &Corner, block: &mut [f64], first: usize, end: usize) {
        let (block, _) = S::as_mut_simd_f64s(block);
        let (vectors, j) = (LINE / S::F64_LANES, self.factors.len());
        for stream in first..end {
            let panel = &mut block[self.begin(stream) + j * vectors..][..(PANEL - 1) * vectors + 1];
            let l = corner.divide(self.simd, [panel[0], panel[vectors], panel[2 * vectors], panel[3 * vectors]]);
            [panel[0], panel[vectors], panel[2 * vectors], panel[3 * vectors]] = l;
        }
    }
}

/// L and D where the columns of a panel meet their own rows.
struct Corner {
    pivots: [f64; PANEL],
    /// Their reciprocals.
    scales: [f64; PANEL],
    /// L below its diagonal, column by column.
    lower: [[f64; PANEL]; PANEL],
}

impl Corner {
    /// L D L^T of the columns from `j` to `end` where they meet their own rows of a block.
    #[inline(always)]
    fn of(block: &[f64], j: usize, end: usize) -> Result<Self, Singular> {
        let (mut lower, mut pivots, mut scales) = ([[0.0; PANEL]; PANEL], [0.0; PANEL], [0.0; PANEL]);
        for (lower, tile) in lower.iter_mut().zip(block[LINE * j..LINE * end].chunks_exact(LINE)) {
            lower.copy_from_slice(&tile[j % LINE..j % LINE + PANEL]);
        }
        for k in 0..end - j {
            let pivot = lower[k][k];
            if pivot == 0.0 || !pivot.is_finite() {
                return Err(Singular);
            }
            pivots[k] = pivot;
            let scale = pivot.recip();
            scales[k] = scale;
            let (done, open) = lower.split_at_mut(k + 1);
            let pivot_column = &mut done[k];
            pivot_column[k + 1..].iter_mut().for_each(|value| *value *= scale);
            for (next, column) in (k + 1..).zip(open) {
                let factor = -pivot_column[next] * pivot;
                for (value, &above) in column[next..].iter_mut().zip(&pivot_column[next..]) {
                    *value = above.mul_add(factor, *value);
                }
            }
        }
        Ok(Self { pivots, scales, lower })
    }

    /// L of four columns below the corner.
    #[inline(always)]
    fn divide<S: Simd>(&self, simd: S, [a, b, c, d]: [S::f64s; PANEL]) -> [S::f64s; PANEL] {
        let ([p, q, r, s], [l, m, n, _]) = (self.scales, self.lower);
        let b = simd.mul_add_e_f64s(a, simd.splat_f64s(-l[1]), b);
        let c = simd.mul_add_e_f64s(a, simd.splat_f64s(-l[2]), c);
        let c = simd.mul_add_e_f64s(b, simd.splat_f64s(-m[2]), c);
        let d = simd.mul_add_e_f64s(a, simd.splat_f64s(-l[3]), d);
        let d = simd.mul_add_e_f64s(b, simd.splat_f64s(-m[3]), d);
        let d = simd.mul_add_e_f64s(c, simd.splat_f64s(-n[3]), d);
        let a = simd.mul_f64s(a, simd.splat_f64s(p));
        let b = simd.mul_f64s(b, simd.splat_f64s(q));
        let c = simd.mul_f64s(c, simd.splat_f64s(r));
        [a, b, c, simd.mul_f64s(d, simd.splat_f64s(s))]
    }

    #[inline(always)]
    fn write(&self, block: &mut [f64], j: usize, end: usize) {
        for (k, tile) in block[LINE * j..LINE * end].chunks_exact_mut(LINE).enumerate() {
            let column = &mut tile[j % LINE..][..end - j];
            column[k] = self.pivots[k];
            column[k + 1..].copy_from_slice(&self.lower[k][k + 1..end - j]);
        }
    }
}

/// Forward substitution, division by D and backward substitution: a block of rows at a time.
struct Substitutions<'a> {
    factor: &'a [f64],
    sums: &'a mut [f64],
    right: &'a mut [f64],
    rows: usize,
    /// [`ByPanels::band`].
    band: usize,
}

impl WithSimd for Substitutions<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { factor, sums, right, rows, band } = self;
        let vectors = LINE / S::F64_LANES;
        let zero = simd.splat_f64s(0.0);
        // 1. Forwards.
        for (number, block) in factor.chunks_exact(LINE * rows).enumerate() {
            let (solved, open) = right.split_at_mut(LINE * number);
            let (before, diagonal) = block.split_at(LINE * solved.len());
            let first = first_column(number, band);
            let (before, _) = S::as_simd_f64s(&before[LINE * first..]);
            let (open_vectors, _) = S::as_mut_simd_f64s(&mut open[..LINE]);
            for (v, open) in open_vectors.iter_mut().enumerate() {
                let mut sums = [zero; PANEL];
                for (x, tiles) in solved[first..].chunks_exact(PANEL).zip(before.chunks_exact(PANEL * vectors)) {
                    for (k, sum) in sums.iter_mut().enumerate() {
                        *sum = simd.mul_add_e_f64s(tiles[k * vectors + v], simd.splat_f64s(x[k]), *sum);
                    }
                }
                let [a, b, c, d] = sums;
                *open = simd.sub_f64s(*open, simd.add_f64s(simd.add_f64s(a, b), simd.add_f64s(c, d)));
            }
            let Some(x) = open.first_chunk_mut::<LINE>() else { break };
            let (columns, mut values) = (corner(diagonal), *x);
            for c in 0..LINE {
                for r in c + 1..LINE {
                    values[r] = columns[c][r].mul_add(-values[c], values[r]);
                }
            }
            *x = values;
        }
        // 2. Over D and backwards. Entries below the last row are zero.
        right[rows..].fill(0.0);
        let (sums, _) = S::as_mut_simd_f64s(sums);
        sums.fill(zero);
        for (number, block) in factor.chunks_exact(LINE * rows).enumerate().rev() {
            let begin = LINE * number;
            let (before, diagonal) = block.split_at(LINE * begin);
            let Some(x) = right[begin..].first_chunk_mut::<LINE>() else { break };
            let (before_sums, block_sums) = sums.split_at_mut(vectors * begin);
            let (columns, mut taken, mut values) = (corner(diagonal), [0.0; LINE], *x);
            for (taken, sums) in taken.iter_mut().zip(block_sums.chunks_exact(vectors)) {
                let mut sum = sums[0];
                for &more in &sums[1..] {
                    sum = simd.add_f64s(sum, more);
                }
                *taken = simd.reduce_sum_f64s(sum);
            }
            for c in 0..LINE {
                values[c] = values[c] / columns[c][c] - taken[c];
            }
            for c in (0..LINE).rev() {
                // The latest unknown last: the others do not wait for it.
                for r in (c + 1..LINE).rev() {
                    values[c] = (-columns[c][r]).mul_add(values[r], values[c]);
                }
            }
            *x = values;
            let (x, _) = S::as_simd_f64s(&*x);
            let first = first_column(number, band);
            let (before, _) = S::as_simd_f64s(&before[LINE * first..]);
            for (sums, tile) in
                before_sums[vectors * first..].chunks_exact_mut(vectors).zip(before.chunks_exact(vectors))
            {
                for ((sum, &tile), &x) in sums.iter_mut().zip(tile).zip(x) {
                    *sum = simd.mul_add_e_f64s(tile, x, *sum);
                }
            }
        }
    }
}

/// Columns of L and D where a block meets its own rows, from its tiles there on. A last block may have fewer; unknowns
/// are zero there.
#[inline(always)]
fn corner(block: &[f64]) -> [[f64; LINE]; LINE] {
    let (tiles, _) = block.as_chunks::<LINE>();
    match tiles.first_chunk() {
        Some(tiles) => *tiles,
        None => std::array::from_fn(|c| tiles.get(c).copied().unwrap_or([1.0; LINE])),
    }
}

#[cfg(test)]
#[path = "ldlt_tests.rs"]
mod tests;
