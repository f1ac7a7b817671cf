//! The past of cells carried by poles: one recursion for each pole of each wave, block by block.
//!
//! Poles and states of all waves do not fit into a processor's nearest memory. They are gone through once in a *block*
//! of [`STEPS`] steps: a pass takes in the forces of the block before and foretells the displacement at every instant
//! of this one as if no more forces came. What the earlier instants of the block add is a short sum for each wave, with
//! the first weights of the same recursion. By linearity that is the recursion itself but for rounding.
//!
//! Waves are independent of each other, and threads share them out in groups: the same bits whoever takes which.

use num_complex::Complex64;
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::wave_transform::WaveTransform;
use crate::contact::history::wavenumber_group::{GROUP, Pass, WavenumberGroup};
use crate::counters::Work;
use crate::storage::state::{StateError, fill_all};
use crate::time_rule::TimeRule;
use crate::time_rule::recursion::{Recursion, WithRecursion};
use crate::tyre::poles::cells::CellModel;

/// Steps of a block.
pub const STEPS: usize = 4;
/// Groups that a thread takes at a time.
const GROUPS_TOGETHER: usize = 16;
/// Waves that a thread sums at a time.
const WAVES_TOGETHER: usize = 2048;

/// Waves of one ring and their past.
pub struct WavePast {
    rule: TimeRule,
    transform: WaveTransform,
    groups: Vec<WavenumberGroup>,
    /// What a force at a stage does one, two, ... instants later \[m/N\]: stage by stage, lag by lag, wave by wave.
    within: Vec<f64>,
    /// Number of the coming instant in its block.
    instant: usize,
    /// Forces \[N\] at the instants of a block: of this one as far as they are known, then of the last one.
    forces: Vec<Vec<Complex64>>,
    /// Displacements \[m\] at the instants of this block as foretold.
    foretold: Vec<Vec<Complex64>>,
    sum: Vec<Complex64>,
    /// On the cells of the window \[m\].
    displacement: Vec<f64>,
    work: Work,
    arch: Arch,
}

/// What evolves of a [`WavePast`].
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct WavePastState {
    instant: usize,
    forces: Vec<Vec<Complex64>>,
    foretold: Vec<Vec<Complex64>>,
    poles: Vec<Vec<f64>>,
}

impl WavePast {
    /// At rest.
    pub fn new(model: &CellModel, transform: WaveTransform, rule: TimeRule, time_step: f64) -> Self {
        Self::with_blocks(model, transform, rule, time_step, STEPS)
    }

    /// As [`Self::new`], in blocks of so many steps: with one the plain recursion, to measure against.
    pub fn with_blocks(
        model: &CellModel,
        transform: WaveTransform,
        rule: TimeRule,
        time_step: f64,
        steps: usize,
    ) -> Self {
        let (waves, stages) = (model.len(), rule.stages());
        let instants = steps * stages;
        let groups: Vec<WavenumberGroup> = (0..waves)
            .step_by(GROUP)
            .map(|first| {
                let modes = (first..waves).take(GROUP).map(|wave| model.modes(wave));
                WavenumberGroup::new(modes, rule, time_step, first, instants, 0)
            })
            .collect();
        let lags = instants - 1;
        let mut within = vec![0.0; stages * lags * waves];
        let mut response = vec![0.0; lags];
        for wave in 0..waves {
            let modes = model.modes(wave);
            for stage in 0..stages {
                response.fill(0.0);
                for (index, (&pole, &residue)) in modes.poles.iter().zip(modes.residues).enumerate() {
                    let weights = rule.coefficients(pole, modes.multiplicity(index) * residue, time_step);
                    rule.impulse_response(weights.into(), stage, &mut response);
                }
                for (lag, value) in response.iter().enumerate() {
                    within[(stage * lags + lag) * waves + wave] = *value;
                }
            }
        }
        let zeros = || vec![vec![Complex64::ZERO; waves]; instants];
        let mut work = Work::default();
        groups.iter().for_each(|group| work += group.work());
        // Every instant sees half of the others of its block.
        let products = (instants * lags * waves) as u64;
        work += Work { multiply_adds: products, bytes: 12 * products };
        let (forces, foretold, sum) = (zeros(), zeros(), vec![Complex64::ZERO; waves]);
        let displacement = vec![0.0; transform.cells()];
        Self {
            rule,
            transform,
            groups,
            within,
            instant: 0,
            forces,
            foretold,
            sum,
            displacement,
            work,
            arch: Arch::new(),
        }
    }

