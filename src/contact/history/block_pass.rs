//! The pass of a group of wavenumbers over a block: forces taken in, displacements predicted.

use pulp::{Arch, Simd, WithSimd};

use super::wavenumber_group::{PoleRecord, PoleRows, TOGETHER, WavenumberGroup};
use crate::numeric::Element;
use crate::time_rule::recursion::{MOST_STAGES, Number, PoleState, Recursion, StepMaps};

/// Passes over blocks of instants: takes in the forces of the last one, passes over those between, then predicts
/// u_old over the next as if no more forces came.
// Not inlined: it is long, and its callers would have a copy each.
#[inline(never)]
pub(crate) fn pass<E: Element, R: Recursion>(group: &mut WavenumberGroup<E>, arch: Arch, recursion: R) {
    arch.dispatch(Pass { group, recursion });
}

struct Pass<'a, E, R> {
    group: &'a mut WavenumberGroup<E>,
    recursion: R,
}

impl<E: Element, R: Recursion> WithSimd for Pass<'_, E, R> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { group, recursion } = self;
        let turns = group.pairs.turns || group.reals.turns;
        let forces = E::vectors::<S>(&group.forces);
        let old_forces = E::vectors::<S>(&group.old_forces);
        let displacement = E::vectors_mut::<S>(&mut group.displacement);
        displacement.fill(E::splat(simd, E::default()));
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

/// A block of instants as vectors, a group's numbers of the real system and as many of the imaginary one to an instant.
struct Block<'a, E: Element, S: Simd, R> {
    simd: S,
    recursion: R,
    forces: &'a [E::Vector<S>],
    old_forces: &'a [E::Vector<S>],
    displacement: &'a mut [E::Vector<S>],
    skipped: usize,
}

