//! The frequency domain against the time domain, step by step and element by element.

use std::f64::consts::PI;
use std::sync::OnceLock;

use num_complex::Complex64;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::contact::history::{ModalHistory, PastForces};
use crate::numeric::{Ring, StateReader, StateWriter};
use crate::response::PowerSpectrum;
use crate::scene::{DEFAULT, Scene, TimeRule};
use crate::tyre::influence::Field;
use crate::tyre::rational::{FitOptions, RationalModel, fit};

const ELEMENTS: usize = 16;
const COLUMNS: usize = 5;
const TIME_STEP: f64 = 1e-3;

/// The tyre of the default scene in few elements: what is compared is exact for any model.
fn model() -> &'static RationalModel {
    static MODEL: OnceLock<RationalModel> = OnceLock::new();
    MODEL.get_or_init(|| {
        let tyre = Scene::from_str(DEFAULT, "default").unwrap().scene.tyre;
        fit(&tyre, &FitOptions::new(&tyre, ELEMENTS, 20.0).with_tolerance(1e-3)).unwrap()
    })
}

fn response() -> TyreResponse<'static> {
    TyreResponse { model: model(), scale: 1.0, spring: 0.0, tangential: None }
}

fn layout(elements: usize, substeps: usize, revolutions: usize, phase: usize) -> SegmentLayout {
    SegmentLayout {
        elements,
        substeps,
        revolutions,
        columns: COLUMNS,
        time_step: TIME_STEP,
        phase,
        first_position: -0.3,
        circumference: 1.95,
    }
}

fn noise(layout: &SegmentLayout, steps: usize, mean: f64, seed: u64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    (0..steps * layout.columns).map(|_| mean + random.random_range(-1.0..1.0)).collect()
}

fn accumulated(layout: &SegmentLayout, forces: &[f64]) -> VibrationAccumulator {
    let mut accumulator = VibrationAccumulator::new(*layout);
    for row in forces.chunks_exact(layout.columns) {
        accumulator.push(row, 0.0);
    }
    accumulator
}

/// One segment of forces whose plain and squared-window means are zero at every place, so that nothing is taken off, weighted with the window: what the accumulator transforms.
fn windowed_segment(layout: &SegmentLayout, seed: u64) -> (Vec<f64>, Vec<f64>) {
    let mut forces = noise(layout, layout.length(), 0.0, seed);
    for place in 0..layout.places() {
        let (column, phase) = (place / layout.substeps, place % layout.substeps);
        let steps: Vec<usize> = (layout.first_step(phase)..layout.length()).step_by(layout.substeps).collect();
        let swing = |step: usize| 2.0 * layout.weight(step).powi(2) - 1.0;
        // Twice: the swing's own mean over a substep's steps is not exactly zero.
        for _ in 0..60 {
            let count = steps.len() as f64;
            let mean = steps.iter().map(|&step| forces[step * COLUMNS + column]).sum::<f64>() / count;
            let weighted = steps.iter().map(|&step| swing(step) * forces[step * COLUMNS + column]).sum::<f64>() / count;
            for &step in &steps {
                forces[step * COLUMNS + column] -= mean + weighted * swing(step);
            }
        }
    }
    let weighted = forces.iter().enumerate().map(|(index, force)| layout.weight(index / COLUMNS) * force).collect();
    (forces, weighted)
}

/// Displacements of all elements over the last of many periods of the same forces, and the mean power put in over it, by the run's own recursion.
fn rolled(layout: &SegmentLayout, forces: &[f64], rule: TimeRule, periods: usize) -> (Vec<Vec<f64>>, f64) {
    let (elements, length) = (layout.elements, layout.length());
    let mut history = ModalHistory::new(model(), Field::Surface, rule, TIME_STEP).unwrap();
    let first_weights = ModalHistory::first_weights(model(), Field::Surface, rule, TIME_STEP).unwrap();
    let instant = Ring::new(elements).elements_of(|n| first_weights[n]).to_vec();
    // Two elements more on either side: what enters the window carries no force yet, as in a run.
    let mut power = ContactPower::new(rule, TIME_STEP, COLUMNS + 4);
    let (mut last, mut work) = (Vec::new(), 0.0);
    for step in 0..periods * length {
        let row = &forces[step % length * COLUMNS..][..COLUMNS];
        let first = ((layout.phase + step) / layout.substeps) as i64;
        let mut all = vec![0.0; elements];
        history.displacement(0, &mut all);
        for (column, force) in row.iter().enumerate() {
            for (element, value) in all.iter_mut().enumerate() {
                let distance = (element as i64 - first - column as i64).rem_euclid(elements as i64);
                *value += instant[distance as usize] * force;
            }
        }
        history.push(first, row);
        let window: Vec<f64> =
            (-2..COLUMNS as i64 + 2).map(|c| all[(first + c).rem_euclid(elements as i64) as usize]).collect();
        let wide: Vec<f64> = [0.0; 2].iter().chain(row).chain(&[0.0; 2]).copied().collect();
        let put_in = power.push(first - 2, &wide, &window);
        if step >= (periods - 1) * length {
            last.push(all);
            work += put_in;
        }
    }
    (last, work / length as f64)
}

