//! The past of cells carried by poles: one recursion for each pole of each wave, block by block, in the background.
//!
//! Poles and states of all waves do not fit into a processor's nearest memory. They are gone through once in a *block*
//! of [`STEPS`] steps, a part of them at each instant, and another thread, if there is one, does so while the march
//! searches for the forces of that instant (module `waves`):
//! 1. forces of the previous block are taken in, and the displacement at every instant of the next block is foretold
//!    as if no more forces came;
//! 2. the contributions of the previous block and of the earlier instants of the current one to the coming instant are
//!    summed for each wave, with the first weights of the same recursion.
//!
//! The march adds the displacements by the last instant's forces, which is all that it has to wait for, and goes from
//! waves to cells and back, both without it where waves are short (module `short_ring`). By linearity that is the
//! recursion itself but for rounding, and nothing depends on which thread did what.

use num_complex::Complex;
use serde::{Deserialize, Serialize};

pub use super::ring_waves::RingParts;
use super::ring_waves::{RingWaves, first_responses};
use super::short_ring::{NextInstant, Seen, ShortRing};
use super::wave_transform::{WaveNumber, WaveTransform};
use super::waves::Waves;
use super::zone::CellPast;
use crate::contact::history::background::BackgroundTask;
use crate::counters::{Meter, Stage, Work};
use crate::storage::state::{StateError, StateReader, StateWriter, fill, fill_all};
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

/// Waves of all rings and their past, in single or double precision.
pub struct WavePast<N: WaveNumber = f64> {
    /// Ring by ring; `None`: a short one, which is in the background except for the last forces' displacements.
    rings: Vec<Option<Ring<N>>>,
    /// Effect of the last forces on all short rings.
    next: Option<NextInstant<N>>,
    background: BackgroundTask<Waves<N>>,
    stages: usize,
    /// Number of the coming instant in its block.
    instant: usize,
    /// True if there is a previous instant.
    begun: bool,
    instants: usize,
    /// Work of a block.
    work: Work,
}

/// State of a [`WavePast`].
#[derive(Deserialize, Serialize)]
struct WavePastState<N> {
    instant: usize,
    begun: bool,
    rings: Vec<RingState<N>>,
    /// The last forces that short rings see.
    seen: Option<(i64, Vec<f64>)>,
}

#[derive(Deserialize, Serialize)]
struct RingState<N> {
    latest: Vec<Complex<N>>,
    /// Displacements of a short ring at the coming instant, with their first element.
    field: Option<(i64, Vec<f64>)>,
    /// Sums, forces, foretold displacements of this block and of the next.
    fields: Vec<Vec<N>>,
    turned: bool,
    remembered: Vec<Vec<f32>>,
    earliest: usize,
    poles: Vec<Vec<N>>,
    slow_poles: Vec<Vec<f64>>,
}

/// Influence of the forces of each stage at the next instant, of a ring that is `part` times shorter than the tyre,
/// between cells of a window of `columns` columns.
pub fn first_influences(
    grid: &CellGrid,
    [part, columns]: [usize; 2],
    rows: &[CellRow],
    model: &PoleModel,
    rule: TimeRule,
    time_step: f64,
) -> Vec<CellInfluence> {
    let of_stages = first_responses(model, rule, time_step);
    of_stages.iter().map(|values| CellInfluence::of_waves(grid, columns, [(part, rows, values)])).collect()
}

impl<N: WaveNumber> WavePast<N> {
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
            if let Some(own) = next_instant {
                match &mut influences {
                    Some(all) => all.iter_mut().zip(&own).for_each(|(all, own)| *all += own),
                    None => influences = Some(own),
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
        let background = BackgroundTask::new(Waves::new(waves, rule), rayon::current_num_threads() > 1);
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

    /// Takes the forces of the instant \[N\]; returns whether there is room for all of them.
    pub fn push(&mut self, first_element: i64, forces: &[f64]) -> bool {
        for Ring { transform, forces: of_waves, .. } in self.rings.iter_mut().flatten() {
            transform.forward(first_element, forces, of_waves);
        }
        let has_room = self.next.as_mut().is_none_or(|next| next.last.take(first_element, forces));
        self.instant = (self.instant + 1) % self.instants;
        self.begun = true;
        has_room
    }

    fn restore_rings(&mut self, waves: &mut Waves<N>, state: &WavePastState<N>) -> Result<(), StateError> {
        if state.instant >= self.instants || state.rings.len() != self.rings.len() {
            return Err(StateError::Value);
        }
        (self.instant, self.begun) = (state.instant, state.begun);
        match (&mut self.next, &state.seen) {
            (None, None) => {}
            (Some(next), Some(seen)) => next.last.restore(seen)?,
            _ => return Err(StateError::Value),
        }
        for ((ring, (waves, short)), state) in self.rings.iter_mut().zip(&mut waves.rings).zip(&state.rings) {
            let known = state.earliest == 0 || state.earliest < waves.remembered.len();
            if !known || waves.remembered.len() != state.remembered.len() || waves.fields().len() != state.fields.len()
            {
                return Err(StateError::Value);
            }
            match (ring, short, &state.field) {
                (Some(ring), _, None) => fill(&mut ring.forces, &state.latest)?,
                (None, Some(short), Some(field)) => short.field.restore(field)?,
                _ => return Err(StateError::Value),
            }
            waves.fields_mut().into_iter().zip(&state.fields).try_for_each(|(own, kept)| fill(own, kept))?;
            waves.turned = state.turned;
            waves.remembered.iter_mut().zip(&state.remembered).try_for_each(|(own, kept)| fill(own, kept))?;
            waves.earliest = state.earliest;
            fill_all(waves.states_mut().collect::<Vec<_>>().into_iter(), &state.poles)?;
            fill_all(waves.precise_states_mut().collect::<Vec<_>>().into_iter(), &state.slow_poles)?;
        }
        Ok(())
    }
}

impl<N: WaveNumber> CellPast<1> for WavePast<N> {
    fn add_displacement(&mut self, _: usize, first_element: i64, out: &mut [[f64; 1]], meter: &mut Meter) {
        self.add_displacement(first_element, out.as_flattened_mut(), meter);
    }

    fn push(&mut self, _: usize, first_element: i64, forces: &[[f64; 1]]) -> bool {
        self.push(first_element, forces.as_flattened())
    }

    fn save(&self, state: &mut StateWriter) -> Result<(), StateError> {
        let waves = self.background.take();
        let kept = |seen: &Seen| (seen.first, seen.cells.clone());
        let rings = self.rings.iter().zip(&waves.rings).map(|(ring, (waves, short))| RingState {
            latest: ring.as_ref().map_or_else(Vec::new, |ring| ring.forces.clone()),
            field: short.as_ref().map(|short| kept(&short.field)),
            fields: waves.fields().map(Vec::clone).to_vec(),
            turned: waves.turned,
            remembered: waves.remembered.clone(),
            earliest: waves.earliest,
            poles: waves.states().map(<[N]>::to_vec).collect(),
            slow_poles: waves.precise_states().map(<[f64]>::to_vec).collect(),
        });
        let rings = rings.collect();
        self.background.give_back(waves);
        let seen = self.next.as_ref().map(|next| kept(&next.last));
        state.put(&WavePastState { instant: self.instant, begun: self.begun, rings, seen })
    }

    fn restore(&mut self, state: &mut StateReader<'_>) -> Result<(), StateError> {
        let state = state.take()?;
        let mut waves = self.background.take();
        let restored = self.restore_rings(&mut waves, &state);
        self.background.give_back(waves);
        restored
    }
}
