//! The tasks on disk.

use std::fs;
use std::io::ErrorKind;
use std::ops::{Range, RangeInclusive};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::numeric::digest::sha256;
use crate::numeric::in_parallel;
use crate::results::ResultsError;
use crate::results::inputs::Inputs;
use crate::storage::{Format, PendingFile, Unusable};
use crate::study::sweep::tasks::task::{Task, TaskError, inputs_of};
use crate::study::sweep::variants::Variant;

/// Name of the manifest.
const MANIFEST: &str = "manifest";
const MANIFEST_FORMAT: Format = Format { magic: b"TWAVETSK", version: 1, name: "a manifest of tasks" };
/// Name of the file of a shard's tasks in its folder.
const TASKS: &str = "tasks";
const TASKS_FORMAT: Format = Format { magic: b"TWAVESHD", version: 2, name: "a shard of tasks" };
/// Tasks in a shard. A million tasks make a thousand files, and one task is found by reading a few megabytes.
const SHARD: u64 = 1000;

/// Content of the manifest beside the program's version.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub(crate) struct Manifest {
    /// Title of the swept scene.
    pub title: String,
    /// True if the scene wants pictures.
    pub plots: bool,
    /// Number of tasks.
    pub count: u64,
    /// SHA-256 of the ids of all tasks.
    digest: String,
    /// Number of tasks that job files give to an element of their array.
    pub chunk: u64,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TaskFolder {
    pub path: PathBuf,
    pub manifest: Manifest,
}

/// Tasks that have been written, or were there already.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Written {
    /// Where they are.
    pub folder: TaskFolder,
    /// True if they were there already.
    pub found: bool,
    /// Longest time that the plan of a task expects on one thread \[s\], and the sum over all tasks.
    pub seconds: [f64; 2],
    /// Largest memory that the plan of a task expects \[bytes\].
    pub memory: f64,
    /// True if tasks are done one after the other, see [`Task::alone`].
    pub alone: bool,
}

impl TaskFolder {
    /// Writes the variants of a scene with that title as tasks. `chunk` gives, from the number of tasks and the longest
    /// time of one \[s\], how many tasks job files give to an element of their array; `jobs` writes those files, before
    /// the manifest, which is last.
    ///
    /// # Errors
    /// [`TaskError::Others`] if other tasks are there, [`TaskError::Unusable`] or [`TaskError::Program`] if what is
    /// there cannot be identified, and errors of files.
    pub(crate) fn write<E: From<TaskError>>(
        path: &Path,
        (title, plots): (&str, bool),
        variants: &[Variant],
        chunk: impl FnOnce(u64, f64) -> u64,
        jobs: impl FnOnce(&Written) -> Result<(), E>,
    ) -> Result<Written, E> {
        let present = match Self::open(path) {
            Ok(folder) => Some(folder),
            Err(TaskError::NoTasks { .. }) => None,
            Err(error) => return Err(error.into()),
        };
        let tasks = tasks(variants)?;
        let largest = |of: fn(&Task) -> f64| tasks.iter().map(of).fold(0.0, f64::max);
        let (count, longest) = (tasks.len() as u64, largest(|task| task.seconds));
        let ids: Vec<&str> = tasks.iter().map(|task| task.id.as_str()).collect();
        let manifest =
            Manifest { title: title.to_owned(), plots, count, digest: sha256(&ids), chunk: chunk(count, longest) };
        let folder = Self { path: path.to_owned(), manifest };
        if let Some(Self { manifest: other, .. }) = &present
            && (&other.digest, other.count) != (&folder.manifest.digest, count)
        {
            let (path, title) = (path.to_owned(), other.title.clone());
            return Err(TaskError::Others { path, count: other.count, title }.into());
        }
        for (shard, tasks) in tasks.chunks(SHARD as usize).enumerate() {
            folder.write_shard(shard as u64, tasks)?;
        }
        let seconds = [longest, tasks.iter().map(|task| task.seconds).sum()];
        let (memory, alone) = (largest(|task| task.memory), tasks.iter().any(|task| task.alone));
        let written = Written { folder, found: present.is_some(), seconds, memory, alone };
        jobs(&written)?;
        let content = (env!("CARGO_PKG_VERSION"), &written.folder.manifest);
        write_sealed(&MANIFEST_FORMAT, &path.join(MANIFEST), &content)?;
        Ok(written)
    }

