//! Products of the influence between cells with the forces on all of them, through Fourier transforms.
//!
//! With transforms longer than all distances nothing wraps round:
//! 1. rows of cells along, real, to their waves;
//! 2. these across: F(k, l);
//! 3. u_a(k, l) = sum_b T_ab(k, l) F_b(k, l) + H_ab(k, l) F_b(k, -l), since H is a function of j + j';
//! 4. back across, where the uniform parts are added, and along.

use std::f64::consts::TAU;
use std::sync::Arc;

use num_complex::Complex64;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::{Fft, FftPlanner};

use crate::counters::Work;
use crate::numeric::{transform_length, transform_multiply_adds};
use crate::tyre::influence::{COMPONENTS, TractionInfluence};

/// Forces or displacements of a cell: forward, to the left, into the tyre.
pub(crate) type Vector = [f64; COMPONENTS];

/// G in the waves of a window, with room for a product.
pub(crate) struct TractionProduct {
    columns: usize,
    across: usize,
    along: Transforms,
    forward: Arc<dyn Fft<f64>>,
    inverse: Arc<dyn Fft<f64>>,
    /// Transforms of T and H by pair, wave along and wave across; empty ones are zero.
    toeplitz: Vec<Vec<Complex64>>,
    hankel: Vec<Vec<Complex64>>,
    uniform: Option<Uniform>,
    /// Waves of the forces by component, wave along and wave across, then of displacements.
    forces: Vec<Vec<Complex64>>,
    displacements: Vec<Vec<Complex64>>,
    scratch: Vec<Complex64>,
}

/// Real transforms along with their room.
struct Transforms {
    forward: Arc<dyn RealToComplex<f64>>,
    inverse: Arc<dyn ComplexToReal<f64>>,
    real: Vec<f64>,
    waves: Vec<Complex64>,
    scratch: Vec<Complex64>,
}

/// Parts that a uniform lateral motion stands for, by wave along.
struct Uniform {
    /// Transforms of D by wave across.
    driven: [Vec<Complex64>; COMPONENTS],
    /// Those of O along alone, by cell across.
    observed: [Vec<Complex64>; COMPONENTS],
    /// Lateral motion by wave along.
    motion: Vec<Complex64>,
}

impl Transforms {
    fn new(length: usize) -> Self {
        let mut planner = RealFftPlanner::<f64>::new();
        let (forward, inverse) = (planner.plan_fft_forward(length), planner.plan_fft_inverse(length));
        let scratch = vec![Complex64::ZERO; forward.get_scratch_len().max(inverse.get_scratch_len())];
        Self { real: forward.make_input_vec(), waves: forward.make_output_vec(), forward, inverse, scratch }
    }

    /// Transforms a sequence that is 0 where it is not told.
    fn waves(&mut self, values: impl Iterator<Item = (usize, f64)>) -> &[Complex64] {
        self.real.fill(0.0);
        values.for_each(|(place, value)| self.real[place] = value);
        // Planned lengths: nothing to refuse.
        let _ = self.forward.process_with_scratch(&mut self.real, &mut self.waves, &mut self.scratch);
        &self.waves
    }

    /// Transforms waves to their sequence.
    fn sequence(&mut self, waves: impl Iterator<Item = Complex64>) -> &[f64] {
        self.waves.iter_mut().zip(waves).for_each(|(own, wave)| *own = wave);
        let last = self.waves.len() - 1;
        (self.waves[0].im, self.waves[last].im) = (0.0, 0.0);
        let _ = self.inverse.process_with_scratch(&mut self.waves, &mut self.real, &mut self.scratch);
        &self.real
    }
}

