//! Tests of slices that yield by themselves.

use proptest::prelude::*;

use super::super::active_set::ActiveSet;
use super::super::skew_tests::{RING, entry, rows};
use super::*;
use crate::storage::state::SavedState;

/// Curve S(y) = sum of w_k max(0, y - y_k), the weights scaled to 1; the first y_k is `first`, the others follow by
/// `steps`.
fn curve(first: f64, steps: &[(f64, f64)]) -> StiffnessCurve {
    let total: f64 = steps.iter().map(|step| step.1).sum();
    let mut y = first;
    let events: Vec<(f64, f64)> = steps
        .iter()
        .map(|&(step, weight)| {
            let event = (y, weight / total);
            y += step;
            event
        })
        .collect();
    StiffnessCurve::from_events(0.0, events.into_iter())
}

fn queue(curves: &[StiffnessCurve]) -> RoadStrip {
    let mut queue = RoadStrip::starting_at(0);
    queue.extend(curves.iter().cloned());
    queue
}

fn under(slices: &RoadStrip) -> SlicesUnder<'_> {
    SlicesUnder { slices, first_element: 0 }
}

/// S(v), 0 for v <= 0.
fn pressed(curve: &StiffnessCurve, v: f64) -> f64 {
    if v > 0.0 { curve.displacement_at(v) } else { 0.0 }
}

/// S(w) with w + (influence/c - 1) S(w) = y, by bisection: the left side grows with w.
fn in_series(curve: &StiffnessCurve, y: f64, influence: f64, compliance: f64) -> f64 {
    let (mut low, mut high) = (0.0, y * (compliance / influence).max(1.0));
    if y <= 0.0 {
        return 0.0;
    }
    for _ in 0..200 {
        let w = 0.5 * (low + high);
        if w + (influence / compliance - 1.0) * pressed(curve, w) < y { low = w } else { high = w }
    }
    pressed(curve, 0.5 * (low + high))
}

/// Reference: non-linear Gauss-Seidel with plain sums until nothing changes.
fn gauss_seidel(influence: &[f64], compliance: f64, curves: &[StiffnessCurve], y: &[f64]) -> Vec<f64> {
    let mut forces = vec![0.0_f64; y.len()];
    for _ in 0..1_000_000 {
        let mut change = 0.0_f64;
        for i in 0..y.len() {
            let others: f64 =
                forces.iter().enumerate().filter(|(j, _)| *j != i).map(|(j, f)| influence[i.abs_diff(j)] * f).sum();
            let next = in_series(&curves[i], y[i] - others, influence[0], compliance) / compliance;
            change = change.max((next - forces[i]).abs());
            forces[i] = next;
        }
        if change < 1e-14 {
            break;
        }
    }
    forces
}

/// Largest violation of c F = S(v), relative to the largest S(y), by plain sums.
fn violation(influence: &[f64], compliance: f64, curves: &[StiffnessCurve], y: &[f64], forces: &[f64]) -> f64 {
    let largest = curves.iter().zip(y).map(|(curve, &y)| pressed(curve, y)).fold(0.0, f64::max);
    let of = |i: usize| {
        let u: f64 = forces.iter().enumerate().map(|(j, f)| influence[i.abs_diff(j)] * f).sum();
        let spring = compliance * forces[i];
        (spring - pressed(&curves[i], y[i] - (u - spring))).abs()
    };
    (0..y.len()).map(of).fold(0.0, f64::max) / largest
}

fn decaying(columns: usize, reach: f64) -> Vec<f64> {
    (0..columns).map(|j| (-(j as f64) / reach).exp() + if j == 0 { 0.3 } else { 0.0 }).collect()
}

/// Twelve slices with up to five pieces, some of them with a first one that carries nothing.
fn slices() -> impl Strategy<Value = Vec<StiffnessCurve>> {
    let steps = prop::collection::vec((0.0..0.5_f64, 0.01..1.0_f64), 1..6);
    let first = prop_oneof![3 => Just(0.0), 1 => 0.0..0.3_f64];
    prop::collection::vec((first, steps).prop_map(|(first, steps)| curve(first, &steps)), 12)
}

