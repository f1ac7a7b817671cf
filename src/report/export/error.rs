//! Reasons why results are not exported.

use thiserror::Error;

use crate::effects::stored::StoredError;

/// Reasons why results are not exported.
#[derive(Debug, Error)]
pub(crate) enum ExportError {
    /// A results folder that cannot be read.
    #[error(transparent)]
    Stored(#[from] StoredError),
    /// The run has not written what the format needs.
    #[error("the run has not written {what}: {key} was false, or the run was too short")]
    Missing {
        /// Missing part.
        what: &'static str,
        /// Key of the scene that enables it.
        key: &'static str,
    },
    /// Arrays whose shapes do not fit together.
    #[error("{file} does not fit the other files of its run")]
    Shape {
        /// One of their files.
        file: &'static str,
    },
    /// A variable too large for the format.
    #[error("{name} is larger than the 2 GiB that a variable of this format may have")]
    TooLarge {
        /// Name of the variable.
        name: String,
    },
}
