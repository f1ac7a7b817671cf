//! Outcomes of tasks.
//!
//! A task that is done leaves a small file. A million of those overload a shared disk: a process that does many tasks
//! merges each 64 that it has written into one file, and once all tasks of a shard are done the first process that
//! notices merges them. A file that replaces others gets its name before those are deleted, and a reader that misses
//! one of them looks again: at any moment every outcome is found, however many processes write and collect at once.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use crate::numeric::digest::sha256;
use crate::storage::flat_folder::entries;
use crate::storage::{Format, Unusable};
use crate::study::sweep::run::Done;
use crate::study::sweep::tasks::folder::{TaskFolder, write_sealed};
use crate::study::sweep::tasks::task::{Task, TaskError};

/// Number of outcomes of one process that are merged into one file.
pub(super) const TOGETHER: usize = 64;
/// Name of the file with all outcomes of a shard; a file with some of them appends their count and digest.
const OUTCOMES: &str = "outcomes";
/// Prefix of the name of a file with one outcome; the task's number follows.
const OUTCOME: &str = "outcome-";
const FORMAT: Format = Format { magic: b"TWAVEOUT", version: 3, name: "outcomes of tasks" };
/// Prefix of the name of a file with the reason why a task failed; the task's number follows.
const FAILED: &str = "failed-";
/// Name of the folder of the runs.
const RESULTS: &str = "results";
/// Most attempts to read all files, since another process may merge some of them meanwhile.
const ATTEMPTS: usize = 100;

/// An outcome in a file: index of the task in its shard, its id, its results.
type Entry = (usize, String, Done);

/// The outcomes of a shard's tasks.
pub(crate) struct Outcomes<'a> {
    folder: PathBuf,
    /// Number of the first task.
    first: u64,
    tasks: &'a [Task],
}

/// Outcomes of a shard, as read.
#[derive(Debug, Default)]
pub(crate) struct Found {
    /// Results of each task, in their order.
    pub done: Vec<Option<Done>>,
    /// Files that cannot be used: their tasks have to be done again, unless another file has them.
    pub unusable: Vec<(PathBuf, Unusable)>,
}

impl<'a> Outcomes<'a> {
    pub(crate) fn of(folder: &TaskFolder, shard: u64, tasks: &'a [Task]) -> Self {
        Self { folder: folder.shard_folder(shard), first: folder.numbers(shard).start, tasks }
    }

    /// Folder of the runs of the shard's tasks.
    pub(crate) fn results(&self) -> PathBuf {
        self.folder.join(RESULTS)
    }

    /// File of a task; `index` counts from the shard's first task.
    pub(super) fn file(&self, prefix: &str, index: usize) -> PathBuf {
        self.folder.join(format!("{prefix}{}", self.first + index as u64))
    }

    /// Reads all outcomes; again if a file vanishes meanwhile.
    ///
    /// # Errors
    /// [`TaskError::Read`].
    pub(crate) fn read(&self) -> Result<Found, TaskError> {
        let mut found = Found::default();
        for _ in 0..ATTEMPTS {
            found = Found { done: vec![None; self.tasks.len()], unusable: Vec::new() };
            let mut vanished = false;
            for name in self.names()? {
                vanished |= !self.add(&name, &mut found)?;
            }
            if !vanished || found.is_complete() {
                break;
            }
        }
        Ok(found)
    }

    fn names(&self) -> Result<Vec<String>, TaskError> {
        let mut names = entries(&self.folder).map_err(TaskError::reading(&self.folder))?;
        names.retain(|name| [OUTCOME, OUTCOMES].iter().any(|prefix| name.starts_with(prefix)) && !name.contains('.'));
        Ok(names)
    }

    /// Adds the content of a file; false if the file is gone.
    fn add(&self, name: &str, found: &mut Found) -> Result<bool, TaskError> {
        let path = self.folder.join(name);
        let entries: Result<Vec<Entry>, Unusable> = match FORMAT.read(&path) {
            Ok(body) => body.and_then(|body| body.finish()),
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(false),
            Err(source) => return Err(TaskError::Read { path, source }),
        };
        match entries {
            Ok(entries) => {
                for (index, id, done) in entries {
                    match self.tasks.get(index) {
                        Some(task) if task.id == id => found.done[index] = Some(done),
                        _ => found.unusable.push((path.clone(), Unusable::Key)),
                    }
                }
            }
            Err(reason) => found.unusable.push((path, reason)),
        }
        Ok(true)
    }

