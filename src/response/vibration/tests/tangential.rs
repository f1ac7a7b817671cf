//! Velocities due to tangential forces against the time stepping of the contact.

use super::*;
use crate::contact::cells::CellHistory;
use crate::contact::cells::component_transforms::ComponentTransforms;
use crate::contact::cells::direct::DirectCellHistory;
use crate::counters::Meter;
use crate::response::vibration::TangentialForces;
use crate::scene::{DEFAULT, Sides};
use crate::tyre::influence::{CellGrid, CellSums, CellTruncation, WaveBand, traction_shape};

const COLUMNS_HERE: usize = 6;
const ACROSS_HERE: usize = 3;
const HIGHEST: usize = 3;
/// Column and cell across of the force, and the column that is observed.
const DRIVEN: (usize, usize) = (1, 0);
const SEEN: usize = 4;

/// Mean velocities of the cells of a column, outwards and along, in the last revolution of a harmonic force along or
/// across on one cell, as the contact computes them, with the number of the time step of each.
fn stepped(
    tyre: &Tyre,
    layout: &SegmentLayout,
    (component, bin): (usize, usize),
    lags: usize,
) -> Vec<(usize, [f64; 2])> {
    let grid = CellGrid::new(tyre, layout.elements, ACROSS_HERE);
    let truncation = CellTruncation { lateral_terms: Some(HIGHEST), aliases: Some(1) };
    let sums = CellSums::new(tyre, grid.clone(), truncation, 1e-9, 10.0 / layout.time_step);
    let rows = sums.traction_rows(WaveBand::WHOLE);
    let transform = ComponentTransforms::of_tractions(&grid, COLUMNS_HERE, &rows);
    let mut history = DirectCellHistory::of_tractions(&sums, &rows, transform, layout.rule, layout.time_step, lags);
    let instant = sums.traction_instant(layout.rule.first_rate(layout.time_step), COLUMNS_HERE);
    let (steps, cells) = (lags + layout.length(), COLUMNS_HERE * ACROSS_HERE);
    let driven = DRIVEN.0 * ACROSS_HERE + DRIVEN.1;
    let (mut means, mut found): (Vec<[f64; 2]>, Vec<_>) = Default::default();
    for step in 0..steps {
        let mut forces = vec![[0.0; 3]; cells];
        forces[driven][component] = (2.0 * PI * (bin * step) as f64 / layout.length() as f64).cos();
        let mut moved = vec![[0.0; 3]; cells];
        history.add_displacement(0, 0, &mut moved, &mut Meter::default());
        history.push(0, 0, &forces);
        let mean = |axis: usize| {
            let of = |j: usize| {
                let cell = SEEN * ACROSS_HERE + j;
                moved[cell][axis] + instant.block(cell, driven)[axis][component] * forces[driven][component]
            };
            (0..ACROSS_HERE).map(of).sum::<f64>() / ACROSS_HERE as f64
        };
        means.push([mean(2), mean(0)]);
        if step + layout.length() >= steps {
            let at = |ago: usize, axis: usize| means[step - ago][axis];
            let [now, one, two] = layout.rule.backward_difference();
            let rate =
                [0, 1].map(|axis| (now * at(0, axis) + one * at(1, axis) + two * at(2, axis)) / layout.time_step);
            found.push((step, rate));
        }
    }
    found
}

/// Amplitude of the velocity outwards, or along, of the cells of the observed column, by the sums over the waves of the
/// contact at the s of the rule.
fn summed(
    tyre: &Tyre,
    layout: &SegmentLayout,
    (component, bin): (usize, usize),
    (axis, shares): (usize, &[(usize, f64)]),
) -> Complex64 {
    let grid = CellGrid::new(tyre, layout.elements, ACROSS_HERE);
    let truncation = CellTruncation { lateral_terms: Some(HIGHEST), aliases: Some(1) };
    let sums = CellSums::new(tyre, grid.clone(), truncation, 1e-9, 10.0 / layout.time_step);
    let s = TransferKind::Rule.symbol(layout.rule, layout.angular_frequency(bin), layout.time_step);
    let at = sums.at(s);
    let mut amplitude = Complex64::ZERO;
    for row in sums.traction_rows(WaveBand::WHOLE) {
        let Some((_, share)) = shares.iter().find(|(m, _)| *m == row.m) else { continue };
        for (place, wave) in row.waves.iter().enumerate() {
            let parts = sums.traction_parts(wave, &at);
            let pair = 3 * [2, 0][axis] + component;
            let phase = 2.0 * PI * ((row.first + place) * (SEEN - DRIVEN.0)) as f64 / layout.elements as f64;
            // n and -n together.
            let both = if wave.is_mirror {
                phase.cos() * parts.even[pair]
            } else {
                2.0 * (phase.cos() * parts.even[pair] - phase.sin() * parts.odd[pair])
            };
            amplitude += share * traction_shape(&grid, component, row.m, DRIVEN.1) * s * both;
        }
    }
    amplitude
}

