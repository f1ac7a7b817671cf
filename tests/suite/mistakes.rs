//! Plausible mistakes in scenes, units, roads, tyres and commands, and what the program answers: each is known before
//! anything is run. Of twenty the whole answers of `tyrewave check` stand in a file, of twenty more their key words.
//!
//! `TYREWAVE_MISTAKES=1 cargo test twenty_plausible` writes `twenty_mistakes.txt` anew.

use std::fmt::Write;
use std::fs;

use tyrewave::internals::replaced;

use crate::common::{folder_with, names, tyrewave};

/// Answers of the program.
const ANSWERS: &str = include_str!("twenty_mistakes.txt");
const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/suite/twenty_mistakes.txt");

/// A scene without a mistake.
const SCENE: &str = r#"title = "Chip seal, 80 km/h"
tyre = "car.toml"
[road]
kind = "made"
texture = "dac-11"
[rolling]
speed_kmh = 80.0
duration = 3.5
axle = { load = 3400.0 }
[numerics]
preset = "draft"
fmax = 1000.0
[[receiver]]
name = "beside"
standard = "coast-by"
[[receiver]]
name = "close"
standard = "cpx"
[radiation]
quality = "draft"
"#;

const MADE: &str = "kind = \"made\"\ntexture = \"dac-11\"";

/// Mistakes: the words that were meant, and those that were written.
const MISTAKES: [(&str, &str, &str); 20] = [
    ("a slip in a key", "speed_kmh = 80.0", "sped_kmh = 80.0"),
    ("a decimal comma", "duration = 3.5", "duration = 3,5"),
    ("a word without quotes", "\"draft\"\nfmax", "draft\nfmax"),
    ("a word that is nearly right", "standard = \"coast-by\"", "standard = \"coastby\""),
    ("a load in kN", "load = 3400.0", "load = 3.4"),
    ("an indentation in dm", "{ load = 3400.0 }", "{ indentation = 0.25 }"),
    ("a distance in mm", "standard = \"coast-by\"", "standard = \"coast-by\"\ndistance = 7500.0"),
    ("a microphone in the tyre", "standard = \"cpx\"", "position = [0.1, 0.0, 0.3]"),
    ("one name for two receivers", "\"close\"", "\"beside\""),
    ("a name that a spreadsheet computes", "\"close\"", "\"=close\""),
    ("a title with an escape sequence", "Chip seal", "\\u001b[31mChip seal"),
    ("a run too short for any sound", "duration = 3.5", "duration = 0.3"),
    ("a run too short for a passage", "duration = 3.5", "duration = 1.0"),
    ("a speed above that of the belt's waves", "speed_kmh = 80.0", "speed_kmh = 300.0"),
    ("fewer elements than fmax asks for", "fmax = 1000.0", "fmax = 1000.0\nelements = 128"),
    ("more elements than any tyre needs", "fmax = 1000.0", "fmax = 1000.0\nelements = 100000000"),
    ("a road that is not there", MADE, "kind = \"profile\"\nfile = \"station.dat\""),
    ("a road of another kind", MADE, "kind = \"profile\"\nfile = \"cobbles.crg\""),
    ("a profile without its units", MADE, "kind = \"profile\"\nfile = \"line.csv\""),
    (
        "a road shorter than the run",
        MADE,
        "kind = \"profile\"\nfile = \"line.csv\"\ndistance_unit = \"mm\"\nheight_unit = \"mm\"",
    ),
];

/// Makes a folder with a scene and the files that scenes here name.
fn folder(scene: &str) -> tempfile::TempDir {
    let folder = folder_with(scene);
    let place = folder.path();
    let shipped = |name: &str| concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/").to_owned() + name;
    fs::copy(shipped("tyres/car.toml"), place.join("car.toml")).unwrap();
    fs::copy(shipped("roads/cobbles.crg"), place.join("cobbles.crg")).unwrap();
    let line = (0..400).map(|row| format!("{row},{}\n", f64::from(row % 7) / 10.0));
    fs::write(place.join("line.csv"), format!("x,z\n{}", line.collect::<String>())).unwrap();
    folder
}

