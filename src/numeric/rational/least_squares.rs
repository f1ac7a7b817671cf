//! Dense real least squares by Householder elimination (faer's blocked QR, one thread).
//!
//! [A | B] is reduced in place: A to R, B to Q^T B. The first rows of Q^T B are the right-hand sides of the triangular
//! system, the others are what A cannot explain: the block that vector fitting needs after the residues have been
//! eliminated.

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::householder::{
    apply_block_householder_sequence_transpose_on_the_left_in_place_scratch,
    apply_block_householder_sequence_transpose_on_the_left_in_place_with_conj,
};
use faer::linalg::qr::no_pivoting::factor::{qr_in_place, qr_in_place_scratch, recommended_block_size};
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Conj, Mat, MatMut, Par};

/// Eliminates the first `columns` columns of a matrix in place: they become R (above the diagonal; below it lie the
/// Householder vectors), the others Q^T times themselves.
pub(crate) fn eliminate(matrix: MatMut<'_, f64>, columns: usize) {
    let rows = matrix.nrows();
    let rest_columns = matrix.ncols() - columns;
    let (mut left, mut right) = matrix.split_at_col_mut(columns);
    let size = rows.min(columns);
    if size == 0 {
        return;
    }
    let block = recommended_block_size::<f64>(rows, columns).min(size);
    let mut factors = Mat::<f64>::zeros(block, size);
    let mut memory = MemBuffer::new(StackReq::any_of(&[
        qr_in_place_scratch::<f64>(rows, columns, block, Par::Seq, Default::default()),
        apply_block_householder_sequence_transpose_on_the_left_in_place_scratch::<f64>(rows, block, rest_columns),
    ]));
    qr_in_place(left.rb_mut(), factors.as_mut(), Par::Seq, MemStack::new(&mut memory), Default::default());
    if rest_columns > 0 {
        apply_block_householder_sequence_transpose_on_the_left_in_place_with_conj(
            left.rb().subcols(0, size),
            factors.as_ref(),
            Conj::No,
            right.rb_mut(),
            Par::Seq,
            MemStack::new(&mut memory),
        );
    }
}

/// Solves R x = y by back substitution with the upper triangle of the leading square block of an eliminated matrix, y
/// its column `column`. A zero on the diagonal (a column that depends on those before it) gives a zero unknown.
pub(crate) fn back_substitute(matrix: &Mat<f64>, columns: usize, column: usize, solution: &mut [f64]) {
    let largest = (0..columns).fold(0.0_f64, |a, j| a.max(matrix[(j, j)].abs()));
    for (i, entry) in solution.iter_mut().enumerate() {
        *entry = matrix[(i, column)];
    }
    for j in (0..columns).rev() {
        let pivot = matrix[(j, j)];
        solution[j] = if pivot.abs() > 1e-15 * largest { solution[j] / pivot } else { 0.0 };
        let value = solution[j];
        for (i, entry) in solution[..j].iter_mut().enumerate() {
            *entry -= matrix[(i, j)] * value;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn least_squares_residual_is_orthogonal_to_the_columns() {
        let entry = |i: usize, j: usize| ((i * 7 + j * 13 + 5) % 11) as f64 - 4.0 + if i == j { 6.0 } else { 0.0 };
        let (rows, columns) = (9, 4);
        let mut matrix = Mat::from_fn(rows, columns + 1, entry);
        eliminate(matrix.as_mut(), columns);
        let mut solution = [0.0; 4];
        back_substitute(&matrix, columns, columns, &mut solution);
        for j in 0..columns {
            let product: f64 = (0..rows)
                .map(|i| {
                    let residual = (0..columns).map(|c| entry(i, c) * solution[c]).sum::<f64>() - entry(i, columns);
                    residual * entry(i, j)
                })
                .sum();
            assert!(product.abs() < 1e-11, "{product}");
        }
    }
}
