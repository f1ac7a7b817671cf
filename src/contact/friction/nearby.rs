//! Forces that approximately displace cells as asked for, from the neighbourhood of each cell: the preconditioner of
//! linear equations.
//!
//! Each component by itself: the middle of the inverse of its free field T, without the tyre's sides.

use std::f64::consts::TAU;
use std::ops::Range;

use num_complex::Complex64;

use super::product::{Vector, transformed};
use crate::contact::cells::filter::Filter;
use crate::tyre::influence::{COMPONENTS, TractionInfluence};

/// Cells on either side that the stencil of an inverse covers.
const RADIUS: usize = 2;

pub(super) struct NearbyInverse {
    filters: [Filter<f64>; COMPONENTS],
    /// By component, cell by cell.
    asked: [Vec<f64>; COMPONENTS],
    found: [Vec<f64>; COMPONENTS],
}

/// Middle of the inverses of the free fields T_xx, T_yy and T_zz, by distance along and across, (`RADIUS` + 1)^2,
/// times `diagonal`.
fn inverse_stencils(influence: &TractionInfluence, diagonal: Vector) -> [Vec<f64>; COMPONENTS] {
    /// Floor of the waves of T, as a part of the largest.
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
            diagonal[component] / (p * q) as f64 * waves.iter().enumerate().map(wave).sum::<f64>()
        };
        (0..=RADIUS).flat_map(|i| (0..=RADIUS).map(move |j| (i, j))).map(|(i, j)| near(i, j)).collect()
    };
    std::array::from_fn(of_component)
}

impl NearbyInverse {
    /// Inverses for an influence; `diagonal` is that of a cell on itself \[m/N\].
    pub(super) fn new(influence: &TractionInfluence, diagonal: Vector) -> Self {
        let size = [influence.columns, influence.across];
        let fields = || std::array::from_fn(|_| vec![0.0; influence.cells()]);
        let filters = inverse_stencils(influence, diagonal).map(|stencil| Filter::new(size, RADIUS, stencil));
        Self { filters, asked: fields(), found: fields() }
    }

    /// Value that is asked of a component at a cell.
    pub(super) fn ask(&mut self, cell: usize, component: usize) -> &mut f64 {
        &mut self.asked[component][cell]
    }

    /// Value found for a component at a cell.
    pub(super) fn found(&self, cell: usize, component: usize) -> f64 {
        self.found[component][cell]
    }

    /// Finds the values in a part of the window, a range of cells, outside which nothing is asked for.
    pub(super) fn find(&mut self, part: &Range<usize>) {
        for ((filter, asked), found) in self.filters.iter_mut().zip(&self.asked).zip(&mut self.found) {
            filter.apply(&asked[part.clone()], &mut found[part.clone()]);
        }
    }
}
