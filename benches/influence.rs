//! Influence functions: compliance in lanes compared with scalar, fits compared with brute force, both in one run, each
//! with a physical checksum.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a benchmark may panic, in its helpers, too")]
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "what was measured is printed")]

use std::f64::consts::PI;
use std::hint::black_box;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use num_complex::Complex64;
use tyrewave::internals::{Cache, FitOptions, Weights, fetch_from, fit, multiply_add_rate, operations, wide_tyre};
use tyrewave::scene::TimeRule;
use tyrewave::tyre::{Field, InfluenceSum, Projection, SumAt, Truncation};

fn compliance(criterion: &mut Criterion) {
    let tyre = wide_tyre();
    let sum = InfluenceSum::with(&tyre, Projection::new(&tyre, 512), Truncation::Tail, 1e-8, 2.0 * PI * 20e3);
    let all: Vec<_> = (0..64).map(|k| sum.at(Complex64::new(0.0, 1e3 * 1.05f64.powi(k)))).collect();
    for at in [8, 16, 32, 64].map(|points| &all[..points]) {
        compliance_at(criterion, &sum, at, Field::Surface);
    }
    compliance_at(criterion, &sum, &all, Field::UnderTread);
}

fn compliance_at(criterion: &mut Criterion, sum: &InfluenceSum, at: &[SumAt], driven: Field) {
    let mut lanes = Vec::new();
    sum.faces(40, at, driven, &mut lanes);
    let scalar: Vec<_> = at.iter().map(|at| sum.value(40, at, driven)).collect();
    let evaluations: u64 = scalar.iter().map(|value| value.evaluations).sum();
    for (a, b) in lanes.iter().zip(&scalar) {
        assert!((a.driven - b.value).norm() < 1e-10 * b.value.norm(), "lanes and scalar differ");
    }
    let operations = operations(2) as f64;
    let best = (0..20).fold(f64::INFINITY, |best, _| {
        let begin = Instant::now();
        lanes.clear();
        sum.faces(40, black_box(at), driven, &mut lanes);
        best.min(begin.elapsed().as_secs_f64() / evaluations as f64)
    });
    let peak = multiply_add_rate();
    println!(
        "{driven:?}, {} points, one evaluation in lanes: {:.0} ns, {operations} flop: {:.1} Gflop/s, {:.0} % of the \
         {:.1} Gflop/s of fused multiply-adds on this core",
        at.len(),
        1e9 * best,
        1e-9 * operations / best,
        100.0 * operations / best / peak,
        1e-9 * peak
    );
    let mut group = criterion.benchmark_group(format!("compliance at {} points, {driven:?}", at.len()));
    // Time per element is time per evaluation.
    group.throughput(Throughput::Elements(evaluations));
    group.bench_function("scalar", |bencher| {
        bencher.iter(|| at.iter().map(|at| sum.value(40, black_box(at), driven).value.re).sum::<f64>());
    });
    group.bench_function("lanes", |bencher| {
        bencher.iter(|| {
            lanes.clear();
            sum.faces(40, black_box(at), driven, &mut lanes);
            lanes.len()
        });
    });
    group.finish();
}

/// Lags for each element: 1.4 s of memory at 80 km/h.
///
/// Truncating the memory is the error of brute force as the fit's error is that of the model. It is measured here,
/// relative to the largest |H_n| like the fit's; with this memory brute force is still less accurate than the model, so
/// that the comparison favours brute force.
const LAGS_PER_ELEMENT: usize = 16;

/// The number of elements doubles, or is `TYREWAVE_BENCH_ELEMENTS`.
fn models(criterion: &mut Criterion) {
    let wanted = std::env::var("TYREWAVE_BENCH_ELEMENTS").ok().and_then(|text| text.parse().ok());
    // As a test, without `--bench`, the expensive sizes are left out.
    let sizes: &[usize] =
        if std::env::args().any(|argument| argument == "--bench") { &[128, 256, 512] } else { &[128] };
    wanted
        .map_or_else(|| sizes.to_vec(), |elements| vec![elements])
        .into_iter()
        .for_each(|elements| model(criterion, elements));
}

