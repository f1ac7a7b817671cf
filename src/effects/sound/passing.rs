//! A microphone beside the road, and the tyre or the four tyres of a vehicle that pass it.
//!
//! The tyres of a vehicle roll alike but are incoherent, so their mean squares add, after the time weighting F:
//!
//! 1. All tyres of one side see the microphone on the same line of points. The passage along a line is computed for
//!    every stretch of the run that is long enough ([`Passages`]), and its level is read.
//! 2. A vehicle's passage p takes for its tyre t the stretch p + t, cyclically: tyres make different noise at the same
//!    time as far as the run has different stretches.
//! 3. Each tyre's level is read where it is when the vehicle's middle is at x: half the wheelbase ahead or behind.
//!
//! The rear tyres of a vehicle roll where the front ones have rolled, a wheelbase/V later. Noise with that delay is
//! incoherent except for tones, so they, too, add as mean squares.

use std::ops::Range;

use crate::numeric::in_parallel;
use crate::plan::receivers::PlannedReceiver;
use crate::plan::sound::Sound;
use crate::response::BandGain;
use crate::results::pass_by::PassBySummary;
use crate::sound::band_pass::band_pass;
use crate::sound::levels::energetic_sum;
use crate::sound::pass_by::Passage;
use crate::sound::receivers::COAST_BY_HALF_LENGTH;
use crate::sound::resample::FILE_RATE;
use crate::sound::{Detector, FrequencyWeighting, PassBy, TimeWeighting, WeightingFilter};

use super::stored_signal::StoredSignal;

/// Passing of a receiver beside the road.
pub(super) struct Passing {
    /// One line of points for each side of the vehicle with tyres.
    lines: Vec<Line>,
    tyres: Vec<Tyre>,
    /// Samples of a line that belong to the passage.
    samples: Range<usize>,
    /// Samples before it in which the detector settles.
    lead: usize,
    /// Band of the sound \[Hz\].
    band: Range<f64>,
    /// Gains of its third octaves; none unless set.
    pub(super) gains: Vec<BandGain>,
}

struct Line {
    /// Among the points of all receivers.
    points: Range<usize>,
    passages: Passages,
}

struct Tyre {
    line: usize,
    /// Samples by which it reaches a place on its line before the vehicle's middle does; negative for later.
    early: i64,
}

/// Sound at a microphone beside the road.
pub(super) struct RecordedPassage {
    /// By passage, A-weighted levels F \[dB\] at the samples of a line; minus infinity at samples outside the passage.
    pub(super) levels: Vec<Vec<f64>>,
    /// Pressure of the first passage \[Pa\]: all tyres if each has a different stretch of the run, else the first one
    /// alone, since the same noise from several places would sound like an echo.
    pub(super) sound: Vec<f64>,
    /// Number of tyres in it.
    pub(super) sounding: usize,
}

impl Passing {
    /// Passing of a receiver, over a band \[Hz\]; `None` where the tyre does not pass it.
    pub(super) fn of(
        sound: &Sound,
        delays: &[u64],
        receiver: &PlannedReceiver,
        speed: f64,
        band: &Range<f64>,
    ) -> Option<Self> {
        let passage = receiver.passage()?;
        let line =
            |points: Range<usize>| Some(Line { passages: Passages::of(sound, delays, points.clone(), speed)?, points });
        // 1. Lines of points, one for each side.
        let lines: Option<Vec<Line>> = receiver.lines().into_iter().map(line).collect();
        let lines = lines?;
        let count = lines.iter().map(|line| line.passages.passing.samples()).min()?;
        // 2. Tyres on them.
        let tyres: Vec<Tyre> = match receiver.vehicle() {
            None => vec![Tyre { line: 0, early: 0 }],
            // The vehicle's middle as its tyres see it: the left ones on their right, the front ones behind.
            Some(vehicle) => vehicle
                .seen_from_tyres([0.0; 3])
                .map(|[ahead, aside, _]| Tyre {
                    line: usize::from(aside > 0.0),
                    early: (-ahead / speed * FILE_RATE).round() as i64,
                })
                .into(),
        };
        // 3. Samples of the passage, so that every tyre is on its line.
        let most = tyres.iter().map(|tyre| tyre.early.unsigned_abs()).max().unwrap_or(0) as usize;
        let front = sound.path.positions.get(lines.first()?.points.start)?[0];
        let sample = |place: f64| (front - place) / speed * FILE_RATE;
        let start = (sample(0.5 * passage).ceil() as usize).max(most);
        let end = (sample(-0.5 * passage).floor() as usize + 1).min(count.saturating_sub(most));
        Some(Self {
            lines,
            tyres,
            samples: start..end.max(start),
            lead: start - most,
            band: band.clone(),
            gains: Vec::new(),
        })
    }

