//! The averaged spectrum of a record that is fed sample by sample: memory does not grow with its length.
//!
//! Segments and window are those of [`super::spectrum`]. At any time two segments are open; one that no later sample
//! can reach is transformed and added. The mean m is known at the end only, so the differences from the first sample
//! x_0 are transformed, and with them, for each segment, the window alone: with X and W the two transforms and d = m -
//! x_0, the segment without its mean is
//!
//! ```text
//! |X - d W|^2 = |X|^2 - 2 d Re(X conj W) + d^2 |W|^2
//! ```
//!
//! so three sums per bin suffice. d is of the size of the signal's variation: nothing is lost by cancellation. All
//! sums run in the order of time: the same record gives the same bits.
//!
//! [`SpectrumAccumulator::faded`] is for spectra that span many decades, such as those of sound: a record that is
//! reflected at its ends has a kink there, which leaks some -55 dB of 8 s of a loud band into bands far below it. There
//! the record fades in and out instead, and fades and segments have the slope
//!
//! ```text
//! r(x) = sin(pi/2 sin^2(pi/2 x)),  0 < x < 1,  r(x)^2 + r(1 - x)^2 = 1
//! ```
//!
//! whose side lobes fall by 18 dB per octave. Neighbouring segments still share the power without loss; a sample of a
//! fade counts r^2.

use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use num_complex::Complex64;
use realfft::{RealFftPlanner, RealToComplex};

use super::spectrum::{PowerSpectrum, SpectrumError};
use crate::numeric::{RunningMoments, transform_length};
use crate::storage::state::{Evolving, StateError, StateStream, ensure};

pub(crate) const FEWEST_SAMPLES: usize = 8;

/// Averaged spectrum of a record of known length, fed sample by sample.
#[derive(Clone)]
pub struct SpectrumAccumulator {
    samples: u64,
    time_step: f64,
    /// Number J of hops: segments 0..=J.
    hops: u64,
    /// Samples h from one segment's centre to the next; not whole.
    hop: f64,
    /// Samples over which the record fades in and out; 0 where it is reflected.
    fade: u64,
    transform: Arc<dyn RealToComplex<f64>>,
    moments: RunningMoments,
    not_finite: Option<(u64, f64)>,
    /// Number of the first open segment; the second is the next.
    open: u64,
    /// The two open segments, weighted.
    segments: [Vec<f64>; 2],
    /// |X|^2, Re(X conj W) and |W|^2 by bin.
    sums: [Vec<f64>; 3],
    /// X of every segment, where they are kept.
    transforms: Option<Vec<Vec<Complex64>>>,
}

impl PowerSpectrum {
    /// The spectrum of `signal`, sampled every `time_step` seconds, from segments 2h of about `segment` seconds (cut to
    /// the record; `None`: the whole record at once).
    ///
    /// # Errors
    /// Fewer than 8 samples, a time that is not positive and finite, a sample that is not finite.
    pub fn of(signal: &[f64], time_step: f64, segment: Option<f64>) -> Result<Self, SpectrumError> {
        let mut accumulator = SpectrumAccumulator::new(signal.len(), time_step, segment)?;
        signal.iter().for_each(|&value| accumulator.push(value));
        accumulator.finish()
    }
}

impl SpectrumAccumulator {
    /// For a record of `samples` samples, `time_step` seconds apart; segments as for [`PowerSpectrum::of`].
    ///
    /// # Errors
    /// [`SpectrumError::TooShort`], [`SpectrumError::BadTime`].
    pub fn new(samples: usize, time_step: f64, segment: Option<f64>) -> Result<Self, SpectrumError> {
        if samples < FEWEST_SAMPLES {
            return Err(SpectrumError::TooShort { samples, needed: FEWEST_SAMPLES });
        }
        for (quantity, value) in [("the time step", time_step), ("the segment length", segment.unwrap_or(1.0))] {
            if !(value.is_finite() && value > 0.0) {
                return Err(SpectrumError::BadTime { quantity, value });
            }
        }
        let longest_segment = 2.0 * samples as f64;
        let wanted = segment
            .map_or(longest_segment, |seconds| (seconds / time_step).clamp(FEWEST_SAMPLES as f64, longest_segment));
        let hops = ((longest_segment / wanted).round() as u64).max(1);
        let hop = samples as f64 / hops as f64;
        let this = Self {
            samples: samples as u64,
            time_step,
            hops,
            hop,
            fade: 0,
            transform: RealFftPlanner::<f64>::new().plan_fft_forward(2),
            moments: RunningMoments::default(),
            not_finite: None,
            open: 0,
            segments: Default::default(),
            sums: Default::default(),
            transforms: None,
        };
        Ok(this.in_lengths(1))
    }

