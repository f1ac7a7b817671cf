//! Cost of a run, as in `summary.json`.
//!
//! Cost of a run, as tables for the terminal: stages first, then a time step, counters below. A stage that a run did
//! not use has no line, a quantity that was not measured no column.

use std::collections::BTreeMap;
use std::time::Duration;

use crate::counters::process::peak_memory;
use crate::counters::{Counter, MachinePeak, Meter, Stage, StageCost, idle_share};
use serde::{Deserialize, Serialize};

use super::table::{Report, TextTable, aligned, grouped};

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

/// Stage times and counters as text, a newline last: processor time and the threads' idle share, memory, rates beside
/// those that a core of the machine can reach. Time outside of all stages is listed as the rest; background work has
/// a separate column and is no part of it.
pub fn cost_table(cost: &RunCost) -> Report {
    let steps = cost.counted(Counter::Steps);
    let mut report = Report::from(stages(cost));
    report.text("\n");
    if steps > 0 {
        report.table(step(cost, steps));
        report.text("\n");
    }
    if let Some(line) = compliance(cost) {
        report.text(format!("{line}\n\n"));
    }
    report.table(counters(cost));
    report
}

/// Line on the time of an evaluation of the compliance, if there was one.
fn compliance(cost: &RunCost) -> Option<String> {
    let nanoseconds = cost.rates.compliance_evaluation_ns?;
    let evaluations = cost.counted(Counter::ComplianceEvaluations) as f64;
    let flop = 2.0 * cost.stage(Stage::Influence).multiply_adds.unwrap_or(0) as f64 / evaluations;
    let rate = flop / nanoseconds;
    let peak = cost.machine_peak.map_or(String::new(), |peak| format!(" of {:.1}", 1e-9 * peak.flop_per_second));
    Some(format!("a compliance evaluation: {nanoseconds:.0} ns, {flop:.0} flop: {rate:.1}{peak} Gflop/s"))
}

/// Table of the cost of a time step, stage by stage: time, arithmetic, memory traffic, and their rates, beside the best
/// rates of a core.
fn step(cost: &RunCost, steps: u64) -> TextTable {
    let row = |stage: Stage| {
        let cost = cost.stage(stage);
        let per_step = |amount: f64| amount / steps as f64;
        let rate = |rate: Option<f64>| rate.map_or(String::new(), |rate| format!("{:.1}", 1e-9 * rate));
        let count =
            |amount: Option<u64>| amount.map_or(String::new(), |amount| grouped(per_step(amount as f64) as u64));
        [
            stage.title().to_owned(),
            format!("{:.1} us", 1e6 * per_step(cost.seconds + cost.background_seconds)),
            count(cost.multiply_adds.map(|multiply_adds| 2 * multiply_adds)),
            count(cost.bytes),
            rate(cost.flop_per_second),
            rate(cost.bytes_per_second),
        ]
    };
    let head =
        |unit: &str, best: Option<f64>| best.map_or(unit.to_owned(), |best| format!("{unit} of {:.1}", 1e-9 * best));
    let flop = head("Gflop/s", cost.machine_peak.map(|peak| peak.flop_per_second));
    let bytes = head("GB/s", cost.machine_peak.map(|peak| peak.bytes_per_second));
    let stages = Stage::OF_A_STEP.into_iter().filter(|&stage| cost.stage(stage).calls > 0);
    aligned(["a time step", "time", "flop", "bytes", &flop, &bytes], stages.map(row))
}

/// Columns of the stages' table.
const COLUMNS: [&str; 10] = ["stage", "calls", "wall", "share", "behind", "cpu", "idle", "blocks", "allocated", "peak"];