proptest! {
    #[test]
    fn finds_the_one_solution_from_any_start(
        curves in slices(),
        y in prop::collection::vec(-1.0..1.5_f64, 12),
        start in prop::collection::vec(0.0..2.0_f64, 12),
        reach in 0.3..4.0_f64,
        // Compliances far below and far above G0_ii.
        softer in prop_oneof![Just(1.0), 0.05..20.0_f64],
        patience in prop_oneof![Just(None), Just(Some(0)), Just(Some(PATIENCE))],
    ) {
        let influence = decaying(12, reach);
        let compliance = softer * influence[0];
        let mut search = LocalSet::new(influence.clone(), compliance, 12, 1e-13);
        search.patience = patience;
        search.surface.start_from(&start);
        let (mut forces, mut required, slices) = (vec![0.0; 12], y.clone(), queue(&curves));
        let residuals = search.search(under(&slices), &mut required, &mut forces, &mut Meter::default()).unwrap();
        prop_assert!(residuals.tension <= 0.0 && residuals.penetration < 1e-12 && residuals.complementarity < 1e-12);
        for (force, exact) in forces.iter().zip(gauss_seidel(&influence, compliance, &curves, &y)) {
            prop_assert!((force - exact).abs() < 1e-9, "{force} {exact}");
        }
        // Equation 4 gives the same forces for what is returned in `required`.
        let mut prescribed = vec![0.0; 12];
        ActiveSet::new(influence, 12, 1e-13, 4).search(&required, &mut prescribed, &mut Meter::default()).unwrap();
        for (force, same) in forces.iter().zip(&prescribed) {
            prop_assert!((force - same).abs() < 1e-10, "{force} {same}");
        }
    }

    #[test]
    fn flat_slices_are_equation_4(
        y in prop::collection::vec(-1.0..1.0_f64, 12),
        reach in 0.3..4.0_f64,
        compliance in 0.05..20.0_f64,
    ) {
        let influence = decaying(12, reach);
        let slices = queue(&vec![StiffnessCurve::flat(0.0); 12]);
        let (mut forces, mut prescribed, mut required) = (vec![0.0; 12], vec![0.0; 12], y.clone());
        LocalSet::new(influence.clone(), compliance, 12, 1e-13)
            .search(under(&slices), &mut required, &mut forces, &mut Meter::default())
            .unwrap();
        ActiveSet::new(influence, 12, 1e-13, 4).search(&y, &mut prescribed, &mut Meter::default()).unwrap();
        prop_assert_eq!(&required, &y);
        for (force, same) in forces.iter().zip(&prescribed) {
            prop_assert!((force - same).abs() < 1e-13, "{force} {same}");
        }
    }

    #[test]
    fn slices_press_more_than_equation_4_and_more_when_deeper(
        curves in slices(),
        y in prop::collection::vec(-0.5..1.5_f64, 12),
        deeper in 0.0..0.5_f64,
        reach in 0.3..4.0_f64,
        softer in 0.05..20.0_f64,
    ) {
        let influence = decaying(12, reach);
        let slices = queue(&curves);
        let total = |y: &[f64], softer: f64| {
            let (mut forces, mut required) = (vec![0.0; 12], y.to_vec());
            LocalSet::new(influence.clone(), softer * influence[0], 12, 1e-13)
                .search(under(&slices), &mut required, &mut forces, &mut Meter::default())
                .unwrap();
            (forces, required)
        };
        let (_, required) = total(&y, 1.0);
        // With c = G0_ii, d = y - v + S(v) with v <= y, and y - S(y) grows with y.
        for ((d, curve), &y) in required.iter().zip(&curves).zip(&y) {
            prop_assert!(*d >= curve.displacement_at(y) - 1e-12);
        }
        let lower: Vec<f64> = y.iter().map(|y| y + deeper).collect();
        let ((forces, _), (pushed, _)) = (total(&y, softer), total(&lower, softer));
        // (F' - F).(y' - y) >= 0: the law is monotone.
        let work: f64 = pushed.iter().zip(&forces).map(|(a, b)| (a - b) * deeper).sum();
        prop_assert!(work >= -1e-12);
    }
}

