//! Vector fitting: moves given poles to where the data want them.
//!
//! Relaxed form with common poles for several responses (Gustavsen & Semlyen 1999, *IEEE Trans. Power Deliv.* 14, 1052;
//! Gustavsen 2006, 21, 1587; elimination of the residues by QR: Deschrijver et al. 2008, *IEEE Microw. Wirel. Compon.
//! Lett.* 18, 383):
//!
//! 1. sigma(s) = d + sum c_r phi_r(s), and sigma H_q = constant_q + sum c_qr phi_r(s) for each response q, are both
//!    linear in the unknowns;
//! 2. the columns of c_qr are the same for all responses (weights are one number per response and one per point):
//!    eliminated once by Householder reflections or, where poles need less accuracy, by normal equations
//!    ([`Elimination`]); the residual block of -H_q (phi_r, 1) determines (c, d), with one more row: the mean of Re
//!    sigma over the samples is 1;
//! 3. the zeros of sigma, eigenvalues of A - b c^T/d, are the new poles; unstable ones are mirrored.
//!
//! Everything is real: a pair has the basis functions 1/(s - p) + 1/(s - conj p) and i/(s - p) - i/(s - conj p), each
//! sample gives a real and an imaginary row. Basis functions are scaled by |Re p|, their size on the axis.
//!
//! Cost: with M samples, P poles and Q responses 2 M P^2 (1 + 2 Q) flops for the elimination, 25 P^3 for the
//! eigenvalues.

use faer::Mat;
use num_complex::Complex64;

use super::basis::{ColumnMatrix, Points};
use super::least_squares::{back_substitute, eliminate};
use super::partial_fractions::{fold_conjugates, is_pair, order, sort, stabilise};
use super::{PartialFractions, RationalError, Samples, normal_equations, secular};

/// Calls `column(index, value)` for every real basis function at s, scaled by |Re p|.
fn basis(poles: &[Complex64], s: Complex64, mut column: impl FnMut(usize, Complex64)) {
    let mut index = 0;
    for &pole in poles {
        let scale = -pole.re;
        if is_pair(pole) {
            let (near, far) = ((s - pole).inv() * scale, (s - pole.conj()).inv() * scale);
            column(index, near + far);
            column(index + 1, Complex64::i() * (near - far));
            index += 2;
        } else {
            column(index, (s - pole).inv() * scale);
            index += 1;
        }
    }
}

/// How a relocation eliminates the residues.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Elimination {
    /// Householder reflections: the reference.
    Reflections,
    /// Normal equations with a ridge (see `normal_equations`), reflections where those have lost their digits: some
    /// four times faster, for residuals down to 1e-6.
    Products,
}

/// One relocation: poles that fit the samples better than `poles`. `with_constant`: whether the responses have one.
pub(crate) fn relocate(
    samples: &Samples,
    poles: &[Complex64],
    with_constant: bool,
    elimination: Elimination,
) -> Result<Vec<Complex64>, RationalError> {
    let count = order(poles);
    let left = count + usize::from(with_constant);
    let right = count + 1;
    samples.check(left + right, "vector fitting")?;
    if elimination == Elimination::Products
        && let Some(sigma) = normal_equations::sigma(samples, poles, with_constant)
    {
        return zeros(poles, &sigma);
    }
    let (points, responses) = (samples.points.len(), samples.responses.len());
    // 1. Columns of the residues and constants (common to all responses), then those of (c, d) for each response.
    let rows = 2 * points;
    let mut matrix = Mat::<f64>::zeros(rows, left + right * responses);
    let mut sums = vec![0.0; right];
    for (k, &s) in samples.points.iter().enumerate() {
        let point = samples.point_weights[k];
        basis(poles, s, |index, value| {
            let weighted = value * point;
            matrix[(k, index)] = weighted.re;
            matrix[(points + k, index)] = weighted.im;
            sums[index] += value.re;
            for (q, response) in samples.responses.iter().enumerate() {
                let product = response[k] * weighted * -samples.weights[q];
                matrix[(k, left + q * right + index)] = product.re;
                matrix[(points + k, left + q * right + index)] = product.im;
            }
        });
        if with_constant {
            matrix[(k, count)] = point;
        }
        sums[count] += 1.0;
        for (q, response) in samples.responses.iter().enumerate() {
            let value = response[k] * (-samples.weights[q] * point);
            matrix[(k, left + q * right + count)] = value.re;
            matrix[(points + k, left + q * right + count)] = value.im;
        }
    }
    // 2. Elimination of the residues; the rows below R determine (c, d).
    eliminate(matrix.as_mut(), left);

    let remaining = rows - left;
    let mut reduced = Mat::<f64>::zeros(remaining * responses + 1, right + 1);
    for q in 0..responses {
        for j in 0..right {
            for i in 0..remaining {
                reduced[(q * remaining + i, j)] = matrix[(left + i, left + q * right + j)];
            }
        }
    }
    // 3. The row that forbids sigma = 0: mean of Re sigma = 1, as heavy as all samples of a response of size 1
    // together.
    let heavy = (responses as f64 / points as f64).sqrt();
    for (j, sum) in sums.iter().enumerate() {
        reduced[(remaining * responses, j)] = sum * heavy;
    }
    reduced[(remaining * responses, right)] = points as f64 * heavy;
    eliminate(reduced.as_mut(), right);
    let mut sigma = vec![0.0; right];
    back_substitute(&reduced, right, right, &mut sigma);
    // 4. The new poles.
    zeros(poles, &sigma)
}