impl<E: Element, S: Simd, R: Recursion> Block<'_, E, S, R> {
    /// Vectors of a group's numbers.
    const VECTORS: usize = E::MOST_LANES * size_of::<E>() / size_of::<E::Vector<S>>();

    #[inline(always)]
    fn pass<const PARTS: usize, const TURNS: bool>(&mut self, rows: &mut PoleRows<E, PARTS>) {
        let (forgets, records) = rows.vectors::<S>();
        for (PoleRecord { coefficients, odd, states, remainder }, forgets) in
            records.zip(forgets.chunks_exact(TOGETHER))
        {
            let (one, other) = coefficients.split_at(coefficients.len() / TOGETHER);
            let (one_odd, other_odd) = odd.split_at(odd.len() / TOGETHER);
            let (one_states, other_states) = states.split_at_mut(states.len() / TOGETHER);
            let (one_remainder, other_remainder) = remainder.split_at(remainder.len() / TOGETHER);
            let one_remainder = if forgets[0] { one_remainder } else { &[] };
            let other_remainder = if forgets[1] { other_remainder } else { &[] };
            for vector in 0..Self::VECTORS {
                let one = self.take_in::<PARTS>(vector, one, one_states, one_remainder);
                let other = self.take_in::<PARTS>(vector, other, other_states, other_remainder);
                if TURNS {
                    let one_odd = PoleRows::<E, PARTS>::ratios::<S>(one_odd, vector);
                    let other_odd = PoleRows::<E, PARTS>::ratios::<S>(other_odd, vector);
                    self.predict_both(vector, [one, other], [one_odd, other_odd]);
                } else {
                    self.predict(vector, one, other);
                }
            }
        }
    }

    /// Takes in the block's forces for a pole: updates its states, and returns them with its step maps.
    #[inline(always)]
    fn take_in<const PARTS: usize>(
        &self,
        vector: usize,
        coefficients: &[E::Vector<S>],
        states: &mut [E::Vector<S>],
        remainder: &[E::Vector<S>],
    ) -> Driven<E, S, PARTS> {
        let (simd, vectors) = (self.simd, Self::VECTORS);
        let zero = [E::splat(simd, E::default()); PARTS];
        let mut systems = [PoleState { end: zero, before: zero }; 2];
        let of_system = PoleRows::<E, PARTS>::evolving(R::LOOKS_BACK) / 2;
        for part in 0..PARTS {
            for (which, system) in systems.iter_mut().enumerate() {
                system.end[part] = states[(of_system * which + part) * vectors + vector];
                if R::LOOKS_BACK {
                    system.before[part] = states[(of_system * which + PARTS + part) * vectors + vector];
                }
            }
        }
        let maps =
            self.recursion.maps::<E, S, PARTS>(simd, PoleRows::<E, PARTS>::poles(simd, coefficients, vector, vectors));
        let systems = if remainder.is_empty() {
            self.drive::<PARTS, false>(vector, &maps, systems, remainder)
        } else {
            self.drive::<PARTS, true>(vector, &maps, systems, remainder)
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

    /// The systems after the block's forces, less the `remainder` of the forces that are forgotten meanwhile.
    #[inline(always)]
    fn drive<const PARTS: usize, const FORGETS: bool>(
        &self,
        vector: usize,
        maps: &StepMaps<E, S, PARTS>,
        mut systems: [PoleState<E, S, PARTS>; 2],
        remainder: &[E::Vector<S>],
    ) -> [PoleState<E, S, PARTS>; 2] {
        let (simd, vectors) = (self.simd, Self::VECTORS);
        let kinds = PoleRows::<E, PARTS>::evolving(R::LOOKS_BACK) / (2 * PARTS);
        let of_step = 2 * vectors * R::STAGES;
        let mut old_steps = self.old_forces.chunks_exact(of_step);
        for step in self.forces.chunks_exact(of_step) {
            let old_step = if FORGETS { old_steps.next() } else { None };
            for (which, system) in systems.iter_mut().enumerate() {
                let mut forces = [E::splat(simd, E::default()); MOST_STAGES];
                for stage in 0..R::STAGES {
                    forces[stage] = step[(2 * stage + which) * vectors + vector];
                }
                R::take_in(simd, maps, forces, system);
                let Some(old_step) = old_step else { continue };
                for stage in 0..R::STAGES {
                    let old = old_step[(2 * stage + which) * vectors + vector];
                    for part in 0..PARTS {
                        let of = |kind: usize| remainder[((stage * kinds + kind) * PARTS + part) * vectors + vector];
                        system.end[part] = E::negate_mul_add(simd, of(0), old, system.end[part]);
                        if R::LOOKS_BACK {
                            system.before[part] = E::negate_mul_add(simd, of(1), old, system.before[part]);
                        }
                    }
                }
            }
        }
        systems
    }

    /// Adds the displacements by two poles in the block after the coming one.
    #[inline(always)]
    fn predict<const PARTS: usize>(
        &mut self,
        vector: usize,
        mut one: Driven<E, S, PARTS>,
        mut other: Driven<E, S, PARTS>,
    ) {
        let (simd, vectors) = (self.simd, Self::VECTORS);
        let of_step = 2 * vectors * R::STAGES;
        R::skip(simd, &one.maps, [&mut one.re, &mut one.im], self.skipped);
        R::skip(simd, &other.maps, [&mut other.re, &mut other.im], self.skipped);
        for step in self.displacement.chunks_exact_mut(of_step) {
            let first = [R::predict(simd, &one.maps, &mut one.re), R::predict(simd, &one.maps, &mut one.im)];
            let second = [R::predict(simd, &other.maps, &mut other.re), R::predict(simd, &other.maps, &mut other.im)];
            for stage in 0..R::STAGES {
                for system in 0..2 {
                    let out = &mut step[(2 * stage + system) * vectors + vector];
                    *out = E::add(simd, *out, E::add(simd, first[system][stage], second[system][stage]));
                }
            }
        }
    }

    /// Adds the same with odd parts, whose displacements go from one system to the other.
    #[inline(always)]
    fn predict_both<const PARTS: usize>(
        &mut self,
        vector: usize,
        mut poles: [Driven<E, S, PARTS>; TOGETHER],
        ratios: [Number<E, S, PARTS>; TOGETHER],
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
            let mut both = [[[E::splat(simd, E::default()); MOST_STAGES]; 2]; 2 * TOGETHER];
            for pole in 0..TOGETHER {
                let Driven { maps, re, im } = &mut poles[pole];
                both[2 * pole] = R::predict_both(simd, maps, &odd[pole], re);
                both[2 * pole + 1] = R::predict_both(simd, maps, &odd[pole], im);
            }
            // No closures over vectors: each would be a call.
            let [re, im, other_re, other_im] = &both;
            for stage in 0..R::STAGES {
                let out = &mut step[2 * stage * vectors + vector];
                let even = E::add(simd, re[0][stage], other_re[0][stage]);
                let odd = E::add(simd, im[1][stage], other_im[1][stage]);
                *out = E::add(simd, *out, E::sub(simd, even, odd));
                let out = &mut step[(2 * stage + 1) * vectors + vector];
                let even = E::add(simd, im[0][stage], other_im[0][stage]);
                let odd = E::add(simd, re[1][stage], other_re[1][stage]);
                *out = E::add(simd, *out, E::add(simd, even, odd));
            }
        }
    }
}

/// A pole and its two real systems, all forces so far taken in.
#[derive(Clone, Copy)]
struct Driven<E: Element, S: Simd, const PARTS: usize> {
    maps: StepMaps<E, S, PARTS>,
    re: PoleState<E, S, PARTS>,
    im: PoleState<E, S, PARTS>,
}
