//! Resampling of a measured height map across, to the run's columns.

use rayon::prelude::*;

use super::lattice::{Lattice, same};
use super::sources::height_map::{RoadHeightMap, reflected};
use crate::numeric::windowed_sinc::WindowedSinc;

/// The map's rows at the run's columns.
pub(super) fn across(map: &RoadHeightMap, lattice: &Lattice, kernel: &WindowedSinc) -> Vec<f64> {
    let place = |column: usize| (lattice.y(column) - map.first_y) / map.dy;
    let offset = place(0);
    let whole = offset.round();
    let aligned = same(map.dy, lattice.dy) && (offset - whole).abs() < 1e-6;
    let inside = whole >= 0.0 && whole as usize + lattice.columns <= map.columns;
    if aligned && inside {
        let first = whole as usize;
        let rows = map.heights.chunks_exact(map.columns);
        return rows.flat_map(|row| row[first..first + lattice.columns].iter().copied()).collect();
    }
    // A single column is a line, not a cell: no low-pass at its width.
    let ratio = if lattice.columns > 1 { (lattice.dy / map.dy).max(1.0) } else { 1.0 };
    let mut taps = Vec::new();
    // Positions of the samples of each column in a row, with their weights.
    let plans: Vec<Vec<(usize, f64)>> = (0..lattice.columns)
        .map(|column| {
            let first = kernel.weights(place(column), ratio, &mut taps);
            (first..).zip(&taps).map(|(index, &weight)| (reflected(index, map.columns as i64), weight)).collect()
        })
        .collect();
    let mut rows = vec![0.0; map.rows() * lattice.columns];
    rows.par_chunks_mut(lattice.columns).zip(map.heights.par_chunks(map.columns)).for_each(|(out, row)| {
        for (height, plan) in out.iter_mut().zip(&plans) {
            *height = plan.iter().map(|&(index, weight)| weight * row[index]).sum();
        }
    });
    rows
}
