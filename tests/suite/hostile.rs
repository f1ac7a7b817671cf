//! Hostile input through the program: whatever a file holds, wherever it lies and whatever it is, the program ends
//! soon, with a message and a documented exit code, and writes nothing.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use tyrewave::internals::{edit, implausible, scene_text, without};

use crate::common::{command, folder_with, names, skipped};

const ROLLING: &str = "speed_kmh = 80.0\nwarm_up = 0.02\nduration = 0.05\naxle = { indentation = 0.01, ramp = 0.02 }";
const USAGE: i32 = 2;
/// Longer than any refusal takes, in a build without optimisation beside other tests.
const SOON: Duration = Duration::from_secs(20);
/// Bytes of a message that is too long to be read to its end.
const LONG: usize = 30_000;

fn with_road(road: &str) -> String {
    scene_text(64, road, ROLLING, "memory = 0.1", "")
}

/// Returns the output of the program; ended, and reported, where it does not end soon.
fn outcome(folder: &Path, arguments: &[&str]) -> Output {
    let mut child = command(folder, arguments).stdin(Stdio::null()).spawn().unwrap();
    let begin = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if begin.elapsed() > SOON {
            child.kill().unwrap();
            panic!("{arguments:?} does not end");
        }
        sleep(Duration::from_millis(5));
    }
    child.wait_with_output().unwrap()
}

/// The command must be refused for what it was given, say all the words, and leave the folder as it was.
fn refused(folder: &Path, arguments: &[&str], words: &[&str]) -> String {
    let before = names(folder);
    let output = outcome(folder, arguments);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(USAGE), "{arguments:?}: {message}");
    for word in words {
        assert!(message.contains(word), "\"{word}\" is not in:\n{message}");
    }
    assert!(!message.contains("panicked") && message.len() < LONG, "{message}");
    assert_eq!(names(folder), before, "something was written; {message}");
    assert!(output.stdout.is_empty());
    message
}

#[test]
fn a_profile_of_far_too_small_a_unit_is_refused() {
    let rows = (0..4000).fold("x,z\n".to_owned(), |mut text, row| {
        writeln!(text, "{},{}", 5e-4 * f64::from(row), 0.1 * f64::from(row % 7)).unwrap();
        text
    });
    for (unit, factor) in [("um", 1.0), ("m", 1e6)] {
        let road = format!("kind = \"profile\"\nfile = \"p.csv\"\ndistance_unit = \"{unit}\"\nheight_unit = \"mm\"\n");
        for more in ["at_end = \"repeat\"", "at_end = \"repeat\"\nlateral = \"isotropic\""] {
            let folder = folder_with(&with_road(&(road.clone() + more)));
            let scaled: String = rows
                .lines()
                .map(|line| match line.split_once(',') {
                    Some((x, z)) if x != "x" => format!("{},{z}\n", x.parse::<f64>().unwrap() * factor),
                    _ => format!("{line}\n"),
                })
                .collect();
            fs::write(folder.path().join("p.csv"), scaled).unwrap();
            for command in ["run", "road", "plan"] {
                refused(folder.path(), &[command, "scene.toml"], &["road.file", "p.csv", "m apart", "unit"]);
            }
        }
    }
}

#[test]
fn a_scene_without_sense_is_asked_about() {
    let load = ROLLING.replace("{ indentation = 0.01, ramp = 0.02 }", "{ load = 3.4 }");
    let scene = scene_text(64, "kind = \"smooth\"", &load, "memory = 0.1", "");
    let words = ["rolling.axle.load", "3.4 N is implausible", "another unit?", "allow_implausible"];
    refused(folder_with(&scene).path(), &["run", "scene.toml"], &words);
    let smooth = with_road("kind = \"smooth\"");
    for circumference in ["1.8e19", "3e14"] {
        for allow in ["", "allow_implausible = true\n"] {
            let scene = format!("{allow}{}", edit(&smooth, &[("tyre.circumference", circumference)]));
            refused(folder_with(&scene).path(), &["run", "scene.toml"], &["tyre.circumference", "plausible"]);
        }
    }
}

#[test]
fn sums_that_would_not_end_are_refused_before_they_begin() {
    let smooth = with_road("kind = \"smooth\"");
    let soft = edit(&smooth, &[("tyre.layers.1.material.modulus", "1e6")]);
    let tense = soft.replacen("thickness = 0.013", "thickness = 0.013\ntension = [4e4, 2e4]", 1);
    assert_ne!(soft, tense);
    refused(folder_with(&tense).path(), &["plan", "scene.toml"], &["tyre.layers[1].tension", "do not converge"]);
    let allowed = |changes: &[(&str, &str)]| implausible(&edit(&smooth, changes));
    let thin = allowed(&[("tyre.layers.1.thickness", "1e-6")]);
    refused(folder_with(&thin).path(), &["plan", "scene.toml"], &["tyre.layers[1].thickness", "evaluations"]);
    let many = [("numerics.lateral_terms", "100000"), ("numerics.wavenumber_aliases", "100000")];
    refused(folder_with(&allowed(&many)).path(), &["run", "scene.toml"], &["numerics.lateral_terms", "fewer"]);
}

