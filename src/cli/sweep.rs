//! `tyrewave sweep`: one scene at many speeds, loads, roads and settings.

use std::path::{Path, PathBuf};

use crate::results::ResultsError;
use crate::results::summary::SUMMARY_FILE;
use crate::run::RunError;
use crate::scene::LoadedScene;
use crate::study::sweep::{
    Axes, Design, Done, Factor, LOAD_KEY, Label, Range, RoadUncertainty, SPEED_KEY, Variant, VariantOutcome,
    share_full_scale, sweep, variants,
};
use clap::builder::ArgPredicate;
use clap::{Arg, Args};

use super::context::{Context, print};
use super::error::{CliError, write_message};
use super::options::positive;
use super::report::{beside, check_page, write_page};
use super::side::Place;
use super::sweep_tasks::{TaskArguments, check_tables, missed_message, write_record, write_tables};

const EXAMPLES: &str = "\
Every combination of the varied values is a run with a results folder of its own in that of the sweep. Several run at \
a time, on no more threads than --threads allows; the tyre's influence functions are fitted once, or once for each \
speed if the tyre turns. The sweep also writes sweep.csv and sweep.txt: third-octave levels of the contact force by \
speed, for each band their growth (dB per decade of speed, least squares over the logarithm of the speed) with the rms \
residual, and the rolling resistance; growth.svg and levels.svg; if the scene has receivers, sweep_sound.csv: levels \
in dB(A) there and their growth; with friction sweep_friction.csv, and friction_by_creep.svg if creep is varied; \
sweep.json: the variants, for `tyrewave report`. A variant that missed its load by more than the axle's tolerance is \
marked with a star, and the exit code is 1.

The same command continues a sweep: finished variants are not run again, interrupted ones continue from their \
checkpoint. A variant is run anew if its scene, the version of tyrewave or a file that it reads has changed.

Any key may be varied: --set KEY=FROM..TO:STEP, --set KEY=FROM..TO of whole numbers, --set KEY=A,B,C (a text that \
contains a comma is put in quotes). Values of a seed, such as road.seed, are samples of the same random quantity: the \
table has means over them, with half of the 95 % confidence interval by Student's distribution. design.csv and \
design.json have every mean, third octaves included; force_by_KEY.svg and sound_by_KEY.svg show levels against the \
varied keys. --latin-hypercube 40 takes the 40 points of a Latin hypercube over all --set FROM..TO instead of every \
combination; all values of seeds, --speed, --load and --road are run at each point.

--road-uncertainty rolls a constructed road.texture as it may be: its levels as stated and off by their uncertainty, \
each with its own skewness, 0 and -1.85. For every third octave of force and sound, road_uncertainty.csv has the value \
on the road as stated and the lowest and highest one, means over the values of road.seed.

With --tasks the scenes are written into a folder as tasks, for a batch system or other machines, and nothing is run; \
--task runs tasks, and --collect makes the tables from those that are done. A task that is done is not run again; one \
that was killed continues from its checkpoint (outputs.checkpoint_interval). A task keeps only what the tables need, \
or with --keep-results also its results folder. Beside the tasks are job.slurm and job.hq, job arrays for Slurm and \
HyperQueue with memory and time from the plan. As long as tasks are missing, --collect ends with exit code 1, and \
writes the elements of the array that contain them into the file `missing`.

--road names a file: a profile (.dat, .csv) or OpenCRG (.crg) replaces the file of the scene's road, whose other keys \
are kept if it is of the same kind; a .toml file has the keys of a whole [road].

