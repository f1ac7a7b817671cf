//! A run does what its plan says, and takes what it says.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;
use std::sync::atomic::AtomicBool;

use serde_json::Value;
use tyrewave::Plan;
use tyrewave::counters::{Counter, Stage};
use tyrewave::internals::{WorkUnit, decisions, edit, scene, scene_text, without};
use tyrewave::run::Simulation;
use tyrewave::scene::{DEFAULT, LoadedScene, PLATE};

use crate::common::{program, read_summary};

const ROLLING: &str = "speed_kmh = 80.0\nwarm_up = 0.1\nduration = 0.4\naxle = { load = 3400 }";
const MODAL: &str = "history = \"modal\"\npole_tolerance = 1e-3";

fn scenes() -> Vec<(&'static str, LoadedScene)> {
    let made = "kind = \"made\"\nseed = 3";
    let of = |road, numerics, more| scene(&scene_text(64, road, ROLLING, numerics, more));
    vec![
        ("smooth", of("kind = \"smooth\"", MODAL, "")),
        ("direct", of("kind = \"smooth\"", "memory = 0.05", "")),
        ("direct, vibration", of("kind = \"smooth\"", "memory = 0.05\npole_tolerance = 1e-3", "[outputs.vibration]")),
        ("rough", of(made, MODAL, "")),
        ("level", of(made, MODAL, "[effects]\ntexture = \"off\"")),
        ("uncoupled", of(made, MODAL, "[contact]\ntread = \"uncoupled\"")),
        ("explicit", of(made, MODAL, "[contact]\nslice_coupling = \"explicit\"")),
        ("vibration", of(made, MODAL, "[outputs.vibration]\ntangential = true")),
    ]
}

#[test]
fn a_run_has_the_stages_of_its_plan_and_its_exact_counts() {
    for (name, loaded) in scenes() {
        let plan = Plan::of(&loaded).unwrap();
        let mut run = Simulation::begin(&loaded, &plan, &AtomicBool::new(false)).unwrap();
        while run.step().unwrap().is_some() {}
        let meter = run.finish().meter;
        let planned: BTreeSet<usize> = plan.amounts().work.iter().map(|amount| amount.stage as usize).collect();
        for stage in Stage::ALL.into_iter().filter(|&stage| meter.cost(stage).calls > 0) {
            // A part is planned with its whole.
            let stage = stage.part_of().unwrap_or(stage);
            let planned = planned.contains(&(stage as usize)) || stage == Stage::RoadWait;
            assert!(planned, "{name}: {stage:?} was not planned");
        }
        let expected = |counter| plan.amounts().counters.iter().find(|entry| entry.0 == counter).map(|entry| entry.1);
        assert_eq!(expected(Counter::Steps), Some(meter.counted(Counter::Steps) as f64), "{name}");
        // No more than are made, and few less: the window is planned from a coarse solution.
        let (slices, made) = (expected(Counter::Slices).unwrap(), meter.counted(Counter::Slices) as f64);
        assert!(slices <= made && made <= 1.1 * slices, "{name}: {slices} slices planned, {made} made");
        // A model that the cache holds is known to the last pole.
        let warm = Plan::of(&loaded).unwrap().with_cached_model();
        if let Some((_, poles)) = warm.amounts().counters.iter().find(|entry| entry.0 == Counter::Poles) {
            assert_eq!(*poles as u64, meter.counted(Counter::Poles), "{name}");
        }
        let solves = expected(Counter::Solves).unwrap_or(0.0);
        let counted = meter.counted(Counter::Solves) as f64;
        assert!(
            (solves - counted).abs() <= 0.5 * solves.max(counted),
            "{name}: {solves} solves planned, {counted} done"
        );
    }
}

