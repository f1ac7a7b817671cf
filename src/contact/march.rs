//! One time step after the other.
//!
//! Step l solves at t = l dt; a Runge-Kutta rule at its stages t = (l - 1 + c_i) dt, one after the other. Its force of
//! the step is sum_i b_i F_i, the mean from (l - 1) dt to l dt, which is what moves the tyre: a single stage's force
//! has the stage order 1 only (measured on a smooth road, N = 512, 80 km/h: the mean force is 2767.3 N by sum_i b_i F_i
//! and 2504 N by the last stage of `sdirk2`, 2767.7 N converged). Everything is at rest at t = -dt; the axle waits
//! until t = 0. At each time:
//! 1. u_old of every element of the window from the history;
//! 2. penetration y_i = indentation - rise(x_i) + peak_i - u_old_i and required displacement d_i = S_i(y_i), or the gap
//!    y_i itself where y_i <= 0;
//! 3. forces: the active set (elastic, bedding), or each point by itself (uncoupled); where slices yield by themselves
//!    the search takes y_i itself and d_i follows from the forces;
//! 4. the forces join the history.
//!
//! So for slices; over cells, [`CellZone`] does the same for each cell of the window.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::axle::AxleHeight;
use super::cells::zone::Instant;
use super::cells::{CellZone, CellZoneState};
use super::complementarity::{Residuals, Search, SearchCounts, SearchState, SliceLaw, SlicesUnder};
use super::error::ContactError;
use super::geometry::Geometry;
use super::history::{HistoryState, PastForces};
use super::kernel::ContactKernel;
use super::slice_queue::SliceQueue;
use crate::counters::{Meter, Stage, Work};
use crate::numeric::largest_or_zero;
use crate::scene::{Numerics, TimeRule};
use crate::storage::state::{StateError, fill};

/// Result of one step.
#[derive(Clone, Copy, Debug)]
pub struct StepResult {
    /// Element number of the window's first column.
    pub first_element: i64,
    /// Sum of the forces \[N\].
    pub total_force: f64,
    /// Points that carry force.
    pub points: usize,
    /// Columns from the first to the last point that carries force.
    pub extent: usize,
}

/// Totals over all steps.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub struct MarchTotals {
    /// Worst residuals, absolute.
    pub residuals: Residuals,
    /// Largest force on a point \[N\].
    pub largest_force: f64,
    /// Largest required displacement \[m\].
    pub largest_displacement: f64,
    /// Steps in which an outermost column carried force; of cells, steps that were solved again with a wider window.
    pub edge_contacts: u64,
}

impl MarchTotals {
    /// Residuals relative to the largest force, the largest displacement and their product.
    pub(crate) fn relative_residuals(&self) -> Residuals {
        let relative = |value: f64, scale: f64| if value > 0.0 { value / scale } else { 0.0 };
        Residuals {
            tension: relative(self.residuals.tension, self.largest_force),
            penetration: relative(self.residuals.penetration, self.largest_displacement),
            complementarity: relative(self.residuals.complementarity, self.largest_force * self.largest_displacement),
        }
    }
}

/// The state of a rolling contact.
pub struct March {
    geometry: Geometry,
    /// The window in which contact is sought: for cells it may be longer than that of `geometry`, which is told.
    window: Geometry,
    /// See [`Geometry::rises`].
    rises: Vec<f64>,
    zone: Zone,
    /// Forces at the step's instants by column, one after the other.
    instant_forces: Vec<f64>,
    /// Their mean.
    forces: Vec<f64>,
    step: u64,
    nodes: &'static [f64],
    weights: [f64; 3],
    time_step: f64,
    totals: MarchTotals,
}

/// Zone of the contact: slices or cells.
enum Zone {
    /// Slices, each level across the width.
    Slices(SliceZone),
    /// Cells all over the zone.
    Cells(Box<CellZone>),
}

/// Slices in contact.
struct SliceZone {
    kernel: ContactKernel,
    history: Box<dyn PastForces>,
    search: Search,
    /// Displacements at the step's instants, one after the other.
    instant_displacements: Vec<f64>,
    required: Vec<f64>,
}

