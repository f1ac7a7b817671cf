//! Cost of a run, as tables for the terminal: stages first, then a time step, counters below. A stage that a run did
//! not use has no line, a quantity that was not measured no column.

use super::cost::RunCost;
use super::table::{Report, TextTable, aligned, grouped};
use crate::counters::{Counter, Stage};

/// Stage times and counters as text, a newline last: processor time and the threads' idle share, memory, rates beside
/// those that a core of the machine can reach. Time outside of all stages is listed as the rest; background work has
/// a separate column and is no part of it.
pub fn cost_table(cost: &RunCost) -> Report {
    let steps = cost.counted(Counter::Steps);
    let mut report = Report::default();
    report.table(stages(cost));
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
    use std::time::Duration;

    use super::*;
    use crate::counters::Meter;

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