proptest! {
    #[test]
    fn finds_the_one_solution_with_a_skew_part(
        curves in slices(),
        y in prop::collection::vec(-1.0..1.5_f64, 12),
        start in prop::collection::vec(0.0..2.0_f64, 12),
        softness in 0.05..0.5_f64,
        softer in prop_oneof![Just(1.0), 0.05..20.0_f64],
        skew in prop_oneof![Just(0.004), Just(0.02), Just(0.24)],
        shares in prop::collection::vec(-1.0..1.0_f64, RING / 2 + 1),
        patience in prop_oneof![Just(None), Just(Some(0)), Just(Some(PATIENCE))],
    ) {
        let rows = rows(softness, skew, &shares);
        let [even, odd] = &rows;
        let compliance = softer * even[0];
        let mut search = LocalSet::new(even.clone(), compliance, 12, 1e-13).with_skew(odd);
        search.patience = patience;
        search.surface.start_from(&start);
        let (mut forces, mut required, slices) = (vec![0.0; 12], y.clone(), queue(&curves));
        let residuals = search.search(under(&slices), &mut required, &mut forces, &mut Meter::default()).unwrap();
        prop_assert!(residuals.tension <= 0.0 && residuals.penetration < 1e-12 && residuals.complementarity < 1e-11);
        // Reference: symmetric problems less the displacements by the skew part, until nothing changes.
        let mut exact = vec![0.0; 12];
        let mut change = f64::INFINITY;
        while change > 1e-13 {
            let skewed = |i: usize| (0..12).map(|j| odd[(RING + i - j) % RING] * exact[j]).sum::<f64>();
            let residual: Vec<f64> = (0..12).map(|i| y[i] - skewed(i)).collect();
            let next = gauss_seidel(even, compliance, &curves, &residual);
            change = next.iter().zip(&exact).fold(0.0, |a: f64, (b, c)| a.max((b - c).abs()));
            exact = next;
        }
        for (force, exact) in forces.iter().zip(&exact) {
            prop_assert!((force - exact).abs() < 1e-9 * (1.0 + exact), "{} {}", force, exact);
        }
        for (i, displacement) in search.displacement().iter().enumerate().take(12) {
            let lifted: f64 = (0..12).map(|j| entry(&rows, i, j) * forces[j]).sum();
            prop_assert!((displacement - lifted).abs() < 1e-12 * (1.0 + lifted.abs()));
        }
        // Equation 4 gives the same forces for what is returned in `required`.
        let mut prescribed = vec![0.0; 12];
        let mut search = ActiveSet::new(even.clone(), 12, 1e-13, 4).with_skew(odd);
        search.search(&required, &mut prescribed, &mut Meter::default()).unwrap();
        for (force, same) in forces.iter().zip(&prescribed) {
            prop_assert!((force - same).abs() < 1e-9 * (1.0 + force), "{} {}", force, same);
        }
    }
}

#[test]
fn nothing_touches_when_nothing_is_required() {
    let curves = [curve(0.0, &[(0.1, 1.0)]), curve(0.4, &[(0.1, 1.0), (0.1, 1.0)]), StiffnessCurve::flat(0.0)];
    let slices = queue(&curves);
    let mut search = LocalSet::new(decaying(4, 1.0), 0.7, 4, 1e-12);
    // The second slice carries nothing up to 0.4; there is no road under the fourth column.
    let (mut forces, mut required) = (vec![1.0; 4], vec![-1.0, 0.3, 0.0, f64::NEG_INFINITY]);
    let residuals = search.search(under(&slices), &mut required, &mut forces, &mut Meter::default()).unwrap();
    assert_eq!((forces, residuals), (vec![0.0; 4], Residuals::default()));
    assert_eq!(required, [-1.0, 0.0, 0.0, f64::NEG_INFINITY]);
    assert_eq!(search.counts().histogram[0], 1);
}

#[test]
fn one_point_alone_follows_its_curve() {
    let influence = decaying(8, 1.0);
    let curves: Vec<_> = (0..8).map(|_| curve(0.0, &[(0.1, 1.0), (0.2, 2.0), (0.0, 5.0)])).collect();
    let slices = queue(&curves);
    let mut required = vec![-5.0; 8];
    required[3] = 0.25;
    let mut forces = vec![0.0; 8];
    LocalSet::new(influence.clone(), influence[0], 8, 1e-13)
        .search(under(&slices), &mut required, &mut forces, &mut Meter::default())
        .unwrap();
    assert!((influence[0] * forces[3] - curves[3].displacement_at(0.25)).abs() < 1e-15);
    assert!((required[3] - curves[3].displacement_at(0.25)).abs() < 1e-15, "nobody else acts: equation 4");
    for compliance in [0.01, 0.3, 2.0, 50.0] {
        required[3] = 0.25;
        LocalSet::new(influence.clone(), compliance, 8, 1e-13)
            .search(under(&slices), &mut required, &mut forces, &mut Meter::default())
            .unwrap();
        let pressed = in_series(&curves[3], 0.25, influence[0], compliance);
        assert!((compliance * forces[3] - pressed).abs() < 1e-14, "{compliance}: {} {pressed}", forces[3]);
        assert!((required[3] - influence[0] * forces[3]).abs() < 1e-15);
    }
}