    /// The same accumulator, whose transforms have a length that is a multiple of `multiple`: fast to transform, with
    /// zeros in the tail, which change no energy.
    fn in_lengths(self, multiple: usize) -> Self {
        let length = multiple * transform_length((2.0 * self.hop / multiple as f64).ceil() as usize + 2);
        let sum = vec![0.0; length / 2 + 1];
        Self {
            transform: RealFftPlanner::<f64>::new().plan_fft_forward(length),
            segments: [vec![0.0; length], vec![0.0; length]],
            sums: [sum.clone(), sum.clone(), sum],
            ..self
        }
    }

    /// Keeps the transforms of all segments, where `multiple` is given: of records with the same times and sampling
    /// rates in the ratio of their multiples they have the same resolution.
    #[must_use]
    pub(crate) fn keeping(self, multiple: Option<usize>) -> Self {
        let Some(multiple) = multiple else { return self };
        Self { transforms: Some(Vec::new()), ..self.in_lengths(multiple) }
    }

    /// As [`Self::new`], for a record that fades in and out over `fade` seconds, or a quarter of its length if that is
    /// less.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn faded(samples: usize, time_step: f64, segment: f64, fade: f64) -> Result<Self, SpectrumError> {
        let accumulator = Self::new(samples, time_step, Some(segment))?;
        Ok(Self { fade: ((fade / time_step) as u64).clamp(1, accumulator.samples / 4), ..accumulator })
    }

    /// Memory \[bytes\] of an accumulator with segments of `segment` seconds, and of its spectrum.
    pub fn bytes(time_step: f64, segment: f64) -> f64 {
        // Two segments, three sums and the power of half as many bins.
        8.0 * (2.0 + 2.0) * segment / time_step
    }

    /// Memory \[bytes\] of the transforms of a record of `samples` samples that are kept, and of those of its spectrum.
    pub(crate) fn bytes_of_transforms(samples: usize) -> f64 {
        // Every sample is in two segments, and reflected ones with it; there are half as many bins.
        2.0 * 2.0 * 16.0 * samples as f64
    }

    /// Takes the next sample; samples past the record's length are ignored.
    pub fn push(&mut self, value: f64) {
        let index = self.moments.count();
        if index >= self.samples {
            return;
        }
        if !value.is_finite() && self.not_finite.is_none() {
            self.not_finite = Some((index, value));
        }
        self.moments.push(value);
        let shifted = value - self.moments.shift;
        let index = index as i64;
        // 1. Close the segments that no later sample reaches.
        while self.distance(index, self.open) >= 1.0 && self.open < self.hops {
            self.close();
        }
        // 2. Add the sample, and its mirror image at a reflected end, to the open segments.
        let last = 2 * self.samples as i64 - 1 - index;
        for segment in self.open..=(self.open + 1).min(self.hops) {
            self.add(segment, index, shifted);
            if self.fade > 0 {
                continue;
            }
            // The record continues as its mirror image at either end.
            if segment == 0 {
                self.add(segment, -1 - index, shifted);
            }
            if segment == self.hops {
                self.add(segment, last, shifted);
            }
        }
    }

    /// The spectrum of the whole record.
    ///
    /// # Errors
    /// [`SpectrumError::TooShort`] before the last sample, [`SpectrumError::NotFinite`] with the first sample that is
    /// not finite.
    pub fn finish(mut self) -> Result<PowerSpectrum, SpectrumError> {
        let count = self.moments.count();
        if count < self.samples {
            return Err(SpectrumError::TooShort { samples: count as usize, needed: self.samples as usize });
        }
        if let Some((index, value)) = self.not_finite {
            return Err(SpectrumError::NotFinite { index: index as usize, value });
        }
        while self.open <= self.hops {
            self.close();
        }
        let offset = self.moments.mean_of_shifted();
        let length = self.segments[0].len() as f64;
        // Parseval: sum_n x_n^2 = (1/length) sum over all bins; every bin but the first and the last (even length) is
        // there twice.
        // The squares of both fades add up to half their lengths.
        let scale = 1.0 / (length * (self.samples - self.fade) as f64);
        let last = self.sums[0].len() - 1;
        let [squares, crosses, windows] = &self.sums;
        let bins = squares.iter().zip(crosses).zip(windows).enumerate();
        let power = bins.map(|(k, ((square, cross), window))| {
            let twice = if k == 0 || k == last { scale } else { 2.0 * scale };
            twice * (square - 2.0 * offset * cross + offset * offset * window).max(0.0)
        });
        Ok(PowerSpectrum {
            mean: self.moments.mean().unwrap_or(0.0),
            resolution: 1.0 / (length * self.time_step),
            power: power.collect(),
            nyquist: 0.5 / self.time_step,
            valid_to: f64::INFINITY,
            averaged_over: Some([(self.samples - self.fade) as f64 * self.time_step, 1.0 + 1.2 / self.hops as f64]),
            gains: Vec::new(),
            transforms: self.transforms.unwrap_or_default(),
        })
    }

    /// Distance of a sample from a segment's centre, in hops. Sample n sits in the middle of its interval (n, n + 1),
    /// so that both ends of the record are alike.
    fn distance(&self, index: i64, segment: u64) -> f64 {
        (index as f64 + 0.5 - segment as f64 * self.hop) / self.hop
    }

    /// Index of the first sample of a segment's buffer; negative where the segment reaches before the record.
    fn begin(&self, segment: u64) -> i64 {
        (segment as f64 * self.hop - self.hop).floor() as i64
    }

    /// Weight of a sample in a segment: the window, and the fade of the record.
    fn weight(&self, index: i64, segment: u64) -> f64 {
        let distance = self.distance(index, segment);
        if self.fade == 0 {
            return weight(distance);
        }
        let from_end = index.min(self.samples as i64 - 1 - index) as f64 + 0.5;
        slope(1.0 - distance.abs()) * slope(from_end / self.fade as f64)
    }

    fn add(&mut self, segment: u64, index: i64, value: f64) {
        let weight = self.weight(index, segment);
        let place = usize::try_from(index - self.begin(segment)).ok();
        if let Some(cell) = place.and_then(|place| self.segments[(segment - self.open) as usize].get_mut(place))
            && weight > 0.0
        {
            *cell = weight * value;
        }
    }

    /// Adds the first open segment to the sums and opens the next.
    fn close(&mut self) {
        // 1. The window by sample of the buffer.
        let begin = self.begin(self.open);
        let places = 0..self.segments[0].len() as i64;
        let mut window: Vec<f64> = places.map(|place| self.weight(begin + place, self.open)).collect();
        // The buffers are not retained between calls: there may be hundreds of accumulators.
        let mut bins = [(); 2].map(|()| self.transform.make_output_vec());
        let mut scratch = self.transform.make_scratch_vec();
        for (input, output) in [&mut self.segments[0], &mut window].into_iter().zip(&mut bins) {
            // The only error of the transform is a wrong length, and the lengths match by construction.
            let _ = self.transform.process_with_scratch(input, output, &mut scratch);
        }
        // A reflected end is in its segment twice, and counts half.
        let twice = self.fade == 0 && (self.open == 0 || self.open == self.hops);
        let share = if twice { 0.5 } else { 1.0 };
        // 3. The three sums of the module's head.
        let [squares, crosses, windows] = &mut self.sums;
        let [of_segment, of_window] = &bins;
        for (k, (x, w)) in of_segment.iter().zip(of_window).enumerate() {
            squares[k] += share * x.norm_sqr();
            crosses[k] += share * (x.re * w.re + x.im * w.im);
            windows[k] += share * w.norm_sqr();
        }
        let [of_segment, _] = bins;
        if let Some(transforms) = &mut self.transforms {
            transforms.push(of_segment);
        }
        // 4. Open the next segment.
        self.segments.swap(0, 1);
        self.segments[1].fill(0.0);
        self.open += 1;
    }
}

