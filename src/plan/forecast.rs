//! Forecast of a plan on this machine: work times unit costs, distributed over threads.

use serde::Serialize;

use crate::counters::Stage;
use crate::counters::process::resident_memory;
use crate::plan::amounts::{Amounts, WorkPlace};
use crate::plan::unit::UnitCosts;
use crate::plan::{Plan, bytes};
use crate::scene::{History, LoadedScene, SceneError, Zone};

/// Most bytes that a process holds beyond the plan of its run: code that was used, pictures and the page of the
/// results, and what the allocator keeps (measured over twenty scenes, 13 to 58 MB).
const PROGRAM: f64 = 6.6e7;
/// Parallel efficiency of work before the steps.
const EFFICIENCY: f64 = 0.95;

/// Expected time and memory.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Forecast {
    /// Stages with work, in the order of the computation; one entry each for work in and beside the steps.
    pub stages: Vec<StageForecast>,
    /// Time outside all stages \[s\].
    pub rest_seconds: f64,
    /// Expected wall time \[s\].
    pub wall_seconds: f64,
    /// Largest resident memory, the process itself included \[bytes\].
    pub memory: f64,
    /// Number of threads.
    pub threads: usize,
    /// True if unit costs were measured on this machine.
    pub measured: bool,
}

/// Expected time of a stage.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct StageForecast {
    /// The stage.
    pub stage: Stage,
    /// Time of all cores in the stage \[s\].
    pub seconds: f64,
    /// True if other threads do it beside the steps.
    pub background: bool,
}

/// Largest memory of this process at the end of a run, without that of the run's plan \[bytes\]; to be called before
/// the plan is made.
pub(crate) fn process_memory() -> f64 {
    resident_memory().unwrap_or_default() as f64 + PROGRAM
}

impl Plan {
    /// Refuses a plan that needs more memory or time than the scene allows, and what cannot be simulated at all.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] with a complaint that points into the scene.
    pub(crate) fn check_amounts(&self, loaded: &LoadedScene, amounts: &Amounts) -> Result<(), SceneError> {
        let numerics = &self.scene.numerics;
        let memory = amounts.memory_on(1);
        let forecast = Forecast::new(amounts, self.steps, &UnitCosts::default(), 1, 0.0);
        let hours = forecast.core_seconds() / 3600.0;
        let (rule, has_cells) = (numerics.time_rule, self.decisions.zone == Zone::Cells);
        let complaint = if numerics.history == History::Direct && !rule.is_multistep() && !has_cells {
            let wrong = format!(
                "\"{}\" couples the stages of a step: its weights are matrices, which the direct sum does not keep",
                rule.name()
            );
            loaded.complain("numerics.time_rule", wrong, "history = \"modal\", or a multistep rule such as \"bdf2\"")
        } else if memory / 1e9 > numerics.memory_limit && amounts.segments_at_once > 0 {
            loaded.complain(
                "outputs.levels.segments",
                format!(
                    "a run with {} segments at once needs about {} of memory, more than numerics.memory_limit = {} GB",
                    amounts.segments_at_once,
                    bytes(memory),
                    numerics.memory_limit
                ),
                "fewer segments or threads, or a larger memory_limit",
            )
        } else if memory / 1e9 > numerics.memory_limit {
            // Without a given size or a preset, cells are as wide as elements are long.
            let (key, fewer) = [("contact.cells_across", "fewer cells across"), ("contact.cell", "larger cells")]
                .into_iter()
                .find(|(key, _)| has_cells && loaded.gives(key))
                .unwrap_or(("numerics.elements", "fewer elements"));
            loaded.complain(
                key,
                format!(
                    "{} elements, {} lags and {} steps need about {} of memory, more than numerics.memory_limit = {} \
                     GB",
                    numerics.elements,
                    self.lags,
                    self.steps,
                    bytes(memory),
                    numerics.memory_limit
                ),
                format!("{fewer}, a shorter memory, or a larger memory_limit"),
            )
        } else if hours > numerics.time_limit {
            let longest = forecast.stages.iter().max_by(|a, b| a.seconds.total_cmp(&b.seconds));
            let most = longest.map(|stage| format!(" (to {}: {:.1e})", stage.stage.title(), stage.seconds / 3600.0));
            let fit = longest.is_some_and(|stage| stage.stage == Stage::Fit);
            loaded.complain(
                "numerics.elements",
                format!(
                    "{} elements and {} steps need about {hours:.1e} core hours{}, more than numerics.time_limit = {} \
                     h",
                    numerics.elements,
                    self.steps,
                    most.unwrap_or_default(),
                    numerics.time_limit
                ),
                if fit {
                    "fewer elements, a larger pole_tolerance, or a larger time_limit"
                } else {
                    "fewer elements, a shorter run, or a larger time_limit"
                },
            )
        } else {
            return Ok(());
        };
        Err(complaint.into())
    }
}

impl Forecast {
    /// Forecast for amounts of work over `steps` steps; `process` is the memory of the process itself \[bytes\].
    pub(crate) fn new(amounts: &Amounts, steps: u64, costs: &UnitCosts, threads: usize, process: f64) -> Self {
        let many = threads > 1;
        // 1. Sum the work by place in the run, and by stage.
        let mut stages: Vec<StageForecast> = Vec::new();
        let (mut before, mut march, mut march_on_all, mut background_seconds) = (0.0, 0.0, 0.0, 0.0);
        for amount in &amounts.work {
            let seconds = amount.amount * costs.of(amount.stage, amount.unit);
            match amount.place {
                WorkPlace::Before => before += seconds,
                WorkPlace::BeforeOnAll => before += seconds / (1.0 + EFFICIENCY * (threads as f64 - 1.0)),
                WorkPlace::March => march += seconds,
                WorkPlace::MarchOnAll => march_on_all += seconds,
                WorkPlace::Background => background_seconds += seconds,
            }
            let background = many && amount.place == WorkPlace::Background;
            match stages.iter_mut().find(|known| known.stage == amount.stage && known.background == background) {
                Some(known) => known.seconds += seconds,
                None => stages.push(StageForecast { stage: amount.stage, seconds, background }),
            }
        }
        stages.sort_by_key(|entry| entry.stage as usize);
        let rest_seconds = steps as f64 * costs.step;
        march += rest_seconds;
        let all = march + march_on_all + background_seconds;
        // 2. One thread marches; work in the background or shared fills the others.
        let rolling = if many { (march + march_on_all / threads as f64).max(all / threads as f64) } else { all };
        Self {
            stages,
            rest_seconds,
            wall_seconds: before + rolling,
            memory: process + amounts.memory_on(threads),
            threads,
            measured: costs.measured,
        }
    }

    /// Time of all cores \[s\].
    pub(crate) fn core_seconds(&self) -> f64 {
        self.rest_seconds + self.stages.iter().map(|stage| stage.seconds).sum::<f64>()
    }
}
