//! Contact over cells: products with G in double precision; a warm search on a rough road by projected gradients with
//! proportioning, and the dense factorisation of the cells in contact for comparison, with its error; rolling to the
//! finest tolerance and to that of `preset = "standard"`. The past by poles in blocks, in single precision, with fewer
//! poles, by the plain recursion and by direct sums of some lags, and with short waves on a separate ring, with their
//! errors. Transforms of cells to waves, rows side by side and one by one.
//!
//! `cargo bench --bench cells`.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a benchmark may panic, in its helpers, too")]
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "what was measured is printed")]

use std::hint::black_box;

use criterion::{BatchSize, BenchmarkId, Criterion, criterion_group, criterion_main};
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use num_complex::Complex;
use realfft::RealFftPlanner;
use tyrewave::counters::Meter;
use tyrewave::internals::{
    CellFitOptions, CellGrid, CellHistory, CellSearch, CellSums, CellTruncation, DirectCellHistory, FewerPoles,
    InstantCells, PoleModel, RingParts, RoughRoad, WaveBand, WaveHistory, WaveNumber, WaveTransform, fewer_poles,
    first_influences, fit_cells, instant_cells, plate_tyre,
};
use tyrewave::scene::TimeRule;

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
        for tolerance in [3e-10, 1e-5] {
            group.bench_function(
                BenchmarkId::new(format!("rolling over two steps, to {tolerance:.0e}"), &name),
                |bench| {
                    bench.iter_batched_ref(
                        || rolled(columns, across, elements, tolerance),
                        |(search, forces)| {
                            (ROLLED..ROLLED + 2).for_each(|step| roll(search, &road, elements, step, forces));
                        },
                        BatchSize::LargeInput,
                    );
                },
            );
        }
        group.bench_function(BenchmarkId::new("dense factorisation", &name), |bench| {
            bench.iter(|| matrix.llt(Side::Lower).expect("G is positive definite").solve(black_box(&right)));
        });
    }
    group.finish();
}

/// Steps before the measurement.
const ROLLED: usize = 6;

/// Takes a step: the window moves on by a column, with the forces.
fn roll(search: &mut CellSearch, road: &RoughRoad, elements: usize, step: usize, forces: &mut [f64]) {
    let (columns, across) = (search.cells().columns(), search.cells().across());
    search.advance(across);
    forces.copy_within(across.., 0);
    forces[(columns - 1) * across..].fill(0.0);
    search.solve(&road.required(columns, across, elements, step), forces);
}

/// A search that has rolled.
fn rolled(columns: usize, across: usize, elements: usize, tolerance: f64) -> (CellSearch, Vec<f64>) {
    let influence = instant_cells(columns, across, elements, 86e-6 * 1024.0 / elements as f64);
    let mut search = CellSearch::new(InstantCells::new(influence), tolerance);
    let (road, mut forces) = (RoughRoad::new(1), vec![0.0; columns * across]);
    (0..ROLLED).for_each(|step| roll(&mut search, &road, elements, step, &mut forces));
    (search, forces)
}

