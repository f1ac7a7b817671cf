//! Transfers against sums over the tread written out; pressures over time against signals that are known.

use std::f64::consts::TAU;
use std::sync::Arc;

use num_complex::{Complex32, Complex64};
use realfft::RealFftPlanner;

use super::model::PressureModel;
use super::shares::PressureShares;
use super::stream::{BlockPressures, PressureStream};
use super::surface::SurfaceGreen;
use super::transfer::{PressureSpectra, PressureTransfers};
use crate::numeric::{double, legendre};
use crate::response::vibration::{Across, SegmentLayout, TransferKind, TyreResponse, VelocityTable, VibrationField};
use crate::scene::{AirMotion, TimeRule, Tyre};
use crate::storage::state::SavedState;
use crate::test_models::{CIRCUMFERENCE, plate_tyre};
use crate::time_rule::Advance;
use crate::tyre::influence::SurfaceWaves;
use crate::tyre::poles::{FitOptions, fit};

pub(super) const AROUND: usize = 64;

pub(super) fn layout(rule: TimeRule, advance: impl Into<Advance>) -> SegmentLayout {
    let advance = advance.into();
    SegmentLayout {
        elements: 32,
        advance,
        revolutions: 2,
        columns: 5,
        across: Across::Even,
        rule,
        time_step: 0.09 / advance.steps(32) as f64,
        phase: advance.substeps - 1,
        first_position: -0.13,
        circumference: plate_tyre().circumference,
    }
}

/// A tyre that is a little softer than its waves, up to 150 Hz.
fn model(
    layout: SegmentLayout,
    waves: &Arc<SurfaceWaves>,
    tyre: &Tyre,
    air: AirMotion,
    delays: Vec<f64>,
) -> PressureModel {
    let (waves, contact_width) = (Arc::clone(waves), tyre.contact_width);
    PressureModel {
        layout,
        waves,
        tangential: None,
        scale: 1.1,
        contact_width,
        density: 1.2,
        air,
        highest: 150.0,
        delays,
        strips: None,
    }
}

/// Pressure of a unit force at each place, by bin and place.
struct UnitPressures(PressureSpectra);

impl UnitPressures {
    /// At a receiver with this G: a block for each place, in which it alone has a force.
    fn of(model: &PressureModel, green: SurfaceGreen) -> Self {
        let transfers = PressureTransfers { model: model.clone(), greens: vec![green].into() };
        let (bins, places) = (model.bins(), model.layout.places());
        let force = |place: usize| (0..bins * places).map(move |index| if index % places == place { 1.0 } else { 0.0 });
        let blocks: Vec<Vec<Complex32>> =
            (0..places).map(|place| force(place).map(Complex32::from).collect()).collect();
        Self(transfers.pressures(0..1, &blocks))
    }

    fn at(&self, bin: usize, place: usize) -> Complex64 {
        self.0.of_block(0, place).nth(bin).map(double).unwrap()
    }
}

/// Gauss points across half of the tread, rising, with their weights \[m\].
pub(super) fn across(half_width: f64, count: usize) -> Vec<[f64; 2]> {
    let scaled = |[node, weight]: [f64; 2]| [0.5 * half_width * (1.0 + node), 0.5 * half_width * weight];
    let mut points: Vec<[f64; 2]> = legendre::gauss(count).into_iter().map(scaled).collect();
    points.reverse();
    points
}

/// A smooth G, the same at all frequencies.
pub(super) fn green(x: f64, y: f64) -> Complex64 {
    let turn = TAU * x / CIRCUMFERENCE;
    Complex64::new(0.3 + turn.cos() - 0.4 * (2.0 * turn).sin(), turn.sin() + 20.0 * y * y)
}

