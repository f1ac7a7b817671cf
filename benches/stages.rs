//! Stages of a run compared with plain methods, in doubling sizes: transforms between wavenumbers and elements; time
//! steps by poles and by direct sums; vibration streamed segment by segment and from the whole record; the velocity for
//! unit force; the averaged spectrum computed sample by sample and by one transform of the record; arrays written row
//! by row and at once. Both sides are compared before they are timed.
//!
//! `cargo bench --bench stages`.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a benchmark may panic, in its helpers, too")]
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "what was measured is printed")]

use std::f64::consts::PI;
use std::fs;
use std::hint::black_box;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use npyz::WriterBuilder;
use num_complex::Complex64;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use realfft::RealFftPlanner;
use rustfft::FftPlanner;
use tyrewave::Plan;
use tyrewave::counters::{Job, Meter, Unwatched};
use tyrewave::internals::{
    self, Across, ArrayRow, CIRCUMFERENCE, NpyWriter, Prepared, Ring, SegmentLayout, TransferKind, TyreResponse,
    VibrationAccumulator, VibrationField, add, edit, fetch_model, fit_options, prepare, symbols,
};
use tyrewave::response::{PowerSpectrum, ThirdOctaveBand};
use tyrewave::scene::{LoadedScene, PLATE, TimeRule};
use tyrewave::tyre::Field;

/// Elements around the tyre.
const SIZES: [usize; 4] = [128, 256, 512, 1024];
const SPEED: f64 = 80.0 / 3.6;

/// True for a test, without `--bench`, which leaves out the most expensive bench.
fn is_test() -> bool {
    !std::env::args().any(|argument| argument == "--bench")
}

/// Largest difference relative to the largest value of `exact`.
fn difference(found: &[f64], exact: &[f64]) -> f64 {
    assert_eq!(found.len(), exact.len());
    let largest = exact.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    found.iter().zip(exact).fold(0.0_f64, |a, (b, c)| a.max((b - c).abs())) / largest
}

fn transforms(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("transforms");
    for elements in SIZES {
        let value = |n: usize| 1e-6 / (1.0 + n as f64).powi(2);
        let cosines: Vec<f64> = (0..elements).map(|turn| (2.0 * PI * turn as f64 / elements as f64).cos()).collect();
        let half = elements / 2;
        // Waves +-n are one; n = 0 and N/2 occur once.
        let summed = |element: usize| -> f64 {
            let wave =
                |n: usize| if n.is_multiple_of(half) { 1.0 } else { 2.0 } * value(n) * cosines[n * element % elements];
            (0..=half).map(wave).sum()
        };
        let mut ring = Ring::new(elements);
        let exact: Vec<f64> = (0..elements).map(summed).collect();
        let error = difference(ring.elements_of(value), &exact);
        assert!(error < 1e-13, "N = {elements}: {error:e}");
        group.throughput(Throughput::Elements(elements as u64));
        group.bench_function(BenchmarkId::new("fast transform", elements), |bench| {
            bench.iter(|| ring.elements_of(black_box(value))[0]);
        });
        group.bench_function(BenchmarkId::new("sums of cosines", elements), |bench| {
            bench.iter(|| (0..elements).map(|element| summed(black_box(element))).sum::<f64>());
        });
    }
    group.finish();
}

/// The default scene with the given elements and history; practically endless.
fn scene(elements: usize, history: &str, more: &str) -> LoadedScene {
    let text = edit(
        PLATE,
        &[
            ("numerics.elements", &elements.to_string()),
            ("numerics.history", &format!("\"{history}\"")),
            // A rule that direct sums have, too.
            ("numerics.time_rule", "\"bdf2\""),
            ("rolling.duration", "1e5"),
        ],
    );
    internals::scene(&add(&text, "numerics", more))
}

/// A rolling contact on the default road.
struct Rolling {
    prepared: Prepared,
    meter: Meter,
}

impl Rolling {
    fn new(elements: usize, history: &str, more: &str) -> Self {
        let loaded = scene(elements, history, more);
        let (stop, mut unwatched) = (AtomicBool::new(false), Unwatched);
        let mut job = Job::new(&stop, &mut unwatched);
        let prepared = prepare(&loaded, &Plan::new(&loaded.scene), &mut job).expect("a contact");
        Self { prepared, meter: job.meter }
    }

    /// Makes the road under the next steps.
    fn reach(&mut self, steps: u64) {
        let Self { prepared: Prepared { march, road, .. }, meter } = self;
        let (next, geometry) = (march.next_step(), march.geometry());
        let end = geometry.first_element(next + steps - 1) + geometry.columns as i64;
        road.reach(geometry.first_element(next), end, meter).expect("an endless road");
    }

