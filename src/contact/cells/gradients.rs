//! Projected conjugate gradients over the cells, in single precision.
//!
//! After Polonsky and Keer (Wear 231 (1999) 206-219), as for rough half-spaces, but for required displacements:
//!
//! 1. Working set A: F > 0 or u < d. Stop when |u - d| over F > 0 and d - u elsewhere are below the goal.
//! 2. Residual r = d - u on A; preconditioned residual z = (W r) on A, W a small stencil: the middle of the inverse of
//!    the free field's T. Where blocks yield it takes these into account (`block_shares`).
//! 3. Direction t = z + beta t on A, beta = max(0, z.(r - r_old)/(z_old.r_old)), but nowhere negative where F = 0: it
//!    restarts by itself when A changes.
//! 4. F += alpha t, alpha = r.t/(t.G t), and u += alpha G t; forces below 0 are cut, which u is corrected for.
//!
//! Forces stay in double precision; products and all that is made of u - d are in single precision, since they are
//! restarted from an exact u - d before the digits are used up.

use pulp::{Arch, Simd, WithSimd};

use super::block_shares::BlockShares;
use super::filter::Filter;
use super::instant::InstantCells;

/// Numbers of a vector that sums are taken over side by side.
const LANES: usize = 16;

/// How a run ended.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct GradientProgress {
    /// Iterations.
    pub iterations: u64,
    /// Products with G.
    pub products: u64,
    /// Forces that were cut.
    pub cuts: u64,
    /// How far the conditions are missed, as far as single precision can resolve \[m\].
    pub residual: f32,
}

/// Scratch of the method; whole vectors of cells, zeros behind the last one.
pub(super) struct Gradients {
    arch: Arch,
    /// Cells of the part of the window that is considered.
    count: usize,
    filter: Filter<f32>,
    /// u - d.
    miss: Vec<f32>,
    /// F.
    forces: Vec<f64>,
    /// r.
    residual: Vec<f32>,
    /// z.
    preconditioned: Vec<f32>,
    /// r of the iteration before.
    previous: Vec<f32>,
    /// t.
    direction: Vec<f32>,
    /// G t.
    response: Vec<f32>,
    /// z_old.r_old; 0: there is no direction to go on from.
    last: f32,
    /// Cuts of forces that would have been below 0.
    cut: Vec<f32>,
    /// Blocks that yield, where the tread has some.
    blocks: Option<Box<BlockShares>>,
}

/// A pass over all cells, compiled for the processor's instructions; loops go over the numbers of whole vectors side
/// by side, so that no sum waits for another.
enum VectorPass {
    /// r on A; how far the conditions are missed.
    Residual,
    /// z on A; z.r and z.(r - r_old).
    Precondition,
    /// t from z with beta; r.t.
    Direct(f32),
    /// t.G t.
    Curvature,
    /// A step along t of this length; how many forces were cut.
    Advance(f32),
}

struct Dispatched<'a> {
    gradients: &'a mut Gradients,
    pass: VectorPass,
}