fn surface_green(half_width: f64) -> SurfaceGreen {
    let length = CIRCUMFERENCE / AROUND as f64;
    let points: Vec<f64> = across(half_width, 4).into_iter().map(|[y, _]| y).collect();
    let row = |&y: &f64| (0..AROUND).map(move |cell| green((cell as f64 + 0.5) * length, y));
    let values = points.iter().flat_map(row).map(|value| Complex32::new(value.re as f32, value.im as f32));
    SurfaceGreen {
        frequencies: vec![50.0, 1000.0],
        around: AROUND,
        rings: 0,
        values: vec![values.collect(); 2],
        across: points,
        half_width,
        under_patch: None,
    }
}

/// Mean over a cell of a wave of n periods times the rate at which the air sees it move, in the frame of the axle at an
/// angular frequency, with one revolution in 2 pi/`turning` \[rad/s\].
pub(super) fn moving_wave(air: AirMotion, [angular, turning]: [f64; 2], n: i64, cell: usize) -> Complex64 {
    let of = |[node, weight]: [f64; 2]| {
        let angle = TAU * (cell as f64 + 0.5 + 0.5 * node) / AROUND as f64;
        let stream = match air {
            AirMotion::Axle => 0.0,
            AirMotion::Road => angle.cos(),
            AirMotion::WithTread => 1.0,
        };
        0.5 * weight * (angular - n as f64 * turning * stream) * Complex64::from_polar(1.0, n as f64 * angle)
    };
    legendre::gauss(8).into_iter().map(of).sum()
}

/// The curved tyre, turning once in 0.09 s as in the layout.
fn turning_tyre() -> Tyre {
    Tyre { curvature: true, angular_velocity: -TAU / 0.09, ..plate_tyre() }
}

#[test]
fn transfers_are_the_integral_over_the_moving_tread() {
    for tyre in [plate_tyre(), turning_tyre()] {
        integral_over_the_tread(&tyre);
    }
}

fn integral_over_the_tread(tyre: &Tyre) {
    let half_width = 0.5 * tyre.width;
    let waves = Arc::new(SurfaceWaves::new(tyre, AROUND / 2, 3, 3000.0, 1e-6));
    let lateral = waves.lateral.clone();
    let length = tyre.circumference / AROUND as f64;
    let (delay, fine) = (1e-4, across(half_width, 24));
    let [one, two, over_two] = [Advance::within(1), Advance::within(2), Advance::over(2)];
    for (rule, advance, air) in [
        (TimeRule::Sdirk2, two, AirMotion::Axle),
        (TimeRule::Bdf2, one, AirMotion::Axle),
        (TimeRule::Sdirk2, over_two, AirMotion::Axle),
        (TimeRule::Sdirk2, one, AirMotion::WithTread),
        (TimeRule::Sdirk2, two, AirMotion::Road),
        (TimeRule::Bdf2, one, AirMotion::Road),
    ] {
        let (layout, substeps) = (layout(rule, advance), advance.substeps);
        let model = model(layout, &waves, tyre, air, vec![delay]);
        let pressures = UnitPressures::of(&model, surface_green(half_width));
        assert_eq!(pressures.0.blocks(), layout.places());
        let bins = layout.bins().min((150.0 / layout.resolution()) as usize + 1);
        assert_eq!(pressures.0.of_block(0, 0).count(), bins);
        for (stage, column, phase, bin) in [(0, 0, 0, 3), (layout.stages() - 1, 4, substeps - 1, 9)] {
            let angular = layout.angular_frequency(bin);
            let x_c =
                layout.first_position + tyre.circumference / 32.0 * (column as f64 - phase as f64 / substeps as f64);
            // The field of a unit force, wave by wave, summed with G cell by cell and point by point.
            let mut expected = Complex64::ZERO;
            let mut values = vec![Complex64::ZERO; lateral.len()];
            for n in -15_i64..=15 {
                let turning = TAU / (layout.length() as f64 * layout.time_step) * 2.0;
                let material = angular - n as f64 * turning;
                let nyquist = std::f64::consts::PI / layout.time_step;
                let wrapped = (material + nyquist).rem_euclid(2.0 * nyquist) - nyquist;
                let [weight, time] = match rule.runge_kutta() {
                    None => [1.0, 0.0],
                    Some(method) => [method.weights()[stage], (method.nodes[stage] - 1.0) * layout.time_step],
                };
                let seen = if rule.is_multistep() {
                    (Complex64::new(0.0, wrapped) * rule.relative_rate(wrapped * layout.time_step)).im
                } else {
                    wrapped
                };
                waves.at(n, seen / TAU, &mut values);
                let kx = waves.waves.kx(n);
                let sinc = |x: f64| if x.abs() < 1e-9 { 1.0 } else { x.sin() / x };
                let stage_factor = Complex64::from_polar(weight, -wrapped * time);
                let force =
                    stage_factor * Complex64::from_polar(1.0, -kx * x_c) * sinc(0.5 * kx * tyre.circumference / 32.0);
                for (&m, compliance) in lateral.iter().zip(&values) {
                    let ky = waves.waves.ky(m);
                    let strip = 2.0 / tyre.width * sinc(0.5 * ky * tyre.contact_width);
                    for cell in 0..AROUND {
                        let middle = (cell as f64 + 0.5) * length;
                        let wave = moving_wave(air, [angular, turning], n, cell);
                        for &[y, weight] in &fine {
                            let area = 2.0 * weight * length;
                            let inward = 1.1 * force * strip * compliance * wave * (ky * y).cos() / tyre.circumference;
                            let outward = -Complex64::i() * inward;
                            expected += Complex64::i() * angular * 1.2 * green(middle, y) * outward * area;
                        }
                    }
                }
            }
            expected *= Complex64::from_polar(1.0, -angular * delay);
            let place = (stage * layout.columns + column) * substeps + phase;
            let found = pressures.at(bin, place);
            let error = (found - expected).norm() / expected.norm();
            let velocity = tyre.angular_velocity;
            assert!(error < 1e-5, "{velocity}/s, {rule:?}, {air:?}, stage {stage}: {found} {expected}");
        }
        assert!(pressures.at(0, 0).norm() < 1e-30, "what stands still is silent");
    }
}

