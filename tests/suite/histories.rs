//! The past by poles against the past by convolution: the same forces, and what each costs.

#![allow(clippy::unwrap_used, reason = "a test stops where a value is missing")]

use std::path::Path;
use std::sync::atomic::AtomicBool;

use tyrewave::counters::Stage;
use tyrewave::internals::{Advance, CHIP_SEAL, edit, reference, scene, with_road};
use tyrewave::run::{Job, RunOptions, RunReport, Unwatched, run};
use tyrewave::scene::{History, PLATE, Scene, TimeRule};

/// A run of the default tyre on its road at a fixed height.
fn rolled(change: impl Fn(&mut Scene), folder: &Path) -> (Vec<f64>, RunReport) {
    rolled_scene(&edit(PLATE, &[("rolling.axle", "{ indentation = 0.014, ramp = 0.03 }")]), change, folder)
}

/// The same with the scene's text given.
fn rolled_scene(text: &str, change: impl Fn(&mut Scene), folder: &Path) -> (Vec<f64>, RunReport) {
    let mut loaded = scene(text);
    loaded.scene.rolling.warm_up = 0.05;
    loaded.scene.rolling.duration = 0.25;
    // Nothing of the past is left out of the sum.
    loaded.scene.numerics.memory = 1.0;
    loaded.scene.numerics.influence_tolerance = 1e-9;
    loaded.scene.outputs.plots = false;
    change(&mut loaded.scene);
    let options = RunOptions { target: folder.join("out"), threads: rayon::current_num_threads() };
    let report = run(&loaded, &options, Job::new(&AtomicBool::new(false), &mut Unwatched)).unwrap();
    let bytes = std::fs::read(report.folder.join("total_force.npy")).unwrap();
    let force = npyz::NpyFile::new(&bytes[..]).unwrap().into_vec::<f64>().unwrap();
    (force, report)
}

/// Largest difference of two force histories, relative to the peak.
fn difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let peak = b.iter().fold(0.0_f64, |peak, &force| peak.max(force));
    a.iter().zip(b).fold(0.0_f64, |worst, (x, y)| worst.max((x - y).abs())) / peak
}

#[test]
fn poles_give_the_forces_of_the_convolution_for_every_rule() {
    let folder = tempfile::tempdir().unwrap();
    let advances = [Advance::within(1), Advance::within(2), Advance::over(2)];
    let of_bdf2 = advances.map(|advance| (TimeRule::Bdf2, advance));
    for (rule, advance) in of_bdf2.into_iter().chain([(TimeRule::Bdf1, Advance::within(1))]) {
        let of = |history, tolerance| {
            let change = |scene: &mut Scene| {
                scene.numerics.elements = 64;
                scene.numerics.time_rule = rule;
                scene.numerics.take_advance(advance);
                scene.numerics.history = history;
                scene.numerics.pole_tolerance = tolerance;
            };
            rolled(change, folder.path()).0
        };
        let direct = of(History::Direct, 1e-6);
        let error = difference(&of(History::Modal, 1e-6), &direct);
        println!("{rule:?}, {advance}: {error:.1e} of the peak");
        // Measured 7e-7 to 1.4e-6.
        assert!(error < 1e-5, "{rule:?}: {error:e}");
    }
}

#[test]
fn forces_by_poles_have_the_same_bits_on_three_threads() {
    let of = |threads| {
        let folder = tempfile::tempdir().unwrap();
        let change = |scene: &mut Scene| {
            scene.numerics.elements = 128;
            scene.numerics.history = History::Modal;
        };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let force = pool.install(|| rolled(change, folder.path()).0);
        force.iter().map(|force| force.to_bits()).collect::<Vec<_>>()
    };
    assert_eq!(of(1), of(3));
}

