//! Adaptive Antoulas-Anderson approximation of a function with conjugate symmetry (Nakatsukasa, Sète & Trefethen 2018,
//! *SIAM J. Sci. Comput.* 40, A1494).
//!
//! r(s) = N(s)/D(s), N = sum w_j f_j/(s - z_j), D = sum w_j/(s - z_j), interpolates f at the support points z_j
//! whatever the weights. Support points come in conjugate pairs with conjugate weights, so that the unknowns, the
//! Loewner matrix (a real and an imaginary row for each sample) and the polynomials are real:
//!
//! 1. the sample where |f - r| is largest becomes a support point, with its conjugate;
//! 2. the weights are the right singular vector of the smallest singular value of the Loewner matrix over the other
//!    samples;
//! 3. until the largest error is below the tolerance.
//!
//! Poles are the zeros of D: of (s + a) D(s) = d + c (s - A)^-1 b, as in vector fitting, less the root -a that was put
//! in. Cost O(M m^3) for m points: for a start, not for every function.

use faer::Mat;
use num_complex::Complex64;

use super::RationalError;
use super::least_squares::eliminate;

/// A barycentric interpolant. Support points and what belongs to them are stored for Im z >= 0 only.
#[derive(Clone, Debug, Default)]
pub(crate) struct Barycentric {
    /// Support points z_j.
    pub points: Vec<Complex64>,
    /// f(z_j).
    pub values: Vec<Complex64>,
    /// w_j; the conjugate point has the conjugate weight.
    pub weights: Vec<Complex64>,
    /// Largest error on the samples, absolute.
    pub error: f64,
}

impl Barycentric {
    /// r(s); f(s) itself at a support point.
    pub(crate) fn evaluate(&self, s: Complex64) -> Complex64 {
        let (mut numerator, mut denominator) = (Complex64::ZERO, Complex64::ZERO);
        for ((&z, &f), &w) in self.points.iter().zip(&self.values).zip(&self.weights) {
            if s == z {
                return f;
            }
            let near = w / (s - z);
            numerator += near * f;
            denominator += near;
            if z.im > 0.0 {
                if s == z.conj() {
                    return f.conj();
                }
                let far = w.conj() / (s - z.conj());
                numerator += far * f.conj();
                denominator += far;
            }
        }
        numerator / denominator
    }

    /// All poles, conjugates included, stable or not.
    pub(crate) fn poles(&self) -> Result<Vec<Complex64>, RationalError> {
        let count: usize = self.points.iter().map(|z| if z.im > 0.0 { 2 } else { 1 }).sum();
        // -a, the root that is put in: real, and away from every root that matters.
        let shift = 7.3 * self.points.iter().fold(0.0_f64, |a, z| a.max(z.norm()));
        let mut matrix = Mat::<f64>::zeros(count, count);
        let (mut b, mut c) = (vec![0.0; count], vec![0.0; count]);
        let (mut d, mut index) = (0.0, 0);
        // 1. A, b, c (A + a) and d in real form: a pair of support points takes two rows.
        for (z, w) in self.points.iter().zip(&self.weights) {
            if z.im > 0.0 {
                matrix[(index, index + 1)] = z.im;
                matrix[(index + 1, index)] = -z.im;
                b[index] = 2.0;
                d += 2.0 * w.re;
                // c (A + a) with c = (Re w, Im w).
                c[index] = shift * w.re - z.im * w.im;
                c[index + 1] = shift * w.im + z.im * w.re;
                index += 2;
            } else {
                matrix[(index, index)] = z.re;
                b[index] = 1.0;
                d += w.re;
                c[index] = (shift + z.re) * w.re;
                index += 1;
            }
        }
        // 2. The roots are the eigenvalues of A - b c^T/d; d = 0 would be a root at infinity.
        let largest = c.iter().fold(0.0_f64, |a, &b| a.max(b.abs()));
        let d = if d.abs() > 1e-14 * largest { d } else { 1e-14 * largest };
        for j in 0..count {
            for i in 0..count {
                matrix[(i, j)] -= b[i] * c[j] / d;
            }
        }
        if (0..count).any(|j| !matrix[(0, j)].is_finite()) {
            return Err(RationalError::NotFinite { stage: "AAA" });
        }
        let mut roots = matrix.eigenvalues().map_err(|_| RationalError::NoConvergence { stage: "AAA" })?;
        // 3. The root put in is removed.
        let foreign = (0..roots.len()).min_by(|&i, &j| (roots[i] + shift).norm().total_cmp(&(roots[j] + shift).norm()));
        if let Some(foreign) = foreign {
            roots.swap_remove(foreign);
        }
        Ok(roots)
    }
}

