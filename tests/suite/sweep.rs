//! A sweep from its command line to its table, and again.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use std::thread::sleep;
use std::time::Duration;

use tyrewave::internals::{add, edit, implausible, replaced, scene_text, without};

use crate::common::{TREAD_MAP, command, read_summary, write_tread_map};

const ROAD: &str = "kind = \"made\"\nseed = 4\nspacing = 0.01\nwavelengths = [0.2, 0.16, 0.125, 0.1, 0.08]\n\
    levels = [46.0, 46.0, 46.0, 46.0, 46.0]";

fn scene(duration: f64) -> String {
    within(duration, 0.05)
}

/// A scene whose load may be missed by so much.
fn within(duration: f64, tolerance: f64) -> String {
    let axle = format!("axle = {{ load = 3000.0, tolerance = {tolerance:?} }}");
    let rolling = format!("speed_kmh = 80.0\nwarm_up = 0.2\nduration = {duration:?}\n{axle}");
    scene_text(64, ROAD, &rolling, "history = \"modal\"", "[outputs]\ncheckpoint_interval = 0.002")
}

fn sweep(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = command(folder, &["sweep"]);
    command.args(arguments);
    command
}

fn output(folder: &Path, arguments: &[&str]) -> Output {
    sweep(folder, arguments).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Levels by group, nominal frequency and speed, and growth by group and frequency, from `sweep.csv`.
type Levels = BTreeMap<(String, String, String), f64>;

fn table(path: &Path) -> (Levels, BTreeMap<(String, String), f64>) {
    let mut reader = csv::Reader::from_path(path).unwrap();
    let (mut levels, mut growths) = (BTreeMap::new(), BTreeMap::new());
    for row in reader.records().map(Result::unwrap) {
        levels.insert((row[0].into(), row[1].into(), row[3].into()), row[4].parse().unwrap());
        if let Ok(growth) = row[5].parse() {
            growths.insert((row[0].into(), row[1].into()), growth);
        }
    }
    (levels, growths)
}

#[test]
fn a_sweep_makes_one_table_and_again_runs_only_what_is_missing() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    fs::write(place.join("scene.toml"), scene(0.8)).unwrap();
    fs::write(place.join("smooth.toml"), "kind = \"smooth\"").unwrap();
    fs::write(place.join("rough.toml"), edit(ROAD, &[("levels", "[50.0, 50.0, 50.0, 50.0, 50.0]")])).unwrap();
    let arguments = [
        "scene.toml",
        "--speed",
        "40..80:40",
        "--load",
        "2500,3000",
        "--road",
        "rough.toml",
        "--out",
        "s",
        "--threads",
        "2",
    ];
    let first = output(place, &arguments);
    assert!(first.status.success(), "{}", text(&first.stderr));
    assert!(text(&first.stdout).contains("4 variants, 0 of them finished before"), "{}", text(&first.stdout));
    for name in ["sweep.csv", "sweep.txt", "growth.svg", "levels.svg", "rough-2500N-40kmh/spectra.csv"] {
        assert!(place.join("s").join(name).is_file(), "{name}");
    }
    let (levels, growths) = table(&place.join("s/sweep.csv"));
    // The table's levels are those of the runs, and the growth that of two points.
    let mut reader = csv::Reader::from_path(place.join("s/rough-3000N-80kmh/spectra.csv")).unwrap();
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    assert!(rows.len() > 10);
    for row in rows {
        let key = ("rough, 3000 N".to_owned(), row[0].to_owned(), "80".to_owned());
        assert_eq!(levels[&key].to_bits(), row[5].parse::<f64>().unwrap().to_bits());
        let slower = levels.get(&(key.0.clone(), key.1.clone(), "40".to_owned()));
        match slower {
            Some(slower) => {
                let exact = (levels[&key] - slower) / 2.0_f64.log10();
                assert!((growths[&(key.0, key.1)] - exact).abs() < 1e-9 * exact.abs().max(1.0));
            }
            None => assert!(!growths.contains_key(&(key.0, key.1)), "one speed reaches the band"),
        }
    }
    let mean = read_summary(&place.join("s/rough-2500N-40kmh"))["outcome"]["mean_force"].as_f64().unwrap();
    assert!((mean / 2500.0 - 1.0).abs() < 0.05, "{mean}");

    // Again: nothing runs. With one variant gone, another changed by hand, and one speed more: only those.
    let csv = fs::read(place.join("s/sweep.csv")).unwrap();
    let again = output(place, &arguments);
    assert!(text(&again.stdout).contains("4 variants, 4 of them finished before"), "{}", text(&again.stdout));
    assert_eq!(fs::read(place.join("s/sweep.csv")).unwrap(), csv);
    fs::remove_dir_all(place.join("s/rough-2500N-40kmh")).unwrap();
    let summary = place.join("s/rough-3000N-40kmh/summary.json");
    let written = fs::read_to_string(&summary).unwrap();
    fs::write(&summary, replaced(&written, &[("\"version\": \"", "\"version\": \"0")])).unwrap();
    let more = output(place, &arguments.map(|argument| if argument == "40..80:40" { "40..80:20" } else { argument }));
    assert!(text(&more.stdout).contains("6 variants, 2 of them finished before"), "{}", text(&more.stdout));
    let (now, _) = table(&place.join("s/sweep.csv"));
    assert!(levels.iter().all(|(key, level)| now[key].to_bits() == level.to_bits()), "made again, the same bits");
}

