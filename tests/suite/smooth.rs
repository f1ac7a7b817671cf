//! The smooth road: the force settles, the patch profile is smooth, and the elements converge.

use std::f64::consts::TAU;

use num_complex::Complex64;
use tyrewave::internals::{Decisions, edit, scene, scene_text, with_all_terms, with_road};
use tyrewave::scene::{DEFAULT, PLATE, Tyre};
use tyrewave::tyre::{Field, InfluenceSum, Projection, Truncation};

use crate::common::hard_case::measured;
use crate::common::{Results, mean_and_deviation, run};

/// Fails unless the force of the last quarter stands still within `bound` of its mean, and returns that ratio.
fn assert_settled(results: &Results, bound: f64) -> f64 {
    results.assert_sound("smooth road");
    let force = results.array("total_force.npy");
    let (mean, deviation) = mean_and_deviation(&force[force.len() * 3 / 4..]);
    assert!(deviation <= bound * mean, "std/mean = {:.2e} in the last quarter, bound {bound:e}", deviation / mean);
    deviation / mean
}

/// The patch profile of the last step, from its first to its last point in contact.
fn last_profile(results: &Results) -> Vec<f64> {
    let (rows, columns, force) = results.patch();
    let last = &force[(rows - 1) * columns..];
    let from = last.iter().position(|&force| force > 0.0).unwrap();
    let to = last.iter().rposition(|&force| force > 0.0).unwrap();
    last[from..=to].to_vec()
}

/// Fails if a profile has a hole or chatters: a saw-tooth of the elements turns the sign of the second difference at
/// every point, a smooth profile with steep ends only a few times.
fn assert_smooth(profile: &[f64]) {
    assert!(profile.iter().all(|&force| force > 0.0), "a hole: {profile:?}");
    let peak = profile.iter().fold(0.0_f64, |a, &b| a.max(b));
    let second: Vec<f64> = profile.windows(3).map(|w| w[0] - 2.0 * w[1] + w[2]).collect();
    // What the ends do, where the profile starts like a square root, does not count.
    let ends = if profile.len() < 16 { 1 } else { 2 };
    let inside = &second[ends..second.len() - ends];
    assert!(inside.len() >= 4, "too few points to judge: {profile:?}");
    let turns = inside.windows(2).filter(|w| w[0] * w[1] < 0.0 && w[0].abs().min(w[1].abs()) > 1e-3 * peak).count();
    assert!(turns <= 2, "the second difference changes its sign {turns} times: {profile:?}");
    let largest = inside.iter().fold(0.0_f64, |a, &b| a.max(b.abs()));
    assert!(largest < 0.1 * peak, "second difference {largest} at a peak of {peak}");
}

#[test]
fn hard_case_4_short_the_force_on_a_smooth_road_settles() {
    let rolling = "speed_kmh = 80.0\nwarm_up = 0.3\nduration = 1.0\naxle = { indentation = 0.012, ramp = 0.05 }";
    let results = run(&scene_text(256, "kind = \"smooth\"", rolling, "memory = 0.35", ""));
    let ratio = assert_settled(&results, 1e-6);
    measured("N = 256: deviation of the settled force", "1e-6 of the mean", format!("{ratio:.1e}"));
    assert_smooth(&last_profile(&results));
}

/// Rolling that has settled, found without time steps: in the road's frame the waves stand, and wave n is asked at the
/// frequency n V/R at which it passes. Force \[N\] and points in contact at an indentation.
fn standing_waves(tyre: &Tyre, elements: usize, speed: f64, indentation: f64) -> (f64, usize) {
    let sum = InfluenceSum::with(tyre, Projection::new(tyre, elements), Truncation::Tail, 1e-6, 1e5);
    let answers: Vec<Complex64> = (0..=elements / 2)
        .map(|n| {
            let s = Complex64::new(0.0, n as f64 * speed / tyre.radius());
            // Seen from the axle elements run back: the wave that stands there runs against the rotation.
            let found = sum.value(n, &sum.at(s), Field::Surface);
            found.value - Complex64::i() * found.odd
        })
        .collect();
    let influence: Vec<f64> = (0..elements)
        .map(|j| {
            let turn = |n: usize| Complex64::cis(TAU * ((n * j) % elements) as f64 / elements as f64);
            let waves = (1..elements / 2).map(|n| 2.0 * (answers[n] * turn(n)).re);
            answers[0].re + waves.sum::<f64>() + (answers[elements / 2] * turn(elements / 2)).re
        })
        .collect();
    // Elements round the lowest point, pressed down one by one until none moves any more (Gauss and Seidel, projected).
    let reach = elements / 12;
    let lift = |k: usize| {
        let angle = TAU * (k as f64 - reach as f64) / elements as f64;
        indentation - tyre.radius() * (1.0 - angle.cos())
    };
    let mut forces = vec![0.0_f64; 2 * reach + 1];
    for _ in 0..4000 {
        for k in 0..forces.len() {
            let moved: f64 = (0..forces.len()).map(|i| influence[(elements + k - i) % elements] * forces[i]).sum();
            forces[k] = (forces[k] + (lift(k) - moved) / influence[0]).max(0.0);
        }
    }
    (forces.iter().sum(), forces.iter().filter(|&&force| force > 0.0).count())
}

