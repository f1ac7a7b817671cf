//! The past carried by poles: convolution quadrature as a recursion, block by block.
//!
//! For H_n(s) = sum_r R_r/(s - lambda_r) the quadrature sum_p w_p F_(l-p) is exactly the same rule stepping a' = lambda
//! a + F for every pole (MODEL: section 4; the rules stand in `time_rule::recursion`). States and coefficients
//! of all poles do not fit into a processor's nearest memory, and a recursion that goes through them once a step waits
//! for them. So they are gone through once in a *block* of [`INSTANTS`] instants, and while the tyre rolls through a
//! block another thread, if there is one, does so for the next:
//! 1. the forces of the block before, transformed to wavenumbers, are taken in one after the other;
//! 2. u_old of the block to come is foretold as if no forces came after them, and transformed back to the elements
//!    (`far`);
//! 3. what the block before and the earlier instants of its own add to an instant is a short convolution over the
//!    points in contact, with the first weights of the same recursion.
//!
//! By linearity this is the recursion itself: only rounding differs, and nothing depends on who did what. Elements are
//! material, so nothing moves but the elements that are looked at.
//!
//! Cost of a step of s stages: 4 (7 + 2 s) flops and 96 s/[`INSTANTS`] bytes for a pair of poles, 4 (1 + 2 s) flops and
//! 48 s/[`INSTANTS`] bytes for a real one (160 and 80 bytes with bdf2, which keeps two steps); in each block what it
//! takes to pass over one; for each instant two FFTs of length N, and points x columns x (3 [`INSTANTS`] - 1)/2
//! multiply-adds; independent of the memory.

use pulp::Arch;

use super::PastForces;
use super::behind::Behind;
use super::far::Far;
use super::state::{HistoryState, ModalState};
use super::transfer::first_weight;
use super::wavenumber_group::expected_multiply_adds;
use crate::contact::windows::add_windows;
use crate::counters::{Meter, Stage, Work};
use crate::numeric::{Ring, transform_multiply_adds};
use crate::storage::state::{StateError, fill_all};
use crate::time_rule::TimeRule;
use crate::tyre::influence::Field;
use crate::tyre::poles::RationalModel;

/// Instants of a block at most; a block is a whole number of steps. The march does the short convolution, which grows
/// with them, the other thread passes over the states, which happens less often with more of them. Measured in runs on
/// two threads: 2 and 4 differ little, 8 takes a tenth to a fifth longer at N = 512 and 1024.
pub const INSTANTS: usize = 4;

/// Bytes of a pole, conjugates counted: of the model, and for each stage of a step what goes with it.
const POLE_BYTES: [f64; 2] = [30.0, 110.0];

/// What a history is expected to take.
#[derive(Clone, Copy, Debug)]
pub struct ExpectedHistory {
    /// Multiply-adds of the recursion for each step.
    pub poles: f64,
    /// Multiply-adds of the short convolution for each step.
    pub near: f64,
    /// Multiply-adds of the transforms for each step.
    pub transforms: f64,
    /// Poles and their states \[bytes\].
    pub pole_bytes: f64,
    /// Forces, displacements and first influences of blocks \[bytes\].
    pub block_bytes: f64,
}

/// The recursion over all poles of a model.
pub struct ModalHistory {
    elements: usize,
    rule: TimeRule,
    /// Number of the coming instant in its block.
    instant: usize,
    far: Behind<Far>,
    /// u_old \[m\] on the ring at each instant of this block, of the forces up to the block before the last.
    old: Vec<Vec<f64>>,
    /// Forces at the instants of the block before and of this one.
    rows: Vec<Row>,
    /// First weights by stage of the force, lag and distance; see [`first_influences`].
    near: Vec<Vec<f64>>,
    arch: Arch,
}

/// Forces at an instant.
#[derive(Clone, Debug)]
struct Row {
    /// Element that [`Self::forces`] begin with, on the ring.
    first: usize,
    /// Forces \[N\] of the points in contact, as distances from [`Self::first`].
    forces: Vec<(usize, f64)>,
}

impl ModalHistory {
    /// Everything at rest, in blocks of [`INSTANTS`]; `None` if the model does not hold the field.
    pub fn new(model: &RationalModel, field: Field, rule: TimeRule, time_step: f64) -> Option<Self> {
        Self::with_blocks(model, field, rule, time_step, INSTANTS)
    }

    /// As [`Self::new`], in blocks of as many whole steps as `instants` hold, one at least: with one step the plain
    /// recursion, to measure against.
    pub fn with_blocks(
        model: &RationalModel,
        field: Field,
        rule: TimeRule,
        time_step: f64,
        instants: usize,
    ) -> Option<Self> {
        let elements = model.elements;
        let stages = rule.stages();
        let instants = (instants / stages).max(1) * stages;
        // A clone would not keep the room for the forces.
        let rows = (0..2 * instants).map(|_| Row { first: 0, forces: Vec::with_capacity(elements) }).collect();
        Some(Self {
            elements,
            rule,
            instant: 0,
            far: Behind::new(Far::new(model, field, rule, time_step, instants)?, rayon::current_num_threads() > 1),
            old: vec![vec![0.0; elements]; instants],
            rows,
            near: first_influences(model, field, rule, time_step, 2 * instants - 1)?,
            arch: Arch::new(),
        })
    }

