//! The lattice on which the run sees the road: elements along, columns across.

use serde::Serialize;

use super::error::RoadError;
use super::{grid, profile};
use crate::scene::{Lateral, Road};

/// The run's slice lattice: element e lies at road coordinate e dx, its cell is dx long; `columns` columns across the contact
/// width, centred on the tyre, cell-centred, dy apart.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Lattice {
    /// Element length \[m\].
    pub dx: f64,
    /// Column spacing \[m\].
    pub dy: f64,
    /// Columns across.
    pub columns: usize,
}

impl Lattice {
    /// Width of a column of a lattice chosen here \[m\].
    pub const COLUMN_WIDTH: f64 = 0.002;

    /// The lattice for a road: `lateral_points` columns if the scene says so; else a grid's own columns when it is already at
    /// the run's dx and covers the contact width exactly; one column for roads that are level across; else columns of about 2 mm.
    ///
    /// # Errors
    /// A grid's file that cannot be read (its header is needed); dx or width not positive.
    pub fn choose(road: &Road, dx: f64, contact_width: f64, lateral_points: Option<usize>) -> Result<Self, RoadError> {
        positive("element length", dx)?;
        positive("tyre.contact_width", contact_width)?;
        let with = |columns: usize| Self { dx, dy: contact_width / columns as f64, columns };
        if let Some(columns) = lateral_points {
            return if columns > 0 {
                Ok(with(columns))
            } else {
                Err(RoadError::NotPositive { key: "contact.lateral_points", value: 0.0 })
            };
        }
        let usual = with((contact_width / Self::COLUMN_WIDTH).round().max(1.0) as usize);
        Ok(match road {
            Road::Smooth => with(1),
            Road::Profile(profile::ProfileRoad { lateral: Lateral::Extruded, .. }) => with(1),
            Road::Grid(spec) => {
                let columns = grid::columns(spec)?;
                let fits = same(spec.dx, dx) && same(spec.dy * columns as f64, contact_width);
                if fits { Self { dx, dy: spec.dy, columns } } else { usual }
            }
            _ => usual,
        })
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