/// Plain transform over time.
fn transformed(series: &[Complex64]) -> Vec<Complex64> {
    let length = series.len();
    let at = |bin: usize| {
        let turn = |step: usize| Complex64::from_polar(1.0, -2.0 * PI * (bin * step % length) as f64 / length as f64);
        series.iter().enumerate().map(|(step, value)| value * turn(step)).sum()
    };
    (0..length).map(at).collect()
}

/// Velocities of all elements over a period, by the rule's difference quotient: transforms by element, |w'| signed.
fn velocity_transforms(layout: &SegmentLayout, displacement: &[Vec<f64>], kind: TransferKind) -> Vec<Vec<Complex64>> {
    (0..layout.elements)
        .map(|element| {
            let series: Vec<Complex64> = displacement.iter().map(|all| all[element].into()).collect();
            let mut bins = transformed(&series);
            for (bin, value) in bins.iter_mut().enumerate() {
                let signed = layout.material_bin(bin, 0);
                let symbol = kind.symbol(2.0 * PI * signed as f64 * layout.resolution(), layout.time_step);
                // The last bin of a real signal is real: cos, whose derivative the samples do not show.
                *value *= if 2 * signed.unsigned_abs() as usize == layout.length() { symbol.re.into() } else { symbol };
            }
            bins
        })
        .collect()
}

const MULTISTEP: [TimeRule; 3] = [TimeRule::Bdf1, TimeRule::Bdf2, TimeRule::Trapezoidal];

/// Cases: substeps, revolutions, substep of the first step.
const CASES: [(usize, usize, usize); 5] = [(1, 1, 0), (1, 3, 0), (2, 1, 1), (2, 2, 0), (3, 1, 2)];

