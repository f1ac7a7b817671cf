//! Pages of sweeps and of commands beside `run`: whole, with the numbers of their tables, drawn by a browser.

use std::fs;
use std::path::Path;

use tyrewave::internals::{PAGE_HEAD, four_digits, scene_text};

use crate::common::tyrewave;
use crate::report::assert_drawn;

const HEARD: &str = "[[receiver]]\nstandard = \"cpx\"\n[radiation]\nquality = \"draft\"\nfmax = 500.0";

fn small(elements: usize, more: &str) -> String {
    let rolling = "speed_kmh = 80.0\nwarm_up = 0.1\nduration = 0.7\naxle = { load = 3000.0, tolerance = 0.5 }";
    scene_text(elements, "kind = \"made\"\nseed = 4", rolling, "history = \"modal\"\npole_tolerance = 1e-3", more)
}

/// Executes a command that must succeed.
fn done(place: &Path, arguments: &[&str]) {
    let output = tyrewave(place, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
}

/// Reads a page that must be whole and fetch nothing.
fn whole(path: &Path) -> String {
    let text = fs::read_to_string(path).unwrap();
    assert!(text.starts_with(PAGE_HEAD) && text.ends_with("</html>"));
    // Links of the contents lead to places of the page itself.
    let plain = text.replace("http://www.w3.org/2000/svg", "").replace("href=\"#", "");
    for address in ["http:", "https:", "src=\"//", "href=", "<link", "url("] {
        assert!(!plain.contains(address), "{address}");
    }
    for image in text.split("role=\"img\"").skip(1) {
        assert!(!image.starts_with(" aria-label=\"\""), "a picture has no words");
    }
    text
}

fn rows(path: &Path) -> Vec<csv::StringRecord> {
    csv::Reader::from_path(path).unwrap().records().map(Result::unwrap).collect()
}

#[test]
fn the_page_of_a_sweep_has_levels_sounds_and_tables() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    fs::write(place.join("scene.toml"), small(64, HEARD)).unwrap();
    let varied = ["--speed", "60,80", "--set", "road.seed=1..2"];
    done(place, &[&["sweep", "scene.toml", "--out", "s", "--report", "-q"][..], &varied].concat());
    let text = whole(&place.join("s.html"));
    for heading in ["Levels", "Third octaves", "Sound", "Growth with the speed", "Tables"] {
        assert!(text.contains(&format!("<h2>{heading}</h2>")), "{heading}");
    }
    assert!(text.contains("A sweep of 4 runs: road.seed = 1, 2; speed km/h = 60, 80."));
    let means = rows(&place.join("s/design.csv"));
    let levels: Vec<_> = means.iter().filter(|row| &row[2] == "dB(A)" && !row[1].ends_with(" Hz")).collect();
    assert_eq!(levels.len(), 2, "one receiver at two speeds");
    let same_bands = levels.iter().all(|row| row[9] == levels[0][9]);
    for row in levels {
        let number = |column: usize| row[column].parse::<f64>().unwrap();
        let [mean, interval] = [number(4), number(5)];
        let reported = format!("{}: {} \u{b1} {}", &row[1], four_digits(mean), four_digits(interval));
        // Pictures hold levels over common bands against each other, tables have each over all of its bands.
        assert!(!same_bands || text.contains(&format!("\n{reported}</title>")), "{reported}");
        let cell = |least: &str| text.contains(&format!("<td class=\"number\">{least}{mean:.2} +- {interval:.2}"));
        assert!(cell("") || cell("at least "), "{mean}");
    }
    // One seed is played at each speed, as it is in its folder.
    assert!(text.contains("2 of 4 runs, of several seeds the first.") && text.matches("<audio").count() == 2);
    assert!(text.contains("<dt>60 km/h, ") && text.contains("<dt>80 km/h, "));
    assert_drawn(&text, place, 5);

    done(place, &["report", "s", "--out", "again.html"]);
    assert_eq!(fs::read_to_string(place.join("again.html")).unwrap(), text);
    let refused = |arguments: &[&str], word: &str| {
        let output = tyrewave(place, arguments);
        let reported = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && reported.contains(word), "{arguments:?}: {reported}");
    };
    refused(&["report", "s", "s/seed=1-60kmh"], "name it alone");
    refused(&["sweep", "--collect", "s", "--report"], "cannot be used with");
    fs::rename(place.join("s/seed=2-60kmh"), place.join("elsewhere")).unwrap();
    done(place, &["report", "s"]);
    assert!(whole(&place.join("s.html")).contains("Not finished and not shown: 1 of them."));
    // Nothing outside of the folder is read.
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("../elsewhere", place.join("s/seed=2-60kmh")).unwrap();
        refused(&["report", "s"], "link");
    }
    let record = fs::read_to_string(place.join("s/sweep.json")).unwrap();
    fs::write(place.join("s/sweep.json"), record.replace("\"seed=2-60kmh\"", "\"../elsewhere\"")).unwrap();
    refused(&["report", "s"], "s/sweep.json");
    fs::write(place.join("s/sweep.json"), record.replace("\"format_version\": 1", "\"format_version\": 9")).unwrap();
    refused(&["report", "s"], "version 1");
    fs::write(place.join("s/sweep.json"), record.replacen("\"road.seed\"", "\"road\"", 1)).unwrap();
    refused(&["report", "s"], "the same keys");
}

