//! Work without the interpreter's lock: on a separate pool of threads, watched by the calling thread.
//!
//! The calling thread checks ten times a second for Python's signals (Ctrl-C) and reports the progress. A signal, or an
//! exception of the progress function, asks the work to stop; the exception is raised when it has. The pool lives for
//! one call, so that a process that forks later inherits no threads.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use ndarray::Array2;
use pyo3::prelude::*;
use rayon::ThreadPoolBuilder;

use super::error::Failure;
use crate::counters::Stage;
use crate::run::Progress;

/// Interval of the checks.
const POLL_INTERVAL: Duration = Duration::from_millis(100);
/// More threads are taken for a typing error.
const MOST_THREADS: usize = 1024;

/// State that work and caller share.
#[derive(Default)]
pub(super) struct Watched {
    /// Asks the work to stop.
    pub(super) stop: AtomicBool,
    /// Number of steps done, and of all; both 0 outside of the steps.
    done: AtomicU64,
    steps: AtomicU64,
    /// Title of the present stage.
    stage: Mutex<&'static str>,
}

impl Watched {
    /// Title of the present stage, the amount done, and the whole amount; 0 if unknown.
    fn state(&self) -> (&'static str, u64, u64) {
        let stage = *self.stage.lock().unwrap_or_else(PoisonError::into_inner);
        (stage, self.done.load(Ordering::Relaxed), self.steps.load(Ordering::Relaxed))
    }

    /// Begins a stage of `count` pieces, each of which calls [`Self::piece_done`].
    pub(super) fn pieces_of(&self, stage: Stage, count: usize) {
        self.enter(stage.title(), 0, count as u64);
    }

    pub(super) fn piece_done(&self) {
        self.done.fetch_add(1, Ordering::Relaxed);
    }

    fn enter(&self, stage: &'static str, done: u64, steps: u64) {
        *self.stage.lock().unwrap_or_else(PoisonError::into_inner) = stage;
        self.done.store(done, Ordering::Relaxed);
        self.steps.store(steps, Ordering::Relaxed);
    }
}

impl Progress for &Watched {
    fn stage(&mut self, stage: Stage) {
        self.enter(stage.title(), 0, 0);
    }

    fn pieces(&mut self, done: usize, open: usize) {
        self.done.store(done as u64, Ordering::Relaxed);
        self.steps.store((done + open) as u64, Ordering::Relaxed);
    }

    fn march(&mut self, done: u64, steps: u64, _time_step: f64) {
        self.enter("roll", done, steps);
    }

    fn step(&mut self, done: u64) {
        self.done.store(done, Ordering::Relaxed);
    }

    // Notes and warnings of a run are in its summary, too: they are not reported.
}

/// Receiver of the progress, and the last state it was given.
struct Reporter<'a> {
    progress: Option<&'a Py<PyAny>>,
    last: (&'static str, u64, u64),
}

impl Reporter<'_> {
    /// Calls `progress(stage, done, total)` if the state has changed.
    fn report(&mut self, py: Python<'_>, watched: &Watched) -> PyResult<()> {
        let state = watched.state();
        let Some(progress) = self.progress.filter(|_| state != self.last) else { return Ok(()) };
        self.last = state;
        progress.call1(py, state).map(drop)
    }
}

/// Does work on `threads` threads, by default one per processor, without the interpreter's lock.
///
/// # Errors
/// The exception of the work, or the one that stopped it; its attribute `kept` is the folder of an unfinished run, or
/// `None`.
pub(super) fn carried_out<T: Send>(
    py: Python<'_>,
    threads: Option<usize>,
    progress: Option<&Py<PyAny>>,
    work: impl FnOnce(&Watched) -> Result<T, Failure> + Send,
) -> PyResult<T> {
    if let Some(threads) = threads.filter(|threads| !(1..=MOST_THREADS).contains(threads)) {
        let wrong = format!("threads is {threads}: 1 to {MOST_THREADS} are possible");
        return Err(Failure::Argument(wrong).raised(py));
    }
    let pool = ThreadPoolBuilder::new().num_threads(threads.unwrap_or_default()).build();
    let pool = pool.map_err(|error| Failure::Inside(format!("cannot start threads: {error}")).raised(py))?;
    let watched = Watched::default();
    let mut reporter = Reporter { progress, last: watched.state() };
    let (done, stopped) = py.detach(|| {
        pool.in_place_scope(|scope| {
            let (sender, receiver) = channel();
            let watched = &watched;
            // Without a receiver the caller is gone, and the result is not needed.
            scope.spawn(move |_| drop(sender.send(work(watched))));
            let mut stopped: Option<PyErr> = None;
            loop {
                let check = |py: Python<'_>| py.check_signals().and_then(|()| reporter.report(py, watched));
                match receiver.recv_timeout(POLL_INTERVAL) {
                    Err(RecvTimeoutError::Timeout) if stopped.is_some() => {}
                    Err(RecvTimeoutError::Timeout) => {
                        stopped = Python::attach(check).err();
                        watched.stop.store(stopped.is_some(), Ordering::Relaxed);
                    }
                    Ok(done) => {
                        let stopped = stopped.or_else(|| Python::attach(check).err());
                        return (Some(done), stopped);
                    }
                    // The work has panicked; the scope propagates that.
                    Err(RecvTimeoutError::Disconnected) => return (None, stopped),
                }
            }
        })
    });
    match (done, stopped) {
        (Some(done), Some(stopped)) => {
            let partial = done.as_ref().err().and_then(Failure::partial);
            let reported = stopped.value(py).setattr("kept", partial);
            Err(reported.err().unwrap_or(stopped))
        }
        (Some(done), None) => done.map_err(|failure| failure.raised(py)),
        (None, stopped) => Err(stopped.unwrap_or_else(|| Failure::Inside("the work has ended".into()).raised(py))),
    }
}

/// Rows of `columns` numbers each as an array; another total is a [`Failure::Inside`].
pub(super) fn shaped<T>(rows: Vec<Vec<T>>, columns: usize) -> Result<Array2<T>, Failure> {
    let shape = (rows.len(), columns);
    of_shape(rows.into_iter().flatten().collect(), shape)
}

/// An array from its values, row after row; a wrong number of them is a [`Failure::Inside`].
pub(super) fn of_shape<T>(values: Vec<T>, shape: (usize, usize)) -> Result<Array2<T>, Failure> {
    Array2::from_shape_vec(shape, values).map_err(|error| Failure::Inside(error.to_string()))
}
