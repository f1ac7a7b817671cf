//! Progress without a terminal: a line every ten seconds, also while a stage reports nothing; the pace of a run's
//! steps, and the remaining time that follows from it.
//!
//! A changing pace predicts nothing: the remaining time is reported only while the pace of the later half of the time
//! agrees with that of all of it, and by the slower of both. Blocks of steps whose evaluation stops the march count by
//! their mean time: while there are some to come and none is done, no time is reported.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::counters::Stage;
use indicatif::HumanDuration;

use super::error::write_message;

const INTERVAL: Duration = Duration::from_secs(10);

/// Work under way, for the next line.
#[derive(Debug, Default)]
pub(super) enum Doing {
    /// Reading and planning.
    #[default]
    Beginning,
    /// Work of which only the name is known.
    Named(String),
    /// Steps: number of all, their length \[s\], and their pace.
    Steps { all: u64, time_step: f64, pace: Arc<Mutex<Pace>> },
    /// Share of all work that is done, and the name of the present part.
    Share(f64, String),
}

impl Doing {
    /// The line, `seconds` after the begin.
    fn line(&self, seconds: u64) -> String {
        match self {
            Self::Beginning => format!("{seconds} s: beginning"),
            Self::Named(name) => format!("{seconds} s: {name}"),
            Self::Steps { all, time_step, pace } => {
                let pace = pace.lock().unwrap_or_else(PoisonError::into_inner);
                let [rolled, to_roll] = [pace.done, *all].map(|steps| steps as f64 * time_step);
                let percent = 100.0 * pace.done as f64 / (*all).max(1) as f64;
                let stage = pace.stage.map(|stage| format!(", {}", stage.title())).unwrap_or_default();
                let to_go = pace.seconds_remaining(pace.now(), *all);
                let to_go = to_go.map(|seconds| format!(", about {} to go", in_words(seconds))).unwrap_or_default();
                format!("{seconds} s: rolled {rolled:.2} of {to_roll:.2} s, {percent:.0} %{stage}{to_go}")
            }
            Self::Share(share, name) => format!("{seconds} s: {:.0} % of all work, {name}", 100.0 * share),
        }
    }
}

/// Duration in words, such as `45s`.
pub(super) fn in_words(seconds: f64) -> String {
    let whole = Duration::try_from_secs_f64(seconds.round());
    whole.map_or_else(|_| "?".to_owned(), |whole| format!("{:#}", HumanDuration(whole)))
}

/// Work that the lines report, and whether it has ended.
#[derive(Debug, Default)]
struct Shared {
    doing: Mutex<(Doing, bool)>,
    ended: Condvar,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, (Doing, bool)> {
        self.doing.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A thread that reports the work under way, until this is dropped.
#[derive(Debug)]
pub(super) struct ProgressLog {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl ProgressLog {
    /// Starts to write to standard error.
    pub(super) fn start() -> Self {
        Self::with_interval(INTERVAL, write_message)
    }

    fn with_interval(interval: Duration, mut say: impl FnMut(&str) + Send + 'static) -> Self {
        let shared = Arc::new(Shared::default());
        let (begin, work) = (Instant::now(), Arc::clone(&shared));
        let lines = move || {
            let mut doing = work.lock();
            loop {
                let waited = work.ended.wait_timeout_while(doing, interval, |(_, has_ended)| !*has_ended);
                doing = waited.map_or_else(|error| error.into_inner().0, |(doing, _)| doing);
                if doing.1 {
                    return;
                }
                say(&doing.0.line(begin.elapsed().as_secs()));
            }
        };
        // Without a thread nothing is reported, and the work is done all the same.
        Self { shared, thread: std::thread::Builder::new().spawn(lines).ok() }
    }

    pub(super) fn set(&self, doing: Doing) {
        self.shared.lock().0 = doing;
    }
}

impl Drop for ProgressLog {
    fn drop(&mut self) {
        self.shared.lock().1 = true;
        self.shared.ended.notify_all();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

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
    use std::sync::mpsc::channel;

    use super::*;

    #[test]
    fn work_without_progress_is_reported_until_it_ends() {
        let (send, lines) = channel();
        let log = ProgressLog::with_interval(Duration::from_millis(5), move |line| send.send(line.to_owned()).unwrap());
        log.set(Doing::Named("sum influence functions".to_owned()));
        for _ in 0..3 {
            let line = || lines.recv_timeout(Duration::from_secs(60)).unwrap();
            while !line().ends_with("sum influence functions") {}
        }
        drop(log);
        while lines.try_recv().is_ok() {}
        assert!(lines.recv().is_err(), "the thread has ended");
    }

    #[test]
    fn a_line_states_the_steps_and_a_known_time_to_go() {
        let mut pace = Pace::after(0);
        (1..=20).for_each(|second| pace.mark(f64::from(second), 50 * second as u64));
        let steps = |pace| Doing::Steps { all: 4000, time_step: 1e-3, pace: Arc::new(Mutex::new(pace)) }.line(42);
        // Told 20 s before the last step.
        assert_eq!(steps(pace), "42 s: rolled 1.00 of 4.00 s, 25 %, about 80s to go");
        let mut pace = Pace::after(1000);
        assert_eq!(steps(Pace::after(1000)), "42 s: rolled 1.00 of 4.00 s, 25 %");
        pace.blocks(0.0, 2, Some(Stage::Sound));
        assert_eq!(steps(pace), "42 s: rolled 1.00 of 4.00 s, 25 %, transform to sound");
        assert_eq!(Doing::Share(0.37, "- rotation".to_owned()).line(9), "9 s: 37 % of all work, - rotation");
    }

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
