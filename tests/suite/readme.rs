//! Statements of the README and of the pages under docs/, executed.

use std::fs;
use std::path::Path;

use tyrewave::scene::{Axle, DEFAULT, Scene};

const README: &str = include_str!("../../README.md");
const SCENES: &str = include_str!("../../docs/scenes.md");
const LONGER: &str = include_str!("../README.md");

/// Texts of the fenced blocks of a language.
fn blocks<'a>(page: &'a str, language: &str) -> Vec<&'a str> {
    let fence = format!("```{language}\n");
    page.split(fence.as_str()).skip(1).map(|rest| rest.split("```").next().unwrap()).collect()
}

/// README, the pages beside it and those under docs/.
fn pages() -> Vec<String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let beside = ["README.md", "CONTRIBUTING.md", "ARCHITECTURE.md"].map(|name| root.join(name));
    let docs = fs::read_dir(root.join("docs")).unwrap().map(|entry| entry.unwrap().path());
    let docs = docs.filter(|path| path.extension().is_some_and(|ending| ending == "md"));
    beside.into_iter().chain(docs).map(|path| fs::read_to_string(path).unwrap()).collect()
}

#[test]
fn the_first_scene_is_the_default_scene() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("tyres")).unwrap();
    let tyre = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/tyres/car.toml");
    fs::copy(tyre, folder.path().join("tyres/car.toml")).unwrap();
    let default = Scene::from_str(DEFAULT, "default").unwrap().scene;
    let shown = blocks(SCENES, "toml");
    let path = folder.path().join("scene.toml");
    fs::write(&path, shown[0]).unwrap();
    assert_eq!(Scene::load(&path).unwrap().scene, default, "the first scene of docs/scenes.md is not the default one");
}

#[test]
fn pages_are_narrow_and_the_readme_is_short() {
    assert!(README.lines().count() < 150);
    for page in pages() {
        for line in page.lines() {
            assert!(line.chars().count() <= 120, "{line}");
        }
    }
}

#[test]
fn ignored_tests_named_exist_and_every_ignored_test_is_named() {
    let mut ignored = 0;
    for entry in fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/suite")).unwrap() {
        let path = entry.unwrap().path();
        let Ok(text) = fs::read_to_string(&path) else { continue };
        for after in text.split("\n#[ignore").skip(1) {
            let name = after.split("fn ").nth(1).unwrap().split('(').next().unwrap();
            ignored += 1;
            assert!(LONGER.contains(&format!("`{name}`")), "tests/README.md does not name the ignored test {name}");
        }
    }
    assert!(ignored >= 3);
}

#[test]
fn figures_in_the_text_are_those_of_the_default_scene() {
    let scene = Scene::from_str(DEFAULT, "default").unwrap().scene;
    assert!(README.contains(&format!("at {} km/h", scene.rolling.speed_kmh)));
    assert!(matches!(scene.rolling.axle, Axle::Load { .. }));
    for file in ["LICENSE-MIT", "LICENSE-APACHE", ".ci/run"] {
        assert!(
            README.contains(file) && fs::exists(concat!(env!("CARGO_MANIFEST_DIR"), "/").to_owned() + file).unwrap()
        );
    }
}

#[test]
fn files_of_the_results_are_named() {
    for file in ["summary.json", "time.npy", "total_force.npy", "patch_force.npy", "patch_element.npy", "spectra.csv"] {
        assert!(README.contains(&format!("`{file}`")), "{file}");
    }
}
