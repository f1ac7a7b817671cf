//! Every parser against mutated files: none panics, none takes long, none gives heights that are no numbers.
//!
//! A mutant is a valid file with bits flipped, parts cut, doubled or taken from another file, and numbers and tokens in
//! the place of others. The same seed makes the same mutants; a failure prints target, number and bytes.

use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use sha2::{Digest, Sha256};
use tempfile::TempDir;
use tyrewave::internals::{
    Cache, Cached, RationalModel, cases, measured_mobility as measured, radiation_cases as evaluate_radiation,
    sampled_heights,
};
use tyrewave::road::{Lattice, Limits, describe};
use tyrewave::scene::{
    AtEnd, DEFAULT, GridRoad, Lateral, LengthUnit, Levelling, OpenCrgRoad, PLATE, ProfileRoad, Road, Scene, Widen,
};

mod corpus;
mod mutants;
mod scenes;

/// Longest that a parser may take for a file of some kilobytes, in any build.
const LONGEST: Duration = Duration::from_secs(20);
/// Time beyond which an execution is reported, and examined.
const TOLD: Duration = Duration::from_secs(1);
/// Memory for opening a road or solving a case \[bytes\].
const MEMORY: u64 = 1 << 24;

/// A parser and what it is fed.
struct Target {
    name: &'static str,
    corpus: Vec<Vec<u8>>,
    /// Mutants in a short test.
    executions: u64,
    feed: fn(&Path, &[u8]),
}

fn targets() -> Vec<Target> {
    let target = |name, corpus, executions, feed| Target { name, corpus, executions, feed };
    let texts = |texts: &[&str]| texts.iter().map(|text| text.as_bytes().to_vec()).collect::<Vec<_>>();
    vec![
        target("scene", texts(&[DEFAULT, PLATE, corpus::SOUND]), 100, scene),
        target("tyre file", texts(&[corpus::TYRE]), 100, tyre),
        target("profile .dat", vec![corpus::captif()], 150, profile),
        target("profile .csv", vec![corpus::profile(b','), corpus::profile(b';')], 150, profile),
        target("OpenCRG", vec![corpus::crg_text(), corpus::crg_binary()], 150, crg),
        target(".npy grid", corpus::grids(), 300, grid),
        target("compliance cases", texts(&[corpus::COMPLIANCE]), 100, compliance),
        target("radiation cases", texts(&[corpus::RADIATION]), 20, radiation_cases),
        target("mobilities", texts(&corpus::MOBILITIES), 300, mobilities),
        target("sealed file", vec![corpus::sealed()], 200, sealed),
        target("sealed body", vec![corpus::body()], 200, sealed_body),
    ]
}

fn scene(_folder: &Path, bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    match Scene::from_str(text, "scene.toml") {
        Ok(loaded) => assert!(loaded.hash().is_ok()),
        Err(error) => assert!(error.render(false).len() < 100_000),
    }
}

fn tyre(folder: &Path, bytes: &[u8]) {
    let scene = "tyre = \"tyre.toml\"\nrolling = { speed_kmh = 80, duration = 1, axle = { load = 3400 } }\n";
    fs::write(folder.join("scene.toml"), scene).unwrap();
    fs::write(folder.join("tyre.toml"), bytes).unwrap();
    if let Err(error) = Scene::load(folder.join("scene.toml")) {
        assert!(error.render(false).len() < 100_000);
    }
}

/// Describes a road in a file: what can be described has finite heights.
fn road(folder: &Path, bytes: &[u8], road: impl Fn(std::path::PathBuf) -> Road) {
    let file = folder.join("road");
    fs::write(&file, bytes).unwrap();
    let spec = road(file);
    let limits = Limits { bytes: MEMORY };
    let reported =
        Lattice::choose(&spec, 0.01, 0.1, None, None).and_then(|lattice| describe(&spec, lattice, 20.0, limits));
    if let Ok(reported) = reported {
        assert!(sampled_heights(&reported).iter().all(|height| height.is_finite()));
        assert!(reported.levels.iter().all(|at| at.level.is_finite()) && reported.rms.is_finite());
    }
}

fn profile(folder: &Path, bytes: &[u8]) {
    // An isotropic surface takes a hundred times as long: it is designed, whatever the profile.
    let laterals: &[_] = &[Lateral::Extruded, Lateral::Isotropic];
    for &lateral in &laterals[..if bytes.len().is_multiple_of(32) { 2 } else { 1 }] {
        let unit = Some(LengthUnit::Millimetre);
        let of = |file| {
            let (columns, range) = (None, None);
            let at_end = AtEnd::Repeat;
            let (distance_unit, height_unit, seed) = (unit, unit, 1);
            let (missing, level, longest_wavelength) = (None, Levelling::Slope, None);
            Road::Profile(ProfileRoad {
                file,
                distance_unit,
                height_unit,
                columns,
                range,
                missing,
                level,
                longest_wavelength,
                lateral,
                seed,
                at_end,
            })
        };
        road(folder, bytes, of);
    }
}

