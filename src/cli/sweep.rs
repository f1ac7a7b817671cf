//! `tyrewave sweep`: one scene at many speeds, loads and roads.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use tyrewave::results::ResultsError;
use tyrewave::results::plots::ThirdOctavePlot;
use tyrewave::results::summary::SUMMARY_FILE;
use tyrewave::scene::Scene;
use tyrewave::study::sweep::table::{csv, growth_plot};
use tyrewave::study::sweep::{Axes, Outcome, SweepBlock, SweepWatch, Variant, blocks, sweep, variants};

use super::options::positive;
use super::{CliError, Context, print, side_folder};

const EXAMPLES: &str = "\
Every combination of speed, load and road is a run of its own, with a results folder of its own under the sweep's. Several run at a time, on no more threads than \
--threads allows; the tyre's influence functions are fitted once. Beside the folders: sweep.csv and sweep.txt, third-octave levels of the contact force by speed and, per band, how \
they grow (dB per decade of speed, least squares over the logarithm of the speed) with the rms of what that line \
misses, and the rolling resistance; growth.svg and levels.svg.

The same command again goes on where it left off: finished variants are not run again, interrupted ones go on from their checkpoint. A variant is another one when its scene, the \
version of tyrewave or its road file has changed.

A road is a file: a profile (.dat, .csv) or OpenCRG (.crg) takes the place of the scene's road, whose other keys stay if it is of the same kind; a .toml file holds \
the keys of a whole [road].

Examples:
  tyrewave sweep scenes/default.toml --speed 50..130:10
  tyrewave sweep scenes/default.toml --speed 50,80,100 --load 3000,4000 --out trial
  tyrewave sweep scenes/default.toml --speed 50..100:25 --road smooth.toml --road stone.crg";

/// Most values that a range may stand for; a slip of the finger must not start a million runs.
const MOST_VALUES: usize = 1000;

/// Arguments of `tyrewave sweep`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct SweepArguments {
    /// The scene, a TOML file.
    pub scene: PathBuf,
    /// Speeds in km/h: FROM..TO:STEP, both ends included, or values separated by commas.
    #[arg(long, value_name = "SPEEDS", value_parser = values)]
    pub speed: Values,
    /// Loads in N, in the same form; default: the scene's axle.
    #[arg(long, value_name = "LOADS", value_parser = values)]
    pub load: Option<Values>,
    /// Road file; may be given several times; default: the scene's road.
    #[arg(long, value_name = "FILE")]
    pub road: Vec<PathBuf>,
    /// Folder of the sweep; default: results/NAME-sweep, NAME being the scene's.
    #[arg(long, short, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
}

/// Positive numbers from the command line, each once.
#[derive(Clone, Debug, PartialEq)]
pub struct Values(pub Vec<f64>);

