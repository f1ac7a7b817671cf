//! Least squares of a relocation by normal equations: products of columns and Cholesky factors, all over vectors.
//!
//! With C = (phi_r, 1) and B_q = H_q (phi_r, 1), weighted (see [`super::vector_fitting`]), the unknowns (c, d) of sigma
//! minimise (c, d)^T S (c, d) under the row that forbids 0,
//!
//! ```text
//! S = sum over q of B_q^T B_q - W_q^T W_q,    W_q = L^-1 C^T B_q,    L L^T = C^T C.
//! ```
//!
//! S holds the square of what reflections hold: of a direction in which poles hardly matter, with a share of less than
//! 1e-7 or so, it holds nothing but rounding. c = 0 leaves the poles where they are, so that a ridge of the size of
//! that rounding on c leaves alone what S does not determine. Measured on the default tyre at 3e-6, N = 1024, before
//! removals were tried more often: a third fewer relocations than with reflections, which send such poles about (1291
//! against 1871; with the removals of today 1702). A pivot that has lost its digits all the same is reported, and the
//! caller takes reflections.

use std::ops::Range;

use num_complex::Complex64;
use pulp::{Arch, Simd, WithSimd};

use super::basis::{ColumnMatrix, Points};
use super::partial_fractions::order;
use super::{ComplexParts, Samples};
use crate::numeric::MOST_LANES;

/// Columns and rows of a block of products that is held in registers.
const BLOCK: usize = 4;
/// A pivot below this fraction of its diagonal entry has lost its digits.
const LEAST_PIVOT: f64 = 1e-14;

/// Ridge on c, relative to the square of its column of B: the rounding of S, measured. A tenth of it is too little
/// (half of the relocations lose their digits), a hundred times as much takes 9 % more poles.
const RIDGE: f64 = 1e-13;

/// (c, d) of sigma; `None` where pivots have lost their digits.
pub(super) fn sigma(samples: &Samples, poles: &[Complex64], with_constant: bool) -> Option<Vec<f64>> {
    let count = order(poles);
    let (left, right) = (count + usize::from(with_constant), count + 1);
    let points = Points::new(&samples.points, &samples.point_weights);
    // C, then every B_q.
    let mut columns = ColumnMatrix::zeros(points.rows(), left + right * samples.responses.len());
    points.fill(poles, with_constant, &mut columns.entries);
    for (q, response) in samples.responses.iter().enumerate() {
        let response = ComplexParts::new(response.iter().copied(), 0.0);
        let (known, rest) = columns.entries.split_at_mut((left + q * right) * columns.rows);
        points.multiply(&known[..count * columns.rows], &response, samples.weights[q], rest);
    }
    // S, with the ridge on c.
    let mut reduced = reduced(&columns, left, right)?;
    for j in 0..count {
        let squares = columns.entries[left * columns.rows..].chunks_exact(columns.rows).skip(j).step_by(right);
        let size: f64 = squares.flatten().map(|entry| entry * entry).sum();
        reduced.entries[j * reduced.rows + j] += RIDGE * size;
    }
    // The row that forbids sigma = 0: mean of Re sigma = 1, as heavy as all samples of a response of size 1 together.
    let number = samples.points.len();
    let heavy = samples.responses.len() as f64 / number as f64;
    let mean = |j: usize| -> f64 {
        let values = columns.column(j)[..number].iter().zip(&samples.point_weights);
        values.map(|(value, weight)| value / weight).sum()
    };
    let row: Vec<f64> = (0..count).map(mean).chain([number as f64]).collect();
    for (j, column) in reduced.entries.chunks_exact_mut(reduced.rows).enumerate() {
        for (entry, value) in column.iter_mut().zip(&row) {
            *entry += heavy * value * row[j];
        }
    }
    if !factorise(&mut reduced, right) {
        return None;
    }
    let mut sigma: Vec<f64> = row.iter().map(|value| value * heavy * number as f64).collect();
    solve(&reduced, &mut sigma);
    sigma.iter().all(|entry| entry.is_finite()).then_some(sigma)
}

