//! A run stepped by its caller: the contact force on a rough road, printed while it rolls, a line every few
//! milliseconds.
//!
//! `cargo run --release --example forces_live`
#![allow(clippy::print_stdout, reason = "an example shows what it found")]

use std::error::Error;
use std::sync::atomic::AtomicBool;

use tyrewave::scene::PLATE;
use tyrewave::{Plan, Scene, Simulation};

/// Force per character of a bar \[N\].
const NEWTONS: f64 = 100.0;
/// Time between two lines \[s\].
const EVERY: f64 = 2e-3;

fn main() -> Result<(), Box<dyn Error>> {
    // The shipped scene of a flat tyre, coarser and shorter.
    let mut loaded = Scene::from_str(PLATE, "plate")?;
    let scene = &mut loaded.scene;
    (scene.numerics.elements, scene.numerics.pole_tolerance) = (128, 1e-3);
    (scene.rolling.warm_up, scene.rolling.duration) = (0.5, 0.2);
    let plan = Plan::of(&loaded)?;
    plan.check(&loaded)?;

    let mut run = Simulation::begin(&loaded, &plan, &AtomicBool::new(false))?;
    let steps_a_line = (EVERY / run.time_step()).ceil() as u64;
    while let Some(step) = run.step()? {
        let done = run.next_step();
        let time = done as f64 * run.time_step();
        // The tyre has settled into rolling by then.
        if time >= loaded.scene.rolling.warm_up && done.is_multiple_of(steps_a_line) {
            let bar = "#".repeat((step.total_force / NEWTONS) as usize);
            println!("{time:7.4} s {:6.0} N {bar}", step.total_force);
        }
    }
    let results = run.finish();
    let [mean, variation] = [results.mean_force, results.rms_force_variation].map(Option::unwrap_or_default);
    println!("mean {mean:.0} N, variation {variation:.0} N rms");
    Ok(())
}
