//! Wavenumbers side by side in the lanes of vectors: their poles, their states, and one pass over them per block of
//! instants.

use num_complex::{Complex, Complex64};
use pulp::{Arch, Simd, WithSimd};

use crate::counters::Work;
use crate::numeric::lanes::dispatch;
use crate::time_rule::TimeRule;
use crate::time_rule::recursion::{MOST_STAGES, Number, Poles, Recursion, State, StepMaps, WithRecursion};
use crate::tyre::poles::Modes;

/// Wavenumbers of a group.
pub(crate) const GROUP: usize = 8;

/// Part of what the slowest pole has left of a force below which the others may keep it.
const FORGOTTEN: f64 = 1e-9;

/// Part of an odd residue as which a smaller even one counts: far below a rounding of what both displace.
const LEAST_EVEN: f64 = 1e-30;

/// Poles that a pass foretells together: u_old is read and written that much less often.
const TOGETHER: usize = 2;

/// Poles of one kind, pairs (PARTS = 2) or real ones (1): the r-th of every wavenumber side by side. Wavenumbers with
/// fewer than their neighbours have poles that do nothing.
#[derive(Clone, Debug, Default)]
struct PoleRows<const PARTS: usize> {
    /// Pole by pole: g, then w, part by part, times [`GROUP`] numbers.
    coefficients: Vec<f64>,
    /// Pole by pole: q, ratio of the odd residue to the even one, part by part, times [`GROUP`] numbers; empty at rest.
    odd: Vec<f64>,
    /// Pole by pole: b of the last step, with a rule that looks back that of the one before too, under the real part of
    /// the force, then the same under its imaginary part, part by part, times [`GROUP`] numbers.
    states: Vec<f64>,
    /// Pole by pole: what is left of a unit force at each instant of a step when it is forgotten, in the state's order,
    /// times [`GROUP`] numbers. Empty: nothing is forgotten.
    left: Vec<f64>,
    /// Which poles have anything left then.
    forgets: Vec<bool>,
}

impl<const PARTS: usize> PoleRows<PARTS> {
    /// Numbers of a pole that do not change.
    const FIXED: usize = 2 * PARTS;
    /// Numbers of a pole that evolve.
    const fn evolving(looks_back: bool) -> usize {
        if looks_back { 4 * PARTS } else { 2 * PARTS }
    }

    /// From each wavenumber's g, w and q, without motion; of a tyre that `turns`, or at rest.
    fn new(wavenumbers: &[Vec<[Complex64; 3]>], looks_back: bool, turns: bool) -> Self {
        let poles = wavenumbers.iter().map(Vec::len).max().unwrap_or(0).next_multiple_of(TOGETHER);
        let mut coefficients = vec![0.0; poles * Self::FIXED * GROUP];
        let mut odd = vec![0.0; if turns { poles * PARTS * GROUP } else { 0 }];
        let parts = |number: Complex64| [number.re, number.im].into_iter().take(PARTS);
        for (lane, own) in wavenumbers.iter().enumerate() {
            for (index, &[g, w, q]) in own.iter().enumerate() {
                for (slot, value) in parts(g).chain(parts(w)).enumerate() {
                    coefficients[(index * Self::FIXED + slot) * GROUP + lane] = value;
                }
                for (slot, value) in parts(q).enumerate().take(odd.len()) {
                    odd[(index * PARTS + slot) * GROUP + lane] = value;
                }
            }
        }
        let states = vec![0.0; poles * Self::evolving(looks_back) * GROUP];
        Self { coefficients, odd, states, left: Vec::new(), forgets: vec![false; poles] }
    }

