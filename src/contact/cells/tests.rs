//! Sums and histories of cells against what they are by definition.

use num_complex::Complex64;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::direct::DirectCellHistory;
use super::history::{RingParts, WaveHistory, fewer_poles, first_influences};
use super::resting::RestingCells;
use super::wave_transform::{WaveNumber, WaveTransform};
use super::{CellHistory, CellProduct};
use crate::counters::Meter;
use crate::scene::{DEFAULT, Law, PLATE, Scene, Sides, Tyre};
use crate::time_rule::{Advance, TimeRule};
use crate::tyre::influence::{CellGrid, CellSums, CellTruncation, WaveBand};
use crate::tyre::poles::cells::{CellFitOptions, fit_cells};
use crate::tyre::poles::pole_model::PoleModel;

const COLUMNS: usize = 9;
const ACROSS: usize = 5;
const ELEMENTS: usize = 32;
const TIME_STEP: f64 = 2e-4;

fn tyre(scene: &str) -> Tyre {
    Scene::from_str(scene, "scene").unwrap().scene.tyre
}

fn sums(tyre: &Tyre, truncation: CellTruncation, rule: TimeRule) -> CellSums {
    let largest = rule.resolved_symbol() / TIME_STEP;
    CellSums::new(tyre, CellGrid::new(tyre, ELEMENTS, ACROSS), truncation, 1e-10, largest)
}

const FINITE: CellTruncation = CellTruncation { lateral_terms: Some(6), aliases: Some(0) };

/// Force of a cell of the ring \[N\], arbitrary.
fn force(instant: usize, element: i64, j: usize) -> f64 {
    let drive = ((7 * instant + j) as f64 + 3.1 * (element * element) as f64).sin();
    drive.max(0.0)
}

/// u = sum over waves by definition in the frequency domain, for forces exp(s t) on one cell.
fn response(tyre: &Tyre, s: Complex64, distance: i64, [j, other]: [usize; 2], last_m: usize) -> Complex64 {
    let stack = crate::tyre::layers::Stack::new(tyre).at(s);
    let (length, pitch) = (tyre.circumference / ELEMENTS as f64, tyre.contact_width / ACROSS as f64);
    let sinc = |x: f64| if x == 0.0 { 1.0 } else { x.sin() / x };
    let y = |j: usize| 0.5 * (tyre.width - tyre.contact_width) + (j as f64 + 0.5) * pitch;
    let mut sum = Complex64::ZERO;
    for n in -(ELEMENTS as i64) / 2..ELEMENTS as i64 / 2 {
        let kx = std::f64::consts::TAU * n as f64 / tyre.circumference;
        for m in 1..=last_m {
            let ky = std::f64::consts::PI * m as f64 / tyre.width;
            let shape = |j: usize| (ky * y(j)).sin() * sinc(0.5 * ky * pitch);
            let weight =
                sinc(0.5 * kx * length).powi(2) / tyre.circumference * 2.0 / tyre.width * shape(j) * shape(other);
            let along = Complex64::from_polar(1.0, kx * length * distance as f64);
            sum += weight * along * stack.normal(kx, ky).surface;
        }
    }
    sum
}

#[test]
fn the_instants_influence_is_the_finite_double_sum() {
    let tyre = tyre(PLATE);
    let s = 1.5 / TIME_STEP;
    let influence = sums(&tyre, FINITE, TimeRule::Bdf2).instant(s, COLUMNS);
    for (along, j, other) in [(0, 0, 0), (0, 2, 2), (1, 0, 4), (3, 1, 2), (8, 4, 4)] {
        let found = influence.toeplitz[along * ACROSS + usize::abs_diff(j, other)]
            + influence.hankel[along * (2 * ACROSS - 1) + j + other];
        let exact = response(&tyre, s.into(), along as i64, [j, other], 6).re;
        let scale = response(&tyre, s.into(), 0, [2, 2], 6).re;
        assert!((found - exact).abs() < 1e-11 * scale, "{along} {j} {other}: {found:e} {exact:e}");
    }
}

