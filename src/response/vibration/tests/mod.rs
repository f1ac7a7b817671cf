//! The frequency domain against the time domain, step by step and element by element.

mod resolved;
mod tangential;
mod time_domain;
mod turning;

use std::f64::consts::PI;
use std::sync::OnceLock;

use num_complex::Complex64;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::response::PowerSpectrum;
use crate::scene::{PLATE, Scene, TimeRule, Tyre};
use crate::storage::state::SavedState;
use crate::time_rule::Advance;
use crate::tyre::influence::Field;
use crate::tyre::poles::model::Entry;
use crate::tyre::poles::{FitOptions, RationalModel, TangentialModel, WaveModes, fit};

const ELEMENTS: usize = 16;
const COLUMNS: usize = 5;
const TIME_STEP: f64 = 1e-3;

/// The tyre of the default scene in few elements: what is compared is exact for any model.
fn model() -> &'static RationalModel {
    static MODEL: OnceLock<RationalModel> = OnceLock::new();
    MODEL.get_or_init(|| {
        let tyre = Scene::from_str(PLATE, "default").unwrap().scene.tyre;
        fit(&tyre, &FitOptions::new(&tyre, ELEMENTS, 20.0).with_tolerance(1e-3)).unwrap()
    })
}

/// The model as if its tyre turned: with odd parts as large as the even ones, of waves that are not their own mirror.
fn turned(model: &RationalModel) -> RationalModel {
    let entries = (0..=model.largest_wavenumber()).map(|n| {
        let faces = [model.driven, Field::Bottom].map(|face| model.modes(n, face).unwrap());
        let size = if n == 0 || n == model.largest_wavenumber() { 0.0 } else { 1.0 };
        let odd = faces.map(|modes| {
            let odd = modes.residues.iter().enumerate().map(|(index, residue)| {
                let turn = if index < modes.pairs { Complex64::new(0.6, 0.8) } else { Complex64::new(-0.7, 0.0) };
                size * turn * residue
            });
            odd.collect()
        });
        Entry {
            poles: faces[0].poles.to_vec(),
            residues: faces.map(|modes| modes.residues.to_vec()),
            odd,
            constants: faces.map(|modes| modes.constant),
            ..Entry::default()
        }
    });
    RationalModel::assemble(model.elements, model.driven, model.top, model.tolerance, entries)
}

/// H_n(s) of a wave of either sign, at any s.
fn of_wave(modes: &WaveModes<'_>, n: i64, s: Complex64) -> Complex64 {
    modes.evaluate(s) + Complex64::i() * n.signum() as f64 * modes.evaluate_odd(s)
}

fn response() -> TyreResponse<'static> {
    TyreResponse { model: model(), scale: 1.0, spring: 0.0, tangential: None }
}

fn turning_response() -> TyreResponse<'static> {
    static MODEL: OnceLock<RationalModel> = OnceLock::new();
    TyreResponse { model: MODEL.get_or_init(|| turned(model())), ..response() }
}

fn layout(elements: usize, advance: impl Into<Advance>, revolutions: usize, phase: usize) -> SegmentLayout {
    SegmentLayout {
        elements,
        advance: advance.into(),
        revolutions,
        columns: COLUMNS,
        across: Across::Even,
        rule: TimeRule::Bdf2,
        time_step: TIME_STEP,
        phase,
        first_position: -0.3,
        circumference: 1.95,
    }
}

fn noise(layout: &SegmentLayout, steps: usize, mean: f64, seed: u64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    (0..steps * layout.width()).map(|_| mean + random.random_range(-1.0..1.0)).collect()
}

fn accumulated(layout: &SegmentLayout, forces: &[f64]) -> VibrationAccumulator {
    let mut accumulator = VibrationAccumulator::new(*layout);
    for row in forces.chunks_exact(layout.width()) {
        accumulator.push(row, 0.0);
    }
    accumulator
}

