//! Work behind the march for the past of cells: at each instant a part of the pass over all poles, and the sum
//! of what all but the last forces do at the next instant.
//!
//! With rotation, u_n = E_n F_n + i O_n F_n, n >= 0, with E and O as operators in time: real, over the same poles.

use std::ops::Range;

use num_complex::{Complex, Complex64};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use crate::contact::history::behind::Task;
use crate::contact::history::block_pass::pass;
use crate::contact::history::wavenumber_group::{GROUP, WavenumberGroup};
use crate::counters::{Clock, CpuClock, Meter, Spent, Stage, Work};
use crate::time_rule::TimeRule;
use crate::time_rule::recursion::{Recursion, WithRecursion};
use crate::tyre::poles::Modes;
use crate::tyre::poles::cells::CellModel;

/// The waves of all rings, and what is to be done for them.
pub struct Waves {
    /// Ring by ring.
    pub rings: Vec<RingWaves>,
    rule: TimeRule,
    /// The instant of the block that the march is at.
    instant: usize,
    /// Clock of processor time beside wall time, if there is one, and times of the last part.
    cpu: Option<CpuClock>,
    spent: Spent,
    /// True if it went on behind the march.
    behind: bool,
}

/// The waves of one ring.
pub struct RingWaves {
    groups: Vec<WavenumberGroup>,
    /// Response one, two, ... instants after a force at a stage \[m/N\]: stage by stage, lag by lag, wave by wave.
    within: Vec<f64>,
    /// The same of odd parts; empty where no wave has one.
    within_odd: Vec<f64>,
    stages: usize,
    /// Forces \[N\] at the instants of the block before and of this one.
    forces: Vec<Vec<Complex64>>,
    /// Displacements \[m\] at the instants of this block and of the next one, as foretold from the blocks before the
    /// last, and before this one.
    foretold: Vec<Vec<Complex64>>,
    /// Displacements at the coming instant by all but the last forces \[m\].
    sum: Vec<Complex64>,
    /// Forces of the blocks that are not forgotten yet, instant by instant; none where nothing ever is.
    pub remembered: Vec<Vec<Complex<f32>>>,
    /// The earliest block of them, which is forgotten next.
    pub earliest: usize,
    work: Work,
    arch: Arch,
}

impl RingWaves {
    /// At rest, for blocks of so many steps.
    pub fn new(
        model: &CellModel,
        rule: TimeRule,
        time_step: f64,
        steps: usize,
        forgotten_after: Option<usize>,
    ) -> Self {
        let (waves, stages) = (model.len(), rule.stages());
        let instants = steps * stages;
        let mut groups: Vec<WavenumberGroup> = (0..waves)
            .step_by(GROUP)
            .map(|first| {
                let modes = (first..waves).take(GROUP).map(|wave| model.modes(wave));
                // The coming block is passed over: it is under way while the next is foretold.
                WavenumberGroup::new(modes, rule, time_step, first, instants, 1)
            })
            .collect();
        let mut remembered = Vec::new();
        if let Some(after) = forgotten_after {
            let blocks = (after / steps).max(1);
            groups.par_iter_mut().for_each(|group| group.forget(rule, blocks * steps));
            remembered = vec![vec![Complex::ZERO; waves]; blocks * instants];
        }
        let within = responses(model, rule, time_step, instants, |modes| modes.residues);
        let turns = (0..waves).any(|wave| !model.modes(wave).odd.is_empty());
        let odd = || responses(model, rule, time_step, instants, |modes| modes.odd);
        let within_odd = if turns { odd() } else { Vec::new() };
        let mut work = Work::default();
        groups.iter().for_each(|group| work += group.work());
        // Every instant sees the block before and half of the others of its own.
        let products = (instants * (3 * instants - 1) * waves * if turns { 2 } else { 1 }) as u64;
        work += Work { multiply_adds: products, bytes: 12 * products };
        let zeros = || vec![vec![Complex64::ZERO; waves]; 2 * instants];
        let (forces, foretold, sum) = (zeros(), zeros(), vec![Complex64::ZERO; waves]);
        Self {
            groups,
            within,
            within_odd,
            stages,
            forces,
            foretold,
            sum,
            remembered,
            earliest: 0,
            work,
            arch: Arch::new(),
        }
    }

    /// Returns the work of a block.
    pub fn work(&self) -> Work {
        self.work
    }

    /// Instants of a block.
    fn instants(&self) -> usize {
        self.forces.len() / 2
    }

    /// Takes the forces of an instant of the block.
    pub fn take_forces(&mut self, instant: usize, forces: &mut Vec<Complex64>) {
        let place = self.instants() + instant;
        std::mem::swap(&mut self.forces[place], forces);
    }

    /// A block begins.
    pub fn turn(&mut self) {
        let instants = self.instants();
        self.forces.rotate_left(instants);
        self.foretold.rotate_left(instants);
    }

    /// Completes the displacements at an instant of the block by those of the last forces.
    pub fn finish(&mut self, instant: usize, displacement: &mut Vec<Complex64>) {
        let now = self.instants() + instant;
        self.add_forces(now, now - 1..now);
        std::mem::swap(&mut self.sum, displacement);
    }

    /// Adds what the forces of earlier instants do now, all counted from the block before.
    fn add_forces(&mut self, now: usize, earlier: Range<usize>) {
        let (waves, lags) = (self.sum.len(), 2 * self.instants() - 1);
        for number in earlier {
            let row = (number % self.stages * lags + now - number - 1) * waves;
            let weights = &self.within[row..row + waves];
            self.arch.dispatch(Weighted { sum: &mut self.sum, weights, forces: &self.forces[number] });
            if let Some(weights) = self.within_odd.get(row..row + waves) {
                self.arch.dispatch(WeightedOdd { sum: &mut self.sum, weights, forces: &self.forces[number] });
            }
        }
    }

