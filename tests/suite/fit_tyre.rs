//! A tyre found again from mobilities that were computed and disturbed.

use std::f64::consts::{LN_10, TAU};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use num_complex::Complex64;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tyrewave::scene::Tyre;
use tyrewave::study::fit_tyre::measured::Point;
use tyrewave::study::fit_tyre::{Fit, Parameter, Uncertainty, fit};
use tyrewave::test_models::default_tyre;
use tyrewave::tyre::influence::mobility::driving_point;

const PATCHES: [f64; 4] = [0.05, 0.02, 0.01, 0.005];
const UNCERTAINTY: Uncertainty = Uncertainty { level: 0.5, phase: 3.0 };
/// How far starts lie from the truth.
const AWAY: f64 = 0.35;

/// The tyre that is found again.
fn truth() -> Tyre {
    default_tyre()
}

/// What is fitted unless somebody says otherwise.
fn usual() -> Vec<Parameter> {
    Parameter::ALL.into_iter().filter(|parameter| parameter.is_usually_free()).collect()
}

/// Mobilities at frequencies from 50 to `highest` Hz, evenly spaced on a logarithmic axis, disturbed by as much as
/// their uncertainties.
fn measured(tyre: &Tyre, patches: &[f64], (count, highest): (u32, f64), seed: u64) -> Vec<Point> {
    let frequency = |k: u32| 50.0 * (highest / 50.0).powf(f64::from(k) / f64::from(count - 1));
    let frequencies: Vec<f64> = (0..count).map(frequency).collect();
    let mobility = driving_point(tyre, patches, &frequencies);
    let mut chance = ChaCha8Rng::seed_from_u64(seed);
    let mut points = Vec::new();
    for (&frequency, row) in frequencies.iter().zip(&mobility.values) {
        for (&patch, &value) in patches.iter().zip(row) {
            // Two normal numbers (Box and Muller).
            let radius = (-2.0 * (1.0 - chance.random::<f64>()).ln()).sqrt();
            let (sine, cosine) = (TAU * chance.random::<f64>()).sin_cos();
            let level = UNCERTAINTY.level * radius * sine / 20.0 * LN_10;
            let phase = (UNCERTAINTY.phase * radius * cosine).to_radians();
            points.push(Point { frequency, patch, mobility: value * Complex64::new(level, phase).exp() });
        }
    }
    points
}

/// The tyre with each parameter somewhere within [`AWAY`] of its value.
fn start(tyre: &Tyre, parameters: &[Parameter], seed: u64) -> Tyre {
    let mut chance = ChaCha8Rng::seed_from_u64(seed);
    let mut start = tyre.clone();
    for parameter in parameters {
        *parameter.place(&mut start).unwrap() *= 1.0 + AWAY * (2.0 * chance.random::<f64>() - 1.0);
    }
    start
}

fn fitted(start: &Tyre, free: &[Parameter], points: &[Point]) -> Fit {
    fit(start, free, points, UNCERTAINTY, &AtomicBool::new(false), &mut |_, _| ()).unwrap()
}

/// Distance from the truth of each free parameter, in its standard deviations.
fn errors(fit: &Fit, truth: &Tyre) -> Vec<f64> {
    let error = |estimate: &tyrewave::study::fit_tyre::Estimate| {
        (estimate.value / estimate.parameter.value(truth).unwrap()).ln() / estimate.deviation
    };
    fit.estimates.iter().map(error).collect()
}

fn row(name: &str, values: impl Iterator<Item = f64>) -> String {
    format!("{name:>22} |{}", values.map(|value| format!("{value:8.2}")).collect::<String>())
}

fn heading(parameters: &[Parameter]) -> String {
    let short = |parameter: &Parameter| {
        let name = parameter.name().split('-').map(|part| &part[..part.len().min(3)]).collect::<Vec<_>>().join("-");
        format!("{name:>8}")
    };
    format!("{:>22} |{}", "", parameters.iter().map(short).collect::<String>())
}

#[test]
#[ignore = "minutes: ten fits"]
fn ten_random_starts_find_the_tyre_again() {
    let (truth, free) = (truth(), usual());
    println!("errors of ten starts within 35 %, in standard deviations\n{}", heading(&free));
    let mut worst = 0.0_f64;
    for seed in 0..10 {
        let points = measured(&truth, &PATCHES, (60, 3000.0), 100 + seed);
        let begin = Instant::now();
        let found = fitted(&start(&truth, &free, seed), &free, &points);
        let errors = errors(&found, &truth);
        worst = errors.iter().fold(worst, |worst, error| worst.max(error.abs()));
        let [before, chi] = found.chi_squared;
        println!(
            "{}  chi^2/N {before:8.1} -> {chi:.3}, {:.0} s",
            row(&format!("start {seed}"), errors.into_iter()),
            begin.elapsed().as_secs_f64()
        );
        if seed == 0 {
            let bounds = found.estimates.iter().map(|estimate| 100.0 * estimate.deviation);
            println!("{}  condition {:.0}", row("bound [%]", bounds), found.condition);
        }
    }
    assert!(worst < 3.0, "{worst}");
}
