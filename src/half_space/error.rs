//! What can go wrong in contact with the half-space.

/// A contact problem that cannot be posed or was not solved.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum HalfSpaceError {
    /// An influence matrix that is not positive definite.
    #[error("the influence matrix of {cells} cells in contact is not positive definite")]
    NotPositiveDefinite {
        /// Order of the matrix.
        cells: usize,
    },
}