    /// Takes a step under an axle that reacts to the force.
    fn step(&mut self) {
        let Self { prepared: Prepared { march, road, axle, .. }, meter } = self;
        let step = march.next_step();
        let result = march.step(axle, road.slices(), meter).expect("a step");
        axle.observe(step, result.total_force);
    }
}

/// Whole time steps without the road: history, penetration, search. The cost of direct sums depends on their memory; it
/// is filled first, so that nothing is forgotten while the methods are compared and all of it is there when they are
/// timed.
fn march(criterion: &mut Criterion) {
    const STEPS: u64 = 16;
    let memory = if is_test() { 0.05 } else { 0.3 };
    let mut group = criterion.benchmark_group(format!("time steps, direct sums over {memory} s"));
    group.sample_size(10).throughput(Throughput::Elements(STEPS));
    for elements in SIZES {
        let mut ways = [
            ("poles", Rolling::new(elements, "modal", "")),
            ("direct sums", Rolling::new(elements, "direct", &format!("memory = {memory}"))),
        ];
        let (mut peak, mut error) = (0.0_f64, 0.0_f64);
        for _ in 0..(memory * SPEED * elements as f64 / CIRCUMFERENCE) as u64 {
            let [poles, direct] = ways.each_mut().map(|(_, rolling)| {
                rolling.reach(1);
                rolling.step();
                rolling.prepared.march.footprint().column_mean()
            });
            peak = direct.iter().fold(peak, |a, &b| a.max(b));
            error = poles.iter().zip(direct).fold(error, |a, (b, c)| a.max((b - c).abs()));
        }
        println!(
            "N = {elements}: forces by poles {:.0e} of the peak, {peak:.0} N, off those by direct sums",
            error / peak
        );
        assert!(peak > 10.0 && error < 2e-5 * peak, "{error:e} N of {peak} N");
        for (name, rolling) in &mut ways {
            group.bench_function(BenchmarkId::new(*name, elements), |bench| {
                bench.iter_custom(|rounds| {
                    let mut spent = Duration::ZERO;
                    for _ in 0..rounds {
                        rolling.reach(STEPS);
                        let begin = Instant::now();
                        (0..STEPS).for_each(|_| rolling.step());
                        spent += begin.elapsed();
                    }
                    spent
                });
            });
        }
    }
    group.finish();
}

fn layout(elements: usize, revolutions: usize) -> SegmentLayout {
    SegmentLayout {
        across: Across::Even,
        elements,
        advance: 1.into(),
        revolutions,
        columns: elements * 9 / 64,
        rule: TimeRule::Bdf2,
        time_step: CIRCUMFERENCE / elements as f64 / SPEED,
        phase: 0,
        first_position: -0.12,
        circumference: CIRCUMFERENCE,
    }
}

/// Forces of waves with whole periods in a segment, at least two: their means, plain and weighted with the squared
/// window, are zero, so that no mean pattern is subtracted.
fn patch_forces(layout: &SegmentLayout, steps: usize) -> Vec<f64> {
    const WAVES: usize = 8;
    let mut random = ChaCha8Rng::seed_from_u64(9);
    let length = layout.length();
    let mut forces = vec![0.0; steps * layout.columns];
    for column in 0..layout.columns {
        for _ in 0..WAVES {
            let (periods, phase) = (random.random_range(2..length / 2), 2.0 * PI * random.random::<f64>());
            for step in 0..steps {
                let turn = 2.0 * PI * (step * periods % length) as f64 / length as f64;
                forces[step * layout.columns + column] += 10.0 * (turn + phase).cos();
            }
        }
    }
    forces
}

/// Mean powers by bin and wavenumber, streamed.
fn streamed_powers(layout: &SegmentLayout, forces: &[f64]) -> Vec<f64> {
    let mut accumulator = VibrationAccumulator::new(*layout);
    for row in forces.chunks_exact(layout.columns) {
        accumulator.push(row, 0.0);
    }
    accumulator.finish().expect("a whole segment").powers
}

