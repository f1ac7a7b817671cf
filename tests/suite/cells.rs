//! Contact over cells in three dimensions: whole runs, their limits and the hard cases.

use std::fs;
use std::time::Instant;

use tyrewave::half_space::{Extent, HeightMap, IndentationControl, IndentationLimits, indent};
use tyrewave::internals::{
    CIRCUMFERENCE, CellSearch, InstantCells, RoughRoad, add, edit, grid_road, love_displacement, scene, scene_text,
};
use tyrewave::road::{Lattice, RoadSurface};
use tyrewave::run::Simulation;
use tyrewave::scene::LoadedScene;
use tyrewave::{Plan, road};

use tyrewave::internals::CellInfluence;

use crate::common::hard_case::measured;
use crate::common::{Results, mean_and_deviation, read_array, run, write_grid};

const ROLLING: &str = "speed_kmh = 80.0\nwarm_up = 0.1\nduration = 0.1\naxle = { load = 3400.0, tolerance = 0.05 }";
const INDENTED: &str = "speed_kmh = 80.0\nwarm_up = 0.05\nduration = 0.1\naxle = { indentation = 0.01, ramp = 0.03 }";
const MADE: &str = "kind = \"made\"\nseed = 3";
const NUMERICS: &str = "pole_tolerance = 1e-4";

/// A scene of cells; its sums are short, with three waves across for each cell.
fn cells(elements: usize, across: usize, road: &str, rolling: &str, numerics: &str) -> String {
    let contact = format!("[contact]\nzone = \"cells\"\ncells_across = {across}");
    let text = scene_text(elements, road, rolling, numerics, &contact);
    edit(&text, &[("numerics.lateral_terms", &(3 * across).to_string())])
}

fn bytes(results: &Results) -> Vec<Vec<u8>> {
    ["total_force.npy", "patch_force.npy", "row_force.npy", "contact_area.npy", "peak_pressure.npy", "spectra.csv"]
        .iter()
        .map(|name| fs::read(results.path(name)).unwrap())
        .collect()
}

#[test]
fn hard_case_9_cells_on_one_and_two_threads() {
    let text = cells(96, 5, MADE, ROLLING, NUMERICS);
    let on = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| run(&text));
    let one = on(1);
    one.assert_sound("one thread");
    one.assert_window_held("one thread");
    assert!(bytes(&one) == bytes(&on(2)), "two threads give other bytes");
    measured("bytes of the results on 1 and 2 threads", "the same", "the same");
    let summary = one.summary();
    let patch = &summary["outcome"]["cells"];
    assert_eq!(patch["across"], 5);
    let (area, pressure) = (patch["mean_area"].as_f64().unwrap(), patch["mean_pressure"].as_f64().unwrap());
    assert!((2e-3..1.2e-2).contains(&area) && (2e5..2e6).contains(&pressure), "{area} m^2, {pressure} Pa");
    // Rows across add up to the total, and so do columns along.
    let total = one.array("total_force.npy");
    let (shape, rows) = read_array::<f64>(&one.path("row_force.npy"));
    assert_eq!(shape, [total.len(), 5]);
    for (total, rows) in total.iter().zip(rows.chunks_exact(5)) {
        assert!((rows.iter().sum::<f64>() - total).abs() <= 1e-9 * total.max(1.0));
    }
    for picture in ["cells_mean_pressure.svg", "cells_pressure.svg", "cells_road.svg"] {
        assert!(fs::read_to_string(one.path(picture)).unwrap().starts_with("<svg"), "{picture}");
    }
}

