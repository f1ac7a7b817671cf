//! Limit of all of C at high wavenumbers and real s: the elastic half-space of the tread's material.
//!
//! With x = Q/(mu k^2) >= 0, kappa = mu/(lambda + 2 mu), a = sqrt(1 + kappa x), b = sqrt(1 + x), as in
//! [`surface_asymptote`](super::surface_asymptote),
//!
//! ```text
//! D = ((2 + x)^2 - 4 a b)/x = (16 (1 - kappa) + (24 - 16 kappa) x + 8 x^2 + x^3)/((2 + x)^2 + 4 a b)
//! mu k C_LL = b/D,   mu k C_zz = a/D,   mu k C_SS = 1/b
//! mu k C_Lz = (2 a b - (2 + x))/(x D),  (2 a b - (2 + x))/x = (4 kappa - (1 - 4 kappa) x)/((2 + x) + 2 a b)
//! ```
//!
//! in forms without cancellation at x -> 0.

/// Compliances of a half-space along the wave (L), across it (S) and outwards (z).
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
    use num_complex::Complex64;

    use super::*;
    use crate::test_models::plate_tyre;
    use crate::tyre::layers::compliance::Stack;

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