/// State of a [`March`].
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct MarchState {
    step: u64,
    totals: MarchTotals,
    forces: Vec<f64>,
    zone: ZoneState,
}

/// State of a [`Zone`].
#[derive(Clone, Debug, Deserialize, Serialize)]
enum ZoneState {
    Slices(Box<(SearchState, HistoryState)>),
    Cells(Box<CellZoneState>),
}

impl March {
    /// Slices at rest, about to do step 0; `time_step` \[s\] is for messages only.
    pub fn new(
        geometry: Geometry,
        kernel: ContactKernel,
        slices: SliceLaw,
        history: Box<dyn PastForces>,
        numerics: &Numerics,
        time_step: f64,
    ) -> Self {
        let columns = geometry.columns;
        let mut within_a_step = kernel.within_a_step();
        within_a_step.truncate(columns);
        let zone = SliceZone {
            history,
            search: Search::new(within_a_step, kernel.is_coupled(), slices, numerics),
            instant_displacements: vec![0.0; columns * numerics.time_rule.stages()],
            required: vec![0.0; columns],
            kernel,
        };
        Self::over(Zone::Slices(zone), geometry, 0, numerics.time_rule, time_step)
    }

    /// Cells at rest, about to do step 0; `time_step` \[s\] is for messages only.
    pub fn with_cells(geometry: Geometry, zone: CellZone, rule: TimeRule, time_step: f64) -> Self {
        let margin = zone.margin();
        Self::over(Zone::Cells(Box::new(zone)), geometry, margin, rule, time_step)
    }

    fn over(zone: Zone, geometry: Geometry, margin: usize, rule: TimeRule, time_step: f64) -> Self {
        let (columns, nodes) = (geometry.columns, rule.nodes());
        let window = geometry.wider(margin);
        Self {
            zone,
            instant_forces: vec![0.0; columns * nodes.len()],
            forces: vec![0.0; columns],
            step: 0,
            nodes,
            weights: rule.weights(),
            time_step,
            totals: MarchTotals::default(),
            rises: window.rises(nodes),
            window,
            geometry,
        }
    }

    /// Where the elements are whose forces are told.
    pub fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// Elements that can touch at a step.
    pub(crate) fn reach(&self, step: u64) -> Range<i64> {
        let first = self.window.first_element(step);
        first..first + self.window.columns as i64
    }

    /// Steps that were solved again with a wider window by the marches before.
    pub(crate) fn count_again(&mut self, edge_contacts: u64) {
        self.totals.edge_contacts += edge_contacts;
    }

    /// First weights \[m/N\]: other bits there mean other bits everywhere.
    pub(crate) fn first_weights(&self) -> &[f64] {
        match &self.zone {
            Zone::Slices(zone) => &zone.kernel.instant,
            Zone::Cells(zone) => zone.first_weights(),
        }
    }

    /// Spring compliance per element \[m/N\]; 0 without springs.
    pub fn spring(&self) -> f64 {
        match &self.zone {
            Zone::Slices(zone) => zone.kernel.spring,
            Zone::Cells(_) => 0.0,
        }
    }

    /// Points across of [`Self::instant_forces`]: cells, or the slice as a whole.
    pub fn points_across(&self) -> usize {
        match &self.zone {
            Zone::Slices(_) => 1,
            Zone::Cells(zone) => zone.across(),
        }
    }

    /// The cells, where the contact is one of cells.
    pub fn cells(&self) -> Option<&CellZone> {
        match &self.zone {
            Zone::Slices(_) => None,
            Zone::Cells(zone) => Some(zone),
        }
    }

    /// Forces of the last step by column of the window \[N\]: for a Runge-Kutta rule their mean over the step.
    pub fn forces(&self) -> &[f64] {
        &self.forces
    }

    /// Forces at the last step's instants, stage after stage, by point of the window \[N\].
    pub fn instant_forces(&self) -> &[f64] {
        match &self.zone {
            Zone::Slices(_) => &self.instant_forces,
            Zone::Cells(zone) => zone.instant_forces(),
        }
    }

