//! Vibration of whole runs: against the time domain, its energy, and that it costs nothing where it is not wanted.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a failing test may panic, in its helpers, too")]

mod common;

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::fs;
use std::sync::atomic::AtomicBool;

use common::{Results, read_array, run, scene, scene_text};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use realfft::RealFftPlanner;
use serde_json::Value;
use tyrewave::contact::history::{ModalHistory, PastForces};
use tyrewave::contact::slice_queue::SliceQueue;
use tyrewave::meter::{Counter, Meter, Stage};
use tyrewave::pipeline::Plan;
use tyrewave::pipeline::past::{fetch, fit_options};
use tyrewave::pipeline::prepare::prepare;
use tyrewave::response::vibration::{
    SegmentLayout, TransferKind, TyreResponse, VelocityTable, VibrationAccumulator, VibrationField, point_spectrum,
};
use tyrewave::response::{PowerSpectrum, ThirdOctaveBand};
use tyrewave::road::slices::StiffnessCurve;
use tyrewave::scene::TimeRule;
use tyrewave::tyre::influence::Field;

const SPEED: f64 = 80.0 / 3.6;

fn rolling(duration: f64) -> String {
    format!("speed_kmh = 80.0\nwarm_up = 0.3\nduration = {duration:?}\naxle = {{ load = 3000.0 }}")
}

const ROUGH: &str = "kind = \"made\"\nseed = 4";

fn numerics(substeps: u32, more: &str) -> String {
    format!("history = \"modal\"\nsubsteps = {substeps}\npole_tolerance = 1e-4\n{more}")
}

fn vibration(keys: &str) -> String {
    format!("[outputs]\nplots = true\n[outputs.vibration]\n{keys}\n")
}