#[test]
fn a_variant_whose_input_file_has_changed_is_run_again() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    fs::write(place.join("scene.toml"), edit(&scene(0.1), &[("numerics.history", "\"direct\"")]) + TREAD_MAP).unwrap();
    let map = place.join("map.npy");
    let found = |depth: f64| {
        write_tread_map(&map, depth);
        // As old as any file may be: only its content counts.
        fs::File::options().append(true).open(&map).unwrap().set_modified(std::time::UNIX_EPOCH).unwrap();
        let output = output(place, &["scene.toml", "--speed", "60,80", "--out", "s"]);
        let reported = text(&output.stdout);
        let count = reported.split("2 variants, ").nth(1).and_then(|rest| rest.chars().next());
        count.unwrap_or_else(|| panic!("{reported}{}", text(&output.stderr)))
    };
    assert_eq!([0.008, 0.008, 0.007, 0.007, 0.008].map(found), ['0', '2', '0', '2', '0']);
    let summary = read_summary(&place.join("s/80kmh"));
    assert!(summary["inputs"][0]["file"].as_str().unwrap().ends_with("map.npy"), "{}", summary["inputs"]);
}

#[test]
fn a_missed_load_is_marked_and_reported_once() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    fs::write(place.join("scene.toml"), within(0.3, 1e-9)).unwrap();
    for _ in 0..2 {
        let missed = output(place, &["scene.toml", "--speed", "80", "--out", "s", "-q"]);
        let (table, message) = (text(&missed.stdout), text(&missed.stderr));
        assert_eq!(missed.status.code(), Some(1), "{message}");
        assert!(message.contains("1 of 1 variants missed their load") && message.contains("80kmh"), "{message}");
        assert_eq!((table + &message).matches("off the load of").count(), 1, "{message}");
        assert!(fs::read_to_string(place.join("s/sweep.txt")).unwrap().contains("80 km/h *"));
        assert!(place.join("s/80kmh/summary.json").exists());
    }
}

