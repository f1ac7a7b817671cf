//! Mistakes in what is in a tyre, and in what follows from it.

use super::super::super::{Cavity, Scene, Sides};
use super::super::{BASE, complaints};
use super::{accepted, refused};
use crate::test_models::replaced;

const ARC: &str = "pressure = 2.2e5, sidewall_radius = 0.05, sidewall_angle = 1.1";
const AIR: &str = "radius = 0.235, depth = 0.08, density = 3.8";

/// Puts keys of the tyre before its contact width.
#[track_caller]
fn tyre_refused(keys: &str, line: usize, key: &str, wrong: &str, right: &str) {
    refused("contact_width = 0.12", &format!("{keys}\ncontact_width = 0.12"), line, key, wrong, right);
}

/// Puts an inflation with these keys before the contact width.
#[track_caller]
fn inflation_refused(keys: &str, key: &str, wrong: &str, right: &str) {
    tyre_refused(&format!("inflation = {{ {keys} }}"), 5, &format!("tyre.inflation.{key}"), wrong, right);
}

/// Puts a cavity with these keys into a curved tyre with guided sides.
#[track_caller]
fn cavity_refused(keys: &str, key: &str, wrong: &str, right: &str) {
    let keys = format!("curvature = true\nsides = \"guided\"\ncavity = {{ {keys} }}");
    tyre_refused(&keys, 7, &format!("tyre.cavity{key}"), wrong, right);
}

/// The base scene, inflated, without foundation and tensions.
fn left_out(inflation: &str) -> String {
    replaced(
        BASE,
        &[
            (
                "foundation = { normal = 1.8e6, tangential = 1e6, loss_factor = 0.1 }",
                &format!("inflation = {inflation}"),
            ),
            ("tension = [6e4, 2e4]\n", ""),
        ],
    )
}

#[test]
fn words_and_flags() {
    tyre_refused("sides = \"gided\"", 5, "tyre.sides", "\"gided\" is not known", "did you mean \"guided\"?");
    tyre_refused("sides = true", 5, "tyre.sides", "cannot stand here", "one of \"supported\", \"guided\"");
    tyre_refused("curvature = 1", 5, "tyre.curvature", "1 cannot stand here", "true or false");
    tyre_refused("inflation = 2.2e5", 5, "tyre.inflation", "cannot stand here", "{ pressure = ...");
    tyre_refused("curvature = true\ncavity = true", 6, "tyre.cavity", "cannot stand here", "{ radius = ...");
    let tyre = accepted("contact_width", "sides = \"guided\"\ncurvature = true\ncontact_width").tyre;
    assert!(tyre.sides == Sides::Guided && tyre.curvature);
}

#[test]
fn numbers_of_the_inflation() {
    inflation_refused("sidewall_mass = 0", "pressure", "missing", "above 0 Pa");
    for (number, shown) in [("0", "0 is out"), ("-1", "-1 is out"), ("nan", "not a finite"), ("inf", "not a finite")] {
        inflation_refused(&format!("pressure = {number}"), "pressure", shown, "above 0 Pa");
    }
    inflation_refused("pressure = 1e5, sidewall_mass = -1", "sidewall_mass", "-1 is out", "at least 0 kg/m^2");
    inflation_refused("pressure = 1e5, sidewall_mas = 1", "sidewall_mas", "not a key", "`sidewall_mass`");
    let arc = |from: &str, to: &str| replaced(ARC, &[(from, to)]);
    inflation_refused(&arc("= 0.05", "= 0"), "sidewall_radius", "0 is out", "above 0 m");
    inflation_refused(&format!("{ARC}, sidewall_shear = -1"), "sidewall_shear", "-1 is out", "at least 0 N/m");
}

#[test]
fn arcs_are_given_as_a_whole_or_not_at_all() {
    inflation_refused("pressure = 1e5, sidewall_radius = 0.05", "sidewall_angle", "missing", "rad");
    inflation_refused("pressure = 1e5, sidewall_angle = 1.1", "sidewall_radius", "missing", "above 0 m");
    let keys = "inflation = { pressure = 1e5, sidewall_shear = 1 }\ncontact_width = 0.12";
    let found = complaints(&replaced(BASE, &[("contact_width = 0.12", keys)]));
    let keys: Vec<_> = found.iter().map(|complaint| complaint.key.as_str()).collect();
    assert_eq!(keys, ["tyre.inflation.sidewall_radius", "tyre.inflation.sidewall_angle"]);
}

