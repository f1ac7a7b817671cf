//! The linear systems of the search: G0 of the points in contact, 16 to 512 of them, solved by LU, by Cholesky and by
//! LDLT (LU without exchanges), factors made anew or kept, by the program's own LDLT by panels, by Levinson's recursion
//! where the points are neighbours, and with one point more than a kept factor has, each with its residual.
//!
//! `cargo bench --bench linear_solvers`.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a benchmark may panic, in its helpers, too")]
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "what was measured is printed")]

use std::f64::consts::PI;
use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use faer::linalg::solvers::Solve;
use faer::{Mat, MatRef, Side};
use num_complex::Complex64;
use tyrewave::contact::complementarity::{LINE, Ldlt, room};
use tyrewave::numeric::Ring;
use tyrewave::test_models::plate_scene;
use tyrewave::tyre::influence::{Field, InfluenceSum, Projection, Truncation};

/// G0 by distance: the default tyre with 4096 elements at 80 km/h, BDF2.
fn instant_influence() -> Vec<f64> {
    const ELEMENTS: usize = 4096;
    let scene = plate_scene();
    let time_step = scene.tyre.circumference / ELEMENTS as f64 / scene.rolling.speed();
    let projection = Projection::new(&scene.tyre, ELEMENTS);
    let sum = InfluenceSum::with(&scene.tyre, projection, Truncation::Tail, 1e-8, 1.5 / time_step);
    let at = sum.at(Complex64::new(1.5 / time_step, 0.0));
    Ring::new(ELEMENTS).elements_of(|n| sum.value(n, &at, Field::Surface).value.re).to_vec()
}

/// Levinson's recursion for a symmetric Toeplitz matrix given by its first row: 2 P^2 multiply-adds, no matrix.
fn levinson(row: &[f64], d: &[f64]) -> Vec<f64> {
    let size = d.len();
    let mut forward = vec![0.0; size];
    let mut solution = vec![0.0; size];
    forward[0] = 1.0 / row[0];
    solution[0] = d[0] / row[0];
    let mut next = vec![0.0; size];
    for n in 1..size {
        let error: f64 = (0..n).map(|i| row[n - i] * forward[i]).sum();
        let scale = 1.0 / (1.0 - error * error);
        for i in 0..=n {
            let (ahead, behind) = (if i < n { forward[i] } else { 0.0 }, if i > 0 { forward[n - i] } else { 0.0 });
            next[i] = scale * (ahead - error * behind);
        }
        forward[..=n].copy_from_slice(&next[..=n]);
        let missing = d[n] - (0..n).map(|i| row[n - i] * solution[i]).sum::<f64>();
        for i in 0..=n {
            solution[i] += missing * forward[n - i];
        }
    }
    solution
}

fn residual(matrix: MatRef<'_, f64>, solution: &[f64], d: &[f64]) -> f64 {
    let largest = d.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    (0..d.len())
        .map(|i| ((0..d.len()).map(|j| matrix[(i, j)] * solution[j]).sum::<f64>() - d[i]).abs() / largest)
        .fold(0.0, f64::max)
}

/// Solves with one point more than the factor has, by its row: two solves with the factor.
fn bordered(solve: impl Fn(&[f64]) -> Vec<f64>, row: &[f64], own: f64, d: &[f64], last: f64) -> Vec<f64> {
    let (without, share) = (solve(d), solve(row));
    let dot = |values: &[f64]| row.iter().zip(values).map(|(a, b)| a * b).sum::<f64>();
    let force = (last - dot(&without)) / (own - dot(&share));
    let mut solution: Vec<f64> = without.iter().zip(&share).map(|(a, b)| a - force * b).collect();
    solution.push(force);
    solution
}

