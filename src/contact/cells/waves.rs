//! Work behind the march for the past of cells: at each instant a part of the pass over all poles, and the sum
//! of what all but the last forces do at the next instant.
//!
//! With rotation, u_n = E_n F_n + i O_n F_n, n >= 0, with E and O as operators in time: real, over the same poles.

use std::ops::Range;

use num_complex::Complex;
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

/// Widest vectors of a tile.
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

/// The waves of one ring, in tiles of [`tile`] neighbours. Of a complex field a tile has the real parts first, then the
/// imaginary parts; all that is summed for a tile stands together, so that it is read as one stream.
pub struct RingWaves<N> {
    groups: Vec<WavenumberGroup<N>>,
    /// Those whose poles are too slow for single precision.
    precise: Vec<WavenumberGroup<f64>>,
    /// Response one, two, ... instants after a force at a stage \[m/N\], of odd parts too where waves have these: tile
    /// by tile, stage by stage, lag by lag, even and odd.
    within: Vec<N>,
    /// Tiles with odd parts: short waves have none.
    turning: Vec<bool>,
    stages: usize,
    /// Instants of a block.
    instants: usize,
    /// Forces \[N\] at the instants of the block before and of this one, tile by tile, instant by instant.
    forces: Vec<N>,
    /// Displacements \[m\] at the instants of this block and of the next one, as foretold from the blocks before the
    /// last, and before this one; likewise.
    foretold: Vec<N>,
    /// True if the later one of two blocks stands first.
    pub turned: bool,
    /// Displacements by all forces but the last at the coming instant, and by all but two at the one after it \[m\]:
    /// those of two instants are found together, which reads forces and weights once. Tile by tile.
    sums: Vec<N>,
    /// Forces of the blocks that are not forgotten yet, block by block, tile by tile; none where nothing ever is.
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
        let (instants, tiles) = (steps * stages, waves.div_ceil(tile::<N>()));
        let reduced = |wave: usize| fewer_poles(&model.modes(wave), rule, time_step, steps, fewer?);
        let reduced: Vec<Option<FewerPoles>> = (0..waves).into_par_iter().map(reduced).collect();
        let modes = |wave: usize| reduced[wave].as_ref().map_or(model.modes(wave), FewerPoles::modes);
        let group_of = |first: usize, count: usize| {
            // The coming block is passed over: it is under way while the next is foretold.
            (first..waves.min(first + count)).map(modes)
        };
        let allowed = fewer.map_or(ROUNDED, |tolerance| ROUNDED.max(ROUNDED_OF_TOLERANCE * tolerance));
        let (mut groups, mut precise) = (Vec::new(), Vec::new());
        for first in (0..waves).step_by(N::MOST_LANES) {
            let modes = group_of(first, N::MOST_LANES);
            if N::EPSILON > f64::EPSILON && modes.clone().any(|modes| is_slow(&modes, time_step, allowed)) {
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
            remembered = vec![vec![0.0; tiles * 2 * instants * tile::<N>()]; blocks];
        }
        let turns = |tile: usize| waves_of::<N>(tile, waves).any(|wave| !model.modes(wave).odd.is_empty());
        let turning: Vec<bool> = (0..tiles).map(turns).collect();
        let within = responses(model, rule, time_step, instants, &turning);
        let mut work = Work::default();
        groups.iter().for_each(|group| work += group.work());
        precise.iter().for_each(|group| work += group.work());
        // Every instant sees the block before and half of the others of its own.
        let summed: usize = turning.iter().map(|&turns| tile::<N>() * kinds(turns)).sum();
        let products = (instants * (3 * instants - 1) * summed) as u64;
        work += Work { multiply_adds: products, bytes: 12 * products };
        let zeros = |instants: usize| vec![N::default(); tiles * 2 * instants * tile::<N>()];
        Self {
            groups,
            precise,
            within,
            turning,
            stages,
            instants,
            forces: zeros(2 * instants),
            foretold: zeros(2 * instants),
            turned: false,
            sums: zeros(2),
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

    /// Takes the forces of an instant of the block.
    pub fn take_forces(&mut self, instant: usize, forces: &[Complex<N>]) {
        let (size, instants) = (tile::<N>(), self.instants);
        let place = slot(instants + instant, instants, self.turned);
        let tiles = self.forces.chunks_exact_mut(4 * instants * size);
        for (tile, forces) in tiles.zip(forces.chunks(size)) {
            let (re, im) = tile[2 * size * place..][..2 * size].split_at_mut(size);
            for ((re, im), force) in re.iter_mut().zip(im).zip(forces) {
                (*re, *im) = (force.re, force.im);
            }
        }
    }

    /// A block begins.
    pub fn turn(&mut self) {
        self.turned = !self.turned;
    }

    /// Gives the displacements at an instant of the block, completed by those of the last forces.
    pub fn finish(&mut self, instant: usize, displacement: &mut [Complex<N>]) {
        let now = self.instants + instant;
        self.add_forces(now, now - 1..now, false);
        let size = tile::<N>();
        for (sums, out) in self.sums.chunks_exact(4 * size).zip(displacement.chunks_mut(size)) {
            let (re, im) = sums[..2 * size].split_at(size);
            for (out, (re, im)) in out.iter_mut().zip(re.iter().zip(im)) {
                *out = Complex::new(*re, *im);
            }
        }
    }

    /// Adds what the forces of earlier instants do now, and where both are wanted at the next instant, all counted from
    /// the block before.
    fn add_forces(&mut self, now: usize, earlier: Range<usize>, both: bool) {
        let Self { within, turning, forces, sums, instants, stages, turned, arch, .. } = self;
        let (instants, stages, turned) = (*instants, *stages, *turned);
        arch.dispatch(Weighted { sums, within, turning, forces, instants, stages, turned, now, earlier, both });
    }

    /// Does the work behind the march at an instant: a part of the pass, and the sum for the next instant.
    fn go_on<R: Recursion>(&mut self, instant: usize, recursion: R) {
        let Self { groups, precise, instants, forces, foretold, turned, remembered, earliest, arch, .. } = self;
        let (instants, turned, size) = (*instants, *turned, tile::<N>());
        let of_tile = 2 * instants * size;
        let old = remembered.get(*earliest).map_or(&[][..], Vec::as_slice);
        let mut block = Block { arch: *arch, recursion, instants, turned, forces, old, foretold };
        let share = |groups: usize| instant * groups / instants..(instant + 1) * groups / instants;
        let (own, slow) = (share(groups.len()), share(precise.len()));
        groups[own].iter_mut().for_each(|group| block.pass(group));
        precise[slow].iter_mut().for_each(|group| block.pass(group));
        if instant + 1 == instants
            && let Some(old) = remembered.get_mut(*earliest)
        {
            let first = 2 * size * slot(0, instants, turned);
            let last = forces.chunks_exact(2 * of_tile).map(|tile| &tile[first..][..of_tile]);
            for (old, last) in old.chunks_exact_mut(of_tile).zip(last) {
                old.iter_mut().zip(last).for_each(|(old, force)| *old = force.double() as f32);
            }
            *earliest = (*earliest + 1) % remembered.len();
        }
        let now = instants + instant + 1;
        if instant % 2 == 1 || instants % 2 == 1 {
            let both = instants.is_multiple_of(2);
            let places = [1, 2].map(|later| slot((instant + later) % (2 * instants), instants, turned));
            for (sums, foretold) in self.sums.chunks_exact_mut(4 * size).zip(self.foretold.chunks_exact(2 * of_tile)) {
                for (sum, place) in sums.chunks_exact_mut(2 * size).zip(places) {
                    sum.copy_from_slice(&foretold[2 * size * place..][..2 * size]);
                }
            }
            // The pass has taken in the block before; the next one is told without it.
            let first = if instant + 1 == instants { instants } else { 0 };
            self.add_forces(now, first..now - 1, both);
        } else {
            for sums in self.sums.chunks_exact_mut(4 * size) {
                sums.copy_within(2 * size.., 0);
            }
            self.add_forces(now, now - 2..now - 1, false);
        }
    }

    /// Fields that evolve.
    pub fn fields(&self) -> [&Vec<N>; 3] {
        [&self.sums, &self.forces, &self.foretold]
    }

    /// As [`Self::fields`], to be changed.
    pub fn fields_mut(&mut self) -> [&mut Vec<N>; 3] {
        [&mut self.sums, &mut self.forces, &mut self.foretold]
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

/// Waves of a tile.
const fn tile<N: Element>() -> usize {
    TOGETHER * N::MOST_LANES
}

/// The waves of a tile, of so many in all.
fn waves_of<N: Element>(number: usize, waves: usize) -> Range<usize> {
    let first = number * tile::<N>();
    first..waves.min(first + tile::<N>())
}

/// Place of an instant of two blocks, counted from the first of the block before.
const fn slot(number: usize, instants: usize, turned: bool) -> usize {
    if turned { (number + instants) % (2 * instants) } else { number }
}

/// Input and output of a pass.
struct Block<'a, N, R> {
    arch: Arch,
    recursion: R,
    instants: usize,
    turned: bool,
    /// Forces of the last block and of this one.
    forces: &'a [N],
    /// Those that are forgotten.
    old: &'a [f32],
    /// Displacements in this block and in the coming one.
    foretold: &'a mut [N],
}

impl<N: Element, R: Recursion> Block<'_, N, R> {
    fn pass<E: Element>(&mut self, group: &mut WavenumberGroup<E>) {
        let (size, instants, waves) = (tile::<N>(), self.instants, group.wavenumbers());
        let (tile, own) = (waves.start / size, waves.start % size..waves.start % size + waves.len());
        let parts = |instant: usize| {
            [0, size].map(|part| 2 * size * instant + part + own.start..).map(|from| from.start..from.start + own.len())
        };
        let of_tile = 2 * instants * size;
        let forces = &self.forces[2 * of_tile * tile..][..2 * of_tile];
        for instant in 0..instants {
            let places = parts(slot(instant, instants, self.turned));
            for (own, part) in group.forces_mut(instant).into_iter().zip(places) {
                own.iter_mut().zip(&forces[part]).for_each(|(own, force)| *own = E::rounded(force.double()));
            }
        }
        if let Some(old) = self.old.get(of_tile * tile..of_tile * (tile + 1)) {
            for instant in 0..instants {
                for (own, part) in group.old_forces_mut(instant).into_iter().zip(parts(instant)) {
                    own.iter_mut().zip(&old[part]).for_each(|(own, force)| *own = E::rounded((*force).into()));
                }
            }
        }
        pass(group, self.arch, self.recursion);
        let foretold = &mut self.foretold[2 * of_tile * tile..][..2 * of_tile];
        for instant in 0..instants {
            let places = parts(slot(instants + instant, instants, self.turned));
            for (part, own) in places.into_iter().zip(group.displacement_parts(instant)) {
                let out = &mut foretold[part];
                out.iter_mut().zip(own).for_each(|(out, own)| *out = N::rounded(own.double()));
            }
        }
    }
}

/// Part of a wave's static displacement that rounding its poles to single precision may be, where none is left out.
const ROUNDED: f64 = 2e-6;
/// The same in parts of the tolerance to which some are left out.
const ROUNDED_OF_TOLERANCE: f64 = 0.1;

/// Tells waves whose poles single precision would move too far: of a pole that decays by d a step it changes the static
/// displacement by its rounding over d.
fn is_slow(modes: &Modes<'_>, time_step: f64, allowed: f64) -> bool {
    let (mut all, mut moved) = (0.0_f64, 0.0);
    for (index, (pole, residue)) in modes.poles.iter().zip(modes.residues).enumerate() {
        let part = (modes.multiplicity(index) * residue / pole).re;
        all += part;
        moved += part.abs() * 0.5 * f64::from(f32::EPSILON) / (pole.norm() * time_step);
    }
    moved > allowed * all.abs()
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

/// Kinds of a tile's parts: even ones alone, or odd ones too.
const fn kinds(turns: bool) -> usize {
    if turns { 2 } else { 1 }
}

/// Response of all waves one, two, ... instants after a force at a stage, as they are summed; see [`RingWaves`].
fn responses<N: Element>(
    model: &CellModel,
    rule: TimeRule,
    time_step: f64,
    instants: usize,
    turning: &[bool],
) -> Vec<N> {
    let (stages, lags, size) = (rule.stages(), 2 * instants - 1, tile::<N>());
    let of_tile = |turns: &bool| stages * lags * kinds(*turns) * size;
    let mut within = vec![N::default(); turning.iter().map(of_tile).sum()];
    let mut response = vec![0.0; lags];
    let mut rest = within.as_mut_slice();
    for (tile, turns) in turning.iter().enumerate() {
        let (own, others) = rest.split_at_mut(of_tile(turns));
        rest = others;
        for wave in waves_of::<N>(tile, model.len()) {
            let modes = model.modes(wave);
            for (kind, residues) in [modes.residues, modes.odd].into_iter().enumerate().take(kinds(*turns)) {
                for stage in 0..stages {
                    response.fill(0.0);
                    for (index, (&pole, &residue)) in modes.poles.iter().zip(residues).enumerate() {
                        let weights = rule.coefficients(pole, modes.multiplicity(index) * residue, time_step);
                        rule.impulse_response(weights.into(), stage, &mut response);
                    }
                    for (lag, value) in response.iter().enumerate() {
                        own[((stage * lags + lag) * kinds(*turns) + kind) * size + wave % size] = N::rounded(*value);
                    }
                }
            }
        }
    }
    within
}

/// Adds what forces do: weight times force, and i times odd weight times force.
struct Weighted<'a, N> {
    sums: &'a mut [N],
    within: &'a [N],
    turning: &'a [bool],
    forces: &'a [N],
    instants: usize,
    stages: usize,
    turned: bool,
    now: usize,
    earlier: Range<usize>,
    both: bool,
}

impl<N: Element> WithSimd for Weighted<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        // As many sums as there are registers for.
        match (N::lanes::<S>() == N::MOST_LANES, self.both) {
            (true, false) => self.add::<S, 1, 4>(simd),
            (true, true) => self.add::<S, 2, 4>(simd),
            (false, false) => self.add::<S, 1, 2>(simd),
            (false, true) => self.add::<S, 2, 2>(simd),
        }
    }
}

