//! What tasks have found.
//!
//! A task that is done leaves a small file. A million of those are more than a shared disk likes: once all tasks of a
//! shard are done they become one file, by whoever sees it first. That file has its name before the small ones go, and
//! whoever misses one of those looks at it again: at any moment every outcome is found, however many collect at once.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use crate::storage::flat_folder::entries;
use crate::storage::sealed_file::Body;
use crate::storage::{Format, Unusable};
use crate::study::sweep::run::Done;
use crate::study::sweep::tasks::error::TaskError;
use crate::study::sweep::tasks::folder::{TaskFolder, write_sealed};
use crate::study::sweep::tasks::task::Task;

/// Name of all outcomes of a shard.
const OUTCOMES: &str = "outcomes";
const OUTCOMES_FORMAT: Format = Format { magic: b"TWAVEOUS", version: 1, name: "outcomes of tasks" };
/// Name of one outcome, before the task's number.
const OUTCOME: &str = "outcome-";
const OUTCOME_FORMAT: Format = Format { magic: b"TWAVEOUT", version: 1, name: "an outcome of a task" };
/// Name of the reason why a task has failed, before the task's number.
const FAILED: &str = "failed-";
/// Name of the folder that runs are in.
const RESULTS: &str = "results";

/// The outcomes of a shard's tasks.
pub struct Outcomes<'a> {
    folder: PathBuf,
    /// Number of the first task.
    first: u64,
    tasks: &'a [Task],
}

/// What is there of a shard.
#[derive(Debug, Default)]
pub struct Found {
    /// What each task has found, in their order.
    pub done: Vec<Option<Done>>,
    /// Files that are there and cannot be used: their tasks are to be done again.
    pub unusable: Vec<(PathBuf, Unusable)>,
}

impl<'a> Outcomes<'a> {
    /// Of a shard and its tasks.
    pub fn of(folder: &TaskFolder, shard: u64, tasks: &'a [Task]) -> Self {
        Self { folder: folder.shard_folder(shard), first: folder.numbers(shard).start, tasks }
    }

    /// Where the runs of the shard's tasks are.
    pub fn results(&self) -> PathBuf {
        self.folder.join(RESULTS)
    }

    /// The file that belongs to a task of the shard, counted from its first.
    pub(super) fn file(&self, prefix: &str, index: usize) -> PathBuf {
        self.folder.join(format!("{prefix}{}", self.first + index as u64))
    }

    /// All that is there.
    ///
    /// # Errors
    /// [`TaskError::Read`].
    pub fn read(&self) -> Result<Found, TaskError> {
        let mut unusable = Vec::new();
        if let Some(done) = self.read_all(&mut unusable)? {
            return Ok(Found { done, unusable });
        }
        let there = entries(&self.folder).map_err(TaskError::reading(&self.folder))?;
        let mut done = vec![None; self.tasks.len()];
        let mut vanished = false;
        for name in there {
            let number = name.strip_prefix(OUTCOME).and_then(|number| number.parse::<u64>().ok());
            let index = number.and_then(|number| usize::try_from(number.checked_sub(self.first)?).ok());
            let Some(index) = index.filter(|&index| index < self.tasks.len()) else { continue };
            done[index] = self.read_one(index, &mut unusable)?;
            vanished |= done[index].is_none();
        }
        if vanished || done.iter().any(Option::is_none) {
            // Somebody else may have made one file of them meanwhile.
            if let Some(done) = self.read_all(&mut Vec::new())? {
                return Ok(Found { done, unusable: Vec::new() });
            }
        }
        Ok(Found { done, unusable })
    }

    /// What one task of the shard has found, if it is done.
    ///
    /// # Errors
    /// [`TaskError::Read`].
    pub fn read_task(&self, index: usize) -> Result<Option<Done>, TaskError> {
        match self.read_one(index, &mut Vec::new())? {
            Some(done) => Ok(Some(done)),
            None => Ok(self.read_all(&mut Vec::new())?.and_then(|mut done| done.swap_remove(index))),
        }
    }

    fn read_one(&self, index: usize, unusable: &mut Vec<(PathBuf, Unusable)>) -> Result<Option<Done>, TaskError> {
        let content = |body: Body| {
            let (id, done): (String, Done) = body.finish()?;
            if id == self.tasks[index].id { Ok(done) } else { Err(Unusable::Key) }
        };
        read(&OUTCOME_FORMAT, &self.file(OUTCOME, index), content, unusable)
    }

    fn read_all(&self, unusable: &mut Vec<(PathBuf, Unusable)>) -> Result<Option<Vec<Option<Done>>>, TaskError> {
        let content = |body: Body| {
            let all: Vec<(String, Done)> = body.finish()?;
            let ours =
                all.len() == self.tasks.len() && all.iter().zip(self.tasks).all(|((id, _), task)| *id == task.id);
            if ours { Ok(all.into_iter().map(|(_, done)| Some(done)).collect()) } else { Err(Unusable::Key) }
        };
        read(&OUTCOMES_FORMAT, &self.folder.join(OUTCOMES), content, unusable)
    }

    /// Keeps what a task of the shard has found.
    ///
    /// # Errors
    /// [`TaskError::Results`].
    pub fn keep(&self, index: usize, done: &Done) -> Result<(), TaskError> {
        write_sealed(&OUTCOME_FORMAT, &self.file(OUTCOME, index), &(&self.tasks[index].id, done))?;
        // A reason of an earlier attempt.
        let _ = fs::remove_file(self.file(FAILED, index));
        Ok(())
    }

    /// Keeps the reason why a task of the shard has failed, for whoever collects; what cannot be kept has been told.
    pub fn keep_failure(&self, index: usize, reason: &str) {
        let _ = fs::write(self.file(FAILED, index), reason);
    }

    /// Why a task of the shard has failed the last time, where it has.
    pub fn failure(&self, index: usize) -> Option<String> {
        let bytes = fs::read(self.file(FAILED, index)).ok()?;
        Some(String::from_utf8_lossy(&bytes).into_owned())
    }

    /// Makes one file of all outcomes, if all are there and are not one file already.
    ///
    /// # Errors
    /// [`TaskError::Read`], [`TaskError::Results`].
    pub fn compact(&self) -> Result<(), TaskError> {
        let there = entries(&self.folder).map_err(TaskError::reading(&self.folder))?;
        if there.iter().filter(|name| name.starts_with(OUTCOME)).count() < self.tasks.len() {
            return Ok(());
        }
        let found = self.read()?;
        let ids = self.tasks.iter().map(|task| task.id.as_str());
        let all: Option<Vec<(&str, Done)>> = ids.zip(found.done).map(|(id, done)| Some((id, done?))).collect();
        if let Some(all) = all {
            write_sealed(&OUTCOMES_FORMAT, &self.folder.join(OUTCOMES), &all)?;
            for index in 0..self.tasks.len() {
                // Whoever collects at the same time may have removed it.
                let _ = fs::remove_file(self.file(OUTCOME, index));
            }
            // Unless results are kept it is empty.
            let _ = fs::remove_dir(self.results());
        }
        Ok(())
    }
}

/// What a sealed file holds; `None` where there is none, or one that cannot be used.
fn read<T>(
    format: &Format,
    path: &Path,
    content: impl FnOnce(Body) -> Result<T, Unusable>,
    unusable: &mut Vec<(PathBuf, Unusable)>,
) -> Result<Option<T>, TaskError> {
    match format.read(path) {
        Ok(body) => Ok(body.and_then(content).map_err(|reason| unusable.push((path.to_owned(), reason))).ok()),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        Err(source) => Err(TaskError::Read { path: path.to_owned(), source }),
    }
}
