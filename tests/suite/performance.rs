//! Performance as it is recorded: every workload finds what it must and takes what the committed record says; a planted
//! slowdown is found, none is found where there is none.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::AtomicBool;

use serde_json::Value;
use tyrewave::Plan;
use tyrewave::internals::{
    PerformanceRecord, Workload, differences, instruction_set, measure_performance as measure,
    performance_value as value, read_accepted,
};
use tyrewave::run::Simulation;
use tyrewave::scene::History;

use crate::common::{program, skipped};

fn folder() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The committed records, that of this processor's instructions first: rounding may differ in the others.
fn committed() -> Vec<PerformanceRecord> {
    let records = folder().join("profiles/record");
    let mut sets = vec![instruction_set(), "x86-64-v3", "x86-64-v4"];
    sets.dedup();
    let places = sets.into_iter().map(|set| PerformanceRecord::place(&records, set)).filter(|path| path.exists());
    places.map(|path| PerformanceRecord::read(&path).unwrap()).collect()
}

#[test]
fn every_workload_is_right_and_takes_what_the_record_says() {
    let records = committed();
    let known = records.iter().flat_map(|record| record.workloads.keys());
    known.for_each(|name| assert!(Workload::ALL.iter().any(|workload| workload.name() == name), "{name}"));
    assert!(records.iter().any(|record| record.workloads.len() == Workload::ALL.len()), "no record is complete");
    let accepted = read_accepted(&folder().join("profiles/accepted.toml")).unwrap();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let mut unexplained = Vec::new();
    for workload in Workload::ALL {
        let measurement = pool.install(|| measure(workload, &AtomicBool::new(false))).unwrap();
        let name = workload.name();
        println!("{name}: {:?}", measurement.found);
        assert_eq!(measurement.found.complaint(), None, "{name}");
        assert!(!measurement.counters.is_empty() && !measurement.blocks.is_empty(), "{measurement:?}");
        let record = records.iter().find(|record| record.workloads.contains_key(name)).expect("a record");
        let other = record.stamp["instruction_set"] != measurement.instruction_set;
        let recorded = &record.workloads[name].counters;
        for difference in differences(name, recorded, &measurement.counters, &accepted, other) {
            println!("{name}: {difference:?}");
            if difference.explained.is_none() {
                unexplained
                    .push(format!("{name}: {} was {}, is {}", difference.counter, difference.from, difference.to));
            }
        }
    }
    assert!(
        unexplained.is_empty(),
        "work has changed: {unexplained:#?}\nIf it should, say why in profiles/accepted.toml, or record again with \
         `tyrewave profile record`."
    );
}

