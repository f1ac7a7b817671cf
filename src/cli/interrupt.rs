//! Ctrl-C: the first one asks the run to stop at the next step and keep what it has, the second one stops it at once.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::error::{CliError, INTERRUPTED};
use super::messages::tell;

/// From now on a file that would grow past the system's limit (`ulimit -f`) is an error of writing, as a full disk is,
/// and not the end of the program.
pub fn outlive_file_limits() {
    // A handler that does nothing of use takes the place of the signal's deadly default; without it all is as before.
    #[cfg(unix)]
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default());
}

/// Whether the user has asked for the end. Clones share the answer.
#[derive(Clone, Debug, Default)]
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Listens for Ctrl-C, and on Unix for SIGTERM and SIGHUP, from now on. Once per process.
    ///
    /// # Errors
    /// If the system does not let us, or somebody else listens already.
    pub fn listen() -> Result<Self, CliError> {
        let interrupt = Self::default();
        let shared = interrupt.clone();
        ctrlc::set_handler(move || {
            if shared.request() {
                // What is written has a name that says that it is not finished.
                std::process::exit(i32::from(INTERRUPTED));
            }
            tell("\nstopping after this step and keeping what there is (again: stop at once)");
        })
        .map_err(|error| CliError::Failed(format!("cannot listen for Ctrl-C: {error}")))?;
        Ok(interrupt)
    }

    /// Asks for the end; returns whether that had been asked for before.
    pub fn request(&self) -> bool {
        self.0.swap(true, Ordering::Relaxed)
    }

    /// What a run looks at between two steps.
    pub fn flag(&self) -> &AtomicBool {
        &self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_second_request_knows_of_the_first() {
        let interrupt = Interrupt::default();
        let run = interrupt.clone();
        assert!(!run.flag().load(Ordering::Relaxed));
        assert!(!interrupt.request());
        assert!(run.flag().load(Ordering::Relaxed));
        assert!(interrupt.request());
    }
}