/// S (lower triangle) from C (`left` columns) and the B_q (`right` columns each); `None` where a pivot of C^T C has
/// lost its digits.
fn reduced(columns: &ColumnMatrix, left: usize, right: usize) -> Option<ColumnMatrix> {
    // 1. C^T C = L L^T, and L^-1.
    let padded = left.next_multiple_of(MOST_LANES);
    let mut factor = ColumnMatrix::zeros(padded, left);
    products([columns, columns], 0..left, 0..left, &mut factor);
    if !factorise(&mut factor, left) {
        return None;
    }
    let mut inverse = ColumnMatrix::zeros(padded, left);
    invert(&factor, left, &mut inverse);
    // 2. Sum over q of B_q^T B_q - W_q^T W_q.
    let mut reduced = ColumnMatrix::zeros(right.next_multiple_of(MOST_LANES), right);
    let mut part = reduced.clone();
    let (mut mixed, mut projected) = (ColumnMatrix::zeros(padded, right), ColumnMatrix::zeros(padded, right));
    let number = columns.entries.len() / columns.rows;
    for start in (left..number).step_by(right) {
        let range = start..start + right;
        products([columns, columns], range.clone(), range.clone(), &mut part);
        accumulate(&mut reduced, &part, 1.0);
        products([columns, columns], 0..left, range, &mut mixed);
        products([&inverse, &mixed], 0..left, 0..right, &mut projected);
        products([&projected, &projected], 0..right, 0..right, &mut part);
        accumulate(&mut reduced, &part, -1.0);
    }
    Some(reduced)
}

fn accumulate(sum: &mut ColumnMatrix, part: &ColumnMatrix, sign: f64) {
    for (sum, part) in sum.entries.iter_mut().zip(&part.entries) {
        *sum += sign * part;
    }
}

/// Products of columns: `target` column j - right.start, row i - left.start is column i of the first times column j of
/// the second, for i in `left`, j in `right`. Of columns times themselves only the lower triangle is valid.
fn products(columns: [&ColumnMatrix; 2], left: Range<usize>, right: Range<usize>, target: &mut ColumnMatrix) {
    Arch::new().dispatch(Products { columns, left, right, target });
}

struct Products<'a> {
    columns: [&'a ColumnMatrix; 2],
    left: Range<usize>,
    right: Range<usize>,
    target: &'a mut ColumnMatrix,
}

impl WithSimd for Products<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { columns, left, right, target } = self;
        let [first, second] = columns;
        let triangle = std::ptr::eq(first, second) && left == right;
        let vectors = first.rows / S::F64_LANES;
        for j0 in right.clone().step_by(BLOCK) {
            let to: [&[S::f64s]; BLOCK] =
                std::array::from_fn(|j| &S::as_simd_f64s(second.column((j0 + j).min(right.end - 1))).0[..vectors]);
            for i0 in left.clone().step_by(BLOCK) {
                if triangle && i0 < j0 {
                    continue;
                }
                let from: [&[S::f64s]; BLOCK] =
                    std::array::from_fn(|i| &S::as_simd_f64s(first.column((i0 + i).min(left.end - 1))).0[..vectors]);
                let mut sums = [[simd.splat_f64s(0.0); BLOCK]; BLOCK];
                for k in 0..vectors {
                    let a: [S::f64s; BLOCK] = [from[0][k], from[1][k], from[2][k], from[3][k]];
                    let b: [S::f64s; BLOCK] = [to[0][k], to[1][k], to[2][k], to[3][k]];
                    for j in 0..BLOCK {
                        for i in 0..BLOCK {
                            sums[j][i] = simd.mul_add_e_f64s(a[i], b[j], sums[j][i]);
                        }
                    }
                }
                for (j, sums) in sums.iter().enumerate().take(right.end - j0) {
                    let start = (j0 + j - right.start) * target.rows + i0 - left.start;
                    for (i, &sum) in sums.iter().enumerate().take(left.end - i0) {
                        target.entries[start + i] = simd.reduce_sum_f64s(sum);
                    }
                }
            }
        }
    }
}

/// Cholesky: replaces the lower triangle of a symmetric positive definite matrix by L, L L^T the matrix. `false`: a
/// pivot has lost its digits.
fn factorise(matrix: &mut ColumnMatrix, size: usize) -> bool {
    Arch::new().dispatch(Factorise { matrix, size })
}

struct Factorise<'a> {
    matrix: &'a mut ColumnMatrix,
    size: usize,
}

impl WithSimd for Factorise<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> bool {
        let Self { matrix: ColumnMatrix { rows, entries }, size } = self;
        let rows = *rows;
        let least: Vec<f64> = (0..size).map(|j| LEAST_PIVOT * entries[j * rows + j]).collect();
        for k in 0..size {
            let (column, after) = entries[k * rows..].split_at_mut(rows);
            let pivot = column[k];
            if pivot.is_nan() || pivot <= least[k] {
                return false;
            }
            let inverse = pivot.sqrt().recip();
            for entry in &mut column[k..size] {
                *entry *= inverse;
            }
            for (j, other) in (k + 1..size).zip(after.chunks_exact_mut(rows)) {
                subtract(&mut other[j..size], &column[j..size], column[j]);
            }
        }
        true
    }
}

