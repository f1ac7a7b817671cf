//! Limits of C_zz, and of all of C at real s, at high wavenumbers: the elastic half-space of the tread's material.
//!
//! A normal load of wavenumber k on a half-space gives (Lamb 1904, here with s = i w and x = Q/(mu k^2), kappa =
//! mu/(lambda + 2 mu))
//!
//! ```text
//! mu k C_zz = phi(x) = a x/((2 + x)^2 - 4 a b),   a = sqrt(1 + kappa x),  b = sqrt(1 + x),
//! ```
//!
//! with phi(0) = 1 - nu. phi has its nearest singularity at the Rayleigh pole, |x| > 0.76 for any nu > 0, so the power
//! series converges like (|x|/0.76)^j. Hence a sum of C_zz over wavenumbers above some k_c needs no evaluation at all:
//! with the moments M_j = sum weight k^-(2j+1), which depend on neither s nor the material's stiffness,
//!
//! ```text
//! sum weight C_zz = (1/mu) sum_j phi_j (Q/mu)^j M_j.
//! ```
//!
//! A layer of thickness h differs from the half-space by terms of the order (k h)^2 exp(-2 k h).

use num_complex::Complex64;

/// Terms of the power series.
pub(crate) const TERMS: usize = 14;

/// Largest |x| at which the series is used: (0.12/0.76)^14 = 6e-12.
pub(crate) const LARGEST_ARGUMENT: f64 = 0.12;

/// Power-series coefficients phi_j for a modulus ratio kappa = mu/(lambda + 2 mu) in (0, 1).
///
/// Numerator and denominator both start at x, so the quotient of the shifted series is taken; the constant terms
/// cancel exactly.
pub(crate) fn series(kappa: f64) -> [f64; TERMS] {
    // sqrt(1 + c x): coefficients binomial(1/2, j) c^j.
    let root = |c: f64| {
        let mut coefficients = [1.0; TERMS + 1];
        for j in 1..=TERMS {
            let order = j as f64;
            coefficients[j] = coefficients[j - 1] * c * (1.5 - order) / order;
        }
        coefficients
    };
    let (a, b) = (root(kappa), root(1.0));
    // ((2 + x)^2 - 4 a b)/x.
    let mut denominator = [0.0; TERMS];
    for (j, entry) in denominator.iter_mut().enumerate() {
        let product: f64 = (0..=j + 1).map(|i| a[i] * b[j + 1 - i]).sum();
        let square = match j {
            0 => 4.0,
            1 => 1.0,
            _ => 0.0,
        };
        *entry = square - 4.0 * product;
    }
    let mut quotient = [0.0; TERMS];
    for j in 0..TERMS {
        let known: f64 = (0..j).map(|i| quotient[i] * denominator[j - i]).sum();
        quotient[j] = (a[j] - known) / denominator[0];
    }
    quotient
}

/// phi(x) in closed form: also where the series does not converge. Cancels for x -> 0.
pub(crate) fn closed_form(kappa: f64, x: Complex64) -> Complex64 {
    let (a, b) = ((x * kappa + 1.0).sqrt(), (x + 1.0).sqrt());
    a * x / ((x + 2.0) * (x + 2.0) - a * b * 4.0)
}

/// Wavenumber above which a layer of thickness `h` \[m\] is a half-space to a relative `tolerance` \[1/m\].
pub(crate) fn thickness_limit(h: f64, tolerance: f64) -> f64 {
    // 4 (k h)^2 exp(-2 k h) = tolerance, by fixed-point iteration from the large-argument side; it contracts by 1/(k
    // h).
    let mut argument: f64 = 0.5 * (4.0 / tolerance).ln();
    for _ in 0..8 {
        argument = 0.5 * (4.0 * argument * argument / tolerance).ln();
    }
    argument / h
}

