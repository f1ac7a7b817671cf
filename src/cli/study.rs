//! `tyrewave study`: accuracy against time of every knob of a scene.

use std::path::PathBuf;

use clap::Args;
use tyrewave::counters::Meter;
use tyrewave::plan::settled;
use tyrewave::results::folder::ResultsFolder;
use tyrewave::results::summary::{Cost, Summary};
use tyrewave::scene::Scene;
use tyrewave::study::accuracy::presets::{Verdict, verdicts};
use tyrewave::study::accuracy::{StudyOptions, Sweep, study};

use super::options::positive;
use super::study_report::{csv, json, picture, text, verdict_table};
use super::{CliError, Context, side_folder};

const EXAMPLES: &str = "\
Every knob that trades accuracy for time is swept with the others at a fine reference: elements, steps, time rules, poles, cells across, curves; what only the direct history has, where \
the scene has it. Errors are differences of third-octave levels of the contact force from 100 Hz to fmax, of the force itself, and of its mean and the patch's length. The reference is halved and \
doubled in turn: errors below the doubt that is left are marked. Laws of tread and slices are listed apart: they are models. Then combinations are chosen by what the single knobs let expect, \
rolled, and the expectation is corrected. The front is by exact work; times stand beside it.

Results: study.txt, study.csv, study.json, study.svg.

Examples:
  tyrewave study scenes/default.toml
  tyrewave study scenes/default.toml --duration 6 --runs 40 --out trial
  tyrewave study scenes/default.toml --check-presets
  tyrewave study scenes/default.toml --elements 2048 --substeps 8";

/// Arguments of `tyrewave study`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct StudyArguments {
    /// The scene, a TOML file.
    pub scene: PathBuf,
    /// Highest frequency compared, in Hz; default: the scene's fmax, or 1000.
    #[arg(long, value_name = "HZ", value_parser = positive)]
    pub fmax: Option<f64>,
    /// Time compared, in s; default: the scene's, at most 1.
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    pub duration: Option<f64>,
    /// Combinations of settings that are rolled.
    #[arg(long, value_name = "N", default_value_t = StudyOptions::RUNS as u16)]
    pub runs: u16,
    /// Check the presets instead: they, and settings close to them, against the reference; exit code 1 if one does not
    /// keep its stated error, or is not on the front.
    #[arg(long)]
    pub check_presets: bool,
    /// Elements of the reference; default: twice the scene's, or a quarter more than the finest preset's.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(32..))]
    pub elements: Option<u32>,
    /// Steps per element of the reference; default: so many that a period of fmax has 48.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(2..))]
    pub substeps: Option<u16>,
    /// Results folder; default: results/NAME-study, NAME being the scene's.
    #[arg(long, short, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
}

impl StudyArguments {
    /// Studies, writes and prints.
    ///
    /// # Errors
    /// [`CliError`].
    pub fn execute(self, context: &Context) -> Result<(), CliError> {
        let loaded = settled(Scene::load(&self.scene)?)?;
        loaded.check_time_domain()?;
        let target = self.out.clone().unwrap_or_else(|| side_folder(&self.scene, "study"));
        // What cannot be replaced is refused before the long work.
        drop(ResultsFolder::create(&target)?);
        let begin = std::time::Instant::now();
        let defaults = StudyOptions::of(&loaded.scene);
        let options = StudyOptions {
            highest: self.fmax.unwrap_or(defaults.highest),
            duration: self.duration.unwrap_or(defaults.duration),
            runs: if self.check_presets { 0 } else { usize::from(self.runs) },
            sweep: if self.check_presets { Sweep::Neighbours } else { Sweep::Knobs },
            // A multiple of 16: all parts that are swept are even.
            elements: self.elements.map(|elements| (elements as usize).div_ceil(16) * 16),
            substeps: self.substeps.map(usize::from),
        };
        let mut progress = context.progress();
        let found = study(&loaded, &options, context.interrupt.flag(), &mut progress)?;
        drop(progress);
        let folder = ResultsFolder::create(&target)?;
        let verdicts = verdicts(&found);
        let mut text = text(&found, &loaded.scene);
        text.push_str(&verdict_table(&verdicts));
        folder.write_text("study.txt", &text)?;
        folder.write_text("study.csv", &csv(&found))?;
        folder.write_text("study.json", &json(&found))?;
        folder.write_text("study.svg", &picture(&found, &loaded.title())?)?;
        let cost = Cost::new(&Meter::default(), begin.elapsed().as_secs_f64(), context.threads);
        let place = folder.finish(Summary::begun(&loaded.title(), loaded.settings()?, cost))?;
        context.answer(&format!("{text}\n"), &place)?;
        let fails = |verdict: &&Verdict| !(verdict.keeps_its_error() && verdict.is_on_the_front());
        let failed: Vec<String> =
            verdicts.iter().filter(fails).map(|verdict| verdict.preset.name().to_owned()).collect();
        if self.check_presets && !failed.is_empty() { Err(CliError::Presets { failed }) } else { Ok(()) }
    }
}
