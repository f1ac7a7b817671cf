//! Influence functions over distance and time: g_j(t) = sum over n = -N/2 ... N/2 - 1 of exp(2 pi i n j/N) sum_r R_r
//! exp(lambda_r t), exact for the model, without a transform or wrap-around. Of a tyre that turns cosines of E_n, less
//! sines of O_n.

use std::f64::consts::PI;

use num_complex::Complex64;

use super::influence::Field;
use super::poles::RationalModel;
use crate::numeric::in_parallel;

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_models::tyre;
    use crate::tyre::poles::{Direction, FitOptions, fit, turning_ring};

    #[test]
    fn impulse_response_decays_and_integrates_to_static_influence() {
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
    }
}