/// Zeros of sigma = d + sum c_r phi_r, mirrored into the left half plane. `sigma` holds the c_r (scaled basis), then
/// d.
fn zeros(poles: &[Complex64], sigma: &[f64]) -> Result<Vec<Complex64>, RationalError> {
    let count = sigma.len() - 1;
    let largest = sigma[..count].iter().fold(0.0_f64, |a, &b| a.max(b.abs()));
    // d -> 0 sends a pole to infinity; keep it finite.
    let d = if sigma[count].abs() > 1e-8 * largest.max(1e-300) { sigma[count] } else { 1e-8 * largest.max(1e-300) };
    let mut index = 0;
    let shares: Vec<Complex64> = poles
        .iter()
        .map(|pole| {
            let scale = -pole.re / d;
            let share =
                if is_pair(*pole) { Complex64::new(sigma[index], sigma[index + 1]) } else { sigma[index].into() };
            index += if is_pair(*pole) { 2 } else { 1 };
            share * scale
        })
        .collect();
    // Iteration from the poles; the eigenvalues of A - b c^T where it does not converge.
    if let Some(mut moved) = secular::zeros(poles, &shares) {
        sort(&mut moved);
        stabilise(&mut moved);
        return Ok(moved);
    }
    let mut matrix = Mat::<f64>::zeros(count, count);
    let (mut b, mut c) = (vec![0.0; count], vec![0.0; count]);
    let mut index = 0;
    for (&pole, &share) in poles.iter().zip(&shares) {
        // A similarity that makes b and c of one pole equally large.
        let size = share.norm();
        let balance = if size > 0.0 { size.sqrt() } else { 1.0 };
        if is_pair(pole) {
            matrix[(index, index)] = pole.re;
            matrix[(index, index + 1)] = pole.im;
            matrix[(index + 1, index)] = -pole.im;
            matrix[(index + 1, index + 1)] = pole.re;
            let balance = balance * std::f64::consts::FRAC_1_SQRT_2;
            b[index] = 2.0 * balance;
            c[index] = share.re / balance;
            c[index + 1] = share.im / balance;
            index += 2;
        } else {
            matrix[(index, index)] = pole.re;
            b[index] = balance;
            c[index] = share.re / balance;
            index += 1;
        }
    }
    for j in 0..count {
        for i in 0..count {
            matrix[(i, j)] -= b[i] * c[j];
            if !matrix[(i, j)].is_finite() {
                return Err(RationalError::NotFinite { stage: "vector fitting" });
            }
        }
    }
    let roots = matrix.eigenvalues().map_err(|_| RationalError::NoConvergence { stage: "vector fitting" })?;
    let mut moved = fold_conjugates(&roots);
    stabilise(&mut moved);
    Ok(moved)
}

/// Residues (and constants) of given poles for every response, by least squares.
pub(crate) fn residues(
    samples: &Samples,
    poles: &[Complex64],
    with_constant: bool,
) -> Result<Vec<PartialFractions>, RationalError> {
    regularised_residues(samples, poles, with_constant, 0.0)
}

/// As [`residues`], for poles that the samples hardly distinguish: a coefficient (a pole's peak, weighted) of 1 counts
/// like an error of `ridge` (Tikhonov); 0 for none.
pub(crate) fn regularised_residues(
    samples: &Samples,
    poles: &[Complex64],
    with_constant: bool,
    ridge: f64,
) -> Result<Vec<PartialFractions>, RationalError> {
    let count = order(poles);
    let left = count + usize::from(with_constant);
    samples.check(left, "residue fit")?;
    let (points, responses) = (samples.points.len(), samples.responses.len());
    let ridges = if ridge > 0.0 { left } else { 0 };
    let prepared = Points::new(&samples.points, &samples.point_weights);
    let mut columns = ColumnMatrix::zeros(prepared.rows(), left);
    prepared.fill(poles, with_constant, &mut columns.entries);
    let half = columns.rows / 2;
    // The ridges stand below the samples, one row per coefficient; the responses are right-hand sides.
    let mut matrix = Mat::<f64>::zeros(2 * points + ridges, left + responses);
    for index in 0..left {
        let column = columns.column(index);
        let target = matrix.col_as_slice_mut(index);
        target[..points].copy_from_slice(&column[..points]);
        target[points..2 * points].copy_from_slice(&column[half..half + points]);
        if ridges > 0 {
            target[2 * points + index] = ridge;
        }
    }
    for (q, response) in samples.responses.iter().enumerate() {
        let target = matrix.col_as_slice_mut(left + q);
        for (k, &value) in response.iter().enumerate() {
            let value = value * (samples.weights[q] * samples.point_weights[k]);
            (target[k], target[points + k]) = (value.re, value.im);
        }
    }
    eliminate(matrix.as_mut(), left);
    let mut solution = vec![0.0; left];
    let mut models = Vec::with_capacity(responses);
    for q in 0..responses {
        back_substitute(&matrix, left, left + q, &mut solution);
        models.push(from_scaled(poles, &solution, count, with_constant, samples.weights[q]));
    }
    Ok(models)
}

