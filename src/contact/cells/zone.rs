//! The contact of one instant over all cells of the window.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::direct::{DirectPast, DirectPastState};
use super::instant::InstantCells;
use super::past::{WavePast, WavePastState};
use super::search::{CellCounts, CellSearch};
use crate::contact::complementarity::{Residuals, SearchCounts};
use crate::contact::slice_queue::SliceQueue;
use crate::counters::{Meter, Stage, Work};
use crate::numeric::largest_or_zero;
use crate::storage::state::{StateError, fill};
use crate::tyre::influence::CellInfluence;

/// How cells carry the past along.
pub enum CellPast {
    /// By poles.
    Modal(Box<WavePast>),
    /// As sums.
    Direct(Box<DirectPast>),
}

/// State of a [`CellPast`].
#[derive(Clone, Debug, Deserialize, Serialize)]
pub enum CellPastState {
    /// State of [`CellPast::Modal`].
    Modal(WavePastState),
    /// State of [`CellPast::Direct`].
    Direct(DirectPastState),
}

impl CellPast {
    /// Adds what the past displaces at a stage of the step \[m\].
    fn add_displacement(&mut self, stage: usize, first_element: i64, out: &mut [f64], meter: &mut Meter) {
        match self {
            Self::Modal(past) => past.add_displacement(first_element, out, meter),
            Self::Direct(past) => {
                if stage == 0 {
                    meter.add_work(Stage::History, past.work());
                }
                past.add_displacement(stage, first_element, out);
            }
        }
    }

    /// Takes the forces of a stage \[N\].
    fn push(&mut self, stage: usize, first_element: i64, forces: &[f64]) {
        match self {
            Self::Modal(past) => past.push(first_element, forces),
            Self::Direct(past) => past.push(stage, first_element, forces),
        }
    }

    fn save(&self) -> CellPastState {
        match self {
            Self::Modal(past) => CellPastState::Modal(past.save()),
            Self::Direct(past) => CellPastState::Direct(past.save()),
        }
    }

    fn restore(&mut self, state: &CellPastState) -> Result<(), StateError> {
        match (self, state) {
            (Self::Modal(past), CellPastState::Modal(state)) => past.restore(state),
            (Self::Direct(past), CellPastState::Direct(state)) => past.restore(state),
            _ => Err(StateError::Value),
        }
    }
}

/// The cells of a window, column by column. The window may be longer than the one whose forces are told: what is beyond
/// its ends then counts with their columns.
pub struct CellZone {
    across: usize,
    /// Columns of the window beyond either end of what is told.
    margin: usize,
    /// Height of the tread above its middle by cell across \[m\]: the crown; infinite where there is a void.
    crown: Vec<f64>,
    past: CellPast,
    search: CellSearch,
    /// Forces of the last instant, then of this one \[N\], and the element that they begin with.
    forces: Vec<f64>,
    first_element: i64,
    required: Vec<f64>,
    /// Displacements left over from the past \[m\].
    old: Vec<f64>,
    /// Forces and displacements at the step's instants, one after the other: those that are told.
    instant_forces: Vec<f64>,
    instant_displacements: Vec<f64>,
    /// Forces of the last step: the mean of those at its instants \[N\].
    mean: Vec<f64>,
}

/// State of a [`CellZone`].
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct CellZoneState {
    past: CellPastState,
    counts: CellCounts,
    forces: Vec<f64>,
    first_element: i64,
}

/// Result of an instant.
pub(crate) struct Instant {
    /// How far the contact conditions are missed.
    pub residuals: Residuals,
    /// Largest force on a cell \[N\].
    pub largest_force: f64,
    /// Largest required displacement \[m\].
    pub largest_displacement: f64,
    /// True if every required displacement is a number.
    pub is_sound: bool,
    /// True if an outermost column of the window carries force.
    pub is_at_end: bool,
}

impl CellZone {
    /// At rest. `crown`: height of the tread above its middle by cell across \[m\]; `tolerance` is how far a cell may
    /// be from where it is required to be, relative to the largest required displacement; a step has so many stages.
    /// The window is longer by `margin` columns at either end than what is told.
    pub fn new(
        influence: CellInfluence,
        crown: Vec<f64>,
        past: CellPast,
        stages: usize,
        tolerance: f64,
        margin: usize,
    ) -> Self {
        let across = influence.across;
        let cells = influence.columns * across;
        let told = (influence.columns - 2 * margin) * across;
        Self {
            across,
            margin,
            crown,
            past,
            search: CellSearch::new(InstantCells::new(influence), tolerance),
            forces: vec![0.0; cells],
            first_element: i64::MIN,
            required: vec![0.0; cells],
            old: vec![0.0; cells],
            instant_forces: vec![0.0; stages * told],
            instant_displacements: vec![0.0; stages * told],
            mean: vec![0.0; told],
        }
    }

    /// Columns of the window beyond either end of what is told.
    pub(crate) fn margin(&self) -> usize {
        self.margin
    }

    /// The cells that are told, among those of the window.
    fn told(&self) -> Range<usize> {
        let outside = self.margin * self.across;
        outside..self.forces.len() - outside
    }

    /// Cells across.
    pub fn across(&self) -> usize {
        self.across
    }

    /// First weights of the free field \[m/N\].
    pub fn first_weights(&self) -> &[f64] {
        self.search.cells().free_field()
    }

    /// Forces at the last step's instants, stage after stage, cell by cell \[N\].
    pub fn instant_forces(&self) -> &[f64] {
        &self.instant_forces
    }

    /// Forces of the last step, cell by cell \[N\]: for a Runge-Kutta rule their mean over the step.
    pub fn forces_of_step(&self) -> &[f64] {
        &self.mean
    }

