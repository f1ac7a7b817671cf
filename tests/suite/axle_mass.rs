//! An axle with a mass: free vibration on the tyre, lift-off and landing, limits.

use std::fs;
use std::sync::atomic::AtomicBool;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tyrewave::Plan;
use tyrewave::counters::Meter;
use tyrewave::internals::{
    AxleHeight, CIRCUMFERENCE, LoadControl, MovingAxle, Prepared, RoadStrip, SprungMass, StaticContact, grid_road,
    implausible, prepare, scene, scene_text,
};
use tyrewave::road::StiffnessCurve;
use tyrewave::run::{Job, RunError, Unwatched};
use tyrewave::scene::LoadedScene;

use crate::common::{Results, mean_and_deviation, run, try_run, write_grid};

const SMOOTH: &str = "kind = \"smooth\"";

fn rolling(warm_up: f64, duration: f64, axle: &str) -> String {
    format!("speed_kmh = 80.0\nwarm_up = {warm_up:?}\nduration = {duration:?}\naxle = {axle}")
}

fn prepared(loaded: &LoadedScene) -> (Prepared, Plan) {
    let plan = Plan::new(&loaded.scene);
    (prepare(loaded, &plan, &mut Job::new(&AtomicBool::new(false), &mut Unwatched)).unwrap(), plan)
}

/// Total forces on a smooth road for an axle that `next` gives before every step and that receives the force.
fn roll(loaded: &LoadedScene, steps: u64, axle: &mut dyn FnMut(u64, Option<f64>) -> AxleHeight) -> Vec<f64> {
    let (Prepared { mut march, .. }, _) = prepared(loaded);
    let mut slices = RoadStrip::starting_at(march.geometry().first_element(0));
    slices.extend((0..steps + march.geometry().columns as u64).map(|_| StiffnessCurve::flat(0.0)));
    let (mut forces, mut last) = (Vec::new(), None);
    for step in 0..steps {
        let height = axle(step, last);
        last = Some(march.step(&height, &slices, &mut Meter::default()).unwrap().total_force);
        forces.extend(last);
    }
    forces
}