/// Limit of all of C at real s: compliances of a half-space along the wave (L), across it (S) and outwards (z).
///
/// With x = Q/(mu k^2) >= 0, kappa = mu/(lambda + 2 mu), a = sqrt(1 + kappa x), b = sqrt(1 + x),
///
/// ```text
/// D = ((2 + x)^2 - 4 a b)/x = (16 (1 - kappa) + (24 - 16 kappa) x + 8 x^2 + x^3)/((2 + x)^2 + 4 a b)
/// mu k C_LL = b/D,   mu k C_zz = a/D,   mu k C_SS = 1/b
/// mu k C_Lz = (2 a b - (2 + x))/(x D),  (2 a b - (2 + x))/x = (4 kappa - (1 - 4 kappa) x)/((2 + x) + 2 a b)
/// ```
///
/// in forms without cancellation at x -> 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct HalfSpaceTraction {
    /// C_LL mu k.
    pub along: f64,
    /// C_Lz mu k: motion along the wave, a quarter of a period apart, by outward traction.
    pub mixed: f64,
    /// C_zz mu k.
    pub outward: f64,
    /// C_SS mu k.
    pub shear: f64,
}

impl HalfSpaceTraction {
    /// Compliances times mu k for a modulus ratio kappa and x >= 0.
    pub(crate) fn new(kappa: f64, x: f64) -> Self {
        let (a, b) = ((1.0 + kappa * x).sqrt(), (1.0 + x).sqrt());
        let numerator = 16.0 * (1.0 - kappa) + x * ((24.0 - 16.0 * kappa) + x * (8.0 + x));
        let denominator = numerator / ((2.0 + x) * (2.0 + x) + 4.0 * a * b);
        let mixed = (4.0 * kappa - (1.0 - 4.0 * kappa) * x) / ((2.0 + x) + 2.0 * a * b);
        Self { along: b / denominator, mixed: mixed / denominator, outward: a / denominator, shear: 1.0 / b }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_models::plate_tyre;
    use crate::tyre::layers::compliance::Stack;

    #[test]
    fn series_equals_the_closed_form_and_1_minus_nu_at_rest() {
        for nu in [0.0, 0.3, 0.49, 0.4999] {
            let kappa = crate::tyre::layers::material::modulus_ratio(nu);
            let phi = series(kappa);
            assert!((phi[0] - (1.0 - nu)).abs() < 1e-14, "{} {nu}", phi[0]);
            for x in [Complex64::new(-0.19, 0.0), Complex64::new(0.1, 0.16), Complex64::new(0.19, 0.0)] {
                let sum = phi.iter().rev().fold(Complex64::ZERO, |sum, &c| sum * x + c);
                let exact = closed_form(kappa, x);
                assert!((sum - exact).norm() < 1e-8 * exact.norm(), "nu {nu} x {x}: {sum} {exact}");
            }
        }
    }

    #[test]
    fn short_waves_of_a_stack_are_those_of_its_treads_half_space() {
        let stack = Stack::new(&plate_tyre());
        for (s, k) in [(1.0, 4000.0), (2e3, 3000.0), (2e4, 3000.0), (1e5, 2500.0)] {
            let at = stack.at(Complex64::new(s, 0.0));
            let tread = at.tread();
            let x = tread.inertia_over_shear().re / (k * k);
            let found = HalfSpaceTraction::new(tread.modulus_ratio, x);
            let scale = tread.inverse_shear.re / k;
            let along = at.full(k, 0.0).0;
            // C_xz = -i C_Lz, with z outward.
            let pairs = [
                (found.along, along[0][0].re),
                (found.shear, along[1][1].re),
                (found.outward, along[2][2].re),
                (found.mixed, -along[0][2].im),
                (found.mixed, along[2][0].im),
            ];
            for (found, exact) in pairs {
                assert!((found * scale - exact).abs() < 1e-8 * scale, "s = {s}, k = {k}: {found} {}", exact / scale);
            }
        }
    }
}
