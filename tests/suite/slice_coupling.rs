//! The two couplings of the slice law: the paper's equation 4, and each slice's own spring in series with the coupled
//! tread.
//!
//! `cargo test --release --test suite slice_coupling -- --ignored --nocapture`

use std::fs;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tempfile::TempDir;
use tyrewave::counters::{Counter, Stage};
use tyrewave::internals::{
    CHIP_SEAL, CIRCUMFERENCE, add, edit, grid_road, implausible, reference, scene_text, with_road,
};
use tyrewave::scene::PLATE;

use crate::common::{Results, run, write_grid};

const ROLLING: &str = "speed_kmh = 80.0\nwarm_up = 0.1\nduration = 0.15\naxle = { indentation = 0.012, ramp = 0.03 }";

fn contact(coupling: &str, more: &str) -> String {
    format!("[contact]\nslice_coupling = \"{coupling}\"\n{more}")
}

/// A road of six cells across, rough by up to `roughness` \[m\] on a level of each row \[m\].
fn rough_road(elements: usize, roughness: f64, level: impl Fn(usize) -> f64) -> (TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("road.npy");
    let mut random = ChaCha8Rng::seed_from_u64(17);
    let heights: Vec<f64> =
        (0..elements * 5 * 6).map(|cell| level(cell / 6) + random.random_range(0.0..roughness)).collect();
    write_grid(&path, 6, &heights);
    let road = grid_road(&path, elements, 6);
    (folder, road)
}

/// Level of a row \[m\].
type Level<'a> = &'a dyn Fn(usize) -> f64;

fn fallbacks(results: &Results) -> u64 {
    results.report.meter.counted(Counter::Fallbacks)
}

