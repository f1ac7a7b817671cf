//! Mistakes in a tyre's inflation and sidewalls, and in quantities that follow from them.

use super::super::super::{Cavity, Scene, Sides};
use super::super::{BASE, complaints};
use super::{accepted, refused};
use crate::test_models::replaced;

const ARC: &str = "radius = 0.05, angle = 1.1, mass = 7.0, shear = 8e3";
const AIR: &str = "radius = 0.235, depth = 0.08, density = 3.8";

/// Checks the only complaint about keys of the tyre put before its contact width.
#[track_caller]
fn tyre_refused(keys: &str, line: usize, key: &str, wrong: &str, right: &str) {
    refused("contact_width = 0.12", &format!("{keys}\ncontact_width = 0.12"), line, key, wrong, right);
}

/// Checks the only complaint about an inflation with these keys, put before the contact width.
#[track_caller]
fn inflation_refused(keys: &str, key: &str, wrong: &str, right: &str) {
    tyre_refused(&format!("inflation = {{ {keys} }}"), 5, &format!("tyre.inflation.{key}"), wrong, right);
}

/// Checks the only complaint about a cavity with these keys, in a curved tyre with guided sides.
#[track_caller]
fn cavity_refused(keys: &str, key: &str, wrong: &str, right: &str) {
    let keys = format!("curvature = true\nsides = \"guided\"\ncavity = {{ {keys} }}");
    tyre_refused(&keys, 7, &format!("tyre.cavity{key}"), wrong, right);
}

/// The base scene curved and inflated, with sidewalls and without foundation and tensions; the sidewalls are in line 7.
fn on_sidewalls(sidewall: &str) -> String {
    let foundation = "foundation = { normal = 1.8e6, tangential = 1e6, loss_factor = 0.1 }";
    let instead = format!("curvature = true\nsidewall = {{ {sidewall} }}\ninflation = {{ pressure = 2.2e5 }}");
    replaced(BASE, &[(foundation, &instead), ("tension = [6e4, 2e4]\n", "")])
}

/// Checks the only complaint about a scene on sidewalls.
#[track_caller]
fn sidewall_refused(sidewall: &str, key: &str, wrong: &str, right: &str) {
    let found = complaints(&on_sidewalls(sidewall));
    let [only] = found.as_slice() else { panic!("{found:#?}") };
    assert_eq!((only.line, only.key.as_str()), (7, format!("tyre.sidewall{key}").as_str()), "{only:?}");
    assert!(only.wrong.contains(wrong) && only.right.contains(right), "{only:?}");
}

#[test]
fn words_and_flags() {
    tyre_refused("sides = \"gided\"", 5, "tyre.sides", "\"gided\" is not known", "did you mean \"guided\"?");
    tyre_refused("sides = true", 5, "tyre.sides", "is not allowed here", "one of \"supported\", \"guided\"");
    tyre_refused("curvature = 1", 5, "tyre.curvature", "1 is not allowed here", "true or false");
    tyre_refused("inflation = 2.2e5", 5, "tyre.inflation", "is not allowed here", "{ pressure = ...");
    tyre_refused("curvature = true\ncavity = true", 6, "tyre.cavity", "is not allowed here", "{ radius = ...");
    let tyre = accepted("contact_width", "sides = \"guided\"\ncurvature = true\ncontact_width").tyre;
    assert!(tyre.sides == Sides::Guided && tyre.curvature);
}

#[test]
fn numbers_of_the_inflation() {
    inflation_refused("", "pressure", "missing", "above 0 Pa");
    for (number, shown) in [("0", "0 is out"), ("-1", "-1 is out"), ("nan", "not a finite"), ("inf", "not a finite")] {
        inflation_refused(&format!("pressure = {number}"), "pressure", shown, "above 0 Pa");
    }
    inflation_refused("pressure = 1e5, presure = 1", "presure", "not a key", "known keys: pressure");
}

