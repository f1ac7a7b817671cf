//! Waves of one ring: at each instant a part of the pass over all poles, and the sum of the displacements by all but
//! the last forces at the next instant.
//!
//! With rotation, u_n = E_n F_n + i O_n F_n, n >= 0, with E and O as operators in time: real, over the same poles.

use std::ops::Range;

use num_complex::{Complex, Complex64};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use super::fewer_poles::FewerPoles;
use super::wave_transform::{WaveNumber, WaveTransform};
use crate::contact::history::add_responses;
use crate::contact::history::block_pass::pass;
use crate::contact::history::wavenumber_group::WavenumberGroup;
use crate::counters::Work;
use crate::numeric::Element;
use crate::storage::state::{Evolving, StateError, StateStream, ensure};
use crate::time_rule::recursion::Recursion;
use crate::time_rule::{Advance, TimeRule};
use crate::tyre::influence::{CellInfluence, WaveValues};
use crate::tyre::poles::WaveModes;
use crate::tyre::poles::pole_model::PoleModel;

/// Widest vectors of a tile: its rows are long enough for the processor to read ahead, and some fit into its nearest
/// memory together. Odd: rows a power of two apart would take each other's places there.
const TOGETHER: usize = 31;

/// One ring: the waves that it carries.
pub struct RingParts<'m, N: WaveNumber = f64> {
    /// Their poles.
    pub model: &'m PoleModel,
    /// From cells to waves and back.
    pub transform: WaveTransform<N>,
    /// Influence of each stage's forces at the next instant between the cells that the transform covers, a part of the
    /// window, by [`first_influences`](super::history::first_influences); `None`: it covers all of the window.
    pub next_instant: Option<Vec<CellInfluence>>,
    /// Steps after which forces are forgotten, of which whole blocks count, one at least; `None`: never. On a ring
    /// shorter than the tyre the window comes back to where it was, and slowly recovering deformation would still be
    /// there.
    pub forgotten_after: Option<usize>,
    /// How far the window moves on in a step.
    pub advance: Advance,
    /// Fewer poles that predict displacements by forces older than a block; `None`: none is left out.
    pub fewer_poles: Option<FewerPoles>,
}

/// The waves of one ring, in tiles of [`tile`] neighbours. Of a complex field a tile has the real parts first, then the
/// imaginary parts; all that is summed for a tile stands together, so that it is read as one stream.
pub(super) struct RingWaves<N> {
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
    /// Displacements \[m\] at the instants of this block and of the next one, as predicted from the blocks before the
    /// last, and before this one; likewise.
    predicted: Vec<N>,
    /// True if the later one of two blocks stands first.
    turned: bool,
    /// Displacements by all forces but the last at the coming instant, and by all but two at the one after it \[m\]:
    /// those of two instants are found together, which reads forces and weights once. Tile by tile.
    sums: Vec<N>,
    /// Forces of the blocks that are not forgotten yet, block by block, group by group; none where nothing ever is.
    remembered: Vec<Vec<f32>>,
    /// The earliest block of them, which is forgotten next.
    earliest: usize,
    work: Work,
    arch: Arch,
}

