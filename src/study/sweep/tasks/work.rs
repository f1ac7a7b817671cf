//! Does tasks.
//!
//! A task that is done is skipped; one that was begun continues from its checkpoint; one that another process works on
//! is left to it. A task that fails does not stop the others.

use std::fs::{self, File, TryLockError};
use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use crate::results::ResultsError;
use crate::run::Progress;
use crate::storage::flat_folder;
use crate::study::sweep::run::{Done, VariantOutcome, sweep};
use crate::study::sweep::tasks::folder::TaskFolder;
use crate::study::sweep::tasks::outcomes::{Outcomes, TOGETHER};
use crate::study::sweep::tasks::task::{Task, TaskError};
use crate::study::trial::UNIT;

/// Prefix of the file that a process locks while it does a task; the task's number follows.
const LOCK: &str = "lock-";

/// How tasks are done.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TaskWork {
    /// Threads in all: this many tasks at a time, unless each needs all of them.
    pub threads: usize,
    /// True to keep the results folders of tasks; otherwise only what the tables need stays.
    pub keep_results: bool,
}

/// End of a task.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Ended {
    /// It had been done before.
    Found,
    /// It is done; the text says how far off its load was, if that was missed.
    Done(Option<String>),
    /// The user, or the batch system, stopped it.
    Stopped,
    /// Another process works on it.
    Busy,
    /// It failed, for this reason.
    Failed(String),
}

