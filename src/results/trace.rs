//! Timeline of a run for programs that draw it: Chrome's trace events (Perfetto, chrome://tracing) and folded stacks
//! (flame graphs).
//!
//! - Trace: one complete event ("X") for each span, in microseconds since the run began; thread 1 is that of the run,
//!   thread 2 the background work. Format: "Trace Event Format", Duffy et al., Google 2016.
//! - Folded: a line for every stack, frames from the outermost to the innermost with semicolons between them, then the
//!   microseconds spent in exactly that stack, on the thread of the run. Format: B. Gregg, FlameGraph, `stackcollapse`.
//!   The lines add up to the wall time of the run.

use serde_json::{Value, json};

use crate::counters::trace::{Row, Trace, What};
use crate::counters::{Phase, Stage};

/// Begin of a trace.
pub(crate) const TRACE_HEAD: &str = "{\"displayTimeUnit\":\"ms\",\"otherData\":";
/// Begin of folded stacks.
pub(crate) const FOLDED_HEAD: &str = "tyrewave;run";

/// Chrome's trace events of a run that has ended.
pub(crate) fn chrome_trace(trace: &Trace, title: &str) -> String {
    let thread = |row: Row| match row {
        Row::March => 1,
        Row::Background => 2,
    };
    let named = |row: Row, name: &str| {
        let tid = thread(row);
        json!({ "name": "thread_name", "ph": "M", "pid": 1, "tid": tid, "args": { "name": name } })
    };
    let mut events: Vec<Value> = vec![
        json!({ "name": "process_name", "ph": "M", "pid": 1, "args": { "name": format!("tyrewave: {title}") } }),
        named(Row::March, "run"),
        named(Row::Background, "behind the run"),
    ];
    // Outer spans before those within them, as readers expect.
    let mut spans: Vec<_> = trace.spans.iter().collect();
    spans.sort_by_key(|span| (thread(span.row), span.begin, std::cmp::Reverse(span.length)));
    events.extend(spans.into_iter().map(|span| {
        let (name, category) = match span.what {
            What::Run => ("run".to_owned(), "run"),
            What::Phase(phase) => (phase.title().to_owned(), "phase"),
            What::Steps(first, end) => (format!("steps {first} to {}", end - 1), "steps"),
            What::Stage(stage) => (stage.title().to_owned(), "stage"),
        };
        let microseconds = |time: std::time::Duration| time.as_nanos() as f64 / 1000.0;
        json!({
            "name": name, "cat": category, "ph": "X", "pid": 1, "tid": thread(span.row),
            "ts": microseconds(span.begin), "dur": microseconds(span.length),
        })
    }));
    let document = json!({
        "displayTimeUnit": "ms",
        "otherData": { "version": env!("CARGO_PKG_VERSION"), "spans_without_room": trace.dropped() },
        "traceEvents": events,
    });
    format!("{document}\n")
}

/// Folded stacks of a run that has ended. Time outside of all stages counts for its phase, time outside of all phases
/// for the run.
pub(crate) fn folded_stacks(trace: &Trace) -> String {
    let microseconds = |time: std::time::Duration| u64::try_from(time.as_micros()).unwrap_or(u64::MAX);
    let mut text = String::new();
    let mut line = |stack: &str, time: u64| {
        if time > 0 {
            text.push_str(&format!("{stack} {time}\n"));
        }
    };
    let mut untraced = microseconds(trace.wall);
    for phase in Phase::ALL {
        let name = format!("tyrewave;run;{}", phase.title());
        let whole = microseconds(trace.phase_time(phase)).min(untraced);
        let mut unstaged = whole;
        for stage in Stage::ALL {
            let time = microseconds(trace.stage_time(phase, stage)).min(unstaged);
            let outer = stage.part_of().map_or(String::new(), |outer| format!("{};", outer.title()));
            line(&format!("{name};{outer}{}", stage.title()), time);
            unstaged -= time;
        }
        line(&name, unstaged);
        untraced -= whole;
    }
    line("tyrewave;run", untraced);
    text
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, Instant};

    use super::*;
    use crate::counters::{Meter, Spent, Watch};

    fn busy(microseconds: u64) {
        let begin = Instant::now();
        while begin.elapsed() < Duration::from_micros(microseconds) {
            std::hint::black_box(begin);
        }
    }

    fn meter() -> Meter {
        let mut meter = Meter::new(Watch { trace: true, ..Watch::EVERY });
        let open = meter.open();
        busy(600);
        meter.time(Stage::Axle, || busy(300));
        meter.close_shared(open, &[(Stage::Influence, 0.75), (Stage::Fit, 0.25)]);
        meter.trace_mut().unwrap().expect_steps(0, 300);
        meter.enter(Phase::Contact);
        for step in 0..300 {
            meter.begin_step(step);
            let begin = Instant::now();
            busy(10);
            let wall = begin.elapsed();
            meter.add_in_steps(Stage::ActiveSet, Spent { wall: wall / 2, ..Spent::default() });
            meter.add_in_steps(Stage::Factorisation, Spent { wall: wall / 4, ..Spent::default() });
            if step == 100 {
                meter.time(Stage::RoadWait, || busy(200));
                meter.add_background_since(Stage::Road, begin, begin.elapsed());
            }
            meter.end_step(step + 1);
        }
        meter.trace_mut().unwrap().end_block(300);
        meter.enter(Phase::Results);
        meter.settle_steps(300);
        meter.time(Stage::Output, || busy(100));
        meter.trace_mut().unwrap().end(Instant::now());
        meter
    }

    #[test]
    fn folded_stacks_add_up_to_the_wall_time() {
        let meter = meter();
        let trace = meter.trace().unwrap();
        let text = folded_stacks(trace);
        assert!(text.starts_with(FOLDED_HEAD) && chrome_trace(trace, "").starts_with(TRACE_HEAD));
        let times: Vec<(&str, u64)> = text
            .lines()
            .map(|line| line.rsplit_once(' ').unwrap())
            .map(|(stack, time)| (stack, time.parse().unwrap()))
            .collect();
        assert_eq!(times.iter().map(|(_, time)| time).sum::<u64>(), trace.wall.as_micros() as u64, "{text}");
        for stage in Stage::ALL {
            let in_stacks: u64 =
                times.iter().filter(|(stack, _)| stack.ends_with(stage.title())).map(|(_, time)| time).sum();
            let in_table = meter.cost(stage).spent.wall.as_micros() as u64;
            assert!(
                in_stacks.abs_diff(in_table) <= Phase::ALL.len() as u64,
                "{stage:?} {in_stacks} {in_table}\n{text}"
            );
        }
        assert!(times.iter().any(|(stack, _)| *stack == "tyrewave;run;contact;search the active set;factorise"));
    }
}
