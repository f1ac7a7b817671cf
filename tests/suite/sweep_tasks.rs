//! A sweep through a folder of tasks: the same tables as a plain one, whatever comes between.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;
use std::thread::sleep;
use std::time::Duration;

use tempfile::TempDir;
use tyrewave::internals::{implausible, scene_text};

use crate::common::{TREAD_MAP, command, folder_with, names, tyrewave, write_tread_map};

const ROAD: &str = "kind = \"made\"\nseed = 4\nspacing = 0.01\nwavelengths = [0.2, 0.16, 0.125, 0.1, 0.08]\n\
    levels = [46.0, 46.0, 46.0, 46.0, 46.0]";
/// Arguments of a sweep with six variants.
const SWEEP: [&str; 6] = ["sweep", "scene.toml", "--speed", "40..80:20", "--load", "2500,3000"];

fn scene(road: &str, duration: f64) -> String {
    let axle = "axle = { load = 3000.0, tolerance = 0.5 }";
    let rolling = format!("speed_kmh = 80.0\nwarm_up = 0.1\nduration = {duration:?}\n{axle}");
    scene_text(64, road, &rolling, "history = \"modal\"", "[outputs]\ncheckpoint_interval = 0.002")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn sweep(place: &Path, more: &[&str]) -> Output {
    tyrewave(place, &[&SWEEP[..], more].concat())
}

fn task(place: &Path, numbers: &str) -> Output {
    tyrewave(place, &["sweep", "--task", "t", numbers, "--threads", "2"])
}

fn collect(place: &Path) -> Output {
    tyrewave(place, &["sweep", "--collect", "t"])
}

fn assert_done(output: &Output) {
    assert!(output.status.success(), "{}{}", text(&output.stdout), text(&output.stderr));
}

fn assert_refused(output: &Output, word: &str) {
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains(word), "{word}: {message}");
}

/// A folder with a scene and its tasks.
fn written(road: &str, duration: f64) -> TempDir {
    let folder = folder_with(&scene(road, duration));
    assert_done(&sweep(folder.path(), &["--tasks", "t"]));
    folder
}

/// Flips a bit in the middle of a file.
fn damage(path: &PathBuf) {
    let mut bytes = fs::read(path).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(path, bytes).unwrap();
}

#[test]
fn tasks_and_their_collection_make_the_tables_of_a_plain_sweep() {
    let folder = written(ROAD, 0.3);
    let place = folder.path();
    assert_done(&sweep(place, &["--out", "plain"]));
    assert_eq!(names(&place.join("t")), ["job.hq", "job.slurm", "logs", "manifest", "shard-0000"]);
    assert_done(&task(place, "4"));
    // What is missing is named, in numbers of elements for the job array, too: here two tasks an element.
    let missing = collect(place);
    let message = text(&missing.stderr);
    assert_eq!(missing.status.code(), Some(1), "{message}");
    assert!(message.contains("5 of 6 tasks are missing: 0 (2500N-40kmh), 1 (2500N-60kmh), 2"), "{message}");
    assert!(text(&missing.stdout).contains("1 of 6 tasks are done"), "{}", text(&missing.stdout));
    assert_eq!(fs::read_to_string(place.join("t/missing")).unwrap(), "0\n");
    // A task that is done is done.
    let again = task(place, "4");
    assert_done(&again);
    assert!(text(&again.stdout).contains("task 4 (3000N-60kmh): was done before"), "{}", text(&again.stdout));
    let rest = task(place, "0..5");
    assert_done(&rest);
    assert_eq!(text(&rest.stdout).matches(": done\n").count(), 5, "{}", text(&rest.stdout));
    // Six outcomes have become one file.
    assert_eq!(names(&place.join("t/shard-0000")), ["outcomes", "tasks"]);
    for _ in 0..2 {
        assert_done(&collect(place));
        assert!(!place.join("t/missing").exists());
        for name in ["sweep.csv", "sweep.txt", "growth.svg", "levels.svg"] {
            let read = |folder: &str| fs::read(place.join(folder).join(name)).unwrap();
            assert!(read("plain") == read("t"), "{name}");
        }
    }
    let json = tyrewave(place, &["sweep", "--collect", "t", "--json"]);
    let json: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    assert_eq!((&json["done"], &json["missing"], &json["elements"]), (&6.into(), &"".into(), &"".into()));
}