/// Elements around the tyre, cells across, columns of the window, lags of the direct sums.
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
    let model = &model;
    fn ring<'m, N: WaveNumber>(
        model: &'m PoleModel,
        transform: WaveTransform<N>,
        fewer_poles: Option<FewerPoles>,
    ) -> RingParts<'m, N> {
        RingParts { model, transform, next_instant: None, forgotten_after: None, advance: 1.into(), fewer_poles }
    }
    let double = || WaveTransform::<f64>::new(sums.grid(), columns, &rows);
    let single = || WaveTransform::<f32>::new(sums.grid(), columns, &rows);
    let boxed = |past: WaveHistory| -> Box<dyn CellHistory<1>> { Box::new(past) };
    let rounded = |past: WaveHistory<f32>| -> Box<dyn CellHistory<1>> { Box::new(past) };
    let blocks = || [ring(model, double(), None)];
    let mut pasts = [
        ("blocks", boxed(WaveHistory::new(blocks(), rule, time_step))),
        ("single precision", rounded(WaveHistory::new([ring(model, single(), None)], rule, time_step))),
        ("plain recursion", boxed(WaveHistory::with_blocks(blocks(), rule, time_step, 1))),
    ];
    let mut direct: Box<dyn CellHistory<1>> =
        Box::new(DirectCellHistory::new(&sums, &rows, double(), rule, time_step, lags));
    let mut step = 0;
    let mut meter = Meter::default();
    let mut displaced = |past: &mut Box<dyn CellHistory<1>>, step: i64| {
        let mut out = vec![0.0; columns * across];
        past.add_displacement(0, step, out.as_chunks_mut().0, &mut meter);
        let force = |cell: usize| (0.1 * step as f64 + 0.7 * cell as f64).sin().max(0.0);
        past.push(0, step, (0..columns * across).map(force).collect::<Vec<f64>>().as_chunks().0);
        out
    };
    let (mut errors, mut largest) = ([0.0_f64; 3], 0.0_f64);
    while step < lags as i64 {
        let exact = displaced(&mut direct, step);
        for ((_, past), error) in pasts.iter_mut().zip(&mut errors) {
            let differences = displaced(past, step).into_iter().zip(&exact).map(|(a, b)| (a - b).abs());
            *error = differences.fold(*error, f64::max);
        }
        largest = exact.iter().fold(largest, |largest, u| largest.max(u.abs()));
        step += 1;
    }
    for ((name, _), error) in pasts.iter().zip(errors) {
        println!("{} waves, {lags} lags, {name}: error {:.1e}", model.len(), error / largest);
    }
    // Reduced sets of poles exist for one-step rules only.
    let rule = TimeRule::Sdirk2;
    let least = fewer_poles(model, rule, time_step, options.tolerance);
    let (mut all, mut fewer) = (
        boxed(WaveHistory::new(blocks(), rule, time_step)),
        boxed(WaveHistory::new([ring(model, double(), Some(least.clone()))], rule, time_step)),
    );
    let (mut error, mut largest) = (0.0_f64, 0.0_f64);
    for instant in 0..2 * lags as i64 {
        let exact = displaced(&mut all, instant / 2);
        let differences = displaced(&mut fewer, instant / 2).into_iter().zip(&exact).map(|(a, b)| (a - b).abs());
        error = differences.fold(error, f64::max);
        largest = exact.iter().fold(largest, |largest, u| largest.max(u.abs()));
    }
    println!("fewer poles: error {:.1e}", error / largest);
    let both = rounded(WaveHistory::new([ring(model, single(), Some(least))], rule, time_step));
    let mut group = criterion.benchmark_group("past of cells");
    group.sample_size(10);
    let of_stages = [("sdirk2", all), ("sdirk2, fewer poles", fewer), ("sdirk2, both", both)];
    let sums = [("direct sums", direct)];
    for (name, mut past) in pasts.into_iter().chain(sums).chain(of_stages) {
        group.bench_function(name, |bench| {
            bench.iter(|| {
                step += 1;
                displaced(&mut past, step)
            });
        });
    }
    group.finish();
}

/// Elements around the tyre, cells across, columns of the window, of the part of it that short waves reach, and of the
/// contact.
const RINGS: [usize; 5] = [512, 24, 40, 32, 24];