#[test]
fn ties_soft_beginnings_and_nearly_identical_neighbours_end() {
    // Hard case: a nearly singular G0, breakpoints met exactly, slices that are all but free of stiffness at first.
    let influence: Vec<f64> =
        (0..40).map(|j| 1.0 / (1.0 + (j as f64 / 12.0).powi(2)) + if j == 0 { 1e-9 } else { 0.0 }).collect();
    for (compliance, round) in [0.03, 1.0, 30.0].into_iter().flat_map(|c| (0..50).map(move |round| (c, round))) {
        let mut search = LocalSet::new(influence.clone(), compliance, 40, 1e-12);
        let curves: Vec<_> = (0..40)
            .map(|i| match (i + round) % 4 {
                0 => StiffnessCurve::flat(0.0),
                1 => curve(0.0, &[(0.5, 1e-13), (0.5, 1.0), (0.0, 1.0)]),
                2 => curve(0.5, &[(0.5, 1.0), (0.0, 1e-9)]),
                _ => curve(0.0, &[(1.0, 1.0), (0.0, 1.0)]),
            })
            .collect();
        let slices = queue(&curves);
        let y: Vec<f64> =
            (0..40).map(|i| if (i + round) % 7 < 3 { 1.0 } else { 1.0 - 1e-14 * (i % 3) as f64 }).collect();
        let (mut required, mut forces) = (y.clone(), vec![0.0; 40]);
        let residuals = search.search(under(&slices), &mut required, &mut forces, &mut Meter::default()).unwrap();
        assert!(residuals.tension <= 0.0 && residuals.penetration < 1e-9, "{residuals:?}");
        let violation = violation(&influence, compliance, &curves, &y, &forces);
        assert!(violation < 1e-9, "round {round}: {violation:e}");
    }
}

#[test]
fn the_fallback_alone_finds_the_solution_too() {
    let influence = decaying(10, 6.0);
    let curves: Vec<_> = (0..10).map(|i| curve(0.0, &[(0.2, 1.0 + i as f64), (0.4, 1.0), (0.0, 3.0)])).collect();
    let slices = queue(&curves);
    let compliance = influence[0];
    let mut search = LocalSet::new(influence.clone(), compliance, 10, 1e-13);
    search.patience = None;
    let mut fallbacks = 0;
    for round in 0..40 {
        let y: Vec<f64> = (0..10).map(|i| if (i * 7 + round) % 3 == 0 { 1.0 } else { -0.2 + 0.1 * i as f64 }).collect();
        // Far from it: two sweeps do not find the pieces.
        let start: Vec<f64> = (0..10).map(|i| ((i + round) % 2) as f64 * 50.0).collect();
        search.surface.start_from(&start);
        let (mut required, mut forces) = (y.clone(), vec![0.0; 10]);
        search.search(under(&slices), &mut required, &mut forces, &mut Meter::default()).unwrap();
        assert!(violation(&influence, compliance, &curves, &y, &forces) < 1e-12);
        fallbacks = search.counts().fallbacks;
    }
    println!("{fallbacks} fallbacks");
    assert!(fallbacks > 10, "the fallback was hardly ever needed");
}

/// Rough slices under many points, and penetrations of an instant.
fn rough_patch(instant: usize) -> (RoadStrip, Vec<f64>) {
    const COLUMNS: usize = 100;
    let curves: Vec<_> = (0..COLUMNS)
        .map(|i| curve(0.02 * ((i * i) % 7) as f64, &[(0.1 + 0.02 * (i % 16) as f64, 1.0), (0.3, 2.0), (0.0, 3.0)]))
        .collect();
    let along = |i: usize| (i as f64 - 50.0 + 0.1 * instant as f64) / 45.0;
    (queue(&curves), (0..COLUMNS).map(|i| 1.2 - along(i).powi(2) + 0.05 * ((i * 13 + instant) as f64).sin()).collect())
}

