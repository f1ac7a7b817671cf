//! `tyrewave run`: from a scene to contact forces and their spectrum.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use clap::Args;

const EXAMPLES: &str = "\
Results: summary.json (what was run, how it went, what it cost), time.npy, total_force.npy, patch_force.npy, patch_element.npy (plain NumPy \
arrays, warm-up included), spectra.csv (third-octave levels) and plots in SVG.

An existing results folder is replaced when the run is complete, not before; a folder that holds anything else is left alone.

Examples:
  tyrewave run scenes/default.toml                    results in results/default
  tyrewave run scenes/default.toml --out trial        results in trial
  tyrewave run scenes/default.toml --profile          and a table of what took how long";

/// Arguments of `tyrewave run`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct RunArguments {
    /// The scene, a TOML file.
    pub scene: PathBuf,
    /// Results folder; default: results/NAME, NAME being the scene's.
    #[arg(long, short, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// Print stage times and work counters at the end.
    #[arg(long)]
    pub profile: bool,
}

impl RunArguments {
    /// Where the results go.
    pub fn results_folder(&self) -> PathBuf {
        self.out
            .clone()
            .unwrap_or_else(|| Path::new("results").join(self.scene.file_stem().unwrap_or(OsStr::new("scene"))))
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        run: RunArguments,
    }

    #[test]
    fn results_are_named_after_the_scene() {
        let folder = |line: &[&str]| Line::try_parse_from(line).map(|line| line.run.results_folder());
        assert_eq!(folder(&["run", "scenes/default.toml"]).unwrap(), Path::new("results/default"));
        assert_eq!(folder(&["run", "a.toml", "--out", "x/y"]).unwrap(), Path::new("x/y"));
        assert!(folder(&["run"]).is_err());
    }
}