/// Short waves on a separate ring, advanced beside the march except for the effect of the last forces, and on the
/// tyre's ring.
fn rings(criterion: &mut Criterion) {
    let [elements, across, columns, seen, patch] = RINGS;
    let (rule, time_step) = (TimeRule::Sdirk2, 86e-6 * 1024.0 / elements as f64);
    let tyre = plate_tyre();
    let options = CellFitOptions { top: 8.0 / time_step, tolerance: 1e-4, most_poles: 160 };
    let fitted = |band: WaveBand| {
        let grid = CellGrid::new(&tyre, elements, across).on_ring(band.ring);
        let sums = CellSums::new(&tyre, grid, CellTruncation::default(), 1e-8, 8.0 / time_step);
        let rows = sums.waves(band);
        let model = fit_cells(&sums, &rows, &options, &Default::default()).expect("the waves can be fitted");
        (band.ring, sums.grid().clone(), rows, model)
    };
    let border = Some([231.0, 461.0]);
    let long = WaveBand { fades_out: border, ..WaveBand::WHOLE };
    let short = WaveBand { ring: Some(128), fades_in: border, ..WaveBand::WHOLE };
    let (one, two) = ([fitted(WaveBand::WHOLE)], [long, short].map(fitted));
    let mut pasts = [("one ring", &one[..]), ("two rings", &two)].map(|(name, rings)| {
        let rings = rings.iter().map(|(ring, grid, rows, model)| {
            let width = if ring.is_some() { seen } else { columns };
            let first = |_| first_influences(grid, width, rows, model, rule, time_step);
            RingParts {
                model,
                transform: WaveTransform::<f32>::new(grid, width, rows),
                next_instant: ring.map(first),
                forgotten_after: ring.map(|cells| cells - seen - 20),
                advance: 1.into(),
                fewer_poles: Some(fewer_poles(model, rule, time_step, options.tolerance)),
            }
        });
        (name, WaveHistory::<f32>::new(rings, rule, time_step))
    });
    let (mut instant, mut meter) = (0, Meter::default());
    let mut displaced = |past: &mut WaveHistory<f32>, instant: i64| {
        let mut out = vec![0.0; columns * across];
        past.add_displacement(instant / 2, &mut out, &mut meter);
        let outside = (columns - patch) / 2 * across;
        let force = |cell: usize| {
            let is_pressed = (outside..columns * across - outside).contains(&cell);
            if is_pressed { (0.1 * instant as f64 + 0.7 * cell as f64).sin().max(0.0) } else { 0.0 }
        };
        assert!(past.push(instant / 2, &(0..columns * across).map(force).collect::<Vec<f64>>()));
        out[outside..columns * across - outside].to_vec()
    };
    let (mut error, mut largest) = (0.0_f64, 0.0_f64);
    while instant < 4 * elements as i64 {
        let [one, two] = pasts.each_mut().map(|(_, past)| displaced(past, instant));
        error = one.iter().zip(&two).fold(error, |worst, (a, b)| worst.max((a - b).abs()));
        largest = one.iter().fold(largest, |largest, u| largest.max(u.abs()));
        instant += 1;
    }
    println!("short waves on a separate ring: error {:.1e}", error / largest);
    let mut group = criterion.benchmark_group("rings of cells");
    group.sample_size(10);
    for (name, mut past) in pasts {
        group.bench_function(name, |bench| {
            bench.iter(|| {
                instant += 1;
                displaced(&mut past, instant)
            });
        });
    }
    group.finish();
}

/// Cells of a ring, cells across, columns of the window.
const ROWS: [usize; 3] = [256, 60, 70];

/// Forces to the waves of a ring: rows side by side in vectors, and one real transform after the other, without the
/// products across.
fn rows(criterion: &mut Criterion) {
    let [ring, across, columns] = ROWS;
    let tyre = plate_tyre();
    let sums = CellSums::new(&tyre, CellGrid::new(&tyre, ring, across), CellTruncation::default(), 1e-8, 1e5);
    let rows = sums.waves(WaveBand::WHOLE);
    let mut transform = WaveTransform::<f32>::new(sums.grid(), columns, &rows);
    let mut exact = WaveTransform::<f64>::new(sums.grid(), columns, &rows);
    let forces: Vec<f64> = (0..columns * across).map(|cell| (0.7 * (cell * cell) as f64).sin().max(0.0)).collect();
    let mut spectrum = vec![Complex::default(); transform.waves()];
    let mut exact_spectrum = vec![Complex::default(); transform.waves()];
    transform.forward(3, &forces, &mut spectrum);
    exact.forward(3, &forces, &mut exact_spectrum);
    let of_wave = |(a, b): (&Complex<f32>, &Complex<f64>)| (f64::from(a.re) - b.re).hypot(f64::from(a.im) - b.im);
    let error = spectrum.iter().zip(&exact_spectrum).map(of_wave).fold(0.0, f64::max);
    let largest = exact_spectrum.iter().map(|wave| wave.norm()).fold(0.0, f64::max);
    println!("{} rows to waves: error {:.1e}", rows.len(), error / largest);
    let one_by_one = RealFftPlanner::<f32>::new().plan_fft_forward(ring);
    let (mut field, mut waves) = (one_by_one.make_input_vec(), one_by_one.make_output_vec());
    let mut scratch = one_by_one.make_scratch_vec();
    let mut group = criterion.benchmark_group("rows of cells");
    group.bench_function("side by side, products across too", |bench| {
        bench.iter(|| transform.forward(3, black_box(&forces), &mut spectrum));
    });
    group.bench_function("one by one", |bench| {
        bench.iter(|| {
            for (row, forces) in forces.chunks_exact(columns).cycle().take(rows.len()).enumerate() {
                field.fill(0.0);
                field[..columns].iter_mut().zip(forces).for_each(|(cell, force)| *cell = *force as f32);
                one_by_one.process_with_scratch(&mut field, &mut waves, &mut scratch).expect("planned lengths");
                black_box(row);
            }
        });
    });
    group.finish();
}

criterion_group!(benches, cells, past, rings, rows);
criterion_main!(benches);
