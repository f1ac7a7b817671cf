//! The linear systems of the search: G0 of the points in contact, 16 to 512 of them, solved by LU, by Cholesky and by
//! LDLT (without pivoting), with new or retained factors, by the program's LDLT by panels, by Levinson's recursion if
//! the points are neighbours, and with one point more than a retained factor has, each with its residual.
//!
//! G0 plus the compliances of slices, of a rotating tyre, from a guess to the tolerance: by corrections with a new
//! factor of the whole symmetric matrix or of a band; by conjugate residuals with that of the whole, retained for 1 and
//! 4 instants in which only slopes have changed, not the points (plain corrections with it diverge: slopes change by
//! factors at the ends of the patch).
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
use pulp::Arch;
use tyrewave::internals::{Aligned, LINE, Ldlt, Ring, add_to_diagonal, add_windows, packed_length, plate_scene};
use tyrewave::tyre::{Field, InfluenceSum, Projection, Truncation};

/// G0 by distance: the default tyre with `elements` elements at 80 km/h, its rule's first weight at `rate`/dt;
/// symmetric and skew part, the latter from waves of O_n = `skew` E_n.
fn instant_influence(elements: usize, rate: f64, skew: f64) -> [Vec<f64>; 2] {
    let scene = plate_scene();
    let time_step = scene.tyre.circumference / elements as f64 / scene.rolling.speed();
    let projection = Projection::new(&scene.tyre, elements);
    let sum = InfluenceSum::with(&scene.tyre, projection, Truncation::Tail, 1e-8, rate / time_step);
    let at = sum.at(Complex64::new(rate / time_step, 0.0));
    let even = |n: usize| sum.value(n, &at, Field::Surface).value.re;
    let mut ring = Ring::new(elements);
    [ring.elements_of(even).to_vec(), ring.odd_elements_of(|n| skew * even(n)).to_vec()]
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

/// Solves with one point more than the factor has, by bordering with its row: two solves with the factor.
fn bordered(solve: impl Fn(&[f64]) -> Vec<f64>, row: &[f64], diagonal: f64, d: &[f64], last: f64) -> Vec<f64> {
    let (without, share) = (solve(d), solve(row));
    let dot = |values: &[f64]| row.iter().zip(values).map(|(a, b)| a * b).sum::<f64>();
    let force = (last - dot(&without)) / (diagonal - dot(&share));
    let mut solution: Vec<f64> = without.iter().zip(&share).map(|(a, b)| a - force * b).collect();
    solution.push(force);
    solution
}

fn solvers(criterion: &mut Criterion) {
    let [influence, _] = instant_influence(4096, 1.5, 0.0);
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
            let (mut memory, mut right) = (vec![0.0; packed_length(points)], vec![0.0; stride]);
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
        let (mut solver, mut memory, mut values) =
            (Ldlt::new(points), vec![0.0; packed_length(points)], vec![0.0; stride]);
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

/// Slices of an instant on consecutive points: G0, and the additional compliance of each slice.
struct Slices {
    points: Vec<usize>,
    /// Symmetric part of G0 by distance.
    influence: Vec<f64>,
    /// G0 from distance 1 - points on.
    row: Vec<f64>,
    /// Additional compliance c (1/s - 1).
    additional: Vec<f64>,
    /// Exact forces, and a guess of them; they displace the points as wanted.
    forces: [Vec<f64>; 2],
    wanted: Vec<f64>,
    arch: Arch,
}

impl Slices {
    /// On stones of 3 mm under a tyre that has moved by `instant` instants, half an element each.
    fn new([even, odd]: &[Vec<f64>; 2], points: usize, compliance: f64, instant: usize) -> Self {
        let signed = |distance: i64| {
            let (even, odd) = (even[distance.unsigned_abs() as usize], odd[distance.unsigned_abs() as usize]);
            if distance < 0 { even - odd } else { even + odd }
        };
        let (last, padded) = (points as i64 - 1, points.next_multiple_of(LINE) as i64);
        let slope = |i: usize| {
            let along = ((i as f64 + 0.5 - 0.5 * instant as f64) / points as f64).clamp(0.002, 0.998);
            let stone = 0.6 + 0.35 * (i as f64 * 12.9898).sin();
            1.0 - (-6.0 * stone * along * (1.0 - along) * 4.0).exp()
        };
        let force =
            |i: usize| 40.0 * (PI * (i as f64 + 0.5) / points as f64).sin() * (1.0 + 0.5 * (i as f64 * 7.7).sin());
        let exact: Vec<f64> = (0..points).map(force).collect();
        let guess = exact.iter().enumerate().map(|(i, force)| force * (1.0 + 0.02 * (i as f64 * 3.1).cos())).collect();
        let mut slices = Self {
            points: (0..points).collect(),
            influence: even[..points].to_vec(),
            row: (-last..=padded).map(signed).collect(),
            additional: (0..points).map(|i| compliance * (slope(i).recip() - 1.0)).collect(),
            forces: [exact, guess],
            wanted: vec![0.0; points],
            arch: Arch::new(),
        };
        let mut displaced = vec![0.0; points.next_multiple_of(LINE)];
        slices.displace(&slices.forces[0], &mut displaced);
        let parts = displaced.iter().zip(&slices.additional).zip(&slices.forces[0]);
        slices.wanted = parts.map(|((displaced, additional), force)| displaced + additional * force).collect();
        slices
    }

    fn displace(&self, forces: &[f64], displaced: &mut [f64]) {
        displaced.fill(0.0);
        add_windows(self.arch, displaced, &self.row, forces.len() - 1, forces);
    }

    fn factorise(&self, solver: &mut Ldlt, matrix: &mut [f64], band: usize) {
        solver.assemble_band(&self.points, &self.influence, matrix, band);
        add_to_diagonal(matrix, &self.additional);
        solver.factorise_band(matrix, self.points.len(), band).expect("G0 is positive definite");
    }

    /// Computes the residuals; returns the largest.
    fn residuals(&self, forces: &[f64], residuals: &mut [f64]) -> f64 {
        self.displace(forces, residuals);
        let equations = residuals.iter_mut().zip(&self.wanted).zip(&self.additional).zip(forces);
        equations.fold(0.0_f64, |largest, (((residual, wanted), additional), force)| {
            *residual = wanted - additional * force - *residual;
            largest.max(residual.abs())
        })
    }

    /// Corrects the guess until the residual is at most 0.5e-12 of the largest displacement; returns the number of
    /// corrections and the relative residual. With `directions` each correction is conjugate to those before.
    fn solve(
        &self,
        solver: &mut Ldlt,
        (matrix, band): (&[f64], usize),
        [forces, residuals]: [&mut [f64]; 2],
        directions: Option<&mut Vec<[Vec<f64>; 2]>>,
    ) -> (usize, f64) {
        let (points, stride) = (self.points.len(), residuals.len());
        forces.copy_from_slice(&self.forces[1]);
        let scale = self.wanted.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        let Some(directions) = directions else {
            for corrections in 0..MOST_CORRECTIONS {
                let largest = self.residuals(forces, residuals);
                if largest <= 0.5e-12 * scale {
                    return (corrections, largest / scale);
                }
                solver.solve_band(matrix, residuals, stride, points, band).expect("G0 is positive definite");
                forces.iter_mut().zip(&*residuals).for_each(|(force, change)| *force += change);
            }
            return (MOST_CORRECTIONS, f64::NAN);
        };
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut largest = self.residuals(forces, residuals);
        for corrections in 0..MOST_CORRECTIONS {
            if largest <= 0.5e-12 * scale {
                return (corrections, largest / scale);
            }
            let (before, after) = directions.split_at_mut(corrections);
            let [change, effect] = &mut after[0];
            change.copy_from_slice(residuals);
            solver.solve_band(matrix, change, stride, points, band).expect("G0 is positive definite");
            self.displace(&change[..points], effect);
            effect
                .iter_mut()
                .zip(&self.additional)
                .zip(&*change)
                .for_each(|((effect, additional), change)| *effect += additional * change);
            for [other, its] in before {
                let share = dot(&effect[..points], &its[..points]);
                change.iter_mut().zip(&*other).for_each(|(change, other)| *change -= share * other);
                effect.iter_mut().zip(&*its).for_each(|(effect, its)| *effect -= share * its);
            }
            let length = dot(&effect[..points], &effect[..points]).sqrt();
            change.iter_mut().chain(&mut *effect).for_each(|value| *value /= length);
            let share = dot(&residuals[..points], &effect[..points]);
            forces.iter_mut().zip(&*change).for_each(|(force, change)| *force += share * change);
            largest = self.residuals(forces, residuals);
        }
        (MOST_CORRECTIONS, largest / scale)
    }
}

/// Number of corrections after which a method has failed.
const MOST_CORRECTIONS: usize = 60;

/// Slices with a separate compliance, with the different factors.
fn yielding(criterion: &mut Criterion) {
    const KAPPA: f64 = 4.6e-10;
    /// First rate of `sdirk2`.
    const RATE: f64 = 2.0 + std::f64::consts::SQRT_2;
    let tyre = plate_scene().tyre;
    for (points, elements) in [(34_usize, 512_usize), (67, 1024), (134, 2048), (268, 4096)] {
        // The largest skew part of any tyre.
        let influence = instant_influence(elements, RATE, 4.0 * PI / (RATE * elements as f64));
        let compliance = KAPPA / (tyre.circumference / elements as f64 * tyre.contact_width);
        let slices = Slices::new(&influence, points, compliance, 0);
        let mut solver = Ldlt::new(points);
        let [mut matrix, mut retained] = [packed_length(points), packed_length(points)].map(Aligned::new);
        let (matrix, retained) = (matrix.part(0, packed_length(points)), retained.part(0, packed_length(points)));
        let (mut forces, mut residuals) = (vec![0.0; points], Aligned::new(points.next_multiple_of(LINE)));
        let residuals = residuals.part(0, points.next_multiple_of(LINE));
        let mut directions = vec![[vec![0.0; residuals.len()], vec![0.0; residuals.len()]]; MOST_CORRECTIONS];
        let mut group = criterion.benchmark_group(format!("{points} slices that yield"));
        group.sample_size(20);
        let mut ways: Vec<(String, usize, Option<usize>)> = vec![("whole, made anew".to_owned(), points, None)];
        ways.extend([1, 4].map(|age| (format!("whole, kept for {age} instants"), points, Some(age))));
        ways.extend([1, 2, 3].map(|band| (format!("band of {band} blocks, made anew"), band, None)));
        for (name, band, age) in ways {
            if let Some(age) = age {
                // The factor of `age` instants before.
                Slices::new(&influence, points, compliance, age).factorise(&mut solver, retained, band);
            }
            let mut solved = |matrix: &mut [f64]| {
                if age.is_none() {
                    slices.factorise(&mut solver, matrix, band);
                }
                let factor = if age.is_none() { &*matrix } else { &*retained };
                slices.solve(&mut solver, (factor, band), [&mut forces, residuals], age.map(|_| &mut directions))
            };
            let (corrections, residual) = solved(matrix);
            group.bench_function(&*name, |bench| bench.iter(|| black_box(solved(black_box(&mut *matrix)))));
            let error = slices.forces[0].iter().zip(&forces).fold(0.0_f64, |a, (b, c)| a.max((b - c).abs() / 40.0));
            println!("{points} slices, {name}: {corrections} corrections, residual {residual:.0e}, forces {error:.0e}");
            assert!(error < 1e-9, "{name}: {error:e}");
        }
        group.finish();
    }
}

criterion_group!(benches, solvers, yielding);
criterion_main!(benches);
