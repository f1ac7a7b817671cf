//! Wavenumbers side by side in the lanes of vectors: their poles, their states, and one pass over them per block of
//! instants.

use std::ops::Range;

use num_complex::Complex64;
use pulp::{Simd, WithSimd};

use crate::counters::Work;
use crate::numeric::lanes::dispatch;
use crate::numeric::{Element, largest_or_zero};
use crate::storage::state::{Evolving, StateError, StateStream};
use crate::time_rule::TimeRule;
use crate::time_rule::recursion::{MOST_STAGES, Number, PoleState, Poles, Recursion, WithRecursion};
use crate::tyre::poles::WaveModes;

/// Part of the remainder of a force in the slowest pole below which the others may keep theirs.
const FORGOTTEN: f64 = 1e-9;

/// Part of an odd residue as which a smaller even one counts: far below a rounding of the displacements by both.
const LEAST_EVEN: f64 = 1e-30;

/// Poles that a pass predicts together: u_old is read and written that much less often.
pub(super) const TOGETHER: usize = 2;

/// Poles of one kind, pairs (PARTS = 2) or real ones (1): the r-th of every wavenumber side by side. Wavenumbers with
/// fewer than their neighbours have poles that do nothing. All that a pass needs of [`TOGETHER`] poles stands together,
/// so that it reads one stream, a group's numbers of each:
/// 1. pole by pole g, then w, part by part;
/// 2. pole by pole q, the ratio of the odd residue to the even one, part by part; not at rest;
/// 3. pole by pole b of the last step, with a rule that looks back that of the one before too, under the real part of
///    the force, then the same under its imaginary part, part by part;
/// 4. pole by pole the remainder of a unit force at each instant of a step when it is forgotten, in the state's order;
///    only where forces are forgotten.
#[derive(Clone, Debug, Default)]
pub(super) struct PoleRows<E, const PARTS: usize> {
    pub(super) numbers: Vec<E>,
    pub(super) turns: bool,
    looks_back: bool,
    /// Numbers of a pole's remainder.
    remainder: usize,
    /// Which poles have a remainder that counts.
    pub(super) forgets: Vec<bool>,
}

/// Numbers, or vectors, of the poles that stand together, as described at [`PoleRows`].
pub(super) struct PoleRecord<'a, T> {
    pub(super) coefficients: &'a mut [T],
    pub(super) odd: &'a mut [T],
    pub(super) states: &'a mut [T],
    pub(super) remainder: &'a mut [T],
}

impl<E: Element, const PARTS: usize> PoleRows<E, PARTS> {
    /// Numbers of a pole that do not change.
    pub(super) const FIXED: usize = 2 * PARTS;
    /// Numbers of a pole that evolve.
    pub(super) const fn evolving(looks_back: bool) -> usize {
        if looks_back { 4 * PARTS } else { 2 * PARTS }
    }

    /// Numbers of each kind that a pole has.
    fn lengths(&self) -> [usize; 4] {
        [Self::FIXED, if self.turns { PARTS } else { 0 }, Self::evolving(self.looks_back), self.remainder]
    }