/// One segment of forces whose plain and squared-window means are zero at every place, so that no mean pattern is taken
/// off; and the same weighted with the window, as the accumulator transforms it.
fn windowed_segment(layout: &SegmentLayout, seed: u64) -> (Vec<f64>, Vec<f64>) {
    let width = layout.width();
    let mut forces = noise(layout, layout.length(), 0.0, seed);
    for place in 0..layout.places() {
        let (column, phase) = (place / layout.substeps(), place % layout.substeps());
        let steps: Vec<usize> = (layout.first_step(phase)..layout.length()).step_by(layout.substeps()).collect();
        let swing = |step: usize| 2.0 * layout.weight(step).powi(2) - 1.0;
        // Repeated: the swing's mean over a substep's steps is not exactly zero.
        for _ in 0..60 {
            let count = steps.len() as f64;
            let mean = steps.iter().map(|&step| forces[step * width + column]).sum::<f64>() / count;
            let weighted = steps.iter().map(|&step| swing(step) * forces[step * width + column]).sum::<f64>() / count;
            for &step in &steps {
                forces[step * width + column] -= mean + weighted * swing(step);
            }
        }
    }
    let weighted = forces.iter().enumerate().map(|(index, force)| layout.weight(index / width) * force).collect();
    (forces, weighted)
}

#[test]
fn nothing_is_lost_between_places_and_waves() {
    for (substeps, rule) in [1, 2, 3].into_iter().flat_map(|q| [(q, TimeRule::Bdf2), (q, TimeRule::Sdirk3)]) {
        // Few enough bins for the mean pattern to be taken off exactly in all of them.
        let layout = SegmentLayout { rule, ..layout(14, substeps, 1, substeps - 1) };
        let (steps, width) = (4 * layout.hop(), layout.width());
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
            for column in 0..width {
                let sum = &mut sums[place(step, column)];
                sum[0] += weight(step) * forces[step * width + column];
                sum[1] += weight(step);
            }
        }
        let (mut varying, mut standing, mut weights) = (0.0, 0.0, 0.0);
        for step in 0..steps {
            weights += weight(step);
            for column in 0..width {
                let [sum, weights] = sums[place(step, column)];
                let mean = sum / weights;
                varying += weight(step) * (forces[step * width + column] - mean).powi(2);
                standing += weight(step) * mean * mean;
            }
        }
        // sum |F_n|^2 = N sum F_e^2.
        let (varying, standing) = (14.0 * varying / weights, 14.0 * standing / weights);
        let all = |bin: usize, row: &[f64]| {
            let waves = layout.wavenumbers();
            let powers = row[..layout.stages() * waves].iter().enumerate();
            powers.map(|(index, power)| layout.sides(bin) * layout.share(index % waves) * power).sum::<f64>()
        };
        let vibration: f64 = (0..layout.bins()).map(|bin| all(bin, patch.row(bin))).sum();
        let pattern: f64 = patch.mean_pattern.iter().map(|(bin, row)| all(*bin, row)).sum();
        assert!((vibration / varying - 1.0).abs() < 1e-10, "q = {substeps}: {vibration} {varying}");
        assert!((pattern / standing - 1.0).abs() < 1e-10, "q = {substeps}: {pattern} {standing}");
    }
}

#[test]
fn both_frames_have_the_same_power_and_maps_and_bands_hold_it() {
    let tyre = Scene::from_str(PLATE, "default").unwrap().scene.tyre;
    // Turning with the layout.
    let angular_velocity = -2.0 * PI / (2 * ELEMENTS) as f64 / TIME_STEP;
    let turning = Tyre { curvature: true, angular_velocity, ..tyre };
    let fitted = fit(&turning, &FitOptions::new(&turning, ELEMENTS, 20.0).with_tolerance(1e-3)).unwrap();
    assert!(fitted.turns());
    let responses =
        [(response(), true), (TyreResponse { model: &fitted, ..response() }, true), (turning_response(), false)];
    for (rule, kind) in [
        (TimeRule::Bdf2, TransferKind::Exact),
        (TimeRule::Sdirk2, TransferKind::Exact),
        (TimeRule::Sdirk2, TransferKind::Rule),
        (TimeRule::Sdirk3, TransferKind::Rule),
    ] {
        for (response, passive) in &responses {
            let dissipation = same_power(SegmentLayout { rule, ..layout(ELEMENTS, 2, 3, 1) }, kind, response);
            let dissipates = dissipation.mean_pattern > 0.0 && dissipation.vibration > 0.0;
            assert!(dissipates || !passive, "a passive tyre dissipates");
        }
    }
}