impl TractionProduct {
    /// Makes the product with an influence.
    pub(crate) fn new(influence: &TractionInfluence) -> Self {
        let TractionInfluence { columns, across, pairs, uniform } = influence;
        let (columns, across) = (*columns, *across);
        let (p, q) = (transform_length(2 * columns - 1), transform_length(2 * across - 1));
        let mut planner = FftPlanner::new();
        let (forward, inverse) = (planner.plan_fft_forward(q), planner.plan_fft_inverse(q));
        let room = forward.get_inplace_scratch_len().max(inverse.get_inplace_scratch_len());
        let mut this = Self {
            columns,
            across,
            along: Transforms::new(p),
            forward,
            inverse,
            toeplitz: Vec::new(),
            hankel: Vec::new(),
            uniform: None,
            forces: Vec::new(),
            displacements: Vec::new(),
            scratch: vec![Complex64::ZERO; room],
        };
        let width = influence.width();
        for pair in pairs {
            let toeplitz = this.transformed(&pair.toeplitz, width, |s| (s + q + 1 - across) % q);
            let hankel = this.transformed(&pair.hankel, width, |s| s);
            this.toeplitz.push(toeplitz);
            this.hankel.push(hankel);
        }
        this.uniform = uniform.as_ref().map(|uniform| Uniform {
            driven: uniform.driven.each_ref().map(|driven| this.transformed(driven, across, |j| j)),
            observed: uniform.observed.each_ref().map(|observed| this.transformed_along(observed, across)),
            motion: vec![Complex64::ZERO; p / 2 + 1],
        });
        let field = || vec![Complex64::ZERO; (p / 2 + 1) * q];
        this.forces = (0..COMPONENTS).map(|_| field()).collect();
        this.displacements = (0..COMPONENTS).map(|_| field()).collect();
        this
    }

    /// Transforms a table along whose rows stand for distances, wave by wave.
    fn transformed_along(&mut self, table: &[f64], width: usize) -> Vec<Complex64> {
        let (p, columns) = (self.along.real.len(), self.columns);
        let mut out = vec![Complex64::ZERO; if table.is_empty() { 0 } else { (p / 2 + 1) * width }];
        for place in 0..if table.is_empty() { 0 } else { width } {
            let rows = table.iter().skip(place).step_by(width).enumerate();
            let waves = self.along.waves(rows.map(|(row, &value)| ((row + p + 1 - columns) % p, value)));
            for (out, wave) in out[place..].iter_mut().step_by(width).zip(waves) {
                *out = wave / p as f64;
            }
        }
        out
    }

    /// Transforms a table along and across, its numbers across at the places told.
    fn transformed(&mut self, table: &[f64], width: usize, place: impl Fn(usize) -> usize) -> Vec<Complex64> {
        let along = self.transformed_along(table, width);
        let q = self.forward.len();
        let mut out = vec![Complex64::ZERO; along.len() / width * q];
        for (out, along) in out.chunks_exact_mut(q).zip(along.chunks_exact(width)) {
            along.iter().enumerate().for_each(|(s, &value)| out[place(s)] = value / q as f64);
        }
        self.forward.process_with_scratch(&mut out, &mut self.scratch);
        out
    }

    /// Returns the middle of the inverses of T_xx, T_yy and T_zz, (2 radius + 1)^2 by distance along and across, times
    /// `own`.
    pub(crate) fn inverse_stencils(&self, radius: usize, own: Vector) -> [Vec<f64>; COMPONENTS] {
        /// Part of the largest wave of T below which none is taken to be.
        const FLOOR: f64 = 1e-3;
        let (p, q) = (self.along.real.len(), self.forward.len());
        let cosines = |length: usize, distance: usize| -> Vec<f64> {
            (0..length).map(|wave| (TAU * (wave * distance % length) as f64 / length as f64).cos()).collect()
        };
        let of_component = |component: usize| {
            let waves = &self.toeplitz[component * (COMPONENTS + 1)];
            let largest = waves.iter().fold(0.0_f64, |largest, wave| largest.max(wave.re));
            let inverse: Vec<f64> = waves.iter().map(|wave| wave.re.max(FLOOR * largest).recip()).collect();
            let mut near = vec![0.0; (radius + 1) * (radius + 1)];
            for (place, near) in near.iter_mut().enumerate() {
                let (along, across) = (cosines(p, place / (radius + 1)), cosines(q, place % (radius + 1)));
                for (k, (row, along)) in inverse.chunks_exact(q).zip(along).enumerate() {
                    let sides = if k == 0 || 2 * k == p { 1.0 } else { 2.0 };
                    *near += sides * along * row.iter().zip(&across).map(|(value, cosine)| value * cosine).sum::<f64>();
                }
                // T is kept over its length, and so would its inverse be.
                *near *= own[component] / ((p * q) as f64).powi(2);
            }
            let width = 2 * radius + 1;
            let at =
                |place: usize| near[(place / width).abs_diff(radius) * (radius + 1) + (place % width).abs_diff(radius)];
            (0..width * width).map(at).collect()
        };
        std::array::from_fn(of_component)
    }

