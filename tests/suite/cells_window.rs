//! The window of cells: it holds every stone that the tyre can meet.

use std::path::Path;

use tyrewave::internals::{CIRCUMFERENCE, edit, grid_road, scene_text, with_all_terms};

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
fn a_stone_ahead_touches_cells_as_early_as_slices() {
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
