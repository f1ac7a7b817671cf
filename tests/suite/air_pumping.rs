//! Air under the contact patch: what grooves change, what they leave as it was, what is refused.

use std::fs;
use std::sync::atomic::{AtomicBool, Ordering};

use tyrewave::Plan;
use tyrewave::counters::Progress;
use tyrewave::internals::{decisions, edit, plan_rows as rows, scene, scene_text};
use tyrewave::run::{Job, RunOptions, Simulation, Unwatched, resume};
use tyrewave::scene::{LoadedScene, Scene};

use crate::common::{Results, run};

const ELEMENTS: usize = 128;
const SPEED: f64 = 80.0 / 3.6;
const AROUND: f64 = 1.95;
const MADE: &str = "kind = \"made\"\nseed = 3";
const SLICES: &str = "slices = \"winkler\"\ncells_across = 4";
/// A groove over half of the strip, two cells wide.
const GROOVE: &str = "[tread_pattern]\ngrooves = [{ position = 0.0, width = 0.06, depth = 0.008 }]\n";
/// Low frequencies alone: boundary elements of a second.
const HEARD: &str = "[[receiver]]\nname = \"beside\"\nposition = [0.3, 0.6, 0.2]\n\
                     [radiation]\nfmax = 500.0\nnodes_per_wavelength = 5.0\nfrequency_tolerance = \"0.5 dB\"\n\
                     audio = false\n";
const DRAFT: &str = "[[receiver]]\nposition = [0.3, 0.6, 0.2]\n[radiation]\nquality = \"draft\"\nfmax = 500.0\n";
const OPEN: &str = "[air_pumping]\npatch = \"grooves\"\n";
const CELLS: &str = "zone = \"cells\"\ncells_across = 4";
const VOIDS: &str = "[air_pumping]\npatch = \"voids\"\n";
const SQUEEZED: &str = "squeeze = true\n";

/// A scene of so many revolutions, with the keys of its contact and other tables after them.
fn rolled(revolutions: f64, contact: &str, more: &str) -> String {
    let turn = AROUND / SPEED;
    let rolling = format!(
        "speed_kmh = 80.0\nwarm_up = 0.0\nduration = {:?}\naxle = {{ indentation = 0.014, ramp = 0.01 }}",
        (revolutions + 0.001) * turn
    );
    let numerics = format!("substeps = 1\ntime_rule = \"bdf2\"\nhistory = \"direct\"\nmemory = {:?}", 0.9 * turn);
    let outputs = "[outputs]\nplots = false\n";
    scene_text(ELEMENTS, MADE, &rolling, &numerics, &format!("[contact]\n{contact}\n{outputs}{more}"))
}

/// Tables of the sound.
const SOUND: [&str; 2] = ["sound.csv", "sound_narrow.csv"];

#[test]
fn grooves_sound_the_same_on_any_number_of_threads() {
    let of = |more: &str| run(&rolled(8.0, SLICES, &format!("{GROOVE}{HEARD}{more}")));
    let without = of("");
    let bytes = |results: &Results| SOUND.map(|name| fs::read(results.path(name)).unwrap());
    let off = format!("{OPEN}[effects]\nair_pumping = \"off\"\n");
    for more in ["[air_pumping]\n", "[air_pumping]\npatch = \"sealed\"\n", &off] {
        let sealed = of(more);
        assert!(bytes(&without) == bytes(&sealed) && !sealed.path("gap.csv").exists(), "{more}");
    }
    let on =
        |threads: usize| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| of(OPEN));
    let (one, two) = (on(1), on(2));
    assert!(bytes(&one) == bytes(&two), "threads");
    let gap = |results: &Results| fs::read_to_string(results.path("gap.csv")).unwrap();
    assert_eq!(gap(&one), gap(&two));
    // The forces are the same.
    let force = |results: &Results| fs::read(results.path("total_force.npy")).unwrap();
    assert!(force(&one) == force(&without));
    let level = |results: &Results| results.summary()["sound"]["receivers"][0]["level"].as_f64().unwrap();
    let (sealed, open) = (level(&without), level(&one));
    println!("sealed {sealed:.2} dB, open {open:.2} dB");
    assert!((sealed - open).abs() > 0.01, "{sealed} {open} dB");
    let table = gap(&one);
    let mut lines = table.lines();
    let header =
        "groove,position_m,width_m,depth_m,resonance_hz,quality,largest_pa,receiver,frequency_hz,green_1_per_m";
    assert_eq!(lines.next(), Some(header));
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    assert!(rows.len() >= 5 && rows.iter().all(|row| row[9].parse::<f64>().unwrap() > 0.0), "{table}");
    // In the middle of the groove it is louder than at the receiver, and far from 1 % of the static air pressure.
    let largest: f64 = rows[0][6].parse().unwrap();
    println!("largest pressure in the middle of the groove {largest:.2} Pa");
    let mean = 2e-5 * 10.0_f64.powf(open / 20.0);
    assert!(largest > 10.0 * mean && largest < 1400.0, "{largest} Pa, {mean} Pa at the receiver");
    let warnings = &one.summary()["warnings"];
    assert!(!warnings.to_string().contains("not linear"), "{warnings}");
    // Up to 500 Hz it has no peak.
    assert!(rows.iter().all(|row| row[0] == "0" && row[4].is_empty() && row[7] == "beside"), "{table}");
}

