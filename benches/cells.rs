//! Contact over cells: products with G in double precision, a warm search on a rough road by projected gradients with
//! proportioning behind them, and the dense factorisation of the cells in contact beside it, with its error.
//!
//! `cargo bench --bench cells`.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a benchmark may panic, in its helpers, too")]

use std::hint::black_box;

use criterion::{BatchSize, BenchmarkId, Criterion, criterion_group, criterion_main};
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use tyrewave::contact::cells::{CellSearch, InstantCells};
use tyrewave::test_models::cells::{RoughRoad, instant_cells};

fn cells(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("cells");
    group.sample_size(10);
    for (columns, across, elements) in [(64, 60, 1024), (128, 120, 2048)] {
        let name = format!("{columns} x {across}");
        let influence = instant_cells(columns, across, elements, 86e-6 * 1024.0 / elements as f64);
        let mut search = CellSearch::new(InstantCells::new(influence), 1e-9);
        let road = RoughRoad::new(1);
        let mut forces = vec![0.0; columns * across];
        search.solve(&road.required(columns, across, elements, 0), &mut forces);
        forces.copy_within(across.., 0);
        forces[(columns - 1) * across..].fill(0.0);
        let (guess, required) = (forces.clone(), road.required(columns, across, elements, 1));
        let before = search.counts();
        search.solve(&required, &mut forces);
        let after = search.counts();
        let active: Vec<usize> = (0..forces.len()).filter(|&cell| forces[cell] > 0.0).collect();
        let operator = search.cells();
        let matrix = Mat::from_fn(active.len(), active.len(), |a, b| operator.entry(active[a], active[b]));
        let right = Mat::from_fn(active.len(), 1, |a, _| required[active[a]]);
        let solution = matrix.llt(Side::Lower).expect("G is positive definite").solve(&right);
        let largest = forces.iter().copied().fold(0.0, f64::max);
        let error = active.iter().enumerate().map(|(n, &cell)| (solution[(n, 0)] - forces[cell]).abs() / largest);
        println!(
            "{name}: {} in contact, {} iterations, {} + {} products, error {:.1e}",
            active.len(),
            after.iterations - before.iterations,
            after.products - before.products,
            after.single_products - before.single_products,
            error.fold(0.0, f64::max)
        );
        let mut displacement = vec![0.0; forces.len()];
        group.bench_function(BenchmarkId::new("product", &name), |bench| {
            bench.iter(|| search.cells_mut().displacement(black_box(&forces), &mut displacement));
        });
        group.bench_function(BenchmarkId::new("warm search", &name), |bench| {
            bench.iter_batched_ref(
                || guess.clone(),
                |forces| search.solve(black_box(&required), forces),
                BatchSize::SmallInput,
            );
        });
        group.bench_function(BenchmarkId::new("dense factorisation", &name), |bench| {
            bench.iter(|| matrix.llt(Side::Lower).expect("G is positive definite").solve(black_box(&right)));
        });
    }
    group.finish();
}

criterion_group!(benches, cells);
criterion_main!(benches);
