//! Cells along an element: their positions, and their effect on slices.

use super::*;
use crate::road::slices::SliceBuilder;
use crate::scene::{AtEnd, GridRoad, MadeRoad};

fn grid(folder: &tempfile::TempDir, rows: usize, columns: usize, dx: f64, dy: f64, at_end: AtEnd) -> (Road, Vec<f64>) {
    let heights: Vec<f64> = (0..rows * columns).map(|i| 1e-3 * (i as f64 * 1.7).sin()).collect();
    let bytes = npy(&[rows as u64, columns as u64], npyz::Order::C, heights.iter().copied());
    let file = write(folder, "grid.npy", &bytes);
    (Road::Grid(GridRoad { at_end, ..super::measured::grid(file, dx, dy) }), heights)
}

#[test]
fn cells_of_an_element_lie_round_its_middle() {
    for along in 1..6 {
        let lattice = Lattice { dx: 0.0071, along, dy: 0.002, columns: 3 };
        for element in [-3_i64, 0, 7] {
            let rows = element * along as i64..(element + 1) * along as i64;
            let middle = rows.clone().map(|row| lattice.place(row, 1.0)).sum::<f64>() / along as f64;
            assert!((middle - element as f64 * lattice.dx).abs() < 1e-16, "{along} cells: {middle}");
            let first = lattice.place(rows.start, 1.0) - 0.5 * lattice.cell();
            assert!((first - (element as f64 - 0.5) * lattice.dx).abs() < 1e-16, "{along} cells fill their element");
        }
    }
}

#[test]
fn cells_are_about_two_millimetres_unless_the_scene_says_so() {
    let made = Road::Made(MadeRoad::default());
    let of = |dx: f64, across, along| Lattice::choose(&made, dx, 0.12, across, along).unwrap();
    for (dx, along) in [(0.0019, 1), (0.002, 1), (3.0 * 0.002, 3), (0.0061, 4)] {
        assert_eq!((of(dx, None, None).along, of(dx, None, None).columns), (along, 60), "{dx} m");
    }
    let given = of(0.0061, Some(7), Some(2));
    assert_eq!((given.along, given.columns, given.cells()), (2, 7, 14));
    assert!(matches!(
        Lattice::choose(&made, 0.004, 0.12, None, Some(0)),
        Err(RoadError::NotPositive { key: "contact.cells_along", .. })
    ));
    let smooth = Lattice::choose(&Road::Smooth, 0.0061, 0.12, None, None).unwrap();
    assert_eq!(smooth.cells(), 1);
}

#[test]
fn an_odd_number_of_rows_on_an_element_is_used_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let (spec, heights) = grid(&folder, 30, 4, 0.0015, 0.03, AtEnd::Repeat);
    let lattice = Lattice::choose(&spec, 0.0045, 0.12, None, None).unwrap();
    assert_eq!((lattice.along, lattice.columns), (3, 4));
    let mut road = open(&spec, lattice);
    assert_eq!(road.period(), Some(10));
    // Element 0 is centred on the map's row 0, so its first row is the map's last.
    let found = rows(&mut road, 0, 10);
    let expected = heights[29 * 4..].iter().chain(&heights[..29 * 4]);
    assert!(found.iter().zip(expected).all(|(a, b)| a.to_bits() == b.to_bits()));
    // The rows of two elements do not divide the map's: the road repeats after the least common multiple of both.
    let other = Lattice { dx: 7.0 * 0.0015, along: 7, ..lattice };
    let mut road = open(&spec, other);
    assert_eq!(road.period(), Some(30));
    let (first, later) = (rows(&mut road, -2, 4), rows(&mut road, 28, 4));
    assert!(first.iter().zip(&later).all(|(a, b)| a.to_bits() == b.to_bits()));
    // An even number lies on both sides of the element's middle: resampled.
    let even = Lattice::choose(&spec, 0.003, 0.12, None, None).unwrap();
    assert_eq!((even.along, open(&spec, even).period()), (2, None));
}

/// A step of 1 mm under the middle of an element: half of the area touches 1 mm later, whatever the number of cells.
#[test]
fn a_step_across_has_an_area_curve() {
    let along = 8;
    let heights: Vec<f64> = (0..along).map(|row| if row < along / 2 { 0.0 } else { -1e-3 }).collect();
    let curve = SliceBuilder::winkler(1).unwrap().with_lines(along).unwrap().build_rows(&heights).unwrap().remove(0);
    assert!((curve.displacement_at(1e-3) - 0.5e-3).abs() < 1e-18);
    assert!((curve.displacement_at(3e-3) - 2.5e-3).abs() < 1e-17);
}

/// Both laws must have a limit for short cells. S is evaluated where the flat tread is 1 mm below the road's mean: past
/// the highest cell, which is higher with more cells, S would converge more slowly.
#[test]
fn slices_converge_with_cells_along() {
    let spec = Road::Made(MadeRoad { seed: 8, ..MadeRoad::default() });
    let mean = |along: usize, half_space: bool| {
        let lattice = Lattice { dx: 0.0076, along, dy: 0.002, columns: 60 };
        let heights = rows(&mut open(&spec, lattice), 0, 150);
        let builder = if half_space {
            SliceBuilder::half_space(60, slices::CELL_LENGTH, 0.002).unwrap()
        } else {
            SliceBuilder::winkler(60).unwrap()
        };
        let curves = builder.with_lines(along).unwrap().build_rows(&heights).unwrap();
        curves.iter().map(|curve| curve.displacement_at(curve.peak + 1e-3)).sum::<f64>() / 150.0
    };
    for half_space in [false, true] {
        let found = [1, 2, 4, 8].map(|along| mean(along, half_space));
        println!("half-space {half_space}: mean S with 1, 2, 4, 8 cells along {found:?}");
        let steps = [0, 1, 2].map(|i| (found[i + 1] - found[i]).abs());
        assert!(steps[2] < 0.5 * steps[0] && steps[2] < 0.01 * found[3], "{found:?}");
    }
}
