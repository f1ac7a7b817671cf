//! What a plan will take on this machine: work times unit costs, and how threads share it.

use serde::Serialize;

use crate::counters::Stage;
use crate::plan::amounts::{Amounts, Place};
use crate::plan::unit::UnitCosts;

/// Share of the ideal that threads reach on work before the steps.
const EFFICIENCY: f64 = 0.95;

/// Time and memory expected.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Forecast {
    /// Stages with work, in the order of the data's way, with the time of all cores in each \[s\], and whether it is
    /// beside the steps.
    pub stages: Vec<StageForecast>,
    /// Time in no stage \[s\].
    pub rest_seconds: f64,
    /// Wall time \[s\].
    pub wall_seconds: f64,
    /// Largest resident memory, the process itself included \[bytes\].
    pub memory: f64,
    /// Threads.
    pub threads: usize,
    /// Whether unit costs were measured on this machine.
    pub measured: bool,
}

/// Time expected in a stage.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StageForecast {
    /// The stage.
    pub stage: Stage,
    /// Time of all cores in it \[s\].
    pub seconds: f64,
    /// Whether other threads do it while the run marches on.
    pub background: bool,
}

impl Forecast {
    /// For amounts of work over so many steps. `process`: what the process itself holds \[bytes\].
    pub fn new(amounts: &Amounts, steps: u64, costs: &UnitCosts, threads: usize, process: f64) -> Self {
        let many = threads > 1;
        let mut stages: Vec<StageForecast> = Vec::new();
        let (mut before, mut march, mut march_on_all, mut behind) = (0.0, 0.0, 0.0, 0.0);
        for amount in &amounts.work {
            let seconds = amount.amount * costs.of(amount.stage, amount.unit);
            match amount.place {
                Place::Before => before += seconds,
                Place::BeforeOnAll => before += seconds / (1.0 + EFFICIENCY * (threads as f64 - 1.0)),
                Place::March => march += seconds,
                Place::MarchOnAll => march_on_all += seconds,
                Place::Behind => behind += seconds,
            }
            let background = many && amount.place == Place::Behind;
            match stages.iter_mut().find(|known| known.stage == amount.stage && known.background == background) {
                Some(known) => known.seconds += seconds,
                None => stages.push(StageForecast { stage: amount.stage, seconds, background }),
            }
        }
        stages.sort_by_key(|entry| entry.stage as usize);
        let rest_seconds = steps as f64 * costs.step;
        march += rest_seconds;
        let all = march + march_on_all + behind;
        // One thread marches; what is behind it, or shared, fills the others.
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
    pub fn core_seconds(&self) -> f64 {
        self.rest_seconds + self.stages.iter().map(|stage| stage.seconds).sum::<f64>()
    }
}