/// Approximates `values` at `points` (Im >= 0) until the largest error is below `tolerance` times the largest value,
/// or `most` support points are used, or `patience` of them have not halved the error: it is then that of the values.
pub(crate) fn approximate(
    points: &[Complex64],
    values: &[Complex64],
    tolerance: f64,
    [most, patience]: [usize; 2],
) -> Result<Barycentric, RationalError> {
    if values.iter().any(|value| !value.is_finite()) {
        return Err(RationalError::NotFinite { stage: "AAA" });
    }
    let scale = values.iter().fold(0.0_f64, |a, value| a.max(value.norm()));
    let mean = values.iter().sum::<Complex64>().re / values.len().max(1) as f64;
    let mut current: Vec<Complex64> = vec![Complex64::new(mean, 0.0); values.len()];
    let mut taken = vec![false; values.len()];
    let mut model = Barycentric::default();
    let (mut halved, mut halved_at) = (f64::INFINITY, 0);
    loop {
        // 1. The worst sample that is no support point yet; its error is that of the model.
        let worst = (0..values.len()).filter(|&k| !taken[k]).map(|k| (k, (values[k] - current[k]).norm())).fold(
            None,
            |best: Option<(usize, f64)>, next| match best {
                Some(best) if best.1 >= next.1 => Some(best),
                _ => Some(next),
            },
        );
        let Some((worst, error)) = worst else { break };
        model.error = error;
        let count = model.points.len();
        if error < 0.5 * halved {
            (halved, halved_at) = (error, count);
        }
        if (error <= tolerance * scale && count > 0) || count == most || count - halved_at >= patience {
            break;
        }
        // 2. It becomes a support point.
        taken[worst] = true;
        model.points.push(points[worst]);
        model.values.push(values[worst]);
        let columns: usize = model.points.iter().map(|z| if z.im > 0.0 { 2 } else { 1 }).sum();
        let rest: Vec<usize> = (0..values.len()).filter(|&k| !taken[k]).collect();
        if 2 * rest.len() < columns {
            return Err(RationalError::TooFewSamples { samples: values.len(), unknowns: columns });
        }
        // 3. New weights, and the model at the samples left.
        model.weights = weights(&model, points, values, &rest, columns)?;
        for &k in &rest {
            current[k] = model.evaluate(points[k]);
        }
    }
    Ok(model)
}

/// Weights of least Loewner residual, of norm 1, by QR and the SVD of R; `rest` are the samples that are no support
/// points.
fn weights(
    model: &Barycentric,
    points: &[Complex64],
    values: &[Complex64],
    rest: &[usize],
    columns: usize,
) -> Result<Vec<Complex64>, RationalError> {
    let rows = rest.len();
    let mut loewner = Mat::<f64>::zeros(2 * rows, columns);
    for (row, &k) in rest.iter().enumerate() {
        let (s, value) = (points[k], values[k]);
        let mut index = 0;
        let mut put = |index: usize, entry: Complex64| {
            loewner[(row, index)] = entry.re;
            loewner[(rows + row, index)] = entry.im;
        };
        for (&z, &f) in model.points.iter().zip(&model.values) {
            let near = (value - f) / (s - z);
            if z.im > 0.0 {
                let far = (value - f.conj()) / (s - z.conj());
                put(index, near + far);
                put(index + 1, Complex64::i() * (near - far));
                index += 2;
            } else {
                put(index, near);
                index += 1;
            }
        }
    }
    eliminate(loewner.as_mut(), columns);
    let triangle = Mat::<f64>::from_fn(columns, columns, |i, j| if i <= j { loewner[(i, j)] } else { 0.0 });
    let svd = triangle.svd().map_err(|_| RationalError::NoConvergence { stage: "AAA" })?;
    let vector = svd.V().col(columns - 1);
    let mut index = 0;
    Ok(model
        .points
        .iter()
        .map(|z| {
            if z.im > 0.0 {
                index += 2;
                Complex64::new(vector[index - 2], vector[index - 1])
            } else {
                index += 1;
                Complex64::new(vector[index - 1], 0.0)
            }
        })
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(count: usize, lowest: f64, highest: f64) -> Vec<Complex64> {
        (0..count)
            .map(|k| Complex64::new(0.0, lowest * (highest / lowest).powf(k as f64 / (count - 1) as f64)))
            .collect()
    }

    #[test]
    fn a_rational_function_is_reproduced_with_its_poles() {
        let f = |s: Complex64| (s * 3.0 + 1.0) / (s * s + s * 0.2 + 25.0) + 2.0 / (s + 4.0);
        let points = axis(60, 0.01, 100.0);
        let values: Vec<_> = points.iter().map(|&s| f(s)).collect();
        let model = approximate(&points, &values, 1e-12, [20; 2]).unwrap();
        for s in [Complex64::new(3.0, 0.0), Complex64::new(0.1, 4.7), Complex64::new(0.0, 33.3)] {
            assert!((model.evaluate(s) - f(s)).norm() < 1e-11 * f(s).norm());
        }
        for pole in [Complex64::new(-0.1, 24.99_f64.sqrt()), Complex64::new(-4.0, 0.0)] {
            let nearest =
                model.poles().unwrap().iter().map(|found| (found - pole).norm()).fold(f64::INFINITY, f64::min);
            assert!(nearest < 1e-8, "{pole}: {nearest}");
        }
    }

    #[test]
    fn a_branch_point_with_a_delay_converges_root_exponentially() {
        // sqrt type singularity at -1, with a smooth factor: error about exp(-pi sqrt(2 m/2)) for m poles.
        let f = |s: Complex64| (s + 1.0).powf(-0.4) * (-(s * 0.01)).exp();
        let points = axis(300, 1e-3, 200.0);
        let values: Vec<_> = points.iter().map(|&s| f(s)).collect();
        let mut last = f64::INFINITY;
        for (tolerance, most) in [(1e-3, 5), (1e-6, 9), (1e-9, 14)] {
            let model = approximate(&points, &values, tolerance, [30; 2]).unwrap();
            assert!(model.points.len() <= most, "{} pairs for {tolerance}", model.points.len());
            let fresh = axis(777, 1.3e-3, 180.0);
            let error = fresh.iter().map(|&s| (model.evaluate(s) - f(s)).norm()).fold(0.0, f64::max);
            assert!(error < 5.0 * tolerance && error < last, "{error}");
            last = error;
        }
    }
}
