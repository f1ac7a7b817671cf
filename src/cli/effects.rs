//! `tyrewave effects`: what each effect is worth, before it is paid for.

use std::path::{Path, PathBuf};

use clap::Args;
use csv::Writer;
use tyrewave::counters::Meter;
use tyrewave::plan::{bytes, settled};
use tyrewave::response::BandLevel;
use tyrewave::results::folder::ResultsFolder;
use tyrewave::results::plots::{Axis, LinePlot, Series};
use tyrewave::results::summary::{Cost, RollingResistance, Summary};
use tyrewave::results::table::aligned;
use tyrewave::results::{PlotError, ResultsError};
use tyrewave::scene::Scene;
use tyrewave::study::compare;
use tyrewave::study::effects::{self, Comparison, Effect, Found, Worth};

use super::options::positive;
use super::{CliError, Context, side_folder};

/// Longest time rolled for each variant unless asked for \[s\].
const LONGEST: f64 = 3.0;

const EXAMPLES: &str = "\
Rolls the scene without any effect that can be taken away, with all of them, with each one alone, and with all but one; then tabulates what each effect changes: third-octave \
levels of the contact force, mean force, length of the patch, rolling resistance, time of the steps, planned memory.

Results: effects.csv, effects.txt, and the changes of the levels as plots, effects_added.svg and effects_taken_away.svg.

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
        let loaded = settled(Scene::load(&self.scene)?)?;
        loaded.check_time_domain()?;
        let target = self.out.clone().unwrap_or_else(|| side_folder(&self.scene, "effects"));
        drop(ResultsFolder::create(&target)?);
        let begin = std::time::Instant::now();
        let duration = self.duration.unwrap_or(loaded.scene.rolling.duration.min(LONGEST));
        let mut progress = context.progress();
        let comparison = effects::compare(&loaded, duration, context.interrupt.flag(), &mut progress)?;
        drop(progress);
        let folder = ResultsFolder::create(&target)?;
        let text = text(&comparison);
        folder.write_text("effects.txt", &text)?;
        folder.write_text("effects.csv", &table(&comparison, Path::new("effects.csv"))?)?;
        for (way, name) in [(Way::Added, "effects_added.svg"), (Way::TakenAway, "effects_taken_away.svg")] {
            if let Some(svg) = plot(&comparison, way, &loaded.title())? {
                folder.write_text(name, &svg)?;
            }
        }
        let cost = Cost::new(&Meter::default(), begin.elapsed().as_secs_f64(), context.threads);
        let place = folder.finish(Summary::begun(&loaded.title(), loaded.settings()?, cost))?;
        context.answer(&format!("{text}\n"), &place)
    }
}

/// How an effect is switched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Way {
    /// Alone, compared with none.
    Added,
    /// All but this, compared with all.
    TakenAway,
}

impl Way {
    const ALL: [Self; 2] = [Self::Added, Self::TakenAway];

    const fn title(self) -> &'static str {
        match self {
            Self::Added => "each effect alone",
            Self::TakenAway => "all effects but one",
        }
    }

    const fn sign(self) -> char {
        match self {
            Self::Added => '+',
            Self::TakenAway => '-',
        }
    }
}

/// The effects that the scene can have, each with its run and what that is compared with.
fn runs(comparison: &Comparison, way: Way) -> Vec<(Effect, &Found, &Found)> {
    let Comparison { base, all, effects, .. } = comparison;
    let run = |worth| match worth {
        &Worth { effect, found: Ok([ref alone, ref without]) } => Some(match way {
            Way::Added => (effect, alone, base),
            Way::TakenAway => (effect, without, all),
        }),
        Worth { found: Err(_), .. } => None,
    };
    effects.iter().filter_map(run).collect()
}

/// Those that change any level by as much as is shown.
fn changing(comparison: &Comparison, way: Way) -> Vec<(Effect, &Found, &Found)> {
    let mut runs = runs(comparison, way);
    runs.retain(|(_, found, reference)| changes(found, reference).any(|(_, change)| change.abs() >= 0.05));
    runs
}

/// Change of the level of each band of `reference`, in dB.
fn changes<'a>(found: &'a Found, reference: &'a Found) -> impl Iterator<Item = (&'a BandLevel, f64)> {
    compare::changes(&found.levels, &reference.levels)
}

