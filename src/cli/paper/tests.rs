//! The paper computed again: every figure and statement is there, with a verdict and finite numbers.

use std::collections::BTreeSet;
use std::sync::atomic::AtomicBool;

use crate::run::{RunError, Unwatched};
use crate::scene::LoadedScene;
use crate::test_models::{scene, scene_text};
use serde_json::Value;

use super::page::{page, statement_table};
use super::pictures::pictures;
use super::recompute::{PaperOptions, recompute};
use super::statement::Verdict;

const TINY: PaperOptions = PaperOptions {
    elements: 48,
    duration: 0.6,
    coarse_elements: 48,
    coarse_duration: 0.7,
    halvings: 2,
    highest: 125.0,
    frequencies: 6,
    slices: 20,
    sums: 4,
};

/// Few cells: slices on a half-space take most of the time.
const CONTACT: &str = "[contact]\ncells_across = 6";

fn small() -> LoadedScene {
    let rolling = "speed_kmh = 80.0\nwarm_up = 0.2\nduration = 0.6\naxle = { load = 3400 }";
    // Histories by short sums: no fits but those that are timed.
    let numerics = "substeps = 2\npole_tolerance = 2e-3\nmemory = 0.02";
    scene(&scene_text(48, "kind = \"made\"\nseed = 2", rolling, numerics, CONTACT))
}

/// Checks that no number is missing: JSON has null for NaN and infinity.
fn assert_finite(value: &Value, path: &str) {
    match value {
        Value::Null => panic!("{path} is not finite"),
        Value::Array(values) => values.iter().enumerate().for_each(|(k, v)| assert_finite(v, &format!("{path}.{k}"))),
        Value::Object(values) => values.iter().for_each(|(key, v)| assert_finite(v, &format!("{path}.{key}"))),
        _ => {}
    }
}

#[test]
fn every_figure_and_statement_is_there_with_a_verdict_and_finite_numbers() {
    let loaded = small();
    let paper = recompute(&loaded, &TINY, &AtomicBool::new(false), &mut Unwatched).unwrap();
    let places: BTreeSet<&str> = paper.statements.iter().map(|of| of.place).collect();
    let expected =
        ["figure 2", "figure 3", "figure 4", "figure 5", "figure 6", "contact search", "performance", "equation 4"];
    assert_eq!(places, expected.into());
    for of in &paper.statements {
        println!("{}: {} | {} | {}", of.place, of.subject, of.found, of.verdict.words());
        assert!(!of.paper.is_empty() && !of.why.is_empty(), "{of:?}");
        assert!(of.found.contains(|letter: char| letter.is_ascii_digit()) && !of.found.contains("NaN"), "{of:?}");
        assert!(!of.found.contains("inf"), "{of:?}");
        // Figures that are pictures in the paper; times may be too close to call.
        let pictured = ["figure 3", "figure 5"].contains(&of.place);
        assert!(of.place == "performance" || (of.verdict == Verdict::NotComparable) == pictured, "{of:?}");
    }
    assert_finite(&serde_json::json!(paper), "paper");
    // Results that hold for a tiny scene, too.
    assert!(paper.patch_forces.smallest.abs() < f64::MIN_POSITIVE && paper.patch_forces.steps > 10);
    assert!(paper.patch_forces.length > 0.03 && paper.patch_forces.length < 0.3, "{:?}", paper.patch_forces.length);
    assert!(paper.influence.exact.evaluations > paper.influence.plain.evaluations && paper.influence.kept > 0.0);
    assert_eq!(paper.equation_4.steps.len(), 3);
    assert!(paper.equation_4.couplings.iter().all(|refined| refined.differences.len() == 2));

    let pictures = pictures(&paper).unwrap();
    let drawn: BTreeSet<&str> = pictures.iter().map(|picture| picture.place).collect();
    assert_eq!(drawn.len(), places.len() - 1, "{drawn:?}");
    let page = page(&paper, &loaded.scene, &pictures);
    assert_eq!(page.matches("<figure>").count(), pictures.len());
    for text in ["Figure 2", "Equation 4", "agrees", "not comparable"] {
        assert!(page.contains(text), "{text}");
    }
    assert_eq!(page.matches("<svg ").count(), pictures.len(), "a picture is left out");
    assert_eq!(statement_table(&paper.statements).rows().len(), paper.statements.len());
}

#[test]
fn an_interruption_ends_it() {
    let stopped = recompute(&small(), &TINY, &AtomicBool::new(true), &mut Unwatched);
    assert!(matches!(stopped, Err(RunError::Interrupted { .. })), "{stopped:?}");
}
