//! Pasts of cells of a tyre that turns.

use std::f64::consts::TAU;

use num_complex::Complex64;

use super::CellHistory;
use super::direct::DirectCellHistory;
use super::history::{RingParts, WaveHistory};
use super::wave_transform::WaveTransform;
use crate::counters::Meter;
use crate::scene::{DEFAULT, Scene, Tyre};
use crate::storage::state::SavedState;
use crate::time_rule::TimeRule;
use crate::tyre::influence::{CellGrid, CellSums, CellTruncation, CellWave, FaceValues, WaveBand};
use crate::tyre::poles::cells::{CellFitOptions, fit_cells};
use crate::tyre::poles::pole_model::PoleModel;

const COLUMNS: usize = 9;
const ACROSS: usize = 4;
const ELEMENTS: usize = 32;
const TIME_STEP: f64 = 2e-4;
const FINITE: CellTruncation = CellTruncation { lateral_terms: Some(3), aliases: Some(0) };

/// The default tyre at 250 km/h.
fn turning() -> Tyre {
    let tyre = Scene::from_str(DEFAULT, "scene").unwrap().scene.tyre;
    Tyre { angular_velocity: -250.0 / 3.6 / tyre.radius(), ..tyre }
}

fn sums(tyre: &Tyre, rule: TimeRule) -> CellSums {
    let largest = rule.resolved_symbol() / TIME_STEP;
    CellSums::new(tyre, CellGrid::new(tyre, ELEMENTS, ACROSS), FINITE, 1e-8, largest)
}

fn fitted(sums: &CellSums) -> PoleModel {
    let options = CellFitOptions { top: 8.0 / TIME_STEP, tolerance: 1e-6, most_poles: 160 };
    fit_cells(sums, &sums.waves(WaveBand::WHOLE), &options, &Default::default()).unwrap()
}

fn transform(sums: &CellSums) -> WaveTransform {
    WaveTransform::new(sums.grid(), COLUMNS, &sums.waves(WaveBand::WHOLE))
}

/// Forces of the window's cells \[N\], arbitrary.
fn forces(instant: usize, first: i64) -> Vec<f64> {
    let force = |element: i64, j: usize| ((7 * instant + j) as f64 + 3.1 * (element * element) as f64).sin().max(0.0);
    (first..first + COLUMNS as i64).flat_map(|element| (0..ACROSS).map(move |j| force(element, j))).collect()
}

#[test]
fn both_histories_of_a_turning_tyre_are_the_same() {
    let tyre = turning();
    for rule in [TimeRule::Bdf2, TimeRule::Sdirk2, TimeRule::Sdirk3] {
        let sums = sums(&tyre, rule);
        let rows = sums.waves(WaveBand::WHOLE);
        let mut direct = DirectCellHistory::new(&sums, &rows, transform(&sums), rule, TIME_STEP, 64);
        let model = fitted(&sums);
        assert!(model.turns());
        let still = fitted(&self::sums(&Tyre { angular_velocity: 0.0, ..tyre.clone() }, rule));
        assert!(!still.turns());
        let history = |model| {
            WaveHistory::new(
                [RingParts {
                    model,
                    transform: transform(&sums),
                    next_instant: None,
                    forgotten_after: None,
                    advance: 1.into(),
                    fewer_poles: None,
                }],
                rule,
                TIME_STEP,
            )
        };
        let (mut poles, mut at_rest) = (history(&model), history(&still));
        let mut meter = Meter::default();
        let stages = rule.stages();
        let [mut worst, mut largest, mut by_turning] = [0.0_f64; 3];
        for step in 0..40 {
            let first = step / 3;
            for stage in 0..stages {
                let mut all = [(); 3].map(|()| vec![0.0; COLUMNS * ACROSS]);
                direct.add_displacement(stage, first, all[0].as_chunks_mut().0, &mut meter);
                poles.add_displacement(first, &mut all[1], &mut meter);
                at_rest.add_displacement(first, &mut all[2], &mut meter);
                let forces = forces(step as usize * stages + stage, first);
                direct.push(stage, first, forces.as_chunks().0);
                poles.push(first, &forces);
                at_rest.push(first, &forces);
                let [direct, poles, at_rest] = &all;
                for ((a, b), c) in direct.iter().zip(poles).zip(at_rest) {
                    (worst, largest) = (worst.max((a - b).abs()), largest.max(a.abs()));
                    by_turning = by_turning.max((a - c).abs());
                }
            }
        }
        println!("{rule:?}: {:.1e}, by turning {:.1e}", worst / largest, by_turning / largest);
        assert!(largest > 0.0 && worst < 1e-5 * largest, "{rule:?}: {:.2e}", worst / largest);
        assert!(by_turning > 1e-2 * largest);
    }
}

