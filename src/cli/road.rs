//! `tyrewave road`: what a scene's road is like.

use std::path::PathBuf;

use clap::Args;

const EXAMPLES: &str = "\
Printed: extent, resolution, dropped points, mean profile depth, third-octave texture levels, and the highest frequency that the road can excite at \
the scene's speed. Drawn: its heights, in colours.

Examples:
  tyrewave road scenes/default.toml
  tyrewave road scenes/default.toml --out road";

/// Arguments of `tyrewave road`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct RoadArguments {
    /// The scene; its road, contact width and speed count.
    pub scene: PathBuf,
    /// Folder for the picture; default: results/NAME-road, NAME being the scene's.
    #[arg(long, short, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
}