#[test]
fn free_vibration_is_that_of_mass_and_dynamic_stiffness() {
    // The tyre by itself: its force at a height that is led, and what a small step of the height adds. From these alone
    // the mass's motion is integrated by another scheme (Newmark, the mean acceleration, implicit in today's force) and
    // compared.
    let (mass, indentation) = (35.0, 0.012);
    for (rule, damping, stiffness) in [("bdf2", 0.0, 0.0), ("bdf2", 1500.0, 5e4), ("bdf1", 0.0, 0.0)] {
        let numerics = format!("history = \"modal\"\ntime_rule = \"{rule}\"");
        let text = scene_text(256, SMOOTH, &rolling(0.5, 0.5, "{ indentation = 0.012 }"), &numerics, "");
        let loaded = scene(&text);
        let (Prepared { contact, .. }, plan) = prepared(&loaded);
        let time_step = plan.time_step;
        let ramp = (0.4 / time_step).round() as u64;
        let steps = ramp + (0.4 / time_step).round() as u64;
        let guided = |step: u64, more: f64| AxleHeight::Fixed {
            indentation: indentation * (step as f64 / ramp as f64).min(1.0) + more,
            ramp: 0.0,
        };
        let held = roll(&loaded, steps, &mut |step, _| guided(step, 0.0));
        let small = 2e-5;
        let pushed = roll(&loaded, steps, &mut |step, _| guided(step, if step >= ramp { small } else { 0.0 }));
        let response: Vec<f64> = (ramp..steps).map(|l| (pushed[l as usize] - held[l as usize]) / small).collect();
        // 15 N more than the tyre carries where it is set free.
        let load = held[ramp as usize] + 15.0;
        let sprung = SprungMass { load, mass, stiffness, damping };
        // The ramp is 3/20 of the warm-up; corrections of the rest begin later than this run ends.
        let start = StaticContact { indentation, ..contact.at_rest };
        let control = LoadControl::new(load, start, ramp * 20 / 3 + 1);
        let mut axle = AxleHeight::Moving(Box::new(MovingAxle::new(sprung, control, time_step, 0.0)));
        let mut heights = Vec::new();
        roll(&loaded, steps, &mut |step, force| {
            if let Some(force) = force {
                axle.observe(step - 1, force);
            }
            heights.push(axle.indentation(step) - indentation);
            axle.clone()
        });
        let found = &heights[ramp as usize..];
        // z'' = (load - F - k z - c z')/m with F = held + sum of the response to all increments of z.
        let (mut z, mut v, mut increments) = (vec![0.0], 0.0, vec![0.0]);
        let acceleration = |force: f64, z: f64, v: f64| (load - force - stiffness * z - damping * v) / mass;
        let mut last = acceleration(held[ramp as usize], 0.0, 0.0);
        for l in 1..response.len() {
            let from = |j: usize, increments: &[f64]| increments[j] * response[l - j];
            let past = held[ramp as usize + l] + (0..l).map(|j| from(j, &increments)).sum::<f64>();
            let before = z[l - 1];
            // z = before + dt v + dt^2/4 (last + a), v' = v + dt/2 (last + a), solved for a.
            let known_v = v + 0.5 * time_step * last;
            let known_z = before + time_step * v + 0.25 * time_step * time_step * last;
            let (by_z, by_v) = (0.25 * time_step * time_step, 0.5 * time_step);
            let right = load - past - response[0] * (known_z - before) - stiffness * known_z - damping * known_v;
            let now = right / (mass + (response[0] + stiffness) * by_z + damping * by_v);
            z.push(known_z + by_z * now);
            v = known_v + by_v * now;
            increments.push(z[l] - before);
            last = now;
        }
        let peak = z.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        let worst = found.iter().zip(&z).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / peak;
        let period = |z: &[f64]| {
            let end = z.last().unwrap();
            let crossings: Vec<usize> =
                (1..z.len()).filter(|&l| (z[l] - end) * (z[l - 1] - end) < 0.0).take(9).collect();
            2.0 * (crossings.last().unwrap() - crossings[0]) as f64 * time_step / (crossings.len() - 1) as f64
        };
        println!(
            "{rule}, c = {damping} N s/m, k = {stiffness} N/m: {:.2} and {:.2} Hz, largest difference {worst:.1e} of \
             the peak of {:.3} mm; stiffness {:.2e} N/m at once, {:.2e} at the end",
            1.0 / period(found),
            1.0 / period(&z),
            1e3 * peak,
            response[0],
            response.last().unwrap()
        );
        assert!(worst < 5e-3, "{rule}: {worst}");
        let loudest = |z: &[f64]| z.iter().fold(0.0_f64, |a, b| a.max((b - z.last().unwrap()).abs()));
        let tail = |z: &[f64]| loudest(&z[z.len() * 3 / 4..]) / loudest(z);
        assert!((tail(found) - tail(&z)).abs() < 0.02, "damping: {} and {}", tail(found), tail(&z));
    }
}

/// `axle.npy`.
fn heights(results: &Results) -> Vec<f64> {
    results.array("axle.npy")
}

#[test]
fn a_heavy_axle_stays_where_a_held_one_is() {
    let road = "kind = \"made\"\nseed = 1";
    // A mass that nothing has: it holds the axle still.
    let scene = |axle: &str| scene_text(96, road, &rolling(0.2, 0.3, axle), "memory = 0.25", "");
    let of = |axle: &str| run(&implausible(&scene(axle)));
    let heavy = of("{ load = 3000.0, mass = 1e10, tolerance = 0.2 }");
    heavy.assert_sound("heavy");
    let height = heights(&heavy);
    let at_rest = *height.last().unwrap();
    let time = heavy.array("time.npy");
    // The ramp of the load control: 3/20 of the warm-up, in whole steps.
    let warm_up = (0.2 / time[1]).round() as u64;
    let held = of(&format!("{{ indentation = {at_rest:?}, ramp = {:?} }}", (warm_up * 3 / 20) as f64 * time[1]));
    let (a, b) = (heavy.array("total_force.npy"), held.array("total_force.npy"));
    let worst = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    println!("largest difference {worst:.1e} N");
    assert!(worst < 1e-3 * 3000.0, "{worst}");
    let motion = heavy.report.summary.outcome.axle.unwrap();
    assert!(motion.rms_variation < 1e-9 && (motion.mean - at_rest).abs() < 1e-9, "{motion:?}");
    assert!(held.report.summary.outcome.axle.is_none() && !held.path("axle.npy").exists());
}