    /// Displacements at the last step's instants, stage after stage, by point \[m\]: u = G0 F + u_old with the
    /// springs' own.
    pub(crate) fn instant_displacements(&self) -> &[f64] {
        match &self.zone {
            Zone::Slices(zone) => &zone.instant_displacements,
            Zone::Cells(zone) => zone.instant_displacements(),
        }
    }

    /// Required displacements of the last step by point \[m\]; -infinity where there is no road.
    pub fn required(&self) -> &[f64] {
        match &self.zone {
            Zone::Slices(zone) => &zone.required,
            Zone::Cells(zone) => zone.required(),
        }
    }

    /// Totals so far.
    pub(crate) fn totals(&self) -> &MarchTotals {
        &self.totals
    }

    /// Returns the work of the search so far.
    pub fn search_counts(&self) -> SearchCounts {
        match &self.zone {
            Zone::Slices(zone) => zone.search.counts(),
            Zone::Cells(zone) => zone.search_counts(),
        }
    }

    /// Number of the next step.
    pub fn next_step(&self) -> u64 {
        self.step
    }

    /// Does the next step under an axle; its stages are counted and timed by `meter`.
    ///
    /// # Errors
    /// [`ContactError`]; the march cannot go on then.
    pub fn step(
        &mut self,
        axle: &AxleHeight,
        slices: &SliceQueue,
        meter: &mut Meter,
    ) -> Result<StepResult, ContactError> {
        let first_element = self.geometry.first_element(self.step);
        if let Zone::Slices(zone) = &mut self.zone
            && self.step > 0
        {
            zone.search.advance((first_element - self.geometry.first_element(self.step - 1)) as usize);
        }
        let mut total_force = 0.0;
        self.forces.fill(0.0);
        for (stage, (&node, weight)) in self.nodes.iter().zip(self.weights).enumerate() {
            // Multistep rules solve at the step's end: exactly at l dt.
            let indentation = axle.between((self.step as f64 - 1.0) + node);
            total_force += weight * self.stage(first_element, stage, indentation, slices, meter)?;
            for (mean, force) in self.forces.iter_mut().zip(&self.instant_forces[stage * self.geometry.columns..]) {
                *mean += weight * force;
            }
        }
        if let Zone::Cells(zone) = &mut self.zone {
            zone.end_step(&self.weights);
        }
        self.step += 1;
        let forces = self.forces();
        let from = forces.iter().position(|&force| force > 0.0);
        let to = forces.iter().rposition(|&force| force > 0.0);
        Ok(StepResult {
            first_element,
            total_force,
            points: forces.iter().filter(|&&force| force > 0.0).count(),
            extent: from.zip(to).map_or(0, |(from, to)| to - from + 1),
        })
    }

    /// Solves for the contact at an instant of the step; returns the total force.
    fn stage(
        &mut self,
        first_element: i64,
        stage: usize,
        indentation: f64,
        slices: &SliceQueue,
        meter: &mut Meter,
    ) -> Result<f64, ContactError> {
        let (step, columns) = (self.step, self.geometry.columns);
        let forces = &mut self.instant_forces[stage * columns..(stage + 1) * columns];
        let row = self.geometry.substep(step) * self.nodes.len() + stage;
        let rises = &self.rises[row * self.window.columns..];
        let solved = match &mut self.zone {
            Zone::Slices(zone) => {
                zone.solve((step, stage, first_element), indentation, rises, slices, forces, meter)?
            }
            Zone::Cells(zone) => {
                let first_element = self.window.first_element(step);
                zone.solve((stage, first_element), indentation, rises, slices, forces, meter)
            }
        };
        let total_force: f64 = forces.iter().sum();
        let time = step as f64 * self.time_step;
        if !total_force.is_finite() || !solved.is_sound {
            return Err(ContactError::NotFinite { step, time });
        }
        let (displacement, radius) = (solved.largest_displacement, self.geometry.radius);
        if displacement > radius {
            return Err(ContactError::Unbounded { step, time, displacement, radius });
        }
        let totals = &mut self.totals;
        totals.residuals = totals.residuals.worst(solved.residuals);
        totals.largest_force = totals.largest_force.max(solved.largest_force);
        totals.largest_displacement = totals.largest_displacement.max(displacement);
        // A window grows at both ends: one column of the tyre may be left.
        let outside = self.window.elements - self.window.columns;
        match &self.zone {
            Zone::Cells(_) if solved.is_at_end && outside > 1 => Err(ContactError::AtWindowEnd { step, time }),
            Zone::Slices(_) => {
                totals.edge_contacts += u64::from(solved.is_at_end && outside > 0);
                Ok(total_force)
            }
            Zone::Cells(_) => Ok(total_force),
        }
    }
}

