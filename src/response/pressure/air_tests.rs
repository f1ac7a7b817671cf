//! Motions of the air at the tread: which motion of the tread radiates no sound in each, and where all three agree.

use std::f64::consts::TAU;
use std::sync::Arc;

use num_complex::{Complex32, Complex64};

use super::model::PressureModel;
use super::shares::PressureShares;
use super::stream::PressureStream;
use super::surface::SurfaceGreen;
use super::tests::across;
use super::transfer::PressureTransfers;
use crate::response::vibration::{Across, SegmentLayout};
use crate::scene::{AirMotion, TimeRule};
use crate::test_models::{CIRCUMFERENCE, plate_tyre};
use crate::tyre::influence::SurfaceWaves;

const AIRS: [AirMotion; 3] = [AirMotion::Axle, AirMotion::Road, AirMotion::WithTread];
const ELEMENTS: usize = 256;
const AROUND: usize = 512;
/// Number of lateral waves into which forces are resolved, even and odd ones.
const COMPONENTS: usize = 4;
/// Duration of a revolution \[s\].
const REVOLUTION: f64 = 0.09;

/// Forces all round the tyre, even over the strip or resolved across it.
fn layout(across: Across, rule: TimeRule) -> SegmentLayout {
    SegmentLayout {
        elements: ELEMENTS,
        advance: 1.into(),
        revolutions: 2,
        columns: ELEMENTS,
        across,
        rule,
        time_step: REVOLUTION / ELEMENTS as f64,
        phase: 0,
        first_position: -0.5 * CIRCUMFERENCE,
        circumference: CIRCUMFERENCE,
    }
}

/// Models of the same tyre, one for each motion of the air.
fn models(layout: SegmentLayout) -> [PressureModel; 3] {
    let tyre = plate_tyre();
    let lateral = match layout.across {
        Across::Even => vec![1, 3, 5],
        Across::Resolved { .. } => (1..=COMPONENTS).collect(),
    };
    let waves = Arc::new(SurfaceWaves::of(&tyre, AROUND / 2, lateral, 1500.0, 1e-6));
    AIRS.map(|air| PressureModel {
        layout,
        waves: Arc::clone(&waves),
        scale: 1.0,
        tangential: None,
        contact_width: tyre.contact_width,
        density: 1.2,
        air,
        highest: 1200.0,
        delays: vec![0.0],
        strips: None,
    })
}

/// G, even and odd across, that vanishes further from the contact than an angle \[degrees\].
fn green_within(degrees: f64, frequencies: Vec<f64>) -> SurfaceGreen {
    let half_width = 0.5 * plate_tyre().width;
    let points: Vec<f64> = across(half_width, 4).into_iter().map(|[y, _]| y).collect();
    let cells = (degrees / 360.0 * AROUND as f64) as usize;
    let value = |part: usize, y: f64, cell: usize| {
        let from = cell.min(AROUND - 1 - cell);
        let side = if 2 * cell < AROUND { 1.0 } else { -1.0 };
        let hump = 1.0 - ((from as f64 + 0.5) / cells as f64).powi(2);
        let even = hump.max(0.0) * Complex64::new(1.0 + 0.2 * side, 20.0 * y * y);
        let value = if part == 0 { even } else { even * 8.0 * y };
        Complex32::new(value.re as f32, value.im as f32)
    };
    let rows = (0..2).flat_map(|part| points.iter().map(move |&y| (part, y)));
    let values: Vec<Complex32> = rows.flat_map(|(part, y)| (0..AROUND).map(move |cell| value(part, y, cell))).collect();
    let values = vec![values; frequencies.len()];
    SurfaceGreen { frequencies, around: AROUND, across: points, half_width, rings: 0, values, under_patch: None }
}

/// Root mean square of the pressure under forces by step and column, in each motion of the air \[Pa\].
fn received(models: &[PressureModel; 3], green: &SurfaceGreen, force: impl Fn(usize, usize) -> f64) -> [f64; 3] {
    models.each_ref().map(|model| {
        let (layout, steps) = (model.layout, 2 * model.layout.length());
        let transfers = PressureTransfers { model: model.clone(), greens: vec![green.clone()].into() };
        let mut stream = PressureStream::new(transfers, steps as u64, usize::MAX);
        for step in 0..steps {
            let column = |index: usize| force(step, index % layout.columns);
            stream.push(&(0..layout.width()).map(column).collect::<Vec<f64>>());
        }
        let (mut sum, mut count) = (0.0, 0.0);
        stream.receive(None, |_, pressures, _| {
            pressures.of(0, |block| {
                sum += block.iter().map(|pressure| pressure * pressure).sum::<f64>();
                count += block.len() as f64;
            });
        });
        f64::sqrt(sum / count)
    })
}

