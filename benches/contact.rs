//! Cost of a time step: the history's direct convolution by window and memory, in multiply-adds; the history by poles, instant by instant and in blocks; and the search for the points in contact with
//! cached factors, with fresh ones, and by projected Gauss-Seidel sweeps, each with its error.
//!
//! `cargo bench --bench contact`.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a benchmark may panic, in its helpers, too")]

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use num_complex::Complex64;
use realfft::RealFftPlanner;
use tyrewave::contact::active_set::ActiveSet;
use tyrewave::contact::factors::FactorCache;
use tyrewave::contact::history::{DirectHistory, ModalHistory, PastForces};
use tyrewave::contact::tread::LagKernel;
use tyrewave::scene::{DEFAULT, Scene, TimeRule};
use tyrewave::tyre::convolution_quadrature::Weights;
use tyrewave::tyre::influence::{Field, InfluenceSum};
use tyrewave::tyre::rational::{FitOptions, fit};

const ELEMENTS: usize = 512;
/// Points in contact of the default tyre.
const POINTS: usize = 24;

/// Weights with the shape of a belt wave, cheap to make: the cost does not depend on their values.
fn weights(lags: usize) -> Weights {
    let rows = ELEMENTS / 2 + 1;
    let value = |n: usize, p: usize| {
        let (n, p) = (n as f64, p as f64);
        (0.02 * (1.0 + n).sqrt() * p).cos() * (-p / 400.0).exp() / (1.0 + n)
    };
    Weights {
        values: (0..rows * lags).map(|i| value(i / lags, i % lags)).collect(),
        lags,
        at_rest: (0..rows).map(|n| 10.0 / (1.0 + n as f64)).collect(),
        evaluations: 0,
        omitted: 0.0,
    }
}

/// Forces of a patch in the middle of the window.
fn forces(columns: usize, step: usize) -> Vec<f64> {
    let from = (columns - POINTS) / 2;
    let force = |j: usize| 100.0 + ((j * 7 + step * 3) % 11) as f64;
    (0..columns).map(|j| if (from..from + POINTS).contains(&j) { force(j) } else { 0.0 }).collect()
}

fn history(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("history");
    group.sample_size(20);
    for (columns, lags) in [(48, 1024), (72, 1024), (72, 4096), (144, 4096)] {
        let kernel = LagKernel::new(&weights(lags), ELEMENTS, columns, 1);
        let mut history = DirectHistory::new(kernel.clone(), columns, 1);
        for step in 0..lags {
            history.push(step as i64, &forces(columns, step));
        }
        let mut old = vec![0.0; columns];
        let first = lags as i64;
        let work = history.displacement(first, &mut old);
        // One column again, one product after the other.
        let column = columns / 2;
        let plain: f64 = (1..lags)
            .flat_map(|p| (0..columns).map(move |j| (p, j)))
            .map(|(p, j)| {
                // Element first + column, seen from element first - p + j: column - j + p further on.
                forces(columns, lags - p)[j] * kernel.lag(p)[columns - 1 + column - j]
            })
            .sum();
        assert!((plain - old[column]).abs() <= 1e-9 * plain.abs().max(1.0), "{plain} {}", old[column]);
        group.throughput(Throughput::Elements(work.sums.multiply_adds));
        group.bench_function(BenchmarkId::new(format!("window {columns}"), format!("lags {lags}")), |bench| {
            bench.iter(|| history.displacement(first, black_box(&mut old)));
        });
    }
    group.finish();
}

/// The history by poles, its instants taken one by one or in blocks, `TYREWAVE_BENCH_ELEMENTS` round the tyre. One iteration is 240 instants, so that whole blocks are timed.
fn modal(criterion: &mut Criterion) {
    const ROUND: i64 = 240;
    let tyre = Scene::from_str(DEFAULT, "default").expect("the default scene").scene.tyre;
    let elements = std::env::var("TYREWAVE_BENCH_ELEMENTS").ok().and_then(|text| text.parse().ok()).unwrap_or(128);
    let time_step = tyre.circumference / elements as f64 / (80.0 / 3.6);
    let options = FitOptions::new(&tyre, elements, 80.0 / 3.6);
    let model = fit(&tyre, &options).unwrap_or_else(|error| panic!("the default tyre is refused: {error}"));
    let columns = elements * 9 / 64;
    let (from, to) = (columns / 4, columns - columns / 4);
    let roll = |history: &mut ModalHistory, old: &mut [f64], begin: i64| {
        let mut forces = vec![0.0; columns];
        for instant in begin..begin + ROUND {
            history.displacement(instant, old);
            for (j, force) in forces.iter_mut().enumerate().take(to).skip(from) {
                *force = 100.0 + ((j as i64 * 7 + instant * 3) % 11) as f64;
            }
            history.push(instant, &forces);
        }
    };
    let history = |instants| {
        ModalHistory::with_blocks(&model, Field::Surface, TimeRule::Bdf2, time_step, instants)
            .expect("the surface is fitted")
    };
    let mut exact = vec![0.0; columns];
    roll(&mut history(1), &mut exact, 0);
    let largest = exact.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    let mut group = criterion.benchmark_group(format!("history by poles, {elements} elements"));
    group.sample_size(20).throughput(Throughput::Elements(ROUND as u64));
    for instants in [1, 4, 8, 16, 24, 40] {
        let (mut blocks, mut old) = (history(instants), vec![0.0; columns]);
        roll(&mut blocks, &mut old, 0);
        let error = old.iter().zip(&exact).fold(0.0_f64, |a, (b, c)| a.max((b - c).abs())) / largest;
        println!("blocks of {instants}: {error:.0e} off the plain recursion");
        assert!(error < 1e-12, "{error:e}");
        let mut begin = ROUND;
        group.bench_function(BenchmarkId::new("block", instants), |bench| {
            bench.iter(|| {
                roll(&mut blocks, black_box(&mut old), begin);
                begin += ROUND;
            });
        });
    }
    group.finish();
}

