//! Errors of writing results.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::storage::StateError;

/// Errors of writing results. Most name a path, so that the user knows which disk or permission is meant.
#[derive(Debug, Error)]
pub enum ResultsError {
    /// A folder or file could not be created.
    #[error("cannot create {}: {source}", path.display())]
    Create {
        /// Path that was to be created.
        path: PathBuf,
        /// Error of the file system.
        source: io::Error,
    },
    /// Writing failed half-way: disk full, quota, file system gone.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// Path of the file being written.
        path: PathBuf,
        /// Error of the file system.
        source: io::Error,
    },
    /// An array that is to be held in memory does not fit.
    #[error("there is no room for the {bytes} bytes of {array}; in a folder they go to a file")]
    OutOfMemory {
        /// Name of the array.
        array: &'static str,
        /// Size of the array \[bytes\].
        bytes: f64,
    },
    /// A state that cannot be serialised.
    #[error(transparent)]
    State(#[from] StateError),
    /// The finished folder could not be given its name.
    #[error("cannot rename {} to {}: {source}", from.display(), to.display())]
    Rename {
        /// Present name.
        from: PathBuf,
        /// New name.
        to: PathBuf,
        /// Error of the file system.
        source: io::Error,
    },
    /// The output path ends in `..`, `/` or nothing, and cannot be the name of a folder.
    #[error("{} does not name a folder to write results to: choose another --out, as results/trial", path.display())]
    NoFolderName {
        /// Path given.
        path: PathBuf,
    },
    /// The output path is not a results folder.
    #[error("{} exists and is not a tyrewave results folder; it is left alone (choose another --out)", path.display())]
    NotOurs {
        /// Output path.
        path: PathBuf,
    },
    /// A results folder with files that do not belong to the run.
    #[error(
        "{} holds {entry}, which tyrewave did not write; the folder is left alone \
         (move {entry} away or choose another --out)",
        path.display()
    )]
    ForeignEntry {
        /// Output path.
        path: PathBuf,
        /// Name of the file or folder that tyrewave did not write.
        entry: String,
    },
    /// Something appeared at the output path during the run.
    #[error("{0}; that came there while the results were made")]
    Overtaken(Box<ResultsError>),
    /// A row of another length than the array's.
    #[error("{}: a row of {got} numbers in an array of {expected} columns", path.display())]
    RowLength {
        /// Path of the array's file.
        path: PathBuf,
        /// Number of columns of the array.
        expected: usize,
        /// Length of the row.
        got: usize,
    },
    /// An array to be continued is not the one that was begun.
    #[error(
        "{} is not the array that was begun: it lacks some of its first {rows} rows, or has another type or width",
        path.display()
    )]
    NotThisArray {
        /// Path of the array's file.
        path: PathBuf,
        /// Number of rows that it must have.
        rows: u64,
    },
    /// A summary that cannot be written as JSON.
    #[error("cannot write {} as JSON: {source}", path.display())]
    Json {
        /// Path of the summary.
        path: PathBuf,
        /// Error of the serialiser.
        source: serde_json::Error,
    },
    /// A sound that cannot be written as a file.
    #[error("cannot make {}: {source}", path.display())]
    Audio {
        /// Path of the sound file.
        path: PathBuf,
        /// Fault found in the sound.
        source: Box<crate::sound::WavError>,
    },
}

impl ResultsError {
    /// True for errors of the request, found before anything was tried: foreign files at the output path, a path
    /// without a name, an array that is not the one to continue.
    pub fn is_refusal(&self) -> bool {
        matches!(
            self,
            Self::NotOurs { .. } | Self::ForeignEntry { .. } | Self::NoFolderName { .. } | Self::NotThisArray { .. }
        )
    }

    /// Error of writing to `path`, for `map_err`.
    pub fn writing(path: &Path) -> impl FnOnce(io::Error) -> Self + use<'_> {
        move |source| Self::Write { path: path.to_owned(), source }
    }

    /// Error of creating `path`, for `map_err`.
    pub fn creating(path: &Path) -> impl FnOnce(io::Error) -> Self + use<'_> {
        move |source| Self::Create { path: path.to_owned(), source }
    }
}