    /// Time, place and Doppler ratio of the vehicle's middle, which moves as a tyre on the first line.
    pub(super) fn middle(&self) -> &PassBy {
        &self.lines[0].passages.passing
    }

    /// Samples of a line that belong to the passage.
    pub(super) fn samples(&self) -> Range<usize> {
        self.samples.clone()
    }

    /// Reason why there is no passage in so many samples; `None` if there is one.
    pub(super) fn missing(&self, sound: &Sound, stored: usize) -> Option<String> {
        let longest = self.lines.iter().max_by_key(|line| line.passages.length())?;
        longest.passages.missing(sound, stored)
    }

    /// Message if there are too few passages in so many samples for the statistical error of their maximum.
    pub(super) fn few(&self, stored: usize) -> Option<String> {
        let summary = self.summary_of(String::new(), &vec![0.0; self.passages(stored)]);
        (summary.passages > 0 && summary.standard_error.is_none()).then(|| summary.statistics())
    }

    /// Number of passages in so many samples.
    fn passages(&self, stored: usize) -> usize {
        self.lines.iter().map(|line| line.passages.within(stored)).min().unwrap_or(0).max(0) as usize
    }

    /// Summary of the passages' highest levels while the vehicle's middle is between the lines of the standard.
    pub(super) fn summary(&self, file: String, levels: &[Vec<f64>]) -> PassBySummary {
        let highest = |levels: &Vec<f64>| Some(self.middle().highest(levels, COAST_BY_HALF_LENGTH)?.1);
        let maxima: Vec<f64> = levels.iter().filter_map(highest).collect();
        self.summary_of(file, &maxima)
    }

    fn summary_of(&self, file: String, maxima: &[f64]) -> PassBySummary {
        PassBySummary::new(file, maxima, self.tyres.len(), self.middle().samples() as f64 / FILE_RATE)
    }

    /// Makes all points store what the passages within the first `stored` samples need of them.
    pub(super) fn request(&self, stored: usize, signals: &mut [StoredSignal]) {
        for Line { points, passages } in &self.lines {
            for (receiver, signal) in signals[points.clone()].iter_mut().enumerate() {
                let wanted = (0..passages.within(stored)).map(|passage| passages.samples(passage, receiver));
                *signal = StoredSignal::of(wanted.collect());
            }
        }
    }

    /// All passages in the stored pressures of the points, of `stored` samples; `None` if there is none.
    pub(super) fn record(&self, stored: usize, signals: &[StoredSignal]) -> Option<RecordedPassage> {
        let stretches = Some(self.passages(stored)).filter(|&stretches| stretches > 0)?;
        let sounding = if stretches < self.tyres.len() { 1 } else { self.tyres.len() };
        let mut sound: Vec<f64> = Vec::new();
        // Levels by line and stretch.
        let mut alone: Vec<Vec<Vec<f64>>> = Vec::new();
        for (number, line) in self.lines.iter().enumerate() {
            let read = |stretch: usize| {
                let pressures = band_pass(&line.pressures(stretch, signals)?, FILE_RATE, &self.band, &self.gains);
                let levels = self.levels(&pressures)?;
                // In the first passage a tyre has the stretch of its number.
                let tyre = self.tyres[..sounding].get(stretch).filter(|tyre| tyre.line == number);
                Some((levels, tyre.map(|tyre| (tyre, pressures))))
            };
            let read = in_parallel::made(stretches, read).into_iter().collect::<Option<Vec<_>>>()?;
            let (levels, sounds): (Vec<_>, Vec<_>) = read.into_iter().unzip();
            for (tyre, pressures) in sounds.into_iter().flatten() {
                let pressure = self.samples().map(|sample| pressures[tyre.at(sample)]);
                if sound.is_empty() {
                    sound = pressure.collect();
                } else {
                    sound.iter_mut().zip(pressure).for_each(|(sum, more)| *sum += more);
                }
            }
            alone.push(levels);
        }
        let levels = (0..stretches).map(|passage| self.together(&alone, passage)).collect();
        Some(RecordedPassage { levels, sound, sounding })
    }

    /// Reading of a sound level meter for a line's pressures \[dB\]. It starts from the mean square of the lead, so
    /// that a steady noise has its level at once; levels are read after the lead.
    fn levels(&self, pressures: &[f64]) -> Option<Vec<f64>> {
        let weighted = WeightingFilter::new(FrequencyWeighting::A, FILE_RATE).ok()?.apply(pressures);
        let lead = &weighted[..self.lead.min(weighted.len())];
        let before = lead.iter().map(|pressure| pressure * pressure).sum::<f64>() / lead.len().max(1) as f64;
        Some(Detector::new(TimeWeighting::Fast, FILE_RATE).after(before).levels(&weighted))
    }