#[test]
fn thirty_two_of_thousands_of_unknown_keys_are_reported() {
    let many = (0..16_000).fold(with_road("kind = \"smooth\""), |mut text, number| {
        writeln!(text, "key{number} = {number}").unwrap();
        text
    });
    let message = refused(folder_with(&many).path(), &["run", "scene.toml"], &["and 15968 more"]);
    assert_eq!(message.matches("is not a key").count(), 32);
    let broken = (0..16_000).fold(String::new(), |mut text, number| {
        writeln!(text, "key{number} = = {number}").unwrap();
        text
    });
    refused(folder_with(&broken).path(), &["run", "scene.toml"], &["scene.toml:1:", "more"]);
}

#[test]
fn a_scene_as_large_or_as_deep_as_a_bomb_is_refused() {
    let array = format!("title = [{}]\n", "0,".repeat(10_000_000));
    refused(folder_with(&array).path(), &["run", "scene.toml"], &["scene.toml", "bytes"]);
    for deep in ["[".repeat(200_000), "{a=".repeat(100_000), "a.".repeat(200_000)] {
        for text in [format!("title = {deep}\n"), format!("{deep}\n"), format!("{deep}b = 1\n"), format!("[{deep}b]\n")]
        {
            refused(folder_with(&text).path(), &["run", "scene.toml"], &["scene.toml"]);
        }
    }
}

#[test]
#[cfg(unix)]
fn pipes_devices_and_folders_are_no_input() {
    let smooth = with_road("kind = \"smooth\"");
    let folder = folder_with(&smooth);
    let here = folder.path();
    if !Command::new("mkfifo").arg(here.join("pipe")).status().is_ok_and(|status| status.success()) {
        skipped("no named pipes here");
        return;
    }
    fs::create_dir(here.join("folder")).unwrap();
    std::os::unix::fs::symlink("/dev/zero", here.join("zero")).unwrap();
    let map =
        ["indent", "--dx", "1e-3", "--dy", "1e-3", "--modulus", "1e7", "--poisson", "0.4", "--load", "7", "--heights"];
    for name in ["pipe", "zero", "folder"] {
        for before in [&["run"][..], &["compliance"], &["radiation-cases"], &map, &["fit-tyre"], &["road"]] {
            let after: &[&str] = if before == ["fit-tyre"] { &["scene.toml"] } else { &[] };
            refused(here, &[before, &[name], after].concat(), &[name]);
        }
        let tyre = format!("tyre = \"{name}\"\n{}", without(&smooth, &["tyre"]));
        fs::write(here.join("tyre.toml"), tyre).unwrap();
        refused(here, &["--allow-outside", "run", "tyre.toml"], &["tyre", name]);
        for more in ["kind = \"profile\"", "kind = \"opencrg\"", "kind = \"grid\""] {
            fs::write(here.join("road.toml"), with_road(&format!("{more}\nfile = \"{name}\""))).unwrap();
            refused(here, &["--allow-outside", "road", "road.toml"], &["road.file", name]);
        }
    }
}

#[test]
fn a_bad_tyre_file_is_not_shown_in_full() {
    let smooth = with_road("kind = \"smooth\"");
    let scene = format!("tyre = \"t.toml\"\n{}", without(&smooth, &["tyre"]));
    let folder = folder_with(&scene);
    for text in [
        "x".repeat(900_000),
        format!("name = \"{}\"", "y".repeat(900_000)),
        "a = '''\n".to_owned() + &"b\n".repeat(90_000),
    ] {
        fs::write(folder.path().join("t.toml"), text).unwrap();
        refused(folder.path(), &["run", "scene.toml"], &["t.toml"]);
    }
}

#[test]
fn a_scene_opens_files_of_its_folder_only_unless_allowed() {
    let smooth = with_road("kind = \"smooth\"");
    let tyre = "circumference = 1.95\n";
    let above = tempfile::tempdir().unwrap();
    let folder = above.path().join("scenes");
    fs::create_dir(&folder).unwrap();
    fs::write(above.path().join("t.toml"), tyre).unwrap();
    fs::write(above.path().join("p.csv"), "x,z\n0,0\n").unwrap();
    let scene = |tyre: &str| format!("tyre = '{tyre}'\n{}", without(&smooth, &["tyre"]));
    let absolute = above.path().join("t.toml");
    for path in ["../t.toml", absolute.to_str().unwrap()] {
        fs::write(folder.join("scene.toml"), scene(path)).unwrap();
        refused(&folder, &["run", "scene.toml"], &["scene.toml:1:", "outside the scene's folder", "--allow-outside"]);
        refused(&folder, &["run", "scene.toml", "--allow-outside"], &["tyre.width", "missing"]);
    }
    let road = "kind = \"profile\"\nfile = \"../p.csv\"\ndistance_unit = \"mm\"\nheight_unit = \"mm\"";
    fs::write(folder.join("scene.toml"), with_road(road)).unwrap();
    refused(&folder, &["road", "scene.toml"], &["road.file", "outside the scene's folder", "--allow-outside"]);
    refused(&folder, &["road", "scene.toml", "--allow-outside"], &["usable points"]);
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("../t.toml", folder.join("link.toml")).unwrap();
        fs::write(folder.join("scene.toml"), scene("link.toml")).unwrap();
        refused(&folder, &["run", "scene.toml"], &["outside the scene's folder"]);
    }
}