#[test]
fn shares_of_waves_and_circumference_add_up_to_the_transfer() {
    let tyre = turning_tyre();
    let waves = Arc::new(SurfaceWaves::new(&tyre, AROUND / 2, 3, 3000.0, 1e-6));
    for (rule, air, bin) in [
        (TimeRule::Bdf2, AirMotion::Axle, 9),
        (TimeRule::Bdf2, AirMotion::WithTread, 3),
        (TimeRule::Bdf1, AirMotion::Axle, 3),
        (TimeRule::Bdf2, AirMotion::Road, 9),
    ] {
        // The middle column is the contact's centre.
        let layout = SegmentLayout { first_position: -2.0 * tyre.circumference / 32.0, ..layout(rule, 1) };
        let model = model(layout, &waves, &tyre, air, vec![0.0]);
        let known = surface_green(0.5 * tyre.width);
        let expected = UnitPressures::of(&model, known.clone()).at(bin, 2);
        let green = SurfaceGreen { frequencies: vec![bin as f64 * layout.resolution()], ..known };
        let shares = PressureShares::at(&model, &green, 0);
        let error = (shares.pressure - expected).norm() / expected.norm();
        assert!(error < 1e-5, "{rule:?}: {} {expected}", shares.pressure);
        assert_eq!((shares.most(), shares.cells.len()), (15, AROUND));
        let round: Complex64 = shares.cells.iter().sum();
        assert!((round - shares.pressure).norm() < 1e-6 * round.norm(), "{round} {}", shares.pressure);
        let all: f64 = shares.of_waves().iter().sum();
        let (by_wave, by_angle) = (shares.up_to_wave(), shares.up_to_angle(10));
        for sum in [all, by_wave[15], by_angle[9]] {
            assert!((sum - 1.0).abs() < 1e-6, "{sum}");
        }
        // The test's G has periods 0, 1 and 2 round the tyre and no others: waves beyond do not radiate, but for air
        // over the road, whose stream has one period.
        let most = if air == AirMotion::Road { 3 } else { 2 };
        assert!(shares.enough_waves() <= most && (by_wave[most] - 1.0).abs() < 1e-4, "{by_wave:?}");
        // Half of the way round is the contact, whatever the number of angles.
        assert!((by_angle[4] - shares.up_to_angle(2)[0]).abs() < 1e-12);
        assert!((0.0..=180.0).contains(&shares.enough_angle()));
    }
}

