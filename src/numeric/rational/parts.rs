//! Complex numbers as real and imaginary parts, and partial fractions evaluated on them a vector at a time.

use num_complex::Complex64;
use pulp::{Arch, Simd, WithSimd};

use super::PartialFractions;
use super::partial_fractions::is_pair;
use crate::numeric::MOST_LANES;

/// Complex numbers as real and imaginary parts, filled up to whole vectors.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ComplexParts {
    /// Real parts.
    pub re: Vec<f64>,
    /// Imaginary parts.
    pub im: Vec<f64>,
}

impl ComplexParts {
    /// Filled up to whole vectors with the real number `filler`.
    pub(crate) fn new(values: impl Iterator<Item = Complex64>, filler: f64) -> Self {
        let (mut re, mut im): (Vec<f64>, Vec<f64>) = values.map(|value| (value.re, value.im)).unzip();
        let length = re.len().next_multiple_of(MOST_LANES);
        re.resize(length, filler);
        im.resize(length, 0.0);
        Self { re, im }
    }

    pub(crate) fn get(&self, k: usize) -> Complex64 {
        Complex64::new(self.re[k], self.im[k])
    }
}

impl PartialFractions {
    /// Values at many points, equal to [`PartialFractions::evaluate`] to rounding.
    pub(crate) fn evaluate_all(&self, points: &ComplexParts) -> ComplexParts {
        let length = points.re.len();
        let mut values = ComplexParts { re: vec![self.constant; length], im: vec![0.0; length] };
        Arch::new().dispatch(Evaluate { model: self, points, values: &mut values });
        values
    }
}

struct Evaluate<'a> {
    model: &'a PartialFractions,
    points: &'a ComplexParts,
    values: &'a mut ComplexParts,
}

impl WithSimd for Evaluate<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let length = self.points.re.len();
        let (re, im) = (&self.points.re[..length], &self.points.im[..length]);
        let (sum_re, sum_im) = (&mut self.values.re[..length], &mut self.values.im[..length]);
        for (&pole, &residue) in self.model.poles.iter().zip(&self.model.residues) {
            if is_pair(pole) {
                // (2 Re R s - 2 Re(R conj p))/((s - p)(s - conj p)).
                let (slope, rest) = (2.0 * residue.re, 2.0 * (residue.re * pole.re + residue.im * pole.im));
                for k in 0..length {
                    let (a, below, above) = (re[k] - pole.re, im[k] - pole.im, im[k] + pole.im);
                    let (d_re, d_im) = (a * a - below * above, 2.0 * a * im[k]);
                    let (n_re, n_im) = (slope * re[k] - rest, slope * im[k]);
                    let inverse = 1.0 / (d_re * d_re + d_im * d_im);
                    sum_re[k] += (n_re * d_re + n_im * d_im) * inverse;
                    sum_im[k] += (n_im * d_re - n_re * d_im) * inverse;
                }
            } else {
                for k in 0..length {
                    let a = re[k] - pole.re;
                    let inverse = residue.re / (a * a + im[k] * im[k]);
                    sum_re[k] += a * inverse;
                    sum_im[k] -= im[k] * inverse;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_points_at_once_give_what_one_by_one_gives() {
        let model = PartialFractions {
            poles: vec![Complex64::new(-3.0, 40.0), Complex64::new(-1e3, 2e4), (-7.0).into()],
            residues: vec![Complex64::new(2.0, -5.0), Complex64::new(-300.0, 40.0), 1.5.into()],
            constant: 0.25,
        };
        let points: Vec<_> =
            (0..13).map(|k| Complex64::new(f64::from(k % 3) * 11.0, 3f64.powi(k) * 0.1)).chain([5.0.into()]).collect();
        let values = model.evaluate_all(&ComplexParts::new(points.iter().copied(), 1.0));
        for (k, &s) in points.iter().enumerate() {
            let exact = model.evaluate(s);
            assert!((values.get(k) - exact).norm() < 1e-14 * exact.norm(), "{s}: {} {exact}", values.get(k));
        }
    }
}
