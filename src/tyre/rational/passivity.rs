//! Passivity of a model: Re(s H(s)) >= 0 on the axis, within the band and beyond it.

use num_complex::Complex64;

use super::ladder::RUNGS;
use super::sampled::{Errors, Sampled};
use super::wavenumber::Target;
use crate::numeric::rational::PartialFractions;
use crate::numeric::rational::vector_fitting::residues;

/// Points beyond the band where passivity is checked: factors of sqrt(2) above the top.
const BEYOND: usize = 20;
/// Rounds of mending.
const MENDING_ROUNDS: usize = 8;

/// Mends a model that generates energy: its residues are refitted with the offending points as further samples, where the model is asked for its own real part and no
/// energy. Most offences lie beyond the band, where nothing else determines it. Only what stays within the tolerance is taken.
pub fn passive(
    sampled: &Sampled<'_>,
    target: &Target,
    poles: &[Complex64],
    mut models: Vec<PartialFractions>,
    mut errors: Errors,
) -> (Vec<PartialFractions>, Errors) {
    let mut samples = sampled.samples(true);
    for _ in 0..MENDING_ROUNDS {
        let (least, s) = least_power(sampled, &models[0]);
        if least >= 0.0 {
            break;
        }
        for s in [s * 0.93, s, s * 1.07] {
            samples.points.push(s);
            samples.point_weights.push(sampled.point_weight(models[0].evaluate(s)));
            for (face, (response, model)) in samples.responses.iter_mut().zip(&models).enumerate() {
                let value = model.evaluate(s);
                let margin = -0.5 * target.tolerance * sampled.local_scale(value);
                response.push(if face == 0 { Complex64::new(value.re, margin) } else { value });
            }
        }
        let Ok(mended) = residues(&samples, poles, target.constant) else { break };
        let new = sampled.errors(&mended);
        if new.largest() > target.tolerance {
            break;
        }
        (models, errors) = (mended, new);
    }
    (models, errors)
}

/// Smallest Re(s H)/|s|, relative to the local scale of the errors, on every eighth rung and beyond the band, and where.
pub fn least_power(sampled: &Sampled<'_>, model: &PartialFractions) -> (f64, Complex64) {
    let top = sampled.ladder.axis[RUNGS].im;
    let beyond = (1..=BEYOND).map(|i| Complex64::new(0.0, top * 2f64.powf(0.5 * i as f64)));
    let inside = sampled.ladder.axis.iter().skip(4).step_by(8).copied();
    inside
        .chain(beyond)
        .map(|s| {
            let value = model.evaluate(s);
            (-value.im / sampled.local_scale(value), s)
        })
        .fold((f64::INFINITY, Complex64::ZERO), |least, next| if next.0 < least.0 { next } else { least })
}
