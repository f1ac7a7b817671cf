//! Displacements by the forces of the last block and of this one: a short convolution, by Fourier transforms.
//!
//! An instant's forces and displacements are restricted to a window of C columns, which has moved on by at most some
//! elements a step since the earliest forces that count. On a ring of M elements, M at least twice as long as the
//! window and the distance moved together, no distance between a force and a column of the window is taken for
//! another, so that the ring may stand for the tyre's of N elements; where that is not longer it is taken itself.
//! Influence is an even function of distance, and its spectrum real. Of a tyre that turns it is uneven, and the
//! spectrum has imaginary parts.
//!
//! Cost of an instant: two real transforms of length M, and M fused multiply-adds for each earlier instant, 2 M if the
//! tyre turns. At N = 1024 that is a tenth of the cost of the sum over points and columns, which it replaces; rounding
//! is relative to the largest displacement of the ring.

use std::sync::Arc;

use num_complex::Complex64;
use pulp::{Arch, Simd, WithSimd};
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};

use crate::counters::Work;
use crate::numeric::{transform_length, transform_multiply_adds};

/// Spectra are filled up to whole vectors of any processor.
const LANES: usize = 8;

/// Elements of the ring for windows of `columns` columns that move on by `way` elements, on a tyre of `elements`.
fn ring_length(elements: usize, columns: usize, way: usize) -> usize {
    transform_length(2 * (columns + way)).min(elements)
}

/// Numbers in the spectrum of a real sequence, padded to whole vectors.
const fn padded(ring: usize) -> usize {
    (ring / 2 + 1).next_multiple_of(LANES)
}

/// Forces at the latest instants by wavenumber, and their influence on each other.
pub(super) struct NearForces {
    ring: usize,
    /// Spectra of the influence by stage of the force and lag, divided by the ring's length.
    influence: Vec<f64>,
    /// Imaginary parts of these spectra; empty where influence is even.
    odd: Vec<f64>,
    lags: usize,
    /// Spectra of the forces by instant: real parts, imaginary parts.
    forces: Vec<f64>,
    forward: Arc<dyn RealToComplex<f64>>,
    inverse: Arc<dyn ComplexToReal<f64>>,
    /// Forces or displacements on the ring.
    field: Vec<f64>,
    spectrum: Vec<Complex64>,
    sums: Vec<f64>,
    scratch: Vec<Complex64>,
    arch: Arch,
}

impl NearForces {
    /// No forces, with space for `instants` of them. `influence`: by stage of the force and lag, all of one stage
    /// together, on the tyre's elements by distance \[m/N\]; windows have at most `columns` columns and move on by at
    /// most `way` elements from the earliest instant to the latest. `uneven`: influence differs forwards and
    /// backwards.
    pub(super) fn new(
        influence: &[Vec<f64>],
        lags: usize,
        instants: usize,
        columns: usize,
        way: usize,
        uneven: bool,
    ) -> Self {
        let elements = influence.first().map_or(2, Vec::len);
        let ring = ring_length(elements, columns, way);
        let mut planner = RealFftPlanner::<f64>::new();
        let (forward, inverse) = (planner.plan_fft_forward(ring), planner.plan_fft_inverse(ring));
        let scratch = vec![Complex64::ZERO; forward.get_scratch_len().max(inverse.get_scratch_len())];
        let mut near = Self {
            ring,
            influence: Vec::with_capacity(influence.len() * padded(ring)),
            odd: Vec::with_capacity(if uneven { influence.len() * padded(ring) } else { 0 }),
            lags,
            forces: vec![0.0; 2 * padded(ring) * instants],
            field: forward.make_input_vec(),
            spectrum: forward.make_output_vec(),
            sums: vec![0.0; 2 * padded(ring)],
            forward,
            inverse,
            scratch,
            arch: Arch::new(),
        };
        let scale = (ring as f64).recip();
        for influence in influence {
            for (position, value) in near.field.iter_mut().enumerate() {
                let backwards = ring - position;
                let mirrored = if uneven { elements - backwards } else { backwards };
                *value = scale * influence[if position < backwards { position } else { mirrored }];
            }
            near.transform();
            near.influence.extend(near.spectrum.iter().map(|value| value.re));
            near.influence.resize(near.influence.len().next_multiple_of(LANES), 0.0);
            if uneven {
                near.odd.extend(near.spectrum.iter().map(|value| value.im));
                near.odd.resize(near.influence.len(), 0.0);
            }
        }
        near
    }

