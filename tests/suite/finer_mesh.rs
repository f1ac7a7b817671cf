//! Levels of a finer mesh, `outputs.levels`: against runs over that mesh, and what is refused beside them.

use std::collections::BTreeMap;
use std::fs;

use tyrewave::internals::{add, edit, scene, scene_text};
use tyrewave::{Plan, Simulation};

use crate::common::{Results, run};

const ROAD: &str = "kind = \"made\"\nseed = 3";
const LEVELS: &str = "levels = { standard_error = 0.5 }";
pub(crate) const CPX: &str = "[[receiver]]\nstandard = \"cpx\"\n[radiation]\nfmax = 500.0\nquality = \"draft\"\n";

/// Some seconds over cells of 1/`elements` of the tyre, three across.
pub(crate) fn over(elements: usize, seconds: f64, outputs: &str, more: &str) -> String {
    let rolling = format!(
        "speed_kmh = 80.0\nwarm_up = 0.2\nduration = {seconds:?}\naxle = {{ indentation = 0.012, ramp = 0.05 }}"
    );
    let contact = format!(
        "[contact]\nzone = \"cells\"\ncells_across = 3\n[outputs]\nplots = false\narrays = false\n{outputs}\n{more}"
    );
    let text = scene_text(elements, ROAD, &rolling, "pole_tolerance = 1e-3\ncontact_tolerance = 1e-4", &contact);
    edit(&text, &[("numerics.lateral_terms", "9")])
}

/// Columns of a table of third octaves by nominal frequency \[Hz\], 100 to 500 Hz; of the only receiver.
pub(crate) fn bands(results: &Results, file: &str, column: &str) -> BTreeMap<i32, f64> {
    let table = fs::read_to_string(results.path(file)).unwrap();
    let mut lines = table.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let place = |name: &str| header.iter().position(|column| *column == name).unwrap();
    let (nominal, wanted) = (place("nominal_hz"), place(column));
    let rows = lines.map(|line| line.split(',').collect::<Vec<_>>());
    let number = |text: &str| text.parse::<f64>().unwrap();
    rows.map(|row| (number(row[nominal]) as i32, number(row[wanted])))
        .filter(|(nominal, _)| (100..=500).contains(nominal))
        .collect()
}

fn largest_difference(one: &BTreeMap<i32, f64>, other: &BTreeMap<i32, f64>) -> f64 {
    one.iter().map(|(band, level)| (level - other[band]).abs()).fold(0.0, f64::max)
}

/// A run over 96 elements whose levels are those of 192: nearer to a run over these than without the correction.
#[test]
fn levels_of_force_and_sound_are_those_of_the_finer_mesh() {
    let of = |elements, outputs: &str| run(&over(elements, 2.0, outputs, CPX));
    let [coarse, fine, corrected] = [of(96, ""), of(192, ""), of(96, LEVELS)];
    for (file, level) in [("spectra.csv", "level_db_re_1n"), ("sound.csv", "level_db_re_20upa")] {
        let [coarse, fine, levels] = [&coarse, &fine, &corrected].map(|results| bands(results, file, level));
        let [before, after] = [&coarse, &levels].map(|levels| largest_difference(levels, &fine));
        println!("{file}: largest difference from the finer mesh {before:.2} dB, corrected {after:.2} dB");
        assert!(before > 1.0 && after < 0.6 * before, "{file}: {before} {after}");
        // What is added is told, and each level has its standard error.
        let added = bands(&corrected, file, "correction_db");
        let errors = bands(&corrected, file, "standard_error_db");
        assert!(added.iter().all(|(band, added)| (levels[band] - coarse[band] - added).abs() < 1e-6), "{added:?}");
        let holds = |(band, error): (&i32, &f64)| *error > 0.05 && (levels[band] - fine[band]).abs() < 3.0 * error;
        assert!(errors.iter().all(holds), "{errors:?}");
    }
    let summary = corrected.summary();
    assert_eq!(summary["levels"]["elements"], 192);
    assert!(summary["levels"]["seconds"].as_f64().unwrap() >= 0.6);
    assert!(!summary["notes"].to_string().is_empty() && summary["notes"].to_string().contains("192 elements"));
    // The sound file has the gains, too.
    let level = |results: &Results| results.summary()["sound"]["receivers"][0]["level_a"].as_f64().unwrap();
    let peak = |results: &Results| results.summary()["sound"]["receivers"][0]["audio"]["peak"].as_f64().unwrap();
    let [louder, higher] = [level(&corrected) - level(&coarse), 20.0 * (peak(&corrected) / peak(&coarse)).log10()];
    assert!((louder - higher).abs() < 2.0, "levels by {louder} dB, peaks by {higher} dB");
}

/// Both meshes take the steps of the preset, which without it would be too long for `fmax`.
#[test]
fn both_meshes_keep_the_preset_of_the_run() {
    let wishes = "preset = \"draft\"\nfmax = 500.0";
    let summary = run(&add(&over(96, 0.6, LEVELS, ""), "numerics", wishes)).summary();
    let steps_per_second = summary["outcome"]["steps"].as_f64().unwrap() / 0.8;
    assert!(steps_per_second < 5.8 * 500.0 && summary["levels"]["elements"] == 192, "{steps_per_second}");
}

/// Without sound to listen to, a run takes no more road than the error asks for.
#[test]
fn the_run_is_as_long_as_its_standard_error_takes() {
    let seconds = |error: f64| {
        let results = run(&over(96, 8.0, &format!("levels = {{ standard_error = {error:?} }}"), ""));
        let errors = bands(&results, "spectra.csv", "standard_error_db");
        let largest = errors.values().fold(0.0_f64, |largest, error| largest.max(*error));
        let summary = results.summary();
        let missed = summary["warnings"].to_string().contains("outputs.levels.standard_error");
        // The estimate of the error by which the run's length is chosen has an error itself.
        assert!(missed || largest < 1.4 * error, "{error} dB: {largest} dB");
        summary["outcome"]["simulated_time"].as_f64().unwrap()
    };
    let [long, short] = [seconds(0.6), seconds(2.0)];
    assert!(short < 0.7 * long && short < 4.0, "{short} {long}");
}

#[test]
fn what_levels_of_a_finer_mesh_cannot_be_is_refused() {
    let refused = |text: &str| tyrewave::Scene::from_str(text, "scene").unwrap_err().to_string();
    let by_slices = over(96, 1.0, LEVELS, "").replace("zone = \"cells\"\n", "").replace("cells_across = 3\n", "");
    let reported = Plan::of(&scene(&by_slices)).unwrap_err().to_string();
    assert!(reported.contains("outputs.levels") && reported.contains("cells"), "{reported}");
    let with_friction = over(96, 1.0, LEVELS, "[friction]\nmu = 0.8\n");
    assert!(refused(&with_friction).contains("only levels of normal force and sound"));
    let odd = over(96, 1.0, "levels = { standard_error = 0.5, elements = 100 }", "");
    let reported = Plan::of(&scene(&odd)).unwrap_err().to_string();
    assert!(reported.contains("outputs.levels.elements") && reported.contains("192"), "{reported}");
    let loaded = scene(&over(96, 1.0, LEVELS, ""));
    let plan = Plan::of(&loaded).unwrap();
    let Err(error) = Simulation::begin(&loaded, &plan, &Default::default()) else { panic!("has begun") };
    assert!(error.to_string().contains("outputs.levels"), "{error}");
}
