//! Work behind the march for the past of cells: at each instant a part of the pass over all poles, and the sum
//! of what all but the last forces do at the next instant.
//!
//! With rotation, u_n = E_n F_n + i O_n F_n, n >= 0, with E and O as operators in time: real, over the same poles.

use std::ops::Range;

use num_complex::{Complex, Complex64};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use super::fewer_poles::{FewerPoles, fewer_poles};
use crate::contact::history::behind::Task;
use crate::contact::history::block_pass::pass;
use crate::contact::history::wavenumber_group::WavenumberGroup;
use crate::counters::{Clock, CpuClock, Meter, Spent, Stage, Work};
use crate::numeric::Element;
use crate::time_rule::TimeRule;
use crate::time_rule::recursion::{Recursion, WithRecursion};
use crate::tyre::poles::Modes;
use crate::tyre::poles::cells::CellModel;

/// Vectors of waves whose sums are found side by side, so that none waits for the other.
const TOGETHER: usize = 4;

/// The waves of all rings, and what is to be done for them.
pub struct Waves<N> {
    /// Ring by ring.
    pub rings: Vec<RingWaves<N>>,
    rule: TimeRule,
    /// The instant of the block that the march is at.
    instant: usize,
    /// Clock of processor time beside wall time, if there is one, and times of the last part.
    cpu: Option<CpuClock>,
    spent: Spent,
    /// True if it went on behind the march.
    behind: bool,
}

/// The waves of one ring. Complex fields over all of them have their real parts first, then their imaginary parts, each
/// filled up to whole vectors.
pub struct RingWaves<N> {
    groups: Vec<WavenumberGroup<N>>,
    /// Those whose poles are too slow for single precision.
    precise: Vec<WavenumberGroup<f64>>,
    /// Response one, two, ... instants after a force at a stage \[m/N\]: stage by stage, lag by lag, wave by wave.
    within: Vec<N>,
    /// The same of odd parts; empty where no wave has one.
    within_odd: Vec<N>,
    stages: usize,
    /// Numbers of half a field.
    padded: usize,
    /// Forces \[N\] at the instants of the block before and of this one.
    forces: Vec<Vec<N>>,
    /// Displacements \[m\] at the instants of this block and of the next one, as foretold from the blocks before the
    /// last, and before this one.
    foretold: Vec<Vec<N>>,
    /// Displacements by all forces but the last at the coming instant, and by all but two at the one after it \[m\]:
    /// those of two instants are found together, which reads forces and weights once.
    sums: [Vec<N>; 2],
    /// Forces of the blocks that are not forgotten yet, instant by instant; none where nothing ever is.
    pub remembered: Vec<Vec<f32>>,
    /// The earliest block of them, which is forgotten next.
    pub earliest: usize,
    work: Work,
    arch: Arch,
}

