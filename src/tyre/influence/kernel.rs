//! The compliance kernel: C and D of a wave of n periods round the tyre and of the lateral number m, at s.
//!
//! All sums over waves take the tyre's answer to a wave from here. A wave (n, m) has kx = 2 pi n/L on the tread's
//! surface and ky = m pi/B. Of a flat tyre it is answered by the [`Stack`] at (kx, ky, s), of a curved one by a
//! [`CylinderWave`](crate::tyre::layers::cylinder::CylinderWave) as long as it is long enough to feel the curvature.
//! Across the width it is a sine where the sides are supported, and a centred strip excites the odd m; a cosine where
//! they are guided, and the strip excites the even ones, 0 among them.
//!
//! With rotation, the waves n and -n differ: n is signed. An entry X of C at both is given by its [`Parts`], real
//! functions of s: at rest the odd part of a normal compliance is 0, and the even part of the tangential one. Waves
//! that are evaluated as flat have the parts of the tyre at rest; the sums add the effect of rotation on them
//! (`super::short_waves`).

use std::sync::Arc;

use num_complex::Complex64;
use pulp::Simd;
use serde::{Deserialize, Serialize};

use super::curved_waves::CurvedWaves;
use super::parts::Parts;
use super::waves::Waves;
use crate::numeric::lanes::outlined;
use crate::numeric::{ComplexField, Lanes, MOST_LANES};
use crate::scene::{Layer, Tyre};
use crate::sidewall::SidewallAt;
use crate::tyre::layers::compliance::{Matrix3, NormalCompliance, Stack, StackAt};
use crate::tyre::layers::cylinder::{CylinderAt, CylinderWave, EdgeMotion};
use crate::tyre::layers::lane_compliance::LaneStack;
use crate::tyre::layers::layer::LayerAt;

/// Displacement observed, and where the force acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Field {
    /// Outward displacement of the tread surface, force on the surface.
    Surface,
    /// Outward displacement of the innermost face, force on the surface.
    Bottom,
    /// Carcass directly under the outermost layer, driven there, with that layer's mass on it: what the springs of a
    /// bedding act on.
    UnderTread,
}

/// Compliance kernel of a tyre, for any s.
#[derive(Clone, Debug)]
pub(crate) struct Kernel {
    stack: Stack,
    waves: Waves,
    curved: Option<Arc<CurvedWaves>>,
}

#[derive(Clone, Debug)]
pub(crate) struct KernelAt {
    stack: StackAt,
    waves: Waves,
    curved: Option<(Arc<CurvedWaves>, CylinderAt)>,
}

impl Kernel {
    /// For |s| up to `largest_s` \[1/s\]; on a curved tyre with values within a relative `tolerance`.
    pub(crate) fn new(tyre: &Tyre, largest_s: f64, tolerance: f64) -> Self {
        Self::on_ring(tyre, Waves::new(tyre), largest_s, tolerance)
    }

    /// The same for the waves of a shorter ring: n counts periods round that.
    pub(super) fn on_ring(tyre: &Tyre, waves: Waves, largest_s: f64, tolerance: f64) -> Self {
        let curved = tyre.curvature.then(|| Arc::new(CurvedWaves::new(tyre, waves, largest_s, tolerance)));
        Self { stack: Stack::new(tyre), waves, curved }
    }

    /// Outermost layer, if it is a half-space to short waves: a layer under tension has no such limit.
    pub(super) fn tread(&self) -> Option<&Layer> {
        self.stack.layers().last().filter(|tread| !tread.is_tense())
    }

    /// Wavenumber from which on a curved tyre's waves are evaluated as flat \[1/m\]; `None` for a flat tyre.
    pub(super) fn flat_from(&self) -> Option<f64> {
        self.curved.as_ref().map(|waves| waves.below)
    }

    /// Prepares the waves below a wavenumber \[1/m\]: see [`CurvedWaves::prepare`].
    pub(super) fn prepare(&self, cut_off: f64) {
        if let Some(waves) = &self.curved {
            waves.prepare(cut_off);
        }
    }

    /// Kernel at s = 0: waves for s = 0 alone take less work.
    pub(super) fn at_rest(&self) -> KernelAt {
        let curved = self.curved.as_ref().map(|waves| Arc::new(waves.at_rest()));
        Self { stack: self.stack.clone(), waves: self.waves, curved }.at(Complex64::ZERO)
    }

    pub(crate) fn at(&self, s: Complex64) -> KernelAt {
        let curved = self.curved.as_ref().map(|waves| (Arc::clone(waves), waves.cylinder.at(s)));
        KernelAt { stack: self.stack.at(s), waves: self.waves, curved }
    }
}

impl KernelAt {
    /// Outermost layer at this s.
    pub(crate) fn tread(&self) -> &LayerAt<Complex64> {
        self.stack.tread()
    }

