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
//! So for slices, in `slices`; over cells, `CellZone` does the same for each cell of the window.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::axle::AxleHeight;
use super::complementarity::{Residuals, SearchCounts, SliceLaw};
use super::error::ContactError;
use super::footprint::{Footprint, WindowShape};
use super::geometry::Geometry;
use super::history::ForceHistory;
use super::kernel::ContactKernel;
use super::slices::SliceZone;
use super::zone::{ContactZone, Instant};
use crate::counters::Meter;
use crate::road::strip::RoadStrip;
use crate::scene::{Numerics, TimeRule};
use crate::storage::state::{Evolving, StateError, StateStream, StateValue};

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
pub(crate) struct MarchTotals {
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
    /// The search window: for cells it may be longer than that of `geometry`, the output window.
    window: Geometry,
    /// See [`Geometry::rises`].
    rises: Vec<f64>,
    zone: Box<dyn ContactZone>,
    footprint: Footprint,
    step: u64,
    nodes: &'static [f64],
    weights: [f64; 3],
    time_step: f64,
    totals: MarchTotals,
}

impl March {
    /// Slices at rest, about to do step 0; `time_step` \[s\] is used in messages only.
    pub fn new(
        geometry: Geometry,
        kernel: ContactKernel,
        slices: SliceLaw,
        history: Box<dyn ForceHistory>,
        numerics: &Numerics,
        time_step: f64,
    ) -> Self {
        let zone = SliceZone::new(geometry.columns, kernel, slices, history, numerics);
        Self::over(Box::new(zone), geometry, numerics.time_rule, time_step)
    }

    /// A zone at rest, about to do step 0; `time_step` \[s\] is used in messages only.
    pub(crate) fn over(zone: Box<dyn ContactZone>, geometry: Geometry, rule: TimeRule, time_step: f64) -> Self {
        let (nodes, weights) = (rule.nodes(), rule.weights());
        let window = geometry.wider(zone.margin());
        let (across, sub_cells) = (zone.across(), zone.sub_cells());
        let shape = WindowShape { columns: geometry.columns, across, stages: nodes.len(), sub_cells };
        Self {
            footprint: Footprint::new(shape, weights, zone.has_friction()),
            step: 0,
            nodes,
            weights,
            time_step,
            totals: MarchTotals::default(),
            zone,
            rises: window.rises(nodes),
            window,
            geometry,
        }
    }

    /// Where the elements are whose forces are reported.
    pub fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// Forces and displacements of the last step.
    pub fn footprint(&self) -> &Footprint {
        &self.footprint
    }

    /// Elements that can touch at a step.
    pub(crate) fn reach(&self, step: u64) -> Range<i64> {
        let first = self.window.first_element(step);
        first..first + self.window.columns as i64
    }

    /// Adds the steps that previous marches solved again with a wider window.
    pub(crate) fn count_again(&mut self, edge_contacts: u64) {
        self.totals.edge_contacts += edge_contacts;
    }

    /// First weights \[m/N\]: if their bits differ between two runs, so do those of all results.
    pub(crate) fn first_weights(&self) -> &[f64] {
        self.zone.first_weights()
    }

    /// Spring compliance per element \[m/N\]; 0 without springs.
    pub fn spring(&self) -> f64 {
        self.zone.spring()
    }

    /// True if a window that contact outgrows is widened; otherwise such steps are only counted.
    pub(crate) fn is_widened(&self) -> bool {
        self.zone.is_widened()
    }

    pub(crate) fn totals(&self) -> &MarchTotals {
        &self.totals
    }

    /// Work of the search so far.
    pub fn search_counts(&self) -> SearchCounts {
        self.zone.search_counts()
    }

    /// Number of the next step.
    pub fn next_step(&self) -> u64 {
        self.step
    }

    /// Does the next step under an axle; its stages are counted and timed by `meter`.
    ///
    /// # Errors
    /// [`ContactError`]; the march cannot go on then.
    pub fn step(&mut self, axle: &AxleHeight, road: &RoadStrip, meter: &mut Meter) -> Result<StepResult, ContactError> {
        let first_element = self.geometry.first_element(self.step);
        if self.step > 0 {
            self.zone.advance((first_element - self.geometry.first_element(self.step - 1)) as usize);
        }
        let mut total_force = 0.0;
        for (stage, (&node, weight)) in self.nodes.iter().zip(self.weights).enumerate() {
            // Multistep rules solve at the step's end: exactly at l dt.
            let indentation = axle.between((self.step as f64 - 1.0) + node);
            total_force += weight * self.stage(first_element, stage, indentation, road, meter)?;
        }
        self.footprint.end_step();
        self.step += 1;
        let (points, extent) = (self.footprint.touching_columns(), self.footprint.extent());
        Ok(StepResult { first_element, total_force, points, extent })
    }

    /// Solves for the contact at an instant of the step; returns the total force \[N\].
    fn stage(
        &mut self,
        first_output: i64,
        stage: usize,
        indentation: f64,
        road: &RoadStrip,
        meter: &mut Meter,
    ) -> Result<f64, ContactError> {
        let step = self.step;
        let row = self.geometry.substep(step) * self.nodes.len() + stage;
        let rises = &self.rises[row * self.window.columns..];
        let first_element = self.window.first_element(step);
        let at = Instant { step, stage, first_element, indentation, rises };
        let solved = self.zone.solve(at, road, self.footprint.stage(stage, first_output), meter)?;
        let total_force = self.footprint.total_at(stage);
        let time = step as f64 * self.time_step;
        if !total_force.is_finite() || !solved.has_no_nan {
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
        let outside = self.window.elements - self.window.columns;
        if solved.is_at_end && self.zone.is_widened() {
            // A window grows at both ends: one column of the tyre may be left.
            return if outside > 1 { Err(ContactError::AtWindowEnd { step, time }) } else { Ok(total_force) };
        }
        totals.edge_contacts += u64::from(solved.is_at_end && outside > 0);
        Ok(total_force)
    }
}

impl Evolving for March {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        state.all([&mut self.step, &mut StateValue(&mut self.totals), &mut self.footprint, &mut self.zone])
    }
}