impl<N: WaveNumber> RingWaves<N> {
    /// Waves at rest, for blocks of `steps` steps. A short ring leaves the displacements by the last forces to others.
    pub(super) fn new(parts: &RingParts<'_, N>, rule: TimeRule, time_step: f64, steps: usize) -> Self {
        let RingParts { model, transform, advance, fewer_poles: fewer, .. } = parts;
        let (waves, stages) = (model.len(), rule.stages());
        let (instants, tiles) = (steps * stages, waves.div_ceil(tile::<N>()));
        let predicting = fewer.as_ref().and_then(|fewer| fewer.model.as_ref()).unwrap_or(model);
        let modes = |wave: usize| predicting.wave(wave);
        let allowed = allowed_rounding(fewer.as_ref().map(|fewer| fewer.tolerance));
        let angles = transform.angles();
        // A deformation at rest on the road moves through the tyre with the window.
        let rate = |wave: usize| angles[wave] / advance.time_of_element(time_step);
        let [fast, slow] = by_precision::<N>(waves, |wave| is_slow(&modes(wave), time_step, rate(wave), allowed));
        let group =
            |range: Range<usize>| WavenumberGroup::new(range.start, range.map(modes), rule, time_step, instants);
        let mut groups: Vec<WavenumberGroup<N>> = fast.into_iter().map(group).collect();
        let group =
            |range: Range<usize>| WavenumberGroup::new(range.start, range.map(modes), rule, time_step, instants);
        let mut precise: Vec<WavenumberGroup<f64>> = slow.into_iter().map(group).collect();
        let mut remembered = Vec::new();
        if let Some(after) = parts.forgotten_after {
            let blocks = (after / steps).max(1);
            groups.par_iter_mut().for_each(|group| group.forget(rule, blocks * steps));
            precise.par_iter_mut().for_each(|group| group.forget(rule, blocks * steps));
            remembered = vec![vec![0.0; tiles * 2 * instants * tile::<N>()]; blocks];
        }
        let turns = |tile: usize| waves_of::<N>(tile, waves).any(|wave| !model.wave(wave).odd.is_empty());
        let turning: Vec<bool> = (0..tiles).map(turns).collect();
        let within = responses(model, rule, time_step, instants, &turning);
        let mut work = Work::default();
        groups.iter().for_each(|group| work += group.work());
        precise.iter().for_each(|group| work += group.work());
        // Every instant sums the previous block and half of the others of its block.
        let summed: usize = turning.iter().map(|&turns| tile::<N>() * kinds(turns)).sum();
        let of_instant = 3 * instants - if parts.next_instant.is_some() { 3 } else { 1 };
        let products = (instants * of_instant * summed) as u64;
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
            predicted: zeros(2 * instants),
            turned: false,
            sums: zeros(2),
            remembered,
            earliest: 0,
            work,
            arch: Arch::new(),
        }
    }

    pub(super) fn work(&self) -> Work {
        self.work
    }

    pub(super) fn take_forces(&mut self, instant: usize, forces: &[Complex<N>]) {
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

    /// Begins a block.
    pub(super) fn turn(&mut self) {
        self.turned = !self.turned;
    }

    /// Completes the displacements at an instant of the block by those due to the last forces.
    pub(super) fn finish(&mut self, instant: usize) {
        let now = self.instants + instant;
        self.add_forces(now, now - 1..now, false);
    }

    /// Writes the displacements at the coming instant as far as they are known.
    pub(super) fn displacement(&self, displacement: &mut [Complex<N>]) {
        let size = tile::<N>();
        for (sums, out) in self.sums.chunks_exact(4 * size).zip(displacement.chunks_mut(size)) {
            let (re, im) = sums[..2 * size].split_at(size);
            for (out, (re, im)) in out.iter_mut().zip(re.iter().zip(im)) {
                *out = Complex::new(*re, *im);
            }
        }
    }

    /// Adds the displacements by the forces of earlier instants at `now`, and with `both` at the next instant; all are
    /// counted from the beginning of the previous block.
    fn add_forces(&mut self, now: usize, earlier: Range<usize>, both: bool) {
        let Self { within, turning, forces, sums, instants, stages, turned, arch, .. } = self;
        let (instants, stages, turned) = (*instants, *stages, *turned);
        arch.dispatch(Weighted { sums, within, turning, forces, instants, stages, turned, now, earlier, both });
    }

    /// Does the work in the background at an instant: a part of the pass, and the sum for the next instant.
    pub(super) fn advance<R: Recursion>(&mut self, instant: usize, recursion: R) {
        let Self { groups, precise, instants, forces, predicted, turned, remembered, earliest, arch, .. } = self;
        let (instants, turned, size) = (*instants, *turned, tile::<N>());
        let of_tile = 2 * instants * size;
        let old = remembered.get_mut(*earliest).map_or(&mut [][..], Vec::as_mut_slice);
        let mut block = Block { arch: *arch, recursion, instants, turned, forces, old, predicted };
        // 1. Share of the groups that the pass takes at this instant.
        let share = |groups: usize| instant * groups / instants..(instant + 1) * groups / instants;
        let (fast, slow) = (share(groups.len()), share(precise.len()));
        groups[fast].iter_mut().for_each(|group| block.pass(group));
        precise[slow].iter_mut().for_each(|group| block.pass(group));
        if instant + 1 == instants && !remembered.is_empty() {
            *earliest = (*earliest + 1) % remembered.len();
        }
        // 2. Displacements at the next instant, of two instants at once where a block has an even number of them.
        let now = instants + instant + 1;
        if instant % 2 == 1 || instants % 2 == 1 {
            let both = instants.is_multiple_of(2);
            let places = [1, 2].map(|later| slot((instant + later) % (2 * instants), instants, turned));
            for (sums, predicted) in self.sums.chunks_exact_mut(4 * size).zip(self.predicted.chunks_exact(2 * of_tile))
            {
                for (sum, place) in sums.chunks_exact_mut(2 * size).zip(places) {
                    sum.copy_from_slice(&predicted[2 * size * place..][..2 * size]);
                }
            }
            // The pass has taken in the previous block; the next one is predicted without it.
            let first = if instant + 1 == instants { instants } else { 0 };
            self.add_forces(now, first..now - 1, both);
        } else {
            for sums in self.sums.chunks_exact_mut(4 * size) {
                sums.copy_within(2 * size.., 0);
            }
            self.add_forces(now, now - 2..now - 1, false);
        }
    }
}