#[test]
fn hard_cases_5_are_met_with_the_implicit_coupling() {
    let n = 96;
    let place = n * 3 / 2;
    let pit = |row: usize| if (place..place + n / 2).contains(&row) { -0.04 } else { 0.0 };
    let spike = |row: usize| if row == place { 0.02 } else { 0.0 };
    let step = |row: usize| if row < place { 0.0 } else { 0.01 };
    let level = |_: usize| 0.0;
    let roads: [(&str, f64, Level<'_>); 6] = [
        ("rough", 3e-3, &level),
        ("all but level", 1e-12, &level),
        ("very rough", 2e-2, &level),
        ("pit", 1e-3, &pit),
        ("spike", 1e-3, &spike),
        ("step", 1e-3, &step),
    ];
    for (name, roughness, level) in roads {
        let (_folder, road) = rough_road(n, roughness, level);
        let rolling = format!("start = 1.0\n{ROLLING}");
        let results = run(&scene_text(n, &road, &rolling, "memory = 0.2", &contact("implicit", "")));
        results.assert_sound(name);
        println!("{name}: {} fallbacks, {:?}", fallbacks(&results), results.report.summary.contact.solves_per_step);
        if name == "pit" {
            let force = results.array("total_force.npy");
            assert!(force[60..].iter().any(|&force| force < f64::MIN_POSITIVE), "never in the air");
        }
    }
    let (_folder, road) = rough_road(n, 3e-3, level);
    let rolling = format!("start = 1.0\n{ROLLING}");
    for (name, modulus, numerics, more) in [
        ("stiff", "8.0e9", "memory = 0.2", ""),
        ("soft", "8.0e3", "memory = 0.2", ""),
        ("bedding", "8.0e6", "memory = 0.2", "tread = \"bedding\""),
        ("two stages", "8.0e6", "history = \"modal\"\ntime_rule = \"sdirk2\"", ""),
        ("half-space", "8.0e6", "history = \"modal\"\nsubsteps = 3", "slices = \"half-space\""),
    ] {
        let text = scene_text(n, &road, &rolling, numerics, &contact("implicit", more));
        let text = edit(&text, &[("tyre.layers.1.material.modulus", modulus)]);
        let results = run(&implausible(&text));
        results.assert_sound(name);
        println!("{name}: {} fallbacks, {:?}", fallbacks(&results), results.report.summary.contact.solves_per_step);
    }
}

#[test]
fn flat_slices_are_the_same_bytes_by_both_couplings_and_rough_ones_carry_more_by_the_implicit() {
    let n = 64;
    let (_folder, road) = rough_road(n, 2e-3, |_| 0.0);
    let rolling = format!("start = 1.0\n{ROLLING}");
    let with =
        |coupling: &str, more: &str| run(&scene_text(n, &road, &rolling, "memory = 0.2", &contact(coupling, more)));
    let bytes = |results: &Results| fs::read(results.path("patch_force.npy")).unwrap();
    let flat = "slices = \"none\"";
    assert!(bytes(&with("explicit", flat)) == bytes(&with("implicit", flat)));
    let [explicit, implicit] =
        ["explicit", "implicit"].map(|coupling| with(coupling, "").report.summary.outcome.mean_force.unwrap());
    println!("mean force at 12 mm: {explicit:.0} N explicit, {implicit:.0} N implicit");
    assert!(implicit > 1.001 * explicit, "what the neighbours do is no penetration: {explicit} {implicit}");
}

#[test]
#[ignore = "eight runs of seconds rolled: a minute or two"]
fn both_couplings_at_equal_load_with_their_cost() {
    let chip_seal = format!("kind = \"profile\"\nfile = {:?}\nlateral = \"isotropic\"\nseed = 1", reference(CHIP_SEAL));
    for (name, road) in [("dense asphalt", "kind = \"made\"\nseed = 1".to_owned()), ("chip seal", chip_seal)] {
        for elements in [512, 1024] {
            let of = |coupling: &str| {
                let text = edit(
                    &with_road(PLATE, &road),
                    &[
                        ("numerics.elements", &elements.to_string()),
                        ("rolling.duration", "8.0"),
                        ("rolling.warm_up", "1.0"),
                    ],
                );
                run(&add(&text, "contact", &format!("slice_coupling = \"{coupling}\"")))
            };
            let both = ["explicit", "implicit"].map(of);
            println!("{name}, N = {elements}, {:.2} mm an element", 1e3 * CIRCUMFERENCE / f64::from(elements));
            for (coupling, results) in ["explicit", "implicit"].into_iter().zip(&both) {
                let (summary, meter) = (&results.report.summary, &results.report.meter);
                let outcome = &summary.outcome;
                let steps = outcome.steps as f64;
                println!(
                    "   {coupling}: mean force {:.0} N, rms {:.0} N, contact {:.1} mm, indentation {:.3} mm; search \
                     {:.1} us a step, {:.2} solves, {:.2} factorisations, {} fallbacks; \
                     solves by step {:?}; residuals {:.0e} {:.0e} {:.0e}",
                    outcome.mean_force.unwrap(),
                    outcome.rms_force_variation.unwrap(),
                    1e3 * outcome.mean_contact_length.unwrap(),
                    1e3 * outcome.indentation.unwrap(),
                    1e6 * (meter.cost(Stage::ActiveSet).spent.wall + meter.cost(Stage::Factorisation).spent.wall)
                        .as_secs_f64()
                        / steps,
                    meter.counted(Counter::Solves) as f64 / steps,
                    meter.counted(Counter::Factorisations) as f64 / steps,
                    meter.counted(Counter::Fallbacks),
                    summary.contact.solves_per_step,
                    summary.contact.tension,
                    summary.contact.penetration,
                    summary.contact.complementarity,
                );
                results.assert_sound(coupling);
                assert!((outcome.mean_force.unwrap() / 3400.0 - 1.0).abs() < 0.03);
            }
            println!("   band [Hz]   explicit   implicit   difference [dB]");
            let [explicit, implicit] = both.each_ref().map(Results::force_levels);
            for (a, b) in explicit.iter().zip(&implicit) {
                let difference = b.level - a.level;
                println!("   {:>9}   {:8.1}   {:8.1}           {difference:+5.1}", a.band.label(), a.level, b.level);
                assert!(difference.is_finite());
            }
        }
    }
}
