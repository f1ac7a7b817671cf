//! L D L^T of small symmetric matrices in memory that is taken once.
//!
//! Few points are factorised two columns at a time, taken off all that follow; many by faer's blocks. Measured (bench
//! `linear_solvers`, assembly and solution included) the former takes 0.35 to 0.42 of the time of the latter for 16 to
//! 192 points, 0.5 for 256 and 0.8 for 512, with residuals alike. Both leave L below the diagonal and D on it.

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::ldlt::factor::LdltRegularization;
use faer::linalg::cholesky::ldlt::{factor, solve};
use faer::{MatMut, MatRef, Par};
use pulp::{Arch, Simd, WithSimd};

use crate::numeric::windows::add_row;

/// Numbers to a cache line: columns of factors begin on one.
pub const LINE: usize = 8;
/// Points from which faer's blocks are the faster way.
const MANY: usize = 512;

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

/// G0 of some points, given by increasing column numbers, from G0 by distance: the lower triangle, which says it all.
/// Neighbours are copied together.
pub fn lower_triangle(points: &[usize], influence: &[f64], matrix: &mut [f64], stride: usize) {
    for (row, (column, &j)) in matrix.chunks_exact_mut(stride).zip(points).enumerate() {
        let mut open = &mut column[row..points.len()];
        for run in points[row..].chunk_by(|one, next| one + 1 == *next) {
            let (values, rest) = open.split_at_mut(run.len());
            values.copy_from_slice(&influence[run[0] - j..][..run.len()]);
            open = rest;
        }
    }
}

/// Factorises and solves; columns of matrices and right sides stand `stride` apart.
pub struct Ldlt {
    arch: Arch,
    many: usize,
    scratch: MemBuffer,
}

impl Ldlt {
    /// For up to so many points and right sides.
    pub fn new(points: usize, right_sides: usize) -> Self {
        Self::switching(points, right_sides, MANY)
    }

    /// As [`Self::new`], faer's blocks from `many` points on.
    pub fn switching(points: usize, right_sides: usize, many: usize) -> Self {
        let of = |points| {
            let solution = solve::solve_in_place_scratch::<f64>(points, right_sides, Par::Seq);
            factor::cholesky_in_place_scratch::<f64>(points, Par::Seq, Default::default()).or(solution)
        };
        let scratch = (many..=points).map(of).fold(StackReq::EMPTY, StackReq::or);
        Self { arch: Arch::new(), many, scratch: MemBuffer::new(scratch) }
    }

    /// L and D in place, from the lower triangle; numbers above it may be lost.
    ///
    /// # Errors
    /// [`Singular`].
    pub fn factorise(&mut self, matrix: &mut [f64], stride: usize, rows: usize) -> Result<(), Singular> {
        if rows < self.many {
            return self.arch.dispatch(ByColumns { matrix, stride, rows });
        }
        let matrix = MatMut::from_column_major_slice_with_stride_mut(matrix, rows, rows, stride);
        let (plain, stack) = (LdltRegularization::default(), MemStack::new(&mut self.scratch));
        factor::cholesky_in_place(matrix, plain, Par::Seq, stack, Default::default()).map(drop).map_err(|_| Singular)
    }

    /// Solves in place with such factors.
    ///
    /// # Errors
    /// [`Singular`] unless all results are finite.
    pub fn solve(
        &mut self,
        factor: &[f64],
        right: &mut [f64],
        stride: usize,
        rows: usize,
        columns: usize,
    ) -> Result<(), Singular> {
        if rows < self.many {
            for right in right.chunks_mut(stride.max(1)).take(columns) {
                self.arch.dispatch(Substitutions { factor, stride, right: &mut right[..rows] });
            }
        } else {
            let factor = MatRef::from_column_major_slice_with_stride(factor, rows, rows, stride);
            let right = MatMut::from_column_major_slice_with_stride_mut(&mut *right, rows, columns, stride);
            solve::solve_in_place(factor, factor.diagonal(), right, Par::Seq, MemStack::new(&mut self.scratch));
        }
        finite(right.chunks(stride.max(1)).take(columns).flat_map(|right| &right[..rows]))
    }
}

/// Columns of L two by two: once both are done, they are taken off all that follow.
struct ByColumns<'a> {
    matrix: &'a mut [f64],
    stride: usize,
    rows: usize,
}

impl WithSimd for ByColumns<'_> {
    type Output = Result<(), Singular>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let Self { matrix, stride, rows } = self;
        // Whole vectors where the stride leaves room for them.
        let last = rows.next_multiple_of(LINE).min(stride);
        for j in (0..rows).step_by(2) {
            let (column, after) = matrix[j * stride..].split_at_mut(stride);
            let pivot = over_pivot(&mut column[j..rows])?;
            if j + 1 == rows {
                break;
            }
            let (next, after) = after.split_at_mut(stride);
            add_row(simd, &mut next[j + 1..rows], &column[j + 1..rows], -column[j + 1] * pivot);
            let pivots = [pivot, over_pivot(&mut next[j + 1..rows])?];
            for (i, open) in (j + 2..rows).zip(after.chunks_mut(stride)) {
                let rows = i / LINE * LINE..last;
                let factors = [-column[i] * pivots[0], -next[i] * pivots[1]];
                add_two(simd, &mut open[rows.clone()], [&column[rows.clone()], &next[rows]], factors);
            }
        }
        Ok(())
    }
}

