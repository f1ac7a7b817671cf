//! Cost of roads: made texture generated in chunks, alone and with the curves of its slices, compared with one
//! transform of the whole area; a measured profile resampled once and spread across, compared with the same heights
//! resampled column by column. The number of elements around the tyre doubles.
//!
//! `cargo bench --bench road`.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a benchmark may panic, in its helpers, too")]
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "what was measured is printed")]

use std::f64::consts::PI;
use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rustfft::FftPlanner;
use rustfft::num_complex::Complex64;
use tyrewave::internals::{Resampled, RingSpectrum, RoadHeightMap, TargetSpectrum, transform_length};
use tyrewave::road::{Lattice, Limits, RoadSurface, SliceBuilder};
use tyrewave::scene::{AtEnd, MadeRoad, NamedTexture, Road};

const METRES: f64 = 10.0;
const SIZES: [usize; 4] = [128, 256, 512, 1024];

fn lattice(elements: usize) -> Lattice {
    Lattice { dx: 1.95 / elements as f64, along: 1, dy: 0.002, columns: 70 }
}

fn mean_square(heights: &[f64]) -> f64 {
    heights.iter().map(|z| z * z).sum::<f64>() / heights.len() as f64
}

/// The textbook method for a texture of the same spectrum: the whole area at once, random lines along and across,
/// transformed. One metre across, of which the run's columns are used.
fn at_once(spectrum: &RingSpectrum, lattice: Lattice, rows: usize, seed: u64) -> Vec<f64> {
    let (along, across) = (transform_length(rows), (1.024 / lattice.dy).round() as usize);
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let wavenumber = |line: usize, lines: usize, spacing: f64| line.min(lines - line) as f64 / (lines as f64 * spacing);
    let cell = 1.0 / (along as f64 * lattice.dx * across as f64 * lattice.dy);
    let mut planner = FftPlanner::new();
    let (over_columns, over_rows) = (planner.plan_fft_inverse(across), planner.plan_fft_inverse(along));
    let mut row = vec![Complex64::default(); across];
    let mut lattice_spectrum = vec![Complex64::default(); lattice.columns * along];
    for i in 0..along {
        for (j, value) in row.iter_mut().enumerate() {
            let square = wavenumber(i, along, lattice.dx).powi(2) + wavenumber(j, across, lattice.dy).powi(2);
            let (size, phase) = (random.random::<f64>(), 2.0 * PI * random.random::<f64>());
            *value = Complex64::from_polar((-2.0 * (1.0 - size).ln() * spectrum.density(square) * cell).sqrt(), phase);
        }
        over_columns.process(&mut row);
        for (column, value) in row[..lattice.columns].iter().enumerate() {
            lattice_spectrum[column * along + i] = *value;
        }
    }
    over_rows.process(&mut lattice_spectrum);
    (0..rows * lattice.columns)
        .map(|place| lattice_spectrum[place % lattice.columns * along + place / lattice.columns].re)
        .collect()
}

