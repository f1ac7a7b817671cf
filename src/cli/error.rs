//! Errors of a command, and their exit codes.
//!
//! Messages on standard error: the one place that writes there.
//!
//! A message that cannot be written (a full disk behind a redirection, a closed pipe) must not end a run, as
//! `eprintln!` would: clippy refuses that and its kin everywhere in the program and the library.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::half_space::HalfSpaceError;
use crate::performance::compare::PerformanceError;
use crate::results::{PlotError, ResultsError};
use crate::road::slices::SliceError;
use crate::run::RunError;
use crate::scene::SceneError;
use crate::storage::{CacheError, InputError};
use crate::study::sweep::SweepError;
use crate::study::sweep::tasks::TaskError;
use crate::study::validation::ValidationError;
use thiserror::Error;

/// Exit code of a run that failed after its begin.
pub(super) const FAILED: u8 = 1;
/// Exit code of a command line or a scene that is invalid.
pub(super) const USAGE: u8 = 2;
/// Exit code of results that could not be written.
pub(super) const NOT_WRITABLE: u8 = 3;
/// Exit code if the results are complete, but standard output could not be written.
pub(super) const UNPRINTED: u8 = 4;
/// Exit code of a comparison that rests on too little to be decided.
pub(super) const UNDECIDED: u8 = 5;
/// Exit code after Ctrl-C: 128 + SIGINT, as shells do.
pub(super) const INTERRUPTED: u8 = 130;

/// Reasons why a command failed.
#[derive(Debug, Error)]
pub(crate) enum CliError {
    /// Errors of the library's stages: scene, road, contact, results.
    #[error(transparent)]
    Run(RunError),
    /// Errors in the content of a file that is named on the command line.
    #[error("{}: {source}", path.display())]
    InFile { path: PathBuf, source: Box<CliError> },
    #[error(transparent)]
    HalfSpace(#[from] HalfSpaceError),
    #[error(transparent)]
    Sweep(#[from] SweepError),
    #[error(transparent)]
    Tasks(#[from] TaskError),
    #[error("the cache of influence models: {0}")]
    Cache(#[from] CacheError),
    /// A file that was named on the command line.
    #[error("cannot read {}: {source}", path.display())]
    Read { path: PathBuf, source: std::io::Error },
    /// Anything else on the command line, or in a file named there, that is invalid.
    #[error("{0}")]
    Usage(String),
    /// Everything was done, and part of it failed a requirement.
    #[error("{0}")]
    Failed(String),
    /// In a comparison of performance the second one is worse.
    #[error("worse than what it was compared with")]
    Worse,
    /// Times scatter too much, or rest on too few runs, for a comparison of performance.
    #[error("undecided: give more --pairs and a larger --budget, or choose a --workload")]
    Undecided,
    /// The user stopped the run; `partial` holds the partial results, if there are any.
    #[error("interrupted; {}", partial.as_ref().map_or_else(|| "no results are kept".to_owned(), |path| {
        format!("partial results are in {0}; `tyrewave resume {0}` continues", path.display())
    }))]
    Interrupted { partial: Option<PathBuf> },
    /// The user stopped work on several runs; `folder` holds the results of those that were done.
    #[error("interrupted; the results so far are in {}", folder.display())]
    PartDone { folder: PathBuf },
    #[error("interrupted; the same command continues the sweep")]
    SweepStopped,
    #[error("cannot write to standard output: {0}")]
    Print(#[source] std::io::Error),
    /// Everything was done, but standard output could not be written.
    #[error("cannot write to standard output: {source}; the results are complete, in {}", folder.display())]
    Unprinted { source: std::io::Error, folder: PathBuf },
}

impl CliError {
    /// Constructor of the error of reading a file that was named on the command line, for `map_err`.
    pub(crate) fn reading(path: &Path) -> impl FnOnce(InputError) -> Self {
        move |error| Self::Read { path: path.to_owned(), source: error.into() }
    }

    /// Exit code that this error ends the program with.
    pub(crate) fn exit_code(&self) -> u8 {
        match self {
            Self::Run(error) => match error {
                RunError::Scene(_) | RunError::Road(_) | RunError::Slices(_) | RunError::Checkpoint(_) => USAGE,
                RunError::Contact(_) | RunError::Impossible(_) => FAILED,
                RunError::Plot(_) | RunError::Spectrum(_) | RunError::State(_) => FAILED,
                RunError::Results(error) if error.is_refusal() => USAGE,
                RunError::Results(_) | RunError::Resumable { .. } => NOT_WRITABLE,
                RunError::Interrupted { .. } => INTERRUPTED,
            },
            Self::InFile { source, .. } => source.exit_code(),
            Self::HalfSpace(HalfSpaceError::NotConverged { .. }) => FAILED,
            Self::HalfSpace(_) => USAGE,
            Self::Tasks(TaskError::Results(error)) if !error.is_refusal() => NOT_WRITABLE,
            Self::Sweep(_) | Self::Tasks(_) | Self::Read { .. } | Self::Usage(_) => USAGE,
            Self::Cache(_) | Self::Failed(_) | Self::Worse => FAILED,
            Self::Interrupted { .. } | Self::PartDone { .. } | Self::SweepStopped => INTERRUPTED,
            Self::Print(_) => NOT_WRITABLE,
            Self::Unprinted { .. } => UNPRINTED,
            Self::Undecided => UNDECIDED,
        }
    }