    /// Transforms [`Self::field`] to its spectrum.
    fn transform(&mut self) {
        let Self { forward, field, spectrum, scratch, .. } = self;
        // Planned lengths: nothing to refuse.
        let _ = forward.process_with_scratch(field, spectrum, scratch);
    }

    /// Takes in an instant's forces \[N\], given as (element, force).
    pub(super) fn take(&mut self, instant: usize, forces: impl Iterator<Item = (i64, f64)>) {
        self.field.fill(0.0);
        for (element, force) in forces {
            self.field[element.rem_euclid(self.ring as i64) as usize] = force;
        }
        self.transform();
        let padded = padded(self.ring);
        let (real, imaginary) = self.forces[2 * padded * instant..][..2 * padded].split_at_mut(padded);
        for ((real, imaginary), value) in real.iter_mut().zip(imaginary).zip(&self.spectrum) {
            (*real, *imaginary) = (value.re, value.im);
        }
    }

    /// Forgets the first half of the instants; the second takes its place.
    pub(super) fn turn(&mut self) {
        let half = self.forces.len() / 2;
        self.forces.copy_within(half.., 0);
    }

    /// Adds to `out` the displacements by the forces of all instants before `now` \[m\]; `first`: element that `out`
    /// begins with.
    pub(super) fn add_displacement(&mut self, now: usize, first: i64, out: &mut [f64]) {
        let Self { ring, influence, odd, lags, forces, sums, arch, .. } = self;
        let stages = influence.len() / (*lags * padded(*ring));
        arch.dispatch(Products { influence, odd, forces, sums, padded: padded(*ring), lags: *lags, stages, now });
        let (real, imaginary) = self.sums.split_at(padded(self.ring));
        for ((value, &re), &im) in self.spectrum.iter_mut().zip(real).zip(imaginary) {
            *value = Complex64::new(re, im);
        }
        let last = self.spectrum.len() - 1;
        (self.spectrum[0].im, self.spectrum[last].im) = (0.0, 0.0);
        // Planned lengths, and the ends are real: nothing to refuse.
        let _ = self.inverse.process_with_scratch(&mut self.spectrum, &mut self.field, &mut self.scratch);
        let (behind, ahead) = self.field.split_at(first.rem_euclid(self.ring as i64) as usize);
        out.iter_mut().zip(ahead.iter().chain(behind)).for_each(|(out, near)| *out += near);
    }

    /// Work of [`Self::take`] and [`Self::add_displacement`] together.
    pub(super) fn work(&self, now: usize) -> Work {
        let uneven = !self.odd.is_empty();
        let multiply_adds = expected_multiply_adds(self.ring, now as f64, uneven) as u64;
        // Real and imaginary parts of the forces beside the influence; transforms as the far field counts them.
        let parts = if uneven { 4 } else { 3 };
        Work { multiply_adds, bytes: (8 * (parts * now * padded(self.ring) + 6 * self.ring)) as u64 }
    }
}

/// Multiply-adds of an instant that sums `seen` earlier ones, and the numbers of a real spectrum.
pub(super) fn expected(elements: usize, columns: usize, way: usize, seen: f64, uneven: bool) -> (f64, f64) {
    let ring = ring_length(elements, columns, way);
    (expected_multiply_adds(ring, seen, uneven), padded(ring) as f64)
}

fn expected_multiply_adds(ring: usize, seen: f64, uneven: bool) -> f64 {
    transform_multiply_adds(ring) + seen * (if uneven { 4 } else { 2 } * padded(ring)) as f64
}

/// sum over the instants before `now` of influence times forces.
struct Products<'a> {
    influence: &'a [f64],
    odd: &'a [f64],
    forces: &'a [f64],
    sums: &'a mut [f64],
    padded: usize,
    lags: usize,
    stages: usize,
    now: usize,
}