#[test]
fn the_closed_sum_is_what_ever_longer_ones_tend_to() {
    for scene in [PLATE, DEFAULT] {
        let tyre = tyre(scene);
        let s = 3.4 / TIME_STEP;
        let closed = sums(&tyre, CellTruncation::default(), TimeRule::Sdirk2).instant(s, COLUMNS);
        let long = |aliases| {
            let last = (2.0 * tyre.width / tyre.contact_width * ACROSS as f64 * aliases as f64).round() as usize;
            let truncation = CellTruncation { lateral_terms: Some(last), aliases: Some(aliases) };
            sums(&tyre, truncation, TimeRule::Sdirk2).instant(s, COLUMNS)
        };
        let (short, longer) = (long(20), long(60));
        let scale = closed.toeplitz[0];
        let difference = |a: &[f64], b: &[f64]| a.iter().zip(b).fold(0.0_f64, |worst, (a, b)| worst.max((a - b).abs()));
        let [first, second] = [&short, &longer].map(|other| {
            difference(&closed.toeplitz, &other.toeplitz).max(difference(&closed.hankel, &other.hankel)) / scale
        });
        println!("20 aliases {first:.2e}, 60 aliases {second:.2e}");
        assert!(second < 0.3 * first && second < 2e-3, "{first:.2e} {second:.2e}");
    }
}

#[test]
fn both_histories_are_the_convolution_with_the_definition() {
    let tyre = tyre(PLATE);
    for rule in [TimeRule::Bdf2, TimeRule::Sdirk2, TimeRule::Sdirk3] {
        let sums = sums(&tyre, FINITE, rule);
        let rows = sums.waves(WaveBand::WHOLE);
        let transform = || WaveTransform::new(sums.grid(), COLUMNS, &rows);
        let mut direct = DirectCellHistory::new(&sums, &rows, transform(), rule, TIME_STEP, 64);
        let options = CellFitOptions { top: 8.0 / TIME_STEP, tolerance: 1e-6, most_poles: 160 };
        let model = fit_cells(&sums, &rows, &options, &Default::default()).unwrap();
        let ring = RingParts {
            model: &model,
            transform: transform(),
            next_instant: None,
            forgotten_after: None,
            advance: 1.into(),
            fewer_poles: None,
        };
        let mut poles = WaveHistory::new([ring], rule, TIME_STEP);
        let mut meter = Meter::default();
        let stages = rule.stages();
        let (mut worst, mut largest) = (0.0_f64, 0.0_f64);
        for step in 0..40 {
            let first = step / 3;
            for stage in 0..stages {
                let mut both = [vec![0.0; COLUMNS * ACROSS], vec![0.0; COLUMNS * ACROSS]];
                direct.add_displacement(stage, first, both[0].as_chunks_mut().0, &mut meter);
                poles.add_displacement(first, &mut both[1], &mut meter);
                let instant = step as usize * stages + stage;
                let cells = (0..COLUMNS as i64).flat_map(|c| (0..ACROSS).map(move |j| force(instant, first + c, j)));
                let forces: Vec<f64> = cells.collect();
                direct.push(stage, first, forces.as_chunks().0);
                poles.push(first, &forces);
                for (a, b) in both[0].iter().zip(&both[1]) {
                    (worst, largest) = (worst.max((a - b).abs()), largest.max(a.abs()));
                }
            }
        }
        assert!(largest > 0.0 && worst < 1e-5 * largest, "{rule:?}: {:.2e}", worst / largest);
    }
}

