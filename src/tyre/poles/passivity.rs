//! Passivity of a model: Re(s H(s)) >= 0 on the axis, within the band and beyond it.

use num_complex::Complex64;

use super::sampled::{Candidate, Sampled};
use crate::numeric::rational::PartialFractions;

/// Rounds of mending.
const MENDING_ROUNDS: usize = 8;

/// Mends a model that generates energy: its residues are refitted with the offending points as further samples, where
/// the model is asked for its own real part and no energy. Most offences lie beyond the band, where nothing else
/// determines it. Only what stays within the tolerance is taken.
pub fn passive(sampled: &Sampled<'_>, mut candidate: Candidate) -> Candidate {
    let tolerance = sampled.target.tolerance;
    let mut samples = sampled.samples(true);
    for _ in 0..MENDING_ROUNDS {
        let models = &candidate.models;
        let (least, s) = least_power(sampled, &models[0]);
        if least >= 0.0 {
            break;
        }
        for s in [s * 0.93, s, s * 1.07] {
            samples.points.push(s);
            samples.point_weights.push(sampled.point_weight(models[0].evaluate(s)));
            for (face, (response, model)) in samples.responses.iter_mut().zip(models).enumerate() {
                let value = model.evaluate(s);
                let margin = -0.5 * tolerance * sampled.local_scale(value);
                response.push(if face == 0 { Complex64::new(value.re, margin) } else { value });
            }
        }
        match sampled.candidate(&samples, candidate.poles.clone()) {
            Ok(mended) if mended.errors.largest() <= tolerance => candidate = mended,
            _ => break,
        }
    }
    candidate
}

/// Smallest Re(s H)/|s|, relative to the local scale of the errors, on every eighth rung and beyond the band, and
/// where.
pub fn least_power(sampled: &Sampled<'_>, model: &PartialFractions) -> (f64, Complex64) {
    let checked = &sampled.ladder.checked;
    let values = model.evaluate_all(&sampled.ladder.checked_parts);
    checked
        .iter()
        .enumerate()
        .map(|(k, &s)| {
            let value = values.get(k);
            (-value.im / sampled.local_scale(value), s)
        })
        .fold((f64::INFINITY, Complex64::ZERO), |least, next| if next.0 < least.0 { next } else { least })
}
