//! Pace of a run's steps, and the remaining time that follows from it.
//!
//! A changing pace predicts nothing: the remaining time is reported only while the pace of the later half of the time
//! agrees with that of all of it, and by the slower of both.

/// Least time between two marks \[s\].
const APART: f64 = 0.25;
/// Least time of steps before the remaining time is reported \[s\].
const SHORTEST: f64 = 5.0;
/// Largest relative difference between the pace of the later half and that of all.
const STEADY: f64 = 0.25;

/// Times at which numbers of steps were done.
#[derive(Debug)]
pub(super) struct Pace {
    /// Time since the first mark \[s\], and number of steps done.
    marks: Vec<(f64, u64)>,
}

impl Pace {
    /// Begins after `done` steps, which an earlier process may have done.
    pub(super) fn after(done: u64) -> Self {
        Self { marks: vec![(0.0, done)] }
    }

    /// Records that `done` steps are done at a time since the beginning \[s\].
    pub(super) fn mark(&mut self, time: f64, done: u64) {
        if self.marks.last().is_none_or(|last| time >= last.0 + APART) {
            self.marks.push((time, done));
        }
    }

    /// Remaining time of `all` steps \[s\]; `None` while that cannot be predicted.
    pub(super) fn seconds_left(&self, all: u64) -> Option<f64> {
        let (&first, &last) = (self.marks.first()?, self.marks.last()?);
        let &middle = self.marks.iter().rfind(|mark| mark.0 <= 0.5 * last.0)?;
        let pace = |from: (f64, u64)| (last.1 - from.1) as f64 / (last.0 - from.0);
        let (whole, late) = (pace(first), pace(middle));
        let is_steady = last.0 >= SHORTEST && (late - whole).abs() <= STEADY * whole;
        is_steady
            .then(|| all.saturating_sub(last.1) as f64 / whole.min(late))
            .filter(|seconds_left| seconds_left.is_finite())
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
    fn the_rest_is_told_by_a_steady_pace_alone() {
        assert_eq!(pace([10; 10]).seconds_left(300), Some(10.0));
        assert_eq!(pace([10; 4]).seconds_left(300), None, "too early");
        // The slower pace counts.
        assert_eq!(pace([12, 12, 12, 12, 12, 10, 10, 10, 10, 10]).seconds_left(310), Some(10.0));
        // First fast, as a tyre that does not touch the road yet; then ten times as slow: no time is reported
        // meanwhile.
        let mut rates = vec![100; 5];
        rates.extend([10; 5]);
        assert_eq!(pace(rates.clone()).seconds_left(10_000), None);
        rates.extend([10; 300]);
        let seconds_left = pace(rates).seconds_left(10_000).unwrap();
        assert!((seconds_left * 10.0 / (10_000.0 - 100.0 - 500.0 - 3050.0) - 1.0).abs() < 1e-9, "{seconds_left}");
        assert_eq!(pace([0; 10]).seconds_left(300), None, "a run that stands still");
        assert_eq!(Pace::after(0).seconds_left(10), None);
    }
}
