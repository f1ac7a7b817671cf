//! Figures without rolling: mobility of the tread (figure 2) and a rough road (figure 3).

use crate::numeric::StraightLine;
use crate::plan::Plan;
use crate::report::mobility::{LEVEL, plot};
use crate::report::road::map;
use crate::run::road::{described, in_scene};
use crate::scene::{LoadedScene, Tyre};
use crate::tyre::influence::mobility::{driving_point, frequencies, level};
use serde_json::json;

use super::subject::{Subject, Verdict};
use crate::cli::error::CliError;

/// Sides of the square patches \[m\], falling.
const PATCHES: [f64; 4] = [0.05, 0.02, 0.01, 0.005];
/// Range of frequencies \[Hz\], and their number.
const BAND: [f64; 2] = [50.0, 3000.0];
const POINTS: u32 = 120;
/// Above this frequency the mobility of a small patch is a spring's \[Hz\].
const SPRING_FROM: f64 = 1000.0;
/// Share of the frequencies at which the level must rise: resonances of the tyre may hide it at the others.
const OFTEN: f64 = 0.9;

/// Figure 2: driving-point mobility of patches of several sizes.
pub(super) fn mobility(tyre: &Tyre) -> Result<Subject, CliError> {
    let frequencies = frequencies(BAND[0], BAND[1], POINTS);
    let mobility = driving_point(tyre, &PATCHES, &frequencies);
    let levels: Vec<[f64; 4]> =
        mobility.values.iter().map(|row| std::array::from_fn(|patch| level(row[patch]))).collect();
    // 1. Rise of the level from each patch to the next smaller one.
    let count = levels.len() as f64;
    let rising =
        levels.iter().filter(|row| row.is_sorted_by(|larger, smaller| larger < smaller)).count() as f64 / count;
    let halvings = (PATCHES[0] / PATCHES[3]).log2();
    let per_halving = levels.iter().map(|row| row[3] - row[0]).sum::<f64>() / (count * halvings);
    // 2. Power of the frequency with which the mobility of the smallest patch grows.
    let values = frequencies.iter().zip(&mobility.values).filter(|(frequency, _)| **frequency >= SPRING_FROM);
    let smallest: Vec<(f64, f64)> = values.map(|(&frequency, row)| (frequency, row[3].norm())).collect();
    let exponent = StraightLine::power_law(&smallest).map_or(f64::NAN, |line| line.slope);
    let numbers =
        json!({ "patches": PATCHES, "rising": rising, "mean_rise_per_halving": per_halving, "exponent": exponent });
    let mut subject = Subject::new("Figure 2", "mobility", numbers);
    let share = 100.0 * rising;
    subject.state(
        ["mobility of the tread over the size of the patch", "the level rises as the patch shrinks"],
        format!(
            "{per_halving:.1} dB for half the side; at {share:.0} % of the frequencies from each patch to the next"
        ),
        (Verdict::of(rising >= OFTEN), format!("such a rise at {} % of the frequencies or more", 100.0 * OFTEN)),
    );
    let smallest = 1e3 * PATCHES[3];
    subject.state(
        ["mobility of a small patch", "grows like that of a spring above 400 to 1000 Hz"],
        format!("grows with the frequency to the power {exponent:.2} from {SPRING_FROM} Hz on, {smallest} mm"),
        (Verdict::of((exponent - 1.0).abs() < 0.5), "a power nearer to a spring's 1 than to a damper's 0"),
    );
    let names = PATCHES.map(|side| format!("{} mm", 1e3 * side));
    let picture = plot(&mobility, "Driving-point mobility of the tread", &names, LEVEL).to_svg();
    subject.pictures.push((["mobility.svg", "A square patch in the middle of the tread."], picture));
    Ok(subject)
}

/// Figure 3: a piece of the scene's road, and its measures.
pub(super) fn road(loaded: &LoadedScene) -> Result<Subject, CliError> {
    let road = described(&Plan::new(&loaded.scene)).map_err(|error| in_scene(loaded, error))?;
    let depth = road.mean_profile_depth.as_ref().and_then(|depth| depth.mean);
    let numbers = json!({ "rms": road.rms, "mean_profile_depth": depth, "levels": road.levels });
    let mut subject = Subject::new("Figure 3", "road", numbers);
    let depth = depth.map_or_else(String::new, |depth| format!("mean profile depth {:.2} mm, ", 1e3 * depth));
    subject.state(
        ["a rough road", "a measured road in a picture"],
        format!("{depth}rms height {:.2} mm, {} third octaves", 1e3 * road.rms, road.levels.len()),
        (Verdict::NotComparable, "the heights of the paper's road are not given; this one is made"),
    );
    if !road.sample.heights.is_empty() {
        subject
            .pictures
            .push((["road.svg", "A piece of the road, its heights in colours."], map("A rough road", &road)?));
    }
    Ok(subject)
}
