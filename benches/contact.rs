//! Cost of a time step: the history's direct convolution by window and memory, in multiply-adds; the history by poles,
//! instant by instant and in blocks, compared with the direct sum; the search for the points in contact with many kept
//! factors, with one, and by projected Gauss-Seidel sweeps; a solution with a cached factor, with a neighbouring set's,
//! and with a new one. Each with its error.
//!
//! `cargo bench --bench contact`.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a benchmark may panic, in its helpers, too")]
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "what was measured is printed")]

use std::hint::black_box;
use std::sync::atomic::AtomicBool;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use num_complex::Complex64;
use realfft::RealFftPlanner;
use tyrewave::counters::{Meter, Stage};
use tyrewave::internals::{
    ActiveSet, DirectHistory, FactorCache, FactorCounts, FitOptions, ForceHistory, INSTANTS, LagKernel, ModalHistory,
    RationalModel, Ring, SinglePrecision, Weights, fetch_model, plate_scene, plate_tyre,
};
use tyrewave::scene::TimeRule;
use tyrewave::tyre::{Field, InfluenceSum};

const ELEMENTS: usize = 512;
/// Points in contact of the default tyre.
const POINTS: usize = 24;

/// Weights with the shape of a belt wave, quick to make: the cost does not depend on their values.
fn weights(lags: usize) -> Weights {
    let rows = ELEMENTS / 2 + 1;
    let value = |n: usize, p: usize| {
        let (n, p) = (n as f64, p as f64);
        (0.02 * (1.0 + n).sqrt() * p).cos() * (-p / 400.0).exp() / (1.0 + n)
    };
    Weights {
        values: (0..rows * lags).map(|i| value(i / lags, i % lags)).collect(),
        odd: Vec::new(),
        lags,
        at_rest: (0..rows).map(|n| 10.0 / (1.0 + n as f64)).collect(),
        evaluations: 0,
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
        let mut meter = Meter::default();
        history.displacement(first, &mut old, &mut meter);
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
        group.throughput(Throughput::Elements(meter.cost(Stage::History).work.multiply_adds));
        group.bench_function(BenchmarkId::new(format!("window {columns}"), format!("lags {lags}")), |bench| {
            bench.iter(|| history.displacement(first, black_box(&mut old), &mut Meter::default()));
        });
    }
    group.finish();
}

/// Weights of the convolution that is equivalent to the recursion, from its response to a unit force on one element: a
/// direct sum with them differs from it by rounding only.
fn pulse_weights(model: &RationalModel, rule: TimeRule, time_step: f64, lags: usize) -> Weights {
    let elements = model.elements;
    let mut history = ModalHistory::with_blocks(model, Field::Surface, rule, time_step, [elements, 1], 1, None)
        .expect("the surface is fitted");
    let forward = RealFftPlanner::<f64>::new().plan_fft_forward(elements);
    let (mut ring, mut waves) = (forward.make_input_vec(), forward.make_output_vec());
    let mut values = vec![0.0; waves.len() * lags];
    let mut forces = vec![0.0; elements];
    for lag in 0..lags {
        history.displacement(0, &mut ring, &mut Meter::default());
        forces[0] = if lag == 0 { 1.0 } else { 0.0 };
        history.push(0, &forces);
        forward.process(&mut ring, &mut waves).expect("planned lengths");
        for (n, wave) in waves.iter().enumerate() {
            values[n * lags + lag] = wave.re / elements as f64;
        }
    }
    let at_rest = model.at_rest(Field::Surface).expect("the surface is fitted");
    Weights { values, odd: Vec::new(), lags, at_rest, evaluations: 0 }
}

