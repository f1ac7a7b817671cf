//! Errors of writing results.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::storage::StateError;

/// Why results could not be written. Every variant says which path, so that the user knows which disk or right it is
/// about.
#[derive(Debug, Error)]
pub enum ResultsError {
    /// A folder or file could not be made.
    #[error("cannot create {}: {source}", path.display())]
    Create {
        /// Path that was to be created.
        path: PathBuf,
        /// The system's answer.
        source: io::Error,
    },
    /// Writing failed half-way: disk full, quota, file system gone.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// The file being written.
        path: PathBuf,
        /// The system's answer.
        source: io::Error,
    },
    /// An array that is to be kept in memory does not fit.
    #[error("there is no room for the {bytes} bytes of {array}; in a folder they go to a file")]
    Room {
        /// Name of the array.
        array: &'static str,
        /// Its size \[bytes\].
        bytes: f64,
    },
    /// A state that has no bytes.
    #[error(transparent)]
    State(#[from] StateError),
    /// The finished folder could not be given its name.
    #[error("cannot rename {} to {}: {source}", from.display(), to.display())]
    Rename {
        /// Present name.
        from: PathBuf,
        /// Wanted name.
        to: PathBuf,
        /// The system's answer.
        source: io::Error,
    },
    /// The output path ends in `..`, `/` or nothing: there is no name that a folder could get.
    #[error("{} does not name a folder to write results to", path.display())]
    NoFolderName {
        /// The path given.
        path: PathBuf,
    },
    /// Something stands at the output path that is not a results folder.
    #[error("{} exists and is not a tyrewave results folder; it is left alone (choose another --out)", path.display())]
    NotOurs {
        /// The output path.
        path: PathBuf,
    },
    /// A results folder with files that are not of the run.
    #[error(
        "{} holds {entry}, which tyrewave did not write; the folder is left alone \
         (move {entry} away or choose another --out)",
        path.display()
    )]
    ForeignEntry {
        /// The output path.
        path: PathBuf,
        /// Name of the file or folder that is not ours.
        entry: String,
    },
    /// Something came to the output path while the run went on.
    #[error("{0}; that came there while the results were made")]
    Overtaken(Box<ResultsError>),
    /// A row of another length than the array's.
    #[error("{}: a row of {got} numbers in an array of {expected} columns", path.display())]
    RowLength {
        /// The array's file.
        path: PathBuf,
        /// Columns of the array.
        expected: usize,
        /// Length of the row.
        got: usize,
    },
    /// An array to be gone on with is not the one that was begun.
    #[error(
        "{} is not the array that was begun: it lacks some of its first {rows} rows, or has another type or width",
        path.display()
    )]
    NotThisArray {
        /// The array's file.
        path: PathBuf,
        /// Rows that it must have.
        rows: u64,
    },
    /// A summary that cannot be written as JSON.
    #[error("cannot write {} as JSON: {source}", path.display())]
    Json {
        /// The summary's path.
        path: PathBuf,
        /// The serialiser's complaint.
        source: serde_json::Error,
    },
    /// A sound that cannot be put into a file.
    #[error("cannot make {}: {source}", path.display())]
    Audio {
        /// The sound file.
        path: PathBuf,
        /// Fault of the sound.
        source: Box<crate::sound::WavError>,
    },
}

impl ResultsError {
    /// Tells errors of the request, after which nothing was tried: foreign files in the way, a place
    /// without a name, an array that is not the one to go on with.
    pub fn is_refusal(&self) -> bool {
        matches!(
            self,
            Self::NotOurs { .. } | Self::ForeignEntry { .. } | Self::NoFolderName { .. } | Self::NotThisArray { .. }
        )
    }

    /// Makes the error that writing to `path` failed, for `map_err`.
    pub fn writing(path: &Path) -> impl FnOnce(io::Error) -> Self + use<'_> {
        move |source| Self::Write { path: path.to_owned(), source }
    }

    /// Makes the error that creating `path` failed, for `map_err`.
    pub fn creating(path: &Path) -> impl FnOnce(io::Error) -> Self + use<'_> {
        move |source| Self::Create { path: path.to_owned(), source }
    }
}
