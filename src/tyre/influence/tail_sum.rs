//! Tails of infinite sums over smooth terms, as a dozen nodes and weights.
//!
//! A plain tail is an integral with end corrections (Euler and Maclaurin, midpoint form):
//!
//! ```text
//! sum_(k >= 1) g(X - 1/2 + k) = int_X^inf g dx + g'(X)/24 - 7 g'''(X)/5760 + 31 g^(5)(X)/967680 - ...
//! ```
//!
//! with the derivatives from differences of terms next to the edge and the integral by Gauss-Legendre quadrature in
//! t = X/x. An oscillating tail is summed by parts (Abel):
//!
//! ```text
//! sum_(k >= 0) z^k g(k) = sum_j z^j/(1 - z)^(j+1) (Delta^j g)(0),   |z| = 1, z != 1.
//! ```

use num_complex::Complex64;

/// Eight-point Gauss-Legendre nodes and weights on 0..1.
const NODES: [(f64, f64); 8] = [
    (0.019_855_071_751_231_856, 0.050_614_268_145_188_13),
    (0.101_666_761_293_186_64, 0.111_190_517_226_687_24),
    (0.237_233_795_041_835_5, 0.156_853_322_938_943_63),
    (0.408_282_678_752_175_1, 0.181_341_891_689_181),
    (0.591_717_321_247_825, 0.181_341_891_689_181),
    (0.762_766_204_958_164_5, 0.156_853_322_938_943_63),
    (0.898_333_238_706_813_4, 0.111_190_517_226_687_24),
    (0.980_144_928_248_768_1, 0.050_614_268_145_188_13),
];

/// Differences in place of the end corrections up to the fifth derivative: distance on either side of the edge and
/// weight. Error of the order of the seventh.
const END_CORRECTION: [(f64, f64); 3] =
    [(0.5, 26279.0 / 483_840.0), (1.5, -4691.0 / 967_680.0), (2.5, 367.0 / 967_680.0)];

/// Terms of the summation by parts.
const PARTS: usize = 8;

/// Nodes and weights (x, weight) such that sum weight g(x) is the sum of g over edge + 1/2, edge + 3/2, ...
/// `edge` > 2.5; g falls at least like x^-2 and is smooth on the scale of x. Relative error 1e-10 from an edge of 16
/// on, where g is a power.
pub(super) fn plain(edge: f64) -> impl Iterator<Item = (f64, f64)> {
    let integral = NODES.into_iter().map(move |(t, weight)| (edge / t, weight * edge / (t * t)));
    let ends = END_CORRECTION
        .into_iter()
        .flat_map(move |(distance, weight)| [(edge + distance, weight), (edge - distance, -weight)]);
    integral.chain(ends)
}

/// Weights such that sum weight_k g(k), k = 0..8, is Re of sum_(k >= 0) first z^k g(k), z = exp(i `angle`). Error: the
/// eighth difference of g over |2 sin(angle/2)|^8.
pub(super) fn oscillating(first: Complex64, angle: f64) -> [f64; PARTS] {
    let z = Complex64::cis(angle);
    let inverse = (1.0 - z).inv();
    let mut weights = [Complex64::ZERO; PARTS];
    let mut factor = first * inverse;
    // Row j of Pascal's triangle with alternating signs: Delta^j.
    let mut difference = [0.0; PARTS];
    difference[0] = 1.0;
    for j in 0..PARTS {
        for (weight, &coefficient) in weights.iter_mut().zip(&difference[..=j]) {
            *weight += factor * coefficient;
        }
        factor *= z * inverse;
        if j + 1 < PARTS {
            for i in (0..=j + 1).rev() {
                difference[i] = if i > 0 { difference[i - 1] } else { 0.0 } - difference[i];
            }
        }
    }
    weights.map(|weight| weight.re)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn a_tail_of_inverse_squares_and_cubes_is_the_zeta_functions() {
        // zeta(2) and zeta(3) less the terms before the edge.
        for (power, zeta) in [(2, PI * PI / 6.0), (3, 1.202_056_903_159_594_2)] {
            for (before, bound) in [(6, 3e-7), (16, 1e-10)] {
                let known: f64 = (1..=before).map(|k| f64::from(k).powi(-power)).sum();
                let rest: f64 = plain(f64::from(before) + 0.5).map(|(x, weight)| weight * x.powi(-power)).sum();
                let error = (known + rest - zeta).abs() / zeta;
                assert!(error < bound, "power {power}, {before} terms: {error:.1e}");
            }
        }
    }

    #[test]
    fn an_oscillating_tail_is_the_fourier_series_of_a_parabola() {
        // sum cos(k t)/k^2 = t^2/4 - pi t/2 + pi^2/6.
        for t in [1.0_f64, 2.0, 3.0] {
            let exact = t * t / 4.0 - PI * t / 2.0 + PI * PI / 6.0;
            let before = 60;
            let known: f64 = (1..before).map(|k| (f64::from(k) * t).cos() / f64::from(k * k)).sum();
            let weights = oscillating(Complex64::cis(f64::from(before) * t), t);
            let rest: f64 = (before..).zip(weights).map(|(k, weight)| weight / f64::from(k * k)).sum();
            assert!((known + rest - exact).abs() < 1e-12, "{t}: {:e}", known + rest - exact);
        }
    }
}