fn solvers(criterion: &mut Criterion) {
    let influence = instant_influence();
    for points in [16_usize, 32, 64, 128, 192, 256, 512] {
        let matrix = Mat::from_fn(points, points, |i, j| influence[i.abs_diff(j)]);
        let d: Vec<f64> = (0..points).map(|i| 1e-3 * (PI * (i as f64 + 0.5) / points as f64).sin()).collect();
        let right = || Mat::from_fn(points, 1, |i, _| d[i]);
        let column = |solution: Mat<f64>| -> Vec<f64> { (0..solution.nrows()).map(|i| solution[(i, 0)]).collect() };
        let lu = matrix.partial_piv_lu();
        let cholesky = matrix.llt(Side::Lower).expect("G0 is positive definite");
        let symmetric = matrix.ldlt(Side::Lower).expect("G0 is positive definite");
        let smaller = Mat::from_fn(points - 1, points - 1, |i, j| influence[i.abs_diff(j)]).partial_piv_lu();
        let row: Vec<f64> = (0..points - 1).map(|i| influence[points - 1 - i]).collect();
        let one_more = || {
            let solve = |d: &[f64]| column(smaller.solve(Mat::from_fn(points - 1, 1, |i, _| d[i])));
            bordered(solve, &row, influence[0], &d[..points - 1], d[points - 1])
        };
        let set: Vec<usize> = (0..points).collect();
        let stride = points.next_multiple_of(LINE);
        let anew = |solver: &mut Ldlt, memory: &mut [f64], right: &mut [f64]| {
            solver.assemble(&set, &influence, memory);
            right[..points].copy_from_slice(&d);
            solver.factorise(memory, points).expect("G0 is positive definite");
            solver.solve(memory, right, stride, points).expect("G0 is positive definite");
        };
        let by_panels = || {
            let (mut memory, mut right) = (vec![0.0; room(points)], vec![0.0; stride]);
            anew(&mut Ldlt::new(points), &mut memory, &mut right);
            right.truncate(points);
            right
        };
        let mut line = format!("{points:4} points, residuals:");
        for (name, solution) in [
            ("LU", column(lu.solve(right()))),
            ("Cholesky", column(cholesky.solve(right()))),
            ("LDLT", column(symmetric.solve(right()))),
            ("by panels", by_panels()),
            ("Levinson", levinson(&influence, &d)),
            ("one more", one_more()),
        ] {
            let residual = residual(matrix.as_ref(), &solution, &d);
            line.push_str(&format!(" {name} {residual:.0e}"));
            assert!(residual < 1e-11, "{points} points, {name}: {residual:e}");
        }
        println!("{line}");
        let mut group = criterion.benchmark_group(format!("{points} points"));
        group.sample_size(20).throughput(Throughput::Elements(points as u64));
        group.bench_function(BenchmarkId::new("LU", "made anew"), |bench| {
            bench.iter(|| black_box(&matrix).partial_piv_lu().solve(right()));
        });
        group.bench_function(BenchmarkId::new("Cholesky", "made anew"), |bench| {
            bench.iter(|| black_box(&matrix).llt(Side::Lower).map(|factor| factor.solve(right())));
        });
        group.bench_function(BenchmarkId::new("LDLT", "made anew"), |bench| {
            bench.iter(|| black_box(&matrix).ldlt(Side::Lower).map(|factor| factor.solve(right())));
        });
        let (mut solver, mut memory, mut values) = (Ldlt::new(points), vec![0.0; room(points)], vec![0.0; stride]);
        group.bench_function(BenchmarkId::new("LDLT by panels", "made anew"), |bench| {
            bench.iter(|| anew(&mut solver, black_box(&mut memory), black_box(&mut values)));
        });
        group.bench_function(BenchmarkId::new("LDLT", "kept"), |bench| {
            bench.iter(|| symmetric.solve(black_box(right())));
        });
        group.bench_function(BenchmarkId::new("LU", "kept"), |bench| bench.iter(|| lu.solve(black_box(right()))));
        group.bench_function(BenchmarkId::new("Cholesky", "kept"), |bench| {
            bench.iter(|| cholesky.solve(black_box(right())));
        });
        group.bench_function(BenchmarkId::new("LU", "one point more"), |bench| bench.iter(one_more));
        group.bench_function(BenchmarkId::new("Levinson", "neighbours"), |bench| {
            bench.iter(|| levinson(black_box(&influence), black_box(&d)));
        });
        group.finish();
    }
}

criterion_group!(benches, solvers);
criterion_main!(benches);