#[test]
fn direct_sums_when_turning_are_those_by_frequency() {
    let tyre = turning();
    let (rule, lags) = (TimeRule::Bdf2, 64);
    let sums = sums(&tyre, rule);
    let rows = sums.waves(WaveBand::WHOLE);
    let mut direct = DirectCellHistory::new(&sums, &rows, transform(&sums), rule, TIME_STEP, lags);
    let (driven, points, radius) = ((4, 1), 160, 0.85_f64);
    // One impulse, seen by cells before and behind it, as the sum over signed waves on a separate circle.
    let grid = sums.grid();
    let waves: Vec<(usize, usize, &CellWave)> =
        rows.iter().flat_map(|row| row.waves.iter().enumerate().map(|(n, wave)| (row.m, n, wave))).collect();
    let response = |values: &[FaceValues], distance: i64, j: usize| {
        let mut sum = Complex64::ZERO;
        for (&(m, n, _), value) in waves.iter().zip(values) {
            let shapes = grid.shape(m, j) * grid.shape(m, driven.1);
            let turn = Complex64::cis(TAU * (n as i64 * distance) as f64 / ELEMENTS as f64);
            let odd = Complex64::i() * value.odd[0];
            // The last wave has one sign alone, and no odd part.
            let mirror = if n == 0 || 2 * n == ELEMENTS { Complex64::ZERO } else { turn.conj() * (value.driven - odd) };
            sum += shapes * (turn * (value.driven + odd) + mirror);
        }
        sum
    };
    let others = [(6, 3), (2, 3)];
    let on_circle: Vec<(Complex64, [Complex64; 2])> = (0..points)
        .map(|k| {
            let zeta = Complex64::from_polar(radius, -TAU * k as f64 / points as f64);
            let s = rule.symbol(zeta) / TIME_STEP;
            let (at, mut values) = (sums.at(s), Vec::new());
            waves.iter().for_each(|(.., wave)| sums.values(wave, [&at], &mut values));
            (zeta, others.map(|(element, j)| response(&values, element - driven.0, j)))
        })
        .collect();
    let weights = |place: usize, lag: i32| {
        let sum: Complex64 = on_circle.iter().map(|(zeta, response)| response[place] * zeta.powi(-lag)).sum();
        sum / points as f64
    };
    let sums: Vec<[Complex64; 2]> = (0..20).map(|lag| [weights(0, lag), weights(1, lag)]).collect();
    let largest = sums.iter().flatten().fold(0.0_f64, |a, b| a.max(b.re.abs()));
    assert!(sums.iter().flatten().all(|weight| weight.im.abs() < 1e-9 * largest), "influence is real");
    let expected: Vec<[f64; 2]> = sums.iter().map(|weights| weights.map(|weight| weight.re)).collect();
    let mut differ = 0.0_f64;
    for (lag, weights) in expected.iter().enumerate() {
        let mut out = vec![0.0; COLUMNS * ACROSS];
        direct.add_displacement(0, 0, out.as_chunks_mut().0, &mut Meter::default());
        let mut forces = vec![0.0; COLUMNS * ACROSS];
        if lag == 0 {
            forces[driven.0 as usize * ACROSS + driven.1] = 1.0;
        } else {
            for ((element, j), weight) in others.into_iter().zip(weights) {
                let found = out[element as usize * ACROSS + j];
                assert!((found - weight).abs() < 1e-8 * largest, "{lag}: {found:e} {weight:e}");
            }
            differ = differ.max((weights[0] - weights[1]).abs() / largest);
        }
        direct.push(0, 0, forces.as_chunks().0);
    }
    assert!(differ > 1e-3, "before and behind it {differ:e}");
}

#[test]
fn a_history_of_a_turning_tyre_continues_from_its_state() {
    let rule = TimeRule::Sdirk2;
    let sums = sums(&turning(), rule);
    let model = fitted(&sums);
    let history = || {
        let ring = RingParts {
            model: &model,
            transform: transform(&sums),
            next_instant: None,
            forgotten_after: Some(16),
            advance: 1.into(),
            fewer_poles: None,
        };
        WaveHistory::new([ring], rule, TIME_STEP)
    };
    let mut meter = Meter::default();
    let mut instant = |history: &mut WaveHistory, instant: usize| {
        let mut out = vec![0.0; COLUMNS * ACROSS];
        let first = (instant / 4) as i64;
        history.add_displacement(first, &mut out, &mut meter);
        history.push(first, &forces(instant, first));
        out
    };
    let (mut one, mut other) = (history(), history());
    for number in 0..61 {
        instant(&mut one, number);
    }
    SavedState::of(&mut one).unwrap().restore(&mut other).unwrap();
    for number in 61..120 {
        assert_eq!(instant(&mut one, number), instant(&mut other, number), "{number}");
    }
}
