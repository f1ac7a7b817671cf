//! Stiffness curves of road slices: growing factor compared with one search per level, curves of springs compared with
//! sums over them, scaling in slices, points and threads; a metre of pressed road compared with one of springs.
//!
//! `cargo bench --bench slices` measures; `-- --table` prints the tables.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a benchmark may panic, in its helpers, too")]
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "what was measured is printed")]

use std::hint::black_box;
use std::time::Instant;

use criterion::{BenchmarkId, Criterion, Throughput};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tyrewave::internals::{GrowingContact, LineInfluence, PressedRoad, StripCurves};
use tyrewave::road::{Lattice, Limits, RoadSurface, SliceBuilder};
use tyrewave::scene::{DEFAULT, Scene};

mod common;
#[path = "../tests/suite/line_contact/line_search.rs"]
mod line_search;
use common::{median, thread_seconds};

/// Number of levels at which the search computes the same curve.
const LEVELS: u32 = 64;
const WIDTH: f64 = 0.16;
const LENGTH: f64 = 3.8e-3;

/// Slices of `points` heights: a random walk of about a millimetre across the width.
fn heights(slices: usize, points: usize) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let mut z = 0.0;
    let step = 2e-3 / (points as f64).sqrt();
    (0..slices * points)
        .map(|place| {
            z = if place % points == 0 { 0.0 } else { 0.95 * z + step * (rng.random::<f64>() - 0.5) };
            z
        })
        .collect()
}

fn depths(row: &[f64]) -> Vec<f64> {
    let peak = row.iter().copied().fold(f64::MIN, f64::max);
    row.iter().map(|z| peak - z).collect()
}

/// Force at all levels by one search each, started from the level below; and the multiply-adds.
fn searched(line: &LineInfluence, depths: &[f64], deepest: f64) -> (Vec<f64>, u64) {
    let (mut forces, mut work, mut guess) = (Vec::new(), 0, None::<Vec<bool>>);
    for level in 1..=LEVELS {
        let y = deepest * f64::from(level) / f64::from(LEVELS);
        let contact = line_search::solve(line, depths, y, guess.as_deref());
        forces.push(contact.pressure.iter().sum());
        work += contact.multiply_adds;
        guess = Some(contact.touching);
    }
    (forces, work)
}

/// Checks that the followed curve contains the searched forces.
fn checked(growing: &GrowingContact, line: &LineInfluence, forces: &[f64], deepest: f64) {
    for (level, force) in (1..=LEVELS).zip(forces) {
        let y = deepest * f64::from(level) / f64::from(LEVELS);
        let followed: f64 = growing.events().iter().map(|&(touch, w)| w * (y - touch).max(0.0)).sum();
        let error = (followed - force).abs() / (y * line.flat_stiffness());
        assert!(error < 1e-11, "error {error:e} at {y}");
    }
}

