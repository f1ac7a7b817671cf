//! Why a folder of tasks cannot be used.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::results::ResultsError;
use crate::scene::SceneError;
use crate::storage::Unusable;

/// Reasons why tasks cannot be written, done or collected.
#[derive(Debug, Error)]
pub(crate) enum TaskError {
    /// There is no manifest.
    #[error("no tasks: there is no {} (`tyrewave sweep SCENE --speed ... --tasks DIR` writes tasks)", path.display())]
    NoTasks {
        /// The manifest.
        path: PathBuf,
    },
    /// Manifest or tasks are damaged.
    #[error(
        "{} cannot be used: {reason}; delete it, and the command that wrote the tasks writes it again (what is done \
         stays, for outcomes are known by their scenes)",
        path.display()
    )]
    Unusable {
        /// The file.
        path: PathBuf,
        /// Fault of the file.
        reason: Unusable,
    },
    /// Tasks of another version of the program.
    #[error(
        "tyrewave {found} has written the tasks in {}, this is {}; the same bits cannot be promised: use that version, \
         or write the tasks into another folder",
        path.display(),
        env!("CARGO_PKG_VERSION")
    )]
    Program {
        /// The folder.
        path: PathBuf,
        /// The version found.
        found: String,
    },
    /// The folder holds other tasks.
    #[error("{} holds {count} other tasks (\"{title}\"); they are left alone: choose another folder", path.display())]
    Others {
        /// The folder.
        path: PathBuf,
        /// Number of its tasks.
        count: u64,
        /// Title of their scene.
        title: String,
    },
    /// No task has the number.
    #[error("there is no task {number} in {}: they have the numbers 0 to {last}", path.display())]
    Number {
        /// The folder.
        path: PathBuf,
        /// The number asked for.
        number: u64,
        /// Number of the last task.
        last: u64,
    },
    /// A file that the scene reads has changed.
    #[error("task {task}: the file {} has changed since the tasks were written", path.display())]
    Input {
        /// Name of the task.
        task: String,
        /// The file.
        path: PathBuf,
    },
    /// The scene of a task.
    #[error("task {task}: {source}")]
    Scene {
        /// Name of the task.
        task: String,
        /// Fault of the scene.
        source: SceneError,
    },
    /// A file that cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Error of the system.
        source: io::Error,
    },
    /// A file that cannot be written.
    #[error(transparent)]
    Results(#[from] ResultsError),
}

impl TaskError {
    /// Constructor of the error that reading `path` failed, for `map_err`.
    pub(super) fn reading(path: &Path) -> impl FnOnce(io::Error) -> Self + use<'_> {
        move |source| Self::Read { path: path.to_owned(), source }
    }
}