#[test]
fn keys_of_the_sidewalls_have_a_table_of_their_own_now() {
    for key in ["radius", "angle", "mass", "shear"] {
        let now = format!("`tyre.sidewall.{key}` now");
        inflation_refused(
            &format!("pressure = 1e5, sidewall_{key} = 1"),
            &format!("sidewall_{key}"),
            &now,
            "[tyre.sidew",
        );
    }
    let keys = "inflation = { pressure = 1e5, sidewall_radius = 0.05, sidewall_angle = 1.1 }\ncontact_width = 0.12";
    let found = complaints(&replaced(BASE, &[("contact_width = 0.12", keys)]));
    let keys: Vec<_> = found.iter().map(|complaint| complaint.key.as_str()).collect();
    assert_eq!(keys, ["tyre.inflation.sidewall_radius", "tyre.inflation.sidewall_angle"]);
}

#[test]
fn numbers_of_the_sidewalls() {
    let with = |from: &str, to: &str| replaced(ARC, &[(from, to)]);
    for (key, unit) in [("radius", "0 m"), ("mass", "0 kg/m^2"), ("shear", "0 N/m")] {
        let value = ARC.split(", ").find(|part| part.starts_with(key)).unwrap();
        for wrong in ["0", "-1"] {
            let zero = with(value, &format!("{key} = {wrong}"));
            sidewall_refused(&zero, &format!(".{key}"), &format!("{wrong} is out of range"), unit);
        }
        sidewall_refused(&with(value, &format!("{key} = nan")), &format!(".{key}"), "not a finite number", unit);
        let left_out = ARC.split(", ").filter(|part| *part != value).collect::<Vec<_>>().join(", ");
        sidewall_refused(&left_out, &format!(".{key}"), "missing", unit);
    }
    for angle in ["0", "-1.1", "3.15", "90"] {
        sidewall_refused(
            &with("angle = 1.1", &format!("angle = {angle}")),
            ".angle",
            "is out of range",
            "above 0 and below",
        );
    }
    sidewall_refused(&format!("{ARC}, loss_factor = -0.1"), ".loss_factor", "-0.1 is out", "at least 0");
    sidewall_refused(&format!("{ARC}, hoop = 1e3"), ".hoop", "less than a quarter of the shear", "leave it out");
    sidewall_refused(&format!("{ARC}, mas = 1"), ".mas", "not a key", "known keys");
    sidewall_refused(&with("radius = 0.05", "radius = 0.17"), ".radius", "is 0.29", "a shorter radius");
    sidewall_refused(&with("angle = 1.1", "angle = 3.1"), ".angle", "no stable shape", "from 0.5 to 1.5 rad");
}

#[test]
fn a_belt_that_would_buckle() {
    let pulls = replaced(ARC, &[("radius = 0.05", "radius = 0.15"), ("angle = 1.1", "angle = 0.2")]);
    sidewall_refused(&pulls, ".angle", "would buckle it", "a larger angle, a shorter radius, or a layer's tension");
    for (from, to) in [
        ("angle = 0.2", "angle = 1.0"),
        ("radius = 0.15", "radius = 0.03"),
        ("name = \"belt\"\n", "name = \"belt\"\ntension = [6e4, 2e4]\n"),
    ] {
        let text = replaced(&on_sidewalls(&pulls), &[(from, to)]);
        assert!(Scene::from_str(&text, "right").is_ok(), "{to}");
    }
}

