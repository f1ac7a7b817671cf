//! Each mistake that a scene can have: exactly one complaint, with its line, its key, and the remedy.

mod effects;
mod inflation;
mod plausible;
mod road;
mod rolling;
mod sound;
mod text;
mod tyre;

use super::super::Scene;
use super::{Complaint, complaints, edited};

/// Asserts that replacing `from` by `to` in the base scene leads to exactly one complaint.
#[track_caller]
fn refused(from: &str, to: &str, line: usize, key: &str, wrong: &str, right: &str) {
    let found = complaints(&edited(from, to));
    let [Complaint { line: at, key: about, wrong: is_wrong, right: would_be_right, .. }] = found.as_slice() else {
        panic!("expected one complaint, got {found:#?}")
    };
    assert_eq!((*at, about.as_str()), (line, key), "line and key; {is_wrong}; {would_be_right}");
    assert!(is_wrong.contains(wrong), "{is_wrong:?} does not say {wrong:?}");
    assert!(would_be_right.contains(right), "{would_be_right:?} does not say {right:?}");
}

#[track_caller]
fn accepted(from: &str, to: &str) -> Scene {
    let text = edited(from, to);
    Scene::from_str(&text, "test.toml").unwrap_or_else(|error| panic!("{}\n{text}", error.render(false))).scene
}

/// [`refused`] for another road in place of the smooth one.
#[track_caller]
fn road_refused(road: &str, line: usize, key: &str, wrong: &str, right: &str) {
    refused("kind = \"smooth\"", road, line, key, wrong, right);
}

/// [`refused`] for another axle.
#[track_caller]
fn axle_refused(axle: &str, key: &str, wrong: &str, right: &str) {
    refused("axle = { load = 3400 }", &format!("axle = {axle}"), 21, key, wrong, right);
}

/// [`refused`] for another material of the tread.
#[track_caller]
fn material_refused(material: &str, key: &str, wrong: &str, right: &str) {
    let from = "{ law = \"power-law\", modulus = 8e6, loss_factor = 0.25, poisson = 0.49, density = 1150 }";
    refused(from, &format!("{{ poisson = 0.49, density = 1150, {material} }}"), 15, key, wrong, right);
}
