//! Tests of scene loading.

mod files;
mod messages;
mod mistakes;
mod places;
mod round_trip;
mod schema;

use super::{LoadedScene, Scene, SceneError};
use crate::test_models::replaced;

/// A complete scene; the tests of mistakes refer to its lines by number.
pub(crate) const BASE: &str = r#"title = "base"
[tyre]
circumference = 1.95
width = 0.2
contact_width = 0.12
foundation = { normal = 1.8e6, tangential = 1e6, loss_factor = 0.1 }
[[tyre.layers]]
name = "belt"
thickness = 0.006
tension = [6e4, 2e4]
material = { modulus = 5e8, loss_factor = 0.08, poisson = 0.3, density = 1300 }
[[tyre.layers]]
name = "tread"
thickness = 0.013
material = { law = "power-law", modulus = 8e6, loss_factor = 0.25, poisson = 0.49, density = 1150 }
[road]
kind = "smooth"
[rolling]
speed_kmh = 80
duration = 1.5
axle = { load = 3400 }
[contact]
tread = "elastic"
[numerics]
elements = 512
[outputs]
plots = true
"#;

/// The base scene with one passage replaced.
pub(crate) fn edited(from: &str, to: &str) -> String {
    assert_eq!(BASE.matches(from).count(), 1, "{from:?} must occur once in the base scene");
    replaced(BASE, &[(from, to)])
}

/// A complaint in comparable form.
#[derive(Debug)]
pub(crate) struct Complaint {
    pub(crate) line: usize,
    pub(crate) column: usize,
    pub(crate) key: String,
    pub(crate) wrong: String,
    pub(crate) right: String,
}

/// All complaints about a text that must be an invalid scene.
pub(crate) fn complaints(text: &str) -> Vec<Complaint> {
    match Scene::from_str(text, "test.toml") {
        Err(error @ SceneError::Invalid { .. }) => listed(&error),
        other => panic!("expected complaints, got {other:?} for\n{text}"),
    }
}

pub(crate) fn listed(error: &SceneError) -> Vec<Complaint> {
    let complaint = |diagnostic: &super::Diagnostic| Complaint {
        line: diagnostic.line(),
        column: diagnostic.column(),
        key: diagnostic.key().to_owned(),
        wrong: diagnostic.problem().to_string(),
        right: diagnostic.problem().right.clone(),
    };
    error.diagnostics().iter().map(complaint).collect()
}

fn hash(scene: &LoadedScene) -> String {
    scene.hash().unwrap()
}
