//! The history carried by poles: convolution quadrature as a recursion, block by block.
//!
//! For H_n(s) = sum_r R_r/(s - lambda_r) the quadrature sum_p w_p F_(l-p) is exactly the same rule stepping a' = lambda
//! a + F for every pole (docs/theory.md 5; the rules stand in `time_rule::recursion`). States and coefficients
//! of all poles do not fit into a processor's nearest memory, and a recursion that goes through them once a step waits
//! for them. So they are gone through once in a *block* of [`INSTANTS`] instants, and while the tyre rolls through a
//! block another thread, if there is one, does so for the next:
//! 1. the forces of the previous block, transformed to wavenumbers, are taken in one after the other;
//! 2. u_old of the block to come is predicted as if no forces came after them, and transformed back to the elements
//!    (`far`);
//! 3. the contribution of the previous block and of the earlier instants of the current one to an instant is a short
//!    convolution (`near`), with the first weights of the same recursion.
//!
//! A tyre that turns has odd parts beside the even ones (`time_rule::recursion`), and influence that differs forwards
//! and backwards.
//!
//! By linearity this is the recursion itself: only rounding differs, and nothing depends on which thread did what.
//! Elements are material, so only the part of them that the window covers changes.
//!
//! Cost of a step of s stages: 4 (7 + 2 s) flops and 96 s/[`INSTANTS`] bytes for a pair of poles, 4 (1 + 2 s) flops
//! and 48 s/[`INSTANTS`] bytes for a real one (160 and 80 bytes with bdf2, which keeps two steps), 8 s and 4 s flops
//! more where the tyre turns; in each block the passing over one; for each instant two FFTs of length N, and the cost
//! of `near`; independent of the memory.

use super::ForceHistory;
use super::far::{Far, SinglePrecision};
use super::near::{self, NearForces};
use super::transfer::{add_responses, first_weight, odd_first_weight};
use super::wavenumber_group::expected_multiply_adds;
use crate::counters::{Meter, Stage};
use crate::numeric::background::Background;
use crate::numeric::{Ring, transform_multiply_adds};
use crate::storage::state::{Evolving, StateError, StateStream, ensure};
use crate::time_rule::TimeRule;
use crate::tyre::influence::Field;
use crate::tyre::poles::RationalModel;

/// Instants of a block at most; a block is a whole number of steps. The other thread passes over the states, which
/// happens less often with more of them; the march and the transforms hardly depend on them. Measured in runs on two
/// threads: 8 is a twentieth faster than 4, 16 is not faster.
pub const INSTANTS: usize = 8;

/// Bytes of a pole, conjugates counted: of the model, and for each stage of a step the rest.
const POLE_BYTES: [f64; 2] = [30.0, 110.0];
/// Bytes of a pole's odd parts, conjugates counted: residues of two faces, and q.
const ODD_POLE_BYTES: f64 = 24.0;

/// Expected work and memory of a history.
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
    /// Number of the coming instant in its block.
    instant: usize,
    far: Background<Far>,
    /// u_old \[m\] on the ring at each instant of this block, of the forces up to the block before the last.
    old: Vec<Vec<f64>>,
    /// Elements in contact and their forces \[N\] at the instants of the previous block and of this one.
    rows: Vec<Vec<(i64, f64)>>,
    near: NearForces,
}

impl ModalHistory {
    /// Recursion at rest, in double precision and in blocks of [`INSTANTS`], for windows of at most `columns` columns
    /// that move on by at most an element a step; `None` if the model does not hold the field.
    pub fn new(model: &RationalModel, field: Field, rule: TimeRule, time_step: f64, columns: usize) -> Option<Self> {
        Self::with_blocks(model, field, rule, time_step, [columns, 1], INSTANTS, None)
    }

    /// Recursion as that of [`Self::new`], in blocks of as many whole steps as `instants` hold, one at least: with one
    /// step it is the plain recursion, to compare with. Windows have at most so many columns and move on by at most so
    /// many elements a step; of forces older than a block the poles may be in `single` precision.
    pub fn with_blocks(
        model: &RationalModel,
        field: Field,
        rule: TimeRule,
        time_step: f64,
        [columns, elements_per_step]: [usize; 2],
        instants: usize,
        single: Option<SinglePrecision>,
    ) -> Option<Self> {
        let elements = model.elements;
        let stages = rule.stages();
        let instants = (instants / stages).max(1) * stages;
        // A clone would not keep the capacity for the forces.
        let rows = (0..2 * instants).map(|_| Vec::with_capacity(elements)).collect();
        let lags = 2 * instants - 1;
        let influence = first_influences(model, field, rule, time_step, lags)?;
        let way = 2 * instants / stages * elements_per_step;
        Some(Self {
            elements,
            instant: 0,
            far: Background::on_a_thread(Far::new(model, field, rule, time_step, instants, single)?),
            old: vec![vec![0.0; elements]; instants],
            rows,
            near: NearForces::new(&influence, lags, 2 * instants, columns, way, model.turns()),
        })
    }