#[test]
fn notes_that_all_variants_share_are_reported_once() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    let chosen = add(&scene(0.3), "numerics", "preset = \"draft\"\nfmax = 150.0");
    fs::write(place.join("scene.toml"), without(&chosen, &["numerics.elements"])).unwrap();
    let count = |reported: &str, word: &str| reported.lines().filter(|line| line.contains(word)).count();
    let varied = ["--set", "road.seed=1..3", "--speed", "60,80"];
    let swept = output(place, &[&["scene.toml", "--out", "s", "--threads", "1"], &varied[..]].concat());
    let reported = text(&swept.stderr);
    assert!(swept.status.success(), "{reported}");
    // Poles are the same at every speed, steps in a period are not.
    assert_eq!(count(&reported, "numerics.pole_tolerance = "), 1, "{reported}");
    assert_eq!(count(&reported, "kmh: numerics.pole_tolerance"), 0, "{reported}");
    assert_eq!(count(&reported, "kmh: numerics.substeps = "), 6, "{reported}");
    let summary = read_summary(&place.join("s/seed=1-60kmh"));
    let has = |key: &str| summary[key].to_string().contains("numerics.pole_tolerance = ");
    assert_eq!([has("notes"), has("warnings")], [true, false], "{summary:#}");
    // Tasks are done by themselves, and reported together.
    assert!(output(place, &[&["scene.toml", "--tasks", "t"], &varied[..]].concat()).status.success());
    let worked = output(place, &["--task", "t", "0..5", "--threads", "1"]);
    assert_eq!(count(&text(&worked.stdout), "numerics.pole_tolerance = "), 1, "{}", text(&worked.stdout));
}

#[test]
#[cfg(unix)]
fn a_killed_sweep_continues_from_its_checkpoints() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    fs::write(place.join("scene.toml"), scene(40.0)).unwrap();
    let arguments = |out| ["scene.toml", "--speed", "60,80", "--out", out, "--threads", "2"];
    let whole = output(place, &arguments("whole"));
    assert!(whole.status.success(), "{}", text(&whole.stderr));
    for signal in ["-KILL", "-INT"] {
        let mut run = sweep(place, &arguments("cut")).spawn().unwrap();
        let checkpoints = || {
            let entries = fs::read_dir(place.join("cut")).into_iter().flatten();
            entries.filter(|entry| entry.as_ref().unwrap().path().join("checkpoint").exists()).count()
        };
        while checkpoints() < 2 && run.try_wait().unwrap().is_none() {
            sleep(Duration::from_millis(1));
        }
        sleep(Duration::from_millis(30));
        assert!(Command::new("kill").args([signal, &run.id().to_string()]).status().unwrap().success());
        let stopped = run.wait_with_output().unwrap();
        assert!(!stopped.status.success(), "it was too fast to be stopped");
        assert!(signal == "-KILL" || stopped.status.code() == Some(130), "{}", text(&stopped.stderr));
    }
    let last = output(place, &arguments("cut"));
    assert!(last.status.success(), "{}", text(&last.stderr));
    for name in ["sweep.csv", "sweep.txt", "60kmh/total_force.npy", "80kmh/patch_force.npy", "80kmh/spectra.csv"] {
        assert!(
            fs::read(place.join("whole").join(name)).unwrap() == fs::read(place.join("cut").join(name)).unwrap(),
            "{name}"
        );
    }
    let names: Vec<_> = fs::read_dir(place.join("cut")).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert!(names.iter().all(|name| !name.to_string_lossy().contains("partial")), "{names:?}");
}

