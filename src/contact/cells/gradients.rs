//! Projected conjugate gradients over the cells, in single precision.
//!
//! After Polonsky and Keer (Wear 231 (1999) 206-219), as for rough half-spaces, but for required displacements:
//!
//! 1. Working set A: F > 0 or u < d. Stop when |u - d| over F > 0 and d - u elsewhere are below the goal.
//! 2. Residual r = d - u on A; preconditioned residual z = (W r) on A, W a small stencil: the middle of the inverse of
//!    the free field's T.
//! 3. Direction t = z + beta t on A, beta = max(0, z.(r - r_old)/(z_old.r_old)), which forgets by itself when A changes.
//! 4. F += alpha t, alpha = r.t/(t.G t), and u += alpha G t; forces below 0 are cut, which u is told of too.
//!
//! Forces stay in double precision; products and all that is made of u - d are in single precision, since they are
//! begun anew from an exact u - d before the digits are used up.

use pulp::{Arch, Simd, WithSimd};

use super::instant::InstantCells;

/// Numbers of a vector that sums are taken over side by side.
const LANES: usize = 16;

/// How a run ended.
#[derive(Clone, Copy, Debug, Default)]
pub struct Progress {
    /// Iterations.
    pub iterations: u64,
    /// Products with G.
    pub products: u64,
    /// Forces that were cut.
    pub cuts: u64,
}

/// The method's room.
pub struct Gradients {
    arch: Arch,
    /// Cells on either side that the stencil reaches.
    radius: usize,
    /// W by distance along and across, (radius + 1)^2.
    stencil: Vec<f32>,
    /// Row length of the residual with its edges of zeros.
    stride: usize,
    /// u - d.
    pub miss: Vec<f32>,
    /// r with edges.
    residual: Vec<f32>,
    /// z.
    preconditioned: Vec<f32>,
    /// r of the iteration before.
    previous: Vec<f32>,
    /// t.
    direction: Vec<f32>,
    /// G t.
    response: Vec<f32>,
    /// What was added to forces that would have been below 0.
    cut: Vec<f32>,
}

/// W r.
struct Stencil<'a> {
    radius: usize,
    weights: &'a [f32],
    stride: usize,
    across: usize,
    residual: &'a [f32],
    out: &'a mut [f32],
}

impl WithSimd for Stencil<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        /// Vectors of a row that are summed together.
        const TOGETHER: usize = 4;
        let Self { radius, weights, stride, across, residual, out } = self;
        let lanes = S::F32_LANES;
        for (i, row) in out.chunks_exact_mut(across).enumerate() {
            for (number, out) in row.chunks_mut(TOGETHER * lanes).enumerate() {
                let first = number * TOGETHER * lanes;
                let mut sums = [simd.splat_f32s(0.0); TOGETHER];
                for a in 0..=2 * radius {
                    let weights = &weights[a.abs_diff(radius) * (radius + 1)..][..=radius];
                    let line = &residual[(i + a) * stride + first..];
                    for b in 0..=2 * radius {
                        let weight = simd.splat_f32s(weights[b.abs_diff(radius)]);
                        let (vectors, _) = S::as_simd_f32s(&line[b..b + TOGETHER * lanes]);
                        for (sum, &vector) in sums.iter_mut().zip(vectors) {
                            *sum = simd.mul_add_e_f32s(weight, vector, *sum);
                        }
                    }
                }
                for (out, sum) in out.chunks_mut(lanes).zip(sums) {
                    simd.partial_store_f32s(out, sum);
                }
            }
        }
    }
}

/// Sums side by side, so that none waits for the other.
#[inline(always)]
fn sum(values: impl Iterator<Item = f32>) -> f32 {
    let mut lanes = [0.0_f32; LANES];
    for (number, value) in values.enumerate() {
        lanes[number % LANES] += value;
    }
    lanes.into_iter().sum()
}

impl Gradients {
    /// For a window, with a stencil that reaches so far.
    pub fn new(cells: &InstantCells, radius: usize) -> Self {
        let (columns, across) = (cells.columns(), cells.across());
        let stride = across.next_multiple_of(4 * LANES) + 2 * radius;
        let zeros = || vec![0.0; columns * across];
        Self {
            arch: Arch::new(),
            radius,
            stencil: cells.inverse_stencil(radius),
            stride,
            miss: zeros(),
            residual: vec![0.0; (columns + 2 * radius) * stride],
            preconditioned: zeros(),
            previous: zeros(),
            direction: zeros(),
            response: zeros(),
            cut: zeros(),
        }
    }