Examples:
  tyrewave sweep scenes/default.toml --speed 50..130:10
  tyrewave sweep scenes/default.toml --speed 50..130:10 --report
                                                      and a page, results/default-sweep.html
  tyrewave sweep scenes/default.toml --speed 50,80,100 --load 3000,4000 --out trial
  tyrewave sweep scenes/default.toml --speed 50..100:25 --road smooth.toml --road stone.crg
  tyrewave sweep scenes/default.toml --set contact.tread=elastic,bedding --set road.seed=1..20
  tyrewave sweep scenes/default.toml --road-uncertainty --set road.seed=1..3
  tyrewave sweep scenes/default.toml --latin-hypercube 40 --set rolling.speed_kmh=50.0..130 \\
      --set tyre.layers[1].thickness=0.008..0.014
  tyrewave sweep scenes/default.toml --speed 50..130:1 --load 2000..5000:100 --tasks shared/trial
  sbatch shared/trial/job.slurm
  bash shared/trial/job.hq
  tyrewave sweep --task shared/trial 0..99 --threads 4
  tyrewave sweep --collect shared/trial
  sbatch --array=$(cat shared/trial/missing) shared/trial/job.slurm";

/// Options for a folder of tasks, which holds the scene and the values of its factors.
const ELSEWHERE: [&str; 2] = ["task", "collect"];
/// Options that vary something.
const VARIED: [&str; 5] = ["settings", "speed", "load", "road", "latin_hypercube"];

#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
#[command(mut_arg("scene", elsewhere))]
#[command(mut_args(|argument| if VARIED.contains(&argument.get_id().as_str()) {
    argument.conflicts_with_all(ELSEWHERE)
} else {
    argument
}))]
pub(crate) struct SweepArguments {
    #[command(flatten)]
    place: Place,
    /// Speeds in km/h: FROM..TO:STEP, both ends included, or values separated by commas.
    #[arg(long, value_name = "SPEEDS", value_parser = values)]
    speed: Option<Values>,
    /// Loads in N, in the same form; default: the scene's axle.
    #[arg(long, value_name = "LOADS", value_parser = values)]
    load: Option<Values>,
    /// Road file; may be given several times; default: the scene's road.
    #[arg(long, value_name = "FILE")]
    road: Vec<PathBuf>,
    /// Roll the road as it may be: levels off by their uncertainty, with each skewness that was read.
    #[arg(long, conflicts_with_all = ["latin_hypercube", "tasks", "task", "collect"])]
    road_uncertainty: bool,
    /// Number of points of a Latin hypercube over the ranges of --set, instead of every combination.
    #[arg(long, value_name = "POINTS")]
    latin_hypercube: Option<usize>,
    /// Seed of the Latin hypercube's random numbers.
    #[arg(long, value_name = "SEED", default_value_t = 1, requires = "latin_hypercube")]
    design_seed: u64,
    /// Make a page of the sweep, beside its folder: see tyrewave help report.
    #[arg(long, conflicts_with_all = ["tasks", "task", "collect"])]
    report: bool,
    #[command(flatten)]
    tasks: TaskArguments,
}

/// The scene's argument: not needed if tasks in a folder are done or collected; it gets a placeholder then.
fn elsewhere(scene: Arg) -> Arg {
    let unused = ELSEWHERE.map(|mode| (mode, ArgPredicate::IsPresent, "-"));
    let scene = scene.required(false).required_unless_present_any(ELSEWHERE);
    scene.default_value_ifs(unused).conflicts_with_all(ELSEWHERE)
}

/// Positive numbers from the command line, distinct.
#[derive(Clone, Debug)]
struct Values(Vec<f64>);

/// Parses `FROM..TO:STEP` or `A,B,C`.
fn values(text: &str) -> Result<Values, String> {
    let with_form = |problem| format!("{problem}: give FROM..TO:STEP, such as 50..130:10, or values as 50,80,110");
    let found = match text.split_once("..") {
        None => text.split(',').map(positive).collect::<Result<Vec<_>, _>>().map_err(with_form)?,
        Some((from, rest)) => {
            positive(from)?;
            match Range::parse(text).filter(|_| rest.contains(':')) {
                Some(Ok(Range::Steps(texts))) => texts.iter().map(|text| positive(text)).collect::<Result<_, _>>()?,
                Some(Err(problem)) => return Err(problem),
                _ => return Err("a range is FROM..TO:STEP, such as 50..130:10".into()),
            }
        }
    };
    for (index, value) in found.iter().enumerate() {
        if found[..index].iter().any(|other| other.total_cmp(value).is_eq()) {
            return Err(format!("{value} is given twice"));
        }
    }
    Ok(Values(found))
}

