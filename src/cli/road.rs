//! `tyrewave road`: what a scene's road is like.

use std::path::{Path, PathBuf};

use clap::Args;
use ndarray::ArrayView2;
use serde_json::json;
use tyrewave::counters::{Meter, Stage};
use tyrewave::plan::{Plan, settled};
use tyrewave::results::plots::RoadMap;
use tyrewave::results::summary::Cost;
use tyrewave::results::table::{aligned, words};
use tyrewave::results::{ResultsFolder, Summary};
use tyrewave::road::{RoadDescription, describe};
use tyrewave::run::prepare::{in_scene, road_limits};
use tyrewave::scene::{DEFAULT, LoadedScene, Scene};
use tyrewave::study::sweep::{Axes, variants};

use super::{CliError, Context, side_folder};

const EXAMPLES: &str = "\
Printed: extent, resolution, dropped points, mean profile depth, third-octave texture levels, and the highest frequency that the road can excite at \
the scene's speed. Drawn: its heights, in colours.

Examples:
  tyrewave road scenes/default.toml
  tyrewave road station.dat
  tyrewave road scenes/default.toml --out road";

/// Arguments of `tyrewave road`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct RoadArguments {
    /// The scene; its road, contact width and speed count. Or a road file (.dat, .csv, .crg), seen by the default
    /// scene.
    pub scene: PathBuf,
    /// Folder for the picture; default: results/NAME-road, NAME being the scene's.
    #[arg(long, short, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
}

impl RoadArguments {
    /// Describes the road on the run's lattice; writes `road.json` and `road.svg`.
    ///
    /// # Errors
    /// [`CliError`].
    pub fn execute(self, context: &Context) -> Result<(), CliError> {
        let loaded = settled(road_scene(&self.scene)?)?;
        let scene = &loaded.scene;
        let begin = std::time::Instant::now();
        let mut meter = Meter::default();
        let description = meter
            .time(Stage::Road, || {
                describe(&scene.road, Plan::new(scene).lattice()?, scene.rolling.speed(), road_limits(scene))
            })
            .map_err(|error| in_scene(&loaded, error))?;
        let title = loaded.title();
        let target = self.out.clone().unwrap_or_else(|| side_folder(&self.scene, "road"));
        let folder = ResultsFolder::create(&target)?;
        let sample = &description.sample;
        if let Ok(heights) = ArrayView2::from_shape((sample.rows, sample.columns), &sample.heights) {
            let map = RoadMap { title: &title, heights, start: sample.start, dx: sample.dx, dy: sample.dy };
            folder.write_text("road.svg", &map.to_svg()?)?;
        }
        folder.write_text("road.json", &format!("{:#}\n", json!(description)))?;
        let cost = Cost::new(&meter, begin.elapsed().as_secs_f64(), context.threads);
        let place = folder.finish(Summary::begun(&title, loaded.settings()?, cost))?;
        context.answer(&description_text(&description), &place)
    }
}

/// A scene, or the default scene on the road that a file holds.
fn road_scene(path: &Path) -> Result<LoadedScene, CliError> {
    if path.extension().is_none_or(|ending| ending.eq_ignore_ascii_case("toml")) {
        return Ok(Scene::load(path)?);
    }
    let axes = Axes { roads: vec![path.to_owned()], ..Axes::default() };
    let mut made = variants(&Scene::from_str(DEFAULT, "default")?, &axes)?;
    // One road at one speed.
    Ok(made.swap_remove(0).loaded)
}

fn description_text(road: &RoadDescription) -> String {
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
    let levels: Vec<_> = road
        .levels
        .iter()
        .map(|level| [format!("{:.2}", 1e3 * level.wavelength), format!("{:.1}", level.level)])
        .collect();
    let levels = if levels.is_empty() {
        String::new()
    } else {
        format!("\n{}", aligned(&["wavelength [mm]", "level [dB re 1e-6 m]"], &levels))
    };
    let notes: String = road.report.notes.iter().map(|note| format!("note: {note}\n")).collect();
    format!("{}{levels}\n{notes}", words(&[""; 0], &rows))
}