#[test]
fn answers_that_are_no_numbers_are_errors() {
    let folder = tempfile::tempdir().unwrap();
    let cases = r#"{"tyres": [{"name": "t", "layers": [{"thickness": 0.01, "material":
        {"law": "elastic", "modulus": 1e308, "poisson": 0.3, "density": 1e308}}],
        "foundation": {"normal": 1e308, "tangential": 1e308}}],
        "cases": [{"tyre": "t", "kx": 1e200, "ky": 1e200, "s": [0, 1e200]}]}"#;
    fs::write(folder.path().join("cases.json"), cases).unwrap();
    refused(folder.path(), &["compliance", "cases.json"], &["case 0", "not finite"]);
    let mut heights = vec![0.0; 64];
    heights[27] = 1e30;
    crate::common::write_grid(&folder.path().join("z.npy"), 8, &heights);
    let indent =
        ["indent", "--heights", "z.npy", "--dx", "1e-3", "--dy", "1e-3", "--modulus", "1e7", "--poisson", "0.4"];
    for pressed in [["--penetration", "1e-3"], ["--load", "100"]] {
        refused(folder.path(), &[&indent[..], &pressed].concat(), &["1e30 m", "rounding"]);
    }
}

#[test]
fn a_flat_table_is_no_road() {
    let road_text =
        "kind = \"profile\"\nfile = \"p.csv\"\ndistance_unit = \"mm\"\nheight_unit = \"mm\"\nat_end = \"repeat\"";
    let folder = folder_with(&with_road(road_text));
    let flat = (0..2000).fold("x,z\n".to_owned(), |text, row| text + &format!("{row},0\n"));
    fs::write(folder.path().join("p.csv"), flat).unwrap();
    refused(folder.path(), &["road", "scene.toml"], &["p.csv", "it is flat", "road.height_unit"]);
    fs::write(
        folder.path().join("scene.toml"),
        with_road(&road_text.replace("at_end = \"repeat\"", "lateral = \"isotropic\"")),
    )
    .unwrap();
    refused(folder.path(), &["road", "scene.toml"], &["p.csv", "it is flat"]);
}

/// A level OpenCRG road in text form with modifiers.
fn crg(modifiers: &str) -> String {
    let mut text = format!(
        "$CT\nsmall\n$\n$ROAD_CRG\nreference_line_start_u = 0.0\nreference_line_end_u = 20.0\n\
         reference_line_increment = 0.01\nlong_section_v_right = -0.1\nlong_section_v_left = 0.1\n\
         long_section_v_increment = 0.1\n$\n$ROAD_CRG_MODS\n{modifiers}\n$\n$KD_DEFINITION\n#:LRFI\n\
         D:long section 1,m\nD:long section 2,m\nD:long section 3,m\n$\n$$$$\n"
    );
    for row in 0..2001 {
        let height = 1e-3 * f64::from(row % 10);
        writeln!(text, "{height:10.7}{height:10.7}{height:10.7}").unwrap();
    }
    text
}

#[test]
fn opencrg_roads_are_checked_once_they_are_scaled() {
    let folder = folder_with(&with_road("kind = \"opencrg\"\nfile = \"a.crg\""));
    for (modifiers, word) in [
        ("scale_length = 1e-300", "m apart"),
        ("scale_length = 1e300", "m apart"),
        ("scale_length = -1", "m apart"),
        ("scale_width = 1e-300", "m apart"),
        ("scale_z_grid = 1e300", "no road has this"),
        ("scale_z_grid = 1e308\nscale_slope = 1e308", "no road has this"),
    ] {
        fs::write(folder.path().join("a.crg"), crg(modifiers)).unwrap();
        refused(folder.path(), &["road", "scene.toml"], &["road.file", "a.crg", word]);
    }
    let digits = format!("scale_length = {}x", "1".repeat(150_000));
    fs::write(folder.path().join("a.crg"), crg(&digits)).unwrap();
    refused(folder.path(), &["road", "scene.toml"], &["scale_length", "is not a number"]);
}
