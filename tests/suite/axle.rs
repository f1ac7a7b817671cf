//! The axle: held by a load or by a height; and the tread laws on the same axle.

use tyrewave::internals::{edit, scene_text};

use crate::common::{mean_and_deviation, run};

#[test]
fn a_load_is_carried_on_smooth_and_rough_roads() {
    for (road, load, warm_up) in [
        ("kind = \"smooth\"", 2000.0, 0.5),
        ("kind = \"smooth\"", 4000.0, 0.5),
        ("kind = \"made\"\nseed = 1", 3400.0, 1.0),
        ("kind = \"made\"\nseed = 2", 3000.0, 1.0),
    ] {
        let rolling = format!(
            "speed_kmh = 80.0\nwarm_up = {warm_up:?}\nduration = 1.5\naxle = {{ load = {load:?}, tolerance = 0.01 }}"
        );
        let results = run(&scene_text(96, road, &rolling, "memory = 0.25", ""));
        results.assert_sound(road);
        let found = results.report.summary.outcome.load.unwrap();
        // The same from the array: all steps after the warm-up.
        let (time, force) = (results.array("time.npy"), results.array("total_force.npy"));
        let (mean, _) = mean_and_deviation(&force[(warm_up / time[1]).round() as usize..]);
        println!("{road}, {load} N: {:+.3} %", 100.0 * found.relative_error);
        assert!((mean / load - 1.0 - found.relative_error).abs() < 1e-12);
        assert!(found.met && (mean / load - 1.0).abs() <= 0.01, "{road}: {mean} N instead of {load} N");
        let warned = results.report.summary.warnings.iter().any(|warning| warning.contains("load"));
        assert!(!warned, "{:?}", results.report.summary.warnings);
    }
}

#[test]
fn a_load_that_is_missed_is_said() {
    let rolling = "speed_kmh = 80.0\nwarm_up = 0.05\nduration = 0.1\naxle = { load = 3400.0, tolerance = 1e-9 }";
    let results = run(&scene_text(64, "kind = \"made\"", rolling, "memory = 0.1", ""));
    let found = results.report.summary.outcome.load.unwrap();
    assert!(!found.met);
    assert!(results.report.summary.warnings.iter().any(|warning| warning.contains("off the load")));
}

#[test]
fn the_indentation_rises_along_its_ramp() {
    let rolling = "speed_kmh = 80.0\nwarm_up = 0.0\nduration = 0.6\naxle = { indentation = 0.01, ramp = 0.3 }";
    let text = scene_text(96, "kind = \"smooth\"", rolling, "memory = 0.6", "");
    let results = run(&text);
    results.assert_sound("ramp");
    let (time, force) = (results.array("time.npy"), results.array("total_force.npy"));
    assert!(force[0].abs() < 1e-12 && force.last().unwrap() > &500.0, "at rest before t = 0");
    let at = |t: f64| force[(t / time[1]).round() as usize];
    let levels = [0.05, 0.1, 0.2, 0.29].map(at);
    assert!(levels.is_sorted(), "the force does not rise with the indentation: {levels:?}");
    let end = *force.last().unwrap();
    assert!((at(0.59) / end - 1.0).abs() < 0.01, "it stands when the indentation does: {} {end}", at(0.59));
    // The same height without a ramp ends at the same force: the law has no memory beyond the run's.
    let sudden = run(&edit(&text, &[("rolling.axle.ramp", "0.05")]));
    let other = *sudden.array("total_force.npy").last().unwrap();
    assert!((other / end - 1.0).abs() < 1e-2, "{other} {end}");
}

/// Mean and deviation of the last third, smooth road, by tread law.
fn by_law(tread: &str) -> (f64, f64, f64) {
    let rolling = "speed_kmh = 80.0\nwarm_up = 0.2\nduration = 0.4\naxle = { indentation = 0.012, ramp = 0.05 }";
    let contact = format!("[contact]\ntread = \"{tread}\"");
    let results = run(&scene_text(128, "kind = \"smooth\"", rolling, "memory = 0.5", &contact));
    results.assert_sound(tread);
    let force = results.array("total_force.npy");
    let (mean, deviation) = mean_and_deviation(&force[force.len() * 2 / 3..]);
    println!("{tread}: {mean:.1} N, std/mean {:.1e}", deviation / mean);
    (mean, deviation / mean, results.report.summary.outcome.mean_contact_length.unwrap())
}

#[test]
fn elastic_and_bedding_tread_of_equal_stiffness_carry_alike() {
    let (elastic, steady, _) = by_law("elastic");
    assert!(steady < 1e-4);
    let (bedding, steady, _) = by_law("bedding");
    assert!(steady < 1e-4);
    // The springs are matched at rest and do not stiffen with frequency as the tread does: rolling, they carry less.
    let ratio = bedding / elastic;
    assert!((0.85..=1.02).contains(&ratio), "bedding carries {ratio} of the elastic tread");
}
