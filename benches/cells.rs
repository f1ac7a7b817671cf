//! Contact over cells: products with G in double precision, a warm search on a rough road by projected gradients with
//! proportioning behind them, and the dense factorisation of the cells in contact beside it, with its error. The past
//! by poles in blocks, by the plain recursion and by direct sums of some lags, with the errors of both.
//!
//! `cargo bench --bench cells`.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a benchmark may panic, in its helpers, too")]
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "what was measured is printed")]

use std::hint::black_box;

use criterion::{BatchSize, BenchmarkId, Criterion, criterion_group, criterion_main};
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use tyrewave::contact::cells::direct::DirectPast;
use tyrewave::contact::cells::past::{RingParts, STEPS, WavePast};
use tyrewave::contact::cells::wave_transform::WaveTransform;
use tyrewave::contact::cells::{CellSearch, InstantCells};
use tyrewave::counters::Meter;
use tyrewave::scene::TimeRule;
use tyrewave::test_models::cells::{RoughRoad, instant_cells};
use tyrewave::test_models::plate_tyre;
use tyrewave::tyre::influence::{CellGrid, CellSums, CellTruncation, WaveBand};
use tyrewave::tyre::poles::cells::{CellFitOptions, fit_cells};

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

/// Elements round the tyre, cells across, columns of the window, lags of the direct sums.
const PAST: [usize; 4] = [256, 15, 36, 64];

fn past(criterion: &mut Criterion) {
    let [elements, across, columns, lags] = PAST;
    let (rule, time_step) = (TimeRule::Bdf2, 86e-6 * 1024.0 / elements as f64);
    let tyre = plate_tyre();
    let grid = CellGrid::new(&tyre, elements, across);
    let truncation = CellTruncation { lateral_terms: Some(2 * across), aliases: Some(0) };
    let sums = CellSums::new(&tyre, grid, truncation, 1e-8, 8.0 / time_step);
    let rows = sums.waves(WaveBand::WHOLE);
    let options = CellFitOptions { top: 8.0 / time_step, tolerance: 1e-4, most_poles: 160 };
    let model = fit_cells(&sums, &rows, &options, &Default::default()).expect("the waves can be fitted");
    let transform = || WaveTransform::new(sums.grid(), elements, columns, &rows);
    let poles = |steps: usize| {
        let ring = RingParts { model: &model, transform: transform(), forgotten_after: None };
        WavePast::with_blocks([ring], rule, time_step, steps)
    };
    let mut direct = DirectPast::new(&sums, &rows, transform(), rule, time_step, lags);
    let force = |step: i64, cell: usize| (0.1 * step as f64 + 0.7 * cell as f64).sin().max(0.0);
    let forces = |step: i64| (0..columns * across).map(|cell| force(step, cell)).collect::<Vec<f64>>();
    let mut meter = Meter::default();
    let mut displaced = |past: &mut WavePast, step: i64| {
        let mut out = vec![0.0; columns * across];
        past.add_displacement(step, &mut out, &mut meter);
        past.push(step, &forces(step));
        out
    };
    let (mut blocks, mut plain) = (poles(STEPS), poles(1));
    let (mut errors, mut largest) = ([0.0_f64; 2], 0.0_f64);
    for step in 0..lags as i64 {
        let mut exact = vec![0.0; columns * across];
        direct.add_displacement(0, step, &mut exact);
        direct.push(0, step, &forces(step));
        for (past, error) in [&mut blocks, &mut plain].into_iter().zip(&mut errors) {
            let differences = displaced(past, step).into_iter().zip(&exact).map(|(a, b)| (a - b).abs());
            *error = differences.fold(*error, f64::max);
        }
        largest = exact.iter().fold(largest, |largest, u| largest.max(u.abs()));
    }
    let [of_blocks, of_plain] = errors.map(|error| error / largest);
    println!("{} waves, {lags} lags: errors {of_blocks:.1e} in blocks, {of_plain:.1e} plain", model.len());
    let mut group = criterion.benchmark_group("past of cells");
    group.sample_size(10);
    let mut step = lags as i64;
    for (name, past) in [("blocks", &mut blocks), ("plain recursion", &mut plain)] {
        group.bench_function(name, |bench| {
            bench.iter(|| {
                step += 1;
                displaced(past, step)
            });
        });
    }
    group.bench_function(format!("direct sums, {lags} lags"), |bench| {
        bench.iter(|| {
            step += 1;
            let mut out = vec![0.0; columns * across];
            direct.add_displacement(0, step, &mut out);
            direct.push(0, step, &forces(step));
            out
        });
    });
    group.finish();
}

criterion_group!(benches, cells, past);
criterion_main!(benches);
