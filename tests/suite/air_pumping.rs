//! Air under the contact patch: what grooves change, what they leave as it was, what is refused.

use std::fs;

use tyrewave::plan::Plan;
use tyrewave::run::Simulation;
use tyrewave::scene::Scene;
use tyrewave::test_models::{edit, scene, scene_text};

use crate::suite::common::run;

const ELEMENTS: usize = 128;
const SPEED: f64 = 80.0 / 3.6;
const AROUND: f64 = 1.95;
const MADE: &str = "kind = \"made\"\nseed = 3";
const SLICES: &str = "slices = \"winkler\"\ncells_across = 4";
/// A groove over half of the strip, two cells wide.
const GROOVE: &str = "[tread_pattern]\ngrooves = [{ position = 0.0, width = 0.06, depth = 0.008 }]\n";
/// Low frequencies alone: boundary elements of a second.
const HEARD: &str = "[[receiver]]\nname = \"beside\"\nposition = [0.3, 0.6, 0.2]\n\
                     [radiation]\nfmax = 500.0\nnodes_per_wavelength = 5.0\nfrequency_tolerance = \"0.5 dB\"\n\
                     audio = false\n";
const DRAFT: &str = "[[receiver]]\nposition = [0.3, 0.6, 0.2]\n[radiation]\nquality = \"draft\"\nfmax = 500.0\n";
const OPEN: &str = "[air_pumping]\npatch = \"grooves\"\n";

/// A scene of so many revolutions, with the keys of its contact and other tables after them.
fn rolled(revolutions: f64, contact: &str, more: &str) -> String {
    let turn = AROUND / SPEED;
    let rolling = format!(
        "speed_kmh = 80.0\nwarm_up = 0.0\nduration = {:?}\naxle = {{ indentation = 0.014, ramp = 0.01 }}",
        (revolutions + 0.001) * turn
    );
    let numerics = format!("substeps = 1\ntime_rule = \"bdf2\"\nhistory = \"direct\"\nmemory = {:?}", 0.9 * turn);
    let outputs = "[outputs]\nplots = false\n";
    scene_text(ELEMENTS, MADE, &rolling, &numerics, &format!("[contact]\n{contact}\n{outputs}{more}"))
}

/// Tables of the sound.
const SOUND: [&str; 2] = ["sound.csv", "sound_narrow.csv"];

#[test]
fn grooves_are_heard_on_any_number_of_threads_and_a_sealed_patch_is_the_one_without_a_table() {
    let of = |more: &str| run(&rolled(8.0, SLICES, &format!("{GROOVE}{HEARD}{more}")));
    let without = of("");
    let bytes = |results: &crate::suite::common::Results| SOUND.map(|name| fs::read(results.path(name)).unwrap());
    let off = format!("{OPEN}[effects]\nair_pumping = \"off\"\n");
    for more in ["[air_pumping]\n", "[air_pumping]\npatch = \"sealed\"\n", &off] {
        let sealed = of(more);
        assert!(bytes(&without) == bytes(&sealed) && !sealed.path("gap.csv").exists(), "{more}");
    }
    let on =
        |threads: usize| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| of(OPEN));
    let (one, two) = (on(1), on(2));
    assert!(bytes(&one) == bytes(&two), "threads");
    let gap = |results: &crate::suite::common::Results| fs::read_to_string(results.path("gap.csv")).unwrap();
    assert_eq!(gap(&one), gap(&two));
    // The forces are the same.
    let force = |results: &crate::suite::common::Results| fs::read(results.path("total_force.npy")).unwrap();
    assert!(force(&one) == force(&without));
    let level =
        |results: &crate::suite::common::Results| results.summary()["sound"]["receivers"][0]["level"].as_f64().unwrap();
    let (sealed, open) = (level(&without), level(&one));
    println!("sealed {sealed:.2} dB, open {open:.2} dB");
    assert!((sealed - open).abs() > 0.01, "{sealed} {open} dB");
    let table = gap(&one);
    let mut lines = table.lines();
    let header = "groove,position_m,width_m,depth_m,resonance_hz,quality,receiver,frequency_hz,green_1_per_m";
    assert_eq!(lines.next(), Some(header));
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    assert!(rows.len() >= 5 && rows.iter().all(|row| row[8].parse::<f64>().unwrap() > 0.0), "{table}");
    // Up to 500 Hz it has no peak.
    assert!(rows.iter().all(|row| row[0] == "0" && row[4].is_empty() && row[6] == "beside"), "{table}");
}

#[test]
fn ways_of_the_air_that_a_scene_cannot_have_are_refused_with_their_places() {
    let refusal = |text: &str| {
        let planned = Scene::from_str(text, "scene.toml").and_then(|loaded| Plan::of(&loaded));
        planned.map(|_| String::new()).unwrap_or_else(|error| error.render(false))
    };
    let heard = |more: &str| format!("{GROOVE}{HEARD}{more}\n{OPEN}");
    let cases = [
        (SLICES, format!("{GROOVE}{OPEN}"), "air_pumping", "no [[receiver]]"),
        (SLICES, format!("{HEARD}{OPEN}"), "air_pumping.patch", "no grooves"),
        (SLICES, heard("acoustic_gap = 0.001"), "radiation.acoustic_gap", "not by both"),
        (SLICES, format!("{GROOVE}{DRAFT}{OPEN}"), "radiation.quality", "mouths"),
        ("slices = \"winkler\"\ncells_across = 4\ntread = \"uncoupled\"", heard(""), "contact.tread", "no volume"),
        (SLICES, format!("{GROOVE}{HEARD}[air_pumping]\npatch = \"voids\"\n"), "air_pumping.patch", "voids"),
        (SLICES, format!("{GROOVE}{HEARD}[air_pumping]\nsqueeze = true\n"), "air_pumping.squeeze", "not a key"),
        (SLICES, "[effects]\nair_pumping = \"on\"\n".to_owned(), "effects.air_pumping", "no [air_pumping]"),
    ];
    for (contact, more, key, wrong) in cases {
        let told = refusal(&rolled(8.0, contact, &more));
        let is_named = told.contains(key) || key.split('.').all(|part| told.contains(part));
        assert!(is_named && told.contains(wrong), "{key}, {wrong}: {told}\n{more}");
    }
    assert_eq!(refusal(&rolled(8.0, SLICES, &heard(""))), "");
    // Known once the patch is: where the sheet ends the gap is 19 mm high.
    let changes = [("radiation.fmax", "4000.0"), ("numerics.elements", "1024")];
    let high = edit(&rolled(8.0, SLICES, &heard("patch_length = 0.12")), &changes);
    let loaded = scene(&high);
    let plan = Plan::of(&loaded).unwrap();
    let told = match Simulation::begin(&loaded, &plan, &Default::default()) {
        Ok(_) => String::new(),
        Err(error) => error.to_string(),
    };
    assert!(told.contains("sixth") && told.contains("fmax"), "{told}");
}