#[test]
#[ignore = "direct sums at N = 512 and 1024: a few minutes"]
fn accuracy_against_time_of_both_histories() {
    let folder = tempfile::tempdir().unwrap();
    println!(
        "| N | history | tolerance | error of the force / peak | influence functions | history without transforms, per \
         step |"
    );
    println!("|---|---|---|---|---|---|");
    for elements in [512, 1024] {
        let of = |history, tolerance: f64| {
            let change = |scene: &mut Scene| {
                scene.numerics.elements = elements;
                scene.numerics.history = history;
                scene.numerics.pole_tolerance = tolerance;
            };
            rolled(change, folder.path())
        };
        let (reference, direct) = of(History::Direct, 1e-6);
        let row = |name: &str, tolerance: &str, error: f64, report: &RunReport| {
            let steps = report.summary.outcome.steps as f64;
            println!(
                "| {elements} | {name} | {tolerance} | {error:.1e} | {:.2} s | {:.0} us |",
                (report.meter.cost(Stage::Influence).spent.wall + report.meter.cost(Stage::Fit).spent.wall)
                    .as_secs_f64(),
                1e6 * report.meter.cost(Stage::History).spent.wall.as_secs_f64() / steps
            );
        };
        row("direct", "-", 0.0, &direct);
        for tolerance in [1e-4, 1e-5, 1e-7] {
            let (force, report) = of(History::Modal, tolerance);
            row("modal", &format!("{tolerance:.0e}"), difference(&force, &reference), &report);
        }
    }
}

#[test]
#[ignore = "direct sums over 1.5 s at N = 1024: a few minutes"]
fn poles_give_the_forces_of_the_convolution_at_full_length() {
    let path = reference(CHIP_SEAL);
    let folder = tempfile::tempdir().unwrap();
    let road = format!("kind = \"profile\"\nfile = '{}'\nlateral = \"isotropic\"\nseed = 1", path.display());
    let text = edit(&with_road(PLATE, &road), &[("rolling.axle", "{ indentation = 0.012, ramp = 0.03 }")]);
    let of = |history, tolerance: f64, duration: f64| {
        let change = |scene: &mut Scene| {
            scene.numerics.elements = 1024;
            scene.numerics.history = history;
            scene.numerics.pole_tolerance = tolerance;
            scene.numerics.influence_tolerance = 1e-10;
            scene.rolling.duration = duration;
            scene.numerics.memory = duration + 0.1;
            scene.numerics.memory_limit = 16.0;
        };
        rolled_scene(&text, change, folder.path())
    };
    let cost = |name: &str, report: &RunReport| {
        let of = |stage| report.meter.cost(stage).spent.wall.as_secs_f64();
        let per_step = 1e6 * of(Stage::History) / report.summary.outcome.steps as f64;
        println!(
            "{name}: influence functions {:.2} s, history {per_step:.0} us per step",
            of(Stage::Influence) + of(Stage::Fit)
        );
        per_step
    };
    let standard = tyrewave::scene::Numerics::default().pole_tolerance;
    let (reference, direct) = of(History::Direct, standard, 0.25);
    cost("0.3 s, direct", &direct);
    for (tolerance, bound) in [(standard, 1e-5), (1e-7, 1e-7)] {
        let (force, report) = of(History::Modal, tolerance, 0.25);
        let error = difference(&force, &reference);
        cost(&format!("0.3 s, modal {tolerance:.0e}, error {error:.1e} of the peak"), &report);
        assert!(error < bound, "{tolerance:e}: {error:e}");
    }
    // The sum's cost grows with what it remembers, the recursion's does not.
    let (reference, direct) = of(History::Direct, standard, 1.45);
    let (force, modal) = of(History::Modal, standard, 1.45);
    let error = difference(&force, &reference);
    let ratio = cost("1.5 s, direct", &direct) / cost(&format!("1.5 s, modal, error {error:.1e}"), &modal);
    println!("history by sums over history by poles: {ratio:.0}");
    assert!(error < 1e-5, "{error:e}");
}