fn model(criterion: &mut Criterion, elements: usize) {
    let tyre = wide_tyre();
    let lags = LAGS_PER_ELEMENT * elements;
    let time_step = tyre.circumference / elements as f64 / (80.0 / 3.6);
    // Slightly more accurate than brute force with its memory, relative to each H_n's largest value.
    let options = FitOptions { top: 2.0 * PI * 20e3, ..FitOptions::new(&tyre, elements, 0.0).with_tolerance(3e-6) };
    let fitted = fit(&tyre, &options).unwrap_or_else(|error| panic!("the default tyre is refused: {error}"));
    let sum = InfluenceSum::with(&tyre, Projection::new(&tyre, elements), Truncation::Tail, 1e-8, options.top);
    let brute = Weights::new(&sum, Field::Surface, TimeRule::Bdf2, time_step, lags);
    let (mut fit_error, mut memory_error, mut first_error) = (0.0_f64, 0.0_f64, 0.0_f64);
    for n in 0..=elements / 2 {
        let statistics = &fitted.statistics()[n];
        fit_error = fit_error.max(statistics.error).max(statistics.real_axis_error);
        let peak = (0..2000)
            .filter_map(|k| fitted.evaluate(n, Complex64::new(0.0, 100.0 * 1.0036f64.powi(k)), Field::Surface))
            .fold(brute.at_rest[n], |peak, value| peak.max(value.norm()));
        let sum: f64 = brute.of(n).iter().sum();
        memory_error = memory_error.max((brute.at_rest[n] - sum).abs() / peak);
        let first = fitted.evaluate(n, Complex64::new(1.5 / time_step, 0.0), Field::Surface).map_or(f64::NAN, |h| h.re);
        first_error = first_error.max((first - brute.of(n)[0]).abs() / peak);
    }
    println!(
        "N = {elements}: {} evaluations fitted, error {fit_error:.1e}; {} brute force, {lags} lags, error \
         {memory_error:.1e}; ratio {:.0}; {} poles; first weights differ by {first_error:.1e}",
        fitted.evaluations(),
        brute.evaluations,
        brute.evaluations as f64 / fitted.evaluations() as f64,
        fitted.order()
    );
    assert!(fit_error <= options.tolerance && first_error <= 1.1 * options.tolerance, "{fit_error:e} {first_error:e}");
    assert!(fit_error < memory_error, "brute force with {lags} lags is the more exact one: {memory_error:e}");
    // A coarse tyre's brute force stops at its sampling frequency, far below the 20 kHz of the fit.
    assert!(brute.evaluations > fitted.evaluations() * (10 * elements as u64 / 256).min(20));
    let folder = std::env::temp_dir().join(format!("tyrewave-bench-{}", std::process::id()));
    let cache = Cache::at(folder.clone(), u64::MAX);
    let never = AtomicBool::new(false);
    let _ = fetch_from(&cache, &tyre, &options, &never);
    let mut group = criterion.benchmark_group(format!("influence N = {elements}"));
    // Time per element is time per influence function.
    group.sample_size(10).throughput(Throughput::Elements(elements as u64 / 2 + 1));
    group.bench_function("fitted", |bencher| bencher.iter(|| fit(&tyre, &options).map(|model| model.order())));
    group.bench_function("brute force", |bencher| {
        bencher.iter(|| Weights::new(&sum, Field::Surface, TimeRule::Bdf2, time_step, lags).evaluations);
    });
    group.bench_function("from the cache", |bencher| {
        bencher.iter(|| fetch_from(&cache, &tyre, &options, &never).map(|fetched| fetched.warm));
    });
    group.finish();
    let _ = std::fs::remove_dir_all(folder);
}

criterion_group!(benches, compliance, models);
criterion_main!(benches);
