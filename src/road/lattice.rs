//! The lattice of road cells in a run: elements along, cells along and across each.

use serde::Serialize;

use super::error::{RoadError, positive};

/// The run's lattice of road cells: element e is centred at road coordinate e dx and has `along` rows of cells, each
/// of `columns` cells across the contact width, centred on the tyre. Heights are those at the cells' centres.
///
/// Rows are numbered throughout: element e has the rows e `along` to (e + 1) `along`, so its slice is `along` x
/// `columns` contiguous heights.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Lattice {
    /// Element length \[m\].
    pub dx: f64,
    /// Number of cells along an element.
    pub along: usize,
    /// Column spacing \[m\].
    pub dy: f64,
    /// Number of cells across.
    pub columns: usize,
}

impl Lattice {
    /// Refuses lengths and numbers that are not positive.
    pub(super) fn check(&self) -> Result<(), RoadError> {
        positive("element length", self.dx)?;
        positive("column spacing", self.dy)?;
        positive("contact.cells_across", self.columns as f64)?;
        positive("contact.cells_along", self.along as f64)
    }

    /// Number of cells of about the size `cell` across a width \[m\], at least 1.
    pub fn across(contact_width: f64, cell: f64) -> usize {
        (contact_width / cell).round().max(1.0) as usize
    }

    /// Length of a cell, the spacing of rows \[m\].
    pub fn cell(&self) -> f64 {
        self.dx / self.along as f64
    }

    /// Position of a row's middle in units of `spacing` \[m\]: the road coordinate itself for 1 m.
    pub fn place(&self, row: i64, spacing: f64) -> f64 {
        // One ratio for all rows: where it is a round number, so are the positions.
        (row as f64 - 0.5 * (self.along as f64 - 1.0)) * (self.cell() / spacing)
    }

    /// Number of heights of one element.
    pub fn cells(&self) -> usize {
        self.along * self.columns
    }

    /// Width covered by the columns \[m\].
    pub fn width(&self) -> f64 {
        self.dy * self.columns as f64
    }

    /// Lateral position of a column's centre from the tyre's middle \[m\].
    pub fn y(&self, column: usize) -> f64 {
        (column as f64 - 0.5 * (self.columns as f64 - 1.0)) * self.dy
    }
}

/// True if two numbers are equal up to rounding in a scene file.
pub(super) fn same(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * a.abs().max(b.abs())
}
