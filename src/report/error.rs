//! Why a report is not made.

use thiserror::Error;

use super::stored::StoredError;
use crate::results::PlotError;

/// Why there is no page.
#[derive(Debug, Error)]
pub enum ReportError {
    /// A results folder that cannot be read.
    #[error(transparent)]
    Stored(#[from] StoredError),
    /// A picture that cannot be drawn.
    #[error(transparent)]
    Plot(#[from] PlotError),
}
