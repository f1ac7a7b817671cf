//! The force on a rough road has a limit for small time steps and elements, and the way there is of second order: what
//! the local contact law is for.
//!
//! Forces are compared as spectra over the same stretch of time, below 1 kHz: a Hann window, exact Fourier sums at
//! common frequencies. Quick tests roll the flat tyre; disturbances and tables are of the default one.

use std::f64::consts::{PI, TAU};

use num_complex::Complex64;
use toml::Table;
use tyrewave::internals::{Advance, CHIP_SEAL, edit, reference, scene, scene_text, with_all_terms};
use tyrewave::scene::TimeRule;

use crate::common::{run, try_run};

const HIGHEST: f64 = 1000.0;

/// A stretch of time that is compared, and how a scene is rolled through it.
#[derive(Clone)]
struct Setting {
    road: String,
    speed: f64,
    contact: String,
    axle: &'static str,
    warm_up: f64,
    duration: f64,
    /// Cells along of an element of a 256th of the circumference.
    cells: usize,
    /// The tyre of the default scene instead of the flat one.
    default_tyre: bool,
}

impl Setting {
    fn made() -> Self {
        Self {
            road: "kind = \"made\"\nseed = 1".into(),
            speed: 80.0,
            contact: String::new(),
            axle: "{ indentation = 0.012, ramp = 0.05 }",
            warm_up: 0.12,
            duration: 0.2,
            cells: 4,
            default_tyre: false,
        }
    }

    /// The default tyre, under about the load of the default scene.
    fn of_the_default_tyre() -> Self {
        Self { axle: "{ indentation = 0.0165, ramp = 0.05 }", default_tyre: true, ..Self::made() }
    }

    fn text(&self, elements: usize, advance: impl Into<Advance>, rule: TimeRule) -> String {
        let Self { road, speed, contact, axle, warm_up, duration, cells, default_tyre } = self;
        let rolling = format!("speed_kmh = {speed}\nwarm_up = {warm_up}\nduration = {duration}\naxle = {axle}");
        let rule = rule.name();
        let numerics =
            format!("{}\ntime_rule = \"{rule}\"\nhistory = \"modal\"\ntime_limit = 100.0", keys(advance.into()));
        let more = format!(
            "[contact]\ncells_along = {}\nslice_tolerance = 1e-7\n{contact}\n\
             [outputs]\nspectra = false\nplots = false",
            (cells * 256 / elements).max(1)
        );
        let text = with_all_terms(&scene_text(elements, road, &rolling, &numerics, &more));
        if !default_tyre {
            return text;
        }
        let table = |text: &str| text.parse::<Table>().unwrap();
        let (mut scene, mut default) = (table(&text), table(include_str!("../../scenes/default.toml")));
        scene.insert("tyre".into(), default.remove("tyre").unwrap());
        scene.to_string()
    }

    fn force(&self, elements: usize, advance: impl Into<Advance>, rule: TimeRule) -> Force {
        let text = self.text(elements, advance, rule);
        let results = run(&text);
        let counters = results.summary()["cost"]["counters"].clone();
        assert_eq!(counters["fallbacks"], 0, "{text}");
        let (time, force) = (results.array("time.npy"), results.array("total_force.npy"));
        let step = time[1] - time[0];
        // The mean force of a Runge-Kutta step belongs to its middle.
        let lag = if rule.nodes().len() > 1 { 0.5 * step } else { 0.0 };
        let (begin, length) = (self.warm_up, self.duration);
        let window = |t: f64| if (0.0..length).contains(&t) { (PI * t / length).sin().powi(2) } else { 0.0 };
        let samples: Vec<(f64, f64)> = time.iter().zip(&force).map(|(t, f)| (t - lag - begin, *f)).collect();
        let (weight, sum) =
            samples.iter().fold((0.0, 0.0), |(weight, sum), (t, f)| (weight + window(*t), sum + window(*t) * f));
        let mean = sum / weight;
        let spectrum = (1..=(1.13 * HIGHEST * length) as usize).map(|k| {
            let frequency = k as f64 / length;
            let sum: Complex64 = samples
                .iter()
                .map(|(t, f)| Complex64::from_polar(step * window(*t) * (f - mean), -TAU * frequency * t))
                .sum();
            (frequency, sum / rule.mean_response(TAU * frequency * step))
        });
        Force { spectrum: spectrum.collect(), mean }
    }
}

struct Force {
    spectrum: Vec<(f64, Complex64)>,
    mean: f64,
}

impl Force {
    /// L2 of the difference below 1 kHz, relative; and the largest difference of a third octave from 100 Hz on \[dB\].
    fn distance(&self, other: &Self) -> (f64, f64) {
        let below = |spectrum: &[(f64, Complex64)], from: f64, to: f64| -> f64 {
            spectrum.iter().filter(|(f, _)| (from..to).contains(f)).map(|(_, x)| x.norm_sqr()).sum()
        };
        let difference: Vec<(f64, Complex64)> =
            self.spectrum.iter().zip(&other.spectrum).map(|((f, a), (_, b))| (*f, a - b)).collect();
        let l2 = (below(&difference, 0.0, HIGHEST) / below(&other.spectrum, 0.0, HIGHEST)).sqrt();
        let band = |spectrum: &[(f64, Complex64)], k: i32| {
            let middle = 1000.0 * 10.0_f64.powf(f64::from(k) / 10.0);
            let edge = 10.0_f64.powf(0.05);
            below(spectrum, middle / edge, middle * edge)
        };
        let worst = (-10..=0).map(|k| (10.0 * (band(&self.spectrum, k) / band(&other.spectrum, k)).log10()).abs());
        (l2, worst.fold(0.0, f64::max))
    }
}

