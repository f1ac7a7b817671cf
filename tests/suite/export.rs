//! Results in the formats of other programs: read back by scipy, pyuff and Python's own parser where they are, by the
//! rules of their formats everywhere.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;

use serde_json::Value;
use tempfile::TempDir;
use tyrewave::internals::{MAT_HEAD, PYTHON, UFF_HEAD, VTK_HEAD, edit, read_force_levels, scene_text};

use crate::common::{names, read_array, read_summary, skipped, tyrewave};

/// A run of slices that vibrates and has a receiver, and one of cells. Made once for all tests.
static RESULTS: LazyLock<TempDir> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    let rolling = "speed_kmh = 80.0\nwarm_up = 0.1\nduration = 0.7\naxle = { load = 3000.0, tolerance = 0.5 }";
    let receiver = "[outputs.vibration]\nmap = true\n[[receiver]]\nstandard = \"cpx\"\n\
                    [radiation]\nquality = \"draft\"\n\
                    fmax = 500.0\n[outputs]\nplots = false";
    let cells = "[contact]\nzone = \"cells\"\ncells_across = 3\n[outputs]\nplots = false\ncells_every = 0.005";
    let short = "speed_kmh = 80.0\nwarm_up = 0.05\nduration = 0.05\naxle = { indentation = 0.01, ramp = 0.03 }";
    for (name, rolling, terms, more) in [("slices", rolling, "4", receiver), ("cells", short, "9", cells)] {
        let text = scene_text(64, "kind = \"made\"\nseed = 4", rolling, "pole_tolerance = 1e-3", more);
        let text = edit(&text, &[("numerics.lateral_terms", terms)]);
        fs::write(folder.path().join(format!("{name}.toml")), text).unwrap();
        let output = tyrewave(folder.path(), &["run", &format!("{name}.toml"), "--out", name, "-q"]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
    folder
});

