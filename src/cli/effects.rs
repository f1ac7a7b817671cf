//! `tyrewave effects`: the contribution of each effect, and its cost.

use crate::counters::Stage;
use crate::plan::{Plan, UnitCosts, bytes, process_memory};
use crate::response::BandLevel;
use crate::results::plots::{Axis, LinePlot, Series};
use crate::results::sound::RatedLevel;
use crate::results::table::{Report, TextTable, aligned};
use crate::sound::{Compared, SoundLevels, TotalLevel};
use crate::study::calibration::calibrated;
use crate::study::effects::{self, ComparisonDirection, Effect, EffectComparison, LONGEST};
use crate::study::trial::{LOWEST_BAND, Trial, level_changes};
use clap::Args;

use super::context::Context;
use super::error::CliError;
use super::options::positive;
use super::side::Place;

const EXAMPLES: &str = "\
Rolls the scene without any effect that can be taken away, with all of these effects, with each one alone, and with \
all but one. The tables show the changes by each effect: third-octave levels of the contact force, mean force, length \
of the patch, rolling resistance, time of the steps, planned memory. If the scene has receivers, radiation is one of \
the effects, and the levels at the receivers with all effects but one are listed beside those with all effects. For a \
scene of slices the time and memory of contact over cells are given, too. The largest change and the plots include \
only valid bands. The time of all runs is forecast before the first of them.

Results: effects.csv, effects.txt, and plots of the changes of the levels, effects_added.svg and \
effects_taken_away.svg.

Examples:
  tyrewave effects scenes/default.toml
  tyrewave effects scenes/default.toml --duration 10 --out trial";

#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct EffectsArguments {
    #[command(flatten)]
    place: Place,
    /// Duration of each variant after the warm-up, in s; default: the scene's, at most 3.
    #[arg(long, value_name = "SECONDS", value_parser = positive, allow_negative_numbers = true)]
    duration: Option<f64>,
}

impl EffectsArguments {
    pub(crate) fn execute(self, context: &Context) -> Result<(), CliError> {
        let mut side = self.place.open("effects", context)?;
        side.loaded.check_time_domain()?;
        let duration = self.duration.unwrap_or(side.loaded.scene.rolling.duration.min(LONGEST));
        let costs = calibrated(context.interrupt.flag())?;
        let comparison = effects::compare(&side.loaded, duration, &costs, context.job(&mut context.progress()))?;
        let mut report = report(&comparison);
        if let Some(cells) = effects::over_cells(&side.loaded, duration) {
            report.text(cells_instead(&comparison.all.plan, &cells, &costs, context));
        }
        side.file("effects.txt", report.to_string());
        side.file("effects.csv", comparison.csv());
        for (direction, name) in [
            (ComparisonDirection::Added, "effects_added.svg"),
            (ComparisonDirection::TakenAway, "effects_taken_away.svg"),
        ] {
            let title = format!("Levels, {}: {}", direction.title(), side.loaded.title());
            if let Some(plot) = plot(&comparison, direction, &title) {
                side.file(name, plot.to_svg());
            }
        }
        report.text("\n");
        side.finish(context, &report)
    }
}

/// Describes contact over cells in place of slices, with time and memory on this machine.
fn cells_instead(slices: &Plan, cells: &Plan, costs: &UnitCosts, context: &Context) -> String {
    let [slices, cells] = [slices, cells].map(|plan| plan.forecast(costs, context.threads, process_memory()));
    format!(
        "\ncontact over cells instead (contact.zone = \"cells\"): planned {:.0} s and {}, over slices {:.0} s and {}\n",
        cells.wall_seconds,
        bytes(cells.memory),
        slices.wall_seconds,
        bytes(slices.memory)
    )
}

/// The effects that change any level by as much as the tables show, 0.05 dB.
fn changing(comparison: &EffectComparison, direction: ComparisonDirection) -> Vec<(Effect, &Trial, &Trial)> {
    let mut runs = comparison.runs(direction);
    runs.retain(|(_, found, reference)| changes(found, reference).any(|(_, change)| change.abs() >= 0.05));
    runs
}

