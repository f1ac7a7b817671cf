//! `tyrewave report` and `tyrewave compare`: finished results, to look at and to compare.

use std::path::{Path, PathBuf};

use crate::report::{Comparison, MeasuredLevels, PAGE_HEAD, ReportError, Stored, page};
use crate::results::summary::SUMMARY_FILE;
use crate::storage::input::{self, TABLE_BYTES};
use crate::study::sweep::StoredSweep;
use clap::Args;

use super::context::{Context, print};
use super::error::CliError;
use super::output_file::{OutputFile, Replaces, check};

const REPORT_EXAMPLES: &str = "\
One HTML file that needs only a browser: a description of the scene, the plan with its reasons, the road and its \
texture, forces, spectra with their errors, vibration, sound to play, computing cost, and the whole scene. Pictures \
show the value under the pointer. Several results are compared with the first one. The page of a sweep has levels \
against the varied quantities, third octaves and sounds of its runs side by side, growth and tables.

Examples:
  tyrewave report results/default                     results/default.html
  tyrewave report results/80 results/110 --out speeds.html
  tyrewave report results/default-sweep               results/default-sweep.html
  tyrewave run scenes/default.toml --report           runs, then reports";

/// Arguments of `tyrewave report`.
#[derive(Clone, Debug, Args)]
#[command(after_help = REPORT_EXAMPLES)]
pub(crate) struct ReportArguments {
    /// Results folders of `tyrewave run`, or one of `tyrewave sweep`.
    #[arg(required = true, value_name = "RESULTS")]
    results: Vec<PathBuf>,
    /// The page; default: the first folder's name with .html, beside it.
    #[arg(long, short, value_name = "FILE")]
    out: Option<PathBuf>,
}

impl ReportArguments {
    /// Writes the page and prints its name.
    pub(crate) fn execute(self, context: &Context) -> Result<(), CliError> {
        let out = self.out.unwrap_or_else(|| beside(&self.results[0], ".html"));
        write_page(&self.results, None, &out, context)
    }
}

const COMPARE_EXAMPLES: &str = "\
Settings that differ; figures with their differences from the first results; third octaves of forces, velocities and \
sound. Levels that are not valid in every run are in brackets. A file may be given in place of a folder: measured \
third octaves of the sound pressure level, as a table with a column of frequencies (frequency_hz) and one of levels \
(level_db, or level_db_a if A-weighted; with several receivers one column each, named after the receiver).

Examples:
  tyrewave compare results/before results/after
  tyrewave compare results/80 results/110 results/130 --csv > speeds.csv
  tyrewave compare measured.csv results/80";

/// Arguments of `tyrewave compare`.
#[derive(Clone, Debug, Args)]
#[command(after_help = COMPARE_EXAMPLES)]
pub(crate) struct CompareArguments {
    /// Results folders of `tyrewave run`, or files of measured levels, two or more; the others are compared with the
    /// first.
    #[arg(required = true, num_args = 2.., value_name = "RESULTS")]
    results: Vec<PathBuf>,
    /// Print CSV instead of tables: a row for each figure and third octave.
    #[arg(long)]
    csv: bool,
}

impl CompareArguments {
    pub(crate) fn execute(self, context: &Context) -> Result<(), CliError> {
        if self.csv && context.options.json {
            return Err(CliError::Usage("--csv and --json exclude each other".to_owned()));
        }
        let (files, folders): (Vec<_>, Vec<_>) =
            self.results.iter().cloned().enumerate().partition(|(_, path)| path.is_file());
        if folders.is_empty() {
            return Err(CliError::Usage(
                "measured levels are compared with a results folder: name one, too".to_owned(),
            ));
        }
        let folders: Vec<PathBuf> = folders.into_iter().map(|(_, folder)| folder).collect();
        let mut comparison = Comparison::of(&stored(&folders)?);
        for (number, path) in files {
            let bytes = input::read(&path, TABLE_BYTES).map_err(CliError::reading(&path))?;
            let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
            MeasuredLevels::read(&bytes, name)
                .and_then(|measured| measured.put_into(&mut comparison, number))
                .map_err(|wrong| CliError::Usage(format!("{}: {wrong}", path.display())))?;
        }
        if context.options.json {
            print(&format!("{:#}\n", serde_json::json!(comparison)))
        } else if self.csv {
            print(&comparison.csv())
        } else {
            context.print_report(&comparison.report())
        }
    }
}

fn stored(folders: &[PathBuf]) -> Result<Vec<Stored>, CliError> {
    let open = |folder: &PathBuf| Stored::open(folder).map_err(|error| not_opened(folder, &error.to_string()));
    folders.iter().map(open).collect()
}

/// Error of a folder that was not opened; for one without results the message states what is wanted.
fn not_opened(folder: &Path, error: &str) -> CliError {
    let wanted =
        if folder.join(SUMMARY_FILE).is_file() { "" } else { ": name the folder of a finished `tyrewave run`" };
    CliError::Usage(format!("{error}{wanted}"))
}

/// The sweep in a folder, if it is the only one; `None` if all folders are those of runs.
fn sweep_of(folders: &[PathBuf]) -> Result<Option<StoredSweep>, CliError> {
    let mut sweep = None;
    for folder in folders {
        let found = StoredSweep::open(folder).map_err(|error| not_opened(folder, &error.to_string()))?;
        if found.is_some() && folders.len() > 1 {
            let reported = "is the folder of a sweep, which has a page of its own: name it alone, or its runs";
            return Err(CliError::Usage(format!("{} {reported}", folder.display())));
        }
        sweep = found.or(sweep);
    }
    Ok(sweep)
}

/// Default path for what is made from a results folder: beside it, its name with an ending.
pub(super) fn beside(folder: &Path, ending: &str) -> PathBuf {
    let mut name = folder.file_name().unwrap_or(folder.as_os_str()).to_owned();
    name.push(ending);
    folder.with_file_name(name)
}

/// Refuses a path where something other than an earlier page stands.
pub(super) fn check_page(out: &Path) -> Result<(), CliError> {
    check(out, Replaces::Beginning(PAGE_HEAD))
}

/// Writes the page of some results atomically, in place of an earlier one, and prints its name. `road` is the file of
/// their measured road, if known.
pub(super) fn write_page(
    folders: &[PathBuf],
    road: Option<&Path>,
    out: &Path,
    context: &Context,
) -> Result<(), CliError> {
    let file = OutputFile::begin(out, Replaces::Beginning(PAGE_HEAD))?;
    let text = match sweep_of(folders)? {
        Some(sweep) => sweep.page(),
        None => page(&stored(folders)?.into_iter().map(|stored| stored.with_road(road)).collect::<Vec<_>>()),
    };
    let text = text.map_err(|error| match error {
        // The folder is not what it claims to be: a usage error, as in export.
        ReportError::Stored(error) => CliError::Usage(error.to_string()),
        other => CliError::Failed(other.to_string()),
    })?;
    file.complete(&text)?;
    context.say(&format!("report in {}\n", out.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_without_results_is_refused_with_what_is_wanted() {
        let folder = tempfile::tempdir().unwrap();
        let error = stored(&[folder.path().to_owned()]).unwrap_err().to_string();
        assert!(error.contains("name the folder of a finished `tyrewave run`"), "{error}");
    }

    #[test]
    fn a_page_stands_beside_its_folder() {
        assert_eq!(beside(Path::new("results/80.5"), ".html"), Path::new("results/80.5.html"));
        assert_eq!(beside(Path::new("run"), ".html"), Path::new("run.html"));
    }
}
