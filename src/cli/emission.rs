//! `tyrewave emission`: a sweep's sound as models of traffic noise take it.

use std::fs;
use std::path::{Path, PathBuf};

use crate::results::ResultsError;
use crate::study::emission::{EMISSION_HEAD, Emission};
use crate::study::sweep::StoredSweep;
use clap::Args;

use super::context::{Context, print};
use super::error::CliError;
use super::output_file::{OutputFile, Replaces};

const EXAMPLES: &str = "\
Needs the folder of a finished sweep over speeds, of a scene with a coast-by receiver. For each band a straight line \
is fitted to the levels, L = A + B lg(v/v_ref); half of the 95 % confidence intervals of A and B and the rms residual \
are given, too:
  cnossos-eu  octaves 63 Hz to 8 kHz of the sound power of a car's four tyres: A_R and B_R, v_ref = 70 km/h
  nord2000    third octaves 25 Hz to 10 kHz of the same: a_R and b_R, v_ref = 70 km/h
  un-r117     L_AFmax of the coast-by, runs from 70 to 90 km/h, v_ref = 80 km/h

Runs that differ only in speed or seed share one line; each road, load and setting has a line of its own. Sound powers \
are those of point sources over a hard road that lead to the same mean square along the coast-by line (docs/sound.md). \
A row is valid if its band is valid in every run. All rows are in emission.csv, in the sweep's folder.

Examples:
  tyrewave sweep scenes/sound.toml --speed 50..110:10 --out results/speeds
  tyrewave emission results/speeds
  tyrewave emission results/speeds --json -q > emission.json
  tyrewave sweep scenes/sound.toml --speed 50..110:10 --set road.seed=1..3 --out results/draws
  tyrewave emission results/draws --out results/emission";

const FILE: &str = "emission.csv";

#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct EmissionArguments {
    /// Folder of a finished `tyrewave sweep` over speeds.
    #[arg(value_name = "SWEEP")]
    sweep: PathBuf,
    /// Folder for emission.csv; default: the sweep's.
    #[arg(long, short, value_name = "FOLDER")]
    out: Option<PathBuf>,
}

impl EmissionArguments {
    pub(crate) fn execute(self, context: &Context) -> Result<(), CliError> {
        let sweep = opened(&self.sweep)?;
        let emission = Emission::of(&sweep).map_err(|error| CliError::Usage(error.to_string()))?;
        let out = self.out.unwrap_or(self.sweep);
        fs::create_dir_all(&out).map_err(ResultsError::creating(&out))?;
        let path = out.join(FILE);
        OutputFile::begin(&path, Replaces::Beginning(EMISSION_HEAD))?.complete(&emission.csv())?;
        if context.options.json {
            return print(&format!("{:#}\n", emission.to_json()));
        }
        context.print_report(&emission.report())?;
        context.say(&format!("rows in {}\n", path.display()))
    }
}

fn opened(folder: &Path) -> Result<StoredSweep, CliError> {
    let found = if folder.is_dir() { StoredSweep::open(folder) } else { Ok(None) };
    let none = || {
        let right = "`tyrewave sweep SCENE --speed 50..110:10` makes one";
        CliError::Usage(format!("{} is not the folder of a sweep: {right}", folder.display()))
    };
    found.map_err(|error| CliError::Usage(error.to_string()))?.ok_or_else(none)
}
