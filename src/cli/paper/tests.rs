//! The paper computed again: every figure and statement is there, with a verdict and finite numbers.

use std::collections::BTreeSet;
use std::sync::atomic::AtomicBool;

use crate::cli::error::CliError;
use crate::results::table::ReportPart;
use crate::run::{Job, Unwatched};
use crate::scene::Scene;
use crate::test_models::{scene, scene_text};
use serde_json::Value;

use super::subject::{Statement, Subject, Verdict};
use super::{page, recompute, report};

/// Highest frequency compared \[Hz\].
const HIGHEST: f64 = 125.0;

/// Few cells: slices on a half-space take most of the time.
const CONTACT: &str = "[contact]\ncells_across = 6";

fn small() -> Scene {
    let rolling = "speed_kmh = 80.0\nwarm_up = 0.2\nduration = 0.6\naxle = { load = 3400 }";
    // Histories by short sums, without fits.
    let numerics = "substeps = 2\npole_tolerance = 2e-3\nmemory = 0.02";
    scene(&scene_text(64, "kind = \"made\"\nseed = 2", rolling, numerics, CONTACT)).scene
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
fn every_figure_and_statement_has_a_verdict_and_finite_numbers() {
    let scene = small();
    let subjects = recompute(&scene, HIGHEST, Job::new(&AtomicBool::new(false), &mut Unwatched)).unwrap();
    let statements: Vec<&Statement> = subjects.iter().flat_map(|subject| &subject.statements).collect();
    let places: BTreeSet<&str> = statements.iter().map(|of| of.place.as_str()).collect();
    let expected = ["figure 2", "figure 3", "figure 4", "figure 5", "figure 6", "contact search", "equation 4"];
    assert_eq!(places, expected.into());
    for of in &statements {
        println!("{}: {} | {} | {:?}", of.place, of.subject, of.found, of.verdict);
        assert!(!of.paper.is_empty() && !of.why.is_empty(), "{of:?}");
        assert!(of.found.contains(|letter: char| letter.is_ascii_digit()) && !of.found.contains("NaN"), "{of:?}");
        assert!(!of.found.contains("inf"), "{of:?}");
        // Figures that are pictures in the paper.
        let pictured = ["figure 3", "figure 5"].contains(&of.place.as_str());
        assert_eq!(of.verdict == Verdict::NotComparable, pictured, "{of:?}");
    }
    subjects.iter().for_each(|subject| assert_finite(&subject.numbers, subject.key));
    // Results that hold for a tiny scene, too.
    let number = |key: &str, pointer: &str| {
        let subject: &Subject = subjects.iter().find(|subject| subject.key == key).unwrap();
        subject.numbers.pointer(pointer).unwrap().clone()
    };
    let patch = |name: &str| number("patch_forces", name).as_f64().unwrap();
    assert!(patch("/smallest").abs() < f64::MIN_POSITIVE);
    assert!(patch("/length") > 0.03 && patch("/length") < 0.3, "{:?}", patch("/length"));
    for coupling in ["/couplings/0", "/couplings/1"] {
        let of = number("equation_4", coupling);
        assert_eq!(["steps", "differences"].map(|key| of[key].as_array().unwrap().len()), [5, 4]);
    }

    let drawn: BTreeSet<&str> = subjects.iter().filter(|of| !of.pictures.is_empty()).map(|of| of.heading).collect();
    assert_eq!(drawn, ["Figure 2", "Figure 3", "Figure 4", "Figure 5", "Figure 6"].into());
    let report = report(&statements, &scene);
    let ReportPart::Table(table) = &report.parts()[0] else { panic!("{report}") };
    assert_eq!(table.rows.len(), statements.len());
    let page = page(&subjects, &report);
    let drawn = subjects.iter().map(|subject| subject.pictures.len()).sum::<usize>();
    assert_eq!([page.matches("<figure>").count(), page.matches("<svg ").count()], [drawn; 2], "a picture is left out");
    for text in ["Figure 2", "equation 4", "agrees", "not comparable", "64 elements"] {
        assert!(page.contains(text), "{text}");
    }
}

#[test]
fn an_interruption_ends_it() {
    let stopped = recompute(&small(), HIGHEST, Job::new(&AtomicBool::new(true), &mut Unwatched));
    assert!(matches!(stopped, Err(CliError::Interrupted { .. })), "{stopped:?}");
}