fn keys(Advance { substeps, elements_per_step }: Advance) -> String {
    format!("substeps = {substeps}\nelements_per_step = {elements_per_step}")
}

/// Distances of runs with steps halved again and again from each other: q = 1, 2, 4, ...
fn successive(setting: &Setting, elements: usize, rule: TimeRule, halvings: u32) -> Vec<(f64, f64)> {
    let forces: Vec<Force> = (0..=halvings).map(|k| setting.force(elements, 1 << k, rule)).collect();
    forces.windows(2).map(|pair| pair[0].distance(&pair[1])).collect()
}

fn show(name: &str, distances: &[(f64, f64)]) {
    let cells: Vec<String> = distances.iter().map(|(l2, worst)| format!("{l2:.4} ({worst:.2} dB)")).collect();
    println!("{name}: {}", cells.join("  "));
}

#[test]
fn steps_of_several_elements_lead_to_steps_of_one() {
    let advances = [Advance::over(4), Advance::over(2), Advance::within(1), Advance::within(2)];
    let forces = advances.map(|advance| Setting::made().force(512, advance, TimeRule::Sdirk2));
    let distances: Vec<(f64, f64)> = forces.windows(2).map(|pair| pair[0].distance(&pair[1])).collect();
    show("4, 2, 1, 1/2 elements a step", &distances);
    let found = orders(&distances);
    assert!(found.iter().all(|&order| order > 0.7) && distances[2].1 < 0.5, "{distances:?} {found:?}");
}

/// Orders observed between successive differences.
fn orders(distances: &[(f64, f64)]) -> Vec<f64> {
    distances.windows(2).map(|pair| (pair[0].0 / pair[1].0).log2()).collect()
}

#[test]
fn the_force_converges_with_the_time_step_in_second_order() {
    let setting = Setting::made();
    for (rule, bound) in [(TimeRule::Sdirk2, 0.3), (TimeRule::Bdf2, 0.4)] {
        let distances = successive(&setting, 128, rule, 5);
        show(rule.name(), &distances);
        let last = *orders(&distances).last().unwrap();
        assert!((last - 2.0).abs() < bound, "{}: order {last} of {distances:?}", rule.name());
        assert!(distances.windows(2).all(|pair| pair[1].0 < pair[0].0), "{distances:?}");
    }
}

#[test]
fn the_force_of_a_fast_turning_tyre_converges_in_second_order() {
    let setting = Setting { speed: 250.0, ..Setting::of_the_default_tyre() };
    let distances = successive(&setting, 64, TimeRule::Sdirk2, 4);
    show("250 km/h", &distances);
    let last = *orders(&distances).last().unwrap();
    assert!((last - 2.0).abs() < 0.2, "order {last} of {distances:?}");
}

#[test]
fn the_papers_coupling_has_no_limit() {
    // Its slices stiffen with every halving: forces drift away from each other by as much as before, and grow.
    let setting = Setting { contact: "slice_coupling = \"explicit\"".into(), ..Setting::made() };
    let forces: Vec<Force> = [4, 8, 16].map(|q| setting.force(128, q, TimeRule::Sdirk2)).into();
    let (first, second) = (forces[0].distance(&forces[1]).0, forces[1].distance(&forces[2]).0);
    println!("{first:.3} {second:.3}, means {:.0} {:.0}", forces[0].mean, forces[2].mean);
    assert!(second > 0.4 * first && second > 0.1, "{first} {second}");
}

#[test]
fn other_treads_and_axles_converge_too() {
    for (name, contact, axle, floor) in [
        ("mass on the axle", "", "{ load = 3000.0, mass = 40.0, tolerance = 0.5 }", 1.2),
        ("load", "", "{ load = 3000.0, tolerance = 0.5 }", 1.2),
        // Without the coupling within a step an error of first order remains; the limit is the elastic tread itself.
        ("uncoupled", "tread = \"uncoupled\"", "{ indentation = 0.012, ramp = 0.05 }", 0.3),
    ] {
        let setting = Setting { contact: contact.into(), axle, ..Setting::made() };
        let forces: Vec<Force> = [8, 16, 32].map(|q| setting.force(128, q, TimeRule::Sdirk2)).into();
        let (coarse, fine) = (forces[0].distance(&forces[1]), forces[1].distance(&forces[2]));
        show(name, &[coarse, fine]);
        assert!((coarse.0 / fine.0).log2() > floor, "{name}: {coarse:?} {fine:?}");
    }
}