#[test]
fn the_same_tasks_are_left_and_others_are_refused() {
    let folder = written(ROAD, 0.1);
    let place = folder.path();
    assert_done(&task(place, "0"));
    let again = sweep(place, &["--tasks", "t", "--chunk", "2"]);
    assert_done(&again);
    assert!(text(&again.stdout).contains("6 tasks in t, written before"), "{}", text(&again.stdout));
    assert!(fs::read_to_string(place.join("t/job.slurm")).unwrap().contains("#SBATCH --array=0-2%"));
    assert!(text(&task(place, "0").stdout).contains("was done before"));
    assert_eq!(collect(place).status.code(), Some(1));
    assert_eq!(fs::read_to_string(place.join("t/missing")).unwrap(), "0-2\n");
    let before = names(&place.join("t"));
    for other in [&["--set", "numerics.elements=80"][..], &["--load", "2500"]] {
        let arguments = if other[0] == "--load" { &SWEEP[..4] } else { &SWEEP[..] };
        let refused = tyrewave(place, &[arguments, other, &["--tasks", "t"]].concat());
        assert_refused(&refused, "holds 6 other tasks");
    }
    assert_eq!(names(&place.join("t")), before);
    // Somebody's file is no job file of ours.
    fs::create_dir(place.join("mine")).unwrap();
    fs::write(place.join("mine/job.slurm"), "#!/bin/bash\necho mine\n").unwrap();
    assert_refused(&sweep(place, &["--tasks", "mine"]), "job.slurm");
    assert_eq!(fs::read_to_string(place.join("mine/job.slurm")).unwrap(), "#!/bin/bash\necho mine\n");
    assert!(!place.join("mine/manifest").exists());
}

#[test]
fn what_makes_no_sense_is_answered() {
    let folder = written(ROAD, 0.1);
    let place = folder.path();
    assert_refused(&task(place, "6"), "they have the numbers 0 to 5");
    assert_refused(&task(place, "3..6"), "no task 6");
    assert_refused(&task(place, "3..1"), "before they begin");
    assert_refused(&tyrewave(place, &["sweep", "--task", ".", "0"]), "no tasks: there is no");
    assert_refused(&tyrewave(place, &["sweep", "--collect", "nowhere"]), "no tasks: there is no");
    assert_refused(&tyrewave(place, &["sweep", "--task", "t"]), "--task");
    assert_refused(&tyrewave(place, &["sweep", "scene.toml", "--collect", "t"]), "cannot be used with");
    assert_refused(&tyrewave(place, &["sweep", "--speed", "80"]), "required");
    assert_refused(&sweep(place, &["--tasks", "u", "--out", "s"]), "--out");
    assert!(!place.join("u").exists() && names(&place.join("t/shard-0000")) == ["tasks"]);
}