#[test]
fn what_is_off_has_no_work_in_the_plan() {
    for (name, loaded) in scenes() {
        let plan = Plan::new(&loaded.scene);
        let has = |stage| plan.amounts().work.iter().any(|amount| amount.stage == stage);
        assert_eq!(has(Stage::Vibration), name.contains("vibration"), "{name}");
        let fits = plan.amounts().work.iter().any(|amount| amount.unit == WorkUnit::Fit);
        assert_eq!(fits, name != "direct", "{name}: only the direct sum does without a fit");
        let factors = plan.amounts().memory.iter().any(|(what, _)| *what == "factors");
        assert_eq!(factors, name != "uncoupled", "{name}");
        assert_eq!(has(Stage::Transforms), !name.starts_with("direct"), "{name}");
        let effects: Vec<_> = decisions(&plan).rows.iter().map(|row| row.effect).collect();
        for effect in ["rotation of the tyre", "texture across the width", "tread coupling", "radiation", "friction"] {
            assert!(effects.contains(&effect), "{effects:?}");
        }
        assert!(decisions(&plan).rows.iter().all(|row| !row.reason.is_empty()), "{name}");
    }
}

#[test]
fn what_road_and_model_cannot_honour_is_said_once() {
    let road = "kind = \"made\"\nspacing = 0.01\nwavelengths = [0.1, 0.08]\nlevels = [46, 46]";
    let numerics = format!("{MODAL}\nfmax = 1000\naccuracy = \"7 dB\"");
    let text = without(&scene_text(64, road, ROLLING, &numerics, ""), &["numerics.elements"]);
    let loaded = scene(&text);
    let run = Simulation::begin(&loaded, &Plan::of(&loaded).unwrap(), &AtomicBool::new(false)).unwrap();
    let found = run.finish();
    let count = |texts: &[String], said: &str| texts.iter().filter(|text| text.contains(said)).count();
    // A road that does not reach the frequency asked for is to be acted on; what was chosen, and what a plate is good
    // for, is to be known.
    let all = [
        ("gives no excitation above", [1, 0]),
        ("flat plate's absolute levels are indicative", [0, 1]),
        ("numerics.elements =", [0, 1]),
    ];
    for (said, expected) in all {
        assert_eq!([&found.warnings, &found.notes].map(|texts| count(texts, said)), expected, "{said}: {found:#?}");
    }
}

fn tyrewave(cache: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let output = Command::new(program()).args(arguments).env("TYREWAVE_CACHE_DIR", cache).output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    (output.status.code(), text)
}

#[test]
fn the_plan_is_a_table_and_json_and_measures_this_machine_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("small.toml");
    std::fs::write(&path, scene_text(64, "kind = \"smooth\"", ROLLING, MODAL, "")).unwrap();
    let path = path.to_str().unwrap();
    let cache = folder.path().join("cache");
    let (code, text) = tyrewave(&cache, &["plan", path]);
    assert_eq!(code, Some(0), "{text}");
    for expected in
        ["rotation of the tyre", "auto: the scene has no [friction]", "convolve the force history", "memory"]
    {
        assert!(text.contains(expected), "{text}");
    }
    let record = std::fs::read(cache.join("calibration.json")).unwrap();
    let (code, text) = tyrewave(&cache, &["plan", path, "--json"]);
    assert_eq!(code, Some(0), "{text}");
    let json: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(json["forecast"]["measured"], Value::Bool(true));
    assert!(json["effects"].as_array().unwrap().len() >= 8);
    assert_eq!(std::fs::read(cache.join("calibration.json")).unwrap(), record, "measured again");
}

/// One of ten scenes: text, edits, and more tables.
type Case = (&'static str, &'static str, &'static [(&'static str, &'static str)], &'static str);

const SHORT: (&str, &str) = ("rolling.duration", "2.0");
const SMOOTH: (&str, &str) = ("road", "{ kind = \"smooth\" }");
const BDF2: (&str, &str) = ("numerics.time_rule", "\"bdf2\"");
const MASS: (&str, &str) = ("rolling.axle", "{ load = 3400.0, mass = 40, stiffness = 2e4, damping = 1500 }");
const CASES: [Case; 10] = [
    ("smooth, no outputs", PLATE, &[SHORT, SMOOTH], "[outputs]\narrays = false\nspectra = false\nplots = false\n"),
    ("smooth, direct", PLATE, &[("rolling.duration", "0.5"), SMOOTH, ("numerics.history", "\"direct\""), BDF2], ""),
    ("default road", PLATE, &[SHORT], ""),
    ("a curved tyre", DEFAULT, &[SHORT], ""),
    ("half-space slices", PLATE, &[SHORT, ("contact.slices", "\"half-space\"")], ""),
    ("N = 1024", PLATE, &[("rolling.duration", "1.5"), ("numerics.elements", "1024")], ""),
    ("a curved tyre, direct", DEFAULT, &[("rolling.duration", "0.5"), ("numerics.history", "\"direct\""), BDF2], ""),
    ("130 km/h", PLATE, &[("rolling.duration", "6.0"), ("rolling.speed_kmh", "130.0")], ""),
    ("mass", PLATE, &[SHORT, MASS], ""),
    (
        "everything",
        PLATE,
        &[SHORT, MASS],
        "[outputs.vibration]\ntangential = true\npoints = [0.3, -0.3]\n\
         elements = [5]\nmap = true\n",
    ),
];

