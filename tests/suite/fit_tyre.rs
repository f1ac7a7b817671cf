//! A tyre found again from mobilities that were computed and disturbed.

use std::f64::consts::{LN_10, TAU};
use std::fs;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use num_complex::Complex64;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tempfile::TempDir;
use tyrewave::internals::{
    Estimate, FIT_TYRE_BOUND as BOUND, FitTyreError, MeasuredPoint, Parameter, TyreFit, Uncertainty, driving_point,
    fit_tyre as fit, plate_tyre, replaced,
};
use tyrewave::scene::{PLATE, Scene, Tyre};

use crate::common::{names, tyrewave};

const PATCHES: [f64; 4] = [0.05, 0.02, 0.01, 0.005];
const UNCERTAINTY: Uncertainty = Uncertainty { level: 0.5, phase: 3.0 };
/// How far starts lie from the truth.
const AWAY: f64 = 0.35;

/// The tyre that is found again.
fn truth() -> Tyre {
    plate_tyre()
}

/// Returns the parameters that are fitted by default.
fn usual() -> Vec<Parameter> {
    let truth = truth();
    let is_free = |parameter: &Parameter| parameter.is_usually_free() && parameter.value(&truth).is_some();
    Parameter::ALL.into_iter().filter(is_free).collect()
}

