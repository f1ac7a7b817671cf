//! A row of equal rectangular cells on the half-space: how the pressure on one cell displaces the others.
//!
//! Cells `length` by `pitch`, side by side along the pitch: the influence matrix G_ij = g_|i-j| is a symmetric Toeplitz
//! matrix of Love's displacements at the cells' middles. Two facts about it are established once per grid, in
//! O(n^2) operations:
//!
//! 1. x = G^-1 e_1 by Levinson's recursion (Golub and Van Loan, Matrix Computations, algorithm 4.7.2 for a general
//!    right-hand side).
//! 2. All entries of B = G^-1 from x alone, diagonal by diagonal (Trench, J. SIAM 12 (1964) 515-522; algorithm 4.7.3):
//!    B_(i+1)(j+1) = B_ij + (x_(i+1) x_(j+1) - x_(n-i) x_(n-j))/x_1.
//! 3. If no entry off the diagonal is positive and no row sum negative, B is a Stieltjes matrix that keeps both
//!    properties under Schur complements. Then G_AA^-1 1 >= 0 for *every* set A of cells in contact: as the body is
//!    pushed in, no pressure ever falls, so no cell ever leaves and the contact set only grows, whatever the profile.

use crate::half_space::love;

/// Influence of the cells of one row on each other, with the properties of its inverse.
#[derive(Clone, Debug)]
pub struct LineInfluence {
    row: Box<[f64]>,
    flat_stiffness: f64,
    only_grows: bool,
}

impl LineInfluence {
    /// `cells` >= 1 cells of `length` (along the row's normal) by `pitch` (along the row), both positive \[m\].
    ///
    /// Displacements are for a pressure of E*: multiply by p/E*.
    pub fn love(cells: usize, length: f64, pitch: f64) -> Self {
        Self::from_row((0..cells).map(|j| love::displacement(0.0, j as f64 * pitch, length, pitch)).collect())
    }

    /// From the displacements g_0, g_1, ... of a cell itself and of its neighbours, which must make a positive
    /// definite matrix.
    pub fn from_row(row: Box<[f64]>) -> Self {
        let first = first_column_of_inverse(&row);
        let (flat_stiffness, only_grows) = inverse_properties(&first);
        Self { row, flat_stiffness, only_grows }
    }

    /// Number of cells in the row.
    pub fn cells(&self) -> usize {
        self.row.len()
    }

    /// g_0, g_1, ..., one per cell \[m per unit of p/E*\].
    pub fn row(&self) -> &[f64] {
        &self.row
    }

    /// Sum of all pressures/E* for a flat body pushed in by 1 m: 1^T G^-1 1 \[1/m\].
    pub fn flat_stiffness(&self) -> f64 {
        self.flat_stiffness
    }

    /// True where the contact set provably only grows with the penetration, for any profile (see the module's step 3).
    pub fn only_grows(&self) -> bool {
        self.only_grows
    }
}

/// Solves G x = e_1 for the symmetric Toeplitz matrix of first row `row`.
fn first_column_of_inverse(row: &[f64]) -> Vec<f64> {
    let n = row.len();
    // Durbin: y solves the Yule-Walker equations of growing order for g_1, g_2, ...; `error` is their residual energy.
    let mut y: Vec<f64> = Vec::with_capacity(n);
    let mut error = row[0];
    for k in 1..n {
        let product: f64 = row[1..k].iter().rev().zip(&y).map(|(g, y)| g * y).sum();
        let reflection = -(row[k] + product) / error;
        for i in 0..(k - 1).div_ceil(2) {
            let mirror = k - 2 - i;
            let (a, b) = (y[i], y[mirror]);
            y[i] = a + reflection * b;
            y[mirror] = b + reflection * a;
        }
        y.push(reflection);
        error *= 1.0 - reflection * reflection;
    }
    // G (1, y) = (error, 0, ..., 0).
    std::iter::once(1.0 / error).chain(y.iter().map(|y| y / error)).collect()
}

/// Sum of all entries of the inverse, and whether it is a Stieltjes matrix with non-negative row sums, to rounding.
fn inverse_properties(first: &[f64]) -> (f64, bool) {
    let n = first.len();
    let mut row_sums = vec![0.0; n];
    let mut largest_off_diagonal = f64::NEG_INFINITY;
    for lag in 0..n {
        let mut entry = first[lag];
        for i in 0..n - lag {
            if i > 0 {
                entry += (first[i] * first[i + lag] - first[n - i] * first[n - i - lag]) / first[0];
            }
            row_sums[i] += entry;
            if lag > 0 {
                row_sums[i + lag] += entry;
                largest_off_diagonal = largest_off_diagonal.max(entry);
            }
        }
    }
    // Each entry carries the rounding of up to n steps.
    let rounding = n as f64 * f64::EPSILON * first[0];
    let least_row_sum = row_sums.iter().copied().fold(f64::INFINITY, f64::min);
    (row_sums.iter().sum(), largest_off_diagonal <= rounding && least_row_sum >= -rounding)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inverse_reproduces_the_flat_body() {
        for cells in [1, 2, 3, 7, 40] {
            let line = LineInfluence::love(cells, 3e-3, 1e-3);
            let first = first_column_of_inverse(line.row());
            for i in 0..cells {
                let product: f64 = (0..cells).map(|j| line.row()[i.abs_diff(j)] * first[j]).sum();
                let expected = if i == 0 { 1.0 } else { 0.0 };
                assert!((product - expected).abs() < 1e-12, "{cells} cells, row {i}: {product}");
            }
        }
    }

    #[test]
    fn contact_only_grows_on_every_grid_of_the_half_space() {
        for cells in [1, 2, 20, 80, 300] {
            for aspect in [1e-3, 0.1, 0.5, 1.0, 2.0, 10.0, 1000.0] {
                assert!(LineInfluence::love(cells, aspect * 1e-3, 1e-3).only_grows(), "{cells} cells, aspect {aspect}");
            }
        }
    }

    #[test]
    fn contact_only_grows_on_very_many_cells() {
        for aspect in [1e-2, 1.0, 100.0] {
            assert!(LineInfluence::love(5000, aspect * 3e-5, 3e-5).only_grows(), "aspect {aspect}");
        }
    }

    #[test]
    fn an_influence_whose_contact_may_shrink_is_not_certified() {
        // Stronger on the neighbour but one than on the neighbour: pressing there unloads the one between.
        assert!(!LineInfluence::from_row([1.0, 0.1, 0.5, 0.0].into()).only_grows());
    }
}