fn tables() {
    println!(
        "| points | curve by growing factor, us | {LEVELS} searches, us | time ratio | multiply-adds ratio |\n\
         |---|---|---|---|---|"
    );
    for points in [20, 40, 80, 160, 320] {
        let line = LineInfluence::love(points, LENGTH, WIDTH / points as f64);
        let slices = (20_000 / points).max(20);
        let all = heights(slices, points);
        let mut growing = GrowingContact::default();
        let mut rounds: [Vec<f64>; 2] = Default::default();
        let mut ratio = 0.0;
        // The thread's clock has ticks of some milliseconds: whole batches are timed, and the short side repeatedly.
        const REPEATED: usize = 20;
        for _ in 0..3 {
            let begin = thread_seconds();
            for _ in 0..REPEATED {
                for row in all.chunks_exact(points) {
                    growing.follow(&line, &depths(row));
                }
            }
            let followed = (thread_seconds() - begin) / REPEATED as f64;
            let before = growing.multiply_adds();
            let (mut work, mut searching) = (0, 0.0);
            for batch in all.chunks(points * slices.div_ceil(4)) {
                let mut contacts = Vec::new();
                for row in batch.chunks_exact(points) {
                    growing.follow(&line, &depths(row));
                    contacts.push(growing.clone());
                }
                let begin = thread_seconds();
                for (row, growing) in batch.chunks_exact(points).zip(&contacts) {
                    let deepest = growing.events()[points - 1].0;
                    let (forces, adds) = searched(&line, &depths(row), deepest);
                    work += adds;
                    checked(growing, &line, &forces, deepest);
                }
                searching += thread_seconds() - begin;
            }
            ratio = work as f64 / (growing.multiply_adds() - before) as f64;
            for (round, spent) in rounds.iter_mut().zip([followed, searching]) {
                round.push(1e6 * spent / slices as f64);
            }
        }
        let [followed, searched] = rounds.map(median);
        println!("| {points} | {followed:.1} | {searched:.0} | {:.0} | {ratio:.1} |", searched / followed);
    }
    println!(
        "\n| law | slices | points | 1 thread, CPU s | ns a height | 1 thread, s | 2 threads, s | parallel efficiency \
         | largest error, um |\n|---|---|---|---|---|---|---|---|---|"
    );
    let pool = |threads: usize| rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a thread pool");
    let (one, two) = (pool(1), pool(2));
    for (slices, points) in [(10_000, 80), (100_000, 80), (100_000, 20), (100_000, 40), (25_000, 160), (6_000, 320)] {
        let all = heights(slices, points);
        let half_space = SliceBuilder::half_space(points, LENGTH, WIDTH / points as f64).expect("cells of some size");
        let springs = || SliceBuilder::winkler(points).expect("some points");
        let laws = [
            ("winkler, sorted", springs(), 0.0),
            ("winkler, by bins", springs(), 1e-6),
            ("half-space", half_space, 1e-6),
        ];
        for (law, builder, tolerance) in laws {
            let builder = builder.with_tolerance(tolerance).expect("a tolerance");
            let mut error = 0.0_f64;
            let mut times: [Vec<f64>; 3] = Default::default();
            for _ in 0..3 {
                let first = one.install(|| {
                    let (begin, cpu) = (Instant::now(), thread_seconds());
                    let curves = builder.build_rows(&all).expect("curves");
                    times[0].push(thread_seconds() - cpu);
                    times[1].push(begin.elapsed().as_secs_f64());
                    curves
                });
                let begin = Instant::now();
                let second = two.install(|| builder.build_rows(&all).expect("curves"));
                times[2].push(begin.elapsed().as_secs_f64());
                assert_eq!(first, second, "the number of threads changed the result");
                error = first.iter().fold(error, |error, curve| error.max(curve.error));
            }
            let [cpu, wall, both] = times.map(median);
            println!(
                "| {law} | {slices} | {points} | {cpu:.2} | {:.1} | {wall:.2} | {both:.2} | {:.2} | {:.2} |",
                1e9 * cpu / (slices * points) as f64,
                wall / (2.0 * both),
                1e6 * error
            );
        }
    }
}

/// The default tyre on its road, metre by metre: pressed curves, and those of springs.
struct Metres {
    surface: RoadSurface,
    pressed: PressedRoad,
    springs: SliceBuilder,
    lattice: Lattice,
    /// Number of elements in a metre, and the first element not used yet.
    elements: usize,
    next: i64,
}

impl Metres {
    /// `elements` elements around the tyre, with cells of 2 mm.
    fn new(elements: usize) -> Self {
        let scene = Scene::from_str(DEFAULT, "scene").expect("the default scene").scene;
        let (dx, width) = (scene.tyre.circumference / elements as f64, scene.tyre.contact_width);
        let columns = Lattice::across(width, 2e-3);
        let lattice = Lattice { dx, along: (dx / 2e-3).round() as usize, dy: width / columns as f64, columns };
        let radius = scene.tyre.crown_radius.expect("a crown");
        let crown = (0..columns).map(|column| lattice.y(column).powi(2) / (2.0 * radius)).collect();
        Self {
            surface: RoadSurface::open(&scene.road, lattice, Limits::default()).expect("the default road"),
            pressed: PressedRoad::new(&scene.tyre, lattice, crown).expect("a tread").uncached(),
            springs: SliceBuilder::winkler(columns).and_then(|law| law.with_lines(lattice.along)).expect("a lattice"),
            lattice,
            elements: (1.0 / dx) as usize,
            next: 0,
        }
    }

    /// Largest error of the next metre's pressed curves \[m\].
    fn press(&mut self) -> f64 {
        let from = self.next;
        self.next += self.elements as i64;
        let curves = self.pressed.curves(&mut self.surface, from..self.next).expect("curves");
        curves.iter().fold(0.0, |error, curve| error.max(curve.error))
    }

    /// Largest error of the next metre's curves of springs \[m\].
    fn spring(&mut self) -> f64 {
        let mut heights = vec![0.0; self.elements * self.lattice.cells()];
        self.surface.heights(self.next, self.elements, &mut heights).expect("heights");
        self.next += self.elements as i64;
        let curves = self.springs.build_rows(&heights).expect("curves");
        curves.iter().fold(0.0, |error, curve| error.max(curve.error))
    }
}

