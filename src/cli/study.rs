//! `tyrewave study`: accuracy against time of every knob of a scene.

use crate::plan::front::FrontRow;
use crate::results::plots::{Axis, WorkPrecisionPanel, WorkPrecisionPlot};
use crate::results::table::{self, Report, aligned, optional, row};
use crate::run::prepare::checked;
use crate::scene::{Contact, History, Numerics};
use crate::study::accuracy::{Knob, Study, StudyCost, StudyOptions, StudyPoint, Sweep, study};
use crate::study::trial::{LOWEST_BAND, RunDifference};
use crate::time_rule::Advance;
use clap::Args;
use serde_json::json;

use super::context::Context;
use super::error::CliError;
use super::options::positive;
use super::side::Place;

const EXAMPLES: &str = "\
Varies each numerical setting that trades accuracy for time, with all other settings at a fine reference: elements, \
steps, time rules, poles, cells across, curves. Errors are differences of third-octave levels of the contact force \
from 100 Hz to fmax, of the force itself, of the mean force, of the patch's length and of the rolling resistance. \
Errors below the uncertainty of the reference are marked. The front has the settings of least work for their error; \
work is counted exactly, and times are listed, too.

Without --whole the study is an outline: the scene's own settings and every second value of each setting are compared \
with a reference of twice the scene's elements, 24 steps in a period of fmax and poles to 1e-5. The whole study \
(--whole) has 48 steps in a period and poles to 5e-6, and rolls all values of each setting, by slices also the \
presets. The uncertainty of the reference is its difference from one that is half as fine.

Contributions of laws and effects: `tyrewave effects`. Errors of radiated sound: `tyrewave sweep` over \
radiation.nodes_per_wavelength, frequency_tolerance and lateral_waves.

An interrupted study keeps the results of its completed runs in FOLDER.partial.

Results: study.txt, study.csv, study.json, study.svg, study.html (a page of all).

Examples:
  tyrewave study scenes/default.toml
  tyrewave study scenes/default.toml --whole --duration 6 --out trial
  tyrewave study scenes/default.toml --check-presets --elements 2048";

#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct StudyArguments {
    #[command(flatten)]
    place: Place,
    /// Highest frequency compared, in Hz; default: the scene's fmax, or 1000.
    #[arg(long, value_name = "HZ", value_parser = positive, allow_negative_numbers = true)]
    fmax: Option<f64>,
    /// Duration that is compared, in s; default: the scene's, at most 1.
    #[arg(long, value_name = "SECONDS", value_parser = positive, allow_negative_numbers = true)]
    duration: Option<f64>,
    /// Vary everything: the presets, and all values of each setting.
    #[arg(long, conflicts_with = "check_presets")]
    whole: bool,
    /// Removed: `tyrewave sweep --set` runs combinations of settings.
    #[arg(long, hide = true)]
    runs: Option<String>,
    /// Check only the presets against the reference; exit code 1 if one exceeds its stated error.
    #[arg(long)]
    check_presets: bool,
    /// Elements of the reference; default: twice the scene's, or, if presets are compared, a quarter more than those of
    /// the finest preset.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(32..))]
    elements: Option<u32>,
    /// Steps per element of the reference; default: as many as give 24 steps in a period of fmax, with --whole 48.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(2..))]
    substeps: Option<u16>,
}

