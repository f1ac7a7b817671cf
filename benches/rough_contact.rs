//! Rough contact on the half-space: iterations and thread-CPU time over grid size, surface and number of threads, each
//! solution checked; and criterion measurements compared with a plain convolution.
//!
//! `cargo bench --bench rough_contact` measures; `-- --table 128,256,512` prints the table.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a benchmark may panic, in its helpers, too")]
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "what was measured is printed")]

use std::f64::consts::PI;
use std::time::Instant;

use criterion::{BenchmarkId, Criterion, Throughput};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rustfft::FftPlanner;
use rustfft::num_complex::Complex64;
use tyrewave::half_space::{Extent, HeightMap, Indentation, IndentationControl, IndentationLimits, indent};
use tyrewave::internals::{Convolution, love_displacement};

mod common;
use common::{median, thread_seconds};

const SIDE: f64 = 0.128;
/// E = 1e7 Pa, nu = 0.45.
const MODULUS: f64 = 1e7 / (1.0 - 0.45 * 0.45);

/// A periodic random surface, Hurst exponent 0.8 between a quarter of the side and four cells, rms slope 0.1, with the
/// cap of a sphere of radius 0.3 m under it if `sphere`.
fn surface(n: usize, sphere: bool) -> HeightMap {
    let mut rng = ChaCha8Rng::seed_from_u64(20030101);
    let dx = SIDE / n as f64;
    let (longest, shortest) = (2.0 * PI / (SIDE / 4.0), 2.0 * PI / (4.0 * dx));
    let wavenumber = |i: usize| 2.0 * PI / SIDE * if i < n / 2 { i as f64 } else { i as f64 - n as f64 };
    let mut spectrum = vec![Complex64::default(); n * n];
    let mut slope = 0.0;
    for i in 0..n {
        for j in 0..n {
            let k = wavenumber(i).hypot(wavenumber(j));
            // Two uniform numbers for every mode, used or not: sizes share the statistics of their random sequence
            // only.
            let (size, phase) = (rng.random::<f64>(), 2.0 * PI * rng.random::<f64>());
            if k > 0.0 && k <= shortest {
                let amplitude = k.max(longest).powf(-1.8) * (-(1.0 - size).ln()).sqrt();
                spectrum[i * n + j] = Complex64::from_polar(amplitude, phase);
                slope += 0.5 * (k * amplitude).powi(2);
            }
        }
    }
    let transform = FftPlanner::new().plan_fft_inverse(n);
    for _ in 0..2 {
        transform.process(&mut spectrum);
        for i in 0..n {
            for j in 0..i {
                spectrum.swap(i * n + j, j * n + i);
            }
        }
    }
    let scale = 0.1 / slope.sqrt();
    let middle = 0.5 * (n as f64 - 1.0);
    let heights = (0..n * n)
        .map(|place| {
            let (x, y) = (((place / n) as f64 - middle) * dx, ((place % n) as f64 - middle) * dx);
            let rough = spectrum[place].re * scale;
            if sphere { rough - (x * x + y * y) / 0.6 } else { rough }
        })
        .collect();
    HeightMap { heights, extent: Extent { nx: n, ny: n }, dx, dy: dx }
}

fn penetration(map: &HeightMap, sphere: bool) -> f64 {
    if sphere {
        return 0.003;
    }
    let mean = map.heights.iter().sum::<f64>() / map.heights.len() as f64;
    let peak = map.heights.iter().copied().fold(f64::MIN, f64::max);
    0.75 * (peak - mean)
}

/// Checks the contact conditions from the pressure alone.
fn checked(map: &HeightMap, contact: &Indentation) {
    assert!(contact.residual <= 1e-8, "residual {:e}", contact.residual);
    let Extent { nx, ny } = map.extent;
    let kernel = |i: usize, j: usize| love_displacement(i as f64 * map.dx, j as f64 * map.dy, map.dx, map.dy) / MODULUS;
    let mut displacement = vec![0.0; nx * ny];
    Convolution::<f64>::from_kernel(map.extent, kernel).apply(&contact.pressure, &mut displacement, |_| true);
    let peak = map.heights.iter().copied().fold(f64::MIN, f64::max);
    let plane = peak - contact.penetration;
    for ((u, z), p) in displacement.iter().zip(&map.heights).zip(&contact.pressure) {
        let gap = (u - (z - plane)) / contact.penetration;
        assert!(gap > -2e-8 && (*p <= 0.0 || gap < 2e-8) && *p >= 0.0, "gap {gap:e} at pressure {p}");
    }
}