#[test]
fn what_radiates_is_the_velocity_of_the_vibration() {
    for tyre in [plate_tyre(), turning_tyre()] {
        radiates_what_vibrates(tyre);
    }
}

fn radiates_what_vibrates(tyre: Tyre) {
    // A strip as wide as the tyre, so that the strip's mean is that of the tread. G is a smooth hump over elements
    // beside the patch: waves shorter than two elements are aliased in the vibration, and absent in the sound.
    const ELEMENTS: usize = 128;
    const CELL: usize = 31;
    let tyre = Tyre { contact_width: tyre.width, ..tyre };
    let model = fit(&tyre, &FitOptions::new(&tyre, ELEMENTS, 22.0).with_tolerance(1e-4)).unwrap();
    let response = TyreResponse { model: &model, scale: 1.0, spring: 0.0, tangential: None };
    let layout = SegmentLayout {
        elements: ELEMENTS,
        revolutions: 2,
        time_step: 0.09 / ELEMENTS as f64,
        phase: 0,
        first_position: -0.03,
        ..layout(TimeRule::Sdirk2, 1)
    };
    let table = VelocityTable::new(&layout, &response, TransferKind::Exact, VibrationField::Tread).unwrap();
    let length = tyre.circumference / ELEMENTS as f64;
    let hump = |cell: usize| (-0.5 * ((cell as f64 - CELL as f64) / 5.0).powi(2)).exp();
    let cells = || CELL - 20..=CELL + 20;
    let half_width = 0.5 * tyre.width;
    let across: Vec<f64> = across(half_width, 4).into_iter().map(|[y, _]| y).collect();
    let at = |cell: usize| if cells().contains(&cell) { hump(cell) as f32 } else { 0.0 };
    let values = (0..4 * ELEMENTS).map(|index| at(index % ELEMENTS));
    let green = SurfaceGreen {
        frequencies: vec![50.0],
        around: ELEMENTS,
        rings: 0,
        values: vec![values.map(|value| Complex32::new(value, 0.0)).collect()],
        across,
        half_width,
        under_patch: None,
    };
    let waves = Arc::new(SurfaceWaves::new(&tyre, ELEMENTS / 2, 20, 0.5 / layout.time_step, 1e-6));
    let pressure = PressureModel {
        layout,
        waves,
        scale: 1.0,
        tangential: None,
        contact_width: tyre.contact_width,
        density: 1.2,
        air: AirMotion::WithTread,
        highest: 400.0,
        delays: vec![0.0],
        strips: None,
    };
    let turned_round = Tyre { angular_velocity: -tyre.angular_velocity, ..tyre.clone() };
    let other = SurfaceWaves::new(&turned_round, ELEMENTS / 2, 20, 0.5 / layout.time_step, 1e-6);
    let other = PressureModel { waves: Arc::new(other), ..pressure.clone() };
    let [pressures, of_other] = [pressure, other].map(|model| UnitPressures::of(&model, green.clone()));
    let mut inward = vec![Complex64::ZERO; layout.places()];
    let mut apart = 0.0_f64;
    for bin in [9, 16, 25] {
        let mut sum = vec![Complex64::ZERO; layout.places()];
        for cell in cells() {
            table.at_position((cell as f64 + 0.5) * length)(bin, &mut inward);
            sum.iter_mut().zip(&inward).for_each(|(sum, velocity)| *sum += hump(cell) * velocity);
        }
        let scale = Complex64::i() * layout.angular_frequency(bin) * 1.2 * length * tyre.width;
        for place in [0, 3, layout.columns + 4] {
            let error = |pressures: &UnitPressures| {
                let outward = pressures.at(bin, place) / scale;
                (outward + sum[place]).norm() / sum[place].norm()
            };
            let velocity = tyre.angular_velocity;
            assert!(error(&pressures) < 0.01, "{velocity}/s, bin {bin}, place {place}: {:e}", error(&pressures));
            apart = apart.max(error(&of_other));
        }
    }
    println!("{}/s, turned round: {apart:.1e}", tyre.angular_velocity);
    assert!(!tyre.turns() || apart > 0.1, "which way it turns is heard: {apart:e}");
}

