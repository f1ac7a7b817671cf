//! `tyrewave tyre`: properties of a scene's tyre.

use crate::contact::static_contact::StaticContact;
use crate::counters::{Counter, Stage};
use crate::plan::overload::{Overload, overload};
use crate::report::tyre::{LEVEL, UnderLoad, plot as mobility_plot, tyre_record};
use crate::results::table::Report;
use crate::results::tread_pattern::{pattern_csv, pitch_spectrum, tread_picture};
use crate::run::{Progress, RunError};
use crate::scene::{GRAVITY, LoadedScene, Scene, SceneError};
use crate::study::loads::{LoadedTyre, rolling};
use crate::study::rolling_waves::rolling_waves;
use crate::tyre::influence::mobility::{driving_point, frequencies};
use crate::tyre::modes::{modes, radial_compliance};
use clap::Args;
use serde_json::json;

use super::context::Context;
use super::error::CliError;
use super::mobility::to_csv as mobility_csv;
use super::options::{patch_side, positive};
use super::side::Place;
use super::tyre_views as views;

const EXAMPLES: &str = "\
Modes: free vibrations with n periods round the tyre and the lateral number m, by frequency, damping (relative to \
critical) and motion: radial (if it is a quarter at least), otherwise the largest part, circumferential (for n = 0: \
torsion) or lateral. They are the poles of the tread surface's compliance; m are the lowest that a centred load \
excites. The tyre does not turn.

Rolling: with --rolling also the radial waves (lowest m) of the tyre that turns at the scene's speed, travelling with \
the rotation and against it, and critical speeds: of the belt, of the tread, and the stability limit of the turning \
tyre.

Loads: deflection, stiffness and length of the patch on a smooth road, the tyre standing; --rolling adds the mean \
length at the scene's speed, from a short run for each load. Lengths are those of whole elements, L/N, and grow by two \
at a time: numerics.elements refines them. A load is in kg (converted with 9.81 m/s2), or in newtons if an N follows.

Tread pattern: if there is one, its depths, its void ratio and the spectrum of its pitch sequence.

Mobility: velocity of a square patch of the tread for a unit force on it; the smaller the patch the higher its level.

Only the scene's tyre, its elements and, with --rolling, its speed and numerics are used. A tyre's file may be given \
instead; the tyre then rolls in the default scene.

Results: tyre.json (all numbers, SI units), modes.csv, loads.csv, mobility.csv; dispersion.svg (modes over n), \
compliance.svg (radial compliance over n and frequency, modes in grey), load_deflection.svg, patch_length.svg, \
mobility.svg, mobility_phase.svg; tyre.html, a page of all; with --rolling rolling_waves.csv and rolling_waves.svg: a \
wave against the rotation that lies on its line n V/L is stationary beside the axle; of a tread with a pattern \
pattern.csv, tread_pattern.svg and pitch_spectrum.svg.

Examples:
  tyrewave tyre scenes/default.toml
  tyrewave tyre scenes/tyres/wide.toml
  tyrewave tyre scenes/tyres/summer.toml
  tyrewave tyre scenes/default.toml --rolling --loads 300,350,400
  tyrewave tyre scenes/default.toml --loads 3400N,4000N --waves 20 --highest 800 --out tyre
  tyrewave tyre scenes/default.toml --json -q";

/// Number of points of the curves over the load.
const CURVE_POINTS: usize = 40;
/// Lowest and highest frequency of the mobility \[Hz\].
const MOBILITY: (f64, f64) = (50.0, 3000.0);
/// Frequencies of the mobility's table \[Hz\].
const TABLE: [f64; 7] = [63.0, 100.0, 200.0, 315.0, 500.0, 1000.0, 2000.0];
/// Number of rows of the map of the compliance.
const MAP_ROWS: u32 = 250;
/// Pictures of the page's sections, with their captions.
const MODES: [[&str; 2]; 2] = [
    ["dispersion.svg", "Frequency in Hz of each mode over the number n of its periods round the tyre."],
    ["compliance.svg", "Radial compliance of the tread surface over n and frequency in Hz; grey: the modes."],
];
const TURNING: [[&str; 2]; 1] = [[
    "rolling_waves.svg",
    "Frequency in Hz of the radial waves of the turning tyre, with its rotation and against it; a wave against it that \
     lies on the line n V/L is stationary beside the axle.",
]];
const LOADS: [[&str; 2]; 2] = [
    ["load_deflection.svg", "Load in N over the deflection in mm, the tyre standing on a smooth road."],
    ["patch_length.svg", "Length of the contact patch in mm over the load in N, in steps of whole elements."],
];
const PATTERN: [[&str; 2]; 2] = [
    ["tread_pattern.svg", "Depth of the tread in mm, a part of it unrolled."],
    ["pitch_spectrum.svg", "Amplitude of one unit pulse to each pitch, at the frequencies of the scene's speed in Hz."],
];
const MOBILITIES: [[&str; 2]; 2] = [
    ["mobility.svg", "Velocity of square patches of the tread for a unit force, dB re 1 m/(N s), by their side."],
    ["mobility_phase.svg", "Phase of that velocity in degrees."],
];