#[test]
fn angles_without_an_arc() {
    let with = |angle: &str| replaced(ARC, &[("= 1.1", &format!("= {angle}"))]);
    for angle in ["0", "-1.1", "3.1416", "90"] {
        inflation_refused(&with(angle), "sidewall_angle", "not half the angle of an arc", "above 0 and below pi rad");
    }
    inflation_refused(&with("nan"), "sidewall_angle", "not a finite number", "rad");
    // So small that the chord is the arc to the last digit, so large that the wall yields the more the more it is bent.
    for angle in ["1e-9", "2.85"] {
        let text = left_out(&format!("{{ {}, sidewall_shear = 8e3 }}", with(angle)));
        let found = complaints(&replaced(&text, &[("= 0.05", "= 0.01")]));
        let [only] = found.as_slice() else { panic!("{angle}: {found:#?}") };
        assert_eq!((only.line, only.key.as_str()), (6, "tyre.inflation.sidewall_angle"), "{only:?}");
        assert!(only.wrong.contains("foundation.normal") && only.wrong.contains("bears nothing"), "{}", only.wrong);
        assert!(only.right.contains("give foundation.normal"), "{}", only.right);
    }
}

#[test]
fn a_belt_that_would_buckle() {
    let inflation = replaced(ARC, &[("radius = 0.05", "radius = 0.3")]);
    let found = complaints(&left_out(&format!("{{ {inflation} }}")));
    let [only] = found.as_slice() else { panic!("{found:#?}") };
    assert_eq!((only.line, only.key.as_str()), (6, "tyre.inflation.sidewall_angle"));
    assert_eq!(
        only.wrong,
        "the sidewalls pull the belt inwards by 2.994e5 Pa, the pressure is 220000 Pa: a tension of -2.313e4 N/m would \
         buckle it"
    );
    assert_eq!(
        only.right,
        "write a number above 1.2310 rad, a sidewall_radius below 0.2205 m, or the innermost layer's tension"
    );
    // What it says would be right is.
    for (from, to) in [
        ("sidewall_angle = 1.1", "sidewall_angle = 1.232"),
        ("sidewall_radius = 0.3", "sidewall_radius = 0.22"),
        ("name = \"belt\"\n", "name = \"belt\"\ntension = [6e4, 2e4]\n"),
    ] {
        let text = replaced(&left_out(&format!("{{ {inflation} }}")), &[(from, to)]);
        assert!(Scene::from_str(&text, "right").is_ok(), "{to}");
    }
}

#[test]
fn what_is_left_out_comes_from_the_sidewalls_and_what_is_given_wins() {
    let tyre =
        |text: &str| Scene::from_str(text, "x").unwrap_or_else(|error| panic!("{}", error.render(false))).scene.tyre;
    let inflation = format!("{{ {ARC}, sidewall_shear = 8e3 }}");
    let text = left_out(&inflation);
    let all = tyre(&text);
    let carried = all.carried().unwrap();
    assert_eq!((all.layers[0].tension, all.layers[1].tension), ([carried.tension, 0.0], [0.0; 2]));
    assert_eq!((all.foundation.normal, all.foundation.tangential), (carried.normal, carried.tangential));
    assert!(all.foundation.loss_factor.abs() < 1e-15);
    let inner = 1.95 / std::f64::consts::TAU - 0.019;
    assert!((carried.tension / (inner * 2.2e5 * (1.0 - 0.1 * 1.1_f64.cos() / 0.2)) - 1.0).abs() < 1e-12);

    let given = format!("foundation = {{ normal = 7e6, loss_factor = 0.2 }}\ninflation = {inflation}");
    let some = tyre(&replaced(&text, &[(&format!("inflation = {inflation}"), &given)]));
    assert_eq!((some.foundation.normal, some.foundation.tangential), (7e6, carried.tangential));
    assert!((some.foundation.loss_factor - 0.2).abs() < 1e-15);
    let tense = tyre(&replaced(&text, &[("name = \"belt\"\n", "name = \"belt\"\ntension = [5e4, 1e4]\n")]));
    assert_eq!((tense.layers[0].tension, tense.layers[1].tension), ([5e4, 1e4], [0.0; 2]));
    // Written out, all of it is given, and the same.
    let scene = Scene::from_str(&text, "x").unwrap().scene;
    assert_eq!(Scene::from_str(&scene.to_toml().unwrap(), "written").unwrap().scene, scene);
}