#[test]
fn cells_are_written_as_often_as_they_are_wanted() {
    let text = cells(64, 4, MADE, INDENTED, NUMERICS);
    let results = run(&(text + "[outputs]\ncells_every = 0.01\n"));
    let (shape, frames) = read_array::<f32>(&results.path("cells.npy"));
    let (_, times) = read_array::<f64>(&results.path("cells_time.npy"));
    let (_, columns, patch) = results.patch();
    assert_eq!(shape, [times.len(), 4 * columns]);
    assert!((14..=17).contains(&times.len()), "{} frames", times.len());
    let (step, force) = (results.report.summary.outcome.time_step, results.array("total_force.npy"));
    for (frame, time) in frames.chunks_exact(4 * columns).zip(times) {
        let row = (time / step).round() as usize;
        let total: f32 = frame.iter().sum();
        assert!((f64::from(total) - force[row]).abs() < 1e-4 * force[row].max(1.0), "{total} at {time} s");
        assert!(
            (patch[row * columns..][..columns].iter().sum::<f64>() - force[row]).abs() < 1e-9 * force[row].max(1.0)
        );
    }
}

/// A run in memory, step by step: forces of the cells at its end.
fn in_memory(loaded: &LoadedScene) -> (Vec<f64>, Vec<f64>) {
    let plan = Plan::of(loaded).unwrap();
    let mut run = Simulation::begin(loaded, &plan, &Default::default()).unwrap();
    let mut total = Vec::new();
    while let Some(step) = run.step().unwrap() {
        total.push(step.total_force);
    }
    (total, run.forces().to_vec())
}

#[test]
fn poles_are_the_finite_double_sums() {
    let rolling = "speed_kmh = 80.0\nwarm_up = 0.0\nduration = 0.05\naxle = { indentation = 0.008, ramp = 0.01 }";
    for (rule, elements_per_step) in [("bdf2", 1), ("sdirk2", 1), ("sdirk2", 2)] {
        let with = |history: &str| {
            let numerics = format!("time_rule = \"{rule}\"\nelements_per_step = {elements_per_step}\n{history}");
            let text = edit(&cells(48, 4, MADE, rolling, &numerics), &[("numerics.wavenumber_aliases", "0")]);
            in_memory(&scene(&text))
        };
        let direct = with("history = \"direct\"\nmemory = 0.06");
        let poles = with("pole_tolerance = 1e-6");
        let largest = direct.0.iter().fold(0.0_f64, |a, &b| a.max(b));
        for (kind, a, b) in [("total", &direct.0, &poles.0), ("column", &direct.1, &poles.1)] {
            let error = a.iter().zip(b).fold(0.0_f64, |worst, (a, b)| worst.max((a - b).abs())) / largest;
            println!("{rule}, {elements_per_step} elements, {kind}: {error:.1e}");
            assert!(largest > 100.0 && error < 1e-5, "{rule}, {kind}: {error:e} of the peak");
        }
    }
}

#[test]
fn a_smooth_road_gives_steady_forces_and_a_row_the_slices() {
    let smooth = cells(96, 1, "kind = \"smooth\"", INDENTED, "pole_tolerance = 1e-6");
    let one = run(&smooth);
    one.assert_sound("one row");
    let force = one.array("total_force.npy");
    let (mean, deviation) = mean_and_deviation(&force[force.len() - 100..]);
    assert!(deviation < 5e-3 * mean, "{deviation} of {mean} N");
    // A single row of cells is a slice: both count waves of odd number alone. Where sums are cut short, cells count the
    // last wave round the tyre once, slices twice: 0.34 % of the force here.
    let slices = scene_text(96, "kind = \"smooth\"", INDENTED, "pole_tolerance = 1e-6", "");
    let other = run(&edit(&slices, &[("numerics.lateral_terms", "2")]));
    let (expected, _) = mean_and_deviation(&other.array("total_force.npy")[force.len() - 100..]);
    assert!((mean / expected - 1.0).abs() < 5e-3, "{mean} and {expected} N");
}

