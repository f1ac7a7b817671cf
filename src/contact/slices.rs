//! Slices in contact: each is level across the width and touches as a whole.

use super::complementarity::{Search, SearchCounts, SliceLaw, SlicesUnder};
use super::error::ContactError;
use super::footprint::StageMut;
use super::history::ForceHistory;
use super::kernel::ContactKernel;
use super::zone::{ContactZone, Instant, Solved};
use crate::counters::{Meter, Stage, Work};
use crate::numeric::largest_or_zero;
use crate::road::strip::RoadStrip;
use crate::scene::Numerics;
use crate::storage::state::evolving;

pub(crate) struct SliceZone {
    kernel: ContactKernel,
    history: Box<dyn ForceHistory>,
    search: Search,
}

impl SliceZone {
    pub(crate) fn new(
        columns: usize,
        kernel: ContactKernel,
        slices: SliceLaw,
        history: Box<dyn ForceHistory>,
        numerics: &Numerics,
    ) -> Self {
        let mut within_a_step = kernel.within_a_step();
        within_a_step.truncate(columns);
        let search = Search::new(within_a_step, kernel.odd_within_a_step(), kernel.is_coupled(), slices, numerics);
        Self { kernel, history, search }
    }
}

impl ContactZone for SliceZone {
    fn solve(
        &mut self,
        at: Instant<'_>,
        road: &RoadStrip,
        stage: StageMut<'_>,
        meter: &mut Meter,
    ) -> Result<Solved, ContactError> {
        let Instant { step, first_element, indentation, rises, .. } = at;
        let StageMut { force, displacement: old, required, .. } = stage;
        if !road.has_curves() {
            return Err(ContactError::RoadForm);
        }
        let mut laps = meter.laps();
        self.history.displacement(first_element, old, meter);
        old.iter_mut().for_each(|displacement| *displacement *= self.kernel.scale);
        meter.lap(&mut laps, Stage::History);
        let takes_penetrations = self.search.takes_penetrations();
        let known = old.iter().zip(rises);
        for ((element, required), (&old, &rise)) in (first_element..).zip(&mut *required).zip(known) {
            *required = match road.curve(element) {
                Some(curve) => {
                    let penetration = indentation - rise + curve.peak - old;
                    if takes_penetrations { penetration } else { curve.displacement_at(penetration) }
                }
                None => f64::NEG_INFINITY,
            };
        }
        let columns = force.len() as u64;
        // Rise, penetration and a piece of the curve: about 8 numbers and as many operations.
        meter.add_work(Stage::Penetration, Work { multiply_adds: 4 * columns, bytes: 8 * 8 * columns });
        meter.lap(&mut laps, Stage::Penetration);
        let under = SlicesUnder { slices: road, first_element };
        let residuals = self.search.forces(required, under, force, step, meter)?;
        meter.lap(&mut laps, Stage::ActiveSet);
        self.history.push(first_element, force);
        meter.lap(&mut laps, Stage::History);
        self.search.add_displacement(force, old);
        Ok(Solved {
            residuals,
            largest_force: largest_or_zero(force),
            largest_displacement: largest_or_zero(required),
            has_no_nan: required.iter().fold(true, |none, required| none & !required.is_nan()),
            is_at_end: force.first().zip(force.last()).is_some_and(|(&first, &last)| first > 0.0 || last > 0.0),
        })
    }

    fn advance(&mut self, columns: usize) {
        self.search.advance(columns);
    }

    fn first_weights(&self) -> &[f64] {
        &self.kernel.instant
    }

    fn spring(&self) -> f64 {
        self.kernel.spring
    }

    fn search_counts(&self) -> SearchCounts {
        self.search.counts()
    }
}

evolving!(SliceZone: search, history);
