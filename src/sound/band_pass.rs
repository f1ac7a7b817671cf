//! A signal restricted to a band of frequencies, for sound files and the levels that are read from them.
//!
//! The whole signal is transformed, multiplied and transformed back. Between the band's edges nothing but given gains
//! of third octaves changes it; beyond them a raised cosine falls to zero over a tenth below and a fiftieth above,
//! which rings for some periods there.
//! Cost: two transforms of the signal's length.

use std::ops::Range;

use realfft::RealFftPlanner;

use crate::numeric::transform_length;
use crate::response::{BandGain, gain_at};

/// Widths of the flanks, relative to the lower and the upper edge.
const FALLS: [f64; 2] = [0.1, 0.02];
/// Silence behind the signal, so that its end does not ring into its beginning \[s\].
const SILENCE: f64 = 0.2;

/// Part of a signal, sampled at `rate` \[Hz\], between two frequencies \[Hz\], with the gains of its bands.
pub(crate) fn band_pass(signal: &[f64], rate: f64, band: &Range<f64>, gains: &[BandGain]) -> Vec<f64> {
    let length = transform_length(signal.len() + (SILENCE * rate) as usize);
    let mut planner = RealFftPlanner::new();
    let (forward, backward) = (planner.plan_fft_forward(length), planner.plan_fft_inverse(length));
    let mut series = forward.make_input_vec();
    series[..signal.len()].copy_from_slice(signal);
    let mut lines = forward.make_output_vec();
    // The only error is a wrong length; all have the planned length, and the first and the last bin stay real.
    let transformed = forward.process(&mut series, &mut lines);
    debug_assert!(transformed.is_ok());
    for (line, value) in lines.iter_mut().enumerate() {
        let frequency = line as f64 * rate / length as f64;
        *value *= gain(frequency, band) * gain_at(gains, frequency) / length as f64;
    }
    let transformed = backward.process(&mut lines, &mut series);
    debug_assert!(transformed.is_ok());
    series.truncate(signal.len());
    series
}

fn gain(frequency: f64, band: &Range<f64>) -> f64 {
    let below = (band.start - frequency) / (FALLS[0] * band.start);
    let above = (frequency - band.end) / (FALLS[1] * band.end);
    0.5 * (1.0 + (std::f64::consts::PI * below.max(above).clamp(0.0, 1.0)).cos())
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    #[test]
    fn tones_within_a_band_stay_and_those_beyond_are_gone() {
        let rate = 48_000.0;
        let band = 22.4..2239.0;
        for (frequency, gain) in [(25.0, 1.0), (1000.0, 1.0), (2230.0, 1.0), (2300.0, 0.0), (5000.0, 0.0), (19.0, 0.0)]
        {
            let tone: Vec<f64> = (0..60_000).map(|n| (TAU * frequency * f64::from(n) / rate).sin()).collect();
            let found = band_pass(&tone, rate, &band, &[]);
            assert_eq!(found.len(), tone.len());
            // Away from the ends, where the tone begins and ends.
            let error = (20_000..40_000).map(|n| (found[n] - gain * tone[n]).abs()).fold(0.0, f64::max);
            assert!(error < 0.01, "{frequency} Hz: {error}");
        }
    }
}
