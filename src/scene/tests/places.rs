//! Complaints of later stages, and queries of a loaded scene.

use super::super::{LoadedScene, Scene, SceneError};
use super::{BASE, edited, hash, listed};

fn loaded(text: &str) -> LoadedScene {
    Scene::from_str(text, "folder/test.toml").unwrap()
}

#[test]
fn later_complaints_point_into_the_file() {
    let scene = loaded(BASE);
    for (key, line, column) in [
        ("rolling.duration", 20, 12),
        ("rolling.axle.load", 21, 17),
        ("tyre.layers[1].thickness", 14, 13),
        ("tyre.layers[0].tension[1]", 10, 17),
        ("tyre.layers[1]", 12, 1),
        ("road", 16, 2),
    ] {
        let diagnostic = scene.complain(key, "too short", "take a longer one");
        assert_eq!((diagnostic.key(), diagnostic.line()), (key, line));
        assert!(diagnostic.column().abs_diff(column) <= 1, "{key}: column {}", diagnostic.column());
        assert_eq!(diagnostic.file(), "folder/test.toml");
        assert!(diagnostic.to_string().contains("too short (take a longer one)"));
    }
}

#[test]
fn a_key_that_was_left_out_is_placed_at_the_table_around_it() {
    let scene = loaded(BASE);
    let places = [("numerics.memory", 24), ("tyre.layers[1].material.corner_frequency", 15), ("road.file", 16)];
    for (key, line) in places {
        let diagnostic = scene.complain(key, "wrong", "right");
        assert_eq!((diagnostic.key(), diagnostic.line()), (key, line));
    }
    let error = SceneError::from(scene.complain("elsewhere", "wrong", "right"));
    assert_eq!(error.to_string(), "folder/test.toml:1:1: elsewhere: wrong (right)");
    assert!(error.render(false).contains("wrong"));
}

#[test]
fn a_hysteretic_layer_is_refused_in_the_time_domain_only() {
    let scene = loaded(&edited("law = \"power-law\"", "law = \"hysteretic\""));
    let found = listed(&scene.check_time_domain().unwrap_err());
    assert_eq!((found.len(), found[0].line, found[0].column), (1, 15, 20));
    assert_eq!(found[0].key, "tyre.layers[1].material.law");
    assert!(found[0].wrong.contains("not causal"));
    for law in ["power-law", "prony", "elastic"] {
        assert!(found[0].right.contains(law), "{}", found[0].right);
    }
    assert!(loaded(BASE).check_time_domain().is_ok());
}

#[test]
fn the_hash_is_of_the_settings_and_not_of_the_formatting() {
    let scene = loaded(BASE);
    assert_eq!(hash(&scene).len(), 64);
    let spelt_out = loaded(&edited("elements = 512", "# as default\nsubsteps = 1\nelements = 0x200"));
    assert_eq!(hash(&scene), hash(&spelt_out));
    for (from, to) in [("elements = 512", "elements = 514"), ("load = 3400", "load = 3400.0000000000005")] {
        assert_ne!(hash(&scene), hash(&loaded(&edited(from, to))), "{to}");
    }
}

#[test]
fn the_name_is_the_files() {
    assert_eq!(loaded(BASE).name(), "test");
}