const TENTH: (&str, &str) = ("rolling.duration", "0.3");
const COARSE: (&str, &str) =
    ("numerics", "{ elements = 128, pole_tolerance = 1e-3, history = \"modal\", time_rule = \"sdirk2\" }");
const DIRECT: (&str, &str) =
    ("numerics", "{ elements = 256, memory = 0.25, history = \"direct\", time_rule = \"bdf2\" }");
const TOLERANT: (&str, &str) = ("rolling.axle", "{ load = 3400.0, tolerance = 0.5 }");
const SHORT_CASES: [Case; 10] = [
    ("a fit of a curved tyre", DEFAULT, &[TENTH, COARSE, TOLERANT], ""),
    ("its model from the cache", DEFAULT, &[TENTH, COARSE, TOLERANT, SMOOTH], ""),
    ("a flat tyre", PLATE, &[TENTH, COARSE, TOLERANT], ""),
    ("a direct history on a curved tyre", DEFAULT, &[TENTH, DIRECT, TOLERANT], ""),
    ("a direct history on a flat tyre", PLATE, &[TENTH, DIRECT, TOLERANT], ""),
    ("half-space slices", PLATE, &[TENTH, COARSE, TOLERANT, ("contact.slices", "\"half-space\"")], ""),
    ("a tread without coupling", PLATE, &[TENTH, COARSE, TOLERANT, ("contact", "{ tread = \"uncoupled\" }")], ""),
    (
        "vibration",
        PLATE,
        &[TENTH, COARSE, TOLERANT],
        "[outputs.vibration]\ntangential = true\npoints = [0.3]\nmap = true\n",
    ),
    (
        "sound",
        DEFAULT,
        &[("rolling.duration", "1.0"), COARSE, TOLERANT],
        "[radiation]\nquality = \"draft\"\nfmax = 400.0\n[[receiver]]\nstandard = \"cpx\"\n",
    ),
    ("cells", PLATE, &[TENTH, COARSE, TOLERANT, ("contact", "{ zone = \"cells\", cells_across = 4 }")], ""),
];

/// Runs a scene with a page of its results: planned memory, and the largest that the process took \[bytes\].
#[cfg(target_os = "linux")]
fn memory_planned_and_taken(cache: &Path, arguments: &[&str], target: &Path) -> [f64; 2] {
    let mut command = Command::new(program());
    command.args(arguments).args(["--out", target.to_str().unwrap(), "--report", "-q"]);
    let mut run = command.env("TYREWAVE_CACHE_DIR", cache).spawn().unwrap();
    let mut peak = 0.0;
    let status = loop {
        let status = std::fs::read_to_string(format!("/proc/{}/status", run.id())).unwrap_or_default();
        if let Some(line) = status.lines().find_map(|line| line.strip_prefix("VmHWM:")) {
            peak = 1024.0 * line.trim().trim_end_matches(" kB").parse::<f64>().unwrap();
        }
        if let Some(status) = run.try_wait().unwrap() {
            break status;
        }
        std::thread::sleep(std::time::Duration::from_millis(2));
    };
    assert_eq!(status.code(), Some(0), "{arguments:?}");
    [read_summary(target).pointer("/cost/planned/memory").and_then(Value::as_f64).unwrap(), peak]
}

