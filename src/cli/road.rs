//! `tyrewave road`: properties of a scene's road.

use std::path::Path;

use crate::counters::Stage;
use crate::plan::Plan;
use crate::report::road::{description, map, texture_spectrum};
use crate::road::RoadError;
use crate::run::road::{described, in_scene};
use crate::scene::{DEFAULT, LoadedScene, Scene, SceneError, Setting};
use crate::study::sweep::{Axes, variants};
use clap::Args;
use serde_json::json;

use super::context::{Context, SceneFile};
use super::error::CliError;
use super::side::{Place, Side};

const EXAMPLES: &str = "\
In place of a scene, a road file (.dat, .csv, .txt, .erd, .crg, .xyz, .asc) may be given: the default scene is then \
used on this road. The answer depends only on the scene's road, contact width and speed. Columns and units are found \
from the titles of a table, such as \"Height (mm)\"; where it has none, --columns, --distance-unit and --height-unit \
give them.

Printed: columns read, extent, resolution, dropped points, skewness and kurtosis, mean profile depth (ISO 13473-1) \
with its valid segments and a comparison with the reference surface of ISO 10844, third-octave texture levels (ISO \
13473-4), levels of macrotexture and megatexture, and the highest frequency that the road can excite at the scene's \
speed. Drawn: the heights of the road, in colours, and its texture spectrum, grey where the road is too short for a \
level.

Examples:
  tyrewave road scenes/default.toml
  tyrewave road station.dat
  tyrewave road measured.csv --distance-unit m --height-unit mm
  tyrewave road scenes/default.toml --out road";

#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct RoadArguments {
    #[command(flatten)]
    place: Place,
    /// Columns of distance and height, by titles or by numbers from 1; equal to --set road.columns=[A,B].
    #[arg(long, value_name = "A,B", value_delimiter = ',')]
    columns: Vec<String>,
    /// Unit of the distances in a file that does not state it; equal to --set road.distance_unit=UNIT.
    #[arg(long, value_name = "UNIT", value_parser = UNITS)]
    distance_unit: Option<String>,
    /// Unit of the heights in a file that does not state it.
    #[arg(long, value_name = "UNIT", value_parser = UNITS)]
    height_unit: Option<String>,
}

const UNITS: [&str; 7] = ["m", "mm", "um", "cm", "in", "ft", "mil"];

impl RoadArguments {
    /// Describes the road on the run's lattice; writes `road.json`, `road.svg` and `texture_spectrum.svg`.
    pub(crate) fn execute(self, context: &Context) -> Result<(), CliError> {
        let Self { mut place, columns, distance_unit, height_unit } = self;
        let columns = (!columns.is_empty()).then(|| json!(columns).to_string());
        let given = [("columns", columns), ("distance_unit", distance_unit), ("height_unit", height_unit)];
        for (key, value) in given {
            let setting = value.map(|value| Setting::parse(&format!("road.{key}={value}")));
            place.scene.settings.extend(setting.transpose().map_err(CliError::Usage)?);
        }
        let of_file = is_road(&place.scene.scene);
        let mut side = Side::new(road_scene(&place.scene, context)?, place.target("road"))?;
        let read = || described(&Plan::new(&side.loaded.scene));
        let road = side.meter.time(Stage::Road, read).map_err(|error| match error {
            RoadError::MissingUnit { path, .. } if of_file => CliError::Usage(format!(
                "{}: the file does not state its units: give --distance-unit and --height-unit, {}",
                path.display(),
                UNITS.join(", ")
            )),
            // The scene is the program's: its places are of no use.
            other if of_file => CliError::Usage(other.to_string()),
            other => in_scene(&side.loaded, other).into(),
        })?;
        let title = side.loaded.title();
        if !road.sample.heights.is_empty() {
            side.picture("road.svg", map(&format!("Heights: {title}"), &road))?;
        }
        if let Some(spectrum) = texture_spectrum(&format!("Texture, third octaves: {title}"), &road) {
            side.file("texture_spectrum.svg", spectrum);
        }
        side.json("road.json", &json!(road));
        side.finish(context, &description(&road))
    }
}

/// True if a file is a road, by its ending, and not a scene.
fn is_road(path: &Path) -> bool {
    path.extension().is_some_and(|ending| !ending.eq_ignore_ascii_case("toml"))
}

/// A scene, or the default scene on the road in a file.
fn road_scene(of: &SceneFile, context: &Context) -> Result<LoadedScene, CliError> {
    let path = &of.scene;
    if !is_road(path) {
        return context.load(of);
    }
    // Settings of a road apply to the file's.
    let (mut road, others): (Vec<_>, Vec<_>) =
        of.settings.iter().cloned().partition(|setting| setting.key().starts_with("road."));
    if road.iter().any(|setting| setting.key() == "road.kind") {
        // The table of another kind begins anew, without its file.
        let absolute = std::path::absolute(path).map_err(|source| SceneError::reading(path, source))?;
        road.insert(0, Setting::file("road.file", &absolute));
    }
    let axes = Axes { roads: vec![path.to_owned()], points: vec![road], ..Axes::default() };
    let mut made = variants(&Scene::from_str_with(DEFAULT, "default", &others)?, &axes)?;
    // One road at one speed, titled by the road's file: only the speed and the tyre's width are the default scene's.
    let mut loaded = made.swap_remove(0).loaded;
    loaded.scene.title = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    Ok(loaded)
}
