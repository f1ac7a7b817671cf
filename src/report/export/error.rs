//! Why results are not exported.

use thiserror::Error;

use crate::effects::stored::StoredError;

/// Why results are not exported.
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
        /// The key of the scene that would have it written.
        key: &'static str,
    },
    /// Arrays that do not belong to each other.
    #[error("{file} does not fit the other files of its run")]
    Shape {
        /// One of them.
        file: &'static str,
    },
    /// More than the format has room for.
    #[error("{name} is larger than the 2 GiB that a variable of this format may have")]
    TooLarge {
        /// Name of the part.
        name: String,
    },
}