#[test]
fn without_arcs_the_foundation_must_be_given() {
    for (inflation, line) in [("inflation = { pressure = 2.2e5 }\n", 2), ("", 2)] {
        let from = "foundation = { normal = 1.8e6, tangential = 1e6, loss_factor = 0.1 }\n";
        refused(from, inflation, line, "tyre.foundation", "missing", "{ normal = ...");
    }
    refused("normal = 1.8e6, ", "", 6, "tyre.foundation.normal", "missing", "at least 0 N/m^3");
    // A foundation that might come from an inflation with a mistake is not missed.
    let text = left_out(&format!("{{ {} }}", replaced(ARC, &[("pressure = 2.2e5", "pressure = -1")])));
    let found = complaints(&text);
    assert!(found.len() == 1 && found[0].key == "tyre.inflation.pressure", "{found:#?}");
}

#[test]
fn numbers_of_the_cavity() {
    cavity_refused("depth = 0.08, density = 3.8", ".radius", "missing", "above 0 m");
    cavity_refused("radius = 0.235, density = 3.8", ".depth", "missing", "above 0 m");
    cavity_refused("radius = 0.235, depth = 0.08", ".density", "missing", "above 0 kg/m^3");
    cavity_refused(&replaced(AIR, &[("depth = 0.08", "depth = 0.235")]), ".depth", "0.235 m is not below", "0.235 m");
    cavity_refused(&replaced(AIR, &[("0.235", "0.32")]), ".radius", "0.32 m is not below the tyre's radius", "0.31");
    cavity_refused(&replaced(AIR, &[("density = 3.8", "density = inf")]), ".density", "not a finite", "kg/m^3");
    cavity_refused(&format!("{AIR}, sound_speed = 0"), ".sound_speed", "0 is out", "above 0 m/s");
    cavity_refused(&format!("{AIR}, relaxation = -1"), ".relaxation", "-1 is out", "at least 0 s");
    let keys = format!("curvature = true\nsides = \"guided\"\ncavity = {{ {AIR} }}\ncontact_width = 0.12");
    let expected = Cavity { radius: 0.235, depth: 0.08, density: 3.8, sound_speed: 343.0, relaxation: 0.0 };
    assert_eq!(accepted("contact_width = 0.12", &keys).tyre.cavity, Some(expected));
}

#[test]
fn what_a_shape_does_not_have() {
    let cavity = format!("sides = \"guided\"\ncavity = {{ {AIR} }}");
    tyre_refused(&cavity, 6, "tyre.cavity", "nothing with a flat tyre", "curvature = true");
    let cavity = format!("curvature = true\ncavity = {{ {AIR} }}");
    tyre_refused(&cavity, 6, "tyre.cavity", "no wave that is constant across", "sides = \"guided\"");
    inflation_refused("pressure = 1e5, sidewall_mass = 2", "sidewall_mass", "nothing with a flat", "curvature = true");
    let thick = replaced(BASE, &[("width = 0.2\n", "width = 0.2\ncurvature = true\n"), ("= 0.013", "= 0.31")]);
    let found = complaints(&thick);
    assert!(found.len() == 1 && found[0].key == "tyre.layers", "{found:#?}");
    assert!(found[0].wrong.contains("0.316 m thick together"), "{}", found[0].wrong);
    assert!(Scene::from_str(&replaced(&thick, &[("curvature = true", "curvature = false")]), "flat").is_ok());
    let tense = [("width = 0.2\n", "width = 0.2\ncurvature = true\n"), ("= 0.013", "= 0.013\ntension = [1e3, 0]")];
    assert!(Scene::from_str(&replaced(BASE, &tense), "a tread under tension").is_ok());
}
