//! Progress of a run, for its watcher.

use super::Stage;

/// Watches a run. All calls come from the thread that runs it, in order; they must be cheap, [`Progress::step`] comes
/// every time step.
pub trait Progress {
    /// Tells that a stage of the preparation begins.
    fn stage(&mut self, _stage: Stage) {}

    /// Tells that so many pieces of the stage are done, and that so many are known to be still to come.
    fn pieces(&mut self, _done: usize, _open: usize) {}

    /// Tells that the march through time begins, or goes on after `done` steps: `steps` steps of `time_step` seconds in
    /// all.
    fn march(&mut self, _done: u64, _steps: u64, _time_step: f64) {}

    /// Tells that so many steps are done.
    fn step(&mut self, _done: u64) {}

    /// Tells the share of all work that is done, 0 to 1, where there is more of it than one run; and the work under
    /// way.
    fn share(&mut self, _done: f64, _doing: &str) {}

    /// Tells something that the user may want to know, as it happens.
    fn note(&mut self, _text: &str) {}

    /// Tells something that the user should act on.
    fn warning(&mut self, _text: &str) {}

    /// Tells that the run has ended, one way or another.
    fn finish(&mut self) {}
}

/// Progress without a watcher.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unwatched;

impl Progress for Unwatched {}
