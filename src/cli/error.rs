//! How a command ends: its error and its exit code.

use std::path::PathBuf;

use thiserror::Error;
use tyrewave::half_space::HalfSpaceError;
use tyrewave::profile::ProfileError;
use tyrewave::profile::measure::Found;
use tyrewave::results::summary::LoadResult;
use tyrewave::results::{PlotError, ResultsError};
use tyrewave::road::slices::SliceError;
use tyrewave::run::RunError;
use tyrewave::scene::SceneError;
use tyrewave::storage::CacheError;
use tyrewave::study::sweep::SweepError;
use tyrewave::tyre::cases::CasesError;

use super::heights::HeightsError;

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
    /// The scene cannot be used.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The run did not reach its end.
    #[error(transparent)]
    Run(RunError),
    /// A file that was named on the command line cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A file of compliance cases makes no sense.
    #[error("{}: {source}", path.display())]
    Cases {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: CasesError,
    },
    /// Heights or other values given on the command line cannot be used.
    #[error(transparent)]
    Heights(#[from] HeightsError),
    /// A slice cannot be made.
    #[error(transparent)]
    Slice(#[from] SliceError),
    /// A contact with the half-space cannot be solved.
    #[error(transparent)]
    HalfSpace(#[from] HalfSpaceError),
    /// The cache of influence models cannot be used.
    #[error("the cache of influence models: {0}")]
    Cache(#[from] CacheError),
    /// Standard output does not take the answer.
    #[error("cannot write to standard output: {0}")]
    Print(#[source] std::io::Error),
    /// The user stopped the run.
    #[error("interrupted{}", kept.as_ref().map_or_else(String::new, |path| format!("; partial results are in {0}; `tyrewave resume {0}` goes on", path.display())))]
    Interrupted {
        /// Where the partial results are, if there are any.
        kept: Option<PathBuf>,
    },
    /// The variants of a sweep make no sense.
    #[error(transparent)]
    Sweep(#[from] SweepError),
    /// Some variants of a sweep failed.
    #[error("{} of {of} variants failed: {}; the others are done", failed.len(), failed.join(", "))]
    SweepFailed {
        /// Their names.
        failed: Vec<String>,
        /// How many there were.
        of: usize,
    },
    /// Some presets are not what they say.
    #[error("presets that do not keep their stated error or are not on the front: {}", failed.join(", "))]
    Presets {
        /// Their names.
        failed: Vec<String>,
    },
    /// The user stopped a sweep.
    #[error("interrupted; the same command goes on where the sweep was")]
    SweepStopped,
    /// Performance could not be recorded or compared.
    #[error(transparent)]
    Profile(ProfileError),
    /// A workload found something else than it must; boxed, since it is large.
    #[error("workload {workload} is wrong and was not recorded: {} is {}, not {} within {:e}", found.what, found.value, found.expected, found.tolerance)]
    WrongResult {
        /// Its name.
        workload: &'static str,
        /// What it found.
        found: Box<Found>,
    },
    /// A run under another load than it was asked for.
    #[error(
        "{load}; the results are in {}; a longer warm_up corrects the height more exactly, a longer duration averages \
         more, and `tolerance = {}` in rolling.axle allows it",
        folder.display(),
        (1.2e3 * load.relative_error.abs()).ceil() / 1e3
    )]
    MissedLoad {
        /// Where the results are.
        folder: PathBuf,
        /// The load and the mean force.
        load: LoadResult,
    },
    /// A comparison of performance went against the second one.
    #[error("not as good as what it was held against")]
    Worse,
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
            Self::Results(_) | Self::Print(_) => NOT_WRITABLE,
            Self::Interrupted { .. } | Self::SweepStopped => INTERRUPTED,
            Self::SweepFailed { .. } | Self::WrongResult { .. } | Self::Worse | Self::Presets { .. } => FAILED,
            Self::MissedLoad { .. } => FAILED,
            Self::Profile(error) => match error {
                ProfileError::File { what: "write", .. } => NOT_WRITABLE,
                ProfileError::File { .. } | ProfileError::Nonsense { .. } => USAGE,
                ProfileError::Interrupted => INTERRUPTED,
                _ => FAILED,
            },
            Self::Sweep(_) => USAGE,
            Self::Scene(_) | Self::Read { .. } | Self::Cases { .. } | Self::Heights(_) | Self::Slice(_) => USAGE,
            Self::HalfSpace(HalfSpaceError::NotConverged { .. } | HalfSpaceError::NotPositiveDefinite { .. }) => FAILED,
            Self::HalfSpace(_) => USAGE,
            Self::Run(error) => match error {
                RunError::Scene(_) | RunError::Road(_) | RunError::Slices(_) => USAGE,
                RunError::Results(_) | RunError::Kept { .. } => NOT_WRITABLE,
                RunError::Checkpoint(_) => USAGE,
                RunError::Interrupted { .. } => INTERRUPTED,
                RunError::HalfSpace(_) | RunError::Contact(_) | RunError::Plot(_) | RunError::Spectrum(_) => FAILED,
            },
            Self::Cache(_) | Self::Plot(_) | Self::Threads { .. } | Self::Signals(_) => FAILED,
        }
    }

    /// The message for people; a mistake in a scene is shown in its place.
    pub fn render(&self, colour: bool) -> String {
        match self {
            Self::Scene(error) | Self::Run(RunError::Scene(error)) => error.render(colour),
            Self::Sweep(SweepError::Scene { name, source }) => format!("variant {name}:\n{}", source.render(colour)),
            other => other.to_string(),
        }
    }
}

impl From<RunError> for CliError {
    fn from(error: RunError) -> Self {
        match error {
            RunError::Interrupted { kept } => Self::Interrupted { kept },
            other => Self::Run(other),
        }
    }
}

impl From<ProfileError> for CliError {
    fn from(error: ProfileError) -> Self {
        match error {
            ProfileError::Interrupted => Self::Interrupted { kept: None },
            other => Self::Profile(other),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use tyrewave::contact::ContactError;

    #[test]
    fn codes_and_messages() {
        let stopped = CliError::Interrupted { kept: Some("results/a.partial".into()) };
        assert_eq!(
            (stopped.exit_code(), stopped.to_string().as_str()),
            (130, "interrupted; partial results are in results/a.partial; `tyrewave resume results/a.partial` goes on")
        );
        assert_eq!(CliError::Interrupted { kept: None }.to_string(), "interrupted");
        let full =
            CliError::from(ResultsError::writing(Path::new("r/time.npy"))(std::io::ErrorKind::StorageFull.into()));
        assert_eq!(full.exit_code(), 3);
        assert!(full.to_string().starts_with("cannot write r/time.npy"), "{full}");
        let contact = RunError::from(ContactError::NotFinite { step: 1, time: 0.1 });
        assert_eq!(CliError::from(contact).exit_code(), 1);
    }
}
