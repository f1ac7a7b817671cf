//! Symmetric matrices as their lower triangles, real and complex (equal to the transpose, not Hermitian), and the
//! partial elimination of complex ones:
//!
//! ```text
//! [A  B^T]                                   [A - B^T D^-1 B]
//! [B  D  ]   from the last row of D upwards:
//! ```
//!
//! Pivots are not exchanged. Impedances of passive bodies at Re s >= 0 have Re(conj(s) x^H Z x) >= 0, which all their
//! Schur complements inherit, so that pivots vanish at undamped resonances alone.
//!
//! Cost of eliminating from N to K rows: (N^3 - K^3)/6 complex multiplications and additions.

use num_complex::Complex64;
use pulp::{Simd, WithSimd};

use super::lanes::dispatch;

/// Place of the entry of a row and a column, at most the row.
#[inline]
fn place(row: usize, column: usize) -> usize {
    row * (row + 1) / 2 + column
}

/// A real symmetric matrix.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SymmetricMatrix {
    entries: Vec<f64>,
}

impl SymmetricMatrix {
    /// Takes the entries of the lower triangle.
    pub(crate) fn from_fn(size: usize, mut entry: impl FnMut(usize, usize) -> f64) -> Self {
        let mut entries = Vec::with_capacity(place(size, 0));
        for row in 0..size {
            entries.extend((0..=row).map(|column| entry(row, column)));
        }
        Self { entries }
    }
}

/// A complex symmetric matrix, real and imaginary parts apart.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ComplexSymmetricMatrix {
    size: usize,
    real: Vec<f64>,
    imaginary: Vec<f64>,
}

impl ComplexSymmetricMatrix {
    pub(crate) fn zeros(size: usize) -> Self {
        let entries = vec![0.0; place(size, 0)];
        Self { size, real: entries.clone(), imaginary: entries }
    }

    #[inline]
    pub(crate) fn at(&self, row: usize, column: usize) -> Complex64 {
        let place = place(row.max(column), row.min(column));
        Complex64::new(self.real[place], self.imaginary[place])
    }

    /// Adds to an entry and to its mirror image.
    #[inline]
    pub(crate) fn add(&mut self, row: usize, column: usize, value: Complex64) {
        let place = place(row.max(column), row.min(column));
        self.real[place] += value.re;
        self.imaginary[place] += value.im;
    }

    /// Adds a multiple of a real matrix of the same size.
    pub(crate) fn add_scaled(&mut self, factor: Complex64, matrix: &SymmetricMatrix) {
        let entries = self.real.iter_mut().zip(&mut self.imaginary).zip(&matrix.entries);
        for ((real, imaginary), entry) in entries {
            *real += factor.re * entry;
            *imaginary += factor.im * entry;
        }
    }

    /// Adds the first rows and columns of another matrix, those of row i at row `places[i]`.
    pub(crate) fn add_at(&mut self, places: &[usize], other: &Self) {
        for (row, &row_place) in places.iter().enumerate() {
            for (column, &column_place) in places[..=row].iter().enumerate() {
                self.add(row_place, column_place, other.at(row, column));
            }
        }
    }

    /// Eliminates all but the first `kept` rows and columns.
    pub(crate) fn eliminate(&mut self, kept: usize) {
        let Self { size, real, imaginary } = self;
        dispatch(Elimination { size: *size, kept, real, imaginary });
        let entries = place(kept, 0);
        real.truncate(entries);
        imaginary.truncate(entries);
        *size = kept;
    }
}

/// Partial elimination. A type, not a closure, to be compiled for each set of instructions.
struct Elimination<'a> {
    size: usize,
    kept: usize,
    real: &'a mut [f64],
    imaginary: &'a mut [f64],
}

impl WithSimd for Elimination<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { size, kept, real, imaginary } = self;
        for pivot in (kept..size).rev() {
            let (real_above, real_pivot) = real.split_at_mut(place(pivot, 0));
            let (imaginary_above, imaginary_pivot) = imaginary.split_at_mut(place(pivot, 0));
            let inverse = Complex64::new(real_pivot[pivot], imaginary_pivot[pivot]).inv();
            for row in 0..pivot {
                let (re, im) = (real_pivot[row], imaginary_pivot[row]);
                // Rows that the pivot does not touch are many: loads and functionals.
                if re == 0.0 && im == 0.0 {
                    continue;
                }
                let factor = Complex64::new(re, im) * inverse;
                let range = place(row, 0)..place(row + 1, 0);
                let rows = real_above[range.clone()].iter_mut().zip(&mut imaginary_above[range]);
                let pivots = real_pivot[..=row].iter().zip(&imaginary_pivot[..=row]);
                for ((real, imaginary), (&re, &im)) in rows.zip(pivots) {
                    *real -= factor.re * re - factor.im * im;
                    *imaginary -= factor.re * im + factor.im * re;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use faer::Mat;
    use faer::linalg::solvers::{DenseSolveCore, Solve};

    use super::*;

    /// Entries without a pattern, the diagonal large.
    fn entry(row: usize, column: usize) -> Complex64 {
        let (row, column) = (row.max(column) as f64, row.min(column) as f64);
        let value = Complex64::new((3.1 * row + 1.7 * column).sin(), (2.3 * row - 0.9 * column).cos());
        if row.to_bits() == column.to_bits() { value + Complex64::new(9.0, 2.0) } else { value }
    }

    #[test]
    fn elimination_is_the_schur_complement() {
        let (size, kept) = (13, 5);
        let mut matrix = ComplexSymmetricMatrix::zeros(size);
        for row in 0..size {
            (0..=row).for_each(|column| matrix.add(row, column, entry(row, column)));
        }
        matrix.eliminate(kept);
        let rest = Mat::from_fn(size - kept, size - kept, |i, j| entry(kept + i, kept + j));
        let coupling = Mat::from_fn(size - kept, kept, |i, j| entry(kept + i, j));
        let exact =
            Mat::from_fn(kept, kept, entry) - coupling.transpose() * rest.partial_piv_lu().solve(coupling.as_ref());
        for row in 0..kept {
            for column in 0..kept {
                let error = (matrix.at(row, column) - exact[(row, column)]).norm();
                assert!(error < 1e-13, "{row}, {column}: {error:e}");
            }
        }
        // Nothing kept but the first row: the reciprocal of an entry of the inverse.
        matrix.eliminate(1);
        let whole = Mat::from_fn(size, size, entry).partial_piv_lu().inverse();
        assert!((matrix.at(0, 0) * whole[(0, 0)] - 1.0).norm() < 1e-13);
    }

    #[test]
    fn parts_are_added_where_they_belong() {
        let mut sum = ComplexSymmetricMatrix::zeros(3);
        sum.add_scaled(Complex64::new(0.0, 2.0), &SymmetricMatrix::from_fn(3, |row, column| (3 * row + column) as f64));
        let mut part = ComplexSymmetricMatrix::zeros(2);
        part.add(0, 1, Complex64::ONE);
        part.add(1, 1, Complex64::new(5.0, 0.0));
        sum.add_at(&[2, 0], &part);
        assert_eq!(sum.at(0, 2), Complex64::new(1.0, 12.0));
        assert_eq!(sum.at(2, 0), sum.at(0, 2));
        assert_eq!(sum.at(0, 0), Complex64::new(5.0, 0.0));
        assert_eq!(sum.at(2, 1), Complex64::new(0.0, 14.0));
    }
}
