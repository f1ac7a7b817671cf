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

use serde::{Deserialize, Serialize};

use super::axle::AxleHeight;
use super::complementarity::{Residuals, Search, SearchCounts, SearchState, SliceLaw, SlicesUnder};
use super::error::ContactError;
use super::geometry::Geometry;
use super::history::{HistoryState, PastForces};
use super::kernel::ContactKernel;
use super::slice_queue::SliceQueue;
use crate::counters::{Meter, Stage, Work};
use crate::numeric::largest_or_zero;
use crate::scene::Numerics;
use crate::storage::state::{StateError, fill};

/// What one step gave.
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
    /// Steps in which an outermost column carried force.
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
    /// See [`Geometry::rises`].
    rises: Vec<f64>,
    kernel: ContactKernel,
    history: Box<dyn PastForces>,
    search: Search,
    /// Forces and displacements at the step's instants, one after the other.
    instant_forces: Vec<f64>,
    instant_displacements: Vec<f64>,
    /// Their mean force.
    forces: Vec<f64>,
    required: Vec<f64>,
    step: u64,
    nodes: &'static [f64],
    weights: [f64; 3],
    time_step: f64,
    totals: MarchTotals,
}

/// What evolves of a [`March`].
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct MarchState {
    step: u64,
    totals: MarchTotals,
    forces: Vec<f64>,
    search: SearchState,
    history: HistoryState,
}

impl March {
    /// Everything at rest, about to do step 0; `time_step` \[s\] is for messages only.
    pub fn new(
        geometry: Geometry,
        kernel: ContactKernel,
        slices: SliceLaw,
        history: Box<dyn PastForces>,
        numerics: &Numerics,
        time_step: f64,
    ) -> Self {
        let columns = geometry.columns;
        let nodes = numerics.time_rule.nodes();
        let mut within_a_step = kernel.within_a_step();
        within_a_step.truncate(columns);
        Self {
            history,
            search: Search::new(within_a_step, kernel.is_coupled(), slices, numerics),
            instant_forces: vec![0.0; columns * nodes.len()],
            instant_displacements: vec![0.0; columns * nodes.len()],
            forces: vec![0.0; columns],
            required: vec![0.0; columns],
            step: 0,
            nodes,
            weights: numerics.time_rule.weights(),
            time_step,
            totals: MarchTotals::default(),
            rises: geometry.rises(nodes),
            geometry,
            kernel,
        }
    }

    /// Where the elements are.
    pub fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// Influence functions in use.
    pub fn kernel(&self) -> &ContactKernel {
        &self.kernel
    }

    /// Forces of the last step by column of the window \[N\]: for a Runge-Kutta rule their mean over the step.
    pub fn forces(&self) -> &[f64] {
        &self.forces
    }

    /// Forces at the last step's instants, stage after stage, by column of the window \[N\].
    pub fn instant_forces(&self) -> &[f64] {
        &self.instant_forces
    }

    /// Displacements at the last step's instants, stage after stage, by column \[m\]: u = G0 F + u_old with the
    /// springs' own.
    pub(crate) fn instant_displacements(&self) -> &[f64] {
        &self.instant_displacements
    }

    /// Required displacements of the last step by column \[m\]; -infinity where there is no road.
    pub fn required(&self) -> &[f64] {
        &self.required
    }

    /// Totals so far.
    pub(crate) fn totals(&self) -> &MarchTotals {
        &self.totals
    }

    /// What the search did so far.
    pub fn search_counts(&self) -> SearchCounts {
        self.search.counts()
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
        if self.step > 0 {
            self.search.advance((first_element - self.geometry.first_element(self.step - 1)) as usize);
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
        let now = stage * columns..(stage + 1) * columns;
        let (forces, old) = (&mut self.instant_forces[now.clone()], &mut self.instant_displacements[now]);
        let mut laps = meter.laps();
        self.history.displacement(first_element, old, meter);
        old.iter_mut().for_each(|displacement| *displacement *= self.kernel.scale);
        meter.lap(&mut laps, Stage::History);
        let takes_penetrations = self.search.takes_penetrations();
        let row = self.geometry.substep(step) * self.nodes.len() + stage;
        let rises = &self.rises[row * columns..];
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
        let total_force: f64 = forces.iter().sum();
        let time = step as f64 * self.time_step;
        if !total_force.is_finite() || self.required.iter().fold(false, |lost, required| lost | required.is_nan()) {
            return Err(ContactError::NotFinite { step, time });
        }
        let (displacement, radius) = (largest_or_zero(&self.required), self.geometry.radius);
        if displacement > radius {
            return Err(ContactError::Unbounded { step, time, displacement, radius });
        }
        let totals = &mut self.totals;
        totals.residuals = totals.residuals.worst(residuals);
        totals.largest_force = totals.largest_force.max(largest_or_zero(forces));
        totals.largest_displacement = totals.largest_displacement.max(displacement);
        let edge = forces.first().zip(forces.last()).is_some_and(|(&first, &last)| first > 0.0 || last > 0.0);
        totals.edge_contacts += u64::from(edge && forces.len() < self.geometry.elements);
        Ok(total_force)
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
            search: self.search.save(),
            history: self.history.save(),
        }
    }

    /// Goes on from the state of an equal march.
    ///
    /// # Errors
    /// [`StateError`]; the march is of no use then.
    pub fn restore(&mut self, state: MarchState) -> Result<(), StateError> {
        let MarchState { step, totals, forces, search, history } = state;
        (self.step, self.totals) = (step, totals);
        fill(&mut self.forces, &forces)?;
        self.search.restore(search)?;
        self.history.restore(history)
    }
}