fn text(comparison: &Comparison) -> String {
    let row = |name: &str, found: &Found, reference: Option<&Found>| {
        let change = |value: f64, of: fn(&Found) -> f64, unit: &str| match reference {
            Some(reference) => format!("{:+.1} {unit}", value * (of(found) - of(reference))),
            None => format!("{:.1} {unit}", value * of(found)),
        };
        let resistance = |found: &Found| found.rolling_resistance.map(|resistance| resistance.force);
        let resisted = match (resistance(found), reference.map(resistance)) {
            (Some(now), Some(Some(before))) => format!("{:+.2} N", now - before),
            (Some(now), _) => format!("{now:.2} N"),
            (None, _) => "-".to_owned(),
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
            resisted,
            worst,
            format!("{:.2} s", found.seconds),
            bytes(found.memory),
        ]
    };
    let mut rows = vec![row("none", &comparison.base, None), row("all", &comparison.all, Some(&comparison.base))];
    for way in Way::ALL {
        for (effect, found, reference) in runs(comparison, way) {
            rows.push(row(&format!("{} {}", way.sign(), effect.title()), found, Some(reference)));
        }
    }
    for (name, found) in &comparison.doubts {
        rows.push(row(&format!("{name} the local compliance"), found, Some(&comparison.all)));
    }
    let header = [
        "effects",
        "mean force",
        "patch",
        "rolling resistance",
        "largest change of a band",
        "steps",
        "memory, planned",
    ];
    let mut text = aligned(&header, &rows);
    text.push_str("\n+ alone, compared with none; - all but this, compared with all\n");
    if !comparison.doubts.is_empty() {
        text.push_str("local compliance: known within a factor of two; compared with all\n");
    }
    text.push_str("rolling resistance: none without tread coupling, where the displacements are not the tyre's own\n");
    for worth in &comparison.effects {
        if let Err(reason) = &worth.found {
            text.push_str(&format!("{}: not in this scene: {reason}\n", worth.effect.title()));
        }
    }
    for (way, name, base) in [(Way::Added, "none", &comparison.base), (Way::TakenAway, "all", &comparison.all)] {
        let runs = changing(comparison, way);
        let mut header = vec!["band [Hz]".to_owned(), format!("{name} [dB re 1 N]")];
        header.extend(runs.iter().map(|(effect, ..)| format!("{} {}", way.sign(), effect.short())));
        let row = |(index, band): (usize, &BandLevel)| -> Vec<String> {
            let change = |(_, found, reference): &(Effect, &Found, &Found)| {
                changes(found, reference).nth(index).map_or(String::new(), |(_, change)| format!("{change:+.1}"))
            };
            [band.band.label(), format!("{:.1}", band.level)].into_iter().chain(runs.iter().map(change)).collect()
        };
        let bands: Vec<Vec<String>> = base.levels.iter().enumerate().map(row).collect();
        text.push('\n');
        text.push_str(&aligned(&header, &bands));
    }
    text
}

fn table(comparison: &Comparison, path: &Path) -> Result<String, ResultsError> {
    let failed = |error: csv::Error| ResultsError::writing(path)(error.into());
    let mut writer = Writer::from_writer(Vec::new());
    let bands = comparison.base.levels.iter().map(|band| format!("level_db_re_1n_{}hz", band.band.nominal_frequency()));
    let header = ["effects", "mean_force_n", "contact_length_m", "steps_s", "memory_bytes"].into_iter();
    let header = header.chain(RollingResistance::COLUMNS).map(str::to_owned);
    writer.write_record(header.chain(bands)).map_err(failed)?;
    let mut named = vec![("none".to_owned(), &comparison.base), ("all".to_owned(), &comparison.all)];
    for way in Way::ALL {
        let name = |effect: Effect| format!("{} {}", way.sign(), effect.title());
        named.extend(runs(comparison, way).into_iter().map(|(effect, found, _)| (name(effect), found)));
    }
    named.extend(comparison.doubts.iter().map(|(name, found)| (format!("{name} the local compliance"), found)));
    for (name, found) in named {
        let numbers = [found.mean_force, found.contact_length, found.seconds, found.memory];
        let levels = found.levels.iter().map(|band| band.level);
        let numbers = numbers.map(|number| number.to_string()).into_iter();
        let resistance = RollingResistance::cells(found.rolling_resistance);
        let record = [name].into_iter().chain(numbers).chain(resistance).chain(levels.map(|level| level.to_string()));
        writer.write_record(record).map_err(failed)?;
    }
    let bytes = writer.into_inner().map_err(|error| ResultsError::writing(path)(error.into_error()))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// Changes beyond this are cut: next to a change of thirty decibels nobody sees one of three.
const LARGEST_DRAWN: f64 = 12.0;

/// The changes of the levels as SVG, of the effects that change any; `None` where there are none, or runs too short for
/// a spectrum.
fn plot(comparison: &Comparison, way: Way, title: &str) -> Result<Option<String>, PlotError> {
    let runs = changing(comparison, way);
    let points = |found, reference| -> Vec<(f64, f64)> {
        changes(found, reference).map(|(band, change)| (band.band.mid_frequency(), change)).collect()
    };
    let series: Vec<Series<'_>> = runs
        .iter()
        .map(|(effect, found, reference)| Series { name: effect.title(), points: points(found, reference) })
        .collect();
    let drawn = || series.iter().flat_map(|series| &series.points).filter(|(_, change)| change.is_finite());
    let frequencies = drawn().map(|(frequency, _)| *frequency);
    let (low, high) = frequencies.fold((f64::MAX, 0.0_f64), |(low, high), f| (low.min(f), high.max(f)));
    if low > high {
        return Ok(None);
    }
    let seen = drawn().map(|(_, change)| change.clamp(-LARGEST_DRAWN, LARGEST_DRAWN)).chain([0.0]);
    let plot = LinePlot {
        title: &format!("{title}: {}", way.title()),
        x: Axis::logarithmic("Frequency [Hz]", 0.9 * low..1.1 * high),
        y: Axis::linear_around("Change of the contact force level [dB]", seen),
        series: series.clone(),
    };
    plot.to_svg().map(Some)
}
