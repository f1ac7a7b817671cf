//! Compliance of a centred strip of a belt with free edges: the sum over guided waves, wave by wave, and the edges'
//! correction. Reference path: no tables, no moments.
//!
//! ```text
//! H = (1/R) sum_m (1/N_m) a_m^2 C_zz(n, m) + correction,    m even, a_m = sinc(k_m b/2).
//! ```
//!
//! From k = [`HALF_SPACE`]/h on, h the tread's thickness, C_zz is that of a half-space; the sum ends where the rest, of
//! terms below 2 C_zz/(B (k_m b/2)^2), is below [`REST`] of it.

use std::f64::consts::{FRAC_PI_2, PI};

use num_complex::Complex64;

use super::belt::FreeEdges;
use super::lateral_shapes::Parity;
use crate::numeric::sinc;
use crate::tyre::layers::curved::CurvedStack;
use crate::tyre::layers::cylinder::Cylinder;
use crate::tyre::layers::material::{modulus_ratio, shear_modulus};
use crate::tyre::layers::surface_asymptote::{LARGEST_ARGUMENT, closed_form, series};

/// Wavenumber times thickness of the tread from which on it is a half-space, within 1/(k R) of C_zz.
const HALF_SPACE: f64 = 30.0;
/// Rest of the sum over its first term.
const REST: f64 = 1e-7;
/// Relative accuracy of the waves.
const TOLERANCE: f64 = 1e-9;

impl FreeEdges {
    /// Mean of w over a centred strip of a width \[m\] for a unit force per radian, uniform over the strip, in motion
    /// of n periods round the tyre at s \[m/(N/rad)\].
    pub fn strip(&self, n: i64, s: Complex64, strip: f64) -> Complex64 {
        strip_of(self.guided(), n, s, strip) + self.section(n, Parity::Even).at(s).strip(strip)
    }
}

/// Number of lateral numbers that feel the layers.
pub(super) fn explicit_waves(stack: &CurvedStack) -> f64 {
    stack.layers.last().map_or(0.0, |tread| (HALF_SPACE * stack.width / (PI * tread.thickness)).ceil())
}

/// The sum over guided waves of a stack.
pub(super) fn strip_of(stack: CurvedStack, n: i64, s: Complex64, strip: f64) -> Complex64 {
    let CurvedStack { width, radius, .. } = stack;
    let Some(tread) = stack.layers.last().cloned() else { return Complex64::ZERO };
    let weight = |m: usize| {
        let share = sinc(FRAC_PI_2 * m as f64 * strip / width);
        share * share * if m == 0 { 1.0 } else { 2.0 } / width
    };
    // 1. Waves that feel the layers.
    let explicit = explicit_waves(&stack) as usize;
    let cylinder = Cylinder::of(stack, s.norm(), TOLERANCE);
    let at = cylinder.at(s);
    let waves = (0..explicit).step_by(2);
    let sum: Complex64 = waves
        .map(|m| {
            let [forwards, backwards] = cylinder.wave(n.abs(), m).normal_both_ways(&at);
            (if n < 0 { backwards } else { forwards }).surface * weight(m)
        })
        .sum();
    // 2. The half-space.
    let shear = shear_modulus(&tread.material, s);
    let (kappa, inertia) = (modulus_ratio(tread.material.poisson), s * s * tread.material.density);
    let coefficients = series(kappa);
    let half_space = |m: usize| {
        let k = (PI * m as f64 / width).hypot(n as f64 / radius);
        let x = inertia / (shear * k * k);
        let relative = if x.norm() < LARGEST_ARGUMENT {
            coefficients.iter().rev().fold(Complex64::ZERO, |sum, term| sum * x + term)
        } else {
            closed_form(kappa, x)
        };
        relative / (shear * k)
    };
    let mut rest = Complex64::ZERO;
    for m in (explicit.next_multiple_of(2)..).step_by(2) {
        rest += half_space(m) * weight(m);
        // The sum of 1/m^3 over even m from here on is a quarter of 1/m^2.
        let bound = half_space(m) * (m as f64 * 0.25 * 2.0 / width / (FRAC_PI_2 * m as f64 * strip / width).powi(2));
        if bound.norm() <= REST * sum.norm() || bound.is_nan() {
            break;
        }
    }
    (sum + rest) / radius
}