#[test]
fn spectra_everywhere_and_at_points_are_those_of_the_time_domain() {
    for rule in MULTISTEP {
        for (substeps, revolutions, phase) in CASES {
            let layout = layout(ELEMENTS, substeps, revolutions, phase);
            let kind = TransferKind::Rule(rule);
            let (plain, weighted) = windowed_segment(&layout, 5);
            let positions = [layout.first_position, 0.0, 0.1, -0.7, 0.975];
            let mut accumulator = VibrationAccumulator::new(layout);
            let table = VelocityTable::new(&layout, &response(), kind, VibrationField::Tread).unwrap();
            table.add_points(&mut accumulator, &positions);
            let elements = vec![0, 6, 15, 7];
            accumulator.set_elements(ElementVelocities::new(&layout, 0, vec![table], elements.clone()));
            for row in plain.chunks_exact(COLUMNS) {
                accumulator.push(row, 0.0);
            }
            let patch = accumulator.finish().unwrap();
            let request = SpectraRequest { fields: &[VibrationField::Tread], kind, maps: true };
            let (fields, dissipation) = field_spectra(&patch, &response(), &request).unwrap();

            // Until a creep at 1 Hz has died out.
            let (displacement, power) = rolled(&layout, &weighted, rule, 12_000 / layout.length());
            let velocities = velocity_transforms(&layout, &displacement, kind);
            let length = layout.length() as f64;
            // The accumulator divides by the energy of the window, half the length.
            let scale = 2.0 / (length * length);
            let bins = layout.bins();
            let last = bins - 1;
            let name = format!("{rule:?}, q = {substeps}, r = {revolutions}");

            let material: Vec<f64> = (0..bins)
                .map(|bin| {
                    let sum: f64 = velocities.iter().map(|element| element[bin].norm_sqr()).sum();
                    layout.sides(bin) * scale * sum / ELEMENTS as f64
                })
                .collect();
            let largest = material.iter().fold(0.0_f64, |a, &b| a.max(b));
            for (bin, exact) in material.iter().enumerate().take(last).skip(1) {
                let error = (fields[0].material.power[bin] - exact).abs() / largest;
                assert!(error < 1e-6, "{name}, material, bin {bin}: {error:e}");
            }

            for (point, &element) in elements.iter().enumerate() {
                let found = element_spectrum(&patch, point);
                let powers: Vec<f64> =
                    (0..bins).map(|bin| layout.sides(bin) * scale * velocities[element][bin].norm_sqr()).collect();
                let largest = powers.iter().fold(0.0_f64, |a, &b| a.max(b));
                for (bin, exact) in powers.iter().enumerate().take(last) {
                    let error = (found.power[bin] - exact).abs() / largest;
                    assert!(error < 1e-6, "{name}, element {element}, bin {bin}: {error:e}");
                }
            }

            // v_n(l), then at fixed places; half of either end of the wavenumbers, the rule's last bin left out on both sides.
            let series = |element: usize| -> Vec<Complex64> {
                let bins: Vec<Complex64> = velocities[element].iter().map(|value| value.conj()).collect();
                transformed(&bins).into_iter().map(|value| value.conj() / length).collect()
            };
            let by_element: Vec<Vec<Complex64>> = (0..ELEMENTS).map(series).collect();
            for (point, position) in positions.iter().enumerate() {
                let at = |step: usize| -> Complex64 {
                    let mut sum = Complex64::ZERO;
                    for index in 0..layout.wavenumbers() {
                        let n = layout.wavenumber(index) as f64;
                        let wave: Complex64 = (0..ELEMENTS)
                            .map(|e| {
                                by_element[e][step]
                                    * Complex64::from_polar(1.0, -2.0 * PI * n * e as f64 / ELEMENTS as f64)
                            })
                            .sum::<Complex64>()
                            / ELEMENTS as f64;
                        let elements_on = (position - layout.first_position) * ELEMENTS as f64 / layout.circumference
                            + (layout.phase + step) as f64 / substeps as f64;
                        let turn = Complex64::from_polar(1.0, 2.0 * PI * n * elements_on / ELEMENTS as f64);
                        sum += layout.share(index) * wave * turn;
                    }
                    sum
                };
                let exact = transformed(&(0..layout.length()).map(at).collect::<Vec<_>>());
                let found = point_spectrum(&patch, point);
                let powers: Vec<f64> = (0..bins).map(|bin| layout.sides(bin) * scale * exact[bin].norm_sqr()).collect();
                let largest = powers.iter().fold(0.0_f64, |a, &b| a.max(b));
                for (bin, exact) in powers.iter().enumerate() {
                    // The last bin of the material frame has no side; its wave of n lies there in these bins.
                    let doubtful = (0..layout.wavenumbers()).any(|i| {
                        2 * layout.material_bin(bin, layout.wavenumber(i)).unsigned_abs() as usize == layout.length()
                    });
                    let error = (found.power[bin] - exact).abs() / largest;
                    assert!(doubtful || error < 1e-6, "{name}, {position} m, bin {bin}: {error:e}");
                }
            }

            if rule != TimeRule::Trapezoidal {
                let error = (0.5 * dissipation.total() / power - 1.0).abs();
                assert!(error < 1e-6, "{name}: {power} W put in, error {error:e}");
            }
        }
    }
}