#[test]
fn a_tension_left_out_comes_from_the_sidewalls() {
    let tyre =
        |text: &str| Scene::from_str(text, "x").unwrap_or_else(|error| panic!("{}", error.render(false))).scene.tyre;
    let text = on_sidewalls(ARC);
    let all = tyre(&text);
    let carried = all.carried_tension().unwrap();
    assert_eq!((all.layers[0].tension, all.layers[1].tension), ([carried, 0.0], [0.0; 2]));
    // A flat arc would pull 2 p r cos(phi); the true circumference changes that by some percent.
    let inner = 1.95 / std::f64::consts::TAU - 0.019;
    let flat = inner * 2.2e5 * (1.0 - 0.1 * 1.1_f64.cos() / 0.2);
    assert!((carried / flat - 1.0).abs() < 0.1 && (carried / flat - 1.0).abs() > 0.01, "{carried} {flat}");
    let tense = tyre(&replaced(&text, &[("name = \"tread\"\n", "name = \"tread\"\ntension = [5e4, 1e4]\n")]));
    assert_eq!((tense.layers[0].tension, tense.layers[1].tension), ([0.0; 2], [5e4, 1e4]));
    // When the scene is written out the tension is given, with the same value.
    let scene = Scene::from_str(&text, "x").unwrap().scene;
    assert_eq!(Scene::from_str(&scene.to_toml().unwrap(), "written").unwrap().scene, scene);
}

#[test]
fn either_a_foundation_or_sidewalls_hold_a_tyre() {
    for inflation in ["inflation = { pressure = 2.2e5 }\n", ""] {
        let from = "foundation = { normal = 1.8e6, tangential = 1e6, loss_factor = 0.1 }\n";
        refused(from, inflation, 2, "tyre.foundation", "missing", "{ normal = ...");
    }
    refused("normal = 1.8e6, ", "", 6, "tyre.foundation.normal", "missing", "at least 0 N/m^3");
    let nothing = "foundation = { normal = 0, tangential = 0 }";
    let from = "foundation = { normal = 1.8e6, tangential = 1e6, loss_factor = 0.1 }";
    refused(from, nothing, 6, "tyre.foundation", "carries no load", "above 0 N/m^3");
    let both = replaced(&on_sidewalls(ARC), &[("curvature = true\n", &format!("curvature = true\n{from}\n"))]);
    let found = complaints(&both);
    let [only] = found.as_slice() else { panic!("{found:#?}") };
    assert_eq!((only.line, only.key.as_str()), (7, "tyre.foundation"));
    assert!(only.wrong.contains("`sidewall` exclude each other"), "{only:?}");
    for (part, key, wrong) in [
        ("inflation = { pressure = 2.2e5 }\n", "tyre.inflation", "missing"),
        ("curvature = true\n", "tyre.sidewall", "does not apply with a flat tyre"),
    ] {
        let found = complaints(&replaced(&on_sidewalls(ARC), &[(part, "")]));
        let [only] = found.as_slice() else { panic!("{found:#?}") };
        assert!(only.key == key && only.wrong.contains(wrong), "{only:?}");
    }
    // If the sidewalls themselves are wrong, nothing else is complained about.
    sidewall_refused(&replaced(ARC, &[("angle = 1.1, ", "")]), ".angle", "missing", "rad");
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
    tyre_refused(&cavity, 6, "tyre.cavity", "does not apply with a flat tyre", "curvature = true");
    let cavity = format!("curvature = true\ncavity = {{ {AIR} }}");
    tyre_refused(&cavity, 6, "tyre.cavity", "no wave that is constant across", "sides = \"guided\"");
    let thick = replaced(BASE, &[("width = 0.2\n", "width = 0.2\ncurvature = true\n"), ("= 0.013", "= 0.31")]);
    let found = complaints(&thick);
    assert!(found.len() == 1 && found[0].key == "tyre.layers", "{found:#?}");
    assert!(found[0].wrong.contains("0.316 m thick together"), "{}", found[0].wrong);
    assert!(Scene::from_str(&replaced(&thick, &[("curvature = true", "curvature = false")]), "flat").is_ok());
    let tense = [("width = 0.2\n", "width = 0.2\ncurvature = true\n"), ("= 0.013", "= 0.013\ntension = [1e3, 0]")];
    assert!(Scene::from_str(&replaced(BASE, &tense), "a tread under tension").is_ok());
}
