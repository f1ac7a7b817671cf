//! Names that users' scripts read: commands and options, keys of scenes, files of results, columns, JSON paths. A
//! change of one is a change of `kept.txt`, a line in the CHANGELOG and an answer that names the new one.
//!
//! `TYREWAVE_KEPT=1 cargo test names_that_scripts_read` writes `kept.txt` anew.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use serde_json::Value;
use tyrewave::internals::scene_text;
use tyrewave::scene::{DEFAULT, Scene};

use crate::common::{command, names, read_summary, tyrewave, write_grid};

/// The names.
const KEPT: &str = include_str!("kept.txt");
const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/suite/kept.txt");

const ROLLING: &str = "speed_kmh = 80.0\nwarm_up = 0.1\nduration = 1.0\n\
                       axle = { load = 3000.0, mass = 300.0, stiffness = 2e4, damping = 1.5e3, tolerance = 0.9 }";
const NUMERICS: &str = "history = \"modal\"\npole_tolerance = 1e-3";
const SLICES: &str = "[outputs]\nsections = 10.0\n[outputs.vibration]\nbelt = true\nmap = true\npoints = [0.1]\n\
                      [[receiver]]\nstandard = \"coast-by\"\npassage = 20.0\n\
                      [[receiver]]\nstandard = \"cpx\"\n\
                      [[receiver]]\nstandard = \"circle\"\nradius = 3.0\nheight = 0.3\n\
                      [radiation]\nquality = \"draft\"\nfmax = 300.0";
/// Those of cells, of a hemisphere and of probes.
const CELLS: &str = "[contact]\nzone = \"cells\"\ncells_across = 3\n[outputs]\ncells_every = 0.1\n\
                     [[receiver]]\nstandard = \"hemisphere\"\nradius = 3.0\n[[receiver]]\nstandard = \"obsi\"\n\
                     [radiation]\nfmax = 200.0\nnodes_per_wavelength = 4.0\nfrequency_tolerance = \"1 dB\"";
/// Those of a tread's pattern.
const PATTERN: &str = "[contact]\nzone = \"cells\"\ncells_across = 4\n[tread_pattern]\npitches = 16\n\
                       laterals = [{ from = -0.06, to = 0.0, width = 0.03046875, depth = 0.008, offset = 0.375 }]";
/// Those of air in the grooves of a tread.
const GROOVES: &str = "[contact]\nslices = \"winkler\"\ncells_across = 4\n\
                       [tread_pattern]\ngrooves = [{ position = 0.0, width = 0.06, depth = 0.008 }]\n\
                       [[receiver]]\nposition = [0.1, 1.0, 0.3]\n\
                       [radiation]\nfmax = 200.0\nnodes_per_wavelength = 4.0\nfrequency_tolerance = \"1 dB\"\n\
                       audio = false\n[air_pumping]\npatch = \"grooves\"";
/// Those of blocks that press air out.
const SQUEEZE: &str = "[contact]\nzone = \"cells\"\ncells_across = 4\n\
                       [tread_pattern]\ngrooves = [{ position = 0.0, width = 0.06, depth = 0.008 }]\n\
                       [[receiver]]\nposition = [0.1, 1.0, 0.3]\n\
                       [radiation]\nfmax = 200.0\nnodes_per_wavelength = 4.0\nfrequency_tolerance = \"1 dB\"\n\
                       audio = false\n[air_pumping]\npatch = \"grooves\"\nsqueeze = true";
/// Those of air in all voids.
const VOIDS: &str = "[contact]\nzone = \"cells\"\ncells_across = 4\n\
                     [[receiver]]\nposition = [0.1, 1.0, 0.3]\n\
                     [radiation]\nfmax = 200.0\nnodes_per_wavelength = 4.0\nfrequency_tolerance = \"1 dB\"\n\
                     audio = false\n[air_pumping]\npatch = \"voids\"";
/// Those of levels of a finer mesh.
const LEVELS: &str = "[contact]\nzone = \"cells\"\ncells_across = 3\n[outputs]\nlevels = { standard_error = 2.0 }\n\
                      [[receiver]]\nposition = [0.1, 1.0, 0.3]\n\
                      [radiation]\nfmax = 200.0\nnodes_per_wavelength = 4.0\nfrequency_tolerance = \"1 dB\"\n\
                      audio = false";
/// Those of friction and adhesion.
const FRICTION: &str = "[contact]\nzone = \"cells\"\ncells_across = 3\n[outputs]\ncells_every = 0.1\n\
                        [friction]\nmu = 0.5\n[adhesion]\nstress = 1e4\nrange = 1e-5";

/// A road of a file.
const MEASURED: &str = "kind = \"grid\"\nfile = \"road.npy\"\ndx = 0.1\ndy = 0.2\nat_end = \"repeat\"";

