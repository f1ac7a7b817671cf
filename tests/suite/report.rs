//! Pages of results: whole, by themselves, drawn by a browser without errors; and results held against each other.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::LazyLock;
use std::time::{Duration, Instant};

use serde_json::Value;
use tempfile::TempDir;
use tyrewave::internals::{Comparison, PAGE_HEAD, scene_text, stored_spectra};
use tyrewave::report::{Stored, page};
use tyrewave::response::BandLevel;

use crate::common::{names, read_summary, skipped, tyrewave};

/// Two runs that differ in their speed, with vibration; a draft's sound in the first. Made once for all tests.
fn results() -> &'static (TempDir, [PathBuf; 2]) {
    static RESULTS: LazyLock<(TempDir, [PathBuf; 2])> = LazyLock::new(run_both);
    &RESULTS
}

fn run_both() -> (TempDir, [PathBuf; 2]) {
    let folder = tempfile::tempdir().unwrap();
    let text = |speed: f64, more: &str| {
        let rolling = format!(
            "speed_kmh = {speed:?}\nwarm_up = 0.1\nduration = 0.7\naxle = {{ load = 3000.0, tolerance = 0.5 }}"
        );
        let more = format!("[outputs.vibration]\nmap = true\n{more}");
        let numerics = "history = \"modal\"\npole_tolerance = 1e-3";
        scene_text(64, "kind = \"made\"\nseed = 4", &rolling, numerics, &more)
    };
    let receiver = "[[receiver]]\nstandard = \"cpx\"\n[radiation]\nquality = \"draft\"\nfmax = 500.0";
    let folders = [("slow", 60.0, receiver), ("fast", 80.0, "")].map(|(name, speed, more)| {
        fs::write(folder.path().join(format!("{name}.toml")), text(speed, more)).unwrap();
        let scene = format!("{name}.toml");
        let output = tyrewave(folder.path(), &["run", &scene, "--out", name, "--report", "-q"]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        assert!(folder.path().join(format!("{name}.html")).is_file(), "--report writes the page");
        folder.path().join(name)
    });
    (folder, folders)
}

fn open(folders: &[PathBuf]) -> Vec<Stored> {
    folders.iter().map(|folder| Stored::open(folder).unwrap()).collect()
}

#[test]
fn a_damaged_array_is_refused_by_report_as_by_export() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("run");
    fs::create_dir(&place).unwrap();
    let (_, [slow, _]) = results();
    for name in names(slow) {
        fs::copy(slow.join(&name), place.join(&name)).unwrap();
    }
    let array = place.join("total_force.npy");
    let bytes = fs::read(&array).unwrap();
    fs::write(&array, &bytes[..bytes.len() - 4]).unwrap();
    for command in [&["report", "run"][..], &["export", "run", "--format", "mat"]] {
        let output = tyrewave(folder.path(), command);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{command:?}: {message}");
        assert!(message.contains("total_force.npy"), "{command:?}: {message}");
    }
    assert_eq!(names(folder.path()), ["run"]);
}

/// A browser, where there is one.
fn browser() -> Option<&'static str> {
    let runs = |name: &&str| {
        let mut command = Command::new(name);
        command.arg("--version").stdout(Stdio::null()).stderr(Stdio::null());
        command.status().is_ok_and(|status| status.success())
    };
    ["chromium", "chromium-browser", "google-chrome"].into_iter().find(runs)
}

/// The page as a browser has it after its scripts, `probe` among them; windows so wide \[pixels\].
fn drawn(browser: &str, page: &Path, width: u32) -> String {
    let profile = tempfile::tempdir().unwrap();
    let mut command = Command::new(browser);
    command.args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking", "--disable-sync"]);
    command.arg(format!("--user-data-dir={}", profile.path().display())).arg(format!("--window-size={width},900"));
    command.arg("--dump-dom").arg(format!("file://{}", page.display()));
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    let stdout = child.stdout.take().unwrap();
    let reader = std::thread::spawn(move || std::io::read_to_string(stdout).unwrap());
    let begin = Instant::now();
    while child.try_wait().unwrap().is_none() {
        assert!(begin.elapsed() < Duration::from_secs(60), "{browser} does not end");
        std::thread::sleep(Duration::from_millis(50));
    }
    reader.join().unwrap()
}