    /// Improves the forces, of which `miss` is u - d, until the conditions are met to `goal` or after `most` iterations.
    pub fn run(&mut self, cells: &mut InstantCells, forces: &mut [f64], goal: f32, most: u64) -> Progress {
        let mut progress = Progress::default();
        let across = cells.across();
        let mut last = 0.0;
        self.direction.fill(0.0);
        self.previous.fill(0.0);
        while progress.iterations < most && self.set_residual(forces, across) > goal {
            progress.iterations += 1;
            let Self { arch, radius, stencil, stride, residual, preconditioned, .. } = self;
            let (radius, stride) = (*radius, *stride);
            arch.dispatch(Stencil { radius, weights: stencil, stride, across, residual, out: preconditioned });
            let (along, product) = self.direct(forces, across, last);
            last = product;
            cells.single_displacement(&self.direction, &mut self.response);
            progress.products += 1;
            let curvature = sum(self.direction.iter().zip(&self.response).map(|(t, q)| t * q));
            let length = along / curvature;
            if !(length.is_finite() && product > 0.0) {
                break;
            }
            let cuts = self.advance(forces, length);
            if cuts > 0 {
                progress.cuts += cuts;
                self.take_back(cells, cuts, &mut progress);
            }
        }
        progress
    }

    /// r on A; how far the conditions are missed.
    fn set_residual(&mut self, forces: &[f64], across: usize) -> f32 {
        let lines = self.residual[self.radius * self.stride..].chunks_exact_mut(self.stride);
        let mut worst = [0.0_f32; LANES];
        for ((line, miss), forces) in lines.zip(self.miss.chunks_exact(across)).zip(forces.chunks_exact(across)) {
            let line = &mut line[self.radius..self.radius + across];
            for (number, ((r, &miss), &force)) in line.iter_mut().zip(miss).zip(forces).enumerate() {
                *r = if force > 0.0 || miss < 0.0 { -miss } else { 0.0 };
                worst[number % LANES] = worst[number % LANES].max(r.abs());
            }
        }
        worst.into_iter().fold(0.0, f32::max)
    }

    /// t from z; r.t and z.r.
    fn direct(&mut self, forces: &[f64], across: usize, last: f32) -> (f32, f32) {
        let Self { radius, stride, residual, preconditioned, previous, direction, miss, .. } = self;
        let (mut product, mut change) = ([0.0_f32; LANES], [0.0_f32; LANES]);
        let lines = || residual[*radius * *stride..].chunks_exact(*stride).map(|line| &line[*radius..*radius + across]);
        let rows = preconditioned.chunks_exact_mut(across).zip(previous.chunks_exact_mut(across));
        let given = miss.chunks_exact(across).zip(forces.chunks_exact(across));
        for ((line, (z, previous)), (miss, forces)) in lines().zip(rows).zip(given) {
            let given = miss.iter().zip(forces);
            for (number, (((&r, z), previous), (&miss, &force))) in
                line.iter().zip(z).zip(previous).zip(given).enumerate()
            {
                *z = if force > 0.0 || miss < 0.0 { *z } else { 0.0 };
                product[number % LANES] += *z * r;
                change[number % LANES] += *z * (r - *previous);
                *previous = r;
            }
        }
        let (product, change): (f32, f32) = (product.into_iter().sum(), change.into_iter().sum());
        let beta = if last > 0.0 { (change / last).max(0.0) } else { 0.0 };
        let mut along = [0.0_f32; LANES];
        let rows = preconditioned.chunks_exact(across).zip(direction.chunks_exact_mut(across));
        let given = miss.chunks_exact(across).zip(forces.chunks_exact(across));
        for ((line, (z, t)), (miss, forces)) in lines().zip(rows).zip(given) {
            let given = miss.iter().zip(forces);
            for (number, (((&r, &z), t), (&miss, &force))) in line.iter().zip(z).zip(t).zip(given).enumerate() {
                *t = if force > 0.0 || miss < 0.0 { z + beta * *t } else { 0.0 };
                along[number % LANES] += r * *t;
            }
        }
        (along.into_iter().sum(), product)
    }

    /// A step along t; how many forces were cut.
    fn advance(&mut self, forces: &mut [f64], length: f32) -> u64 {
        let mut cuts = 0;
        let values = self.miss.iter_mut().zip(&self.response).zip(&self.direction).zip(&mut self.cut);
        for (force, (((miss, &response), &t), cut)) in forces.iter_mut().zip(values) {
            *miss += length * response;
            let next = *force + f64::from(length * t);
            *force = next.max(0.0);
            *cut = (*force - next) as f32;
            cuts += u64::from(next < 0.0);
        }
        cuts
    }

    /// Tells u of the cuts: a few one by one, many by a product.
    fn take_back(&mut self, cells: &mut InstantCells, cuts: u64, progress: &mut Progress) {
        /// Cuts that take the time of a product.
        const MANY: u64 = 48;
        if cuts > MANY {
            cells.single_displacement(&self.cut, &mut self.response);
            progress.products += 1;
            self.miss.iter_mut().zip(&self.response).for_each(|(miss, response)| *miss += response);
        } else {
            for (cell, &cut) in self.cut.iter().enumerate().filter(|(_, cut)| **cut > 0.0) {
                cells.add_single_force(cell, cut, &mut self.miss);
            }
        }
    }
}