/// The same from the whole record: each step's forces transformed over the ring, then each wavenumber's segments over
/// time.
fn powers_at_once(layout: &SegmentLayout, forces: &[f64]) -> Vec<f64> {
    let (elements, length, steps) = (layout.elements, layout.length(), forces.len() / layout.columns);
    let mut planner = FftPlanner::<f64>::new();
    let (over_ring, over_time) = (planner.plan_fft_forward(elements), planner.plan_fft_forward(length));
    let mut waves = vec![Complex64::ZERO; steps * elements];
    for (wave, row) in waves.chunks_exact_mut(elements).zip(forces.chunks_exact(layout.columns)) {
        wave.iter_mut().zip(row).for_each(|(entry, &force)| *entry = force.into());
    }
    over_ring.process(&mut waves);
    let begins: Vec<usize> = (0..=steps - length).step_by(layout.hop()).collect();
    let scale = 1.0 / (begins.len() * layout.hop() * length) as f64;
    let mut powers = vec![0.0; layout.bins() * layout.wavenumbers()];
    let mut series = vec![Complex64::ZERO; length];
    for index in 0..layout.wavenumbers() {
        let place = layout.wavenumber(index).rem_euclid(elements as i64) as usize;
        for begin in &begins {
            for (step, value) in series.iter_mut().enumerate() {
                *value = layout.weight(step) * waves[(begin + step) * elements + place];
            }
            over_time.process(&mut series);
            for (row, value) in powers.chunks_exact_mut(layout.wavenumbers()).zip(&series) {
                row[index] += scale * value.norm_sqr();
            }
        }
    }
    powers
}

fn vibration(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("vibration, three segments of a revolution");
    group.sample_size(10);
    for elements in SIZES {
        let layout = layout(elements, 1);
        let steps = 2 * layout.length();
        let forces = patch_forces(&layout, steps);
        let error = difference(&streamed_powers(&layout, &forces), &powers_at_once(&layout, &forces));
        assert!(error < 1e-11, "N = {elements}: {error:e}");
        group.throughput(Throughput::Elements(steps as u64));
        group.bench_function(BenchmarkId::new("streamed", elements), |bench| {
            bench.iter(|| streamed_powers(&layout, black_box(&forces)));
        });
        group.bench_function(BenchmarkId::new("whole record", elements), |bench| {
            bench.iter(|| powers_at_once(&layout, black_box(&forces)));
        });
    }
    group.finish();
}

/// One wavenumber's velocity for unit force at all bins: many frequencies side by side, and one after the other.
fn velocities(criterion: &mut Criterion) {
    const ELEMENTS: usize = 128;
    const N: usize = 10;
    let scene = scene(ELEMENTS, "modal", "").scene;
    let options = fit_options(&scene, Field::Surface);
    let model = fetch_model(&scene.tyre, &options, &AtomicBool::new(false)).expect("the default tyre").model;
    let response = TyreResponse { model: &model, scale: 1.0, spring: 0.0, tangential: None };
    let mut group = criterion.benchmark_group("velocity for unit force");
    for revolutions in [4, 8, 16, 32] {
        let symbols = symbols(&layout(ELEMENTS, revolutions), TransferKind::Rule);
        let bins = symbols.len();
        let one_by_one = |s: &Complex64| s * model.evaluate(N, *s, Field::Surface).expect("the surface is fitted");
        let mut found = vec![Complex64::ZERO; bins];
        assert!(response.velocities(N, VibrationField::Tread, &symbols, &mut found));
        let exact: Vec<Complex64> = symbols.iter().map(one_by_one).collect();
        let largest = exact.iter().fold(0.0_f64, |a, b| a.max(b.norm()));
        let error = found.iter().zip(&exact).fold(0.0_f64, |a, (b, c)| a.max((b - c).norm())) / largest;
        assert!(error < 1e-12, "{bins} bins: {error:e}");
        group.throughput(Throughput::Elements(bins as u64));
        group.bench_function(BenchmarkId::new("side by side", bins), |bench| {
            bench.iter(|| response.velocities(N, VibrationField::Tread, black_box(&symbols), &mut found));
        });
        group.bench_function(BenchmarkId::new("one after the other", bins), |bench| {
            bench.iter(|| black_box(&symbols).iter().map(one_by_one).sum::<Complex64>());
        });
    }
    group.finish();
}

/// The whole record's power spectrum by one transform, without a window.
fn one_transform(signal: &[f64], time_step: f64) -> PowerSpectrum {
    let samples = signal.len();
    let mean = signal.iter().sum::<f64>() / samples as f64;
    let transform = RealFftPlanner::<f64>::new().plan_fft_forward(samples);
    let mut varying: Vec<f64> = signal.iter().map(|value| value - mean).collect();
    let mut bins = transform.make_output_vec();
    transform.process(&mut varying, &mut bins).expect("planned lengths");
    let sides = |bin: usize| if bin == 0 || 2 * bin == samples { 1.0 } else { 2.0 };
    let power = bins.iter().enumerate().map(|(bin, x)| sides(bin) * x.norm_sqr() / (samples as f64).powi(2)).collect();
    let mut spectrum = PowerSpectrum::of_powers(power, 1.0 / (samples as f64 * time_step), 0.5 / time_step);
    spectrum.mean = mean;
    spectrum
}