fn crg(folder: &Path, bytes: &[u8]) {
    road(folder, bytes, |file| {
        let (lateral_position, missing, longest_wavelength) = (None, None, Some(1.0));
        let (widen, level, at_end) = (Widen::Mirror, Levelling::Slope, AtEnd::Mirror);
        Road::OpenCrg(OpenCrgRoad { file, lateral_position, widen, missing, level, longest_wavelength, at_end })
    });
}

fn grid_road(file: PathBuf) -> GridRoad {
    let (distance_unit, height_unit, columns) = (None, None, None);
    let (dx, dy, widen, at_end) = (Some(0.01), Some(0.025), Widen::Mirror, AtEnd::Repeat);
    let (missing, level, longest_wavelength) = (None, Levelling::Mean, None);
    GridRoad { file, dx, dy, distance_unit, height_unit, columns, widen, missing, level, longest_wavelength, at_end }
}

fn grid(folder: &Path, bytes: &[u8]) {
    // The ending decides whether it is an array.
    road(folder, bytes, |file| {
        let array = file.with_extension("npy");
        fs::copy(&file, &array).unwrap();
        Road::Grid(grid_road(array))
    });
}

fn compliance(_folder: &Path, bytes: &[u8]) {
    if let Ok(answer) = cases::evaluate(&String::from_utf8_lossy(bytes)) {
        let written = answer["cases"].to_string();
        assert!(!written.contains("[null"), "{written}");
    }
}

fn radiation_cases(_folder: &Path, bytes: &[u8]) {
    if let Ok(answer) = evaluate_radiation(&String::from_utf8_lossy(bytes), MEMORY, &|| false) {
        assert!(!answer.to_string().contains("null"), "{answer}");
    }
}

fn mobilities(_folder: &Path, bytes: &[u8]) {
    if let Ok(points) = measured::read(bytes, 0.2) {
        assert!(points.iter().all(|point| point.frequency > 0.0 && point.mobility.is_finite()));
    }
}

fn sealed(folder: &Path, bytes: &[u8]) {
    let cache = Cache::at(folder.to_owned(), u64::MAX);
    fs::write(cache.path::<RationalModel>(&corpus::KEY), bytes).unwrap();
    assert!(!matches!(cache.load::<RationalModel>(&corpus::KEY), Ok(Some(Ok(_)))), "no such model was stored");
    let _ = tyrewave::internals::read_checkpoint(folder);
}

/// A body in a file whose seal is whole.
fn sealed_body(folder: &Path, bytes: &[u8]) {
    let format = RationalModel::KIND.format;
    let length = (bytes.len() as u64).to_le_bytes();
    let mut file = [&format.magic[..], &format.version.to_le_bytes(), &length, bytes].concat();
    let seal = Sha256::digest(&file);
    file.extend_from_slice(&seal);
    sealed(folder, &file);
}

/// Feeds a target so many mutants, or as many as there is time for; returns how many, and the slowest.
fn feed(target: &Target, seed: u64, executions: u64, time: Duration) -> (u64, Duration) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let folder: TempDir = tempfile::tempdir().unwrap();
    let (begin, mut slowest) = (Instant::now(), Duration::ZERO);
    for bytes in &target.corpus {
        (target.feed)(folder.path(), bytes);
    }
    for number in 0..executions {
        if begin.elapsed() > time {
            return (number, slowest);
        }
        let bytes = mutants::mutant(&target.corpus, &mut random);
        // What does not end at all is found here.
        fs::write(folder.path().join("mutant"), &bytes).unwrap();
        let start = Instant::now();
        let outcome = catch_unwind(AssertUnwindSafe(|| (target.feed)(folder.path(), &bytes)));
        let taken = start.elapsed();
        if taken > slowest && taken > TOLD {
            println!("{}: {taken:.1?} for mutant {number} of seed {seed}", target.name);
        }
        slowest = slowest.max(taken);
        let shown = String::from_utf8_lossy(&bytes[..bytes.len().min(4000)]).into_owned();
        assert!(outcome.is_ok(), "{} panics at mutant {number} of seed {seed}:\n{shown}", target.name);
        assert!(taken < LONGEST, "{}: {taken:?} for mutant {number} of seed {seed}:\n{shown}", target.name);
    }
    (executions, slowest)
}

#[test]
fn no_parser_panics_at_mutated_files() {
    for target in targets() {
        feed(&target, 1, target.executions, Duration::from_millis(300));
    }
}

#[test]
#[ignore = "a minute for each parser, or TYREWAVE_FUZZ_SECONDS; 11 min"]
fn no_parser_panics_at_very_many_mutated_files() {
    let number = |name: &str| std::env::var(name).ok().and_then(|text| text.parse().ok());
    let (seconds, seed) = (number("TYREWAVE_FUZZ_SECONDS").unwrap_or(60), number("TYREWAVE_FUZZ_SEED").unwrap_or(2));
    let wanted = std::env::var("TYREWAVE_FUZZ_TARGET").unwrap_or_default();
    for target in targets().iter().filter(|target| target.name.contains(&wanted)) {
        let (executions, slowest) = feed(target, seed, u64::MAX, Duration::from_secs(seconds));
        println!("{:18} {executions:>9} executions, the slowest {slowest:.1?}", target.name);
    }
}
