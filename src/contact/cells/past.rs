//! The past of cells carried by poles: one recursion for each pole of each wave, block by block, behind the march.
//!
//! Poles and states of all waves do not fit into a processor's nearest memory. They are gone through once in a *block*
//! of [`STEPS`] steps, a part of them at each instant, and another thread, if there is one, does so while the march
//! searches for the forces of that instant (module `waves`):
//! 1. forces of the block before are taken in, and the displacement at every instant of the next block is foretold as
//!    if no more forces came;
//! 2. what the block before and the earlier instants of its own add to the coming instant is summed for each wave, with
//!    the first weights of the same recursion.
//!
//! The march adds what the last instant's forces do, which is all that it has to wait for, and goes from waves to cells
//! and back. By linearity that is the recursion itself but for rounding, and nothing depends on who did what.

use num_complex::Complex;
use serde::{Deserialize, Serialize};

use super::wave_transform::{WaveNumber, WaveTransform};
use super::waves::{RingWaves, Waves};
use crate::contact::history::behind::Behind;
use crate::counters::{Meter, Stage, Work};
use crate::storage::state::{StateError, fill, fill_all};
use crate::time_rule::TimeRule;
use crate::tyre::poles::cells::CellModel;

/// Steps of a block.
pub const STEPS: usize = 4;

/// One ring: the waves that it carries.
pub struct RingParts<'m, N: WaveNumber = f64> {
    /// Their poles.
    pub model: &'m CellModel,
    /// From cells to waves and back.
    pub transform: WaveTransform<N>,
    /// Steps after which forces are forgotten, of which whole blocks count, one at least; `None`: never. On a ring
    /// shorter than the tyre the window comes back to where it was, and what creeps back slowly would still be there.
    pub forgotten_after: Option<usize>,
    /// Tolerance to which fewer poles may foretell what forces displace later than a block, relative to each wave's
    /// influence; `None`: none is left out.
    pub fewer_poles: Option<f64>,
}

/// A ring as the march sees it.
struct Ring<N: WaveNumber> {
    transform: WaveTransform<N>,
    /// Forces \[N\] of the last instant by wave.
    forces: Vec<Complex<N>>,
    /// Displacement \[m\] of the coming one.
    displacement: Vec<Complex<N>>,
}

/// Waves of all rings and their past, in single or double precision.
pub struct WavePast<N: WaveNumber = f64> {
    rings: Vec<Ring<N>>,
    behind: Behind<Waves<N>>,
    /// Number of the coming instant in its block.
    instant: usize,
    /// True if there is an instant before it.
    begun: bool,
    instants: usize,
    /// Work of a block.
    work: Work,
}

/// State of a [`WavePast`].
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct WavePastState<N> {
    instant: usize,
    begun: bool,
    rings: Vec<RingState<N>>,
}

/// State of a ring.
#[derive(Clone, Debug, Deserialize, Serialize)]
struct RingState<N> {
    latest: Vec<Complex<N>>,
    /// Sums, forces, foretold displacements of this block and of the next.
    fields: Vec<Vec<N>>,
    turned: bool,
    remembered: Vec<Vec<f32>>,
    earliest: usize,
    poles: Vec<Vec<N>>,
    slow_poles: Vec<Vec<f64>>,
}

impl<N: WaveNumber> WavePast<N> {
    /// At rest.
    pub fn new<'m>(parts: impl IntoIterator<Item = RingParts<'m, N>>, rule: TimeRule, time_step: f64) -> Self {
        Self::with_blocks(parts, rule, time_step, STEPS)
    }

    /// As [`Self::new`], in blocks of so many steps.
    pub fn with_blocks<'m>(
        parts: impl IntoIterator<Item = RingParts<'m, N>>,
        rule: TimeRule,
        time_step: f64,
        steps: usize,
    ) -> Self {
        let mut work = Work::default();
        let (mut rings, mut waves) = (Vec::new(), Vec::new());
        for RingParts { model, transform, forgotten_after, fewer_poles } in parts {
            let ring = RingWaves::new(model, rule, time_step, steps, forgotten_after, fewer_poles);
            work += ring.work();
            waves.push(ring);
            let zeros = || vec![Complex::new(N::default(), N::default()); model.len()];
            rings.push(Ring { transform, forces: zeros(), displacement: zeros() });
        }
        let behind = Behind::new(Waves::new(waves, rule), rayon::current_num_threads() > 1);
        Self { rings, behind, instant: 0, begun: false, instants: steps * rule.stages(), work }
    }

    /// Adds what the past displaces at the coming instant \[m\] on the window that begins with `first_element`; the
    /// forces of every instant are to be known before the next.
    pub fn add_displacement(&mut self, first_element: i64, out: &mut [f64], meter: &mut Meter) {
        let mut waves = self.behind.take();
        waves.report(meter);
        let last = self.begun.then(|| (self.instant + self.instants - 1) % self.instants);
        if self.instant == 0 {
            meter.add_work(Stage::History, self.work);
        }
        for (ring, waves) in self.rings.iter_mut().zip(&mut waves.rings) {
            if let Some(last) = last {
                waves.take_forces(last, &ring.forces);
            }
            if self.instant == 0 {
                waves.turn();
            }
            waves.finish(self.instant, &mut ring.displacement);
        }
        waves.begin(self.instant, meter.cpu_clock());
        self.behind.begin(waves);
        for ring in &mut self.rings {
            ring.transform.add_inverse(&ring.displacement, first_element, out);
        }
    }

    /// Takes the forces of the instant \[N\].
    pub fn push(&mut self, first_element: i64, forces: &[f64]) {
        for ring in &mut self.rings {
            ring.transform.forward(first_element, forces, &mut ring.forces);
        }
        self.instant = (self.instant + 1) % self.instants;
        self.begun = true;
    }

    /// Takes the state down; the same for any number of threads.
    pub fn save(&self) -> WavePastState<N> {
        let waves = self.behind.take();
        let state = |(ring, waves): (&Ring<N>, &RingWaves<N>)| RingState {
            latest: ring.forces.clone(),
            fields: waves.fields().map(Vec::clone).to_vec(),
            turned: waves.turned,
            remembered: waves.remembered.clone(),
            earliest: waves.earliest,
            poles: waves.states().map(<[N]>::to_vec).collect(),
            slow_poles: waves.precise_states().map(<[f64]>::to_vec).collect(),
        };
        let rings = self.rings.iter().zip(&waves.rings).map(state).collect();
        self.behind.give_back(waves);
        WavePastState { instant: self.instant, begun: self.begun, rings }
    }

    /// Goes on from the state of an equal past.
    ///
    /// # Errors
    /// [`StateError`].
    pub fn restore(&mut self, state: &WavePastState<N>) -> Result<(), StateError> {
        let mut waves = self.behind.take();
        let restored = self.restore_rings(&mut waves, state);
        self.behind.give_back(waves);
        restored
    }

    fn restore_rings(&mut self, waves: &mut Waves<N>, state: &WavePastState<N>) -> Result<(), StateError> {
        if state.instant >= self.instants || state.rings.len() != self.rings.len() {
            return Err(StateError::Value);
        }
        (self.instant, self.begun) = (state.instant, state.begun);
        for ((ring, waves), state) in self.rings.iter_mut().zip(&mut waves.rings).zip(&state.rings) {
            let known = state.earliest == 0 || state.earliest < waves.remembered.len();
            if !known || waves.remembered.len() != state.remembered.len() || waves.fields().len() != state.fields.len()
            {
                return Err(StateError::Value);
            }
            fill(&mut ring.forces, &state.latest)?;
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
