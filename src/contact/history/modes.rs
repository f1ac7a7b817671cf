//! The past carried by poles: convolution quadrature as a recursion, block by block.
//!
//! For H_n(s) = sum_r R_r/(s - lambda_r) the quadrature sum_p w_p F_(l-p) is exactly the same rule stepping a' = lambda
//! a + F for every pole (MODEL: section 4; the rules stand in [`super::recursion`]). States and coefficients of all
//! poles do not fit into a processor's nearest memory, and a recursion that goes through them once a step waits for
//! them. So they are gone through once in a *block* of [`INSTANTS`] instants:
//! 1. the block's forces, transformed to wavenumbers, are taken in one after the other;
//! 2. u_old of the whole next block is foretold as if no more forces came, and transformed back to the elements;
//! 3. within that block, what its own earlier instants add is a short convolution over the points in contact, with the
//!    first weights of the same recursion.
//!
//! By linearity this is the recursion itself: only rounding differs. Elements are material, so nothing moves but the
//! elements that are looked at.
//!
//! Cost of a step of s stages: 4 (7 + 2 s) flops and 96 s/[`INSTANTS`] bytes for a pair of poles, 4 (1 + 2 s) flops and
//! 48 s/[`INSTANTS`] bytes for a real one (160 and 80 bytes with bdf2, which keeps two steps), and for each instant two
//! FFTs of length N, and points x columns x ([`INSTANTS`] - 1)/2 multiply-adds; independent of the memory. Wavenumbers
//! are independent and so are instants in the transforms: any split over threads gives the same bits.

use std::sync::Arc;

use num_complex::Complex64;
use pulp::Arch;
use rayon::prelude::*;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};

use super::recursion::{Recursion, WithRecursion, coefficients, impulse_response, with_recursion};
use super::transfer::first_weight;
use super::wavenumber_group::{GROUP, Pass, WavenumberGroup};
use super::{HistoryWork, PastForces};
use crate::meter::{Clocks, Laps, Work};
use crate::numeric::windows::add_windows;
use crate::numeric::{Ring, StateError, StateReader, StateWriter, transform_multiply_adds};
use crate::scene::TimeRule;
use crate::tyre::influence::Field;
use crate::tyre::rational::RationalModel;

/// Instants of a block at most; a block is a whole number of steps. Measured at N = 1024 (bench `contact`, and runs): 4
/// to 12 differ little, 1 takes three times as long, and from 16 on the short convolution within the block costs more
/// than the poles save.
pub const INSTANTS: usize = 8;

/// Multiply-adds of a pass from which it is worth handing work to a second thread, a hand-over costing some 15 us.
/// Measured with 1.6 million: 17 us an instant on two threads against 22 on one. N = 1024 has 1.0 million with
/// `sdirk2`, N = 512 0.6 million, which is too little.
pub const PARALLEL_FROM: u64 = 800_000;

/// The recursion over all poles of a model.
pub struct ModalHistory {
    elements: usize,
    rule: TimeRule,
    /// Number of the coming instant in its block.
    instant: usize,
    groups: Vec<WavenumberGroup>,
    forward: Arc<dyn RealToComplex<f64>>,
    inverse: Arc<dyn ComplexToReal<f64>>,
    rows: Vec<Row>,
    /// First weights by stage of the force, lag and distance; see [`Self::first_influences`].
    near: Vec<Vec<f64>>,
    parallel: bool,
    clocks: Clocks,
    arch: Arch,
}

