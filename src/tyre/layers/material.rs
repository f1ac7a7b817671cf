//! Viscoelastic laws: the modulus as a function of s.
//!
//! - `power-law`: E(s) = E0 ((s + wc)/w0)^(2 gamma), gamma = atan(eta)/pi. For s = i w well above the corner wc the
//!   phase is gamma pi = atan(eta): the loss factor is eta. The corner keeps the static modulus finite.
//! - `prony`: E(s) = Einf (1 + sum_j g_j s tau_j/(1 + s tau_j)).
//! - `elastic`: E(s) = E0.
//! - `hysteretic`: E0 (1 + i eta sign(Im s)): the textbook law, not causal.

use std::f64::consts::PI;

use num_complex::Complex64;

use crate::scene::{Foundation, Law, Material};

/// ((s + wc)/w0)^(2 atan(eta)/pi): the frequency dependence shared by power-law materials and the foundation;
/// frequencies in Hz.
pub(super) fn power_law(s: Complex64, loss_factor: f64, reference_frequency: f64, corner_frequency: f64) -> Complex64 {
    let ratio = (s + 2.0 * PI * corner_frequency) / (2.0 * PI * reference_frequency);
    ratio.powf(2.0 * loss_factor.atan() / PI)
}

/// Young's modulus E(s) \[Pa\].
pub fn modulus(material: &Material, s: Complex64) -> Complex64 {
    let factor = match material.law {
        Law::Elastic => Complex64::new(1.0, 0.0),
        Law::PowerLaw => power_law(s, material.loss_factor, material.reference_frequency, material.corner_frequency),
        Law::Prony => material
            .weights
            .iter()
            .zip(&material.times)
            .map(|(&weight, &time)| s * (weight * time) / (s * time + 1.0))
            .fold(Complex64::new(1.0, 0.0), |sum, term| sum + term),
        Law::Hysteretic => {
            let sign = if s.im > 0.0 {
                1.0
            } else if s.im < 0.0 {
                -1.0
            } else {
                0.0
            };
            Complex64::new(1.0, material.loss_factor * sign)
        }
    };
    factor * material.modulus
}

/// Shear modulus mu(s) \[Pa\].
pub(crate) fn shear_modulus(material: &Material, s: Complex64) -> Complex64 {
    modulus(material, s) / (2.0 * (1.0 + material.poisson))
}

/// Effective modulus |E(2 pi i f)|/(1 - nu^2) \[Pa\] at a frequency \[Hz\]: that of a half-space under a rigid
/// indenter.
pub(crate) fn effective_modulus(material: &Material, frequency: f64) -> f64 {
    let poisson = material.poisson;
    modulus(material, Complex64::new(0.0, 2.0 * PI * frequency)).norm() / (1.0 - poisson * poisson)
}

/// Foundation stiffness per area at s: \[tangential, normal\] \[N/m^3\].
pub fn foundation_stiffness(foundation: &Foundation, s: Complex64) -> [Complex64; 2] {
    let factor = power_law(s, foundation.loss_factor, foundation.reference_frequency, foundation.corner_frequency);
    [factor * foundation.tangential, factor * foundation.normal]
}

/// Ratio of shear to longitudinal modulus mu/(lambda + 2 mu) = (1 - 2 nu)/(2 - 2 nu); real for a real Poisson's ratio.
pub(crate) fn modulus_ratio(poisson: f64) -> f64 {
    (1.0 - 2.0 * poisson) / (2.0 - 2.0 * poisson)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rubber(law: Law) -> Material {
        Material {
            law,
            modulus: 8e6,
            loss_factor: 0.25,
            poisson: 0.49,
            density: 1150.0,
            reference_frequency: 1000.0,
            corner_frequency: 1.0,
            weights: vec![0.3, 0.2],
            times: vec![1e-2, 1e-4],
        }
    }

    #[test]
    fn power_law_has_its_loss_factor_and_a_finite_static_modulus() {
        let e = modulus(&rubber(Law::PowerLaw), Complex64::new(0.0, 2.0 * PI * 1000.0));
        assert!((e.im / e.re - 0.25).abs() < 1e-3);
        let gamma = 0.25_f64.atan() / PI;
        let still = modulus(&rubber(Law::PowerLaw), Complex64::new(0.0, 0.0));
        assert!((still.re - 8e6 * 1e-3_f64.powf(2.0 * gamma)).abs() < 1e-6 * still.re);
        assert!(still.im.abs() < f64::MIN_POSITIVE, "a modulus at rest is real: {still}");
    }

    #[test]
    fn causal_laws_are_passive_and_hysteretic_is_odd_in_frequency() {
        for law in [Law::Elastic, Law::PowerLaw, Law::Prony] {
            for s in [Complex64::new(1.0, 300.0), Complex64::new(0.0, 5e4), Complex64::new(1e5, 1.0)] {
                assert!(modulus(&rubber(law), s).im >= 0.0);
                let conjugate = modulus(&rubber(law), s.conj());
                assert!((conjugate - modulus(&rubber(law), s).conj()).norm() < 1e-9 * conjugate.norm());
            }
        }
        let e = modulus(&rubber(Law::Hysteretic), Complex64::new(0.0, -3.0));
        assert!((e.im / e.re + 0.25).abs() < 1e-15);
    }
}
