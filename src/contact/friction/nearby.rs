//! Forces that nearly displace cells as asked for, from what is near each cell: the preconditioner of linear equations.
//!
//! Each component by itself: the middle of the inverse of its free field T, without the tyre's sides. Vectors hold
//! cells across.

use std::f64::consts::TAU;
use std::ops::Range;

use num_complex::Complex64;
use pulp::{Arch, Simd, WithSimd};

use super::product::{Vector, transformed};
use crate::numeric::Element;
use crate::tyre::influence::{COMPONENTS, TractionInfluence};

/// Cells on either side that an inverse is taken of.
const RADIUS: usize = 2;
/// Cells that a stencil is wide.
const WIDTH: usize = 2 * RADIUS + 1;

/// Inverses of the free fields near a cell, with room for a product.
pub(super) struct NearbyInverse {
    arch: Arch,
    columns: usize,
    across: usize,
    /// Cells of a row with room on either side, and in whole vectors.
    stride: usize,
    row: usize,
    /// By component, distance along and across.
    stencils: [Vec<f64>; COMPONENTS],
    /// By component and column, from `RADIUS` columns before the first one on.
    asked: Vec<f64>,
    /// By component and column.
    found: Vec<f64>,
}

/// Returns the middle of the inverses of the free fields T_xx, T_yy and T_zz, `WIDTH`^2 by distance along and across,
/// times `own`.
fn inverse_stencils(influence: &TractionInfluence, own: Vector) -> [Vec<f64>; COMPONENTS] {
    /// Part of the largest wave of T below which none is taken to be.
    const FLOOR: f64 = 1e-3;
    let (columns, across) = (influence.columns, influence.across);
    let (p, q) = (2 * columns - 1, 2 * across - 1);
    let cosine = |phase: usize, length: usize| (TAU * (phase % length) as f64 / length as f64).cos();
    let of_component = |component: usize| {
        let along = transformed(&influence.pairs[component * (COMPONENTS + 1)].toeplitz, q, columns);
        // T is even along and across.
        let of_wave = |row: &[Complex64]| -> Vec<f64> {
            let value = |l: usize| row.iter().enumerate().map(|(s, t)| t.re * cosine(l * (s + across), q)).sum();
            (0..q).map(value).collect()
        };
        let waves: Vec<f64> = along.chunks_exact(q).flat_map(of_wave).collect();
        let largest = waves.iter().fold(0.0_f64, |largest, wave| largest.max(*wave));
        let near = |i: usize, j: usize| -> f64 {
            let wave = |(place, wave): (usize, &f64)| {
                let (k, l) = (place / q, place % q);
                let sides = if k == 0 { 1.0 } else { 2.0 };
                sides * cosine(k * i, p) * cosine(l * j, q) / wave.max(FLOOR * largest)
            };
            own[component] / (p * q) as f64 * waves.iter().enumerate().map(wave).sum::<f64>()
        };
        let quarter: Vec<f64> =
            (0..=RADIUS).flat_map(|i| (0..=RADIUS).map(move |j| (i, j))).map(|(i, j)| near(i, j)).collect();
        let at =
            |place: usize| quarter[(place / WIDTH).abs_diff(RADIUS) * (RADIUS + 1) + (place % WIDTH).abs_diff(RADIUS)];
        (0..WIDTH * WIDTH).map(at).collect()
    };
    std::array::from_fn(of_component)
}

impl NearbyInverse {
    /// Makes the inverses of an influence; `own` is that of a cell on itself \[m/N\].
    pub(super) fn new(influence: &TractionInfluence, own: Vector) -> Self {
        let (columns, across) = (influence.columns, influence.across);
        let row = across.next_multiple_of(f64::MOST_LANES);
        let stride = row + 2 * RADIUS;
        Self {
            arch: Arch::new(),
            columns,
            across,
            stride,
            row,
            stencils: inverse_stencils(influence, own),
            asked: vec![0.0; COMPONENTS * (columns + 2 * RADIUS) * stride],
            found: vec![0.0; COMPONENTS * columns * row],
        }
    }

    /// Returns the value of a component at a cell, to be asked for.
    pub(super) fn ask(&mut self, cell: usize, component: usize) -> &mut f64 {
        let (column, j) = (cell / self.across, cell % self.across);
        &mut self.asked[(component * (self.columns + 2 * RADIUS) + column + RADIUS) * self.stride + RADIUS + j]
    }

    /// Returns what was found for a component at a cell.
    pub(super) fn found(&self, cell: usize, component: usize) -> f64 {
        self.found[(component * self.columns + cell / self.across) * self.row + cell % self.across]
    }

    /// Finds the values of some columns.
    pub(super) fn find(&mut self, columns: Range<usize>) {
        let arch = self.arch;
        arch.dispatch(Find { nearby: self, columns });
    }
}

/// Products of some columns.
struct Find<'a> {
    nearby: &'a mut NearbyInverse,
    columns: Range<usize>,
}

impl WithSimd for Find<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { nearby: NearbyInverse { columns, stride, row, stencils, asked, found, .. }, columns: range } = self;
        let lanes = f64::lanes::<S>();
        for component in 0..COMPONENTS {
            let weights = &stencils[component];
            for column in range.start..range.end {
                let out = &mut found[(component * *columns + column) * *row..][..*row];
                let asked = &asked[(component * (*columns + 2 * RADIUS) + column) * *stride..][..WIDTH * *stride];
                for first in (0..*row).step_by(lanes) {
                    let mut sum = simd.splat_f64s(0.0);
                    for a in 0..WIDTH {
                        for b in 0..WIDTH {
                            let near = f64::load(simd, &asked[a * *stride + b + first..][..lanes]);
                            sum = simd.mul_add_e_f64s(simd.splat_f64s(weights[a * WIDTH + b]), near, sum);
                        }
                    }
                    f64::store(simd, &mut out[first..first + lanes], sum);
                }
            }
        }
    }
}
