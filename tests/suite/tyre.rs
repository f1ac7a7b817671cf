//! `tyrewave tyre`: modes against known resonances, loads against the contact at rest and a run, and the command.

use std::fs;

use serde_json::Value;
use tyrewave::internals::{LoadedTyre, Motion, StaticTyre, modes, plate_tyre, radial_compliance, scene, scene_text};
use tyrewave::tyre::{Field, InfluenceSum};

use crate::common::{names, run, tyrewave};

/// Resonances by an independent calculation of the surface compliance for n = 0..=6, m = 1 \[Hz\].
const RESONANCES: [f64; 7] = [91.5, 95.8, 107.8, 125.5, 147.5, 172.5, 200.0];

#[test]
fn modes_of_the_plate_tyre_lie_at_its_resonances() {
    let tyre = plate_tyre();
    let found = modes(&tyre, 6, 1, 300.0).unwrap();
    assert_eq!(found.unconfirmed, []);
    let step = 0.02;
    let frequencies: Vec<f64> = (0..12_000).map(|k| 60.0 + step * f64::from(k)).collect();
    let (m, rows) = radial_compliance(&tyre, 6, &frequencies);
    assert_eq!((m, found.confirmed.len()), (1, 7), "{found:?}");
    for (n, (mode, resonance)) in found.confirmed.iter().zip(RESONANCES).enumerate() {
        let highest = (0..rows.len()).max_by(|&a, &b| rows[a][n].total_cmp(&rows[b][n])).unwrap();
        let (peak, frequency, damping) = (frequencies[highest], mode.frequency(), mode.damping());
        println!("n = {n}: mode {frequency:.3} Hz, damping {damping:.4}, peak {peak:.2} Hz, expected {resonance} Hz");
        assert_eq!((mode.n, mode.m, mode.motion), (n, 1, Motion::Radial));
        // The list's values lie on a grid of a quarter of a hertz, some rounded to 0.1 Hz.
        assert!((peak - resonance).abs() <= 0.125 + 0.05 + step, "n = {n}: peak {peak}, expected {resonance}");
        // An oscillator's peak lies zeta^2/2 below |Im s|, 5e-4 at most; what the other modes and the tread add to the
        // compliance is below a twentieth of the peak and shifts it by less than that part of the half-width.
        let allowed = frequency * (0.5 * damping * damping + 0.05 * damping) + step;
        assert!((peak - frequency).abs() <= allowed, "n = {n}: peak {peak}, mode {frequency}, {allowed} allowed");
    }
}

#[test]
fn a_tyre_file_is_checked_and_described_but_not_run() {
    let folder = crate::common::folder_with(&small_scene());
    fs::write(folder.path().join("plate.toml"), toml::to_string(&plate_tyre()).unwrap()).unwrap();
    let text = |output: &[u8]| String::from_utf8_lossy(output).into_owned();
    let checked = tyrewave(folder.path(), &["check", "scene.toml", "plate.toml"]);
    let table = text(&checked.stdout);
    assert!(checked.status.success() && table.contains("can be run"), "{table}{}", text(&checked.stderr));
    assert!(table.lines().any(|line| line.contains("plate.toml") && line.contains("a tyre")), "{table}");
    let run = tyrewave(folder.path(), &["run", "plate.toml"]);
    let message = text(&run.stderr);
    assert_eq!(run.status.code(), Some(2));
    assert!(message.contains("the file of a tyre") && message.contains("tyre = \"plate.toml\""), "{message}");
    assert_eq!(message.lines().count(), 1, "{message}");
    let few = ["--waves=2", "--lateral=1", "--highest=150", "--loads=300", "--points=4", "--patch=20"];
    let described = tyrewave(folder.path(), &[&["tyre", "plate.toml"][..], &few].concat());
    let reported = text(&described.stdout);
    assert!(
        described.status.success() && reported.starts_with("Tyre of plate.toml\n"),
        "{reported}{}",
        text(&described.stderr)
    );
    assert!(folder.path().join("results/plate-tyre/tyre.json").is_file());
    // A mistake in it is reported with its place there.
    let wrong = toml::to_string(&plate_tyre()).unwrap().replacen("width =", "widht =", 1);
    fs::write(folder.path().join("plate.toml"), wrong).unwrap();
    let message = text(&tyrewave(folder.path(), &["check", "plate.toml"]).stderr);
    assert!(message.contains("plate.toml:") && message.contains("did you mean `width`?"), "{message}");
}

const ROLLING: &str = "speed_kmh = 80.0\nwarm_up = 0.3\nduration = 1.0\naxle = { indentation = 0.012, ramp = 0.05 }";

fn small_scene() -> String {
    scene_text(64, "kind = \"made\"", ROLLING, "", "")
}

