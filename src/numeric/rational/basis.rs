//! The real basis functions of given poles at many points, as columns side by side.
//!
//! A pair has 1/(s - p) + 1/(s - conj p) = 2 (s - Re p)/d and i/(s - p) - i/(s - conj p) = -2 Im p/d with
//! d = (s - p)(s - conj p), a real pole 1/(s - p); each scaled by |Re p|, its size on the axis. A column holds the real
//! parts at all points, then the imaginary parts; both halves are filled up with zeros to whole vectors.

use num_complex::Complex64;
use pulp::{Arch, Simd, WithSimd};

use super::ComplexParts;
use super::partial_fractions::{is_pair, order};

/// Columns of equal length, one after the other.
#[derive(Clone, Debug, Default)]
pub(super) struct ColumnMatrix {
    /// Length of a column.
    pub rows: usize,
    /// Entries, column by column.
    pub entries: Vec<f64>,
}

impl ColumnMatrix {
    pub(super) fn zeros(rows: usize, columns: usize) -> Self {
        Self { rows, entries: vec![0.0; rows * columns] }
    }

    pub(super) fn column(&self, column: usize) -> &[f64] {
        &self.entries[column * self.rows..(column + 1) * self.rows]
    }
}

/// Points with weights, padded to whole vectors.
#[derive(Clone, Debug)]
pub(super) struct Points {
    /// s_k; 1 where filled up.
    at: ComplexParts,
    /// Weights; 0 where filled up.
    weights: Vec<f64>,
}

impl Points {
    pub(super) fn new(points: &[Complex64], weights: &[f64]) -> Self {
        let at = ComplexParts::new(points.iter().copied(), 1.0);
        let mut weights = weights.to_vec();
        weights.resize(at.re.len(), 0.0);
        Self { at, weights }
    }

    /// Length of a column.
    pub(super) fn rows(&self) -> usize {
        2 * self.weights.len()
    }

    /// Writes the weighted basis functions of `poles`, and the weights themselves as the last column if
    /// `with_constant`, to the front of `columns`.
    pub(super) fn fill(&self, poles: &[Complex64], with_constant: bool, columns: &mut [f64]) {
        Arch::new().dispatch(Fill { points: self, poles, columns });
        if with_constant {
            let start = order(poles) * self.rows();
            columns[start..start + self.weights.len()].copy_from_slice(&self.weights);
        }
    }

    /// Writes the basis functions (`left`, as [`Points::fill`] writes them) times `scale` and a response, and the
    /// weighted response itself as the last column.
    pub(super) fn multiply(&self, left: &[f64], response: &ComplexParts, scale: f64, columns: &mut [f64]) {
        Arch::new().dispatch(Multiply { points: self, left, response, scale, columns });
    }
}

struct Fill<'a> {
    points: &'a Points,
    poles: &'a [Complex64],
    columns: &'a mut [f64],
}

impl WithSimd for Fill<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Points { at, weights } = self.points;
        let half = weights.len();
        let (re, im, weights) = (&at.re[..half], &at.im[..half], &weights[..half]);
        let mut rest = self.columns;
        for &pole in self.poles {
            let (first, others) = rest.split_at_mut(2 * half);
            let (first_re, first_im) = first.split_at_mut(half);
            rest = others;
            if is_pair(pole) {
                let (second, others) = rest.split_at_mut(2 * half);
                let (second_re, second_im) = second.split_at_mut(half);
                rest = others;
                for k in 0..half {
                    let (a, below, above) = (re[k] - pole.re, im[k] - pole.im, im[k] + pole.im);
                    let (d_re, d_im) = (a * a - below * above, 2.0 * a * im[k]);
                    let scale = -2.0 * pole.re * weights[k] / (d_re * d_re + d_im * d_im);
                    first_re[k] = (a * d_re + im[k] * d_im) * scale;
                    first_im[k] = (im[k] * d_re - a * d_im) * scale;
                    second_re[k] = -pole.im * d_re * scale;
                    second_im[k] = pole.im * d_im * scale;
                }
            } else {
                for k in 0..half {
                    let a = re[k] - pole.re;
                    let scale = -pole.re * weights[k] / (a * a + im[k] * im[k]);
                    first_re[k] = a * scale;
                    first_im[k] = -im[k] * scale;
                }
            }
        }
    }
}

struct Multiply<'a> {
    points: &'a Points,
    left: &'a [f64],
    response: &'a ComplexParts,
    scale: f64,
    columns: &'a mut [f64],
}

impl WithSimd for Multiply<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let half = self.points.weights.len();
        let (re, im, scale) = (&self.response.re[..half], &self.response.im[..half], self.scale);
        let (products, last) = self.columns.split_at_mut(self.left.len());
        for (from, to) in self.left.chunks_exact(2 * half).zip(products.chunks_exact_mut(2 * half)) {
            let (from_re, from_im) = from.split_at(half);
            let (to_re, to_im) = to.split_at_mut(half);
            let (from_im, to_im) = (&from_im[..half], &mut to_im[..half]);
            for k in 0..half {
                to_re[k] = scale * (from_re[k] * re[k] - from_im[k] * im[k]);
                to_im[k] = scale * (from_re[k] * im[k] + from_im[k] * re[k]);
            }
        }
        let (to_re, to_im) = last[..2 * half].split_at_mut(half);
        for k in 0..half {
            let weight = scale * self.points.weights[k];
            to_re[k] = weight * re[k];
            to_im[k] = weight * im[k];
        }
    }
}
