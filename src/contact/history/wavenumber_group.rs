//! Wavenumbers side by side in the lanes of vectors: their poles, their states, and one pass over them per block of instants.

use num_complex::Complex64;
use pulp::{Simd, WithSimd};

use super::recursion::{Poles, Recursion, State, coefficients};
use crate::scene::TimeRule;
use crate::tyre::influence::Field;
use crate::tyre::rational::RationalModel;

/// Wavenumbers of a group.
pub const GROUP: usize = 8;

/// Poles that a pass foretells together: u_old is read and written that much less often.
const TOGETHER: usize = 2;

/// Numbers of a pole that do not change: g and w, real and imaginary.
const FIXED: usize = 4;
/// Numbers of a pole that evolve: b ahead and behind, real and imaginary, under the real and the imaginary part of the force.
const EVOLVING: usize = 8;

/// [`GROUP`] neighbouring wavenumbers. The r-th pole of each of them makes up one vector; wavenumbers with fewer poles than their neighbours get poles that do nothing.
#[derive(Clone, Debug)]
pub struct WavenumberGroup {
    /// First wavenumber.
    first: usize,
    /// Wavenumbers in use.
    count: usize,
    /// Pole by pole: [`FIXED`] times [`GROUP`] numbers.
    coefficients: Vec<f64>,
    /// Pole by pole: [`EVOLVING`] times [`GROUP`] numbers.
    states: Vec<f64>,
    /// Forces of the last block by instant: real parts of the group, imaginary parts.
    forces: Vec<f64>,
    /// u_old of the coming block without its own forces, likewise.
    displacement: Vec<f64>,
}

impl WavenumberGroup {
    /// The group from wavenumber `first` on, at rest, for blocks of so many instants; `None` if the model does not hold the field.
    pub fn new(
        model: &RationalModel,
        field: Field,
        rule: TimeRule,
        time_step: f64,
        first: usize,
        instants: usize,
    ) -> Option<Self> {
        let count = GROUP.min(model.largest_wavenumber() + 1 - first);
        let modes: Option<Vec<_>> = (first..first + count).map(|n| model.modes(n, field)).collect();
        let modes = modes?;
        let poles = modes.iter().map(|modes| modes.poles.len()).max().unwrap_or(0).next_multiple_of(TOGETHER);
        let mut fixed = vec![0.0; poles * FIXED * GROUP];
        for (lane, modes) in modes.iter().enumerate() {
            for (index, (&pole, &residue)) in modes.poles.iter().zip(modes.residues).enumerate() {
                let (g, w) = coefficients(rule, pole, modes.multiplicity(index) * residue, time_step);
                for (slot, value) in [g.re, g.im, w.re, w.im].into_iter().enumerate() {
                    fixed[(index * FIXED + slot) * GROUP + lane] = value;
                }
            }
        }
        Some(Self {
            first,
            count,
            coefficients: fixed,
            states: vec![0.0; poles * EVOLVING * GROUP],
            forces: vec![0.0; instants * 2 * GROUP],
            displacement: vec![0.0; instants * 2 * GROUP],
        })
    }

    /// Poles that a pass goes through, those that do nothing included.
    pub fn poles(&self) -> usize {
        self.coefficients.len() / FIXED
    }

    /// All that evolves.
    pub fn states(&self) -> &[f64] {
        &self.states
    }

    /// As [`Self::states`], to be changed.
    pub fn states_mut(&mut self) -> &mut [f64] {
        &mut self.states
    }

    /// Takes the group's part of the forces of an instant, given by wavenumber.
    pub fn take_forces(&mut self, instant: usize, spectrum: &[Complex64]) {
        let (re, im) = self.forces[2 * GROUP * instant..2 * GROUP * (instant + 1)].split_at_mut(GROUP);
        for ((re, im), value) in re.iter_mut().zip(im).zip(&spectrum[self.first..self.first + self.count]) {
            (*re, *im) = (value.re, value.im);
        }
    }

    /// Gives the group's part of u_old at an instant, by wavenumber.
    pub fn give_displacement(&self, instant: usize, spectrum: &mut [Complex64]) {
        let (re, im) = self.displacement[2 * GROUP * instant..2 * GROUP * (instant + 1)].split_at(GROUP);
        for ((re, im), value) in re.iter().zip(im).zip(&mut spectrum[self.first..self.first + self.count]) {
            *value = Complex64::new(*re, *im);
        }
    }
}

/// A block of instants: takes in the forces of the last one, then foretells u_old over the coming one as if no more forces came.
pub struct Pass<'a, R> {
    /// The group.
    pub group: &'a mut WavenumberGroup,
    /// The rule.
    pub recursion: R,
    /// Instants of a time step; a block is a whole number of time steps.
    pub stages: usize,
}

impl<R: Recursion> WithSimd for Pass<'_, R> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { group, recursion, stages } = self;
        let vectors = GROUP / S::F64_LANES;
        let (fixed, _) = S::as_simd_f64s(&group.coefficients);
        let (states, _) = S::as_mut_simd_f64s(&mut group.states);
        let (forces, _) = S::as_simd_f64s(&group.forces);
        let (displacement, _) = S::as_mut_simd_f64s(&mut group.displacement);
        displacement.fill(simd.splat_f64s(0.0));
        let following = |stage: usize| if stage + 1 < stages { stage + 1 } else { 0 };
        let pairs = fixed.chunks_exact(TOGETHER * FIXED * vectors);
        for (fixed, states) in pairs.zip(states.chunks_exact_mut(TOGETHER * EVOLVING * vectors)) {
            for vector in 0..vectors {
                let mut both = [0, 1].map(|which| {
                    let fixed = |slot: usize| fixed[(which * FIXED + slot) * vectors + vector];
                    let states = &mut states[which * EVOLVING * vectors..];
                    let state = |slot: usize| states[slot * vectors + vector];
                    let poles = Poles { g: [fixed(0), fixed(1)], w: [fixed(2), fixed(3)] };
                    let mut re = State::new(simd, [state(0), state(1)], [state(2), state(3)]);
                    let mut im = State::new(simd, [state(4), state(5)], [state(6), state(7)]);
                    let mut stage = 0;
                    for force in forces.chunks_exact(2 * vectors) {
                        stage = following(stage);
                        recursion.driven(simd, stage, &poles, force[vector], &mut re);
                        recursion.driven(simd, stage, &poles, force[vectors + vector], &mut im);
                    }
                    let evolved = [re.ahead, re.behind, im.ahead, im.behind];
                    for (slot, value) in evolved.into_iter().flatten().enumerate() {
                        states[slot * vectors + vector] = value;
                    }
                    (poles, re, im)
                });
                let mut stage = 0;
                for (instant, out) in displacement.chunks_exact_mut(2 * vectors).enumerate() {
                    if instant > 0 {
                        stage = following(stage);
                        for (poles, re, im) in &mut both {
                            recursion.next(simd, stage, poles, re);
                            recursion.next(simd, stage, poles, im);
                        }
                    }
                    let [(_, re, im), (_, other_re, other_im)] = &both;
                    let (re, im) =
                        (simd.add_f64s(re.ahead[0], other_re.ahead[0]), simd.add_f64s(im.ahead[0], other_im.ahead[0]));
                    out[vector] = simd.add_f64s(out[vector], re);
                    out[vectors + vector] = simd.add_f64s(out[vectors + vector], im);
                }
            }
        }
    }
}