    /// Returns the work of a product.
    pub(crate) fn work(&self) -> Work {
        let (p, q) = (self.along.real.len(), self.forward.len());
        let fields = (2 * COMPONENTS) as f64;
        let transforms = fields
            * (0.5 * self.across as f64 * transform_multiply_adds(p) + (p / 2) as f64 * transform_multiply_adds(q));
        let pairs: usize = self.toeplitz.iter().chain(&self.hankel).map(Vec::len).sum();
        Work { multiply_adds: transforms as u64 + 4 * pairs as u64, bytes: 16 * (pairs as u64 + (6 * p * q) as u64) }
    }

    /// Finds u = G F.
    pub(crate) fn displacement(&mut self, forces: &[Vector], out: &mut [Vector]) {
        let (columns, across, q) = (self.columns, self.across, self.forward.len());
        for (component, waves) in self.forces.iter_mut().enumerate() {
            waves.fill(Complex64::ZERO);
            for j in 0..across {
                let cells = (0..columns).map(|i| (i, forces[i * across + j][component]));
                let row = self.along.waves(cells);
                waves[j..].iter_mut().step_by(q).zip(row).for_each(|(own, wave)| *own = *wave);
            }
        }
        if let Some(Uniform { observed, motion, .. }) = &mut self.uniform {
            motion.fill(Complex64::ZERO);
            for (observed, waves) in observed.iter().zip(&self.forces) {
                let rows = observed.chunks_exact(across).zip(waves.chunks_exact(q));
                for (motion, (observed, waves)) in motion.iter_mut().zip(rows) {
                    *motion += observed.iter().zip(waves).map(|(a, b)| a * b).sum::<Complex64>();
                }
            }
        }
        for waves in &mut self.forces {
            self.forward.process_with_scratch(waves, &mut self.scratch);
        }
        for (a, u) in self.displacements.iter_mut().enumerate() {
            u.fill(Complex64::ZERO);
            for (b, forces) in self.forces.iter().enumerate() {
                let pair = COMPONENTS * a + b;
                for (u, (t, f)) in u.iter_mut().zip(self.toeplitz[pair].iter().zip(forces)) {
                    *u += t * f;
                }
                let rows = self.hankel[pair].chunks_exact(q).zip(forces.chunks_exact(q));
                for (u, (h, f)) in u.chunks_exact_mut(q).zip(rows) {
                    u[0] += h[0] * f[0];
                    for (u, (h, f)) in u[1..].iter_mut().zip(h[1..].iter().zip(f[1..].iter().rev())) {
                        *u += h * f;
                    }
                }
            }
            if let Some(uniform) = &self.uniform {
                let rows = uniform.driven[a].chunks_exact(q).zip(self.forces[1].chunks_exact(q));
                for (u, (driven, f)) in u.chunks_exact_mut(q).zip(rows) {
                    u.iter_mut().zip(driven).for_each(|(u, driven)| *u -= driven * f[0]);
                }
            }
            self.inverse.process_with_scratch(u, &mut self.scratch);
            if let (1, Some(uniform)) = (a, &self.uniform) {
                for (u, motion) in u.chunks_exact_mut(q).zip(&uniform.motion) {
                    u[..across].iter_mut().for_each(|u| *u -= motion);
                }
            }
            for j in 0..across {
                let row = self.along.sequence(u[j..].iter().step_by(q).copied());
                for (out, value) in out[j..].iter_mut().step_by(across).zip(row) {
                    out[a] = *value;
                }
            }
        }
    }
}
