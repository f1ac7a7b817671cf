//! Bad input through the program: a clear message, the documented exit code, and nothing written.

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use tyrewave::internals::{COBBLES, edit, reference, scene_text, with_all_terms, without};

use crate::common::{folder_with, names, program, read_array, read_summary, skipped, tyrewave};

const USAGE: i32 = 2;
const NOT_WRITABLE: i32 = 3;
const INTERRUPTED: i32 = 130;

const ROLLING: &str = "speed_kmh = 80.0\nwarm_up = 0.05\nduration = 0.1\naxle = { indentation = 0.012, ramp = 0.05 }";

/// A short scene that works.
fn good() -> String {
    scene_text(64, "kind = \"smooth\"", ROLLING, "memory = 0.1", "")
}

fn with_road(road: &str) -> String {
    scene_text(64, road, ROLLING, "memory = 0.1", "")
}

#[test]
fn a_missed_load_keeps_its_results_and_is_no_success() {
    let missed = |tolerance: &str| {
        let axle = format!("{{ load = 3400.0, tolerance = {tolerance} }}");
        let folder = folder_with(&edit(&with_road("kind = \"made\""), &[("rolling.axle", &axle)]));
        let output = tyrewave(folder.path(), &["run", "scene.toml"]);
        let complete = read_summary(&folder.path().join("results/scene"))["complete"] == true;
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned(), complete)
    };
    let (code, message, complete) = missed("1e-9");
    assert_eq!((code, complete), (Some(1), true), "{message}");
    for word in ["off the load of 3400 N", "results/scene", "warm_up", "tolerance = 0"] {
        assert!(message.contains(word), "{word}: {message}");
    }
    let (code, message, complete) = missed("0.5");
    assert_eq!((code, complete), (Some(0), true), "{message}");
}

/// Runs `scene.toml` in the folder: it must end with the code, say all the words, and leave the folder as it was.
fn assert_refused(folder: &Path, code: i32, words: &[&str]) {
    let before = names(folder);
    let output = tyrewave(folder, &["run", "scene.toml"]);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{message}");
    for word in words {
        assert!(message.contains(word), "\"{word}\" is not in:\n{message}");
    }
    assert!(!message.contains("panicked"), "{message}");
    assert_eq!(names(folder), before, "something was written; {message}");
    assert!(output.stdout.is_empty());
}

/// The number of the line that holds a text.
fn line_of(scene: &str, text: &str) -> String {
    let line = scene.lines().position(|line| line.contains(text)).unwrap() + 1;
    format!("scene.toml:{line}:")
}

/// The good scene with `old` replaced: it must be refused with the line of `new`, and the words.
fn assert_replaced_is_refused(old: &str, new: &str, words: &[&str]) {
    let scene = good();
    assert!(scene.contains(old), "{old}");
    let scene = scene.replacen(old, new, 1);
    let line = line_of(&scene, new);
    let mut all = vec![line.as_str()];
    all.extend(words);
    assert_refused(folder_with(&scene).path(), USAGE, &all);
}

