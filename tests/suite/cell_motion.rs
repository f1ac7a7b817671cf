//! Vibration and sound of contact over cells: whole runs against those of slices, the energy of the vibration, bytes on
//! any number of threads, and that nothing is done unless it is asked for.

use std::collections::BTreeMap;
use std::fs;

use serde_json::Value;
use tyrewave::Plan;
use tyrewave::counters::{Counter, Stage};
use tyrewave::internals::{edit, scene, scene_text, with_all_terms, without};
use tyrewave::response::ThirdOctaveBand;
use tyrewave::scene::Scene;

use crate::common::{Results, run};

const ROUGH: &str = "kind = \"made\"\nseed = 4\ntexture = \"rough-asphalt\"";
const SMOOTH: &str = "kind = \"smooth\"";

fn rolling(duration: f64) -> String {
    format!("speed_kmh = 80.0\nwarm_up = 0.3\nduration = {duration:?}\naxle = {{ indentation = 0.012, ramp = 0.05 }}")
}

fn vibration(keys: &str) -> String {
    format!("[outputs]\nplots = false\n[outputs.vibration]\n{keys}\n")
}

/// A scene of cells with three waves across for each cell, and none but the first lobe along.
fn cells(elements: usize, across: usize, road: &str, duration: f64, numerics: &str, more: &str) -> String {
    let contact = format!("[contact]\nzone = \"cells\"\ncells_across = {across}\n{more}");
    let numerics = format!("pole_tolerance = 1e-4\n{numerics}");
    let text = scene_text(elements, road, &rolling(duration), &numerics, &contact);
    let terms = (3 * across).to_string();
    edit(&text, &[("numerics.lateral_terms", &terms), ("numerics.wavenumber_aliases", "0")])
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

/// Levels of `vibration.csv` \[dB\] by field, frame and place.
fn levels(results: &Results) -> BTreeMap<String, Vec<(ThirdOctaveBand, f64)>> {
    results.assert_window_held("levels");
    let mut reader = csv::Reader::from_path(results.path("vibration.csv")).unwrap();
    let mut all: BTreeMap<_, Vec<_>> = BTreeMap::new();
    for row in reader.records() {
        let row = row.unwrap();
        let band = ThirdOctaveBand::containing(row[5].parse().unwrap()).unwrap();
        all.entry(row.iter().take(4).collect::<Vec<_>>().join(" ")).or_default().push((band, row[7].parse().unwrap()));
    }
    all
}

/// Largest differences of third octaves from 40 Hz to 1 kHz, by spectrum \[dB\].
fn differences(one: &Results, other: &Results) -> BTreeMap<String, f64> {
    let (one, other) = (levels(one), levels(other));
    assert!(one.keys().eq(other.keys()), "{:?} {:?}", one.keys(), other.keys());
    let largest = |(name, levels): (&String, &Vec<(ThirdOctaveBand, f64)>)| {
        let pairs = levels.iter().zip(&other[name]).filter(|(one, _)| (39.0..1001.0).contains(&one.0.mid_frequency()));
        (name.clone(), pairs.fold(0.0_f64, |largest, (one, other)| largest.max((one.1 - other.1).abs())))
    };
    one.iter().map(largest).collect()
}

#[test]
fn what_the_forces_on_cells_put_in_is_dissipated() {
    for (name, road, rule, bound) in [
        ("smooth", SMOOTH, "bdf2", 1e-5),
        ("smooth", SMOOTH, "sdirk2", 1e-5),
        ("rough", ROUGH, "sdirk2", 3e-4),
        ("rough", ROUGH, "bdf2", 3e-4),
        ("rough", ROUGH, "sdirk3", 3e-4),
    ] {
        let text =
            cells(96, 4, road, 2.0, &format!("time_rule = \"{rule}\""), &vibration("belt = false\nsegment = 0.4"));
        let results = run(&text);
        let power = &results.summary()["vibration"]["power"];
        println!("{name}, {rule}: {power}");
        assert!(number(&power["put_in"]) > 0.0 && power.get("dissipated_by_tyre").is_none(), "{name}, {rule}");
        let difference = number(&power["relative_difference"]);
        assert!(difference.abs() < bound, "{name}, {rule}: {difference}");
    }
}

#[test]
fn one_row_of_cells_moves_the_tyre_as_a_slice_does() {
    let keys = "tangential = true\npoints = [-0.2]\nelements = [7]\nsegment = 0.4\n";
    for rule in ["bdf2", "sdirk2"] {
        let numerics = format!("time_rule = \"{rule}\"");
        let one = cells(96, 1, ROUGH, 1.2, &numerics, &vibration(&format!("{keys}lateral_tolerance = 1e-3")));
        let one = run(&with_all_terms(&one));
        // A single row of cells is a slice that is level across and has the road's height at an element's middle.
        let slices = "[contact]\ncells_across = 1\ncells_along = 1\n";
        let numerics = format!("pole_tolerance = 1e-4\n{numerics}");
        let other = scene_text(96, ROUGH, &rolling(1.2), &numerics, &format!("{slices}{}", vibration(keys)));
        let other = run(&with_all_terms(&other));
        // Forces and velocities are found by different poles, the waves beyond the first lobe with and without memory:
        // 0.02 % of the force, and 1e-3 of the tread's mean square are waves that are left out.
        for (name, difference) in differences(&one, &other) {
            println!("{rule}, {name}: {difference:.2} dB");
            let bound = if name.contains("-0.2") { 0.25 } else { 0.15 };
            assert!(difference < bound, "{rule}, {name}: {difference} dB");
        }
        let waves = one.summary()["vibration"]["waves_across"].as_u64().unwrap();
        // What a cell yields beyond the waves that the run carries is no part of the balance: 1.1 % of the power here.
        let power = &one.summary()["vibration"]["power"];
        let share = number(&power["put_into_waves"]) / number(&power["put_in"]);
        let difference = number(&power["relative_difference"]);
        assert!((0.9..1.0).contains(&share) && difference.abs() < 1e-3, "{rule}: {power}");
        // As far as waves of the length of an element.
        assert!(waves == 10 && other.summary()["vibration"].get("waves_across").is_none(), "{waves}");
    }
}

#[test]
fn vibration_of_cells_has_the_same_bytes_on_two_threads() {
    let keys = vibration("points = [0.05]\nelements = [40]\nsegment = 0.2\nmap = true");
    let text = cells(64, 4, ROUGH, 0.5, "time_rule = \"sdirk2\"", &keys);
    let on = |threads: usize, text: &str| {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| run(text))
    };
    let (one, two) = (on(1, &text), on(2, &text));
    for name in
        ["vibration.csv", "vibration_narrow.csv", "vibration_map_tread_material.npy", "vibration_map_belt_material.npy"]
    {
        assert!(fs::read(one.path(name)).unwrap() == fs::read(two.path(name)).unwrap(), "{name}");
    }
    assert_eq!(one.summary()["vibration"], two.summary()["vibration"]);
    let meter = &one.report.meter;
    assert!(meter.counted(Counter::VibrationTransforms) > 0 && meter.counted(Counter::VibrationEvaluations) > 0);
    let without = run(&without(&text, &["outputs"]));
    for name in ["total_force.npy", "patch_force.npy", "row_force.npy"] {
        assert!(
            fs::read(one.path(name)).unwrap() == fs::read(without.path(name)).unwrap(),
            "{name}: looking on changes nothing"
        );
    }
    let meter = &without.report.meter;
    assert_eq!(meter.cost(Stage::Vibration).calls, 0);
    for counter in [Counter::VibrationTransforms, Counter::VibrationEvaluations] {
        assert_eq!(meter.counted(counter), 0, "{counter:?}");
    }
}