#[test]
fn a_frozen_texture_is_silent_where_tyre_and_road_touch() {
    let resolved = Across::Resolved { components: COMPONENTS, values: 0 };
    for across in [Across::Even, resolved] {
        for (rule, n) in [(TimeRule::Bdf2, 20), (TimeRule::Sdirk2, 60)] {
            let models = models(layout(across, rule));
            // An element finds what the one before it found a step earlier: f(x + V t).
            let frozen = |step: usize, column: usize| (TAU * (n * (column + step)) as f64 / ELEMENTS as f64).cos();
            let [axle, road, with_tread] = received(&models, &green_within(5.0, vec![50.0, 1500.0]), frozen);
            println!("{across:?}, n = {n}: road {:.1e}, with-tread {:.1e}", road / axle, with_tread / axle);
            assert!(with_tread < 1e-6 * axle, "{across:?}, n = {n}: {with_tread} {axle}");
            assert!(road < 1e-2 * axle && road > 1e-4 * axle, "{across:?}, n = {n}: {road} {axle}");
            // At the top the air runs against the tread: as if the texture went by at twice the speed.
            let top = green_within(5.0, vec![50.0, 1500.0]);
            let values = top.values.iter().map(|of| {
                of.chunks_exact(AROUND).flat_map(|row| [&row[AROUND / 2..], &row[..AROUND / 2]].concat()).collect()
            });
            let top = SurfaceGreen { values: values.collect(), ..top };
            let [axle, road, _] = received(&models, &top, frozen);
            assert!((road / axle - 2.0).abs() < 0.01, "{across:?}, n = {n}, top: {road} {axle}");
        }
    }
}

#[test]
fn a_frozen_wave_alone_is_silent_to_rounding() {
    // A force in the middle has all components; the one that is checked is fixed to the road.
    for n in [3_i64, 20, 60, 100] {
        let green = green_within(5.0, vec![n as f64 / REVOLUTION]);
        let models = models(layout(Across::Even, TimeRule::Bdf2));
        let [axle, road, with_tread] = models.each_ref().map(|model| {
            let shares = PressureShares::at(model, &green, 0);
            shares.waves[(n + shares.most() as i64) as usize].norm()
        });
        assert!(with_tread < 1e-12 * axle, "n = {n}: {with_tread} {axle}");
        assert!(road < 1e-2 * axle && road > 1e-4 * axle, "n = {n}: {road} {axle}");
    }
}

#[test]
fn a_static_flattening_is_silent_in_every_air() {
    let models = models(layout(Across::Even, TimeRule::Sdirk2));
    let green = green_within(90.0, vec![50.0, 1500.0]);
    let patch = |column: usize| if column.abs_diff(ELEMENTS / 2) < 7 { 1.0 } else { 0.0 };
    let still = received(&models, &green, |_, column| patch(column));
    let vibrating = received(&models, &green, |step, column| patch(column) * (TAU * 20.0 * step as f64 / 256.0).cos());
    for (still, vibrating) in still.iter().zip(vibrating) {
        assert!(*still < 1e-9 * vibrating && vibrating > 0.0, "{still} {vibrating}");
    }
}

#[test]
fn as_the_speed_falls_all_airs_become_one() {
    let green = green_within(90.0, vec![100.0]);
    let apart = |slower: usize| {
        let layout = layout(Across::Even, TimeRule::Bdf2);
        // More steps of the same length make a longer revolution of the same tyre.
        let models = models(SegmentLayout { advance: slower.into(), ..layout });
        let [axle, others @ ..] = models.each_ref().map(|model| PressureShares::at(model, &green, 0).pressure);
        others.map(|other| (other - axle).norm() / axle.norm())
    };
    for (fast, slow) in apart(1).into_iter().zip(apart(10_000_000)) {
        assert!(fast > 1e-2 && slow < 1e-5, "{fast} {slow}");
    }
}
