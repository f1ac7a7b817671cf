//! Errors of contact problems on the half-space.

/// A contact problem that is ill-posed or was not solved.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum HalfSpaceError {
    /// Number of heights that does not fit the grid.
    #[error("a height map of {rows} x {columns} cells needs as many heights, at least one; {found} were given")]
    Shape {
        /// Rows of the grid.
        rows: usize,
        /// Columns of the grid.
        columns: usize,
        /// Number of heights given.
        found: usize,
    },
    /// A quantity that must be positive and finite.
    #[error("{what} is {value}: it must be positive and finite")]
    NotPositive {
        /// Name of the quantity, for the message.
        what: &'static str,
        /// Value given \[SI\].
        value: f64,
    },
    /// A hole in the height map.
    #[error("height {value} in row {row}, column {column} (counted from 0): holes must be filled first")]
    Hole {
        /// Row, counted from 0.
        row: usize,
        /// Column, counted from 0.
        column: usize,
        /// Height given \[m\], NaN or infinite.
        value: f64,
    },
    /// A periodic grid with an odd number of rows or columns.
    #[error("a periodic height map needs even numbers of rows and columns; it has {rows} x {columns}")]
    Odd {
        /// Rows of the grid.
        rows: usize,
        /// Columns of the grid.
        columns: usize,
    },
    /// A penetration so small beside the heights that their rounding hides it.
    #[error(
        "a penetration of {penetration:e} m is lost in the rounding of heights up to {highest:e} m: take a spike or an \
         offset out of the heights, or press harder"
    )]
    Unresolved {
        /// Penetration \[m\].
        penetration: f64,
        /// Largest magnitude of a height \[m\].
        highest: f64,
    },
    /// The iteration did not reach its tolerance.
    #[error(
        "no convergence in {iterations} iterations: the contact conditions are violated by {residual:.1e} of the \
         penetration"
    )]
    NotConverged {
        /// Iterations done.
        iterations: usize,
        /// Largest violation, relative to the penetration.
        residual: f64,
    },
}