#[test]
fn a_sweep_of_another_key_is_drawn_against_that_key() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    fs::write(place.join("scene.toml"), small(64, "")).unwrap();
    done(place, &["sweep", "scene.toml", "--out", "s", "--load", "2500,3000,3500", "--report", "-q"]);
    let text = whole(&place.join("s.html"));
    assert!(text.contains("load N = 2500, 3000, 3500") && text.contains("Force against load N"));
    assert!(
        !text.contains("<h2>Sound</h2>") && !text.contains("<h2>Growth") && text.contains("<h2>Third octaves</h2>")
    );
    for row in rows(&place.join("s/sweep.csv")).iter().filter(|row| &row[12] == "1") {
        assert!(text.contains(&format!("{:.2}", row[4].parse::<f64>().unwrap())), "{row:?}");
    }
}

#[test]
fn a_tyre_its_radiation_and_a_study_have_pages() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    fs::write(place.join("scene.toml"), small(32, "")).unwrap();
    let few = ["--waves=2", "--lateral=1", "--highest=150", "--loads=300", "--points=4", "--patch=20", "-q"];
    done(place, &[&["tyre", "scene.toml", "--out", "t"][..], &few].concat());
    let text = whole(&place.join("t/tyre.html"));
    let stiffness = rows(&place.join("t/loads.csv"))[0][2].parse::<f64>().unwrap();
    assert!(text.contains("<td>300 kg</td>") && text.contains(&format!("{stiffness:.3e}")), "{stiffness}");
    assert!(["Modes", "Under a load", "Mobility"].iter().all(|of| text.contains(&format!("<h2>{of}</h2>"))));
    assert!(!text.contains("Turning tyre"), "it was not rolled");
    assert_drawn(&text, place, 6);

    done(place, &["radiation", "scene.toml", "--out", "r", "--highest", "600", "--points", "2", "-q"]);
    let text = whole(&place.join("r/radiation.html"));
    for row in rows(&place.join("r/radiation.csv")) {
        let [frequency, horn] = [&row[0], &row[4]].map(|cell| cell.parse::<f64>().unwrap());
        let cells = format!("<td>{frequency:.0}</td><td class=\"number\">{horn:+.1} dB</td>");
        assert!(text.contains(&cells), "{cells}");
    }
    assert_drawn(&text, place, 10);

    let study = ["study", "scene.toml", "--fmax", "125", "--duration", "0.3", "--elements", "64", "--substeps", "4"];
    done(place, &[&study[..], &["--out", "a", "-q"]].concat());
    let text = whole(&place.join("a/study.html"));
    assert!(text.contains("Settings of the discretisation") && text.contains("Multiply-adds per second of rolling"));
    for row in rows(&place.join("a/study.csv")).iter().filter(|row| &row[0] == "substeps") {
        assert!(text.contains(&format!("<td>{} {}</td>", &row[0], &row[1])), "{row:?}");
    }
}