    /// Splits numbers, each of `of_number` elements, into records.
    #[inline(always)]
    pub(super) fn records<T>(
        lengths: [usize; 4],
        numbers: &mut [T],
        of_number: usize,
    ) -> impl Iterator<Item = PoleRecord<'_, T>> {
        let [fixed, odd, evolving, remainder] = lengths.map(|length| TOGETHER * length * of_number);
        numbers.chunks_exact_mut(fixed + odd + evolving + remainder).map(move |record| {
            let (coefficients, rest) = record.split_at_mut(fixed);
            let (odd, rest) = rest.split_at_mut(odd);
            let (states, remainder) = rest.split_at_mut(evolving);
            PoleRecord { coefficients, odd, states, remainder }
        })
    }

    /// Which poles have a remainder that counts, and the records as vectors.
    #[inline(always)]
    pub(super) fn vectors<S: Simd>(&mut self) -> (&[bool], impl Iterator<Item = PoleRecord<'_, E::Vector<S>>>) {
        let lengths = self.lengths();
        let numbers = E::vectors_mut::<S>(&mut self.numbers);
        (&self.forgets, Self::records(lengths, numbers, E::MOST_LANES / E::lanes::<S>()))
    }

    /// Rows from each wavenumber's g, w and q, without motion; of a tyre that `turns`, or at rest.
    fn new(wavenumbers: &[Vec<[Complex64; 3]>], looks_back: bool, turns: bool) -> Self {
        let poles = wavenumbers.iter().map(Vec::len).max().unwrap_or(0).next_multiple_of(TOGETHER);
        let mut this = Self { numbers: Vec::new(), turns, looks_back, remainder: 0, forgets: vec![false; poles] };
        let lengths = this.lengths();
        this.numbers = vec![E::default(); poles * lengths.iter().sum::<usize>() * E::MOST_LANES];
        for (first, record) in (0..).step_by(TOGETHER).zip(Self::records(lengths, &mut this.numbers, E::MOST_LANES)) {
            for (lane, channels) in wavenumbers.iter().enumerate() {
                for (index, &[g, w, q]) in channels.iter().skip(first).take(TOGETHER).enumerate() {
                    put_parts::<E, PARTS>(record.coefficients, index * Self::FIXED, lane, &[g, w]);
                    if turns {
                        put_parts::<E, PARTS>(record.odd, index * PARTS, lane, &[q]);
                    }
                }
            }
        }
        this
    }

    /// Finds the remainders of a unit force at each instant of a step `steps` steps later, and the poles in which they
    /// count.
    #[inline(always)]
    fn forget<S: Simd, R: Recursion>(&mut self, simd: S, recursion: R, steps: usize) {
        let (vectors, kinds) = (E::MOST_LANES / E::lanes::<S>(), Self::evolving(R::LOOKS_BACK) / (2 * PARTS));
        let known = Self::records(self.lengths(), &mut self.numbers, E::MOST_LANES);
        self.remainder = R::STAGES * kinds * PARTS;
        let mut wider = Self { numbers: Vec::new(), forgets: Vec::new(), ..*self };
        let lengths = wider.lengths();
        // 1. Wider rows, with space for the remainders.
        wider.numbers = vec![E::default(); self.forgets.len() * lengths.iter().sum::<usize>() * E::MOST_LANES];
        for (wide, known) in Self::records(lengths, &mut wider.numbers, E::MOST_LANES).zip(known) {
            wide.coefficients.copy_from_slice(known.coefficients);
            wide.odd.copy_from_slice(known.odd);
            wide.states.copy_from_slice(known.states);
        }
        let largest = |values: &[E]| values.iter().fold(0.0_f64, |largest, value| largest.max(value.double().abs()));
        let mut sizes = Vec::with_capacity(self.forgets.len());
        let of_pole = self.remainder * vectors;
        // 2. Remainder of a unit force at each stage, pole by pole.
        for PoleRecord { coefficients, remainder, .. } in wider.vectors::<S>().1 {
            let poles = coefficients.chunks_exact(Self::FIXED * vectors).zip(remainder.chunks_exact_mut(of_pole));
            for (coefficients, remainder) in poles {
                for vector in 0..vectors {
                    let maps = recursion.maps::<E, S, PARTS>(simd, Self::poles(simd, coefficients, vector, vectors));
                    for stage in 0..R::STAGES {
                        let zero = [E::splat(simd, E::default()); PARTS];
                        let mut states = [PoleState { end: zero, before: zero }; 2];
                        let mut forces = [E::splat(simd, E::default()); MOST_STAGES];
                        forces[stage] = E::splat(simd, E::rounded(1.0));
                        R::take_in(simd, &maps, forces, &mut states[0]);
                        let [state, other] = &mut states;
                        R::skip(simd, &maps, [state, other], steps);
                        for (kind, number) in [states[0].end, states[0].before].into_iter().enumerate().take(kinds) {
                            for (part, value) in number.into_iter().enumerate() {
                                remainder[((stage * kinds + kind) * PARTS + part) * vectors + vector] = value;
                            }
                        }
                    }
                }
            }
        }
        // 3. Poles whose remainder counts beside the largest one.
        for PoleRecord { odd, remainder, .. } in Self::records(lengths, &mut wider.numbers, E::MOST_LANES) {
            // Displacements by the odd part of a pole may be larger.
            let mut ratios = odd.chunks_exact(PARTS * E::MOST_LANES).map(|ratios| largest(ratios).max(1.0));
            let of_poles = remainder.chunks_exact(self.remainder * E::MOST_LANES);
            sizes.extend(of_poles.map(|remainder| largest(remainder) * ratios.next().unwrap_or(1.0)));
        }
        let scale = FORGOTTEN * largest_or_zero(&sizes);
        wider.forgets = sizes.iter().map(|size| *size > scale).collect();
        *self = wider;
    }

    /// States of the poles that stand together.
    fn states_mut(&mut self) -> impl Iterator<Item = &mut [E]> {
        Self::records(self.lengths(), &mut self.numbers, E::MOST_LANES).map(|record| record.states)
    }

    #[inline(always)]
    pub(super) fn poles<S: Simd>(
        simd: S,
        coefficients: &[E::Vector<S>],
        vector: usize,
        vectors: usize,
    ) -> Poles<E, S, PARTS> {
        let zero = [E::splat(simd, E::default()); PARTS];
        let mut poles = Poles::<E, S, PARTS> { g: zero, w: zero };
        for part in 0..PARTS {
            poles.g[part] = coefficients[part * vectors + vector];
            poles.w[part] = coefficients[(PARTS + part) * vectors + vector];
        }
        poles
    }

    /// Multiply-adds of a pass over `steps` steps: two real systems, R at every step taken in and at every one
    /// predicted, W and A at their stages, A of an odd part too, and the products of passing over a block.
    fn multiply_adds(&self, steps: usize, stages: usize, skip: usize) -> usize {
        self.forgets.len() * E::MOST_LANES * Self::multiply_adds_of_one(steps, stages, skip, self.turns)
    }

    /// Multiply-adds of one pole, a pair counted as one.
    const fn multiply_adds_of_one(steps: usize, stages: usize, skip: usize, turns: bool) -> usize {
        let odd = if turns { PARTS * stages } else { 0 };
        let of_step = 2 * (2 * PARTS * PARTS + PARTS * (2 * stages - 1) + odd);
        steps * of_step + skip * PARTS * PARTS
    }

    /// Bytes of a pass: coefficients read, states read and written.
    fn bytes(&self) -> usize {
        let [fixed, odd, evolving, _] = self.lengths();
        self.forgets.len() * (fixed + odd + 2 * evolving) * E::MOST_LANES * size_of::<E>()
    }

    /// q of a vector of poles.
    #[inline(always)]
    pub(super) fn ratios<S: Simd>(odd: &[E::Vector<S>], vector: usize) -> Number<E, S, PARTS> {
        let mut ratios = [odd[vector]; PARTS];
        for part in 1..PARTS {
            ratios[part] = odd[part * (E::MOST_LANES / E::lanes::<S>()) + vector];
        }
        ratios
    }
}