    /// Levels of a passage, from those of lines and stretches.
    fn together(&self, alone: &[Vec<Vec<f64>>], passage: usize) -> Vec<f64> {
        if let ([only], [levels]) = (&self.tyres[..], alone) {
            debug_assert_eq!(only.early, 0);
            let mut levels = levels[passage].clone();
            levels[..self.samples.start].fill(f64::NEG_INFINITY);
            levels[self.samples.end..].fill(f64::NEG_INFINITY);
            return levels;
        }
        let of_tyre = |(number, tyre): (usize, &Tyre), sample: usize| {
            let line = &alone[tyre.line];
            line[(passage + number) % line.len()][tyre.at(sample)]
        };
        let mut levels = vec![f64::NEG_INFINITY; self.middle().samples()];
        for sample in self.samples() {
            levels[sample] = energetic_sum(self.tyres.iter().enumerate().map(|tyre| of_tyre(tyre, sample)));
        }
        levels
    }
}

impl Line {
    /// Pressures of a stretch \[Pa\].
    fn pressures(&self, stretch: usize, signals: &[StoredSignal]) -> Option<Vec<f64>> {
        let point = |receiver: usize, _| signals[self.points.start + receiver].excerpt(stretch).collect();
        self.passages.passing.synthesise(point).ok()
    }
}

impl Tyre {
    /// Sample on its line at which it is when the vehicle's middle is at `sample`; the range of samples leaves room for
    /// it.
    fn at(&self, sample: usize) -> usize {
        sample.saturating_add_signed(self.early as isize)
    }
}

/// Passages along a line of points, and the samples of the points' pressures that they need.
pub(super) struct Passages {
    /// Pass-by of the points.
    pub(super) passing: PassBy,
    /// By point, range of samples relative to the passage's beginning, the whole steps of its delay taken off.
    needed: Vec<Range<i64>>,
    /// Samples from one passage to the next.
    hop: i64,
}

impl Passages {
    /// Passages of points that the tyre passes; `None` where they are not on a line.
    pub(super) fn of(sound: &Sound, delays: &[u64], points: Range<usize>, speed: f64) -> Option<Self> {
        let rate = 1.0 / sound.path.layout.time_step;
        let passing = PassBy::new(Passage {
            receivers: sound.path.positions[points.clone()].to_vec(),
            speed,
            sound_speed: sound.path.air.sound_speed,
            input_rate: rate,
            output_rate: FILE_RATE,
            amplification: true,
        });
        let passing = passing.ok()?;
        let delays = delays[points].iter().enumerate();
        let needed = delays.map(|(receiver, &delay)| {
            let Range { start, end } = passing.needed(receiver);
            start - delay as i64..end - delay as i64
        });
        let needed = needed.collect();
        let hop = (passing.samples() as f64 / FILE_RATE * rate).ceil() as i64;
        Some(Self { passing, needed, hop })
    }

    /// Range of samples over all points.
    fn span(&self) -> Range<i64> {
        let first = self.needed.iter().map(|needed| needed.start).min().unwrap_or(0);
        first..self.needed.iter().map(|needed| needed.end).max().unwrap_or(0)
    }

    /// Number of samples that a passage needs.
    pub(super) fn length(&self) -> i64 {
        let Range { start, end } = self.span();
        end - start
    }

    /// Number of passages in so many samples, one after the other.
    pub(super) fn within(&self, stored: usize) -> i64 {
        let (stored, length) = (stored as i64, self.length());
        if stored < length { 0 } else { (stored - length) / self.hop + 1 }
    }

    /// Range of samples of a point that a passage needs.
    pub(super) fn samples(&self, passage: i64, receiver: usize) -> Range<usize> {
        let begin = passage * self.hop - self.span().start;
        let Range { start, end } = self.needed[receiver];
        (begin + start) as usize..(begin + end) as usize
    }

    /// Reason why there is no passage in so many samples; `None` if there is one.
    pub(super) fn missing(&self, sound: &Sound, stored: usize) -> Option<String> {
        if self.within(stored) > 0 {
            return None;
        }
        let length = self.length();
        if length > sound.stored_samples() as i64 {
            return Some("no passage: at this speed one takes longer than the pressures that are kept".to_owned());
        }
        let seconds = sound.duration_for(length as u64);
        Some(format!("no passage: the run is too short for one, which takes a rolling.duration of {seconds:.2} s"))
    }
}
