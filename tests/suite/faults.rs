//! Faults that a program meets in the world: messages that cannot be written, places that are taken, limits, kills in
//! the middle of a move. Never a wrong result, never a result lost without need.
#![cfg(unix)]

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use tempfile::TempDir;

use tyrewave::internals::{edit, scene_text};

use crate::common::{command, names, program, read_summary, skipped, tyrewave, write_grid};

const USAGE: i32 = 2;
const NOT_WRITABLE: i32 = 3;
const UNPRINTED: i32 = 4;

/// A short run with a warning and a missed load to report.
fn scene() -> String {
    let rolling = "speed_kmh = 80.0\nwarm_up = 0.05\nduration = 0.1\naxle = { indentation = 0.012, ramp = 0.05 }";
    scene_text(64, "kind = \"smooth\"", rolling, "memory = 0.1", "")
}

fn folder_with(scene: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.toml"), scene).unwrap();
    folder
}

/// A shell command line in the folder; `$1` is the program.
fn shell(folder: &Path, line: &str) -> Output {
    Command::new("sh").args(["-c", line, "sh"]).arg(program()).current_dir(folder).output().unwrap()
}

fn message(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn messages_that_cannot_be_written_lose_no_run() {
    let missed = edit(&scene(), &[("rolling.axle", "{ load = 3400.0, tolerance = 1e-9 }")]);
    let folder = folder_with(&missed);
    fs::write(folder.path().join("wrong.toml"), "nonsense").unwrap();
    fs::write(folder.path().join("met.toml"), scene()).unwrap();
    let pipe = |line: &str| format!("{{ {line} 2>&1 >/dev/null; echo $? >code; }} | true; cat code; exit $(cat code)");
    for to in ["2>/dev/full", "2>&-", "| closed"] {
        if to == "2>/dev/full" && !Path::new("/dev/full").exists() {
            skipped("no /dev/full");
            continue;
        }
        let run = |line: &str| match to {
            // The reader is gone before the program says a word.
            "| closed" => shell(folder.path(), &pipe(&format!("sleep 0.2; \"$1\" {line}"))),
            _ => shell(folder.path(), &format!("\"$1\" {line} {to}")),
        };
        for (line, code) in [("run scene.toml --out out", 1), ("run wrong.toml", USAGE), ("walk", USAGE)] {
            let output = run(line);
            assert_eq!(output.status.code(), Some(code), "{to} {line}: {}", message(&output));
        }
        assert_eq!(read_summary(&folder.path().join("out"))["complete"], true, "{to}");
        fs::remove_dir_all(folder.path().join("out")).unwrap();
    }
    // Results that are complete are said to be so where the answer cannot be printed.
    if Path::new("/dev/full").exists() {
        for json in ["", " --json"] {
            let output = shell(folder.path(), &format!("\"$1\" run met.toml --out out{json} >/dev/full"));
            assert_eq!(output.status.code(), Some(UNPRINTED), "{}", message(&output));
            assert!(message(&output).contains("the results are complete, in out"), "{}", message(&output));
            assert_eq!(read_summary(&folder.path().join("out"))["complete"], true);
        }
    }
    // What was asked for and cannot be said is an error, whoever says it.
    for line in ["--help", "keys", "cache list"].iter().filter(|_| Path::new("/dev/full").exists()) {
        let output = shell(folder.path(), &format!("\"$1\" {line} >/dev/full"));
        assert_eq!(output.status.code(), Some(NOT_WRITABLE), "{line}: {}", message(&output));
    }
}

#[test]
fn an_output_file_replaces_earlier_ones_of_its_kind_only() {
    let folder = folder_with(&scene());
    let place = folder.path();
    fs::write(place.join("notes.txt"), "precious").unwrap();
    std::os::unix::fs::symlink("notes.txt", place.join("link")).unwrap();
    let before = names(place);
    let scene_before = fs::read(place.join("scene.toml")).unwrap();
    for option in ["--trace", "--folded"] {
        for wrong in ["scene.toml", "notes.txt", "link", "/dev/null", "/dev/full", "."] {
            let output = tyrewave(place, &["run", "scene.toml", option, wrong]);
            assert_eq!(output.status.code(), Some(USAGE), "{option} {wrong}: {}", message(&output));
            assert!(message(&output).contains("left alone"), "{}", message(&output));
        }
    }
    fs::create_dir(place.join("roads")).unwrap();
    fs::write(place.join("roads/sweep.csv"), "x,z\n0,0\n1e-3,0\n").unwrap();
    let line = ["sweep", "scene.toml", "--speed", "80", "--road", "roads/sweep.csv", "--out", "roads"];
    let sweep = tyrewave(place, &line);
    assert_eq!(sweep.status.code(), Some(USAGE), "{}", message(&sweep));
    assert!(message(&sweep).contains("is an input"), "{}", message(&sweep));
    fs::remove_dir_all(place.join("roads")).unwrap();
    let both = tyrewave(place, &["run", "scene.toml", "--trace", "one", "--folded", "./one"]);
    assert_eq!(both.status.code(), Some(USAGE), "{}", message(&both));
    assert_eq!(names(place), before, "something was written");
    assert_eq!(fs::read(place.join("scene.toml")).unwrap(), scene_before);
    assert_eq!(fs::read(place.join("notes.txt")).unwrap(), b"precious");
    for _ in 0..2 {
        let output = tyrewave(place, &["run", "scene.toml", "--trace", "trace.json", "--folded", "stacks.txt"]);
        assert!(output.status.success(), "{}", message(&output));
    }
}

#[test]
fn indent_names_the_heights_and_never_replaces_them() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    let mut heights: Vec<f64> = (0..64).map(|cell| 1e-4 * f64::from(cell % 7)).collect();
    write_grid(&place.join("heights.npy"), 8, &heights);
    heights[9] = f64::NAN;
    write_grid(&place.join("holes.npy"), 8, &heights);
    let before = fs::read(place.join("heights.npy")).unwrap();
    let indent = |file: &str, more: &[&str]| {
        let line = ["indent", "--dx", "1e-3", "--dy", "1e-3", "--modulus", "1e7", "--poisson", "0.4"];
        tyrewave(place, &[&line[..], &["--penetration", "1e-4", "--heights", file], more].concat())
    };
    let output = indent("holes.npy", &[]);
    assert_eq!(output.status.code(), Some(USAGE), "{}", message(&output));
    assert!(message(&output).contains("holes.npy: height NaN in row 1"), "{}", message(&output));
    for (arguments, code) in [
        (&["--out", "heights.npy"][..], USAGE),
        (&["--out", "heights.npy", "--force"], USAGE),
        (&["--out", "pressure.npy"], 0),
        (&["--out", "pressure.npy"], USAGE),
        (&["--out", "pressure.npy", "--force"], 0),
    ] {
        let output = indent("heights.npy", arguments);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {}", message(&output));
    }
    assert_eq!(fs::read(place.join("heights.npy")).unwrap(), before);
    assert_eq!(names(place), ["heights.npy", "holes.npy", "pressure.npy"]);
}