/// Compares the motion of a tyre's tread by tangential forces with the exact sum, and with steps of the contact with
/// two lengths of memory.
fn compare(name: &str, tyre: &Tyre, lags: [usize; 2]) {
    let numbers: Vec<usize> =
        CellGrid::new(tyre, 16, ACROSS_HERE).lateral_numbers().take_while(|m| *m <= HIGHEST).collect();
    let layout = SegmentLayout {
        rule: TimeRule::Bdf2,
        time_step: 2e-4,
        across: Across::Resolved { components: 3 * numbers.len(), values: 1 },
        circumference: tyre.circumference,
        ..layout(16, 1, 4, 0)
    };
    let (elements, count) = (layout.elements, numbers.len());
    let grid = CellGrid::new(tyre, elements, ACROSS_HERE);
    let shares: Vec<(usize, f64)> = numbers.iter().map(|&m| (m, grid.mean_shape(m))).collect();
    let forces = TangentialForces::new(tyre, &layout, &shares, 1e-9);
    let bin = 1;
    let width = layout.channels() * layout.bins();
    for component in [0, 1] {
        let steps = lags.map(|lags| stepped(tyre, &layout, (component, bin), lags));
        for (axis, field) in [VibrationField::Tread, VibrationField::Tangential].into_iter().enumerate() {
            // Amplitude of the velocity at the observed column.
            let mut amplitude = Complex64::ZERO;
            for n in 0..=elements / 2 {
                let mut ways = [(); 2].map(|()| vec![Complex64::ZERO; width]);
                let [forwards, backwards] = &mut ways;
                forces.put(&layout, field, n, [forwards, backwards]);
                let both = if n == 0 || 2 * n == elements { &[0][..] } else { &[0, 1] };
                for &way in both {
                    let sign = if way == 0 { 1.0 } else { -1.0 };
                    let along = if axis == 1 { Complex64::new(0.0, sign) } else { Complex64::ONE };
                    let distance = SEEN as f64 - DRIVEN.0 as f64;
                    let turn = Complex64::from_polar(1.0, sign * 2.0 * PI * n as f64 * distance / elements as f64);
                    for (index, &m) in numbers.iter().enumerate() {
                        let channel = (1 + component) * count + index;
                        let shape = traction_shape(&grid, component, m, DRIVEN.1);
                        amplitude += along * turn * shape * ways[way][channel * layout.bins() + bin];
                    }
                }
            }
            let exact = summed(tyre, &layout, (component, bin), (axis, &shares));
            let error = (amplitude - exact).norm() / exact.norm();
            let missed = steps.each_ref().map(|steps| {
                steps.iter().fold(0.0_f64, |worst, (step, found)| {
                    let phase = 2.0 * PI * (bin * step) as f64 / layout.length() as f64;
                    let expected = (amplitude * Complex64::from_polar(1.0, phase)).re;
                    worst.max((found[axis] - expected).abs() / amplitude.norm())
                })
            });
            println!("{name}, force {component}, {field:?}: {exact:.3e} m/s, off by {error:.1e}, steps {missed:?}");
            assert!(error < 1e-4, "{name}, force {component}, {field:?}: {error:e}");
            // The longer memory is more accurate.
            let is_nearer = missed[1] < 0.02 && missed[1] < missed[0];
            assert!(is_nearer, "{name}, force {component}, {field:?}: {missed:?}");
        }
    }
}

#[test]
fn tangential_forces_move_the_tread_as_steps_of_the_contact() {
    let plate = Scene::from_str(PLATE, "plate").unwrap().scene.tyre;
    let guided = Tyre { sides: Sides::Guided, ..plate.clone() };
    compare("supported", &plate, [500, 2000]);
    // The guided tyre creeps, and its memory decays slowly: more steps are needed.
    compare("guided", &guided, [500, 4000]);
    // With its sidewalls more damped a turning tyre forgets sooner.
    let mut damped = turning();
    damped.sidewall.as_mut().unwrap().loss_factor = 0.4;
    compare("turning", &damped, [125, 500]);
}

#[test]
#[ignore = "minutes: the influence of a curved tyre for 2000 steps"]
fn tangential_forces_move_a_turning_tread_as_steps_of_contact() {
    compare("turning", &turning(), [500, 2000]);
}

fn turning() -> Tyre {
    Tyre { angular_velocity: -100.0, ..Scene::from_str(DEFAULT, "default").unwrap().scene.tyre }
}
