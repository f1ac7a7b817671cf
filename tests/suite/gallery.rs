//! The scenes to begin with: each of them rolls, and stands in the gallery with its picture.

use std::fs;
use std::path::Path;

use tyrewave::internals::{CHIP_SEAL, reference};

use crate::archive::copy;
use crate::common::{read_summary, tyrewave};

const GALLERY: &str = include_str!("../../profiles/GALLERY.md");

/// A copy of the scenes' folder with a measured station in it.
fn scenes() -> (tempfile::TempDir, Vec<String>) {
    let folder = tempfile::tempdir().unwrap();
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    copy(&from, folder.path());
    fs::copy(reference(CHIP_SEAL), folder.path().join("roads/station.dat")).unwrap();
    (folder, names_in(&from))
}

fn names_in(folder: &Path) -> Vec<String> {
    let files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let scenes = files.filter(|path| path.extension().is_some_and(|ending| ending == "toml"));
    let mut names: Vec<String> = scenes.map(|path| path.file_name().unwrap().to_str().unwrap().to_owned()).collect();
    names.sort();
    names
}

#[test]
fn every_scene_rolls_at_draft_quality() {
    let (folder, names) = scenes();
    assert!(names.len() >= 10, "{names:?}");
    for name in names {
        let mut settings = vec!["numerics={ elements = 128, pole_tolerance = 1e-3 }"];
        // In so short a run the load is met roughly.
        let short =
            ["rolling.warm_up=0.1", "rolling.duration=0.2", "rolling.axle.tolerance=0.5", "outputs.plots=false"];
        settings.extend(short);
        if ["cells.toml", "chip_seal.toml", "sound.toml"].contains(&name.as_str()) {
            settings.push("contact.cells_across=6");
        }
        if name == "sound.toml" {
            settings.extend(["radiation={ quality = \"draft\", fmax = 300.0 }", "receiver=[{ standard = \"cpx\" }]"]);
        }
        let settings = settings.iter().flat_map(|setting| ["--set", setting]);
        let arguments: Vec<&str> = ["run", &name, "--out", "out", "-q"].into_iter().chain(settings).collect();
        let output = tyrewave(folder.path(), &arguments);
        assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
        let summary = read_summary(&folder.path().join("out"));
        let force = summary["outcome"]["mean_force"].as_f64().unwrap();
        assert!((1500.0..6000.0).contains(&force), "{name}: {force} N");
        assert_eq!(summary["contact"]["aborted_searches"], 0, "{name}");
    }
}

#[test]
fn every_scene_stands_in_the_gallery_with_its_picture() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for name in names_in(&root.join("scenes")) {
        let name = name.trim_end_matches(".toml");
        assert!(GALLERY.contains(&format!("scenes/{name}.toml")), "{name} is not in profiles/GALLERY.md");
        if name != "station" {
            let picture = format!("pictures/scene_{name}.svg");
            assert!(GALLERY.contains(&picture) && root.join("profiles").join(&picture).is_file(), "{picture}");
        }
    }
}