impl WithSimd for Dispatched<'_> {
    type Output = [f32; 2];

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> [f32; 2] {
        let Gradients { count, miss, forces, residual, preconditioned, previous, direction, response, cut, .. } =
            self.gradients;
        // Entries behind belong to longer parts.
        let padded = 0..count.next_multiple_of(LANES);
        let miss = miss[padded.clone()].as_chunks_mut::<LANES>().0;
        let forces = forces[padded.clone()].as_chunks_mut::<LANES>().0;
        let r = residual[padded.clone()].as_chunks_mut::<LANES>().0;
        let z = preconditioned[padded.clone()].as_chunks_mut::<LANES>().0;
        let previous = previous[padded.clone()].as_chunks_mut::<LANES>().0;
        let t = direction[padded.clone()].as_chunks_mut::<LANES>().0;
        let response = response[padded.clone()].as_chunks::<LANES>().0;
        let cut = cut[padded].as_chunks_mut::<LANES>().0;
        let [mut first, mut second] = [[0.0_f32; LANES]; 2];
        let total = |sums: [f32; LANES]| sums.into_iter().sum::<f32>();
        match self.pass {
            VectorPass::Residual => {
                for ((r, miss), forces) in r.iter_mut().zip(miss).zip(forces) {
                    for lane in 0..LANES {
                        let touches = (forces[lane] > 0.0) | (miss[lane] < 0.0);
                        r[lane] = if touches { -miss[lane] } else { 0.0 };
                        let size = r[lane].abs();
                        first[lane] = if size > first[lane] { size } else { first[lane] };
                    }
                }
                [first.into_iter().fold(0.0, f32::max), 0.0]
            }
            VectorPass::Precondition => {
                for ((r, z), previous) in r.iter().zip(z).zip(previous) {
                    for lane in 0..LANES {
                        z[lane] = if r[lane].abs() > 0.0 { z[lane] } else { 0.0 };
                        first[lane] += z[lane] * r[lane];
                        second[lane] += z[lane] * (r[lane] - previous[lane]);
                        previous[lane] = r[lane];
                    }
                }
                [total(first), total(second)]
            }
            VectorPass::Direct(beta) => {
                for ((r, forces), (z, t)) in r.iter().zip(forces).zip(z.iter().zip(t)) {
                    for lane in 0..LANES {
                        let next = if r[lane].abs() > 0.0 { z[lane] + beta * t[lane] } else { 0.0 };
                        // A cell that is about to touch is not pulled: that would be cut off again and again.
                        t[lane] = if (forces[lane] > 0.0) | (next > 0.0) { next } else { 0.0 };
                        first[lane] += r[lane] * t[lane];
                    }
                }
                [total(first), 0.0]
            }
            VectorPass::Curvature => {
                for (t, response) in t.iter().zip(response) {
                    for lane in 0..LANES {
                        first[lane] += t[lane] * response[lane];
                    }
                }
                [total(first), 0.0]
            }
            VectorPass::Advance(length) => {
                let steps = t.iter().zip(response);
                for (((miss, forces), cut), (t, response)) in miss.iter_mut().zip(forces).zip(cut).zip(steps) {
                    for lane in 0..LANES {
                        miss[lane] += length * response[lane];
                        let next = forces[lane] + f64::from(length * t[lane]);
                        let clipped = if next > 0.0 { next } else { 0.0 };
                        forces[lane] = clipped;
                        cut[lane] = (clipped - next) as f32;
                        first[lane] += if next < 0.0 { 1.0 } else { 0.0 };
                    }
                }
                [total(first), 0.0]
            }
        }
    }
}

impl Gradients {
    pub(super) fn new(cells: &InstantCells, radius: usize) -> Self {
        let padded = cells.cells().next_multiple_of(LANES);
        let zeros = || vec![0.0; padded];
        Self {
            arch: Arch::new(),
            count: 0,
            filter: Filter::new([cells.columns(), cells.across()], radius, cells.inverse_stencil(radius)),
            miss: zeros(),
            forces: vec![0.0; padded],
            residual: zeros(),
            preconditioned: zeros(),
            previous: zeros(),
            direction: zeros(),
            response: zeros(),
            cut: zeros(),
            last: 0.0,
            blocks: cells.blocks().map(|_| Box::default()),
        }
    }

    /// Begins with forces whose u - d is not known on a part of the window: u to single precision.
    pub(super) fn begin(&mut self, cells: &mut InstantCells, required: &[f64], forces: &[f64]) {
        self.hold(forces.len());
        self.cut.iter_mut().zip(forces).for_each(|(single, force)| *single = *force as f32);
        cells.single_displacement(&self.cut[..self.count], &mut self.response[..self.count]);
        for ((miss, &u), &d) in self.miss.iter_mut().zip(&self.response).zip(required) {
            *miss = (f64::from(u) - d) as f32;
        }
    }

    /// Continues from an exact u on a part of the window: in the last direction, where the part is the previous one,
    /// or `anew`.
    pub(super) fn resume(&mut self, required: &[f64], displacement: &[f64], anew: bool) {
        if anew {
            self.hold(required.len());
        }
        for ((miss, &u), &d) in self.miss.iter_mut().zip(displacement).zip(required) {
            *miss = (u - d) as f32;
        }
    }