    /// First weights w_(n,0) of the quadrature, n = 0..=N/2: the model at delta(0)/dt \[m/N\]; of a tyre that turns
    /// those of the even parts.
    pub fn first_weights(model: &RationalModel, field: Field, rule: TimeRule, time_step: f64) -> Option<Vec<f64>> {
        (0..=model.largest_wavenumber())
            .map(|n| model.modes(n, field).map(|modes| first_weight(&modes, rule, time_step)))
            .collect()
    }

    /// First weights of the odd parts, likewise \[m/N\]; empty at rest.
    pub fn odd_first_weights(model: &RationalModel, field: Field, rule: TimeRule, time_step: f64) -> Option<Vec<f64>> {
        let wavenumbers = if model.turns() { 0..model.largest_wavenumber() + 1 } else { 0..0 };
        wavenumbers.map(|n| model.modes(n, field).map(|modes| odd_first_weight(&modes, rule, time_step))).collect()
    }

    /// Forecasts work and memory for a model of `poles` poles, conjugates counted, under a rule, with a window of so
    /// many columns that moves on by so many elements a step; of a tyre that `turns`, or at rest.
    pub fn expected(
        rule: TimeRule,
        elements: usize,
        poles: f64,
        [columns, elements_per_step]: [usize; 2],
        turns: bool,
    ) -> ExpectedHistory {
        let (stages, instants) = (rule.nodes().len() as f64, INSTANTS as f64);
        let steps_of_block = (INSTANTS / rule.nodes().len()).max(1);
        // An instant sums those of the previous block and, on average, half of the present one.
        let seen = 0.5 * (3.0 * instants - 1.0);
        let (near, spectrum) = near::expected(elements, columns, 2 * steps_of_block * elements_per_step, seen, turns);
        let (odd_bytes, influences) = if turns { (ODD_POLE_BYTES, 2.0) } else { (0.0, 1.0) };
        ExpectedHistory {
            poles: expected_multiply_adds(rule, steps_of_block, elements / 2 + 1, poles, turns),
            near: stages * near,
            transforms: stages * transform_multiply_adds(elements),
            pole_bytes: poles * (POLE_BYTES[0] + odd_bytes + POLE_BYTES[1] * stages),
            // Two rings, a spectrum and two blocks' forces; spectra of those and of the first influences.
            block_bytes: elements as f64 * 56.0 * instants
                + 8.0 * spectrum * (influences * stages * (2.0 * instants - 1.0) + 4.0 * instants),
        }
    }

    /// Begins a block: takes over its u_old, and hands out the last block's forces for u_old of the next.
    fn turn(&mut self, meter: &mut Meter) {
        self.rows.rotate_left(self.old.len());
        self.near.turn();
        let mut far = self.far.take();
        far.report(meter);
        far.cpu = meter.cpu_clock();
        let block = far.rings.iter_mut().zip(&mut self.old).zip(&self.rows);
        for ((ring, old), row) in block {
            std::mem::swap(ring, old);
            ring.fill(0.0);
            for &(element, force) in row {
                ring[element.rem_euclid(self.elements as i64) as usize] = force;
            }
        }
        self.far.begin(far);
    }
}

/// Influence of a force at a stage, 1, 2, ... instants later, on the element j further on \[m/N\]: row (stage x lags +
/// lag - 1), j = 0..N.
fn first_influences(
    model: &RationalModel,
    field: Field,
    rule: TimeRule,
    time_step: f64,
    lags: usize,
) -> Option<Vec<Vec<f64>>> {
    let stages = rule.stages();
    let wavenumbers = model.largest_wavenumber() + 1;
    let mut weights = vec![0.0; wavenumbers * stages * lags];
    let mut odd_weights = vec![0.0; if model.turns() { weights.len() } else { 0 }];
    for n in 0..wavenumbers {
        let modes = model.modes(n, field)?;
        let start = n * stages * lags;
        add_responses(&modes, modes.residues, rule, time_step, lags, &mut weights[start..start + stages * lags]);
        if let Some(odd_weights) = odd_weights.get_mut(start..start + stages * lags) {
            add_responses(&modes, modes.odd, rule, time_step, lags, odd_weights);
        }
    }
    let mut ring = Ring::new(model.elements);
    let rows = (0..stages * lags).map(|row| {
        let mut influence = ring.elements_of(|n| weights[n * stages * lags + row]).to_vec();
        if !odd_weights.is_empty() {
            let odd = ring.odd_elements_of(|n| odd_weights[n * stages * lags + row]);
            influence.iter_mut().zip(odd).for_each(|(even, odd)| *even += odd);
        }
        influence
    });
    Some(rows.collect())
}

