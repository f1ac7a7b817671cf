//! The tutorial, followed line by line.

use std::fs::{self, OpenOptions};
use std::io::Write;
use std::path::Path;

use crate::archive::{unpacked, words};
use crate::common::tyrewave;

const TUTORIAL: &str = include_str!("../../docs/tutorial.md");

/// Settings that make every run a short one.
const SHORT: [&str; 6] =
    ["--set", "rolling.warm_up=0.1", "--set", "radiation.quality=draft", "--set", "radiation.fmax=500.0"];

/// Commands that take minutes and have separate tests.
const LONG: [&str; 2] = ["fit-tyre", "effects"];

/// Follows the tutorial in the unpacked archive: with short runs and without [`LONG`], or as it is.
fn follow(short: bool) {
    let folder = unpacked();
    let mut commands = 0;
    for block in TUTORIAL.split("```").skip(1).step_by(2) {
        let (language, text) = block.split_once('\n').unwrap();
        match language {
            "toml" => {
                let (file, addition) = text.split_once('\n').unwrap();
                let path = folder.path().join(file.strip_prefix("# ").unwrap());
                let mut file = OpenOptions::new().append(true).open(&path).unwrap();
                write!(file, "\n{addition}").unwrap();
            }
            "sh" => {
                for line in text.replace("\\\n", " ").lines() {
                    carry_out(folder.path(), line, short);
                    commands += 1;
                }
            }
            other => panic!("a block of {other}"),
        }
    }
    assert_eq!(commands, 13);
    let long = ["fitted/tyre.toml", "effects/effects.csv"];
    let files = [
        "first.html",
        "first/sound_cpx.wav",
        "first/sound.csv",
        "station/texture_spectrum.svg",
        "seal/spectra.csv",
        "speeds/sweep.csv",
    ];
    for file in files.into_iter().chain(long.into_iter().filter(|_| !short)) {
        assert!(folder.path().join("trial").join(file).exists(), "{file}");
    }
}

fn carry_out(folder: &Path, line: &str, short: bool) {
    let words: Vec<&str> = words(line).collect();
    if words[0] == "cp" {
        fs::copy(folder.join(words[1]), folder.join(words[2])).unwrap();
        return;
    }
    assert_eq!(words[0], "tyrewave", "{line}");
    let mut arguments: Vec<&str> = words[1..].to_vec();
    if short && LONG.contains(&arguments[0]) {
        return;
    }
    if short && ["run", "sweep", "plan"].contains(&arguments[0]) {
        for word in &mut arguments {
            match word.split_once('=') {
                Some(("rolling.duration", _)) => *word = "rolling.duration=0.6",
                Some(("numerics", _)) => *word = "numerics={elements=128}",
                _ => {}
            }
        }
        arguments.extend(SHORT);
    }
    let done = tyrewave(folder, &arguments);
    assert!(done.status.success(), "{line}: {}", String::from_utf8_lossy(&done.stderr));
}

#[test]
fn the_tutorial_holds_with_short_runs() {
    follow(true);
}

#[test]
#[ignore = "minutes: the tutorial's runs at their length"]
fn the_tutorial_holds_as_it_stands() {
    follow(false);
}
