//! Passages of a microphone beside the road that a run is long enough for.

use std::ops::Range;

use crate::plan::sound::Sound;
use crate::sound::PassBy;
use crate::sound::pass_by::Passage;
use crate::sound::resample::FILE_RATE;

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