#[test]
fn damaged_and_foreign_folders_are_refused() {
    let folder = written(ROAD, 0.1);
    let place = folder.path();
    ["0", "1", "2"].iter().for_each(|number| assert_done(&task(place, number)));
    let [manifest, tasks] = ["t/manifest", "t/shard-0000/tasks"].map(|name| place.join(name));
    for (path, version) in [(&manifest, 1), (&tasks, 2)] {
        let whole = fs::read(path).unwrap();
        let shown = path.file_name().unwrap().to_str().unwrap();
        damage(path);
        for output in [task(place, "0"), collect(place)] {
            assert_refused(&output, "it is damaged");
            assert_refused(&output, shown);
        }
        fs::write(path, &whole[..whole.len() / 3]).unwrap();
        assert_refused(&collect(place), "it is truncated");
        let other = [&whole[..8], &9_u32.to_le_bytes(), &whole[12..]].concat();
        fs::write(path, other).unwrap();
        assert_refused(&collect(place), &format!("it has format version 9, this program reads {version}"));
        fs::remove_file(path).unwrap();
        // What is done stays.
        assert_done(&sweep(place, &["--tasks", "t"]));
        assert!(path.is_file(), "{shown}");
    }
    assert!(text(&collect(place).stdout).contains("3 of 6 tasks are done"));
    // An outcome that is damaged, or another scene's, is no outcome.
    assert_done(&sweep(place, &["--set", "numerics.elements=80", "--tasks", "u"]));
    assert_done(&tyrewave(place, &["sweep", "--task", "u", "1"]));
    fs::copy(place.join("u/shard-0000/outcome-1"), place.join("t/shard-0000/outcome-1")).unwrap();
    damage(&place.join("t/shard-0000/outcome-0"));
    let collected = collect(place);
    assert!(text(&collected.stdout).contains("1 of 6 tasks are done"), "{}", text(&collected.stdout));
    let message = text(&collected.stderr);
    assert!(message.contains("outcome-0 cannot be used: it is damaged"), "{message}");
    assert!(message.contains("outcome-1 cannot be used: it belongs to another key"), "{message}");
    assert_done(&task(place, "0..5"));
    assert_done(&collect(place));
    damage(&place.join("t/shard-0000/outcomes"));
    let message = text(&collect(place).stderr);
    assert!(message.contains("outcomes cannot be used") && message.contains("6 of 6 tasks are missing"), "{message}");
    assert_done(&task(place, "0..5"));
    assert_done(&collect(place));
}

#[test]
fn an_input_file_that_has_changed_is_refused() {
    let place = tempfile::tempdir().unwrap();
    let road = place.path().join("road.csv");
    let profile = |height: f64| {
        let rows = (0..400).map(|at| format!("{},{}\n", f64::from(at) * 0.005, height * f64::from(at % 7)));
        format!("distance,height\n{}", rows.collect::<String>())
    };
    fs::write(&road, profile(1e-4)).unwrap();
    let of_file = "kind = \"profile\"\nfile = \"road.csv\"\nat_end = \"repeat\"\n\
        distance_unit = \"m\"\nheight_unit = \"m\"";
    fs::write(place.path().join("scene.toml"), scene(of_file, 0.1) + TREAD_MAP).unwrap();
    let map = place.path().join("map.npy");
    write_tread_map(&map, 0.008);
    assert_done(&sweep(place.path(), &["--tasks", "t"]));
    assert_done(&task(place.path(), "0"));
    fs::write(&road, profile(2e-4)).unwrap();
    assert_refused(&task(place.path(), "1"), "road.csv has changed since the tasks were written");
    assert_refused(&sweep(place.path(), &["--tasks", "t"]), "other tasks");
    fs::remove_file(&road).unwrap();
    assert_refused(&task(place.path(), "0..5"), "cannot read");
    fs::write(&road, profile(1e-4)).unwrap();
    write_tread_map(&map, 0.007);
    assert_refused(&task(place.path(), "1"), "map.npy has changed since the tasks were written");
    assert_refused(&sweep(place.path(), &["--tasks", "t"]), "other tasks");
    write_tread_map(&map, 0.008);
    assert_done(&task(place.path(), "1"));
}

#[test]
fn a_task_that_fails_leaves_the_others_and_its_reason() {
    let folder = folder_with(&implausible(&scene(ROAD, 0.1)));
    let place = folder.path();
    let arguments = ["sweep", "scene.toml", "--speed", "80", "--load", "3000,1e9", "--tasks", "t"];
    assert_done(&tyrewave(place, &arguments));
    let failed = task(place, "0..1");
    let message = text(&failed.stderr);
    assert_eq!(failed.status.code(), Some(1), "{message}");
    for part in ["task 1 (1000000000N-80kmh): failed: ", "rolling.axle.load: no axle height carries"] {
        assert!(message.contains(part), "{message}");
    }
    let collected = collect(place);
    let message = text(&collected.stderr);
    assert_eq!(collected.status.code(), Some(1), "{message}");
    for part in ["1 of 2 tasks are missing", "failed: ", "rolling.axle.load: no axle height"] {
        assert!(message.contains(part), "{message}");
    }
}

