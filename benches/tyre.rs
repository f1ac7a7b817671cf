//! Cost of the tyre: one evaluation of the compliance, flat and curved, one of a sidewall's impedance, and one
//! influence function by its two exact methods, with the error of both relative to a sum of the smallest tolerance.
//!
//! `cargo bench --bench tyre`.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a benchmark may panic, in its helpers, too")]
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "what was measured is printed")]

use std::f64::consts::PI;
use std::hint::black_box;
use std::sync::Arc as Shared;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use num_complex::Complex64;
use tyrewave::internals::{Arc, CurvedStack, Cylinder, FINE_STEP, Relaxation, STEP, Sidewall, plate_scene, plate_tyre};
use tyrewave::scene::{DEFAULT, Scene, Tyre};
use tyrewave::tyre::{Field, InfluenceSum, Projection, Stack, Truncation};

const ELEMENTS: usize = 512;

fn compliance(criterion: &mut Criterion) {
    let tyre = plate_tyre();
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

/// One impedance of a sidewall's edge, and eight neighbours together, as in runs.
fn sidewall(criterion: &mut Criterion) {
    let arc = Arc {
        radius: 0.055,
        angle: 1.0,
        pressure: 2.2e5,
        mass: 7.0,
        shear: 8e3,
        hoop: 3.2e4,
        edge_radius: 0.297,
        angular_velocity: 0.0,
        relaxation: Relaxation::of_loss_factor(0.15),
    };
    let sidewall = Shared::new(Sidewall::new(arc));
    let mut group = criterion.benchmark_group("sidewall");
    for (name, n, frequency) in [("low", 3, 100.0), ("fast", 3, 2.5e3), ("short", 143, 100.0)] {
        let s = Complex64::new(0.0, 2.0 * PI * frequency);
        group.bench_function(BenchmarkId::new("one", name), |bench| {
            bench.iter(|| {
                let edge = sidewall.impedance(black_box(n), s);
                assert!(edge.radial.norm() > 0.0);
                edge
            });
        });
        group.throughput(Throughput::Elements(8)).bench_function(BenchmarkId::new("neighbours", name), |bench| {
            bench.iter(|| sidewall.at(black_box(s), n as usize).both_ways(n as usize).forwards);
        });
    }
    group.finish();
}

fn influence(criterion: &mut Criterion) {
    let scene = plate_scene();
    let time_step = scene.tyre.circumference / ELEMENTS as f64 / scene.rolling.speed();
    let sum = |truncation, tolerance| {
        let projection = Projection::new(&scene.tyre, ELEMENTS);
        InfluenceSum::with(&scene.tyre, projection, truncation, tolerance, 4.0 / time_step)
    };
    let points = [Complex64::ZERO, Complex64::new(50.0, 2.0 * PI * 300.0), Complex64::new(1.5 / time_step, 0.0)];
    let numbers = [0_usize, 10, 100, 256];
    let at = |sum: &InfluenceSum| -> Vec<(Complex64, u64)> {
        let of = |&s: &Complex64| {
            let at = sum.at(s);
            numbers.map(|n| sum.value(n, &at, Field::Surface)).map(|found| (found.value, found.evaluations))
        };
        points.iter().flat_map(of).collect()
    };
    let exact = at(&sum(Truncation::Tail, 1e-12));
    let mut group = criterion.benchmark_group("influence");
    group.sample_size(10);
    // As a test, without `--bench`, the most expensive ones are left out.
    let fast = !std::env::args().any(|argument| argument == "--bench");
    println!(
        "terms a value, N = {ELEMENTS}     with the half-space's tail          without, until the rest is bounded"
    );
    for exponent in 3..=8 {
        let tolerance = 10f64.powi(-exponent);
        let mut line = format!("tolerance {tolerance:.0e}");
        for (name, truncation) in [("tail", Truncation::Tail), ("bounded", Truncation::Bounded)] {
            if truncation == Truncation::Bounded && exponent > if fast { 4 } else { 7 } {
                continue;
            }
            let sum = sum(truncation, tolerance);
            let found = at(&sum);
            let evaluations: u64 = found.iter().map(|value| value.1).sum();
            // Both tolerances are relative to the value at rest, the first point.
            let error = found.iter().zip(&exact).enumerate().fold(0.0, |worst: f64, (i, (found, exact_value))| {
                worst.max((found.0 - exact_value.0).norm() / exact[i % numbers.len()].0.norm())
            });
            line.push_str(&format!("   {:>9} terms, error {error:.1e}", evaluations / found.len() as u64));
            assert!(error < 2.0 * tolerance, "{name}: relative error {error:e}, wanted {tolerance:e}");
            group.throughput(Throughput::Elements(found.len() as u64));
            if exponent % 2 == 0 && exponent <= 6 {
                group.bench_function(BenchmarkId::new(name, tolerance), |bench| bench.iter(|| black_box(at(&sum))));
            }
        }
        println!("{line}");
    }
    group.finish();
}

/// A wave of the curved tyre by several methods, with the error of each relative to steps a sixth as long; then the
/// sums of one wavenumber at many s side by side, curved and flat, at rest and rotating, then in both directions.
fn curved(criterion: &mut Criterion) {
    let tyre = Scene::from_str(DEFAULT, "default").unwrap().scene.tyre;
    let (n, m, s) = (60, 4, Complex64::new(50.0, 2.0 * PI * 1000.0));
    let top = 2.0 * PI * 20e3;
    let stack = CurvedStack::new(&tyre);
    let cylinder = Cylinder::new(&tyre, top, 1e-5);
    let (wave, at) = (cylinder.wave(n, m), cylinder.at(s));
    let exact = stack.compliance(n, m, s, FINE_STEP / 6.0).0[2][2];
    let error = |value: Complex64| (value - exact).norm() / exact.norm();
    println!(
        "error of C: prepared wave {:.1e}, steps {:.1e}, fine steps {:.1e}",
        error(wave.normal(&at).surface),
        error(stack.compliance(n, m, s, STEP).0[2][2]),
        error(stack.compliance(n, m, s, FINE_STEP).0[2][2])
    );
    let mut group = criterion.benchmark_group("curved");
    group.sample_size(20);
    group.bench_function("prepare a wave", |bench| bench.iter(|| cylinder.wave(black_box(n), m)));
    group.bench_function("prepared wave at s", |bench| bench.iter(|| wave.normal(black_box(&at))));
    let turning = Tyre { angular_velocity: -69.4 / tyre.radius(), ..tyre.clone() };
    let turning_cylinder = Cylinder::new(&turning, top, 1e-5);
    let (turning_wave, turning_at) = (turning_cylinder.wave(n, m), turning_cylinder.at(s));
    group.bench_function("prepare a wave, turning", |bench| bench.iter(|| turning_cylinder.wave(black_box(n), m)));
    group.bench_function("prepared wave at s, turning, both ways", |bench| {
        bench.iter(|| turning_wave.normal_both_ways(black_box(&turning_at)));
    });
    group.bench_function("steps at s", |bench| bench.iter(|| stack.compliance(n, m, black_box(s), STEP)));
    let without = |tyre: &Tyre| {
        let mut tyre = tyre.clone();
        tyre.layers.iter_mut().for_each(|layer| layer.cords.clear());
        tyre
    };
    let flat = Tyre { curvature: false, inflation: None, cavity: None, ..tyre.clone() };
    let (isotropic, isotropic_flat, isotropic_turning) = (without(&tyre), without(&flat), without(&turning));
    for (name, tyre) in [
        ("curved", &tyre),
        ("curved, turning", &turning),
        ("curved, no cords", &isotropic),
        ("curved, no cords, turning", &isotropic_turning),
        ("flat", &flat),
        ("flat, no cords", &isotropic_flat),
    ] {
        let sum = InfluenceSum::with(tyre, Projection::new(tyre, ELEMENTS), Truncation::Tail, 1e-7, top);
        let points: Vec<_> = (1..=256).map(|k| sum.at(Complex64::new(0.0, 2.0 * PI * 10.0 * f64::from(k)))).collect();
        let mut values = Vec::new();
        sum.faces(60, &points, Field::Surface, &mut values);
        group.throughput(Throughput::Elements(values.iter().map(|faces| faces.evaluations).sum()));
        group.bench_function(BenchmarkId::new("sums at 256 s", name), |bench| {
            bench.iter(|| {
                values.clear();
                sum.faces(60, &points, Field::Surface, &mut values);
            });
        });
    }
    group.finish();
}

criterion_group!(benches, compliance, sidewall, influence, curved);
criterion_main!(benches);
