//! `tyrewave sweep`: one scene at many speeds, loads, roads and settings.

use std::path::{Path, PathBuf};

use clap::Args;
use tyrewave::response::BandLevel;
use tyrewave::results::ResultsError;
use tyrewave::results::plots::ThirdOctavePlot;
use tyrewave::results::spectra::FORCE_LEVEL;
use tyrewave::results::summary::SUMMARY_FILE;
use tyrewave::results::table::Report;
use tyrewave::run::RunError;
use tyrewave::scene::LoadedScene;
use tyrewave::study::sweep::table::{csv, growth_plot, sound_csv};
use tyrewave::study::sweep::{
    Axes, Design, Done, Factor, Label, Outcome, Range, RepeatedTable, SPEED_KEY, SweepBlock, Variant, blocks, sweep,
    variants,
};

use super::context::{Context, print};
use super::error::CliError;
use super::messages::tell;
use super::options::positive;
use super::output_file::{Replaces, check};
use super::side::Place;

const EXAMPLES: &str = "\
Every combination of what is varied is a run of its own, with a results folder of its own under the sweep's. \
Several run at a time, on no more threads than --threads allows; the tyre's influence functions are fitted once. \
Beside the folders: sweep.csv and sweep.txt, third-octave levels of the contact force by speed and, per band, how \
they grow (dB per decade of speed, least squares over the logarithm of the speed) with the rms of what that line \
misses, and the rolling resistance; growth.svg and levels.svg; where the scene has receivers, sweep_sound.csv: levels \
in dB(A) there and how they grow. A variant that missed its load by more than the axle's \
tolerance is marked with a star, and the exit code is 1.

The same command again goes on where it left off: finished variants are not run again, interrupted ones go on from \
their checkpoint. A variant is another one when its scene, the version of tyrewave or its road file has changed.

Any key may be varied: --set KEY=FROM..TO:STEP, --set KEY=FROM..TO of whole numbers, --set KEY=A,B,C (a text with a \
comma in it stands in quotes). Values of a seed, such as road.seed, are draws of the same thing: the table has means \
over them, with half of the 95 % interval that Student's distribution gives. design.csv and design.json have every \
mean, third octaves included; force_by_KEY.svg and sound_by_KEY.svg show levels against what is varied. \
--latin-hypercube 40 takes 40 points between the ends of all --set FROM..TO, whose parts each are taken once, instead \
of every combination; values of seeds are repeated at each, and so are --speed, --load and --road.

A road is a file: a profile (.dat, .csv) or OpenCRG (.crg) takes the place of the scene's road, whose other keys stay \
if it is of the same kind; a .toml file holds the keys of a whole [road].

Examples:
  tyrewave sweep scenes/default.toml --speed 50..130:10
  tyrewave sweep scenes/default.toml --speed 50,80,100 --load 3000,4000 --out trial
  tyrewave sweep scenes/default.toml --speed 50..100:25 --road smooth.toml --road stone.crg
  tyrewave sweep scenes/default.toml --set contact.tread=elastic,bedding --set road.seed=1..20
  tyrewave sweep scenes/default.toml --latin-hypercube 40 --set rolling.speed_kmh=50.0..130 \\
      --set tyre.layers[1].thickness=0.008..0.014";

/// What is written beside the variants' folders.
const TEXT: &str = "sweep.txt";
const TABLE: &str = "sweep.csv";
const SOUND: &str = "sweep_sound.csv";
const GROWTH: &str = "growth.svg";
const LEVELS: &str = "levels.svg";
const DESIGN: &str = "design.csv";
const DESIGN_JSON: &str = "design.json";

/// Most spectra of a design in one picture.
const MOST_SPECTRA: usize = 12;

#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct SweepArguments {
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
    /// So many points of a Latin hypercube over what --set varies, instead of every combination.
    #[arg(long, value_name = "POINTS")]
    latin_hypercube: Option<usize>,
    /// Seed of the Latin hypercube's random numbers.
    #[arg(long, value_name = "SEED", default_value_t = 1, requires = "latin_hypercube")]
    design_seed: u64,
}

/// Positive numbers from the command line, each once.
#[derive(Clone, Debug)]
struct Values(Vec<f64>);