    /// True if another process has done a task and its outcome is not merged with others yet.
    pub(crate) fn has(&self, index: usize) -> bool {
        let mut found = Found { done: vec![None; self.tasks.len()], unusable: Vec::new() };
        let name = format!("{OUTCOME}{}", self.first + index as u64);
        self.add(&name, &mut found).is_ok_and(|there| there && found.done[index].is_some())
    }

    /// Writes the results of a task of the shard.
    ///
    /// # Errors
    /// [`TaskError::Results`].
    pub(crate) fn keep(&self, index: usize, done: &Done) -> Result<(), TaskError> {
        self.write(&self.file(OUTCOME, index), [(index, done)])?;
        // Removes the reason of an earlier failure.
        let _ = fs::remove_file(self.file(FAILED, index));
        Ok(())
    }

    /// Merges what this process has written by [`Self::keep`] into one file.
    ///
    /// # Errors
    /// [`TaskError::Results`].
    pub(crate) fn join(&self, results: &[(usize, Done)]) -> Result<(), TaskError> {
        if results.len() < 2 {
            return Ok(());
        }
        let ids: Vec<&str> = results.iter().map(|(index, _)| self.tasks[*index].id.as_str()).collect();
        // Other processes may merge others, but equal names have equal contents.
        let name = format!("{OUTCOMES}-{}-{}", results.len(), sha256(&ids));
        self.write(&self.folder.join(name), results.iter().map(|(index, done)| (*index, done)))?;
        for (index, _) in results {
            // A process that has merged the whole shard may have removed it.
            let _ = fs::remove_file(self.file(OUTCOME, *index));
        }
        Ok(())
    }

    fn write<'d>(&self, path: &Path, done: impl IntoIterator<Item = (usize, &'d Done)>) -> Result<(), TaskError> {
        let entry = |(index, done): (usize, &'d Done)| (index, self.tasks[index].id.as_str(), done);
        write_sealed(&FORMAT, path, &done.into_iter().map(entry).collect::<Vec<_>>())
    }

    /// Writes the reason why a task of the shard has failed, for the collection; a failure of this is ignored, since
    /// the reason has been reported.
    pub(crate) fn keep_failure(&self, index: usize, reason: &str) {
        let _ = fs::write(self.file(FAILED, index), reason);
    }

    /// Why the last attempt of a task failed; `None` if it did not.
    pub(crate) fn failure(&self, index: usize) -> Option<String> {
        let bytes = fs::read(self.file(FAILED, index)).ok()?;
        Some(String::from_utf8_lossy(&bytes).into_owned())
    }

    /// Merges all outcomes if the names of the files say that all may be there.
    ///
    /// # Errors
    /// As [`Self::collect`].
    pub(crate) fn complete(&self) -> Result<(), TaskError> {
        let count = |name: &String| match name.strip_prefix(OUTCOMES) {
            Some(rest) => rest.split('-').nth(1).map_or(Some(0), |count| count.parse::<usize>().ok()).unwrap_or(0),
            None => 1,
        };
        let counted: usize = self.names()?.iter().map(count).sum();
        if counted >= self.tasks.len() { self.collect().map(drop) } else { Ok(()) }
    }

    /// Reads all outcomes, and merges them into one file once they are complete.
    ///
    /// # Errors
    /// [`TaskError::Read`], [`TaskError::Results`].
    pub(crate) fn collect(&self) -> Result<Found, TaskError> {
        let found = self.read()?;
        let names = self.names()?;
        if !found.is_complete() || names == [OUTCOMES] {
            return Ok(found);
        }
        let done = found.done.iter().enumerate();
        self.write(&self.folder.join(OUTCOMES), done.filter_map(|(index, done)| Some((index, done.as_ref()?))))?;
        for name in names.iter().filter(|name| *name != OUTCOMES) {
            // Another process that collects may have removed it.
            let _ = fs::remove_file(self.folder.join(name));
        }
        // It is empty, unless results folders are retained.
        let _ = fs::remove_dir(self.results());
        Ok(found)
    }
}