#[test]
fn the_mean_force_is_the_load_with_and_without_a_spring() {
    for (road, axle) in [
        (SMOOTH, "{ load = 3000.0, mass = 40.0 }"),
        (SMOOTH, "{ load = 3000.0, mass = 40.0, stiffness = 3e4, damping = 1500.0 }"),
        ("kind = \"made\"\nseed = 2", "{ load = 3000.0, mass = 40.0, stiffness = 3e4, damping = 1500.0 }"),
        ("kind = \"made\"\nseed = 2", "{ load = 3000.0, mass = 40.0, damping = 1500.0 }"),
    ] {
        let results = run(&scene_text(96, road, &rolling(1.5, 1.5, axle), "history = \"modal\"", ""));
        results.assert_sound(axle);
        let outcome = &results.report.summary.outcome;
        let (found, motion) = (outcome.load.unwrap(), outcome.axle.unwrap());
        println!(
            "{road}, {axle}: {:+.3} %, axle at {:.3} mm, rms {:.4} mm",
            100.0 * found.relative_error,
            1e3 * motion.mean,
            1e3 * motion.rms_variation
        );
        assert!(found.met, "{axle}: {found:?}");
        // The same from the array.
        let (time, height) = (results.array("time.npy"), heights(&results));
        assert_eq!(time.len(), height.len());
        let (mean, deviation) = mean_and_deviation(&height[(1.5 / time[1]).round() as usize..]);
        assert!((mean - motion.mean).abs() < 1e-12 && (deviation - motion.rms_variation).abs() < 1e-9);
        match (road == SMOOTH, axle.contains("damping")) {
            // Nothing shakes it, and the damper has taken the beginning away.
            (true, true) => assert!(motion.rms_variation < 1e-7, "{motion:?}"),
            (true, false) => {}
            (false, _) => assert!((5e-6..1e-4).contains(&motion.rms_variation), "{motion:?}"),
        }
    }
}

#[test]
fn a_wheel_on_cobbles_leaves_the_road_and_lands() {
    let n = 96;
    let element = CIRCUMFERENCE / n as f64;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cobbles.npy");
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let stones: Vec<f64> = (0..900).map(|_| random.random_range(-0.03..0.0)).collect();
    // Stones of 0.14 m, up to 30 mm apart in height.
    let heights_of: Vec<f64> = (0..30 * n).map(|row| stones[(row as f64 * element / 0.14) as usize]).collect();
    write_grid(&path, 1, &heights_of);
    for numerics in ["memory = 0.25", "history = \"modal\"\ntime_rule = \"sdirk2\""] {
        let (load, mass, damping) = (3000.0, 30.0, 500.0);
        let axle = format!("{{ load = {load:?}, mass = {mass:?}, damping = {damping:?}, tolerance = 0.5 }}");
        let rolling = format!("start = 1.0\n{}", rolling(0.5, 1.5, &axle));
        let results = run(&scene_text(n, &grid_road(&path, n, 1), &rolling, numerics, ""));
        results.assert_sound("cobbles");
        let (force, height, time) = (results.array("total_force.npy"), heights(&results), results.array("time.npy"));
        let begin = force.len() / 4;
        let is_airborne = |step: usize| force[step] < f64::MIN_POSITIVE;
        let air = (begin..force.len()).filter(|&step| is_airborne(step)).count();
        let landings = (begin..force.len()).filter(|&step| is_airborne(step - 1) && !is_airborne(step)).count();
        let (low, high) = height.iter().fold((f64::MAX, f64::MIN), |(a, b), &z| (a.min(z), b.max(z)));
        let found = results.report.summary.outcome.load.unwrap();
        println!(
            "{numerics}: {air} of {} steps in the air, {landings} landings, axle from {:.1} to {:.1} mm, peak force \
             {:.0} N, mean {:+.1} % off the load",
            force.len() - begin,
            1e3 * low,
            1e3 * high,
            force.iter().fold(0.0_f64, |a, &b| a.max(b)),
            100.0 * found.relative_error
        );
        assert!(air > 20 && landings >= 3, "{air} {landings}");
        assert!(low > -0.2 && high < 0.06, "the wheel flies away or sinks: {low} {high}");
        assert!(found.relative_error.abs() < 0.05, "{found:?}");
        if numerics.contains("sdirk2") {
            continue;
        }
        // In the air it is a mass that falls under its load and its damper.
        let mut inspected = 0;
        for step in (begin..force.len() - 1).filter(|&step| is_airborne(step)) {
            let dt = time[1];
            let (before, after) = ((height[step] - height[step - 1]) / dt, (height[step + 1] - height[step]) / dt);
            let fall = (load - damping * 0.5 * (before + after)) / mass;
            assert!(((after - before) / dt - fall).abs() < 1e-6 * load / mass, "step {step}");
            inspected += 1;
        }
        assert!(inspected > 20);
    }
}