/// Writes row i of L^-1 as column i of `target`, for all rows.
fn invert(factor: &ColumnMatrix, size: usize, target: &mut ColumnMatrix) {
    Arch::new().dispatch(Invert { factor, size, target });
}

struct Invert<'a> {
    factor: &'a ColumnMatrix,
    size: usize,
    target: &'a mut ColumnMatrix,
}

impl WithSimd for Invert<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { factor, size, target } = self;
        let mut column = vec![0.0; size];
        for i in 0..size {
            column[i..].fill(0.0);
            column[i] = 1.0;
            forward(simd, factor, i, &mut column);
            for (k, &entry) in column.iter().enumerate().skip(i) {
                target.entries[k * target.rows + i] = entry;
            }
        }
    }
}

/// Solves L L^T x = y in place.
fn solve(factor: &ColumnMatrix, right: &mut [f64]) {
    let size = right.len();
    Arch::new().dispatch(Forward { factor, right });
    for i in (0..size).rev() {
        let column = &factor.column(i)[..size];
        let known: f64 = right[i + 1..].iter().zip(&column[i + 1..]).map(|(x, entry)| x * entry).sum();
        right[i] = (right[i] - known) / column[i];
    }
}

struct Forward<'a> {
    factor: &'a ColumnMatrix,
    right: &'a mut [f64],
}

impl WithSimd for Forward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        forward(simd, self.factor, 0, self.right);
    }
}

/// Solves L x = y in place, the first `zeros` entries of y being 0.
#[inline(always)]
fn forward<S: Simd>(_: S, factor: &ColumnMatrix, zeros: usize, right: &mut [f64]) {
    let size = right.len();
    for i in zeros..size {
        let column = &factor.column(i)[..size];
        let value = right[i] / column[i];
        right[i] = value;
        subtract(&mut right[i + 1..], &column[i + 1..], value);
    }
}

#[inline(always)]
fn subtract(target: &mut [f64], column: &[f64], factor: f64) {
    for (entry, other) in target.iter_mut().zip(column) {
        *entry -= other * factor;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_factor_and_its_inverse_are_those_of_the_matrix() {
        for size in [1, 5, 8, 21] {
            let rows = 24;
            let mut columns = ColumnMatrix::zeros(rows, size);
            for (k, entry) in columns.entries.iter_mut().enumerate() {
                *entry = ((k * 7 + 3) % 11) as f64 - 5.0 + if k % rows == k / rows { 9.0 } else { 0.0 };
            }
            let exact = |i: usize, j: usize| -> f64 {
                columns.column(i).iter().zip(columns.column(j)).map(|(a, b)| a * b).sum()
            };
            let mut factor = ColumnMatrix::zeros(rows, size);
            products([&columns, &columns], 0..size, 0..size, &mut factor);
            assert!(factorise(&mut factor, size));
            let mut inverse = ColumnMatrix::zeros(rows, size);
            invert(&factor, size, &mut inverse);
            for i in 0..size {
                for j in 0..=i {
                    let product: f64 = (0..=j).map(|k| factor.column(k)[i] * factor.column(k)[j]).sum();
                    assert!((product - exact(i, j)).abs() < 1e-12 * exact(0, 0), "{size}: {i} {j}");
                    let unit: f64 = (j..=i).map(|k| inverse.column(i)[k] * factor.column(j)[k]).sum();
                    assert!((unit - f64::from(u8::from(i == j))).abs() < 1e-11, "{size}: {i} {j}");
                }
            }
            let mut solution: Vec<f64> = (0..size).map(|i| (0..size).map(|j| exact(i, j) * j as f64).sum()).collect();
            solve(&factor, &mut solution);
            assert!(solution.iter().enumerate().all(|(j, x)| (x - j as f64).abs() < 1e-9), "{solution:?}");
        }
    }

    #[test]
    fn columns_that_depend_on_each_other_are_reported() {
        let mut columns = ColumnMatrix::zeros(8, 3);
        for (k, entry) in columns.entries.iter_mut().enumerate() {
            *entry = if k < 16 { (k % 5) as f64 } else { (k % 5) as f64 + ((k + 2) % 5) as f64 };
        }
        let (first, second) = (columns.column(0).to_vec(), columns.column(1).to_vec());
        for (entry, (a, b)) in columns.entries[16..].iter_mut().zip(first.iter().zip(&second)) {
            *entry = a - 2.0 * b;
        }
        let mut square = ColumnMatrix::zeros(8, 3);
        products([&columns, &columns], 0..3, 0..3, &mut square);
        assert!(!factorise(&mut square, 3));
    }
}