/// Bytes of the tables of the sound.
fn sound(results: &Results) -> [Vec<u8>; 2] {
    SOUND.map(|name| fs::read(results.path(name)).unwrap())
}

/// Interruption once so many steps are done.
struct After<'a>(u64, &'a AtomicBool);

impl Progress for After<'_> {
    fn step(&mut self, done: u64) {
        self.1.fetch_or(done >= self.0, Ordering::Relaxed);
    }
}

#[test]
fn squeezed_blocks_sound_the_same_on_any_threads_and_resumed() {
    let text = |more: &str| rolled(8.0, CELLS, &format!("{GROOVE}{HEARD}{more}"));
    let of = |more: &str| run(&text(more));
    let squeezed = format!("{OPEN}{SQUEEZED}");
    // Where it is off nothing is as if there were no key.
    let open = of(OPEN);
    let without = of(&format!("{OPEN}squeeze = false\n"));
    assert!(sound(&open) == sound(&without), "squeeze = false");
    let sealed = of("");
    assert!(sound(&sealed) == sound(&of(&format!("{squeezed}[effects]\nair_pumping = \"off\"\n"))), "off");
    let on = |threads: usize| {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| of(&squeezed))
    };
    let (one, two) = (on(1), on(2));
    assert!(sound(&one) == sound(&two), "threads");
    // Stopped while its second block of forces is taken in, and gone on with.
    let folder = tempfile::tempdir().unwrap();
    let (target, stop) = (folder.path().join("run"), AtomicBool::new(false));
    let options = RunOptions { target: target.clone(), threads: 1 };
    let stopped = tyrewave::run::run(&scene(&text(&squeezed)), &options, Job::new(&stop, &mut After(900, &stop)));
    assert!(stopped.is_err() && !target.exists());
    resume(&target, 1, Job::new(&AtomicBool::new(false), &mut Unwatched)).unwrap();
    assert!(SOUND.map(|name| fs::read(target.join(name)).unwrap()) == sound(&one), "resumed");
    // The forces are the same, and the vibration's part is all there was.
    let force = |results: &Results| fs::read(results.path("total_force.npy")).unwrap();
    assert!(force(&one) == force(&open));
    let table = |results: &Results| -> Vec<Vec<String>> {
        let text = fs::read_to_string(results.path("sound.csv")).unwrap();
        text.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect()
    };
    let (open, one_table) = (table(&open), table(&one));
    assert_eq!(one_table[0][..8], open[0][..8]);
    assert_eq!(one_table[0][8..], ["vibration_db_re_20upa", "squeeze_db_re_20upa", "standard_error_db"]);
    let mut apart = 0.0_f64;
    for (row, before) in one_table[1..].iter().zip(&open[1..]) {
        assert_eq!(row[8], before[3], "vibration");
        let [sum, vibration, squeeze] =
            [3, 8, 9].map(|column| 10.0_f64.powf(row[column].parse::<f64>().unwrap() / 20.0));
        // Pressures add up, not their squares.
        let most = vibration + squeeze;
        assert!(sum < most * (1.0 + 1e-6) && sum > (vibration - squeeze).abs() * (1.0 - 1e-6), "{row:?}");
        apart = apart.max((20.0 * (sum / vibration.hypot(squeeze)).log10()).abs());
        println!("{}: sum {} dB, vibration {} dB, squeeze {} dB", row[1], row[3], row[8], row[9]);
    }
    println!("levels are up to {apart:.2} dB off a sum of powers");
    assert!(one_table.len() > 5 && apart > 0.02, "{apart}");
    let receiver = &one.summary()["sound"]["receivers"][0];
    // Levels of the parts are sums over the bands that count, each with the weight of the whole there; weights are of
    // single lines.
    for (key, column) in [("vibration_level_a", 8), ("squeeze_level_a", 9)] {
        let number = |row: &[String], column: usize| row[column].parse::<f64>().unwrap();
        let power = |row: &Vec<String>| 10.0_f64.powf((number(row, column) + number(row, 4) - number(row, 3)) / 10.0);
        let valid = one_table[1..].iter().filter(|row| row[5] == "1");
        let (level, expected) = (receiver[key].as_f64().unwrap(), 10.0 * valid.map(power).sum::<f64>().log10());
        assert!((level - expected).abs() < 1.0, "{key}: {level} and {expected}");
    }
    assert!(sealed.summary()["sound"]["receivers"][0]["squeeze_level_a"].is_null());
}

