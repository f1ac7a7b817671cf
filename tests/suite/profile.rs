//! The stage profile: its numbers agree with each other, its files with their formats, and it changes no bit of a
//! result.

use std::fs;
use std::path::Path;
use std::process::Output;
use std::sync::atomic::AtomicBool;

use serde_json::{Value, json};
use tyrewave::Plan;
use tyrewave::counters::{Stage, Timing};
use tyrewave::internals::{cpu_time, edit, scene_text};
use tyrewave::run::Simulation;
use tyrewave::scene::{PLATE, Road, Scene};

use crate::common::{command, read_summary};

const ROLLING: &str = "speed_kmh = 80.0\nwarm_up = 0.1\nduration = 0.6\naxle = { load = 3400 }";

fn text() -> String {
    let vibration = "[outputs]\ncheckpoint_interval = 0.01\n[outputs.vibration]\nsegment = 0.1\npoints = [0.1]";
    scene_text(64, "kind = \"made\"\nseed = 3", ROLLING, "history = \"modal\"\npole_tolerance = 1e-3", vibration)
}

fn tyrewave(folder: &Path, arguments: &[&str]) -> Output {
    command(folder, arguments).env("TYREWAVE_CACHE_DIR", folder.join("cache")).output().unwrap()
}

/// An event's row, begin and end \[us\].
fn interval(event: &Value) -> (u64, f64, f64) {
    let begin = event["ts"].as_f64().unwrap();
    (event["tid"].as_u64().unwrap(), begin, begin + event["dur"].as_f64().unwrap())
}

#[test]
fn a_profiled_run_has_the_same_bytes_and_consistent_files() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    fs::write(place.join("scene.toml"), text()).unwrap();
    for threads in ["1", "2"] {
        let plain = tyrewave(place, &["run", "scene.toml", "--out", "plain", "--threads", threads]);
        assert!(plain.status.success(), "{}", String::from_utf8_lossy(&plain.stderr));
        let options = ["--profile", "--trace", "trace.json", "--folded", "stacks.txt", "--threads", threads];
        let profiled = tyrewave(place, &[&["run", "scene.toml", "--out", "profiled"], &options[..]].concat());
        assert!(profiled.status.success(), "{}", String::from_utf8_lossy(&profiled.stderr));
        for entry in fs::read_dir(place.join("plain")).unwrap().map(|entry| entry.unwrap().file_name()) {
            let bytes = |run: &str| fs::read(place.join(run).join(&entry)).unwrap();
            assert!(entry == "summary.json" || bytes("plain") == bytes("profiled"), "{entry:?} differs");
        }
        let (plain, summary) = (read_summary(&place.join("plain")), read_summary(&place.join("profiled")));
        for key in ["outcome", "contact", "vibration", "settings", "scene_sha256"] {
            assert_eq!(plain[key], summary[key], "{key}");
        }
        check_table(&String::from_utf8(profiled.stdout).unwrap());
        let cost = &summary["cost"];
        let shares = [&plain, &summary].map(|summary| summary["cost"]["share_of_steps_timed"].clone());
        assert_eq!(shares, [json!(0.0625), json!(1.0)]);
        check_trace(&fs::read_to_string(place.join("trace.json")).unwrap(), cost);
        check_stacks(&fs::read_to_string(place.join("stacks.txt")).unwrap(), cost);
        let names: Vec<_> = fs::read_dir(place).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        assert!(names.iter().all(|name| !name.to_string_lossy().ends_with(".tmp")), "{names:?}");
    }
}

fn check_table(text: &str) {
    for column in ["calls", "wall", "share", "cpu", "idle", "peak", "all steps together", "Gflop/s of", "GB/s of"] {
        assert!(text.contains(column), "{column}: {text}");
    }
    assert!(text.lines().all(|line| line.chars().count() <= 120), "{text}");
    assert!(text.lines().any(|line| line.trim_start().starts_with("factorise ")), "{text}");
}

fn seconds(cost: &Value, stage: Stage) -> f64 {
    let name = serde_json::to_value(stage).unwrap();
    cost["stages"][name.as_str().unwrap()]["seconds"].as_f64().unwrap()
}

fn check_trace(text: &str, cost: &Value) {
    let trace: Value = serde_json::from_str(text).unwrap();
    assert_eq!(trace["otherData"]["spans_without_room"], 0);
    let events: Vec<&Value> =
        trace["traceEvents"].as_array().unwrap().iter().filter(|event| event["ph"] == "X").collect();
    // Within a row an event either lies within an earlier one or begins after its end; times are written to the
    // nanosecond.
    const ROUNDING: f64 = 2e-3;
    for row in [1, 2] {
        let mut open: Vec<f64> = Vec::new();
        let mut last = f64::NEG_INFINITY;
        for (_, begin, end) in events.iter().map(|event| interval(event)).filter(|event| event.0 == row) {
            assert!(begin >= last - ROUNDING && end >= begin);
            last = begin;
            open.retain(|&outer| outer > begin + ROUNDING);
            assert!(open.iter().all(|&outer| end <= outer + ROUNDING), "row {row}: {begin} to {end} in {open:?}");
            open.push(end);
        }
    }
    let named = |name: &str| -> Vec<f64> {
        let these = events.iter().filter(|event| event["name"] == name && event["tid"] == 1);
        these.map(|event| 1e-6 * event["dur"].as_f64().unwrap()).collect()
    };
    let total = |name: &str| named(name).iter().sum::<f64>();
    // One reading of the clock begins both, another ends both; times of spans are written to the nanosecond.
    assert!((total("run") - cost["wall_seconds"].as_f64().unwrap()).abs() < 2e-9);
    assert_eq!(["prepare", "contact", "results"].map(|phase| named(phase).len()), [1, 1, 1]);
    let mut stages = 0;
    for stage in Stage::ALL.into_iter().filter(|&stage| seconds(cost, stage) > 0.0) {
        stages += 1;
        let (table, events) = (seconds(cost, stage), total(stage.title()));
        // Writing continues within other stages, whose events hold it.
        let within = if stage == Stage::Response { seconds(cost, Stage::Output) } else { 0.0 };
        assert!(events >= table - 1e-5 && events <= table + within + 1e-5, "{stage:?}: {table} s, {events} s traced");
    }
    assert!(stages >= 9, "{stages} stages");
}