fn spectrum(criterion: &mut Criterion) {
    const TIME_STEP: f64 = 1e-4;
    const SEGMENT: Option<f64> = Some(0.2);
    const TONES: [f64; 3] = [160.0, 400.0, 1000.0];
    let mut group = criterion.benchmark_group("response spectrum");
    for samples in [1_usize << 13, 1 << 14, 1 << 15, 1 << 16] {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let tones = |time: f64| TONES.map(|tone| 100.0 * (2.0 * PI * tone * time).sin()).iter().sum::<f64>();
        let signal: Vec<f64> =
            (0..samples).map(|n| 3400.0 + tones(n as f64 * TIME_STEP) + random.random_range(-1.0..1.0)).collect();
        let averaged = PowerSpectrum::of(&signal, TIME_STEP, SEGMENT).expect("a spectrum");
        let whole = one_transform(&signal, TIME_STEP);
        let ratio = averaged.mean_square() / whole.mean_square();
        assert!((ratio - 1.0).abs() < 1e-11, "{samples} samples: mean squares differ by {:e}", ratio - 1.0);
        for tone in TONES {
            let band = ThirdOctaveBand::containing(tone).expect("a band");
            let power = |spectrum: &PowerSpectrum| spectrum.power_within(band.lower_edge()..band.upper_edge());
            let difference = 10.0 * (power(&averaged) / power(&whole)).log10();
            assert!(difference.abs() < 0.2, "{samples} samples, {tone} Hz: {difference} dB");
        }
        group.throughput(Throughput::Elements(samples as u64));
        group.bench_function(BenchmarkId::new("sample by sample", samples), |bench| {
            bench.iter(|| PowerSpectrum::of(black_box(&signal), TIME_STEP, SEGMENT).map(|spectrum| spectrum.mean));
        });
        group.bench_function(BenchmarkId::new("one transform", samples), |bench| {
            bench.iter(|| one_transform(black_box(&signal), TIME_STEP).mean);
        });
    }
    group.finish();
}

/// Writes an array row by row, complete but not flushed to the disk.
fn streamed_array(path: &Path, columns: usize, values: &[f64]) {
    let mut writer = NpyWriter::create(path, ArrayRow::Columns(columns)).expect("a file");
    values.chunks_exact(columns).for_each(|row| writer.push(row).expect("a row"));
    writer.checkpoint().expect("a header");
}

/// Writes the same bytes at once, made in memory by the crate npyz.
fn array_at_once(path: &Path, columns: usize, values: &[f64]) {
    let mut bytes = Vec::new();
    let shape = [(values.len() / columns) as u64, columns as u64];
    let options = npyz::WriteOptions::new().default_dtype().shape(&shape).writer(&mut bytes);
    let mut writer = options.begin_nd().expect("a header");
    writer.extend(values.iter().copied()).expect("values");
    writer.finish().expect("all values");
    fs::write(path, bytes).expect("a file");
}

fn output(criterion: &mut Criterion) {
    const COLUMNS: usize = 72;
    let folder = tempfile::tempdir().expect("a folder");
    let paths = ["streamed.npy", "at_once.npy"].map(|name| folder.path().join(name));
    let mut group = criterion.benchmark_group("output");
    for rows in [1024_usize, 2048, 4096, 8192] {
        let values: Vec<f64> = (0..rows * COLUMNS).map(|place| (place as f64).sqrt()).collect();
        streamed_array(&paths[0], COLUMNS, &values);
        array_at_once(&paths[1], COLUMNS, &values);
        for path in &paths {
            let array = npyz::NpyFile::new(fs::File::open(path).expect("the file")).expect("an array");
            assert_eq!(array.shape(), [rows as u64, COLUMNS as u64]);
            assert_eq!(array.into_vec::<f64>().expect("numbers"), values);
        }
        group.throughput(Throughput::Bytes(8 * values.len() as u64));
        group.bench_function(BenchmarkId::new("row by row", rows), |bench| {
            bench.iter(|| streamed_array(&paths[0], COLUMNS, black_box(&values)));
        });
        group.bench_function(BenchmarkId::new("at once", rows), |bench| {
            bench.iter(|| array_at_once(&paths[1], COLUMNS, black_box(&values)));
        });
    }
    group.finish();
}

criterion_group!(benches, transforms, march, vibration, velocities, spectrum, output);
criterion_main!(benches);
