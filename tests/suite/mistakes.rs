//! Twenty plausible mistakes in scenes, and what `tyrewave check` answers: each is known before anything is run.
//!
//! `TYREWAVE_MISTAKES=1 cargo test twenty_plausible` writes `twenty_mistakes.txt` anew.

use std::fmt::Write;
use std::fs;

use tyrewave::test_models::replaced;

use crate::suite::common::{folder_with, names, tyrewave};

/// Answers of the program.
const ANSWERS: &str = include_str!("twenty_mistakes.txt");
const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/suite/twenty_mistakes.txt");

/// A scene without a mistake.
const SCENE: &str = r#"title = "Chip seal, 80 km/h"
tyre = "car.toml"
[road]
kind = "made"
seed = 1
[rolling]
speed_kmh = 80.0
duration = 3.5
axle = { load = 3400.0 }
[numerics]
preset = "draft"
fmax = 1000.0
[[receiver]]
name = "beside"
standard = "coast-by"
[[receiver]]
name = "close"
standard = "cpx"
[radiation]
quality = "draft"
"#;

const MADE: &str = "kind = \"made\"\nseed = 1";

/// Mistakes: the words that were meant, and those that were written.
const MISTAKES: [(&str, &str, &str); 20] = [
    ("a slip in a key", "speed_kmh = 80.0", "sped_kmh = 80.0"),
    ("a decimal comma", "duration = 3.5", "duration = 3,5"),
    ("a word without quotes", "\"draft\"\nfmax", "draft\nfmax"),
    ("a word that is nearly right", "standard = \"coast-by\"", "standard = \"coastby\""),
    ("a load in kN", "load = 3400.0", "load = 3.4"),
    ("an indentation in dm", "{ load = 3400.0 }", "{ indentation = 0.25 }"),
    ("a distance in mm", "standard = \"coast-by\"", "standard = \"coast-by\"\ndistance = 7500.0"),
    ("a microphone in the tyre", "standard = \"cpx\"", "position = [0.1, 0.0, 0.3]"),
    ("one name for two receivers", "\"close\"", "\"beside\""),
    ("a name that a spreadsheet computes", "\"close\"", "\"=close\""),
    ("a title with an escape sequence", "Chip seal", "\\u001b[31mChip seal"),
    ("a run too short for any sound", "duration = 3.5", "duration = 0.3"),
    ("a run too short for a passage", "duration = 3.5", "duration = 1.0"),
    ("a speed above that of the belt's waves", "speed_kmh = 80.0", "speed_kmh = 300.0"),
    ("fewer elements than fmax asks for", "fmax = 1000.0", "fmax = 1000.0\nelements = 128"),
    ("more elements than any tyre needs", "fmax = 1000.0", "fmax = 1000.0\nelements = 100000000"),
    ("a road that is not there", MADE, "kind = \"profile\"\nfile = \"station.dat\""),
    ("a road of another kind", MADE, "kind = \"profile\"\nfile = \"cobbles.crg\""),
    ("a profile without its units", MADE, "kind = \"profile\"\nfile = \"line.csv\""),
    (
        "a road shorter than the run",
        MADE,
        "kind = \"profile\"\nfile = \"line.csv\"\ndistance_unit = \"mm\"\nheight_unit = \"mm\"",
    ),
];

#[test]
fn twenty_plausible_mistakes_are_answered_before_anything_is_run() {
    let mut answers = String::new();
    let scenes = [("no mistake", "", "")].iter().chain(&MISTAKES);
    for (number, (what, meant, written)) in scenes.enumerate() {
        let folder = folder_with(&replaced(SCENE, &[(meant, written)]));
        let place = folder.path();
        let shipped = |name: &str| concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/").to_owned() + name;
        fs::copy(shipped("tyres/car.toml"), place.join("car.toml")).unwrap();
        fs::copy(shipped("roads/cobbles.crg"), place.join("cobbles.crg")).unwrap();
        let line = (0..400).map(|row| format!("{row},{}\n", f64::from(row % 7) / 10.0));
        fs::write(place.join("line.csv"), format!("x,z\n{}", line.collect::<String>())).unwrap();
        let before = names(place);
        let output = tyrewave(place, &["check", "scene.toml"]);
        assert_eq!(names(place), before, "{what}");
        let (told, error) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
        let warnings = told.lines().filter(|line| line.contains("warning: ")).map(|line| format!("{line}\n"));
        let said = format!("{}{error}", warnings.collect::<String>());
        assert_eq!(output.status.success(), error.is_empty(), "{what}: {error}");
        let said = [place.to_owned(), place.canonicalize().unwrap()]
            .iter()
            .fold(said, |said, place| said.replace(&format!("{}/", place.display()), ""));
        if number == 0 {
            assert_eq!(said, "", "{what}");
            continue;
        }
        let written = written.replace('\n', "\n   ");
        write!(answers, "{number}. {what}:\n\n   {written}\n\n{}\n", said.trim_end()).unwrap();
        answers.push('\n');
    }
    if std::env::var_os("TYREWAVE_MISTAKES").is_some() {
        fs::write(FILE, &answers).unwrap();
    } else {
        assert_eq!(answers, ANSWERS);
    }
}