/// The history by poles, in single instants or in blocks, in double or single precision, and by the direct sum over
/// the default memory; the number of elements doubles, or is `TYREWAVE_BENCH_ELEMENTS`. One iteration by poles is
/// 240 instants, so that whole blocks are timed.
fn modal(criterion: &mut Criterion) {
    const ROUND: i64 = 240;
    /// Memory of the direct sum \[s\].
    const MEMORY: f64 = 0.7;
    let tyre = plate_tyre();
    let wanted = std::env::var("TYREWAVE_BENCH_ELEMENTS").ok().and_then(|text| text.parse().ok());
    for elements in wanted.map_or_else(|| vec![128_usize, 256, 512, 1024], |elements| vec![elements]) {
        let time_step = tyre.circumference / elements as f64 / (80.0 / 3.6);
        let options = FitOptions::new(&tyre, elements, 80.0 / 3.6);
        let model = fetch_model(&tyre, &options, &AtomicBool::new(false))
            .unwrap_or_else(|error| panic!("the default tyre is refused: {error}"))
            .model;
        let columns = elements * 9 / 64;
        let (from, to) = (columns / 4, columns - columns / 4);
        let forces_at = |instant: i64, forces: &mut [f64]| {
            for (j, force) in forces.iter_mut().enumerate().take(to).skip(from) {
                *force = 100.0 + ((j as i64 * 7 + instant * 3) % 11) as f64;
            }
        };
        let roll = |history: &mut dyn ForceHistory, old: &mut [f64], begin: i64, instants: i64| {
            let mut forces = vec![0.0; columns];
            for instant in begin..begin + instants {
                history.displacement(instant, old, &mut Meter::default());
                forces_at(instant, &mut forces);
                history.push(instant, &forces);
            }
        };
        let history = |instants, single| {
            ModalHistory::with_blocks(&model, Field::Surface, TimeRule::Bdf2, time_step, [columns, 1], instants, single)
                .expect("the surface is fitted")
        };
        let mut exact = vec![0.0; columns];
        roll(&mut history(1, None), &mut exact, 0, ROUND);
        let largest = exact.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        let checked = |name: &str, old: &[f64], bound: f64| {
            let error = old.iter().zip(&exact).fold(0.0_f64, |a, (b, c)| a.max((b - c).abs())) / largest;
            println!("N = {elements}, {name}: {error:.0e} off the plain recursion");
            assert!(error < bound, "{error:e}");
        };
        let mut group = criterion.benchmark_group(format!("history by poles, {elements} elements"));
        group.sample_size(20).throughput(Throughput::Elements(ROUND as u64));
        // All lengths of blocks for the cheapest size; otherwise the plain recursion and the length in use.
        let lengths: &[usize] =
            if elements <= 128 || wanted.is_some() { &[1, 2, 4, INSTANTS, 16, 40] } else { &[1, INSTANTS] };
        let single = Some(SinglePrecision { tolerance: 1e-3, advance: 1.into() });
        let double = lengths.iter().map(|&instants| ("block", instants, None, 1e-12));
        for (name, instants, single, bound) in double.chain([("single precision, block", INSTANTS, single, 1e-4)]) {
            let (mut blocks, mut old) = (history(instants, single), vec![0.0; columns]);
            roll(&mut blocks, &mut old, 0, ROUND);
            checked(&format!("{name} of {instants}"), &old, bound);
            let mut begin = ROUND;
            group.bench_function(BenchmarkId::new(name, instants), |bench| {
                bench.iter(|| {
                    roll(&mut blocks, black_box(&mut old), begin, ROUND);
                    begin += ROUND;
                });
            });
        }
        let lags = (MEMORY / time_step) as usize;
        let weights = pulse_weights(&model, TimeRule::Bdf2, time_step, lags);
        let mut direct = DirectHistory::new(LagKernel::new(&weights, elements, columns, 1), columns, 1);
        let mut old = vec![0.0; columns];
        roll(&mut direct, &mut old, 0, ROUND);
        checked(&format!("direct sum of {lags} lags"), &old, 1e-12);
        let (mut instant, mut forces) = (ROUND, vec![0.0; columns]);
        while instant < ROUND + lags as i64 {
            forces_at(instant, &mut forces);
            direct.push(instant, &forces);
            instant += 1;
        }
        group.sample_size(10).throughput(Throughput::Elements(1));
        group.bench_function("direct sum", |bench| {
            bench.iter(|| {
                roll(&mut direct, black_box(&mut old), instant, 1);
                instant += 1;
            });
        });
        group.finish();
    }
}

/// G0 of the default tyre, BDF2, by distance.
fn instant_influence() -> Vec<f64> {
    let scene = plate_scene();
    let time_step = scene.tyre.circumference / ELEMENTS as f64 / scene.rolling.speed();
    let sum = InfluenceSum::new(&scene.tyre, &scene.numerics, 4.0 / time_step);
    let at = sum.at(Complex64::new(1.5 / time_step, 0.0));
    Ring::new(ELEMENTS).elements_of(|n| sum.value(n, &at, Field::Surface).value.re).to_vec()
}