#[test]
fn short_waves_on_a_short_ring_are_those_of_the_whole_tyre() {
    // Contact is in the middle of the window, and short waves are seen four columns farther.
    let (elements, ring, columns, seen, patch, across, time_step) = (512, 120, 40, 32, 24, 24, 1.7e-4);
    let mut tyre = tyre(PLATE);
    (tyre.width, tyre.contact_width) = (0.136, 0.111);
    let options = CellFitOptions { top: 8.0 / time_step, tolerance: 1e-4, most_poles: 160 };
    let fitted = |band: WaveBand| {
        let mut tyre = tyre.clone();
        if band.folded {
            tyre.width = CellGrid::new(&tyre, elements, across).width_in_cells();
            assert!((tyre.width - 0.136).abs() > 1e-3, "the sides of this tyre are not on cells");
        }
        let grid = CellGrid::new(&tyre, elements, across).on_ring(band.ring);
        let sums = CellSums::new(&tyre, grid, CellTruncation::default(), 1e-8, 8.0 / time_step);
        let rows = sums.waves(band);
        let model = fit_cells(&sums, &rows, &options, &Default::default()).unwrap();
        (band.ring, sums.grid().clone(), rows, model)
    };
    let [longer, shorter] = [Some([231.0, 461.0]), Some([461.0, 923.0])];
    let band = |ring, fades_in, fades_out, folded| WaveBand { ring, fades_in, fades_out, folded };
    let short = |fades_in, fades_out, folded| band(Some(ring), fades_in, fades_out, folded);
    let bands = [band(None, None, longer, false), short(longer, shorter, false), short(shorter, None, true)];
    let (whole, parts) = ([fitted(WaveBand::WHOLE)], bands.map(fitted));
    // The window goes round the short ring three times. Deformation left there recovers as slowly; elements in the
    // window are remembered for as long as they stay in it.
    let remembered = |elements_per_step: usize| (ring - seen - 4 - 16 * elements_per_step) / elements_per_step;
    for (elements_per_step, forgotten_after, bound) in
        [(1, Some(remembered(1)), 1e-4), (2, Some(remembered(2)), 1e-4), (1, None, 1e-3)]
    {
        let mut histories = [&whole[..], &parts].map(|rings| {
            let rings = rings.iter().map(|(ring, grid, rows, model)| {
                let width = if ring.is_some() { seen } else { columns };
                let transform = WaveTransform::<f64>::new(grid, width, rows);
                let first = |_| first_influences(grid, width, rows, model, TimeRule::Sdirk2, time_step);
                RingParts {
                    model,
                    transform,
                    next_instant: ring.map(first),
                    forgotten_after: forgotten_after.filter(|_| ring.is_some()),
                    advance: Advance::over(elements_per_step),
                    fewer_poles: None,
                }
            });
            WaveHistory::new(rings, TimeRule::Sdirk2, time_step)
        });
        let ([mut worst, mut beyond], mut largest) = ([0.0_f64; 2], 0.0_f64);
        let inside = |column: usize, of: usize| (columns - of) / 2 <= column && column < (columns + of) / 2;
        // Less than a revolution of the tyre, where it comes to where it was.
        for instant in 0..800 / elements_per_step {
            let first = (instant / 2) as i64 * elements_per_step as i64;
            let cells = (0..columns).flat_map(|c| (0..across).map(move |j| (c, j)));
            let pressed = |(c, j)| if inside(c, patch) { force(instant / 7, first + c as i64, j) } else { 0.0 };
            let forces: Vec<f64> = cells.map(pressed).collect();
            let [a, b] = histories.each_mut().map(|history| {
                let mut out = vec![0.0; columns * across];
                history.add_displacement(first, &mut out, &mut Meter::default());
                assert!(history.push(first, &forces));
                out
            });
            for (cell, (a, b)) in a.iter().zip(&b).enumerate() {
                let missed = if inside(cell / across, patch + 2) { &mut worst } else { &mut beyond };
                (*missed, largest) = (missed.max((a - b).abs()), largest.max(a.abs()));
            }
        }
        println!(
            "{elements_per_step} elements, forgotten after {forgotten_after:?}: {:.1e}, {:.1e} beyond",
            worst / largest,
            beyond / largest
        );
        // Farther away nothing touches yet, and short waves are not seen.
        assert!(beyond < 5e-3 * largest, "{:.2e} beyond", beyond / largest);
        assert!(largest > 0.0 && worst < bound * largest, "{:.2e}", worst / largest);
        assert!(forgotten_after.is_some() || worst > 1e-4 * largest, "nothing creeps back: {:.2e}", worst / largest);
    }
}

