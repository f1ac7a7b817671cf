//! The tables of a sweep and their files.

use std::path::Path;

use crate::response::{BandLevel, LevelErrors};
use crate::results::ResultsError;
use crate::results::plots::ThirdOctavePlot;
use crate::results::spectra::FORCE_LEVEL;
use crate::results::table::Report;
use crate::storage::PendingFile;
use crate::study::sweep::friction_curves::{friction_csv, friction_plot};
use crate::study::sweep::record::{RECORD_FILE, Recorded, SweepRecord};
use crate::study::sweep::table::{MOST_SPECTRA, csv, growth_plot, side_by_side, sound_csv};
use crate::study::sweep::{Done, Label, RepeatedTable, blocks};

use super::error::CliError;
use super::output_file::{Replaces, check};

/// Files beside the variants' folders.
const TEXT: &str = "sweep.txt";
const TABLE: &str = "sweep.csv";
const SOUND: &str = "sweep_sound.csv";
const FRICTION: &str = "sweep_friction.csv";
const FRICTION_CURVES: &str = "friction_by_creep.svg";
const GROWTH: &str = "growth.svg";
const LEVELS: &str = "levels.svg";
const DESIGN: &str = "design.csv";
const DESIGN_JSON: &str = "design.json";

/// Refuses a folder in which a sweep's tables would replace its inputs.
pub(super) fn check_tables(folder: &Path, inputs: &[&Path]) -> Result<(), CliError> {
    let names = [TEXT, TABLE, SOUND, FRICTION, FRICTION_CURVES, GROWTH, LEVELS, DESIGN, DESIGN_JSON, RECORD_FILE];
    names.iter().try_for_each(|name| check(&folder.join(name), Replaces::AllBut(inputs)))
}

/// Writes the tables of a sweep, and its pictures if they are wanted; returns the report.
pub(super) fn write_tables(
    folder: &Path,
    (title, plots): (&str, bool),
    runs: &[(Label, Option<Done>)],
) -> Result<Report, CliError> {
    let blocks = blocks(runs);
    let repeated = RepeatedTable::new(runs);
    let report = repeated.as_ref().map_or_else(|| side_by_side(&blocks), RepeatedTable::report);
    let write = |name: &str, text: &str| write(folder, name, text);
    write(TEXT, &report.to_string())?;
    write(TABLE, &csv(&blocks))?;
    if let Some(sound) = sound_csv(&blocks) {
        write(SOUND, &sound)?;
    }
    if let Some(friction) = friction_csv(runs) {
        write(FRICTION, &friction)?;
    }
    if let Some(repeated) = &repeated {
        write(DESIGN, &repeated.csv())?;
        write(DESIGN_JSON, &format!("{:#}\n", repeated.to_json()))?;
        let drawn = if plots { repeated.plots(title) } else { Vec::new() };
        drawn.iter().try_for_each(|(name, svg)| write(name, svg))?;
    }
    if plots {
        if let Some(svg) = friction_plot(runs, &format!("Tangential forces: {title}")) {
            write(FRICTION_CURVES, &svg)?;
        }
        if let Some(svg) = growth_plot(&blocks, &format!("Growth with the speed: {title}")) {
            write(GROWTH, &svg)?;
        }
        let spectra = spectra(runs);
        if !spectra.is_empty() && (repeated.is_none() || spectra.len() <= MOST_SPECTRA) {
            let title = &format!("Contact force, third octaves: {title}");
            write(
                LEVELS,
                &ThirdOctavePlot { title, quantity: FORCE_LEVEL, spectra, errors: LevelErrors::default() }.to_svg()?,
            )?;
        }
    }
    Ok(report)
}

/// Writes the list of variants, with which of them have left their results in folders here.
pub(super) fn write_record(folder: &Path, title: String, runs: &[(Label, Option<Done>)]) -> Result<(), CliError> {
    let recorded = |(label, done): &(Label, Option<Done>)| Recorded { label: label.clone(), done: done.is_some() };
    let record = SweepRecord::new(title, runs.iter().map(recorded).collect());
    Ok(write(folder, RECORD_FILE, &record.to_json())?)
}

fn write(folder: &Path, name: &str, text: &str) -> Result<(), ResultsError> {
    let path = folder.join(name);
    let file = PendingFile::create(&path).map_err(ResultsError::creating(&path))?;
    file.complete(text).map_err(ResultsError::writing(&path))
}

/// Names and levels of the variants that have levels.
fn spectra(runs: &[(Label, Option<Done>)]) -> Vec<(&str, &[BandLevel])> {
    let done = runs.iter().filter_map(|(label, done)| Some((label, done.as_ref()?)));
    let levels = done.map(|(label, done)| (label.name.as_str(), done.levels.as_slice()));
    levels.filter(|(_, levels)| !levels.is_empty()).collect()
}

/// Message on the variants that missed their load; `None` if none did.
pub(super) fn missed_message(missed: &[String], all: usize) -> Option<String> {
    let what = "variants missed their load by more than its tolerance";
    let reported = || format!("{} of {all} {what}: {}; their results are kept", missed.len(), missed.join(", "));
    (!missed.is_empty()).then(reported)
}
