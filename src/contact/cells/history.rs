//! The history of cells carried by poles: one recursion for each pole of each wave, block by block, in the background.
//!
//! Poles and states of all waves do not fit into a processor's nearest memory. They are gone through once in a *block*
//! of [`STEPS`] steps, a part of them at each instant, and another thread, if there is one, does so while the march
//! searches for the forces of that instant (module `waves`):
//! 1. forces of the previous block are taken in, and the displacement at every instant of the next block is predicted
//!    as if no more forces came;
//! 2. the contributions of the previous block and of the earlier instants of the current one to the coming instant are
//!    summed for each wave, with the first weights of the same recursion.
//!
//! The march adds the displacements by the last instant's forces, which is all that it has to wait for, and goes from
//! waves to cells and back, both without it where waves are short (module `short_ring`). By linearity that is the
//! recursion itself but for rounding, and nothing depends on which thread did what.

use num_complex::Complex;

pub use super::fewer_poles::FewerPoles;
pub use super::ring_waves::RingParts;
use super::ring_waves::{RingWaves, first_responses};
use super::short_ring::{NextInstant, ShortRing};
use super::wave_transform::{WaveNumber, WaveTransform};
use super::waves::BackgroundWaves;
use super::zone::CellHistory;
use crate::counters::{Meter, Stage, Work};
use crate::numeric::background::Background;
use crate::storage::state::{Evolving, StateError, StateStream, ensure};
use crate::time_rule::TimeRule;
use crate::tyre::influence::{CellGrid, CellInfluence, CellRow};
use crate::tyre::poles::pole_model::PoleModel;

/// Steps of a block.
pub(crate) const STEPS: usize = 4;

/// A ring that sees all of the window, on the march's side.
struct Ring<N: WaveNumber> {
    transform: WaveTransform<N>,
    /// Forces \[N\] of the last instant by wave.
    forces: Vec<Complex<N>>,
    /// Displacement \[m\] of the coming one.
    displacement: Vec<Complex<N>>,
}

/// Waves of all rings and their history, in single or double precision.
pub struct WaveHistory<N: WaveNumber = f64> {
    /// Ring by ring; `None`: a short one, which is in the background except for the last forces' displacements.
    rings: Vec<Option<Ring<N>>>,
    /// Effect of the last forces on all short rings.
    next: Option<NextInstant<N>>,
    background: Background<BackgroundWaves<N>>,
    stages: usize,
    /// Number of the coming instant in its block.
    instant: usize,
    /// True if there is a previous instant.
    begun: bool,
    instants: usize,
    /// Work of a block.
    work: Work,
}

/// Influence of the forces of each stage at the next instant, by the waves of the grid's ring, between cells of a
/// window of `columns` columns.
pub fn first_influences(
    grid: &CellGrid,
    columns: usize,
    rows: &[CellRow],
    model: &PoleModel,
    rule: TimeRule,
    time_step: f64,
) -> Vec<CellInfluence> {
    let of_stages = first_responses(model, rule, time_step);
    of_stages.iter().map(|values| CellInfluence::of_waves(grid, columns, [(grid.elements(), rows, values)])).collect()
}

/// Poles that predict the waves of a model from block to block, within a tolerance relative to each wave's influence.
pub fn fewer_poles(model: &PoleModel, rule: TimeRule, time_step: f64, tolerance: f64) -> FewerPoles {
    FewerPoles::of(model, rule, time_step, STEPS, tolerance)
}

