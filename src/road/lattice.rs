//! The lattice on which the run sees the road: elements along, cells along and across each.

use serde::Serialize;

use super::error::{RoadError, positive};

/// The run's lattice of road cells: element e is centred at road coordinate e dx and holds `along` rows of cells, each
/// of `columns` cells across the contact width, centred on the tyre. Heights are those of the cells' centres.
///
/// Rows are counted through: element e owns the rows e `along` to (e + 1) `along`, so its slice is `along` x `columns`
/// contiguous heights.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Lattice {
    /// Element length \[m\].
    pub dx: f64,
    /// Cells along an element.
    pub along: usize,
    /// Column spacing \[m\].
    pub dy: f64,
    /// Cells across.
    pub columns: usize,
}

impl Lattice {
    /// Refuses lengths and numbers that make no lattice.
    pub(super) fn check(&self) -> Result<(), RoadError> {
        positive("element length", self.dx)?;
        positive("column spacing", self.dy)?;
        positive("contact.cells_across", self.columns as f64)?;
        positive("contact.cells_along", self.along as f64)
    }

    /// Returns the cells of a size across a width \[m\], as nearly as can be.
    pub fn across(contact_width: f64, cell: f64) -> usize {
        (contact_width / cell).round().max(1.0) as usize
    }

    /// Returns the length of a cell: the spacing of rows \[m\].
    pub fn cell(&self) -> f64 {
        self.dx / self.along as f64
    }

    /// Returns the place of a row's middle in units of `spacing` \[m\]: the road coordinate itself in units of 1 m.
    pub fn place(&self, row: i64, spacing: f64) -> f64 {
        // One ratio for all rows: where it is a round number, so are the places.
        (row as f64 - 0.5 * (self.along as f64 - 1.0)) * (self.cell() / spacing)
    }

    /// Returns the heights of one element.
    pub fn cells(&self) -> usize {
        self.along * self.columns
    }

    /// Returns the width covered \[m\].
    pub fn width(&self) -> f64 {
        self.dy * self.columns as f64
    }

    /// Returns the lateral position of a column's centre from the tyre's middle \[m\].
    pub fn y(&self, column: usize) -> f64 {
        (column as f64 - 0.5 * (self.columns as f64 - 1.0)) * self.dy
    }
}

/// Tells whether two numbers are equal up to rounding in a scene file.
pub(super) fn same(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * a.abs().max(b.abs())
}