#[test]
fn a_crown_takes_force_from_the_edges() {
    let edges = |crown: Option<f64>| {
        let mut loaded = scene(&cells(96, 8, "kind = \"smooth\"", INDENTED, NUMERICS));
        loaded.scene.tyre.crown_radius = crown;
        let text = loaded.scene.to_toml().unwrap();
        let results = run(&text);
        results.assert_sound("crown");
        let (_, rows) = read_array::<f64>(&results.path("row_force.npy"));
        let last = &rows[rows.len() - 8..];
        // Left and right are the same on a smooth road.
        assert!((0..4).all(|j| (last[j] - last[7 - j]).abs() < 1e-6 * last[0].max(last[3])), "{last:?}");
        2.0 * last[0] / last.iter().sum::<f64>()
    };
    let (level, crowned) = (edges(None), edges(Some(0.5)));
    println!("both edges of all: level {level:.2}, crowned {crowned:.2}");
    assert!(level > 0.3 && crowned < 0.95 * level, "{level} {crowned}");
}

/// Rolls over a road of one column along, the same all across; the tyre starts at 1 m.
fn over(name: &str, rolling: &str, height: impl Fn(usize) -> f64) -> Results {
    let (elements, across) = (96, 3);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("road.npy");
    let heights: Vec<f64> = (0..elements * 4).flat_map(|row| [height(row); 3]).collect();
    write_grid(&path, across, &heights);
    let rolling = format!("start = 1.0\n{rolling}");
    let results = run(&cells(elements, across, &grid_road(&path, elements, across), &rolling, NUMERICS));
    results.assert_sound(name);
    results.assert_window_held(name);
    results
}

#[test]
fn hard_case_5_in_cells_step_gap_spike_lift_off_and_one_cell() {
    let element = CIRCUMFERENCE / 96.0;
    let place = 180;
    assert!(place as f64 * element > 1.1);
    let touched = |results: &Results| results.array("contact_area.npy");
    over("step", INDENTED, |row| if row < place { 0.0 } else { 0.008 });
    over("gap", INDENTED, |row| if (place..place + 3).contains(&row) { -0.05 } else { 0.0 });
    over("spike", INDENTED, |row| if row == place { 0.02 } else { 0.0 });
    let thrown =
        over("lift-off and landing", INDENTED, |row| if (place..place + 30).contains(&row) { -0.05 } else { 0.0 });
    let area = touched(&thrown);
    assert!(area.contains(&0.0) && *area.last().unwrap() > 0.0, "it never left the ground, or stayed up");
    let barely = INDENTED.replace("0.01,", "0.00005,");
    let one = over("one column of cells", &barely, |_| 0.0);
    let cell = element * 0.12 / 3.0;
    assert!(touched(&one).last().unwrap() / cell < 4.5, "{:?}", touched(&one).last());
    // All heights alike, twice: ties.
    over("ties", INDENTED, |row| if row % 2 == 0 { 0.0 } else { -1e-4 });
}

#[test]
fn mistakes_about_cells_are_answered_with_their_keys() {
    let base = cells(64, 4, MADE, INDENTED, "");
    let answer = |text: &str| {
        let error = tyrewave::scene::Scene::from_str(text, "scene.toml").unwrap_err();
        error.render(false)
    };
    for (more, key) in [
        ("\nslices = \"winkler\"", "slices"),
        ("\nslice_coupling = \"local\"", "slice_coupling"),
        ("\ntread = \"bedding\"", "tread"),
        ("\ncell = 0.002", "cells_across"),
        ("\ncells_along = 2", "cells_along"),
        ("\ncells_across = 13", "lateral_terms"),
    ] {
        let text = match (more.strip_prefix("\ncells_across = "), more.starts_with("\n[")) {
            (Some(across), _) => answer(&edit(&base, &[("contact.cells_across", across)])),
            (None, true) => answer(&(base.clone() + more)),
            (None, false) => answer(&add(&base, "contact", more)),
        };
        assert!(text.contains(key), "{more}: {text}");
    }
    let text = answer(&scene_text(64, MADE, INDENTED, "", "[outputs]\ncells_every = 0.1\n"));
    assert!(text.contains("cells_every"), "{text}");
    let text = answer(&scene_text(64, MADE, INDENTED, "", "[contact]\ncell = 0.002\n"));
    assert!(text.contains("zone = \"cells\""), "{text}");
}

