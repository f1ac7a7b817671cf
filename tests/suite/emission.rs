//! Emission of a sweep: rows for models of traffic noise, from its command line to its table.

use std::fs;
use std::path::Path;
use std::process::Output;

use tyrewave::internals::scene_text;

use crate::common::command;

const MODAL: &str = "history = \"modal\"\npole_tolerance = 1e-4";
const ROLLING: &str = "speed_kmh = 80.0\nwarm_up = 0.3\nduration = 2.6\naxle = { load = 3000.0, tolerance = 0.9 }";
/// One tyre and a vehicle of four at its place, received by the same microphone, and one that moves along.
const BESIDE: &str = "[[receiver]]\nname = \"one\"\nstandard = \"coast-by\"\npassage = 20.0\n\
                      [[receiver]]\nname = \"four\"\nstandard = \"coast-by\"\npassage = 20.0\n\
                      vehicle = { wheelbase = 0.0, track = 0.25 }\n\
                      [[receiver]]\nname = \"along\"\nposition = [0.0, 3.0, 1.0]\n\
                      [outputs]\nplots = false\n";

fn scene(receivers: &str) -> String {
    let way = "[radiation]\nfmax = 300.0\nquality = \"draft\"\naudio = false";
    let more = if receivers.is_empty() { String::new() } else { format!("{receivers}{way}") };
    scene_text(64, "kind = \"made\"\nseed = 4", ROLLING, MODAL, &more)
}

fn program(folder: &Path, arguments: &[&str]) -> Output {
    command(folder, arguments).env("TYREWAVE_CACHE_DIR", folder.join("cache")).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn rows(path: &Path) -> Vec<csv::StringRecord> {
    csv::Reader::from_path(path).unwrap().records().map(Result::unwrap).collect()
}

fn number(row: &csv::StringRecord, column: usize) -> f64 {
    row[column].parse().unwrap()
}

#[test]
fn rows_are_the_lines_through_the_written_levels() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    fs::write(place.join("scene.toml"), scene(BESIDE)).unwrap();
    let swept = program(place, &["sweep", "scene.toml", "--speed", "60,75,85", "--out", "s", "--threads", "2"]);
    assert!(swept.status.success(), "{}", text(&swept.stderr));
    let made = program(place, &["emission", "s"]);
    let reported = text(&made.stdout);
    assert!(made.status.success(), "{}", text(&made.stderr));
    for word in ["one: CNOSSOS-EU", "four: Nord2000", "UN R117", "(", "rows in s/emission.csv"] {
        assert!(reported.contains(word), "{word}: {reported}");
    }
    let found = rows(&place.join("s/emission.csv"));
    let of = |receiver: &str, model: &str, band: &str| {
        let row = found.iter().find(|row| &row[1] == receiver && &row[2] == model && &row[3] == band);
        row.unwrap_or_else(|| panic!("{receiver}, {model}, {band}: {reported}"))
    };
    // The band of 125 Hz by hand: its levels, the mean of 1/(2 pi r^2) over the line, four tyres, a line through three.
    let levels = [60.0, 75.0, 85.0].map(|speed| {
        let table = rows(&place.join(format!("s/{speed}kmh/sound.csv")));
        let row = table.iter().find(|row| &row[0] == "one" && &row[1] == "125").unwrap();
        (f64::log10(speed / 70.0), number(row, 3), &row[5] == "1")
    });
    // 81 points along 20 m, every 0.25 m.
    let spread = (-40..=40).map(|step| {
        let squares = (0.25 * f64::from(step)).powi(2) + 7.5_f64.powi(2) + 1.15_f64.powi(2);
        (std::f64::consts::TAU * squares).recip()
    });
    let impedance = 343.2 * 101_325.0 / (287.05 * 293.15);
    let way = 10.0 * (impedance * 1e-12 / 4e-10 * spread.sum::<f64>() / 81.0).log10();
    let power = levels.map(|(x, level, _)| (x, level - way + 10.0 * 4.0_f64.log10()));
    let mean = |value: fn(&(f64, f64)) -> f64| power.iter().map(value).sum::<f64>() / 3.0;
    let (x, y) = (mean(|point| point.0), mean(|point| point.1));
    let slope = power.iter().map(|point| (point.0 - x) * (point.1 - y)).sum::<f64>()
        / power.iter().map(|point| (point.0 - x).powi(2)).sum::<f64>();
    // A third octave by the source of CNOSSOS-EU is in no row; its octave has it, with its neighbours.
    let octave = of("one", "cnossos-eu", "125");
    assert!(number(octave, 6) > y - slope * x && &octave[12] == "60" && &octave[13] == "85" && &octave[11] == "3");
    assert_eq!(&octave[14] == "1", levels.iter().all(|level| level.2), "{octave:?}");
    // Low over the road and at low frequencies the free field is 3 dB below the half space, but for the higher source.
    let third = of("one", "nord2000", "125");
    assert!((number(third, 6) - (y - slope * x - 10.0 * 2.0_f64.log10())).abs() < 0.2, "{third:?}: {y} {slope} {x}");
    assert!((number(third, 7) - slope).abs() < 1e-6, "{third:?}");
    // Four tyres in one place are as one tyre four times.
    for (model, band) in [("cnossos-eu", "63"), ("nord2000", "80")] {
        let [one, four] = ["one", "four"].map(|receiver| number(of(receiver, model, band), 6));
        assert!((one - four).abs() < 0.01, "{model}: {one} and {four}");
    }
    // Maxima of bands up to 250 Hz at most make no line: the loudest is above.
    assert!(found.iter().all(|row| &row[2] != "un-r117"), "{reported}");
    for receiver in ["one", "four"] {
        assert!(reported.contains(&format!("{receiver}: no line of UN R117: ")), "{reported}");
    }
    assert!(found.iter().all(|row| &row[1] != "along"), "it is not passed");
    // Bands above what is radiated are given, but not valid.
    let high = found.iter().filter(|row| &row[2] == "nord2000" && row[3].parse::<f64>().unwrap() > 300.0);
    assert!(high.clone().all(|row| &row[14] == "0"), "{found:?}");

    // Again the same bytes, elsewhere on demand; another file of that name stays.
    let bytes = fs::read(place.join("s/emission.csv")).unwrap();
    let json = program(place, &["emission", "s", "--out", "e", "--json"]);
    let json: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    assert_eq!(json["rows"].as_array().unwrap().len(), found.len());
    assert_eq!(fs::read(place.join("e/emission.csv")).unwrap(), bytes);
    fs::write(place.join("e/emission.csv"), "mine").unwrap();
    let refused = program(place, &["emission", "s", "--out", "e"]);
    assert!(refused.status.code() == Some(2) && text(&refused.stderr).contains("left alone"));
    // An unfinished run is reported.
    let summary = place.join("s/75kmh/summary.json");
    let written = fs::read_to_string(&summary).unwrap();
    fs::write(&summary, written.replacen("\"complete\": true", "\"complete\": false", 1)).unwrap();
    let refused = program(place, &["emission", "s"]);
    let reported = text(&refused.stderr);
    assert!(refused.status.code() == Some(2) && reported.contains("75kmh is not finished"), "{reported}");
}

