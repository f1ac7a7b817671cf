//! What a run cost, as `summary.json` has it.

use std::time::Duration;

use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};

use crate::counters::process::peak_memory;
use crate::counters::{Counter, MachinePeak, Meter, Stage, idle_share};

/// Stage times, counters and rates. Numbers that were not measured are `null`.
#[derive(Clone, Debug, Serialize)]
pub struct Cost {
    /// Wall time of the whole run \[s\].
    pub wall_seconds: f64,
    /// Processor time of all threads for the whole run \[s\].
    pub cpu_seconds: Option<f64>,
    /// Share of the threads' time in which they had nothing to do.
    pub idle_share: Option<f64>,
    /// Threads it ran on.
    pub threads: usize,
    /// Largest resident memory of the process \[bytes\]; `null` where the system does not tell.
    pub peak_memory: Option<u64>,
    /// What was expected before the run; `null` for what is not planned.
    pub planned: Option<Planned>,
    /// Share of the time steps that were timed, in blocks: the times of stages within the steps are theirs, taken for
    /// all.
    pub share_of_steps_timed: f64,
    /// All steps together.
    pub steps: StepsRecord,
    /// Cost by stage, in the order of the data's way; what went on in the background is beside the wall time, not a
    /// part of it.
    pub stages: StageCosts,
    /// Rates of what was counted.
    pub rates: Rates,
    /// Best rates of one core of the machine, measured after a closely watched run.
    pub machine_peak: Option<MachinePeak>,
    /// Exact work counters; the same for any number of threads.
    #[serde(serialize_with = "counters")]
    pub counters: Meter,
}

/// What a plan expected of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Planned {
    /// Wall time \[s\].
    pub wall_seconds: f64,
    /// Largest memory \[bytes\].
    pub memory: f64,
    /// Whether the costs of units of work behind it were measured on this machine.
    pub measured: bool,
}

/// Rates over a whole run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Rates {
    /// Time of one evaluation of the layered compliance \[ns\]: processor time of all threads in the stage over
    /// evaluations, sums and all around them included; wall time where no processor time was measured.
    pub compliance_evaluation_ns: Option<f64>,
    /// Time of a step \[us\], all stages of the steps together, without what goes on in the background.
    pub step_us: Option<f64>,
}

impl Rates {
    fn of(meter: &Meter) -> Self {
        let per = |seconds: f64, counter: Counter| {
            let amount = meter.counted(counter) as f64;
            (amount > 0.0).then(|| seconds / amount)
        };
        let sums = meter.cost(Stage::Influence);
        let seconds = sums.cpu_seconds().unwrap_or(sums.wall.as_secs_f64());
        let steps: f64 = Stage::OF_A_STEP.iter().map(|&stage| meter.cost(stage).wall.as_secs_f64()).sum();
        Self {
            compliance_evaluation_ns: per(1e9 * seconds, Counter::ComplianceEvaluations),
            step_us: per(1e6 * steps, Counter::Steps),
        }
    }
}

/// All steps of a run together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct StepsRecord {
    /// Wall time \[s\].
    pub seconds: f64,
    /// Processor time of all threads \[s\].
    pub cpu_seconds: Option<f64>,
    /// Share of the threads' time in which they had nothing to do.
    pub idle_share: Option<f64>,
}

impl StepsRecord {
    fn of(meter: &Meter, threads: usize) -> Self {
        let steps = meter.steps();
        let (seconds, cpu_seconds) = (steps.wall.as_secs_f64(), steps.cpu_seconds());
        Self { seconds, cpu_seconds, idle_share: cpu_seconds.map(|cpu| idle_share(cpu, seconds, threads)) }
    }
}

/// Cost by stage, on so many threads.
#[derive(Clone, Debug)]
pub struct StageCosts {
    /// The costs.
    pub meter: Meter,
    /// Threads of the run.
    pub threads: usize,
}

impl Cost {
    /// Cost of a run as its meter has it.
    pub fn new(meter: &Meter, wall_seconds: f64, threads: usize) -> Self {
        let meter = meter.without_trace();
        Self {
            wall_seconds,
            cpu_seconds: None,
            idle_share: None,
            threads,
            peak_memory: peak_memory(),
            planned: None,
            share_of_steps_timed: meter.timing().share_of_steps(),
            steps: StepsRecord::of(&meter, threads),
            stages: StageCosts { meter: meter.clone(), threads },
            rates: Rates::of(&meter),
            machine_peak: None,
            counters: meter,
        }
    }