#[test]
fn single_precision_and_fewer_poles_give_the_same_history() {
    let (elements, columns, across, time_step) = (256, 24, 12, 1.7e-4);
    let tyre = tyre(DEFAULT);
    let options = CellFitOptions { top: 8.0 / time_step, tolerance: 1e-4, most_poles: 160 };
    let sums = CellSums::new(
        &tyre,
        CellGrid::new(&tyre, elements, across),
        CellTruncation { lateral_terms: Some(2 * across), aliases: Some(0) },
        1e-8,
        8.0 / time_step,
    );
    let rows = sums.waves(WaveBand::WHOLE);
    let model = fit_cells(&sums, &rows, &options, &Default::default()).unwrap();
    fn history<N: WaveNumber>(
        model: &PoleModel,
        transform: WaveTransform<N>,
        tolerance: Option<f64>,
    ) -> WaveHistory<N> {
        let (rule, time_step) = (TimeRule::Sdirk2, 1.7e-4);
        let fewer_poles = tolerance.map(|tolerance| fewer_poles(model, rule, time_step, tolerance));
        let ring =
            RingParts { model, transform, next_instant: None, forgotten_after: None, advance: 1.into(), fewer_poles };
        WaveHistory::new([ring], rule, time_step)
    }
    let double = || WaveTransform::<f64>::new(sums.grid(), columns, &rows);
    let single = || WaveTransform::<f32>::new(sums.grid(), columns, &rows);
    let (mut exact, mut fewer) = (history(&model, double(), None), history(&model, double(), Some(1e-4)));
    let (mut rounded, mut both) = (history(&model, single(), None), history::<f32>(&model, single(), Some(1e-4)));
    let (mut errors, mut largest) = ([0.0_f64; 3], 0.0_f64);
    for instant in 0..1500 {
        let first = (instant / 2) as i64;
        let cells = (0..columns as i64).flat_map(|c| (0..across).map(move |j| force(instant / 7, first + c, j)));
        let forces: Vec<f64> = cells.collect();
        let mut all = [(); 4].map(|()| vec![0.0; columns * across]);
        let mut meter = Meter::default();
        exact.add_displacement(first, &mut all[0], &mut meter);
        fewer.add_displacement(first, &mut all[1], &mut meter);
        rounded.add_displacement(first, &mut all[2], &mut meter);
        both.add_displacement(first, &mut all[3], &mut meter);
        exact.push(first, &forces);
        fewer.push(first, &forces);
        rounded.push(first, &forces);
        both.push(first, &forces);
        let [exact, others @ ..] = &all;
        for (error, other) in errors.iter_mut().zip(others) {
            let worst = exact.iter().zip(other).fold(0.0_f64, |worst, (a, b)| worst.max((a - b).abs()));
            *error = error.max(worst);
        }
        largest = exact.iter().fold(largest, |largest, u| largest.max(u.abs()));
    }
    let [by_poles, by_rounding, by_both] = errors.map(|error| error / largest);
    println!("fewer poles {by_poles:.1e}, single precision {by_rounding:.1e}, both {by_both:.1e}");
    assert!(by_poles > 1e-9 && by_poles < 1e-4, "{by_poles:e}");
    assert!(by_rounding > 1e-9 && by_rounding < 1e-5, "{by_rounding:e}");
    // With fewer poles, rounding may be a tenth of their tolerance.
    assert!(by_both < by_poles + 0.1 * 1e-4, "{by_both:e}");
}

#[test]
fn a_void_carries_nothing_and_its_neighbours_more() {
    let tyre = tyre(PLATE);
    let across = 6;
    let grid = CellGrid::new(&tyre, 128, across);
    let rows = |void: Option<usize>| {
        let sums = CellSums::new(&tyre, grid.clone(), CellTruncation::default(), 1e-8, 1.0);
        let crown: Vec<f64> = (0..across).map(|j| if Some(j) == void { f64::INFINITY } else { 0.0 }).collect();
        let mut resting = RestingCells::new(sums, crown.into(), None);
        let (_, forces) = resting.pressed(8e-3);
        (0..across).map(|j| forces.iter().skip(j).step_by(across).sum::<f64>()).collect::<Vec<f64>>()
    };
    let (whole, cut) = (rows(None), rows(Some(2)));
    assert!(cut[2].abs() <= 0.0 && cut[1] > 1.01 * whole[1] && cut[3] > 1.01 * whole[3], "{whole:?} {cut:?}");
}

#[test]
fn a_crowned_tyre_with_a_deep_tread_presses_like_hertzs_sphere() {
    let mut tyre = tyre(PLATE);
    let radius = tyre.radius();
    let mut tread = tyre.layers.pop().unwrap();
    (tread.thickness, tread.material.law) = (0.4, Law::Elastic);
    let modulus = tread.material.modulus / (1.0 - tread.material.poisson * tread.material.poisson);
    tyre.layers = vec![tread];
    (tyre.foundation.normal, tyre.foundation.tangential) = (1e11, 1e11);
    (tyre.width, tyre.contact_width, tyre.sides) = (0.4, 0.04, Sides::Guided);
    let (elements, across) = (2048, 42);
    let grid = CellGrid::new(&tyre, elements, across);
    let crown: Vec<f64> = (0..across).map(|j| grid.from_middle(j).powi(2) / (2.0 * radius)).collect();
    let sums = CellSums::new(&tyre, grid, CellTruncation::default(), 1e-8, 1.0);
    let depth = 4e-4;
    let mut resting = RestingCells::new(sums, crown.into(), None);
    let (found, forces) = resting.pressed(depth);
    // The contact's radius, sqrt(R depth) = 11 mm, is twelve cells, and three hundredths of the depth of the tread,
    // which is bonded and all but incompressible (Dimitriadis et al. 2002, Biophys. J. 82, 2798).
    let ratio = (radius * depth).sqrt() / 0.4;
    let layer = 1.0 + 1.133 * ratio + 1.283 * ratio * ratio;
    let hertz = 4.0 / 3.0 * modulus * radius.sqrt() * depth.powf(1.5) * layer;
    println!("{} N, Hertz {hertz} N; {} mm long", found.force, 1e3 * found.length);
    assert!((found.force / hertz - 1.0).abs() < 0.015, "{} N, Hertz {hertz} N", found.force);
    assert!((found.length / (2.0 * (radius * depth).sqrt()) - 1.0).abs() < 0.12, "{} m", found.length);
    let total: f64 = forces.iter().sum();
    assert!((total - found.force).abs() < 1e-9 * total);
}