fn check_stacks(text: &str, cost: &Value) {
    let lines: Vec<(&str, f64)> = text
        .lines()
        .map(|line| line.rsplit_once(' ').unwrap())
        .map(|(stack, time)| (stack, 1e-6 * time.parse::<f64>().unwrap()))
        .collect();
    let wall = cost["wall_seconds"].as_f64().unwrap();
    let all: f64 = lines.iter().map(|(_, time)| time).sum();
    // Written to the microsecond.
    assert!((all - wall).abs() < 2e-6, "{all} s of {wall} s");
    for stage in Stage::ALL {
        let folded: f64 = lines.iter().filter(|(stack, _)| stack.ends_with(stage.title())).map(|(_, time)| time).sum();
        assert!((folded - seconds(cost, stage)).abs() < 1e-5, "{stage:?}: {folded} s\n{text}");
    }
    assert!(lines.iter().all(|(stack, _)| stack.starts_with("tyrewave;run")));
}

#[test]
fn a_file_that_cannot_be_written_is_refused_before_the_run() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.toml"), text()).unwrap();
    for option in ["--trace", "--folded"] {
        for (wrong, code) in [("none/file", 3), (".", 2)] {
            let output = tyrewave(folder.path(), &["run", "scene.toml", option, wrong]);
            let message = String::from_utf8_lossy(&output.stderr);
            assert_eq!(output.status.code(), Some(code), "{option} {wrong}: {message}");
            assert!(message.contains(wrong), "{message}");
        }
    }
    let remaining: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(remaining, ["scene.toml"]);
}

/// Steps that are measured together: a whole period of what is timed.
const TOGETHER: u64 = 1024;
/// Ways to watch, each with the share of a step that it may take more than the first.
const WAYS: [(&str, Timing, f64); 4] = [
    ("nothing in the steps", Timing::Outside, 0.0),
    ("sampled, the default", Timing::Sampled, 0.002),
    ("closely: --profile", Timing::Closely, 0.01),
    ("every step: --trace", Timing::Every, 0.02),
];

/// Processor time so far \[s\]; asked for twice, since the first answer may be old.
fn processor_time() -> f64 {
    cpu_time();
    cpu_time().unwrap().as_secs_f64()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Equal runs do the same steps, one piece after the other. Each is watched in every way in turn, in changing order, so
/// that neither the place of a run in memory nor the order says anything. A smooth road: its steps are the shortest,
/// and equal.
#[test]
#[ignore = "measures time: for a release build on a quiet machine"]
fn overhead() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    for (elements, rounds) in [(512, 40), (1024, 20)] {
        let text = edit(PLATE, &[("numerics.elements", &elements.to_string())]);
        let mut loaded = Scene::from_str(&text, "default").unwrap();
        loaded.scene.road = Road::Smooth;
        let plan = Plan::new(&loaded.scene);
        pool.install(|| {
            let mut runs = WAYS.map(|_| Simulation::begin(&loaded, &plan, &AtomicBool::new(false)).unwrap());
            // By way: the mean of a round of pieces.
            let mut times: [Vec<f64>; WAYS.len()] = Default::default();
            for round in 0..=rounds {
                let mut sums = [0.0; WAYS.len()];
                for piece in 0..WAYS.len() {
                    for place in 0..WAYS.len() {
                        let (run, way) = ((place + round) % WAYS.len(), (place + round + piece) % WAYS.len());
                        runs[run].set_timing(WAYS[way].1);
                        let begin = processor_time();
                        for _ in 0..TOGETHER {
                            runs[run].step().unwrap();
                        }
                        sums[way] += processor_time() - begin;
                    }
                }
                // The first round finds cold memory, and the tyre still in the air.
                if round > 0 {
                    let pieces = (WAYS.len() as u64 * TOGETHER) as f64;
                    times.iter_mut().zip(sums).for_each(|(times, sum)| times.push(sum / pieces));
                }
            }
            let step = median(times[0].clone());
            for ((name, _, bound), of_way) in WAYS.into_iter().zip(&times) {
                let more = median(of_way.iter().zip(&times[0]).map(|(time, base)| time - base).collect());
                println!(
                    "N = {elements}, {name}: {:+.0} ns, {:+.2} % of a step's {:.1} us",
                    1e9 * more,
                    100.0 * more / step,
                    1e6 * step
                );
                assert!(more <= bound * step, "{name}: {more} s of {step} s");
            }
        });
    }
}