#[test]
fn a_stream_of_delays_gives_the_delayed_forces_without_a_seam() {
    for (substeps, late) in [(1, 3_usize), (2, 10)] {
        let layout = layout(TimeRule::Sdirk2, substeps);
        let length = layout.length();
        let bins = length / 2 + 1;
        // One place alone radiates, later by whole steps.
        let place = (layout.columns + 2) * substeps + substeps - 1;
        let waves = Arc::new(SurfaceWaves::new(&plate_tyre(), 2, 1, 100.0, 1e-3));
        let model = PressureModel {
            highest: f64::INFINITY,
            ..model(layout, &waves, &plate_tyre(), AirMotion::Axle, vec![0.0])
        };
        let transfers = PressureTransfers { model, greens: vec![surface_green(0.1)].into() };
        let steps = 3 * length + 17;
        let mut stream = PressureStream::new(transfers.clone(), steps as u64, usize::MAX);
        let force = |step: usize, place: usize| ((step * 7 + place * 13) as f64 * 0.37).sin();
        let backward = RealFftPlanner::new().plan_fft_inverse(length);
        let mut found = Vec::new();
        for step in 0..steps {
            let forces: Vec<f64> = (0..layout.width()).map(|place| force(step, place)).collect();
            // Half-way the stream is stopped while a block waits, and another one continues from its state.
            if step == length + 5 {
                assert_eq!(stream.blocks_that_wait().len(), 1);
                let state = SavedState::of(&mut stream).unwrap();
                stream = PressureStream::new(transfers.clone(), steps as u64, usize::MAX);
                state.restore(&mut stream).unwrap();
            }
            let foreseen = stream.remaining_blocks(1).1;
            let is_due = stream.push(&forces) && stream.is_due();
            assert_eq!(foreseen, is_due, "{step}");
            if is_due {
                let blocks = stream.blocks_that_wait();
                let spectra = PressureSpectra::of([1, blocks.len(), bins], |_, block, bin| {
                    let turn = -TAU * (bin * late) as f64 / length as f64;
                    double(blocks[block][bin * layout.places() + place]) * Complex64::from_polar(2.0, turn)
                });
                assert!(found.is_empty(), "all blocks wait for the last one");
                BlockPressures::new(&layout, &*backward, spectra).of(0, |block| found.extend_from_slice(block));
            }
        }
        assert_eq!(found.len() as u64, PressureStream::samples(&layout, steps as u64));
        let first = PressureStream::first_step(&layout) as usize;
        let whole = |block: usize| -> Vec<f64> {
            let sounding = |step: usize| layout.phase_of(step) == substeps - 1;
            let begin = block * layout.hop();
            (begin..begin + length)
                .map(|step| if sounding(step) { 2.0 * force(step, layout.columns + 2) } else { 0.0 })
                .collect()
        };
        let sign = |step: usize| if step.is_multiple_of(2) { 1.0 } else { -1.0 };
        for (block, pressures) in found.chunks_exact(layout.hop()).enumerate() {
            // Mean and highest frequency of a block do not radiate.
            let forces = whole(block);
            let mean = forces.iter().sum::<f64>() / length as f64;
            let fastest = forces.iter().enumerate().map(|(n, force)| sign(n) * force).sum::<f64>() / length as f64;
            for (index, value) in pressures.iter().enumerate() {
                let emitted = first + index - late;
                let expected = forces[emitted] - mean - sign(emitted) * fastest;
                assert!((value - expected).abs() < 1e-5, "q = {substeps}, block {block}: {value} {expected}");
            }
        }
    }
}

