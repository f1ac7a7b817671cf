//! Time rules side by side: order, stability of the inverse, and the hard cases of the model that touch them.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a failing test may panic, in its helpers, too")]

mod common;

use common::{CIRCUMFERENCE, mean_and_deviation, scene, scene_text};
use tyrewave::contact::ContactError;
use tyrewave::contact::axle::AxleHeight;
use tyrewave::contact::geometry::Geometry;
use tyrewave::contact::history::ModalHistory;
use tyrewave::contact::march::March;
use tyrewave::contact::slice_queue::SliceQueue;
use tyrewave::contact::stability::Stability;
use tyrewave::contact::tread::ContactKernel;
use tyrewave::pipeline::past::fetch;
use tyrewave::road::slices::SliceBuilder;
use tyrewave::scene::{TimeRule, Tread};
use tyrewave::tyre::influence::Field;
use tyrewave::tyre::rational::{FitOptions, RationalModel};

const SMOOTH: &str = "kind = \"smooth\"";
const INDENTED: &str = "speed_kmh = 80.0\nwarm_up = 0.05\nduration = 0.15\naxle = { indentation = 0.012, ramp = 0.03 }";

/// Poles of the default tyre with N elements.
fn model(elements: usize, speed: f64, tolerance: f64) -> RationalModel {
    let loaded = scene(&scene_text(elements, SMOOTH, INDENTED, "", ""));
    let options = FitOptions::new(&loaded.scene.tyre, elements, speed).with_tolerance(tolerance);
    fetch(&loaded.scene.tyre, &options).unwrap().model
}

/// The total force over `duration` \[s\] on a smooth road at 12 mm of indentation, without the program's refusals.
fn smooth_road(model: &RationalModel, rule: TimeRule, speed_kmh: f64, substeps: usize, duration: f64) -> Result<Vec<f64>, ContactError> {
    let elements = model.elements;
    let mut numerics = scene(&scene_text(elements, SMOOTH, INDENTED, "", "")).scene.numerics;
    numerics.time_rule = rule;
    let speed = speed_kmh / 3.6;
    let time_step = CIRCUMFERENCE / elements as f64 / (speed * substeps as f64);
    let geometry = Geometry::new(CIRCUMFERENCE, elements, substeps, 0.0, 0.11);
    let first = ModalHistory::first_weights(model, Field::Surface, rule, time_step).unwrap();
    let kernel = ContactKernel::new(Tread::Elastic, &first, elements, 0.0)?;
    let history = ModalHistory::new(model, Field::Surface, rule, time_step).unwrap();
    let mut march = March::new(geometry, kernel, Box::new(history), &numerics, time_step);
    let axle = AxleHeight::Fixed { indentation: 0.012, ramp: 0.05 / time_step };
    let mut slices = SliceQueue::starting_at(march.geometry().first_element(0));
    let flat = SliceBuilder::flat(1).unwrap().build_rows(&[0.0]).unwrap();
    let steps = (duration / time_step) as u64;
    let mut force = Vec::new();
    for step in 0..steps {
        let first = march.geometry().first_element(step);
        slices.forget_before(first);
        while slices.end() < first + march.geometry().columns as i64 {
            slices.extend(flat.iter().cloned());
        }
        force.push(march.step(&axle, &slices)?.total_force);
    }
    Ok(force)
}

/// std/mean of the last third.
fn unrest(force: &[f64]) -> f64 {
    let (mean, deviation) = mean_and_deviation(&force[force.len() * 2 / 3..]);
    deviation / mean
}

#[test]
#[ignore = "survey"]
fn survey() {
    for (n, speed) in [(256, 80.0), (256, 250.0), (512, 80.0)] {
        let model = model(n, speed / 3.6 * 4.0, 1e-6);
        for rule in TimeRule::ALL {
            for q in [1, 2, 4] {
                let dt = CIRCUMFERENCE / n as f64 / (speed / 3.6 * q as f64);
                let begin = std::time::Instant::now();
                let stability = Stability::of(&model, Field::Surface, rule, dt, 0.0).unwrap();
                let spent = begin.elapsed();
                let force = smooth_road(&model, rule, speed, q, 0.6);
                match force {
                    Ok(force) => println!("{n} {speed} {rule:?} q {q}: mean {:.2}, unrest {:.1e}, {stability:?} {spent:?}", mean_and_deviation(&force[force.len() * 2 / 3..]).0, unrest(&force)),
                    Err(error) => println!("{n} {speed} {rule:?} q {q}: {error}, {stability:?}"),
                }
            }
        }
    }
}