    /// Returns the rest of a unit force at each instant of a step so many steps later.
    #[inline(always)]
    fn forget<S: Simd, R: Recursion>(&mut self, simd: S, recursion: R, steps: usize) {
        let (vectors, kinds) = (GROUP / S::F64_LANES, Self::evolving(R::LOOKS_BACK) / (2 * PARTS));
        let of_pole = R::STAGES * kinds * PARTS * vectors;
        self.left = vec![0.0; self.forgets.len() * of_pole * S::F64_LANES];
        let (coefficients, _) = S::as_simd_f64s(&self.coefficients);
        let (left, _) = S::as_mut_simd_f64s(&mut self.left);
        let poles = coefficients.chunks_exact(Self::FIXED * vectors).zip(left.chunks_exact_mut(of_pole));
        for (coefficients, left) in poles {
            for vector in 0..vectors {
                let maps = recursion.maps(simd, Self::poles(simd, coefficients, vector, vectors));
                for stage in 0..R::STAGES {
                    let zero = [simd.splat_f64s(0.0); PARTS];
                    let mut states = [State { end: zero, before: zero }; 2];
                    let mut forces = [simd.splat_f64s(0.0); MOST_STAGES];
                    forces[stage] = simd.splat_f64s(1.0);
                    R::take_in(simd, &maps, forces, &mut states[0]);
                    let [state, other] = &mut states;
                    R::skip(simd, &maps, [state, other], steps);
                    for (kind, number) in [states[0].end, states[0].before].into_iter().enumerate().take(kinds) {
                        for (part, value) in number.into_iter().enumerate() {
                            left[((stage * kinds + kind) * PARTS + part) * vectors + vector] = value;
                        }
                    }
                }
            }
        }
        let largest = |values: &[f64]| values.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
        // What a pole displaces by its odd part may be more.
        let mut ratios = self.odd.chunks_exact(PARTS * GROUP).map(|ratios| largest(ratios).max(1.0));
        let of_poles = self.left.chunks_exact(of_pole * S::F64_LANES);
        let sizes: Vec<f64> = of_poles.map(|left| largest(left) * ratios.next().unwrap_or(1.0)).collect();
        let scale = FORGOTTEN * largest(&sizes);
        self.forgets = sizes.iter().map(|size| *size > scale).collect();
    }

    /// A vector of poles.
    #[inline(always)]
    fn poles<S: Simd>(simd: S, coefficients: &[S::f64s], vector: usize, vectors: usize) -> Poles<S, PARTS> {
        let zero = [simd.splat_f64s(0.0); PARTS];
        let mut poles = Poles::<S, PARTS> { g: zero, w: zero };
        for part in 0..PARTS {
            poles.g[part] = coefficients[part * vectors + vector];
            poles.w[part] = coefficients[(PARTS + part) * vectors + vector];
        }
        poles
    }

    /// Multiply-adds of a pass over so many steps: two real systems, R at every step taken in and at every one
    /// foretold, W and A at their stages, A of an odd part too, and the products of passing over a block.
    fn multiply_adds(&self, steps: usize, stages: usize, skip: usize) -> usize {
        self.coefficients.len() / Self::FIXED * Self::multiply_adds_of_one(steps, stages, skip, !self.odd.is_empty())
    }

    /// The same of one pole, a pair counted as one.
    const fn multiply_adds_of_one(steps: usize, stages: usize, skip: usize, turns: bool) -> usize {
        let odd = if turns { PARTS * stages } else { 0 };
        let of_step = 2 * (2 * PARTS * PARTS + PARTS * (2 * stages - 1) + odd);
        steps * of_step + skip * PARTS * PARTS
    }

    /// Bytes of a pass: coefficients read, states read and written.
    fn bytes(&self) -> usize {
        let read = size_of_val(self.coefficients.as_slice()) + size_of_val(self.odd.as_slice());
        read + 2 * size_of_val(self.states.as_slice())
    }

    /// q of a vector of poles.
    #[inline(always)]
    fn ratios<S: Simd>(odd: &[S::f64s], vector: usize) -> Number<S, PARTS> {
        let mut ratios = [odd[vector]; PARTS];
        for part in 1..PARTS {
            ratios[part] = odd[part * (GROUP / S::F64_LANES) + vector];
        }
        ratios
    }
}