/// Paths of a JSON value; numbers of lists, and names that runs choose, are left out.
fn paths(value: &Value, path: &str, found: &mut BTreeSet<String>) {
    match value {
        Value::Object(fields) => fields.iter().for_each(|(key, value)| {
            let key = if key.parse::<f64>().is_ok() { "N" } else { key };
            paths(value, &format!("{path}.{key}"), found);
        }),
        Value::Array(values) if values.iter().any(Value::is_object) => {
            values.iter().for_each(|value| paths(value, &format!("{path}[]"), found));
        }
        _ => drop(found.insert(path.to_owned())),
    }
}

/// Keys of a schema with their paths.
fn keys(schema: &Value, path: &str, found: &mut BTreeSet<String>) {
    let join = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
    if let Some(properties) = schema["properties"].as_object() {
        for (key, value) in properties {
            found.insert(format!("key {}", join(key)));
            keys(value, &join(key), found);
        }
    }
    for list in ["oneOf", "anyOf", "allOf"] {
        schema[list].as_array().into_iter().flatten().for_each(|schema| keys(schema, path, found));
    }
    if schema["items"].is_object() {
        keys(&schema["items"], &format!("{path}[]"), found);
    }
}

/// Commands and their options.
fn commands(folder: &Path, found: &mut BTreeSet<String>) {
    let help = |arguments: &[&str]| String::from_utf8(tyrewave(folder, arguments).stdout).unwrap();
    let all = help(&["--help"]);
    let list = all.split("Commands:\n").nth(1).unwrap().split("\n\n").next().unwrap();
    for line in list.lines().filter(|line| line.starts_with("  ") && !line.starts_with("   ")) {
        let command = line.split_whitespace().next().unwrap();
        found.insert(format!("command {command}"));
        if command == "help" {
            continue;
        }
        for line in help(&[command, "--help"]).lines() {
            let words = line.trim_start();
            let options = words.split([' ', ',', '=', '[', '<']).take(3).filter(|word| word.starts_with("--"));
            let option = options.take(1).filter(|_| words.starts_with('-'));
            found.extend(option.map(|option| format!("option {command} {option}")));
        }
    }
}

/// Files, columns and JSON paths of a run.
fn results(folder: &Path, name: &str, found: &mut BTreeSet<String>) {
    // A separate cache: what was solved for before has no condition to report.
    let mut run = command(folder, &["run", &format!("{name}.toml"), "--out", name]);
    let output = run.env("TYREWAVE_CACHE_DIR", folder.join("cache")).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let results = folder.join(name);
    for file in names(&results) {
        found.insert(format!("file {file}"));
        if file.ends_with(".csv") {
            let table = fs::read_to_string(results.join(&file)).unwrap();
            found.insert(format!("columns {file}: {}", table.lines().next().unwrap()));
        }
    }
    let mut summary = read_summary(&results);
    summary.as_object_mut().unwrap().remove("settings");
    paths(&summary, "json summary", found);
}

#[test]
fn names_that_scripts_read_are_kept() {
    let folder = tempfile::tempdir().unwrap();
    let mut found = BTreeSet::new();
    commands(folder.path(), &mut found);
    keys(&Scene::json_schema(), "", &mut found);
    let load = "speed_kmh = 80.0\nwarm_up = 0.1\nduration = 1.2\naxle = { load = 3000.0, tolerance = 0.9 }";
    let heights: Vec<f64> = (0..400).map(|row| 1e-3 * f64::from(row).sin()).collect();
    write_grid(&folder.path().join("road.npy"), 1, &heights);
    for (name, rolling, numerics, more) in [
        ("slices", ROLLING, NUMERICS, SLICES),
        ("cells", load, NUMERICS, CELLS),
        ("friction", load, "", FRICTION),
        ("pattern", load, NUMERICS, PATTERN),
        ("grooves", load, NUMERICS, GROOVES),
        ("squeeze", load, NUMERICS, SQUEEZE),
        ("voids", load, NUMERICS, VOIDS),
        ("levels", load, NUMERICS, LEVELS),
    ] {
        // One of them reads a file.
        let road = if name == "friction" { MEASURED } else { "kind = \"made\"" };
        let text = scene_text(64, road, rolling, numerics, more);
        fs::write(folder.path().join(format!("{name}.toml")), text).unwrap();
        results(folder.path(), name, &mut found);
    }
    let tables = DEFAULT.lines().filter(|line| line.starts_with('['));
    found.extend(tables.map(|line| format!("default {}", line.split('#').next().unwrap().trim())));
    let text = found.iter().map(|name| format!("{name}\n")).collect::<String>();
    if std::env::var_os("TYREWAVE_KEPT").is_some() {
        fs::write(FILE, &text).unwrap();
        return;
    }
    let known: BTreeSet<String> = KEPT.lines().map(str::to_owned).collect();
    let (gone, new): (Vec<_>, Vec<_>) = (known.difference(&found).collect(), found.difference(&known).collect());
    assert!(gone.is_empty() && new.is_empty(), "gone: {gone:#?}\nnew, to be added to kept.txt: {new:#?}");
}