fn same_power(layout: SegmentLayout, kind: TransferKind, response: &TyreResponse<'_>) -> Dissipation {
    let patch = accumulated(&layout, &noise(&layout, 5 * layout.hop(), 9.0, 11)).finish().unwrap();
    let fields = [VibrationField::Tread, VibrationField::Belt];
    let request = SpectraRequest { fields: &fields, kind, maps: true };
    let (spectra, dissipation) = field_spectra(&patch, response, &request).unwrap();
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
    dissipation
}

#[test]
fn points_all_round_have_the_mean_over_the_circumference() {
    for (rule, kind) in [(TimeRule::Bdf2, TransferKind::Exact), (TimeRule::Sdirk2, TransferKind::Rule)] {
        for response in [response(), turning_response()] {
            points_all_round(SegmentLayout { rule, ..layout(ELEMENTS, 2, 2, 0) }, kind, &response);
        }
    }
}

fn points_all_round(layout: SegmentLayout, kind: TransferKind, response: &TyreResponse<'_>) {
    let stages = layout.stages();
    let mut accumulator = VibrationAccumulator::new(layout);
    let table = VelocityTable::new(&layout, response, kind, VibrationField::Belt).unwrap();
    // More points than waves: no two waves look alike on them.
    let count = 2 * ELEMENTS;
    let positions: Vec<f64> = (0..count).map(|point| point as f64 * 1.95 / count as f64 - 0.9).collect();
    accumulator.add_points(&table, &positions);
    for row in noise(&layout, 4 * layout.hop(), 2.0, 8).chunks_exact(layout.width()) {
        accumulator.push(row, 0.0);
    }
    let patch = accumulator.finish().unwrap();
    for bin in 0..layout.bins() {
        // By wave: the two halves of the shortest one are a quarter of its power each here, half everywhere (where its
        // elements are).
        let wave = |index: usize| {
            let n = layout.wavenumber(index);
            let share = layout.share(index).powi(2);
            let mut weights = vec![0.0; products::count(stages)];
            let velocity = |stage: usize| table.at(stage, n, layout.material_bin(bin, n));
            products::weights_of_square(stages, velocity, &mut weights);
            let product = |number: usize| patch.row(bin)[number * layout.wavenumbers() + index];
            share * layout.sides(bin) * products::form(stages, &weights, false, product)
        };
        let expected: f64 = (0..layout.wavenumbers()).map(wave).sum();
        let mean = (0..count).map(|point| point_spectrum(&patch, point).power[bin]).sum::<f64>() / count as f64;
        assert!((mean / expected - 1.0).abs() < 1e-9, "bin {bin}: {mean} {expected}");
    }
}

#[test]
fn all_elements_have_the_mean_over_the_circumference() {
    let tyre = Scene::from_str(PLATE, "default").unwrap().scene.tyre;
    // Segments of an odd number of revolutions begin half a turn on; few enough bins for the mean pattern, which the
    // first segment does not know, to be taken off exactly in all of them.
    for (substeps, revolutions, phase, first) in [(1, 1, 0, 5), (2, 1, 1, -3), (3, 1, 2, 40)] {
        let layout = layout(14, substeps, revolutions, phase);
        let options = FitOptions::new(&tyre, layout.elements, 20.0).with_tolerance(1e-3);
        let model = fit(&tyre, &options).unwrap();
        let top = layout.angular_frequency(layout.bins() - 1);
        let tangential = crate::tyre::poles::tangential_model(&tyre, &model, top).unwrap();
        let response = TyreResponse { model: &model, scale: 1.0, spring: 1e-6, tangential: Some(&tangential) };
        // As if it turned: another function for the odd part of the tangential motion.
        let other = TangentialModel {
            odd_residues: tangential.residues.iter().cycle().skip(1).zip(&tangential.residues).map(swapped).collect(),
            odd_constants: tangential.constants.iter().rev().copied().collect(),
            ..tangential.clone()
        };
        let turning = turned(&model);
        let turning = TyreResponse { model: &turning, tangential: Some(&other), ..response };
        for (rule, kind) in [
            (TimeRule::Bdf2, TransferKind::Exact),
            (TimeRule::Sdirk2, TransferKind::Rule),
            (TimeRule::Sdirk3, TransferKind::Rule),
        ] {
            for response in [&response, &turning] {
                mean_over_elements(SegmentLayout { rule, ..layout }, kind, first, response);
            }
        }
    }
}