#[test]
fn a_band_finds_what_the_whole_matrix_finds() {
    let even = decaying(100, 1.5);
    for skew in [0.0, 0.01] {
        let odd: Vec<f64> = if skew > 0.0 { even.iter().map(|even| skew * even).collect() } else { Vec::new() };
        let set = || LocalSet::new(even.clone(), 0.8, 100, 1e-12).with_skew(&odd);
        let (mut banded, mut whole) = (set(), set());
        whole.band = 100;
        let mut forces = [vec![0.0; 100], vec![0.0; 100]];
        for instant in 0..40 {
            let (slices, y) = rough_patch(instant);
            for (search, forces) in [&mut banded, &mut whole].into_iter().zip(&mut forces) {
                let mut required = y.clone();
                let residuals = search.search(under(&slices), &mut required, forces, &mut Meter::default()).unwrap();
                assert!(residuals.tension <= 0.0 && residuals.penetration < 1e-12, "{residuals:?}");
                assert!(residuals.complementarity < 1e-11, "{residuals:?}");
            }
            for (found, exact) in forces[0].iter().zip(&forces[1]) {
                assert!((found - exact).abs() < 1e-11, "{instant}: {found} {exact}");
            }
            for (found, exact) in banded.displacement().iter().zip(whole.displacement()) {
                assert!((found - exact).abs() < 1e-11, "{instant}: {found} {exact}");
            }
        }
        let [banded, whole] = [banded.counts(), whole.counts()];
        println!("skew {skew}: {} and {} solves, {:?}", banded.solves, whole.solves, banded.factors);
        assert!(banded.factors.bands >= 40 && whole.factors.factorisations >= 40, "{banded:?} {whole:?}");
        let others = [banded.factors.factorisations, banded.factors.refactorisations, whole.factors.bands];
        assert_eq!((others, banded.fallbacks), ([0; 3], 0));
        assert!(banded.factorisation.multiply_adds * 4 < whole.factorisation.multiply_adds);
    }
}

#[test]
fn a_band_that_does_not_converge_gives_way_to_the_whole_matrix() {
    // Smooth within the band: the least eigenvalues of G0 are far below the part outside the band.
    let influence: Vec<f64> =
        (0..100).map(|j| (-(j as f64 / 6.0).powi(2)).exp() + if j == 0 { 1e-6 } else { 0.0 }).collect();
    let mut search = LocalSet::new(influence.clone(), 0.8, 100, 1e-12);
    assert!(search.band < 4, "{}", search.band);
    let slices: Vec<_> = (0..100).map(|_| StiffnessCurve::flat(0.0)).collect();
    let y: Vec<f64> = (0..100).map(|i| 1.0 + 1e-3 * (i as f64 * 0.1).sin()).collect();
    let (mut required, mut forces) = (y.clone(), vec![0.0; 100]);
    let under = queue(&slices);
    let residuals = search.search(self::under(&under), &mut required, &mut forces, &mut Meter::default()).unwrap();
    assert!(residuals.tension <= 0.0 && residuals.penetration < 1e-9, "{residuals:?}");
    assert!(violation(&influence, 0.8, &slices, &y, &forces) < 1e-9);
    let factors = search.counts().factors;
    // Sets of few points took the whole matrix at once.
    assert!(factors.refactorisations > 10 && factors.factorisations >= factors.refactorisations, "{factors:?}");
}

#[test]
fn a_restored_search_goes_on_in_the_same_bits() {
    // Few points, and so many that a band serves.
    for columns in [16, 100] {
        let influence = decaying(columns, 1.5);
        let curves: Vec<_> = (0..130).map(|i| curve(0.0, &[(0.1 + 0.02 * (i % 16) as f64, 1.0), (0.0, 3.0)])).collect();
        let slices = queue(&curves);
        let step = |search: &mut LocalSet, round: usize| {
            search.advance(round % 2);
            let under = SlicesUnder { slices: &slices, first_element: (round as i64 + 1) / 2 };
            let mut required: Vec<f64> = (0..columns).map(|i| 0.5 + ((i * 5 + round * 3) as f64).sin()).collect();
            let mut forces = vec![0.0; columns];
            search.search(under, &mut required, &mut forces, &mut Meter::default()).unwrap();
            forces.iter().chain(&required).map(|value| value.to_bits()).collect::<Vec<_>>()
        };
        let mut whole = LocalSet::new(influence.clone(), 0.8, columns, 1e-13);
        (0..20).for_each(|round| drop(step(&mut whole, round)));
        let mut restored = LocalSet::new(influence, 0.8, columns, 1e-13);
        SavedState::of(&mut whole).unwrap().restore(&mut restored).unwrap();
        for round in 20..40 {
            assert_eq!(step(&mut whole, round), step(&mut restored, round));
        }
        assert_eq!(whole.counts(), restored.counts());
        assert_eq!(whole.counts().factors.bands > 0, columns == 100, "{:?}", whole.counts());
    }
}