impl SweepArguments {
    /// The scene, and what is varied. Settings that are neither a range nor a list belong to the scene.
    fn varied(&self, context: &Context) -> Result<(LoadedScene, Axes, Option<RoadUncertainty>), CliError> {
        let usage = CliError::Usage;
        let (mut factors, mut place) = (Vec::new(), self.place.scene.clone());
        place.settings.clear();
        for setting in &self.place.scene.settings {
            match Factor::of(setting).map_err(usage)? {
                Some(factor) => factors.push(factor),
                None => place.settings.push(setting.clone()),
            }
        }
        for (option, key, is_given) in
            [("--speed", SPEED_KEY, self.speed.is_some()), ("--load", LOAD_KEY, self.load.is_some())]
        {
            if is_given && self.place.scene.settings.iter().any(|setting| setting.key() == key) {
                return Err(usage(format!("{option} and --set {key} are the same: give one of them")));
            }
        }
        let mut speeds = self.speed.clone().map_or(Vec::new(), |speeds| speeds.0);
        if speeds.is_empty() && self.latin_hypercube.is_none() {
            // Speeds have a table by bands, with their growth.
            if let Some(index) = factors.iter().position(|factor| factor.key == SPEED_KEY) {
                let refused = |problem| usage(format!("--set {SPEED_KEY}: {problem}"));
                let listed = factors[index].values.texts().map_err(refused)?.join(",");
                speeds = values(&listed).map_err(refused)?.0;
                factors.remove(index);
            }
        }
        let loaded = context.load(&place)?;
        let uncertainty = self.road_uncertainty.then(|| RoadUncertainty::of(&loaded.scene));
        let uncertainty = uncertainty.transpose().map_err(usage)?;
        factors.extend(uncertainty.iter().flat_map(|uncertainty| uncertainty.factors.clone()));
        let design = match self.latin_hypercube {
            Some(points) => Design::LatinHypercube { points, seed: self.design_seed },
            None => Design::Grid,
        };
        let points = match design {
            Design::Grid if factors.is_empty() => Vec::new(),
            design => design.points(&factors).map_err(usage)?,
        };
        let loads = self.load.clone().map_or(Vec::new(), |loads| loads.0);
        let axes = Axes { speeds, loads, roads: self.road.clone(), points };
        if axes == Axes::default() {
            let how = "--speed, --load, --road, --road-uncertainty, or --set with a range or a list without brackets, \
                       such as --set road.seed=1..20 or --set contact.tread=elastic,bedding";
            return Err(usage(format!("nothing is varied: give {how}")));
        }
        Ok((loaded, axes, uncertainty))
    }

