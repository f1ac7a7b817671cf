//! `tyrewave road`: what a scene's road is like.

use std::path::{Path, PathBuf};

use clap::Args;
use ndarray::ArrayView2;
use serde_json::json;
use tyrewave::counters::Stage;
use tyrewave::plan::Plan;
use tyrewave::results::plots::road_map;
use tyrewave::results::table::{Report, aligned, words};
use tyrewave::road::{RoadDescription, describe};
use tyrewave::run::prepare::{in_scene, road_limits};
use tyrewave::scene::{DEFAULT, LoadedScene, Scene};
use tyrewave::study::sweep::{Axes, variants};

use super::context::Context;
use super::error::CliError;
use super::side::{Place, Side};

const EXAMPLES: &str = "\
Printed: extent, resolution, dropped points, mean profile depth, third-octave texture levels, and the highest \
frequency that the road can excite at the scene's speed. Drawn: its heights, in colours.

Examples:
  tyrewave road scenes/default.toml
  tyrewave road station.dat
  tyrewave road scenes/default.toml --out road";

#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct RoadArguments {
    /// The scene; its road, contact width and speed count. Or a road file (.dat, .csv, .crg), seen by the default
    /// scene.
    scene: PathBuf,
    /// Folder for the picture; default: results/NAME-road, NAME being the scene's.
    #[arg(long, short, value_name = "FOLDER")]
    out: Option<PathBuf>,
}

impl RoadArguments {
    /// Describes the road on the run's lattice; writes `road.json` and `road.svg`.
    pub fn execute(self, context: &Context) -> Result<(), CliError> {
        let Self { scene, out } = self;
        let mut side = Side::new(road_scene(&scene, context)?, Place { scene, out }.target("road"))?;
        let scene = &side.loaded.scene;
        let read = || describe(&scene.road, Plan::new(scene).lattice()?, scene.rolling.speed(), road_limits(scene));
        let road = side.meter.time(Stage::Road, read).map_err(|error| in_scene(&side.loaded, error))?;
        let sample = &road.sample;
        if let Ok(heights) = ArrayView2::from_shape((sample.rows, sample.columns), &sample.heights) {
            let map = road_map(&side.loaded.title(), heights, sample.start, [sample.dx, sample.dy]);
            side.picture("road.svg", map)?;
        }
        side.json("road.json", &json!(road));
        side.finish(context, &report(&road))
    }
}

/// A scene, or the default scene on the road that a file holds.
fn road_scene(path: &Path, context: &Context) -> Result<LoadedScene, CliError> {
    if path.extension().is_none_or(|ending| ending.eq_ignore_ascii_case("toml")) {
        return Ok(context.load(path)?);
    }
    let axes = Axes { roads: vec![path.to_owned()], ..Axes::default() };
    let mut made = variants(&Scene::from_str(DEFAULT, "default")?, &axes)?;
    // One road at one speed, headed with its own name: only the speed and the tyre's width are the default scene's.
    let mut loaded = made.swap_remove(0).loaded;
    loaded.scene.title = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    Ok(loaded)
}

fn report(road: &RoadDescription) -> Report {
    let mut rows: Vec<[String; 2]> = Vec::new();
    let mut row = |name: &str, value: String| rows.push([name.to_owned(), value]);
    let millimetres = |length: f64| format!("{:.3} mm", 1e3 * length);
    row("extent", road.extent.map_or("endless".into(), |(from, to)| format!("{from:.3} to {to:.3} m")));
    row(
        "run's lattice",
        format!(
            "elements of {}, {} x {} cells of {} along, {} across",
            millimetres(road.lattice.dx),
            road.lattice.along,
            road.lattice.columns,
            millimetres(road.lattice.cell()),
            millimetres(road.lattice.dy)
        ),
    );
    if let Some(spacing) = road.report.spacing {
        let across = road.report.lateral_spacing.map_or("level across".into(), |dy| format!("dy {}", millimetres(dy)));
        row("road's own lattice", format!("dx {}, {across}", millimetres(spacing)));
    }
    if road.report.points > 0 {
        let share = 100.0 * road.report.missing as f64 / road.report.points as f64;
        row("points in the file", format!("{}, {} missing ({share:.1} %)", road.report.points, road.report.missing));
    }
    row("rms height", millimetres(road.rms));
    row("highest to lowest", millimetres(road.span));
    row("mean profile depth", road.mean_profile_depth.map_or("not defined".into(), millimetres));
    let hertz = |frequency: Option<f64>| frequency.map_or("none".into(), |f| format!("{f:.0} Hz"));
    row(
        "highest frequency excited",
        format!(
            "{} in this run, {} by the road itself",
            hertz(road.highest_frequency),
            hertz(road.highest_frequency_of_road)
        ),
    );
    let mut report = Report::default();
    report.table(words([""; 0], rows));
    if !road.levels.is_empty() {
        let level = road.levels.iter().map(|at| [format!("{:.2}", 1e3 * at.wavelength), format!("{:.1}", at.level)]);
        report.text("\n");
        report.table(aligned(["wavelength [mm]", "level [dB re 1e-6 m]"], level));
    }
    report.text("\n");
    road.report.notes.iter().for_each(|note| report.text(format!("note: {note}\n")));
    report
}