/// An instant of a block.
#[derive(Clone, Debug)]
struct Row {
    /// Element that [`Self::forces`] begin with, on the ring.
    first: usize,
    /// Forces \[N\] of the points in contact, as distances from [`Self::first`].
    forces: Vec<(usize, f64)>,
    /// Forces by wavenumber, then displacements by wavenumber.
    spectrum: Vec<Complex64>,
    /// Forces on the ring, then u_old of the coming block's instant without that block's own forces \[m\].
    ring: Vec<f64>,
    scratch: Vec<Complex64>,
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
        let stages = rule.nodes().len();
        let instants = (instants / stages).max(1) * stages;
        let groups: Option<Vec<_>> = (0..=elements / 2)
            .step_by(GROUP)
            .map(|first| WavenumberGroup::new(model, field, rule, time_step, first, instants))
            .collect();
        let groups = groups?;
        let mut planner = RealFftPlanner::<f64>::new();
        let (forward, inverse) = (planner.plan_fft_forward(elements), planner.plan_fft_inverse(elements));
        let row = Row {
            first: 0,
            forces: Vec::with_capacity(elements),
            spectrum: forward.make_output_vec(),
            ring: forward.make_input_vec(),
            scratch: vec![Complex64::ZERO; forward.get_scratch_len().max(inverse.get_scratch_len())],
        };
        // A clone would not keep the room for the forces.
        let rows = (0..instants).map(|_| Row { forces: Vec::with_capacity(elements), ..row.clone() }).collect();
        Some(Self {
            elements,
            rule,
            instant: 0,
            parallel: groups.iter().map(|group| group.work().multiply_adds).sum::<u64>() >= PARALLEL_FROM,
            near: first_influences(model, field, rule, time_step, instants)?,
            groups,
            forward,
            inverse,
            rows,
            clocks: Clocks::OFF,
            arch: Arch::new(),
        })
    }

    /// First weights w_(n,0) of the quadrature, n = 0..=N/2: the model at delta(0)/dt \[m/N\].
    pub fn first_weights(model: &RationalModel, field: Field, rule: TimeRule, time_step: f64) -> Option<Vec<f64>> {
        (0..=model.largest_wavenumber())
            .map(|n| model.modes(n, field).map(|modes| first_weight(&modes, rule, time_step)))
            .collect()
    }

    /// Adds what the forces of earlier instants of the block displace.
    fn add_near(&self, first: usize, out: &mut [f64]) -> Work {
        let (stages, lags) = (self.rule.nodes().len(), self.rows.len() - 1);
        let mut points = 0;
        for (earlier, row) in self.rows[..self.instant].iter().enumerate() {
            let influence = &self.near[(earlier % stages) * lags + self.instant - earlier - 1];
            let shift = first + self.elements - row.first;
            let window =
                |&(distance, force): &(usize, f64)| ((shift + self.elements - distance) % self.elements, force);
            add_windows(self.arch, out, influence, row.forces.iter().map(window));
            points += row.forces.len();
        }
        let multiply_adds = (points * out.len()) as u64;
        Work { multiply_adds, bytes: 8 * multiply_adds }
    }
}

/// Takes in a block's forces and foretells the next block.
struct NextBlock<'a> {
    history: &'a mut ModalHistory,
    work: &'a mut HistoryWork,
}

impl WithRecursion for NextBlock<'_> {
    type Output = ();

    fn with<R: Recursion>(self, recursion: R) {
        let ModalHistory { elements, groups, rows, forward, inverse, arch, parallel, clocks, .. } = self.history;
        // Planned lengths; the forces are real and so is the displacement: nothing to refuse.
        let transform = |row: &mut Row| {
            row.ring.fill(0.0);
            for &(distance, force) in &row.forces {
                row.ring[(row.first + distance) % *elements] = force;
            }
            row.forces.clear();
            let _ = forward.process_with_scratch(&mut row.ring, &mut row.spectrum, &mut row.scratch);
        };
        let advance = |group: &mut WavenumberGroup, rows: &[Row]| {
            for (instant, row) in rows.iter().enumerate() {
                group.take_forces(instant, &row.spectrum);
            }
            arch.dispatch(Pass { group, recursion });
        };
        // One piece of work stays on this thread.
        let least = if *parallel { 1 } else { usize::MAX };
        let mut laps = Laps::begin(*clocks);
        rows.par_iter_mut().with_min_len(least).for_each(transform);
        let mut transform_time = laps.lap();
        groups.par_iter_mut().with_min_len(least).for_each(|group| advance(group, rows));
        laps.lap();
        let transform_back = |(instant, row): (usize, &mut Row)| {
            for group in groups.iter() {
                group.give_displacement(instant, &mut row.spectrum);
            }
            let last = row.spectrum.len() - 1;
            (row.spectrum[0].im, row.spectrum[last].im) = (0.0, 0.0);
            let _ = inverse.process_with_scratch(&mut row.spectrum, &mut row.ring, &mut row.scratch);
        };
        rows.par_iter_mut().with_min_len(least).enumerate().for_each(transform_back);
        transform_time += laps.lap();
        let (instants, length) = (rows.len(), *elements as u64);
        groups.iter().for_each(|group| self.work.sums += group.work());
        *self.work = HistoryWork {
            sums: self.work.sums,
            // Two real transforms for each instant: as much as a complex one. Their input, output and scratch.
            transforms: Work {
                multiply_adds: (instants as f64 * transform_multiply_adds(*elements)) as u64,
                bytes: 2 * instants as u64 * 3 * 8 * length,
            },
            passes: 1,
            transform_time,
        };
    }
}

