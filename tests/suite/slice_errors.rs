//! Stated errors of contact over slices beside contact over cells.

use std::fs;

use tyrewave::internals::{SliceErrors, StoredTable, checked, reported_slice_errors, scene, scene_text, slice_errors};
use tyrewave::response::{BandLevel, ThirdOctaveBand};
use tyrewave::scene::{DEFAULT, Scene, Setting};

use crate::common::{Results, folder_with, run, try_run, tyrewave};

const SEAL: &str = "kind = \"made\"\nseed = 3\ntexture = \"chip-seal\"";
const ROLLING: &str = "speed_kmh = 80.0\nwarm_up = 0.1\nduration = 1.2\naxle = { load = 3400.0, tolerance = 0.5 }";
const NUMERICS: &str = "history = \"modal\"\npole_tolerance = 1e-3\ntime_rule = \"sdirk2\"";
/// Segments in which the band of 25 Hz is at least two lines wide.
const HEARD: &str = "[outputs.vibration]\nbelt = false\nsegment = 0.4\n[[receiver]]\nstandard = \"cpx\"\n\
                     [radiation]\nquality = \"draft\"\nfmax = 1000.0";

/// Errors by slices and validity of the bands in a table, by its first signal.
fn bands(results: &Results, file: &str) -> Vec<(f64, Option<f64>, bool)> {
    let table = StoredTable::parse(&fs::read_to_string(results.path(file)).unwrap()).unwrap();
    let [nominal, error, valid] = ["nominal_hz", "slice_error_db", "valid"].map(|name| table.numbers(name).unwrap());
    let known = |error: f64| (!error.is_nan()).then_some(error);
    (0..nominal.len()).map(|row| (nominal[row], known(error[row]), valid[row] > 0.0)).collect()
}

#[test]
fn bands_by_slices_state_errors_and_are_valid_up_to_a_limit() {
    let of = |more: &str| run(&scene_text(256, SEAL, ROLLING, NUMERICS, &format!("[contact]\n{more}\n{HEARD}")));
    let usual = of("");
    let errors: SliceErrors = serde_json::from_value(usual.summary()["contact"]["slices"].clone()).unwrap();
    assert!(errors.macrotexture > 1e-3, "{errors:?}");
    for (file, valid_to) in [
        ("spectra.csv", errors.force_valid_to),
        ("vibration.csv", errors.force_valid_to),
        ("sound.csv", errors.sound_valid_to),
    ] {
        let found = bands(&usual, file);
        let reported = found.iter().filter(|(nominal, error, _)| *nominal >= 100.0 && error.is_some()).count();
        assert!(reported > 5, "{file}: {found:?}");
        for (nominal, error, valid) in found {
            assert!(!valid || error.is_none_or(|error| error <= 2.0), "{file}: {nominal} Hz");
            assert!(!valid || nominal <= 1.02 * valid_to, "{file}: {nominal} Hz");
            assert!(valid || nominal > 0.98 * valid_to, "{file}: {nominal} Hz");
        }
    }
    let all = of("largest_slice_error = \"60 dB\"");
    assert!(bands(&all, "spectra.csv").iter().any(|(nominal, _, valid)| *valid && *nominal >= 400.0));
    assert_eq!(fs::read(usual.path("total_force.npy")).unwrap(), fs::read(all.path("total_force.npy")).unwrap());
}

#[test]
fn cells_and_laws_that_were_not_measured_state_no_error() {
    let flat = "cells_across = 1\ncells_along = 1";
    for contact in ["zone = \"cells\"", "slices = \"half-space\"", "slice_coupling = \"explicit\"", flat] {
        let text = scene_text(64, SEAL, ROLLING, NUMERICS, &format!("[contact]\n{contact}"));
        assert_eq!(slice_errors(&checked(&scene(&text)).unwrap()), None, "{contact}");
    }
    let smooth = scene_text(64, "kind = \"smooth\"", ROLLING, NUMERICS, "");
    assert_eq!(slice_errors(&checked(&scene(&smooth)).unwrap()), None);
    let folder = folder_with(&scene_text(
        64,
        SEAL,
        ROLLING,
        NUMERICS,
        "[contact]\nzone = \"cells\"\n\
        largest_slice_error = \"3 dB\"",
    ));
    let answer = tyrewave(folder.path(), &["check", "scene.toml"]);
    assert!(!answer.status.success() && String::from_utf8_lossy(&answer.stderr).contains("largest_slice_error"));
}