#[test]
fn the_good_scene_is_good() {
    let folder = folder_with(&good());
    let output = tyrewave(folder.path(), &["run", "scene.toml"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(names(folder.path()), ["results", "scene.toml"]);
    assert_eq!(read_summary(&folder.path().join("results/scene"))["complete"], true);
}

#[test]
fn an_unknown_key() {
    assert_replaced_is_refused("memory = 0.1", "memry = 0.1", &["memry", "did you mean `memory`?"]);
}

#[test]
fn a_negative_thickness() {
    assert_replaced_is_refused(
        "thickness = 0.013",
        "thickness = -0.013",
        &["tyre.layers[1].thickness", "-0.013", "above 0"],
    );
}

#[test]
fn a_poisson_ratio_of_one_half() {
    assert_replaced_is_refused("poisson = 0.49", "poisson = 0.5", &["poisson", "below 0.5"]);
}

#[test]
fn a_number_that_is_none() {
    assert_replaced_is_refused("duration = 0.1", "duration = nan", &["rolling.duration", "NaN", "finite"]);
    assert_replaced_is_refused("speed_kmh = 80.0", "speed_kmh = inf", &["rolling.speed_kmh", "finite"]);
}

#[test]
fn a_billion_elements() {
    let begin = Instant::now();
    assert_replaced_is_refused(
        "elements = 64",
        "elements = 1000000000",
        &["numerics.elements", "1000000000 is too large", "at most 1000000"],
    );
    assert!(begin.elapsed() < Duration::from_secs(20), "it was tried");
}

#[test]
fn a_law_that_is_not_causal() {
    let scene = edit(&good(), &[("tyre.layers.1.material.law", "\"hysteretic\"")]);
    let line = line_of(&scene, "hysteretic");
    let words = [line.as_str(), "tyre.layers[1].material.law", "not causal", "power-law", "prony"];
    assert_refused(folder_with(&scene).path(), USAGE, &words);
}

#[test]
fn missing_files() {
    let scene = with_road("kind = \"profile\"\nfile = \"nowhere.dat\"");
    let line = line_of(&scene, "file =");
    assert_refused(folder_with(&scene).path(), USAGE, &["road.file", "nowhere.dat", &line]);
    let empty = tempfile::tempdir().unwrap();
    assert_refused(empty.path(), USAGE, &["scene.toml"]);
    let scene = format!("tyre = \"nowhere.toml\"\n{}", without(&good(), &["tyre"]));
    assert_refused(folder_with(&scene).path(), USAGE, &["scene.toml:1:", "tyre", "nowhere.toml"]);
}

/// A level OpenCRG road in text form, 1 m x 0.2 m on 1 cm, of `rows` rows.
fn small_crg(rows: usize) -> String {
    let mut text = String::from(
        "$CT\nsmall\n$\n$ROAD_CRG\nreference_line_start_u = 0.0\nreference_line_end_u = 20.0\n\
         reference_line_increment = 0.01\nlong_section_v_right = -0.1\nlong_section_v_left = 0.1\n\
         long_section_v_increment = 0.1\n$\n$KD_DEFINITION\n#:LRFI\nD:long section 1,m\nD:long section 2,m\n\
         D:long section 3,m\n$\n$$$$\n",
    );
    for row in 0..rows {
        let height = 1e-3 * (row % 10) as f64;
        text.push_str(&format!("{height:10.7}{height:10.7}{height:10.7}\n"));
    }
    text
}

#[test]
fn a_truncated_opencrg_file() {
    let scene = with_road("kind = \"opencrg\"\nfile = \"road.crg\"");
    let folder = folder_with(&scene);
    fs::write(folder.path().join("road.crg"), small_crg(2001)).unwrap();
    let output = tyrewave(folder.path(), &["run", "scene.toml", "--out", "whole"]);
    assert!(output.status.success(), "the whole file is good: {}", String::from_utf8_lossy(&output.stderr));
    fs::remove_dir_all(folder.path().join("whole")).unwrap();
    fs::write(folder.path().join("road.crg"), small_crg(1500)).unwrap();
    assert_refused(folder.path(), USAGE, &["road.file", "road.crg", &line_of(&scene, "file ="), "1500", "2001"]);
}

#[test]
fn the_damaged_belgian_block() {
    let scene = with_road("kind = \"opencrg\"\nfile = \"belgian_block_damaged.crg\"");
    let folder = folder_with(&scene);
    // As a transfer as text leaves it: a byte of the heights is lost.
    let mut damaged = fs::read(reference(COBBLES)).unwrap();
    let place = damaged.windows(2).rposition(|pair| pair == b"\r\n").unwrap();
    damaged.remove(place);
    fs::write(folder.path().join("belgian_block_damaged.crg"), damaged).unwrap();
    assert_refused(folder.path(), USAGE, &["road.file", "belgian_block_damaged.crg", &line_of(&scene, "file =")]);
}

#[test]
fn profiles_without_numbers() {
    let scene = with_road("kind = \"profile\"\nfile = \"road.csv\"\ndistance_unit = \"mm\"\nheight_unit = \"mm\"");
    let line = line_of(&scene, "file =");
    let folder = folder_with(&scene);
    let profile = folder.path().join("road.csv");
    fs::write(&profile, "").unwrap();
    assert_refused(folder.path(), USAGE, &["road.file", "road.csv", "0 usable points", &line]);
    fs::write(&profile, "x,z\n0,0.1\n1,rough\n2,0.2\n").unwrap();
    assert_refused(folder.path(), USAGE, &["road.file", "road.csv", "line 3", "\"rough\" is not a number", &line]);
    fs::write(&profile, "# exported\nx,z\n\n0,0.1\n\n# next\n1,rough\n2,0.2\n").unwrap();
    assert_refused(folder.path(), USAGE, &["road.file", "road.csv", "line 7", "\"rough\" is not a number", &line]);
    // Without a scene there is no place in one.
    let output = tyrewave(folder.path(), &["road", "road.csv", "--distance-unit", "mm", "--height-unit", "mm"]);
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(USAGE), "{message}");
    assert!(message.contains("line 7") && message.contains("road.csv") && !message.contains("80kmh"), "{message}");
}

#[test]
fn a_road_shorter_than_the_run() {
    let scene = with_road("kind = \"profile\"\nfile = \"road.csv\"\ndistance_unit = \"mm\"\nheight_unit = \"mm\"");
    let folder = folder_with(&scene);
    let rows: Vec<String> = (0..1500).map(|i| format!("{i},{}", 0.1 * f64::from(i % 7))).collect();
    fs::write(folder.path().join("road.csv"), format!("x,z\n{}\n", rows.join("\n"))).unwrap();
    assert_refused(folder.path(), USAGE, &["rolling.duration", "1.499 m", "at_end", &line_of(&scene, "duration =")]);
}

#[test]
fn results_that_cannot_be_written() {
    let folder = folder_with(&good());
    fs::write(folder.path().join("file"), "").unwrap();
    let before = names(folder.path());
    let begin = Instant::now();
    for out in ["file/below", "/proc/tyrewave"] {
        if out.starts_with('/') && !Path::new("/proc").exists() {
            skipped("no /proc");
            continue;
        }
        let output = tyrewave(folder.path(), &["run", "scene.toml", "--out", out]);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(NOT_WRITABLE), "{message}");
        assert!(message.contains("cannot create") && message.contains(out), "{message}");
        assert_eq!(names(folder.path()), before);
    }
    println!("refused in {:?}", begin.elapsed());
}