impl<N: WaveNumber> Evolving for RingWaves<N> {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        state.all([&mut self.sums, &mut self.forces, &mut self.predicted, &mut self.turned])?;
        state.all([&mut self.remembered, &mut self.earliest, &mut self.groups, &mut self.precise])?;
        ensure(self.earliest < self.remembered.len().max(1))
    }
}

/// Number of waves in a tile.
const fn tile<N: Element>() -> usize {
    TOGETHER * N::MOST_LANES
}

/// Waves of a tile, `waves` being their number in all.
fn waves_of<N: Element>(number: usize, waves: usize) -> Range<usize> {
    let first = number * tile::<N>();
    first..waves.min(first + tile::<N>())
}

/// Place of an instant of two blocks, counted from the first of the previous block.
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
    /// Forces that are forgotten, group by group; those of the last block take their place.
    old: &'a mut [f32],
    /// Displacements in this block and in the coming one.
    predicted: &'a mut [N],
}

impl<N: Element, R: Recursion> Block<'_, N, R> {
    fn pass<E: Element>(&mut self, group: &mut WavenumberGroup<E>) {
        let (size, instants, first) = (tile::<N>(), self.instants, group.wavenumbers().start);
        let (tile, offset) = (first / size, first % size);
        // Tiles are whole groups: behind the last wave there are zeros.
        let part = |instant: usize, part: usize| {
            let first = 2 * size * instant + part * size + offset;
            first..first + E::MOST_LANES
        };
        let of_tile = 2 * instants * size;
        let forces = &self.forces[2 * of_tile * tile..][..2 * of_tile];
        for (instant, pair) in group.forces.chunks_exact_mut(2 * E::MOST_LANES).enumerate() {
            let place = slot(instant, instants, self.turned);
            for (number, values) in pair.chunks_exact_mut(E::MOST_LANES).enumerate() {
                copy(&forces[part(place, number)], values, |force| E::rounded(force.double()));
            }
        }
        let lanes = N::MOST_LANES;
        let of_group = 2 * instants * lanes;
        if let Some(old) = self.old.get_mut(first / lanes * of_group..).and_then(|old| old.get_mut(..of_group)) {
            let rows = old.chunks_exact_mut(lanes).zip(group.old_forces.chunks_exact_mut(E::MOST_LANES));
            for (row, (old, values)) in rows.enumerate() {
                let old = &mut old[first % lanes..][..E::MOST_LANES];
                copy(old, values, |force| E::rounded(force.into()));
                let place = slot(row / 2, instants, self.turned);
                copy(&forces[part(place, row % 2)], old, |force| force.double() as f32);
            }
        }
        pass(group, self.arch, self.recursion);
        let predicted = &mut self.predicted[2 * of_tile * tile..][..2 * of_tile];
        for (instant, pair) in group.displacement.chunks_exact(2 * E::MOST_LANES).enumerate() {
            let place = slot(instants + instant, instants, self.turned);
            for (number, values) in pair.chunks_exact(E::MOST_LANES).enumerate() {
                copy(values, &mut predicted[part(place, number)], |displacement| N::rounded(displacement.double()));
            }
        }
    }
}

/// Copies the numbers of a group, in pieces of a known length.
#[inline(always)]
fn copy<A: Copy, B: Copy>(from: &[A], to: &mut [B], number: impl Fn(A) -> B) {
    const PIECE: usize = 8;
    for (from, to) in from.as_chunks::<PIECE>().0.iter().zip(to.as_chunks_mut::<PIECE>().0) {
        // Read before any is written, so that the compiler may take them together.
        let from = *from;
        for place in 0..PIECE {
            to[place] = number(from[place]);
        }
    }
}