#[test]
fn plan_and_run_say_where_slices_end_and_that_a_wish_is_missed() {
    let text = scene_text(64, SEAL, ROLLING, "preset = \"draft\"\nfmax = 1000.0", "").replace("elements = 64\n", "");
    let folder = folder_with(&text);
    let printed = |arguments: &[&str]| {
        let answer = tyrewave(folder.path(), arguments);
        format!("{}{}", String::from_utf8_lossy(&answer.stdout), String::from_utf8_lossy(&answer.stderr))
    };
    for arguments in [&["plan", "scene.toml"][..], &["run", "scene.toml", "--set", "rolling.duration=0.3"]] {
        let printed = printed(arguments);
        let words = printed.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(words.contains("numerics.fmax = 1000 Hz is not reached"), "{words}");
        assert!(words.contains("contact.zone = \"cells\""), "{words}");
    }
}

/// Slices beside finer cells on a road at a speed \[km/h\]: the largest excess of a force level's error over the stated
/// one, of bands from 100 Hz to `highest` \[dB\]. Elements of slices and of cells, and the time after 0.2 s \[s\].
fn excess(road: &str, speed: f64, law: &str, elements: [usize; 2], duration: f64, highest: ThirdOctaveBand) -> f64 {
    let run = |elements: usize, more: &[&str]| -> (Vec<BandLevel>, Option<SliceErrors>) {
        let of_run = [
            format!("road={{ {road} }}"),
            format!("rolling.speed_kmh={speed:?}"),
            format!("rolling.duration={duration:?}"),
            format!("numerics.elements={elements}"),
        ];
        let fixed =
            ["rolling.warm_up=0.2", "outputs.plots=false", "outputs.arrays=false", "numerics.pole_tolerance=1e-4"];
        let all = of_run.iter().map(String::as_str).chain(fixed).chain(more.iter().copied());
        let settings: Vec<Setting> = all.map(|text| Setting::parse(text).unwrap()).collect();
        let results = try_run(&Scene::from_str_with(DEFAULT, "default", &settings).unwrap()).unwrap();
        (results.force_levels(), reported_slice_errors(&results.report.summary.contact).cloned())
    };
    let (slices, errors) = run(elements[0], &[&format!("contact.slices={law}")]);
    let (cells, _) = run(elements[1], &["contact.zone=cells", "numerics.contact_tolerance=1e-5"]);
    let errors = errors.unwrap();
    let mut largest = f64::NEG_INFINITY;
    for (slices, cells) in slices.iter().zip(&cells) {
        let (Some(stated), true) = (errors.force(slices.band), slices.band <= highest) else { continue };
        let found = slices.level - cells.level;
        println!("{road}, {speed} km/h, {law}, {:>5} Hz: {found:+.1} dB, stated {stated:.1} dB", slices.band.label());
        largest = largest.max(found.abs() - stated);
    }
    largest
}

/// Cells of 3.8 mm are fine enough for texture waves of 76 mm: 400 Hz at this speed.
#[test]
fn slices_keep_their_stated_error_on_another_seed() {
    let road = "kind = \"made\", texture = \"sma-8\", seed = 23";
    let found = excess(road, 110.0, "winkler", [512, 512], 0.8, ThirdOctaveBand(-4));
    assert!(found <= 1.0, "{found}");
}

#[test]
#[ignore = "four runs over cells of 1 mm, four over slices"]
fn slices_keep_their_stated_errors_on_other_roads_and_seeds() {
    for (texture, seed, speed, law) in [
        ("dac-11", 21, 110.0, "winkler"),
        ("iso-10844", 4, 80.0, "winkler"),
        ("chip-seal", 22, 80.0, "pressed"),
        ("chip-seal", 22, 50.0, "winkler"),
    ] {
        let road = format!("kind = \"made\", texture = \"{texture}\", seed = {seed}");
        let found = excess(&road, speed, law, [1024, 2048], 0.6, ThirdOctaveBand(2));
        // Of 240 bands of such runs 94 % are within 1 dB, force within 1.8 dB.
        assert!(found <= 1.8, "{texture} at {speed} km/h, {law}: {found}");
    }
}
