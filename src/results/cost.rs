//! Cost of a run, as in `summary.json`.

use std::collections::BTreeMap;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use crate::counters::process::peak_memory;
use crate::counters::{Counter, MachinePeak, Meter, Stage, StageCost, idle_share};

/// Stage times, counters and rates. Numbers that were not measured are `null`.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct RunCost {
    /// Wall time of the whole run \[s\].
    pub wall_seconds: f64,
    /// Processor time of all threads for the whole run \[s\].
    pub cpu_seconds: Option<f64>,
    /// Share of the threads' time without work.
    pub idle_share: Option<f64>,
    /// Number of threads.
    pub threads: usize,
    /// Largest resident memory of the process \[bytes\]; `null` where the system does not report it.
    pub peak_memory: Option<u64>,
    /// Cost expected before the run; `null` if it was not planned.
    pub(crate) planned: Option<Planned>,
    /// Share of the time steps that were timed, in blocks: the times of stages within the steps are extrapolated from
    /// these.
    pub share_of_steps_timed: f64,
    /// All steps together.
    pub(crate) steps: StepsRecord,
    /// Cost by stage, in the order of the data flow; background work is not part of the wall time.
    pub(crate) stages: BTreeMap<Stage, StageRecord>,
    /// Rates of what was counted.
    pub(crate) rates: CostRates,
    /// Best rates of one core of the machine, measured after a run with detailed timing.
    pub machine_peak: Option<MachinePeak>,
    /// Exact work counters; the same for any number of threads.
    pub counters: BTreeMap<Counter, u64>,
    /// True if processor time and memory were measured.
    #[serde(skip)]
    pub closely: bool,
}

/// Expected cost of a plan.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub(crate) struct Planned {
    /// Expected wall time \[s\].
    pub wall_seconds: f64,
    /// Largest memory \[bytes\].
    pub memory: f64,
    /// True if the unit costs behind it were measured on this machine.
    pub measured: bool,
}

/// Rates over a whole run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub(crate) struct CostRates {
    /// Time of one evaluation of the layered compliance \[ns\]: processor time of all threads in the stage over the
    /// number of evaluations, sums and everything around them included; wall time where no processor time was measured.
    pub compliance_evaluation_ns: Option<f64>,
    /// Time of a step \[us\], all stages of the steps together, without background work.
    pub step_us: Option<f64>,
}

/// Cost of all steps of a run together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub(crate) struct StepsRecord {
    /// Wall time \[s\].
    pub seconds: f64,
    /// Processor time of all threads \[s\].
    pub cpu_seconds: Option<f64>,
    /// Share of the threads' time without work.
    pub idle_share: Option<f64>,
}

/// Cost of a stage. Numbers that were not measured are `None`.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
pub(crate) struct StageRecord {
    /// Number of times that it was entered.
    pub calls: u64,
    /// Time that the run spent in it \[s\].
    pub seconds: f64,
    /// Time of its background work \[s\].
    pub background_seconds: f64,
    /// Processor time \[s\], see [`StageCost::spent`].
    pub cpu_seconds: Option<f64>,
    /// Share of the threads' time without work.
    pub idle_share: Option<f64>,
    /// Number of allocations and reallocations of the whole process during the stage.
    pub allocations: Option<u64>,
    /// Size of these \[bytes\].
    pub allocated_bytes: Option<u64>,
    /// Largest resident memory until its end \[bytes\].
    pub peak_memory: Option<u64>,
    /// Number of multiply-adds.
    pub multiply_adds: Option<u64>,
    /// Bytes of tables and states that are read and written.
    pub bytes: Option<u64>,
    /// Floating-point operations per second.
    pub flop_per_second: Option<f64>,
    /// Bytes per second.
    pub bytes_per_second: Option<f64>,
}

impl StageRecord {
    fn new(cost: StageCost, threads: usize) -> Self {
        let counted = |amount: u64| (amount > 0).then_some(amount);
        Self {
            calls: cost.calls,
            seconds: cost.spent.wall.as_secs_f64(),
            background_seconds: cost.background.as_secs_f64(),
            cpu_seconds: cost.spent.cpu_seconds(),
            idle_share: cost.idle_share(threads),
            allocations: cost.allocations.map(|allocations| allocations.count),
            allocated_bytes: cost.allocations.map(|allocations| allocations.bytes),
            peak_memory: cost.peak_memory,
            multiply_adds: counted(cost.work.multiply_adds),
            bytes: counted(cost.work.bytes),
            flop_per_second: cost.rate(2 * cost.work.multiply_adds),
            bytes_per_second: cost.rate(cost.work.bytes),
        }
    }
}