fn table_of_metres() {
    const METRES: usize = 20;
    println!("\n| elements | law | ms a metre | largest error, um |\n|---|---|---|---|");
    for elements in [256, 512, 1024] {
        let mut metres = Metres::new(elements);
        // The tables of the pressed road are made once.
        metres.press();
        let laws = [("winkler", Metres::spring as fn(&mut Metres) -> f64), ("pressed", Metres::press)];
        for (law, make) in laws {
            let begin = thread_seconds();
            let error = (0..METRES).map(|_| make(&mut metres)).fold(0.0, f64::max);
            let time = 1e3 * (thread_seconds() - begin) / METRES as f64;
            println!("| {elements} | {law} | {time:.1} | {:.2} |", 1e6 * error);
        }
    }
}

/// S(y) of independent springs, summed over them.
fn summed_springs(depths: &[f64], y: f64) -> f64 {
    depths.iter().map(|depth| (y - depth).max(0.0)).sum::<f64>() / depths.len() as f64
}

fn measure(criterion: &mut Criterion) {
    for elements in [256, 512] {
        let mut metres = Metres::new(elements);
        metres.press();
        let mut group = criterion.benchmark_group(format!("a metre of road, N = {elements}"));
        group.sample_size(10).throughput(Throughput::Elements(1));
        group.bench_function("springs", |bencher| bencher.iter(|| metres.spring()));
        group.bench_function("pressed", |bencher| bencher.iter(|| metres.press()));
        group.finish();
    }
    const ROWS: usize = 100;
    for points in [20, 40, 80, 160] {
        let line = LineInfluence::love(points, LENGTH, WIDTH / points as f64);
        let all = heights(ROWS, points);
        let of_one = depths(&all[..points]);
        let mut growing = GrowingContact::default();
        growing.follow(&line, &of_one);
        let deepest = growing.events()[points - 1].0;
        let (forces, _) = searched(&line, &of_one, deepest);
        checked(&growing, &line, &forces, deepest);
        // Time per element is time per slice.
        let mut group = criterion.benchmark_group(format!("half-space slices of {points} points"));
        group.sample_size(10).throughput(Throughput::Elements(1));
        group.bench_function("growing factor", |bencher| {
            bencher.iter(|| growing.follow(&line, &of_one));
        });
        group.bench_function(BenchmarkId::new("searches", LEVELS), |bencher| {
            bencher.iter(|| searched(&line, &of_one, deepest));
        });
        group.finish();

        // Springs: curves made once and looked up, or sums over the springs each time.
        let winkler = SliceBuilder::winkler(points).expect("some points");
        let curves = winkler.build_rows(&all).expect("curves");
        let all_depths: Vec<Vec<f64>> = all.chunks_exact(points).map(depths).collect();
        let levels: Vec<f64> = (1..=LEVELS).map(|level| 2e-3 * f64::from(level) / f64::from(LEVELS)).collect();
        for (curve, depths) in curves.iter().zip(&all_depths) {
            for &y in &levels {
                let error = (curve.displacement_at(y) - summed_springs(depths, y)).abs();
                assert!(error < 1e-14, "error {error:e} m at {y}");
            }
        }
        let mut group = criterion.benchmark_group(format!("spring slices of {points} points"));
        group.sample_size(10).throughput(Throughput::Elements(ROWS as u64));
        group.bench_function("curves made", |bencher| {
            bencher.iter(|| winkler.build_rows(black_box(&all)).expect("curves"));
        });
        group.bench_function(BenchmarkId::new("penetrations by curve", LEVELS), |bencher| {
            let at = |y: f64| curves.iter().map(|curve| curve.displacement_at(y)).sum::<f64>();
            bencher.iter(|| black_box(&levels).iter().map(|&y| at(y)).sum::<f64>());
        });
        group.bench_function(BenchmarkId::new("penetrations by sums", LEVELS), |bencher| {
            let at = |y: f64| all_depths.iter().map(|depths| summed_springs(depths, y)).sum::<f64>();
            bencher.iter(|| black_box(&levels).iter().map(|&y| at(y)).sum::<f64>());
        });
        group.finish();
    }
}

fn main() {
    if std::env::args().any(|argument| argument == "--table") {
        tables();
        table_of_metres();
        return;
    }
    let mut criterion = Criterion::default().configure_from_args();
    measure(&mut criterion);
    criterion.final_summary();
}
