//! Power spectrum of a uniformly sampled signal whose sum over frequency *is* the signal's mean square.
//!
//! Levels of bands are meaningful only if no energy is lost between them, so every step keeps the energy exactly:
//!
//! 1. The mean is removed; the rest has the mean square m. (The mean is known at the end only: see
//!    [`super::accumulator`], which takes the record sample by sample.)
//! 2. The record of N samples is cut into overlapping segments, J + 1 of them, h = N/J samples apart, weighted with w =
//!    cos(pi/2 (t - j h)/h), |t - j h| < h: neighbours' squares add to cos^2 + sin^2 = 1 at every sample, so the
//!    segments share the energy without loss and every segment starts and ends at zero (little leakage).
//! 3. The first and last segment reach half beyond the record. They are filled by reflection and count half. Reflection
//!    keeps the signal continuous but not its slope; the two kinks leak the same energy however the record is cut. In a
//!    record of 3 s a line at 100 Hz shows 26 dB down in the next band; a record of 12 s brings 6 dB more.
//! 4. Each segment is transformed; by Parseval's theorem the bins add up to the segment's energy.
//! 5. A bin k stands for the interval (k - 1/2, k + 1/2) df, cut at 0 and at the Nyquist frequency; its power is spread
//!    evenly over it. A band takes the share of its overlap, so bands that tile the axis share the power without loss,
//!    too.
//!
//! Resolution: the main lobe of w is 3 df wide (zeros at +-1.5 df), side lobes fall 12 dB per octave. A segment shorter
//! than the record averages (Welch 1967, Modified periodograms); a single pair (J = 1) keeps the finest resolution.
//!
//! Statistical error: of noise with the density S, the mean square E of a band over a record of T seconds has the
//! variance (1/T) integral S^2 df (Bendat & Piersol 2010, Random Data, section 8.5). The bins P_k of the record give an
//! estimate of it; the mean of P_k^2 is (1 + 1.2/J) times that of S^2, as neighbouring segments are correlated by
//! 1/pi^2. So the standard error in dB is 10/ln(10) sqrt(sum P_k^2/df/(T (1 + 1.2/J)))/E. Narrow resonances, which
//! leave a band few degrees of freedom, count by their squares; of a tone it is too large.
//!
//! Cost: four real FFTs per segment length of signal; memory: some segments, whatever the length of the record.

use std::f64::consts::TAU;
use std::ops::Range;

use num_complex::Complex64;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::band_gain::BandGain;
use super::third_octave::ThirdOctaveBand;
use crate::time_rule::TimeRule;

/// Errors of a spectrum.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum SpectrumError {
    /// Too few samples for a spectrum.
    #[error("a spectrum needs at least {needed} samples, the signal has {samples}")]
    TooShort {
        /// Number of samples given.
        samples: usize,
        /// Smallest number that is accepted.
        needed: usize,
    },
    /// A time step or segment length that is not a positive number.
    #[error("{quantity} must be a positive number of seconds, not {value}")]
    BadTime {
        /// Name of the quantity: time step or segment length.
        quantity: &'static str,
        /// The value given \[s\].
        value: f64,
    },
    /// NaN or infinity in the signal.
    #[error("sample {index} of the signal is {value}")]
    NotFinite {
        /// Index of the first such sample.
        index: usize,
        /// NaN or an infinity.
        value: f64,
    },
}

/// One-sided power spectrum of a real signal, its mean removed.
#[derive(Clone, Debug, PartialEq)]
pub struct PowerSpectrum {
    /// Mean of the signal, removed before anything else \[unit\].
    pub mean: f64,
    /// Distance df of neighbouring bins \[Hz\].
    pub resolution: f64,
    /// Power in each bin, before any gains \[unit^2\]; bin k lies at k df, the last at most at the Nyquist frequency.
    /// They sum to the mean square of the signal less its mean.
    pub power: Vec<f64>,
    /// Half the sampling rate \[Hz\].
    pub nyquist: f64,
    /// Highest frequency at which the signal is valid \[Hz\]; infinite unless set.
    pub valid_to: f64,
    /// T \[s\] and 1 + 1.2/J, by which standard errors follow from the bins; `None` if the power is not that of a
    /// record.
    pub averaged_over: Option<[f64; 2]>,
    /// Gains of its bands by which it was corrected, ascending; empty otherwise.
    pub(crate) gains: Vec<BandGain>,
    /// Transforms of the segments of the record, or of several records in turn, where they are kept.
    pub(crate) transforms: Vec<Vec<Complex64>>,
}

