//! `tyrewave sweep --tasks`, `--task` and `--collect`: a sweep through a folder of tasks; the tables of
//! a sweep and their files.

use std::collections::BTreeSet;
use std::ffi::OsString;
use std::fs;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use crate::response::{BandLevel, LevelErrors};
use crate::results::ResultsError;
use crate::results::plots::ThirdOctavePlot;
use crate::results::spectra::FORCE_LEVEL;
use crate::results::table::Report;
use crate::storage::PendingFile;
use crate::study::sweep::friction_curves::{friction_csv, friction_plot};
use crate::study::sweep::record::{RECORD_FILE, Recorded, SweepRecord};
use crate::study::sweep::table::{MOST_SPECTRA, csv, growth_plot, side_by_side, sound_csv};
use crate::study::sweep::tasks::jobs::{self, HEAD, LOGS, MISSING};
use crate::study::sweep::tasks::{Collection, Ended, Event, Jobs, Numbers, TaskFolder, TaskWork, Written};
use crate::study::sweep::{Done, Label, RepeatedTable, RoadUncertainty, Variant, blocks};
use clap::Args;
use serde_json::json;

use super::context::{Context, print};
use super::error::{CliError, write_message};
use super::output_file::{OutputFile, Replaces, check};

/// Job files beside the tasks.
const SLURM: &str = "job.slurm";
const HYPERQUEUE: &str = "job.hq";
/// Most missing or failed tasks that are named one by one.
const NAMED: usize = 5;
/// Most variants in the pictures, which are illegible with more.
const MOST_DRAWN: usize = 1000;

#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Tasks")]
pub(super) struct TaskArguments {
    /// Write the scenes into a folder as tasks, with job files for Slurm and HyperQueue, and run nothing. --threads is
    /// then the number of processors of an element of the job array, which runs as many tasks at a time; default: 1.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["task", "collect"])]
    tasks: Option<PathBuf>,
    /// Run one of the tasks in a folder, or those from N to M (N..M, both included), on --threads threads.
    #[arg(long, num_args = 2, value_names = ["DIR", "N"], conflicts_with = "collect")]
    task: Vec<OsString>,
    /// Make the tables of the tasks in a folder and list missing ones; tables go to the folder, or to --out.
    #[arg(long, value_name = "DIR")]
    collect: Option<PathBuf>,
    /// Number of tasks in an element of the job array; default: enough for a minute, and for at most 1000 elements.
    #[arg(long, value_name = "N", requires = "tasks", value_parser = clap::value_parser!(u64).range(1..))]
    chunk: Option<u64>,
    /// Largest number of elements of Slurm's job array that run at a time; default: 1000.
    #[arg(long, value_name = "N", requires = "tasks", value_parser = clap::value_parser!(u64).range(1..))]
    at_once: Option<u64>,
    /// Keep the results folder of every task, as DIR/shard-.../results/NAME; with --tasks: write the option into the
    /// job files.
    #[arg(long)]
    keep_results: bool,
}

impl TaskArguments {
    pub(super) fn are_written(&self) -> bool {
        self.tasks.is_some()
    }

    /// True if tasks in a folder are to be done or collected.
    pub(super) fn are_there(&self) -> bool {
        self.collect.is_some() || !self.task.is_empty()
    }

    /// Does or collects tasks.
    pub(super) fn execute(&self, out: Option<&Path>, context: &Context) -> Result<(), CliError> {
        match (&self.collect, self.task.as_slice()) {
            (Some(folder), _) => collect(folder, out, context),
            (None, [folder, numbers]) => self.work(Path::new(folder), &numbers.to_string_lossy(), context),
            _ => Err(CliError::Usage("--task needs a folder and a number".to_owned())),
        }
    }

    /// Writes tasks and job files.
    pub(super) fn write(
        &self,
        (title, plots): (&str, bool),
        variants: &[Variant],
        out: Option<&Path>,
        context: &Context,
    ) -> Result<(), CliError> {
        let (Some(folder), None) = (&self.tasks, out) else {
            return Err(CliError::Usage("--tasks names the folder: there is nothing for --out".to_owned()));
        };
        let threads = context.options.threads.map_or(1, usize::from);
        let chunk = |count, seconds| self.chunk.unwrap_or_else(|| jobs::chunk(count, seconds, threads));
        let write_jobs = |written: &Written| self.write_jobs(written, threads);
        let written = TaskFolder::write(folder, (title, plots), variants, chunk, write_jobs)?;
        let (count, place) = (written.folder.manifest.count, folder.display());
        if context.options.json {
            let json = json!({
                "tasks": count, "found": written.found, "chunk": written.folder.manifest.chunk,
                "longest_seconds": written.seconds[0], "seconds": written.seconds[1], "memory": written.memory,
            });
            return print(&format!("{json:#}\n"));
        }
        let there = if written.found { ", written before" } else { "" };
        context.say(&format!(
            "{count} tasks in {place}{there}\n\
             planned on one thread: at most {:.1} s and {:.0} MB each, {:.2} h in all\n\
             submit with `sbatch {place}/{SLURM}` or `bash {place}/{HYPERQUEUE}`, or do them here with\n\
             `tyrewave sweep --task {place} 0..{}`; then `tyrewave sweep --collect {place}`\n",
            written.seconds[0],
            written.memory / 1e6,
            written.seconds[1] / 3600.0,
            count.saturating_sub(1),
        ))
    }