    /// First weights w_(n,0) of the quadrature, n = 0..=N/2: the model at delta(0)/dt \[m/N\].
    pub fn first_weights(model: &RationalModel, field: Field, rule: TimeRule, time_step: f64) -> Option<Vec<f64>> {
        (0..=model.largest_wavenumber())
            .map(|n| model.modes(n, field).map(|modes| first_weight(&modes, rule, time_step)))
            .collect()
    }

    /// What a model of so many poles, conjugates counted, is expected to take under a rule. `pairs`: points in contact
    /// times columns of the window.
    pub fn expected(rule: TimeRule, elements: usize, poles: f64, pairs: f64) -> ExpectedHistory {
        let (stages, instants) = (rule.nodes().len() as f64, INSTANTS as f64);
        let steps_of_block = (INSTANTS / rule.nodes().len()).max(1);
        ExpectedHistory {
            poles: expected_multiply_adds(rule, steps_of_block, elements / 2 + 1, poles),
            near: 0.5 * stages * (3.0 * instants - 1.0) * pairs,
            transforms: stages * transform_multiply_adds(elements),
            pole_bytes: poles * (POLE_BYTES[0] + POLE_BYTES[1] * stages),
            // Two rings, a spectrum and two blocks' forces; the first influences of so many lags, the ring twice over.
            block_bytes: elements as f64 * (56.0 * instants + 16.0 * stages * (2.0 * instants - 1.0)),
        }
    }

    /// A block begins: u_old of it is fetched, the last block's forces are sent out for that of the next.
    fn turn(&mut self, meter: &mut Meter) {
        self.rows.rotate_left(self.old.len());
        let mut far = self.far.take();
        far.report(meter);
        far.cpu = meter.cpu_clock();
        let block = far.rings.iter_mut().zip(&mut self.old).zip(&self.rows);
        for ((ring, old), row) in block {
            std::mem::swap(ring, old);
            ring.fill(0.0);
            for &(distance, force) in &row.forces {
                ring[(row.first + distance) % self.elements] = force;
            }
        }
        self.far.begin(far);
    }

    /// Adds what the forces of the block before and of earlier instants of this one displace.
    fn add_near(&self, first: usize, out: &mut [f64]) -> Work {
        let (stages, lags) = (self.rule.stages(), 2 * self.old.len() - 1);
        let mut points = 0;
        let now = self.old.len() + self.instant;
        for (earlier, row) in self.rows[..now].iter().enumerate() {
            let influence = &self.near[(earlier % stages) * lags + now - earlier - 1];
            // No remainder here: it would take longer than the sums.
            let shift = (first + self.elements - row.first) % self.elements;
            let window = |&(distance, force): &(usize, f64)| {
                let from = if distance > shift { shift + self.elements } else { shift } - distance;
                (from, force)
            };
            add_windows(self.arch, out, influence, row.forces.iter().map(window));
            points += row.forces.len();
        }
        let multiply_adds = (points * out.len()) as u64;
        Work { multiply_adds, bytes: 8 * multiply_adds }
    }
}

/// Influence of a force at a stage, 1, 2, ... instants later, on the element j further on, \[m/N\]: row (stage x lags +
/// lag - 1), j = 0..2N - 1, so that a window may begin at any element of the ring.
fn first_influences(
    model: &RationalModel,
    field: Field,
    rule: TimeRule,
    time_step: f64,
    lags: usize,
) -> Option<Vec<Vec<f64>>> {
    let stages = rule.stages();
    let mut weights = vec![0.0; (model.largest_wavenumber() + 1) * stages * lags];
    for (n, weights) in weights.chunks_mut(stages * lags).enumerate() {
        let modes = model.modes(n, field)?;
        for (index, (&pole, &residue)) in modes.poles.iter().zip(modes.residues).enumerate() {
            let (g, w) = rule.coefficients(pole, modes.multiplicity(index) * residue, time_step);
            for (stage, response) in weights.chunks_mut(lags).enumerate() {
                rule.impulse_response([g, w], stage, response);
            }
        }
    }
    let mut ring = Ring::new(model.elements);
    let rows = 0..stages * lags;
    Some(rows.map(|row| ring.elements_of(|n| weights[n * stages * lags + row]).repeat(2)).collect())
}

