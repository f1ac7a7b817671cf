//! Errors of a run.

use std::path::PathBuf;

use thiserror::Error;

use crate::contact::ContactError;
use crate::response::SpectrumError;
use crate::results::{CheckpointError, PlotError, ResultsError};
use crate::road::RoadError;
use crate::road::maker::MakingError;
use crate::road::slices::SliceError;
use crate::scene::{SceneError, SetUpError};
use crate::storage::StateError;

/// Error of a run, by the layer that it comes from.
#[derive(Debug, Error)]
pub enum RunError {
    /// The scene cannot be used, or asks for more than is available.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// Error of the road.
    #[error(transparent)]
    Road(#[from] RoadError),
    /// Error of the road's slices.
    #[error(transparent)]
    Slices(#[from] SliceError),
    /// Error of the contact.
    #[error(transparent)]
    Contact(#[from] ContactError),
    /// Energies that cannot be: the results are not those of any tyre.
    #[error("{0}")]
    Impossible(String),
    /// The results could not be written.
    #[error(transparent)]
    Results(#[from] ResultsError),
    /// A plot could not be drawn.
    #[error(transparent)]
    Plot(#[from] PlotError),
    /// The spectrum could not be computed.
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
    /// The state of an unfinished run does not fit.
    #[error(transparent)]
    State(#[from] StateError),
    /// The run cannot be resumed.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    /// Writing the results failed before the run's end, but there is a checkpoint to resume from.
    #[error(
        "{source}; the run up to its last checkpoint is kept: when there is space, `tyrewave resume {}` continues",
        folder.display()
    )]
    Resumable {
        /// Error of the results.
        source: ResultsError,
        /// Folder of the unfinished run.
        folder: PathBuf,
    },
    /// The user stopped the run.
    #[error("interrupted")]
    Interrupted {
        /// Folder of the partial results, if there are any.
        partial: Option<PathBuf>,
    },
}

impl From<MakingError> for RunError {
    fn from(error: MakingError) -> Self {
        match error {
            MakingError::Road(error) => Self::Road(error),
            MakingError::Slices(error) => Self::Slices(error),
        }
    }
}

impl From<SetUpError> for RunError {
    fn from(error: SetUpError) -> Self {
        match error {
            SetUpError::Scene(error) => Self::Scene(error),
            SetUpError::Stopped => Self::Interrupted { partial: None },
        }
    }
}