#[test]
fn a_swing_decays_alike_by_rules_of_one_stage_and_of_two() {
    // Let go where the resting tyre carries the load; the rolling one is stiffer. A force that acted half a step off
    // would change what is left by 15 % with one step per element.
    let of = |rule: &str, substeps: usize| {
        let numerics = format!("history = \"modal\"\ntime_rule = \"{rule}\"\nsubsteps = {substeps}");
        let axle = "{ load = 3000.0, mass = 35.0, tolerance = 0.5 }";
        let results = run(&scene_text(256, SMOOTH, &rolling(0.5, 0.8, axle), &numerics, ""));
        let (height, dt) = (heights(&results), results.array("time.npy")[1]);
        let (settled, _) = mean_and_deviation(&height[height.len() * 4 / 5..]);
        let peak = |from: f64, to: f64| {
            let part = &height[(from / dt) as usize..(to / dt) as usize];
            part.iter().fold(0.0_f64, |a, z| a.max((z - settled).abs()))
        };
        (peak(0.08, 0.16), peak(0.32, 0.40) / peak(0.08, 0.16))
    };
    let reference = of("sdirk2", 8);
    println!("sdirk2, 8: first {:.4} mm, later {:.4} of it", 1e3 * reference.0, reference.1);
    for (rule, substeps) in [("sdirk2", 1), ("sdirk2", 2), ("bdf2", 1), ("bdf2", 4)] {
        let found = of(rule, substeps);
        println!("{rule}, {substeps}: first {:.4} mm, later {:.4} of it", 1e3 * found.0, found.1);
        assert!((found.1 / reference.1 - 1.0).abs() < 0.04, "{rule}, {substeps}");
    }
}

#[test]
fn a_mass_too_light_for_the_time_step_is_refused() {
    let of = |mass: f64| {
        let axle = format!("{{ load = 3000.0, mass = {mass:?}, tolerance = 0.5 }}");
        try_run(&scene(&scene_text(96, "kind = \"made\"", &rolling(0.3, 0.4, &axle), "history = \"modal\"", "")))
    };
    let refused = of(0.01).err().unwrap();
    assert!(matches!(refused, RunError::Scene(_)), "{refused}");
    let message = refused.to_string();
    println!("{message}");
    assert!(message.contains("too fast for a step") && message.contains("at least"), "{message}");
    let least: f64 = message.split("at least ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    assert!(of(0.99 * least).is_err());
    let results = of(1.01 * least).unwrap();
    results.assert_sound("the least mass");
    let (low, high) = heights(&results).into_iter().fold((f64::MAX, f64::MIN), |(a, b), z| (a.min(z), b.max(z)));
    println!("{least} kg: from {:.2} to {:.2} mm", 1e3 * low, 1e3 * high);
    assert!(low > -0.02 && high < 0.04);
}

#[test]
fn the_axle_moves_alike_on_any_number_of_threads() {
    let axle = "{ load = 3000.0, mass = 30.0, stiffness = 2e4, damping = 500.0, tolerance = 0.5 }";
    let text = scene_text(96, "kind = \"made\"", &rolling(0.2, 0.2, axle), "history = \"modal\"", "");
    let bytes = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let results = pool.install(|| run(&text));
        ["axle.npy", "patch_force.npy"].map(|name| fs::read(results.path(name)).unwrap())
    };
    let one = bytes(1);
    assert!(one[0].len() > 1000 && one == bytes(2) && one == bytes(3));
}
