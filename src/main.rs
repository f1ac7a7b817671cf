//! The `tyrewave` program.
//!
//! Its allocator is mimalloc. With the feature `count-allocations` it is the system's, counted: every allocation then
//! costs atomic additions that all threads share, which an ordinary run must not pay for (and on stable Rust
//! `stats_alloc` cannot wrap another allocator in a constant).

use std::process::ExitCode;

use tyrewave::counters::Allocations;

#[cfg(not(feature = "count-allocations"))]
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

#[cfg(feature = "count-allocations")]
#[global_allocator]
static ALLOCATOR: &stats_alloc::StatsAlloc<std::alloc::System> = &stats_alloc::INSTRUMENTED_SYSTEM;

#[cfg(not(feature = "count-allocations"))]
const PROBE: Option<fn() -> Allocations> = None;

#[cfg(feature = "count-allocations")]
const PROBE: Option<fn() -> Allocations> = Some(|| {
    let stats = ALLOCATOR.stats();
    Allocations { count: (stats.allocations + stats.reallocations) as u64, bytes: stats.bytes_allocated as u64 }
});

fn main() -> ExitCode {
    tyrewave::command_line(PROBE)
}
