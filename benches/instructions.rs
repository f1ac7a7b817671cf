//! Instructions that the steps of fixed workloads execute, counted by Valgrind's callgrind, whatever the load of the
//! machine. Set-ups are not counted; vectors are those of the emulated processor. A second call shows the change since
//! the first.
//!
//! `cargo bench --features count-instructions --bench instructions`, with Valgrind and the program gungraun-runner of
//! the same version as gungraun in Cargo.lock (`cargo install gungraun-runner --version 0.17.2`).
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a benchmark may panic, in its helpers, too")]

use std::sync::atomic::AtomicBool;

use gungraun::{LibraryBenchmarkConfig, library_benchmark, library_benchmark_group, main};
use tyrewave::internals::Workload;
use tyrewave::plan::Plan;
use tyrewave::run::{Results, Simulation};

/// A run before its first step, on this thread alone: others would not be counted.
fn begun(workload: Workload) -> Simulation {
    rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global().expect("the first pool");
    let loaded = workload.scene().expect("a scene").expect("a workload that rolls");
    let plan = Plan::of(&loaded).expect("a plan");
    Simulation::begin(&loaded, &plan, &AtomicBool::new(false)).expect("a run")
}

#[library_benchmark(setup = begun)]
#[bench::smooth(Workload::Smooth)]
#[bench::rough(Workload::Rough)]
#[bench::high_speed(Workload::HighSpeed)]
#[bench::half_space_slices(Workload::HalfSpaceSlices)]
#[bench::direct_history(Workload::DirectHistory)]
#[bench::cells(Workload::Cells)]
#[bench::sound(Workload::Sound)]
fn steps(mut run: Simulation) -> Results {
    while run.step().expect("a step").is_some() {}
    run.finish()
}

library_benchmark_group!(
    name = workloads;
    benchmarks = steps
);
main!(
    // The cache of influence functions, without which every set-up fits the tyre.
    config = LibraryBenchmarkConfig::default().pass_through_envs(["HOME", "XDG_CACHE_HOME", "TYREWAVE_CACHE_DIR"]);
    library_benchmark_groups = workloads
);
