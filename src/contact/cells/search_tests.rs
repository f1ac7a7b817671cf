//! Tests of the search.

use std::collections::BTreeMap;
use std::sync::Mutex;

use proptest::prelude::*;

use super::*;
use crate::storage::state::SavedState;
use crate::test_models::cells::{RoughRoad, instant_cells, turning_cells};
use crate::tyre::influence::CellInfluence;

/// Influences by columns and cells across, summed once.
static INFLUENCES: Mutex<BTreeMap<(usize, usize, bool), CellInfluence>> = Mutex::new(BTreeMap::new());
/// Largest odd part of a wave over its even part where tyres turn: ten times what 512 elements have at 250 km/h.
const SKEW: f64 = 0.1;

fn search(columns: usize, across: usize, tolerance: f64) -> CellSearch {
    search_of(columns, across, tolerance, false)
}

fn search_of(columns: usize, across: usize, tolerance: f64, turns: bool) -> CellSearch {
    let mut known = INFLUENCES.lock().unwrap();
    let influence = known.entry((columns, across, turns)).or_insert_with(|| match turns {
        true => turning_cells(columns, across, 1024, 86e-6, SKEW),
        false => instant_cells(columns, across, 1024, 86e-6),
    });
    CellSearch::new(InstantCells::new(influence.clone()), tolerance)
}

/// Forces by least-index pivoting with dense solutions.
fn dense(cells: &InstantCells, required: &[f64]) -> Vec<f64> {
    let count = cells.cells();
    let mut active: Vec<bool> = required.iter().map(|d| *d > 0.0).collect();
    let largest = largest_or_zero(required);
    loop {
        let points: Vec<usize> = (0..count).filter(|&cell| active[cell]).collect();
        let mut matrix: Vec<Vec<f64>> =
            points.iter().map(|&a| points.iter().map(|&b| cells.entry(a, b)).collect()).collect();
        let mut values: Vec<f64> = points.iter().map(|&cell| required[cell]).collect();
        for pivot in 0..points.len() {
            let (above, below) = matrix.split_at_mut(pivot + 1);
            for (row, line) in below.iter_mut().enumerate() {
                let factor = line[pivot] / above[pivot][pivot];
                line.iter_mut().zip(&above[pivot]).skip(pivot).for_each(|(a, b)| *a -= factor * b);
                values[pivot + 1 + row] -= factor * values[pivot];
            }
        }
        for pivot in (0..points.len()).rev() {
            let known: f64 = (pivot + 1..points.len()).map(|other| matrix[pivot][other] * values[other]).sum();
            values[pivot] = (values[pivot] - known) / matrix[pivot][pivot];
        }
        let mut forces = vec![0.0; count];
        points.iter().zip(&values).for_each(|(&cell, &value)| forces[cell] = value);
        let wrong = (0..count).rev().find(|&cell| {
            let u: f64 = points.iter().map(|&other| cells.entry(cell, other) * forces[other]).sum();
            if active[cell] { forces[cell] < 0.0 } else { required[cell] - u > 1e-13 * largest }
        });
        match wrong {
            Some(cell) => active[cell] = !active[cell],
            None => return forces,
        }
    }
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |largest, value| largest.max(value.abs()))
}

fn difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |largest, (a, b)| largest.max((a - b).abs()))
}