/// Mean squares of `vibration.csv` by field, frame, place and band: a position, or `element` and its number.
fn levels(results: &Results) -> BTreeMap<(String, String, String), Vec<(ThirdOctaveBand, f64)>> {
    let mut reader = csv::Reader::from_path(results.path("vibration.csv")).unwrap();
    let mut all: BTreeMap<_, Vec<_>> = BTreeMap::new();
    for row in reader.records() {
        let row = row.unwrap();
        let band = ThirdOctaveBand::containing(row[5].parse().unwrap()).unwrap();
        let place = if row[3].is_empty() { row[2].to_owned() } else { format!("element {}", &row[3]) };
        let key = (row[0].to_owned(), row[1].to_owned(), place);
        all.entry(key).or_default().push((band, row[6].parse().unwrap()));
    }
    all
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

#[test]
fn levels_are_those_of_elements_followed_in_the_time_domain() {
    // What is left is the window, which blurs forces here and velocities there, and falls with the square of its length: measured 0.18 dB at 0.5 s, in the band of the first resonance.
    for (segment, bound) in [(0.5, 0.25), (2.0, 0.05)] {
        let largest = largest_difference(segment);
        assert!(largest < bound, "segments of {segment} s: {largest} dB");
    }
}

/// Largest difference of the third octaves from 40 Hz to 1 kHz from those of elements followed in the time domain \[dB\].
fn largest_difference(segment: f64) -> f64 {
    // Eight seconds, 5837 samples a second; the recursion of the run once more over its forces.
    let (elements, substeps) = (128, 4);
    let text = scene_text(
        elements,
        ROUGH,
        &rolling(8.0),
        &numerics(substeps as u32, ""),
        &vibration(&format!("segment = {segment:?}")),
    );
    let results = run(&text);
    let loaded = scene(&text);
    let options = fit_options(&loaded.scene, Field::Surface);
    let model = fetch(&loaded.scene.tyre, &options, &AtomicBool::new(false)).unwrap().model;
    let step = common::CIRCUMFERENCE / (elements * substeps) as f64 / SPEED;
    let rule = loaded.scene.numerics.time_rule;
    let mut history = ModalHistory::new(&model, Field::Surface, rule, step).unwrap();
    let first_weights = ModalHistory::first_weights(&model, Field::Surface, rule, step).unwrap();
    let instant = tyrewave::numeric::Ring::new(elements).elements_of(|n| first_weights[n]).to_vec();
    let (rows, columns, forces) = results.patch();
    let first = results.elements();
    let mut tracks = vec![Vec::with_capacity(rows); elements];
    for (row, &first) in forces.chunks_exact(columns).zip(&first) {
        let mut all = vec![0.0; elements];
        history.displacement(0, &mut all);
        for (column, force) in row.iter().enumerate().filter(|(_, force)| **force != 0.0) {
            for (element, value) in all.iter_mut().enumerate() {
                *value +=
                    instant[(element as i64 - first - column as i64).rem_euclid(elements as i64) as usize] * force;
            }
        }
        history.push(first, row);
        tracks.iter_mut().zip(all).for_each(|(track, value)| track.push(value));
    }
    let warm_up = (0.3 / step).round() as usize;
    let velocities: Vec<Vec<f64>> = tracks
        .iter()
        .map(|track| {
            (warm_up..rows).map(|l| (1.5 * track[l] - 2.0 * track[l - 1] + 0.5 * track[l - 2]) / step).collect()
        })
        .collect();
    // The pattern that stands over the road, seen by each element at its place: lines whose leakage would hide the rest.
    let places = elements * substeps;
    let place = |element: usize, l: usize| (element * substeps + places - l % places) % places;
    let mut pattern = vec![[0.0; 2]; places];
    for (element, velocity) in velocities.iter().enumerate() {
        for (l, value) in velocity.iter().enumerate() {
            let sum = &mut pattern[place(element, l)];
            *sum = [sum[0] + value, sum[1] + 1.0];
        }
    }
    let of_vibration = &results.summary()["vibration"];
    let segments = of_vibration["segments"].as_u64().unwrap() as usize;
    let length = of_vibration["revolutions"].as_u64().unwrap() as usize * places;
    let transform = RealFftPlanner::<f64>::new().plan_fft_forward(length);
    let (mut bins, mut power) = (transform.make_output_vec(), vec![0.0; length / 2 + 1]);
    for (element, velocity) in velocities.iter().enumerate() {
        let varying = velocity.iter().enumerate().map(|(l, value)| {
            let [sum, count] = pattern[place(element, l)];
            value - sum / count
        });
        let velocity: Vec<f64> = varying.collect();
        // The same segments and window, over the velocities instead of the forces.
        for segment in 0..segments {
            let part = &velocity[segment * length / 2..][..length];
            let window = |l: usize| (PI * (l as f64 + 0.5) / length as f64).sin();
            let mut series: Vec<f64> = part.iter().enumerate().map(|(l, value)| window(l) * value).collect();
            transform.process(&mut series, &mut bins).unwrap();
            for (k, (sum, bin)) in power.iter_mut().zip(&bins).enumerate() {
                let sides = if k == 0 || 2 * k == length { 1.0 } else { 2.0 };
                *sum += sides * bin.norm_sqr() * 2.0 / (length * length * segments * elements) as f64;
            }
        }
    }
    let spectrum = PowerSpectrum { mean: 0.0, resolution: 1.0 / (length as f64 * step), power, nyquist: 0.5 / step };
    let sums: BTreeMap<ThirdOctaveBand, f64> =
        spectrum.third_octaves(20.0, 1.0).into_iter().map(|level| (level.band, level.mean_square)).collect();
    let found = levels(&results);
    let found = &found[&("tread".to_owned(), "material-varying".to_owned(), String::new())];
    let mut largest = 0.0_f64;
    for &(band, mean_square) in found {
        let difference = 10.0 * (mean_square / sums[&band]).log10();
        println!("{segment} s, {:>6} Hz: {difference:+.3} dB", band.label());
        if (39.0..1001.0).contains(&band.mid_frequency()) {
            largest = largest.max(difference.abs());
        }
    }
    largest
}

#[test]
fn what_the_forces_put_in_is_dissipated() {
    for (name, road, rule, tread, bound) in [
        ("smooth", "kind = \"smooth\"", "bdf2", "elastic", 1e-5),
        ("rough", ROUGH, "bdf2", "elastic", 3e-4),
        ("rough", ROUGH, "bdf1", "elastic", 3e-4),
        ("rough", ROUGH, "bdf2", "bedding", 3e-4),
    ] {
        let more = format!("[contact]\ntread = \"{tread}\"\n{}", vibration("segment = 0.4"));
        let text = scene_text(128, road, &rolling(2.5), &numerics(1, &format!("time_rule = \"{rule}\"")), &more);
        // The carcass under the springs has sharper resonances at its shortest waves.
        let text =
            if tread == "bedding" { text.replace("pole_tolerance = 1e-4", "pole_tolerance = 1e-3") } else { text };
        let results = run(&text);
        results.assert_sound(name);
        let summary = results.summary();
        let power = &summary["vibration"]["power"];
        println!("{name}, {rule}, {tread}: {power}");
        let difference = number(&power["relative_difference"]);
        assert!(number(&power["put_in"]) > 0.0, "{name}, {rule}: a tyre that drives itself");
        assert!(difference.abs() < bound, "{name}, {rule}, {tread}: {difference}");
    }
}

#[test]
fn frames_points_and_maps_are_written_as_they_are_wanted() {
    let keys = "tangential = true\nmap = true\npoints = [0.0, -0.1, 0.975]\nelements = [95, 0]\nsegment = 0.3";
    let text = scene_text(96, ROUGH, &rolling(1.3), &numerics(1, ""), &vibration(keys));
    let results = run(&text);
    let summary = results.summary();
    let all = levels(&results);
    assert_eq!(all.len(), 3 * (3 + 3 + 2 * 2), "{:?}", all.keys());
    let sum = |field: &str, frame: &str, position: &str| -> f64 {
        all[&(field.to_owned(), frame.to_owned(), position.to_owned())].iter().map(|(_, square)| square).sum()
    };
    for (index, field) in ["tread", "belt", "tangential"].into_iter().enumerate() {
        let of_field = &summary["vibration"]["fields"][index];
        assert_eq!(of_field["field"], field);
        let total = number(&of_field["rms_velocity"]).powi(2);
        let bands = sum(field, "non-rotating", "");
        // All bands but what lies below 18 Hz and above the last whole one.
        assert!(bands <= total * (1.0 + 1e-12) && bands > 0.7 * total, "{field}: {bands} of {total}");
        for element in ["element 0", "element 95"] {
            // Every element has been over the same road: nearly the mean, and the same lines of the mean pattern.
            let varying = sum(field, "material-varying", element);
            assert!(
                (varying / sum(field, "material-varying", "")).log10().abs() < 0.2,
                "{field}, {element}: {varying}"
            );
            let lines = |place: &str| sum(field, "material", place) - sum(field, "material-varying", place);
            assert!((lines(element) / lines("") - 1.0).abs() < 1e-9, "{field}, {element}");
        }
        for frame in ["material", "non-rotating"] {
            let (shape, density) = read_array::<f64>(&results.path(&format!("vibration_map_{field}_{frame}.npy")));
            let frequencies = results.array("vibration_map_frequency.npy");
            assert_eq!(shape, [frequencies.len(), 97]);
            let width = frequencies[1] - frequencies[0];
            let power = density.iter().sum::<f64>() * width;
            assert!((power / total - 1.0).abs() < 1e-9, "{field}, {frame}: {power} of {total}");
            assert!(
                fs::read_to_string(results.path(&format!("vibration_map_{field}_{frame}.svg")))
                    .unwrap()
                    .contains("svg")
            );
        }
    }
    assert!((results.array("vibration_map_wavenumber.npy")[0] + 48.0).abs() < 1e-12);
    let [error, omitted] = [0, 1].map(|index| number(&summary["vibration"]["tangential_error"][index]));
    assert!(error < 0.02 && omitted < 0.02, "{error} {omitted}");
    assert!(number(&summary["vibration"]["seconds_left_out"]) < 0.3);
    assert!(results.path("vibration_elements_belt.svg").exists());
    assert!(results.path("vibration_spectrum.svg").exists() && results.path("vibration_narrow.csv").exists());
}

#[test]
fn what_is_not_wanted_costs_nothing() {
    let text = scene_text(64, "kind = \"smooth\"", &rolling(0.3), &numerics(1, ""), "");
    let results = run(&text);
    assert!(results.summary().get("vibration").is_none());
    let meter = &results.report.meter;
    assert_eq!(meter.cost(Stage::Vibration).calls, 0);
    for counter in [Counter::VibrationTransforms, Counter::VibrationEvaluations] {
        assert_eq!(meter.counted(counter), 0, "{counter:?}");
    }
    let files = fs::read_dir(results.folder.path().join("run")).unwrap();
    let names: Vec<String> = files.map(|file| file.unwrap().file_name().into_string().unwrap()).collect();
    assert!(!names.iter().any(|name| name.contains("vibration")), "{names:?}");
    let wanted = format!("{text}{}", vibration("belt = false"));
    let with = run(&wanted);
    for name in ["total_force.npy", "patch_force.npy"] {
        assert!(
            fs::read(results.path(name)).unwrap() == fs::read(with.path(name)).unwrap(),
            "{name}: looking on changes nothing"
        );
    }
    assert!(with.report.meter.counted(Counter::VibrationTransforms) > 0);
}

#[test]
fn a_run_shorter_than_a_revolution_says_so() {
    let text = scene_text(64, "kind = \"smooth\"", &rolling(0.05), &numerics(1, ""), &vibration(""));
    let results = run(&text);
    let warnings = results.summary()["warnings"].to_string();
    assert!(warnings.contains("too short for vibration: it needs a revolution, 0.09 s"), "{warnings}");
    assert!(!results.path("vibration.csv").exists());
}

#[test]
fn the_same_bytes_on_any_number_of_threads() {
    let keys = vibration("points = [0.05]\nelements = [40]\nsegment = 0.2");
    let text = scene_text(128, ROUGH, &rolling(0.7), &numerics(2, ""), &keys);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let results = pool.install(|| run(&text));
        ["vibration.csv", "vibration_narrow.csv"].map(|name| fs::read(results.path(name)).unwrap())
    };
    let one = on(1);
    assert!(one == on(2) && one == on(3));
}