impl<N: Element> RingWaves<N> {
    /// At rest, for blocks of so many steps.
    pub fn new(
        model: &CellModel,
        rule: TimeRule,
        time_step: f64,
        steps: usize,
        forgotten_after: Option<usize>,
        fewer: Option<f64>,
    ) -> Self {
        let (waves, stages) = (model.len(), rule.stages());
        let (instants, padded) = (steps * stages, padded::<N>(waves));
        let reduced = |wave: usize| fewer_poles(&model.modes(wave), rule, time_step, steps, fewer?);
        let reduced: Vec<Option<FewerPoles>> = (0..waves).into_par_iter().map(reduced).collect();
        let modes = |wave: usize| reduced[wave].as_ref().map_or(model.modes(wave), FewerPoles::modes);
        let group_of = |first: usize, count: usize| {
            // The coming block is passed over: it is under way while the next is foretold.
            (first..waves.min(first + count)).map(modes)
        };
        let (mut groups, mut precise) = (Vec::new(), Vec::new());
        for first in (0..waves).step_by(N::MOST_LANES) {
            let modes = group_of(first, N::MOST_LANES);
            if N::EPSILON > f64::EPSILON && modes.clone().any(|modes| is_slow(&modes, time_step)) {
                for first in (first..waves.min(first + N::MOST_LANES)).step_by(f64::MOST_LANES) {
                    let modes = group_of(first, f64::MOST_LANES);
                    precise.push(WavenumberGroup::new(modes, rule, time_step, first, instants, 1));
                }
            } else {
                groups.push(WavenumberGroup::new(modes, rule, time_step, first, instants, 1));
            }
        }
        let mut remembered = Vec::new();
        if let Some(after) = forgotten_after {
            let blocks = (after / steps).max(1);
            groups.par_iter_mut().for_each(|group| group.forget(rule, blocks * steps));
            precise.par_iter_mut().for_each(|group| group.forget(rule, blocks * steps));
            remembered = vec![vec![0.0; 2 * padded]; blocks * instants];
        }
        let within = responses(model, rule, time_step, instants, |modes| modes.residues);
        let turns = (0..waves).any(|wave| !model.modes(wave).odd.is_empty());
        let odd = || responses(model, rule, time_step, instants, |modes| modes.odd);
        let within_odd = if turns { odd() } else { Vec::new() };
        let mut work = Work::default();
        groups.iter().for_each(|group| work += group.work());
        precise.iter().for_each(|group| work += group.work());
        // Every instant sees the block before and half of the others of its own.
        let products = (instants * (3 * instants - 1) * waves * if turns { 2 } else { 1 }) as u64;
        work += Work { multiply_adds: products, bytes: 12 * products };
        let zeros = || vec![N::default(); 2 * padded];
        let block = || vec![zeros(); 2 * instants];
        Self {
            groups,
            precise,
            within,
            within_odd,
            stages,
            padded,
            forces: block(),
            foretold: block(),
            sums: [zeros(), zeros()],
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
    pub fn take_forces(&mut self, instant: usize, forces: &[Complex<N>]) {
        let instants = self.instants();
        let (re, im) = self.forces[instants + instant].split_at_mut(self.padded);
        for ((re, im), force) in re.iter_mut().zip(im).zip(forces) {
            (*re, *im) = (force.re, force.im);
        }
    }

    /// A block begins.
    pub fn turn(&mut self) {
        let instants = self.instants();
        self.forces.rotate_left(instants);
        self.foretold.rotate_left(instants);
    }

    /// Gives the displacements at an instant of the block, completed by those of the last forces.
    pub fn finish(&mut self, instant: usize, displacement: &mut [Complex<N>]) {
        let now = self.instants() + instant;
        self.add_forces(now, now - 1..now, false);
        let (re, im) = self.sums[0].split_at(self.padded);
        for (out, (re, im)) in displacement.iter_mut().zip(re.iter().zip(im)) {
            *out = Complex::new(*re, *im);
        }
    }

    /// Adds what the forces of earlier instants do now, and where both are wanted at the next instant, all counted from
    /// the block before.
    fn add_forces(&mut self, now: usize, earlier: Range<usize>, both: bool) {
        let Self { within, within_odd, stages, padded, forces, sums, arch, .. } = self;
        let lags = forces.len() - 1;
        let weighted =
            Weighted { sums, within, within_odd, forces, padded: *padded, stages: *stages, lags, now, earlier, both };
        arch.dispatch(weighted);
    }

    /// Does the work behind the march at an instant: a part of the pass, and the sum for the next instant.
    fn go_on<R: Recursion>(&mut self, instant: usize, recursion: R) {
        let instants = self.instants();
        let Self { groups, precise, padded, forces, foretold, remembered, earliest, arch, .. } = self;
        let (last, _) = forces.split_at(instants);
        let (_, next) = foretold.split_at_mut(instants);
        let blocks = remembered.len() / instants;
        let old = remembered.chunks_exact_mut(instants).nth(*earliest).unwrap_or_default();
        let mut block = Block { arch: *arch, recursion, padded: *padded, last, old: &*old, next };
        let share = |groups: usize| instant * groups / instants..(instant + 1) * groups / instants;
        let (own, slow) = (share(groups.len()), share(precise.len()));
        groups[own].iter_mut().for_each(|group| block.pass(group));
        precise[slow].iter_mut().for_each(|group| block.pass(group));
        if instant + 1 == instants && blocks > 0 {
            for (old, forces) in old.iter_mut().zip(last) {
                old.iter_mut().zip(forces).for_each(|(old, force)| *old = force.double() as f32);
            }
            *earliest = (*earliest + 1) % blocks;
        }
        let now = instants + instant + 1;
        if instant % 2 == 1 || instants % 2 == 1 {
            let both = instants.is_multiple_of(2);
            for (sum, foretold) in self.sums.iter_mut().zip(&self.foretold[instant + 1..]) {
                sum.copy_from_slice(foretold);
            }
            // The pass has taken in the block before; the next one is told without it.
            let first = if instant + 1 == instants { instants } else { 0 };
            self.add_forces(now, first..now - 1, both);
        } else {
            self.sums.swap(0, 1);
            self.add_forces(now, now - 2..now - 1, false);
        }
    }

    /// Fields that evolve.
    pub fn fields(&self) -> impl Iterator<Item = &Vec<N>> {
        self.sums.iter().chain(&self.forces).chain(&self.foretold)
    }

    /// As [`Self::fields`], to be changed.
    pub fn fields_mut(&mut self) -> impl Iterator<Item = &mut Vec<N>> {
        self.sums.iter_mut().chain(&mut self.forces).chain(&mut self.foretold)
    }

    /// States of all poles.
    pub fn states(&self) -> impl Iterator<Item = &[N]> {
        self.groups.iter().flat_map(WavenumberGroup::states)
    }

    /// As [`Self::states`], to be changed.
    pub fn states_mut(&mut self) -> impl Iterator<Item = &mut [N]> {
        self.groups.iter_mut().flat_map(WavenumberGroup::states_mut)
    }

    /// States of the slow poles.
    pub fn precise_states(&self) -> impl Iterator<Item = &[f64]> {
        self.precise.iter().flat_map(WavenumberGroup::states)
    }

    /// As [`Self::precise_states`], to be changed.
    pub fn precise_states_mut(&mut self) -> impl Iterator<Item = &mut [f64]> {
        self.precise.iter_mut().flat_map(WavenumberGroup::states_mut)
    }
}

/// Input and output of a pass.
struct Block<'a, N, R> {
    arch: Arch,
    recursion: R,
    padded: usize,
    /// Forces of the last block.
    last: &'a [Vec<N>],
    /// Those that are forgotten.
    old: &'a [Vec<f32>],
    /// Displacements in the coming block.
    next: &'a mut [Vec<N>],
}

impl<N: Element, R: Recursion> Block<'_, N, R> {
    fn pass<E: Element>(&mut self, group: &mut WavenumberGroup<E>) {
        let (padded, waves) = (self.padded, group.wavenumbers());
        let parts = waves.clone().zip(padded + waves.start..);
        for (instant, forces) in self.last.iter().enumerate() {
            let value = |number: usize| E::rounded(forces[number].double());
            group.take_forces(instant, parts.clone().map(|(re, im)| [value(re), value(im)]));
        }
        for (instant, forces) in self.old.iter().enumerate() {
            let value = |number: usize| E::rounded(forces[number].into());
            group.take_old_forces(instant, parts.clone().map(|(re, im)| [value(re), value(im)]));
        }
        pass(group, self.arch, self.recursion);
        for (instant, foretold) in self.next.iter_mut().enumerate() {
            for ((re, im), value) in parts.clone().zip(group.displacement(instant)) {
                [foretold[re], foretold[im]] = value.map(|value| N::rounded(value.double()));
            }
        }
    }
}