    /// What a block costs, if one begins with the coming instant.
    pub fn work(&self) -> Work {
        if self.instant == 0 { self.work } else { Work::default() }
    }

    /// What the past displaces as last found, cell by cell \[m\].
    pub fn displacement(&self) -> &[f64] {
        &self.displacement
    }

    /// Finds what the past displaces at the coming instant, on the window that begins with `first_element`; the forces
    /// of every instant are to be known before the next.
    pub fn displace(&mut self, first_element: i64) {
        if self.instant == 0 {
            self.rule.with_recursion(Block(self));
        }
        let Self { rule, transform, within, instant, forces, foretold, sum, displacement, arch, .. } = self;
        let (stages, lags, waves) = (rule.stages(), forces.len() - 1, sum.len());
        let now = *instant;
        sum.par_chunks_mut(WAVES_TOGETHER).enumerate().for_each(|(part, sum)| {
            let range = part * WAVES_TOGETHER..part * WAVES_TOGETHER + sum.len();
            sum.copy_from_slice(&foretold[now][range.clone()]);
            for (earlier, forces) in forces[..now].iter().enumerate() {
                let row = (earlier % stages * lags + now - earlier - 1) * waves;
                let weights = &within[row..row + waves][range.clone()];
                arch.dispatch(Weighted { sum, weights, forces: &forces[range.clone()] });
            }
        });
        displacement.fill(0.0);
        transform.add_inverse(sum, first_element, displacement);
    }

    /// Takes the forces of the instant \[N\].
    pub fn push(&mut self, first_element: i64, forces: &[f64]) {
        self.transform.forward(first_element, forces, &mut self.forces[self.instant]);
        self.instant = (self.instant + 1) % self.forces.len();
    }

    /// Takes the state down.
    pub fn save(&self) -> WavePastState {
        WavePastState {
            instant: self.instant,
            forces: self.forces.clone(),
            foretold: self.foretold.clone(),
            poles: self.groups.iter().flat_map(WavenumberGroup::states).map(<[f64]>::to_vec).collect(),
        }
    }

    /// Goes on from the state of an equal past.
    ///
    /// # Errors
    /// [`StateError`].
    pub fn restore(&mut self, state: &WavePastState) -> Result<(), StateError> {
        if state.instant >= self.forces.len() {
            return Err(StateError::Value);
        }
        self.instant = state.instant;
        for (own, kept) in [(&mut self.forces, &state.forces), (&mut self.foretold, &state.foretold)] {
            let same = own.len() == kept.len() && own.iter().zip(kept).all(|(own, kept)| own.len() == kept.len());
            if !same {
                return Err(StateError::Value);
            }
            own.clone_from(kept);
        }
        let states: Vec<&mut [f64]> = self.groups.iter_mut().flat_map(WavenumberGroup::states_mut).collect();
        fill_all(states.into_iter(), &state.poles)
    }
}

/// Adds weight times force, wave by wave. A type, not a closure, since it has to be inlined into the dispatch to be
/// compiled for its instructions.
struct Weighted<'a> {
    sum: &'a mut [Complex64],
    weights: &'a [f64],
    forces: &'a [Complex64],
}

impl WithSimd for Weighted<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for ((sum, &weight), force) in self.sum.iter_mut().zip(self.weights).zip(self.forces) {
            sum.re = weight.mul_add(force.re, sum.re);
            sum.im = weight.mul_add(force.im, sum.im);
        }
    }
}

/// A pass over all poles.
struct Block<'a>(&'a mut WavePast);

impl WithRecursion for Block<'_> {
    type Output = ();

    fn with<R: Recursion>(self, recursion: R) {
        let WavePast { groups, forces, foretold, arch, .. } = self.0;
        groups.par_iter_mut().with_min_len(GROUPS_TOGETHER).for_each(|group| {
            for (instant, forces) in forces.iter().enumerate() {
                group.take_forces(instant, forces);
            }
            arch.dispatch(Pass { group, recursion });
        });
        for group in groups {
            for (instant, foretold) in foretold.iter_mut().enumerate() {
                group.give_displacement(instant, foretold);
            }
        }
    }
}
