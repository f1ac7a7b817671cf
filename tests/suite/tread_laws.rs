//! The paper's figure 6: the tread laws at equal static contact stiffness on a rough road at 80 km/h, as levels of the
//! contact force.
//!
//! `cargo test --release --test suite tread_laws -- --ignored --nocapture`; with `TYREWAVE_PICTURE` set to a file, the
//! default tread is drawn there.

use std::fs;

use tyrewave::internals::{LevelErrors, ThirdOctavePlot, add, edit, implausible, scene_text, without};
use tyrewave::response::BandLevel;
use tyrewave::scene::PLATE;

use crate::common::{Results, run};

/// The laws and their tables `[contact]`, the reference first.
const LAWS: [(&str, &str); 3] = [
    ("elastic", "tread = \"elastic\""),
    ("bedding", "tread = \"bedding\""),
    ("uncoupled", "tread = \"uncoupled\"\nequal_stiffness = true"),
];

/// The default scene's history is by poles; those of the carcass reach 7e-5 under the default tread, 4e-4 under one of
/// four times its modulus (wavenumber 128), far below the laws' differences.
fn of_law(text: &str, law: &str, contact: &str) -> String {
    let text = add(&without(text, &["contact.tread"]), "contact", contact);
    if law.ends_with("bedding") { add(&text, "numerics", "pole_tolerance = 1e-3") } else { text }
}

/// Differences of levels from the first law's \[dB\], by band.
fn differences(levels: &[Vec<BandLevel>], law: usize) -> Vec<f64> {
    levels[law].iter().zip(&levels[0]).map(|(a, b)| a.level - b.level).collect()
}

#[test]
fn all_laws_carry_alike_where_static_stiffness_counts() {
    // 1 m/h: a step takes 37 s, the material's slowest motion (1 Hz) has long ended.
    for modulus in ["8.0e6", "2.0e6"] {
        let mean = |contact: &str| {
            let rolling =
                "speed_kmh = 0.001\nwarm_up = 1200.0\nduration = 1200.0\naxle = { indentation = 0.012, ramp = 600.0 }";
            let numerics = "substeps = 2\nmemory = 1200.0";
            let text = scene_text(256, "kind = \"smooth\"", rolling, numerics, &format!("[contact]\n{contact}"));
            let text = edit(&text, &[("tyre.layers.1.material.modulus", modulus)]);
            let results = run(&implausible(&text));
            results.assert_sound(contact);
            results.report.summary.outcome.mean_force.unwrap()
        };
        let forces = LAWS.map(|(_, contact)| mean(contact));
        let plain = mean("tread = \"uncoupled\"");
        println!("E = {modulus}: {forces:.0?} N; uncoupled without scaling {plain:.0} N");
        for force in forces {
            assert!((force / forces[0] - 1.0).abs() < 0.01, "{forces:?}");
        }
        assert!((plain / forces[0] - 1.0).abs() > 0.1, "the scaling made no difference: {plain} {}", forces[0]);
    }
}

#[test]
fn laws_differ_most_where_the_tread_moves_by_itself() {
    let of = |law: &str, contact: &str| {
        let text = edit(PLATE, &[("numerics.elements", "256"), ("rolling.duration", "2.0")]);
        let results = run(&of_law(&text, law, contact));
        results.assert_sound(contact);
        results.force_levels()
    };
    let levels: Vec<_> = LAWS.iter().map(|(law, contact)| of(law, contact)).collect();
    // Below, the tyre moves as a whole and the bedding is as stiff as the elastic tread; above, only the tread between
    // carcass and stones moves. What the uncoupled law leaves out belongs to the time step, and is next to nothing at
    // this one.
    let uncoupled = differences(&levels, 2);
    println!("{} less elastic: {uncoupled:.2?} dB", LAWS[2].0);
    assert!(uncoupled.iter().all(|difference| difference.abs() < 0.5), "{uncoupled:?}");
    let (law, allowed) = (1, 3.0);
    let found = differences(&levels, law);
    println!("{} less elastic: {found:.1?} dB", LAWS[law].0);
    let largest = |low: f64, high: f64| {
        let within =
            levels[0].iter().zip(&found).filter(|(level, _)| (low..high).contains(&level.band.mid_frequency()));
        within.map(|(_, difference)| difference.abs()).fold(0.0, f64::max)
    };
    let (below, above) = (largest(20.0, 170.0), largest(300.0, 2000.0));
    assert!(below < allowed && above > 2.0 * below && above > 3.0, "{}: {below} and {above} dB", LAWS[law].0);
}

#[test]
#[ignore = "twelve runs of 5 s rolled: minutes"]
fn tread_laws_at_equal_contact_stiffness() {
    for (name, modulus) in [("soft, E/4", 2.0e6), ("standard, E", 8.0e6), ("stiff, 4 E", 3.2e7)] {
        // The bedding of the previous models: E over the thickness of the tread, whatever the static stiffness.
        let unmatched = format!("tread = \"bedding\"\nbedding_stiffness = {:e}", modulus / 0.013);
        let laws: Vec<(&str, &str)> = LAWS.into_iter().chain([("unmatched bedding", unmatched.as_str())]).collect();
        let of = |law: &str, contact: &str| {
            let modulus = format!("{modulus:e}");
            let changes = [
                ("tyre.layers.1.material.modulus", modulus.as_str()),
                ("numerics.elements", "256"),
                ("numerics.substeps", "4"),
                ("rolling.duration", "4.0"),
                ("rolling.warm_up", "0.8"),
            ];
            run(&of_law(&edit(PLATE, &changes), law, contact))
        };
        let all: Vec<Results> = laws.iter().map(|(law, contact)| of(law, contact)).collect();
        println!("{name}:");
        for ((law, _), results) in laws.iter().zip(&all) {
            results.assert_sound(law);
            let outcome = &results.report.summary.outcome;
            println!(
                "   {law}: mean force {:.0} N, rms {:.0} N, contact {:.1} mm, indentation {:.2} mm, {:?}",
                outcome.mean_force.unwrap(),
                outcome.rms_force_variation.unwrap(),
                1e3 * outcome.mean_contact_length.unwrap(),
                1e3 * outcome.indentation.unwrap(),
                results.report.summary.warnings
            );
        }
        let levels: Vec<_> = all.iter().map(Results::force_levels).collect();
        println!("   band [Hz]   elastic [dB]   less elastic: bedding   uncoupled   unmatched bedding [dB]");
        let found: Vec<Vec<f64>> = (1..laws.len()).map(|law| differences(&levels, law)).collect();
        for (index, level) in levels[0].iter().enumerate() {
            let [bedding, uncoupled, unmatched] = [0, 1, 2].map(|law: usize| found[law][index]);
            let band = level.band.label();
            println!("   {band:>9}   {:12.1}   {bedding:+21.1}   {uncoupled:+9.1}   {unmatched:+17.1}", level.level);
            assert!(bedding.is_finite() && uncoupled.abs() < 0.5 && unmatched.is_finite());
        }
        if let Some(file) = std::env::var_os("TYREWAVE_PICTURE").filter(|_| name.starts_with("standard")) {
            let spectra = laws.iter().zip(&levels).map(|((law, _), levels)| (*law, levels.as_slice())).collect();
            let plot = ThirdOctavePlot {
                title: "Tread laws at equal static stiffness, dense asphalt, 80 km/h",
                quantity: "Contact force level [dB re 1 N]",
                spectra,
                errors: LevelErrors::default(),
            };
            fs::write(file, plot.to_svg().unwrap()).unwrap();
        }
    }
}