impl ForceHistory for ModalHistory {
    fn displacement(&mut self, first_element: i64, out: &mut [f64], meter: &mut Meter) {
        if self.instant == 0 {
            self.turn(meter);
        }
        let first = first_element.rem_euclid(self.elements as i64) as usize;
        let (behind, ahead) = self.old[self.instant].split_at(first);
        for (value, old) in out.iter_mut().zip(ahead.iter().chain(behind)) {
            *value = *old;
        }
        let now = self.old.len() + self.instant;
        self.near.add_displacement(now, first_element, out);
        meter.add_work(Stage::History, self.near.work(now));
    }

    fn push(&mut self, first_element: i64, forces: &[f64]) {
        let now = self.old.len() + self.instant;
        let row = &mut self.rows[now];
        row.clear();
        row.extend((first_element..).zip(forces.iter().copied()).filter(|(_, force)| *force != 0.0));
        self.near.take(now, row.iter().copied());
        self.instant = (self.instant + 1) % self.old.len();
    }
}

impl Evolving for ModalHistory {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        let Self { elements, instant, far, old, rows, near } = self;
        state.all([instant, old])?;
        ensure(*instant < old.len())?;
        for (number, row) in rows.iter_mut().enumerate() {
            state.growing(row)?;
            ensure(row.len() <= *elements)?;
            if state.is_restoring() {
                near.take(number, row.iter().copied());
            }
        }
        far.with(|far| far.state(state))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{PLATE, Scene};
    use crate::storage::state::SavedState;
    use crate::tyre::poles::{FitOptions, fit, turning_ring};

    const COLUMNS: usize = 11;

    fn model() -> RationalModel {
        let tyre = Scene::from_str(PLATE, "default").unwrap().scene.tyre;
        fit(&tyre, &FitOptions::new(&tyre, 48, 20.0).with_tolerance(1e-3)).unwrap()
    }

    /// Rolls with forces of some points, none at times, that depend on the displacement; returns every u_old.
    fn roll(history: &mut ModalHistory, rule: TimeRule, from: i64, to: i64) -> Vec<f64> {
        let stages = rule.stages() as i64;
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

    /// A model at rest, and one of a ring that turns.
    fn models() -> [RationalModel; 2] {
        [model(), turning_ring::model(48, -200.0)]
    }

    #[test]
    fn blocks_are_the_plain_recursion() {
        for (model, rule) in models().iter().flat_map(|model| TimeRule::ALL.map(|rule| (model, rule))) {
            let history = |instants| {
                ModalHistory::with_blocks(model, Field::Surface, rule, 1e-4, [COLUMNS, 1], instants, None).unwrap()
            };
            let plain = roll(&mut history(1), rule, 0, 150);
            let largest = plain.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
            for instants in [2, 7, INSTANTS, 40] {
                let blocks = roll(&mut history(instants), rule, 0, 150);
                let error = plain.iter().zip(&blocks).fold(0.0_f64, |a, (b, c)| a.max((b - c).abs())) / largest;
                assert!(error < 1e-13, "{rule:?}, turns: {}, {instants} instants: {error:e}", model.turns());
            }
        }
    }

    /// Recursion in single precision, for poles to within 1e-3.
    fn single(model: &RationalModel, rule: TimeRule) -> ModalHistory {
        let single = Some(SinglePrecision { tolerance: 1e-3, advance: 2.into() });
        ModalHistory::with_blocks(model, Field::Surface, rule, 1e-4, [COLUMNS, 1], INSTANTS, single).unwrap()
    }

    #[test]
    fn single_precision_changes_displacements_by_less_than_its_tolerance() {
        for (model, rule) in models().iter().flat_map(|model| TimeRule::ALL.map(|rule| (model, rule))) {
            let mut double = ModalHistory::new(model, Field::Surface, rule, 1e-4, COLUMNS).unwrap();
            let [double, single] = [&mut double, &mut single(model, rule)].map(|history| roll(history, rule, 0, 600));
            let largest = double.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
            let error = double.iter().zip(&single).fold(0.0_f64, |a, (b, c)| a.max((b - c).abs())) / largest;
            println!("{rule:?}, turns: {}: {error:.1e}", model.turns());
            assert!(error > 0.0 && error < 1e-4, "{rule:?}, turns: {}: {error:e}", model.turns());
        }
    }

    #[test]
    fn a_history_goes_on_from_any_instant_of_a_block_bit_for_bit() {
        for (model, rule) in models().iter().flat_map(|model| TimeRule::ALL.map(|rule| (model, rule))) {
            let double = |model: &_, rule| ModalHistory::new(model, Field::Surface, rule, 1e-4, COLUMNS).unwrap();
            for (history, stop) in (29..50).flat_map(|stop| [(double as fn(&_, _) -> _, stop), (single, stop)]) {
                let mut whole = history(model, rule);
                roll(&mut whole, rule, 0, stop);
                let mut restored = history(model, rule);
                SavedState::of(&mut whole).unwrap().restore(&mut restored).unwrap();
                assert_eq!(roll(&mut whole, rule, stop, 90), roll(&mut restored, rule, stop, 90), "{rule:?}, {stop}");
            }
        }
    }
}