/// Counts what went wrong, what has no place in the page, and states it in the page itself.
const PROBE: &str = r#"<script>
const wrong = []; addEventListener("error", (event) => wrong.push(event.message), true);
addEventListener("load", () => {
  const pictures = [...document.querySelectorAll(".picture svg")];
  const cut = pictures.filter((svg) => svg.getBoundingClientRect().right > innerWidth);
  const flat = pictures.filter((svg) => svg.getBoundingClientRect().height < 20 || !svg.querySelector("title"));
  const texts = pictures.flatMap((svg) => [...svg.querySelectorAll("text")].map((text) => [svg, text]));
  const size = ([svg, text]) => parseFloat(getComputedStyle(text).fontSize)
    * svg.getBoundingClientRect().width / svg.viewBox.baseVal.width;
  const outside = texts.filter(([svg, text]) => {
    const [sheet, words] = [svg, text].map((of) => of.getBoundingClientRect());
    return words.left < sheet.left - 1 || words.right > sheet.right + 1 || words.top < sheet.top - 1
      || words.bottom > sheet.bottom + 1;
  });
  document.body.dataset.illegible = texts.filter((text) => size(text) < 10).length;
  document.body.dataset.outside = outside.map(([, text]) => text.textContent.trim()).join("; ") || "nothing";
  const target = document.querySelector(".picture svg rect > title").parentElement;
  const at = target.getBoundingClientRect();
  target.dispatchEvent(new PointerEvent("pointermove", { bubbles: true, clientX: at.x + 1, clientY: at.y + 1 }));
  const told = document.getElementById("told");
  document.body.dataset.pictures = pictures.length; document.body.dataset.flat = flat.length;
  document.body.dataset.cut = cut.length;
  document.body.dataset.told = !told.hidden && told.textContent.length > 3;
  document.body.dataset.wide = document.documentElement.scrollWidth > innerWidth;
  document.body.dataset.wrong = wrong.join("; ") || "nothing";
});
</script>"#;

#[test]
fn a_page_is_complete_and_drawn_without_a_network() {
    let (folder, folders) = results();
    let text = fs::read_to_string(folder.path().join("slow.html")).unwrap();
    for section in ["Plan", "Road", "Contact", "Force spectrum", "Vibration", "Sound", "Cost", "To run it again"] {
        assert!(text.contains(&format!("<h2>{section}</h2>")), "{section}");
    }
    let place = |section: &str| text.find(&format!("<h2>{section}</h2>"));
    assert!(place("Sound") < place("Plan"), "what was asked for comes before how it was computed");
    let contents = text.split("<nav>").nth(1).and_then(|rest| rest.split("</nav>").next()).unwrap();
    assert_eq!(contents.matches("<a href=\"#").count(), text.matches("<h2>").count(), "{contents}");
    assert!(text.find("<nav>") < text.find("<h2>") && contents.contains("href=\"#to-run-it-again-0\""));
    assert!(text.contains("60 km/h") && text.contains("data:audio/wav;base64,") && text.contains("speed_kmh = 60.0"));
    assert!(text.starts_with(PAGE_HEAD));
    // Names of formats apart, an address would be something to fetch.
    let plain = text.replace("http://www.w3.org/2000/svg", "");
    assert!(!plain.contains("http:") && !plain.contains("https:") && !plain.contains("src=\"//"));
    let fast = fs::read_to_string(folder.path().join("fast.html")).unwrap();
    assert!(!fast.contains("<h2>Sound</h2>"), "what a run does not have is left out");

    assert_drawn(&page(&open(folders)).unwrap(), folder.path(), 12);
}

