//! Errors of recording and comparing performance.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::run::RunError;
use crate::scene::SceneError;
use crate::tyre::poles::FitError;

/// Reasons why there is no measurement, record or comparison.
#[derive(Debug, Error)]
pub enum PerformanceError {
    /// A rolling workload ended early.
    #[error("workload {workload}: {source}")]
    Run {
        /// Name of the workload.
        workload: String,
        /// Error of the run.
        source: Box<RunError>,
    },
    /// A workload's scene was refused.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A workload's fit was refused.
    #[error("workload influence: {0}")]
    Fit(#[from] FitError),
    /// The user stopped the work.
    #[error("interrupted")]
    Interrupted,
    /// A file cannot be read or written.
    #[error("cannot {what} {}: {source}", path.display())]
    File {
        /// `read` or `write`.
        what: &'static str,
        /// The file.
        path: PathBuf,
        /// Error of the system.
        source: io::Error,
    },
    /// A file is neither a record nor a list of accepted changes.
    #[error("{}: {wrong}; {right}", path.display())]
    Nonsense {
        /// The file.
        path: PathBuf,
        /// Fault found.
        wrong: String,
        /// Remedy.
        right: &'static str,
    },
    /// A program to be compared did not give a measurement.
    #[error("{} profile measure {workload}: {wrong}", program.display())]
    Program {
        /// The program.
        program: PathBuf,
        /// The workload.
        workload: String,
        /// Fault found.
        wrong: String,
    },
}

impl PerformanceError {
    /// Constructor of the error of reading a file, for `map_err`.
    pub(crate) fn reading(path: &Path) -> impl FnOnce(io::Error) -> Self {
        move |source| Self::File { what: "read", path: path.to_owned(), source }
    }

    /// Constructor of the error of writing a file, for `map_err`.
    pub(crate) fn writing(path: &Path) -> impl FnOnce(io::Error) -> Self {
        move |source| Self::File { what: "write", path: path.to_owned(), source }
    }
}
