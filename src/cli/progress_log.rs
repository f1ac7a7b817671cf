//! Progress without a terminal: a line every ten seconds, also while a stage reports nothing.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use indicatif::HumanDuration;

use super::messages::write_message;
use super::pace::Pace;

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

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;

    use super::*;
    use crate::counters::Stage;

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
}
