//! Allocations of stages, counted by the program's allocator; and that watching asks for nothing itself.
//!
//! One test only in this file: whatever else ran beside it would be counted, too.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a failing test may panic, in its helpers, too")]

use std::alloc::System;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};
use tyrewave::counters::{Allocations, Meter, Phase, Spent, Stage, Watch};
use tyrewave::internals::{scene, scene_text};
use tyrewave::{Plan, Simulation};

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

fn probe() -> Allocations {
    let stats = ALLOCATOR.stats();
    Allocations { count: (stats.allocations + stats.reallocations) as u64, bytes: stats.bytes_allocated as u64 }
}

#[test]
fn stages_count_allocations_and_a_trace_of_steps_has_none() {
    let rolling = "speed_kmh = 80.0\nwarm_up = 0.05\nduration = 0.1\naxle = { load = 3400 }";
    let text = scene_text(64, "kind = \"made\"", rolling, "history = \"modal\"\npole_tolerance = 1e-3", "");
    let loaded = scene(&text);
    let plan = Plan::of(&loaded).unwrap();
    let watch = Watch { allocations: Some(probe), ..Watch::CLOSELY };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let region = Region::new(ALLOCATOR);
    let meter = pool.install(|| {
        let run = Simulation::begin_watched(&loaded, &plan, &AtomicBool::new(false), watch);
        let mut run = run.unwrap();
        while run.step().unwrap().is_some() {}
        run.finish().meter
    });
    let all = region.change();
    let of = |stage| meter.cost(stage).allocations;
    for stage in [Stage::Influence, Stage::Axle, Stage::Road] {
        let allocations = of(stage).unwrap();
        assert!(allocations.count > 0 && allocations.bytes > 8 * allocations.count, "{stage:?}: {allocations:?}");
    }
    let (mut count, mut bytes) = (0, 0);
    for stage in Stage::ALL {
        if let Some(allocations) = of(stage) {
            (count, bytes) = (count + allocations.count, bytes + allocations.bytes);
        }
    }
    assert!(count <= (all.allocations + all.reallocations) as u64 && bytes <= all.bytes_allocated as u64);
    for stage in [Stage::History, Stage::Transforms, Stage::Penetration, Stage::ActiveSet, Stage::Factorisation] {
        assert_eq!(of(stage), None, "{stage:?}");
    }

    let mut meter = Meter::new(Watch { trace: true, ..Watch::EVERY });
    meter.trace_mut().unwrap().expect_steps(0, 100_000);
    meter.enter(Phase::Contact);
    let region = Region::new(ALLOCATOR);
    for step in 0..100_000 {
        meter.begin_step(step);
        let spent = Spent { wall: Duration::from_nanos(10), ..Spent::default() };
        Stage::OF_A_STEP.into_iter().for_each(|stage| meter.add_in_steps(stage, spent));
        meter.end_step(step + 1);
    }
    let change = region.change();
    assert_eq!((change.allocations, change.reallocations), (0, 0));
    assert!(meter.trace().unwrap().span_count() > 5000 && meter.trace().unwrap().dropped() == 0);
}
