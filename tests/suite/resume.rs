//! Runs that are stopped and continue: the same bytes as without the stop, whatever stopped them.
#![cfg(unix)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output};
use std::thread::sleep;
use std::time::{Duration, Instant};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;
use tempfile::TempDir;

use tyrewave::internals::{add, edit, scene_text, with_all_terms};

use crate::common::{TREAD_MAP, command, names, program, read_summary, skipped, tyrewave, write_grid, write_tread_map};

const USAGE: i32 = 2;
const NOT_WRITABLE: i32 = 3;
const INTERRUPTED: i32 = 130;

/// A run of some tenths of a second of wall time, with a checkpoint every few milliseconds.
fn scene_of(history: &str, road: &str, duration: f64, interval: f64) -> String {
    let rolling = format!("speed_kmh = 80.0\nwarm_up = 0.2\nduration = {duration:?}\naxle = {{ load = 3000.0 }}");
    let numerics = format!("memory = 0.2\nhistory = \"{history}\"\ncached_factors = 5");
    let outputs = format!("[outputs]\ncheckpoint_interval = {interval:?}");
    scene_text(64, road, &rolling, &numerics, &outputs)
}

/// Speed of all runs \[m/s\].
const SPEED: f64 = 80.0 / 3.6;

/// A folder with the scene in it, and `road.npy`, a rough road of that many metres.
fn folder_with(scene: &str, metres: f64) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(9);
    let heights: Vec<f64> = (0..(metres / 0.03) as usize * 5).map(|_| random.random_range(0.0..3e-3)).collect();
    write_grid(&folder.path().join("road.npy"), 5, &heights);
    fs::write(folder.path().join("scene.toml"), scene).unwrap();
    folder
}

/// The road of [`folder_with`].
fn road(at_end: &str) -> String {
    format!("kind = \"grid\"\nfile = \"road.npy\"\ndx = 0.03\ndy = 0.024\nlevel = \"off\"\nat_end = \"{at_end}\"")
}

