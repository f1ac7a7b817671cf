//! First run of a new user: a scene to begin with, its check, settings on the command line, answers as JSON.

use std::fs;
use std::process::Output;

use serde_json::Value;
use tyrewave::internals::scene_text;

use crate::common::{names, tyrewave};

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn done(output: Output) -> String {
    assert!(output.status.success(), "{}", text(&output.stderr));
    text(&output.stdout)
}

#[test]
fn init_writes_a_valid_scene_and_overwrites_nothing() {
    let folder = tempfile::tempdir().unwrap();
    assert!(done(tyrewave(folder.path(), &["init", "trial"])).contains("tyrewave check trial/scene.toml"));
    assert_eq!(names(&folder.path().join("trial")), ["scene.schema.json", "scene.toml", "tyre.toml"]);
    let checked = done(tyrewave(folder.path(), &["check", "trial/scene.toml"]));
    assert!(checked.contains("can be run"), "{checked}");
    let short = ["numerics={ elements = 64, pole_tolerance = 1e-3 }", "rolling.duration=0.1", "rolling.warm_up=0.1"];
    let settings = short.iter().flat_map(|setting| ["--set", setting]);
    let run = ["run", "trial/scene.toml", "--report", "-q", "--set", "rolling.axle.tolerance=0.5"];
    done(tyrewave(folder.path(), &run.into_iter().chain(settings).collect::<Vec<_>>()));
    assert_eq!(names(&folder.path().join("results")), ["scene", "scene.html"], "nobody has made that folder before");
    fs::write(folder.path().join("trial/tyre.toml"), "mine").unwrap();
    fs::remove_file(folder.path().join("trial/scene.toml")).unwrap();
    let again = tyrewave(folder.path(), &["init", "trial"]);
    assert_eq!(again.status.code(), Some(2));
    assert_eq!(fs::read_to_string(folder.path().join("trial/tyre.toml")).unwrap(), "mine");
    let broken = tyrewave(folder.path(), &["check", "trial/scene.toml"]);
    assert_eq!(broken.status.code(), Some(2), "{}", text(&broken.stderr));
}

#[test]
fn check_opens_the_road_and_sees_the_limits() {
    let folder = tempfile::tempdir().unwrap();
    let rolling = "speed_kmh = 80.0\nduration = 0.1\naxle = { load = 3000.0 }";
    fs::write(folder.path().join("scene.toml"), scene_text(64, "kind = \"smooth\"", rolling, "", "")).unwrap();
    let check = |setting: &str| tyrewave(folder.path(), &["check", "scene.toml", "--set", setting]);
    assert!(check("rolling.speed_kmh=60").status.success());
    for (setting, reported) in [
        ("road={ kind = \"profile\", file = \"none.dat\" }", "none.dat"),
        ("rolling.duration=1e9", "plausible"),
        ("rolling.sped_kmh=60", "speed_kmh"),
    ] {
        let output = check(setting);
        assert_eq!(output.status.code(), Some(2), "{setting}");
        assert!(text(&output.stderr).contains(reported), "{}", text(&output.stderr));
    }
    assert_eq!(names(folder.path()), ["scene.toml"]);
}

#[test]
fn a_setting_is_as_if_the_scene_said_so() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, speed: f64| {
        let rolling = format!("speed_kmh = {speed:?}\nwarm_up = 0.05\nduration = 0.1\naxle = {{ indentation = 0.01 }}");
        fs::write(folder.path().join(name), scene_text(64, "kind = \"smooth\"", &rolling, "", "")).unwrap();
    };
    write("a.toml", 60.0);
    write("b.toml", 80.0);
    done(tyrewave(folder.path(), &["run", "a.toml", "--out", "set", "--set", "rolling.speed_kmh=80", "-q"]));
    done(tyrewave(folder.path(), &["run", "b.toml", "--out", "said", "-q"]));
    let force = |name: &str| fs::read(folder.path().join(name).join("total_force.npy")).unwrap();
    assert_eq!(force("set"), force("said"));
    let summary = |name: &str| crate::common::read_summary(&folder.path().join(name));
    assert_eq!(summary("set")["scene_sha256"], summary("said")["scene_sha256"]);
}

#[test]
fn former_commands_are_answered_with_what_replaces_them() {
    let folder = tempfile::tempdir().unwrap();
    let replaced =
        [("influence", "tyrewave mobility"), ("rules", "docs/theory.md"), ("slice", "tyrewave slices SCENE")];
    for (former, instead) in replaced {
        let answer = tyrewave(folder.path(), &[former, "a.toml"]);
        assert_eq!(answer.status.code(), Some(2), "{former}");
        let reported = String::from_utf8_lossy(&answer.stderr);
        assert!(reported.contains("has been removed") && reported.contains(instead), "{reported}");
    }
}

#[test]
fn every_table_is_json_where_that_is_wanted() {
    let folder = tempfile::tempdir().unwrap();
    let rolling = "speed_kmh = 80.0\nwarm_up = 0.05\nduration = 0.1\naxle = { indentation = 0.01 }";
    fs::write(folder.path().join("a.toml"), scene_text(64, "kind = \"smooth\"", rolling, "", "")).unwrap();
    for command in [
        &["run", "a.toml"][..],
        &["check", "a.toml"],
        &["keys", "rolling"],
        &["cache", "list"],
        &["road", "a.toml"],
        &["slices", "a.toml"],
        &["sweep", "a.toml", "--speed", "60,80"],
    ] {
        let output = done(tyrewave(folder.path(), &[command, &["--json"]].concat()));
        let parsed: Result<Value, _> = serde_json::from_str(&output);
        assert!(parsed.is_ok_and(|json| json.is_array() || json.is_object()), "{command:?}: {output}");
    }
}

#[test]
fn a_table_of_points_is_a_grid_if_a_setting_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let point = |at: i32| format!("{},{},{:.4}\n", 2 * (at / 4), 30 * (at % 4), (0.3 * f64::from(at)).sin());
    let text = (0..1200).map(point).fold("x (mm),y (mm),z (mm)\n".to_owned(), |text, line| text + &line);
    fs::write(folder.path().join("cloud.csv"), text).unwrap();
    let output = done(tyrewave(folder.path(), &["road", "cloud.csv", "--set", "road.kind=grid"]));
    assert!(output.contains("rms height"), "{output}");
}

#[test]
fn shells_get_completions_and_man_pages_of_every_command() {
    let folder = tempfile::tempdir().unwrap();
    let bash = done(tyrewave(folder.path(), &["completions", "bash"]));
    assert!(bash.contains("fit-tyre") && bash.contains("--set"));
    done(tyrewave(folder.path(), &["man", "pages"]));
    let pages = names(&folder.path().join("pages"));
    assert!(pages.contains(&"tyrewave-run.1".to_owned()) && pages.len() > 25, "{pages:?}");
}