    /// The same error, of a command whose results are complete in a folder.
    pub(crate) fn with_results(self, folder: &Path) -> Self {
        match self {
            Self::Print(source) => Self::Unprinted { source, folder: folder.to_owned() },
            other => other,
        }
    }

    /// The same error, with the file that it is about.
    pub(crate) fn in_file(self, path: &Path) -> Self {
        Self::InFile { path: path.to_owned(), source: Box::new(self) }
    }

    /// Message for people; a mistake in a scene is shown in its context.
    pub(crate) fn render(&self, colour: bool) -> String {
        match self {
            Self::Run(RunError::Scene(error)) => error.render(colour),
            Self::Tasks(TaskError::Scene { task, source }) => format!("task {task}:\n{}", source.render(colour)),
            Self::Sweep(SweepError::Scene { name, source }) => format!("variant {name}:\n{}", source.render(colour)),
            other => other.to_string(),
        }
    }
}

impl From<RunError> for CliError {
    fn from(error: RunError) -> Self {
        match error {
            RunError::Interrupted { partial } => Self::Interrupted { partial },
            other => Self::Run(other),
        }
    }
}

impl From<ValidationError> for CliError {
    fn from(error: ValidationError) -> Self {
        match error {
            ValidationError::Run(error) => error.into(),
            ValidationError::Sweep(error) => error.into(),
            ValidationError::Modes(error) => Self::Failed(error.to_string()),
        }
    }
}

impl From<PerformanceError> for CliError {
    fn from(error: PerformanceError) -> Self {
        match error {
            PerformanceError::Interrupted => Self::Interrupted { partial: None },
            PerformanceError::Program(wrong) => Self::Failed(wrong),
        }
    }
}

/// Errors that are also errors of a run.
macro_rules! of_a_run {
    ($($error:ty),*) => {$(
        impl From<$error> for CliError {
            fn from(error: $error) -> Self {
                Self::Run(error.into())
            }
        }
    )*};
}

of_a_run!(SceneError, SliceError, ResultsError, PlotError);

/// Writes a message and a line end; one that cannot be written is lost.
pub(super) fn write_message(message: &str) {
    write_message_to(&mut io::stderr(), message);
}

fn write_message_to(out: &mut impl Write, message: &str) {
    // In one piece, so that messages of several threads do not mix.
    let _ = out.write_all(format!("{message}\n").as_bytes());
}

#[cfg(test)]
mod tests {
    use crate::contact::ContactError;

    use super::*;

    #[test]
    fn codes_and_messages() {
        let stopped = CliError::Interrupted { partial: Some("results/a.partial".into()) };
        assert_eq!(
            (stopped.exit_code(), stopped.to_string().as_str()),
            (
                130,
                "interrupted; partial results are in results/a.partial; `tyrewave resume results/a.partial` continues"
            )
        );
        assert_eq!(CliError::Interrupted { partial: None }.to_string(), "interrupted; no results are kept");
        let full =
            CliError::from(ResultsError::writing(Path::new("r/time.npy"))(std::io::ErrorKind::StorageFull.into()));
        assert_eq!(full.exit_code(), 3);
        assert!(full.to_string().starts_with("cannot write r/time.npy"), "{full}");
        let taken = || ResultsError::NotOurs { path: "thesis".into() };
        let overtaken = ResultsError::Overtaken(Box::new(taken()));
        assert_eq!((CliError::from(taken()).exit_code(), CliError::from(overtaken).exit_code()), (2, 3));
        let contact = RunError::from(ContactError::NotFinite { step: 1, time: 0.1 });
        assert_eq!(CliError::from(contact).exit_code(), 1);
    }

    #[test]
    fn a_message_is_a_line_and_one_that_cannot_be_written_is_lost() {
        let mut paper = Vec::new();
        write_message_to(&mut paper, "note: it rains");
        assert_eq!(paper, b"note: it rains\n");
        write_message_to(&mut &mut [0_u8; 3][..], "note: it rains");
    }
}