/// `FROM..TO:STEP` or `A,B,C`.
fn values(text: &str) -> Result<Values, String> {
    let found = match text.split_once("..") {
        None => text.split(',').map(positive).collect::<Result<Vec<_>, _>>()?,
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
    /// The scene, and what is varied of it. Settings that are no range and no list are the scene's own.
    fn varied(&self, context: &Context) -> Result<(LoadedScene, Axes), CliError> {
        let usage = CliError::Usage;
        let (mut factors, mut place) = (Vec::new(), self.place.scene.clone());
        place.settings.clear();
        for setting in &self.place.scene.settings {
            match Factor::of(setting).map_err(usage)? {
                Some(factor) => factors.push(factor),
                None => place.settings.push(setting.clone()),
            }
        }
        let mut speeds = self.speed.clone().map_or(Vec::new(), |speeds| speeds.0);
        if speeds.is_empty() && self.latin_hypercube.is_none() {
            // The table of speeds is one of bands, and their growth.
            if let Some(index) = factors.iter().position(|factor| factor.key == SPEED_KEY) {
                let told = |problem| usage(format!("--set {SPEED_KEY}: {problem}"));
                let listed = factors[index].values.texts().map_err(told)?.join(",");
                speeds = values(&listed).map_err(told)?.0;
                factors.remove(index);
            }
        } else if !speeds.is_empty() && factors.iter().any(|factor| factor.key == SPEED_KEY) {
            return Err(usage(format!("--speed and --set {SPEED_KEY} are the same: give one of them")));
        }
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
            let how = "--speed, --load, --road, or --set with a range or a list, such as --set road.seed=1..20";
            return Err(usage(format!("nothing is varied: give {how}")));
        }
        Ok((context.load(&place)?, axes))
    }

    /// Runs the sweep and prints its table.
    pub fn execute(self, context: &Context) -> Result<(), CliError> {
        let (base, axes) = self.varied(context)?;
        let variants = variants(&base, &axes)?;
        let folder = self.place.clone().target("sweep");
        if folder.join(SUMMARY_FILE).exists() {
            return Err(ResultsError::NotOurs { path: folder }.into());
        }
        let base_road = base.scene.road.file();
        let roads = axes.roads.iter().map(PathBuf::as_path);
        let inputs: Vec<&Path> = [self.place.scene.scene.as_path()].into_iter().chain(base_road).chain(roads).collect();
        for name in [TEXT, TABLE, SOUND, GROWTH, LEVELS, DESIGN, DESIGN_JSON] {
            check(&folder.join(name), Replaces::AllBut(&inputs))?;
        }
        std::fs::create_dir_all(&folder).map_err(ResultsError::creating(&folder))?;

        let mut progress = context.progress();
        let outcomes = sweep(&variants, &folder, context.threads, context.interrupt.flag(), &mut progress);
        drop(progress);
        let runs: Vec<(Label, Option<Done>)> = variants
            .iter()
            .zip(&outcomes)
            .map(|(variant, outcome)| (variant.label.clone(), outcome.done().cloned()))
            .collect();
        let blocks = blocks(&runs);
        let repeated = RepeatedTable::new(&runs);
        let report = repeated.as_ref().map_or_else(|| side_by_side(&blocks), RepeatedTable::report);
        let write = |name: &str, text: &str| {
            let path = folder.join(name);
            std::fs::write(&path, text).map_err(ResultsError::writing(&path))
        };
        write(TEXT, &report.to_string())?;
        write(TABLE, &csv(&blocks))?;
        if let Some(sound) = sound_csv(&blocks) {
            write(SOUND, &sound)?;
        }
        if let Some(repeated) = &repeated {
            write(DESIGN, &repeated.csv())?;
            write(DESIGN_JSON, &format!("{:#}\n", repeated.to_json()))?;
            if base.scene.outputs.plots {
                for (name, svg) in repeated.plots(&base.title())? {
                    write(&name, &svg)?;
                }
            }
        }
        if base.scene.outputs.plots {
            if let Some(svg) = growth_plot(&blocks, &format!("Growth with the speed: {}", base.title()))? {
                write(GROWTH, &svg)?;
            }
            let spectra = spectra(&runs);
            // More cannot be told apart in one picture.
            if !spectra.is_empty() && (repeated.is_none() || spectra.len() <= MOST_SPECTRA) {
                let quantity = FORCE_LEVEL;
                let title = &format!("Contact force, third octaves: {}", base.title());
                write(LEVELS, &ThirdOctavePlot { title, quantity, spectra, error: None }.to_svg()?)?;
            }
        }
        let ended = ended(&variants, &outcomes, context.colour);
        if matches!(ended, Err(CliError::SweepStopped)) {
            return ended;
        }
        context.print_report(&report)?;
        if !context.options.quiet && !context.options.json {
            let found = outcomes.iter().filter(|outcome| outcome.done().is_some_and(|done| done.found)).count();
            let (all, place) = (variants.len(), folder.display());
            print(&format!("\n{all} variants, {found} of them found finished\nresults in {place}\n"))?;
        }
        ended
    }
}

/// The tables of all roads, loads and settings, speeds side by side.
fn side_by_side(blocks: &[SweepBlock]) -> Report {
    let mut report = Report::default();
    for (index, block) in blocks.iter().enumerate() {
        if index > 0 {
            report.text("\n");
        }
        report.append(block.report());
    }
    report
}

/// Names and levels of the variants that have any.
fn spectra(runs: &[(Label, Option<Done>)]) -> Vec<(&str, &[BandLevel])> {
    let done = runs.iter().filter_map(|(label, done)| Some((label, done.as_ref()?)));
    let levels = done.map(|(label, done)| (label.name.as_str(), done.levels.as_slice()));
    levels.filter(|(_, levels)| !levels.is_empty()).collect()
}

/// Reports what failed; an error unless all variants are done, each under its load.
fn ended(variants: &[Variant], outcomes: &[Outcome], colour: bool) -> Result<(), CliError> {
    let (mut failed, mut missed) = (Vec::new(), Vec::new());
    for (variant, outcome) in variants.iter().zip(outcomes) {
        match outcome {
            Outcome::Failed(error) => {
                let message = match error {
                    RunError::Scene(error) => error.render(colour),
                    other => other.to_string(),
                };
                tell(&format!("{}: {message}", variant.label.name));
                failed.push(variant.label.name.clone());
            }
            Outcome::Done(done) if done.missed_load().is_some() => missed.push(variant.label.name.clone()),
            Outcome::Done(_) | Outcome::Stopped => {}
        }
    }
    if outcomes.iter().any(|outcome| matches!(outcome, Outcome::Stopped)) {
        return Err(CliError::SweepStopped);
    }
    let told = |names: &[String], what: &str| format!("{} of {} variants {what}", names.len(), variants.len());
    let mut wrong = Vec::new();
    if !failed.is_empty() {
        wrong.push(format!("{}: {}; the others are done", told(&failed, "failed"), failed.join(", ")));
    }
    if !missed.is_empty() {
        let what = "missed their load by more than its tolerance";
        wrong.push(format!("{}: {}; their results are kept", told(&missed, what), missed.join(", ")));
    }
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
