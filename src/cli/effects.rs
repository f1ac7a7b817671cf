//! `tyrewave effects`: what each effect is worth, before it is paid for.

use std::path::{Path, PathBuf};

use clap::Args;
use csv::Writer;

use super::options::positive;
use super::{CliError, Context, print, side_folder};
use crate::meter::Meter;
use crate::pipeline::plan::bytes;
use crate::pipeline::worth::{Comparison, Found, compare};
use crate::response::BandLevel;
use crate::results::folder::ResultsFolder;
use crate::results::plots::{Axis, LinePlot, Series};
use crate::results::summary::{Cost, Summary};
use crate::results::table::aligned;
use crate::results::{PlotError, ResultsError};
use crate::scene::Scene;

/// Longest time rolled for each variant unless asked for \[s\].
const LONGEST: f64 = 3.0;

const EXAMPLES: &str = "\
Rolls the scene without any effect that can be taken away, with all of them, with each one alone, and with all but one; then tabulates what each effect changes: third-octave \
levels of the contact force, mean force, length of the patch, time of the steps, planned memory.

Results: effects.csv, effects.txt, and the changes of the levels as a plot, effects.svg.

Examples:
  tyrewave effects scenes/default.toml
  tyrewave effects scenes/default.toml --duration 10 --out trial";

/// Arguments of `tyrewave effects`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct EffectsArguments {
    /// The scene, a TOML file.
    pub scene: PathBuf,
    /// Time rolled after the warm-up for each variant, in s; default: the scene's, at most 3.
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    pub duration: Option<f64>,
    /// Results folder; default: results/NAME-effects, NAME being the scene's.
    #[arg(long, short, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
}

impl EffectsArguments {
    /// Compares and prints the tables.
    ///
    /// # Errors
    /// [`CliError`].
    pub fn execute(self, context: &Context) -> Result<(), CliError> {
        let loaded = Scene::load(&self.scene)?;
        loaded.check_time_domain()?;
        let target = self.out.clone().unwrap_or_else(|| side_folder(&self.scene, "effects"));
        drop(ResultsFolder::create(&target)?);
        let begin = std::time::Instant::now();
        let duration = self.duration.unwrap_or(loaded.scene.rolling.duration.min(LONGEST));
        let mut progress = context.progress();
        let comparison = compare(&loaded, duration, context.interrupt.flag(), &mut progress)?;
        drop(progress);
        let folder = ResultsFolder::create(&target)?;
        let text = text(&comparison);
        folder.write_text("effects.txt", &text)?;
        folder.write_text("effects.csv", &table(&comparison, Path::new("effects.csv"))?)?;
        if let Some(svg) = plot(&comparison, &loaded.title())? {
            folder.write_text("effects.svg", &svg)?;
        }
        let cost = Cost::new(&Meter::default(), begin.elapsed().as_secs_f64(), context.threads);
        let place = folder.finish(Summary::begun(&loaded.title(), loaded.settings()?, cost))?;
        if context.options.quiet {
            return Ok(());
        }
        print(&format!("{text}\nresults in {}\n", place.display()))
    }
}

/// The runs with their names and what each is compared with, in order.
fn runs(comparison: &Comparison) -> Vec<(String, &Found, &Found)> {
    let Comparison { base, all, effects } = comparison;
    let mut runs = vec![("all".to_owned(), all, base)];
    for worth in effects {
        if let Ok([alone, without]) = &worth.found {
            runs.push((format!("+ {}", worth.effect.title()), alone, base));
            runs.push((format!("- {}", worth.effect.title()), without, all));
        }
    }
    runs
}

/// Change of the level of each band of `reference`, in dB; NaN where one of them is silent.
fn changes<'a>(found: &'a Found, reference: &'a Found) -> impl Iterator<Item = (&'a BandLevel, f64)> {
    let level = |band: &BandLevel| {
        found.levels.iter().find(|other| other.band == band.band).map_or(f64::NAN, |other| other.level)
    };
    reference.levels.iter().map(move |band| {
        let change = level(band) - band.level;
        (band, if change.is_finite() { change } else { f64::NAN })
    })
}

