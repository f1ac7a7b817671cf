//! Ctrl-C: the first one asks the run to stop at the next step and keep what it has, the second one stops it at once.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use super::error::{CliError, INTERRUPTED, write_message};

/// Requests within this time of the first count as the same: a batch system signals a job's shell and its programs, and
/// the shell passes it on.
const SAME_REQUEST: Duration = Duration::from_millis(500);

/// From now on a file that would grow past the system's limit (`ulimit -f`) is an error of writing, like a full disk,
/// and does not end the program.
pub(super) fn outlive_file_limits() {
    // A handler without effect replaces the signal's fatal default; if it cannot be registered, nothing changes.
    #[cfg(unix)]
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default());
}

/// Request of the user to end the program. Clones share it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Interrupt {
    asked: Arc<AtomicBool>,
    /// Time of the first request.
    first: Arc<OnceLock<Instant>>,
    /// True once the command checks the flag between its steps: a command that does not ends at the first request.
    is_seen: Arc<AtomicBool>,
}

/// Kind of a request for the end.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Request {
    /// The first one, to a command that will see it.
    First,
    /// The first one, received again by another path.
    Same,
    /// The first one, to a command that does not check the flag.
    Unseen,
    /// A later one.
    Further,
}

impl Interrupt {
    /// Listens for Ctrl-C, and on Unix for SIGTERM and SIGHUP, from now on. Once per process.
    ///
    /// # Errors
    /// Fails if the system does not allow it, or another part of the program listens already.
    pub(crate) fn listen() -> Result<Self, CliError> {
        let interrupt = Self::default();
        let shared = interrupt.clone();
        ctrlc::set_handler(move || match shared.request(Instant::now()) {
            Request::First => write_message("\nstopping as soon as possible (again: at once)"),
            Request::Same => {}
            Request::Unseen => {
                write_message(&CliError::Interrupted { partial: None }.to_string());
                std::process::exit(i32::from(INTERRUPTED));
            }
            // Unfinished files have names that say so.
            Request::Further => std::process::exit(i32::from(INTERRUPTED)),
        })
        .map_err(|error| CliError::Failed(format!("cannot listen for Ctrl-C: {error}")))?;
        Ok(interrupt)
    }

    fn request(&self, at: Instant) -> Request {
        let first = *self.first.get_or_init(|| at);
        if !self.asked.swap(true, Ordering::Relaxed) {
            if self.is_seen.load(Ordering::Relaxed) { Request::First } else { Request::Unseen }
        } else if at.saturating_duration_since(first) < SAME_REQUEST {
            Request::Same
        } else {
            Request::Further
        }
    }

    /// Flag that a run checks between two steps; from now on the first request only sets it.
    pub(crate) fn flag(&self) -> &AtomicBool {
        self.is_seen.store(true, Ordering::Relaxed);
        &self.asked
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_request_is_one_that_comes_later() {
        let (interrupt, begin) = (Interrupt::default(), Instant::now());
        let run = interrupt.clone();
        assert!(!run.flag().load(Ordering::Relaxed));
        assert_eq!(interrupt.request(begin), Request::First);
        assert!(run.flag().load(Ordering::Relaxed));
        assert_eq!(run.request(begin + Duration::from_millis(20)), Request::Same);
        assert_eq!(run.request(begin + SAME_REQUEST), Request::Further);
    }

    #[test]
    fn a_command_that_looks_at_no_flag_ends_at_the_first_request() {
        assert_eq!(Interrupt::default().request(Instant::now()), Request::Unseen);
    }
}