impl StudyArguments {
    pub(crate) fn execute(self, context: &Context) -> Result<(), CliError> {
        if self.runs.is_some() {
            let gone = "`study --runs` has been removed: `tyrewave sweep --set` runs combinations of settings";
            return Err(CliError::Usage(gone.to_owned()));
        }
        let mut side = self.place.open("study", context)?;
        let loaded = &side.loaded;
        loaded.check_time_domain()?;
        let sweep = match (self.whole, self.check_presets) {
            (_, true) => Sweep::Presets,
            (true, _) => Sweep::Knobs,
            _ => Sweep::Outline,
        };
        let mut options = StudyOptions::new(&loaded.scene, sweep);
        options.highest = self.fmax.unwrap_or(options.highest);
        options.duration = self.duration.unwrap_or(options.duration);
        (options.elements, options.substeps) =
            (self.elements.map(|count| count as usize), self.substeps.map(usize::from));
        if self.check_presets && FrontRow::finest_error(&loaded.scene, options.highest).is_none() {
            let wrong = format!("presets state no error up to {} Hz on this road", options.highest);
            return Err(CliError::Usage(format!("{wrong}: take a lower --fmax, 1000 at most on every road")));
        }
        let found = study(loaded, &options, context.job(&mut context.progress()))?;
        let mut report = report(&found);
        let plan = checked(loaded)?;
        if let Some(errors) = &plan.slice_errors {
            report.text(format!("\nApart from these errors: {}\n", plan.end_of_slices(errors).0));
        }
        let picture = picture(&found, &loaded.title()).map(|picture| picture.to_svg());
        side.file("study.txt", report.to_string());
        side.file("study.csv", csv(&found));
        side.file("study.json", format!("{:#}\n", json!({ "version": env!("CARGO_PKG_VERSION"), "study": found })));
        if let Some(picture) = picture {
            side.file(PICTURE[0], picture);
        }
        let lead = "Each setting that trades accuracy for time, the others at a fine reference.";
        let title = format!("Study: {}", side.loaded.title());
        side.page("study.html", [&title, lead], &[("Accuracy against time", &[PICTURE], &report)]);
        report.text("\n");
        if !found.complete {
            return side.keep(context, &report);
        }
        side.finish(context, &report)?;
        let failed = found.presets().filter(|(point, stated)| point.difference.worst > *stated);
        let failed: Vec<&str> = failed.map(|(point, _)| point.label.as_str()).collect();
        if self.check_presets && !failed.is_empty() {
            return Err(CliError::Failed(format!(
                "presets that do not keep their stated error: {}",
                failed.join(", ")
            )));
        }
        Ok(())
    }
}

/// The picture and its caption.
const PICTURE: [&str; 2] = [
    "study.svg",
    "Largest error of a third octave in dB against the work and the time for one second of rolling. A line is a \
     setting, its points are its values. Below the dashed line errors are smaller than the uncertainty of the \
     reference.",
];

