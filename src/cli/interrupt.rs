//! Ctrl-C: the first one asks the run to stop at the next step and keep what it has, the second one stops it at once.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use super::error::{CliError, INTERRUPTED};
use super::messages::tell;

/// Requests within this time of the first are the same one: a batch system signals a job's shell and its programs, and
/// the shell hands it on.
const SAME_REQUEST: Duration = Duration::from_millis(500);

/// Makes a file that would grow past the system's limit (`ulimit -f`) an error of writing from now on, as a full disk
/// is, and not the end of the program.
pub(super) fn outlive_file_limits() {
    // A handler that does nothing of use takes the place of the signal's deadly default; without it all is as before.
    #[cfg(unix)]
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default());
}

/// True if the user has asked for the end. Clones share the answer.
#[derive(Clone, Debug, Default)]
pub(crate) struct Interrupt {
    asked: Arc<AtomicBool>,
    /// When that was first asked for.
    first: Arc<OnceLock<Instant>>,
    /// True once the command looks at the flag between its steps: what does not ends at the first request.
    looked_at: Arc<AtomicBool>,
}

/// Which request for the end one is.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Request {
    /// The first one, of a command that will see it.
    First,
    /// The first one, come another way.
    Same,
    /// The first one, which no part of the command would see.
    Unseen,
    /// One more.
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
            Request::First => tell("\nstopping after this step and keeping what there is (again: stop at once)"),
            Request::Same => {}
            Request::Unseen => {
                tell(&CliError::Interrupted { kept: None }.to_string());
                std::process::exit(i32::from(INTERRUPTED));
            }
            // What is written has a name that says that it is not finished.
            Request::Further => std::process::exit(i32::from(INTERRUPTED)),
        })
        .map_err(|error| CliError::Failed(format!("cannot listen for Ctrl-C: {error}")))?;
        Ok(interrupt)
    }

    /// Asks for the end, at an instant.
    fn request(&self, at: Instant) -> Request {
        let first = *self.first.get_or_init(|| at);
        if !self.asked.swap(true, Ordering::Relaxed) {
            if self.looked_at.load(Ordering::Relaxed) { Request::First } else { Request::Unseen }
        } else if at.saturating_duration_since(first) < SAME_REQUEST {
            Request::Same
        } else {
            Request::Further
        }
    }

    /// Returns the flag that a run looks at between two steps.
    pub(crate) fn flag(&self) -> &AtomicBool {
        self.looked_at.store(true, Ordering::Relaxed);
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