fn assert_met(search: &mut CellSearch, required: &[f64], forces: &[f64], residuals: CellResiduals) {
    let bound = search.tolerance;
    assert!(residuals.tension <= 0.0 && residuals.penetration <= bound && residuals.complementarity <= bound);
    let scale = largest_or_zero(required);
    for (cell, (&force, &d)) in forces.iter().zip(required).enumerate() {
        let u: f64 = forces.iter().enumerate().map(|(other, force)| search.cells.entry(cell, other) * force).sum();
        assert!(force >= 0.0 && d - u <= 1.01 * bound * scale);
        assert!(force <= 0.0 || (u - d).abs() <= 1.01 * bound * scale);
        assert!((u - search.displacement()[cell]).abs() <= 1e-12 * scale);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_cells_are_solved_from_any_guess_by_either_method(
        (columns, across) in (1_usize..7, 1_usize..9),
        values in prop::collection::vec(prop_oneof![4 => -1.0..1.0, 1 => Just(f64::NEG_INFINITY)], 48),
        guess in prop::collection::vec(0.0..1e5, 48),
        turns in any::<bool>(),
    ) {
        let count = columns * across;
        let required: Vec<f64> = values[..count].iter().map(|value| 1e-3 * value).collect();
        let mut search = search_of(columns, across, 1e-10, turns);
        let expected = dense(&search.cells, &required);
        for (most, guess) in [(MOST_ITERATIONS, &[0.0; 48][..]), (MOST_ITERATIONS, &guess), (0, &guess), (1, &guess)] {
            search.most = most;
            let mut forces = guess[..count].to_vec();
            let residuals = search.solve(&required, &mut forces);
            assert_met(&mut search, &required, &forces, residuals);
            prop_assert!(difference(&forces, &expected) <= 1e-9 * largest(&expected), "{most}");
        }
    }
}

#[test]
fn hard_cases_end() {
    let (columns, across) = (6, 7);
    let count = columns * across;
    let mut only = vec![f64::NEG_INFINITY; count];
    only[17] = 1e-3;
    let mut spike = vec![-1e-5; count];
    spike[20] = 0.1;
    let mut tied = vec![1e-3; count];
    // Where one force holds up its neighbours exactly.
    let cells = search(columns, across, 1e-10).cells;
    for (cell, d) in tied.iter_mut().enumerate() {
        *d = 1e3 * cells.entry(cell, 24);
    }
    let cases =
        [only, spike, tied, vec![1e-3; count], vec![1e-12; count], (0..count).map(|n| 1e-9 * n as f64).collect()];
    for most in [MOST_ITERATIONS, 0] {
        for required in &cases {
            for guess in [0.0, 1e3, 1e30] {
                let mut search = search(columns, across, 1e-9);
                search.most = most;
                let mut forces = vec![guess; count];
                let residuals = search.solve(required, &mut forces);
                assert_met(&mut search, required, &forces, residuals);
            }
        }
    }
    let mut search = search(columns, across, 1e-9);
    for required in [vec![-1.0; count], vec![f64::NEG_INFINITY; count], vec![0.0; count]] {
        let mut forces = vec![1.0; count];
        assert_eq!(search.solve(&required, &mut forces), CellResiduals::default());
        assert!(largest(&forces) <= 0.0 && largest(search.displacement()) <= 0.0);
    }
    for wrong in [f64::NAN, f64::INFINITY] {
        let (mut required, mut forces) = (vec![1e-3; count], vec![f64::NAN; count]);
        required[3] = wrong;
        assert!(!search.solve(&required, &mut forces).penetration.is_finite());
    }
    let mut forces = vec![f64::NAN; count];
    assert!(search.solve(&vec![1e-3; count], &mut forces).penetration <= 1e-9);
}

#[test]
fn rough_roads_take_few_iterations_and_no_fallback() {
    rough_roads_roll_through(false);
    rough_roads_roll_through(true);
}

fn rough_roads_roll_through(turns: bool) {
    const INSTANTS: u64 = 20;
    let (columns, across) = (64, 60);
    let road = RoughRoad::new(1);
    let [mut rolling, mut anew] = [(); 2].map(|()| search_of(columns, across, 1e-9, turns));
    let mut forces = vec![0.0; columns * across];
    let (mut before, mut touching) = (CellCounts::default(), 0);
    for instant in 0..=INSTANTS {
        let required = road.required(columns, across, 1024, instant as usize);
        forces.copy_within(across.., 0);
        forces[(columns - 1) * across..].fill(0.0);
        let residuals = rolling.solve(&required, &mut forces);
        assert!(residuals.penetration.max(residuals.complementarity) <= 1e-9);
        if instant == 0 {
            before = rolling.counts();
        }
        touching = forces.iter().filter(|force| **force > 0.0).count();
    }
    // The skew part makes a difference.
    let mut symmetric = search(columns, across, 1e-9);
    let mut other = forces.clone();
    symmetric.solve(&road.required(columns, across, 1024, INSTANTS as usize), &mut other);
    assert_eq!(difference(&other, &forces) > 1e-3 * largest(&forces), turns);
    // The guess makes none.
    let mut other = vec![0.0; columns * across];
    anew.most = 0;
    anew.solve(&road.required(columns, across, 1024, INSTANTS as usize), &mut other);
    assert!(difference(&other, &forces) <= 1e-8 * largest(&forces));
    let counts = rolling.counts();
    println!("turns: {turns}, {touching} touch; {before:?}; {counts:?}; alone by proportioning {:?}", anew.counts());
    assert!((700..1300).contains(&touching), "{touching}");
    assert_eq!(counts.fallbacks, 0);
    assert!(counts.iterations - before.iterations <= 16 * INSTANTS, "{counts:?}");
    assert!(counts.products - before.products <= 3 * INSTANTS, "{counts:?}");
}

#[test]
fn a_skew_part_that_is_too_large_for_sweeps_is_reported() {
    let (columns, across) = (12, 8);
    let required = RoughRoad::new(1).required(columns, across, 1024, 0);
    let by_sweeps = |skew: f64| {
        let cells = InstantCells::new(turning_cells(columns, across, 1024, 86e-6, skew));
        let mut search = CellSearch::new(cells, 1e-9);
        search.most = 0;
        let mut forces = vec![0.0; columns * across];
        let residuals = search.solve(&required, &mut forces);
        let missed = residuals.penetration.max(residuals.complementarity);
        assert_eq!(search.is_unsettled(), missed > 1e-9, "{residuals:?}");
        search.is_unsettled()
    };
    assert!(!by_sweeps(0.3) && by_sweeps(5.0));
}

#[test]
fn equal_guesses_give_equal_bits_whatever_was_before() {
    let road = RoughRoad::new(2);
    let (mut one, mut other) = (search(20, 24, 1e-9), search(20, 24, 1e-9));
    let mut forces = vec![0.0; 480];
    other.solve(&road.required(20, 24, 1024, 7), &mut forces);
    let (mut a, mut b) = (vec![10.0; 480], vec![10.0; 480]);
    let required = road.required(20, 24, 1024, 3);
    one.solve(&required, &mut a);
    other.solve(&required, &mut b);
    assert!(a.iter().zip(&b).all(|(a, b)| a.to_bits() == b.to_bits()));
    SavedState::of(&mut one).unwrap().restore(&mut other).unwrap();
    assert_eq!(other.counts(), one.counts());
}

#[test]
#[ignore = "measures"]
fn time_of_rolling() {
    for (columns, across, elements) in [(64, 60, 1024), (128, 120, 2048)] {
        let influence = instant_cells(columns, across, elements, 86e-6 * 1024.0 / elements as f64);
        for radius in [1, 2, 3, 4, 6] {
            let cells = InstantCells::new(influence.clone());
            let mut search = CellSearch::new(cells, 1e-9);
            search.gradients = Gradients::new(&search.cells, radius);
            let road = RoughRoad::new(1);
            let mut forces = vec![0.0; columns * across];
            let mut best = [f64::INFINITY; 12];
            let mut before = CellCounts::default();
            for (instant, best) in best.iter_mut().enumerate() {
                let required = road.required(columns, across, elements, instant);
                forces.copy_within(across.., 0);
                forces[(columns - 1) * across..].fill(0.0);
                let guess = forces.clone();
                before = search.counts();
                search.solve(&required, &mut forces);
                let state = SavedState::of(&mut search).unwrap();
                for _ in 0..100 {
                    forces.copy_from_slice(&guess);
                    let begin = std::time::Instant::now();
                    search.solve(&required, &mut forces);
                    *best = best.min(begin.elapsed().as_secs_f64());
                }
                state.restore(&mut search).unwrap();
            }
            let counts = search.counts();
            println!(
                "{columns} x {across}, radius {radius}: last {:.0}, mean of best {:.0} us; {counts:?}, last {} {} {}",
                1e6 * best[11],
                1e6 * best[1..].iter().sum::<f64>() / 11.0,
                counts.iterations - before.iterations,
                counts.single_products - before.single_products,
                counts.products - before.products,
            );
        }
    }
}

#[test]
fn a_coarse_tolerance_takes_half_of_the_iterations() {
    let (columns, across) = (64, 30);
    let road = RoughRoad::new(5);
    let roll = |tolerance: f64| {
        let mut search = search(columns, across, tolerance);
        let mut forces = vec![0.0; columns * across];
        let mut all = Vec::new();
        for step in 0..24 {
            search.advance(across);
            assert!(forces[..across].iter().all(|force| *force <= 0.0), "the window is too short");
            forces.copy_within(across.., 0);
            forces[(columns - 1) * across..].fill(0.0);
            let required = road.required(columns, across, 1024, step);
            let residuals = search.solve(&required, &mut forces);
            assert!(residuals.penetration.max(residuals.complementarity) <= tolerance, "{step}: {residuals:?}");
            // Computed anew, in double precision: u of the forces, and the conditions that they are reported to meet.
            let mut u = vec![0.0; forces.len()];
            search.cells_mut().displacement(&forces, &mut u);
            let found = search.found.clone();
            assert!(found.len() == u.len() || search.is_single());
            assert!(
                difference(&u[found.clone()], &search.displacement()[found])
                    < 0.2 * tolerance * largest_or_zero(&required)
            );
            let touches = |cell: usize| forces[cell] > 0.0;
            let missed =
                |cell: usize| if touches(cell) { (u[cell] - required[cell]).abs() } else { required[cell] - u[cell] };
            let missed = (0..u.len()).map(missed).fold(0.0, f64::max);
            assert!(missed <= 1.2 * tolerance * largest_or_zero(&required), "{step}: {missed:e}");
            all.push(forces.clone());
        }
        (all, search.counts())
    };
    let (exact, fine) = roll(1e-10);
    let (coarse, counts) = roll(1e-5);
    println!("{fine:?}\n{counts:?}");
    let scale = exact.iter().map(|forces| largest(forces)).fold(0.0, f64::max);
    let error = exact.iter().zip(&coarse).map(|(a, b)| difference(a, b)).fold(0.0, f64::max) / scale;
    println!("forces {error:.1e}");
    assert!(error > 1e-9 && error < 1e-4, "{error:e}");
    assert!(2 * counts.iterations < fine.iterations && counts.fallbacks == 0);
    // Products over all of the window are few.
    assert!(counts.products < 3 && fine.products > 45, "{} {}", counts.products, fine.products);
}