/// Further mistakes: the command line, and words of the answer.
const COMMANDS: [(&str, &[&str], &[&str]); 20] = [
    ("a load in kg", &["check", "scene.toml", "--set", "rolling.axle.load=350"], &["350 kg weigh 3434 N"]),
    (
        "a load ten times as large",
        &["check", "scene.toml", "--set", "rolling.axle.load=34000"],
        &["from 580 to 14000 N"],
    ),
    ("a load in N for kg", &["tyre", "car.toml", "--loads", "3400"], &["33354 N"]),
    ("a load that is a word", &["tyre", "car.toml", "--loads", "heavy"], &["kilograms as 350", "3400N"]),
    (
        "air without pressure",
        &["check", "scene.toml", "--set", "tyre.cavity.density=1.2"],
        &["tyre.cavity.density", "air at 220000 Pa over the atmosphere has 3.82"],
    ),
    (
        "an angle of cords in radians",
        &["check", "scene.toml", "--set", "tyre.layers[1].cords[0].angle_deg=0.436"],
        &["angle_deg", "from 1.6 to 90 degrees"],
    ),
    (
        "a pressure in bar",
        &["check", "scene.toml", "--set", "tyre.inflation.pressure=2.2"],
        &["tyre.inflation.pressure", "2.2 Pa is implausible"],
    ),
    (
        "a modulus in MPa",
        &["check", "scene.toml", "--set", "tyre.layers[2].material.modulus=5.5"],
        &["material.modulus", "5.5 Pa is implausible"],
    ),
    (
        "a thickness in mm",
        &["check", "scene.toml", "--set", "tyre.layers[2].thickness=13"],
        &["thickness", "13 m is implausible"],
    ),
    (
        "microphones in mm",
        &["check", "scene.toml", "--set", "receiver[1]={ position = [200.0, 200.0, 100.0] }"],
        &["receiver[1].position[0]", "200 m is implausible"],
    ),
    (
        "a warm-up longer than the run",
        &["check", "scene.toml", "--set", "rolling.warm_up=50"],
        &["rolling.warm_up: 50 s are simulated before the 3.5 s that are evaluated"],
    ),
    (
        "a warm-up in which no height is found",
        &["check", "scene.toml", "--set", "rolling.warm_up=0.01"],
        &["rolling.warm_up", "to find the height of its load", "at least"],
    ),
    (
        "elements that nobody can count",
        &["check", "scene.toml", "--set", "numerics.elements=1000000000000000000"],
        &["numerics.elements", "at most 1000000"],
    ),
    (
        "cells finer than any texture",
        &["check", "scene.toml", "--set", "contact.cells_across=100000"],
        &["contact.cells_across", "at most 10000"],
    ),
    (
        "pitches beyond counting",
        &["check", "scene.toml", "--set", "tread_pattern={ pitches = 4000000000 }"],
        &["tread_pattern.pitches", "at most 1000"],
    ),
    ("friction in percent", &["check", "scene.toml", "--set", "friction={ mu = 90 }"], &["friction.mu", "at most 8"]),
    (
        "a spin in degrees",
        &["check", "scene.toml", "--set", "friction={ mu = 0.9, creep = { spin = 1000.0 } }"],
        &["friction.creep.spin", "to 10 1/m is plausible"],
    ),
    (
        "a setting without its value",
        &["check", "scene.toml", "--set", "rolling.speed_kmh"],
        &["is not a setting", "KEY=VALUE"],
    ),
    ("a command with a slip", &["chek", "scene.toml"], &["'chek'", "'check'"]),
    ("a scene that is not there", &["run", "scen.toml"], &["scen.toml", "there is no file"]),
];

#[test]
fn answers_to_forty_plausible_mistakes() {
    assert_eq!(MISTAKES.len() + COMMANDS.len(), 40);
    let folder = folder(SCENE);
    let place = folder.path();
    let before = names(place);
    for (what, arguments, words) in COMMANDS {
        let output = tyrewave(place, arguments);
        let printed =
            [&output.stdout, &output.stderr].map(|printed| String::from_utf8_lossy(printed).into_owned()).concat();
        for word in words {
            assert!(printed.contains(word), "{what}: no \"{word}\" in\n{printed}");
        }
        assert!(!printed.contains("panicked"), "{what}: {printed}");
        assert_eq!(output.status.success(), printed.contains("warning: "), "{what}: {printed}");
        assert_eq!(names(place), before, "{what}");
    }
}

#[test]
fn twenty_plausible_mistakes_are_answered_before_a_run() {
    let mut answers = String::new();
    let scenes = [("no mistake", "", "")].iter().chain(&MISTAKES);
    for (number, (what, meant, written)) in scenes.enumerate() {
        let folder = folder(&replaced(SCENE, &[(meant, written)]));
        let place = folder.path();
        let before = names(place);
        let output = tyrewave(place, &["check", "scene.toml"]);
        assert_eq!(names(place), before, "{what}");
        let (reported, error) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
        let warnings = reported.lines().filter(|line| line.contains("warning: ")).map(|line| format!("{line}\n"));
        let printed = format!("{}{error}", warnings.collect::<String>());
        assert_eq!(output.status.success(), error.is_empty(), "{what}: {error}");
        let printed = [place.to_owned(), place.canonicalize().unwrap()]
            .iter()
            .fold(printed, |printed, place| printed.replace(&format!("{}/", place.display()), ""));
        if number == 0 {
            assert_eq!(printed, "", "{what}");
            continue;
        }
        let written = written.replace('\n', "\n   ");
        write!(answers, "{number}. {what}:\n\n   {written}\n\n{}\n", printed.trim_end()).unwrap();
        answers.push('\n');
    }
    if std::env::var_os("TYREWAVE_MISTAKES").is_some() {
        fs::write(FILE, &answers).unwrap();
    } else {
        assert_eq!(answers, ANSWERS);
    }
}