    fn write_jobs(&self, written: &Written, threads: usize) -> Result<(), CliError> {
        let path = &written.folder.path;
        let unknown = |what: &'static str| move |error| CliError::Failed(format!("{what}: {error}"));
        let folder = std::path::absolute(path).map_err(unknown("the folder of tasks"))?;
        let program = std::env::current_exe().map_err(unknown("the program's own file"))?;
        let mut jobs = Jobs { keep_results: self.keep_results, ..Jobs::of(written, &program, &folder, threads) };
        jobs.at_once = self.at_once.unwrap_or(jobs.at_once);
        // Slurm does not create the folder for messages.
        let logs = path.join(LOGS);
        fs::create_dir_all(&logs).map_err(ResultsError::creating(&logs))?;
        for (name, text) in [(SLURM, jobs.slurm()), (HYPERQUEUE, jobs.hyperqueue())] {
            OutputFile::begin(&path.join(name), Replaces::Beginning(HEAD))?.complete(&text)?;
        }
        Ok(())
    }

    fn work(&self, folder: &Path, numbers: &str, context: &Context) -> Result<(), CliError> {
        let numbers = range(numbers).map_err(CliError::Usage)?;
        let folder = TaskFolder::open(folder)?;
        folder.shards_of(&numbers)?;
        let bar = context.bar("tasks", numbers.end() - numbers.start() + 1);
        let reported_notes = Mutex::new(BTreeSet::new());
        let first_time = |note: &str| reported_notes.lock().is_ok_and(|mut notes| notes.insert(note.to_owned()));
        let reported = |number: u64, name: &str, event: Event<'_>| {
            let text = match event {
                Event::GoesOn([rolled, all]) => format!("continues at {rolled:.3} s of {all:.3} s"),
                // Only the first task with a note reports it: most notes apply to all tasks.
                Event::Note(text) if !first_time(text) => return,
                Event::Note(text) => format!("note: {text}"),
                Event::Warning(text) => format!("warning: {text}"),
                Event::Ended(ended) => {
                    bar.inc(1);
                    ending(ended)
                }
            };
            let message = format!("task {number} ({name}): {text}");
            match event {
                Event::Ended(Ended::Failed(_) | Ended::Busy) => bar.suspend(|| write_message(&message)),
                // For people only: if it cannot be printed, the task is done all the same.
                _ => bar.suspend(|| context.say(&format!("{message}\n")).unwrap_or_default()),
            }
        };
        let work = TaskWork { threads: context.threads, keep_results: self.keep_results };
        let ended = folder.work(&numbers, work, context.interrupt.flag(), &reported)?;
        bar.finish_and_clear();
        let count = |of: fn(&Ended) -> bool| ended.iter().filter(|ended| of(ended)).count();
        let [stopped, busy, failed] = [
            count(|ended| *ended == Ended::Stopped),
            count(|ended| *ended == Ended::Busy),
            count(|ended| matches!(ended, Ended::Failed(_))),
        ];
        if stopped > 0 {
            return Err(CliError::SweepStopped);
        }
        if busy + failed > 0 {
            let all = ended.len();
            return Err(CliError::Failed(format!(
                "{failed} of {all} tasks failed, {busy} are being run by another process"
            )));
        }
        Ok(())
    }
}

/// End of a task, in words.
fn ending(ended: &Ended) -> String {
    match ended {
        Ended::Found => "was done before".to_owned(),
        Ended::Done(None) => "done".to_owned(),
        Ended::Done(Some(missed)) => format!("done; {missed}"),
        Ended::Stopped => "stopped; it can be continued".to_owned(),
        Ended::Busy => "another process is running it".to_owned(),
        Ended::Failed(reason) => format!("failed: {reason}"),
    }
}

/// Parses `N` or `N..M`.
fn range(text: &str) -> Result<RangeInclusive<u64>, String> {
    let number = |text: &str| {
        let number = text.trim().parse::<u64>();
        number.map_err(|_| format!("\"{text}\" is not a task's number: give N, or N..M, both included"))
    };
    let (first, last) = match text.split_once("..") {
        None => (number(text)?, number(text)?),
        Some((first, last)) => (number(first)?, number(last)?),
    };
    if first > last { Err(format!("the tasks end at {last}, before they begin at {first}")) } else { Ok(first..=last) }
}

