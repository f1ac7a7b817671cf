//! `tyrewave emission`: a sweep's sound as models of traffic noise take it.

use std::fs;
use std::path::{Path, PathBuf};

use crate::report::Stored;
use crate::results::ResultsError;
use crate::results::summary::SUMMARY_FILE;
use crate::study::emission::{EMISSION_HEAD, Emission};
use clap::Args;

use super::context::{Context, print};
use super::error::CliError;
use super::output_file::{OutputFile, Replaces};

const EXAMPLES: &str = "\
Needs the folder of a finished sweep over speeds, of a scene with a coast-by receiver. Per band a line through the \
levels, L = A + B lg(v/v_ref), with half of the 95 % intervals of A and B and the rms of what the line misses:
  cnossos-eu  octaves 63 Hz to 8 kHz of the sound power of a car's four tyres: A_R and B_R, v_ref = 70 km/h
  nord2000    third octaves 25 Hz to 10 kHz of the same: a_R and b_R, v_ref = 70 km/h
  un-r117     maximum F of the coast-by, runs from 70 to 90 km/h, v_ref = 80 km/h

Runs that differ in speed, or in seeds, make one line; roads, loads and settings have lines of their own. Sound powers \
are those of point sources over a hard road that lead to the same mean square along the coast-by line (docs/sound.md). \
A row is valid where every run vouches for its band. All rows stand in emission.csv, in the sweep's folder.

Examples:
  tyrewave sweep scenes/sound.toml --speed 50..110:10 --out results/speeds
  tyrewave emission results/speeds
  tyrewave emission results/speeds --json -q > emission.json
  tyrewave sweep scenes/sound.toml --speed 50..110:10 --set road.seed=1..3 --out results/draws
  tyrewave emission results/draws --out results/emission";

/// File of all rows.
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
    /// Reads, fits, writes and prints.
    pub(crate) fn execute(self, context: &Context) -> Result<(), CliError> {
        let usage = |error: &dyn std::fmt::Display| CliError::Usage(error.to_string());
        let open = |folder: &PathBuf| Stored::open(folder).map_err(|error| usage(&error));
        let runs = runs(&self.sweep)?.iter().map(open).collect::<Result<Vec<_>, _>>()?;
        let emission = Emission::of(&runs).map_err(|error| usage(&error))?;
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

/// The results folders of a sweep, by name.
fn runs(sweep: &Path) -> Result<Vec<PathBuf>, CliError> {
    let wrong = |problem: &str| {
        let right = "give the folder of a sweep: `tyrewave sweep SCENE --speed 50..110:10` makes one";
        Err(CliError::Usage(format!("{} {problem}: {right}", sweep.display())))
    };
    if sweep.is_file() {
        return wrong("is a file");
    }
    if sweep.join(SUMMARY_FILE).exists() {
        return wrong("has the results of a single run");
    }
    let read = |source| CliError::Read { path: sweep.to_owned(), source };
    let mut folders = Vec::new();
    for entry in fs::read_dir(sweep).map_err(read)? {
        let folder = entry.map_err(read)?.path();
        if folder.join(SUMMARY_FILE).is_file() {
            folders.push(folder);
        }
    }
    folders.sort();
    if folders.is_empty() { wrong("has no results of runs in it") } else { Ok(folders) }
}
