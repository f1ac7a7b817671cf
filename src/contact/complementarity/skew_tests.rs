//! Tests of G0 with a skew part, against dense matrices.

use proptest::prelude::*;

use super::*;
use crate::counters::Meter;
use crate::numeric::Ring;
use crate::storage::state::SavedState;

/// Elements of the ring from which rows are taken.
pub(super) const RING: usize = 64;

/// Symmetric and skew part of a row by distance, of waves with O_n = `skew` E_n times numbers up to 1.
pub(super) fn rows(softness: f64, skew: f64, shares: &[f64]) -> [Vec<f64>; 2] {
    let even = |n: usize| (softness + (1.0 + n as f64 / 6.0).powi(-2)) / RING as f64;
    let mut ring = Ring::new(RING);
    let row = ring.elements_of(even).to_vec();
    [row, ring.odd_elements_of(|n| skew * shares[n % shares.len()] * even(n)).to_vec()]
}

/// G0 from `point` to `column`.
pub(super) fn entry([even, odd]: &[Vec<f64>; 2], column: usize, point: usize) -> f64 {
    let distance = (RING + column - point) % RING;
    even[distance] + odd[distance]
}

/// Solution of a dense system, with exchange of rows.
fn solved(mut matrix: Vec<Vec<f64>>, mut right: Vec<f64>) -> Vec<f64> {
    let size = right.len();
    for step in 0..size {
        let pivot = (step..size).max_by(|&i, &j| matrix[i][step].abs().total_cmp(&matrix[j][step].abs())).unwrap();
        matrix.swap(step, pivot);
        right.swap(step, pivot);
        for row in step + 1..size {
            let factor = matrix[row][step] / matrix[step][step];
            let above = matrix[step].clone();
            for (value, above) in matrix[row].iter_mut().zip(&above).skip(step) {
                *value -= factor * above;
            }
            right[row] -= factor * right[step];
        }
    }
    for step in (0..size).rev() {
        let known: f64 = (step + 1..size).map(|column| matrix[step][column] * right[column]).sum();
        right[step] = (right[step] - known) / matrix[step][step];
    }
    right
}

/// Reference: forces of every set that meets all conditions.
fn solutions(rows: &[Vec<f64>; 2], d: &[f64]) -> Vec<Vec<f64>> {
    let all = (0..1_u32 << d.len()).filter_map(|set| {
        let points: Vec<usize> = (0..d.len()).filter(|&column| set >> column & 1 == 1).collect();
        let matrix = points.iter().map(|&i| points.iter().map(|&j| entry(rows, i, j)).collect()).collect();
        let found = solved(matrix, points.iter().map(|&point| d[point]).collect());
        let mut forces = vec![0.0; d.len()];
        points.iter().zip(&found).for_each(|(&point, &force)| forces[point] = force);
        let lifted = |i: usize| forces.iter().enumerate().map(|(j, force)| entry(rows, i, j) * force).sum::<f64>();
        let off = |i: usize| points.contains(&i) || lifted(i) >= d[i];
        (found.iter().all(|force| *force > 0.0) && (0..d.len()).all(off)).then_some(forces)
    });
    all.collect()
}

fn shares() -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(-1.0..1.0_f64, RING / 2 + 1)
}

const POINTS: usize = 9;

proptest! {
    #[test]
    fn the_one_solution_of_an_unsymmetric_problem_is_found(
        d in prop::collection::vec(-1.0..1.0_f64, POINTS),
        start in prop::collection::vec(0.0..5.0_f64, POINTS),
        softness in 0.01..0.5_f64,
        skew in prop_oneof![Just(0.004), Just(0.02), Just(0.24)],
        shares in shares(),
    ) {
        let rows = rows(softness, skew, &shares);
        let exact = solutions(&rows, &d);
        prop_assert_eq!(exact.len(), 1, "exactly one");
        let [even, odd] = &rows;
        let mut search = ActiveSet::new(even.clone(), POINTS, 1e-12, 64).with_skew(odd);
        search.start_from(&start);
        let mut forces = vec![0.0; POINTS];
        let residuals = search.search(&d, &mut forces, &mut Meter::default()).unwrap();
        prop_assert!(residuals.tension <= 0.0 && residuals.penetration < 1e-12 && residuals.complementarity < 1e-10);
        for (i, (force, exact)) in forces.iter().zip(&exact[0]).enumerate() {
            prop_assert!((force - exact).abs() < 1e-9 * (1.0 + exact.abs()), "{}: {} {}", i, force, exact);
            // Displacements are those of the whole G0, from which power is computed.
            let lifted: f64 = forces.iter().enumerate().map(|(j, force)| entry(&rows, i, j) * force).sum();
            prop_assert!((search.displacement()[i] - lifted).abs() < 1e-12 * (1.0 + lifted.abs()));
        }
    }
}