#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct TyreArguments {
    #[command(flatten)]
    place: Place,
    /// Largest number n of periods round the tyre.
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u16).range(..=500))]
    waves: u16,
    /// Number of lateral numbers m, from the lowest on.
    #[arg(long, value_name = "COUNT", default_value_t = 3, value_parser = clap::value_parser!(u16).range(1..=50))]
    lateral: u16,
    /// Highest frequency of the modes, in Hz.
    #[arg(long, value_name = "HZ", default_value = "500", value_parser = positive, allow_negative_numbers = true)]
    highest: f64,
    /// Loads: kg, or newtons as 3400N.
    #[arg(long, value_name = "LOADS", value_delimiter = ',', default_value = "300,350,400", value_parser = load)]
    loads: Vec<Load>,
    /// Also roll the tyre under each load on a smooth road (seconds each), and compute the waves of the turning tyre.
    #[arg(long)]
    rolling: bool,
    /// Sides of the square patches of the mobility, in mm.
    #[arg(long, value_name = "MM", value_delimiter = ',', default_value = "50,20,10,5", value_parser = patch_side)]
    patch: Vec<f64>,
    /// Number of frequencies of the mobility; 300 resolve modes of 2 % damping.
    #[arg(long, value_name = "N", default_value_t = 300, value_parser = clap::value_parser!(u32).range(2..=100_000))]
    points: u32,
}

/// A load as given, and in N.
#[derive(Clone, Debug, PartialEq)]
struct Load {
    label: String,
    newtons: f64,
}

/// Parses `300` or `300kg`, `3400N`.
fn load(text: &str) -> Result<Load, String> {
    let text = text.trim();
    let wrong = |_| format!("\"{text}\" is not a load: give kilograms as 350, or newtons as 3400N");
    let (number, unit, newtons) = match text.strip_suffix('N') {
        Some(number) => (number, "N", 1.0),
        None => (text.strip_suffix("kg").unwrap_or(text), "kg", GRAVITY),
    };
    let value = positive(number).map_err(wrong)?;
    Ok(Load { label: format!("{value} {unit}"), newtons: newtons * value })
}

/// Warnings about loads for which the tyre's model is inaccurate.
///
/// # Errors
/// [`CliError::Failed`] for a load beyond the model, unless the scene allows implausible values.
fn judged(loaded: &LoadedScene, contacts: &[StaticContact]) -> Result<Vec<String>, CliError> {
    let Scene { tyre, allow_implausible, .. } = &loaded.scene;
    let mut warnings = Vec::new();
    for found in contacts.iter().filter_map(|contact| overload(tyre, contact)) {
        match found {
            Overload::Beyond(wrong) if !allow_implausible => {
                return Err(CliError::Failed(format!("--loads: {wrong}; loads without a unit are in kg")));
            }
            Overload::Unusual(wrong) | Overload::Beyond(wrong) => warnings.push(wrong),
        }
    }
    Ok(warnings)
}