/// Writes numbers, of real ones (PARTS = 1) only the real parts, to a lane of a group's, part by part from `place` on.
pub(in crate::contact) fn put_parts<E: Element, const PARTS: usize>(
    group: &mut [E],
    place: usize,
    lane: usize,
    numbers: &[Complex64],
) {
    let parts = numbers.iter().flat_map(|number| [number.re, number.im].into_iter().take(PARTS));
    parts.zip(place..).for_each(|(part, place)| group[place * E::MOST_LANES + lane] = E::rounded(part));
}

/// Multiply-adds for each step that `poles` poles, conjugates counted, are expected to take in blocks of `steps`
/// steps: as if all were pairs. Real ones take less, and those that fill up a group take as much more (within 5 % of
/// the counts in runs). Of a tyre that `turns` odd parts come on top.
pub(crate) fn expected_multiply_adds(rule: TimeRule, steps: usize, wavenumbers: usize, poles: f64, turns: bool) -> f64 {
    let (skip, stages) = (rule.products_of_skip(steps), rule.stages());
    let pair = PoleRows::<f64, 2>::multiply_adds_of_one(steps, stages, skip, turns);
    let padded = wavenumbers.next_multiple_of(f64::MOST_LANES) as f64 / wavenumbers as f64;
    0.5 * poles * padded * pair as f64 / steps as f64
}

/// Residue that a state carries, and q, its ratio to which the odd one is.
fn carried(even: Complex64, odd: Complex64) -> [Complex64; 2] {
    if odd == Complex64::ZERO {
        return [even, odd];
    }
    let least = LEAST_EVEN * odd.norm();
    let even = if even.norm() < least { least.into() } else { even };
    [even, odd / even]
}

/// Neighbouring wavenumbers, as many as the widest vector has numbers.
#[derive(Clone, Debug)]
pub(crate) struct WavenumberGroup<E> {
    /// First wavenumber.
    first: usize,
    /// Wavenumbers in use.
    count: usize,
    pub(super) pairs: PoleRows<E, 2>,
    pub(super) reals: PoleRows<E, 1>,
    stages: usize,
    /// Steps between the forces taken in and the displacement predicted.
    pub(super) skipped: usize,
    /// Products of passing over them.
    skip: usize,
    /// Forces of the last block by instant: real parts of the group, imaginary parts.
    pub(crate) forces: Vec<E>,
    /// Those of the block that is forgotten likewise; empty: none is.
    pub(crate) old_forces: Vec<E>,
    /// u_old of the block predicted without the forces of those between, likewise.
    pub(crate) displacement: Vec<E>,
}

