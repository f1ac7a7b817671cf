//! Sections of the road, `outputs.sections`: their levels against those of the same steps, kill and resume, refusals.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use tyrewave::Scene;
use tyrewave::internals::{scene, scene_text};
use tyrewave::response::PowerSpectrum;
use tyrewave::run::{Job, Unwatched, run_in_memory};

use crate::common::{command, names, read_summary, run, tyrewave};

const MADE: &str = "kind = \"made\"\nseed = 3\ntexture = \"rough-asphalt\"";
const MICROPHONES: &str = "[[receiver]]\nstandard = \"cpx\"\n[[receiver]]\nposition = [0.5, 1.0, 0.3]\nname = \"ear\"\n\
                           [radiation]\nquality = \"draft\"\naudio = false";

/// A run over a road with sections and microphones.
fn text(road: &str, duration: f64, outputs: &str, sound: &str) -> String {
    let rolling = format!(
        "speed_kmh = 80.0\nwarm_up = 0.1\nduration = {duration:?}\naxle = {{ load = 3000.0, tolerance = 0.9 }}"
    );
    let more = format!("[outputs]\nplots = false\n{outputs}\n{sound}");
    scene_text(64, road, &rolling, "history = \"modal\"\npole_tolerance = 1e-3", &more)
}

/// Value, standard error and validity by section, quantity, receiver, and band of force or texture.
type Values = BTreeMap<(u64, String, String, String), (f64, Option<f64>, bool)>;

fn values(table: &str) -> Values {
    let mut found = Values::new();
    for row in csv::Reader::from_reader(table.as_bytes()).records() {
        let row = row.unwrap();
        let key = (row[0].parse().unwrap(), row[4].to_owned(), row[5].to_owned(), format!("{}{}", &row[6], &row[7]));
        let value = (row[8].parse().unwrap_or(f64::NEG_INFINITY), row[10].parse().ok(), &row[11] == "1");
        assert_eq!(found.insert(key, value), None, "{row:?} comes twice");
    }
    found
}

fn key(section: u64, quantity: &str, receiver: &str, band: &str) -> (u64, String, String, String) {
    (section, quantity.to_owned(), receiver.to_owned(), band.to_owned())
}

#[test]
fn levels_of_a_section_are_those_of_its_steps() {
    let length = 9.0;
    let results = run(&text(MADE, 1.5, "sections = 9.0", ""));
    let found = values(&fs::read_to_string(results.path("sections.csv")).unwrap());
    let (time, force) = (results.array("time.npy"), results.array("total_force.npy"));
    let step = time[1] * 80.0 / 3.6;
    let warm_up = (0.1 / time[1]).round() as usize;
    let whole = results.force_levels();
    let recorded = PowerSpectrum::of(&force[warm_up..], time[1], Some(0.5)).unwrap().third_octaves(20.0, 1.0);
    let begin = |section: u64| warm_up + (section as f64 * length / step).round() as usize;
    assert_eq!(found.keys().next_back().unwrap().0, 3, "33 m have three sections of 9 m");
    for section in 0..3 {
        let steps = begin(section)..begin(section + 1);
        let mean = force[steps.clone()].iter().sum::<f64>() / steps.len() as f64;
        let (reported, ..) = found[&key(section + 1, "mean_force", "", "")];
        assert!((reported / mean - 1.0).abs() < 1e-12, "{reported} {mean}");
        let spectrum = PowerSpectrum::of(&force[steps], time[1], Some(0.5)).unwrap();
        let mut sum = 0.0;
        for (level, (whole, recorded)) in spectrum.third_octaves(20.0, 1.0).iter().zip(whole.iter().zip(&recorded)) {
            let band = level.band.nominal_frequency().to_string();
            let (reported, error, valid) = found[&key(section + 1, "force_level", "", &band)];
            // What the mean over a step takes from a band of the whole run is taken from that of a section.
            let expected = level.level + whole.level - recorded.level;
            let near_nyquist = 0.02 * (level.band.nominal_frequency() / 100.0).powi(2);
            assert!((reported - expected).abs() < near_nyquist.max(0.02), "{band} Hz: {reported} {expected}");
            let expected = spectrum.standard_error([level.band]).unwrap();
            assert!((error.unwrap() / expected - 1.0).abs() < 0.05, "{band} Hz");
            sum += if valid { 10.0_f64.powf(0.1 * reported) } else { 0.0 };
        }
        let (overall, error, _) = found[&key(section + 1, "force_level", "", "")];
        assert!((overall - 10.0 * sum.log10()).abs() < 1e-9 && error.unwrap() > 0.0);
        let (depth, error, valid) = found[&key(section + 1, "mean_profile_depth", "", "")];
        assert!((0.1..3.0).contains(&depth) && error.unwrap() < depth && valid, "{depth} mm");
        assert!(found[&key(section + 1, "texture_level", "", "50")].2, "9 m have 180 wavelengths of 50 mm");
    }
}