#[test]
fn pressures_have_the_same_bits_however_many_blocks_wait() {
    let waves = Arc::new(SurfaceWaves::new(&plate_tyre(), AROUND / 2, 3, 3000.0, 1e-3));
    let components = waves.lateral.len();
    // Small and large products take different ways.
    let resolved = Across::Resolved { components, values: 0 };
    for (across, receivers) in [(Across::Even, 1), (resolved, 2), (resolved, 40)] {
        let layout = SegmentLayout { across, ..layout(TimeRule::Sdirk2, 1) };
        let delays = (0..receivers).map(|receiver| 1e-4 * receiver as f64).collect();
        let model = model(layout, &waves, &plate_tyre(), AirMotion::Road, delays);
        let mut greens = vec![surface_green(0.5 * plate_tyre().width); receivers];
        for (receiver, green) in greens.iter_mut().enumerate() {
            green.values.iter_mut().flatten().for_each(|value| *value *= 1.0 + receiver as f32);
        }
        let transfers = PressureTransfers { model, greens: greens.into() };
        let (hop, blocks) = (layout.hop(), 9);
        let steps = layout.length() + (blocks - 1) * hop;
        // Pressures by receiver, multiply-adds and passes.
        let received = |most_waiting: usize| {
            let mut stream = PressureStream::new(transfers.clone(), steps as u64, most_waiting);
            let (mut found, mut multiply_adds, mut passes) = (vec![Vec::new(); receivers], 0, 0);
            for step in 0..steps {
                let forces = (0..layout.width()).map(|place| ((step * 7 + place * 13) as f64 * 0.37).sin());
                if stream.push(&forces.collect::<Vec<f64>>()) && stream.is_due() {
                    multiply_adds += stream.multiply_adds();
                    passes += 1;
                    stream.receive(None, |some, pressures, _| {
                        for receiver in some.clone() {
                            let of = |block: &[f64]| found[receiver].extend(block.iter().map(|value| value.to_bits()));
                            pressures.of(receiver - some.start, of);
                        }
                    });
                }
            }
            (found, multiply_adds, passes)
        };
        let (one, four, all) = (received(1), received(4), received(usize::MAX));
        assert!(one.0.iter().all(|found| found.len() == blocks * hop && found.iter().any(|bits| *bits != 0)));
        assert!(one.0 == four.0 && one.0 == all.0, "{receivers} receivers");
        assert_eq!([one.2, four.2, all.2], [9, 3, 1]);
        assert!(one.1 > four.1 && four.1 > all.1, "{} {} {}", one.1, four.1, all.1);
    }
}

#[test]
fn memory_is_bounded_whatever_the_receivers_and_the_steps() {
    let layout = SegmentLayout { elements: 1024, revolutions: 6, columns: 142, ..layout(TimeRule::Sdirk2, 1) };
    let (bins, day) = (1318, 1_000_000_000);
    let most = PressureStream::most_waiting(&layout, day, f64::INFINITY);
    let bytes = |receivers, waiting| PressureStream::bytes(&layout, bins, waiting, receivers, [512, 6]);
    assert!(most <= 32);
    for (in_memory, steps, expected) in [(0.4, day, 1), (5.7, day, 5), (1e3, day, most), (1e3, 0, 1)] {
        assert_eq!(PressureStream::most_waiting(&layout, steps, in_memory), expected, "{in_memory} in memory");
    }
    for (receivers, batches) in [(1, 1), (131, 1), (284, 2), (10_000, 63)] {
        let (found, of_batch) = PressureStream::batches(receivers);
        assert!(found == batches && of_batch <= 160 && found * of_batch >= receivers, "{receivers}: {found}");
        let all = bytes(receivers, most);
        assert!(all <= bytes(160, most) && bytes(160, most) < 2.5e8, "{all}");
    }
    assert!(bytes(131, PressureStream::most_waiting(&layout, 3 * layout.length() as u64, 1e3)) < bytes(131, most));
}
