//! Cost of the tyre: one evaluation of the compliance, and one influence function by its two exact ways, with the error of both against a
//! sum of the smallest tolerance.
//!
//! `cargo bench --bench tyre`.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a benchmark may panic, in its helpers, too")]

use std::f64::consts::PI;
use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use num_complex::Complex64;
use tyrewave::scene::{DEFAULT, Scene};
use tyrewave::tyre::compliance::Stack;
use tyrewave::tyre::influence::{Field, InfluenceSum, Projection, Truncation};

const ELEMENTS: usize = 512;

fn compliance(criterion: &mut Criterion) {
    let tyre = Scene::from_str(DEFAULT, "default").expect("the default scene").scene.tyre;
    let stack = Stack::new(&tyre);
    let mut group = criterion.benchmark_group("compliance");
    for (name, k) in [("kh < 1", 30.0), ("kh = 5", 400.0), ("kh = 40", 3000.0)] {
        let at = stack.at(Complex64::new(500.0, 2.0 * PI * 1000.0));
        group.throughput(Throughput::Elements(1)).bench_function(BenchmarkId::new("normal", name), |bench| {
            bench.iter(|| {
                let value = at.normal(black_box(k), black_box(0.5 * k)).surface;
                assert!(value.norm() > 0.0);
                value
            });
        });
    }
    group.bench_function("moduli at one s", |bench| bench.iter(|| stack.at(black_box(Complex64::new(500.0, 6000.0)))));
    group.finish();
}

fn influence(criterion: &mut Criterion) {
    let scene = Scene::from_str(DEFAULT, "default").expect("the default scene").scene;
    let time_step = scene.tyre.circumference / ELEMENTS as f64 / scene.rolling.speed();
    let sum = |truncation, tolerance| {
        let projection = Projection::new(&scene.tyre, ELEMENTS);
        InfluenceSum::with(&scene.tyre, projection, truncation, tolerance, 4.0 / time_step)
    };
    let points = [Complex64::ZERO, Complex64::new(50.0, 2.0 * PI * 300.0), Complex64::new(1.5 / time_step, 0.0)];
    let numbers = [0_usize, 10, 100, 256];
    let reference = sum(Truncation::Tail, 1e-12);
    let exact: Vec<Complex64> = points
        .iter()
        .flat_map(|&s| {
            let at = reference.at(s);
            numbers.map(|n| reference.value(n, &at, Field::Surface).value)
        })
        .collect();
    let mut group = criterion.benchmark_group("influence");
    group.sample_size(10);
    // As a test, without `--bench`, the dearest way is left out.
    let fast = !std::env::args().any(|argument| argument == "--bench");
    for (name, truncation, tolerance) in [
        ("tail 1e-7", Truncation::Tail, 1e-7),
        ("tail 1e-10", Truncation::Tail, 1e-10),
        ("bounded 1e-4", Truncation::Bounded, 1e-4),
        ("bounded 1e-6", Truncation::Bounded, 1e-6),
    ] {
        if fast && tolerance < 1e-5 && truncation == Truncation::Bounded {
            continue;
        }
        let sum = sum(truncation, tolerance);
        let (mut evaluations, mut worst) = (0, 0.0_f64);
        for (i, &s) in points.iter().enumerate() {
            let at = sum.at(s);
            for (j, &n) in numbers.iter().enumerate() {
                let found = sum.value(n, &at, Field::Surface);
                evaluations += found.evaluations;
                let exact = exact[i * numbers.len() + j];
                worst = worst.max((found.value - exact).norm() / exact.norm());
            }
        }
        println!("{name}: largest relative error {worst:.1e}, {} evaluations a value", evaluations / 12);
        // The moments of the tail replace a_m^2 by its mean far out: some 2e-7 stay whatever the tolerance.
        assert!(worst < 20.0 * tolerance + 5e-7, "{name}: relative error {worst:e}");
        group.throughput(Throughput::Elements(12));
        group.bench_function(name, |bench| {
            bench.iter(|| {
                for &s in &points {
                    let at = sum.at(s);
                    for &n in &numbers {
                        black_box(sum.value(n, &at, Field::Surface));
                    }
                }
            });
        });
    }
    group.finish();
}

criterion_group!(benches, compliance, influence);
criterion_main!(benches);