/// Residues of another wavenumber for as many poles.
fn swapped((other, residues): (&Vec<Complex64>, &Vec<Complex64>)) -> Vec<Complex64> {
    residues
        .iter()
        .zip(other.iter().cycle())
        .map(|(residue, other)| if residue.im == 0.0 { other.re.into() } else { *other })
        .collect()
}

fn mean_over_elements(layout: SegmentLayout, kind: TransferKind, first: i64, response: &TyreResponse<'_>) {
    let fields = [VibrationField::Tread, VibrationField::Tangential];
    let tables = fields.map(|field| VelocityTable::new(&layout, response, kind, field).unwrap()).into();
    let mut accumulator = VibrationAccumulator::new(layout);
    let elements: Vec<usize> = (0..layout.elements).collect();
    accumulator.set_elements(ElementVelocities::new(&layout, first, tables, elements));
    for row in noise(&layout, 6 * layout.hop() + 3, 30.0, 17).chunks_exact(layout.width()) {
        accumulator.push(row, 0.0);
    }
    let patch = accumulator.finish().unwrap();
    assert_eq!(patch.segments, 5);
    let request = SpectraRequest { fields: &fields, kind, maps: false };
    let (spectra, _) = field_spectra(&patch, response, &request).unwrap();
    for (field, points) in spectra.iter().zip([0..14, 14..28]) {
        let largest = field.material_varying.power.iter().fold(0.0_f64, |a, &b| a.max(b));
        for bin in 0..layout.bins() - 1 {
            let sum: f64 = points.clone().map(|point| element_spectrum(&patch, point).power[bin]).sum();
            let error = (sum / 14.0 - field.material_varying.power[bin]).abs() / largest;
            assert!(error < 1e-10, "{:?}, q = {}, bin {bin}: {error:e}", field.field, layout.substeps());
        }
    }
}

#[test]
fn a_standing_force_turns_in_the_frame_of_the_tyre() {
    for response in [response(), turning_response()] {
        standing_force(&response);
    }
}

fn standing_force(response: &TyreResponse<'_>) {
    let layout = layout(ELEMENTS, 1, 2, 0);
    let force = 700.0;
    let mut row = [0.0; COLUMNS];
    row[2] = force;
    let forces: Vec<f64> = (0..3 * layout.hop()).flat_map(|_| row).collect();
    let patch = accumulated(&layout, &forces).finish().unwrap();
    let request = SpectraRequest { fields: &[VibrationField::Tread], kind: TransferKind::Exact, maps: false };
    let (spectra, dissipation) = field_spectra(&patch, response, &request).unwrap();
    let rotation = 2.0 * PI / (ELEMENTS as f64 * TIME_STEP);
    // A pattern at rest over the road, exp(i n (x - V t)): the wave n at -n V/R.
    let velocity = |n: usize| {
        let s = Complex64::new(0.0, -(n as f64) * rotation);
        s * of_wave(&response.model.modes(n, Field::Surface).unwrap(), n as i64, s)
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
fn stopped_vibration_continues_in_the_same_bits_on_any_threads() {
    for rule in [TimeRule::Bdf2, TimeRule::Sdirk2] {
        stopped_anywhere(SegmentLayout { rule, ..layout(ELEMENTS, 2, 1, 0) });
    }
}

fn stopped_anywhere(layout: SegmentLayout) {
    let forces = noise(&layout, 5 * layout.hop() + 7, 20.0, 2);
    let response = turning_response();
    let table = VelocityTable::new(&layout, &response, TransferKind::Exact, VibrationField::Belt).unwrap();
    let new = || {
        let mut accumulator = VibrationAccumulator::new(layout);
        accumulator.add_points(&table, &[0.2]);
        let table = VelocityTable::new(&layout, &response, TransferKind::Exact, VibrationField::Tread).unwrap();
        accumulator.set_elements(ElementVelocities::new(&layout, 3, vec![table], vec![9]));
        accumulator
    };
    let push = |accumulator: &mut VibrationAccumulator, forces: &[f64]| {
        forces.chunks_exact(layout.width()).for_each(|row| {
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
        let stop = stop * layout.width();
        let stopped = pool(2).install(|| {
            let mut first = new();
            push(&mut first, &forces[..stop]);
            let mut second = new();
            SavedState::of(&mut first).unwrap().restore(&mut second).unwrap();
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
