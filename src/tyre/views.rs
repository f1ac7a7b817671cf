//! Views of influence functions: magnitude over wavenumber and frequency, g over distance and time, causality, and the
//! static influence compared with the half-space's.
//!
//! - [`magnitudes`]: |H_n(i w)|; its poles are in [`RationalModel::modes`];
//! - [`impulse_responses`]: g_j(t) = sum over n = -N/2 ... N/2 - 1 of exp(2 pi i n j/N) sum_r R_r exp(lambda_r t):
//!   exact for the model, without a transform or wrap-around. Of a tyre that turns cosines of E_n, less sines of O_n;
//! - [`causality`]: convolution weights at negative lags from the exact sums, causal law or not, by the circle method;
//! - [`static_ratios`]: G_j/G_0 at rest, and for a half-space of the tread's material (Boussinesq, mean over
//!   rectangles).

use std::f64::consts::PI;

use num_complex::Complex64;
use realfft::RealFftPlanner;

use super::influence::convolution_quadrature::Contour;
use super::influence::{Field, InfluenceSum};
use super::poles::{Direction, RationalModel};
use crate::numeric::in_parallel;
use crate::scene::TimeRule;

/// |H_n(2 pi i f)| \[m/N\], of a tyre that turns for the waves of one direction: one row per wavenumber, one column
/// per frequency \[Hz\]. `None` for a field that the model does not have.
pub(crate) fn magnitudes(
    model: &RationalModel,
    field: Field,
    direction: Direction,
    wavenumbers: &[usize],
    frequencies: &[f64],
) -> Option<Vec<Vec<f64>>> {
    let row = |&n: &usize| {
        let modes = model.modes(n.min(model.largest_wavenumber()), field)?;
        let at = |&f: &f64| modes.evaluate_wave(direction, Complex64::new(0.0, 2.0 * PI * f)).norm();
        Some(frequencies.iter().map(at).collect())
    };
    in_parallel::map(wavenumbers, row).into_iter().collect()
}

/// Driving-point mobility of one element, s sum over n = -N/2 ... N/2 - 1 of Ht_n(s), from a value for each
/// n = 0..=N/2 \[m/(N s)\].
pub(crate) fn element_mobility(elements: usize, s: Complex64, value: impl Fn(usize) -> Complex64) -> Complex64 {
    s * (0..=elements / 2).map(|n| value(n) * multiplicity(n, elements)).sum::<Complex64>()
}

/// Number of times that the wavenumber n occurs among -N/2 ... N/2 - 1, up to its sign.
fn multiplicity(n: usize, elements: usize) -> f64 {
    if n == 0 || 2 * n == elements { 1.0 } else { 2.0 }
}

/// Phase of the wave n at a distance \[elements\].
fn phase(n: usize, distance: usize, elements: usize) -> f64 {
    2.0 * PI * ((n * distance) % elements) as f64 / elements as f64
}

/// Factor of E_n at a distance \[elements\] in the sum over n and -n.
fn weight(n: usize, distance: usize, elements: usize) -> f64 {
    multiplicity(n, elements) * phase(n, distance, elements).cos()
}

/// Factor of O_n, in the same sum.
fn odd_weight(n: usize, distance: usize, elements: usize) -> f64 {
    -multiplicity(n, elements) * phase(n, distance, elements).sin()
}