impl<N: Element> Weighted<'_, N> {
    /// Adds to the sums of so many instants.
    #[inline(always)]
    fn add<S: Simd, const INSTANTS: usize, const VECTORS: usize>(mut self, simd: S) {
        let of_field = tile::<N>() / N::lanes::<S>();
        let sums = N::vectors_mut::<S>(std::mem::take(&mut self.sums)).chunks_exact_mut(4 * of_field);
        let forces = N::vectors::<S>(self.forces).chunks_exact(4 * self.instants * of_field);
        let mut within = N::vectors::<S>(self.within);
        for ((sums, forces), &turns) in sums.zip(forces).zip(self.turning) {
            let (own, others) = within.split_at(self.stages * (2 * self.instants - 1) * kinds(turns) * of_field);
            within = others;
            if turns {
                self.add_tile::<S, INSTANTS, VECTORS, true>(simd, sums, own, forces);
            } else {
                self.add_tile::<S, INSTANTS, VECTORS, false>(simd, sums, own, forces);
            }
        }
    }

    #[inline(always)]
    fn add_tile<S: Simd, const INSTANTS: usize, const VECTORS: usize, const TURNS: bool>(
        &self,
        simd: S,
        sums: &mut [N::Vector<S>],
        within: &[N::Vector<S>],
        forces: &[N::Vector<S>],
    ) {
        let Self { instants, stages, turned, now, .. } = *self;
        let (lags, of_field) = (2 * instants - 1, tile::<N>() / N::lanes::<S>());
        for first in (0..of_field).step_by(VECTORS) {
            let mut totals = [[[N::splat(simd, N::default()); VECTORS]; 2]; INSTANTS];
            for (instant, total) in totals.iter_mut().enumerate() {
                for (part, total) in total.iter_mut().enumerate() {
                    total.copy_from_slice(&sums[(2 * instant + part) * of_field + first..][..VECTORS]);
                }
            }
            for number in self.earlier.clone() {
                let force = &forces[2 * of_field * slot(number, instants, turned) + first..];
                let (re, im) = (&force[..VECTORS], &force[of_field..][..VECTORS]);
                for (instant, [total_re, total_im]) in totals.iter_mut().enumerate() {
                    let row = number % stages * lags + now + instant - number - 1;
                    let weights = &within[row * kinds(TURNS) * of_field + first..];
                    for v in 0..VECTORS {
                        total_re[v] = N::mul_add(simd, weights[v], re[v], total_re[v]);
                        total_im[v] = N::mul_add(simd, weights[v], im[v], total_im[v]);
                    }
                    if TURNS {
                        let odd = &weights[of_field..][..VECTORS];
                        for v in 0..VECTORS {
                            total_re[v] = N::negate_mul_add(simd, odd[v], im[v], total_re[v]);
                            total_im[v] = N::mul_add(simd, odd[v], re[v], total_im[v]);
                        }
                    }
                }
            }
            for (instant, total) in totals.iter().enumerate() {
                for (part, total) in total.iter().enumerate() {
                    sums[(2 * instant + part) * of_field + first..][..VECTORS].copy_from_slice(total);
                }
            }
        }
    }
}