impl Found {
    fn is_complete(&self) -> bool {
        self.done.iter().all(Option::is_some)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::summary::LoadResult;

    const COUNT: usize = 12;

    fn tasks() -> Vec<Task> {
        (0..COUNT).map(|index| Task::example(&format!("scene {index}"))).collect()
    }

    /// Results of a task, distinct by its number.
    fn done(index: usize) -> Done {
        let load = LoadResult { wanted: 0.1 + index as f64, relative_error: 1.0 / 3.0, tolerance: 0.01, met: false };
        Done { load: Some(load), ..Done::default() }
    }

    fn of<'a>(folder: &Path, tasks: &'a [Task]) -> Outcomes<'a> {
        Outcomes { folder: folder.to_owned(), first: 3000, tasks }
    }

    fn names(folder: &Path) -> Vec<String> {
        let mut names = entries(folder).unwrap();
        names.sort();
        names
    }

    #[test]
    fn outcomes_are_found_in_one_file_in_some_and_in_many() {
        let (folder, tasks) = (tempfile::tempdir().unwrap(), tasks());
        let outcomes = of(folder.path(), &tasks);
        let known = |wanted: &[usize]| {
            let found = outcomes.read().unwrap();
            assert!(found.unusable.is_empty());
            let expected = (0..COUNT).map(|index| wanted.contains(&index).then(|| done(index)));
            assert_eq!(found.done, expected.collect::<Vec<_>>());
        };
        known(&[]);
        for index in [0, 5, 7] {
            outcomes.keep(index, &done(index)).unwrap();
            assert!(outcomes.has(index) && !outcomes.has(index + 1));
        }
        known(&[0, 5, 7]);
        assert_eq!(names(folder.path()), ["outcome-3000", "outcome-3005", "outcome-3007"]);
        outcomes.join(&[(0, done(0)), (7, done(7))]).unwrap();
        known(&[0, 5, 7]);
        assert_eq!(names(folder.path()).len(), 2);
        outcomes.complete().unwrap();
        known(&[0, 5, 7]);
        for index in 0..COUNT {
            outcomes.keep(index, &done(index)).unwrap();
        }
        outcomes.complete().unwrap();
        assert_eq!(names(folder.path()), ["outcomes"]);
        known(&(0..COUNT).collect::<Vec<_>>());
        // What comes later does no harm and is removed by the next collection.
        outcomes.keep(3, &done(3)).unwrap();
        known(&(0..COUNT).collect::<Vec<_>>());
        outcomes.collect().unwrap();
        assert_eq!(names(folder.path()), ["outcomes"]);
    }

    #[test]
    fn whoever_reads_while_others_join_and_collect_misses_nothing() {
        let (folder, tasks) = (tempfile::tempdir().unwrap(), tasks());
        let read = || {
            let found = of(folder.path(), &tasks).read().unwrap();
            found.done.iter().filter(|done| done.is_some()).count()
        };
        for _ in 0..20 {
            for index in 0..COUNT {
                of(folder.path(), &tasks).keep(index, &done(index)).unwrap();
            }
            std::thread::scope(|scope| {
                let halves = [0..COUNT / 2, COUNT / 2..COUNT];
                for half in halves {
                    let results: Vec<_> = half.map(|index| (index, done(index))).collect();
                    let tasks = &tasks;
                    let folder = folder.path();
                    scope.spawn(move || of(folder, tasks).join(&results).unwrap());
                }
                for _ in 0..2 {
                    scope.spawn(|| assert!(of(folder.path(), &tasks).collect().unwrap().is_complete()));
                }
                for _ in 0..20 {
                    assert_eq!(read(), COUNT);
                }
            });
            of(folder.path(), &tasks).collect().unwrap();
            assert_eq!(names(folder.path()), ["outcomes"]);
            fs::remove_file(folder.path().join("outcomes")).unwrap();
        }
    }

    #[test]
    fn what_others_have_found_or_nobody_can_read_is_not_taken() {
        let (folder, tasks) = (tempfile::tempdir().unwrap(), tasks());
        let outcomes = of(folder.path(), &tasks);
        let mut others = tasks.clone();
        others[2].id = "another".to_owned();
        of(folder.path(), &others).keep(2, &done(2)).unwrap();
        outcomes.keep(4, &done(4)).unwrap();
        let path = folder.path().join("outcome-3004");
        let whole = fs::read(&path).unwrap();
        for at in 0..whole.len() {
            let mut bytes = whole.clone();
            bytes[at] ^= 1;
            fs::write(&path, bytes).unwrap();
            let found = outcomes.read().unwrap();
            assert!(found.done.iter().all(Option::is_none) && found.unusable.len() == 2, "byte {at}");
        }
        assert!(!outcomes.has(4) && !outcomes.has(2));
    }
}