/// `FROM..TO:STEP` or `A,B,C`.
fn values(text: &str) -> Result<Values, String> {
    let found = match text.split_once("..") {
        None => text.split(',').map(positive).collect::<Result<Vec<_>, _>>()?,
        Some((from, rest)) => {
            let (to, step) = rest.split_once(':').ok_or("a range is FROM..TO:STEP, such as 50..130:10")?;
            let (from, to, step) = (positive(from)?, positive(to)?, positive(step)?);
            if to < from {
                return Err(format!("the range ends at {to}, before it begins at {from}"));
            }
            // An end that is missed by rounding only is meant to be there.
            let steps = ((to - from) / step * (1.0 + 1e-12) + 1e-9).floor();
            if steps >= MOST_VALUES as f64 {
                return Err(format!("{} values are more than {MOST_VALUES}: choose a larger step", steps + 1.0));
            }
            (0..=steps as u32).map(|index| from + f64::from(index) * step).collect()
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
    /// Runs the sweep and prints its table.
    ///
    /// # Errors
    /// [`CliError`]; [`CliError::SweepFailed`] when some variants failed and the others are done.
    pub fn execute(self, context: &Context) -> Result<(), CliError> {
        let base = Scene::load(&self.scene)?;
        let loads = self.load.map_or(Vec::new(), |loads| loads.0);
        let variants = variants(&base, &Axes { speeds: self.speed.0, loads, roads: self.road })?;
        let folder = self.out.unwrap_or_else(|| side_folder(&self.scene, "sweep"));
        if folder.join(SUMMARY_FILE).exists() {
            return Err(ResultsError::NotOurs { path: folder }.into());
        }
        std::fs::create_dir_all(&folder).map_err(ResultsError::creating(&folder))?;

        let watch = Watch::new(context.options.quiet, variants.len());
        let outcomes = sweep(&variants, &folder, context.threads, context.interrupt.flag(), &watch);
        watch.bar.finish_and_clear();
        let blocks = blocks(&variants, &outcomes);
        let table: String = blocks.iter().map(SweepBlock::text).collect::<Vec<_>>().join("\n");
        let write = |name: &str, text: &str| {
            let path = folder.join(name);
            std::fs::write(&path, text).map_err(ResultsError::writing(&path))
        };
        write("sweep.txt", &table)?;
        write("sweep.csv", &csv(&blocks, &folder.join("sweep.csv"))?)?;
        if base.scene.outputs.plots {
            if let Some(svg) = growth_plot(&blocks, &base.title())? {
                write("growth.svg", &svg)?;
            }
            let spectra: Vec<_> = done(&variants, &outcomes).filter(|(_, levels)| !levels.is_empty()).collect();
            if !spectra.is_empty() {
                let plot = ThirdOctavePlot {
                    title: &base.title(),
                    quantity: "Contact force level [dB re 1 N]",
                    spectra: spectra.clone(),
                };
                write("levels.svg", &plot.to_svg()?)?;
            }
        }
        ended(&variants, &outcomes, context.colour)?;
        let found = outcomes.iter().filter(|outcome| matches!(outcome, Outcome::Done { found: true, .. })).count();
        if context.options.quiet {
            return Ok(());
        }
        let all = variants.len();
        print(&format!("{table}\n{all} variants, {found} of them found finished\nresults in {}\n", folder.display()))
    }
}

/// Names and levels of the variants that are done.
fn done<'a>(
    variants: &'a [Variant],
    outcomes: &'a [Outcome],
) -> impl Iterator<Item = (&'a str, &'a [tyrewave::response::BandLevel])> {
    variants.iter().zip(outcomes).filter_map(|(variant, outcome)| match outcome {
        Outcome::Done { levels, .. } => Some((variant.name.as_str(), levels.as_slice())),
        Outcome::Stopped | Outcome::Failed(_) => None,
    })
}

/// Reports what failed; an error unless all variants are done.
fn ended(variants: &[Variant], outcomes: &[Outcome], colour: bool) -> Result<(), CliError> {
    let mut failed = Vec::new();
    for (variant, outcome) in variants.iter().zip(outcomes) {
        if let Outcome::Failed(error) = outcome {
            let message = match error {
                tyrewave::run::RunError::Scene(error) => error.render(colour),
                other => other.to_string(),
            };
            eprintln!("{}: {message}", variant.name);
            failed.push(variant.name.clone());
        }
    }
    if outcomes.iter().any(|outcome| matches!(outcome, Outcome::Stopped)) {
        return Err(CliError::SweepStopped);
    }
    if failed.is_empty() { Ok(()) } else { Err(CliError::SweepFailed { failed, of: variants.len() }) }
}

/// One line for the whole sweep; silent where standard error is not a terminal.
struct Watch {
    bar: ProgressBar,
    quiet: bool,
}

impl Watch {
    fn new(quiet: bool, variants: usize) -> Self {
        let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let bar = ProgressBar::with_draw_target(Some(0), target);
        let template = "{msg} {bar:30} {percent:>3} %, {elapsed} so far, {eta} to go";
        bar.set_style(ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()));
        bar.set_message(format!("rolling {variants} variants"));
        if !bar.is_hidden() {
            bar.enable_steady_tick(Duration::from_millis(250));
        }
        Self { bar, quiet }
    }
}

impl SweepWatch for Watch {
    fn planned(&self, steps: u64) {
        self.bar.inc_length(steps);
    }

    fn done(&self, steps: u64) {
        self.bar.inc(steps);
    }

    fn note(&self, name: &str, text: &str) {
        if !self.quiet {
            self.bar.suspend(|| eprintln!("note: {name}: {text}"));
        }
    }
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