#[test]
fn voids_of_the_road_sound_the_same_on_any_threads_and_resumed() {
    let text = |more: &str| rolled(8.0, CELLS, &format!("{HEARD}{more}"));
    let sealed = run(&text(""));
    let off = run(&text(&format!("{VOIDS}[effects]\nair_pumping = \"off\"\n")));
    assert!(sound(&sealed) == sound(&off) && !sealed.path("voids.csv").exists(), "off");
    let on = |threads: usize| {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| run(&text(VOIDS)))
    };
    let (one, two) = (on(1), on(2));
    let voids = |results: &Results| fs::read_to_string(results.path("voids.csv")).unwrap();
    assert!(sound(&one) == sound(&two) && voids(&one) == voids(&two), "threads");
    // There is no groove that could resonate.
    assert!(!one.path("gap.csv").exists());
    let folder = tempfile::tempdir().unwrap();
    let (target, stop) = (folder.path().join("run"), AtomicBool::new(false));
    let options = RunOptions { target: target.clone(), threads: 1 };
    let stopped = tyrewave::run::run(&scene(&text(VOIDS)), &options, Job::new(&stop, &mut After(900, &stop)));
    assert!(stopped.is_err() && !target.exists());
    resume(&target, 1, Job::new(&AtomicBool::new(false), &mut Unwatched)).unwrap();
    assert!(SOUND.map(|name| fs::read(target.join(name)).unwrap()) == sound(&one), "resumed");
    let force = |results: &Results| fs::read(results.path("total_force.npy")).unwrap();
    assert!(force(&one) == force(&sealed));
    let spreads = |results: &Results| -> Vec<f64> {
        let text = fs::read_to_string(results.path("sound.csv")).unwrap();
        let mut lines = text.lines();
        assert!(lines.next().unwrap().ends_with(",slice_error_db,voids_spread_db,standard_error_db"));
        lines.map(|line| line.rsplit(',').nth(1).unwrap().parse().unwrap()).collect()
    };
    let found = spreads(&one);
    println!("spreads {found:?} dB");
    assert!(found.iter().all(|spread| *spread >= 0.0) && found.iter().copied().fold(0.0, f64::max) > 0.01);
    assert!(sound(&one) != sound(&sealed));
    let summary = &one.summary()["sound"]["receivers"][0]["voids_spread_a"];
    assert!((0.0..5.0).contains(&summary.as_f64().unwrap()));
    // Where the road is the same at all places, the voids are.
    let smooth = text(VOIDS).replace(MADE, "kind = \"smooth\"");
    let found = spreads(&run(&smooth));
    assert!(found.iter().all(|spread| *spread < 1e-3), "{found:?}");
}

#[test]
fn squeezed_blocks_beside_voids_have_parts_of_all_places() {
    let results = run(&rolled(8.0, CELLS, &format!("{GROOVE}{HEARD}{VOIDS}{SQUEEZED}")));
    let text = fs::read_to_string(results.path("sound.csv")).unwrap();
    assert!(text.lines().next().unwrap().contains(",vibration_db_re_20upa,squeeze_db_re_20upa,voids_spread_db,"));
    assert!(results.path("gap.csv").exists() && results.path("voids.csv").exists());
    for line in text.lines().skip(1) {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap_or(f64::NAN)).collect();
        let [sum, vibration, squeeze] = [3, 8, 9].map(|column| 10.0_f64.powf(cells[column] / 20.0));
        // Root mean squares over places keep the inequality of each place.
        assert!(
            sum < (vibration + squeeze) * (1.0 + 1e-6) && sum > (vibration - squeeze).abs() * (1.0 - 1e-6),
            "{line}"
        );
        assert!(cells[10] >= 0.0);
    }
}