#[test]
fn the_sum_over_the_past_gives_the_same_levels_as_the_poles() {
    let keys = vibration("segment = 0.3");
    let text = |history: &str| {
        let numerics = format!("history = \"{history}\"\nmemory = 0.7\npole_tolerance = 1e-5");
        // All terms: the direct sum then has the influence functions of the model.
        let text = scene_text(64, "kind = \"smooth\"", &rolling(0.8), &numerics, &keys);
        text.replace("lateral_terms = 4\nwavenumber_aliases = 2\n", "")
    };
    let [direct, modal] = ["direct", "modal"].map(|history| levels(&run(&text(history))));
    let key = ("tread".to_owned(), "material".to_owned(), String::new());
    for (one, other) in direct[&key].iter().zip(&modal[&key]) {
        let difference = 10.0 * (one.1 / other.1).log10();
        assert!(difference.abs() < 0.1, "{}: {difference} dB", one.0.label());
    }
}

/// Rough slices rolled over with one step an element; largest difference of the third octaves from 40 Hz to `highest` \[Hz\], in dB, at points beside the axle from the velocities of the elements that
/// pass them as the contact itself has them: in the order of `kinds`.
fn differences_at_points(rule: TimeRule, highest: f64, kinds: [TransferKind; 2]) -> [f64; 2] {
    let elements = 256;
    let rolling = "speed_kmh = 80.0\nwarm_up = 0.0\nduration = 5.0\naxle = { indentation = 0.014, ramp = 0.1 }";
    let loaded = scene(&scene_text(
        elements,
        "kind = \"smooth\"",
        rolling,
        &numerics(1, &format!("time_rule = \"{}\"", rule.name())),
        "",
    ));
    let plan = Plan::new(&loaded.scene);
    let (stop, mut meter) = (AtomicBool::new(false), Meter::default());
    let mut prepared = prepare(&loaded, &plan, &stop, &mut meter).unwrap();
    let model = fetch(&loaded.scene.tyre, &fit_options(&loaded.scene, Field::Surface), &stop).unwrap().model;
    let march = &mut prepared.march;
    let geometry = march.geometry();
    let (columns, first, element) = (geometry.columns, geometry.first_element(0), geometry.element);
    let (position, step) = (geometry.position(first, 0), plan.time_step);
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let mut slices = SliceQueue::starting_at(first);
    let peaks = (0..plan.steps + columns as u64).map(|_| StiffnessCurve::flat(random.random_range(-5e-4..0.0)));
    slices.extend(peaks);

    let layout = SegmentLayout {
        elements,
        substeps: 1,
        revolutions: 12,
        columns,
        time_step: step,
        phase: 0,
        first_position: position,
        circumference: common::CIRCUMFERENCE,
    };
    // Before the patch and behind it. Within it the road holds the tread: velocities are some 26 dB less, what the forces' shares leave of each other, and blurred forces leave more.
    let places = [columns - 4, 2];
    let response = TyreResponse { model: &model, scale: 1.0, spring: 0.0, tangential: None };
    let mut accumulators = kinds.map(|kind| {
        let mut accumulator = VibrationAccumulator::new(layout);
        // A difference over a step is the velocity in its middle, where the element stands half of one further on.
        let shift = if rule.is_multistep() { 0.0 } else { 0.5 };
        let positions = places.map(|column| position + (column as f64 + shift) * element);
        let table = VelocityTable::new(&layout, &response, kind, VibrationField::Tread).unwrap();
        table.add_points(&mut accumulator, &positions);
        accumulator
    });
    let settled = (0.5 / step) as usize;
    let mut earlier = [vec![0.0; columns], vec![0.0; columns]];
    let mut now = vec![0.0; columns];
    let mut velocities = vec![Vec::new(); places.len()];
    for l in 0..plan.steps as usize {
        march.step(&prepared.axle, &slices).unwrap();
        march.displacements(&mut now);
        if l >= settled {
            accumulators.iter_mut().for_each(|accumulator| {
                accumulator.push(march.forces(), 0.0);
            });
            for (column, series) in places.iter().zip(&mut velocities) {
                let [one, two] = [earlier[0][column + 1], earlier[1][column + 2]];
                series.push(match rule {
                    TimeRule::Bdf2 => (1.5 * now[*column] - 2.0 * one + 0.5 * two) / step,
                    _ => (now[*column] - one) / step,
                });
            }
        }
        earlier.swap(0, 1);
        earlier[0].copy_from_slice(&now);
    }
    let mut largest = [0.0_f64; 2];
    for (point, velocity) in velocities.iter().enumerate() {
        let exact = welch(velocity, layout.length(), step).third_octaves(40.0, 1.0);
        for (accumulator, largest) in accumulators.iter().zip(&mut largest) {
            let found = point_spectrum(&accumulator.finish().unwrap(), point).third_octaves(40.0, 1.0);
            for (one, other) in found.iter().zip(&exact).filter(|(one, _)| one.band.mid_frequency() < highest) {
                let difference = one.level - other.level;
                println!("{rule:?}, column {}, {:>6} Hz: {difference:+.3} dB", places[point], one.band.label());
                *largest = largest.max(difference.abs());
            }
        }
    }
    largest
}