/// Fails unless a browser draws a page without errors, on a desk and on a phone, with so many pictures at least.
pub(super) fn assert_drawn(page: &str, folder: &Path, least: usize) {
    let Some(browser) = browser() else {
        skipped("there is no browser");
        return;
    };
    let file = folder.join("probed.html");
    fs::write(&file, page.replacen("<head>", &format!("<head>{PROBE}"), 1)).unwrap();
    for width in [1280, 390] {
        let found = drawn(browser, &file, width);
        let body = found.split("<body").nth(1).and_then(|rest| rest.split('>').next()).unwrap_or_default();
        for expected in [
            "data-flat=\"0\"",
            "data-cut=\"0\"",
            "data-told=\"true\"",
            "data-wide=\"false\"",
            "data-wrong=\"nothing\"",
            "data-illegible=\"0\"",
            "data-outside=\"nothing\"",
        ] {
            assert!(body.contains(expected), "{width} pixels: {body}");
        }
        let pictures = body.split("data-pictures=\"").nth(1).and_then(|rest| rest.split('"').next()).unwrap();
        assert!(pictures.parse::<usize>().unwrap() >= least, "{body}");
    }
}

/// Corners of the lines of a colour, by line.
fn corners(svg: &str, colour: &str) -> Vec<usize> {
    let lines = svg.split('<').filter(|tag| tag.starts_with("polyline") && tag.contains(colour));
    lines.filter_map(|tag| Some(tag.split("points=\"").nth(1)?.split('"').next()?.matches(',').count())).collect()
}

#[test]
fn levels_that_are_not_valid_are_grey_beside_another_run() {
    let (_, folders) = results();
    let all = open(folders);
    let both = page(&all).unwrap();
    let picture = |caption: &str| -> &str {
        let figures = both.split("<figure>").filter(|figure| figure.contains(&format!("<figcaption>{caption}")));
        figures.last().unwrap_or_else(|| panic!("{caption}"))
    };
    let force: Vec<_> = all.iter().map(|stored| &stored_spectra(stored)[0].levels).collect();
    let valid = |levels: &[BandLevel]| levels.iter().filter(|level| level.valid).count();
    let [slow, fast] = [valid(force[0]), valid(force[1])];
    assert!(slow < force[0].len() && fast < force[1].len() && slow > 3, "both have bands of either kind");
    // Two corners a band; bars of errors, a bar a band, and the legend's line come last.
    let levels = picture("Contact force level, third octaves");
    for (colour, valid) in [("#0072B2", slow), ("#D55E00", fast)] {
        let found = corners(levels, colour);
        assert!(found[0] == 2 * valid && found[1..].iter().all(|&corners| corners == 2), "{found:?}");
    }
    assert_eq!(corners(levels, "#BEBEBE"), [2 * force[0].len(), 2 * force[1].len()]);
    // A point for each band that is valid in both.
    let difference = picture("Contact force level, difference from slow");
    assert_eq!(corners(difference, "#D55E00"), [slow.min(fast), 2], "the second run keeps its colour");
    assert!(corners(difference, "#0072B2").is_empty());
    assert_eq!(corners(difference, "#BEBEBE"), [force[0].len()]);
    assert!(difference.contains(", not valid"), "the value at the pointer says so, too");
}

/// A copy of a results folder with another summary.
fn copied(from: &Path, to: &Path, summary: impl FnOnce(&mut Value)) {
    fs::create_dir(to).unwrap();
    for name in names(from) {
        fs::copy(from.join(&name), to.join(&name)).unwrap();
    }
    let mut changed = read_summary(from);
    summary(&mut changed);
    fs::write(to.join("summary.json"), changed.to_string()).unwrap();
}

