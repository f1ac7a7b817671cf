//! A study: errors fall with refinement, work is exact, the front is one.

use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::sleep;
use std::time::Duration;

use tyrewave::internals::{Study, StudyOptions, StudyPoint, Sweep, front, study};
use tyrewave::internals::{scene, scene_text};
use tyrewave::run::{Job, Progress, RunError, Unwatched};
use tyrewave::scene::{DEFAULT, History, LoadedScene};

use crate::common::command;

const ROLLING: &str = "speed_kmh = 80.0\nwarm_up = 0.1\nduration = 0.3\naxle = { load = 3400 }";
const MADE: &str = "kind = \"made\"\nseed = 2";

fn small(history: &str) -> LoadedScene {
    scene(&scene_text(32, MADE, ROLLING, history, ""))
}

fn options(loaded: &LoadedScene, sweep: Sweep, elements: usize) -> StudyOptions {
    let defaults = StudyOptions::new(&loaded.scene, sweep);
    StudyOptions { highest: 125.0, elements: Some(elements), substeps: Some(4), ..defaults }
}

fn studied(loaded: &LoadedScene) -> Study {
    let options = options(loaded, Sweep::Knobs, 64);
    study(loaded, &options, Job::new(&AtomicBool::new(false), &mut Unwatched)).unwrap()
}

#[test]
fn errors_fall_with_refinement_and_work_is_exact() {
    let loaded = small("history = \"modal\"");
    let found = studied(&loaded);
    assert!(found.reference.difference.worst == 0.0 && found.reference.difference.force == 0.0);
    let knob = |name: &str| found.knobs.iter().find(|knob| knob.name == name).unwrap_or_else(|| panic!("{name}"));
    let errors: Vec<f64> = knob("pole tolerance").points.iter().map(|point| point.difference.force).collect();
    println!("poles: {errors:?}");
    assert_eq!(errors.len(), 3);
    // From 1e-3 to 1e-5; a fit is better than asked for by a factor that varies.
    assert!(errors[0] > 5.0 * errors[2] && errors.windows(2).all(|pair| pair[1] < 1.5 * pair[0]), "{errors:?}");
    let elements: Vec<f64> =
        knob("elements").points.iter().map(|point| point.difference.contact_length.abs()).collect();
    println!("elements: {elements:?}");
    assert!(found.complete && found.uncertainty.worst > 0.0, "{:?}", found.uncertainty);

    // The front: rising work, falling error, nothing beats it, and nothing that is not on it is unbeaten.
    let on: Vec<(f64, f64)> = found.front.iter().map(StudyPoint::coordinates).collect();
    assert!(on.windows(2).all(|pair| pair[0].0 < pair[1].0 && pair[0].1 > pair[1].1), "{on:?}");
    let all: Vec<(f64, f64)> = found.points().map(StudyPoint::coordinates).collect();
    let expected: Vec<(f64, f64)> = front(&all).into_iter().map(|index| all[index]).collect();
    assert_eq!(on, expected);

    // Again, on one thread: the same errors and the same work, to the last bit.
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let again = alone.install(|| studied(&loaded));
    assert!(found.points().count() == again.points().count() && found.points().count() > 20);
    for (a, b) in found.points().zip(again.points()) {
        assert_eq!((&a.label, a.difference), (&b.label, b.difference));
        assert_eq!(a.cost.multiply_adds.to_bits(), b.cost.multiply_adds.to_bits(), "{}", a.label);
    }
}

/// Shares of all work as they are reported; asks for the end when work of a name begins.
struct Shares<'a> {
    reported: Vec<(f64, String)>,
    last: &'a str,
    stop: &'a AtomicBool,
}

impl Progress for Shares<'_> {
    fn share(&mut self, done: f64, doing: &str) {
        self.reported.push((done, doing.to_owned()));
        if doing == self.last {
            self.stop.store(true, Ordering::Relaxed);
        }
    }
}

#[test]
fn a_stopped_outline_returns_what_was_rolled() {
    let loaded = small("history = \"modal\"");
    let options = options(&loaded, Sweep::Outline, 64);
    let until = |last: &str| {
        let stop = AtomicBool::new(false);
        let mut shares = Shares { reported: Vec::new(), last, stop: &stop };
        let found = study(&loaded, &options, Job::new(&stop, &mut shares));
        (found, shares.reported)
    };
    let (whole, reported) = until("never");
    let whole = whole.unwrap();
    assert!(whole.complete && reported.is_sorted_by(|a, b| a.0 <= b.0), "{reported:?}");
    assert!(
        reported[0].0 == 0.0 && reported.last().unwrap().0 > 0.9 && reported.iter().all(|(done, _)| *done <= 1.0),
        "{reported:?}"
    );
    assert!(
        reported.iter().any(|(_, doing)| doing == "reference")
            && reported.iter().any(|(_, doing)| doing.contains("pole tolerance"))
    );
    // No presets.
    assert!(
        whole.uncertainty.worst > 0.0
            && whole.named.len() == 1
            && whole.knobs.iter().any(|knob| knob.points.len() == 1)
    );

    let (stopped, _) = until("the scene");
    let stopped = stopped.unwrap();
    // A run that is as short as the scene's here may be over before it sees the stop.
    let rolled = stopped.points().count();
    assert!(!stopped.complete && rolled <= 1 && whole.points().count() > 2, "{:?}", stopped.named);
    assert_eq!(stopped.reference.cost.multiply_adds.to_bits(), whole.reference.cost.multiply_adds.to_bits());
    assert_eq!(stopped.uncertainty, whole.uncertainty);
    let (nothing, _) = until("reference");
    assert!(matches!(nothing, Err(RunError::Interrupted { partial: None })), "{nothing:?}");
}

