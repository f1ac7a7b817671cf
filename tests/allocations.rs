//! No step of the contact allocates: counted, on all threads.
//!
//! One test only in this file: whatever else ran beside it would be counted, too.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a failing test may panic, in its helpers, too")]

use std::alloc::System;
use std::sync::atomic::AtomicBool;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};
use tyrewave::counters::{Job, Meter, Unwatched, Watch};
use tyrewave::internals::{RoadStrip, VibrationObserver, prepare, scene, scene_text};
use tyrewave::road::StiffnessCurve;
use tyrewave::{Observer, Plan, Step};

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// Steps whose allocations are counted.
const COUNTED: u64 = 600;
/// Steps before.
const BEFORE: u64 = 100;

/// Rolls over rough slices made beforehand; returns allocations and reallocations of the counted steps, and the
/// factorisations and cache hits among them.
fn count(history: &str, tread: &str, rule: &str, elements: usize, cached: usize, outputs: &str) -> (usize, u64, u64) {
    let (tread, coupling) = tread.split_once(' ').unwrap_or((tread, "explicit"));
    let rolling = "speed_kmh = 80.0\nwarm_up = 0.0\nduration = 0.4\naxle = { indentation = 0.014, ramp = 0.01 }";
    let numerics = format!("history = \"{history}\"\nmemory = 0.02\ntime_rule = \"{rule}\"\ncached_factors = {cached}");
    let contact = format!("[contact]\ntread = \"{tread}\"\nslice_coupling = \"{coupling}\"\n{outputs}");
    let loaded = scene(&scene_text(elements, "kind = \"made\"", rolling, &numerics, &contact));
    let plan = Plan::new(&loaded.scene);
    let (stop, mut progress) = (AtomicBool::new(false), Unwatched);
    let mut job = Job::new(&stop, &mut progress);
    let mut prepared = prepare(&loaded, &plan, &mut job).unwrap();
    let mut vibration = VibrationObserver::begin(&mut prepared.begin(&loaded, &plan, true), &mut job).unwrap();
    let march = &mut prepared.march;
    let mut random = ChaCha8Rng::seed_from_u64(8);
    let first = march.geometry().first_element(0);
    let mut slices = RoadStrip::starting_at(first);
    slices.extend((0..BEFORE + COUNTED + march.geometry().columns as u64).map(|number| {
        let peak = random.random_range(-6e-3..0.0);
        if coupling == "explicit" || number % 5 == 0 {
            return StiffnessCurve::flat(peak);
        }
        let stones = (0..20).map(|stone| (1e-4 * f64::from(stone), 0.05));
        StiffnessCurve::from_events(peak, stones)
    }));
    for _ in 0..BEFORE {
        march.step(&prepared.axle, &slices, &mut Meter::default()).unwrap();
    }
    // The clocks of a closely watched run allocate nothing either.
    let mut meter = Meter::new(Watch::EVERY);
    let begun = march.next_step();
    let before = march.search_counts().factors;
    let region = Region::new(ALLOCATOR);
    for step in begun..begun + COUNTED {
        meter.begin_step(step);
        let done = march.step(&prepared.axle, &slices, &mut meter).unwrap();
        if let Some(vibration) = &mut vibration {
            let step = Step {
                number: step,
                time: step as f64 * plan.time_step,
                counts: true,
                indentation: prepared.axle.indentation(step),
                total_force: done.total_force,
                power: Some(1.0),
                power_of_waves: Some(1.0),
                contact_length: done.extent as f64 * plan.element,
                point_size: [plan.element, 0.1],
                footprint: march.footprint(),
                geometry: march.geometry(),
            };
            vibration.observe(&step, &mut meter).unwrap();
        }
    }
    let change = region.change();
    let after = march.search_counts().factors;
    (change.allocations + change.reallocations, after.factorisations - before.factorisations, after.hits - before.hits)
}

#[test]
fn no_step_allocates_whether_its_factor_is_found_or_made() {
    // The counter counts.
    let region = Region::new(ALLOCATOR);
    drop(std::hint::black_box(Box::new(1)));
    assert_eq!(region.change().allocations, 1);

    let cases = [
        ("direct", "elastic", "bdf2", 256, 4096),
        ("modal", "elastic", "bdf2", 256, 4096),
        ("modal", "elastic", "bdf2", 256, 3),
        ("modal", "elastic", "sdirk2", 256, 4096),
        ("direct", "bedding", "bdf1", 256, 64),
        ("direct", "uncoupled", "bdf1", 256, 64),
        ("modal", "elastic local", "bdf2", 256, 64),
        // With two threads the poles are gone through on the other.
        ("modal", "elastic", "bdf2", 512, 4096),
    ];
    // Segments of one revolution: some are completed among the counted steps.
    let vibration = "[outputs.vibration]\nsegment = 0.05\npoints = [0.1]\nelements = [5]\n";
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let with_vibration = cases.iter().filter(|case| case.0 == "modal").map(|&case| (case, vibration));
        for ((history, tread, rule, elements, cached), outputs) in
            cases.iter().map(|&case| (case, "")).chain(with_vibration)
        {
            let (allocations, made, found) = pool.install(|| count(history, tread, rule, elements, cached, outputs));
            println!(
                "{history}, {tread}, {rule}, N = {elements}, {cached} factors, {threads} threads: {allocations} \
                 allocations, {made} factors made, {found} found"
            );
            assert_eq!(allocations, 0, "{history}, {tread}, {rule}, {threads} threads");
            assert!(tread == "uncoupled" || made > 10, "{made} factors made");
            assert!(
                tread == "uncoupled" || tread.ends_with("local") || cached < 10 || found > 20,
                "{found} factors found"
            );
        }
    }
}