#[test]
fn nothing_is_lost_between_places_and_waves() {
    for substeps in [1, 2, 3] {
        // Few enough bins for the mean pattern to be taken off exactly in all of them.
        let layout = layout(14, substeps, 1, substeps - 1);
        let steps = 4 * layout.hop();
        let forces = noise(&layout, steps, 40.0, 3);
        let patch = accumulated(&layout, &forces).finish().unwrap();
        assert_eq!(patch.segments, 3);
        // The squared windows: rising over the first hop, one, falling over the last.
        let weight = |step: usize| {
            let hop = layout.hop();
            match step / hop {
                0 => layout.weight(step).powi(2),
                3 => layout.weight(step - 2 * hop).powi(2),
                _ => 1.0,
            }
        };
        let place = |step: usize, column: usize| column * substeps + layout.phase_of(step);
        let mut sums = vec![[0.0; 2]; layout.places()];
        for step in 0..steps {
            for column in 0..COLUMNS {
                let sum = &mut sums[place(step, column)];
                sum[0] += weight(step) * forces[step * COLUMNS + column];
                sum[1] += weight(step);
            }
        }
        let (mut varying, mut standing, mut weights) = (0.0, 0.0, 0.0);
        for step in 0..steps {
            weights += weight(step);
            for column in 0..COLUMNS {
                let [sum, weights] = sums[place(step, column)];
                let mean = sum / weights;
                varying += weight(step) * (forces[step * COLUMNS + column] - mean).powi(2);
                standing += weight(step) * mean * mean;
            }
        }
        // sum |F_n|^2 = N sum F_e^2.
        let (varying, standing) = (14.0 * varying / weights, 14.0 * standing / weights);
        let all = |bin: usize, row: &[f64]| {
            let powers = row.iter().enumerate();
            powers.map(|(index, power)| layout.sides(bin) * layout.share(index) * power).sum::<f64>()
        };
        let vibration: f64 = (0..layout.bins()).map(|bin| all(bin, patch.row(bin))).sum();
        let pattern: f64 = patch.mean_pattern.iter().map(|(bin, row)| all(*bin, row)).sum();
        assert!((vibration / varying - 1.0).abs() < 1e-10, "q = {substeps}: {vibration} {varying}");
        assert!((pattern / standing - 1.0).abs() < 1e-10, "q = {substeps}: {pattern} {standing}");
    }
}

#[test]
fn both_frames_have_the_same_power_and_maps_and_bands_hold_it() {
    let layout = layout(ELEMENTS, 2, 3, 1);
    let patch = accumulated(&layout, &noise(&layout, 5 * layout.hop(), 9.0, 11)).finish().unwrap();
    let fields = [VibrationField::Tread, VibrationField::Belt];
    let request = SpectraRequest { fields: &fields, kind: TransferKind::Exact, maps: true };
    let (spectra, dissipation) = field_spectra(&patch, &response(), &request).unwrap();
    assert!(dissipation.mean_pattern > 0.0 && dissipation.vibration > 0.0, "a passive tyre dissipates");
    for field in &spectra {
        let varying = field.material_varying.mean_square();
        assert!((field.material.mean_square() / (varying + field.mean_pattern) - 1.0).abs() < 1e-12);
        let [material, road] = [&field.material, &field.non_rotating].map(PowerSpectrum::mean_square);
        assert!((material / (road + field.mean_pattern) - 1.0).abs() < 1e-12, "{:?}", field.field);
        let nyquist = field.material.nyquist;
        assert!((field.material.power_within(0.0..nyquist) / material - 1.0).abs() < 1e-12);
        for map in field.maps.as_ref().unwrap() {
            let sum = map.density.iter().sum::<f64>() * map.row_width;
            assert!((sum / road - 1.0).abs() < 1e-12, "{:?}: maps hold the vibration", field.field);
        }
    }
}

#[test]
fn points_all_round_have_the_mean_over_the_circumference() {
    let layout = layout(ELEMENTS, 2, 2, 0);
    let kind = TransferKind::Exact;
    let mut accumulator = VibrationAccumulator::new(layout);
    let table = VelocityTable::new(&layout, &response(), kind, VibrationField::Belt).unwrap();
    // More points than waves: no two waves look alike on them.
    let count = 2 * ELEMENTS;
    let positions: Vec<f64> = (0..count).map(|point| point as f64 * 1.95 / count as f64 - 0.9).collect();
    table.add_points(&mut accumulator, &positions);
    for row in noise(&layout, 4 * layout.hop(), 2.0, 8).chunks_exact(COLUMNS) {
        accumulator.push(row, 0.0);
    }
    let patch = accumulator.finish().unwrap();
    for bin in 0..layout.bins() {
        // By wave: the two halves of the shortest one are a quarter of its power each here, half everywhere (where its elements are).
        let wave = |index: usize| {
            let n = layout.wavenumber(index);
            let share = layout.share(index).powi(2);
            share * layout.sides(bin) * patch.row(bin)[index] * table.at(n, layout.material_bin(bin, n)).norm_sqr()
        };
        let expected: f64 = (0..layout.wavenumbers()).map(wave).sum();
        let mean = (0..count).map(|point| point_spectrum(&patch, point).power[bin]).sum::<f64>() / count as f64;
        assert!((mean / expected - 1.0).abs() < 1e-9, "bin {bin}: {mean} {expected}");
    }
}