#[test]
fn plans_refuse_what_cells_cannot_do_and_nothing_else() {
    let check = |text: &str| {
        let loaded = scene(text);
        Plan::of(&loaded).unwrap().check(&loaded).map_err(|error| error.render(false))
    };
    // Sums over the stages of a step are stored as matrices.
    let direct = "history = \"direct\"\nmemory = 0.02\ntime_rule = \"sdirk2\"";
    check(&cells(64, 4, MADE, INDENTED, direct)).unwrap();
    let many = check(&cells(64, 10_000, MADE, INDENTED, "memory_limit = 0.1")).unwrap_err();
    assert!(many.contains("contact.cells_across") && many.contains("fewer cells"), "{many}");
}

#[test]
fn the_road_of_cells_is_that_of_its_lattice() {
    // The heights under a cell are those of the road at its middle: a made road with four cells across.
    let loaded = scene(&cells(64, 4, MADE, INDENTED, NUMERICS));
    let plan = Plan::of(&loaded).unwrap();
    let lattice = plan.lattice().unwrap();
    assert_eq!((lattice.columns, lattice.along), (4, 1));
    let mut road = RoadSurface::open(&loaded.scene.road, lattice, road::Limits::default()).unwrap();
    let mut heights = vec![0.0; 40];
    road.heights(0, 10, &mut heights).unwrap();
    assert!(heights.iter().any(|height| height.abs() > 1e-4));
    assert!((Lattice::across(0.12, 0.03) as f64 - 4.0).abs() < 1e-12);
}

/// A rough patch of n x n cells on a half-space, by the search over cells and by `indent`: their largest difference of
/// a force over the largest, and the time of both \[s\].
fn patch_on_a_half_space(n: usize, elements: usize) -> (f64, [f64; 2]) {
    const MODULUS: f64 = 1.25e7;
    let (dx, dy) = (CIRCUMFERENCE / elements as f64, 0.111 / n as f64);
    let required = RoughRoad::new(3).required(n, n, elements, 0);
    let unit = |i: usize, j: usize| love_displacement(i as f64 * dx, j as f64 * dy, dx, dy) / (MODULUS * dx * dy);
    let toeplitz = (0..n * n).map(|place| unit(place / n, place % n)).collect();
    let hankel = vec![0.0; n * (2 * n - 1)];
    let influence = CellInfluence { columns: n, across: n, toeplitz, hankel, odd: None };
    let mut search = CellSearch::new(InstantCells::new(influence), 1e-8);
    let mut forces = vec![0.0; n * n];
    let begin = Instant::now();
    let residuals = search.solve(&required, &mut forces);
    let of_cells = begin.elapsed().as_secs_f64();
    assert!(residuals.penetration <= 1e-8 && residuals.complementarity <= 1e-8 && search.counts().fallbacks == 0);
    // The plane at height 0: what is above it is pressed in.
    let peak = required.iter().copied().fold(f64::MIN, f64::max);
    let map = HeightMap { heights: required, extent: Extent { nx: n, ny: n }, dx, dy };
    let begin = Instant::now();
    let indented = indent(&map, MODULUS, IndentationControl::Penetration(peak), IndentationLimits::default()).unwrap();
    let times = [of_cells, begin.elapsed().as_secs_f64()];
    let largest = forces.iter().copied().fold(0.0, f64::max);
    let differences = forces.iter().zip(&indented.pressure).map(|(force, p)| (force - p * dx * dy).abs() / largest);
    (differences.fold(0.0, f64::max), times)
}

#[test]
fn cells_on_a_half_space_press_as_indent_says() {
    let (difference, _) = patch_on_a_half_space(48, 1024);
    assert!(difference < 1e-6, "{difference:e}");
}

#[test]
#[ignore = "measures"]
fn a_patch_of_512_by_512_cells_beside_indent() {
    let (difference, [of_cells, of_indent]) = patch_on_a_half_space(512, 4096);
    println!("cells {of_cells:.2} s, indent {of_indent:.2} s, difference {difference:.1e}");
    assert!(difference < 1e-6, "{difference:e}");
}