/// Writes the tables of what is done, and names what is missing.
fn collect(path: &Path, out: Option<&Path>, context: &Context) -> Result<(), CliError> {
    let folder = TaskFolder::open(path)?;
    let place = out.unwrap_or(path);
    check_tables(place, &[])?;
    fs::create_dir_all(place).map_err(ResultsError::creating(place))?;
    let bar = context.bar("collecting", folder.shards());
    let collection = folder.collect(|| bar.inc(1))?;
    bar.finish_and_clear();
    let drawn = folder.manifest.plots && collection.tasks.len() <= MOST_DRAWN;
    let report = write_tables(place, (&folder.manifest.title, drawn), &collection.tasks, None)?;

    let missing = collection.missing();
    let elements = Numbers::new(missing.0.iter().map(|number| number / folder.manifest.chunk));
    write_missing(path, &elements)?;
    let (count, gone) = (folder.manifest.count, missing.0.len());
    if context.options.json {
        let failed: Vec<_> = collection
            .failed
            .iter()
            .map(|(task, name, reason)| json!({ "task": task, "name": name, "reason": reason }))
            .collect();
        let json = json!({
            "tasks": count, "done": count - gone as u64, "missing": missing.to_string(),
            "elements": elements.to_string(), "failed": failed, "missed_load": collection.missed_loads(),
            "tables": report.to_json(),
        });
        print(&format!("{json:#}\n"))?;
    } else {
        context.print_report(&report)?;
        let done = count - gone as u64;
        context.say(&format!("\n{done} of {count} tasks are done\ntables in {}\n", place.display()))?;
    }
    for (path, reason) in &collection.unusable {
        write_message(&format!("note: {} cannot be used: {reason}; its tasks must be run again", path.display()));
    }
    ended(&collection, &missing, path)
}

/// Writes the list of the job array's elements with missing tasks; deletes it if there are none.
fn write_missing(folder: &Path, elements: &Numbers) -> Result<(), CliError> {
    let path = folder.join(MISSING);
    if elements.0.is_empty() {
        // The file may not exist.
        let _ = fs::remove_file(&path);
        return Ok(());
    }
    OutputFile::begin(&path, Replaces::AllBut(&[]))?.complete(&format!("{elements}\n"))
}

/// An error unless all tasks are done, each under its load.
fn ended(collection: &Collection, missing: &Numbers, folder: &Path) -> Result<(), CliError> {
    let (all, numbers) = (collection.tasks.len(), missing.0.as_slice());
    let mut wrong = Vec::new();
    if !numbers.is_empty() {
        let name = |&number: &u64| {
            let task = usize::try_from(number).ok().and_then(|index| collection.tasks.get(index));
            task.map(|(label, _)| format!("{number} ({})", label.name))
        };
        let first: Vec<String> = numbers.iter().take(NAMED).filter_map(name).collect();
        let more = if numbers.len() > NAMED { ", ..." } else { "" };
        wrong.push(format!("{} of {all} tasks are missing: {}{more}", numbers.len(), first.join(", ")));
    }
    let failed = collection.failed.iter().take(NAMED);
    wrong.extend(failed.map(|(number, name, reason)| format!("task {number} ({name}) failed: {reason}")));
    if !numbers.is_empty() {
        let file = folder.join(MISSING);
        wrong.push(format!("elements of the job array that run them are in {}", file.display()));
    }
    wrong.extend(missed_message(&collection.missed_loads(), all));
    if wrong.is_empty() { Ok(()) } else { Err(CliError::Failed(wrong.join("; "))) }
}

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
const SPREAD: &str = "road_uncertainty.csv";

/// Refuses a folder in which a sweep's tables would replace its inputs.
pub(super) fn check_tables(folder: &Path, inputs: &[&Path]) -> Result<(), CliError> {
    let names =
        [TEXT, TABLE, SOUND, FRICTION, FRICTION_CURVES, GROWTH, LEVELS, DESIGN, DESIGN_JSON, SPREAD, RECORD_FILE];
    names.iter().try_for_each(|name| check(&folder.join(name), Replaces::AllBut(inputs)))
}

/// Writes the tables of a sweep, and its pictures if they are wanted; returns the report.
pub(super) fn write_tables(
    folder: &Path,
    (title, plots): (&str, bool),
    runs: &[(Label, Option<Done>)],
    uncertainty: Option<&RoadUncertainty>,
) -> Result<Report, CliError> {
    let blocks = blocks(runs);
    let repeated = RepeatedTable::new(runs);
    let spread = uncertainty.zip(repeated.as_ref()).map(|(uncertainty, table)| uncertainty.spread(table));
    let mut report = repeated.as_ref().map_or_else(|| side_by_side(&blocks), RepeatedTable::report);
    let write = |name: &str, text: &str| write(folder, name, text);
    if let Some(spread) = spread {
        write(SPREAD, &spread.csv())?;
        report.text("\n");
        report.append(spread.report());
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tasks_are_named_by_a_number_or_a_range() {
        assert_eq!(range("17"), Ok(17..=17));
        assert_eq!(range("0..24"), Ok(0..=24));
        for (text, word) in
            [("3..1", "before they begin"), ("-1", "not a task's number"), ("1..", "N..M"), ("all", "\"all\"")]
        {
            assert!(range(text).unwrap_err().contains(word), "{text}");
        }
    }
}
