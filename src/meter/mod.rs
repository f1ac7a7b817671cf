//! What a run costs: wall time and calls per stage, exact work counters.
//!
//! Stages are timed, kernels are counted. Counters are exact and independent of the machine and of the number of threads;
//! times are neither.

pub mod machine;
pub mod process;
pub mod thread_time;

use std::time::{Duration, Instant};

use serde::Serialize;

/// A stage of the pipeline, in the order of the data's way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// Surface compliance summed to influence functions; convolution weights.
    Influence,
    /// Reading or making the road and resampling it.
    Road,
    /// Stiffness curves of the road slices.
    Slices,
    /// Waiting for road that is being made in the background.
    RoadWait,
    /// Static solution and axle height.
    Axle,
    /// Displacement left over from past forces, without its transforms.
    History,
    /// Transforms of forces and displacements between elements and wavenumbers.
    Transforms,
    /// Displacement that the road slices ask for.
    Penetration,
    /// Active-set search, its factorisations included.
    ActiveSet,
    /// Spectra of the vibration from the patch forces.
    Vibration,
    /// Writing arrays.
    Output,
    /// Spectra and plots.
    Response,
}

impl Stage {
    /// All stages in order.
    pub const ALL: [Self; 12] = [
        Self::Influence,
        Self::Road,
        Self::Slices,
        Self::RoadWait,
        Self::Axle,
        Self::History,
        Self::Transforms,
        Self::Penetration,
        Self::ActiveSet,
        Self::Vibration,
        Self::Output,
        Self::Response,
    ];

    /// The stages that every time step goes through, in order.
    pub const OF_A_STEP: [Self; 8] = [
        Self::Road,
        Self::Slices,
        Self::History,
        Self::Transforms,
        Self::Penetration,
        Self::ActiveSet,
        Self::Vibration,
        Self::Output,
    ];

    /// The stage named as people read it in a table.
    pub const fn title(self) -> &'static str {
        match self {
            Self::Influence => "sum influence functions",
            Self::Road => "make or read the road",
            Self::Slices => "build slice stiffness curves",
            Self::RoadWait => "wait for the road",
            Self::Axle => "find the axle height",
            Self::History => "convolve the force history",
            Self::Transforms => "transform the force history",
            Self::Penetration => "press into the road slices",
            Self::ActiveSet => "search the active set",
            Self::Vibration => "transform to vibration",
            Self::Output => "write arrays",
            Self::Response => "compute spectra and plots",
        }
    }
}

/// An exact work counter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Counter {
    /// Evaluations of the layered compliance at one wavenumber and one s.
    ComplianceEvaluations,
    /// Poles of the rational models, conjugates counted.
    Poles,
    /// Multiply-adds of the history.
    HistoryMultiplyAdds,
    /// Road slices made.
    Slices,
    /// Time steps.
    Steps,
    /// Active-set iterations (linear solves).
    Solves,
    /// Factorisations of an active-set matrix.
    Factorisations,
    /// Active sets whose factor was cached.
    CacheHits,
    /// Active sets whose factor was not cached.
    CacheMisses,
    /// Active sets solved with the factor of one that differs by few points.
    Neighbours,
    /// Factors dropped from the cache.
    CacheEvictions,
    /// Steps in which the least-index fallback took over.
    Fallbacks,
    /// Steps in which an outermost candidate of the window carried force.
    WindowEdgeContacts,
    /// Transforms of the vibration, over time and over the elements.
    VibrationTransforms,
    /// Velocities for unit force evaluated, by wavenumber and frequency.
    VibrationEvaluations,
    /// Bytes written to result arrays.
    BytesWritten,
}

impl Counter {
    /// All counters in order.
    pub const ALL: [Self; 16] = [
        Self::ComplianceEvaluations,
        Self::Poles,
        Self::HistoryMultiplyAdds,
        Self::Slices,
        Self::Steps,
        Self::Solves,
        Self::Factorisations,
        Self::CacheHits,
        Self::CacheMisses,
        Self::Neighbours,
        Self::CacheEvictions,
        Self::Fallbacks,
        Self::WindowEdgeContacts,
        Self::VibrationTransforms,
        Self::VibrationEvaluations,
        Self::BytesWritten,
    ];
}

impl Counter {
    /// Whether none of it is worth telling.
    pub const fn counts_trouble(self) -> bool {
        matches!(self, Self::Fallbacks | Self::WindowEdgeContacts)
    }
}

/// Arithmetic and memory traffic of a stage, as its algorithm needs them: exact, whatever the compiler and the caches make of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Multiply-adds, two flops each.
    pub multiply_adds: u64,
    /// Bytes of tables and states read and written.
    pub bytes: u64,
}

impl std::ops::AddAssign for Work {
    fn add_assign(&mut self, other: Self) {
        self.multiply_adds += other.multiply_adds;
        self.bytes += other.bytes;
    }
}

/// Calls and time of one stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StageCost {
    /// How often the stage was entered.
    pub calls: u64,
    /// Time that the run spent in it: no two stages at once.
    pub wall: Duration,
    /// Time that the stage was at work in the background while the run was in others.
    pub background: Duration,
    /// Arithmetic and memory traffic, where they are counted.
    pub work: Work,
}

/// Stage times and counters of one run. Fixed size: metering never allocates.
#[derive(Clone, Debug, Default)]
pub struct Meter {
    costs: [StageCost; Stage::ALL.len()],
    counts: [u64; Counter::ALL.len()],
}

impl Meter {
    /// Runs `work` as (part of) a stage.
    pub fn time<T>(&mut self, stage: Stage, work: impl FnOnce() -> T) -> T {
        let begin = Instant::now();
        let result = work();
        self.add_time(stage, begin.elapsed());
        result
    }

    /// Adds one call of a stage that was timed elsewhere.
    pub fn add_time(&mut self, stage: Stage, wall: Duration) {
        let cost = &mut self.costs[stage as usize];
        cost.calls += 1;
        cost.wall += wall;
    }

    /// Adds one call of a stage that was at work in the background.
    pub fn add_background(&mut self, stage: Stage, busy: Duration) {
        let cost = &mut self.costs[stage as usize];
        cost.calls += 1;
        cost.background += busy;
    }

    /// Adds what a stage has computed and moved.
    pub fn add_work(&mut self, stage: Stage, work: Work) {
        self.costs[stage as usize].work += work;
    }

    /// Adds to a counter.
    pub fn count(&mut self, counter: Counter, amount: u64) {
        self.counts[counter as usize] += amount;
    }

    /// Adds what a stage has cost in an earlier part of the same run.
    pub fn add_cost(&mut self, stage: Stage, earlier: StageCost) {
        let cost = &mut self.costs[stage as usize];
        cost.calls += earlier.calls;
        cost.wall += earlier.wall;
        cost.background += earlier.background;
        cost.work += earlier.work;
    }

    /// Sets a counter to what it was when an earlier part of the same run ended.
    pub fn set_count(&mut self, counter: Counter, amount: u64) {
        self.counts[counter as usize] = amount;
    }

    /// What a stage has cost so far.
    pub fn cost(&self, stage: Stage) -> StageCost {
        self.costs[stage as usize]
    }

    /// The value of a counter.
    pub fn counted(&self, counter: Counter) -> u64 {
        self.counts[counter as usize]
    }
}