/// Exports results to a separate place.
fn exported(results: &str, format: &str, place: &Path, more: &[&str]) -> PathBuf {
    let out = place.join(format!("{results}.{format}"));
    let results = RESULTS.path().join(results);
    let paths = [results.to_str().unwrap(), "--format", format, "--out", out.to_str().unwrap()];
    let output = tyrewave(place, &[&["export"][..], &paths, more].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(String::from_utf8(output.stdout).unwrap(), format!("exported to {}\n", out.display()));
    out
}

/// Returns the output of a program in Python, in the folder of the results; `None` with a printed line where it cannot
/// be run for want of a package.
fn python(packages: &[&str], program: &str, arguments: &[&Path]) -> Option<String> {
    let imports: String = packages.iter().map(|package| format!("import {package}\n")).collect();
    let run = |program: &str| {
        let mut command = Command::new("python3");
        command.args(["-c", program]).args(arguments).current_dir(RESULTS.path()).output()
    };
    if !run(&imports).is_ok_and(|output| output.status.success()) {
        skipped(&format!("no python3 with {packages:?}"));
        return None;
    }
    let output = run(&(imports + program)).unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    Some(String::from_utf8(output.stdout).unwrap())
}

#[test]
fn scipy_reads_every_array_and_table_from_the_matlab_file() {
    let place = tempfile::tempdir().unwrap();
    let mut files = Vec::new();
    for name in ["slices", "cells"] {
        let file = exported(name, "mat", place.path(), &[]);
        assert!(fs::read(&file).unwrap().starts_with(MAT_HEAD.as_bytes()));
        files.push(file);
    }
    let program = r#"
import json, numpy as np, pathlib, sys, csv
from scipy.io import loadmat
for name, file in zip(["slices", "cells"], sys.argv[1:]):
    folder = pathlib.Path(name)
    found = loadmat(file, squeeze_me=True, struct_as_record=False)
    arrays = sorted(folder.glob("*.npy"))
    assert len(arrays) >= 4, arrays
    for path in arrays:
        variable = path.stem.replace("-", "_")
        assert np.array_equal(np.squeeze(np.load(path)).astype(float), found[variable]), path
        assert getattr(found["units"], variable) != "", path
    for path in folder.glob("*.csv"):
        rows = list(csv.DictReader(path.open()))
        for column in rows[0]:
            values = np.atleast_1d(getattr(found[path.stem], column))
            assert len(values) == len(rows), (path, column)
            for row, value in zip(rows, values):
                if isinstance(value, str) or np.size(value) == 0:
                    assert row[column] == (value if isinstance(value, str) else ""), (path, column, value)
                else:
                    assert np.isnan(value) if row[column] == "" else float(row[column]) == value, (path, column, value)
    summary = json.loads((folder / "summary.json").read_text())
    assert found["run"].name == name and found["run"].mean_force == summary["outcome"]["mean_force"]
    for path in folder.glob("*.wav"):
        audio = [r["audio"] for r in summary["sound"]["receivers"] if r.get("audio", {}).get("file") == path.name][0]
        sound = found[path.stem.replace("-", "_")]
        assert np.isclose(np.abs(sound).max(), audio["peak"], rtol=1e-4), path
        assert np.isclose(len(sound), 48000 * audio["seconds"]) and found["run"].sample_rate == 48000
    assert found["units"].total_force == "N" and found["units"].time_step == "s"
print(found["cells"].shape[0], found["cells_time"].size, loadmat(sys.argv[2])["total_force"].shape[1])
"#;
    let Some(found) = python(&["scipy", "numpy"], program, &[&files[0], &files[1]]) else { return };
    let (_, times) = read_array::<f64>(&RESULTS.path().join("cells/cells_time.npy"));
    assert_eq!(found, format!("{0} {0} 1\n", times.len()));
}

#[test]
fn universal_files_have_fixed_fields_that_pyuff_reads() {
    let place = tempfile::tempdir().unwrap();
    let file = exported("slices", "uff58", place.path(), &[]);
    let text = fs::read_to_string(&file).unwrap();
    assert!(text.starts_with(UFF_HEAD) && text.is_ascii());
    assert_eq!(text, fs::read_to_string(exported("slices", "uff58", place.path(), &[])).unwrap());
    let sets: Vec<Vec<&str>> =
        text.split("    -1\n").filter(|set| !set.is_empty()).map(|set| set.lines().collect()).collect();
    let kinds: Vec<&str> = sets.iter().map(|set| set[0].trim()).collect();
    assert!(kinds.len() > 5 && kinds[..2] == ["151", "164"] && kinds[2..].iter().all(|kind| *kind == "58"));
    let force = &sets[2];
    assert!(force[1].starts_with("Total contact force ") && force[2].starts_with("slices ") && force[1].len() == 80);
    assert_eq!(force[6], "    1         1    0         0 TYRE               1   3 NONE               0   0");
    let (_, values) = read_array::<f64>(&RESULTS.path().join("slices/total_force.npy"));
    assert_eq!(force[7][..43], format!("{:10}{:10}{:10} 0.000000E+00", 4, values.len(), 1)[..]);
    assert_eq!(force[8], format!("        17    0    0    0 {:20} {:20}", "Time", "s"));
    assert_eq!(force[9], format!("         9    0    0    0 {:20} {:20}", "Force", "N"));
    assert_eq!(force.len(), 12 + values.len().div_ceil(4));
    assert_eq!(force[12].len(), 80);
    for (number, value) in force[12].as_bytes().chunks(20).zip(&values) {
        let number: f64 = std::str::from_utf8(number).unwrap().trim().parse().unwrap();
        assert!((number - value).abs() <= 1e-11 * value.abs());
    }
    // The pressure over time at the receiver, in Pa.
    let is_pressure = |set: &&Vec<&str>| set[1].starts_with("Sound pressure: cpx") && set[6].starts_with("    1");
    let channels: Vec<&Vec<&str>> = sets.iter().filter(is_pressure).collect();
    let audio = read_summary(&RESULTS.path().join("slices"))["sound"]["receivers"][0]["audio"].clone();
    let samples: Vec<f64> = channels
        .iter()
        .flat_map(|channel| &channel[12..])
        .flat_map(|line| line.as_bytes().chunks(20))
        .map(|number| std::str::from_utf8(number).unwrap().trim().parse().unwrap())
        .collect();
    let length = samples.len() as f64 / channels.len() as f64 / 48_000.0;
    assert!((length - audio["seconds"].as_f64().unwrap()).abs() < 1e-9, "{length} s in {} channels", channels.len());
    let (found, peak) = (samples.iter().fold(0.0, |most: f64, of| most.max(of.abs())), audio["peak"].as_f64().unwrap());
    assert!(peak > 0.0 && (found / peak - 1.0).abs() < 1e-4, "{found} and {peak} Pa");
    let program = r#"
import csv, numpy as np, pyuff, sys
sets = pyuff.UFF(sys.argv[1]).read_sets()
assert [s["type"] for s in sets[:2]] == [151, 164] and sets[1]["units_code"] == 1
force, time = np.load("slices/total_force.npy"), np.load("slices/time.npy")
assert sets[2]["func_type"] == 1 and np.allclose(sets[2]["data"], force, rtol=1e-10)
assert np.allclose(sets[2]["x"], time, rtol=1e-6) and sets[2]["ordinate_axis_units_lab"] == "N"
def rows(file): return list(csv.DictReader(open("slices/" + file)))
bands = [r for r in rows("spectra.csv") if r["valid"] == "1"]
assert sets[3]["func_type"] == 2 and len(bands) == len(sets[3]["x"]) > 5
assert np.allclose(sets[3]["data"], [float(r["mean_square_n2"]) for r in bands], rtol=1e-10)
assert np.allclose(sets[3]["x"], [float(r["mid_frequency_hz"]) for r in bands], rtol=1e-5)
sound = [s for s in sets[2:] if s["id1"].startswith("Sound pressure")]
thirds, narrow, over_time = [[s for s in sound if s["func_type"] == kind] for kind in (2, 9, 1)]
assert len(over_time) == 1 and over_time[0]["ordinate_axis_units_lab"] == "Pa"
assert np.isclose(over_time[0]["x"][1], 1 / 48000)
assert len(thirds) == len(narrow) == 1, [s["id1"] for s in sound]
levels = [float(r["level_db_re_20upa"]) for r in rows("sound.csv") if r["valid"] == "1"]
assert np.allclose(10 * np.log10(thirds[0]["data"] / 4e-10), levels, atol=1e-6)
assert len(narrow[0]["x"]) == len(rows("sound_narrow.csv"))
assert any(s["id1"].startswith("Velocity, narrow band: tread") for s in sets[2:])
print(len(sets))
"#;
    let Some(found) = python(&["pyuff", "numpy"], program, &[&file]) else { return };
    assert_eq!(found, format!("{}\n", sets.len()));
}

/// The numbers of an array in a file of VTK's.
fn numbers(text: &str, name: &str) -> Vec<f64> {
    let after = text.split(&format!("Name=\"{name}\"")).nth(1).unwrap_or_else(|| panic!("no {name}"));
    let data = after.split_once('>').unwrap().1.split_once('<').unwrap().0;
    data.split_whitespace().map(|number| number.parse().unwrap()).collect()
}

/// Fails unless every element is closed where it must be.
fn assert_well_formed(text: &str) {
    let mut open = Vec::new();
    for tag in text.strip_prefix(VTK_HEAD).unwrap().split('<').skip(1).map(|rest| rest.split_once('>').unwrap().0) {
        match tag.strip_prefix('/') {
            Some(name) => assert_eq!(open.pop(), Some(name)),
            None if tag.ends_with('/') => {}
            None => open.push(tag.split_whitespace().next().unwrap()),
        }
    }
    assert!(open.is_empty(), "{open:?}");
}

#[test]
fn a_patch_over_time_has_its_forces_where_they_act() {
    let place = tempfile::tempdir().unwrap();
    for (results, across, more) in [("slices", 1, &["--every", "0.05"][..]), ("cells", 3, &[])] {
        let folder = exported(results, "vtk", place.path(), more);
        let run = RESULTS.path().join(results);
        let summary = read_summary(&run);
        let step = summary["outcome"]["time_step"].as_f64().unwrap();
        let (_, total) = read_array::<f64>(&run.join("total_force.npy"));
        let (shape, _) = read_array::<f64>(&run.join("patch_force.npy"));
        let (_, first) = read_array::<i64>(&run.join("patch_element.npy"));
        let (element, width) = (1.95 / 64.0, summary["settings"]["tyre"]["contact_width"].as_f64().unwrap());
        let cells = shape[1] * across;
        let collection = fs::read_to_string(folder.join("patch.pvd")).unwrap();
        assert_well_formed(&collection);
        let frames: Vec<(f64, &str)> = collection
            .split("timestep=\"")
            .skip(1)
            .map(|rest| (rest.split('"').next().unwrap().parse().unwrap(), rest.split('"').nth(4).unwrap()))
            .collect();
        // Parts of 0.7 s, or all that were written after the warm-up.
        let written = || read_array::<f64>(&run.join("cells_time.npy")).1;
        let expected =
            if across == 1 { 14 } else { written().iter().filter(|time| **time > 0.05 - 0.5 * step).count() };
        assert!(frames.len() == expected && expected > 8, "{expected}: {collection}");
        assert_eq!(names(&folder).len(), frames.len() + 1);
        for (time, file) in frames {
            let text = fs::read_to_string(folder.join(file)).unwrap();
            assert_well_formed(&text);
            let points = (shape[1] + 1) * (across + 1);
            assert!(text.contains(&format!("NumberOfPoints=\"{points}\" NumberOfPolys=\"{cells}\"")), "{text}");
            let row = (time / step).round() as usize;
            let [force, pressure, elements] = ["force_N", "pressure_Pa", "element"].map(|name| numbers(&text, name));
            assert_eq!((force.len(), pressure.len(), elements.len()), (cells, cells, cells));
            assert!((force.iter().sum::<f64>() - total[row]).abs() < 1e-4 * total[row]);
            let face = element * width / across as f64;
            assert!(force.iter().zip(&pressure).all(|(force, pressure)| (force - pressure * face).abs() < 1e-9));
            assert!((elements[0] - first[row] as f64).abs() < 1e-9);
            let corners = numbers(&text, "connectivity");
            assert!(corners.len() == 4 * cells && corners.iter().all(|corner| *corner < points as f64));
            assert_eq!(numbers(&text, "offsets").last().map(|end| *end as usize), Some(4 * cells));
            assert!((numbers(&text, "TimeValue")[0] - time).abs() < 1e-12);
            let points = numbers(&text, "Points");
            // The centre of force is under the axle, within a few elements, and elements are where they meet the road.
            let middle = |cell: usize| {
                let corner = |end: usize| points[3 * corners[4 * cell + end] as usize];
                0.25 * (0..4).map(corner).sum::<f64>()
            };
            let x = elements[0] * element - 80.0 / 3.6 * (time - 0.5 * step);
            assert!((middle(0) - x).abs() < 1e-9, "{} {x}", middle(0));
            let centre = (0..cells).map(|cell| middle(cell) * force[cell]).sum::<f64>() / total[row];
            assert!(centre.abs() < element, "{centre}");
            let edges = points.chunks(3).map(|point| point[1]);
            assert!((edges.fold(0.0, f64::max) - 0.5 * width).abs() < 1e-12);
        }
        let program = "root = xml.etree.ElementTree.parse(sys.argv[1]).getroot()\nprint(root.get('type'), len(root))";
        let found = python(&["sys", "xml.etree.ElementTree"], program, &[&folder.join("patch_0003.vtp")]);
        assert!(found.is_none_or(|found| found == "PolyData 1\n"));
    }
}

#[test]
fn positions_are_those_of_the_run_wherever_it_starts() {
    let place = tempfile::tempdir().unwrap();
    let element = 1.95 / 64.0;
    let rows: String =
        (0..5000).map(|row| format!("{},{}\n", 1e-3 * f64::from(row), 1e-5 * f64::from(row % 7))).collect();
    fs::write(place.path().join("road.csv"), format!("x,z\n{rows}")).unwrap();
    let road = "kind = \"profile\"\nfile = \"road.csv\"\ndistance_unit = \"m\"\nheight_unit = \"m\"";
    for (name, start, rule) in [("left", "", "sdirk2"), ("given", "start = 0.7321\n", "sdirk2"), ("bdf", "", "bdf2")] {
        let rolling = "speed_kmh = 80.0\nwarm_up = 0.05\nduration = 0.05\naxle = { indentation = 0.01, ramp = 0.03 }";
        let numerics = format!("pole_tolerance = 1e-3\ntime_rule = \"{rule}\"");
        let text = scene_text(64, road, &format!("{start}{rolling}"), &numerics, "[outputs]\nplots = false");
        fs::write(place.path().join("scene.toml"), text).unwrap();
        for command in
            [&["run", "scene.toml", "--out", name, "-q"][..], &["export", name, "-f", "vtk", "--out", "patch"]]
        {
            let output = tyrewave(place.path(), command);
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        }
        let text = fs::read_to_string(place.path().join("patch/patch_0007.vtp")).unwrap();
        let [x, time] = ["Points", "TimeValue"].map(|name| numbers(&text, name)[0]);
        let force = numbers(&text, "force_N");
        let moment: f64 = force.iter().zip(0..).map(|(force, column)| force * f64::from(column)).sum();
        let centre = x + element * (moment / force.iter().sum::<f64>() + 0.5);
        assert!(centre.abs() < 0.25 * element, "{name}: {centre} m");
        // The force of `sdirk2` acts in the middle of its step, which is an element long.
        let (start, lag) = (if start.is_empty() { 0.0 } else { 0.7321 }, if rule == "sdirk2" { 0.5 } else { 0.0 });
        let elements = (x + 80.0 / 3.6 * time + start) / element + 0.5 - lag;
        assert!((elements - elements.round()).abs() < 1e-6, "{name}: {elements}");
    }
}

#[test]
fn earlier_exports_are_replaced_and_nothing_else() {
    let place = tempfile::tempdir().unwrap();
    let cells = RESULTS.path().join("cells");
    let export = |format: &str, more: &[&str]| {
        let output = tyrewave(place.path(), &[&["export", cells.to_str().unwrap(), "--format", format], more].concat());
        (output.status.code().unwrap(), String::from_utf8(output.stderr).unwrap())
    };
    // Of a longer export no instant is left.
    assert_eq!(export("vtk", &["--out", "patch"]).0, 0);
    assert_eq!(export("vtk", &["--out", "patch", "--every", "0.02"]).0, 0);
    assert_eq!(names(&place.path().join("patch")), ["patch.pvd", "patch_0000.vtp", "patch_0001.vtp", "patch_0002.vtp"]);
    fs::write(place.path().join("patch/notes.txt"), "precious").unwrap();
    let (code, message) = export("vtk", &["--out", "patch"]);
    assert!(code == 2 && message.contains("notes.txt"), "{message}");
    assert_eq!(names(&place.path().join("patch")).len(), 5);
    for (format, name) in [("mat", "a.mat"), ("uff58", "a.uff")] {
        for _ in 0..2 {
            assert_eq!(export(format, &["--out", name]).0, 0);
        }
        fs::write(place.path().join(name), "    -1\n    58\nof a measurement").unwrap();
        let (code, message) = export(format, &["--out", name]);
        assert!(code == 2 && message.contains("left alone"), "{message}");
        assert!(fs::read_to_string(place.path().join(name)).unwrap().ends_with("measurement"));
        let (code, message) = export(format, &["--every", "0.1"]);
        assert!(code == 2 && message.contains("--every"), "{message}");
        assert_eq!(export(format, &["--out", "none/a"]).0, 3);
    }
    let output = tyrewave(place.path(), &["export", "nowhere", "--format", "mat"]);
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(names(place.path()), ["a.mat", "a.uff", "patch"]);
}

#[test]
fn ten_lines_of_python_find_what_the_summary_says() {
    assert_eq!(PYTHON.lines().count(), 10);
    let slices = RESULTS.path().join("slices");
    let help = String::from_utf8(tyrewave(RESULTS.path(), &["export", "--help"]).stdout).unwrap();
    let words = |text: &str| text.split_whitespace().collect::<String>();
    assert!(words(&help).contains(&words(PYTHON)), "{help}");
    let Some(found) = python(&["numpy"], PYTHON, &[&slices]) else { return };
    let number = |begin: &str| -> f64 {
        let after = found.lines().find_map(|line| line.strip_prefix(begin)).unwrap();
        after.split_whitespace().next().unwrap().parse().unwrap()
    };
    let summary: Value = read_summary(&slices);
    let mean = summary["outcome"]["mean_force"].as_f64().unwrap();
    assert!((number("mean force ") - mean).abs() < 1e-9 * mean, "{found}");
    let bands = read_force_levels(&fs::read_to_string(slices.join("spectra.csv")).unwrap()).unwrap();
    let squares: f64 = bands.iter().filter(|band| band.valid).map(|band| band.mean_square).sum();
    assert!((number("level ") - 10.0 * squares.log10()).abs() < 1e-9, "{found}");
}
