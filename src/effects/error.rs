//! Faults of an effect.

use thiserror::Error;

use crate::plan::models::ModelError;
use crate::response::SpectrumError;
use crate::results::{PlotError, ResultsError};
use crate::scene::SceneError;
use crate::storage::StateError;

/// Error of an effect, by the layer that it comes from.
#[derive(Debug, Error)]
pub enum EffectError {
    /// The scene asks for what cannot be had.
    #[error(transparent)]
    Scene(#[from] SceneError),
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
    /// The user stopped the run.
    #[error("interrupted")]
    Interrupted,
}

impl From<ModelError> for EffectError {
    fn from(error: ModelError) -> Self {
        match error {
            ModelError::Scene(error) => Self::Scene(error),
            ModelError::Stopped => Self::Interrupted,
        }
    }
}