/// Change of the level of each band that is valid in both runs \[dB\].
fn valid_changes<'a>(found: &'a Trial, reference: &'a Trial) -> impl Iterator<Item = (BandLevel, f64)> {
    changes(found, reference).filter(|(band, _)| band.valid)
}

/// Change of the level of each band of `reference` \[dB\].
fn changes<'a>(found: &'a Trial, reference: &'a Trial) -> impl Iterator<Item = (BandLevel, f64)> {
    level_changes(&found.levels, &reference.levels)
}

/// Largest finite change of a band, in words; empty without any.
fn largest(changes: impl Iterator<Item = (BandLevel, f64)>) -> String {
    let largest = changes.filter(|(_, change)| change.is_finite()).max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
    largest.map_or(String::new(), |(band, change)| format!("{change:+.1} dB at {} Hz", band.band.label()))
}

fn report(comparison: &EffectComparison) -> Report {
    let row = |name: &str, found: &Trial, reference: Option<&Trial>| {
        let change = |value: f64, of: fn(&Trial) -> f64, unit: &str| match reference {
            Some(reference) => format!("{:+.1} {unit}", value * (of(found) - of(reference))),
            None => format!("{:.1} {unit}", value * of(found)),
        };
        let resistance = |found: &Trial| found.resistance().map(|resistance| resistance.force);
        let resisted = match (resistance(found), reference.map(resistance)) {
            (Some(now), Some(Some(before))) => format!("{:+.2} N", now - before),
            (Some(now), _) => format!("{now:.2} N"),
            (None, _) => "-".to_owned(),
        };
        let worst = reference.map_or(String::new(), |reference| largest(valid_changes(found, reference)));
        [
            name.to_owned(),
            change(1.0, Trial::mean_force, "N"),
            change(1e3, Trial::contact_length, "mm"),
            resisted,
            worst,
            format!("{:.2} s", found.seconds),
            bytes(found.memory()),
        ]
    };
    let rows = comparison.rolled().into_iter().map(|(name, found, reference)| row(&name, found, reference));
    let header = [
        "effects",
        "mean force",
        "patch",
        "rolling resistance",
        "largest change of a band",
        "steps",
        "memory, planned",
    ];
    let mut report = Report::from(aligned(header, rows));
    report.text("\n+ alone, compared with none; - all but this, compared with all\n");
    report.text("levels in brackets: bands that are not valid with the scene's settings\n");
    if comparison.uncertainties.iter().any(|(name, _)| name.ends_with("local compliance")) {
        report.text("local compliance: known within a factor of two; compared with all\n");
    }
    report.text(
        "rolling resistance: not defined without tread coupling, where displacements are not those of the tyre\n",
    );
    if comparison.all.results.friction.is_some() {
        report.text("rolling resistance with friction: by hysteresis and by slip\n");
    }
    for contribution in &comparison.effects {
        if let Err(reason) = &contribution.found {
            report.text(format!("{}: {reason}\n", contribution.effect.title));
        }
    }
    for (direction, name, base) in [
        (ComparisonDirection::Added, "none", &comparison.base),
        (ComparisonDirection::TakenAway, "all", &comparison.all),
    ] {
        let runs = changing(comparison, direction);
        let mut header = vec!["band [Hz]".to_owned(), format!("{name} [dB re 1 N]")];
        header.extend(runs.iter().map(|(effect, ..)| format!("{} {}", direction.sign(), effect.short)));
        let row = |(index, band): (usize, &BandLevel)| -> Vec<String> {
            let marked = |valid: bool, number: String| if valid { number } else { format!("({number})") };
            let change = |(_, found, reference): &(Effect, &Trial, &Trial)| {
                changes(found, reference)
                    .nth(index)
                    .map_or(String::new(), |(band, change)| marked(band.valid, format!("{change:+.1}")))
            };
            let first = [band.band.label(), marked(band.valid, format!("{:.1}", band.level))];
            first.into_iter().chain(runs.iter().map(change)).collect()
        };
        report.titled("\n", aligned(header, base.levels.iter().enumerate().map(row)));
    }
    if let Some(table) = receiver_table(comparison) {
        report.titled("\nSound with all effects, with all but one, and by another model:\n", table);
        report.text(
            "changes of levels: over the bands that are valid in both runs, which are listed if they are not all\n",
        );
    }
    report
}