/// Event of a task.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Event<'a> {
    /// It continues where it had been stopped: simulated time so far and in all \[s\].
    GoesOn([f64; 2]),
    /// Information for the user.
    Note(&'a str),
    /// Something that needs the user's attention.
    Warning(&'a str),
    /// The task has ended.
    Ended(&'a Ended),
}

/// Listener to the events of tasks, by number and name.
pub(crate) type Report<'a> = &'a (dyn Fn(u64, &str, Event<'_>) + Sync);

impl TaskFolder {
    /// Does tasks, several at a time; returns the ends of those that were begun or found, in their order.
    ///
    /// # Errors
    /// [`TaskError::Number`], and the first task that is refused: a changed input, an unusable file.
    pub(crate) fn work(
        &self,
        numbers: &RangeInclusive<u64>,
        work: TaskWork,
        stop: &AtomicBool,
        report: Report<'_>,
    ) -> Result<Vec<Ended>, TaskError> {
        let mut ended = Vec::new();
        for shard in self.shards_of(numbers)? {
            let tasks = self.shard(shard)?;
            let outcomes = Outcomes::of(self, shard, &tasks);
            let worker = Worker { outcomes, unmerged: Mutex::default(), tasks: &tasks, work, stop, report };
            let first = self.numbers(shard).start;
            let wanted: Vec<usize> =
                (0..tasks.len()).filter(|&index| numbers.contains(&(first + index as u64))).collect();
            ended.extend(worker.all(&wanted, first)?);
            worker.join(1)?;
            worker.outcomes.complete()?;
        }
        Ok(ended)
    }
}

/// Does tasks of a shard.
struct Worker<'a> {
    outcomes: Outcomes<'a>,
    /// Results that still are in a file each.
    unmerged: Mutex<Vec<(usize, Done)>>,
    tasks: &'a [Task],
    work: TaskWork,
    stop: &'a AtomicBool,
    report: Report<'a>,
}

impl Worker<'_> {
    /// Does some tasks of the shard; `first` is the number of its first task.
    fn all(&self, wanted: &[usize], first: u64) -> Result<Vec<Ended>, TaskError> {
        let found = self.outcomes.read()?.done;
        let open = wanted.iter().filter(|&&index| found[index].is_none()).count();
        let alone = wanted.iter().any(|&index| self.tasks[index].alone);
        let workers = if alone { 1 } else { self.work.threads.min(open).max(1) };
        let next = AtomicUsize::new(0);
        let ended: Vec<Mutex<Option<Result<Ended, TaskError>>>> = wanted.iter().map(|_| Mutex::new(None)).collect();
        let refused = AtomicBool::new(false);
        let threads_of =
            |worker: usize| self.work.threads / workers + usize::from(worker < self.work.threads % workers);
        std::thread::scope(|scope| {
            for worker in 0..workers {
                let (next, ended, refused, found) = (&next, &ended, &refused, &found);
                let threads = threads_of(worker).max(1);
                scope.spawn(move || {
                    while let Some(place) = Some(next.fetch_add(1, Ordering::Relaxed)).filter(|&at| at < wanted.len()) {
                        let index = wanted[place];
                        if refused.load(Ordering::Relaxed) || self.stop.load(Ordering::Relaxed) {
                            break;
                        }
                        let number = first + index as u64;
                        let how = match found[index] {
                            Some(_) => Ok(Ended::Found),
                            None => self.one(index, number, threads),
                        };
                        match &how {
                            Ok(how) => (self.report)(number, &self.tasks[index].label.name, Event::Ended(how)),
                            Err(_) => refused.store(true, Ordering::Relaxed),
                        }
                        if let Ok(mut slot) = ended[place].lock() {
                            *slot = Some(how);
                        }
                    }
                });
            }
        });
        let ended = ended.into_iter().map(|slot| slot.into_inner().ok().flatten().unwrap_or(Ok(Ended::Stopped)));
        // A refusal after the stop is reported all the same.
        let (mut all, mut refusal) = (Vec::new(), None);
        for how in ended {
            match how {
                Ok(how) => all.push(how),
                Err(error) => refusal = refusal.or(Some(error)),
            }
        }
        refusal.map_or(Ok(all), Err)
    }

    /// Merges the unmerged results, if there are `least` of them.
    fn join(&self, least: usize) -> Result<(), TaskError> {
        let mut unmerged = self.unmerged.lock().unwrap_or_else(PoisonError::into_inner);
        let unmerged = if unmerged.len() >= least { std::mem::take(&mut *unmerged) } else { Vec::new() };
        self.outcomes.join(&unmerged)
    }

    /// Does a task that was not done a moment ago.
    fn one(&self, index: usize, number: u64, threads: usize) -> Result<Ended, TaskError> {
        let task = &self.tasks[index];
        let Some(_lock) = Lock::of(self.outcomes.file(LOCK, index))? else { return Ok(Ended::Busy) };
        if self.outcomes.has(index) {
            return Ok(Ended::Found);
        }
        let variant = task.variant(self.work.keep_results)?;
        let results = self.outcomes.results();
        fs::create_dir_all(&results).map_err(ResultsError::creating(&results))?;
        let mut reporter = Reporter { number, name: &task.label.name, report: self.report, all: 0.0, begun: false };
        let outcome = sweep(std::slice::from_ref(&variant), &results, threads, self.stop, &mut reporter).pop();
        match outcome {
            Some(VariantOutcome::Done(done)) => {
                self.outcomes.keep(index, &done)?;
                if !self.work.keep_results {
                    // A folder that cannot be deleted does no harm.
                    let _ = flat_folder::remove(&results.join(&task.label.name));
                }
                let missed = done.missed_load().map(ToString::to_string);
                self.unmerged.lock().unwrap_or_else(PoisonError::into_inner).push((index, done));
                self.join(TOGETHER)?;
                Ok(Ended::Done(missed))
            }
            Some(VariantOutcome::Failed(error)) => {
                let reason = error.to_string();
                self.outcomes.keep_failure(index, &reason);
                Ok(Ended::Failed(reason))
            }
            Some(VariantOutcome::Stopped) | None => Ok(Ended::Stopped),
        }
    }
}

/// Lock of a task by a file. The lock ends with its holder, even if that is killed; the file then stays.
struct Lock {
    /// Held, not read; `None` where the file system has no locks.
    _file: Option<File>,
    path: PathBuf,
}

impl Lock {
    /// `None` if another process holds it.
    fn of(path: PathBuf) -> Result<Option<Self>, TaskError> {
        let file = File::create(&path).map_err(ResultsError::creating(&path))?;
        match file.try_lock() {
            Ok(()) => Ok(Some(Self { _file: Some(file), path })),
            Err(TryLockError::WouldBlock) => Ok(None),
            Err(TryLockError::Error(_)) => Ok(Some(Self { _file: None, path })),
        }
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // A process that has opened it a moment before holds a file without a name, and finds that the task is done.
        let _ = fs::remove_file(&self.path);
    }
}

/// Forwards the progress of a task's run.
struct Reporter<'a> {
    number: u64,
    name: &'a str,
    report: Report<'a>,
    /// Simulated time in all \[s\].
    all: f64,
    begun: bool,
}

impl Progress for Reporter<'_> {
    fn march(&mut self, _done: u64, units: u64, unit: f64) {
        self.all = units as f64 * unit;
    }

    fn step(&mut self, done: u64) {
        if !self.begun && done > 0 {
            let rolled = done as f64 * UNIT;
            (self.report)(self.number, self.name, Event::GoesOn([rolled, self.all]));
        }
        self.begun = true;
    }

    fn note(&mut self, text: &str) {
        (self.report)(self.number, self.name, Event::Note(text));
    }

    fn warning(&mut self, text: &str) {
        (self.report)(self.number, self.name, Event::Warning(text));
    }
}
