//! Runs in memory.

use std::sync::atomic::AtomicBool;

use super::Simulation;
use super::prepare::checked;
use crate::counters::process::cpu_time;
use crate::numeric::RunningMoments;
use crate::plan::Plan;
use crate::response::{BandLevel, PowerSpectrum};
use crate::results::summary::RollingResistance;
use crate::scene::{DEFAULT, LoadedScene, PLATE, Scene, Setting};
use crate::test_models::{self, edit};

fn scene(changes: &[(&str, &str)]) -> LoadedScene {
    let small = [("numerics.elements", "128"), ("numerics.substeps", "4"), ("rolling.duration", "0.3")];
    test_models::scene(&edit(&edit(PLATE, &small), changes))
}

#[test]
fn rolling_resistance_on_smooth_road_is_the_forces_moment() {
    for (rule, lag) in [("bdf2", 0.0), ("sdirk2", 0.5)] {
        let (found, expected, load) = smooth(rule, lag);
        // Elements that have just come into contact were above the plane two steps before; contact lasts some 20 steps.
        assert!((found.power / expected - 1.0).abs() < 0.15, "{rule}: {} W for {expected} W", found.power);
        assert!((found.force * load / found.power - 1.0).abs() < 1e-12);
        assert!((0.001..0.1).contains(&found.coefficient), "{}", found.coefficient);
    }
}

/// Rolling resistance on a smooth road, the mean moment of its forces times the speed of rotation \[W\], and the speed;
/// forces belong to a time `lag` steps before a step's end.
fn smooth(rule: &str, lag: f64) -> (RollingResistance, f64, f64) {
    let rule = format!("\"{rule}\"");
    let loaded = scene(&[("road", "{ kind = \"smooth\" }"), ("numerics.time_rule", &rule)]);
    let plan = Plan::of(&loaded).unwrap();
    let mut run = Simulation::begin(&loaded, &plan, &AtomicBool::new(false)).unwrap();
    let radius = plan.radius;
    // An element in contact follows the plane: its indentation grows by V x/sqrt(R^2 - x^2), x ahead of the axle.
    let mut work = RunningMoments::default();
    while let Some(step) = run.step().unwrap() {
        let march = &run.prepared.march;
        let number = march.next_step() - 1;
        let geometry = march.geometry();
        let power = march.footprint().mean().iter().enumerate().map(|(column, force)| {
            let x = geometry.position_between(step.first_element + column as i64, number as f64 - lag);
            force * plan.speed * x / (radius * radius - x * x).sqrt()
        });
        if number >= plan.warm_up_steps {
            work.push(power.sum());
        }
    }
    let found = run.finish().rolling_resistance.unwrap();
    (found, work.mean().unwrap(), plan.speed)
}

#[test]
fn uncoupled_points_have_no_rolling_resistance() {
    let loaded = scene(&[("contact.tread", "\"uncoupled\""), ("rolling.duration", "0.05")]);
    let plan = Plan::of(&loaded).unwrap();
    let mut run = Simulation::begin(&loaded, &plan, &AtomicBool::new(false)).unwrap();
    while run.step().unwrap().is_some() {}
    assert_eq!(run.finish().rolling_resistance, None);
}

#[test]
fn a_mass_too_light_for_uncoupled_points_is_refused() {
    let of = |mass: f64| {
        let axle = format!("{{ load = 3400.0, mass = {mass:?}, stiffness = 1e4, damping = 10.0 }}");
        checked(&scene(&[("contact.tread", "\"uncoupled\""), ("rolling.axle", &axle)])).map(drop)
    };
    let reported = of(0.05).unwrap_err().to_string();
    assert!(reported.contains("too fast for a step"), "{reported}");
    of(200.0).unwrap();
}

/// The default scene with the given settings of contact and poles, to a tolerance of the contact conditions: forces,
/// processor seconds per step, and the time step.
fn rolled_to(contact: &str, poles: &str, tolerance: f64, seconds: f64) -> (Vec<f64>, f64, f64) {
    let settings = [
        format!("contact={{{contact}}}"),
        format!("numerics={{{poles},contact_tolerance={tolerance:e}}}"),
        "rolling.axle={indentation=0.0168,ramp=0.0}".to_owned(),
        "rolling.warm_up=0.0".to_owned(),
        format!("rolling.duration={seconds}"),
    ];
    let settings: Vec<Setting> = settings.iter().map(|text| Setting::parse(text).unwrap()).collect();
    let loaded = Scene::from_str_with(DEFAULT, "default", &settings).unwrap();
    let plan = Plan::of(&loaded).unwrap();
    let mut run = Simulation::begin(&loaded, &plan, &AtomicBool::new(false)).unwrap();
    let mut forces = Vec::new();
    let begin = cpu_time().unwrap();
    while let Some(step) = run.step().unwrap() {
        forces.push(step.total_force);
    }
    let spent = cpu_time().unwrap() - begin;
    (forces, spent.as_secs_f64() / plan.steps as f64, plan.time_step)
}

/// Third octaves of a force after its first fifth.
fn levels(forces: &[f64], time_step: f64) -> Vec<BandLevel> {
    let skipped = forces.len() / 5;
    PowerSpectrum::of(&forces[skipped..], time_step, Some(0.1)).unwrap().third_octaves(60.0, 1.0)
}

/// Largest difference of levels below a frequency \[dB\].
fn difference(a: &[BandLevel], b: &[BandLevel], high: f64) -> f64 {
    let bands = a.iter().zip(b).filter(|(a, _)| a.band.mid_frequency() < high);
    bands.fold(0.0_f64, |worst, (a, b)| worst.max((a.level - b.level).abs()))
}

#[test]
fn single_precision_changes_levels_of_slices_by_less_than_2e_3_db() {
    // The second tolerance is the least that permits single precision, the first hardly smaller.
    let found = [9.999e-7, 1e-6].map(|tolerance| {
        let (forces, _, time_step) = rolled_to("zone=\"slices\"", "elements=256,pole_tolerance=1e-3", tolerance, 0.5);
        levels(&forces, time_step)
    });
    let error = difference(&found[0], &found[1], 2100.0);
    println!("{error:.1e} dB");
    assert!(error > 0.0 && error < 2e-3, "{error:e}");
}

#[test]
#[ignore = "measures"]
fn times_and_levels_by_tolerance() {
    let cells = ("zone=\"cells\",cells_across=30", "elements=512,pole_tolerance=1e-4", [1e-12, 1e-6, 1e-5, 1e-4], 0.5);
    let slices = |poles| ("zone=\"slices\"", poles, [1e-12, 9.999e-7, 1e-6, 1e-5], 2.0);
    let [short, long] = ["elements=512,pole_tolerance=1e-3", "elements=1024,pole_tolerance=1e-3"].map(slices);
    for (contact, poles, tolerances, seconds) in [cells, short, long] {
        let mut exact: Option<Vec<BandLevel>> = None;
        for tolerance in tolerances {
            let (forces, each, time_step) = rolled_to(contact, poles, tolerance, seconds);
            let found = levels(&forces, time_step);
            let exact = exact.get_or_insert_with(|| found.clone());
            println!(
                "{contact}, {poles}, to {tolerance:.0e}: {:.1} us a step, {:.3} of real time; \
                 off by {:.5} dB to 2 kHz, {:.5} dB to 4 kHz",
                1e6 * each,
                time_step / each,
                difference(exact, &found, 2100.0),
                difference(exact, &found, 4100.0)
            );
        }
    }
}