impl RunCost {
    /// From the times and counters of a meter.
    pub fn new(meter: &Meter, wall_seconds: f64, threads: usize) -> Self {
        let steps = meter.steps();
        let (seconds, cpu_seconds) = (steps.wall.as_secs_f64(), steps.cpu_seconds());
        let idle_share = cpu_seconds.map(|cpu| idle_share(cpu, seconds, threads));
        let per = |seconds: f64, counter: Counter| {
            let amount = meter.counted(counter) as f64;
            (amount > 0.0).then(|| seconds / amount)
        };
        let sums = meter.cost(Stage::Influence).spent;
        let sums = sums.cpu_seconds().unwrap_or(sums.wall.as_secs_f64());
        let staged: f64 = Stage::OF_A_STEP.iter().map(|&stage| meter.cost(stage).spent.wall.as_secs_f64()).sum();
        Self {
            wall_seconds,
            cpu_seconds: None,
            idle_share: None,
            threads,
            peak_memory: peak_memory(),
            planned: None,
            share_of_steps_timed: meter.timing().share_of_steps(),
            steps: StepsRecord { seconds, cpu_seconds, idle_share },
            stages: Stage::ALL.map(|stage| (stage, StageRecord::new(meter.cost(stage), threads))).into(),
            rates: CostRates {
                compliance_evaluation_ns: per(1e9 * sums, Counter::ComplianceEvaluations),
                step_us: per(1e6 * staged, Counter::Steps),
            },
            machine_peak: None,
            counters: Counter::ALL.map(|counter| (counter, meter.counted(counter))).into(),
            closely: meter.watches_closely(),
        }
    }

    pub(crate) fn stage(&self, stage: Stage) -> &StageRecord {
        &self.stages[&stage]
    }

    /// Value of a counter.
    pub fn counted(&self, counter: Counter) -> u64 {
        self.counters[&counter]
    }

    /// The same with the processor time of the whole run, and the idle share that follows from it.
    #[must_use]
    pub fn with_cpu(self, cpu: Option<Duration>) -> Self {
        let cpu_seconds = cpu.map(|cpu| cpu.as_secs_f64());
        let wall = Some(self.wall_seconds).filter(|wall| *wall > 0.0);
        let idle_share = cpu_seconds.zip(wall).map(|(cpu, wall)| idle_share(cpu, wall, self.threads));
        Self { cpu_seconds, idle_share, ..self }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;
    use crate::counters::{Allocations, Counters, Spent, StageCost, Work};

    #[test]
    fn what_was_measured_has_numbers_and_the_rest_is_null() {
        let mut meter = Meter::default();
        let seconds = Duration::from_secs;
        let spent = |wall| Spent { wall: seconds(wall), watched: seconds(1), cpu: seconds(1) };
        let work = Work { multiply_adds: 8_000_000_000, bytes: 6_000_000_000 };
        let mut earlier = Counters::default();
        let history = StageCost { spent: spent(4), watched_all: seconds(1), work, ..StageCost::default() };
        earlier.stages[Stage::History as usize] = history;
        // Within the steps the time of the other threads is not known.
        earlier.stages[Stage::ActiveSet as usize] = StageCost { spent: spent(4), ..StageCost::default() };
        let allocations = Some(Allocations { count: 7, bytes: 900 });
        let wall = Spent { wall: seconds(2), ..Spent::default() };
        earlier.stages[Stage::Influence as usize] =
            StageCost { calls: 1, spent: wall, allocations, peak_memory: Some(5), ..StageCost::default() };
        meter.resume(&earlier);
        meter.count(Counter::ComplianceEvaluations, 1_000_000);
        meter.count(Counter::Steps, 100_000);
        let cost = RunCost::new(&meter, 10.0, 2).with_cpu(Some(seconds(15)));
        let value: Value = serde_json::to_value(&cost).unwrap();
        let history = &value["stages"]["history"];
        assert_eq!((&history["cpu_seconds"], &history["idle_share"]), (&json!(4.0), &json!(0.5)));
        assert_eq!((&history["flop_per_second"], &history["bytes_per_second"]), (&json!(4e9), &json!(1.5e9)));
        assert_eq!((&history["allocations"], &history["peak_memory"]), (&Value::Null, &Value::Null));
        let search = &value["stages"]["active_set"];
        assert_eq!((&search["cpu_seconds"], &search["idle_share"]), (&json!(4.0), &Value::Null));
        let influence = &value["stages"]["influence"];
        assert_eq!((&influence["allocations"], &influence["allocated_bytes"]), (&json!(7), &json!(900)));
        assert_eq!((&influence["peak_memory"], &influence["cpu_seconds"]), (&json!(5), &Value::Null));
        assert_eq!(value["rates"], json!({ "compliance_evaluation_ns": 2000.0, "step_us": 80.0 }));
        assert_eq!((&value["cpu_seconds"], &value["idle_share"]), (&json!(15.0), &json!(0.25)));
        assert_eq!((&value["machine_peak"], &value["share_of_steps_timed"]), (&Value::Null, &json!(0.0625)));
    }
}
