//! Given volumes on cells of the tread against a source that goes by, written out in time.

use std::f64::consts::TAU;
use std::sync::Arc;

use num_complex::Complex32;

use super::model::PressureModel;
use super::stream::PressureStream;
use super::surface::{SurfaceGreen, UnderPatch};
use super::tests::across;
use super::transfer::PressureTransfers;
use crate::contact::geometry::Geometry;
use crate::numeric::legendre;
use crate::response::SqueezedVolumes;
use crate::response::vibration::{Across, SegmentLayout};
use crate::scene::{AirMotion, TimeRule};
use crate::test_models::{CIRCUMFERENCE, plate_tyre};
use crate::time_rule::Advance;
use crate::tyre::influence::SurfaceWaves;
use crate::tyre::tread_pattern::blocks::{NO_BLOCK, TreadBlocks};
use crate::tyre::tread_pattern::squeeze::Squeeze;

const ELEMENTS: usize = 128;
const AROUND: usize = 512;
const ACROSS: usize = 5;
/// Duration of a revolution \[s\].
const REVOLUTION: f64 = 0.09;
const DENSITY: f64 = 1.2;

/// A window over two fifths of the circumference.
fn window(advance: Advance) -> Geometry {
    Geometry::new(CIRCUMFERENCE, ELEMENTS, advance, 0.013, 0.2 * CIRCUMFERENCE)
}

/// A model whose volumes are given by cells.
fn model(window: &Geometry, rule: TimeRule) -> PressureModel {
    let tyre = plate_tyre();
    let layout = SegmentLayout {
        elements: ELEMENTS,
        advance: window.advance,
        revolutions: 2,
        columns: window.columns,
        across: Across::Resolved { components: ACROSS, values: 0 },
        rule,
        time_step: REVOLUTION / window.advance.steps(ELEMENTS) as f64,
        phase: window.substep(0),
        first_position: window.first_position(),
        circumference: CIRCUMFERENCE,
    };
    PressureModel {
        layout,
        waves: Arc::new(SurfaceWaves::new(&tyre, 2, 1, 100.0, 1e-3)),
        tangential: None,
        // Given volumes do not depend on the tyre's compliance.
        scale: 3.0,
        contact_width: tyre.contact_width,
        density: DENSITY,
        air: AirMotion::Road,
        highest: f64::INFINITY,
        delays: vec![0.0],
        strips: Some(ends().into()),
    }
}

/// Ends of the cells across \[m\].
fn ends() -> Vec<f64> {
    let width = plate_tyre().contact_width;
    (0..=ACROSS).map(|end| width * (end as f64 / ACROSS as f64 - 0.5)).collect()
}

/// G is the product of this function of x and of [`aside`] of y.
fn along(x: f64) -> f64 {
    let turn = TAU * x / CIRCUMFERENCE;
    0.3 + turn.cos() - 0.4 * (2.0 * turn).sin()
}

fn aside(y: f64) -> f64 {
    1.0 + 8.0 * y + 20.0 * y * y - 90.0 * y * y * y
}

/// G on the tread, or with values by strip under the patch in place of those at points.
fn field(along: fn(f64) -> f64, aside: fn(f64) -> f64, strips: Option<(&[f64], &[f64])>) -> SurfaceGreen {
    let half_width = 0.5 * plate_tyre().width;
    let length = CIRCUMFERENCE / AROUND as f64;
    let points: Vec<f64> = across(half_width, 4).into_iter().map(|[y, _]| y).collect();
    let part = |sign: f64| {
        points.iter().flat_map(move |&y| {
            let value = 0.5 * (aside(y) + sign * aside(-y));
            (0..AROUND).map(move |cell| Complex32::from((along((cell as f64 + 0.5) * length) * value) as f32))
        })
    };
    let values: Vec<Complex32> = part(1.0).chain(part(-1.0)).collect();
    // All round: sums over waves would ring at an end of the open part.
    let cells = AROUND / 2;
    let under_patch = strips.map(|(ends, of_strip)| {
        let row = |place: usize| {
            let x = (place as f64 + 0.5 - cells as f64) * length;
            of_strip.iter().map(move |value| Complex32::from((along(x) * value) as f32))
        };
        UnderPatch { cells, ends: ends.to_vec(), values: vec![(0..2 * cells).flat_map(row).collect(); 2] }
    });
    SurfaceGreen {
        frequencies: vec![10.0, 1000.0],
        around: AROUND,
        across: points,
        half_width,
        rings: 0,
        values: vec![values; 2],
        under_patch,
    }
}

/// Pressures of the volumes that `volumes` gives by step, in the order of time, and the step of the first.
fn received(
    model: &PressureModel,
    green: SurfaceGreen,
    steps: u64,
    mut volumes: impl FnMut(u64) -> Vec<f64>,
) -> (Vec<f64>, u64) {
    let transfers = PressureTransfers { model: model.clone(), greens: vec![green].into() };
    let mut stream = PressureStream::new(transfers, steps, usize::MAX);
    for step in 0..steps {
        stream.push(&volumes(step));
    }
    let mut found = Vec::new();
    stream.receive(None, |_, pressures, _| pressures.of(0, |block| found.extend_from_slice(block)));
    (found, PressureStream::first_step(&model.layout))
}

fn mean(of: impl Fn(f64) -> f64, [from, to]: [f64; 2]) -> f64 {
    let at = |node: f64| 0.5 * (from + to) + 0.5 * (to - from) * node;
    legendre::gauss(6).into_iter().map(|[node, weight]| 0.5 * weight * of(at(node))).sum()
}