impl WithSimd for Products<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        if self.odd.is_empty() { self.add::<S, false>(simd) } else { self.add::<S, true>(simd) }
    }
}

impl Products<'_> {
    #[inline(always)]
    fn add<S: Simd, const UNEVEN: bool>(self, simd: S) {
        let Self { influence, odd, forces, sums, padded, lags, stages, now } = self;
        let (influence, _) = S::as_simd_f64s(influence);
        let (odd, _) = S::as_simd_f64s(odd);
        let (forces, _) = S::as_simd_f64s(forces);
        let (sums, _) = S::as_mut_simd_f64s(sums);
        let vectors = padded / S::F64_LANES;
        let (real_sums, imaginary_sums) = sums.split_at_mut(vectors);
        for (v, (real_sum, imaginary_sum)) in real_sums.iter_mut().zip(imaginary_sums).enumerate() {
            let (mut re, mut im) = (simd.splat_f64s(0.0), simd.splat_f64s(0.0));
            for (earlier, forces) in forces.chunks_exact(2 * vectors).take(now).enumerate() {
                let row = (earlier % stages) * lags + now - earlier - 1;
                let influence = influence[row * vectors + v];
                re = simd.mul_add_e_f64s(influence, forces[v], re);
                im = simd.mul_add_e_f64s(influence, forces[vectors + v], im);
                if UNEVEN {
                    let odd = odd[row * vectors + v];
                    re = simd.negate_mul_add_e_f64s(odd, forces[vectors + v], re);
                    im = simd.mul_add_e_f64s(odd, forces[v], im);
                }
            }
            (*real_sum, *imaginary_sum) = (re, im);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Forces of windows that move on, compared with the sum over points and columns, with influence that is even and
    /// with influence that is not.
    #[test]
    fn the_ring_stands_for_the_tyre() {
        const COLUMNS: usize = 11;
        let (stages, lags, instants, elements) = (2, 7, 8, 96_usize);
        for (columns, ring, uneven) in
            [(COLUMNS, 30, false), (elements, elements, false), (COLUMNS, 30, true), (elements, elements, true)]
        {
            let of = |row: usize, j: i64| {
                let skew = if uneven { 0.2 * (0.7 * j as f64).sin() } else { 0.0 };
                (-(j.abs() as f64) / (2.0 + row as f64)).exp() * ((0.3 * (row as i64 * j) as f64).cos() + skew)
            };
            let influence: Vec<Vec<f64>> = (0..stages * lags)
                .map(|row| (0..96).map(|j| of(row, if j < 48 { j } else { j - 96 })).collect())
                .collect();
            let mut near = NearForces::new(&influence, lags, instants, columns, instants / stages, uneven);
            assert_eq!((near.ring, near.odd.is_empty()), (ring, !uneven));
            // The window passes the end of both rings.
            let first = |instant: usize| 85 + (instant / stages) as i64;
            let force = |instant: usize, column: usize| ((3 * instant + column * column) as f64).sin();
            for instant in 0..instants {
                let mut out = [0.5; COLUMNS];
                near.add_displacement(instant, first(instant), &mut out);
                for (column, out) in out.iter().enumerate() {
                    let mut exact = 0.5;
                    for earlier in 0..instant {
                        let row = (earlier % stages) * lags + instant - earlier - 1;
                        for point in 0..COLUMNS {
                            let distance = first(instant) + column as i64 - first(earlier) - point as i64;
                            exact += of(row, distance) * force(earlier, point);
                        }
                    }
                    assert!((out - exact).abs() < 1e-13, "{instant}, {column}: {out} {exact}");
                }
                near.take(instant, (0..COLUMNS).map(|c| (first(instant) + c as i64, force(instant, c))));
            }
            let seen = if uneven { 4 } else { 2 };
            let more = near.work(5).multiply_adds - near.work(4).multiply_adds;
            assert_eq!(more, (seen * padded(ring)) as u64);
        }
    }
}