fn made(criterion: &mut Criterion) {
    // Gaussian heights, as those drawn at once.
    let texture = NamedTexture::RoughAsphalt;
    let spec = Road::Made(MadeRoad { texture: Some(texture), ..MadeRoad::default() });
    let spectrum = RingSpectrum::fit(&TargetSpectrum::named(texture));
    let mut group = criterion.benchmark_group("made road");
    group.sample_size(10);
    // As a test, without `--bench`, the expensive sizes are left out.
    let sizes = if std::env::args().any(|argument| argument == "--bench") { &SIZES[..] } else { &SIZES[..2] };
    for &elements in sizes {
        let lattice = lattice(elements);
        let rows = (METRES / lattice.dx) as usize;
        let mut heights = vec![0.0; rows * lattice.columns];
        let mut road = RoadSurface::open(&spec, lattice, Limits::default()).expect("a road");
        road.heights(0, rows, &mut heights).expect("an endless road");
        // Two realisations of one spectrum: their heights agree except for the statistics of 10 m, 35 of the longest
        // waves.
        let ratio = 10.0 * (mean_square(&heights) / mean_square(&at_once(&spectrum, lattice, rows, 1))).log10();
        println!("N = {elements}: the two draws differ by {ratio:.2} dB");
        assert!(ratio.abs() < 1.0, "{ratio} dB");
        // Time per element is time per height.
        group.throughput(Throughput::Elements((rows * lattice.columns) as u64));
        group.bench_function(BenchmarkId::new("open", elements), |bench| {
            bench.iter(|| RoadSurface::open(&spec, lattice, Limits::default()).is_ok());
        });
        let mut first = 0;
        group.bench_function(BenchmarkId::new("drawn in chunks", elements), |bench| {
            bench.iter(|| {
                first += rows as i64;
                assert!(road.heights(first, rows, &mut heights).is_ok());
                // The road must be rough: a realisation that is fast because it is empty fails.
                let height = mean_square(&heights).sqrt();
                assert!((0.3e-3..0.9e-3).contains(&height), "{height} m");
                black_box(height)
            });
        });
        // The work of a run with the standard preset: cells of 2 mm along and across, and the curves of its slices.
        let cells = Lattice { along: (lattice.dx / 0.002).round() as usize, columns: 60, ..lattice };
        let slices = (METRES / cells.dx) as usize;
        let mut area = vec![0.0; slices * cells.cells()];
        let mut road = RoadSurface::open(&spec, cells, Limits::default()).expect("a road");
        let builder = SliceBuilder::winkler(cells.columns).and_then(|builder| builder.with_lines(cells.along));
        group.throughput(Throughput::Elements(area.len() as u64));
        let mut first = 0;
        for (name, tolerance) in [("with curves", 3e-7), ("with exact curves", 0.0)] {
            let builder = builder.clone().and_then(|builder| builder.with_tolerance(tolerance)).expect("some cells");
            group.bench_function(BenchmarkId::new(name, elements), |bench| {
                bench.iter(|| {
                    first += slices as i64;
                    road.heights(first, slices, &mut area).expect("an endless road");
                    builder.build_rows(&area).expect("curves")
                });
            });
        }
        let mut seed = 1;
        group.throughput(Throughput::Elements((METRES / lattice.dx) as u64 * lattice.columns as u64));
        group.bench_function(BenchmarkId::new("drawn at once", elements), |bench| {
            bench.iter(|| {
                seed += 1;
                at_once(&spectrum, lattice, rows, seed)
            });
        });
    }
    group.finish();
}

fn measured(criterion: &mut Criterion) {
    let spacing = 3.75e-5;
    // Waves of 60 mm: four elements of the coarsest tyre.
    let profile: Vec<f64> = (0..48_000).map(|i| 1e-3 * (2.0 * PI * f64::from(i) * spacing / 0.06).sin()).collect();
    let mut group = criterion.benchmark_group("measured road");
    group.sample_size(10);
    for elements in SIZES {
        let lattice = lattice(elements);
        let rows = (METRES / lattice.dx) as usize;
        let map = |columns: usize, dy: f64, first_y: f64| {
            let heights = profile.iter().flat_map(|z| vec![*z; columns]).collect();
            let origins = Vec::new();
            RoadHeightMap { path: "bench".into(), dx: spacing, dy, first_y, columns, heights, origins }
        };
        let mut level = Resampled::new(map(1, 0.0, 0.0), lattice, AtEnd::Repeat);
        let mut by_column = Resampled::new(map(lattice.columns, lattice.dy, lattice.y(0)), lattice, AtEnd::Repeat);
        let (mut spread, mut heights) = (vec![0.0; rows * lattice.columns], vec![0.0; rows * lattice.columns]);
        level.heights(0, &mut spread).unwrap();
        by_column.heights(0, &mut heights).unwrap();
        assert!(spread.iter().zip(&heights).all(|(a, b)| (a - b).abs() < 1e-15), "the ways differ");
        assert!((0.69e-3..0.72e-3).contains(&mean_square(&heights).sqrt()));
        group.throughput(Throughput::Elements(rows as u64));
        for (name, road) in [("profile, spread", &mut level), ("column by column", &mut by_column)] {
            group.bench_function(BenchmarkId::new(name, elements), |bench| {
                bench.iter(|| road.heights(0, black_box(&mut heights)));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, made, measured);
criterion_main!(benches);
