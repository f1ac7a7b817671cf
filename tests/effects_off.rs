//! An effect that is off costs nothing: work counters and allocations of a run are those of the scene that does not
//! name it.
//!
//! One test only in this file: whatever else ran beside it would be counted, too.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a failing test may panic, in its helpers, too")]

use std::alloc::System;
use std::sync::atomic::AtomicBool;

use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};
use tyrewave::counters::{Counter, Stage, Work};
use tyrewave::internals::{RunCost, add, cost_table, scene, scene_text};
use tyrewave::{Plan, Simulation};

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// All that a run counts.
#[derive(Debug, PartialEq)]
struct Count {
    counters: Vec<(Counter, u64)>,
    work: Vec<Work>,
    calls: Vec<u64>,
    allocations: usize,
    bytes: usize,
    /// Stages and counters with a line in the profile.
    lines: usize,
}

fn text(road: &str, more: &str) -> String {
    let rolling = "speed_kmh = 80.0\nwarm_up = 0.05\nduration = 0.1\naxle = { load = 3400 }";
    scene_text(64, road, rolling, "history = \"modal\"\npole_tolerance = 1e-3", more)
}

fn count(text: &str) -> Count {
    let loaded = scene(text);
    // The plan says in words what is off, and a run keeps a copy of them; what follows does not know of it.
    let plan = Plan::new(&loaded.scene);
    let region = Region::new(ALLOCATOR);
    drop(plan.clone());
    let words = region.change().bytes_allocated;
    let region = Region::new(ALLOCATOR);
    let mut run = Simulation::begin(&loaded, &plan, &AtomicBool::new(false)).unwrap();
    while run.step().unwrap().is_some() {}
    let results = run.finish();
    let change = region.change();
    let meter = &results.meter;
    Count {
        counters: Counter::ALL.iter().map(|&counter| (counter, meter.counted(counter))).collect(),
        work: Stage::ALL.iter().map(|&stage| meter.cost(stage).work).collect(),
        calls: Stage::ALL.iter().map(|&stage| meter.cost(stage).calls).collect(),
        allocations: change.allocations + change.reallocations,
        bytes: change.bytes_allocated - words,
        lines: cost_table(&RunCost::new(meter, 1.0, 1)).to_string().lines().count(),
    }
}

const SMOOTH: &str = "kind = \"smooth\"";
const MADE: &str = "kind = \"made\"\nseed = 3";

#[test]
fn an_effect_that_is_off_costs_nothing() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let count_text = |text: &str| {
        // The first time a model is fitted, a cache of this test may be written.
        pool.install(|| count(text));
        pool.install(|| count(text))
    };
    let count = |road, more: &str| count_text(&text(road, more));
    // Scene, effect off, effect on (where the scene can have it): off is nothing, and on is something.
    let cases = [
        (SMOOTH, "[effects]\ntexture = \"off\"", None),
        (SMOOTH, "[effects]\ntexture = \"auto\"", None),
        (MADE, "[effects]\nrotation = \"off\"", None),
        (MADE, "[effects]\nradiation = \"off\"", None),
        (MADE, "[effects]\nfriction = \"off\"", None),
        (MADE, "[contact]\nslice_coupling = \"local\"", Some("[contact]\nslice_coupling = \"explicit\"")),
        (MADE, "[effects]\ntread_vibration = \"off\"", None),
        (MADE, "[effects]\nbelt_vibration = \"off\"", None),
        (MADE, "[effects]\ntangential_motion = \"off\"", None),
    ];
    let [smooth, rough] = [SMOOTH, MADE].map(|road| count(road, ""));
    for (road, off, on) in cases {
        let without = if road == SMOOTH { &smooth } else { &rough };
        assert_eq!(*without, count(road, off), "{off}");
        if let Some(on) = on {
            assert_ne!(count(road, on).work, without.work, "{on} makes no difference: the comparison says nothing");
        }
    }
    // Without texture across, a rough road is as cheap as one column of it: no slice law, fewer allocations.
    let level = count(MADE, "[effects]\ntexture = \"off\"");
    assert!(level.bytes < rough.bytes, "{} bytes, {} with texture", level.bytes, rough.bytes);
    // A curved tyre that is held has no odd parts: fewer products of its past, less memory.
    let [held, turning] = ["off", "auto"].map(|switch| {
        let text = text(MADE, &format!("[effects]\nrotation = \"{switch}\""));
        count_text(&add(&text, "tyre", "curvature = true"))
    });
    let history = |count: &Count| count.work[Stage::History as usize].multiply_adds;
    assert!(history(&held) < history(&turning) && held.bytes < turning.bytes, "{held:?}\n{turning:?}");
    // A smooth road has no slices' work; its profile has fewer lines than that of the same search on a rough one.
    assert!(smooth.lines <= count(MADE, "[contact]\nslice_coupling = \"explicit\"").lines);
}
