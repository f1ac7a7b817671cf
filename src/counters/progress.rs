//! Progress of a run, reported to a watcher. Work that can be stopped, shows its progress, is metered and warns.

use std::sync::atomic::{AtomicBool, Ordering};

use super::{Meter, Stage, Watch};

/// Watches a run. All calls come from the thread that runs it, in order; they must be cheap: [`Progress::step`] is
/// called every time step.
pub trait Progress {
    /// A stage of the preparation begins.
    fn stage(&mut self, _stage: Stage) {}

    /// So many pieces of the stage are done, and so many are known to be still to come.
    fn pieces(&mut self, _done: usize, _open: usize) {}

    /// The march through time begins, or continues after `done` steps: `steps` steps of `time_step` seconds in all.
    fn march(&mut self, _done: u64, _steps: u64, _time_step: f64) {}

    /// So many blocks of steps remain whose evaluation stops the march for long; its stage if the next steps may
    /// come to it. Called before [`Self::step`].
    fn blocks(&mut self, _remaining: u64, _stage: Option<Stage>) {}

    /// So many steps are done, those before a resumption included.
    fn step(&mut self, _done: u64) {}

    /// The share of all work that is done, 0 to 1, where it is more than one run, and the work now being done.
    fn share(&mut self, _done: f64, _doing: &str) {}

    /// Something that the user may want to know, as it happens.
    fn note(&mut self, _text: &str) {}

    /// Something that the user should act on.
    fn warning(&mut self, _text: &str) {}

    /// The run has ended, successfully or not.
    fn finish(&mut self) {}
}

/// Ignores all progress.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unwatched;

impl Progress for Unwatched {}

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