#[test]
fn a_direct_history_is_compared_with_a_modal_reference() {
    let loaded = small("history = \"direct\"\nmemory = 0.3\ntime_rule = \"bdf2\"");
    let options = options(&loaded, Sweep::Outline, 64);
    let found = study(&loaded, &options, Job::new(&AtomicBool::new(false), &mut Unwatched)).unwrap();
    let of_scene = &found.named[0];
    assert_eq!((of_scene.label.as_str(), of_scene.settings.numerics.history), ("the scene", History::Direct));
    assert!(of_scene.cost.fit.is_none() && found.reference.settings.numerics.history == History::Modal);
}

#[test]
#[cfg(target_os = "linux")]
fn an_interrupted_command_names_its_partial_results() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    std::fs::write(place.join("scene.toml"), scene_text(32, MADE, ROLLING, "history = \"modal\"", "")).unwrap();
    let models = || std::fs::read_dir(place.join("cache")).into_iter().flatten().count();
    let interrupted = |arguments: &[&str], is_time: &dyn Fn(u32) -> bool| {
        let mut command = command(place, arguments);
        let child = command.env("TYREWAVE_CACHE_DIR", place.join("cache")).stderr(Stdio::piped()).spawn().unwrap();
        while !is_time(child.id()) {
            sleep(Duration::from_millis(1));
        }
        assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
        let output = child.wait_with_output().unwrap();
        let reported = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(130), "{reported}");
        reported
    };
    // It listens for the signal, and fits.
    let is_listening = |id: u32| {
        let status = std::fs::read_to_string(format!("/proc/{id}/status")).unwrap_or_default();
        let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:"));
        caught.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).is_some_and(|mask| mask & 2 != 0)
    };
    std::fs::write(place.join("large.toml"), DEFAULT).unwrap();
    let reported = interrupted(&["run", "large.toml", "--out", "run"], &is_listening);
    assert!(reported.contains("interrupted; no results are kept") && !place.join("run.partial").exists(), "{reported}");

    // Those of the scene, of the reference and of the next run are there: the reference was rolled.
    let study = ["study", "scene.toml", "--fmax", "125", "--elements", "256", "--substeps", "4", "--out", "s"];
    let reported = interrupted(&study, &|_| models() >= 3);
    assert!(reported.contains("the results so far are in s.partial"), "{reported}");
    let report = std::fs::read_to_string(place.join("s.partial/study.txt")).unwrap();
    assert!(report.starts_with("INTERRUPTED after "), "{report}");
    assert!(report.contains("uncertainty of the reference, from one half as fine"), "{report}");
    assert!(!place.join("s").exists() && place.join("s.partial/study.csv").exists());
}

#[test]
fn a_smooth_road_is_refused() {
    let smooth = scene(&scene_text(32, "kind = \"smooth\"", ROLLING, "", ""));
    let options = options(&smooth, Sweep::Knobs, 64);
    let refused =
        study(&smooth, &options, Job::new(&AtomicBool::new(false), &mut Unwatched)).err().unwrap().to_string();
    assert!(refused.contains("road.kind") && refused.contains("no levels"), "{refused}");
}

#[test]
fn a_study_that_would_take_too_long_is_refused() {
    let loaded = scene(&scene_text(512, MADE, ROLLING, "history = \"modal\"\ntime_limit = 1e-3", ""));
    let options = StudyOptions::new(&loaded.scene, Sweep::Knobs);
    let refused = study(&loaded, &options, Job::new(&AtomicBool::new(false), &mut Unwatched)).err().unwrap();
    assert!(refused.to_string().contains("time_limit"), "{refused}");
}

#[test]
fn contact_over_cells_is_studied_with_its_knobs() {
    let contact = "[contact]\nzone = \"cells\"\ncells_across = 3";
    let loaded = scene(&scene_text(32, MADE, ROLLING, "pole_tolerance = 1e-3", contact));
    let found =
        study(&loaded, &options(&loaded, Sweep::Knobs, 48), Job::new(&AtomicBool::new(false), &mut Unwatched)).unwrap();
    assert_eq!(found.reference.settings.contact.cells_across, Some(6));
    let knob = |name: &str| found.knobs.iter().find(|knob| knob.name == name);
    let cells = &knob("cells").unwrap().points;
    assert!(cells.len() == 3 && cells.iter().all(|point| point.difference.worst > 0.0), "{cells:?}");
    assert!(knob("slice tolerance").is_none() && found.uncertainty.worst > 0.0);
    assert!(found.named.iter().all(|point| point.label == "the scene"));
}

#[test]
fn former_options_are_answered() {
    let folder = tempfile::tempdir().unwrap();
    let output = command(folder.path(), &["study", "scene.toml", "--runs", "12"]).output().unwrap();
    let reported = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(2) && reported.contains("`tyrewave sweep --set`"), "{reported}");
}
