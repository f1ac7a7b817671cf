//! What a run cost, as tables for the terminal: stages first, counters below. What a run did not do has no line.

use std::time::Duration;

use super::table::{aligned, grouped};
use crate::meter::{Counter, Meter, Stage, StageCost};

/// Stage times and counters as text, a newline last. `wall` is the time of the whole run; what no stage has is listed as the rest. What
/// was at work in the background stands beside and is no part of it.
pub fn profile_table(meter: &Meter, wall: Duration) -> String {
    let steps = meter.counted(Counter::Steps);
    let step = if steps > 0 { format!("{}\n", step(meter, steps)) } else { String::new() };
    format!("{}\n{step}{}", stages(meter, wall), counters(meter))
}

/// What every time step costs, stage by stage: time, arithmetic, memory traffic, and the rates that they make.
fn step(meter: &Meter, steps: u64) -> String {
    let row = |stage: Stage| {
        let StageCost { wall, background, work, .. } = meter.cost(stage);
        let seconds = (wall + background).as_secs_f64();
        let per_step = |amount: f64| amount / steps as f64;
        let rate = |amount: u64| match amount {
            0 => String::new(),
            amount if seconds > 0.0 => format!("{:.1}", 1e-9 * amount as f64 / seconds),
            _ => String::new(),
        };
        let count = |amount: u64| if amount > 0 { grouped(per_step(amount as f64) as u64) } else { String::new() };
        [
            stage.title().to_owned(),
            format!("{:.1} us", 1e6 * per_step(seconds)),
            count(2 * work.multiply_adds),
            count(work.bytes),
            rate(2 * work.multiply_adds),
            rate(work.bytes),
        ]
    };
    let stages = Stage::OF_A_STEP.into_iter().filter(|&stage| meter.cost(stage).calls > 0);
    aligned(&["a time step", "time", "flop", "bytes", "Gflop/s", "GB/s"], &stages.map(row).collect::<Vec<_>>())
}

fn stages(meter: &Meter, wall: Duration) -> String {
    let share = |part: Duration| {
        if wall.is_zero() { String::new() } else { format!("{:.1} %", 100.0 * part.as_secs_f64() / wall.as_secs_f64()) }
    };
    let seconds = |time: Duration| format!("{:.3} s", time.as_secs_f64());
    let mut staged = Duration::ZERO;
    let mut rows: Vec<[String; 5]> = Vec::new();
    for stage in Stage::ALL {
        let cost = meter.cost(stage);
        if cost.calls == 0 {
            continue;
        }
        staged += cost.wall;
        let background = if cost.background.is_zero() { String::new() } else { seconds(cost.background) };
        rows.push([stage.title().to_owned(), grouped(cost.calls), seconds(cost.wall), share(cost.wall), background]);
    }
    let rest = wall.saturating_sub(staged);
    for (title, time) in [("everything else", rest), ("whole run", wall)] {
        rows.push([title.to_owned(), String::new(), seconds(time), share(time), String::new()]);
    }
    aligned(&["stage", "calls", "wall", "share", "in background"], &rows)
}

fn counters(meter: &Meter) -> String {
    let row = |counter: Counter| [counter_title(counter).to_owned(), grouped(meter.counted(counter))];
    let told = |&counter: &Counter| meter.counted(counter) > 0 || counter.counts_trouble();
    aligned(&["counter", "amount"], &Counter::ALL.into_iter().filter(told).map(row).collect::<Vec<_>>())
}

/// The counter named as people read it in a table.
pub const fn counter_title(counter: Counter) -> &'static str {
    match counter {
        Counter::ComplianceEvaluations => "compliance evaluations",
        Counter::Poles => "poles of the influence functions",
        Counter::HistoryMultiplyAdds => "history multiply-adds",
        Counter::Slices => "road slices",
        Counter::Steps => "time steps",
        Counter::Solves => "linear solves",
        Counter::Factorisations => "factorisations",
        Counter::CacheHits => "factor cache hits",
        Counter::CacheMisses => "factor cache misses",
        Counter::Neighbours => "misses that a neighbour's factor served",
        Counter::CacheEvictions => "factor cache evictions",
        Counter::Fallbacks => "least-index fallbacks",
        Counter::WindowEdgeContacts => "steps with contact at the window's edge",
        Counter::VibrationTransforms => "transforms of the vibration",
        Counter::VibrationEvaluations => "evaluations of the vibration's transfers",
        Counter::BytesWritten => "bytes written",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_stage_and_counter_in_use_is_listed_and_shares_add_up() {
        let mut meter = Meter::default();
        let idle = profile_table(&meter, Duration::from_secs(4));
        for stage in Stage::ALL {
            assert!(!idle.contains(stage.title()), "{idle}");
            meter.add_time(stage, Duration::ZERO);
        }
        for counter in Counter::ALL {
            assert_eq!(idle.contains(counter_title(counter)), counter.counts_trouble(), "{idle}");
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
            assert!(text.contains(counter_title(counter)), "{text}");
        }
        assert!(text.contains("2.000 s") && text.contains("50.0 %") && text.contains("21 233 664"), "{text}");
        assert!(text.lines().any(|line| line.contains("everything else") && line.contains("50.0 %")), "{text}");
        // Beside the wall time, not in it.
        meter.add_background(Stage::Road, Duration::from_millis(3250));
        let beside = profile_table(&meter, Duration::from_secs(4));
        assert!(beside.lines().any(|line| line.contains(Stage::Road.title()) && line.ends_with("3.250 s")), "{beside}");
        assert!(beside.lines().any(|line| line.contains("everything else") && line.contains("50.0 %")), "{beside}");
        let none = profile_table(&Meter::default(), Duration::ZERO);
        assert!(!none.contains("NaN"), "{none}");
    }
}
