//! Mistakes in effects and in requests for an accuracy.

use super::super::super::{Scene, Switch};
use super::super::{BASE, edited};
use super::{accepted, refused};

/// Checks the only complaint about the base scene with a table of effects before the contact's.
#[track_caller]
fn effect_refused(effect: &str, key: &str, wrong: &str, right: &str) {
    refused("[contact]", &format!("[effects]\n{effect}\n[contact]"), 23, key, wrong, right);
}

#[test]
fn switches() {
    effect_refused("texture = \"offf\"", "effects.texture", "\"offf\" is not known", "did you mean \"off\"?");
    effect_refused("texture = true", "effects.texture", "true is not allowed here", "one of \"on\", \"off\", \"auto\"");
    effect_refused("tangential = \"on\"", "effects.tangential", "not a key of [effects]", "tangential_motion");
    let later = accepted("[contact]", "[effects]\nradiation = \"auto\"\nfriction = \"off\"\n[contact]");
    assert_eq!((later.effects.radiation, later.effects.friction), (Switch::Auto, Switch::Off));
}

#[test]
fn friction_that_is_switched_on_needs_its_table() {
    effect_refused("friction = \"on\"", "effects.friction", "there is no [friction]", "a table [friction]");
}

#[test]
fn effects_that_contradict_the_scene() {
    effect_refused("texture = \"on\"", "effects.texture", "a smooth road has no texture", "\"off\", \"auto\"");
    let text = edited("[contact]", "[effects]\ntexture = \"off\"\n[contact]\ncells_across = 8");
    let error = Scene::from_str(&text, "x").unwrap_err();
    assert_eq!(error.diagnostics()[0].key(), "contact.cells_across", "{error}");
}

#[test]
fn rotation_needs_a_curved_tyre_and_replaces_tension() {
    effect_refused("rotation = \"on\"", "effects.rotation", "a flat plate does not turn", "curvature = true");
    let (key, wrong) = ("effects.centrifugal_tension", "this key has been removed");
    effect_refused("centrifugal_tension = \"auto\"", key, wrong, "effects.rotation = \"auto\"");
    let off = accepted("[contact]", "[effects]\nrotation = \"off\"\n[contact]");
    assert_eq!(off.effects.rotation, Switch::Off);
}

#[test]
fn accuracy_and_presets() {
    let numerics = |keys: &str| format!("[numerics]\n{keys}");
    let of = |keys: &str| Scene::from_str(&edited("[numerics]", &numerics(keys)), "x");
    let message = |keys: &str| of(keys).unwrap_err().render(false);
    for (wish, key) in [("accuracy = \"7 dB\"", "accuracy"), ("preset = \"draft\"", "preset")] {
        let found = message(wish);
        assert!(found.contains("numerics.fmax") && found.contains(&format!("numerics.{key} is meant for")), "{found}");
    }
    assert!(message("fmax = 1000\naccuracy = 0.5").contains("\"0.5 dB\""));
    assert!(message("fmax = 1000\naccuracy = \"20 dB\"").contains("at most 12 dB"));
    assert!(message("fmax = 1000\naccuracy = \"nan dB\"").contains("finite"));
    let unknown = message("fmax = 1000\npreset = \"drafts\"");
    assert!(unknown.contains("did you mean \"draft\"?"), "{unknown}");
    let place = |keys: &str| {
        let error = of(keys).unwrap_err();
        let first = &error.diagnostics()[0];
        (first.line(), first.key().to_owned(), error.to_string())
    };
    let line = BASE.lines().position(|line| line == "[numerics]").unwrap() + 1;
    let (at, key, both) = place("fmax = 1000\npreset = \"draft\"\naccuracy = \"7 dB\"");
    assert_eq!((at, key.as_str()), (line + 3, "numerics.accuracy"));
    assert!(both.contains("either this or `preset`"), "{both}");
}

#[test]
fn effects_that_contradict_the_outputs() {
    let of = |effects: &str, vibration: &str| {
        let text = edited("[contact]", &format!("[effects]\n{effects}\n[contact]"));
        Scene::from_str(&format!("{text}[outputs.vibration]\n{vibration}\n"), "x")
    };
    let key = |effects: &str, vibration: &str| of(effects, vibration).unwrap_err().diagnostics()[0].key().to_owned();
    assert_eq!(key("belt_vibration = \"off\"", "tread = true"), "outputs.vibration.belt");
    assert_eq!(key("tangential_motion = \"on\"", "tread = true"), "effects.tangential_motion");
    assert!(of("belt_vibration = \"off\"", "belt = false").is_ok());
    assert!(of("belt_vibration = \"on\"\ntread_vibration = \"auto\"", "map = true").is_ok());
    let bedding = edited("tread = \"elastic\"", "tread = \"bedding\"\n[effects]\ntangential_motion = \"on\"");
    let error = Scene::from_str(&bedding, "x").unwrap_err();
    assert!(error.to_string().contains("a bedding's springs have no tangential motion"), "{error}");
}