/// Part of a wave's displacement by a force at rest on the road that rounding its poles to single precision may make,
/// where no poles are left out.
const ROUNDED: f64 = 2e-6;
/// The same in parts of the tolerance to which some are left out.
const ROUNDED_OF_TOLERANCE: f64 = 0.1;

/// Part of a wave's displacement that rounding its poles may make, for poles to within a tolerance.
pub(in crate::contact) fn allowed_rounding(tolerance: Option<f64>) -> f64 {
    tolerance.map_or(ROUNDED, |tolerance| ROUNDED.max(ROUNDED_OF_TOLERANCE * tolerance))
}

/// Waves of neighbours that are a group: those that are fast enough for the precision of `N`, and the others, in groups
/// of double precision.
pub(in crate::contact) fn by_precision<N: Element>(
    waves: usize,
    is_slow: impl Fn(usize) -> bool + Sync,
) -> [Vec<Range<usize>>; 2] {
    let groups_of = |waves: Range<usize>, most: usize| {
        waves.clone().step_by(most).map(move |first| first..waves.end.min(first + most))
    };
    let needs_double = |group: &Range<usize>| N::EPSILON > f64::EPSILON && group.clone().any(&is_slow);
    let all: Vec<Range<usize>> = groups_of(0..waves, N::MOST_LANES).collect();
    let (slow, fast): (Vec<_>, Vec<_>) = all.into_par_iter().partition(needs_double);
    [fast, slow.into_iter().flat_map(|group| groups_of(group, f64::MOST_LANES)).collect()]
}

/// True if single precision would move a wave's poles too far: for a pole that decays by d a step it changes the
/// displacement by its rounding over |d + i phi|, phi the phase by which a force at rest on the road moves on in a
/// step; `rate` is that phase over the time step \[rad/s\].
pub(in crate::contact) fn is_slow(modes: &WaveModes<'_>, time_step: f64, rate: f64, allowed: f64) -> bool {
    let s = Complex64::new(0.0, rate);
    let mut moved = 0.0;
    for (index, (pole, residue)) in modes.poles.iter().zip(modes.residues).enumerate() {
        let pairs = [(*pole, *residue), (pole.conj(), residue.conj())];
        for (pole, residue) in pairs.into_iter().take(if index < modes.pairs { 2 } else { 1 }) {
            let distance = (s - pole).norm();
            moved += residue.norm() / distance * 0.5 * f64::from(f32::EPSILON) / (distance * time_step);
        }
    }
    moved > allowed * modes.evaluate(s).norm()
}

/// Number of kinds of a tile's parts: even ones alone, or odd ones too.
const fn kinds(turns: bool) -> usize {
    if turns { 2 } else { 1 }
}

/// Response of all waves an instant after a force, stage by stage \[m/N\].
pub(super) fn first_responses(model: &PoleModel, rule: TimeRule, time_step: f64) -> Vec<WaveValues> {
    let mut all = vec![WaveValues { even: Vec::new(), odd: Vec::new() }; rule.stages()];
    let mut responses = vec![0.0; rule.stages()];
    for modes in (0..model.len()).map(|wave| model.wave(wave)) {
        for (kind, residues) in [modes.residues, modes.odd].into_iter().enumerate().take(kinds(model.turns())) {
            responses.fill(0.0);
            add_responses(&modes, residues, rule, time_step, 1, &mut responses);
            for (values, &response) in all.iter_mut().zip(&responses) {
                let of_kind = if kind == 0 { &mut values.even } else { &mut values.odd };
                of_kind.push(response);
            }
        }
    }
    all
}

/// Response of all waves one, two, ... instants after a force at a stage \[m/N\], in the order in which it is summed;
/// see [`RingWaves`].
fn responses<N: Element>(
    model: &PoleModel,
    rule: TimeRule,
    time_step: f64,
    instants: usize,
    turning: &[bool],
) -> Vec<N> {
    let (stages, lags, size) = (rule.stages(), 2 * instants - 1, tile::<N>());
    let of_tile = |turns: &bool| stages * lags * kinds(*turns) * size;
    let mut within = vec![N::default(); turning.iter().map(of_tile).sum()];
    let mut responses = vec![0.0; stages * lags];
    let mut rest = within.as_mut_slice();
    for (tile, turns) in turning.iter().enumerate() {
        let (tile_responses, others) = rest.split_at_mut(of_tile(turns));
        rest = others;
        for wave in waves_of::<N>(tile, model.len()) {
            let modes = model.wave(wave);
            for (kind, residues) in [modes.residues, modes.odd].into_iter().enumerate().take(kinds(*turns)) {
                responses.fill(0.0);
                add_responses(&modes, residues, rule, time_step, lags, &mut responses);
                for (row, value) in responses.iter().enumerate() {
                    tile_responses[(row * kinds(*turns) + kind) * size + wave % size] = N::rounded(*value);
                }
            }
        }
    }
    within
}

