//! Pace of a run's steps, and the remaining time that follows from it.
//!
//! A changing pace predicts nothing: the remaining time is reported only while the pace of the later half of the time
//! agrees with that of all of it, and by the slower of both. Blocks of steps whose evaluation stops the march count by
//! their mean time: while there are some to come and none is done, no time is reported.

use std::time::Instant;

use crate::counters::Stage;

/// Least time between two marks \[s\].
const APART: f64 = 0.25;
/// Least time of steps before the remaining time is reported \[s\].
const SHORTEST: f64 = 5.0;
/// Largest relative difference between the pace of the later half and that of all.
const STEADY: f64 = 0.25;

/// Times at which numbers of steps were done.
#[derive(Debug)]
pub(super) struct Pace {
    begin: Instant,
    /// Time since the begin without that of blocks \[s\], and number of steps done.
    marks: Vec<(f64, u64)>,
    /// Number of steps done.
    pub(super) done: u64,
    /// Time since the begin of the last report \[s\].
    reported: f64,
    /// Blocks to come, blocks done and their time \[s\].
    blocks: (u64, u64, f64),
    /// Stage that the march may have come to since the last report.
    pub(super) stage: Option<Stage>,
}

impl Pace {
    /// Begins after `done` steps, which an earlier process may have done.
    pub(super) fn after(done: u64) -> Self {
        let (begin, marks) = (Instant::now(), vec![(0.0, done)]);
        Self { begin, marks, done, reported: 0.0, blocks: (0, 0, 0.0), stage: None }
    }

    /// Time since the begin \[s\].
    pub(super) fn now(&self) -> f64 {
        self.begin.elapsed().as_secs_f64()
    }

    /// Records at a time since the begin \[s\] how many blocks are still to come; called before [`Self::mark`].
    pub(super) fn blocks(&mut self, time: f64, remaining: u64, stage: Option<Stage>) {
        let (known, done, taken) = &mut self.blocks;
        if remaining < *known {
            *done += *known - remaining;
            *taken += time - self.reported;
        }
        *known = remaining;
        self.stage = stage;
    }

    /// Records that `done` steps are done at a time since the begin \[s\].
    pub(super) fn mark(&mut self, time: f64, done: u64) {
        (self.reported, self.done) = (time, done);
        let time = time - self.blocks.2;
        if self.marks.last().is_none_or(|last| time >= last.0 + APART) {
            self.marks.push((time, done));
        }
    }

    /// Remaining time of `all` steps at a time since the begin \[s\]; `None` while that cannot be predicted.
    pub(super) fn seconds_remaining(&self, now: f64, all: u64) -> Option<f64> {
        let (&first, &last) = (self.marks.first()?, self.marks.last()?);
        let &middle = self.marks.iter().rfind(|mark| mark.0 <= 0.5 * last.0)?;
        // Contact over a wider window begins again.
        let pace = |from: (f64, u64)| last.1.saturating_sub(from.1) as f64 / (last.0 - from.0);
        let (whole, late) = (pace(first), pace(middle));
        let is_steady = last.0 >= SHORTEST && (late - whole).abs() <= STEADY * whole;
        let of_blocks = match self.blocks {
            (0, ..) => 0.0,
            // Without a block done this is not finite.
            (remaining, done, taken) => remaining as f64 * taken / done as f64,
        };
        let of_steps = all.saturating_sub(self.done) as f64 / whole.min(late);
        is_steady
            .then_some(of_steps + of_blocks - (now - self.reported))
            .filter(|seconds_remaining| seconds_remaining.is_finite() && *seconds_remaining >= 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pace of a number of steps in each second.
    fn pace(rates: impl IntoIterator<Item = u64>) -> Pace {
        let (mut pace, mut done) = (Pace::after(100), 100);
        for (second, rate) in rates.into_iter().enumerate() {
            done += rate;
            pace.mark(second as f64 + 1.0, done);
        }
        pace
    }

    #[test]
    fn only_a_steady_pace_predicts_the_remaining_time() {
        assert_eq!(pace([10; 10]).seconds_remaining(10.0, 300), Some(10.0));
        assert_eq!(pace([10; 4]).seconds_remaining(4.0, 300), None, "too early");
        // The slower pace counts.
        assert_eq!(pace([12, 12, 12, 12, 12, 10, 10, 10, 10, 10]).seconds_remaining(10.0, 310), Some(10.0));
        // First fast, as a tyre that does not touch the road yet; then ten times as slow: no time is reported
        // meanwhile.
        let mut rates = vec![100; 5];
        rates.extend([10; 5]);
        assert_eq!(pace(rates.clone()).seconds_remaining(10.0, 10_000), None);
        rates.extend([10; 300]);
        let seconds_remaining = pace(rates).seconds_remaining(310.0, 10_000).unwrap();
        assert!(
            (seconds_remaining * 10.0 / (10_000.0 - 100.0 - 500.0 - 3050.0) - 1.0).abs() < 1e-9,
            "{seconds_remaining}"
        );
        assert_eq!(pace([0; 10]).seconds_remaining(10.0, 300), None, "a run that stands still");
        assert_eq!(Pace::after(0).seconds_remaining(0.0, 10), None);
    }

    #[test]
    fn the_time_of_blocks_counts_and_is_unknown_before_the_first() {
        let mut pace = Pace::after(0);
        let mut steps = |from: u64, remaining, stage| {
            (1..=10).for_each(|second| {
                let time = (from + second) as f64;
                pace.blocks(time, remaining, stage);
                pace.mark(time, (from + second) * 10 - if remaining < 3 { 610 } else { 0 });
            });
            pace.seconds_remaining((from + 10) as f64, 400)
        };
        assert_eq!(steps(0, 3, Some(Stage::Sound)), None, "no time is known before the first block");
        // A block from 10 to 71 s, within a second of steps; then 10 steps a second again.
        let seconds = steps(70, 2, None).unwrap();
        assert!((seconds - (21.0 + 2.0 * 61.0)).abs() < 1e-9, "{seconds}");
        assert_eq!(pace.stage, None);
        // During a block the time counts down; once it has taken longer than the one before, the time is unknown.
        assert!((pace.seconds_remaining(140.0, 400).unwrap() - (seconds - 60.0)).abs() < 1e-9);
        assert_eq!(pace.seconds_remaining(1e3, 400), None);
    }
}
