//! Influence functions: compliance in lanes against scalar, fitted against brute force, both sides in one run, each with a physical checksum.

use std::f64::consts::PI;
use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use num_complex::Complex64;
use tyrewave::scene::{Foundation, Law, Layer, Material, TimeRule, Tyre};
use tyrewave::tyre::convolution_quadrature::Weights;
use tyrewave::tyre::influence::{Field, InfluenceSum, Projection, Truncation};
use tyrewave::tyre::rational::{Cache, FitOptions, fit};

fn tyre() -> Tyre {
    let material = |modulus, loss_factor, poisson, density| Material {
        law: Law::PowerLaw,
        modulus,
        loss_factor,
        poisson,
        density,
        reference_frequency: 1000.0,
        corner_frequency: 1.0,
        weights: Vec::new(),
        times: Vec::new(),
    };
    let layer = |thickness, tension, material| Layer { name: String::new(), thickness, tension, material };
    Tyre {
        circumference: 1.95,
        width: 0.2,
        contact_width: 0.15,
        foundation: Foundation {
            normal: 1.8e6,
            tangential: 1e6,
            loss_factor: 0.1,
            reference_frequency: 1000.0,
            corner_frequency: 1.0,
        },
        layers: vec![
            layer(6e-3, [6e4, 2e4], material(5e8, 0.08, 0.3, 1300.0)),
            layer(13e-3, [0.0; 2], material(8e6, 0.25, 0.49, 1150.0)),
        ],
    }
}

fn compliance(criterion: &mut Criterion) {
    let tyre = tyre();
    let sum = InfluenceSum::with(&tyre, Projection::new(&tyre, 512), Truncation::Tail, 1e-8, 2.0 * PI * 20e3);
    let at: Vec<_> = (0..64).map(|k| sum.at(Complex64::new(0.0, 1e3 * 1.05f64.powi(k)))).collect();
    let mut lanes = Vec::new();
    sum.faces(40, &at, Field::Surface, &mut lanes);
    let scalar: Vec<_> = at.iter().map(|at| sum.value(40, at, Field::Surface)).collect();
    let evaluations: u64 = scalar.iter().map(|value| value.evaluations).sum();
    for (a, b) in lanes.iter().zip(&scalar) {
        assert!((a.driven - b.value).norm() < 1e-10 * b.value.norm(), "lanes and scalar differ");
    }
    let mut group = criterion.benchmark_group("compliance");
    // Time per element is time per evaluation.
    group.throughput(Throughput::Elements(evaluations));
    group.bench_function("scalar", |bencher| {
        bencher.iter(|| at.iter().map(|at| sum.value(40, black_box(at), Field::Surface).value.re).sum::<f64>());
    });
    group.bench_function("lanes", |bencher| {
        bencher.iter(|| {
            lanes.clear();
            sum.faces(40, black_box(&at), Field::Surface, &mut lanes);
            lanes.len()
        });
    });
    group.finish();
}

fn model(criterion: &mut Criterion) {
    let tyre = tyre();
    let elements = std::env::var("TYREWAVE_BENCH_ELEMENTS").ok().and_then(|text| text.parse().ok()).unwrap_or(256);
    let time_step = tyre.circumference / elements as f64 / (80.0 / 3.6);
    let options = FitOptions { top: 2.0 * PI * 20e3, ..FitOptions::new(&tyre, elements, 0.0).with_tolerance(1e-6) };
    let fitted = fit(&tyre, &options).unwrap_or_else(|error| panic!("the default tyre is refused: {error}"));
    let sum = InfluenceSum::with(&tyre, Projection::new(&tyre, elements), Truncation::Tail, 1e-8, options.top);
    let brute = Weights::new(&sum, Field::Surface, TimeRule::Bdf2, time_step, 4096);
    for n in 0..=elements / 2 {
        let first = fitted.evaluate(n, Complex64::new(1.5 / time_step, 0.0), Field::Surface).map_or(f64::NAN, |h| h.re);
        let largest = brute.at_rest[n].max(brute.of(n)[0]);
        assert!(
            (first - brute.of(n)[0]).abs() < 2e-5 * largest,
            "G0 of the model and of brute force differ at n = {n}"
        );
    }
    println!(
        "N = {elements}: {} evaluations fitted, {} brute force, ratio {:.1}; {} poles",
        fitted.evaluations(),
        brute.evaluations,
        brute.evaluations as f64 / fitted.evaluations() as f64,
        fitted.order()
    );
    let folder = std::env::temp_dir().join(format!("tyrewave-bench-{}", std::process::id()));
    let cache = Cache::at(folder.clone(), u64::MAX);
    let _ = cache.fetch(&tyre, &options);
    let mut group = criterion.benchmark_group(format!("influence N = {elements}"));
    group.sample_size(10);
    group.bench_function("fitted", |bencher| bencher.iter(|| fit(&tyre, &options).map(|model| model.order())));
    group.bench_function("brute force", |bencher| {
        bencher.iter(|| Weights::new(&sum, Field::Surface, TimeRule::Bdf2, time_step, 4096).evaluations);
    });
    group.bench_function("from the cache", |bencher| {
        bencher.iter(|| cache.fetch(&tyre, &options).map(|fetched| fetched.warm));
    });
    group.finish();
    let _ = std::fs::remove_dir_all(folder);
}

criterion_group!(benches, compliance, model);
criterion_main!(benches);