    /// Does the work behind the march at an instant: a part of the pass, and the sum for the next instant.
    fn go_on<R: Recursion>(&mut self, instant: usize, recursion: R) {
        let instants = self.instants();
        let Self { groups, forces, foretold, remembered, earliest, arch, .. } = self;
        let (last, _) = forces.split_at(instants);
        let (_, next) = foretold.split_at_mut(instants);
        let blocks = remembered.len() / instants;
        let old = remembered.chunks_exact_mut(instants).nth(*earliest).unwrap_or_default();
        let share = |part: usize| part * groups.len() / instants;
        let part = share(instant)..share(instant + 1);
        for group in &mut groups[part] {
            for (instant, forces) in last.iter().enumerate() {
                group.take_forces(instant, forces);
            }
            for (instant, forces) in old.iter().enumerate() {
                group.take_old_forces(instant, forces);
            }
            pass(group, *arch, recursion);
            for (instant, foretold) in next.iter_mut().enumerate() {
                group.give_displacement(instant, foretold);
            }
        }
        if instant + 1 == instants && blocks > 0 {
            for (old, forces) in old.iter_mut().zip(last) {
                for (old, force) in old.iter_mut().zip(forces) {
                    *old = Complex::new(force.re as f32, force.im as f32);
                }
            }
            *earliest = (*earliest + 1) % blocks;
        }
        self.sum.copy_from_slice(&self.foretold[instant + 1]);
        // The pass has taken in the block before; the next one is told without it.
        let first = if instant + 1 == instants { instants } else { 0 };
        self.add_forces(instants + instant + 1, first..instants + instant);
    }

    /// Fields that evolve.
    pub fn fields(&self) -> impl Iterator<Item = &Vec<Complex64>> {
        std::iter::once(&self.sum).chain(&self.forces).chain(&self.foretold)
    }

    /// As [`Self::fields`], to be changed.
    pub fn fields_mut(&mut self) -> impl Iterator<Item = &mut Vec<Complex64>> {
        std::iter::once(&mut self.sum).chain(&mut self.forces).chain(&mut self.foretold)
    }

    /// States of all poles.
    pub fn states(&self) -> impl Iterator<Item = &[f64]> {
        self.groups.iter().flat_map(WavenumberGroup::states)
    }

    /// As [`Self::states`], to be changed.
    pub fn states_mut(&mut self) -> impl Iterator<Item = &mut [f64]> {
        self.groups.iter_mut().flat_map(WavenumberGroup::states_mut)
    }
}

impl Waves {
    /// Makes the work of rings.
    pub fn new(rings: Vec<RingWaves>, rule: TimeRule) -> Self {
        Self { rings, rule, instant: 0, cpu: None, spent: Spent::default(), behind: false }
    }

    /// Begins the work that goes on while the march is at an instant of the block.
    pub fn begin(&mut self, instant: usize, cpu: Option<CpuClock>) {
        (self.instant, self.cpu) = (instant, cpu);
    }

    /// Tells what the last part has cost beside the march; what it cost within the march is measured there.
    pub fn report(&self, meter: &mut Meter) {
        if self.behind {
            meter.add_background(Stage::History, self.spent.wall);
        }
    }
}

impl Task for Waves {
    fn carry_out(&mut self, behind: bool) {
        self.behind = behind;
        let mut clock = Clock::start(self.cpu);
        self.rule.with_recursion(GoOn(self));
        self.spent = clock.lap();
    }
}

struct GoOn<'a>(&'a mut Waves);

impl WithRecursion for GoOn<'_> {
    type Output = ();

    fn with<R: Recursion>(self, recursion: R) {
        let Waves { rings, instant, .. } = self.0;
        rings.iter_mut().for_each(|ring| ring.go_on(*instant, recursion));
    }
}

/// Response of all waves by some of their residues one, two, ... instants after a force at a stage: stage by stage, lag
/// by lag, wave by wave.
fn responses(
    model: &CellModel,
    rule: TimeRule,
    time_step: f64,
    instants: usize,
    residues: impl for<'m> Fn(&Modes<'m>) -> &'m [Complex64],
) -> Vec<f64> {
    let (waves, stages, lags) = (model.len(), rule.stages(), 2 * instants - 1);
    let mut within = vec![0.0; stages * lags * waves];
    let mut response = vec![0.0; lags];
    for wave in 0..waves {
        let modes = model.modes(wave);
        for stage in 0..stages {
            response.fill(0.0);
            for (index, (&pole, &residue)) in modes.poles.iter().zip(residues(&modes)).enumerate() {
                let weights = rule.coefficients(pole, modes.multiplicity(index) * residue, time_step);
                rule.impulse_response(weights.into(), stage, &mut response);
            }
            for (lag, value) in response.iter().enumerate() {
                within[(stage * lags + lag) * waves + wave] = *value;
            }
        }
    }
    within
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

/// Adds i times weight times force, wave by wave, likewise.
struct WeightedOdd<'a> {
    sum: &'a mut [Complex64],
    weights: &'a [f64],
    forces: &'a [Complex64],
}

impl WithSimd for WeightedOdd<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for ((sum, &weight), force) in self.sum.iter_mut().zip(self.weights).zip(self.forces) {
            sum.re = weight.mul_add(-force.im, sum.re);
            sum.im = weight.mul_add(force.re, sum.im);
        }
    }
}