/// Multiply-adds for each step that so many poles, conjugates counted, are expected to take in blocks of so many steps:
/// as if all were pairs. Real ones take less, and those that fill up a group take as much more (within 5 % of what runs
/// count). Of a tyre that `turns` odd parts come on top.
pub fn expected_multiply_adds(rule: TimeRule, steps: usize, wavenumbers: usize, poles: f64, turns: bool) -> f64 {
    let (skip, stages) = (rule.products_of_skip(steps), rule.stages());
    let pair = PoleRows::<2>::multiply_adds_of_one(steps, stages, skip, turns);
    let padded = wavenumbers.next_multiple_of(GROUP) as f64 / wavenumbers as f64;
    0.5 * poles * padded * pair as f64 / steps as f64
}

/// The residue that a state carries, and q, which makes the odd one of it.
fn carried(even: Complex64, odd: Complex64) -> [Complex64; 2] {
    if odd == Complex64::ZERO {
        return [even, odd];
    }
    let least = LEAST_EVEN * odd.norm();
    let even = if even.norm() < least { least.into() } else { even };
    [even, odd / even]
}

/// [`GROUP`] neighbouring wavenumbers.
#[derive(Clone, Debug)]
pub struct WavenumberGroup {
    /// First wavenumber.
    first: usize,
    /// Wavenumbers in use.
    count: usize,
    pairs: PoleRows<2>,
    reals: PoleRows<1>,
    /// Stages of a step.
    stages: usize,
    /// Steps between the forces taken in and the displacement foretold.
    skipped: usize,
    /// Products of passing over them.
    skip: usize,
    /// Forces of the last block by instant: real parts of the group, imaginary parts.
    forces: Vec<f64>,
    /// Those of the block that is forgotten likewise; empty: none is.
    old_forces: Vec<f64>,
    /// u_old of the block foretold without the forces of those between, likewise.
    displacement: Vec<f64>,
}

impl WavenumberGroup {
    /// The group of neighbours from wavenumber `first` on, [`GROUP`] at most, at rest, for blocks of so many instants,
    /// of which a pass foretells the one `ahead` blocks after those whose forces it takes in.
    pub fn new<'m>(
        modes: impl IntoIterator<Item = Modes<'m>>,
        rule: TimeRule,
        time_step: f64,
        first: usize,
        instants: usize,
        ahead: usize,
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
        let skipped = ahead * (instants / rule.stages());
        Self {
            first,
            count,
            skipped,
            pairs: PoleRows::new(&pairs, looks_back, turns),
            reals: PoleRows::new(&reals, looks_back, turns),
            stages: rule.stages(),
            skip: rule.products_of_skip(skipped),
            forces: vec![0.0; instants * 2 * GROUP],
            old_forces: Vec::new(),
            displacement: vec![0.0; instants * 2 * GROUP],
        }
    }

    /// Returns the work of a pass.
    pub fn work(&self) -> Work {
        let Self { pairs, reals, stages, skip, .. } = self;
        let steps = self.forces.len() / (2 * GROUP * stages);
        let multiply_adds = pairs.multiply_adds(steps, *stages, *skip) + reals.multiply_adds(steps, *stages, *skip);
        Work { multiply_adds: multiply_adds as u64, bytes: (self.pairs.bytes() + self.reals.bytes()) as u64 }
    }

    /// All that evolves.
    pub(crate) fn states(&self) -> [&[f64]; 2] {
        [&self.pairs.states, &self.reals.states]
    }

    /// As [`Self::states`], to be changed.
    pub(crate) fn states_mut(&mut self) -> [&mut [f64]; 2] {
        [&mut self.pairs.states, &mut self.reals.states]
    }

    /// Blocks of instants: takes in the forces of the last one, passes over those between, then foretells u_old over
    /// the next as if no more forces came.
    // Not inlined: it is long, and its callers would have a copy each.
    #[inline(never)]
    pub(crate) fn pass<R: Recursion>(&mut self, arch: Arch, recursion: R) {
        arch.dispatch(Pass { group: self, recursion });
    }

    /// Takes the group's part of the forces of an instant, given by wavenumber.
    pub(crate) fn take_forces(&mut self, instant: usize, spectrum: &[Complex64]) {
        let (re, im) = self.forces[2 * GROUP * instant..2 * GROUP * (instant + 1)].split_at_mut(GROUP);
        for ((re, im), value) in re.iter_mut().zip(im).zip(&spectrum[self.first..self.first + self.count]) {
            (*re, *im) = (value.re, value.im);
        }
    }

    /// From now on a force is forgotten so many steps after it has been taken in; [`Self::take_old_forces`] says which.
    pub(crate) fn forget(&mut self, rule: TimeRule, steps: usize) {
        self.old_forces = vec![0.0; self.forces.len()];
        rule.with_recursion(Forget { group: self, steps });
    }

    /// Takes the group's part of the forces of an instant that are forgotten.
    pub(crate) fn take_old_forces(&mut self, instant: usize, spectrum: &[Complex<f32>]) {
        let (re, im) = self.old_forces[2 * GROUP * instant..2 * GROUP * (instant + 1)].split_at_mut(GROUP);
        for ((re, im), value) in re.iter_mut().zip(im).zip(&spectrum[self.first..self.first + self.count]) {
            (*re, *im) = (f64::from(value.re), f64::from(value.im));
        }
    }

    /// Gives the group's part of u_old at an instant, by wavenumber.
    pub(crate) fn give_displacement(&self, instant: usize, spectrum: &mut [Complex64]) {
        let (re, im) = self.displacement[2 * GROUP * instant..2 * GROUP * (instant + 1)].split_at(GROUP);
        for ((re, im), value) in re.iter().zip(im).zip(&mut spectrum[self.first..self.first + self.count]) {
            *value = Complex64::new(*re, *im);
        }
    }
}