#[test]
fn squeeze_is_off_with_anything_that_it_needs() {
    let loaded = scene(&rolled(8.0, CELLS, &format!("{GROOVE}{HEARD}{OPEN}{SQUEEZED}")));
    let squeezes = |plan: &Plan| {
        let row = decisions(plan).rows.iter().find(|row| row.effect == "squeeze of blocks").unwrap();
        println!("{}: {} ({})", row.on, row.form, row.reason);
        row.on
    };
    assert!(squeezes(&Plan::of(&loaded).unwrap()));
    let mut seen = 0;
    for title in ["squeeze of blocks", "tread blocks", "tread pattern", "contact in three dimensions"] {
        for row in rows().filter(|row| row.title == title) {
            let mut without = loaded.scene.clone();
            row.switch.unwrap()(&mut without, false);
            let planned = LoadedScene::from_scene(&without, "scene").and_then(|loaded| Plan::of(&loaded));
            let plan = planned.unwrap_or_else(|error| panic!("{title}: {error}"));
            assert!(!squeezes(&plan), "{title}");
            assert!(!plan.sound().unwrap().squeezes, "{title}");
            seen += 1;
        }
    }
    assert_eq!(seen, 4);
}

#[test]
fn impossible_air_paths_are_refused_with_their_places() {
    let refusal = |text: &str| {
        let planned = Scene::from_str(text, "scene.toml").and_then(|loaded| Plan::of(&loaded));
        planned.map(|_| String::new()).unwrap_or_else(|error| error.render(false))
    };
    let with_receiver = |more: &str| format!("{GROOVE}{HEARD}{more}\n{OPEN}");
    let cases = [
        (SLICES, format!("{GROOVE}{OPEN}"), "air_pumping", "no [[receiver]]"),
        (SLICES, format!("{HEARD}{OPEN}"), "air_pumping.patch", "no grooves"),
        (SLICES, with_receiver("acoustic_gap = 0.001"), "radiation.acoustic_gap", "not by both"),
        (SLICES, format!("{GROOVE}{DRAFT}{OPEN}"), "radiation.quality", "openings of the grooves"),
        (
            "slices = \"winkler\"\ncells_across = 4\ntread = \"uncoupled\"",
            with_receiver(""),
            "contact.tread",
            "conserve volume",
        ),
        (SLICES, format!("{HEARD}{VOIDS}"), "air_pumping.patch", "slices do not resolve"),
        (SLICES, format!("{GROOVE}{HEARD}[air_pumping]\nsqueeze = true\n"), "air_pumping.squeeze", "sealed"),
        (SLICES, with_receiver("") + SQUEEZED, "air_pumping.squeeze", "slices have no compliant blocks"),
        (
            CELLS,
            format!("{GROOVE}blocks = \"continuum\"\n{HEARD}{OPEN}{SQUEEZED}"),
            "air_pumping.squeeze",
            "press no air out",
        ),
        (
            CELLS,
            with_receiver("").replace("depth = 0.008", "depth = 0.003") + SQUEEZED,
            "air_pumping.squeeze",
            "a third",
        ),
        (SLICES, "[effects]\nair_pumping = \"on\"\n".to_owned(), "effects.air_pumping", "no [air_pumping]"),
    ];
    for (contact, more, key, wrong) in cases {
        let reported = refusal(&rolled(8.0, contact, &more));
        let is_named = reported.contains(key) || key.split('.').all(|part| reported.contains(part));
        assert!(is_named && reported.contains(wrong), "{key}, {wrong}: {reported}\n{more}");
    }
    assert_eq!(refusal(&rolled(8.0, SLICES, &with_receiver(""))), "");
    assert_eq!(refusal(&rolled(8.0, CELLS, &(with_receiver("") + SQUEEZED))), "");
    // Known once the patch is: where the sheet ends the gap is 19 mm high.
    let changes = [("radiation.fmax", "4000.0"), ("numerics.elements", "1024")];
    let high = edit(&rolled(8.0, SLICES, &with_receiver("patch_length = 0.12")), &changes);
    let loaded = scene(&high);
    let plan = Plan::of(&loaded).unwrap();
    let reported = match Simulation::begin(&loaded, &plan, &Default::default()) {
        Ok(_) => String::new(),
        Err(error) => error.to_string(),
    };
    assert!(reported.contains("sixth") && reported.contains("fmax"), "{reported}");
}