#[test]
fn results_are_retained_where_that_is_asked_for() {
    let folder = written(ROAD, 0.1);
    let place = folder.path();
    assert_done(&tyrewave(place, &["sweep", "--task", "t", "1", "--keep-results"]));
    assert!(place.join("t/shard-0000/results/2500N-60kmh/total_force.npy").is_file());
    assert_done(&task(place, "2"));
    assert!(!place.join("t/shard-0000/results/2500N-80kmh").exists());
}

#[test]
#[cfg(unix)]
fn a_killed_task_continues_to_the_same_bytes() {
    let folder = folder_with(&scene(ROAD, 60.0));
    let place = folder.path();
    let one = ["sweep", "scene.toml", "--speed", "80"];
    let whole = tyrewave(place, &[&one[..], &["--out", "plain"]].concat());
    assert_done(&whole);
    assert_done(&tyrewave(place, &[&one[..], &["--tasks", "t"]].concat()));
    let runs = place.join("t/shard-0000/results");
    let has_checkpoint = || {
        let entries = fs::read_dir(&runs).into_iter().flatten();
        entries.filter(|entry| entry.as_ref().unwrap().path().join("checkpoint").exists()).count() > 0
    };
    for signal in ["-KILL", "-TERM"] {
        let mut run = command(place, &["sweep", "--task", "t", "0"]).spawn().unwrap();
        while !has_checkpoint() && run.try_wait().unwrap().is_none() {
            sleep(Duration::from_millis(1));
        }
        sleep(Duration::from_millis(100));
        // While it is at it nobody else is.
        let other = task(place, "0");
        assert_eq!(other.status.code(), Some(1), "{}", text(&other.stderr));
        assert!(text(&other.stderr).contains("another process is running it"), "{}", text(&other.stderr));
        let id = run.id().to_string();
        assert!(std::process::Command::new("kill").args([signal, &id]).status().unwrap().success());
        let stopped = run.wait_with_output().unwrap();
        assert!(!stopped.status.success(), "it was too fast to be stopped");
        assert!(signal == "-KILL" || stopped.status.code() == Some(130), "{}", text(&stopped.stderr));
        assert_eq!(collect(place).status.code(), Some(1));
    }
    let last = task(place, "0");
    assert_done(&last);
    assert!(text(&last.stdout).contains("task 0 (80kmh): continues at "), "{}", text(&last.stdout));
    assert_done(&collect(place));
    assert!(fs::read(place.join("plain/sweep.csv")).unwrap() == fs::read(place.join("t/sweep.csv")).unwrap());
    assert_eq!(names(&place.join("t/shard-0000")), ["outcomes", "tasks"]);
}

#[test]
fn many_workers_and_collectors_at_once_lose_nothing() {
    let folder = written(ROAD, 0.1);
    let place = folder.path();
    assert_done(&sweep(place, &["--out", "plain"]));
    // Workers in each other's way, and collectors that make one file of the outcomes while others read them.
    let begun: Vec<_> = ["0..3", "2..5", "0..5"]
        .map(|numbers| command(place, &["sweep", "--task", "t", numbers]).spawn().unwrap())
        .into_iter()
        .collect();
    let collectors: Vec<_> = (0..8).map(|_| command(place, &["sweep", "--collect", "t"]).spawn().unwrap()).collect();
    for child in begun.into_iter().chain(collectors) {
        let output = child.wait_with_output().unwrap();
        assert!(matches!(output.status.code(), Some(0 | 1)), "{}", text(&output.stderr));
    }
    assert_done(&task(place, "0..5"));
    let collectors: Vec<_> = (0..4).map(|_| command(place, &["sweep", "--collect", "t"]).spawn().unwrap()).collect();
    for child in collectors {
        assert_done(&child.wait_with_output().unwrap());
    }
    assert!(fs::read(place.join("plain/sweep.csv")).unwrap() == fs::read(place.join("t/sweep.csv")).unwrap());
    let remaining = names(&place.join("t/shard-0000"));
    assert_eq!(remaining, ["outcomes", "tasks"]);
}