/// Removal of forgotten forces.
struct Forget<'a> {
    group: &'a mut WavenumberGroup,
    steps: usize,
}

impl WithRecursion for Forget<'_> {
    type Output = ();

    fn with<R: Recursion>(self, recursion: R) {
        dispatch(Left { group: self.group, steps: self.steps, recursion });
    }
}

struct Left<'a, R> {
    group: &'a mut WavenumberGroup,
    steps: usize,
    recursion: R,
}

impl<R: Recursion> WithSimd for Left<'_, R> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.group.pairs.forget(simd, self.recursion, self.steps);
        self.group.reals.forget(simd, self.recursion, self.steps);
    }
}

/// See [`WavenumberGroup::pass`].
struct Pass<'a, R> {
    group: &'a mut WavenumberGroup,
    recursion: R,
}

impl<R: Recursion> WithSimd for Pass<'_, R> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { group, recursion } = self;
        let turns = !(group.pairs.odd.is_empty() && group.reals.odd.is_empty());
        let (forces, _) = S::as_simd_f64s(&group.forces);
        let (old_forces, _) = S::as_simd_f64s(&group.old_forces);
        let (displacement, _) = S::as_mut_simd_f64s(&mut group.displacement);
        displacement.fill(simd.splat_f64s(0.0));
        let mut block = Block { simd, recursion, forces, old_forces, displacement, skipped: group.skipped };
        if turns {
            block.pass::<2, true>(&mut group.pairs);
            block.pass::<1, true>(&mut group.reals);
        } else {
            block.pass::<2, false>(&mut group.pairs);
            block.pass::<1, false>(&mut group.reals);
        }
    }
}

/// A block of instants as vectors, [`GROUP`] numbers of the real system and as many of the imaginary one to an instant.
struct Block<'a, S: Simd, R> {
    simd: S,
    recursion: R,
    forces: &'a [S::f64s],
    old_forces: &'a [S::f64s],
    displacement: &'a mut [S::f64s],
    skipped: usize,
}