    /// The step is done: its forces are those of its instants with these weights.
    pub(crate) fn end_step(&mut self, weights: &[f64]) {
        self.mean.fill(0.0);
        for (forces, weight) in self.instant_forces.chunks_exact(self.mean.len()).zip(weights) {
            for (mean, force) in self.mean.iter_mut().zip(forces) {
                *mean += weight * force;
            }
        }
    }

    /// Displacements likewise \[m\].
    pub fn instant_displacements(&self) -> &[f64] {
        &self.instant_displacements
    }

    /// Required displacements of the last instant, cell by cell \[m\].
    pub fn required(&self) -> &[f64] {
        &self.required[self.told()]
    }

    /// Returns the work of the search so far.
    pub fn search_counts(&self) -> SearchCounts {
        let CellCounts { iterations, fallbacks, products, .. } = self.search.counts();
        let cells = self.forces.len() as u64;
        // Two transforms of a grid of four times the cells.
        let product = 4 * cells * u64::from(1 + (4 * cells).ilog2());
        let work = Work { multiply_adds: products * product, bytes: products * 64 * cells };
        SearchCounts { solves: iterations, fallbacks, work, ..SearchCounts::default() }
    }

    /// Solves for the contact at a stage of the step, `rises` being the heights of the undeformed tread by column of
    /// the window, which begins with `first_element`, and leaves the forces summed over each column that is told in
    /// `rows`.
    pub(crate) fn solve(
        &mut self,
        (stage, first_element): (usize, i64),
        indentation: f64,
        rises: &[f64],
        road: &SliceQueue,
        rows: &mut [f64],
        meter: &mut Meter,
    ) -> Instant {
        let cells = self.forces.len();
        let old = &mut self.old;
        let mut laps = meter.laps();
        old.fill(0.0);
        self.past.add_displacement(stage, first_element, old, meter);
        meter.lap(&mut laps, Stage::History);
        let required = self.required.chunks_exact_mut(self.across).zip(old.chunks_exact(self.across));
        for ((element, (required, old)), rise) in (first_element..).zip(required).zip(rises) {
            match road.heights(element) {
                Some(heights) => {
                    let cells = required.iter_mut().zip(old).zip(heights).zip(&self.crown);
                    for (((required, old), height), crown) in cells {
                        *required = indentation - rise - crown + height - old;
                    }
                }
                None => required.fill(f64::NEG_INFINITY),
            }
        }
        meter.add_work(Stage::Penetration, Work { multiply_adds: 4 * cells as u64, bytes: 40 * cells as u64 });
        meter.lap(&mut laps, Stage::Penetration);
        // Cells are material: forces move with them through the window.
        let moved = usize::try_from(first_element.saturating_sub(self.first_element)).unwrap_or(usize::MAX);
        let moved = moved.saturating_mul(self.across).min(cells);
        if self.forces[..moved].iter().all(|force| *force <= 0.0) {
            self.search.go_on(moved);
        }
        self.forces.copy_within(moved.., 0);
        self.forces[cells - moved..].fill(0.0);
        self.first_element = first_element;
        let relative = self.search.solve(&self.required, &mut self.forces);
        let largest_displacement = largest_or_zero(&self.required);
        let largest_force = largest_or_zero(&self.forces);
        meter.lap(&mut laps, Stage::ActiveSet);
        self.past.push(stage, first_element, &self.forces);
        meter.lap(&mut laps, Stage::History);
        self.tell(stage, rows);
        let is_touched = |column: Option<&[f64]>| column.is_some_and(|cells| cells.iter().any(|&force| force > 0.0));
        let mut columns = self.forces.chunks_exact(self.across);
        let is_at_end = is_touched(columns.next()) || is_touched(columns.next_back());
        let residuals = Residuals {
            tension: relative.tension * largest_force,
            penetration: relative.penetration * largest_displacement,
            complementarity: relative.complementarity * largest_displacement * largest_force,
        };
        let is_sound = self.required.iter().fold(true, |sound, required| sound & !required.is_nan());
        Instant { residuals, largest_force, largest_displacement, is_sound, is_at_end }
    }

    /// Tells forces and displacements of an instant. Forces beyond the columns that are told go to the outermost of
    /// these, so that none is lost.
    fn tell(&mut self, stage: usize, rows: &mut [f64]) {
        let told = self.told();
        let now = stage * told.len()..(stage + 1) * told.len();
        let u = self.old[told.clone()].iter().zip(&self.search.displacement()[told.clone()]);
        for (out, (old, u)) in self.instant_displacements[now.clone()].iter_mut().zip(u) {
            *out = old + u;
        }
        let forces = &mut self.instant_forces[now];
        forces.copy_from_slice(&self.forces[told.clone()]);
        let last = told.len() - self.across;
        for (end, outside) in [(0, &self.forces[..told.start]), (last, &self.forces[told.end..])] {
            for column in outside.chunks_exact(self.across) {
                for (force, outside) in forces[end..].iter_mut().zip(column) {
                    *force += outside;
                }
            }
        }
        for (row, cells) in rows.iter_mut().zip(forces.chunks_exact(self.across)) {
            *row = cells.iter().sum();
        }
    }

    /// Takes the state down.
    pub fn save(&self) -> CellZoneState {
        CellZoneState {
            past: self.past.save(),
            counts: self.search.counts(),
            forces: self.forces.clone(),
            first_element: self.first_element,
        }
    }

    /// Goes on from the state of an equal zone.
    ///
    /// # Errors
    /// [`StateError`].
    pub fn restore(&mut self, state: &CellZoneState) -> Result<(), StateError> {
        self.past.restore(&state.past)?;
        self.first_element = state.first_element;
        fill(&mut self.forces, &state.forces)?;
        self.search.restore(state.counts, &self.forces);
        Ok(())
    }
}