impl SliceZone {
    /// Solves for the contact at a stage of a step, `rises` being the heights of the undeformed tread by column.
    fn solve(
        &mut self,
        (step, stage, first_element): (u64, usize, i64),
        indentation: f64,
        rises: &[f64],
        slices: &SliceQueue,
        forces: &mut [f64],
        meter: &mut Meter,
    ) -> Result<Instant, ContactError> {
        let columns = forces.len();
        let old = &mut self.instant_displacements[stage * columns..(stage + 1) * columns];
        let mut laps = meter.laps();
        self.history.displacement(first_element, old, meter);
        old.iter_mut().for_each(|displacement| *displacement *= self.kernel.scale);
        meter.lap(&mut laps, Stage::History);
        let takes_penetrations = self.search.takes_penetrations();
        let past = old.iter().zip(rises);
        for ((element, required), (&old, &rise)) in (first_element..).zip(&mut self.required).zip(past) {
            *required = match slices.get(element) {
                Some(curve) => {
                    let penetration = indentation - rise + curve.peak - old;
                    if takes_penetrations { penetration } else { curve.displacement_at(penetration) }
                }
                None => f64::NEG_INFINITY,
            };
        }
        let columns = columns as u64;
        // Rise, penetration and a piece of the curve: about 8 numbers and as many operations.
        meter.add_work(Stage::Penetration, Work { multiply_adds: 4 * columns, bytes: 8 * 8 * columns });
        meter.lap(&mut laps, Stage::Penetration);
        let under = SlicesUnder { slices, first_element };
        let residuals = self.search.forces(&mut self.required, under, forces, step, meter)?;
        meter.lap(&mut laps, Stage::ActiveSet);
        self.history.push(first_element, forces);
        meter.lap(&mut laps, Stage::History);
        self.search.add_displacement(forces, old);
        Ok(Instant {
            residuals,
            largest_force: largest_or_zero(forces),
            largest_displacement: largest_or_zero(&self.required),
            is_sound: self.required.iter().fold(true, |sound, required| sound & !required.is_nan()),
            is_at_end: forces.first().zip(forces.last()).is_some_and(|(&first, &last)| first > 0.0 || last > 0.0),
        })
    }
}

/// The state between two steps.
impl March {
    /// Takes the state down.
    pub fn save(&self) -> MarchState {
        MarchState {
            step: self.step,
            totals: self.totals.clone(),
            forces: self.forces.clone(),
            zone: match &self.zone {
                Zone::Slices(zone) => ZoneState::Slices(Box::new((zone.search.save(), zone.history.save()))),
                Zone::Cells(zone) => ZoneState::Cells(Box::new(zone.save())),
            },
        }
    }

    /// Goes on from the state of an equal march.
    ///
    /// # Errors
    /// [`StateError`]; the march is of no use then.
    pub fn restore(&mut self, state: MarchState) -> Result<(), StateError> {
        let MarchState { step, totals, forces, zone } = state;
        (self.step, self.totals) = (step, totals);
        fill(&mut self.forces, &forces)?;
        match (&mut self.zone, zone) {
            (Zone::Slices(zone), ZoneState::Slices(state)) => {
                let (search, history) = *state;
                zone.search.restore(search)?;
                zone.history.restore(history)
            }
            (Zone::Cells(zone), ZoneState::Cells(state)) => zone.restore(&state),
            _ => Err(StateError::Value),
        }
    }
}
