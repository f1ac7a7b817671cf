//! L D L^T of symmetric matrices of some hundred rows at most, in memory that is taken once.
//!
//! A matrix lies in *tiles*: [`LINE`] rows of a column side by side, all columns of such a block of rows one after the
//! other, so that what is taken off a block of rows goes through memory in one stretch. Four columns are done together
//! and taken off all that follow. Without exchanges: for matrices that are positive definite, or
//! made of a positive and a negative definite block. Measured with assembly and solution, 32 to 192 points take half
//! the time of whole columns taken off two by two, which took 0.35 to 0.42 of the time of faer's blocks (bench
//! `linear_solvers`).

use pulp::{Arch, Simd, WithSimd};

/// Numbers to a cache line: rows of a tile.
pub const LINE: usize = 8;
/// Columns that are done together; a tile's rows are a multiple.
const PANEL: usize = 4;

/// A matrix turned out singular.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Singular;

/// Zeros that begin on a cache line; pages that are never written to take no memory.
pub struct Aligned {
    memory: Vec<f64>,
    begin: usize,
}

impl Aligned {
    /// So many.
    pub fn new(length: usize) -> Self {
        let memory = vec![0.0; length + LINE - 1];
        let begin = memory.as_ptr().align_offset(8 * LINE).min(LINE - 1);
        Self { memory, begin }
    }

    /// Some of them.
    pub fn part(&mut self, first: usize, length: usize) -> &mut [f64] {
        &mut self.memory[self.begin + first..self.begin + first + length]
    }
}

/// An error unless all values are finite.
pub fn finite<'a>(mut values: impl Iterator<Item = &'a f64>) -> Result<(), Singular> {
    if values.all(|value| value.is_finite()) { Ok(()) } else { Err(Singular) }
}

/// Numbers that a matrix of so many rows takes.
pub const fn room(rows: usize) -> usize {
    rows.next_multiple_of(LINE) * rows
}

/// G0 of some points, given by increasing column numbers, from G0 by distance: its lower triangle, which says it all.
/// Neighbours are copied together.
pub fn assemble(points: &[usize], influence: &[f64], matrix: &mut [f64]) {
    let (tiles, _) = matrix.as_chunks_mut::<LINE>();
    let blocks = tiles.chunks_exact_mut(points.len().max(1)).zip(points.chunks(LINE));
    for (number, (tiles, lines)) in blocks.enumerate() {
        let (before, own) = tiles.split_at_mut(LINE * number);
        let (first, last) = (lines[0], lines[lines.len() - 1]);
        if lines.len() == LINE && last - first < LINE {
            for (tile, &point) in before.iter_mut().zip(points) {
                if let Some(values) = influence[first - point..].first_chunk() {
                    *tile = *values;
                }
            }
        } else {
            before.iter_mut().zip(points).for_each(|(tile, &point)| gather(tile, lines, point, influence));
        }
        own.iter_mut().zip(lines).for_each(|(tile, &point)| gather(tile, lines, point, influence));
    }
}

/// A tile: influence of a point on some others, zeros below them.
fn gather(tile: &mut [f64; LINE], lines: &[usize], point: usize, influence: &[f64]) {
    for (entry, &line) in tile.iter_mut().zip(lines) {
        *entry = influence[line.abs_diff(point)];
    }
    tile[lines.len()..].fill(0.0);
}

/// A matrix given by its lower triangle, as entry(row, column).
pub(crate) fn assemble_entries(rows: usize, entry: impl Fn(usize, usize) -> f64, matrix: &mut [f64]) {
    for (number, tiles) in matrix[..room(rows)].chunks_exact_mut(LINE * rows.max(1)).enumerate() {
        for (column, tile) in tiles.chunks_exact_mut(LINE).enumerate() {
            for (lane, value) in tile.iter_mut().enumerate() {
                let row = LINE * number + lane;
                *value = if row < rows && column <= row { entry(row, column) } else { 0.0 };
            }
        }
    }
}

/// Adds to the diagonal of a matrix.
pub(crate) fn add_to_diagonal(matrix: &mut [f64], values: &[f64]) {
    let rows = values.len();
    for (row, value) in values.iter().enumerate() {
        matrix[LINE * (row / LINE * rows + row) + row % LINE] += value;
    }
}

/// Factorises and solves.
pub struct Ldlt {
    arch: Arch,
    /// The panel times D, row by row of it; in solutions sums of the unknowns so far, a line for each column.
    scratch: Aligned,
}

impl Ldlt {
    /// For up to so many rows.
    pub fn new(rows: usize) -> Self {
        Self { arch: Arch::new(), scratch: Aligned::new(LINE * rows.next_multiple_of(LINE)) }
    }