/// g_j(t) \[m/(N s)\] of a unit force impulse: one row per distance j \[elements\], N - j towards smaller elements,
/// one column per time t >= 0 \[s\]. A constant of the model (an impulse at t = 0) is left out. `None` for a field
/// that the model does not have.
pub(crate) fn impulse_responses(
    model: &RationalModel,
    field: Field,
    distances: &[usize],
    times: &[f64],
) -> Option<Vec<Vec<f64>>> {
    let modal = in_parallel::made(model.largest_wavenumber() + 1, |n| {
        let modes = model.modes(n, field)?;
        let over_time = |residues: &[Complex64]| -> Vec<f64> {
            let at = |&t: &f64| {
                let terms = modes.poles.iter().zip(residues).enumerate();
                terms
                    .map(|(index, (&pole, &residue))| (residue * (pole * t).exp()).re * modes.multiplicity(index))
                    .sum()
            };
            times.iter().map(at).collect()
        };
        let odd = if modes.odd.is_empty() { Vec::new() } else { over_time(modes.odd) };
        Some([over_time(modes.residues), odd])
    });
    let modal: Vec<[Vec<f64>; 2]> = modal.into_iter().collect::<Option<_>>()?;
    let row = |&distance: &usize| {
        let mut row = vec![0.0; times.len()];
        for (n, parts) in modal.iter().enumerate() {
            for (modal, weight) in parts.iter().zip([weight, odd_weight]) {
                let weight = weight(n, distance, model.elements);
                row.iter_mut().zip(modal).for_each(|(sum, value)| *sum += weight * value);
            }
        }
        row
    };
    Some(distances.iter().map(row).collect())
}

/// Convolution weights about t = 0 of an element on itself.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Causality {
    /// Largest |w_p| of a negative lag over the largest of all.
    pub precursor: f64,
    /// Fraction of sum w_p^2 that lies before t = 0.
    pub energy_before: f64,
    /// For n = 0..=N/2: square root of that fraction for H_n alone, with H_-n where that differs. A function whose
    /// Laurent coefficients of negative index vanish has an imaginary part that is the Hilbert transform of its real
    /// part on the contour: this is the Kramers-Kronig residual there.
    pub kramers_kronig: Vec<f64>,
}

/// Weights at negative and positive lags from the exact sums, for any law.
///
/// On the circle |zeta| = rho the transform of length K gives rho^-q w_-q + rho^(K-q) w_(K-q) at index K - q: for
/// q < K/2 what wraps round is below rho^K of the weights.
pub(crate) fn causality(sum: &InfluenceSum, rule: TimeRule, time_step: f64, lags: usize) -> Causality {
    let contour = Contour::new(rule, time_step, lags);
    let length = contour.circle.length;
    let at: Vec<_> = contour.points.iter().map(|&s| sum.at(s)).collect();
    let elements = sum.projection().elements;
    let inverse = RealFftPlanner::<f64>::new().plan_fft_inverse(length);
    // 1. Weights of each wavenumber, negative lags first.
    let rows = in_parallel::made(elements / 2 + 1, |n| {
        let mut faces = Vec::with_capacity(at.len());
        sum.faces(n, &at, Field::Surface, &mut faces);
        let signal = |mut spectrum: Vec<Complex64>| {
            spectrum[0].im = 0.0;
            spectrum[length / 2].im = 0.0;
            let mut signal = inverse.make_output_vec();
            // Lengths match by construction.
            let _ = inverse.process(&mut spectrum, &mut signal);
            for (place, value) in signal.iter_mut().enumerate() {
                let lag = if place < length / 2 { place as f64 } else { place as f64 - length as f64 };
                *value *= contour.circle.radius.powf(-lag) / length as f64;
            }
            // Negative lags first.
            signal.rotate_right(length / 2);
            signal
        };
        let odd = if sum.turns() { signal(faces.iter().map(|face| face.odd[0]).collect()) } else { Vec::new() };
        [signal(faces.iter().map(|face| face.driven).collect()), odd]
    });
    // 2. Their squares before t = 0, and those of the sum over all wavenumbers.
    let square = |part: &[f64]| part.iter().map(|w| w * w).sum::<f64>();
    let before = |weights: &[f64]| square(&weights[..weights.len() / 2]);
    // Squares of E and O add up to the mean of H_n's and H_-n's.
    let shared =
        |[even, odd]: [&[f64]; 2]| (before(even) + before(odd)) / (square(even) + square(odd)).max(f64::MIN_POSITIVE);
    let mut total = vec![0.0; length];
    for (n, [row, _]) in rows.iter().enumerate() {
        let weight = multiplicity(n, elements);
        total.iter_mut().zip(row).for_each(|(sum, value)| *sum += weight * value);
    }
    let largest = |part: &[f64]| part.iter().fold(0.0_f64, |a, w| a.max(w.abs()));
    Causality {
        precursor: largest(&total[..length / 2]) / largest(&total),
        energy_before: shared([&total, &[]]),
        kramers_kronig: rows.iter().map(|[even, odd]| shared([even, odd]).sqrt()).collect(),
    }
}