/// Mobilities at frequencies from 50 to `highest` Hz, evenly spaced on a logarithmic axis, disturbed by as much as
/// their uncertainties.
fn measured(tyre: &Tyre, patches: &[f64], (count, highest): (u32, f64), seed: u64) -> Vec<MeasuredPoint> {
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
            points.push(MeasuredPoint { frequency, patch, mobility: value * Complex64::new(level, phase).exp() });
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

fn fitted(start: &Tyre, free: &[Parameter], points: &[MeasuredPoint]) -> TyreFit {
    fit(start, free, points, UNCERTAINTY, &AtomicBool::new(false), &mut |_, _| ()).unwrap()
}

/// Distance from the truth of each free parameter, in its standard deviations.
fn errors(fit: &TyreFit, truth: &Tyre) -> Vec<f64> {
    let error =
        |estimate: &Estimate| (estimate.value / estimate.parameter.value(truth).unwrap()).ln() / estimate.deviation;
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

/// A short measurement: two patches at a dozen frequencies.
fn short(tyre: &Tyre) -> Vec<MeasuredPoint> {
    measured(tyre, &PATCHES[..2], (14, 1000.0), 1)
}

const FEW: [Parameter; 3] = [Parameter::TreadModulus, Parameter::TensionAlong, Parameter::FoundationNormal];

#[test]
fn a_tyre_is_found_from_a_wrong_start_on_any_threads() {
    let truth = truth();
    let points = short(&truth);
    let mut start = truth.clone();
    // Both wrong in the same direction: a descent alone ends where one mode lies on its neighbour.
    for (parameter, factor) in FEW.into_iter().zip([0.7, 1.35, 1.35]) {
        *parameter.place(&mut start).unwrap() *= factor;
    }
    let found = fitted(&start, &FEW, &points);
    let errors = errors(&found, &truth);
    assert!(errors.iter().all(|error| error.abs() < 3.0), "{errors:?}");
    let [before, after] = found.chi_squared;
    assert!(found.converged && before > 10.0 && (0.4..1.8).contains(&after), "{before} {after}");
    for Estimate { value, interval: [from, to], at_bound, deviation, .. } in &found.estimates {
        assert!(from < value && value < to && !at_bound && (1e-4..0.1).contains(deviation), "{:?}", found.estimates);
    }
    for (index, row) in found.correlations.iter().enumerate() {
        assert!((row[index] - 1.0).abs() < 1e-9 && row.iter().all(|value| value.abs() < 1.0 + 1e-9));
    }
    // What was not fitted is the start's, to the bit.
    let mut back = found.tyre.clone();
    FEW.into_iter().for_each(|parameter| *parameter.place(&mut back).unwrap() = parameter.value(&start).unwrap());
    assert_eq!(back, start);
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let again = alone.install(|| fitted(&start, &FEW, &points));
    assert_eq!((again.tyre, again.residuals), (found.tyre, found.residuals));
}

#[test]
fn parameters_end_at_bounds_or_are_not_determined() {
    let truth = truth();
    let points = short(&truth);
    let mut start = truth.clone();
    *Parameter::TreadModulus.place(&mut start).unwrap() /= 1.5 * BOUND;
    let found = fitted(&start, &[Parameter::TreadModulus], &points);
    assert!(found.estimates[0].at_bound && found.chi_squared[1] > 2.0, "{:?}", found.estimates);
    // At 20 kHz nothing of the foundation is felt.
    let high = driving_point(&truth, &PATCHES[..1], &[2e4, 2.1e4]);
    let at =
        |(&frequency, row): (&f64, &Vec<Complex64>)| MeasuredPoint { frequency, patch: PATCHES[0], mobility: row[0] };
    let points: Vec<MeasuredPoint> = high.frequencies.iter().zip(&high.values).map(at).collect();
    let found = fitted(&truth, &[Parameter::FoundationNormal], &points);
    assert!(found.estimates[0].deviation > BOUND.ln(), "{:?}", found.estimates);
}

#[test]
fn too_few_values_and_an_interruption_are_errors() {
    let (truth, free) = (truth(), usual());
    let points = short(&truth);
    let fit = |points: &[MeasuredPoint], stop: bool| {
        fit(&truth, &free, points, UNCERTAINTY, &AtomicBool::new(stop), &mut |_, _| ()).map(|_| ()).unwrap_err()
    };
    assert_eq!(fit(&points[..4], false), FitTyreError::TooFew { values: 4, unknowns: 8 });
    assert_eq!(fit(&points, true), FitTyreError::Interrupted);
}

/// A folder with a measurement and a scene.
fn folder(csv: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("measured.csv"), csv).unwrap();
    fs::write(folder.path().join("scene.toml"), PLATE).unwrap();
    folder
}

/// The measured values as the program reads them.
fn to_csv(points: &[MeasuredPoint]) -> String {
    let row = |MeasuredPoint { frequency, patch, mobility }: &MeasuredPoint| {
        let (level, phase) = (20.0 * mobility.norm().log10(), mobility.arg().to_degrees());
        format!("{frequency},{patch},{level},{phase}\n")
    };
    format!("frequency_hz,patch_m,level_db,phase_deg\n{}", points.iter().map(row).collect::<String>())
}

const COMMAND: [&str; 5] = ["fit-tyre", "measured.csv", "scene.toml", "--out", "fitted"];
const FIXED: &str = "--fix=tread-loss,belt-modulus,belt-loss,tension-across,foundation-normal,foundation-tangential";

#[test]
fn the_program_writes_a_tyre_with_tables_and_pictures() {
    let mut stiffer = truth();
    *Parameter::TreadModulus.place(&mut stiffer).unwrap() *= 1.3;
    let folder = folder(&to_csv(&short(&stiffer)));
    let output = tyrewave(folder.path(), &[&COMMAND[..], &["--json", FIXED]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let answer: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let parameters: Vec<&str> =
        answer["parameters"].as_array().unwrap().iter().map(|entry| entry["name"].as_str().unwrap()).collect();
    assert_eq!(parameters, ["tread-modulus", "tension-along"]);
    let fitted = folder.path().join("fitted");
    let files = ["fit.json", "fit.txt", "mobility.csv", "mobility.svg", "residuals.svg", "summary.json", "tyre.toml"];
    assert_eq!(names(&fitted), files);
    let text = fs::read_to_string(fitted.join("fit.txt")).unwrap();
    for word in ["chi^2/N", "tread-modulus [Pa]", "fixed", "Correlations"] {
        assert!(text.contains(word), "{word}: {text}");
    }

    // A scene with the fitted tyre, and its own measurement as a further one.
    let mut scene: toml::Table = PLATE.parse().unwrap();
    scene.insert("tyre".to_owned(), "fitted/tyre.toml".into());
    fs::write(folder.path().join("other.toml"), scene.to_string()).unwrap();
    let tyre = Scene::load(folder.path().join("other.toml")).unwrap().scene.tyre;
    let modulus = answer["parameters"][0]["value"].as_f64().unwrap();
    assert!((Parameter::TreadModulus.value(&tyre).unwrap() / modulus - 1.0).abs() < 1e-12);
    assert!((modulus / Parameter::TreadModulus.value(&stiffer).unwrap() - 1.0).abs() < 0.05, "{modulus}");
    let again = ["fit-tyre", "fitted/mobility.csv", "other.toml", FIXED];
    let output = tyrewave(folder.path(), &again);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(String::from_utf8_lossy(&output.stdout).contains("results in results/other-fit-tyre"));
}

#[test]
fn what_mobility_writes_is_measured_enough_for_a_fit() {
    let folder = folder("");
    let tyre = toml::to_string(&truth()).unwrap();
    fs::write(folder.path().join("tyre.toml"), tyre).unwrap();
    let mobility = ["mobility", "tyre.toml", "--patch=20,50", "--points=6", "--to=1000", "--out=m"];
    let output = tyrewave(folder.path(), &mobility);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let fit = ["fit-tyre", "m/mobility.csv", "tyre.toml", "--out", "fitted", "--json", FIXED];
    let output = tyrewave(folder.path(), &fit);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let answer: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(answer["measured_values"], 12);
    let modulus = answer["parameters"][0]["value"].as_f64().unwrap();
    assert!((modulus / Parameter::TreadModulus.value(&truth()).unwrap() - 1.0).abs() < 1e-3, "{modulus}");
}

#[test]
fn mistakes_are_refused_with_their_place_and_nothing_is_written() {
    let good = "frequency_hz,patch_m,re,im\n100,0.05,1e-3,1e-3\n";
    for (csv, more, words) in [
        (
            "frequency_hz,patch_m,re,im\n100,50,1,1\n",
            &[][..],
            &["measured.csv: line 2, column 2 (patch_m)", "\"50\""][..],
        ),
        (good, &[], &["measured.csv: 1 measured values", "fix parameters"]),
        (good, &["--fix", "tread"], &["tread-modulus", "foundation-loss"]),
        (good, &["--fix", "belt-loss", "--free", "belt-loss"], &["belt-loss cannot be both"]),
        (good, &["--level-error", "0"], &["not a positive number"]),
    ] {
        let folder = folder(csv);
        let output = tyrewave(folder.path(), &[&COMMAND[..], more].concat());
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{message}");
        words.iter().for_each(|word| assert!(message.contains(word), "{word}: {message}"));
        assert_eq!(names(folder.path()), ["measured.csv", "scene.toml"], "{message}");
    }
    // A parameter that the tyre does not have, with its place in the scene.
    let folder = folder(good);
    let scene = replaced(PLATE, &[("tension = [6.0e4, 2.0e4]", "tension = [6.0e4, 0.0]")]);
    fs::write(folder.path().join("scene.toml"), scene).unwrap();
    let output = tyrewave(folder.path(), &[&COMMAND[..], &["--free", "tension-across"]].concat());
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.code() == Some(2) && message.contains("scene.toml:") && message.contains("from 0"),
        "{message}"
    );
}

#[test]
#[ignore = "minutes: four fits"]
fn a_wrong_patch_and_a_wrong_tread_move_the_parameters() {
    let (truth, free) = (truth(), usual());
    let points = measured(&truth, &PATCHES, (30, 3000.0), 1);
    let changed = |parameter: Parameter| {
        let mut tyre = truth.clone();
        *parameter.place(&mut tyre).unwrap() *= 1.05;
        tyre
    };
    let wider = |point: &MeasuredPoint| MeasuredPoint { patch: 1.05 * point.patch, ..*point };
    let wide: Vec<MeasuredPoint> = points.iter().map(wider).collect();
    println!("change of the parameters in %, bounds and chi^2/N\n{}", heading(&free));
    let mut moved = Vec::new();
    for (name, start, points) in [
        ("all right", truth.clone(), &points),
        ("patches 5 % too large", truth.clone(), &wide),
        ("tread 5 % too thick", changed(Parameter::TreadThickness), &points),
        ("tread 5 % too dense", changed(Parameter::TreadDensity), &points),
    ] {
        let found = fitted(&start, &free, points);
        let error = |estimate: &Estimate| 100.0 * (estimate.value / estimate.parameter.value(&truth).unwrap()).ln();
        let errors: Vec<f64> = found.estimates.iter().map(error).collect();
        println!("{}  {:.2}", row(name, errors.iter().copied()), found.chi_squared[1]);
        moved.push(errors[0]);
    }
    // Expected: 4 % of the tread's modulus; a local spring goes by modulus times side.
    assert!(moved[0].abs() < 2.0 && moved[1] < -2.0 && moved[1] > -8.0, "{moved:?}");
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
