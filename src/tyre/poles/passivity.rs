//! Passivity of a model: Re(s H(s)) >= 0 on the axis, within the band and beyond it, where only the model's poles
//! could make it negative between points of the ladder.
//!
//! With rotation, for both waves: H_n = E + i O and H_-n = E - i O, Re(s H_+-n)/|s| = -Im E -+ Re O at s = i w.

use num_complex::Complex64;

use super::ladder::Ladder;
use super::sampled::{Candidate, Sampled};
use crate::numeric::rational::PartialFractions;

const MENDING_ROUNDS: usize = 8;

/// Mends a model that generates energy: its residues are refitted with the offending points as further samples, at
/// which its value without energy is prescribed. Most offences lie beyond the band, where nothing else determines the
/// model. Only a model within the tolerance is accepted.
pub(super) fn passive(sampled: &Sampled<'_>, mut candidate: Candidate) -> Candidate {
    let tolerance = sampled.target.tolerance;
    let mut samples = sampled.samples();
    for _ in 0..MENDING_ROUNDS {
        let models = &candidate.models;
        let (least, s) = least_power(sampled, models);
        if least >= 0.0 {
            break;
        }
        // Samples at the worst point and on either side: the model's real part, and a little dissipation.
        let is_active = powers(&values(models, s)).map(|power| power < 0.0);
        for s in [s * 0.93, s, s * 1.07] {
            let mut values = values(models, s);
            let square = square(&values);
            samples.points.push(s);
            samples.point_weights.push(sampled.point_weight(square));
            without_energy(&mut values, is_active, -0.5 * tolerance * sampled.local_scale(square));
            for (response, value) in samples.responses.iter_mut().zip(values) {
                response.push(value);
            }
        }
        match sampled.candidate(&samples, candidate.poles.clone()) {
            Ok(mended) if mended.errors.largest() <= tolerance => candidate = mended,
            _ => break,
        }
    }
    candidate
}

/// Values of the models at s, one after the other.
fn values(models: &[PartialFractions], s: Complex64) -> Vec<Complex64> {
    models.iter().map(|model| model.evaluate(s)).collect()
}

/// O of the driven face; 0 of a wave like its mirror image.
fn odd(values: &[Complex64]) -> Complex64 {
    values.get(2).copied().unwrap_or_default()
}

/// Mean of |H_n|^2 and |H_-n|^2 of the driven face.
fn square(values: &[Complex64]) -> f64 {
    values[0].norm_sqr() + odd(values).norm_sqr()
}

/// Re(s H_n)/|s| and Re(s H_-n)/|s| of the driven face on the axis.
fn powers(values: &[Complex64]) -> [f64; 2] {
    let (even, odd) = (values[0], odd(values));
    [-even.im - odd.re, -even.im + odd.re]
}

/// Sets the imaginary part of the offending waves of the driven face to `margin`; their real parts stay.
fn without_energy(values: &mut [Complex64], is_active: [bool; 2], margin: f64) {
    if values.len() <= 2 {
        values[0].im = margin;
        return;
    }
    // Im H_n and Im H_-n.
    let [forwards, backwards] = powers(values).map(|power| -power);
    let asked = |imaginary: f64, is_active: bool| if is_active { margin } else { imaginary };
    let [forwards, backwards] = [asked(forwards, is_active[0]), asked(backwards, is_active[1])];
    values[0].im = 0.5 * (forwards + backwards);
    values[2].re = 0.5 * (forwards - backwards);
}

/// Smallest Re(s H)/|s| of both waves, relative to the local scale of the errors, on every eighth rung and beyond the
/// band, and where; about poles beyond the band, too, where it is below minus the tolerance.
pub(super) fn least_power(sampled: &Sampled<'_>, models: &[PartialFractions]) -> (f64, Complex64) {
    let Ladder { checked, checked_parts, top, .. } = sampled.ladder;
    let even = models[0].evaluate_all(checked_parts);
    let odd = models.get(2).map(|model| model.evaluate_all(checked_parts));
    let relative = |value: Complex64, odd: Complex64| {
        (-value.im - odd.re.abs()) / sampled.local_scale(value.norm_sqr() + odd.norm_sqr())
    };
    let on_ladder = checked.iter().enumerate().map(|(k, &s)| {
        let odd = odd.as_ref().map_or(Complex64::ZERO, |odd| odd.get(k));
        (relative(even.get(k), odd), s)
    });
    let poles = models[0].poles.iter().filter(|pole| pole.im > *top);
    let beside = poles.flat_map(|pole| [-1.0, 0.0, 1.0].map(|widths| Complex64::new(0.0, pole.im + widths * pole.re)));
    let about_poles = beside.filter(|s| s.im > *top).map(|s| {
        let odd = models.get(2).map_or(Complex64::ZERO, |model| model.evaluate(s));
        (relative(models[0].evaluate(s), odd), s)
    });
    let tolerance = sampled.target.tolerance;
    let powers = on_ladder.chain(about_poles.filter(|(power, _)| *power < -tolerance));
    powers.fold((f64::INFINITY, Complex64::ZERO), |least, next| if next.0 < least.0 { next } else { least })
}
