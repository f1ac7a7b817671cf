//! Looking at influence functions: over distance and time, at rest, and whether they answer before they are asked.
//!
//! Causality. H(sigma + i w) is sampled on a line right of the imaginary axis, damped at high frequencies by a Gaussian window, and transformed to time. A causal response is nothing
//! before t = 0, up to the window's own width, which is left out, and what wraps round, which is exp(-sigma T). Setting the part before t = 0 to zero and transforming back is the
//! discrete Kramers-Kronig relation: its residual is the root of the energy before t = 0 over all energy.

use std::f64::consts::PI;

use num_complex::Complex64;
use rayon::prelude::*;
use realfft::RealFftPlanner;

use super::influence::{Field, InfluenceSum};
use super::rational::RationalModel;

/// Response before and after t = 0.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Causality {
    /// Root of the energy before t = 0 over all energy: the Kramers-Kronig residual.
    pub residual: f64,
    /// Largest value before t = 0 over the largest of all.
    pub precursor: f64,
}

/// Samples of the line, and its length in periods of the highest frequency.
const SAMPLES: usize = 8192;
/// exp(-sigma T): what wraps round.
const WRAPPED: f64 = 1e-9;
/// Standard deviation of the window, as a share of the highest frequency.
const WINDOW: f64 = 0.2;

/// Causality of a function of s up to a highest frequency \[Hz\].
pub fn causality(function: impl Fn(Complex64) -> Complex64 + Sync, highest: f64) -> Causality {
    let step = 0.5 / highest;
    let sigma = -WRAPPED.ln() / (SAMPLES as f64 * step);
    let spectrum: Vec<Complex64> = (0..=SAMPLES / 2)
        .into_par_iter()
        .map(|k| {
            let frequency = highest * k as f64 / (SAMPLES / 2) as f64;
            let window = (-0.5 * (frequency / (WINDOW * highest)).powi(2)).exp();
            let value = function(Complex64::new(sigma, 2.0 * PI * frequency)) * window;
            if k == 0 || k == SAMPLES / 2 { Complex64::new(value.re, 0.0) } else { value }
        })
        .collect();
    let inverse = RealFftPlanner::<f64>::new().plan_fft_inverse(SAMPLES);
    let (mut spectrum, mut signal) = (spectrum, inverse.make_output_vec());
    // Planned lengths, real at both ends: nothing to refuse.
    let _ = inverse.process(&mut spectrum, &mut signal);
    // The window is exp(-t^2 (2 pi WINDOW highest)^2/2) wide in time: past seven deviations it is below rounding.
    let width = (7.0 / (2.0 * PI * WINDOW * highest) / step).ceil() as usize;
    let before = &signal[SAMPLES / 2..SAMPLES - width];
    let energy = |values: &[f64]| values.iter().map(|value| value * value).sum::<f64>();
    let largest = |values: &[f64]| values.iter().fold(0.0_f64, |a, &b| a.max(b.abs()));
    Causality { residual: (energy(before) / energy(&signal)).sqrt(), precursor: largest(before) / largest(&signal) }
}

/// g of the element j further on at time t > 0, by the poles of a model: rows by time, columns j = 0..N \[m/(N s)\].
pub fn impulse_response(model: &RationalModel, field: Field, times: &[f64]) -> Option<Vec<Vec<f64>>> {
    let inverse = RealFftPlanner::<f64>::new().plan_fft_inverse(model.elements);
    times
        .par_iter()
        .map(|&t| {
            let mut spectrum = inverse.make_input_vec();
            for (n, entry) in spectrum.iter_mut().enumerate() {
                let modes = model.modes(n, field)?;
                let sum: f64 = modes
                    .poles
                    .iter()
                    .zip(modes.residues)
                    .enumerate()
                    .map(|(index, (&pole, &residue))| {
                        (residue * (pole * t).exp()).re * if index < modes.pairs { 2.0 } else { 1.0 }
                    })
                    .sum();
                *entry = sum.into();
            }
            let mut row = inverse.make_output_vec();
            let _ = inverse.process(&mut spectrum, &mut row);
            Some(row)
        })
        .collect()
}

/// Static influence of the element j further on, j = 0..N \[m/N\].
pub fn static_row(sum: &InfluenceSum, field: Field) -> Vec<f64> {
    let elements = sum.projection().elements;
    let inverse = RealFftPlanner::<f64>::new().plan_fft_inverse(elements);
    let at_rest = sum.at(Complex64::ZERO);
    let mut spectrum: Vec<Complex64> =
        (0..=elements / 2).map(|n| sum.value(n, &at_rest, field).value.re.into()).collect();
    let mut row = inverse.make_output_vec();
    let _ = inverse.process(&mut spectrum, &mut row);
    row
}

/// Driving-point mobility of one element, s sum_n Ht_n(s), from a value per wavenumber \[m/(N s)\].
pub fn element_mobility(elements: usize, s: Complex64, value: impl Fn(usize) -> Complex64) -> Complex64 {
    let sum: Complex64 =
        (0..=elements / 2).map(|n| value(n) * if n == 0 || n == elements / 2 { 1.0 } else { 2.0 }).sum();
    s * sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_damped_oscillator_is_causal_and_its_hysteretic_cousin_is_not() {
        let oscillator = |s: Complex64| (s * s + s * 200.0 + 4e6).inv();
        let causal = causality(oscillator, 5e3);
        assert!(causal.residual < 1e-7 && causal.precursor < 1e-7, "{causal:?}");
        // Structural damping k (1 + i eta): the textbook case of an answer before the question (Crandall 1970).
        let hysteretic = |s: Complex64| (s * s + 4e6 * Complex64::new(1.0, 0.2 * s.im.signum())).inv();
        let precursor = causality(hysteretic, 5e3);
        assert!(precursor.residual > 1e-3 && precursor.precursor > 1e-3, "{precursor:?}");
    }
}
