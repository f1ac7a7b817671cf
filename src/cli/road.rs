//! `tyrewave road`: what a scene's road is like.

use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::json;
use tyrewave::counters::Stage;
use tyrewave::plan::Plan;
use tyrewave::report::road::{description, map, texture_spectrum};
use tyrewave::road::describe;
use tyrewave::run::prepare::{in_scene, road_limits};
use tyrewave::scene::{DEFAULT, LoadedScene, Scene};
use tyrewave::study::sweep::{Axes, variants};

use super::context::Context;
use super::error::CliError;
use super::side::{Place, Side};

const EXAMPLES: &str = "\
Printed: extent, resolution, dropped points, mean profile depth, third-octave texture levels, and the highest \
frequency that the road can excite at the scene's speed. Drawn: its heights, in colours, and its texture spectrum.

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
    /// Describes the road on the run's lattice; writes `road.json`, `road.svg` and `texture_spectrum.svg`.
    pub fn execute(self, context: &Context) -> Result<(), CliError> {
        let Self { scene, out } = self;
        let mut side = Side::new(road_scene(&scene)?, Place { scene, out }.target("road"))?;
        let scene = &side.loaded.scene;
        let read = || describe(&scene.road, Plan::new(scene).lattice()?, scene.rolling.speed(), road_limits(scene));
        let road = side.meter.time(Stage::Road, read).map_err(|error| in_scene(&side.loaded, error))?;
        let title = side.loaded.title();
        if !road.sample.heights.is_empty() {
            side.picture("road.svg", map(&title, &road))?;
        }
        if let Some(spectrum) = texture_spectrum(&title, &road)? {
            side.file("texture_spectrum.svg", spectrum);
        }
        side.json("road.json", &json!(road));
        side.finish(context, &description(&road))
    }
}

/// A scene, or the default scene on the road that a file holds.
fn road_scene(path: &Path) -> Result<LoadedScene, CliError> {
    if path.extension().is_none_or(|ending| ending.eq_ignore_ascii_case("toml")) {
        return Ok(Scene::load(path)?);
    }
    let axes = Axes { roads: vec![path.to_owned()], ..Axes::default() };
    let mut made = variants(&Scene::from_str(DEFAULT, "default")?, &axes)?;
    // One road at one speed, headed with its own name: only the speed and the tyre's width are the default scene's.
    let mut loaded = made.swap_remove(0).loaded;
    loaded.scene.title = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    Ok(loaded)
}