#[test]
fn direct_sums_are_a_calculation_in_the_frequency_domain() {
    let tyre = tyre(PLATE);
    let (rule, lags) = (TimeRule::Bdf2, 64);
    let sums = sums(&tyre, FINITE, rule);
    let rows = sums.waves(WaveBand::WHOLE);
    let transform = WaveTransform::new(sums.grid(), COLUMNS, &rows);
    let mut direct = DirectCellHistory::new(&sums, &rows, transform, rule, TIME_STEP, lags);
    // One impulse, seen by another cell: a trapezoidal sum on a separate circle.
    let (driven, other, points, radius) = ((2, 1), (5, 3), 512, 0.95_f64);
    let on_circle: Vec<(Complex64, Complex64)> = (0..points)
        .map(|k| {
            let zeta = Complex64::from_polar(radius, -std::f64::consts::TAU * k as f64 / points as f64);
            let s = rule.symbol(zeta) / TIME_STEP;
            (zeta, response(&tyre, s, other.0 - driven.0, [other.1, driven.1], 6))
        })
        .collect();
    let weights: Vec<f64> = (0..20)
        .map(|lag| {
            let sum: Complex64 = on_circle.iter().map(|(zeta, response)| response * zeta.powi(-lag)).sum();
            sum.re / points as f64
        })
        .collect();
    let largest = weights.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    for (lag, weight) in weights.iter().enumerate() {
        let mut out = vec![0.0; COLUMNS * ACROSS];
        direct.add_displacement(0, 0, out.as_chunks_mut().0, &mut Meter::default());
        let mut forces = vec![0.0; COLUMNS * ACROSS];
        if lag == 0 {
            forces[driven.0 as usize * ACROSS + driven.1] = 1.0;
        } else {
            let found = out[other.0 as usize * ACROSS + other.1];
            assert!((found - weight).abs() < 1e-9 * largest, "{lag}: {found:e} {weight:e}");
        }
        direct.push(0, 0, forces.as_chunks().0);
    }
}

/// Influences that end within the window have transforms shorter than twice the window.
#[test]
fn an_influence_of_short_reach_is_summed_over_what_it_reaches() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    for ([columns, across], [along, crosswise]) in [
        ([40, 20], [8, 5]),
        ([41, 19], [0, 0]),
        ([33, 24], [32, 3]),
        ([24, 17], [5, 16]),
        ([50, 1], [10, 0]),
        ([9, 40], [3, 22]),
    ] {
        let mut toeplitz: Vec<f64> = (0..columns * across).map(|_| rng.random::<f64>() - 0.5).collect();
        for (place, value) in toeplitz.iter_mut().enumerate() {
            if place / across > along || place % across > crosswise {
                *value = 0.0;
            }
        }
        let hankel = vec![0.0; columns * (2 * across - 1)];
        let forces: Vec<f64> = (0..columns * across).map(|_| rng.random::<f64>() - 0.5).collect();
        let mut found = vec![0.0; forces.len()];
        CellProduct::<f64>::new(columns, across, &toeplitz, &hankel).displacement(&forces, &mut found);
        for (cell, found) in found.iter().enumerate() {
            let entry = |other: usize| {
                let distance = |size: fn(usize, usize) -> usize| size(cell, across).abs_diff(size(other, across));
                toeplitz[distance(|cell, across| cell / across) * across + distance(|cell, across| cell % across)]
            };
            let expected: f64 = forces.iter().enumerate().map(|(other, force)| entry(other) * force).sum();
            assert!((found - expected).abs() < 1e-13 * forces.len() as f64, "{columns} x {across}: {found} {expected}");
        }
    }
}