    /// Writes the tasks of a shard, unless the same are there.
    fn write_shard(&self, shard: u64, tasks: &[Task]) -> Result<(), TaskError> {
        let folder = self.shard_folder(shard);
        fs::create_dir_all(&folder).map_err(ResultsError::creating(&folder))?;
        let same = |one: &Task, other: &Task| (&one.id, &one.label) == (&other.id, &other.label);
        match self.shard(shard) {
            Ok(there) if there.len() == tasks.len() && there.iter().zip(tasks).all(|(a, b)| same(a, b)) => Ok(()),
            _ => write_sealed(&TASKS_FORMAT, &folder.join(TASKS), &tasks),
        }
    }

    /// Opens a folder of tasks.
    ///
    /// # Errors
    /// [`TaskError::NoTasks`], [`TaskError::Unusable`], [`TaskError::Program`], [`TaskError::Read`].
    pub(crate) fn open(path: &Path) -> Result<Self, TaskError> {
        let file = path.join(MANIFEST);
        let unusable = |reason| TaskError::Unusable { path: file.clone(), reason };
        let mut body = match MANIFEST_FORMAT.read(&file) {
            Ok(body) => body.map_err(unusable)?,
            Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {
                return Err(TaskError::NoTasks { path: file });
            }
            Err(source) => return Err(TaskError::Read { path: file, source }),
        };
        let program: String = body.take().map_err(unusable)?;
        if program != env!("CARGO_PKG_VERSION") {
            return Err(TaskError::Program { path: path.to_owned(), found: program });
        }
        Ok(Self { path: path.to_owned(), manifest: body.finish().map_err(unusable)? })
    }

    pub(crate) fn shards(&self) -> u64 {
        self.manifest.count.div_ceil(SHARD)
    }

    pub(crate) fn numbers(&self, shard: u64) -> Range<u64> {
        shard * SHARD..((shard + 1) * SHARD).min(self.manifest.count)
    }

    /// Shards that hold a range of tasks.
    ///
    /// # Errors
    /// [`TaskError::Number`] for the first number that no task has.
    pub(crate) fn shards_of(&self, numbers: &RangeInclusive<u64>) -> Result<RangeInclusive<u64>, TaskError> {
        match [*numbers.start(), *numbers.end()].into_iter().find(|&number| number >= self.manifest.count) {
            Some(number) => {
                let last = self.manifest.count.saturating_sub(1);
                Err(TaskError::Number { path: self.path.clone(), number, last })
            }
            None => Ok(numbers.start() / SHARD..=numbers.end() / SHARD),
        }
    }

    pub(super) fn shard_folder(&self, shard: u64) -> PathBuf {
        self.path.join(format!("shard-{shard:04}"))
    }

    pub(crate) fn shard(&self, shard: u64) -> Result<Vec<Task>, TaskError> {
        let path = self.shard_folder(shard).join(TASKS);
        let unusable = |reason| TaskError::Unusable { path: path.clone(), reason };
        let body = TASKS_FORMAT.read(&path).map_err(TaskError::reading(&path))?.map_err(unusable)?;
        let tasks: Vec<Task> = body.finish().map_err(unusable)?;
        let numbers = self.numbers(shard);
        if tasks.len() as u64 == numbers.end - numbers.start { Ok(tasks) } else { Err(unusable(Unusable::Key)) }
    }
}

fn tasks(variants: &[Variant]) -> Result<Vec<Task>, TaskError> {
    let mut known = Inputs::default();
    let mut read = Vec::new();
    for variant in variants {
        read.push((variant, inputs_of(&variant.plan.scene, &mut known)?));
    }
    in_parallel::map(&read, |(variant, inputs)| Task::of(variant, inputs.clone())).into_iter().collect()
}

/// Writes a sealed file atomically: it is there as a whole or not at all.
pub(super) fn write_sealed(format: &Format, path: &Path, value: &impl Serialize) -> Result<(), TaskError> {
    let file = PendingFile::create(path).map_err(ResultsError::creating(path))?;
    Ok(format.write(file, value).map_err(ResultsError::writing(path))?)
}