/// Level of one third-octave band.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub struct BandLevel {
    /// Band of the level.
    pub band: ThirdOctaveBand,
    /// Mean square in the band \[unit^2\].
    pub mean_square: f64,
    /// 10 lg(mean square / reference^2) \[dB\]; minus infinity for silence.
    pub level: f64,
    /// True if the band is resolved, at least two bins wide, and its mid-frequency is not above
    /// [`PowerSpectrum::valid_to`], but for the rounding of nominal frequencies.
    pub valid: bool,
}

impl PowerSpectrum {
    /// Spectrum of the given powers \[unit^2\] in bins at 0, `resolution`, ... \[Hz\], of which no record is known.
    pub fn of_powers(power: Vec<f64>, resolution: f64, nyquist: f64) -> Self {
        let (valid_to, gains, transforms) = (f64::INFINITY, Vec::new(), Vec::new());
        Self { mean: 0.0, resolution, power, nyquist, valid_to, averaged_over: None, gains, transforms }
    }

    /// Mean of spectra over the same frequencies; `None` of none. The means and limits are those of the first.
    pub(crate) fn mean_of<'a>(mut spectra: impl Iterator<Item = &'a Self>) -> Option<Self> {
        let (mut mean, mut count) = (spectra.next()?.clone(), 1.0);
        for spectrum in spectra {
            mean.power.iter_mut().zip(&spectrum.power).for_each(|(sum, power)| *sum += power);
            mean.transforms.extend_from_slice(&spectrum.transforms);
            count += 1.0;
        }
        mean.power.iter_mut().for_each(|power| *power /= count);
        Some(mean)
    }

    /// Averages spectra of several places, each with `points` points in turn, over the places: one spectrum per point.
    pub(crate) fn means(spectra: Vec<Self>, points: usize) -> Vec<Self> {
        if spectra.len() == points {
            return spectra;
        }
        (0..points).filter_map(|point| Self::mean_of(spectra.iter().skip(point).step_by(points))).collect()
    }

    /// The same spectrum, valid up to a frequency \[Hz\] only.
    #[must_use]
    pub fn valid_to(self, valid_to: f64) -> Self {
        Self { valid_to, ..self }
    }

    /// Spectrum of the signal before it was recorded through a response: every bin over the square of `response` at its
    /// frequency \[Hz\].
    #[must_use]
    pub fn without(mut self, response: impl Fn(f64) -> f64) -> Self {
        for (bin, power) in self.power.iter_mut().enumerate() {
            *power /= response(bin as f64 * self.resolution).powi(2);
        }
        self
    }

    /// Spectrum of forces of which each step's mean by a time rule was recorded: corrects for the low-pass of that
    /// mean.
    #[must_use]
    pub(crate) fn without_mean_of_steps(self, rule: TimeRule, time_step: f64) -> Self {
        self.without(|frequency| rule.mean_response(TAU * frequency * time_step))
    }

    /// Mean square of the signal less its mean: the total power \[unit^2\].
    pub fn mean_square(&self) -> f64 {
        if self.gains.is_empty() { self.power.iter().sum() } else { self.power_within(0.0..f64::INFINITY) }
    }

    /// Power between two frequencies \[Hz\], in unit^2; a bin that an edge cuts counts by its overlap. 0 for an empty
    /// range or NaN.
    pub fn power_within(&self, frequencies: Range<f64>) -> f64 {
        self.bins_within(frequencies).map(|(part, _)| part).sum()
    }

    /// Bins that some frequencies \[Hz\] overlap: the power of each within them, and all of its power.
    pub(super) fn bins_within(&self, frequencies: Range<f64>) -> impl Iterator<Item = (f64, f64)> + '_ {
        let (from, to) = (frequencies.start.max(0.0), frequencies.end.min(self.nyquist));
        let bins = if from < to {
            let first = (from / self.resolution + 0.5).floor() as usize;
            first..((to / self.resolution + 0.5).ceil() as usize + 1).min(self.power.len())
        } else {
            0..0
        };
        bins.map(move |k| {
            let bin = self.bin_interval(k);
            let inside = from.max(bin.start)..to.min(bin.end);
            let (overlap, power) = ((inside.end - inside.start).max(0.0), self.power[k] * self.gain_over(&inside));
            (power * overlap / (bin.end - bin.start), power)
        })
    }

    /// Standard error of the level of the sum of some bands \[dB\]; `None` for silence, or a spectrum that is not of a
    /// record.
    pub fn standard_error(&self, bands: impl IntoIterator<Item = ThirdOctaveBand>) -> Option<f64> {
        let [seconds, overlap] = self.averaged_over?;
        let (mut sum, mut variance) = (0.0, 0.0);
        for band in bands {
            let (mut of_band, mut squares) = (0.0, 0.0);
            for (part, whole) in self.bins_within(band.lower_edge()..band.upper_edge()) {
                of_band += part;
                squares += part * whole;
            }
            sum += of_band;
            variance += match self.gains.iter().find(|gain| gain.band == band) {
                Some(gain) => gain.variance * of_band * of_band,
                None => squares / (self.resolution * seconds * overlap),
            };
        }
        (sum > 0.0).then(|| 10.0 / std::f64::consts::LN_10 * variance.sqrt() / sum)
    }

    /// Takes gains of its bands, ascending, that levels, densities and sums have from now on.
    pub(crate) fn correct(&mut self, gains: &[BandGain]) {
        self.gains = gains.to_vec();
    }

    /// Mean gain over some frequencies \[Hz\]; beyond the outermost bands those of these.
    fn gain_over(&self, interval: &Range<f64>) -> f64 {
        let (Some(first), Some(last)) = (self.gains.first(), self.gains.last()) else { return 1.0 };
        let part = |from: f64, to: f64| (interval.end.min(to) - interval.start.max(from)).max(0.0);
        let inside = self.gains.iter().map(|gain| gain.gain * part(gain.band.lower_edge(), gain.band.upper_edge()));
        let below = first.gain * part(0.0, first.band.lower_edge());
        let above = last.gain * part(last.band.upper_edge(), f64::INFINITY);
        let length = interval.end - interval.start;
        if length > 0.0 { (inside.sum::<f64>() + below + above) / length } else { 1.0 }
    }

    /// Difference that the correction has made to the level of a band \[dB\]; `None` without one.
    pub(crate) fn correction(&self, band: ThirdOctaveBand) -> Option<f64> {
        self.gains.iter().find(|gain| gain.band == band).map(|gain| 10.0 * gain.gain.log10())
    }

    /// Third-octave levels re `reference` (1 N for forces) of all bands that lie whole between `lowest` \[Hz\] and the
    /// Nyquist frequency.
    pub fn third_octaves(&self, lowest: f64, reference: f64) -> Vec<BandLevel> {
        // A band that ends on the Nyquist frequency must not be lost to the rounding of 0.5/dt.
        ThirdOctaveBand::within(lowest..self.nyquist * (1.0 + 1e-12))
            .into_iter()
            .map(|band| {
                let mean_square = self.power_within(band.lower_edge()..band.upper_edge());
                let level = 10.0 * (mean_square / (reference * reference)).log10();
                let valid = band.is_valid_up_to(self.valid_to) && band.width() >= 2.0 * self.resolution;
                BandLevel { band, mean_square, level, valid }
            })
            .collect()
    }

    /// Narrow-band spectrum: frequency \[Hz\] and power spectral density \[unit^2/Hz\] of each bin.
    pub fn density(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.power.iter().enumerate().map(|(k, power)| {
            let bin = self.bin_interval(k);
            (k as f64 * self.resolution, power * self.gain_over(&bin) / (bin.end - bin.start))
        })
    }

    /// Interval of bin k \[Hz\]; the first and the last are half as wide.
    fn bin_interval(&self, k: usize) -> Range<f64> {
        let start = (k as f64 - 0.5).max(0.0) * self.resolution;
        let end = ((k as f64 + 0.5) * self.resolution).min(self.nyquist);
        start..end
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use proptest::prelude::*;
    use rand::RngExt;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use realfft::RealFftPlanner;
    use realfft::num_complex::Complex64;

    use super::*;

    fn noise(samples: usize, seed: u64) -> Vec<f64> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        (0..samples).map(|_| random.random_range(-1.0..1.0)).collect()
    }

    fn sine(amplitude: f64, frequency: f64, rate: f64, samples: usize) -> Vec<f64> {
        (0..samples).map(|n| amplitude * (TAU * frequency * n as f64 / rate + 0.3).sin()).collect()
    }

    fn mean_square(signal: &[f64]) -> f64 {
        let mean = signal.iter().sum::<f64>() / signal.len() as f64;
        signal.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / signal.len() as f64
    }

    fn decibel(ratio: f64) -> f64 {
        10.0 * ratio.log10()
    }

    /// Mean square of the part of the record between two frequencies, by one plain transform of the whole record.
    fn brick_wall(signal: &[f64], rate: f64, band: Range<f64>) -> f64 {
        let samples = signal.len();
        let transform = RealFftPlanner::<f64>::new().plan_fft_forward(samples);
        let mut input = signal.to_vec();
        let mut bins = vec![Complex64::default(); samples / 2 + 1];
        transform.process(&mut input, &mut bins).unwrap();
        let inside = |k: &usize| band.contains(&(*k as f64 * rate / samples as f64));
        (1..samples / 2).filter(inside).map(|k| 2.0 * bins[k].norm_sqr()).sum::<f64>() / (samples as f64).powi(2)
    }

    proptest! {
        #[test]
        fn nothing_is_lost_whatever_the_lengths(samples in 8usize..600, segment in 1e-4f64..2.0, seed: u64) {
            let signal = noise(samples, seed);
            for segment in [None, Some(segment)] {
                let spectrum = PowerSpectrum::of(&signal, 1e-3, segment).unwrap();
                let exact = mean_square(&signal);
                prop_assert!((spectrum.mean_square() / exact - 1.0).abs() < 1e-12);
                prop_assert!((spectrum.power_within(0.0..500.0) / exact - 1.0).abs() < 1e-12);
                let middle = 123.4;
                let parts = spectrum.power_within(0.0..middle) + spectrum.power_within(middle..1e9);
                prop_assert!((parts / exact - 1.0).abs() < 1e-12, "an edge inside a bin splits it");
                let integral: f64 = spectrum.density().map(|(_, density)| density).sum::<f64>();
                prop_assert!(integral.is_finite() && integral > 0.0);
            }
        }
    }

    #[test]
    fn bands_of_noise_sum_to_the_mean_square_over_the_covered_range() {
        let (rate, samples) = (20_000.0, 60_000);
        // Reddened noise with a mean, as forces are: most of the power at the low end, where the leakage would come
        // from.
        let mut state = 0.0;
        let signal: Vec<f64> = noise(samples, 7)
            .into_iter()
            .map(|x| {
                state = 0.98 * state + x;
                4000.0 + state
            })
            .collect();
        for segment in [None, Some(1.0), Some(0.25)] {
            let spectrum = PowerSpectrum::of(&signal, 1.0 / rate, segment).unwrap();
            let bands = spectrum.third_octaves(20.0, 1.0);
            let covered = bands[0].band.lower_edge()..bands[bands.len() - 1].band.upper_edge();
            let sum: f64 = bands.iter().map(|band| band.mean_square).sum();
            let difference = decibel(sum / brick_wall(&signal, rate, covered));
            assert!(difference.abs() < 0.1, "{segment:?}: {difference} dB");
            assert!((spectrum.mean - 4000.0).abs() < 2.0);
        }
    }

    #[test]
    fn levels_of_white_noise_rise_by_one_decibel_per_band() {
        let rate = 10_000.0;
        let spectrum = PowerSpectrum::of(&noise(400_000, 3), 1.0 / rate, Some(0.5)).unwrap();
        let expected = (1.0 / 3.0) / (rate / 2.0);
        for band in spectrum.third_octaves(90.0, 1.0) {
            let ratio = band.mean_square / (expected * band.band.width());
            // Standard deviation of a band's power: 1/sqrt(B T), B >= 23 Hz, T = 40 s: 0.14 dB; four of them.
            assert!(decibel(ratio).abs() < 0.6, "{}: {}", band.band.label(), decibel(ratio));
        }
    }

    /// Levels of noise through a narrow resonance scatter from seed to seed by their standard errors.
    #[test]
    fn levels_scatter_by_their_standard_errors() {
        const SEEDS: u64 = 60;
        let rate = 2000.0;
        let resonance = |seed: u64, samples: usize| -> Vec<f64> {
            // Two poles at 200 Hz, 6 Hz wide.
            let (radius, angle) = ((-TAU * 3.0 / rate).exp(), TAU * 200.0 / rate);
            let (mut last, mut before) = (0.0, 0.0);
            let filtered = noise(samples + 2000, seed).into_iter().map(|x| {
                let now = x + 2.0 * radius * angle.cos() * last - radius * radius * before;
                (before, last) = (last, now);
                now + 0.2 * x
            });
            filtered.skip(2000).collect()
        };
        for (seconds, segment) in [(0.6, 0.5), (3.0, 0.5), (3.0, 1.0)] {
            let spectra: Vec<PowerSpectrum> = (0..SEEDS)
                .map(|seed| PowerSpectrum::of(&resonance(seed, (seconds * rate) as usize), 1.0 / rate, Some(segment)))
                .map(Result::unwrap)
                .collect();
            for bands in [vec![-9], vec![-7], vec![-5], (-10..=-3).collect::<Vec<i32>>()] {
                let bands = || bands.iter().copied().map(ThirdOctaveBand);
                let sum = |spectrum: &PowerSpectrum| {
                    bands().map(|band| spectrum.power_within(band.lower_edge()..band.upper_edge())).sum::<f64>()
                };
                let levels: Vec<f64> = spectra.iter().map(|spectrum| decibel(sum(spectrum))).collect();
                let errors = spectra.iter().map(|spectrum| spectrum.standard_error(bands()).unwrap());
                let mean = levels.iter().sum::<f64>() / SEEDS as f64;
                let chi: f64 = levels.iter().zip(errors).map(|(level, error)| ((level - mean) / error).powi(2)).sum();
                println!("{seconds} s, {segment} s: chi^2 = {chi:.1}");
                // The range of 99.9 % for 59 degrees of freedom; levels in dB are skewed where errors are large.
                assert!((28.0..101.0).contains(&chi), "{seconds} s, {segment} s: chi^2 = {chi}");
            }
        }
        let silent = PowerSpectrum::of(&[1.0; 64], 1e-3, None).unwrap();
        assert_eq!(silent.standard_error([ThirdOctaveBand(-10)]), None);
    }

    #[test]
    fn a_sine_gives_its_level_in_its_band_and_silence_elsewhere() {
        let rate = 16_384.0;
        // What leaks comes from the kinks of the two reflected ends: so much energy per record, whatever its segments,
        // that is 6 dB less in four times the length. A class 1 filter of the standard need not do better than 17 dB.
        for (samples, segment, bound) in
            [(49_153, None, -26.0), (49_153, Some(1.0), -26.0), (4 * 49_153, Some(1.0), -32.0)]
        {
            for n in -10..=7 {
                let band = ThirdOctaveBand(n);
                let signal = sine(2.0, band.mid_frequency(), rate, samples);
                let levels = PowerSpectrum::of(&signal, 1.0 / rate, segment).unwrap().third_octaves(50.0, 1.0);
                for level in levels {
                    if level.band == band {
                        assert!((level.level - decibel(2.0)).abs() < 0.05, "{}: {}", band.label(), level.level);
                    } else {
                        let leak = level.level - decibel(2.0);
                        assert!(leak < bound, "{} leaks {leak} dB into {}", band.label(), level.band.label());
                    }
                }
            }
        }
    }

    #[test]
    fn a_sine_on_an_edge_is_shared_evenly() {
        let band = ThirdOctaveBand(0);
        let signal = sine(1.0, band.upper_edge(), 10_000.0, 30_000);
        let spectrum = PowerSpectrum::of(&signal, 1e-4, Some(1.0)).unwrap();
        let lower = spectrum.power_within(band.lower_edge()..band.upper_edge());
        let upper = spectrum.power_within(band.upper_edge()..ThirdOctaveBand(1).upper_edge());
        assert!((decibel((lower + upper) / 0.5)).abs() < 0.01, "together {}", lower + upper);
        // The share depends on where the edge falls within its bin; a third each is the worst case of a three-bin lobe.
        assert!(lower > 0.12 && upper > 0.12, "{lower} {upper}");
    }

    #[test]
    fn a_step_between_the_ends_does_not_leak_into_high_bands() {
        // A slow ramp of 1000 N: a plain transform would see a step of 1000 N once per record.
        let signal: Vec<f64> = (0..30_000).map(|n| f64::from(n) / 30.0).collect();
        let levels = PowerSpectrum::of(&signal, 1e-4, Some(1.0)).unwrap().third_octaves(900.0, 1.0);
        assert!(levels.iter().all(|level| level.level < -25.0), "{levels:?}");
    }

    #[test]
    fn bands_narrower_than_two_bins_are_not_valid() {
        let lowest_valid = |seconds: f64| {
            let signal = noise((1e4 * seconds) as usize, 3);
            let levels = PowerSpectrum::of(&signal, 1e-4, Some(0.5)).unwrap().third_octaves(22.0, 1.0);
            assert!(levels.iter().skip_while(|level| !level.valid).all(|level| level.valid));
            levels.iter().find(|level| level.valid).map(|level| level.band.nominal_frequency())
        };
        assert_eq!([0.02, 0.1, 1.0].map(lowest_valid), [Some(250.0), Some(50.0), Some(25.0)]);
    }

    #[test]
    fn bad_input_is_named() {
        let good = vec![0.0; 16];
        assert_eq!(PowerSpectrum::of(&good[..7], 1e-3, None), Err(SpectrumError::TooShort { samples: 7, needed: 8 }));
        assert!(matches!(PowerSpectrum::of(&good, 0.0, None), Err(SpectrumError::BadTime { .. })));
        assert!(matches!(PowerSpectrum::of(&good, 1e-3, Some(f64::NAN)), Err(SpectrumError::BadTime { .. })));
        let mut bad = good.clone();
        bad[3] = f64::NAN;
        assert!(matches!(PowerSpectrum::of(&bad, 1e-3, None), Err(SpectrumError::NotFinite { index: 3, .. })));
        let silent = PowerSpectrum::of(&good, 1e-3, None).unwrap();
        assert!(silent.third_octaves(100.0, 1.0).iter().all(|band| band.level == f64::NEG_INFINITY));
        assert!(PowerSpectrum::of(&good, 1e-3, None).unwrap().power_within(f64::NAN..3.0) <= 0.0);
    }
}