impl<N: WaveNumber> WaveHistory<N> {
    /// Past at rest, in blocks of the default length.
    pub fn new<'m>(parts: impl IntoIterator<Item = RingParts<'m, N>>, rule: TimeRule, time_step: f64) -> Self {
        Self::with_blocks(parts, rule, time_step, STEPS)
    }

    /// Past as that of [`Self::new`], in blocks of `steps` steps.
    pub fn with_blocks<'m>(
        parts: impl IntoIterator<Item = RingParts<'m, N>>,
        rule: TimeRule,
        time_step: f64,
        steps: usize,
    ) -> Self {
        let mut work = Work::default();
        let (mut rings, mut waves) = (Vec::new(), Vec::new());
        let mut influences: Option<Vec<CellInfluence>> = None;
        for parts in parts {
            let ring = RingWaves::new(&parts, rule, time_step, steps);
            let RingParts { model, transform, next_instant, .. } = parts;
            work += ring.work();
            work += transform.work() * (2 * steps * rule.stages()) as u64;
            let zeros = || vec![Complex::new(N::default(), N::default()); model.len()];
            if let Some(next) = next_instant {
                match &mut influences {
                    Some(all) => all.iter_mut().zip(&next).for_each(|(all, next)| *all += next),
                    None => influences = Some(next),
                }
                rings.push(None);
                waves.push((ring, Some(ShortRing::new(transform))));
            } else {
                rings.push(Some(Ring { transform, forces: zeros(), displacement: zeros() }));
                waves.push((ring, None));
            }
        }
        let next = influences.map(|influences| NextInstant::new(&influences));
        if let Some(next) = &next {
            work += next.work() * steps as u64;
        }
        let background = Background::on_a_thread(BackgroundWaves::new(waves, rule));
        let stages = rule.stages();
        Self { rings, next, background, stages, instant: 0, begun: false, instants: steps * stages, work }
    }

    /// Adds the displacements by past forces at the coming instant \[m\] on the window that begins with
    /// `first_element`; the forces of every instant have to be pushed before the next.
    pub fn add_displacement(&mut self, first_element: i64, out: &mut [f64], meter: &mut Meter) {
        let mut waves = self.background.take();
        waves.report(meter);
        let last = self.begun.then(|| (self.instant + self.instants - 1) % self.instants);
        if self.instant == 0 {
            meter.add_work(Stage::History, self.work);
        }
        for (ring, (waves, short)) in self.rings.iter_mut().zip(&mut waves.rings) {
            if let Some(Ring { forces, displacement, .. }) = ring {
                if let Some(last) = last {
                    waves.take_forces(last, forces);
                }
                if self.instant == 0 {
                    waves.turn();
                }
                waves.finish(self.instant);
                waves.displacement(displacement);
            } else if let (Some(short), Some(next)) = (short, &self.next) {
                short.field.add_to(first_element, out);
                short.last.copy_from(&next.last);
            }
        }
        waves.begin(self.instant, last, meter.cpu_clock());
        self.background.begin(waves);
        for Ring { transform, displacement, .. } in self.rings.iter_mut().flatten() {
            transform.add_inverse(displacement, first_element, out);
        }
        if let (Some(next), Some(last)) = (&mut self.next, last) {
            next.add_displacement(last % self.stages, first_element, out);
        }
    }

    /// Takes the forces of the instant \[N\]; returns whether all of them fit.
    pub fn push(&mut self, first_element: i64, forces: &[f64]) -> bool {
        for Ring { transform, forces: of_waves, .. } in self.rings.iter_mut().flatten() {
            transform.forward(first_element, forces, of_waves);
        }
        let fits = self.next.as_mut().is_none_or(|next| next.last.take(first_element, forces));
        self.instant = (self.instant + 1) % self.instants;
        self.begun = true;
        fits
    }
}

impl<N: WaveNumber> Evolving for WaveHistory<N> {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        let Self { rings, next, background, instant, begun, instants, .. } = self;
        state.all([instant, begun])?;
        ensure(*instant < *instants)?;
        if let Some(next) = next {
            next.last.state(state)?;
        }
        rings.iter_mut().flatten().try_for_each(|ring| ring.forces.state(state))?;
        background.with(|waves| waves.rings.state(state))
    }
}

impl<N: WaveNumber> CellHistory<1> for WaveHistory<N> {
    fn add_displacement(&mut self, _: usize, first_element: i64, out: &mut [[f64; 1]], meter: &mut Meter) {
        self.add_displacement(first_element, out.as_flattened_mut(), meter);
    }

    fn push(&mut self, _: usize, first_element: i64, forces: &[[f64; 1]]) -> bool {
        self.push(first_element, forces.as_flattened())
    }
}
