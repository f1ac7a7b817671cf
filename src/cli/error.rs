//! How a command ends: its error and its exit code.

use std::path::PathBuf;

use thiserror::Error;

use crate::response::SpectrumError;
use crate::results::{PlotError, ResultsError};

/// Exit code of a run that failed on its way.
pub const FAILED: u8 = 1;
/// Exit code of a command line or a scene that makes no sense.
pub const USAGE: u8 = 2;
/// Exit code of results that could not be written.
pub const NOT_WRITABLE: u8 = 3;
/// Exit code after Ctrl-C: 128 + SIGINT, as shells do.
pub const INTERRUPTED: u8 = 130;

/// Why a command did not do what it was asked for.
#[derive(Debug, Error)]
pub enum CliError {
    /// Results could not be written.
    #[error(transparent)]
    Results(#[from] ResultsError),
    /// A picture could not be drawn.
    #[error(transparent)]
    Plot(#[from] PlotError),
    /// A spectrum could not be computed.
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
    /// The user stopped the run.
    #[error("interrupted{}", kept.as_ref().map_or_else(String::new, |path| format!("; partial results are in {}", path.display())))]
    Interrupted {
        /// Where the partial results are, if there are any.
        kept: Option<PathBuf>,
    },
    /// The threads could not be started.
    #[error("cannot start {threads} threads: {source}")]
    Threads {
        /// How many were wanted; 0: as many as there are processors.
        threads: usize,
        /// The pool's complaint.
        source: rayon::ThreadPoolBuildError,
    },
    /// Ctrl-C cannot be caught.
    #[error("cannot listen for Ctrl-C: {0}")]
    Signals(#[source] ctrlc::Error),
}

impl CliError {
    /// The exit code that this error ends the program with.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Results(_) => NOT_WRITABLE,
            Self::Interrupted { .. } => INTERRUPTED,
            Self::Plot(_) | Self::Spectrum(_) | Self::Threads { .. } | Self::Signals(_) => FAILED,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn codes_and_messages() {
        let stopped = CliError::Interrupted { kept: Some("results/a.partial".into()) };
        assert_eq!(
            (stopped.exit_code(), stopped.to_string().as_str()),
            (130, "interrupted; partial results are in results/a.partial")
        );
        assert_eq!(CliError::Interrupted { kept: None }.to_string(), "interrupted");
        let full =
            CliError::from(ResultsError::writing(Path::new("r/time.npy"))(std::io::ErrorKind::StorageFull.into()));
        assert_eq!(full.exit_code(), 3);
        assert!(full.to_string().starts_with("cannot write r/time.npy"), "{full}");
        assert_eq!(CliError::from(SpectrumError::TooShort { samples: 1, needed: 8 }).exit_code(), 1);
    }
}
