//! Mistakes in effects, and what `fmax` and `accuracy` choose.

use super::super::super::{FrontRow, History, Preset, Road, Scene, Switch, TimeRule};
use super::super::{BASE, edited};
use super::{accepted, refused};
use crate::test_models::replaced;

/// Puts a table of effects before the contact's.
#[track_caller]
fn effect_refused(effect: &str, key: &str, wrong: &str, right: &str) {
    refused("[contact]", &format!("[effects]\n{effect}\n[contact]"), 23, key, wrong, right);
}

#[test]
fn switches() {
    effect_refused("texture = \"offf\"", "effects.texture", "\"offf\" is not known", "did you mean \"off\"?");
    effect_refused("texture = true", "effects.texture", "true cannot stand here", "one of \"on\", \"off\", \"auto\"");
    effect_refused("tangential = \"on\"", "effects.tangential", "not a key of [effects]", "tangential_motion");
    let later = accepted("[contact]", "[effects]\nradiation = \"auto\"\nfriction = \"off\"\n[contact]");
    assert_eq!((later.effects.radiation, later.effects.friction), (Switch::Auto, Switch::Off));
}

#[test]
fn effects_that_are_not_there_yet_are_named() {
    effect_refused(
        "radiation = \"on\"",
        "effects.radiation",
        "sound radiation is not there yet",
        "\"off\", or \"auto\"",
    );
    effect_refused(
        "friction = \"on\"",
        "effects.friction",
        "tangential friction in the contact is not there yet",
        "\"off\"",
    );
}

#[test]
fn effects_that_contradict_the_scene() {
    effect_refused("texture = \"on\"", "effects.texture", "a smooth road has no texture", "\"off\", \"auto\"");
    let text = edited("[contact]", "[effects]\ntexture = \"off\"\n[contact]\ncells_across = 8");
    let error = Scene::from_str(&text, "x").unwrap_err();
    assert_eq!(error.diagnostics()[0].key(), "contact.cells_across", "{error}");
}

#[test]
fn auto_with_nothing_to_decide_from() {
    let auto = ("[contact]", "[effects]\ncentrifugal_tension = \"auto\"\n[contact]");
    let slack = replaced(BASE, &[("tension = [6e4, 2e4]", "tension = [0, 2e4]"), auto]);
    let error = Scene::from_str(&slack, "x").unwrap_err();
    assert!(error.to_string().contains("nothing to compare m'' V^2 with"), "{error}");
    assert!(Scene::from_str(&replaced(&slack, &[("= \"auto\"", "= \"on\"")]), "x").is_ok());
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
    let (at, key, fine) = place("fmax = 1000\naccuracy = \"0.06 dB\"");
    assert_eq!((at, key.as_str()), (line + 2, "numerics.accuracy"));
    assert!(fine.contains("finer than any row") && fine.contains(&format!("at least {} dB", FrontRow::finest_error())));
}

/// The base scene on a made road, without what a row of the table chooses, with keys under `[numerics]`.
fn open(keys: &str) -> String {
    let chosen = ["elements", "substeps", "time_rule", "history"];
    let left = BASE.lines().filter(|line| !chosen.iter().any(|key| line.starts_with(key)));
    let numerics = format!("[numerics]\nfmax = 1000\n{keys}");
    let changes = [("kind = \"smooth\"", "kind = \"made\""), ("[numerics]", numerics.as_str())];
    replaced(&left.collect::<Vec<_>>().join("\n"), &changes)
}

#[test]
fn what_is_not_given_follows_from_preset_and_accuracy_and_says_why() {
    for row in &FrontRow::ALL {
        let (name, error) = (row.preset.name(), row.error);
        let load =
            |wish: &str| Scene::from_str(&open(wish), "x").unwrap_or_else(|error| panic!("{}", error.render(false)));
        let (preset, accuracy) = (load(&format!("preset = \"{name}\"")), load(&format!("accuracy = \"{error} dB\"")));
        let mut same = accuracy.scene.clone();
        (same.numerics.preset, same.numerics.accuracy) = (Some(row.preset), None);
        assert_eq!(same, preset.scene);
        for (loaded, wish) in [(&preset, "preset"), (&accuracy, "accuracy")] {
            let keys: Vec<&str> = loaded.choices().iter().map(|choice| choice.key).collect();
            let first = format!("numerics.{wish}");
            let mut expected = vec![
                first.as_str(),
                "numerics.time_rule",
                "numerics.history",
                "numerics.pole_tolerance",
                "contact.slice_tolerance",
                "contact.cells_across",
                "numerics.elements",
                "numerics.substeps",
                "contact.cells_along",
            ];
            // The standard row's is the default.
            expected.retain(|key| *key != "contact.slice_tolerance" || row.preset != Preset::Standard);
            assert_eq!(keys, expected);
            assert!(loaded.choices()[0].reason.contains(&format!("within {error} dB")));
            assert!(loaded.choices().iter().all(|choice| !choice.reason.is_empty()));
            let found = &loaded.scene;
            assert_eq!(
                found.contact.cells_across,
                Some(Road::cells(found.tyre.contact_width, row.cell_for(found, found.numerics.fmax.unwrap())))
            );
            assert!((found.numerics.pole_tolerance / row.pole_tolerance - 1.0).abs() < 1e-12);
            // The effective settings read back as they are; all of them are given then.
            let again = Scene::from_str(&found.to_toml().unwrap(), "x").unwrap();
            assert_eq!(again.scene, *found);
            assert!(again.choices().is_empty(), "{:?}", again.choices());
        }
    }
}

#[test]
fn keys_that_are_given_stay_beside_a_preset() {
    let keys =
        "preset = \"draft\"\nelements = 1000\ntime_rule = \"sdirk2\"\nhistory = \"direct\"\npole_tolerance = 1e-8";
    let loaded = Scene::from_str(&open(keys), "x").unwrap();
    let numerics = &loaded.scene.numerics;
    assert_eq!((numerics.elements, numerics.time_rule, numerics.history), (1000, TimeRule::Sdirk2, History::Direct));
    assert!((numerics.pole_tolerance - 1e-8).abs() < 1e-20);
    let chosen: Vec<&str> = loaded.choices().iter().map(|choice| choice.key).collect();
    let expected = [
        "numerics.preset",
        "contact.slice_tolerance",
        "contact.cells_across",
        "numerics.substeps",
        "contact.cells_along",
    ];
    assert_eq!(chosen, expected);
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
