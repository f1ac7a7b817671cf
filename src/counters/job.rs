//! Work that can be stopped, shows its progress, is metered and warns.

use std::sync::atomic::{AtomicBool, Ordering};

use super::{Meter, Progress, Watch};

/// Work in progress.
pub struct Job<'a> {
    /// Ends the work once it is set.
    pub stop: &'a AtomicBool,
    /// Receives the progress.
    pub progress: &'a mut dyn Progress,
    /// Cost so far.
    pub meter: Meter,
    /// Warnings that the user should act on.
    pub warnings: Vec<String>,
}

impl<'a> Job<'a> {
    /// A job that has not begun, measured as [`Watch::default`] says.
    pub fn new(stop: &'a AtomicBool, progress: &'a mut dyn Progress) -> Self {
        Self { stop, progress, meter: Meter::default(), warnings: Vec::new() }
    }

    /// The same, measured as closely as `watch` says.
    #[must_use]
    pub fn watched(self, watch: Watch) -> Self {
        Self { meter: Meter::new(watch), ..self }
    }

    pub(crate) fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}