#[test]
fn all_elements_have_the_mean_over_the_circumference() {
    let tyre = Scene::from_str(DEFAULT, "default").unwrap().scene.tyre;
    // Segments of an odd number of revolutions begin half a turn on; few enough bins for the mean pattern, which the first segment does not know, to be taken off exactly in all of them.
    for (substeps, revolutions, phase, first) in [(1, 1, 0, 5), (2, 1, 1, -3), (3, 1, 2, 40)] {
        let layout = SegmentLayout { elements: 14, ..layout(14, substeps, revolutions, phase) };
        let options = FitOptions::new(&tyre, layout.elements, 20.0).with_tolerance(1e-3);
        let model = fit(&tyre, &options).unwrap();
        let top = layout.angular_frequency(layout.bins() - 1);
        let tangential = crate::tyre::tangential::tangential_model(&tyre, &model, top).unwrap();
        let response = TyreResponse { model: &model, scale: 1.0, spring: 1e-6, tangential: Some(&tangential) };
        let fields = [VibrationField::Tread, VibrationField::Tangential];
        let kind = TransferKind::Exact;
        let tables = fields.map(|field| VelocityTable::new(&layout, &response, kind, field).unwrap()).into();
        let mut accumulator = VibrationAccumulator::new(layout);
        let elements: Vec<usize> = (0..layout.elements).collect();
        accumulator.set_elements(ElementVelocities::new(&layout, first, tables, elements));
        for row in noise(&layout, 6 * layout.hop() + 3, 30.0, 17).chunks_exact(COLUMNS) {
            accumulator.push(row, 0.0);
        }
        let patch = accumulator.finish().unwrap();
        assert_eq!(patch.segments, 5);
        let request = SpectraRequest { fields: &fields, kind, maps: false };
        let (spectra, _) = field_spectra(&patch, &response, &request).unwrap();
        for (field, points) in spectra.iter().zip([0..14, 14..28]) {
            let largest = field.material_varying.power.iter().fold(0.0_f64, |a, &b| a.max(b));
            for bin in 0..layout.bins() - 1 {
                let sum: f64 = points.clone().map(|point| element_spectrum(&patch, point).power[bin]).sum();
                let error = (sum / 14.0 - field.material_varying.power[bin]).abs() / largest;
                assert!(error < 1e-10, "{:?}, q = {substeps}, bin {bin}: {error:e}", field.field);
            }
        }
    }
}

#[test]
fn a_standing_force_is_still_beside_the_road_and_turns_with_the_tyre() {
    let layout = layout(ELEMENTS, 1, 2, 0);
    let force = 700.0;
    let mut row = [0.0; COLUMNS];
    row[2] = force;
    let forces: Vec<f64> = (0..3 * layout.hop()).flat_map(|_| row).collect();
    let patch = accumulated(&layout, &forces).finish().unwrap();
    let request = SpectraRequest { fields: &[VibrationField::Tread], kind: TransferKind::Exact, maps: false };
    let (spectra, dissipation) = field_spectra(&patch, &response(), &request).unwrap();
    let rotation = 2.0 * PI / (ELEMENTS as f64 * TIME_STEP);
    let velocity = |n: usize| {
        let s = Complex64::new(0.0, n as f64 * rotation);
        s * model().evaluate(n, s, Field::Surface).unwrap()
    };
    let twice = |n: usize| if n == 0 || n == ELEMENTS / 2 { 1.0 } else { 2.0 };
    let square: f64 = (0..=ELEMENTS / 2).map(|n| twice(n) * velocity(n).norm_sqr() * force * force).sum();
    let power: f64 = (0..=ELEMENTS / 2).map(|n| twice(n) * velocity(n).re * force * force).sum();
    assert!((spectra[0].mean_pattern / square - 1.0).abs() < 1e-12);
    assert!((dissipation.mean_pattern / power - 1.0).abs() < 1e-12);
    assert!(spectra[0].non_rotating.mean_square() < 1e-20 * square);
    // Lines at the multiples of the rotation, two bins apart here, and nothing between them.
    for (bin, found) in spectra[0].material.power.iter().enumerate() {
        let n = bin / 2;
        let line = if bin % 2 == 0 { twice(n) * velocity(n).norm_sqr() * force * force } else { 0.0 };
        assert!((found - line).abs() < 1e-12 * square, "bin {bin}: {found} {line}");
    }
}