/// Mean spectrum of half overlapping segments with the sine window, the mean taken off.
fn welch(series: &[f64], length: usize, step: f64) -> PowerSpectrum {
    let segments = 2 * series.len() / length - 1;
    let used = &series[..(segments + 1) * length / 2];
    let mean = used.iter().sum::<f64>() / used.len() as f64;
    let transform = RealFftPlanner::<f64>::new().plan_fft_forward(length);
    let (mut bins, mut power) = (transform.make_output_vec(), vec![0.0; length / 2 + 1]);
    for segment in 0..segments {
        let part = &used[segment * length / 2..][..length];
        let window = |l: usize| (PI * (l as f64 + 0.5) / length as f64).sin();
        let mut weighted: Vec<f64> = part.iter().enumerate().map(|(l, value)| window(l) * (value - mean)).collect();
        transform.process(&mut weighted, &mut bins).unwrap();
        for (k, (sum, bin)) in power.iter_mut().zip(&bins).enumerate() {
            let sides = if k == 0 || 2 * k == length { 1.0 } else { 2.0 };
            *sum += sides * bin.norm_sqr() * 2.0 / (length * length * segments) as f64;
        }
    }
    PowerSpectrum { mean: 0.0, resolution: 1.0 / (length as f64 * step), power, nyquist: 0.5 / step }
}

#[test]
fn points_have_the_velocities_of_the_elements_that_pass_them_with_every_rule() {
    // One number stands for all that a multistep rule does, and only the window is left. A rule of several stages has more, and forces within a step of which only the mean is known.
    let cases = [(TimeRule::Bdf2, 1100.0, 0.1), (TimeRule::Sdirk2, 700.0, 1.5), (TimeRule::Sdirk3, 700.0, 1.5)];
    let found = cases.map(|(rule, highest, bound)| {
        let [by_rule, exact] = differences_at_points(rule, highest, [TransferKind::Rule(rule), TransferKind::Exact]);
        println!("{rule:?} to {highest} Hz: {by_rule} dB, i w {exact} dB");
        (rule, by_rule, exact, bound)
    });
    for (rule, by_rule, exact, bound) in found {
        assert!(by_rule < bound, "{rule:?}: {by_rule} dB");
        assert!(by_rule < exact, "{rule:?}: {by_rule} dB, i w {exact} dB");
    }
}