#[test]
fn settled_rolling_is_that_of_standing_waves_in_the_patch() {
    let curved = with_road(DEFAULT, "kind = \"smooth\"");
    let plate = with_road(PLATE, "kind = \"smooth\"");
    for (text, indentation) in [(&curved, 0.017), (&plate, 0.0145)] {
        let rolling = [
            ("rolling.axle", &*format!("{{ indentation = {indentation}, ramp = 0.05 }}")),
            ("rolling.warm_up", "0.3"),
            ("rolling.duration", "0.2"),
        ];
        let results = run(&edit(text, &rolling));
        let force = results.array("total_force.npy");
        let (force, points) = (force[force.len() - 1], last_profile(&results).len());
        let loaded = scene(text);
        let (decisions, speed) = (Decisions::new(&loaded.scene), loaded.scene.rolling.speed());
        let pressed = indentation + decisions.growth;
        let elements = loaded.scene.numerics.elements;
        let (expected, standing) = standing_waves(&decisions.tyre, elements, speed, pressed);
        println!("{force:.0} N, {points} points; without time steps {expected:.0} N, {standing} points");
        assert!((force / expected - 1.0).abs() < 0.01, "{force} N, {expected} N");
        assert!(points.abs_diff(standing) <= 1, "{points}, {standing}");
    }
}

#[test]
#[ignore = "full length: about a minute of two cores in the release profile"]
fn the_default_tyre_settles_at_full_length() {
    let rolling = "speed_kmh = 80.0\nwarm_up = 0.5\nduration = 2.5\naxle = { load = 4000.0 }";
    let text = with_all_terms(&scene_text(512, "kind = \"smooth\"", rolling, "memory = 0.7", ""));
    let results = run(&text);
    let ratio = assert_settled(&results, 1e-6);
    let profile = last_profile(&results);
    println!(
        "N = 512, 3 s: std/mean = {ratio:.2e}, {} elements in contact, mean force {:.3} N, profile [N] {profile:.2?}",
        profile.len(),
        results.report.summary.outcome.mean_force.unwrap()
    );
    assert_smooth(&profile);
}

/// Contact length to a fraction of an element: a profile ends like a square root, so its square is extended to zero
/// linearly.
fn contact_length(profile: &[f64], element: f64) -> f64 {
    let end = |first: f64, second: f64| first * first / (second * second - first * first).max(first * first);
    let last = profile.len() - 1;
    let ends = end(profile[0], profile[1]) + end(profile[last], profile[last - 1]);
    (last as f64 + ends) * element
}

#[test]
#[ignore = "N = 512, 1024, 2048: some minutes of two cores in the release profile"]
fn refining_the_elements_converges() {
    println!("| N | mean force, N | contact length, mm | peak pressure, kPa |");
    println!("|---|---|---|---|");
    let mut forces = Vec::new();
    for elements in [256, 512, 1024, 2048] {
        let rolling = "speed_kmh = 80.0\nwarm_up = 0.3\nduration = 0.1\naxle = { indentation = 0.012, ramp = 0.05 }";
        let text = with_all_terms(&scene_text(elements, "kind = \"smooth\"", rolling, "memory = 0.4", ""));
        let results = run(&text);
        let profile = last_profile(&results);
        let element = tyrewave::internals::CIRCUMFERENCE / elements as f64;
        let peak = profile.iter().fold(0.0_f64, |a, &b| a.max(b)) / (element * tyrewave::internals::CONTACT_WIDTH);
        let mean = results.report.summary.outcome.mean_force.unwrap();
        println!("| {elements} | {mean:.2} | {:.2} | {:.2} |", 1e3 * contact_length(&profile, element), 1e-3 * peak);
        forces.push(mean);
    }
    let steps: Vec<f64> = forces.windows(2).map(|w| (w[1] - w[0]).abs()).collect();
    for pair in steps.windows(2) {
        println!("observed order {:.2}", (pair[0] / pair[1]).log2());
        assert!(pair[1] < 0.7 * pair[0], "the differences do not shrink: {steps:?}");
    }
}
