//! The window of cells: it holds every stone that the tyre can meet, and becomes wider where it does not.

use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use tyrewave::counters::{Stage, Watch};
use tyrewave::run::{self, Progress, RunError, RunOptions};
use tyrewave::test_models::{CIRCUMFERENCE, edit, grid_road, scene, scene_text, with_all_terms};

use crate::common::{Results, run, write_grid};

/// Elements per circumference, and of the first part of a road before anything happens.
const ELEMENTS: usize = 256;
const START: &str = "speed_kmh = 80.0\nstart = 1.0";

/// Writes a road of one column, four circumferences long, and gives its keys.
fn road(folder: &Path, elements: usize, height: impl Fn(f64) -> f64) -> String {
    let element = CIRCUMFERENCE / elements as f64;
    let heights: Vec<f64> = (0..4 * elements).map(|row| height(row as f64 * element)).collect();
    let path = folder.join("road.npy");
    write_grid(&path, 1, &heights);
    grid_road(&path, elements, 1)
}

fn on_cells(elements: usize, road: &str, rolling: &str) -> String {
    let rolling = format!("{START}\n{rolling}");
    let contact = "[contact]\nzone = \"cells\"\ncells_across = 1";
    edit(&scene_text(elements, road, &rolling, "pole_tolerance = 1e-5", contact), &[("numerics.lateral_terms", "3")])
}

fn again(results: &Results) -> u64 {
    results.summary()["cost"]["counters"]["window_edge_contacts"].as_u64().unwrap()
}

/// A stone that is higher than the tyre is pressed in touches far ahead of the patch on a smooth road.
#[test]
fn a_single_high_stone_ahead_of_the_patch_touches_cells_as_early_as_slices() {
    let folder = tempfile::tempdir().unwrap();
    let element = CIRCUMFERENCE / ELEMENTS as f64;
    let place = (1.9 / element).round() * element;
    let road = road(folder.path(), ELEMENTS, |x| if (x - place).abs() < 0.5 * element { 0.015 } else { 0.0 });
    let rolling = "warm_up = 0.02\nduration = 0.04\naxle = { indentation = 0.006, ramp = 0.01 }";
    // With all terms, since slices and cells end their sums by other numbers; a slice of a single column is level by
    // every law.
    let cells = run(&with_all_terms(&on_cells(ELEMENTS, &road, rolling)));
    let slices = scene_text(ELEMENTS, &road, &format!("{START}\n{rolling}"), "pole_tolerance = 1e-5", "");
    let slices = run(&with_all_terms(&slices));
    assert_eq!((again(&cells), again(&slices)), (0, 0));
    let (of_cells, of_slices) = (cells.array("total_force.npy"), slices.array("total_force.npy"));
    let largest = of_slices.iter().fold(0.0_f64, |largest, &force| largest.max(force));
    let smooth = of_slices[of_slices.len() / 3];
    assert!(largest > 1.5 * smooth, "the stone is not felt: {largest} of {smooth} N");
    let mut worst = 0.0_f64;
    for (step, (a, b)) in of_cells.iter().zip(&of_slices).enumerate().filter(|(_, (_, b))| **b > 0.1 * smooth) {
        worst = worst.max((a / b - 1.0).abs());
        assert!((a / b - 1.0).abs() < 0.02, "step {step}: {a} N on cells, {b} N on slices");
    }
    println!("worst step {:.2} %", 100.0 * worst);
}

const WIDENED: usize = 96;

/// The load control finds its height on a low road, which then rises: the tyre is pressed in far deeper than its load
/// would have it, and further than the window was made for, unless a stone that it never meets has made that wider.
fn rising(folder: &Path, far_stone: f64) -> String {
    let road = road(folder, WIDENED, |x| match x {
        x if x > 7.5 => far_stone,
        x => -0.06 * ((4.5 - x) / 0.8).clamp(0.0, 1.0),
    });
    on_cells(WIDENED, &road, "warm_up = 0.1\nduration = 0.1\naxle = { load = 3000.0, tolerance = 0.99 }")
}

#[test]
fn contact_at_the_end_of_the_window_is_solved_again_over_a_wider_one() {
    let folders = [0; 2].map(|_| tempfile::tempdir().unwrap());
    let narrow = run(&rising(folders[0].path(), 0.0));
    let wide = run(&rising(folders[1].path(), 0.1));
    assert_eq!(again(&wide), 0);
    assert!((1..4).contains(&again(&narrow)), "{}", again(&narrow));
    let warned = narrow.summary()["warnings"].to_string();
    assert!(warned.contains("solved again over a wider one"), "{warned}");
    let (force, expected) = (narrow.array("total_force.npy"), wide.array("total_force.npy"));
    let largest = expected.iter().fold(0.0_f64, |largest, &force| largest.max(force));
    let error = force.iter().zip(&expected).fold(0.0_f64, |worst, (a, b)| worst.max((a - b).abs())) / largest;
    // Poles of finite sums carry the past in both: what is left is the tolerance of the search.
    assert!(error < 1e-6, "{error:e} of the peak");
    // No force is lost beyond the columns that are told.
    let (_, columns, patch) = narrow.patch();
    assert!(columns < wide.patch().1);
    for (total, row) in force.iter().zip(patch.chunks_exact(columns)) {
        assert!((row.iter().sum::<f64>() - total).abs() <= 1e-9 * total.max(1.0));
    }
}

/// Stops a run once it has begun again and has come to a step.
struct StopsAt<'a> {
    stop: &'a AtomicBool,
    step: u64,
    last: u64,
    is_again: bool,
}

impl Progress for StopsAt<'_> {
    fn stage(&mut self, _stage: Stage) {}
    fn march(&mut self, _done: u64, _steps: u64, _time_step: f64) {}
    fn step(&mut self, done: u64) {
        self.is_again |= done < self.last;
        self.last = done;
        self.stop.fetch_or(self.is_again && done >= self.step, Ordering::Relaxed);
    }
    fn warning(&mut self, _: &str) {}
    fn note(&mut self, _text: &str) {}
    fn finish(&mut self) {}
}

#[test]
fn a_run_stopped_after_its_window_became_wider_goes_on_in_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let text = rising(folder.path(), 0.0);
    let whole = run(&text);
    // While the contact catches up with what is recorded, and after.
    for step in [48, 192] {
        let target = folder.path().join(format!("cut{step}"));
        let options = RunOptions { target: target.clone(), threads: 1, watch: Watch::default() };
        let stop = AtomicBool::new(false);
        let mut progress = StopsAt { stop: &stop, step, last: 0, is_again: false };
        let stopped = run::run(&scene(&text), &options, &stop, &mut progress);
        assert!(matches!(stopped, Err(RunError::Interrupted { kept: Some(_) })), "{stopped:?}");
        run::resume(&target, 1, Watch::default(), &AtomicBool::new(false), &mut run::Unwatched).unwrap();
        for name in ["total_force.npy", "patch_force.npy", "contact_area.npy", "spectra.csv"] {
            let same = fs::read(whole.path(name)).unwrap() == fs::read(target.join(name)).unwrap();
            assert!(same, "stopped at step {step}: {name} differs");
        }
    }
}