#[test]
fn plans_count_what_cells_need_and_refuse_what_does_not_fit() {
    let plan = |keys: &str| {
        let loaded = scene(&cells(512, 6, ROUGH, 2.0, "", &vibration(keys)));
        (Plan::of(&loaded).unwrap(), loaded)
    };
    let memory = |keys: &str| plan(keys).0.amounts().memory_on(1);
    let (none, one) = (plan("").0, memory("segment = 0.2"));
    let without = Plan::of(&scene(&cells(512, 6, ROUGH, 2.0, "", ""))).unwrap().amounts().memory_on(1);
    assert!(none.vibration().is_some() && one > without, "{one} {without}");
    let fine = memory("segment = 0.2\nlateral_tolerance = 1e-6");
    assert!(fine > 1.02 * one, "{fine} {one}: more waves take more memory");
    let segments = |keys: &str| {
        let (plan, _) = plan(keys);
        let vibration = plan.vibration().unwrap();
        plan.vibration_segments(&vibration, 20).unwrap().cells.unwrap()
    };
    // Odd waves of a plate, as far as the sums of the scene go; all of them put in power.
    let all = segments("lateral_tolerance = 1e-6");
    assert_eq!((all.in_mean, all.carried), ((1..18).step_by(2).collect(), 18));
    assert!(segments("").in_mean.len() < 9);
}

#[test]
fn settings_that_mean_nothing_are_answered_with_their_keys() {
    let answer = |text: &str| Scene::from_str(text, "scene.toml").unwrap_err().render(false);
    let slices = scene_text(64, SMOOTH, &rolling(1.0), "", &vibration("lateral_tolerance = 0.1"));
    let text = answer(&slices);
    assert!(text.contains("lateral_tolerance") && text.contains("zone = \"cells\""), "{text}");
    for value in ["0.0", "1.0", "-1.0"] {
        let text = answer(&cells(64, 4, SMOOTH, 1.0, "", &vibration(&format!("lateral_tolerance = {value}"))));
        assert!(text.contains("lateral_tolerance"), "{text}");
    }
    let bedding = cells(64, 4, SMOOTH, 1.0, "", &vibration("")) + "[effects]\ntread_vibration = \"off\"\n";
    assert!(answer(&bedding).contains("outputs.vibration.tread"));
}