impl PastForces for ModalHistory {
    fn displacement(&mut self, first_element: i64, out: &mut [f64], meter: &mut Meter) {
        if self.instant == 0 {
            self.turn(meter);
        }
        let first = first_element.rem_euclid(self.elements as i64) as usize;
        let (behind, ahead) = self.old[self.instant].split_at(first);
        for (value, old) in out.iter_mut().zip(ahead.iter().chain(behind)) {
            *value = *old;
        }
        meter.add_work(Stage::History, self.add_near(first, out));
    }

    fn push(&mut self, first_element: i64, forces: &[f64]) {
        let row = &mut self.rows[self.old.len() + self.instant];
        row.first = first_element.rem_euclid(self.elements as i64) as usize;
        row.forces.clear();
        row.forces.extend(forces.iter().copied().enumerate().filter(|(_, force)| *force != 0.0));
        self.instant = (self.instant + 1) % self.old.len();
    }

    fn save(&self) -> HistoryState {
        let far = self.far.take();
        let state = ModalState {
            instant: self.instant,
            rows: self.rows.iter().map(|row| (row.first, row.forces.clone())).collect(),
            old: self.old.clone(),
            rings: far.rings.clone(),
            poles: far.states().map(<[f64]>::to_vec).collect(),
        };
        self.far.give_back(far);
        HistoryState::Modal(state)
    }

    fn restore(&mut self, state: HistoryState) -> Result<(), StateError> {
        let HistoryState::Modal(ModalState { instant, rows, old, rings, poles }) = state else {
            return Err(StateError::Value);
        };
        let on_ring = |(first, forces): &(usize, Vec<(usize, f64)>)| {
            *first < self.elements && forces.iter().all(|&(distance, _)| distance < self.elements)
        };
        if instant >= self.old.len() || rows.len() != self.rows.len() || !rows.iter().all(on_ring) {
            return Err(StateError::Value);
        }
        self.instant = instant;
        for (row, (first, forces)) in self.rows.iter_mut().zip(rows) {
            row.first = first;
            // In place: the room that a row has is enough for any step.
            row.forces.clear();
            row.forces.extend(forces);
        }
        fill_all(self.old.iter_mut().map(Vec::as_mut_slice), &old)?;
        let mut far = self.far.take();
        let mut filled = fill_all(far.rings.iter_mut().map(Vec::as_mut_slice), &rings);
        filled = filled.and_then(|()| fill_all(far.states_mut().collect::<Vec<_>>().into_iter(), &poles));
        self.far.give_back(far);
        filled
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{PLATE, Scene};
    use crate::storage::state::read_back;
    use crate::tyre::poles::{FitOptions, fit};

    const COLUMNS: usize = 11;

    fn model() -> RationalModel {
        let tyre = Scene::from_str(PLATE, "default").unwrap().scene.tyre;
        fit(&tyre, &FitOptions::new(&tyre, 24, 20.0).with_tolerance(1e-3)).unwrap()
    }

    /// Forces of some points, none at times, that depend on what came before.
    fn roll(history: &mut ModalHistory, from: i64, to: i64) -> Vec<f64> {
        let stages = history.rule.stages() as i64;
        let mut all = Vec::new();
        for instant in from..to {
            let first = instant / stages / 2;
            let mut old = [0.0; COLUMNS];
            history.displacement(first, &mut old, &mut Meter::default());
            let forces: Vec<f64> = (0..COLUMNS as i64)
                .zip(&old)
                .map(|(column, old)| {
                    let drive = ((7 * instant + 3 * (first + column) * (first + column)) as f64).sin();
                    if drive > 0.0 { drive + 1e3 * old } else { 0.0 }
                })
                .collect();
            history.push(first, &forces);
            all.extend(old);
        }
        all
    }

    #[test]
    fn blocks_are_the_plain_recursion() {
        let model = model();
        for rule in TimeRule::ALL {
            let history = |instants| ModalHistory::with_blocks(&model, Field::Surface, rule, 1e-4, instants).unwrap();
            let plain = roll(&mut history(1), 0, 150);
            let largest = plain.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
            for instants in [2, 7, INSTANTS, 40] {
                let blocks = roll(&mut history(instants), 0, 150);
                let error = plain.iter().zip(&blocks).fold(0.0_f64, |a, (b, c)| a.max((b - c).abs())) / largest;
                assert!(error < 1e-13, "{rule:?}, {instants} instants: {error:e}");
            }
        }
    }

    #[test]
    fn a_history_goes_on_from_any_instant_of_a_block_bit_for_bit() {
        let model = model();
        for rule in TimeRule::ALL {
            let history = || ModalHistory::new(&model, Field::Surface, rule, 1e-4).unwrap();
            for stop in 29..50 {
                let mut whole = history();
                roll(&mut whole, 0, stop);
                let mut restored = history();
                restored.restore(read_back(&whole.save())).unwrap();
                assert_eq!(roll(&mut whole, stop, 90), roll(&mut restored, stop, 90), "{rule:?}, {stop}");
            }
        }
    }
}