#[test]
fn names_in_a_results_folder_lead_to_nothing_outside_of_it() {
    let (_, [slow, _]) = results();
    let place = tempfile::tempdir().unwrap();
    // A secret that would serve as a picture, a table, a road and a sound.
    let secret = "<svg >x</svg>\nsecret,words\n1,2\n";
    let file = place.path().join("secret.csv");
    fs::write(&file, secret).unwrap();
    let (base64, absolute) = ("PHN2ZyA+eDwvc3ZnPgpz", file.to_string_lossy().into_owned());
    type Change<'a> = Box<dyn Fn(&mut Value) + 'a>;
    let listed = |name: &str| -> Change<'static> {
        let name = name.to_owned();
        Box::new(move |summary| summary["files"].as_array_mut().unwrap().push(name.clone().into()))
    };
    let refused: [(&str, Change<'_>); 5] = [
        ("listed", listed("../secret.csv")),
        ("absolute", listed(&absolute)),
        ("deeper", listed("vibration_map_/../../secret.csv")),
        ("sound", Box::new(|summary| summary["sound"]["receivers"][0]["audio"]["file"] = "../secret.csv".into())),
        ("tyre", Box::new(|summary| summary["settings"]["tyre"] = absolute.clone().into())),
    ];
    let of = |name: &'static str| -> [Vec<&'static str>; 4] {
        [
            vec!["report", name],
            vec!["compare", name, name],
            vec!["export", name, "--format", "mat"],
            vec!["export", name, "--format", "uff58"],
        ]
    };
    let problem = |command: &[&str], output: &Output| -> String {
        let all = [&output.stdout[..], &output.stderr].concat();
        let text = String::from_utf8_lossy(&all).into_owned();
        assert!(!text.contains("secret,words") && !text.contains("<svg >"), "{command:?}: {text}");
        text
    };
    for (name, change) in refused {
        copied(slow, &place.path().join(name), change);
        for command in of(name) {
            let output = tyrewave(place.path(), &command);
            let text = problem(&command, &output);
            assert_eq!(output.status.code(), Some(2), "{command:?}: {text}");
            assert!(
                text.contains(&format!("{name}/summary.json")) || text.contains("secret.csv"),
                "{command:?}: {text}"
            );
        }
    }
    let road = |summary: &mut Value| {
        summary["settings"]["road"] = serde_json::json!({ "kind": "profile", "file": absolute.clone() });
    };
    copied(slow, &place.path().join("road"), road);
    for command in of("road") {
        let output = tyrewave(place.path(), &command);
        let text = problem(&command, &output);
        assert!(output.status.success(), "{command:?}: {text}");
    }
    let text = fs::read_to_string(place.path().join("road.html")).unwrap();
    assert!(text.contains("its file, secret.csv, is not among the results"));
    assert!(!text.contains("secret,words") && !text.contains(base64));
    #[cfg(unix)]
    for name in ["spectra.csv", "time.npy", "patch_force.svg", "summary.json"] {
        let linked = place.path().join("linked");
        copied(slow, &linked, |_| {});
        fs::remove_file(linked.join(name)).unwrap();
        std::os::unix::fs::symlink("../secret.csv", linked.join(name)).unwrap();
        for command in of("linked") {
            let output = tyrewave(place.path(), &command);
            let text = problem(&command, &output);
            assert_eq!(output.status.code(), Some(2), "{command:?}: {text}");
            assert!(text.contains(&format!("linked/{name}")) && text.contains("link"), "{command:?}: {text}");
        }
        fs::remove_dir_all(linked).unwrap();
    }
    let made = names(place.path()).into_iter().filter(|name| name.contains('.')).collect::<Vec<_>>();
    assert_eq!(made, ["road.html", "road.mat", "road.uff", "secret.csv"], "nothing else was written");
}