#[test]
#[cfg(target_os = "linux")]
fn no_run_takes_more_memory_than_is_planned_its_page_included() {
    let folder = tempfile::tempdir().unwrap();
    let (path, target) = (folder.path().join("case.toml"), folder.path().join("results"));
    for (name, text, edits, more) in SHORT_CASES {
        std::fs::write(&path, format!("{}\n{more}", edit(text, edits))).unwrap();
        let cache = folder.path().join("cache");
        let arguments = ["run", path.to_str().unwrap(), "--threads", "2"];
        let [planned, taken] = memory_planned_and_taken(&cache, &arguments, &target);
        println!("{name}: {:.0} MB planned, {:.0} MB taken", 1e-6 * planned, 1e-6 * taken);
        assert!(taken <= planned && planned < 2.5 * taken, "{name}: {planned} planned, {taken} taken");
    }
}

#[test]
#[cfg(target_os = "linux")]
#[ignore = "times whole runs: needs a quiet machine and a release build"]
fn ten_scenes_take_what_their_plans_say_on_one_and_two_threads() {
    let folder = tempfile::tempdir().unwrap();
    let cache = folder.path().join("cache");
    let mut misses = Vec::new();
    println!("| scene | threads | fit | time planned / taken | memory planned / taken |\n|---|---|---|---|---|");
    for (name, text, edits, more) in CASES {
        let text = edit(text, edits);
        let path = folder.path().join("case.toml");
        std::fs::write(&path, format!("{text}\n{more}")).unwrap();
        let path = path.to_str().unwrap();
        let (code, text) = tyrewave(&cache, &["plan", path]);
        assert_eq!(code, Some(0), "{text}");
        for threads in ["1", "2"] {
            for warm in [false, true] {
                if !warm {
                    tyrewave(&cache, &["cache", "clear"]);
                }
                let target = folder.path().join("results");
                let [planned, taken] = memory_planned_and_taken(&cache, &["run", path, "--threads", threads], &target);
                let summary = read_summary(&target);
                let of = |path: &str| summary.pointer(path).and_then(Value::as_f64).unwrap();
                let time = (of("/cost/planned/wall_seconds"), of("/cost/wall_seconds"));
                let memory = (planned, taken);
                let fit = if warm { "kept" } else { "anew" };
                println!(
                    "| {name} | {threads} | {fit} | {:.2} / {:.2} s = {:.2} | {:.0} / {:.0} MB = {:.2} |",
                    time.0,
                    time.1,
                    time.0 / time.1,
                    1e-6 * memory.0,
                    1e-6 * memory.1,
                    memory.0 / memory.1
                );
                // What is said of memory is a bound.
                for (what, (planned, taken), [above, below]) in
                    [("time", time, [1.5, 1.5]), ("memory", memory, [2.0, 1.0])]
                {
                    if planned > above * taken || taken > below * planned {
                        misses.push(format!(
                            "{name}, {threads} threads, fit {fit}: {what} {planned} planned, {taken} taken"
                        ));
                    }
                }
            }
        }
    }
    assert!(misses.is_empty(), "{misses:#?}");
}

#[test]
fn effects_are_compared_in_tables_and_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("small.toml");
    let of = |road: &str| {
        std::fs::write(&path, scene_text(64, road, ROLLING, &format!("{MODAL}\ntime_rule = \"bdf2\""), "")).unwrap();
        let (cache, target) = (folder.path().join("cache"), folder.path().join("results"));
        let arguments = ["effects", path.to_str().unwrap(), "--out", target.to_str().unwrap(), "--duration", "0.3"];
        let (code, text) = tyrewave(&cache, &arguments);
        assert_eq!(code, Some(0), "{text}");
        (text, std::fs::read_to_string(target.join("effects.csv")).unwrap(), target)
    };
    let (text, csv, target) = of("kind = \"made\"\nseed = 3");
    for row in ["+ texture across the width", "- texture across the width", "+ axle motion", "- tread coupling"] {
        assert!(text.contains(row) && csv.contains(row), "{row} is missing\n{text}\n{csv}");
    }
    // None, all, each of eight effects twice, half and twice the local compliance.
    assert_eq!(csv.lines().count(), 1 + 2 + 2 * 7 + 2, "{csv}");
    assert!(text.contains("half the local compliance") && text.contains("known within a factor of two"), "{text}");
    assert!(target.join("effects_added.svg").exists() && target.join("effects_taken_away.svg").exists());
    let (text, csv, _) = of("kind = \"smooth\"");
    assert!(text.contains("texture across the width: not in this scene: a smooth road has no texture"), "{text}");
    assert!(!csv.contains("texture"), "{csv}");
}