#[test]
fn sweeps_without_a_line_over_speed_are_refused_with_help() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    fs::write(place.join("heard.toml"), scene(BESIDE)).unwrap();
    fs::write(place.join("silent.toml"), scene("")).unwrap();
    for (scene, out, speeds) in [("heard.toml", "one", "80"), ("silent.toml", "silent", "60,80")] {
        let swept = program(place, &["sweep", scene, "--speed", speeds, "--out", out]);
        assert!(swept.status.success(), "{}", text(&swept.stderr));
    }
    fs::create_dir(place.join("empty")).unwrap();
    for (source, words) in [
        ("one", ["80 km/h alone", "--speed 50..110:10"]),
        ("silent", ["no levels at a coast-by receiver", "standard = \"coast-by\""]),
        ("heard.toml", ["not the folder of a sweep", "tyrewave sweep SCENE --speed"]),
        ("one/80kmh", ["not the folder of a sweep", "tyrewave sweep SCENE --speed"]),
        ("empty", ["not the folder of a sweep", "tyrewave sweep SCENE --speed"]),
        ("nowhere", ["not the folder of a sweep", "nowhere"]),
    ] {
        let refused = program(place, &["emission", source]);
        let reported = text(&refused.stderr);
        assert_eq!(refused.status.code(), Some(2), "{source}: {reported}");
        assert!(words.iter().all(|word| reported.contains(word)), "{source}: {reported}");
        assert!(!place.join(source).join("emission.csv").exists());
    }
}