    /// L below the diagonal and D on it, in place.
    ///
    /// # Errors
    /// [`Singular`].
    pub fn factorise(&mut self, matrix: &mut [f64], rows: usize) -> Result<(), Singular> {
        if rows == 0 {
            return Ok(());
        }
        let factors = self.scratch.part(0, PANEL * rows.next_multiple_of(LINE));
        self.arch.dispatch(ByPanels { matrix: &mut matrix[..room(rows)], factors, rows })
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
        if rows == 0 {
            return Ok(());
        }
        let (padded, factor) = (rows.next_multiple_of(LINE), &factor[..room(rows)]);
        for right in right_sides.chunks_exact_mut(stride) {
            let right = &mut right[..padded];
            right[rows..].fill(0.0);
            let sums = self.scratch.part(0, LINE * rows);
            self.arch.dispatch(Substitutions { factor, sums, right: &mut *right, rows });
            finite(right.iter())?;
        }
        Ok(())
    }
}

/// Columns of L four by four: once such a panel is done, it is taken off all columns that follow.
struct ByPanels<'a> {
    matrix: &'a mut [f64],
    /// -D L of a panel, column by column.
    factors: &'a mut [f64],
    rows: usize,
}

impl WithSimd for ByPanels<'_> {
    type Output = Result<(), Singular>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let Self { matrix, factors, rows } = self;
        let vectors = LINE / S::F64_LANES;
        let (f, rest) = factors.split_at_mut(factors.len() / PANEL);
        let (g, rest) = rest.split_at_mut(f.len());
        let (h, k) = rest.split_at_mut(f.len());
        for j in (0..rows).step_by(PANEL) {
            let (end, own) = (rows.min(j + PANEL), j / LINE * LINE * rows);
            let corner = Corner::of(&matrix[own..], j, end)?;
            if end == rows {
                corner.write(&mut matrix[own..], j, end);
                break;
            }
            for (number, block) in matrix.chunks_exact_mut(LINE * rows).enumerate().skip(end / LINE) {
                let (panel, _) = S::as_mut_simd_f64s(&mut block[LINE * j..LINE * end]);
                let lines = LINE * number..LINE * (number + 1);
                let (f, _) = S::as_mut_simd_f64s(&mut f[lines.clone()]);
                let (g, _) = S::as_mut_simd_f64s(&mut g[lines.clone()]);
                let (h, _) = S::as_mut_simd_f64s(&mut h[lines.clone()]);
                let (k, _) = S::as_mut_simd_f64s(&mut k[lines]);
                for v in 0..vectors {
                    let columns = [panel[v], panel[vectors + v], panel[2 * vectors + v], panel[3 * vectors + v]];
                    let (l, times_pivots) = corner.divide(simd, columns);
                    [panel[v], panel[vectors + v], panel[2 * vectors + v], panel[3 * vectors + v]] = l;
                    [f[v], g[v], h[v], k[v]] = times_pivots;
                }
            }
            // The first block may have reached into the corner.
            corner.write(&mut matrix[own..], j, end);
            for (number, block) in matrix.chunks_exact_mut(LINE * rows).enumerate().skip(end / LINE) {
                let last = rows.min(LINE * (number + 1));
                let (done, open) = block.split_at_mut(LINE * end);
                let (panel, _) = S::as_simd_f64s(&done[LINE * j..]);
                let (open, _) = S::as_mut_simd_f64s(&mut open[..LINE * (last - end)]);
                for v in 0..vectors {
                    let [a, b, c, d] = [panel[v], panel[vectors + v], panel[2 * vectors + v], panel[3 * vectors + v]];
                    let factors = f[end..last].iter().zip(&g[end..last]).zip(&h[end..last]).zip(&k[end..last]);
                    for (open, (((&f, &g), &h), &k)) in open.chunks_exact_mut(vectors).zip(factors) {
                        let sum = simd.mul_add_e_f64s(a, simd.splat_f64s(f), open[v]);
                        let sum = simd.mul_add_e_f64s(b, simd.splat_f64s(g), sum);
                        let sum = simd.mul_add_e_f64s(c, simd.splat_f64s(h), sum);
                        open[v] = simd.mul_add_e_f64s(d, simd.splat_f64s(k), sum);
                    }
                }
            }
        }
        Ok(())
    }
}

/// L and D where the columns of a panel meet their own rows.
struct Corner {
    pivots: [f64; PANEL],
    /// L below its diagonal, column by column.
    lower: [[f64; PANEL]; PANEL],
}