    /// Runs the sweep, or its tasks, and prints its table.
    pub(crate) fn execute(self, context: &Context) -> Result<(), CliError> {
        if self.tasks.are_there() {
            return self.tasks.execute(self.place.out.as_deref(), context);
        }
        let (base, axes, uncertainty) = self.varied(context)?;
        let variants = variants(&base, &axes)?;
        let pictures = base.scene.outputs.plots;
        if self.tasks.are_written() {
            return self.tasks.write((&base.title(), pictures), &variants, self.place.out.as_deref(), context);
        }
        let folder = self.place.clone().target("sweep");
        if folder.join(SUMMARY_FILE).exists() {
            return Err(ResultsError::NotOurs { path: folder }.into());
        }
        let read = base.scene.files().map(|(_, file)| file);
        let roads = axes.roads.iter().map(PathBuf::as_path);
        let inputs: Vec<&Path> = [self.place.scene.scene.as_path()].into_iter().chain(read).chain(roads).collect();
        check_tables(&folder, &inputs)?;
        let page = self.report.then(|| beside(&folder, ".html"));
        page.as_deref().map_or(Ok(()), check_page)?;
        std::fs::create_dir_all(&folder).map_err(ResultsError::creating(&folder))?;

        let mut progress = context.progress();
        let outcomes = sweep(&variants, &folder, context.threads, context.interrupt.flag(), &mut progress);
        drop(progress);
        let runs: Vec<(Label, Option<Done>)> = variants
            .iter()
            .zip(&outcomes)
            .map(|(variant, outcome)| (variant.label.clone(), outcome.done().cloned()))
            .collect();
        let folders: Vec<PathBuf> = variants.iter().map(|variant| folder.join(&variant.label.name)).collect();
        share_full_scale(&folders)?;
        let report = write_tables(&folder, (&base.title(), pictures), &runs, uncertainty.as_ref())?;
        write_record(&folder, base.title(), &runs)?;
        let ended = ended(&variants, &outcomes, context.colour);
        if matches!(ended, Err(CliError::SweepStopped)) {
            return ended;
        }
        if let Some(page) = page {
            write_page(std::slice::from_ref(&folder), None, &page, context)?;
        }
        context.print_report(&report).map_err(|error| error.with_results(&folder))?;
        if !context.options.quiet && !context.options.json {
            let found = outcomes.iter().filter(|outcome| outcome.done().is_some_and(|done| done.found)).count();
            let (all, place) = (variants.len(), folder.display());
            print(&format!("\n{all} variants, {found} of them finished before\nresults in {place}\n"))
                .map_err(|error| error.with_results(&folder))?;
        }
        ended
    }
}

/// Reports what failed; an error unless all variants are done, each under its load.
fn ended(variants: &[Variant], outcomes: &[VariantOutcome], colour: bool) -> Result<(), CliError> {
    let (mut failed, mut missed) = (Vec::new(), Vec::new());
    for (variant, outcome) in variants.iter().zip(outcomes) {
        match outcome {
            VariantOutcome::Failed(error) => {
                let message = match error {
                    RunError::Scene(error) => error.render(colour),
                    other => other.to_string(),
                };
                write_message(&format!("{}: {message}", variant.label.name));
                failed.push(variant.label.name.clone());
            }
            VariantOutcome::Done(done) if done.missed_load().is_some() => missed.push(variant.label.name.clone()),
            VariantOutcome::Done(_) | VariantOutcome::Stopped => {}
        }
    }
    if outcomes.iter().any(|outcome| matches!(outcome, VariantOutcome::Stopped)) {
        return Err(CliError::SweepStopped);
    }
    let mut wrong = Vec::new();
    if !failed.is_empty() {
        let (count, all) = (failed.len(), variants.len());
        wrong.push(format!("{count} of {all} variants failed: {}; the others are done", failed.join(", ")));
    }
    wrong.extend(missed_message(&missed, variants.len()));
    if wrong.is_empty() { Ok(()) } else { Err(CliError::Failed(wrong.join("; "))) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_and_lists_are_read_and_bad_ones_answered() {
        let of = |text: &str| values(text).unwrap().0;
        assert_eq!(of("50..130:10"), [50.0, 60.0, 70.0, 80.0, 90.0, 100.0, 110.0, 120.0, 130.0]);
        assert_eq!(of("50..79:10"), [50.0, 60.0, 70.0]);
        assert_eq!(of("1..1.3:0.1").len(), 4, "the end is there in spite of rounding");
        assert_eq!(of("80..80:10"), [80.0]);
        assert_eq!(of("30, 50,80.5"), [30.0, 50.0, 80.5]);
        for (text, word) in [
            ("50..130", "FROM..TO:STEP"),
            ("130..50:10", "before it begins"),
            ("50..130:0", "not a positive number"),
            ("50..130:-10", "not a positive number"),
            ("0..130:10", "not a positive number"),
            ("50..fast:10", "\"fast\""),
            ("1..100000:1", "larger step"),
            ("50-130", "FROM..TO:STEP, such as 50..130:10"),
            ("50,,80", "\"\""),
            ("50,80,50", "given twice"),
            ("", "\"\""),
            ("nan", "not a positive number"),
        ] {
            let error = values(text).unwrap_err();
            assert!(error.contains(word), "{text}: {error}");
        }
    }
}
