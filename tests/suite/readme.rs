//! Statements of the README, executed.

use std::fs;
use std::process::Command;

use tyrewave::scene::{Axle, DEFAULT, Scene};

const README: &str = include_str!("../../README.md");
const LONGER: &str = include_str!("../README.md");

/// Texts of the fenced blocks of a language.
fn blocks(language: &str) -> Vec<&'static str> {
    let fence = format!("```{language}\n");
    README.split(fence.as_str()).skip(1).map(|rest| rest.split("```").next().unwrap()).collect()
}

#[test]
fn the_first_scene_is_the_default_scene() {
    let scenes = blocks("toml");
    assert_eq!(scenes[0], DEFAULT, "the README's first scene is not scenes/default.toml");
    for scene in scenes {
        Scene::from_str(scene, "README.md").unwrap();
    }
}

#[test]
fn commands_exist_with_the_options_shown() {
    let mut found = 0;
    let lines = blocks("sh").into_iter().flat_map(str::lines);
    let spans = README.split('`').skip(1).step_by(2);
    for text in lines.chain(spans) {
        let text = text.split('#').next().unwrap().trim();
        let Some(rest) = text.strip_prefix("tyrewave ").or_else(|| {
            text.split_once(" -- ").and_then(|(cargo, rest)| cargo.starts_with("cargo run").then_some(rest))
        }) else {
            continue;
        };
        found += 1;
        let words: Vec<&str> = rest.split_whitespace().collect();
        if words[0] == "help" {
            continue;
        }
        let output = Command::new(env!("CARGO_BIN_EXE_tyrewave")).args([words[0], "--help"]).output().unwrap();
        assert!(output.status.success(), "{text}");
        let help = String::from_utf8(output.stdout).unwrap();
        for option in words.iter().filter(|word| word.starts_with("--")) {
            assert!(help.contains(option), "{text}: {option} is no option");
        }
        for file in words.iter().filter(|word| word.ends_with(".toml")) {
            assert!(fs::exists(file).unwrap(), "{text}: there is no {file}");
        }
    }
    assert!(found >= 4, "{found} commands found");
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
    for link in README.split("](").skip(1).map(|rest| rest.split(')').next().unwrap()) {
        let local = !link.contains("://");
        assert!(!local || fs::exists(link).unwrap(), "the README links to {link}, which is not there");
    }
}

#[test]
fn files_of_the_results_are_named() {
    for file in ["summary.json", "time.npy", "total_force.npy", "patch_force.npy", "patch_element.npy", "spectra.csv"] {
        assert!(README.contains(&format!("`{file}`")), "{file}");
    }
}