impl<E: Element> WavenumberGroup<E> {
    /// Group of neighbours from wavenumber `first` on, a group's at most, at rest, for blocks of `instants` instants. A
    /// pass leaves out the coming block, which is under way while the next is predicted.
    pub(crate) fn new<'m>(
        first: usize,
        modes: impl IntoIterator<Item = WaveModes<'m>>,
        rule: TimeRule,
        time_step: f64,
        instants: usize,
    ) -> Self {
        let (mut pairs, mut reals, mut count, mut turns) = (Vec::new(), Vec::new(), 0, false);
        for modes in modes {
            count += 1;
            turns |= !modes.odd.is_empty();
            let mut poles = modes.poles.iter().zip(modes.residues).enumerate().map(|(index, (&pole, &residue))| {
                let [residue, q] = carried(residue, modes.odd.get(index).copied().unwrap_or_default());
                let (g, w) = rule.coefficients(pole, modes.multiplicity(index) * residue, time_step);
                [g, w, q]
            });
            pairs.push(poles.by_ref().take(modes.pairs).collect());
            reals.push(poles.collect());
        }
        let looks_back = rule.looks_back();
        let skipped = instants / rule.stages();
        Self {
            first,
            count,
            skipped,
            pairs: PoleRows::new(&pairs, looks_back, turns),
            reals: PoleRows::new(&reals, looks_back, turns),
            stages: rule.stages(),
            skip: rule.products_of_skip(skipped),
            forces: vec![E::default(); instants * 2 * E::MOST_LANES],
            old_forces: Vec::new(),
            displacement: vec![E::default(); instants * 2 * E::MOST_LANES],
        }
    }

    pub(crate) fn work(&self) -> Work {
        let Self { pairs, reals, stages, skip, .. } = self;
        let steps = self.forces.len() / (2 * E::MOST_LANES * stages);
        let multiply_adds = pairs.multiply_adds(steps, *stages, *skip) + reals.multiply_adds(steps, *stages, *skip);
        Work { multiply_adds: multiply_adds as u64, bytes: (self.pairs.bytes() + self.reals.bytes()) as u64 }
    }

    pub(crate) fn wavenumbers(&self) -> Range<usize> {
        self.first..self.first + self.count
    }

    /// Takes the group's part of the forces of an instant, wavenumber by wavenumber: real and imaginary parts.
    pub(crate) fn take_forces(&mut self, instant: usize, forces: impl Iterator<Item = [E; 2]>) {
        let (re, im) = self.forces[2 * E::MOST_LANES * instant..][..2 * E::MOST_LANES].split_at_mut(E::MOST_LANES);
        for ((re, im), force) in re.iter_mut().zip(im).zip(forces) {
            [*re, *im] = force;
        }
    }

    /// Makes the group forget a force `steps` steps after it has been taken in, from now on;
    /// [`Self::old_forces`] holds those that are forgotten.
    pub(crate) fn forget(&mut self, rule: TimeRule, steps: usize) {
        self.old_forces = vec![E::default(); self.forces.len()];
        rule.with_recursion(Forget { group: self, steps });
    }

    /// The group's part of u_old at an instant, wavenumber by wavenumber: real and imaginary parts.
    pub(crate) fn displacement(&self, instant: usize) -> impl Iterator<Item = [E; 2]> {
        let values = &self.displacement[2 * E::MOST_LANES * instant..][..2 * E::MOST_LANES];
        let (re, im) = values.split_at(E::MOST_LANES);
        re.iter().zip(im).map(|(re, im)| [*re, *im]).take(self.count)
    }
}

struct Forget<'a, E> {
    group: &'a mut WavenumberGroup<E>,
    steps: usize,
}

impl<E: Element + Evolving> Evolving for WavenumberGroup<E> {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        self.pairs.states_mut().chain(self.reals.states_mut()).try_for_each(|states| state.list(states))
    }
}

impl<E: Element> WithRecursion for Forget<'_, E> {
    type Output = ();

    fn with<R: Recursion>(self, recursion: R) {
        dispatch(Left { group: self.group, steps: self.steps, recursion });
    }
}

struct Left<'a, E, R> {
    group: &'a mut WavenumberGroup<E>,
    steps: usize,
    recursion: R,
}

impl<E: Element, R: Recursion> WithSimd for Left<'_, E, R> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.group.pairs.forget(simd, self.recursion, self.steps);
        self.group.reals.forget(simd, self.recursion, self.steps);
    }
}