impl Corner {
    /// Of the columns from `j` to `end`, from their block of rows.
    #[inline(always)]
    fn of(block: &[f64], j: usize, end: usize) -> Result<Self, Singular> {
        let (mut lower, mut pivots) = ([[0.0; PANEL]; PANEL], [0.0; PANEL]);
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
            let (done, open) = lower.split_at_mut(k + 1);
            let own = &mut done[k];
            own[k + 1..].iter_mut().for_each(|value| *value *= scale);
            for (next, column) in (k + 1..).zip(open) {
                let factor = -own[next] * pivot;
                for (value, &above) in column[next..].iter_mut().zip(&own[next..]) {
                    *value = above.mul_add(factor, *value);
                }
            }
        }
        Ok(Self { pivots, lower })
    }

    /// L of four columns below the corner, and -D L.
    #[inline(always)]
    fn divide<S: Simd>(&self, simd: S, [a, b, c, d]: [S::f64s; PANEL]) -> ([S::f64s; PANEL], [S::f64s; PANEL]) {
        let ([p, q, r, s], [l, m, n, _]) = (self.pivots, self.lower);
        let a = simd.mul_f64s(a, simd.splat_f64s(p.recip()));
        let b = simd.mul_f64s(simd.mul_add_e_f64s(a, simd.splat_f64s(-l[1] * p), b), simd.splat_f64s(q.recip()));
        let c = simd.mul_add_e_f64s(a, simd.splat_f64s(-l[2] * p), c);
        let c = simd.mul_f64s(simd.mul_add_e_f64s(b, simd.splat_f64s(-m[2] * q), c), simd.splat_f64s(r.recip()));
        let d = simd.mul_add_e_f64s(a, simd.splat_f64s(-l[3] * p), d);
        let d = simd.mul_add_e_f64s(b, simd.splat_f64s(-m[3] * q), d);
        let d = simd.mul_f64s(simd.mul_add_e_f64s(c, simd.splat_f64s(-n[3] * r), d), simd.splat_f64s(s.recip()));
        let times = [
            simd.mul_f64s(a, simd.splat_f64s(-p)),
            simd.mul_f64s(b, simd.splat_f64s(-q)),
            simd.mul_f64s(c, simd.splat_f64s(-r)),
            simd.mul_f64s(d, simd.splat_f64s(-s)),
        ];
        ([a, b, c, d], times)
    }

    #[inline(always)]
    fn write(&self, block: &mut [f64], j: usize, end: usize) {
        for (k, tile) in block[LINE * j..LINE * end].chunks_exact_mut(LINE).enumerate() {
            let own = &mut tile[j % LINE..][..end - j];
            own[k] = self.pivots[k];
            own[k + 1..].copy_from_slice(&self.lower[k][k + 1..end - j]);
        }
    }
}

/// Forwards, over D, backwards: a block of rows at a time.
struct Substitutions<'a> {
    factor: &'a [f64],
    sums: &'a mut [f64],
    right: &'a mut [f64],
    rows: usize,
}

