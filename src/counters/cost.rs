//! Cost of a stage.

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
    /// Memory asked for so far, or within a stage.
    pub struct Allocations {
        /// Allocations and reallocations.
        pub count: u64,
        /// Bytes of all allocations.
        pub bytes: u64,
    }
}

/// Says what the process has asked for so far, on all threads: the program's allocator knows, the library does not.
pub(crate) type AllocationProbe = fn() -> Allocations;

/// Calls and time of one stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub struct StageCost {
    /// How often the stage was entered.
    pub calls: u64,
    /// Time that the run spent in it, no two stages at once; processor time is that of all threads outside of the
    /// steps, of the run's own thread within them.
    pub spent: Spent,
    /// The part of its watched time over which processor time is that of all threads.
    pub watched_all: Duration,
    /// Time that the stage was at work in the background while the run was in others.
    pub background: Duration,
    /// Arithmetic and memory traffic, where they are counted.
    pub work: Work,
    /// Memory asked for by the whole process meanwhile, where that is counted and the stage stands outside of the
    /// steps.
    pub allocations: Option<Allocations>,
    /// Largest resident memory of the process so far when the stage ended \[bytes\]; `None` within the steps and
    /// without a watch.
    pub peak_memory: Option<u64>,
}

impl StageCost {
    /// Returns the time on the run's own thread and in the background \[s\].
    pub fn seconds(&self) -> f64 {
        (self.spent.wall + self.background).as_secs_f64()
    }

    /// Returns the share of so many threads' time in which they had nothing to do: 1 - cpu/(threads x wall), not below
    /// 0. `None` for stages within the steps, too short for it.
    pub fn idle_share(&self, threads: usize) -> Option<f64> {
        let wall = self.spent.wall.as_secs_f64();
        let all = self.watched_all == self.spent.watched && wall > 0.0;
        self.spent.cpu_seconds().filter(|_| all).map(|cpu| idle_share(cpu, wall, threads))
    }

    /// Returns an amount per second; `None` without time.
    pub fn rate(&self, amount: u64) -> Option<f64> {
        let seconds = self.seconds();
        (amount > 0 && seconds > 0.0).then(|| amount as f64 / seconds)
    }

    /// Adds what the same stage has cost elsewhere.
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

/// Returns the share of the time of so many threads that was not processor time, not below 0: 1 - cpu/(threads x wall),
/// times in s.
pub(crate) fn idle_share(cpu: f64, wall: f64, threads: usize) -> f64 {
    (1.0 - cpu / (threads as f64 * wall)).max(0.0)
}