/// Table of the levels at the receivers with all effects and of their changes; `None` without receivers.
fn receiver_table(comparison: &EffectComparison) -> Option<TextTable> {
    let EffectComparison { all, uncertainties, .. } = comparison;
    let of_all = all.receiver_levels();
    if of_all.is_empty() {
        return None;
    }
    let row = |name: String, found: &Trial, changed: bool| -> Vec<String> {
        let receiver_levels = found.receiver_levels();
        let mut cells = vec![name];
        for (rated, levels) in &of_all {
            let found = receiver_levels.iter().find(|(other, _)| other.name == rated.name);
            let change = found.map(|(other, found)| (change(other, rated), worst_of(found, levels)));
            let level = rated.level.as_ref();
            let bands = level.map_or_else(String::new, TotalLevel::range);
            cells.extend(match change {
                _ if !changed => {
                    [level.map_or(NO_PASSAGE.to_owned(), |level| format!("{} dB(A)", level.text())), bands]
                }
                Some((change, worst)) => [change, worst],
                None => ["silent".to_owned(), String::new()],
            });
        }
        let seconds = |stage| found.results.meter.whole(stage).seconds();
        cells.extend([format!("{:.2} s", seconds(Stage::Radiation)), format!("{:.2} s", seconds(Stage::Sound))]);
        cells
    };
    let mut rows = vec![row("all".to_owned(), all, false)];
    for (effect, found, _) in comparison.runs(ComparisonDirection::TakenAway) {
        rows.push(row(format!("- {}", effect.title), found, true));
    }
    rows.extend(uncertainties.iter().map(|(name, found)| row(name.clone(), found, true)));
    let mut header = vec!["effects".to_owned()];
    header.extend(of_all.iter().flat_map(|(rated, _)| [rated.label(), "worst band".to_owned()]));
    header.extend(["set-up", "in the steps"].map(str::to_owned));
    Some(aligned(header, rows))
}

/// Cell where there is no level to compare.
const NO_PASSAGE: &str = "no passage";

/// Change of a level over the bands that are valid in both runs, with these bands if they are not all.
fn change(found: &RatedLevel, reference: &RatedLevel) -> String {
    let Some((found, reference)) = found.level.as_ref().zip(reference.level.as_ref()) else {
        return NO_PASSAGE.to_owned();
    };
    match Compared::difference(found, reference) {
        Ok((change, None)) => format!("{change:+.1} dB(A)"),
        Ok((change, Some(bands))) => format!("{change:+.1} dB(A), {bands}"),
        Err(why) => why.to_string(),
    }
}

/// Largest change of a valid band, in words.
fn worst_of(found: &SoundLevels, reference: &SoundLevels) -> String {
    let changes = level_changes(&found.third_octaves, &reference.third_octaves)
        .filter(|(band, _)| band.valid && band.band.nominal_frequency() >= LOWEST_BAND);
    largest(changes)
}

/// Changes are drawn up to this \[dB\]: beside a change of thirty decibels one of three is invisible.
const LARGEST_DRAWN: f64 = 12.0;

/// Changes of the levels, for the effects that change any; `None` if there are none, or if the runs are too short for a
/// spectrum.
fn plot<'a>(comparison: &EffectComparison, direction: ComparisonDirection, title: &'a str) -> Option<LinePlot<'a>> {
    let points = |found, reference| -> Vec<(f64, f64)> {
        valid_changes(found, reference).map(|(band, change)| (band.band.mid_frequency(), change)).collect()
    };
    let runs = changing(comparison, direction).into_iter();
    let series: Vec<Series<'_>> = runs
        .map(|(effect, found, reference)| Series { name: effect.title, points: points(found, reference) })
        .collect();
    let drawn = || series.iter().flat_map(|series| &series.points).filter(|(_, change)| change.is_finite());
    drawn().next()?;
    let seen = drawn().map(|(_, change)| change.clamp(-LARGEST_DRAWN, LARGEST_DRAWN)).chain([0.0]);
    Some(LinePlot {
        title,
        x: Axis::logarithmic_around("Frequency [Hz]", drawn().map(|point| point.0), [0.9, 1.1]),
        y: Axis::linear_around("Change of the contact force level [dB]", seen),
        series: series.clone(),
    })
}