fn stages(cost: &RunCost) -> TextTable {
    let wall = cost.wall_seconds;
    let share = |part: f64| if wall > 0.0 { format!("{:.1} %", 100.0 * part / wall) } else { String::new() };
    let seconds = |time: f64| format!("{time:.3} s");
    let idle = |share: Option<f64>| share.map_or(String::new(), |share| format!("{:.0} %", 100.0 * share));
    let megabytes = |bytes: Option<u64>| bytes.map_or(String::new(), |bytes| format!("{:.1} MB", 1e-6 * bytes as f64));
    let mut staged = 0.0;
    let mut rows: Vec<[String; COLUMNS.len()]> = Vec::new();
    for (stage, record) in cost.stages.iter().filter(|(_, record)| record.calls > 0) {
        staged += record.seconds;
        let indent = if stage.part_of().is_some() { "  " } else { "" };
        rows.push([
            format!("{indent}{}", stage.title()),
            grouped(record.calls),
            seconds(record.seconds),
            share(record.seconds),
            if record.background_seconds > 0.0 { seconds(record.background_seconds) } else { String::new() },
            record.cpu_seconds.map_or(String::new(), seconds),
            idle(record.idle_share),
            record.allocations.map_or(String::new(), grouped),
            megabytes(record.allocated_bytes),
            megabytes(record.peak_memory),
        ]);
    }
    let rest = |title: &str, time: f64| {
        let mut row = [const { String::new() }; COLUMNS.len()];
        (row[0], row[2], row[3]) = (title.to_owned(), seconds(time), share(time));
        row
    };
    let mut run = rest("whole run", wall);
    // For a run without detailed timing only times are shown.
    if cost.closely {
        (run[5], run[6]) = (cost.cpu_seconds.map_or(String::new(), seconds), idle(cost.idle_share));
        run[9] = megabytes(cost.peak_memory);
    }
    rows.push(rest("everything else", (wall - staged).max(0.0)));
    if cost.closely && cost.steps.seconds > 0.0 {
        let mut steps = rest("all steps together", cost.steps.seconds);
        (steps[5], steps[6]) = (cost.steps.cpu_seconds.map_or(String::new(), seconds), idle(cost.steps.idle_share));
        rows.push(steps);
    }
    rows.push(run);
    let shown: Vec<usize> =
        (0..COLUMNS.len()).filter(|&column| rows.iter().any(|row| !row[column].is_empty())).collect();
    let header = shown.iter().map(|&column| COLUMNS[column]);
    aligned(header, rows.iter().map(|row| shown.iter().map(|&column| &row[column])))
}

fn counters(cost: &RunCost) -> TextTable {
    let reported = cost.counters.iter().filter(|&(counter, &amount)| amount > 0 || counter.counts_trouble());
    aligned(["counter", "amount"], reported.map(|(counter, &amount)| [counter.title().to_owned(), grouped(amount)]))
}

#[cfg(test)]
mod tests {
    use crate::counters::{Allocations, Counters, Spent, Work};
    use serde_json::{Value, json};

    use super::*;

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

    fn profile_table(meter: &Meter, wall: Duration) -> String {
        cost_table(&RunCost::new(meter, wall.as_secs_f64(), 1)).to_string()
    }

    #[test]
    fn every_stage_and_counter_in_use_is_listed_and_shares_add_up() {
        let mut meter = Meter::default();
        let idle = profile_table(&meter, Duration::from_secs(4));
        for stage in Stage::ALL {
            assert!(!idle.contains(stage.title()), "{idle}");
            meter.add_time(stage, Duration::ZERO);
        }
        for counter in Counter::ALL {
            assert_eq!(idle.contains(counter.title()), counter.counts_trouble(), "{idle}");
            meter.count(counter, 1);
        }
        meter.add_time(Stage::History, Duration::from_millis(1500));
        meter.add_time(Stage::History, Duration::from_millis(500));
        meter.count(Counter::HistoryMultiplyAdds, 21_233_663);
        let text = profile_table(&meter, Duration::from_secs(4));
        println!("{text}");
        for stage in Stage::ALL {
            assert!(text.contains(stage.title()), "{text}");
        }
        for counter in Counter::ALL {
            assert!(text.contains(counter.title()), "{text}");
        }
        assert!(text.contains("2.000 s") && text.contains("50.0 %") && text.contains("21 233 664"), "{text}");
        assert!(text.lines().any(|line| line.contains("everything else") && line.contains("50.0 %")), "{text}");
        // Beside the wall time, not in it.
        meter.add_background(Stage::Road, Duration::from_millis(3250));
        let beside = profile_table(&meter, Duration::from_secs(4));
        assert!(beside.lines().any(|line| line.contains(Stage::Road.title()) && line.contains("3.250 s")), "{beside}");
        assert!(beside.lines().any(|line| line.contains("everything else") && line.contains("50.0 %")), "{beside}");
        let none = profile_table(&Meter::default(), Duration::ZERO);
        assert!(!none.contains("NaN"), "{none}");
    }
}