#[test]
fn a_passing_volume_sounds_as_its_change_in_time() {
    // Ends of strips that do not coincide with those of cells.
    let half = 0.5 * plate_tyre().width;
    let (strips, of_strip) = ([-half, -0.041, -0.007, 0.012, 0.03, half], [0.0, 2.0, -1.0, 0.7, 0.3]);
    let in_strips = |[from, to]: [f64; 2]| -> f64 {
        let share = |ends: &[f64]| (ends[1].min(to) - ends[0].max(from)).max(0.0) / (to - from);
        strips.windows(2).zip(of_strip).map(|(ends, value)| share(ends) * value).sum()
    };
    let ends = ends();
    let over_two = Advance::over(2);
    let cases = [(1.into(), TimeRule::Bdf2), (2.into(), TimeRule::Bdf2), (over_two, TimeRule::Bdf2)];
    for (advance, rule) in cases.into_iter().chain([(1.into(), TimeRule::Sdirk2)]) {
        let window = window(advance);
        let model = model(&window, rule);
        let SegmentLayout { time_step, columns, .. } = model.layout;
        let steps = 2 * model.layout.length() as u64;
        // Times of the stages relative to the step's end.
        let late: Vec<f64> = model.layout.actions().iter().map(|[_, time]| *time).collect();
        for (j, is_open) in [(0, false), (2, false), (3, true), (1, true)] {
            // Largest where the element is under the axle, in the middle of the pressures that the stream gives.
            let middle = 5 * model.layout.length() as u64 / 8;
            let element = window.first_element(middle) + columns as i64 / 2;
            let volume = |time: f64| 1e-6 * (-0.5 * ((time - middle as f64 * time_step) / 3.5e-3).powi(2)).exp();
            let volumes = |step: u64| {
                let mut volumes = vec![0.0; late.len() * ACROSS * columns];
                let column = element - window.first_element(step);
                if (0..columns as i64).contains(&column) {
                    for (stage, late) in late.iter().enumerate() {
                        volumes[(stage * ACROSS + j) * columns + column as usize] =
                            volume(step as f64 * time_step + late);
                    }
                }
                volumes
            };
            let green = field(along, aside, is_open.then_some((&strips[..], &of_strip[..])));
            let (found, first) = received(&model, green, steps, volumes);
            let cell = [ends[j], ends[j + 1]];
            let across = if is_open { in_strips(cell) } else { mean(aside, cell) };
            let flow = |time: f64| {
                let x = window.position_between(element, time / time_step);
                let half = 0.5 * CIRCUMFERENCE / ELEMENTS as f64;
                let rate = (volume(time + 1e-6) - volume(time - 1e-6)) / 2e-6;
                rate * across * mean(along, [x - half, x + half])
            };
            let expected = |step: u64| {
                let (time, width) = (step as f64 * time_step, 2e-5);
                // A volume that goes in draws air after it.
                -DENSITY * (flow(time + width) - flow(time - width)) / (2.0 * width)
            };
            let expected: Vec<f64> = (0..found.len() as u64).map(|index| expected(first + index)).collect();
            let largest = expected.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
            let off = found.iter().zip(&expected).map(|(found, expected)| (found - expected).abs());
            let off = off.fold(0.0, f64::max) / largest;
            println!("{advance}, {rule:?}, cell {j}, open {is_open}: off by {off:.1e} of {largest:.2e} Pa");
            assert!(off < 2e-3, "{advance} {rule:?} {j} {is_open}: {off:e}");
        }
    }
}

#[test]
fn squeeze_is_silent_in_a_uniform_field_only() {
    // Blocks of three columns and two cells with voids between them, and a groove.
    let block = |i: usize, j: usize| if i % 4 < 3 && j < 2 { (i / 4) as u32 } else { NO_BLOCK };
    let of_cell = (0..ELEMENTS).flat_map(|i| (0..ACROSS).map(move |j| block(i, j))).collect();
    let count = ELEMENTS / 4;
    let blocks = TreadBlocks::whole(of_cell, &vec![5e-10; count]);
    let forces = Geometry::new(CIRCUMFERENCE, ELEMENTS, 1, 0.0, 0.1 * CIRCUMFERENCE);
    let level = |along: fn(f64) -> f64, aside: fn(f64) -> f64| {
        let mut volumes = SqueezedVolumes::new(Squeeze::new(&blocks, ACROSS), &forces);
        let model = model(&volumes.window().clone(), TimeRule::Bdf2);
        let steps = 2 * model.layout.length() as u64;
        let (found, _) = received(&model, field(along, aside, None), steps, |step| {
            let first = forces.first_element(step);
            let force = |cell: usize| {
                let (column, j) = (cell / ACROSS, cell % ACROSS);
                let place = (column as f64 + 0.5) / forces.columns as f64;
                let rough = 1.0 + 0.3 * ((first + column as i64) as f64 * 2.1 + j as f64).sin();
                let factor = 1.0 + 0.5 * (0.3 * step as f64).cos();
                50.0 * factor * rough * (std::f64::consts::PI * place).sin().powi(2)
            };
            volumes.of(step, &(0..forces.columns * ACROSS).map(force).collect::<Vec<f64>>()).to_vec()
        });
        (found.iter().map(|pressure| pressure * pressure).sum::<f64>() / found.len() as f64).sqrt()
    };
    let (even, uneven) = (level(|_| 1.0, |_| 1.0), level(|_| 1.0, aside));
    println!("G = 1: {even:.1e} Pa; G that differs across: {uneven:.1e} Pa");
    // Cancellation of the volumes in single precision.
    assert!(even < 1e-4 * uneven && uneven > 0.0, "{even:e} {uneven:e}");
}