impl<S: Simd, R: Recursion> Block<'_, S, R> {
    /// Vectors of a group.
    const VECTORS: usize = GROUP / S::F64_LANES;

    #[inline(always)]
    fn pass<const PARTS: usize, const TURNS: bool>(&mut self, rows: &mut PoleRows<PARTS>) {
        let fixed = PoleRows::<PARTS>::FIXED * Self::VECTORS;
        let evolving = PoleRows::<PARTS>::evolving(R::LOOKS_BACK) * Self::VECTORS;
        let (coefficients, _) = S::as_simd_f64s(&rows.coefficients);
        let (odd, _) = S::as_simd_f64s(&rows.odd);
        let of_odd = PARTS * Self::VECTORS;
        let (states, _) = S::as_mut_simd_f64s(&mut rows.states);
        let (left, _) = S::as_simd_f64s(&rows.left);
        let of_left = left.len() / rows.forgets.len().max(1);
        let left_of = |pole: usize| if rows.forgets[pole] { &left[pole * of_left..][..of_left] } else { &[] };
        let together = coefficients.chunks_exact(TOGETHER * fixed).zip(states.chunks_exact_mut(TOGETHER * evolving));
        for (number, (coefficients, states)) in together.enumerate() {
            let (left, other_left) = (left_of(TOGETHER * number), left_of(TOGETHER * number + 1));
            let (one, other) = coefficients.split_at(fixed);
            let (one_states, other_states) = states.split_at_mut(evolving);
            for vector in 0..Self::VECTORS {
                let one = self.take_in::<PARTS>(vector, one, one_states, left);
                let other = self.take_in::<PARTS>(vector, other, other_states, other_left);
                if TURNS {
                    let (one_odd, other_odd) = odd[TOGETHER * number * of_odd..][..TOGETHER * of_odd].split_at(of_odd);
                    let one_odd = PoleRows::<PARTS>::ratios::<S>(one_odd, vector);
                    let other_odd = PoleRows::<PARTS>::ratios::<S>(other_odd, vector);
                    self.foretell_both(vector, [one, other], [one_odd, other_odd]);
                } else {
                    self.foretell(vector, one, other);
                }
            }
        }
    }

    /// A pole takes in the block's forces.
    #[inline(always)]
    fn take_in<const PARTS: usize>(
        &self,
        vector: usize,
        coefficients: &[S::f64s],
        states: &mut [S::f64s],
        left: &[S::f64s],
    ) -> Driven<S, PARTS> {
        let (simd, vectors) = (self.simd, Self::VECTORS);
        let zero = [simd.splat_f64s(0.0); PARTS];
        let mut systems = [State { end: zero, before: zero }; 2];
        let of_system = PoleRows::<PARTS>::evolving(R::LOOKS_BACK) / 2;
        for part in 0..PARTS {
            for (which, system) in systems.iter_mut().enumerate() {
                system.end[part] = states[(of_system * which + part) * vectors + vector];
                if R::LOOKS_BACK {
                    system.before[part] = states[(of_system * which + PARTS + part) * vectors + vector];
                }
            }
        }
        let maps = self.recursion.maps(simd, PoleRows::<PARTS>::poles(simd, coefficients, vector, vectors));
        let systems = if left.is_empty() {
            self.drive::<PARTS, false>(vector, &maps, systems, left)
        } else {
            self.drive::<PARTS, true>(vector, &maps, systems, left)
        };
        for (which, system) in systems.iter().enumerate() {
            for part in 0..PARTS {
                states[(of_system * which + part) * vectors + vector] = system.end[part];
                if R::LOOKS_BACK {
                    states[(of_system * which + PARTS + part) * vectors + vector] = system.before[part];
                }
            }
        }
        let [re, im] = systems;
        Driven { maps, re, im }
    }

    /// The systems after the block's forces, less what is `left` of the forces that are forgotten meanwhile.
    #[inline(always)]
    fn drive<const PARTS: usize, const FORGETS: bool>(
        &self,
        vector: usize,
        maps: &StepMaps<S, PARTS>,
        mut systems: [State<S, PARTS>; 2],
        left: &[S::f64s],
    ) -> [State<S, PARTS>; 2] {
        let (simd, vectors) = (self.simd, Self::VECTORS);
        let kinds = PoleRows::<PARTS>::evolving(R::LOOKS_BACK) / (2 * PARTS);
        let of_step = 2 * vectors * R::STAGES;
        let mut old_steps = self.old_forces.chunks_exact(of_step);
        for step in self.forces.chunks_exact(of_step) {
            let old_step = if FORGETS { old_steps.next() } else { None };
            for (which, system) in systems.iter_mut().enumerate() {
                let mut forces = [simd.splat_f64s(0.0); MOST_STAGES];
                for stage in 0..R::STAGES {
                    forces[stage] = step[(2 * stage + which) * vectors + vector];
                }
                R::take_in(simd, maps, forces, system);
                let Some(old_step) = old_step else { continue };
                for stage in 0..R::STAGES {
                    let old = old_step[(2 * stage + which) * vectors + vector];
                    for part in 0..PARTS {
                        let of = |kind: usize| left[((stage * kinds + kind) * PARTS + part) * vectors + vector];
                        system.end[part] = simd.negate_mul_add_e_f64s(of(0), old, system.end[part]);
                        if R::LOOKS_BACK {
                            system.before[part] = simd.negate_mul_add_e_f64s(of(1), old, system.before[part]);
                        }
                    }
                }
            }
        }
        systems
    }

    /// Two poles add what they displace in the block after the coming one.
    #[inline(always)]
    fn foretell<const PARTS: usize>(&mut self, vector: usize, mut one: Driven<S, PARTS>, mut other: Driven<S, PARTS>) {
        let (simd, vectors) = (self.simd, Self::VECTORS);
        let of_step = 2 * vectors * R::STAGES;
        R::skip(simd, &one.maps, [&mut one.re, &mut one.im], self.skipped);
        R::skip(simd, &other.maps, [&mut other.re, &mut other.im], self.skipped);
        for step in self.displacement.chunks_exact_mut(of_step) {
            let first = [R::foretell(simd, &one.maps, &mut one.re), R::foretell(simd, &one.maps, &mut one.im)];
            let second = [R::foretell(simd, &other.maps, &mut other.re), R::foretell(simd, &other.maps, &mut other.im)];
            for stage in 0..R::STAGES {
                for system in 0..2 {
                    let out = &mut step[(2 * stage + system) * vectors + vector];
                    *out = simd.add_f64s(*out, simd.add_f64s(first[system][stage], second[system][stage]));
                }
            }
        }
    }

    /// The same with odd parts: what they displace goes from one system to the other.
    #[inline(always)]
    fn foretell_both<const PARTS: usize>(
        &mut self,
        vector: usize,
        mut poles: [Driven<S, PARTS>; TOGETHER],
        ratios: [Number<S, PARTS>; TOGETHER],
    ) {
        let (simd, vectors) = (self.simd, Self::VECTORS);
        let of_step = 2 * vectors * R::STAGES;
        let mut odd = [[ratios[0]; MOST_STAGES]; TOGETHER];
        for pole in 0..TOGETHER {
            let Driven { maps, re, im } = &mut poles[pole];
            R::skip(simd, maps, [re, im], self.skipped);
            odd[pole] = R::odd_outputs(simd, maps, ratios[pole]);
        }
        for step in self.displacement.chunks_exact_mut(of_step) {
            let mut both = [[[simd.splat_f64s(0.0); MOST_STAGES]; 2]; 2 * TOGETHER];
            for pole in 0..TOGETHER {
                let Driven { maps, re, im } = &mut poles[pole];
                both[2 * pole] = R::foretell_both(simd, maps, &odd[pole], re);
                both[2 * pole + 1] = R::foretell_both(simd, maps, &odd[pole], im);
            }
            // No closures over vectors: each would be a call.
            let [re, im, other_re, other_im] = &both;
            for stage in 0..R::STAGES {
                let out = &mut step[2 * stage * vectors + vector];
                let even = simd.add_f64s(re[0][stage], other_re[0][stage]);
                let odd = simd.add_f64s(im[1][stage], other_im[1][stage]);
                *out = simd.add_f64s(*out, simd.sub_f64s(even, odd));
                let out = &mut step[(2 * stage + 1) * vectors + vector];
                let even = simd.add_f64s(im[0][stage], other_im[0][stage]);
                let odd = simd.add_f64s(re[1][stage], other_re[1][stage]);
                *out = simd.add_f64s(*out, simd.add_f64s(even, odd));
            }
        }
    }
}

/// A pole and its two real systems, all forces so far taken in.
#[derive(Clone, Copy)]
struct Driven<S: Simd, const PARTS: usize> {
    maps: StepMaps<S, PARTS>,
    re: State<S, PARTS>,
    im: State<S, PARTS>,
}
