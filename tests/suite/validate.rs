//! `tyrewave validate`: a scene held against published values, and the README's section that it writes.

use std::fs;

use serde_json::Value;
use tyrewave::internals::{
    Lacks, StandingTyre, VALIDATION_MARKERS as MARKERS, ValidationMeasured as Measured,
    ValidationPublished as Published, scene_text, validation_markdown as markdown, validation_rows as rows,
};

use crate::common::tyrewave;

const README: &str = include_str!("../../README.md");

/// A small tyre with a draft's sound.
fn small(axle: &str) -> String {
    let rolling = format!("speed_kmh = 60.0\nwarm_up = 0.1\nduration = 0.2\naxle = {axle}");
    let numerics = "history = \"modal\"\npole_tolerance = 1e-3";
    scene_text(
        64,
        "kind = \"smooth\"",
        &rolling,
        numerics,
        "[[receiver]]\nstandard = \"cpx\"\n[radiation]\nquality = \"draft\"\nfmax = 300.0",
    )
}

#[test]
fn a_scene_is_compared_at_the_wanted_speeds_and_roads() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("small.toml"), small("{ load = 3000.0, tolerance = 0.5 }")).unwrap();
    let arguments = ["validate", "small.toml", "--speeds", "80", "--roads", "dac-11,sma-8", "--out", "out", "--json"];
    let output = tyrewave(folder.path(), &[&arguments[..], &["-q"]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let printed: Value = serde_json::from_slice(&output.stdout).unwrap();
    let row = |title: &str| {
        let rows = printed["rows"].as_array().unwrap();
        rows.iter().find(|row| row["title"].as_str().unwrap().contains(title)).unwrap().clone()
    };
    assert_eq!(printed["runs"].as_array().unwrap().len(), 2);
    let level = row("L_AFmax, 80 km/h");
    // Levels of both roads are uncertain by some decibels, and so are those of the tyre that rolls there.
    let spread = level["road_spread"].as_array().unwrap();
    assert!(spread[0].as_f64().unwrap() < -1.0 && spread[1].as_f64().unwrap() > 1.0, "{level}");
    for known in ["stiffness at 350 kg", "patch standing at 400 kg", "L_AFmax, 80 km/h"] {
        assert!(row(known)["computed"].is_number(), "{}", row(known));
    }
    // Levels of 64 elements hold no band that is loud, and neither 50 km/h nor a chip seal was rolled.
    for unknown in ["L_AFmax, 50 km/h", "chip-seal less sma-8", "sma-8 less dac-11", "loudest"] {
        let row = row(unknown);
        assert!(unknown == "loudest" || row["computed"].is_null() && row["outside"].is_null(), "{row}");
    }
    for file in ["validate.txt", "validate.md", "validate.html", "validate.json", "textures.svg", "roads.svg"] {
        assert!(folder.path().join("out").join(file).is_file(), "{file}");
    }
    let page = fs::read_to_string(folder.path().join("out/validate.html")).unwrap();
    assert!(page.contains("<svg") && page.contains("NCHRP 630") && !page.contains("src=\"http"));
}

#[test]
fn unpublished_speeds_and_axles_without_load_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("held.toml"), small("{ indentation = 0.01, ramp = 0.1 }")).unwrap();
    let refused = |arguments: &[&str]| {
        let output = tyrewave(folder.path(), arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        String::from_utf8(output.stderr).unwrap()
    };
    assert!(refused(&["validate", "--speeds", "60"]).contains("no published values"));
    assert!(refused(&["validate", "--roads", "gravel"]).contains("chip-seal"));
    let held = refused(&["validate", "held.toml", "-q"]);
    assert!(held.contains("rolling.axle") && held.contains("held.toml"), "{held}");
}

/// Names and published values are those that the command writes; computed ones come from a run of it.
#[test]
fn the_readme_has_the_section_that_the_command_writes() {
    let start = README.find(MARKERS[0]).expect("the README has the section");
    let end = README.find(MARKERS[1]).unwrap() + MARKERS[1].len();
    let lacks = Lacks { sidewalls: true, cells: true };
    let nothing = Measured { tyre: StandingTyre::default(), runs: Vec::new(), cases: Vec::new(), load: 1.0, lacks };
    let form = markdown(&rows(&nothing, &Published::embedded()));
    let (found, form): (Vec<&str>, Vec<&str>) = (README[start..end].lines().collect(), form.lines().collect());
    assert_eq!(found.len(), form.len(), "run: tyrewave validate --markdown -q");
    for (found, form) in found.iter().zip(form) {
        let cells = |line: &str| line.split('|').map(|cell| cell.trim().to_owned()).collect::<Vec<_>>();
        assert_eq!(
            (cells(found).len(), cells(found).get(1).cloned()),
            (cells(form).len(), cells(form).get(1).cloned())
        );
        let published = form.starts_with("| published") || form.starts_with("| at most");
        assert!(!published || *found == form, "{found}\n{form}");
        assert!(!found.starts_with("| tyrewave") || !found.contains("not computed"), "{found}");
    }
}
