//! `checkpoint`: the state of an unfinished run, beside its arrays.
//!
//! A sealed file (`crate::storage::sealed_file`). It gets its name when it is on the disk: at any moment, also after
//! a power cut or with a full disk, there is a whole checkpoint, the new one or the one before. The arrays are brought
//! to the disk before it, so they hold at least the rows that it counts, whose checksums it holds; anything behind
//! those is cut off.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use serde::Serialize;
use thiserror::Error;

use super::disk::sync_folder;
use super::error::ResultsError;
use crate::storage::sealed_file::{self, Body, Format};
use crate::storage::{PendingFile, StateError};

/// Name of the checkpoint in the folder of an unfinished run.
pub(crate) const CHECKPOINT_FILE: &str = "checkpoint";
/// Name while it is being written; only one process writes to the folder.
pub(super) const TEMPORARY_FILE: &str = "checkpoint.tmp";
/// Name of the effective scene in the folder of an unfinished run.
pub(crate) const SCENE_FILE: &str = "scene.toml";
/// Its version must be raised whenever the meaning of a state changes.
const FORMAT: Format = Format { magic: b"TWAVECHK", version: 18, name: "a checkpoint" };

/// Reason why a run cannot be resumed.
#[derive(Debug, Error)]
pub enum CheckpointError {
    /// No unfinished run of that name.
    #[error(
        "nothing to resume: there is no unfinished run {0} (looked for {0}.partial and {0}.partial-*)",
        path.display()
    )]
    Nothing {
        /// Path given by the caller.
        path: PathBuf,
    },
    /// The run has reached its end.
    #[error("nothing to resume: {} is complete", path.display())]
    Complete {
        /// Path of the results.
        path: PathBuf,
    },
    /// Stopped before the first checkpoint.
    #[error(
        "{} holds no checkpoint: the run was stopped before its first one; start it again with `tyrewave run`",
        path.display()
    )]
    NoCheckpoint {
        /// Folder of the unfinished run.
        path: PathBuf,
    },
    /// More than one unfinished run of that name.
    #[error("several runs of that name are unfinished, name one of them: {}", listed(found))]
    Several {
        /// Folders of these runs.
        found: Vec<PathBuf>,
    },
    /// Another process is writing to its folder.
    #[error("{} is being written by a process that is still running", path.display())]
    Running {
        /// Folder of the unfinished run.
        path: PathBuf,
    },
    /// The file is not a valid checkpoint of the run.
    #[error("{} cannot be used: {reason}", path.display())]
    Unusable {
        /// Path of the checkpoint.
        path: PathBuf,
        /// Fault found.
        reason: CheckpointFault,
    },
    /// An array does not hold what was written to it.
    #[error("{} is damaged: its first {rows} rows are not those that the run had written", path.display())]
    Array {
        /// Path of the array's file.
        path: PathBuf,
        /// Number of rows that it must have.
        rows: u64,
    },
    /// A file or folder cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Io {
        /// Path of the file or folder.
        path: PathBuf,
        /// Error of the file system.
        source: std::io::Error,
    },
}

/// Fault of a checkpoint; its message describes it.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error(transparent)]
pub struct CheckpointFault(#[from] pub(crate) UnusableCheckpoint);

/// Faults of a checkpoint.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub(crate) enum UnusableCheckpoint {
    /// Fault of the sealed file.
    #[error(transparent)]
    File(#[from] sealed_file::Unusable),
    /// Written by another version of the program.
    #[error("tyrewave {found} has written it, this is {}; the same bits cannot be promised", env!("CARGO_PKG_VERSION"))]
    Program {
        /// Version of that program.
        found: String,
    },
    /// Belongs to another scene.
    #[error("it belongs to another scene than the {SCENE_FILE} beside it")]
    Scene,
    /// A file that the scene reads has another content.
    #[error("the file {} has changed since the run began", file.display())]
    Input {
        /// Path of the file.
        file: PathBuf,
    },
    /// The influence functions have other bits here.
    #[error("the tyre's influence functions come out differently here: another machine or library")]
    Influence,
    /// A valid file whose state does not fit the run.
    #[error("{0}")]
    State(#[from] StateError),
}

fn listed(paths: &[PathBuf]) -> String {
    paths.iter().map(|path| path.display().to_string()).collect::<Vec<_>>().join(", ")
}

/// Writes a value as the checkpoint of a folder; the one before stays whole until then.
///
/// # Errors
/// [`ResultsError::Write`].
pub(crate) fn write(folder: &Path, value: &impl Serialize) -> Result<(), ResultsError> {
    let path = folder.join(CHECKPOINT_FILE);
    PendingFile::create_as(&path, ".tmp")
        .and_then(|file| FORMAT.write(file, value))
        .map_err(ResultsError::writing(&path))?;
    sync_folder(folder).map_err(ResultsError::writing(folder))
}

/// Reads a folder's checkpoint.
///
/// # Errors
/// [`CheckpointError::NoCheckpoint`], [`CheckpointError::Io`], [`CheckpointError::Unusable`].
pub fn read(folder: &Path) -> Result<Body, CheckpointError> {
    let path = folder.join(CHECKPOINT_FILE);
    let body = FORMAT.read(&path).map_err(|source| match source.kind() {
        ErrorKind::NotFound => CheckpointError::NoCheckpoint { path: folder.to_owned() },
        _ => CheckpointError::Io { path: path.clone(), source },
    })?;
    body.map_err(|reason| CheckpointError::Unusable { path, reason: UnusableCheckpoint::from(reason).into() })
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn a_checkpoint_that_cannot_be_written_leaves_the_one_before() {
        let folder = tempfile::tempdir().unwrap();
        write(folder.path(), &"first").unwrap();
        // A folder in place of the temporary file has the effect of a disk that refuses it.
        fs::create_dir(folder.path().join(TEMPORARY_FILE)).unwrap();
        assert!(write(folder.path(), &"second").is_err());
        assert_eq!(read(folder.path()).unwrap().finish::<String>().unwrap(), "first");
        let empty = tempfile::tempdir().unwrap();
        assert!(matches!(read(empty.path()), Err(CheckpointError::NoCheckpoint { .. })));
    }
}