fn text(comparison: &Comparison) -> String {
    let row = |name: &str, found: &Found, reference: Option<&Found>| {
        let change = |value: f64, of: fn(&Found) -> f64, unit: &str| match reference {
            Some(reference) => format!("{:+.1} {unit}", value * (of(found) - of(reference))),
            None => format!("{:.1} {unit}", value * of(found)),
        };
        let worst = reference.map_or(String::new(), |reference| {
            let changes = changes(found, reference).filter(|(_, change)| change.is_finite());
            changes
                .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
                .map_or(String::new(), |(band, change)| format!("{change:+.1} dB at {} Hz", band.band.label()))
        });
        [
            name.to_owned(),
            change(1.0, |found| found.mean_force, "N"),
            change(1e3, |found| found.contact_length, "mm"),
            worst,
            format!("{:.2} s", found.seconds),
            bytes(found.memory),
        ]
    };
    let mut rows = vec![row("nothing", &comparison.base, None)];
    rows.extend(runs(comparison).iter().map(|(name, found, reference)| row(name, found, Some(reference))));
    let header = ["effects", "mean force", "patch", "largest change of a band", "steps", "memory, planned"];
    let mut text = aligned(&header, &rows);
    text.push_str("\n+ alone, compared with nothing; - all but this, compared with all\n");
    for worth in &comparison.effects {
        if let Err(reason) = &worth.found {
            text.push_str(&format!("{}: not in this scene: {reason}\n", worth.effect.title()));
        }
    }
    let runs = runs(comparison);
    let mut header = vec!["band [Hz]".to_owned(), "nothing [dB re 1 N]".to_owned()];
    header.extend(runs.iter().map(|(name, ..)| name.clone()));
    let bands: Vec<Vec<String>> = comparison
        .base
        .levels
        .iter()
        .enumerate()
        .map(|(index, band)| {
            let change = |(_, found, reference): &(String, &Found, &Found)| {
                changes(found, reference).nth(index).map_or(String::new(), |(_, change)| format!("{change:+.1}"))
            };
            [band.band.label(), format!("{:.1}", band.level)].into_iter().chain(runs.iter().map(change)).collect()
        })
        .collect();
    text.push('\n');
    text.push_str(&aligned(&header, &bands));
    text
}

fn table(comparison: &Comparison, path: &Path) -> Result<String, ResultsError> {
    let failed = |error: csv::Error| ResultsError::writing(path)(error.into());
    let mut writer = Writer::from_writer(Vec::new());
    let bands = comparison.base.levels.iter().map(|band| format!("level_db_re_1n_{}hz", band.band.nominal_frequency()));
    let header = ["effects", "mean_force_n", "contact_length_m", "steps_s", "memory_bytes"].map(str::to_owned);
    writer.write_record(header.into_iter().chain(bands)).map_err(failed)?;
    let named = [("nothing".to_owned(), &comparison.base)];
    for (name, found) in named.into_iter().chain(runs(comparison).into_iter().map(|(name, found, _)| (name, found))) {
        let numbers = [found.mean_force, found.contact_length, found.seconds, found.memory];
        let levels = found.levels.iter().map(|band| band.level);
        let record = [name].into_iter().chain(numbers.into_iter().chain(levels).map(|number| number.to_string()));
        writer.write_record(record).map_err(failed)?;
    }
    let bytes = writer.into_inner().map_err(|error| ResultsError::writing(path)(error.into_error()))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// The changes of the levels as SVG; `None` for runs too short for a spectrum.
fn plot(comparison: &Comparison, title: &str) -> Result<Option<String>, PlotError> {
    let runs = runs(comparison);
    let points = |found, reference| -> Vec<(f64, f64)> {
        changes(found, reference).map(|(band, change)| (band.band.mid_frequency(), change)).collect()
    };
    // The first is all against nothing: the sum of the others, and out of their scale.
    let series: Vec<Series<'_>> =
        runs.iter().skip(1).map(|(name, found, reference)| Series { name, points: points(found, reference) }).collect();
    let drawn = || series.iter().flat_map(|series| &series.points).filter(|(_, change)| change.is_finite());
    let frequencies = drawn().map(|(frequency, _)| *frequency);
    let (low, high) = frequencies.fold((f64::MAX, 0.0_f64), |(low, high), f| (low.min(f), high.max(f)));
    if low > high {
        return Ok(None);
    }
    let plot = LinePlot {
        title,
        x: Axis::logarithmic("Frequency [Hz]", 0.9 * low..1.1 * high),
        y: Axis::linear_around("Change of the contact force level [dB]", drawn().map(|(_, change)| *change)),
        series: series.clone(),
    };
    plot.to_svg().map(Some)
}