impl TyreArguments {
    pub(crate) fn execute(self, context: &Context) -> Result<(), CliError> {
        let Self { place, waves, lateral, highest, loads, rolling: rolls, patch, points } = self;
        let mut side = place.open_tyre("tyre", context)?;
        let (scene, title) = (side.loaded.scene.clone(), side.loaded.title());
        let tyre = &scene.tyre;
        if rolls {
            side.loaded.check_time_domain()?;
        }
        let mut progress = context.progress();
        progress.stage(Stage::Axle);
        let standing = side.meter.time(Stage::Influence, || LoadedTyre::new(&scene));
        let newtons: Vec<f64> = loads.iter().map(|load| load.newtons).collect();
        let contacts = newtons.iter().map(|&load| standing.under(load)).collect::<Result<Vec<_>, _>>();
        let contacts = contacts.map_err(RunError::from)?;
        let warnings = judged(&side.loaded, &contacts)?;
        let largest = newtons.iter().copied().fold(0.0, f64::max);
        let curve = standing.curve(largest, CURVE_POINTS).map_err(RunError::from)?;

        progress.stage(Stage::Influence);
        let (largest_n, lateral) = (usize::from(waves), usize::from(lateral));
        let found = side
            .meter
            .time(Stage::Influence, || modes(tyre, largest_n, lateral, highest))
            .map_err(|error| CliError::Failed(error.to_string()))?;
        side.meter.count(Counter::ComplianceEvaluations, found.evaluations);
        let rows: Vec<f64> = (0..MAP_ROWS).map(|row| highest * (f64::from(row) + 0.5) / f64::from(MAP_ROWS)).collect();
        let map = radial_compliance(tyre, largest_n, &rows);
        let sides: Vec<f64> = patch.iter().map(|side| side * 1e-3).collect();
        let (from, to) = MOBILITY;
        let mut mobility_at = |frequencies: &[f64]| {
            let mobility = side.meter.time(Stage::Influence, || driving_point(tyre, &sides, frequencies));
            side.meter.count(Counter::ComplianceEvaluations, mobility.evaluations);
            mobility
        };
        let (mobility, in_table) = (mobility_at(&frequencies(from, to, points)), mobility_at(&TABLE));

        let lengths = if rolls { Some(rolling(&scene, &newtons, context.job(&mut progress))?) } else { None };
        let turning = rolls.then(|| side.meter.time(Stage::Influence, || rolling_waves(&scene, largest_n, highest)));
        let turning = turning.transpose().map_err(|error| CliError::Failed(error.to_string()))?;
        drop(progress);
        let under: Vec<UnderLoad> = loads
            .into_iter()
            .zip(contacts)
            .enumerate()
            .map(|(index, (Load { label, .. }, standing))| UnderLoad {
                label,
                standing,
                rolling: lengths.as_ref().map(|lengths| lengths[index]),
            })
            .collect();

        let lateral_names = views::lateral_names(&found);
        let dispersion = views::dispersion(&found, &lateral_names, &title, [largest_n as f64, highest]);
        side.file("dispersion.svg", dispersion.to_svg());
        side.picture("compliance.svg", views::compliance(&found, &title, highest, &map))?;
        side.file("load_deflection.svg", views::load_deflection(&curve, &under, &title).to_svg());
        side.file("patch_length.svg", views::patch_length(&curve, &under, &title).to_svg());
        let names: Vec<String> = patch.iter().map(|patch| format!("{patch} mm")).collect();
        for (name, quantity) in [("mobility.svg", LEVEL), ("mobility_phase.svg", views::PHASE)] {
            side.file(name, mobility_plot(&mobility, &title, &names, quantity).to_svg());
        }
        if let Some(turning) = &turning {
            let picture = views::rolling_picture(turning, &title, tyre.circumference, highest);
            side.file("rolling_waves.svg", picture.to_svg());
            side.file("rolling_waves.csv", views::rolling_csv(turning));
        }
        let pattern = views::pattern_map(&scene).transpose().map_err(|fault| {
            let key = format!("tread_pattern.{}", fault.key);
            SceneError::from(side.loaded.complain(&key, fault.wrong, fault.right))
        })?;
        let speed = scene.rolling.speed();
        if let Some(map) = &pattern {
            side.picture("tread_pattern.svg", tread_picture(map, &title))?;
            if let Some(train) = &map.train {
                side.file("pitch_spectrum.svg", pitch_spectrum(train, speed, &title));
            }
            side.file("pattern.csv", pattern_csv(map, speed));
        }
        side.file("modes.csv", views::modes_csv(&found));
        side.file("loads.csv", views::loads_csv(&under));
        side.file("mobility.csv", mobility_csv(&mobility, &patch));
        let element = tyre.circumference / scene.numerics.elements as f64;
        let mut answer = tyre_record(&title, element, &found, &under, &mobility);
        if let Some(turning) = &turning {
            answer["rolling"] = views::rolling_json(turning);
        }
        if let Some(map) = &pattern {
            answer["tread_pattern"] = views::pattern_json(map);
        }
        side.json("tyre.json", &answer);
        side.settings = json!({
            "scene": side.settings,
            "waves": waves,
            "lateral": lateral,
            "highest": highest,
            "loads": newtons,
            "rolling": rolls,
            "patch_mm": patch,
            "points": points,
        });
        let [of_modes, of_loads, of_mobility] = [
            views::modes_report(&found, largest_n),
            views::loads_report(&under, element),
            views::mobility_report(&in_table, &names),
        ];
        let turning = turning.as_ref().map(views::rolling_report);
        let mut sections = vec![("Modes", &MODES[..], &of_modes)];
        sections.extend(turning.as_ref().map(|report| ("Turning tyre", &TURNING[..], report)));
        sections.extend([("Under a load", &LOADS[..], &of_loads), ("Mobility", &MOBILITIES[..], &of_mobility)]);
        let of_pattern = pattern.as_ref().map(|map| views::pattern_report(map, speed));
        sections.extend(of_pattern.as_ref().map(|report| ("Tread pattern", &PATTERN[..], report)));
        let lead = format!("A tyre of {:.3} m round and {:.0} mm across.", tyre.circumference, 1e3 * tyre.width);
        side.page("tyre.html", [&title, &lead], &sections);
        let mut report = Report::default();
        report.text(format!("{title}\n\n"));
        warnings.into_iter().for_each(|warning| report.text(format!("warning: {warning}\n\n")));
        sections.into_iter().for_each(|(_, _, of)| report.append(of.clone()));
        report.text("\n");
        side.finish(context, &report)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_load_is_in_kilograms_or_in_newtons_where_it_says_so() {
        let newtons = |text: &str| load(text).unwrap().newtons;
        assert!((newtons("350") - 3433.5).abs() < 1e-9 && (newtons(" 350kg ") - 3433.5).abs() < 1e-9);
        assert!((newtons("3400N") - 3400.0).abs() < 1e-9);
        assert_eq!((load("350").unwrap().label, load("3400N").unwrap().label), ("350 kg".into(), "3400 N".into()));
        for text in ["0", "-3", "heavy", "", "N", "3 t", "nan"] {
            let error = load(text).unwrap_err();
            assert!(error.contains("kilograms") && error.contains(&format!("\"{text}\"")), "{error}");
        }
    }
}