#[test]
fn an_unwritable_place_is_refused_before_the_long_work() {
    // 2048 elements without short sums: minutes of work that must not be begun.
    let scene = edit(&with_all_terms(&good()), &[("numerics.elements", "2048")]);
    let folder = folder_with(&scene);
    fs::write(folder.path().join("file"), "").unwrap();
    let begin = Instant::now();
    let output = tyrewave(folder.path(), &["run", "scene.toml", "--out", "file/below"]);
    assert_eq!(output.status.code(), Some(NOT_WRITABLE));
    assert!(begin.elapsed() < Duration::from_secs(10), "{:?}", begin.elapsed());
}

/// A shell command line in the folder, on Unix.
fn shell(folder: &Path, line: &str) -> Output {
    Command::new("sh").args(["-c", line, "sh"]).arg(program()).current_dir(folder).output().unwrap()
}

#[test]
#[cfg(unix)]
fn a_file_that_may_not_grow() {
    // A limit on the size of files stands for a quota; the signal that comes with it must not kill.
    let folder = folder_with(&good());
    let before = names(folder.path());
    let output = shell(folder.path(), "ulimit -f 8; exec \"$1\" run scene.toml --out full");
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(NOT_WRITABLE), "{message}");
    assert!(message.contains("cannot write full.partial") && message.contains(".npy"), "{message}");
    assert_eq!(names(folder.path()), before, "half-written results were left");
}

#[test]
#[cfg(unix)]
fn a_process_that_may_open_few_files_leaves_no_empty_folders() {
    let folder = folder_with(&good());
    let before = names(folder.path());
    for files in 4..=7 {
        let output = shell(folder.path(), &format!("ulimit -n {files}; exec \"$1\" run scene.toml"));
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && message.contains("open files"), "{files}: {message}");
        assert_eq!(names(folder.path()), before, "{files} files: {message}");
    }
}

#[test]
#[cfg(unix)]
fn a_full_disk() {
    let folder = folder_with(&good());
    let disk = folder.path().join("disk");
    fs::create_dir(&disk).unwrap();
    // A disk of 16 kB in a separate mount namespace.
    let line = "mount -t tmpfs -o size=16k none disk && \
        { \"$1\" run scene.toml --out disk/full; code=$?; ls disk; exit $code; }";
    let inside = format!("unshare --user --map-root-user --mount sh -c '{line}' sh \"$1\" || exit $?");
    let can = "mkdir probe && unshare --user --map-root-user --mount mount -t tmpfs -o size=16k none probe";
    if !shell(folder.path(), can).status.success() {
        skipped("no tmpfs can be mounted here");
        return;
    }
    let output = shell(folder.path(), &inside);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(NOT_WRITABLE), "{message}");
    assert!(message.contains("cannot write disk/full.partial") && message.contains("No space left"), "{message}");
    assert_eq!(String::from_utf8_lossy(&output.stdout), "", "half-written results were left on the disk");
}