/// Adds the displacements by forces: weight times force, and i times odd weight times force.
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
        if self.both { self.add::<S, 2>(simd) } else { self.add::<S, 1>(simd) }
    }
}

impl<N: Element> Weighted<'_, N> {
    /// Adds to the sums of `INSTANTS` instants.
    #[inline(always)]
    fn add<S: Simd, const INSTANTS: usize>(mut self, simd: S) {
        let of_field = tile::<N>() / N::lanes::<S>();
        let sums = N::vectors_mut::<S>(std::mem::take(&mut self.sums)).chunks_exact_mut(4 * of_field);
        let forces = N::vectors::<S>(self.forces).chunks_exact(4 * self.instants * of_field);
        let mut within = N::vectors::<S>(self.within);
        for ((sums, forces), &turns) in sums.zip(forces).zip(self.turning) {
            let (responses, others) = within.split_at(self.stages * (2 * self.instants - 1) * kinds(turns) * of_field);
            within = others;
            // Four forces at a time, so that sums are read and written a fourth as often.
            let mut number = self.earlier.start;
            while number < self.earlier.end {
                let remaining = self.earlier.end - number;
                match (remaining >= 4, turns) {
                    (true, true) => self.add_forces::<S, INSTANTS, 4, true>(simd, sums, responses, forces, number),
                    (true, false) => self.add_forces::<S, INSTANTS, 4, false>(simd, sums, responses, forces, number),
                    (false, true) => self.add_forces::<S, INSTANTS, 1, true>(simd, sums, responses, forces, number),
                    (false, false) => self.add_forces::<S, INSTANTS, 1, false>(simd, sums, responses, forces, number),
                }
                number += if remaining >= 4 { 4 } else { 1 };
            }
        }
    }

    /// Adds the displacements by `FORCES` forces from `first` on to a tile.
    #[inline(always)]
    fn add_forces<S: Simd, const INSTANTS: usize, const FORCES: usize, const TURNS: bool>(
        &self,
        simd: S,
        sums: &mut [N::Vector<S>],
        within: &[N::Vector<S>],
        forces: &[N::Vector<S>],
        first: usize,
    ) {
        let Self { instants, stages, turned, now, .. } = *self;
        let (lags, of_field) = (2 * instants - 1, tile::<N>() / N::lanes::<S>());
        let force = |number: usize| &forces[2 * of_field * slot(first + number, instants, turned)..][..2 * of_field];
        let forces: [_; FORCES] = std::array::from_fn(force);
        let weights = |number: usize, instant: usize| {
            let row = (first + number) % stages * lags + now + instant - (first + number) - 1;
            &within[row * kinds(TURNS) * of_field..][..kinds(TURNS) * of_field]
        };
        let weights: [[_; INSTANTS]; FORCES] =
            std::array::from_fn(|number| std::array::from_fn(|instant| weights(number, instant)));
        for (instant, sums) in sums.chunks_exact_mut(2 * of_field).enumerate().take(INSTANTS) {
            let (sums_re, sums_im) = sums.split_at_mut(of_field);
            for v in 0..of_field {
                let (mut re, mut im) = (sums_re[v], sums_im[v]);
                for number in 0..FORCES {
                    let (weights, force) = (weights[number][instant], forces[number]);
                    let (force_re, force_im) = (force[v], force[of_field + v]);
                    re = N::mul_add(simd, weights[v], force_re, re);
                    im = N::mul_add(simd, weights[v], force_im, im);
                    if TURNS {
                        let odd = weights[of_field + v];
                        re = N::negate_mul_add(simd, odd, force_im, re);
                        im = N::mul_add(simd, odd, force_re, im);
                    }
                }
                (sums_re[v], sums_im[v]) = (re, im);
            }
        }
    }
}