fn table(sizes: &str) {
    println!(
        "| cells | surface | given | area | iterations | convolutions | residual | 1 thread, CPU s | 1 thread, s | 2 \
         threads, s |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    let pool = |threads: usize| rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a thread pool");
    let (one, two) = (pool(1), pool(2));
    for n in sizes.split(',').filter_map(|n| n.parse::<usize>().ok()) {
        for sphere in [true, false] {
            let map = surface(n, sphere);
            let penetration = IndentationControl::Penetration(penetration(&map, sphere));
            let solve = |control| indent(&map, MODULUS, control, IndentationLimits::default()).expect("a solution");
            let load = IndentationControl::Load(solve(penetration).load);
            for (name, control) in [("penetration", penetration), ("load", load)] {
                let mut times: [Vec<f64>; 3] = Default::default();
                let mut contact = solve(control);
                for _ in 0..5 {
                    one.install(|| {
                        let (begin, cpu) = (Instant::now(), thread_seconds());
                        contact = solve(control);
                        times[0].push(thread_seconds() - cpu);
                        times[1].push(begin.elapsed().as_secs_f64());
                    });
                    let begin = Instant::now();
                    let same = two.install(|| solve(control));
                    times[2].push(begin.elapsed().as_secs_f64());
                    assert_eq!(same, contact, "the number of threads changed the result");
                }
                checked(&map, &contact);
                let [cpu, wall, both] = times.map(median);
                println!(
                    "| {n} x {n} | {} | {name} | {:.3} | {} | {} | {:.1e} | {cpu:.3} | {wall:.3} | {both:.3} |",
                    if sphere { "rough sphere" } else { "rough plane" },
                    contact.area_fraction,
                    contact.iterations,
                    contact.convolutions,
                    contact.residual,
                );
            }
        }
    }
}

/// The textbook convolution: the whole padded grid as complex numbers, row and column transforms in place.
fn plain_convolution(kernel: &[Complex64], input: &[f64], n: usize, work: &mut [Complex64]) {
    let m = 2 * n;
    let mut planner = FftPlanner::new();
    let (forward, inverse) = (planner.plan_fft_forward(m), planner.plan_fft_inverse(m));
    work.fill(Complex64::default());
    for (row, input) in work.chunks_exact_mut(m).zip(input.chunks_exact(n)) {
        for (value, &input) in row.iter_mut().zip(input) {
            value.re = input;
        }
    }
    let transpose = |work: &mut [Complex64]| {
        for i in 0..m {
            for j in 0..i {
                work.swap(i * m + j, j * m + i);
            }
        }
    };
    forward.process(work);
    transpose(work);
    forward.process(work);
    work.iter_mut().zip(kernel).for_each(|(value, kernel)| *value *= kernel);
    inverse.process(work);
    transpose(work);
    inverse.process(work);
}

fn measure(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("rough_contact");
    group.sample_size(10);
    for n in [64, 128, 256] {
        let map = surface(n, true);
        let control = IndentationControl::Penetration(penetration(&map, true));
        let solve = || indent(&map, MODULUS, control, IndentationLimits::default()).expect("a solution");
        checked(&map, &solve());
        group.throughput(Throughput::Elements((n * n) as u64));
        group.bench_function(BenchmarkId::new("rough sphere", n), |bencher| bencher.iter(solve));
        let kernel = |i: usize, j: usize| love_displacement(i as f64 * map.dx, j as f64 * map.dy, map.dx, map.dy);
        let mut convolution = Convolution::<f64>::from_kernel(map.extent, kernel);
        let mut output = vec![0.0; n * n];
        convolution.apply(&map.heights, &mut output, |_| true);
        let m = 2 * n;
        let mut spectrum: Vec<Complex64> = (0..m * m)
            .map(|place| {
                let (i, j) = (place / m, place % m);
                let (i, j) = (i.min(m - i), j.min(m - j));
                if i < n && j < n { kernel(i, j).into() } else { Complex64::default() }
            })
            .collect();
        let forward = FftPlanner::new().plan_fft_forward(m);
        for _ in 0..2 {
            forward.process(&mut spectrum);
            for i in 0..m {
                for j in 0..i {
                    spectrum.swap(i * m + j, j * m + i);
                }
            }
        }
        let mut work = vec![Complex64::default(); m * m];
        plain_convolution(&spectrum, &map.heights, n, &mut work);
        let scale = 1.0 / (m * m) as f64;
        for place in 0..n * n {
            let plain = work[place / n * m + place % n].re * scale;
            assert!((plain - output[place]).abs() <= 1e-12 * output[0].abs(), "{plain} {}", output[place]);
        }
        group.bench_function(BenchmarkId::new("convolution", n), |bencher| {
            bencher.iter(|| convolution.apply(&map.heights, &mut output, |_| true));
        });
        group.bench_function(BenchmarkId::new("plain convolution", n), |bencher| {
            bencher.iter(|| plain_convolution(&spectrum, &map.heights, n, &mut work));
        });
    }
    group.finish();
}

fn main() {
    let mut arguments = std::env::args().skip_while(|argument| argument != "--table").skip(1);
    if let Some(sizes) = arguments.next() {
        table(&sizes);
        return;
    }
    let mut criterion = Criterion::default().configure_from_args();
    measure(&mut criterion);
    criterion.final_summary();
}
