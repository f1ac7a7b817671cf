//! What can be wrong with the heights that slices are made of.

/// Heights that no stiffness curve can be made of.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SliceError {
    /// A slice without points.
    #[error("a slice needs at least one point across")]
    Empty,
    /// The heights do not fill whole rows, or a row has the wrong number of points.
    #[error("{found} heights given where slices of {columns} points across are expected")]
    Columns {
        /// Points across one slice.
        columns: usize,
        /// Heights given.
        found: usize,
    },
    /// A hole: not a number, or infinite.
    #[error("height {value} in slice {row} at column {column}: holes must be filled before slices are made")]
    Hole {
        /// Row counted from 0.
        row: usize,
        /// Column counted from 0.
        column: usize,
        /// What was found.
        value: f64,
    },
    /// A grid on which contact cannot be shown to grow only; the curve follower needs that.
    #[error(
        "{columns} cells of {length} m by {pitch} m: rounding hides that contact on the half-space only grows; choose fewer cells or another shape"
    )]
    MayShrink {
        /// Cells across.
        columns: usize,
        /// Length of a cell along the road \[m\].
        length: f64,
        /// Width of a cell \[m\].
        pitch: f64,
    },
    /// A cell or a tolerance that is not a positive length.
    #[error("{what} is {value} m: it must be positive and finite")]
    Length {
        /// What the length is.
        what: &'static str,
        /// Its value \[m\].
        value: f64,
    },
}