impl Evolving for SpectrumAccumulator {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        state.value(&mut self.not_finite)?;
        state.all([&mut self.moments, &mut self.open, &mut self.segments, &mut self.sums])?;
        ensure(self.open <= self.hops && self.moments.count() <= self.samples)
    }
}

/// Flank r(x) of the faded window, see the module's head; rises from 0 to 1 over the unit interval.
fn slope(part: f64) -> f64 {
    (FRAC_PI_2 * (FRAC_PI_2 * part.clamp(0.0, 1.0)).sin().powi(2)).sin()
}

/// Cosine window; `distance` from the segment's centre in hops.
fn weight(distance: f64) -> f64 {
    if distance.abs() < 1.0 { (FRAC_PI_2 * distance).cos() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::storage::state::SavedState;

    /// Oracle: the whole record stored, its mean removed first, segments filled by looking back into it.
    fn of_whole_record(signal: &[f64], time_step: f64, segment: Option<f64>) -> Vec<f64> {
        let plan = SpectrumAccumulator::new(signal.len(), time_step, segment).unwrap();
        let (samples, length) = (signal.len() as i64, plan.segments[0].len());
        let mean = signal.iter().sum::<f64>() / samples as f64;
        let mut power = vec![0.0; length / 2 + 1];
        for segment in 0..=plan.hops {
            let begin = plan.begin(segment);
            let mut values: Vec<f64> = (begin..begin + length as i64)
                .map(|index| {
                    let mirrored = if index < 0 { -1 - index } else { index };
                    let mirrored = if mirrored >= samples { 2 * samples - 1 - mirrored } else { mirrored };
                    let weight = weight(plan.distance(index, segment));
                    if weight > 0.0 { weight * (signal[mirrored as usize] - mean) } else { 0.0 }
                })
                .collect();
            let mut bins = plan.transform.make_output_vec();
            plan.transform.process(&mut values, &mut bins).unwrap();
            let share = if segment == 0 || segment == plan.hops { 0.5 } else { 1.0 };
            for (k, (sum, bin)) in power.iter_mut().zip(&bins).enumerate() {
                let twice = if k == 0 || k == length / 2 { 1.0 } else { 2.0 };
                *sum += share * twice * bin.norm_sqr() / (length as f64 * samples as f64);
            }
        }
        power
    }

    fn noise(samples: usize, mean: f64, seed: u64) -> Vec<f64> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        (0..samples).map(|_| mean + random.random_range(-1.0..1.0)).collect()
    }

    proptest! {
        #[test]
        fn the_stream_gives_the_spectrum_of_the_whole_record(
            samples in 8usize..500, segment in prop::option::of(1e-3f64..1.0), mean in -4e3..4e3_f64, seed: u64,
        ) {
            let signal = noise(samples, mean, seed);
            let exact = of_whole_record(&signal, 1e-3, segment);
            let streamed = PowerSpectrum::of(&signal, 1e-3, segment).unwrap();
            let all: f64 = exact.iter().sum();
            for (streamed, exact) in streamed.power.iter().zip(&exact) {
                // Rounding of the samples about a mean of 4e3: 5e-13 of the signal's size.
                prop_assert!((streamed - exact).abs() <= 1e-11 * all, "{streamed} {exact}");
            }
        }

        #[test]
        fn a_stopped_accumulator_continues_with_the_same_bits(samples in 8usize..300, at in 0.0..1.0_f64, seed: u64) {
            let signal = noise(samples, 100.0, seed);
            let stop = (at * samples as f64) as usize;
            let new = || SpectrumAccumulator::new(samples, 1e-3, Some(0.05)).unwrap();
            let mut first = new();
            signal[..stop].iter().for_each(|&value| first.push(value));
            let mut second = new();
            SavedState::of(&mut first).unwrap().restore(&mut second).unwrap();
            signal[stop..].iter().for_each(|&value| second.push(value));
            let whole = PowerSpectrum::of(&signal, 1e-3, Some(0.05)).unwrap();
            let bits = |spectrum: &PowerSpectrum| spectrum.power.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            prop_assert_eq!(bits(&second.finish().unwrap()), bits(&whole));
        }
    }

    /// Spectrum of a signal at 12 kHz, with the segments and the fade that sound has.
    fn faded(signal: &[f64]) -> PowerSpectrum {
        let mut accumulator = SpectrumAccumulator::faded(signal.len(), 1.0 / 12e3, 1.0, 0.25).unwrap();
        signal.iter().for_each(|&value| accumulator.push(value));
        accumulator.finish().unwrap()
    }

    /// A tone of level 0 dB at a frequency \[Hz\], just over two seconds long.
    fn tone(frequency: f64) -> Vec<f64> {
        let angle = |n: usize| std::f64::consts::TAU * frequency * n as f64 / 12e3 + 0.3;
        (0..25_013).map(|n| 2.0_f64.sqrt() * angle(n).sin()).collect()
    }

    #[test]
    fn a_fading_tone_leaks_nothing_into_lower_bands() {
        for frequency in [100.0, 253.0, 1003.0, 2600.0] {
            let levels = faded(&tone(frequency)).third_octaves(20.0, 1.0);
            for level in levels {
                let inside = (level.band.lower_edge()..level.band.upper_edge()).contains(&frequency);
                if inside {
                    assert!(level.level.abs() < 0.01, "{frequency} Hz: {} dB", level.level);
                } else if level.band.upper_edge() < 0.8 * frequency {
                    // Reflected, 253 Hz leak -47 dB into 25 Hz.
                    assert!(level.level < -85.0, "{frequency} Hz leaks {} dB to {:?}", level.level, level.band);
                }
            }
        }
    }

    #[test]
    fn a_spectrum_of_24_db_an_octave_has_its_levels_in_every_band() {
        // As many lines as the record has, of a power that grows with the eighth power of the frequency up to 500 Hz.
        let samples = 24_000;
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let size = |k: u32| (f64::from(k) / 40.0).powi(4);
        let phases: Vec<f64> = (0..=1000).map(|_| random.random_range(0.0..std::f64::consts::TAU)).collect();
        let value = |n: u32| -> f64 {
            let angle = |k: u32| std::f64::consts::TAU * f64::from(k * n % samples) / f64::from(samples);
            (40..=1000).map(|k| size(k) * (angle(k) + phases[k as usize]).cos()).sum()
        };
        // Whole periods of all lines.
        let period: Vec<f64> = (0..samples).map(value).collect();
        let signal: Vec<f64> = (0..8).flat_map(|_| period.iter().copied()).collect();
        for level in faded(&signal).third_octaves(22.0, 1.0) {
            let band = level.band.lower_edge()..level.band.upper_edge();
            // Each line stands for the half hertz about it: by an edge it counts for half a decibel at 25 Hz.
            let inside = |k: u32| {
                let middle = 0.5 * f64::from(k);
                ((band.end.min(middle + 0.25) - band.start.max(middle - 0.25)) / 0.5).max(0.0)
            };
            let exact = 10.0 * (40..=1000).map(|k| 0.5 * inside(k) * size(k).powi(2)).sum::<f64>().log10();
            if exact.is_finite() && band.end < 500.0 {
                assert!((level.level - exact).abs() < 0.3, "{:?}: {} for {exact} dB", level.band, level.level);
            }
        }
    }

    #[test]
    fn a_faded_record_loses_no_power_and_continues_in_the_same_bits() {
        for (samples, segment) in [(3000, 0.25), (8, 1.0), (641, 0.05)] {
            let new = || SpectrumAccumulator::faded(samples, 1e-3, segment, 0.1).unwrap();
            let signal: Vec<f64> =
                vec![2.0; samples].into_iter().zip(noise(samples, 0.0, 9)).map(|(a, b)| a + b).collect();
            let (mut whole, mut second) = (new(), new());
            signal.iter().for_each(|&value| whole.push(value));
            let (mean, fade) = (signal.iter().sum::<f64>() / samples as f64, whole.fade as f64);
            let weight = |n: usize| slope((n.min(samples - 1 - n) as f64 + 0.5) / fade).powi(2);
            let power: f64 = signal.iter().enumerate().map(|(n, value)| weight(n) * (value - mean).powi(2)).sum();
            let stop = samples / 3;
            signal[..stop].iter().for_each(|&value| second.push(value));
            let state = SavedState::of(&mut second).unwrap();
            second = new();
            state.restore(&mut second).unwrap();
            signal[stop..].iter().for_each(|&value| second.push(value));
            let [whole, second] = [whole, second].map(|accumulator| accumulator.finish().unwrap());
            assert_eq!(whole, second);
            let exact = power / (samples as f64 - fade);
            assert!((whole.mean_square() / exact - 1.0).abs() < 1e-9, "{} for {exact}", whole.mean_square());
        }
    }

    #[test]
    fn a_record_that_is_not_complete_has_no_spectrum() {
        let mut short = SpectrumAccumulator::new(100, 1e-3, Some(0.02)).unwrap();
        (0..99).for_each(|n| short.push(f64::from(n)));
        assert!(matches!(short.finish(), Err(SpectrumError::TooShort { samples: 99, needed: 100 })));
    }
}