/// Requirements of a rough patch that moves by an element every other instant.
fn rough(columns: usize, instant: usize) -> Vec<f64> {
    let from_middle = |column: usize| (column as f64 + 0.5 * (instant % 2) as f64 - 0.5 * columns as f64).abs();
    let stone = |element: usize| 0.15 * (element as f64 * 2.3).sin() + 0.1 * (element as f64 * 0.9 + 1.0).cos();
    (0..columns).map(|c| 1.0 - (3.0 * from_middle(c) / columns as f64).powi(2) + stone(c + instant / 2)).collect()
}

#[test]
fn corrections_are_few_and_none_for_a_symmetric_problem() {
    const COLUMNS: usize = 40;
    let shares: Vec<f64> = (0..=RING / 2).map(|n| (n as f64 * 0.7).sin()).collect();
    // As many corrections as ln 1e-13/ln skew, and those of exchanged sets.
    for (skew, most) in [(0.0, 1.6), (0.004, 7.0), (0.02, 9.5), (0.24, 25.0)] {
        let [even, odd] = rows(0.05, skew, &shares);
        let odd = if skew == 0.0 { Vec::new() } else { odd };
        let mut search = ActiveSet::new(even.clone(), COLUMNS, 1e-12, 64).with_skew(&odd);
        let (mut forces, mut instants) = (vec![0.0; COLUMNS], 0);
        for instant in 0..60 {
            search.advance(usize::from(instant > 0 && instant % 2 == 0));
            let residuals = search.search(&rough(COLUMNS, instant), &mut forces, &mut Meter::default()).unwrap();
            assert!(residuals.tension <= 0.0 && residuals.penetration < 1e-12, "{skew}: {residuals:?}");
            instants += 1;
        }
        let counts = search.counts();
        let solves = counts.solves as f64 / f64::from(instants);
        println!("skew {skew}: {solves:.2} solves an instant, {:?}", counts.factors);
        assert!(solves < most && counts.fallbacks == 0, "{skew}: {solves}");
        // A correction looks for no factor.
        assert!(counts.factors.hits + counts.factors.misses <= 2 * instants as u64, "{skew}: {counts:?}");
    }
}

#[test]
fn a_tolerance_below_rounding_ends_at_rounding() {
    // Nearly singular: a smooth row on a fine grid.
    const COLUMNS: usize = 40;
    let shares: Vec<f64> = (0..=RING / 2).map(|n| (n as f64 * 1.3).cos()).collect();
    let even = |n: usize| (1e-9 + (-(n as f64) / 3.0).exp()) / RING as f64;
    let mut ring = Ring::new(RING);
    let row = ring.elements_of(even).to_vec();
    let odd = ring.odd_elements_of(|n| 0.2 * shares[n] * even(n)).to_vec();
    let mut search = ActiveSet::new(row, COLUMNS, 1e-15, 16).with_skew(&odd);
    let mut forces = vec![0.0; COLUMNS];
    for round in 0..50 {
        let d: Vec<f64> =
            (0..COLUMNS).map(|i| if (i + round) % 7 < 3 { 1.0 } else { 1.0 - 1e-14 * (i % 3) as f64 }).collect();
        match search.search(&d, &mut forces, &mut Meter::default()) {
            Ok(residuals) => assert!(residuals.tension <= 0.0 && residuals.penetration < 1e-12, "{residuals:?}"),
            Err(unsolved) => assert_eq!(unsolved, super::residue::Unsolved::Unsettled),
        }
    }
}

#[test]
fn a_restored_unsymmetric_search_continues_in_the_same_bits() {
    const COLUMNS: usize = 40;
    let shares: Vec<f64> = (0..=RING / 2).map(|n| (n as f64 * 0.7).sin()).collect();
    let [even, odd] = rows(0.05, 0.02, &shares);
    let search = || ActiveSet::new(even.clone(), COLUMNS, 1e-12, 8).with_skew(&odd);
    let step = |search: &mut ActiveSet, instant: usize| {
        search.advance(usize::from(instant > 0 && instant.is_multiple_of(2)));
        let mut forces = vec![0.0; COLUMNS];
        search.search(&rough(COLUMNS, instant), &mut forces, &mut Meter::default()).unwrap();
        forces.iter().chain(search.displacement()).map(|value| value.to_bits()).collect::<Vec<_>>()
    };
    let mut whole = search();
    (0..25).for_each(|instant| drop(step(&mut whole, instant)));
    let mut restored = search();
    SavedState::of(&mut whole).unwrap().restore(&mut restored).unwrap();
    for instant in 25..60 {
        assert_eq!(step(&mut whole, instant), step(&mut restored, instant), "{instant}");
    }
    assert_eq!(whole.counts(), restored.counts());
}
