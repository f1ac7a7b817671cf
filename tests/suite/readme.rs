//! Statements of the README and of the pages under docs/, executed.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use tyrewave::scene::{Axle, DEFAULT, Scene};

use crate::suite::common::program;

const README: &str = include_str!("../../README.md");
const SCENES: &str = include_str!("../../docs/scenes.md");
const LONGER: &str = include_str!("../README.md");

/// Texts of the fenced blocks of a language.
fn blocks<'a>(page: &'a str, language: &str) -> Vec<&'a str> {
    let fence = format!("```{language}\n");
    page.split(fence.as_str()).skip(1).map(|rest| rest.split("```").next().unwrap()).collect()
}

/// README, the pages beside it and those under docs/: folder and text.
fn pages() -> Vec<(PathBuf, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let docs = root.join("docs");
    let paths = fs::read_dir(&docs).unwrap().map(|entry| entry.unwrap().path());
    let texts = paths.filter(|path| path.extension().is_some_and(|ending| ending == "md"));
    let beside = ["CONTRIBUTING.md", "ARCHITECTURE.md"].map(|name| fs::read_to_string(root.join(name)).unwrap());
    let mut pages = vec![(root.to_owned(), README.to_owned())];
    pages.extend(beside.map(|text| (root.to_owned(), text)));
    pages.extend(texts.map(|path| (docs.clone(), fs::read_to_string(path).unwrap())));
    pages
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

/// The program's help of a command.
fn help(command: &str) -> String {
    let output = Command::new(program()).args([command, "--help"]).output().unwrap();
    assert!(output.status.success(), "{command}");
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn commands_exist_with_the_options_shown() {
    let mut found = 0;
    for (_, page) in pages() {
        let lines = blocks(&page, "sh").into_iter().flat_map(str::lines);
        for text in lines.chain(page.split('`').skip(1).step_by(2)) {
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
            let help = help(words[0]);
            for option in words.iter().filter(|word| word.starts_with("--")) {
                assert!(help.contains(option), "{text}: {option} is no option");
            }
            // The tutorial makes its own.
            for file in words.iter().filter(|word| word.ends_with(".toml") && !word.starts_with("trial/")) {
                assert!(fs::exists(file).unwrap(), "{text}: there is no {file}");
            }
        }
    }
    assert!(found >= 40, "{found} commands found");
}

#[test]
fn pages_are_narrow_and_the_readme_is_short() {
    assert!(README.lines().count() < 150);
    for (_, page) in pages() {
        for line in page.lines() {
            assert!(line.chars().count() <= 120, "{line}");
        }
    }
}

/// Name by which a page's heading is linked to.
fn anchor(heading: &str) -> String {
    let kept = heading.trim_start_matches('#').trim().chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
    kept.collect::<String>().to_lowercase().replace(' ', "-")
}

#[test]
fn links_between_pages_lead_somewhere() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut all = pages();
    for (folder, name) in [("profiles", "README.md"), ("profiles", "GALLERY.md"), ("python", "README.md")] {
        all.push((root.join(folder), fs::read_to_string(root.join(folder).join(name)).unwrap()));
    }
    all.push((root.join("tests"), LONGER.to_owned()));
    let mut found = 0;
    for (folder, page) in all {
        let targets = page.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(target, _)| target);
        for target in targets.filter(|target| !target.contains("://")) {
            let (file, heading) = target.split_once('#').map_or((target, None), |(file, name)| (file, Some(name)));
            let path = folder.join(file);
            assert!(path.exists(), "{}: there is no {target}", folder.display());
            if let Some(heading) = heading {
                let text = if file.is_empty() { page.clone() } else { fs::read_to_string(&path).unwrap() };
                let held = text.lines().any(|line| line.starts_with('#') && anchor(line) == heading);
                assert!(held, "{}: {target} is no heading", folder.display());
            }
            found += 1;
        }
    }
    assert!(found > 60, "{found}");
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
    for (folder, page) in pages() {
        for link in page.split("](").skip(1).map(|rest| rest.split(')').next().unwrap()) {
            let local = !link.contains("://") && !link.starts_with('#');
            assert!(!local || folder.join(link).exists(), "{}: there is no {link}", folder.display());
        }
    }
}

#[test]
fn files_of_the_results_are_named() {
    for file in ["summary.json", "time.npy", "total_force.npy", "patch_force.npy", "patch_element.npy", "spectra.csv"] {
        assert!(README.contains(&format!("`{file}`")), "{file}");
    }
}