/// Static influence at a distance, relative to that of an element on itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct StaticRatio {
    /// Distance j \[elements\].
    pub distance: usize,
    /// G_j/G_0 of the tyre at rest.
    pub tyre: f64,
    /// Compliance of an elastic half-space: no modulus, no thickness, geometry only.
    pub half_space: f64,
}

/// G_j/G_0 at rest for j = 0..=`most`, elements `element` long and `contact_width` wide \[m\]; `None` for a field that
/// the model does not have.
pub(crate) fn static_ratios(
    model: &RationalModel,
    field: Field,
    [element, contact_width]: [f64; 2],
    most: usize,
) -> Option<Vec<StaticRatio>> {
    let at_rest = model.at_rest(field)?;
    let influence =
        |j: usize| at_rest.iter().enumerate().map(|(n, value)| weight(n, j, model.elements) * value).sum::<f64>();
    let (own, own_half_space) = (influence(0), mean_inverse_distance(0.0, element, contact_width));
    let ratio = |distance| StaticRatio {
        distance,
        tyre: influence(distance) / own,
        half_space: mean_inverse_distance(distance as f64 * element, element, contact_width) / own_half_space,
    };
    Some((0..=most).map(ratio).collect())
}

/// Mean of 1/r between the points of two equal rectangles, `length` by `width` \[m\], whose centres are `distance`
/// apart along the length \[1/m\]: the fourth difference of the function with f_xxyy = 1/r.
pub(crate) fn mean_inverse_distance(distance: f64, length: f64, width: f64) -> f64 {
    let f = |x: f64, y: f64| {
        let r = x.hypot(y);
        let term = |a: f64, b: f64| if a == 0.0 || b == 0.0 { 0.0 } else { 0.5 * a * a * b * (b / a.abs()).asinh() };
        term(x, y) + term(y, x) - r * r * r / 6.0
    };
    let second = |y: f64| f(distance + length, y) - 2.0 * f(distance, y) + f(distance - length, y);
    (second(width) - 2.0 * second(0.0) + second(-width)) / (length * length * width * width)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Law;
    use crate::test_models::tyre;
    use crate::tyre::influence::{Projection, Truncation};
    use crate::tyre::poles::{FitOptions, fit, turning_ring};

    #[test]
    fn causal_laws_answer_after_the_force_and_the_textbook_law_before_it() {
        let elements = 32;
        let (mut worst, mut least) = (0.0_f64, f64::INFINITY);
        for law in [Law::PowerLaw, Law::Prony, Law::Elastic, Law::Hysteretic] {
            let mut tyre = tyre(0.25);
            for layer in &mut tyre.layers {
                layer.material.law = law;
                (layer.material.weights, layer.material.times) = (vec![0.4, 0.3], vec![1e-2, 1e-4]);
            }
            let time_step = tyre.circumference / elements as f64 / (80.0 / 3.6);
            let sum =
                InfluenceSum::with(&tyre, Projection::new(&tyre, elements), Truncation::Tail, 1e-12, 4.0 / time_step);
            let found = causality(&sum, TimeRule::Bdf2, time_step, 128);
            let residual = found.kramers_kronig.iter().fold(0.0_f64, |a, &b| a.max(b));
            println!(
                "{law:?}: precursor {:.1e}, energy {:.1e}, KK {residual:.1e}",
                found.precursor, found.energy_before
            );
            if law == Law::Hysteretic {
                least = found.precursor.min(residual);
            } else {
                worst = worst.max(found.precursor).max(residual);
            }
        }
        assert!(worst < 1e-10, "{worst:.1e}");
        assert!(least > 1e-4, "{least:.1e}");
    }

    #[test]
    fn impulse_response_integrates_to_the_static_influence_and_decays() {
        let tyre = tyre(0.25);
        let options = FitOptions { top: 4e4, ..FitOptions::new(&tyre, 16, 0.0).with_tolerance(1e-4) };
        let model = fit(&tyre, &options).unwrap();
        // Simpson over 1.5 s in steps of 25 us.
        let step = 2.5e-5;
        let times: Vec<f64> = (0..=60_000).map(|i| i as f64 * step).collect();
        let g = impulse_responses(&model, Field::Surface, &[0, 3], &times).unwrap();
        let at_rest = model.at_rest(Field::Surface).unwrap();
        for (row, j) in g.iter().zip([0, 3]) {
            let integral: f64 =
                row.iter().enumerate().map(|(i, value)| value * if i % 2 == 1 { 4.0 } else { 2.0 }).sum::<f64>() * step
                    / 3.0;
            let exact: f64 = at_rest
                .iter()
                .enumerate()
                .map(|(n, h)| multiplicity(n, 16) * (2.0 * PI * (n * j) as f64 / 16.0).cos() * h)
                .sum();
            assert!((integral - exact).abs() < 2e-2 * exact.abs(), "{j}: {integral:e} {exact:e}");
        }
        let peak = g[0].iter().fold(0.0_f64, |a, &b| a.max(b.abs()));
        assert!(g[0].last().unwrap().abs() < 1e-3 * peak);
        assert!(impulse_responses(&model, Field::UnderTread, &[0], &times[..2]).is_none());
    }

    #[test]
    fn a_turning_ring_answers_differently_on_either_side() {
        let (elements, turning) = (16, -70.0);
        let model = turning_ring::model(elements, turning);
        let times = [1e-4, 3e-3, 2e-2];
        let distances = [0, 1, 5, 8, 11, 15];
        let found = impulse_responses(&model, Field::Surface, &distances, &times).unwrap();
        let mut least = f64::INFINITY;
        for (row, j) in found.iter().zip(distances) {
            for (value, t) in row.iter().zip(times) {
                // All waves n = -8..8 one by one: n > 0 has the pole of its direction, and the conjugate of the other
                // one's.
                let of = |n: i64| {
                    let mode = turning_ring::mode(elements, n.unsigned_abs() as usize, turning);
                    let ring = |direction| mode.residue(direction) * (mode.pole(direction) * t).exp();
                    let h = ring(Direction::Forwards) + ring(Direction::Backwards).conj();
                    let h = if n < 0 { h.conj() } else { h };
                    h * Complex64::cis(2.0 * PI * (n * j as i64) as f64 / elements as f64)
                };
                let exact: Complex64 = (-8..8).map(of).sum();
                assert!(exact.im.abs() < 1e-12 * exact.norm().max(1e-3), "{j} {t}");
                assert!((value - exact.re).abs() < 1e-10, "{j} {t}: {value} {exact}");
            }
            let mirrored = found[distances.iter().position(|other| (other + j) % elements == 0).unwrap()][1];
            if j % 8 > 0 {
                least = least.min((row[1] / mirrored - 1.0).abs());
            }
        }
        assert!(least > 1e-2, "{least}");
        let at = |direction| magnitudes(&model, Field::Surface, direction, &[3], &[95.0]).unwrap()[0][0];
        let exact = |direction| {
            turning_ring::mode(elements, 3, turning).at(direction, Complex64::new(0.0, 2.0 * PI * 95.0)).norm()
        };
        for direction in Direction::BOTH {
            assert!((at(direction) / exact(direction) - 1.0).abs() < 1e-12, "{direction:?}");
        }
    }

    #[test]
    fn mean_inverse_distance_is_loves_value_for_a_square_and_1_over_r_far_away() {
        // Mean over a square of side 1 of the potential of the uniformly covered square itself:
        // 4 (ln(1 + sqrt 2) + (1 - sqrt 2)/3).
        let exact = 4.0 * ((1.0 + 2f64.sqrt()).ln() + (1.0 - 2f64.sqrt()) / 3.0);
        assert!((mean_inverse_distance(0.0, 1.0, 1.0) - exact).abs() < 1e-12);
        assert!((mean_inverse_distance(40.0, 1.0, 1.0) * 40.0 - 1.0).abs() < 1e-3);
    }
}
