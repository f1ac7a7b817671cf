//! `tyrewave road`: what a scene's road is like.

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
use super::scene_file::SceneFile;
use super::side::{Place, Side};

const EXAMPLES: &str = "\
In place of a scene, a road file (.dat, .csv, .crg) may be named: the default scene sees it. Of a scene its road, \
contact width and speed count.

Printed: extent, resolution, dropped points, mean profile depth (ISO 13473-1) with its valid segments and whether it \
is that of the reference surface of ISO 10844, third-octave texture levels (ISO 13473-4), those of macrotexture and \
megatexture, and the highest frequency that the road can excite at the scene's speed. Drawn: its heights, in colours, \
and its texture spectrum, grey where the road is too short for a level.

Examples:
  tyrewave road scenes/default.toml
  tyrewave road station.dat
  tyrewave road scenes/default.toml --out road";

#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct RoadArguments {
    #[command(flatten)]
    place: Place,
}

impl RoadArguments {
    /// Describes the road on the run's lattice; writes `road.json`, `road.svg` and `texture_spectrum.svg`.
    pub fn execute(self, context: &Context) -> Result<(), CliError> {
        let mut side = Side::new(road_scene(&self.place.scene, context)?, self.place.target("road"))?;
        let scene = &side.loaded.scene;
        let read = || describe(&scene.road, Plan::new(scene).lattice()?, scene.rolling.speed(), road_limits(scene));
        let road = side.meter.time(Stage::Road, read).map_err(|error| in_scene(&side.loaded, error))?;
        let title = side.loaded.title();
        if !road.sample.heights.is_empty() {
            side.picture("road.svg", map(&format!("Heights: {title}"), &road))?;
        }
        if let Some(spectrum) = texture_spectrum(&format!("Texture, third octaves: {title}"), &road)? {
            side.file("texture_spectrum.svg", spectrum);
        }
        side.json("road.json", &json!(road));
        side.finish(context, &description(&road))
    }
}

/// A scene, or the default scene on the road that a file holds.
fn road_scene(of: &SceneFile, context: &Context) -> Result<LoadedScene, CliError> {
    let path = &of.scene;
    if path.extension().is_none_or(|ending| ending.eq_ignore_ascii_case("toml")) {
        return context.load(of);
    }
    let axes = Axes { roads: vec![path.to_owned()], ..Axes::default() };
    let mut made = variants(&Scene::from_str_with(DEFAULT, "default", &of.settings)?, &axes)?;
    // One road at one speed, headed with its own name: only the speed and the tyre's width are the default scene's.
    let mut loaded = made.swap_remove(0).loaded;
    loaded.scene.title = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    Ok(loaded)
}
