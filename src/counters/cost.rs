//! The cost of a stage of a run.

use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::amounts::amounts;
use super::clock::Spent;

amounts! {
    /// Arithmetic and memory traffic of a stage, as its algorithm needs them: exact, whatever the compiler and the
    /// caches make of it.
    pub struct Work {
        /// Multiply-adds, two flops each.
        pub multiply_adds: u64,
        /// Bytes of tables and states read and written.
        pub bytes: u64,
    }
}

impl std::ops::Mul<u64> for Work {
    type Output = Self;

    fn mul(self, times: u64) -> Self {
        Self { multiply_adds: times * self.multiply_adds, bytes: times * self.bytes }
    }
}

amounts! {
    /// Memory allocated so far, or within a stage.
    pub struct Allocations {
        /// Allocations and reallocations.
        pub count: u64,
        /// Bytes of all allocations.
        pub bytes: u64,
    }
}

/// Reads what the process has allocated so far, on all threads: only the program knows its allocator.
pub(crate) type AllocationProbe = fn() -> Allocations;

/// Calls and time of one stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub struct StageCost {
    /// How often the stage was entered.
    pub calls: u64,
    /// Wall time in the stage; no two stages are charged at once. Processor time is that of all threads outside of the
    /// steps, of the run's thread within them.
    pub spent: Spent,
    /// Part of the watched time over which processor time is that of all threads.
    pub watched_all: Duration,
    /// Time for which the stage worked in the background while the run was in others.
    pub background: Duration,
    /// Arithmetic and memory traffic, where they are counted.
    pub work: Work,
    /// Memory that the whole process allocated meanwhile; only if the allocator counts, and outside of the steps.
    pub allocations: Option<Allocations>,
    /// Largest resident memory of the process so far when the stage ended \[bytes\]; `None` within the steps and
    /// without a watch.
    pub peak_memory: Option<u64>,
}

impl StageCost {
    /// Time on the run's thread plus time in the background \[s\].
    pub fn seconds(&self) -> f64 {
        (self.spent.wall + self.background).as_secs_f64()
    }

    /// Share of the time of so many threads in which they were idle: 1 - cpu/(threads x wall), not below 0. `None` for
    /// stages within the steps, where the processor time of all threads is not read.
    pub fn idle_share(&self, threads: usize) -> Option<f64> {
        let wall = self.spent.wall.as_secs_f64();
        let all = self.watched_all == self.spent.watched && wall > 0.0;
        self.spent.cpu_seconds().filter(|_| all).map(|cpu| idle_share(cpu, wall, threads))
    }

    /// An amount per second of [`Self::seconds`]; `None` for no amount or no time.
    pub fn rate(&self, amount: u64) -> Option<f64> {
        let seconds = self.seconds();
        (amount > 0 && seconds > 0.0).then(|| amount as f64 / seconds)
    }

    /// Adds the cost of the same stage in another part of the run; the peak memory becomes the larger one.
    pub(super) fn add(&mut self, other: &Self) {
        self.calls += other.calls;
        self.spent += other.spent;
        self.watched_all += other.watched_all;
        self.background += other.background;
        self.work += other.work;
        if let Some(allocations) = other.allocations {
            *self.allocations.get_or_insert_default() += allocations;
        }
        self.peak_memory = self.peak_memory.max(other.peak_memory);
    }
}

/// Share of the time of so many threads that was not processor time, not below 0: 1 - cpu/(threads x wall), times in s.
pub(crate) fn idle_share(cpu: f64, wall: f64, threads: usize) -> f64 {
    (1.0 - cpu / (threads as f64 * wall)).max(0.0)
}