    /// Sidewalls as arcs; `None` on a foundation.
    pub(super) fn sidewall(&self) -> Option<&SidewallAt> {
        self.curved.as_ref().and_then(|(_, at)| at.sidewall())
    }

    fn curved(&self, n: i64, m: usize) -> Option<(&CylinderWave, &CylinderAt)> {
        let (waves, at) = self.curved.as_ref()?;
        Some((waves.get(n, m)?, at))
    }

    pub(crate) fn turns(&self) -> bool {
        self.curved.as_ref().is_some_and(|(waves, _)| waves.turns())
    }

    /// C or D of a wave for normal traction \[m/Pa\]; n signed.
    pub(super) fn normal(&self, n: i64, m: usize, field: Field) -> Complex64 {
        if let Some((wave, at)) = self.curved(n, m) {
            if n < 0 && self.turns() {
                let [_, backwards] = both_ways(wave, at, field);
                return backwards;
            }
            return match field {
                Field::Surface => wave.normal(at).surface,
                Field::Bottom => wave.normal(at).bottom,
                Field::UnderTread => wave.under_tread(at),
            };
        }
        let (kx, ky) = (self.waves.kx(n), self.waves.ky(m));
        match field {
            Field::Surface => self.stack.normal(kx, ky).surface,
            Field::Bottom => self.stack.normal(kx, ky).bottom,
            Field::UnderTread => self.stack.under_tread(kx, ky),
        }
    }

    /// Parts of C or D of the waves n and -n for normal traction, n >= 0 \[m/Pa\].
    pub(crate) fn normal_parts(&self, n: i64, m: usize, field: Field) -> Parts<Complex64> {
        match self.curved(n, m) {
            Some((wave, at)) if self.turns() => Parts::of(both_ways(wave, at, field)),
            _ => Parts::even(self.normal(n, m, field)),
        }
    }

    /// C_xz of a wave: displacement of the surface along x for normal traction \[m/Pa\].
    fn tangential(&self, n: i64, m: usize) -> Complex64 {
        match self.curved(n, m) {
            Some(_) => self.full(n, m)[0][2],
            None => self.stack.tangential(self.waves.kx(n), self.waves.ky(m)),
        }
    }

    /// Parts of C_xz of the waves n and -n, n >= 0 \[m/Pa\]: at rest all of it is odd.
    pub(crate) fn tangential_parts(&self, n: i64, m: usize) -> Parts<Complex64> {
        if self.turns() && self.curved(n, m).is_some() {
            return Parts::of([n, -n].map(|n| self.full(n, m)[0][2]));
        }
        let tangential = self.tangential(n, m);
        Parts { even: Complex64::ZERO, odd: tangential * -Complex64::i() }
    }

    /// C of a wave for all tractions \[m/Pa\]; order circumferential, lateral, outward; n signed.
    pub(crate) fn full(&self, n: i64, m: usize) -> Matrix3 {
        let [surface, _] = self.full_of_faces(n, m);
        surface
    }

    /// C and D of a wave for all tractions \[m/Pa\], in that order.
    pub(super) fn full_of_faces(&self, n: i64, m: usize) -> [Matrix3; 2] {
        let (surface, bottom) = match self.curved(n, m) {
            Some((wave, at)) if n < 0 => wave.full_backwards(at),
            Some((wave, at)) => wave.full(at),
            None => self.stack.full(self.waves.kx(n), self.waves.ky(m)),
        };
        [surface, bottom]
    }
}

/// C or D of the waves n and -n for normal traction \[m/Pa\].
fn both_ways(wave: &CylinderWave, at: &CylinderAt, field: Field) -> [Complex64; 2] {
    match field {
        Field::Surface => wave.normal_both_ways(at).map(|normal| normal.surface),
        Field::Bottom => wave.normal_both_ways(at).map(|normal| normal.bottom),
        Field::UnderTread => wave.under_tread_both_ways(at),
    }
}

