//! Rolling over cells with friction compared with rolling without it, at sizes of presets, the past by poles: whole
//! steps. Poles are fitted before, or come from the cache.
//!
//! `cargo bench --bench friction`.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a benchmark may panic, in its helpers, too")]
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "what was measured is printed")]

use std::time::Instant;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use tyrewave::Plan;
use tyrewave::internals::{scene, scene_text};
use tyrewave::run::Simulation;
use tyrewave::scene::LoadedScene;

/// Elements around the tyre and cells across.
const SIZES: [[usize; 2]; 3] = [[128, 8], [256, 16], [512, 16]];
const FRICTION: &str = "[friction]\nmu = 0.9\ncreep = { longitudinal = 0.02, lateral = 0.03 }";
/// Steps before the measurement.
const ROLLED: usize = 60;

fn rolling([elements, across]: [usize; 2], friction: &str) -> LoadedScene {
    let rolling = "speed_kmh = 80.0\nwarm_up = 0.0\nduration = 10.0\naxle = { indentation = 0.012, ramp = 0.005 }";
    let numerics = "time_rule = \"bdf2\"\nhistory = \"modal\"\npole_tolerance = 1e-4\ncontact_tolerance = 1e-5";
    let more = format!("[contact]\nzone = \"cells\"\ncells_across = {across}\n{friction}");
    let text = scene_text(elements, "kind = \"made\"\nseed = 3", rolling, numerics, &more);
    // Truncated sums would not be split into bands, but stay on one ring.
    scene(&text.replace("lateral_terms = 4\nwavenumber_aliases = 2\n", ""))
}

fn friction(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("friction");
    group.sample_size(20);
    // Larger sizes have many poles to fit.
    let is_test = !std::env::args().any(|argument| argument == "--bench");
    for size in SIZES.into_iter().take(if is_test { 1 } else { SIZES.len() }) {
        let mut times = Vec::new();
        for (name, friction) in [("without", ""), ("with", FRICTION)] {
            let loaded = rolling(size, friction);
            let plan = Plan::of(&loaded).unwrap();
            let mut run = Simulation::begin(&loaded, &plan, &Default::default()).unwrap();
            for _ in 0..ROLLED {
                run.step().unwrap().unwrap();
            }
            let begin = Instant::now();
            for _ in 0..ROLLED {
                run.step().unwrap().unwrap();
            }
            times.push(begin.elapsed().as_secs_f64() / ROLLED as f64);
            group.bench_function(BenchmarkId::new(name, format!("{} x {}", size[0], size[1])), |bench| {
                bench.iter(|| run.step().unwrap());
            });
        }
        println!(
            "{size:?}: {:.2} and {:.2} ms a step, {:.1} times",
            1e3 * times[0],
            1e3 * times[1],
            times[1] / times[0]
        );
    }
    group.finish();
}

criterion_group!(benches, friction);
criterion_main!(benches);