#[test]
fn what_cannot_be_swept_is_answered_before_anything_runs() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    fs::write(place.join("scene.toml"), scene(0.1)).unwrap();
    for (arguments, word) in [
        (&["scene.toml", "--speed", "80..50:10"][..], "before it begins"),
        (&["scene.toml", "--speed", "50..80"], "FROM..TO:STEP"),
        (&["scene.toml"], "--speed"),
        (&["scene.toml", "--speed", "80", "--road", "nowhere.dat"], "nowhere.dat"),
        (&["nowhere.toml", "--speed", "80"], "nowhere.toml"),
    ] {
        let refused = output(place, arguments);
        assert_eq!(refused.status.code(), Some(2), "{}", text(&refused.stderr));
        assert!(text(&refused.stderr).contains(word), "{}", text(&refused.stderr));
        assert!(!place.join("results").exists());
    }
    // A variant that fails leaves the others alone.
    fs::write(place.join("scene.toml"), implausible(&scene(0.1))).unwrap();
    let failing = output(place, &["scene.toml", "--speed", "80", "--load", "3000,1e9", "--out", "s"]);
    let message = text(&failing.stderr);
    assert_eq!(failing.status.code(), Some(1), "{message}");
    assert!(message.contains("rolling.axle.load: no axle height carries") && message.contains("1 of 2"), "{message}");
    assert!(place.join("s/3000N-80kmh/summary.json").exists() && place.join("s/sweep.csv").exists());
}

#[test]
fn settings_are_varied_and_seeds_averaged_with_their_confidence() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    fs::write(place.join("scene.toml"), scene(0.6)).unwrap();
    let arguments =
        ["scene.toml", "--out", "s", "--set", "road.seed=1..3", "--set", "contact.tread=elastic,bedding", "--set"];
    let with = |setting: &'static str| [&arguments[..], &[setting]].concat();
    let made = output(place, &with("outputs.plots=true"));
    assert!(made.status.success(), "{}", text(&made.stderr));
    let reported = text(&made.stdout);
    assert!(
        reported.contains("6 variants") && reported.contains("means over seeds") && reported.contains("+-"),
        "{reported}"
    );
    let mut reader = csv::Reader::from_path(place.join("s/design.csv")).unwrap();
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    let overall: Vec<_> = rows.iter().filter(|row| &row[1] == "force, all bands").collect();
    assert_eq!((overall.len(), &overall[0][0], &overall[1][0], &overall[0][3]), (2, "elastic", "bedding", "3"));
    // The mean of one band is that of the three runs.
    let band = rows.iter().find(|row| &row[0] == "bedding" && row[1].contains("125 Hz")).unwrap();
    let (levels, _) = table(&place.join("s/sweep.csv"));
    let level = |seed: u32| levels[&(format!("seed={seed}, tread=bedding"), "125".to_owned(), "80".to_owned())];
    let mean = (level(1) + level(2) + level(3)) / 3.0;
    assert!((band[4].parse::<f64>().unwrap() - mean).abs() < 1e-12, "{band:?}: {mean}");
    let json: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(place.join("s/design.json")).unwrap()).unwrap();
    assert_eq!(json.as_array().unwrap().len(), rows.len());
    assert_eq!(json[0]["factors"]["contact.tread"], "elastic");
    assert!(fs::read_to_string(place.join("s/force_by_contact_tread.svg")).unwrap().contains("bedding"));

    // As tasks it is the same.
    let tasks = [&["scene.toml", "--tasks", "t"], &arguments[3..], &["outputs.plots=true"]].concat();
    assert!(output(place, &tasks).status.success());
    assert!(output(place, &["--task", "t", "0..5"]).status.success());
    let collected = output(place, &["--collect", "t"]);
    assert!(collected.status.success(), "{}", text(&collected.stderr));
    for name in ["design.csv", "design.json", "sweep.csv", "sweep.txt", "force_by_contact_tread.svg"] {
        assert_eq!(
            fs::read(place.join("t").join(name)).unwrap(),
            fs::read(place.join("s").join(name)).unwrap(),
            "{name}"
        );
    }
    let both = output(place, &["--task", "t", "0", "--set", "road.seed=1..2"]);
    assert!(both.status.code() == Some(2) && text(&both.stderr).contains("cannot be used with"));

    let refused = |arguments: &[&str], word: &str| {
        let answer = output(place, arguments);
        let reported = text(&answer.stderr);
        assert!(answer.status.code() == Some(2) && reported.contains(word), "{arguments:?}: {reported}");
    };
    refused(&["scene.toml"], "nothing is varied");
    refused(&with("contact.tred=elastic,bedding"), "tread");
    refused(&with("rolling.speed_kmh=80..50:10"), "before it begins");
    refused(&with("rolling.speed_kmh=50.0..80.5"), "needs steps");
    refused(&with("road.seed=1,2"), "given twice");
    for speeds in ["rolling.speed_kmh=50,80", "rolling.speed_kmh=70"] {
        refused(&[&with(speeds)[..], &["--speed", "50"]].concat(), "the same");
    }
    refused(&[&with("rolling.axle.load=3000")[..], &["--load", "3400"]].concat(), "the same");
    refused(&["scene.toml", "--latin-hypercube", "4", "--speed", "50"], "beside seeds");
}