/// The kernel at several s in lockstep.
pub(in crate::tyre) struct LaneKernel<'a, S: Simd> {
    simd: S,
    single: [&'a KernelAt; MOST_LANES],
    stack: LaneStack<'a, S>,
    waves: Waves,
    curved: Option<(&'a CurvedWaves, CylinderAt<Lanes<S>>)>,
}

impl<'a, S: Simd> LaneKernel<'a, S> {
    /// `kernels`: of the same tyre, one per lane.
    pub(in crate::tyre) fn new(simd: S, kernels: [&'a KernelAt; MOST_LANES]) -> Self {
        let curved = kernels[0].curved.as_ref().map(|(waves, first)| {
            let at = kernels.map(|kernel| kernel.curved.as_ref().map_or(first, |(_, at)| at));
            (waves.as_ref(), CylinderAt::lanes(simd, at))
        });
        let stack = LaneStack::new(simd, kernels.map(|kernel| &kernel.stack));
        Self { simd, single: kernels, stack, waves: kernels[0].waves, curved }
    }

    /// C and D of a wave, driven on the surface, or as [`Field::UnderTread`] \[m/Pa\].
    pub(super) fn driven(&self, n: i64, m: usize, on_surface: bool) -> NormalCompliance<Lanes<S>> {
        outlined(
            self.simd,
            #[inline(always)]
            || {
                if let Some((waves, at)) = &self.curved
                    && let Some(wave) = waves.get(n, m)
                {
                    if waves.turns() {
                        let [forwards, backwards] = driven_both_ways(wave, at, on_surface);
                        return if n < 0 { backwards } else { forwards };
                    }
                    let NormalCompliance { surface, bottom } = wave.normal_at_rest(at);
                    let surface = if on_surface { surface } else { wave.under_tread_at_rest(at) };
                    return NormalCompliance { surface, bottom };
                }
                self.stack.driven(self.waves.kx(n), self.waves.ky(m), on_surface)
            },
        )
    }

    /// Parts of C and D of the waves n and -n, n >= 0, driven on the surface, or as [`Field::UnderTread`]: of the
    /// driven face, then of the innermost one \[m/Pa\].
    pub(super) fn driven_parts(&self, n: i64, m: usize, on_surface: bool) -> [Parts<Lanes<S>>; 2] {
        outlined(
            self.simd,
            #[inline(always)]
            || {
                if let Some((waves, at)) = &self.curved
                    && waves.turns()
                    && let Some(wave) = waves.get(n, m)
                {
                    let [forwards, backwards] = driven_both_ways(wave, at, on_surface);
                    return [
                        Parts::of([forwards.surface, backwards.surface]),
                        Parts::of([forwards.bottom, backwards.bottom]),
                    ];
                }
                let NormalCompliance { surface, bottom } = self.driven(n, m, on_surface);
                [Parts::even(surface), Parts::even(bottom)]
            },
        )
    }

    /// C_xz/i of a wave, C_xz the displacement of the surface along x for normal traction \[m/Pa\]; of waves that feel
    /// the tyre's curvature, one s after another.
    pub(in crate::tyre) fn tangential_over_i(&self, n: i64, m: usize) -> Lanes<S> {
        outlined(
            self.simd,
            #[inline(always)]
            || match &self.curved {
                Some((waves, _)) if waves.get(n, m).is_some() => {
                    Lanes::from_fn(self.simd, |lane| self.single[lane].tangential(n, m) * -Complex64::i())
                }
                _ => self.stack.tangential_over_i(self.waves.kx(n), self.waves.ky(m)),
            },
        )
    }

    /// Parts of C_xz of the waves n and -n, n >= 0 \[m/Pa\]: at rest all of it is odd, [`Self::tangential_over_i`].
    #[inline(always)]
    pub(in crate::tyre) fn tangential_parts(&self, n: i64, m: usize) -> Parts<Lanes<S>> {
        match &self.curved {
            Some((waves, _)) if waves.turns() && waves.get(n, m).is_some() => {
                let parts: [Parts<Complex64>; MOST_LANES] =
                    std::array::from_fn(|lane| self.single[lane].tangential_parts(n, m));
                Parts {
                    even: Lanes::from_fn(self.simd, |lane| parts[lane].even),
                    odd: Lanes::from_fn(self.simd, |lane| parts[lane].odd),
                }
            }
            _ => {
                let odd = self.tangential_over_i(n, m);
                Parts { even: odd * 0.0, odd }
            }
        }
    }

    /// C and D of a wave for normal traction \[m/Pa\].
    #[inline(always)]
    pub(super) fn normal(&self, n: i64, m: usize) -> NormalCompliance<Lanes<S>> {
        self.driven(n, m, true)
    }

    /// Motion of the inner face in the waves n and -n, n >= 0; `None`: too short to reach it.
    pub(super) fn edge_both_ways(&self, n: i64, m: usize) -> Option<[EdgeMotion<Lanes<S>>; 2]> {
        outlined(
            self.simd,
            #[inline(always)]
            || {
                let (waves, at) = self.curved.as_ref()?;
                Some(waves.get(n, m)?.edge_both_ways(at))
            },
        )
    }
}

/// C and D of the waves n and -n, driven on the surface or under the tread \[m/Pa\].
#[inline(always)]
fn driven_both_ways<T: ComplexField>(
    wave: &CylinderWave,
    at: &CylinderAt<T>,
    on_surface: bool,
) -> [NormalCompliance<T>; 2] {
    let [mut forwards, mut backwards] = wave.normal_both_ways(at);
    if !on_surface {
        [forwards.surface, backwards.surface] = wave.under_tread_both_ways(at);
    }
    [forwards, backwards]
}