/// Influence of a force at a stage, 1, 2, ... instants later, on the element j further on, \[m/N\]: row (stage x lags +
/// lag - 1), j = 0..2N - 1, so that a window may begin at any element of the ring.
fn first_influences(
    model: &RationalModel,
    field: Field,
    rule: TimeRule,
    time_step: f64,
    instants: usize,
) -> Option<Vec<Vec<f64>>> {
    let (stages, lags) = (rule.nodes().len(), instants - 1);
    let mut weights = vec![0.0; (model.largest_wavenumber() + 1) * stages * lags];
    for (n, weights) in weights.chunks_mut((stages * lags).max(1)).enumerate() {
        let modes = model.modes(n, field)?;
        for (index, (&pole, &residue)) in modes.poles.iter().zip(modes.residues).enumerate() {
            let (g, w) = coefficients(rule, pole, modes.multiplicity(index) * residue, time_step);
            for (stage, response) in weights.chunks_mut(lags.max(1)).enumerate() {
                impulse_response(rule, [g, w], stage, response);
            }
        }
    }
    let mut ring = Ring::new(model.elements);
    let rows = 0..stages * lags;
    Some(rows.map(|row| ring.elements_of(|n| weights[n * stages * lags + row]).repeat(2)).collect())
}

impl PastForces for ModalHistory {
    fn displacement(&mut self, first_element: i64, out: &mut [f64]) -> HistoryWork {
        let mut work = HistoryWork::default();
        if self.instant == 0 {
            with_recursion(self.rule, NextBlock { history: self, work: &mut work });
        }
        let first = first_element.rem_euclid(self.elements as i64) as usize;
        let ring = &self.rows[self.instant].ring;
        let (behind, ahead) = ring.split_at(first);
        for (value, old) in out.iter_mut().zip(ahead.iter().chain(behind)) {
            *value = *old;
        }
        work.sums += self.add_near(first, out);
        work
    }

    fn push(&mut self, first_element: i64, forces: &[f64]) {
        let row = &mut self.rows[self.instant];
        row.first = first_element.rem_euclid(self.elements as i64) as usize;
        row.forces.clear();
        row.forces.extend(forces.iter().copied().enumerate().filter(|(_, force)| *force != 0.0));
        self.instant = (self.instant + 1) % self.rows.len();
    }

    fn set_clocks(&mut self, clocks: Clocks) {
        self.clocks = clocks;
    }

    fn save(&self, state: &mut StateWriter) {
        state.count(self.instant as u64);
        for row in &self.rows {
            state.count(row.first as u64);
            state.counts(&row.forces.iter().map(|&(distance, _)| distance as u64).collect::<Vec<_>>());
            state.numbers(&row.forces.iter().map(|&(_, force)| force).collect::<Vec<_>>());
            state.numbers(&row.ring);
        }
        self.groups.iter().flat_map(WavenumberGroup::states).for_each(|states| state.numbers(states));
    }

    fn restore(&mut self, state: &mut StateReader<'_>) -> Result<(), StateError> {
        self.instant = state.size()?;
        let mut fits = self.instant < self.rows.len();
        for row in &mut self.rows {
            row.first = state.size()?;
            let distances = state.counts()?;
            let forces = state.numbers()?;
            fits &= row.first < self.elements && distances.len() == forces.len();
            fits &= distances.iter().all(|&distance| distance < self.elements as u64);
            row.forces.clear();
            row.forces.extend(distances.iter().map(|&distance| distance as usize).zip(forces));
            state.numbers_into(&mut row.ring)?;
        }
        if !fits {
            return Err(StateError::Value);
        }
        self.groups.iter_mut().flat_map(WavenumberGroup::states_mut).try_for_each(|states| state.numbers_into(states))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{DEFAULT, Scene};
    use crate::tyre::rational::{FitOptions, fit};

    const RULES: [TimeRule; 6] = [
        TimeRule::Bdf1,
        TimeRule::Bdf2,
        TimeRule::Trapezoidal,
        TimeRule::Sdirk2,
        TimeRule::Sdirk3,
        TimeRule::FirstOrderHold,
    ];
    const COLUMNS: usize = 11;

    fn model() -> RationalModel {
        let tyre = Scene::from_str(DEFAULT, "default").unwrap().scene.tyre;
        fit(&tyre, &FitOptions::new(&tyre, 24, 20.0).with_tolerance(1e-3)).unwrap()
    }

    /// Forces of some points, none at times, that depend on what came before.
    fn roll(history: &mut ModalHistory, from: i64, to: i64) -> Vec<f64> {
        let stages = history.rule.nodes().len() as i64;
        let mut all = Vec::new();
        for instant in from..to {
            let first = instant / stages / 2;
            let mut old = [0.0; COLUMNS];
            history.displacement(first, &mut old);
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
        for rule in RULES {
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
        for rule in RULES {
            let history = || ModalHistory::new(&model, Field::Surface, rule, 1e-4).unwrap();
            for stop in 29..50 {
                let mut whole = history();
                roll(&mut whole, 0, stop);
                let mut state = StateWriter::default();
                whole.save(&mut state);
                let bytes = state.into_bytes();
                let mut restored = history();
                let mut reader = StateReader::new(&bytes);
                restored.restore(&mut reader).unwrap();
                reader.end().unwrap();
                assert_eq!(roll(&mut whole, stop, 90), roll(&mut restored, stop, 90), "{rule:?}, {stop}");
            }
        }
    }
}
