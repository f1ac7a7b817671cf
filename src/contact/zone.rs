//! Zone of the contact: the points that touch, whatever they are, slices or cells.

use super::complementarity::{Residuals, SearchCounts};
use super::error::ContactError;
use super::footprint::StageMut;
use crate::counters::Meter;
use crate::road::strip::RoadStrip;
use crate::storage::state::Evolving;

/// Instant at which a zone is solved.
#[derive(Clone, Copy)]
pub(crate) struct Instant<'a> {
    /// Number of the step.
    pub step: u64,
    /// Number of the instant within it.
    pub stage: usize,
    /// Element number of the first column, of the search window.
    pub first_element: i64,
    /// Indentation of the rigid tyre \[m\].
    pub indentation: f64,
    /// Heights of the undeformed tread by column of that window \[m\].
    pub rises: &'a [f64],
}

pub(crate) struct Solved {
    /// How far the contact conditions are missed.
    pub residuals: Residuals,
    /// Largest force on a point \[N\].
    pub largest_force: f64,
    /// Largest required displacement \[m\].
    pub largest_displacement: f64,
    /// True if no required displacement is NaN.
    pub has_no_nan: bool,
    /// True if an outermost column of the window carries force, or the window has no space for the history of its
    /// forces.
    pub is_at_end: bool,
}

pub(crate) trait ContactZone: Evolving + Send {
    /// Solves for the contact at an instant over a road and writes it to `stage`.
    fn solve(
        &mut self,
        at: Instant<'_>,
        road: &RoadStrip,
        stage: StageMut<'_>,
        meter: &mut Meter,
    ) -> Result<Solved, ContactError>;

    /// Prepares for a step whose window has moved on by `columns`.
    fn advance(&mut self, _columns: usize) {}

    /// Points across a column.
    fn across(&self) -> usize {
        1
    }

    /// Sub-cells of a cell along and across; 1 without.
    fn sub_cells(&self) -> usize {
        1
    }

    /// Columns by which the search window is longer, at either end, than the output window.
    fn margin(&self) -> usize {
        0
    }

    /// True if a step that reaches the window's end is to be solved again over a wider one.
    fn is_widened(&self) -> bool {
        false
    }

    fn has_friction(&self) -> bool {
        false
    }

    /// First weights \[m/N\]: if their bits differ between two runs, so do those of all results.
    fn first_weights(&self) -> &[f64];

    /// Spring compliance of a column \[m/N\]; 0 without springs.
    fn spring(&self) -> f64 {
        0.0
    }

    fn search_counts(&self) -> SearchCounts;
}