#[test]
fn a_record_mirrored_in_space_and_time_has_the_same_waves() {
    // Few enough bins for the mean pattern, which the first segment gives, to be taken off exactly in all of them.
    let layout = layout(14, 1, 1, 0);
    let forces = noise(&layout, 4 * layout.hop(), 3.0, 21);
    let spectra = |forces: &[f64]| accumulated(&layout, forces).finish().unwrap();
    let mirrored: Vec<f64> =
        forces.chunks_exact(COLUMNS).rev().flat_map(|row| row.iter().rev().copied().collect::<Vec<_>>()).collect();
    let (one, other) = (spectra(&forces), spectra(&mirrored));
    for bin in 0..layout.bins() {
        let (row, back) = (one.row(bin), other.row(bin));
        let largest = row.iter().fold(0.0_f64, |a, &b| a.max(b));
        for index in 0..layout.wavenumbers() {
            // Each mirror conjugates, so that n stays with its bin.
            assert!((row[index] - back[index]).abs() < 1e-11 * largest.max(1.0), "bin {bin}, {index}");
        }
    }
}

#[test]
fn stopped_anywhere_it_goes_on_with_the_same_bits_on_any_number_of_threads() {
    let layout = layout(ELEMENTS, 2, 1, 0);
    let forces = noise(&layout, 5 * layout.hop() + 7, 20.0, 2);
    let table = VelocityTable::new(&layout, &response(), TransferKind::Exact, VibrationField::Belt).unwrap();
    let new = || {
        let mut accumulator = VibrationAccumulator::new(layout);
        table.add_points(&mut accumulator, &[0.2]);
        let table = VelocityTable::new(&layout, &response(), TransferKind::Exact, VibrationField::Tread).unwrap();
        accumulator.set_elements(ElementVelocities::new(&layout, 3, vec![table], vec![9]));
        accumulator
    };
    let push = |accumulator: &mut VibrationAccumulator, forces: &[f64]| {
        forces.chunks_exact(COLUMNS).for_each(|row| {
            accumulator.push(row, row[0]);
        });
    };
    let bits = |patch: &PatchSpectra| {
        let all = patch.powers.iter().chain(&patch.points[0]).chain(&patch.elements[0]).chain([&patch.mean_power]);
        all.map(|x| x.to_bits()).collect::<Vec<_>>()
    };
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let whole = pool(1).install(|| {
        let mut whole = new();
        push(&mut whole, &forces);
        bits(&whole.finish().unwrap())
    });
    for stop in [0, 1, layout.hop(), layout.length(), layout.length() + 3, 4 * layout.hop() + 1] {
        let stop = stop * COLUMNS;
        let stopped = pool(2).install(|| {
            let mut first = new();
            push(&mut first, &forces[..stop]);
            let mut state = StateWriter::default();
            first.save(&mut state);
            let bytes = state.into_bytes();
            let mut second = new();
            let mut reader = StateReader::new(&bytes);
            second.restore(&mut reader).unwrap();
            reader.end().unwrap();
            push(&mut second, &forces[stop..]);
            bits(&second.finish().unwrap())
        });
        assert_eq!(whole, stopped, "stopped after {stop}");
    }
}

#[test]
fn less_than_a_segment_is_nothing_and_a_rest_is_left_out() {
    let layout = layout(ELEMENTS, 1, 1, 0);
    let forces = noise(&layout, 3 * layout.hop() - 1, 5.0, 4);
    assert!(accumulated(&layout, &forces[..COLUMNS * (layout.length() - 1)]).finish().is_none());
    let rest = accumulated(&layout, &forces);
    assert_eq!(rest.segments(), 1);
    let exact = accumulated(&layout, &forces[..COLUMNS * layout.length()]);
    assert_eq!(rest.finish(), exact.finish());
}