#[test]
fn a_disturbance_decays_and_a_micrometre_hardly_counts() {
    let setting = Setting::of_the_default_tyre();
    let text = setting.text(256, 1, TimeRule::Sdirk2);
    let (plain, disturbed) = (run(&text), run(&edit(&text, &[("rolling.axle.ramp", "0.050000001")])));
    let (a, b) = (plain.array("total_force.npy"), disturbed.array("total_force.npy"));
    let largest = |range: std::ops::Range<usize>| {
        a[range.clone()].iter().zip(&b[range]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    let (during, after) = (largest(0..a.len() / 4), largest(3 * a.len() / 4..a.len()));
    println!("a ramp longer by 1e-9 s: {during:e} N at first, {after:e} N at the end");
    assert!(during > 0.0 && after < 1e-2 * during, "{during:e} {after:e}");
    // Heights of 1 mm rms that are higher by a thousandth: a micrometre.
    let asphalt = |more: f64| {
        let levels = [42.0, 40.6, 42.8, 44.2, 44.4, 44.6, 46.0, 46.8, 46.2, 45.6, 43.1, 40.3, 37.9, 35.4, 30.4];
        let levels = levels.map(|level| level + more);
        let wavelengths = [
            0.1, 0.0794, 0.0631, 0.0501, 0.0398, 0.0316, 0.0251, 0.02, 0.0158, 0.0126, 0.01, 0.00794, 0.00631, 0.00501,
            0.00398,
        ];
        let road = format!("kind = \"made\"\nseed = 1\nwavelengths = {wavelengths:?}\nlevels = {levels:?}");
        Setting { road, ..Setting::of_the_default_tyre() }.force(256, 1, TimeRule::Sdirk2)
    };
    let (l2, worst) = asphalt(20.0 * 1.001_f64.log10()).distance(&asphalt(0.0));
    println!("a micrometre of road: {l2:.5} ({worst:.3} dB)");
    assert!(worst < 0.05, "{worst} dB");
}

/// Long version: `cargo test --release --test suite convergence -- --ignored --nocapture`.
#[test]
#[ignore = "half an hour: tables of successive differences on four roads at three speeds"]
fn tables_of_convergence() {
    // High peaks are met before the ramp begins: the rough roads need longer to forget that.
    let made = || Setting { warm_up: 0.3, ..Setting::of_the_default_tyre() };
    let mut settings = vec![("dense asphalt", made())];
    let chippings = "kind = \"made\"\npower_law = { rms = 0.0012, exponent = 2.0, longest = 0.1, shortest = 0.005 }";
    settings.push(("chippings", Setting { road: chippings.into(), ..made() }));
    let road = format!("kind = \"profile\"\nfile = '{}'\nlateral = \"isotropic\"", reference(CHIP_SEAL).display());
    settings.push(("CAPTIF", Setting { road, ..made() }));
    let folder = tempfile::tempdir().unwrap();
    let step = folder.path().join("step.csv");
    let rows: String = (0..20_000)
        .map(|k| f64::from(k) * 5e-4)
        .map(|x| format!("{x},{}\n", if (x * 2.0).rem_euclid(2.0) < 1.0 { 0.0 } else { 0.01 }))
        .collect();
    std::fs::write(&step, rows).unwrap();
    let road = format!(
        "kind = \"profile\"\nfile = '{}'\ndistance_unit = \"m\"\nheight_unit = \"m\"\nlateral = \"extruded\"\n\
         at_end = \"mirror\"",
        step.display()
    );
    settings.push(("steps of 10 mm", Setting { road, ..made() }));
    let speeds = [80.0, 30.0, 130.0];
    for (road, setting) in speeds
        .iter()
        .flat_map(|&speed| settings.iter().map(move |(road, setting)| (road, Setting { speed, ..setting.clone() })))
    {
        for (rule, elements) in
            [(TimeRule::Bdf2, 256), (TimeRule::Sdirk2, 256), (TimeRule::Bdf2, 512), (TimeRule::Sdirk2, 512)]
        {
            let name = format!("{road}, {} km/h, N = {elements}, {}, q = 1 ... 32", setting.speed, rule.name());
            show(&name, &successive(&setting, elements, rule, 5));
        }
        // The cells stay the same as elements are halved: they are another limit.
        let setting = Setting { cells: 16, ..setting };
        let forces: Vec<Force> =
            [(256, 16), (512, 8), (1024, 4), (2048, 2)].map(|(n, q)| setting.force(n, q, TimeRule::Sdirk2)).into();
        let distances: Vec<(f64, f64)> = forces[..3].iter().map(|force| force.distance(&forces[3])).collect();
        show(&format!("{road}, {} km/h, N = 256, 512, 1024 against 2048", setting.speed), &distances);
    }
}

#[test]
fn bedding_by_poles_is_refused_with_its_reason_or_converges() {
    let setting = Setting { contact: "tread = \"bedding\"".into(), ..Setting::made() };
    match try_run(&scene(&setting.text(64, 1, TimeRule::Sdirk2))) {
        Ok(results) => results.assert_sound("bedding"),
        Err(error) => assert!(error.to_string().contains("pole"), "{error}"),
    }
}