/// Waits until a condition holds.
fn wait_for(what: &str, mut condition: impl FnMut() -> bool) {
    let begin = Instant::now();
    while !condition() {
        assert!(begin.elapsed() < Duration::from_secs(120), "waited for {what}");
        sleep(Duration::from_millis(20));
    }
}

#[test]
#[cfg(unix)]
fn ctrl_c_keeps_what_there_is_as_partial() {
    let scene = edit(&good(), &[("rolling.duration", "20000.0")]);
    let folder = folder_with(&scene);
    let mut run = Command::new(program())
        .args(["run", "scene.toml", "--out", "long"])
        .current_dir(folder.path())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // Something has reached the disk: the run is well under way.
    let working = folder.path().join(format!("long.partial-{}", run.id())).join("patch_force.npy");
    wait_for("the first rows", || fs::metadata(&working).is_ok_and(|file| file.len() > 100_000));
    assert!(!folder.path().join("long").exists());
    assert!(Command::new("kill").args(["-INT", &run.id().to_string()]).status().unwrap().success());
    wait_for("the end", || run.try_wait().unwrap().is_some());
    let output = run.wait_with_output().unwrap();
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(INTERRUPTED), "{message}");
    assert!(message.contains("interrupted") && message.contains("long.partial"), "{message}");
    assert_eq!(names(folder.path()), ["long.partial", "scene.toml"]);

    let partial = folder.path().join("long.partial");
    let summary = read_summary(&partial);
    assert_eq!(summary["complete"], false);
    let steps = summary["outcome"]["steps"].as_u64().unwrap() as usize;
    assert!(steps > 500, "{steps}");
    for name in ["time.npy", "total_force.npy"] {
        let (shape, values) = read_array::<f64>(&partial.join(name));
        assert_eq!((shape, values.len()), (vec![steps], steps), "{name}");
    }
    let (shape, first) = read_array::<i64>(&partial.join("patch_element.npy"));
    assert_eq!(shape, [steps]);
    assert!(first.windows(2).all(|pair| pair[1] == pair[0] + 1));
    let (shape, patch) = read_array::<f64>(&partial.join("patch_force.npy"));
    assert!(shape[0] == steps && patch.len() == steps * shape[1]);
    let total = read_array::<f64>(&partial.join("total_force.npy")).1;
    let last: f64 = patch[(steps - 1) * shape[1]..].iter().sum();
    assert!((last - total[steps - 1]).abs() <= 1e-9 * last, "the last row is whole");
    let named: Vec<String> = serde_json::from_value(summary["files"].clone()).unwrap();
    assert_eq!(named, names(&partial));
}

#[test]
fn a_second_run_replaces_results_but_no_foreign_folder() {
    let folder = folder_with(&good());
    let run = || tyrewave(folder.path(), &["run", "scene.toml", "--out", "out"]);
    assert!(run().status.success());
    let out = folder.path().join("out");
    let first = read_array::<f64>(&out.join("total_force.npy")).1;
    let second = edit(&good(), &[("rolling.axle.indentation", "0.011")]);
    fs::write(folder.path().join("scene.toml"), second).unwrap();
    assert!(run().status.success());
    let second = read_array::<f64>(&out.join("total_force.npy")).1;
    assert!(first.len() == second.len() && first.last() > second.last(), "the results are not those of the second run");
    assert_eq!(names(folder.path()), ["out", "scene.toml"]);

    fs::write(out.join("notes.txt"), "mine").unwrap();
    let output = run();
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(USAGE), "{message}");
    assert!(message.contains("notes.txt") && message.contains("left alone"), "{message}");
    assert_eq!(read_array::<f64>(&out.join("total_force.npy")).1, second);

    let foreign = folder.path().join("thesis");
    fs::create_dir(&foreign).unwrap();
    fs::write(foreign.join("chapter.tex"), "ten years").unwrap();
    let output = tyrewave(folder.path(), &["run", "scene.toml", "--out", "thesis"]);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(USAGE), "{message}");
    assert!(message.contains("not a tyrewave results folder"), "{message}");
    assert_eq!(names(&foreign), ["chapter.tex"]);
    assert_eq!(fs::read_to_string(foreign.join("chapter.tex")).unwrap(), "ten years");
    assert_eq!(names(folder.path()), ["out", "scene.toml", "thesis"]);
}