#[test]
#[ignore = "two minutes"]
fn the_workloads_must_find_what_the_other_history_finds() {
    let mut wrong = Vec::new();
    for workload in Workload::ALL {
        let Some(mut loaded) = workload.scene().unwrap() else { continue };
        let numerics = &mut loaded.scene.numerics;
        // All of the past by the sum; a tight fit against the sum itself.
        (numerics.history, numerics.memory, numerics.pole_tolerance) = match numerics.history {
            // The sum takes minutes for a rule of two stages.
            History::Modal if workload == Workload::HighSpeed => (History::Modal, 0.7, 1e-7),
            // After one second nothing is left of a force.
            History::Modal => {
                (History::Direct, (loaded.scene.rolling.warm_up + loaded.scene.rolling.duration).min(1.0), 1e-5)
            }
            History::Direct => (History::Modal, 0.7, 1e-6),
        };
        let begin = std::time::Instant::now();
        let plan = Plan::of(&loaded).unwrap();
        let mut run = Simulation::begin(&loaded, &plan, &AtomicBool::new(false)).unwrap();
        while run.step().unwrap().is_some() {}
        let results = run.finish();
        let (truth, value) = (workload.truth(), value(workload, &results));
        println!("{}: {} = {value}, {:.1} s", workload.name(), truth.what, begin.elapsed().as_secs_f64());
        if value.is_nan() || (value - truth.expected).abs() > 1e-9 * value {
            wrong.push(format!("{}: {value} instead of {}", workload.name(), truth.expected));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Compares two programs with the defaults; exit code and verdict.
fn compared(first: &Path, second: &Path, place: &Path) -> (i32, Value, String) {
    let json = place.join("verdict.json");
    let mut command = Command::new(program());
    command.args(["profile", "compare", "--quiet", "--accepted", "profiles/accepted.toml"]);
    let output = command.arg(first).arg(second).arg("--json-file").arg(&json).current_dir(folder()).output().unwrap();
    let text = format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    let verdict =
        serde_json::from_str(&fs::read_to_string(&json).unwrap_or_default()).unwrap_or_else(|_| panic!("{text}"));
    (output.status.code().unwrap(), verdict, text)
}

#[test]
fn comparisons_end_with_the_right_exit_code() {
    let place = tempfile::tempdir().unwrap();
    let record = PerformanceRecord::place(&folder().join("profiles/record"), instruction_set());
    let run = |arguments: &[&str]| {
        let output = Command::new(program())
            .args(["profile", "compare", "--quiet"])
            .args(arguments)
            .current_dir(folder())
            .output();
        let output = output.unwrap();
        let text = format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
        (output.status.code().unwrap(), text)
    };
    let mistakes: [&[&str]; 4] = [
        &["nowhere/record.json"],
        &["nowhere/program"],
        &["Cargo.toml", "README.md", "--workload", "walk"],
        &["tests/layers.json"],
    ];
    for mistake in mistakes {
        assert_eq!(run(mistake).0, 2, "{mistake:?}");
    }
    if !record.exists() {
        skipped(&format!("no record for {}", instruction_set()));
        return;
    }
    let (code, text) = run(&["--workload", "influence"]);
    assert_eq!(code, 0, "{text}");
    // More work than recorded, and a wrong result.
    let mut other = PerformanceRecord::read(&record).unwrap();
    let influence = other.workloads.get_mut("influence").unwrap();
    *influence.counters.get_mut("compliance_evaluations").unwrap() -= 1;
    let path = place.path().join("other.json");
    other.write(&path).unwrap();
    let (code, text) = run(&[path.to_str().unwrap(), record.to_str().unwrap(), "--workload", "influence"]);
    assert!(code == 1 && text.contains("compliance_evaluations") && text.contains("no accepted change"), "{text}");
    other.workloads.get_mut("influence").unwrap().found.value = 2.0;
    other.write(&path).unwrap();
    let (code, text) = run(&[record.to_str().unwrap(), path.to_str().unwrap(), "--workload", "influence"]);
    assert!(code == 1 && text.contains("wrong result"), "{text}");
    // Out of time, a verdict says what it rests on.
    let itself = program();
    let itself = itself.to_str().unwrap();
    let (code, text) = run(&[itself, itself, "--workload", "influence", "--budget", "1"]);
    assert!(code == 5 && text.contains("times undecided") && text.contains(" pairs of runs"), "{text}");
    // A user's scene: between programs alone.
    let scene = place.path().join("mine.toml");
    let text = fs::read_to_string(folder().join("scenes/plate.toml")).unwrap();
    let short = [
        ("elements = 512", "elements = 96"),
        ("duration = 18.0", "duration = 0.2"),
        ("warm_up = 0.5", "warm_up = 0.1"),
    ];
    fs::write(&scene, short.iter().fold(text, |text, (from, to)| text.replace(from, to))).unwrap();
    let scene = scene.to_str().unwrap();
    // Other tests disturb the times of so few pairs: undecided is no fault of the program.
    let (code, text) = run(&[itself, itself, "--scene", scene, "--pairs", "12"]);
    assert!(matches!(code, 0 | 5) && text.contains("mine.toml"), "{text}");
    assert!(text.contains("1 workloads: results correct") && text.contains("in 12 pairs of runs"), "{text}");
    let (code, text) = run(&[record.to_str().unwrap(), itself, "--scene", scene]);
    assert!(code == 2 && text.contains("a record contains no scenes"), "{text}");
    // A program that does not measure is distinguished from one that is worse.
    let (code, text) = run(&[if cfg!(windows) { "cmd" } else { "/bin/false" }, "--workload", "influence"]);
    assert!(code == 1 && text.contains("profile measure"), "{text}");
    // Options and workloads of earlier versions.
    let (code, text) = run(&["--no-instructions"]);
    assert!(code == 2 && text.contains("cargo bench --features count-instructions"), "{text}");
    let (code, text) = run(&["--workload", "compliance"]);
    assert!(code == 2 && text.contains("`influence`"), "{text}");
}

/// Stages that a verdict calls changed: workload, stage, change, ratio.
fn changed(verdict: &Value) -> Vec<(String, String, String, f64)> {
    let workloads = verdict["workloads"].as_array().unwrap().iter();
    let stages = workloads.flat_map(|workload| {
        let name = workload["workload"].as_str().unwrap();
        workload["stages"].as_array().unwrap().iter().map(move |stage| {
            let text = |key: &str| stage[key].as_str().unwrap().to_owned();
            (name.to_owned(), text("stage"), text("change"), stage["ratio"]["median"].as_f64().unwrap())
        })
    });
    stages.filter(|(_, _, change, _)| change == "slower" || change == "faster").collect()
}

#[test]
#[ignore = "an hour with --release: twenty comparisons"]
fn an_unchanged_program_passes_twenty_comparisons() {
    let place = tempfile::tempdir().unwrap();
    // Another file of the same program, so that nothing is shared.
    let copy = place.path().join("copy");
    fs::copy(program(), &copy).unwrap();
    for comparison in 1..=20 {
        let (code, verdict, text) = compared(&program(), &copy, place.path());
        println!("comparison {comparison}:\n{text}");
        assert_eq!((code, changed(&verdict)), (0, Vec::new()), "{text}");
    }
}

/// A copy of the sources with one place of one file changed, built like the program.
fn with(file: &str, place: &str, planted: &str) -> PathBuf {
    let copy = folder().join("target/planted");
    let sources = copy.join("source");
    let _ = fs::remove_dir_all(&sources);
    fs::create_dir_all(&sources).unwrap();
    for name in ["src", "scenes", "benches", "tests", "Cargo.toml", "Cargo.lock", "README.md"] {
        assert!(Command::new("cp").arg("-r").arg(folder().join(name)).arg(&sources).status().unwrap().success());
    }
    let path = sources.join(file);
    let text = fs::read_to_string(&path).unwrap();
    assert_eq!(text.matches(place).count(), 1, "{file} has changed: {place}");
    fs::write(&path, text.replace(place, planted)).unwrap();
    let mut cargo = Command::new(env!("CARGO"));
    cargo
        .args(["build", "--release", "--bin", "tyrewave", "--target-dir"])
        .arg(copy.join("target"))
        .current_dir(&sources);
    assert!(cargo.status().unwrap().success());
    copy.join("target/release/tyrewave")
}

#[test]
#[ignore = "a quarter of an hour with --release: builds the program with a stage 5 % slower, twice"]
fn a_stage_that_takes_five_percent_longer_is_found_and_named() {
    let place = tempfile::tempdir().unwrap();
    let plants = [
        (
            "history",
            "src/contact/history/far.rs",
            "times[0] = clock.lap();\n",
            "times[0] = clock.lap();\nlet (planted, more) = (std::time::Instant::now(), times[0].wall.mul_f64(0.05));\n\
             while planted.elapsed() < more {}\ntimes[0] += clock.lap();\n",
        ),
        (
            "active_set",
            "src/contact/march.rs",
            "let residuals = self.search.forces(&mut self.required, under, &mut self.forces, step, meter)?;\n",
            "let planted = std::time::Instant::now();\n\
             let residuals = self.search.forces(&mut self.required, under, &mut self.forces, step, meter)?;\n\
             let until = planted.elapsed().mul_f64(1.05);\nwhile planted.elapsed() < until {}\n",
        ),
    ];
    for (stage, file, text, planted) in plants {
        let slower = with(file, text, planted);
        let (code, verdict, text) = compared(&program(), &slower, place.path());
        println!("5 % longer: {stage}\n{text}");
        assert_eq!(code, 1, "{text}");
        let found = changed(&verdict);
        assert!(
            found
                .iter()
                .any(|(_, name, change, ratio)| name == stage && change == "slower" && (1.02..1.09).contains(ratio)),
            "{text}"
        );
        // Another build may lay other stages out otherwise, but nothing else is as much slower everywhere.
        let is_other = |name: &str| name != stage && name != "all";
        let others: Vec<_> = found.iter().filter(|(_, name, change, _)| is_other(name) && change == "slower").collect();
        assert!(others.is_empty(), "{others:?}");
    }
}