    /// u to single precision, of the forces that the last run has found.
    pub(super) fn displacement(&self, required: &[f64], out: &mut [f64]) {
        for ((u, &miss), d) in out.iter_mut().zip(&self.miss).zip(required) {
            *u = d + f64::from(miss);
        }
    }

    /// Takes a part of `count` cells, with zeros behind them, and forgets the last direction.
    fn hold(&mut self, count: usize) {
        let behind = count..count.next_multiple_of(LANES);
        (self.count, self.last) = (count, 0.0);
        self.direction[..behind.end].fill(0.0);
        self.previous[..behind.end].fill(0.0);
        self.forces[behind.clone()].fill(0.0);
        for cells in [&mut self.miss, &mut self.preconditioned, &mut self.response, &mut self.cut] {
            cells[behind.clone()].fill(0.0);
        }
    }

    fn pass(&mut self, pass: VectorPass) -> [f32; 2] {
        let arch = self.arch;
        arch.dispatch(Dispatched { gradients: self, pass })
    }

    /// Improves the forces on the part of the window until the conditions are met to `goal` or after `most` iterations.
    pub(super) fn run(
        &mut self,
        cells: &mut InstantCells,
        forces: &mut [f64],
        goal: f32,
        most: u64,
    ) -> GradientProgress {
        let mut progress = GradientProgress::default();
        let count = forces.len();
        self.forces[..count].copy_from_slice(forces);
        loop {
            progress.residual = self.pass(VectorPass::Residual)[0];
            if progress.iterations == most || progress.residual <= goal {
                break;
            }
            if let (0, Some(shares), Some(blocks)) = (progress.iterations, &mut self.blocks, cells.blocks()) {
                shares.take(blocks, &self.filter, &self.residual[..count]);
            }
            progress.iterations += 1;
            self.precondition(count);
            let [mut product, mut change] = self.pass(VectorPass::Precondition);
            if product <= 0.0 {
                // W cut down to A need not be positive definite; the residual itself always leads on.
                self.preconditioned.copy_from_slice(&self.residual);
                self.last = 0.0;
                [product, change] = self.pass(VectorPass::Precondition);
            }
            let beta = if self.last > 0.0 { (change / self.last).max(0.0) } else { 0.0 };
            self.last = product;
            let [mut along, _] = self.pass(VectorPass::Direct(beta));
            if along <= 0.0 {
                [along, _] = self.pass(VectorPass::Direct(0.0));
            }
            cells.single_displacement(&self.direction[..count], &mut self.response[..count]);
            progress.products += 1;
            let length = along / self.pass(VectorPass::Curvature)[0];
            if !(length.is_finite() && product > 0.0) {
                break;
            }
            let cuts = self.pass(VectorPass::Advance(length))[0] as u64;
            if cuts > 0 {
                progress.cuts += cuts;
                self.take_back(cells, count, cuts, &mut progress);
            }
        }
        forces.copy_from_slice(&self.forces[..count]);
        progress
    }

    /// Computes z, also off A.
    fn precondition(&mut self, count: usize) {
        let (residual, z) = (&self.residual[..count], &mut self.preconditioned[..count]);
        let remaining = self.blocks.as_mut().map_or(residual, |blocks| blocks.taken_off(residual));
        self.filter.apply(remaining, z);
    }

    /// Corrects u for the cuts: a few one by one, many by a product.
    fn take_back(&mut self, cells: &mut InstantCells, count: usize, cuts: u64, progress: &mut GradientProgress) {
        /// Cuts that take the time of a product.
        const MANY: u64 = 24;
        if cuts > MANY {
            cells.single_displacement(&self.cut[..count], &mut self.response[..count]);
            progress.products += 1;
            self.miss[..count].iter_mut().zip(&self.response).for_each(|(miss, response)| *miss += response);
        } else {
            for (cell, &cut) in self.cut[..count].iter().enumerate().filter(|(_, cut)| **cut > 0.0) {
                cells.add_single_force(cell, cut, &mut self.miss[..count]);
            }
        }
    }
}