#[test]
fn a_measured_road_is_shown_by_the_run_that_knows_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let heights: String = (0..4000).map(|k| format!("{},{}\n", k, f64::from(k % 7) / 10.0)).collect();
    fs::create_dir(folder.path().join("scenes")).unwrap();
    fs::write(folder.path().join("scenes/road.csv"), format!("x,z\n{heights}")).unwrap();
    let road = "kind = \"profile\"\nfile = \"road.csv\"\ndistance_unit = \"mm\"\nheight_unit = \"mm\"\n\
                at_end = \"repeat\"";
    let rolling = "speed_kmh = 60.0\nwarm_up = 0.05\nduration = 0.1\naxle = { indentation = 0.01 }";
    fs::write(folder.path().join("scenes/a.toml"), scene_text(64, road, rolling, "", "")).unwrap();
    let output = tyrewave(folder.path(), &["run", "scenes/a.toml", "--out", "a", "--report", "-q"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let read = || fs::read_to_string(folder.path().join("a.html")).unwrap();
    assert!(read().contains("Heights of the road") && read().contains("mean profile depth"));
    assert!(tyrewave(folder.path(), &["report", "a"]).status.success());
    assert!(!read().contains("Heights of the road") && read().contains("its file, road.csv, is not among the results"));
}

#[test]
fn chosen_settings_stand_beside_the_plan_not_among_warnings() {
    let (_, folders) = results();
    let of = |notes: &[&str], warnings: &[&str]| {
        let mut stored = Stored::open(&folders[1]).unwrap();
        let texts = |texts: &[&str]| texts.iter().map(|text| (*text).to_owned()).collect();
        (stored.summary.notes, stored.summary.warnings) = (texts(notes), texts(warnings));
        page(&[stored]).unwrap()
    };
    let chosen = of(&["numerics.elements = 64 (chosen)"], &[]);
    assert!(chosen.contains("numerics.elements = 64 (chosen)") && !chosen.contains("<h2>Warnings</h2>"));
    let warned = of(&[], &["the run is too short"]);
    let section = warned.split("<h2>Warnings</h2>").nth(1).and_then(|rest| rest.split("<h2>").next());
    assert!(section.is_some_and(|section| section.contains("the run is too short")));
}

#[test]
fn results_are_compared_with_the_first_and_with_themselves() {
    let (folder, folders) = results();
    let of_both = Comparison::of(&open(folders));
    let keys: Vec<&str> = of_both.settings.iter().map(|setting| setting.key.as_str()).collect();
    assert!(keys.contains(&"rolling.speed_kmh") && keys.contains(&"receiver[0].standard"), "{keys:?}");
    let force = of_both.figures.iter().find(|figure| figure.name == "mean force").unwrap();
    let is_plausible = |found: &f64| (2000.0..4000.0).contains(found);
    assert!(force.found.iter().all(|found| found.as_ref().is_some_and(|found| is_plausible(&found.figure.value))));
    let same = Comparison::of(&open(&[folders[1].clone(), folders[1].clone()]));
    assert!(same.settings.is_empty());
    assert!(same.figures.iter().all(|figure| figure.found[0] == figure.found[1]));

    let run = |arguments: &[&str]| tyrewave(folder.path(), &[&["compare", "slow", "fast"][..], arguments].concat());
    let json: Value = serde_json::from_slice(&run(&["--json"]).stdout).unwrap();
    assert_eq!(json["names"], serde_json::json!(["slow", "fast"]));
    let csv = String::from_utf8(run(&["--csv"]).stdout).unwrap();
    assert!(csv.starts_with("quantity,signal,nominal_hz,valid,slow,fast,"), "{csv}");
    let table = String::from_utf8(run(&[]).stdout).unwrap();
    assert!(table.contains("rolling.speed_kmh") && table.contains("difference"), "{table}");
}

#[test]
fn foreign_files_are_refused_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let made = |name: &str, summary: &str| {
        fs::create_dir(folder.path().join(name)).unwrap();
        fs::write(folder.path().join(name).join("summary.json"), summary).unwrap();
    };
    made("broken", "{ \"format\": ");
    made("foreign", "{ \"format\": \"something else\" }");
    made("later", "{ \"format\": \"tyrewave results\", \"format_version\": 99 }");
    made("hollow", "{ \"format\": \"tyrewave results\", \"format_version\": 1 }");
    for name in ["broken", "foreign", "later", "hollow", "missing"] {
        for command in [&["report", name][..], &["compare", name, name]] {
            let output = tyrewave(folder.path(), command);
            let message = String::from_utf8_lossy(&output.stderr).into_owned();
            assert_eq!(output.status.code(), Some(2), "{command:?}: {message}");
            assert!(message.contains(&format!("{name}/summary.json")), "{message}");
        }
    }
    assert_eq!(names(folder.path()), ["broken", "foreign", "hollow", "later"]);
}