    /// The same with what was expected.
    #[must_use]
    pub fn with_plan(self, planned: Planned) -> Self {
        Self { planned: Some(planned), ..self }
    }

    /// The same with the processor time of the whole run.
    #[must_use]
    pub fn with_cpu(self, cpu: Option<Duration>) -> Self {
        let cpu_seconds = cpu.map(|cpu| cpu.as_secs_f64());
        let wall = Some(self.wall_seconds).filter(|wall| *wall > 0.0);
        let idle_share = cpu_seconds.zip(wall).map(|(cpu, wall)| idle_share(cpu, wall, self.threads));
        Self { cpu_seconds, idle_share, ..self }
    }

    /// The same with what the machine can do.
    #[must_use]
    pub fn with_machine_peak(self, peak: MachinePeak) -> Self {
        Self { machine_peak: Some(peak), ..self }
    }
}

#[derive(Serialize)]
struct StageRecord {
    calls: u64,
    seconds: f64,
    background_seconds: f64,
    cpu_seconds: Option<f64>,
    idle_share: Option<f64>,
    allocations: Option<u64>,
    allocated_bytes: Option<u64>,
    peak_memory: Option<u64>,
    multiply_adds: Option<u64>,
    bytes: Option<u64>,
    flop_per_second: Option<f64>,
    bytes_per_second: Option<f64>,
}

impl Serialize for StageCosts {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let counted = |amount: u64| (amount > 0).then_some(amount);
        let mut map = serializer.serialize_map(Some(Stage::ALL.len()))?;
        for stage in Stage::ALL {
            let cost = self.meter.cost(stage);
            let record = StageRecord {
                calls: cost.calls,
                seconds: cost.wall.as_secs_f64(),
                background_seconds: cost.background.as_secs_f64(),
                cpu_seconds: cost.cpu_seconds(),
                idle_share: cost.idle_share(self.threads),
                allocations: cost.allocations.map(|allocations| allocations.count),
                allocated_bytes: cost.allocations.map(|allocations| allocations.bytes),
                peak_memory: cost.peak_memory,
                multiply_adds: counted(cost.work.multiply_adds),
                bytes: counted(cost.work.bytes),
                flop_per_second: cost.flop_rate(),
                bytes_per_second: cost.byte_rate(),
            };
            map.serialize_entry(&stage, &record)?;
        }
        map.end()
    }
}

fn counters<S: Serializer>(meter: &Meter, serializer: S) -> Result<S::Ok, S::Error> {
    let mut map = serializer.serialize_map(Some(Counter::ALL.len()))?;
    for counter in Counter::ALL {
        map.serialize_entry(&counter, &meter.counted(counter))?;
    }
    map.end()
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;
    use crate::counters::{Allocations, StageCost, Work};

    #[test]
    fn what_was_measured_has_numbers_and_the_rest_is_null() {
        let mut meter = Meter::default();
        let seconds = Duration::from_secs;
        let (watched, watched_all, cpu) = (seconds(1), seconds(1), seconds(1));
        let work = Work { multiply_adds: 8_000_000_000, bytes: 6_000_000_000 };
        let history = StageCost { wall: seconds(4), watched, watched_all, cpu, work, ..StageCost::default() };
        meter.add_cost(Stage::History, history);
        // Within the steps the time of the other threads is not known.
        let search = StageCost { wall: seconds(4), watched, cpu, ..StageCost::default() };
        meter.add_cost(Stage::ActiveSet, search);
        let allocations = Some(Allocations { count: 7, bytes: 900 });
        let sums = StageCost { calls: 1, wall: seconds(2), allocations, peak_memory: Some(5), ..StageCost::default() };
        meter.add_cost(Stage::Influence, sums);
        meter.count(Counter::ComplianceEvaluations, 1_000_000);
        meter.count(Counter::Steps, 100_000);
        let cost = Cost::new(&meter, 10.0, 2).with_cpu(Some(seconds(15)));
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