type Measure = (&'static str, fn(&RunDifference) -> f64);

/// Quantities that are compared: name in tables, and value.
const MEASURES: [Measure; 6] = [
    ("worst [dB]", |difference| difference.worst),
    ("rms [dB]", |difference| difference.rms),
    ("force", |difference| difference.force),
    ("mean force", |difference| difference.mean_force),
    ("patch", |difference| difference.contact_length),
    ("rolling resistance", |difference| difference.rolling_resistance),
];

/// Texts of all measures; those below the uncertainty of the reference are marked.
fn errors(difference: &RunDifference, uncertainty: &RunDifference) -> [String; 6] {
    MEASURES.map(|(name, measure)| {
        let (value, uncertainty) = (measure(difference), measure(uncertainty));
        let mark = if value.abs() < uncertainty.abs() && value != 0.0 { "~" } else { "" };
        if name.ends_with("[dB]") { format!("{mark}{value:.2}") } else { format!("{mark}{value:.1e}") }
    })
}

/// Table of all points: label, errors, cost, and a mark for those on the front.
fn points_table(study: &Study) -> table::TextTable {
    let columns = ["at [Hz]", "multiply-adds/s", "march [s/s]", "fit [s]", "front"];
    let header: Vec<&str> = [""].into_iter().chain(MEASURES.map(|(name, _)| name)).chain(columns).collect();
    let rows = study.groups().map(|(knob, point)| {
        let StudyPoint { label, difference, cost, .. } = point;
        let band = Some(difference.worst_band).filter(|band| *band > 0.0);
        let none = if point.settings.numerics.history == History::Direct { "-" } else { "cached" };
        let fit = cost.fit.map_or(none.to_owned(), |fit| format!("{fit:.2}"));
        let front = if study.front.contains(point) { "*" } else { "" };
        let (work, march) = (format!("{:.2e}", cost.multiply_adds), format!("{:.3}", cost.march));
        let cost = [optional(band), work, march, fit, front.to_owned()];
        let label = knob.map_or_else(|| label.clone(), |knob| format!("{knob} {label}"));
        [label].into_iter().chain(errors(difference, &study.uncertainty)).chain(cost).collect::<Vec<_>>()
    });
    aligned(header, rows)
}

/// All tables of the study.
fn report(study: &Study) -> Report {
    let mut report = Report::default();
    if !study.complete {
        report.text(format!("INTERRUPTED after {} runs: these are their results.\n\n", study.runs));
    }
    let uncertainties = MEASURES.iter().zip(errors(&study.uncertainty, &RunDifference::default()));
    let uncertainties: Vec<String> = uncertainties.map(|((name, _), value)| format!("{name} {value}")).collect();
    report.text(format!(
        "Third octaves of the contact force from {LOWEST_BAND} to {} Hz over {} s, axle held\nreference: {}\n\
         uncertainty of the reference, from one half as fine: {}; smaller errors are marked ~\n",
        study.options.highest,
        study.options.duration,
        study.reference.settings.label(),
        uncertainties.join(", ")
    ));
    report.text("\nSettings of the discretisation, the rest at the reference; * marks the least work for an error:\n");
    report.table(points_table(study));
    for Knob { name, missing, .. } in study.knobs.iter().filter(|knob| knob.missing.is_some()) {
        report.text(format!("{name}: {}\n", optional(missing.as_ref())));
    }
    study.named.iter().for_each(|point| report.text(format!("{}: {}\n", point.label, point.settings.label())));
    for (point, stated) in study.presets() {
        let verdict = if point.difference.worst <= stated { "holds" } else { "does not hold" };
        report.text(format!("{}: stated error {stated} dB {verdict}\n", point.label));
    }
    report
}

/// All points, one per line.
fn csv(study: &Study) -> String {
    let header = "group,point,elements,substeps,elements_per_step,time_rule,pole_tolerance,cells_across,\
                  slice_tolerance_m,worst_db,worst_band_hz,rms_db,force,mean_force,contact_length,rolling_resistance,\
                  multiply_adds_per_s,march_s_per_s,road_s_per_s,fit_s,on_front";
    let line = |(group, point): (Option<&str>, &StudyPoint)| {
        let StudyPoint { label, settings, difference, cost } = point;
        let Numerics { elements, time_rule, pole_tolerance, .. } = &settings.numerics;
        let Advance { substeps, elements_per_step } = settings.numerics.advance();
        let Contact { cells_across, slice_tolerance, .. } = &settings.contact;
        let RunDifference { worst, worst_band, rms, force, mean_force, contact_length, rolling_resistance } =
            difference;
        let StudyCost { multiply_adds, march, road, fit } = cost;
        let (rule, cells, on_front) = (time_rule.name(), optional(*cells_across), study.front.contains(point));
        let of_settings = row([
            &group.unwrap_or("named"),
            label,
            elements,
            &substeps,
            &elements_per_step,
            &rule,
            pole_tolerance,
            &cells,
            slice_tolerance,
        ]);
        let of_errors = row([worst, worst_band, rms, force, mean_force, contact_length, rolling_resistance]);
        [of_settings, of_errors, row([multiply_adds, march, road, &optional(*fit), &on_front])].concat()
    };
    table::csv(header.split(','), [(Some("reference"), &study.reference)].into_iter().chain(study.groups()).map(line))
}

/// Errors against work and against time; `None` for a study without errors yet.
fn picture<'a>(study: &'a Study, title: &'a str) -> Option<WorkPrecisionPlot<'a>> {
    let drawn: Vec<&Knob> = study.knobs.iter().filter(|knob| !knob.points.is_empty()).collect();
    let largest = study.points().map(|point| point.difference.worst).fold(0.0, f64::max);
    if largest == 0.0 {
        return None;
    }
    // A decade below the uncertainty is shown.
    let smallest = (0.1 * study.uncertainty.worst).clamp(1e-3 * largest, 0.5 * largest);
    let panel = |title: &str, cost: fn(&StudyPoint) -> f64| {
        let at = |point: &StudyPoint| (cost(point), point.difference.worst);
        let costs = study.points().map(cost).filter(|cost| *cost > 0.0);
        WorkPrecisionPanel {
            cost: Axis::logarithmic_around(title, costs, [0.75, 1.35]),
            knobs: drawn.iter().map(|knob| knob.points.iter().map(at).collect()).collect(),
            front: study.front.iter().map(at).collect(),
            marks: study.named.iter().map(|point| (point.label.as_str(), at(point))).collect(),
        }
    };
    Some(WorkPrecisionPlot {
        title,
        error: Axis::logarithmic("Largest error of a third octave [dB]", smallest..1.3 * largest),
        knobs: drawn.iter().map(|knob| knob.name).collect(),
        uncertainty: study.uncertainty.worst,
        panels: vec![
            panel("Multiply-adds per second of rolling", |point| point.cost.multiply_adds),
            panel("Time of the steps per second of rolling [s]", |point| point.cost.march),
        ],
    })
}