#[test]
fn the_environment_starts_no_thousands_of_threads() {
    let folder = folder_with(&scene());
    let mut run = command(folder.path(), &["run", "scene.toml"]);
    let output = run.env("RAYON_NUM_THREADS", "100000").output().unwrap();
    assert_eq!(output.status.code(), Some(USAGE), "{}", message(&output));
    assert!(message(&output).contains("RAYON_NUM_THREADS is 100000"), "{}", message(&output));
    let mut run = command(folder.path(), &["run", "scene.toml", "--threads", "1"]);
    assert!(run.env("RAYON_NUM_THREADS", "100000").output().unwrap().status.success());
}

#[test]
fn a_limit_on_files_is_treated_as_a_full_disk() {
    let long = edit(&scene(), &[("rolling.duration", "6.0")]) + "[outputs]\ncheckpoint_interval = 0.001\n";
    let folder = folder_with(&long);
    let place = folder.path();
    assert!(tyrewave(place, &["run", "scene.toml", "--out", "whole"]).status.success());
    let blocks = fs::metadata(place.join("whole/patch_force.npy")).unwrap().len() / 512 / 2;
    let output = shell(place, &format!("ulimit -f {blocks}; \"$1\" run scene.toml --out cut"));
    assert_eq!(output.status.code(), Some(NOT_WRITABLE), "{}", message(&output));
    assert!(message(&output).contains("tyrewave resume cut.partial"), "{}", message(&output));
    let output = tyrewave(place, &["resume", "cut"]);
    assert!(output.status.success(), "{}", message(&output));
    for name in names(&place.join("whole")).iter().filter(|name| name.ends_with(".npy")) {
        assert!(fs::read(place.join("whole").join(name)).unwrap() == fs::read(place.join("cut").join(name)).unwrap());
    }
}

#[test]
fn a_run_killed_while_it_was_renamed_is_repaired() {
    let folder = folder_with(&scene());
    let place = folder.path();
    let run = |out: &str| {
        let output = tyrewave(place, &["run", "scene.toml", "--out", out]);
        assert!(output.status.success(), "{}", message(&output));
    };
    let force = |out: &str| fs::read(place.join(out).join("total_force.npy")).unwrap();
    let killed_before_its_name = || {
        fs::rename(place.join("new"), place.join("out.partial-7")).unwrap();
        fs::write(place.join("out.partial-7/lock"), "out.partial-7").unwrap();
    };
    run("new");
    let new = force("new");
    let older = edit(&scene(), &[("rolling.axle.indentation", "0.011")]);
    // Stepped aside: nothing has the name.
    killed_before_its_name();
    fs::write(place.join("scene.toml"), &older).unwrap();
    run("old");
    fs::rename(place.join("old"), place.join("out.partial-7-old")).unwrap();
    let output = tyrewave(place, &["resume", "out"]);
    assert!(output.status.success(), "{}", message(&output));
    assert!(String::from_utf8_lossy(&output.stdout).contains("the run was complete"));
    assert_eq!((names(place), force("out") == new), (vec!["out".to_owned(), "scene.toml".to_owned()], true));
    // Names exchanged, the older results still there: the next run clears them away.
    run("out.partial-8");
    fs::write(place.join("out/lock"), "out.partial-8").unwrap();
    run("out");
    assert_eq!((names(place), force("out") == new), (vec!["out".to_owned(), "scene.toml".to_owned()], false));
    let output = tyrewave(place, &["resume", "out"]);
    assert_eq!(output.status.code(), Some(USAGE), "{}", message(&output));
    assert!(message(&output).contains("out is complete"), "{}", message(&output));
}