/// Numbers of half a field of so many waves.
const fn padded<N: Element>(waves: usize) -> usize {
    waves.next_multiple_of(TOGETHER * N::MOST_LANES)
}

/// Part of a wave's static displacement that rounding its poles to single precision may be.
const ROUNDED: f64 = 2e-6;

/// Tells waves whose poles single precision would move too far: of a pole that decays by d a step it changes the static
/// displacement by its rounding over d.
fn is_slow(modes: &Modes<'_>, time_step: f64) -> bool {
    let (mut all, mut moved) = (0.0_f64, 0.0);
    for (index, (pole, residue)) in modes.poles.iter().zip(modes.residues).enumerate() {
        let part = (modes.multiplicity(index) * residue / pole).re;
        all += part;
        moved += part.abs() * f64::from(f32::EPSILON) / (pole.norm() * time_step);
    }
    moved > ROUNDED * all.abs()
}

impl<N: Element> Waves<N> {
    /// Makes the work of rings.
    pub fn new(rings: Vec<RingWaves<N>>, rule: TimeRule) -> Self {
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

impl<N: Element> Task for Waves<N> {
    fn carry_out(&mut self, behind: bool) {
        self.behind = behind;
        let mut clock = Clock::start(self.cpu);
        self.rule.with_recursion(GoOn(self));
        self.spent = clock.lap();
    }
}

struct GoOn<'a, N>(&'a mut Waves<N>);

impl<N: Element> WithRecursion for GoOn<'_, N> {
    type Output = ();