#[test]
fn a_load_deflects_the_tyre_as_the_contact_at_rest() {
    let scene = scene(&small_scene()).scene;
    let standing = LoadedTyre::new(&scene);
    let row = InfluenceSum::new(&scene.tyre, &scene.numerics, 1e5).static_row(Field::Surface);
    let other = StaticTyre { influence: &row, circumference: scene.tyre.circumference };
    for load in [500.0, 3433.5, 6000.0] {
        let found = standing.under(load).unwrap();
        assert!((found.force / load - 1.0).abs() <= 1e-9, "{found:?}");
        // The load is met to 1e-9.
        let expected = other.at(found.indentation).unwrap();
        assert!((expected.force / load - 1.0).abs() < 1e-8, "{found:?} {expected:?}");
    }
    let curve = standing.curve(4000.0, 30).unwrap();
    assert!(curve[0].force > 0.0 && curve.last().unwrap().force > 4000.0);
    for pair in curve.windows(2) {
        let secant = (pair[1].force - pair[0].force) / (pair[1].indentation - pair[0].indentation);
        assert!(pair[1].force > pair[0].force && pair[1].length >= pair[0].length, "{pair:?}");
        // A patch that only grows: the force is convex, its slope lies between those of the ends.
        assert!(secant > 0.999 * pair[0].stiffness && secant < 1.001 * pair[1].stiffness, "{pair:?}");
    }
}

#[test]
fn the_command_shows_modes_loads_and_mobility() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.toml"), small_scene()).unwrap();
    let options = ["tyre", "scene.toml", "--waves", "2", "--patch", "50", "--points", "20", "--out", "tyre"];
    let output = tyrewave(folder.path(), &options);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    for words in
        ["m = 1 radial", "91.6 (2.2)", "300 kg", "400 kg", "patch, standing", "50 mm", "1000 Hz", "results in tyre"]
    {
        assert!(text.contains(words), "{words}:\n{text}");
    }
    let files =
        ["compliance.svg", "dispersion.svg", "load_deflection.svg", "loads.csv", "mobility.csv", "mobility.svg"];
    let more = ["mobility_phase.svg", "modes.csv", "patch_length.svg", "summary.json", "tyre.html", "tyre.json"];
    assert_eq!(names(&folder.path().join("tyre")), [&files[..], &more[..]].concat());

    let more = ["--rolling", "--loads", "300kg,4000N", "--json", "-q"];
    let output = tyrewave(folder.path(), &[&options[..], &more[..]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(output.stdout, fs::read(folder.path().join("tyre/tyre.json")).unwrap());
    let number = |value: &Value| value.as_f64().unwrap();
    let first = &answer["modes"][0];
    assert_eq!((&first["n"], &first["m"], &first["motion"]), (&0.into(), &1.into(), &"radial".into()));
    assert!((number(&first["frequency"]) - RESONANCES[0]).abs() < 0.1);
    assert_eq!(answer["mobility"]["patches"][0]["level"].as_array().unwrap().len(), 20);
    let loads = answer["loads"].as_array().unwrap();
    assert!((number(&loads[0]["load"]) - 2943.0).abs() < 1e-5 && (number(&loads[1]["load"]) - 4000.0).abs() < 1e-5);
    // What a run of the same says.
    let rolling = "speed_kmh = 80.0\nwarm_up = 0.3\nduration = 0.1\naxle = { load = 4000.0 }";
    let results = run(&scene_text(64, "kind = \"smooth\"", rolling, "", ""));
    let expected = number(&results.summary()["outcome"]["mean_contact_length"]);
    assert!((number(&loads[1]["rolling_patch_length"]) - expected).abs() < 1e-12, "{loads:?} {expected}");
}

#[test]
fn mistakes_are_answered_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.toml"), small_scene()).unwrap();
    fs::write(folder.path().join("wrong.toml"), small_scene().replace("contact_width", "contact_with")).unwrap();
    for (arguments, code, words) in [
        (&["scene.toml", "--loads", "heavy"][..], 2, ["\"heavy\"", "3400N"]),
        (&["scene.toml", "--loads", "100000"], 1, ["981000 N", "indentation"]),
        (&["scene.toml", "--highest", "0"], 2, ["--highest", "positive"]),
        (&["wrong.toml"], 2, ["contact_with", "wrong.toml:"]),
        (&["nowhere.toml"], 2, ["nowhere.toml", "there is no file"]),
    ] {
        let output = tyrewave(folder.path(), &[&["tyre"], arguments].concat());
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {message}");
        for word in words {
            assert!(message.contains(word), "{arguments:?}: no {word} in\n{message}");
        }
        assert!(output.stdout.is_empty() && !folder.path().join("results/scene-tyre/summary.json").exists());
    }
}