/// Adds to a row two others of its length, each times a factor.
#[inline(always)]
fn add_two<S: Simd>(simd: S, out: &mut [f64], [one, other]: [&[f64]; 2], factors: [f64; 2]) {
    let wide = factors.map(|factor| simd.splat_f64s(factor));
    let (out, out_rest) = S::as_mut_simd_f64s(out);
    let ((one, one_rest), (other, other_rest)) = (S::as_simd_f64s(one), S::as_simd_f64s(other));
    for ((out, &one), &other) in out.iter_mut().zip(one).zip(other) {
        *out = simd.mul_add_e_f64s(wide[1], other, simd.mul_add_e_f64s(wide[0], one, *out));
    }
    for ((out, one), other) in out_rest.iter_mut().zip(one_rest).zip(other_rest) {
        *out = factors[1].mul_add(*other, factors[0].mul_add(*one, *out));
    }
}

/// Divides what stands under a pivot by it; returns the pivot.
#[inline(always)]
fn over_pivot(column: &mut [f64]) -> Result<f64, Singular> {
    match column.split_first_mut() {
        Some((&mut pivot, below)) if pivot != 0.0 && pivot.is_finite() => {
            let scale = pivot.recip();
            below.iter_mut().for_each(|value| *value *= scale);
            Ok(pivot)
        }
        _ => Err(Singular),
    }
}

/// Forwards, over D, backwards.
struct Substitutions<'a> {
    factor: &'a [f64],
    stride: usize,
    right: &'a mut [f64],
}

impl WithSimd for Substitutions<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { factor, stride, right } = self;
        let rows = right.len();
        for k in 0..rows {
            let (solved, open) = right.split_at_mut(k + 1);
            add_row(simd, open, &factor[k * stride + k + 1..], -solved[k]);
        }
        for k in (0..rows).rev() {
            let (open, solved) = right.split_at_mut(k + 1);
            let column = &factor[k * stride + k..k * stride + rows];
            open[k] = open[k] / column[0] - dot(simd, &column[1..], solved);
        }
    }
}

/// The sum of products of two rows of one length.
#[inline(always)]
fn dot<S: Simd>(simd: S, one: &[f64], other: &[f64]) -> f64 {
    let (one, one_rest) = S::as_simd_f64s(one);
    let (other, other_rest) = S::as_simd_f64s(other);
    let wide = one.iter().zip(other).fold(simd.splat_f64s(0.0), |sum, (&a, &b)| simd.mul_add_e_f64s(a, b, sum));
    one_rest.iter().zip(other_rest).fold(simd.reduce_sum_f64s(wide), |sum, (a, b)| a.mul_add(*b, sum))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A positive definite matrix with a spring on its diagonal, the solution 1, 2, 3, ..., and what both give.
    fn system(rows: usize, stride: usize) -> (Vec<f64>, Vec<f64>) {
        let entry = |i: usize, j: usize| {
            (-(i.abs_diff(j) as f64) / 3.0).exp() + if i == j { 0.1 * (1 + i % 5) as f64 } else { 0.0 }
        };
        let matrix =
            (0..rows * stride).map(|at| if at % stride < rows { entry(at / stride, at % stride) } else { 7.0 });
        let right = (0..rows).map(|i| (0..rows).map(|j| entry(i, j) * (j + 1) as f64).sum()).collect();
        (matrix.collect(), right)
    }

    #[test]
    fn both_ways_leave_the_same_factors_and_solve() {
        for rows in [1_usize, 2, 7, 8, 9, 31, 33, 64, 100] {
            for stride in [rows, rows.next_multiple_of(LINE)] {
                let (matrix, right) = system(rows, stride);
                let mut factors = [matrix.clone(), matrix];
                for (factor, many) in factors.iter_mut().zip([usize::MAX, 0]) {
                    let mut solver = Ldlt::switching(rows, 2, many);
                    solver.factorise(factor, stride, rows).unwrap();
                    let mut both = vec![0.0; 2 * stride];
                    both[..rows].copy_from_slice(&right);
                    both[stride..stride + rows].iter_mut().zip(&right).for_each(|(to, from)| *to = -2.0 * from);
                    solver.solve(factor, &mut both, stride, rows, 2).unwrap();
                    for (i, value) in both[..rows].iter().enumerate() {
                        assert!((value - (i + 1) as f64).abs() < 1e-11, "{rows}, {stride}, {many}: {value}");
                        assert!((both[stride + i] + 2.0 * (i + 1) as f64).abs() < 1e-11, "{rows}, {stride}, {many}");
                    }
                }
                let lower = (0..rows).flat_map(|j| j * stride + j..j * stride + rows);
                for at in lower {
                    assert!((factors[0][at] - factors[1][at]).abs() < 1e-13, "{rows}, {stride}: {at}");
                }
            }
        }
    }

    #[test]
    fn a_singular_matrix_is_named() {
        for many in [usize::MAX, 0] {
            let mut matrix = [1.0, 1.0, 1.0, 1.0];
            assert_eq!(Ldlt::switching(2, 1, many).factorise(&mut matrix, 2, 2), Err(Singular));
        }
    }
}