/// Partial fractions from coefficients of the scaled real basis.
fn from_scaled(
    poles: &[Complex64],
    solution: &[f64],
    count: usize,
    with_constant: bool,
    weight: f64,
) -> PartialFractions {
    let mut residues = Vec::with_capacity(poles.len());
    let mut index = 0;
    for &pole in poles {
        let scale = -pole.re / weight;
        if is_pair(pole) {
            residues.push(Complex64::new(solution[index] * scale, solution[index + 1] * scale));
            index += 2;
        } else {
            residues.push(Complex64::new(solution[index] * scale, 0.0));
            index += 1;
        }
    }
    let constant = if with_constant { solution[count] / weight } else { 0.0 };
    PartialFractions { poles: poles.to_vec(), residues, constant }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Starting poles without prior knowledge: `pairs` weakly damped pairs, spaced logarithmically from `lowest` to
    /// `highest` angular frequency \[rad/s\], and a real pole at the lowest.
    fn starting_poles(pairs: usize, lowest: f64, highest: f64) -> Vec<Complex64> {
        let step = (highest / lowest).ln() / (pairs.max(2) - 1) as f64;
        let mut poles: Vec<Complex64> = (0..pairs)
            .map(|i| lowest * (step * i as f64).exp())
            .map(|frequency| Complex64::new(-0.05 * frequency, frequency))
            .collect();
        poles.push(Complex64::new(-lowest, 0.0));
        poles
    }

    fn model() -> PartialFractions {
        PartialFractions {
            poles: vec![Complex64::new(-20.0, 600.0), Complex64::new(-300.0, 9e3), (-50.0).into()],
            residues: vec![Complex64::new(3.0, -900.0), Complex64::new(-40.0, 2e3), 7.0.into()],
            constant: 0.125,
        }
    }

    fn samples_of(models: &[PartialFractions]) -> Samples {
        let points: Vec<_> = (0..120).map(|k| Complex64::new(0.0, 10.0 * 10f64.powf(k as f64 * 3.5 / 119.0))).collect();
        let responses = models.iter().map(|model| points.iter().map(|&s| model.evaluate(s)).collect()).collect();
        Samples { point_weights: vec![1.0; points.len()], points, responses, weights: vec![1.0; models.len()] }
    }

    #[test]
    fn a_rational_function_is_found_again_from_wrong_poles() {
        let exact = model();
        let mut second = exact.clone();
        second.residues.iter_mut().for_each(|residue| *residue = *residue * 0.3 + residue.re);
        second.constant = -1.0;
        let samples = samples_of(&[exact.clone(), second]);
        let relocated = |elimination| {
            let mut poles = starting_poles(2, 100.0, 2e4);
            for _ in 0..12 {
                poles = relocate(&samples, &poles, true, elimination).unwrap();
            }
            poles
        };
        for (found, pole) in relocated(Elimination::Products).iter().zip(&exact.poles) {
            assert!((found - pole).norm() < 1e-5 * pole.norm(), "products: {found} {pole}");
        }
        let poles = relocated(Elimination::Reflections);
        for (found, pole) in poles.iter().zip(&exact.poles) {
            assert!((found - pole).norm() < 1e-8 * pole.norm(), "{found} {pole}");
        }
        let fitted = residues(&samples, &poles, true).unwrap();
        for (found, residue) in fitted[0].residues.iter().zip(&exact.residues) {
            assert!((found - residue).norm() < 1e-7 * residue.norm(), "{found} {residue}");
        }
        assert!((fitted[0].constant - 0.125).abs() < 1e-9);
        assert!((fitted[1].constant + 1.0).abs() < 1e-9);
    }

    #[test]
    fn too_few_samples_and_values_that_are_not_finite_are_refused() {
        let mut samples = samples_of(&[model()]);
        samples.responses[0][3] = Complex64::new(f64::NAN, 0.0);
        let poles = starting_poles(3, 10.0, 1e4);
        assert!(matches!(
            relocate(&samples, &poles, false, Elimination::Reflections),
            Err(RationalError::NotFinite { .. })
        ));
        let few = Samples { points: samples.points[..4].to_vec(), ..samples };
        assert!(matches!(
            relocate(&few, &poles, false, Elimination::Reflections),
            Err(RationalError::TooFewSamples { samples: 4, .. })
        ));
    }
}
