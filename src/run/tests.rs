//! Runs in memory.

use std::sync::atomic::AtomicBool;

use super::Simulation;
use crate::numeric::RunningMoments;
use crate::plan::Plan;
use crate::results::summary::RollingResistance;
use crate::scene::{LoadedScene, PLATE};
use crate::test_models::{self, edit};

fn scene(changes: &[(&str, &str)]) -> LoadedScene {
    let small = [("numerics.elements", "128"), ("numerics.substeps", "4"), ("rolling.duration", "0.3")];
    test_models::scene(&edit(&edit(PLATE, &small), changes))
}

#[test]
fn rolling_resistance_on_a_smooth_road_is_the_moment_of_the_forces() {
    for (rule, lag) in [("bdf2", 0.0), ("sdirk2", 0.5)] {
        let (found, expected, load) = smooth(rule, lag);
        // Elements that have just come down were above the plane two steps before; there are some 20 steps of
        // contact.
        assert!((found.power / expected - 1.0).abs() < 0.15, "{rule}: {} W for {expected} W", found.power);
        assert!((found.force * load / found.power - 1.0).abs() < 1e-12);
        assert!((0.001..0.1).contains(&found.coefficient), "{}", found.coefficient);
    }
}

/// Rolling resistance on a smooth road, the mean moment of its forces times the speed of rotation \[W\], and the
/// speed; forces belong to a time `lag` steps before the end.
fn smooth(rule: &str, lag: f64) -> (RollingResistance, f64, f64) {
    let rule = format!("\"{rule}\"");
    let loaded = scene(&[("road", "{ kind = \"smooth\" }"), ("numerics.time_rule", &rule)]);
    let plan = Plan::of(&loaded).unwrap();
    let mut run = Simulation::begin(&loaded, &plan, &AtomicBool::new(false)).unwrap();
    let radius = plan.radius;
    // An element in contact follows the plane: it is pressed in by V x/sqrt(R^2 - x^2), x ahead of the axle.
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