/// Required displacements \[m\] of a rough patch at a step, scaled to the window.
fn required(columns: usize, step: usize) -> Vec<f64> {
    let middle = 0.5 * (columns as f64 - 1.0);
    let curvature = 3e-6 * (72.0 / columns as f64).powi(2);
    let rough = |e: usize| 2e-4 * ((e * 2_654_435_761 % 1000) as f64 / 1000.0 - 0.5);
    (0..columns).map(|j| 6e-4 - curvature * (j as f64 - middle).powi(2) + rough(j + step)).collect()
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
    const STEPS: usize = 32;
    let influence = instant_influence();
    for columns in [18_usize, 36, 72, 144] {
        let d: Vec<Vec<f64>> = (0..STEPS).map(|step| required(columns, step)).collect();
        let row = || influence[..columns].to_vec();

        // All methods agree.
        let (mut exact, mut found, mut sweeps, mut worst) = (vec![0.0; columns], vec![0.0; columns], 0, 0.0_f64);
        for factors in [4096, 1] {
            let mut active = ActiveSet::new(row(), columns, 1e-12, factors);
            for d in &d {
                exact.fill(0.0);
                sweeps += gauss_seidel(&influence, d, &mut exact);
                active.advance(1);
                assert!(active.search(d, &mut found, &mut Meter::default()).is_ok());
                let peak = exact.iter().fold(0.0_f64, |a, &b| a.max(b));
                worst = exact.iter().zip(&found).map(|(a, b)| (a - b).abs() / peak).fold(worst, f64::max);
            }
        }
        assert!(worst < 1e-9, "the ways differ by {worst:e} of the peak");
        println!(
            "{columns} columns, active set against Gauss-Seidel: {worst:.1e} of the peak; {} sweeps a step",
            sweeps / (2 * STEPS)
        );

        let mut group = criterion.benchmark_group(format!("search of {STEPS} steps, {columns} columns"));
        group.sample_size(20).throughput(Throughput::Elements(STEPS as u64));
        for (name, factors) in [("many factors kept", 4096), ("one factor kept", 1)] {
            let mut active = ActiveSet::new(row(), columns, 1e-12, factors);
            group.bench_function(name, |bench| {
                bench.iter(|| {
                    for d in &d {
                        active.advance(1);
                        assert!(active.search(black_box(d), &mut found, &mut Meter::default()).is_ok());
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
    }
}

fn solve(criterion: &mut Criterion) {
    let influence = instant_influence();
    let mut group = criterion.benchmark_group("solve");
    for points in [16_usize, 32, 64, 128] {
        // Points in a row; the same with one of them exchanged, twice; every second point, which differs by too many
        // for the row's factor to be of use.
        let in_a_row: Vec<usize> = (0..points).collect();
        let exchanged = |without: usize| -> Vec<usize> { (0..=points).filter(|j| *j != without).collect() };
        let (first, second) = (exchanged(1), exchanged(2));
        let spread: Vec<usize> = (0..points).map(|j| 2 * j).collect();
        let values: Vec<f64> = (0..points).map(|j| 1e-4 * (1 + j % 3) as f64).collect();
        group.throughput(Throughput::Elements(points as u64));
        type Served = fn(FactorCounts) -> u64;
        let ways: [(&str, usize, [&[usize]; 2], Served); 3] = [
            ("found", 2, [&in_a_row, &spread], |counts| counts.hits),
            ("beside a neighbour", 1, [&first, &second], |counts| counts.neighbours),
            ("made anew", 1, [&in_a_row, &spread], |counts| counts.factorisations),
        ];
        for (name, capacity, sets, served) in ways {
            let mut cache = FactorCache::new(capacity, 2 * points);
            let mut solution = values.clone();
            for set in [&in_a_row, sets[0], sets[1]] {
                solution.copy_from_slice(&values);
                assert!(cache.solve(set, &influence, &mut solution, &mut Meter::default()).is_ok());
            }
            let before = served(cache.counts());
            for set in sets {
                solution.copy_from_slice(&values);
                assert!(cache.solve(set, &influence, &mut solution, &mut Meter::default()).is_ok());
                for (&i, value) in set.iter().zip(&values) {
                    let displacement: f64 = set.iter().zip(&solution).map(|(&j, f)| influence[i.abs_diff(j)] * f).sum();
                    let residual = (displacement - value).abs();
                    assert!(residual < 1e-12 * 3e-4 * points as f64, "{name}, {points} points: {residual:e}");
                }
            }
            assert_eq!(served(cache.counts()), before + 2, "{name}: {:?}", cache.counts());
            let mut turn = 0;
            group.bench_function(BenchmarkId::new(name, points), |bench| {
                bench.iter(|| {
                    turn = 1 - turn;
                    solution.copy_from_slice(&values);
                    assert!(
                        cache.solve(sets[turn], &influence, black_box(&mut solution), &mut Meter::default()).is_ok()
                    );
                });
            });
        }
    }
    group.finish();
}

criterion_group!(benches, history, modal, search, solve);
criterion_main!(benches);