#[test]
fn a_latin_hypercube_is_run_at_its_points() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    fs::write(place.join("scene.toml"), within(0.4, 0.5)).unwrap();
    let arguments = [
        "scene.toml",
        "--out",
        "s",
        "--latin-hypercube",
        "3",
        "--design-seed",
        "5",
        "--set",
        "rolling.speed_kmh=50.0..80",
        "--set",
        "rolling.axle.load=2500.0..3500",
    ];
    let made = output(place, &arguments);
    assert!(made.status.success(), "{}", text(&made.stderr));
    let mut reader = csv::Reader::from_path(place.join("s/design.csv")).unwrap();
    assert_eq!(reader.headers().unwrap().iter().take(2).collect::<Vec<_>>(), ["rolling.axle.load", "speed km/h"]);
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    let mut speeds: Vec<f64> = rows.iter().map(|row| row[1].parse().unwrap()).collect();
    speeds.sort_by(f64::total_cmp);
    speeds.dedup();
    let parts: Vec<i32> = speeds.iter().map(|speed| ((speed - 50.0) / 10.0).floor() as i32).collect();
    assert_eq!(parts, [0, 1, 2], "{speeds:?}");
    for name in fs::read_dir(place.join("s")).unwrap().map(|entry| entry.unwrap().path()).filter(|path| path.is_dir()) {
        let wanted = read_summary(&name)["outcome"]["load"]["wanted"].as_f64().unwrap();
        assert!(name.file_name().unwrap().to_string_lossy().contains(&format!("load={wanted}")), "{}", name.display());
    }
}

#[test]
fn an_uncertain_road_is_rolled_at_its_corners() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    fs::write(place.join("scene.toml"), scene(0.6)).unwrap();
    let arguments = ["scene.toml", "--road-uncertainty", "--out", "s"];
    let refused = output(place, &arguments);
    assert!(refused.status.code() == Some(2) && text(&refused.stderr).contains("dac-11"), "{}", text(&refused.stderr));
    let named = scene(0.6).replace(ROAD, "kind = \"made\"\nseed = 4\ntexture = \"dac-11\"");
    fs::write(place.join("scene.toml"), named).unwrap();
    let made = output(place, &arguments);
    assert!(made.status.success(), "{}", text(&made.stderr));
    assert!(text(&made.stdout).contains("9 variants") && text(&made.stdout).contains("road as stated"));
    let mut reader = csv::Reader::from_path(place.join("s/road_uncertainty.csv")).unwrap();
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    let row = rows.iter().find(|row| &row[0] == "force, 125 Hz").unwrap();
    let [stated, lowest, highest] = [2, 3, 4].map(|column| row[column].parse::<f64>().unwrap());
    let (levels, _) = table(&place.join("s/sweep.csv"));
    let level = |corner: &str| levels[&(corner.to_owned(), "125".to_owned(), "80".to_owned())];
    assert!((stated - level("offset=0, skewness=-1")).abs() < 1e-12);
    assert!(lowest <= level("offset=-3, skewness=-1.85") && lowest < stated);
    assert!(highest >= level("offset=3, skewness=0") && highest > stated);
}