#[test]
fn one_section_has_the_sound_of_the_whole_run() {
    // As long as the pressures of the run, from 3/8 of a block on.
    let whole = run(&text(MADE, 6.0, "arrays = false", MICROPHONES));
    let cut = run(&text(MADE, 6.0, "arrays = false\nsections = 20.0", MICROPHONES));
    let found = values(&fs::read_to_string(cut.path("sections.csv")).unwrap());
    let receivers = whole.summary()["sound"]["receivers"].clone();
    for receiver in receivers.as_array().unwrap() {
        let name = receiver["name"].as_str().unwrap();
        let levels = found.iter().filter(|((_, quantity, of, _), _)| quantity == "sound_level_a" && of == name);
        let levels: Vec<(f64, f64)> = levels.map(|(_, (level, error, _))| (*level, error.unwrap())).collect();
        assert!((3..=6).contains(&levels.len()), "{levels:?}");
        let mean = 10.0
            * (levels.iter().map(|(level, _)| 10.0_f64.powf(0.1 * level)).sum::<f64>() / levels.len() as f64).log10();
        let expected = receiver["level_a"].as_f64().unwrap();
        let error = levels.iter().map(|(_, error)| error * error).sum::<f64>().sqrt() / levels.len() as f64;
        println!("{name}: {mean:.2} +- {error:.2} dB(A) of sections {levels:.2?}, {expected:.2} dB(A) of the run");
        // Together they are the run but for its ends.
        assert!((mean - expected).abs() < 3.0 * error, "{name}: {mean} {expected}");
    }
    // Levels of the run are those of one without sections.
    let table = |results: &crate::common::Results| fs::read(results.path("sound.csv")).unwrap();
    assert_eq!(table(&whole), table(&cut));
    assert!(!names(&whole.path("")).contains(&"sections.csv".to_owned()), "off means no file");
}

/// A checkpoint every few milliseconds, until the run is killed after some of them; then it is resumed.
#[cfg(unix)]
#[test]
fn a_killed_run_ends_in_the_same_table() {
    let outputs = "arrays = false\nsections = 4.0\ncheckpoint_interval = 0.004";
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    let road = "kind = \"made\"\nseed = 4";
    fs::write(place.join("scene.toml"), text(road, 12.0, outputs, MICROPHONES).replace("plots = false", "")).unwrap();
    let whole = tyrewave(place, &["run", "scene.toml", "--out", "whole"]);
    assert!(whole.status.success(), "{}", String::from_utf8_lossy(&whole.stderr));
    let table = |folder: &str| fs::read(place.join(folder).join("sections.csv")).unwrap();
    let partial = || names(place).into_iter().find(|name| name.starts_with("cut.partial"));
    let mut killed = 0;
    for rows in [20, 2000, 4000] {
        let arguments: &[&str] =
            if partial().is_some() { &["resume", "cut"] } else { &["run", "scene.toml", "--out", "cut"] };
        let mut run = command(place, arguments).spawn().unwrap();
        let has_rows = |place: &Path| {
            let written =
                |name: &str| fs::read_to_string(place.join(name)).is_ok_and(|text| text.lines().count() > rows);
            written("sections.csv") && place.join("checkpoint").exists()
        };
        while run.try_wait().unwrap().is_none() && !partial().is_some_and(|name| has_rows(&place.join(name))) {
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        if run.try_wait().unwrap().is_none() {
            run.kill().unwrap();
            killed += 1;
        }
        run.wait().unwrap();
    }
    assert!(killed > 0, "never killed");
    if partial().is_some() {
        let resumed = tyrewave(place, &["resume", "cut", "--threads", "1"]);
        assert!(resumed.status.success(), "{}", String::from_utf8_lossy(&resumed.stderr));
    }
    println!("{killed} kills, {} rows", String::from_utf8(table("whole")).unwrap().lines().count());
    assert!(table("cut") == table("whole"), "the tables differ");
    let picture = |folder: &str| fs::read_to_string(place.join(folder).join("sections.svg")).unwrap();
    assert_eq!(picture("cut"), picture("whole"));
    for text in ["Force", "Sound", "Profile depth", "Texture", "cpx", "ear"] {
        assert!(picture("whole").contains(text), "{text}");
    }
    assert_eq!(read_summary(&place.join("cut"))["complete"], true);
}

#[test]
fn a_run_in_memory_has_the_same_table() {
    let text = text(MADE, 1.0, "arrays = false\nsections = 5.0", "");
    let written = fs::read(run(&text).path("sections.csv")).unwrap();
    let in_memory = run_in_memory(&scene(&text), Job::new(&AtomicBool::new(false), &mut Unwatched)).unwrap();
    assert!(in_memory.files["sections.csv"] == written, "the tables differ");
}

#[test]
fn a_smooth_road_has_no_texture() {
    let results = run(&text("kind = \"smooth\"", 0.5, "sections = 3.0", ""));
    let found = values(&fs::read_to_string(results.path("sections.csv")).unwrap());
    assert!(found.keys().all(|(_, quantity, ..)| quantity.contains("force")) && !found.is_empty());
}

#[test]
fn sections_that_cannot_be_are_refused() {
    let refused = |outputs: &str| Scene::from_str(&text(MADE, 1.0, outputs, ""), "scene").unwrap_err().to_string();
    let reported = refused("sections = 30.0");
    for words in ["outputs.sections", "rolls 22.22 m", "less than one section of 30 m", "at least 1.350 s"] {
        assert!(reported.contains(words), "{words}: {reported}");
    }
    let reported = refused("sections = 0.2");
    assert!(reported.contains("0.2") && reported.contains("0.5"), "{reported}");
    let cells = text(MADE, 1.0, "sections = 9.0\nlevels = { standard_error = 1.0 }", "")
        + "\n[contact]\nzone = \"cells\"\ncells_across = 3\n";
    let reported = Scene::from_str(&cells, "scene").unwrap_err().to_string();
    assert!(reported.contains("outputs.sections") && reported.contains("or outputs.levels"), "{reported}");
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.toml"), text(MADE, 1.0, "sections = 0.5", "")).unwrap();
    let output = tyrewave(folder.path(), &["run", "scene.toml", "--out", "out"]);
    let reported = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{reported}");
    assert!(reported.contains("hardly longer than the patch") && reported.contains("ten patches"), "{reported}");
}
