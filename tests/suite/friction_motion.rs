//! Motion and sound under friction, and wheels that roll freely: whole runs.

use tyrewave::internals::{add, edit, scene};
use tyrewave::scene::Scene;

use super::friction::{SMOOTH, finite, gone_on_from_state};
use crate::common::run;

const MADE: &str = "kind = \"made\"\nseed = 3";
const BRAKED: &str = "[friction]\nmu = 0.9\n[friction.creep]\nlongitudinal = 0.05\nlateral = 0.02";
const FREE: &str = "[friction]\nmu = 0.9\n[friction.creep]\nlongitudinal = \"free\"";
const HEARD: &str = "[outputs.vibration]\ntread = true\nbelt = true\ntangential = true\npoints = [0.3]\nelements = [5]";

/// Returns the rms velocities of tread, belt and along of a run.
fn velocities(text: &str) -> Vec<f64> {
    let summary = run(text).summary();
    let fields = summary["vibration"]["fields"].as_array().unwrap().clone();
    fields.iter().map(|field| field["rms_velocity"].as_f64().unwrap()).collect()
}

#[test]
fn vibration_includes_tangential_forces() {
    let of = |friction: &str| velocities(&finite(&format!("{friction}\n{HEARD}"), MADE));
    let (without, none, with) = (of(""), of("[friction]\nmu = 0.0"), of(BRAKED));
    assert_eq!(without, none);
    println!("tread, belt, along: {without:?} m/s, with friction {with:?}");
    assert!(with.iter().zip(&without).all(|(with, without)| *with > 0.0 && (with / without - 1.0).abs() > 1e-3));
    assert!(with[2] > 1.5 * without[2], "forces along move the tread along: {with:?} {without:?}");
}

#[test]
fn threads_change_no_bit_of_velocities_under_friction() {
    let text = finite(&format!("{BRAKED}\n{HEARD}"), MADE);
    let on = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| run(&text));
    let (one, two) = (on(1), on(2));
    let file = "vibration_narrow.csv";
    assert_eq!(std::fs::read(one.path(file)).unwrap(), std::fs::read(two.path(file)).unwrap());
}

#[test]
fn a_free_wheel_is_dragged_by_the_power_dissipated() {
    // Forces are those of steps' ends, work is that of differences over steps: both meet as steps get shorter.
    let missed = [1, 4].map(|substeps| {
        let time_step = 1.95 / 64.0 / (80.0 / 3.6) / f64::from(substeps);
        let steps = |count: f64| format!("{}", count * f64::from(substeps) * time_step);
        let text =
            edit(&finite(FREE, SMOOTH), &[("rolling.warm_up", &steps(600.0)), ("rolling.duration", &steps(640.0))]);
        let text = add(&text, "numerics", &format!("substeps = {substeps}"));
        let summary = run(&text).summary();
        let outcome = &summary["outcome"];
        let (friction, resistance) = (&outcome["friction"], &outcome["rolling_resistance"]);
        let free = &friction["free"];
        let number = |value: &serde_json::Value| value.as_f64().unwrap();
        assert!(number(&free["relative_torque"]).abs() < 1e-3 && free["met"].as_bool().unwrap(), "{free}");
        assert!(number(&free["creep"]).abs() < 0.1, "{free}");
        // The axle's force ahead times the speed: there is no torque that works beside it.
        let drag = -number(&friction["mean_longitudinal_force"]);
        let by_slip = number(&friction["slip_resistance"]) * number(&outcome["mean_force"]);
        let dissipated = number(&resistance["force"]) + by_slip;
        println!("{substeps}: drag {drag} N, dissipated over the speed {dissipated} N, {free}");
        assert!(drag > 0.0 && dissipated > 0.0);
        (dissipated / drag - 1.0).abs()
    });
    assert!(missed[1] < 0.4 * missed[0], "{missed:?}");
}

#[test]
fn a_wheel_that_rolls_freely_continues_from_its_state() {
    let parts = gone_on_from_state(&scene(&finite(FREE, MADE)));
    let creeps: Vec<f64> = parts.iter().map(|part| part.creep).collect();
    let is_moving = creeps.windows(2).all(|pair| pair[0].to_bits() != pair[1].to_bits());
    assert!(is_moving, "creep follows the torque: {creeps:?}");
}

#[test]
fn another_word_for_creep_is_refused_with_its_place() {
    let text = finite("[friction]\nmu = 0.9\n[friction.creep]\nlongitudinal = \"fre\"", SMOOTH);
    let reported = Scene::from_str(&text, "scene.toml").unwrap_err().render(false);
    assert!(reported.contains("friction.creep.longitudinal") && reported.contains("\"free\""), "{reported}");
    let free = scene(&finite(FREE, SMOOTH));
    let again = Scene::from_str(&free.scene.to_toml().unwrap(), "again").unwrap();
    assert_eq!(again.scene.friction, free.scene.friction);
}