fn message(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Waits until a condition holds or the process has ended.
fn wait_for(run: &mut Child, mut condition: impl FnMut() -> bool) {
    let begin = Instant::now();
    while !condition() && run.try_wait().unwrap().is_none() {
        assert!(begin.elapsed() < Duration::from_secs(120), "waited too long");
        sleep(Duration::from_millis(2));
    }
}

/// The summary without what depends on the clock and on the machine.
fn timeless(folder: &Path) -> Value {
    let mut summary = read_summary(folder);
    let cost = summary["cost"].as_object_mut().unwrap();
    for key in
        ["wall_seconds", "cpu_seconds", "idle_share", "threads", "steps", "stages", "rates", "peak_memory", "planned"]
    {
        cost.remove(key).unwrap();
    }
    // None of a tyre that an earlier run has fitted, nor of a body whose field it has solved for.
    let counters = cost["counters"].as_object_mut().unwrap();
    for key in ["compliance_evaluations", "radiation_solves", "radiation_kernels"] {
        counters.remove(key).unwrap();
    }
    // Files by their names: the folder is that of the test.
    for input in summary["inputs"].as_array_mut().into_iter().flatten() {
        let name = Path::new(input["file"].as_str().unwrap()).file_name().unwrap().to_str().unwrap().to_owned();
        input["file"] = name.into();
    }
    if let Some(sound) = summary["sound"].as_object_mut() {
        sound.remove("body");
    }
    summary
}

/// Fails unless two results folders hold the same files with the same bytes, times excepted.
fn assert_same(one: &Path, other: &Path) {
    assert_eq!(names(one), names(other));
    assert_eq!(timeless(one), timeless(other));
    for name in names(one).iter().filter(|name| *name != "summary.json") {
        assert!(fs::read(one.join(name)).unwrap() == fs::read(other.join(name)).unwrap(), "{name} differs");
    }
}

/// The one folder of an unfinished run called `name`.
fn unfinished(folder: &Path, name: &str) -> Option<PathBuf> {
    let found: Vec<String> =
        names(folder).into_iter().filter(|entry| entry.starts_with(&format!("{name}.partial"))).collect();
    assert!(found.len() <= 1, "{found:?}");
    found.first().map(|found| folder.join(found))
}

fn signal(run: &Child, name: &str) {
    assert!(Command::new("kill").args([name, &run.id().to_string()]).status().unwrap().success());
}

/// Runs to the end in `whole`, and in `cut` with kill -9 at random moments after a first checkpoint; compares.
fn killed_at_random(scene: &str, metres: f64, kills: usize, seed: u64) {
    let folder = folder_with(scene, metres);
    let place = folder.path();
    let begin = Instant::now();
    let whole = tyrewave(place, &["run", "scene.toml", "--out", "whole", "--threads", "2"]);
    assert!(whole.status.success(), "{}", message(&whole));
    let length = begin.elapsed();
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let (mut killed, mut resumed) = (0, 0);
    for attempt in 0.. {
        let resumable = unfinished(place, "cut").is_some_and(|folder| folder.join("checkpoint").exists());
        if !resumable {
            // Killed before anything could be stored: its folder is of no use.
            unfinished(place, "cut").map(fs::remove_dir_all).transpose().unwrap();
        }
        resumed += usize::from(resumable);
        // The scene's file is needed to begin, not to continue.
        let arguments: &[&str] = if resumable { &["resume", "cut"] } else { &["run", "scene.toml", "--out", "cut"] };
        let threads = ["1", "2"][attempt % 2];
        let mut run = command(place, arguments).args(["--threads", threads]).spawn().unwrap();
        if killed < kills {
            let delay = length.mul_f64(random.random_range(0.0..1.0 / (1.0 + kills as f64 / 2.0)));
            let before =
                unfinished(place, "cut").map(|folder| folder.join("checkpoint")).and_then(|file| fs::read(file).ok());
            if attempt % 3 > 0 {
                // At least one checkpoint further, so that the run gets on.
                wait_for(&mut run, || {
                    let now = names(place).into_iter().find(|name| name.starts_with("cut.partial"));
                    let now = now.and_then(|name| fs::read(place.join(name).join("checkpoint")).ok());
                    now.is_some() && now != before
                });
            }
            sleep(delay);
            if run.try_wait().unwrap().is_none() {
                run.kill().unwrap();
                killed += 1;
            }
        }
        let output = run.wait_with_output().unwrap();
        if output.status.success() {
            break;
        }
        assert_eq!(output.status.code(), None, "{}", message(&output));
    }
    println!("{killed} kills, {resumed} resumes, {length:?} without");
    assert!(resumed >= 1, "never resumed");
    assert_same(&place.join("whole"), &place.join("cut"));
    assert_eq!(names(place), ["cut", "road.npy", "scene.toml", "whole"]);
}

#[test]
fn a_killed_run_with_modal_history_ends_in_the_same_bytes() {
    killed_at_random(&scene_of("modal", &road("refuse"), 20.0, 0.004), 21.0 * SPEED, 5, 1);
}

#[test]
fn a_killed_run_with_direct_history_ends_in_the_same_bytes() {
    killed_at_random(&scene_of("direct", &road("mirror"), 12.0, 0.004), 30.0, 5, 2);
}

#[test]
fn the_papers_coupling_continues_in_the_same_bytes() {
    let scene = scene_of("modal", &road("refuse"), 20.0, 0.004) + "[contact]\nslice_coupling = \"explicit\"\n";
    killed_at_random(&scene, 21.0 * SPEED, 3, 4);
}

#[test]
fn an_axle_with_a_mass_continues_in_the_same_bytes() {
    let axle = "tolerance = 0.05\nmass = 30.0\nstiffness = 2e4\ndamping = 800.0";
    let scene = add(&scene_of("modal", &road("refuse"), 20.0, 0.004), "rolling.axle", axle);
    killed_at_random(&scene, 21.0 * SPEED, 3, 5);
}

#[test]
fn cells_continue_in_the_same_bytes() {
    let scene = scene_of("modal", &road("repeat"), 2.0, 0.02) + "cells_every = 0.01\n";
    let scene = edit(&scene, &[("numerics.lateral_terms", "12")]);
    killed_at_random(&(scene + "[contact]\nzone = \"cells\"\ncells_across = 4\n"), 21.0, 3, 6);
}

#[test]
fn sub_cells_continue_in_the_same_bytes() {
    let scene = with_all_terms(&scene_of("modal", &road("repeat"), 1.0, 0.02));
    killed_at_random(&(scene + "[contact]\nzone = \"cells\"\ncells_across = 4\nsub_cells = 2\n"), 21.0, 3, 16);
}

#[test]
fn a_repeated_road_and_a_fixed_axle_continue_in_the_same_bytes() {
    let scene = scene_of("modal", &road("repeat"), 20.0, 0.004);
    let scene = edit(&scene, &[("rolling.axle", "{ indentation = 0.012, ramp = 0.05 }")]);
    killed_at_random(&scene, 21.0, 3, 3);
}

#[test]
fn vibration_continues_in_the_same_bytes() {
    for (rule, kills) in [("bdf2", 3), ("sdirk2", 2)] {
        let scene = scene_of("modal", &road("refuse"), 20.0, 0.004);
        let scene = add(&scene, "numerics", &format!("time_rule = \"{rule}\""));
        let keys = "segment = 0.2\npoints = [0.1]\nelements = [5]\nmap = true";
        let scene = format!("{scene}[outputs.vibration]\n{keys}\n");
        killed_at_random(&scene, 21.0 * SPEED, kills, 5);
    }
}

#[test]
fn vibration_and_sound_of_cells_continue_in_the_same_bytes() {
    let scene = scene_of("modal", &road("repeat"), 2.0, 0.02);
    let scene = edit(&scene, &[("numerics.lateral_terms", "12")]);
    let keys = "segment = 0.2\npoints = [0.1]\nelements = [5]\nmap = true";
    let cells = "[contact]\nzone = \"cells\"\ncells_across = 4\n";
    let sound = "[[receiver]]\nposition = [0.0, 1.0, 0.3]\n[radiation]\nfmax = 500.0\nquality = \"draft\"\n";
    killed_at_random(&format!("{scene}[outputs.vibration]\n{keys}\n{cells}{sound}"), 21.0, 3, 7);
}

#[test]
fn levels_of_a_finer_mesh_continue_in_the_same_bytes() {
    let scene = scene_of("modal", &road("repeat"), 8.0, 0.02) + "levels = { standard_error = 0.4 }\n";
    let scene = edit(&scene, &[("numerics.lateral_terms", "12")]);
    let folder = folder_with(&(scene + "[contact]\nzone = \"cells\"\ncells_across = 4\n"), 21.0);
    let place = folder.path();
    let whole = tyrewave(place, &["run", "scene.toml", "--out", "whole"]);
    assert!(whole.status.success(), "{}", message(&whole));
    // The short runs come before the first checkpoint.
    let mut run = command(place, &["run", "scene.toml", "--out", "cut"]).spawn().unwrap();
    wait_for(&mut run, || unfinished(place, "cut").is_some_and(|folder| folder.join("checkpoint").exists()));
    signal(&run, "-KILL");
    assert_eq!(run.wait_with_output().unwrap().status.code(), None);
    let resumed = tyrewave(place, &["resume", "cut"]);
    assert!(resumed.status.success(), "{}", message(&resumed));
    assert_same(&place.join("whole"), &place.join("cut"));
}

#[test]
fn radiating_sidewalls_continue_in_the_same_bytes() {
    let scene = edit(&scene_of("modal", &road("repeat"), 12.0, 0.004), &[("numerics.elements", "128")]);
    let mut scene: toml::Table = scene.parse().unwrap();
    let tyre = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/tyres/car.toml");
    scene.insert("tyre".into(), fs::read_to_string(tyre).unwrap().parse::<toml::Table>().unwrap().into());
    let sound = "[[receiver]]\nposition = [0.0, 3.0, 1.2]\n[radiation]\nfmax = 200.0\nnodes_per_wavelength = 5.0\n";
    killed_at_random(&format!("{scene}{sound}"), 21.0, 3, 8);
}

#[test]
fn a_made_road_continues_in_the_same_bytes() {
    // Coarse, so that it is quickly made.
    let road = "kind = \"made\"\nseed = 4\nspacing = 0.01\nwavelengths = [0.1, 0.08]\nlevels = [46.0, 46.0]";
    killed_at_random(&scene_of("direct", road, 4.0, 0.002), 1.0, 2, 4);
}

/// A run that is under way, stopped by a signal once it has written a checkpoint.
fn stopped_by(name: &str, scene: &str) -> (TempDir, Output) {
    let folder = folder_with(scene, 30.0);
    let place = folder.path();
    let mut run = command(place, &["run", "scene.toml", "--out", "cut"]).spawn().unwrap();
    let working = place.join(format!("cut.partial-{}", run.id()));
    wait_for(&mut run, || fs::metadata(working.join("patch_force.npy")).is_ok_and(|file| file.len() > 300_000));
    signal(&run, name);
    let output = run.wait_with_output().unwrap();
    (folder, output)
}

#[test]
fn interrupted_and_terminated_runs_continue_in_the_same_bytes() {
    let scene = scene_of("modal", &road("mirror"), 60.0, 0.0);
    let cut = [("-INT", "1"), ("-TERM", "2")].map(|(name, threads)| {
        // No checkpoint but the one at the interruption.
        let (folder, output) = stopped_by(name, &scene);
        assert_eq!(output.status.code(), Some(INTERRUPTED), "{}", message(&output));
        assert!(message(&output).contains("tyrewave resume cut.partial"), "{}", message(&output));
        assert_eq!(names(folder.path()), ["cut.partial", "road.npy", "scene.toml"]);
        assert_eq!(read_summary(&folder.path().join("cut.partial"))["complete"], false);
        (folder, threads)
    });
    let whole = cut[0].0.path().join("whole");
    let run = tyrewave(cut[0].0.path(), &["run", "scene.toml", "--out", "whole"]);
    assert!(run.status.success(), "{}", message(&run));
    for (folder, threads) in &cut {
        let place = folder.path();
        fs::remove_file(place.join("scene.toml")).unwrap();
        let resumed = tyrewave(place, &["resume", "cut", "--threads", threads]);
        assert!(resumed.status.success(), "{}", message(&resumed));
        assert_same(&whole, &place.join("cut"));
        let remaining = if whole.starts_with(place) { &["cut", "road.npy", "whole"][..] } else { &["cut", "road.npy"] };
        assert_eq!(names(place), remaining);
    }
}

#[test]
fn damaged_and_foreign_checkpoints_and_versions_are_refused() {
    let scene = scene_of("direct", &road("mirror"), 2000.0, 0.0);
    let (folder, _) = stopped_by("-INT", &scene);
    let place = folder.path();
    let partial = place.join("cut.partial");
    let file = partial.join("checkpoint");
    let good = fs::read(&file).unwrap();
    let refused = |words: &[&str]| {
        let output = tyrewave(place, &["resume", "cut"]);
        let message = message(&output);
        assert_eq!(output.status.code(), Some(USAGE), "{message}");
        assert!(words.iter().all(|word| message.contains(word)), "{message}");
        assert!(output.stdout.is_empty() && !message.contains("panicked"), "{message}");
    };
    for (place, words) in
        [(0, "not a checkpoint"), (8, "format version"), (30, "damaged"), (good.len() - 40, "damaged")]
    {
        let mut bad = good.clone();
        bad[place] ^= 0x10;
        fs::write(&file, &bad).unwrap();
        refused(&["cut.partial/checkpoint", words]);
    }
    fs::write(&file, &good[..good.len() / 2]).unwrap();
    refused(&["truncated"]);
    // Another version, its checksum right.
    let version = env!("CARGO_PKG_VERSION").as_bytes();
    let at = good.windows(version.len()).position(|window| window == version).unwrap();
    let mut other = good.clone();
    other[at] ^= 1;
    let end = other.len() - 32;
    let checksum = <sha2::Sha256 as sha2::Digest>::digest(&other[..end]);
    other[end..].copy_from_slice(&checksum);
    fs::write(&file, &other).unwrap();
    refused(&["has written it", env!("CARGO_PKG_VERSION")]);
    // Of another scene: one layer a little thicker.
    fs::write(&file, &good).unwrap();
    let saved = fs::read_to_string(partial.join("scene.toml")).unwrap();
    fs::write(partial.join("scene.toml"), saved.replacen("thickness = 0.013", "thickness = 0.012", 1)).unwrap();
    refused(&["another scene"]);
    fs::write(partial.join("scene.toml"), &saved).unwrap();
    // An array that has lost rows which the checkpoint counts, one with a flipped byte, and one of another shape.
    let array = partial.join("patch_force.npy");
    let rows = fs::read(&array).unwrap();
    fs::write(&array, &rows[..rows.len() / 2]).unwrap();
    refused(&["patch_force.npy is damaged"]);
    fs::write(&array, &rows).unwrap();
    for name in ["time.npy", "total_force.npy", "patch_force.npy", "patch_element.npy"] {
        let good = fs::read(partial.join(name)).unwrap();
        let mut bad = good.clone();
        bad[good.len() / 3] ^= 1;
        fs::write(partial.join(name), &bad).unwrap();
        refused(&[&format!("cut.partial/{name} is damaged")]);
        fs::write(partial.join(name), &good).unwrap();
    }
    let mut other = rows.clone();
    let shape = other.windows(8).position(|window| window == b"'shape':").unwrap();
    let comma = shape + other[shape..].iter().position(|&byte| byte == b',').unwrap();
    other[comma + 2] = b'9';
    fs::write(&array, &other).unwrap();
    refused(&["patch_force.npy is not the array"]);
    fs::write(&array, &rows).unwrap();
    fs::remove_file(&file).unwrap();
    refused(&["holds no checkpoint"]);
    let output = tyrewave(place, &["resume", "nowhere"]);
    assert_eq!(output.status.code(), Some(USAGE));
    assert!(message(&output).contains("nothing to resume"), "{}", message(&output));
    // Nothing was lost by all this.
    assert!(fs::read(&array).unwrap() == rows && partial.join("summary.json").exists());
}

#[test]
fn a_changed_input_file_and_a_running_run_are_refused() {
    let scene = scene_of("direct", &road("repeat"), 20_000.0, 0.01) + TREAD_MAP;
    let folder = folder_with(&scene, 12.0);
    let place = folder.path();
    write_tread_map(&place.join("map.npy"), 0.008);
    let mut run = command(place, &["run", "scene.toml", "--out", "cut"]).spawn().unwrap();
    let working = place.join(format!("cut.partial-{}", run.id()));
    wait_for(&mut run, || working.join("checkpoint").exists());
    let output = tyrewave(place, &["resume", "cut"]);
    assert_eq!(output.status.code(), Some(USAGE));
    assert!(message(&output).contains("still running"), "{}", message(&output));
    run.kill().unwrap();
    run.wait().unwrap();
    for name in ["road.npy", "map.npy"] {
        let written = fs::read(place.join(name)).unwrap();
        let mut bytes = written.clone();
        bytes[1000] ^= 1;
        fs::write(place.join(name), bytes).unwrap();
        let output = tyrewave(place, &["resume", "cut"]);
        assert_eq!(output.status.code(), Some(USAGE), "{}", message(&output));
        assert!(message(&output).contains(&format!("{name} has changed")), "{}", message(&output));
        fs::write(place.join(name), written).unwrap();
    }
    assert!(working.join("checkpoint").exists());
}

#[test]
fn a_run_on_a_full_disk_continues_when_there_is_space() {
    // A disk with room for half the arrays in a separate mount namespace: some seconds of rolling, then no room; then
    // the folder is moved to where there is some.
    let folder = folder_with(&scene_of("modal", &road("mirror"), 30.0, 0.004), 30.0);
    let place = folder.path();
    for name in ["disk", "probe"] {
        fs::create_dir(place.join(name)).unwrap();
    }
    let shell =
        |line: &str| Command::new("sh").args(["-c", line, "sh"]).arg(program()).current_dir(place).output().unwrap();
    let can = "unshare --user --map-root-user --mount mount -t tmpfs -o size=16k none probe";
    if !shell(can).status.success() {
        skipped("no tmpfs can be mounted here");
        return;
    }
    let whole = tyrewave(place, &["run", "scene.toml", "--out", "whole"]);
    assert!(whole.status.success(), "{}", message(&whole));
    let array = fs::metadata(place.join("whole/patch_force.npy")).unwrap().len();
    let line = format!(
        "mount -t tmpfs -o size={} none disk && {{ \"$1\" run scene.toml --out disk/cut; code=$?; ls disk; cp -r \
         disk/cut.partial saved.partial; exit $code; }}",
        array / 2
    );
    let output = shell(&format!("unshare --user --map-root-user --mount sh -c '{line}' sh \"$1\" || exit $?"));
    let text = message(&output);
    assert_eq!(output.status.code(), Some(NOT_WRITABLE), "{text}");
    assert!(text.contains("No space left") && text.contains("tyrewave resume disk/cut.partial"), "{text}");
    assert_eq!(String::from_utf8_lossy(&output.stdout), "cut.partial\n");
    assert!(!place.join("saved.partial/checkpoint.tmp").exists());
    let resumed = tyrewave(place, &["resume", "saved"]);
    assert!(resumed.status.success(), "{}", message(&resumed));
    assert_same(&place.join("whole"), &place.join("saved"));
}
