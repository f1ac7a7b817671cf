//! `tyrewave export`: finished results in the formats of other programs.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use crate::report::Stored;
use crate::report::export::{ExportError, MAT_HEAD, PYTHON, Patch, UFF_HEAD, VTK_HEAD, mat, uff};
use crate::results::ResultsError;
use crate::storage::flat_folder;
use clap::{Args, ValueEnum};

use super::context::Context;
use super::error::{CliError, write_message};
use super::options::positive;
use super::output_file::{OutputFile, Replaces, check};
use super::report::beside;

/// File that lists the instants in a folder.
const COLLECTION: &str = "patch.pvd";

fn examples() -> String {
    format!(
        "\
mat    a MATLAB file, level 5: every array, every table as a struct of its columns, sounds as pressures over time, \
units in the struct `units`
uff58  a universal file: total force over time, third octaves (mean squares of the valid bands) and narrow bands \
(densities) of force, velocities and sound, sound pressure over time, in SI units
vtk    a folder with the patch over time, patch.pvd for ParaView: force and pressure of every element, or of every \
cell if the scene has outputs.cells_every; at most 400 instants

Only an earlier export is replaced.

Examples:
  tyrewave export results/default --format mat                      results/default.mat
  tyrewave export results/default --format uff58 --out force.uff
  tyrewave export results/cells --format vtk                        results/cells_vtk/patch.pvd
  tyrewave export results/default --format vtk --every 0.0005 --out patch

Python needs no export; this prints mean force and level of a results folder:
{}",
        PYTHON.lines().map(|line| format!("  {line}\n")).collect::<String>()
    )
}

/// Arguments of `tyrewave export`.
#[derive(Clone, Debug, Args)]
#[command(after_help = examples())]
pub(crate) struct ExportArguments {
    /// A results folder of `tyrewave run`.
    results: PathBuf,
    /// Format to write.
    #[arg(long, short)]
    format: Format,
    /// The file, or for vtk the folder; default: the results folder's name with .mat, .uff or _vtk, beside it.
    #[arg(long, short, value_name = "FILE_OR_FOLDER")]
    out: Option<PathBuf>,
    /// vtk only: time between two instants after the warm-up, in s; default: instants spread evenly over the run.
    #[arg(long, value_name = "SECONDS", value_parser = positive, allow_negative_numbers = true)]
    every: Option<f64>,
}

/// Formats that can be written.
#[derive(Clone, Copy, Debug, Eq, PartialEq, ValueEnum)]
enum Format {
    /// Universal file, datasets 58.
    Uff58,
    /// MATLAB file.
    Mat,
    /// Polygons over time.
    Vtk,
}

impl ExportArguments {
    /// Writes the file or folder and prints its name.
    pub(crate) fn execute(self, context: &Context) -> Result<(), CliError> {
        if self.every.is_some() && self.format != Format::Vtk {
            return Err(CliError::Usage("--every is for --format vtk".to_owned()));
        }
        let ending = match self.format {
            Format::Uff58 => ".uff",
            Format::Mat => ".mat",
            Format::Vtk => "_vtk",
        };
        let out = self.out.unwrap_or_else(|| beside(&self.results, ending));
        let stored = Stored::open(&self.results).map_err(|error| CliError::Usage(error.to_string()))?;
        match self.format {
            Format::Uff58 => {
                let file = OutputFile::begin(&out, Replaces::Beginning(UFF_HEAD))?;
                file.complete(&uff(&stored).map_err(refused)?)?;
            }
            Format::Mat => {
                let file = OutputFile::begin(&out, Replaces::Beginning(MAT_HEAD))?;
                file.complete(&mat(&stored).map_err(refused)?)?;
            }
            Format::Vtk => {
                let patch = Patch::open(&stored, self.every).map_err(refused)?;
                if let Some(note) = patch.note().filter(|_| !context.options.quiet) {
                    write_message(&format!("note: {note}"));
                }
                write_patch(&patch, &out, context)?;
            }
        }
        context.say(&format!("exported to {}\n", out.display()))
    }
}

fn refused(error: ExportError) -> CliError {
    CliError::Usage(error.to_string())
}

/// Writes the files of a patch, the collection last, and deletes frames of an earlier, longer export.
fn write_patch(patch: &Patch, folder: &Path, context: &Context) -> Result<(), CliError> {
    let ours = Replaces::Beginning(VTK_HEAD);
    let made = match fs::create_dir(folder) {
        Ok(()) => true,
        Err(error) if error.kind() == ErrorKind::AlreadyExists => false,
        Err(error) => return Err(ResultsError::creating(folder)(error).into()),
    };
    let earlier = earlier(folder)?;
    let names: Vec<String> = (0..patch.len()).map(Patch::file).collect();
    let written = || {
        for (frame, name) in names.iter().enumerate() {
            if context.interrupt.flag().load(Ordering::Relaxed) {
                return Err(CliError::Interrupted { partial: None });
            }
            OutputFile::begin(&folder.join(name), ours)?.complete(&patch.frame(frame))?;
        }
        OutputFile::begin(&folder.join(COLLECTION), ours)?.complete(&patch.collection())
    };
    let written = written();
    if written.is_err() && made {
        let _ = flat_folder::remove(folder);
    }
    written?;
    for name in earlier.iter().filter(|name| *name != COLLECTION && !names.contains(name)) {
        let path = folder.join(name);
        check(&path, ours)?;
        fs::remove_file(&path).map_err(ResultsError::writing(&path))?;
    }
    Ok(())
}

/// Names of the files in a folder, which must be an earlier export and nothing else.
fn earlier(folder: &Path) -> Result<Vec<String>, CliError> {
    let reading = |source| CliError::Read { path: folder.to_owned(), source };
    let names = flat_folder::entries(folder).map_err(reading)?;
    for name in &names {
        let is_frame = name.starts_with("patch_") && name.ends_with(".vtp");
        if !is_frame && name != COLLECTION {
            let folder = folder.display();
            return Err(CliError::Usage(format!(
                "{folder} holds {name}, which is not part of an export; it is left alone"
            )));
        }
        check(&folder.join(name), Replaces::Beginning(VTK_HEAD))?;
    }
    Ok(names)
}