/// G0 of the default tyre, BDF2, by distance.
fn instant_influence() -> Vec<f64> {
    let scene = Scene::from_str(DEFAULT, "default").expect("the default scene").scene;
    let time_step = scene.tyre.circumference / ELEMENTS as f64 / scene.rolling.speed();
    let sum = InfluenceSum::new(&scene.tyre, &scene.numerics, 4.0 / time_step);
    let at = sum.at(Complex64::new(1.5 / time_step, 0.0));
    let inverse = RealFftPlanner::<f64>::new().plan_fft_inverse(ELEMENTS);
    let (mut spectrum, mut row) = (inverse.make_input_vec(), inverse.make_output_vec());
    for (n, entry) in spectrum.iter_mut().enumerate() {
        *entry = sum.value(n, &at, Field::Surface).value.re.into();
    }
    inverse.process(&mut spectrum, &mut row).expect("planned lengths");
    row
}

/// Required displacements \[m\] of a rough patch at a step.
fn required(columns: usize, step: usize) -> Vec<f64> {
    let middle = 0.5 * (columns as f64 - 1.0);
    let rough = |e: usize| 2e-4 * ((e * 2_654_435_761 % 1000) as f64 / 1000.0 - 0.5);
    (0..columns).map(|j| 6e-4 - 3e-6 * (j as f64 - middle).powi(2) + rough(j + step)).collect()
}

/// Projected Gauss-Seidel until no force changes by more than 1e-12 of the largest; returns the sweeps.
fn gauss_seidel(influence: &[f64], d: &[f64], forces: &mut [f64]) -> usize {
    for sweep in 1..100_000 {
        let (mut change, mut largest) = (0.0_f64, 0.0_f64);
        for i in 0..d.len() {
            let u: f64 = forces.iter().enumerate().map(|(j, force)| influence[i.abs_diff(j)] * force).sum();
            let next = (forces[i] + (d[i] - u) / influence[0]).max(0.0);
            change = change.max((next - forces[i]).abs());
            largest = largest.max(next);
            forces[i] = next;
        }
        if change <= 1e-12 * largest {
            return sweep;
        }
    }
    0
}

fn search(criterion: &mut Criterion) {
    const COLUMNS: usize = 72;
    const STEPS: usize = 64;
    let influence = instant_influence();
    let d: Vec<Vec<f64>> = (0..STEPS).map(|step| required(COLUMNS, step)).collect();
    let row = || influence[..COLUMNS].to_vec();

    // All ways agree.
    let (mut exact, mut found, mut sweeps, mut worst) = (vec![0.0; COLUMNS], vec![0.0; COLUMNS], 0, 0.0_f64);
    let mut active = ActiveSet::new(row(), COLUMNS, 1e-12, 4096);
    for d in &d {
        exact.fill(0.0);
        sweeps += gauss_seidel(&influence, d, &mut exact);
        active.advance(1);
        assert!(active.search(d, &mut found).is_ok());
        let peak = exact.iter().fold(0.0_f64, |a, &b| a.max(b));
        worst = exact.iter().zip(&found).map(|(a, b)| (a - b).abs() / peak).fold(worst, f64::max);
    }
    assert!(worst < 1e-9, "the ways differ by {worst:e} of the peak");
    println!("active set against Gauss-Seidel: {worst:.1e} of the peak; {} sweeps a step", sweeps / STEPS);

    let mut group = criterion.benchmark_group("search of 64 steps, 72 columns");
    group.sample_size(20).throughput(Throughput::Elements(STEPS as u64));
    for (name, cached) in [("cached factors", 4096), ("fresh factors", 1)] {
        let mut active = ActiveSet::new(row(), COLUMNS, 1e-12, cached);
        group.bench_function(name, |bench| {
            bench.iter(|| {
                for d in &d {
                    active.advance(1);
                    assert!(active.search(black_box(d), &mut found).is_ok());
                }
            });
        });
    }
    group.sample_size(10).bench_function("projected Gauss-Seidel", |bench| {
        bench.iter(|| {
            for d in &d {
                exact.fill(0.0);
                black_box(gauss_seidel(&influence, d, &mut exact));
            }
        });
    });
    group.finish();

    let mut group = criterion.benchmark_group("solve");
    for points in [16_usize, 32, 64] {
        // Two sets that are no shifts of each other; a cache of one factor then finds none of them.
        let sets = [(0..points).collect::<Vec<_>>(), (0..points + 1).filter(|j| *j != 1).collect()];
        let values: Vec<f64> = (0..points).map(|j| 1e-4 * (1 + j % 3) as f64).collect();
        for (name, capacity) in [("cached", 2), ("fresh", 1)] {
            let mut cache = FactorCache::new(capacity, points + 1);
            let mut solution = values.clone();
            group.bench_function(BenchmarkId::new(name, points), |bench| {
                let mut turn = 0;
                bench.iter(|| {
                    turn = 1 - turn;
                    solution.copy_from_slice(&values);
                    assert!(cache.solve(&sets[turn], &influence, black_box(&mut solution)).is_ok());
                });
                let residual = |i: usize| {
                    let sum = |(j, force): (usize, &f64)| influence[sets[turn][i].abs_diff(sets[turn][j])] * force;
                    solution.iter().enumerate().map(sum).sum::<f64>() - values[i]
                };
                assert!((0..points).all(|i| residual(i).abs() < 1e-12 * 3e-4 * points as f64));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, history, modal, search);
criterion_main!(benches);