impl WithSimd for Substitutions<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { factor, sums, right, rows } = self;
        let vectors = LINE / S::F64_LANES;
        let zero = simd.splat_f64s(0.0);
        for (number, block) in factor.chunks_exact(LINE * rows).enumerate() {
            let (solved, open) = right.split_at_mut(LINE * number);
            let (before, own) = block.split_at(LINE * solved.len());
            let (before, _) = S::as_simd_f64s(before);
            let (open_vectors, _) = S::as_mut_simd_f64s(&mut open[..LINE]);
            for (v, open) in open_vectors.iter_mut().enumerate() {
                let mut sums = [zero; PANEL];
                for (x, tiles) in solved.chunks_exact(PANEL).zip(before.chunks_exact(PANEL * vectors)) {
                    for (k, sum) in sums.iter_mut().enumerate() {
                        *sum = simd.mul_add_e_f64s(tiles[k * vectors + v], simd.splat_f64s(x[k]), *sum);
                    }
                }
                let [a, b, c, d] = sums;
                *open = simd.sub_f64s(*open, simd.add_f64s(simd.add_f64s(a, b), simd.add_f64s(c, d)));
            }
            for (c, tile) in own.chunks_exact(LINE).take(LINE).enumerate() {
                let x = -open[c];
                for (value, &l) in open[c + 1..LINE].iter_mut().zip(&tile[c + 1..]) {
                    *value = l.mul_add(x, *value);
                }
            }
        }
        let (sums, _) = S::as_mut_simd_f64s(sums);
        sums.fill(zero);
        for (number, block) in factor.chunks_exact(LINE * rows).enumerate().rev() {
            let begin = LINE * number;
            let (before, own) = block.split_at(LINE * begin);
            let x = &mut right[begin..begin + LINE];
            let (before_sums, own_sums) = sums.split_at_mut(vectors * begin);
            let own = own.chunks_exact(LINE).zip(own_sums.chunks_exact(vectors)).take(LINE);
            for (c, (tile, sums)) in own.enumerate().rev() {
                let mut sum = sums[0];
                for &more in &sums[1..] {
                    sum = simd.add_f64s(sum, more);
                }
                let value = x[c] / tile[c] - simd.reduce_sum_f64s(sum);
                let later = x[c + 1..].iter().zip(&tile[c + 1..]);
                x[c] = later.fold(value, |value, (x, l)| (-l).mul_add(*x, value));
            }
            let (x, _) = S::as_simd_f64s(&*x);
            let (before, _) = S::as_simd_f64s(before);
            for (sums, tile) in before_sums.chunks_exact_mut(vectors).zip(before.chunks_exact(vectors)) {
                for ((sum, &tile), &x) in sums.iter_mut().zip(tile).zip(x) {
                    *sum = simd.mul_add_e_f64s(tile, x, *sum);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A positive definite matrix with springs on its diagonal.
    fn entry(i: usize, j: usize) -> f64 {
        (-(i.abs_diff(j) as f64) / 3.0).exp() + if i == j { 0.1 * (1 + i % 5) as f64 } else { 0.0 }
    }

    #[test]
    fn factors_make_the_matrix_and_solve() {
        for rows in [1_usize, 2, 4, 7, 8, 9, 31, 33, 64, 100] {
            let mut matrix = Aligned::new(room(rows));
            let matrix = matrix.part(0, room(rows));
            assemble_entries(rows, entry, matrix);
            let mut solver = Ldlt::new(rows);
            solver.factorise(matrix, rows).unwrap();
            let at = |i: usize, j: usize| matrix[LINE * (i / LINE * rows + j) + i % LINE];
            let l = |i: usize, j: usize| if i == j { 1.0 } else { at(i, j) };
            for i in 0..rows {
                for j in 0..=i {
                    let product: f64 = (0..=j).map(|k| l(i, k) * at(k, k) * l(j, k)).sum();
                    assert!((product - entry(i, j)).abs() < 1e-14, "{rows}: {i}, {j}");
                }
            }
            let stride = rows.next_multiple_of(LINE) + LINE;
            let mut right = vec![f64::NAN; 2 * stride];
            for i in 0..rows {
                right[i] = (0..rows).map(|j| entry(i, j) * (j + 1) as f64).sum();
                right[stride + i] = -2.0 * right[i];
            }
            solver.solve(matrix, &mut right, stride, rows).unwrap();
            for i in 0..rows {
                assert!((right[i] - (i + 1) as f64).abs() < 1e-11, "{rows}: {}", right[i]);
                assert!((right[stride + i] + 2.0 * (i + 1) as f64).abs() < 1e-11, "{rows}");
            }
        }
    }

    #[test]
    fn points_with_gaps_are_assembled_over_whatever_lay_there() {
        let influence: Vec<f64> = (0..80).map(|distance| entry(0, distance)).collect();
        let runs = [0..20, 21..25, 30..31, 33..58, 60..61, 62..63_usize];
        let points: Vec<usize> = runs.into_iter().flatten().collect();
        let rows = points.len();
        let own: Vec<f64> = (0..rows).map(|row| 0.01 * row as f64).collect();
        let (mut made, mut expected) = (vec![f64::NAN; room(rows)], vec![f64::NAN; room(rows)]);
        assemble(&points, &influence, &mut made);
        add_to_diagonal(&mut made, &own);
        let spring = |i: usize, j: usize| if i == j { own[i] } else { 0.0 };
        assemble_entries(rows, |i, j| influence[points[i] - points[j]] + spring(i, j), &mut expected);
        let mut solver = Ldlt::new(rows);
        solver.factorise(&mut made, rows).unwrap();
        solver.factorise(&mut expected, rows).unwrap();
        for i in 0..rows {
            for j in 0..=i {
                let at = LINE * (i / LINE * rows + j) + i % LINE;
                assert!((made[at] - expected[at]).abs() <= 0.0, "{i}, {j}");
            }
        }
    }

    #[test]
    fn a_singular_matrix_is_named() {
        let mut matrix = vec![0.0; room(2)];
        assemble_entries(2, |_, _| 1.0, &mut matrix);
        assert_eq!(Ldlt::new(2).factorise(&mut matrix, 2), Err(Singular));
    }
}
