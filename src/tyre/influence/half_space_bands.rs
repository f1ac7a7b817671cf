//! The half-space between the layered tread and its power series: bands of wavenumbers in which C_zz is a smooth
//! function of k alone.
//!
//! Where both waves of the tread decay over its thickness, C_zz is the half-space's phi(x)/(mu k), x = Q/(mu k^2),
//! whether or not |x| is small enough for the power series of
//! [`surface_asymptote`](crate::tyre::layers::surface_asymptote). As a function of k^2 it is analytic but for the
//! Rayleigh pole and the branch points, which damping moves off the real axis. In a band \[a, b\] of k^2 it is
//! therefore a short Chebyshev sum, f = sum_j c_j T_j, and a sum over wavenumbers in the band is
//!
//! ```text
//! sum weight C_zz = sum_j c_j nu_j,    nu_j = sum weight T_j(k^2)
//! ```
//!
//! with moments nu_j that depend on neither s nor the material, and coefficients c_j that do not depend on n. The error
//! is of the order of r^-[`BAND_TERMS`], r the sum of the semi-axes of the largest ellipse about the band, foci at its
//! ends, without a singularity (Trefethen 2013, *Approximation theory and approximation practice*, theorem 8.2).

use std::f64::consts::PI;
use std::iter::Sum;
use std::ops::Mul;
use std::sync::LazyLock;

use num_complex::Complex64;
use pulp::Simd;

use crate::tyre::layers::layer::LayerAt;
use crate::tyre::layers::surface_asymptote::closed_form;

/// Chebyshev terms of a band.
pub(super) const BAND_TERMS: usize = 20;

/// Adds weight T_j(x) to the moments, x the position of k^2 in the band on -1..1, in every lane.
#[inline(always)]
pub(super) fn add<S: Simd>(
    simd: S,
    moments: &mut [S::f64s; BAND_TERMS],
    weight: S::f64s,
    k_squared: S::f64s,
    [low, high]: [f64; 2],
) {
    let scale = simd.splat_f64s(2.0 / (high - low));
    let x = simd.mul_f64s(simd.sub_f64s(k_squared, simd.splat_f64s(0.5 * (low + high))), scale);
    let twice = simd.add_f64s(x, x);
    let (mut current, mut next) = (weight, simd.mul_f64s(weight, x));
    for moment in moments {
        *moment = simd.add_f64s(*moment, current);
        (current, next) = (next, simd.sub_f64s(simd.mul_f64s(twice, next), current));
    }
}

/// cos(j angle_i) 2/[`BAND_TERMS`] (half that for j = 0): from values at the Chebyshev points to coefficients.
static TRANSFORM: LazyLock<[[f64; BAND_TERMS]; BAND_TERMS]> = LazyLock::new(|| {
    std::array::from_fn(|j| {
        let scale = if j == 0 { 1.0 } else { 2.0 } / BAND_TERMS as f64;
        std::array::from_fn(|i| scale * (j as f64 * angle(i)).cos())
    })
});

/// Angle of the Chebyshev point i.
fn angle(i: usize) -> f64 {
    PI * (i as f64 + 0.5) / BAND_TERMS as f64
}

/// Chebyshev coefficients of a function of k^2 in a band of k^2.
pub(super) fn chebyshev<T>([low, high]: [f64; 2], function: impl Fn(f64) -> T) -> [T; BAND_TERMS]
where
    T: Copy + Mul<f64, Output = T> + Sum,
{
    // Row 1 holds the cosines themselves, scaled.
    let points = &TRANSFORM[1];
    let scale = 0.5 * BAND_TERMS as f64;
    let values: [T; BAND_TERMS] =
        std::array::from_fn(|i| function(0.5 * (low + high) + 0.5 * (high - low) * points[i] * scale));
    std::array::from_fn(|j| values.iter().zip(&TRANSFORM[j]).map(|(&value, &weight)| value * weight).sum())
}

/// Chebyshev coefficients of C_zz of the half-space in a band of k^2 \[m/Pa\].
pub(super) fn coefficients(tread: &LayerAt<Complex64>, band: [f64; 2]) -> [Complex64; BAND_TERMS] {
    let ratio = tread.inertia_over_shear();
    chebyshev(band, |k_squared| {
        closed_form(tread.modulus_ratio, ratio / k_squared) * tread.inverse_shear / k_squared.sqrt()
    })
}

/// True if both waves decay over the thickness like exp(-`decay`) at a wavenumber k, and hence above it.
pub(super) fn is_half_space(tread: &LayerAt<Complex64>, k: f64, decay: f64) -> bool {
    let ratio = tread.inertia_over_shear();
    let alpha = (ratio * tread.modulus_ratio + k * k).sqrt();
    let beta = (ratio + k * k).sqrt();
    alpha.re.min(beta.re) * tread.thickness >= decay
}

/// True if the Chebyshev sum of a band of k^2 reaches a relative `tolerance`: by the ellipse through the nearest of
/// Rayleigh pole and branch points, which lie at k^2 = -Q/mu times `factor`.
pub(super) fn is_resolved(tread: &LayerAt<Complex64>, [low, high]: [f64; 2], tolerance: f64) -> bool {
    let ratio = tread.inertia_over_shear();
    let kappa = tread.modulus_ratio;
    let nu = (1.0 - 2.0 * kappa) / (2.0 - 2.0 * kappa);
    // Rayleigh speed over shear speed, within 0.5 % (Viktorov).
    let rayleigh = (0.87 + 1.12 * nu) / (1.0 + nu);
    let least = tolerance.powf(-1.0 / BAND_TERMS as f64);
    [1.0 / (rayleigh * rayleigh), 1.0, kappa].into_iter().all(|factor| {
        let w = (-(ratio * factor) * 2.0 - (low + high)) / (high - low);
        let root = (w * w - 1.0).sqrt();
        (w + root).norm().max((w - root).norm()) >= least
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_models::tyre;
    use crate::tyre::influence::{Field, InfluenceSum, Projection, Truncation};

    #[test]
    fn a_looser_sum_agrees_with_one_of_far_more_evaluations() {
        for (loss_factor, saves) in [(0.25, true), (0.5, true), (0.02, false)] {
            let tyre = tyre(loss_factor);
            let sum =
                |tolerance| InfluenceSum::with(&tyre, Projection::new(&tyre, 256), Truncation::Tail, tolerance, 1.3e5);
            let (loose, tight) = (sum(1e-7), sum(1e-13));
            for n in [0, 40, 128] {
                let largest = loose.value(n, &loose.at(Complex64::ZERO), Field::Surface).value.norm();
                for s in [(0.0, 0.0), (0.0, 2e4), (0.0, 5e4), (0.0, 1.26e5), (6e4, 0.0), (3e4, 9e4)] {
                    let s = Complex64::new(s.0, s.1);
                    let at = loose.at(s);
                    let (a, b) = (loose.value(n, &at, Field::Surface), tight.value(n, &tight.at(s), Field::Surface));
                    let error = (a.value - b.value).norm() / largest;
                    assert!(error < 1e-7, "loss factor {loss_factor}, n {n}, s {s}: {error:.1e}");
                    if saves && s.im > 1e5 {
                        assert!(10 * a.evaluations < 9 * b.evaluations, "{} {}", a.evaluations, b.evaluations);
                    }
                }
            }
        }
    }
}
