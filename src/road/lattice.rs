//! The lattice on which the run sees the road: elements along, cells along and across each.

use serde::Serialize;

use super::error::RoadError;
use super::grid;
use crate::scene::{Lateral, ProfileRoad, Road};

/// The run's lattice of road cells: element e is centred at road coordinate e dx and holds `along` rows of cells, each
/// of `columns` cells across the
/// contact width, centred on the tyre. Heights are those of the cells' centres.
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
    /// The lattice for a road: cells across and along as the scene says; else those of a grid that covers the contact
    /// width exactly, its rows falling
    /// on the middle of each element and an odd number of them on its length; one column for roads that are level
    /// across; else cells of about [`Road::cell`].
    ///
    /// # Errors
    /// A grid's file that cannot be read (its header is needed); dx or width not positive.
    pub fn choose(
        road: &Road,
        dx: f64,
        contact_width: f64,
        cells_across: Option<usize>,
        cells_along: Option<usize>,
    ) -> Result<Self, RoadError> {
        positive("element length", dx)?;
        positive("tyre.contact_width", contact_width)?;
        for (key, cells) in [("contact.cells_across", cells_across), ("contact.cells_along", cells_along)] {
            positive(key, cells.unwrap_or(1) as f64)?;
        }
        let (across, along) = (Self::across(contact_width, road.cell()), Road::cells(dx, road.cell()));
        let (columns, along) = match road {
            Road::Smooth => (1, 1),
            Road::Profile(ProfileRoad { lateral: Lateral::Extruded, .. }) => (1, along),
            Road::Grid(spec) => {
                let columns = grid::columns(spec)?;
                let rows = (dx / spec.dx).round();
                let fits =
                    same(rows * spec.dx, dx) && rows as i64 % 2 == 1 && same(spec.dy * columns as f64, contact_width);
                if fits { (columns, rows as usize) } else { (across, along) }
            }
            _ => (across, along),
        };
        let columns = cells_across.unwrap_or(columns);
        Ok(Self { dx, along: cells_along.unwrap_or(along), dy: contact_width / columns as f64, columns })
    }

    /// Cells of a size across a width \[m\], as nearly as can be.
    pub fn across(contact_width: f64, cell: f64) -> usize {
        (contact_width / cell).round().max(1.0) as usize
    }

    /// Length of a cell: the spacing of rows \[m\].
    pub fn cell(&self) -> f64 {
        self.dx / self.along as f64
    }

    /// Place of a row's middle in units of `spacing` \[m\]: the road coordinate itself in units of 1 m.
    pub fn place(&self, row: i64, spacing: f64) -> f64 {
        // One ratio for all rows: where it is a round number, so are the places.
        (row as f64 - 0.5 * (self.along as f64 - 1.0)) * (self.cell() / spacing)
    }

    /// Heights of one element.
    pub fn cells(&self) -> usize {
        self.along * self.columns
    }

    /// Width covered \[m\].
    pub fn width(&self) -> f64 {
        self.dy * self.columns as f64
    }

    /// Lateral position of a column's centre from the tyre's middle \[m\].
    pub fn y(&self, column: usize) -> f64 {
        (column as f64 - 0.5 * (self.columns as f64 - 1.0)) * self.dy
    }
}

/// Equal up to rounding in a scene file.
pub(super) fn same(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * a.abs().max(b.abs())
}

pub(super) fn positive(key: &'static str, value: f64) -> Result<(), RoadError> {
    if value > 0.0 && value.is_finite() { Ok(()) } else { Err(RoadError::NotPositive { key, value }) }
}