    fn with<R: Recursion>(self, recursion: R) {
        let Waves { rings, instant, .. } = self.0;
        rings.iter_mut().for_each(|ring| ring.go_on(*instant, recursion));
    }
}

/// Response of all waves by some of their residues one, two, ... instants after a force at a stage: stage by stage, lag
/// by lag, wave by wave.
fn responses<N: Element>(
    model: &CellModel,
    rule: TimeRule,
    time_step: f64,
    instants: usize,
    residues: impl for<'m> Fn(&Modes<'m>) -> &'m [Complex64],
) -> Vec<N> {
    let (waves, stages, lags) = (model.len(), rule.stages(), 2 * instants - 1);
    let padded = padded::<N>(waves);
    let mut within = vec![N::default(); stages * lags * padded];
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
                within[(stage * lags + lag) * padded + wave] = N::rounded(*value);
            }
        }
    }
    within
}

/// Adds what forces do: weight times force, and i times odd weight times force.
struct Weighted<'a, N> {
    sums: &'a mut [Vec<N>; 2],
    within: &'a [N],
    within_odd: &'a [N],
    forces: &'a [Vec<N>],
    padded: usize,
    stages: usize,
    lags: usize,
    now: usize,
    earlier: Range<usize>,
    both: bool,
}

impl<N: Element> WithSimd for Weighted<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        match (self.both, self.within_odd.is_empty()) {
            (false, true) => self.add::<S, 1, false>(simd),
            (false, false) => self.add::<S, 1, true>(simd),
            (true, true) => self.add::<S, 2, false>(simd),
            (true, false) => self.add::<S, 2, true>(simd),
        }
    }
}

impl<N: Element> Weighted<'_, N> {
    /// Adds to the sums of so many instants.
    #[inline(always)]
    fn add<S: Simd, const INSTANTS: usize, const TURNS: bool>(self, simd: S) {
        let Self { sums, within, within_odd, forces, padded, stages, lags, now, earlier, .. } = self;
        let (within, odd) = (N::vectors::<S>(within), N::vectors::<S>(within_odd));
        let vectors = padded / N::lanes::<S>();
        for first in (0..vectors).step_by(TOGETHER) {
            let mut totals = [[[N::splat(simd, N::default()); TOGETHER]; 2]; INSTANTS];
            for (total, sum) in totals.iter_mut().zip(&*sums) {
                let sum = N::vectors::<S>(sum);
                for part in 0..2 {
                    total[part].copy_from_slice(&sum[part * vectors + first..][..TOGETHER]);
                }
            }
            for number in earlier.clone() {
                let force = N::vectors::<S>(&forces[number]);
                let (re, im) = (&force[first..][..TOGETHER], &force[vectors + first..][..TOGETHER]);
                for (instant, [total_re, total_im]) in totals.iter_mut().enumerate() {
                    let row = (number % stages * lags + now + instant - number - 1) * vectors + first;
                    let weights = &within[row..][..TOGETHER];
                    for v in 0..TOGETHER {
                        total_re[v] = N::mul_add(simd, weights[v], re[v], total_re[v]);
                        total_im[v] = N::mul_add(simd, weights[v], im[v], total_im[v]);
                    }
                    if TURNS {
                        let weights = &odd[row..][..TOGETHER];
                        for v in 0..TOGETHER {
                            total_re[v] = N::negate_mul_add(simd, weights[v], im[v], total_re[v]);
                            total_im[v] = N::mul_add(simd, weights[v], re[v], total_im[v]);
                        }
                    }
                }
            }
            for (total, sum) in totals.iter().zip(&mut *sums) {
                let sum = N::vectors_mut::<S>(sum);
                for part in 0..2 {
                    sum[part * vectors + first..][..TOGETHER].copy_from_slice(&total[part]);
                }
            }
        }
    }
}
