//! A pressure resampled from the rate of a run to that of a sound file.
//!
//! Band-limited interpolation by a Kaiser-windowed sinc ([`WindowedSinc`]): flat to 0.45 of the lower of both rates,
//! 100 dB down from 0.55 of it on. Between 0.45 and 0.5, where a run is no longer valid, a tone fades and its image
//! above the old Nyquist frequency appears.
//!
//! Measured from 5.8 to 48 kHz: a tone below 0.45 of the rate has an error of at most 1.4e-5 of its amplitude (-97 dB),
//! images included. Cost: 66 multiplications and additions per output sample, more by the ratio where the rate is
//! lowered.

use std::sync::LazyLock;

use crate::numeric::windowed_sinc::{Phases, WindowedSinc};

/// Sampling rate of sound files \[Hz\].
pub(crate) const FILE_RATE: f64 = 48_000.0;

/// Interpolation kernel.
static KERNEL: LazyLock<WindowedSinc> = LazyLock::new(|| WindowedSinc::new(0.45, 0.55, 100.0));
/// The kernel as a table, for rates that are not lowered. Linear interpolation between its entries is exact to 2e-7 of
/// the peak.
static PHASES: LazyLock<Phases<f64>> = LazyLock::new(|| Phases::new(&KERNEL, 2048, |weight| weight));

/// Half the kernel's width in samples of the lower rate.
pub(super) fn half_width() -> f64 {
    KERNEL.half_width
}

/// Resamples a signal from `rate` to `new_rate` samples a second (both > 0), from the same first instant on and not
/// beyond its last sample. Before its first and after its last sample the signal counts as 0: it fades in and out over
/// half the kernel's width, 33 samples of the lower rate.
pub(crate) fn resample(signal: &[f64], rate: f64, new_rate: f64) -> Vec<f64> {
    let Some(last) = signal.len().checked_sub(1) else {
        return Vec::new();
    };
    let step = rate / new_rate;
    // The last sample counts where it falls on a new sample up to rounding.
    let count = (last as f64 / step + 1e-9).floor() as usize + 1;
    let mut weights = Vec::new();
    (0..count).map(|n| weighted(signal, 0, n as f64 * step, step, &mut weights)).collect()
}

/// Interpolates a signal at `position`, counted in samples, where the first sample of `signal` has the index `first`;
/// outside its samples the signal is 0. `ratio` is the rate of the signal over the new rate.
pub(super) fn weighted(signal: &[f64], first: i64, position: f64, ratio: f64, weights: &mut Vec<f64>) -> f64 {
    let from = if ratio > 1.0 {
        KERNEL.weights(position, ratio, weights)
    } else {
        weights.clear();
        weights.extend(PHASES.weights(position));
        position.floor() as i64 - PHASES.reach() as i64 + 1
    } - first;
    let skipped = usize::try_from(-from).unwrap_or(0).min(weights.len());
    let begin = usize::try_from(from).unwrap_or(0).min(signal.len());
    dot(&weights[skipped..], &signal[begin..])
}

/// Sum of products over the shorter of both lengths, as eight parallel sums, so that no addition waits for the previous
/// one.
fn dot(weights: &[f64], signal: &[f64]) -> f64 {
    let count = weights.len().min(signal.len());
    let (by_eight, rest) = weights[..count].as_chunks::<8>();
    let (signal_by_eight, signal_rest) = signal[..count].as_chunks::<8>();
    let mut sums = [0.0; 8];
    for (weights, signal) in by_eight.iter().zip(signal_by_eight) {
        for lane in 0..8 {
            sums[lane] += weights[lane] * signal[lane];
        }
    }
    let rest: f64 = rest.iter().zip(signal_rest).map(|(weight, sample)| weight * sample).sum();
    sums.iter().sum::<f64>() + rest
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    const RATE: f64 = 5812.3;

    fn tone(frequency: f64, rate: f64, samples: usize) -> Vec<f64> {
        (0..samples).map(|n| (TAU * frequency * n as f64 / rate + 0.4).sin()).collect()
    }

    /// Largest difference from the exact tone, except within the kernel's width of the ends.
    fn error(frequency: f64, rate: f64, new_rate: f64) -> f64 {
        let samples = (2000.0 * (rate / new_rate).max(1.0)) as usize;
        let found = resample(&tone(frequency, rate, samples), rate, new_rate);
        let exact = tone(frequency, new_rate, found.len());
        let margin = (40.0 * new_rate / rate.min(new_rate)) as usize;
        let inside = margin..found.len() - margin;
        assert!(inside.len() > 500);
        found[inside.clone()].iter().zip(&exact[inside]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn tones_come_back_with_the_stated_error() {
        for part in [0.003, 0.1, 0.2, 0.3, 0.4, 0.43, 0.45] {
            let up = error(part * RATE, RATE, FILE_RATE);
            assert!(up < 1.4e-5, "{part} of the rate: {up}");
            let down = error(part * RATE, FILE_RATE, RATE);
            assert!(down < 1.4e-5, "{part} of the new rate: {down}");
        }
        assert!(error(0.5 * RATE, RATE, FILE_RATE) > 0.1, "a tone at the Nyquist frequency is lost");
    }

    #[test]
    fn what_the_lower_rate_cannot_carry_is_gone() {
        let signal = tone(0.6 * RATE, FILE_RATE, 48_000);
        let found = resample(&signal, FILE_RATE, RATE);
        let residual = found[40..found.len() - 40].iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        assert!(residual < 2e-5, "{residual}");
    }

    #[test]
    fn lengths_fit_and_the_same_rate_changes_nothing() {
        let signal = tone(100.0, RATE, 500);
        let same = resample(&signal, RATE, RATE);
        assert_eq!(same.len(), 500);
        assert!(same.iter().zip(&signal).skip(40).take(420).all(|(a, b)| (a - b).abs() < 1e-5));
        assert_eq!(resample(&signal, 12_000.0, 48_000.0).len(), 4 * 499 + 1);
        assert_eq!(resample(&signal[..1], 6000.0, 48_000.0).len(), 1);
        assert!(resample(&[], RATE, FILE_RATE).is_empty());
    }
}
