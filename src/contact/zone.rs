//! Zone of the contact: the points that touch, whatever they are, slices or cells.

use super::complementarity::{Residuals, SearchCounts};
use super::error::ContactError;
use super::footprint::StageMut;
use crate::counters::Meter;
use crate::road::strip::RoadStrip;
use crate::storage::state::{StateError, StateReader, StateWriter};

/// Instant at which a zone is solved.
#[derive(Clone, Copy)]
pub(crate) struct Instant<'a> {
    /// Number of the step.
    pub step: u64,
    /// Number of the instant within it.
    pub stage: usize,
    /// Element number of the first column, of the window in which contact is sought.
    pub first_element: i64,
    /// Indentation of the rigid tyre \[m\].
    pub indentation: f64,
    /// Heights of the undeformed tread by column of that window \[m\].
    pub rises: &'a [f64],
}

/// Result of an instant.
pub(crate) struct Solved {
    /// How far the contact conditions are missed.
    pub residuals: Residuals,
    /// Largest force on a point \[N\].
    pub largest_force: f64,
    /// Largest required displacement \[m\].
    pub largest_displacement: f64,
    /// True if every required displacement is a number.
    pub is_sound: bool,
    /// True if an outermost column of the window carries force, or the window has no room for the past of its forces.
    pub is_at_end: bool,
}

/// Zone of the contact.
pub(crate) trait Zone: Send {
    /// Solves for the contact at an instant, over a road.
    ///
    /// # Errors
    /// [`ContactError`].
    fn solve(
        &mut self,
        at: Instant<'_>,
        road: &RoadStrip,
        stage: StageMut<'_>,
        meter: &mut Meter,
    ) -> Result<Solved, ContactError>;

    /// Prepares for a step whose window has moved on by so many columns.
    fn advance(&mut self, _columns: usize) {}

    /// Returns the points across a column.
    fn across(&self) -> usize {
        1
    }

    /// Returns the columns by which the window in which contact is sought is longer, at either end, than the one that
    /// is told.
    fn margin(&self) -> usize {
        0
    }

    /// Tells whether a step that reaches the window's end is to be solved again over a wider one.
    fn is_widened(&self) -> bool {
        false
    }

    /// Tells whether its forces have a tangential part.
    fn has_friction(&self) -> bool {
        false
    }

    /// Returns the first weights \[m/N\]: other bits there mean other bits everywhere.
    fn first_weights(&self) -> &[f64];

    /// Returns the spring compliance of a column \[m/N\]; 0 without springs.
    fn spring(&self) -> f64 {
        0.0
    }

    /// Returns the work of the search so far.
    fn search_counts(&self) -> SearchCounts;

    /// Takes the state down.
    ///
    /// # Errors
    /// [`StateError`].
    fn save(&self, state: &mut StateWriter) -> Result<(), StateError>;

    /// Goes on from the state of an equal zone.
    ///
    /// # Errors
    /// [`StateError`].
    fn restore(&mut self, state: &mut StateReader<'_>) -> Result<(), StateError>;
}
