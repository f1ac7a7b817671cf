//! Errors of making slices from heights.

/// Heights or a grid from which no stiffness curve can be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SliceError {
    /// A slice without cells.
    #[error("a slice needs at least one cell")]
    Empty,
    /// The heights do not fill whole slices, or a slice has the wrong number of cells.
    #[error("{found} heights given where slices of {cells} cells are expected")]
    Cells {
        /// Cells of one slice.
        cells: usize,
        /// Heights given.
        found: usize,
    },
    /// A hole: not a number, or infinite.
    #[error("height {value} in slice {slice}, cell {cell}: holes must be filled before slices are made")]
    Hole {
        /// Slice counted from 0.
        slice: usize,
        /// Cell counted from 0, across first.
        cell: usize,
        /// Value found.
        value: f64,
    },
    /// A law that depends on more of the road than the slice.
    #[error("the curves of a pressed road are made of the strip as a whole, not slice by slice")]
    Together,
    /// A grid on which contact cannot be shown to only grow; the curve follower needs that.
    #[error(
        "{columns} cells of {length} m by {pitch} m: rounding hides that contact on the half-space only grows; \
         choose fewer cells or another shape"
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
        /// Name of the length.
        what: &'static str,
        /// Its value \[m\].
        value: f64,
    },
}

impl SliceError {
    /// Checks that all heights are finite; `cells` is the number of cells in a slice.
    ///
    /// # Errors
    /// [`SliceError::Hole`] for the first that is not.
    pub fn refuse_holes(heights: &[f64], cells: usize) -> Result<(), Self> {
        first_hole(heights).map_or(Ok(()), |place| {
            Err(Self::Hole { slice: place / cells, cell: place % cells, value: heights[place] })
        })
    }
}

/// Index of the first height that is not finite.
fn first_hole(heights: &[f64]) -> Option<usize> {
    /// Heights that are checked together, without a branch for each.
    const BLOCK: usize = 64;
    let sound = |heights: &[f64]| heights.iter().fold(true, |sound, height| sound & height.is_finite());
    let block = heights.chunks(BLOCK).position(|heights| !sound(heights))?;
    let place = heights[block * BLOCK..].iter().position(|height| !height.is_finite())?;
    Some(block * BLOCK + place)
}
