//! `tyrewave study`: accuracy against time of every knob of a scene.

use crate::plan::front::FrontRow;
use crate::results::plots::{Axis, WorkPrecisionPanel, WorkPrecisionPlot};
use crate::results::sound::BodySummary;
use crate::results::table::{self, Report, Table, aligned, optional, row, words};
use crate::run::prepare::checked;
use crate::scene::{Contact, Numerics, Scene};
use crate::study::accuracy::verdict::{LARGEST_EXCESS, Verdict, verdicts};
use crate::study::accuracy::{
    Cost, Joint, Kind, Knob, Point, Richardson, SoundDifference, SoundPoint, SoundStudy, Study, StudyOptions, Sweep,
    study,
};
use crate::study::trial::{Difference, LOWEST_BAND};
use clap::Args;

use super::context::Context;
use super::error::CliError;
use super::options::positive;
use super::side::Place;

const EXAMPLES: &str = "\
Varies each numerical setting that trades accuracy for time, with all other settings at a fine reference: elements, \
steps, time rules, poles, cells across, curves. Errors are differences of third-octave levels of the contact force \
from 100 Hz to fmax, of the force itself, of the mean force, of the patch's length and of the rolling resistance. \
Errors below the uncertainty of the reference (its doubt) are marked. The front has the settings of least work for \
their error; work is counted exactly, and times are listed, too.

Without --whole the study is an outline: the scene's own settings and every second value of each setting are compared \
with a reference of twice the scene's elements, 24 steps in a period of fmax and poles to 1e-5. The doubt is the whole \
difference between this reference and one that is half as fine.

The whole study (--whole) has 48 steps in a period and poles to 5e-6, rolls all values of each setting, also those \
that only the direct history has, and takes the doubt from references half and twice as fine. It also rolls the \
presets, and other laws of tread and slices; these laws are listed apart, since they are other models. Then \
combinations of settings are chosen by their expected error and rolled, and the expectation is corrected (--runs). If \
the scene has receivers, the sound of one run's forces is computed with finer and coarser radiation: errors in dB(A) \
and of third octaves against nodes per wavelength, frequencies and lateral waves.

An interrupted study keeps the results of its completed runs in FOLDER.partial.

Results: study.txt, study.csv, study.json, study.svg, study.html (a page of all); with receivers and --whole also \
study_sound.csv.

Examples:
  tyrewave study scenes/default.toml
  tyrewave study scenes/default.toml --whole --duration 6 --runs 40 --out trial
  tyrewave study scenes/default.toml --check-presets
  tyrewave study scenes/default.toml --elements 2048 --substeps 8";

#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct StudyArguments {
    #[command(flatten)]
    place: Place,
    /// Highest frequency compared, in Hz; default: the scene's fmax, or 1000.
    #[arg(long, value_name = "HZ", value_parser = positive)]
    fmax: Option<f64>,
    /// Duration that is compared, in s; default: the scene's, at most 1.
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    duration: Option<f64>,
    /// Study everything: presets, all values of each setting, laws, combinations, and the radiation of sound.
    #[arg(long, conflicts_with = "check_presets")]
    whole: bool,
    /// Number of combinations of settings that are rolled; default: 12 with --whole, otherwise 0.
    #[arg(long, value_name = "N")]
    runs: Option<u16>,
    /// Check only the presets, and settings close to them, against the reference; exit code 1 if a preset exceeds its
    /// stated error, or is not on the front.
    #[arg(long)]
    check_presets: bool,
    /// Elements of the reference; default: twice the scene's, or, if presets are rolled, a quarter more than those of
    /// the finest preset.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(32..))]
    elements: Option<u32>,
    /// Steps per element of the reference; default: as many as give 24 steps in a period of fmax, with --whole 48.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(2..))]
    substeps: Option<u16>,
}

impl StudyArguments {
    pub(crate) fn execute(self, context: &Context) -> Result<(), CliError> {
        let mut side = self.place.open("study", context)?;
        let loaded = &side.loaded;
        loaded.check_time_domain()?;
        let scene = &loaded.scene;
        let defaults = if self.whole { StudyOptions::whole(scene) } else { StudyOptions::outline(scene) };
        let options = StudyOptions {
            highest: self.fmax.unwrap_or(defaults.highest),
            duration: self.duration.unwrap_or(defaults.duration),
            runs: if self.check_presets { 0 } else { self.runs.map_or(defaults.runs, usize::from) },
            sweep: if self.check_presets { Sweep::Neighbours } else { defaults.sweep },
            // A multiple of 16: all fractions that are swept are even.
            elements: self.elements.map(|elements| (elements as usize).div_ceil(16) * 16),
            substeps: self.substeps.map(usize::from),
        };
        if self.check_presets && FrontRow::finest_error(scene, options.highest).is_none() {
            let wrong = format!("presets state no error up to {} Hz on this road", options.highest);
            return Err(CliError::Usage(format!("{wrong}: take a lower --fmax, 1000 at most on every road")));
        }
        let mut progress = context.progress();
        let found = study(loaded, &options, context.interrupt.flag(), &mut progress)?;
        drop(progress);
        let verdicts = verdicts(&found);
        let mut report = report(&found, &loaded.scene);
        if !verdicts.is_empty() {
            report.text("\nPresets:\n");
            report.table(verdict_table(&verdicts));
        }
        let plan = checked(loaded)?;
        if let Some(errors) = &plan.slice_errors {
            report.text(format!("\nApart from these errors: {}\n", plan.end_of_slices(errors).0));
        }
        let picture = picture(&found, &loaded.title()).map(|picture| picture.to_svg());
        side.file("study.txt", report.to_string());
        side.file("study.csv", csv(&found));
        side.file("study.json", json(&found));
        if let Some(sound) = &found.sound {
            side.file("study_sound.csv", sound_csv(sound));
        }
        if let Some(picture) = picture {
            side.file(PICTURE[0], picture);
        }
        let lead = "Every setting that trades accuracy for time, the others at a fine reference. Errors are \
                    differences of the contact force from that of the reference; those below the doubt about it are \
                    marked ~.";
        let title = format!("Study: {}", side.loaded.title());
        side.page("study.html", [&title, lead], &[("Accuracy against time", &[PICTURE], &report)]);
        report.text("\n");
        if !found.complete {
            return side.keep(context, &report);
        }
        side.finish(context, &report)?;
        let fails = |verdict: &&Verdict| !(verdict.keeps_its_error() && verdict.is_on_the_front());
        let failed: Vec<&str> = verdicts.iter().filter(fails).map(|verdict| verdict.preset.name()).collect();
        if !self.check_presets || failed.is_empty() {
            return Ok(());
        }
        let wrong = "presets that do not keep their stated error or are not on the front";
        Err(CliError::Failed(format!("{wrong}: {}", failed.join(", "))))
    }
}

/// The picture and its caption.
const PICTURE: [&str; 2] = [
    "study.svg",
    "Largest error of a third octave in dB against the work and against the time of a second rolled. A line is a \
     setting, its points are its values. No point has both less work and a smaller error than those on the front. \
     Below the dashed line errors are smaller than the doubt about the reference.",
];

const HEADER: [&str; 11] = [
    "",
    "worst [dB]",
    "at [Hz]",
    "rms [dB]",
    "force",
    "mean force",
    "patch",
    "rolling resistance",
    "multiply-adds/s",
    "march [s/s]",
    "fit [s]",
];

/// Marks a number that is below the reference's uncertainty.
fn told(value: f64, doubt: f64, text: String) -> String {
    if value.abs() < doubt && value != 0.0 { format!("~{text}") } else { text }
}

fn cells(label: String, point: &Point, doubt: &Difference) -> [String; 11] {
    let Point { difference: found, cost, .. } = point;
    let fixed = |value: f64, doubt: f64, digits: usize| told(value, doubt, format!("{value:.digits$}"));
    let small = |value: f64, doubt: f64| told(value, doubt, format!("{value:.1e}"));
    [
        label,
        fixed(found.worst, doubt.worst, 2),
        if found.worst > 0.0 { format!("{}", found.worst_band) } else { String::new() },
        fixed(found.rms, doubt.rms, 2),
        fixed(found.force, doubt.force, 3),
        small(found.mean_force, doubt.mean_force),
        small(found.contact_length, doubt.contact_length),
        small(found.rolling_resistance, doubt.rolling_resistance),
        format!("{:.2e}", cost.multiply_adds),
        format!("{:.3}", cost.march),
        cost.fit.map_or("kept".to_owned(), |fit| format!("{fit:.2}")),
    ]
}

/// All tables of the study.
fn report(study: &Study, scene: &Scene) -> Report {
    let Study { options, reference, doubt, .. } = study;
    let mut report = Report::default();
    if !study.complete {
        report.text(format!("INTERRUPTED after {} runs: this is what they gave.\n\n", study.rolled));
    }
    if options.sweep == Sweep::Outline {
        report.text(
            "An outline: a whole study (--whole) has a finer reference and more settings, presets, combinations, laws, \
             and ways of the sound.\n\n",
        );
    }
    report.text(format!(
        "Third octaves of the contact force from {LOWEST_BAND} to {} Hz over {} s, axle held; {} threads\n\
         reference: {}\n\n\
         How sure the reference is: the same with a setting halved and doubled, the order that shows, the error that \
         is left; without a doubled one, all of the difference:\n",
        options.highest,
        options.duration,
        study.threads,
        reference.settings.label(scene)
    ));
    let mut refined: Vec<[String; 6]> = Vec::new();
    for of in &study.refined {
        let measures = [
            (of.knob, "worst [dB]", of.worst),
            ("", "rms [dB]", of.rms),
            ("", "force", of.force),
            ("", "mean force", of.mean_force),
            ("", "patch", of.contact_length),
            ("", "rolling resistance", of.rolling_resistance),
        ];
        refined.extend(measures.map(|(knob, currency, Richardson { coarse, fine, order, error, converges })| {
            let order = match order {
                Some(order) if converges => format!("{order:.1}"),
                Some(order) => format!("{order:.1}, not converged"),
                None if fine.is_none() => "-".to_owned(),
                None => "exact".to_owned(),
            };
            let fine = fine.map_or("-".to_owned(), |value| format!("{value:.2e}"));
            let [coarse, error] = [coarse, error].map(|value| format!("{value:.2e}"));
            [knob.to_owned(), currency.to_owned(), coarse, fine, order, error]
        }));
    }
    report.table(words(["", "difference of", "halved", "doubled", "order", "left"], refined));
    report.text(format!(
        "doubt: {:.2} dB worst, {:.2} dB rms, force {:.2e}, mean force {:.1e}, patch {:.1e}, \
         rolling resistance {:.1e}; smaller errors are marked ~\n",
        doubt.worst, doubt.rms, doubt.force, doubt.mean_force, doubt.contact_length, doubt.rolling_resistance
    ));
    for (kind, title) in [
        (Kind::Error, "Settings of the discretisation, the rest at the reference"),
        (Kind::Neighbour, "Settings around the presets"),
        (Kind::Model, "Laws: another model, not an error"),
    ] {
        let knobs: Vec<&Knob> = study.knobs.iter().filter(|knob| knob.kind == kind).collect();
        if knobs.is_empty() {
            continue;
        }
        let points = knobs.iter().flat_map(|knob| knob.points.iter().map(move |point| (&knob.name, point)));
        let rows = points.map(|(name, point)| cells(format!("{name} {}", point.label), point, doubt));
        report.text(format!("\n{title}:\n"));
        report.table(aligned(HEADER, rows));
        for Knob { name, missing, anchor, .. } in knobs {
            if let Some(reason) = missing {
                report.text(format!("{name}: {reason}\n"));
            }
            if let Some(anchor) = anchor {
                report.text(format!("{name}: compared with {}\n", anchor.label(scene)));
            }
        }
    }
    if !study.joint.is_empty() {
        let row = |Joint { point, expected, .. }: &Joint| {
            let worst = point.difference.worst;
            [
                point.settings.label(scene),
                format!("{:.2}", expected.error),
                told(worst, doubt.worst, format!("{worst:.2}")),
                format!("{:.2e}", expected.multiply_adds),
                format!("{:.2e}", point.cost.multiply_adds),
                format!("{:.3}", point.cost.march),
            ]
        };
        let header = ["", "expected [dB]", "found [dB]", "expected work/s", "found work/s", "march [s/s]"];
        report.text("\nCombinations, in the order of their choice:\n");
        report.table(aligned(header, study.joint.iter().map(row)));
    }
    for (title, points) in [("Settings with a name", &study.named), ("Front, by exact work", &study.front)] {
        if points.is_empty() {
            continue;
        }
        report.text(format!("\n{title}:\n"));
        report.table(aligned(HEADER, points.iter().map(|point| cells(point.label.clone(), point, doubt))));
        points.iter().for_each(|point| report.text(format!("{}: {}\n", point.label, point.settings.label(scene))));
    }
    if let Some(sound) = &study.sound {
        report.text(format!("\nSound, the same forces, against {}:\n", sound.reference.label));
        report.table(sound_table(sound));
    }
    report
}

/// Errors of the sound, for the receiver with the largest.
fn sound_table(sound: &SoundStudy) -> Table {
    let row = |point: &SoundPoint| -> [String; 8] {
        let worst = point.worst();
        let BodySummary { frequencies, solved, unknowns, .. } = &point.body;
        let all_kept = *solved == 0;
        [
            point.label.clone(),
            worst.map_or("reference".to_owned(), |worst| format!("{:.2}", worst.worst)),
            worst.map_or(String::new(), |worst| worst.worst_band.to_string()),
            worst.map_or(String::new(), |worst| worst.receiver.clone()),
            point.level_a(),
            frequencies.to_string(),
            if all_kept { "kept".to_owned() } else { unknowns.to_string() },
            if all_kept { "kept".to_owned() } else { format!("{:.1}", point.seconds) },
        ]
    };
    let rows = std::iter::once(&sound.reference).chain(&sound.points).map(row);
    aligned(["", "worst [dB]", "at [Hz]", "receiver", "[dB(A)]", "frequencies", "unknowns", "set-up [s]"], rows)
}

/// Errors of the sound by receiver.
fn sound_csv(sound: &SoundStudy) -> String {
    let header = ["way", "receiver", "worst_db", "worst_band_hz", "level_db_a", "frequencies", "solved", "set_up_s"];
    let rows = sound.points.iter().flat_map(|SoundPoint { label, differences, body, seconds }| {
        differences.iter().map(move |SoundDifference { receiver, worst, worst_band, level_a }| {
            let level_a = optional(*level_a);
            row([label, receiver, worst, worst_band, &level_a, &body.frequencies, &body.solved, seconds])
        })
    });
    table::csv(header, rows)
}

/// Stated and found errors of the presets.
fn verdict_table(verdicts: &[Verdict]) -> Table {
    let row = |verdict: &Verdict| {
        let words = match (verdict.keeps_its_error(), verdict.is_on_the_front()) {
            (true, true) => "holds".to_owned(),
            (false, _) => "does not keep its error".to_owned(),
            (true, false) => format!("more than {LARGEST_EXCESS} times the front's work"),
        };
        let Verdict { preset, stated, found, excess } = verdict;
        [preset.name().to_owned(), format!("{stated:.2}"), format!("{found:.2}"), format!("{excess:.2}"), words]
    };
    aligned(["", "stated [dB]", "found [dB]", "work / front's", ""], verdicts.iter().map(row))
}

/// All points, one per line.
fn csv(study: &Study) -> String {
    let header = "group,point,elements,substeps,time_rule,pole_tolerance,cells_across,slice_tolerance_m,worst_db,\
                  worst_band_hz,rms_db,force,mean_force,contact_length,rolling_resistance,multiply_adds_per_s,\
                  compliance_evaluations,march_s_per_s,road_s_per_s,fit_s,expected_db,on_front";
    let line = |group: &str, point: &Point, expected: Option<f64>| {
        let Point { label, settings, difference, cost } = point;
        let Numerics { elements, substeps, time_rule, pole_tolerance, .. } = &settings.numerics;
        let Contact { cells_across, slice_tolerance, .. } = &settings.contact;
        let Difference { worst, worst_band, rms, force, mean_force, contact_length, rolling_resistance } = difference;
        let Cost { multiply_adds, compliance_evaluations, march, road, fit } = cost;
        let (rule, cells, on_front) = (time_rule.name(), optional(*cells_across), study.front.contains(point));
        let of_settings = row([&group, label, elements, substeps, &rule, pole_tolerance, &cells, slice_tolerance]);
        let of_errors = row([worst, worst_band, rms, force, mean_force, contact_length, rolling_resistance]);
        let of_cost = row([multiply_adds, compliance_evaluations, march, road, &optional(*fit)]);
        [of_settings, of_errors, of_cost, row([&optional(expected), &on_front])].concat()
    };
    let knobs = study.knobs.iter().flat_map(|knob| knob.points.iter().map(|point| line(&knob.name, point, None)));
    let joint = study.joint.iter().map(|joint| line("combination", &joint.point, Some(joint.expected.error)));
    let named = study.named.iter().map(|point| line("named", point, None));
    table::csv(
        header.split(','),
        [line("reference", &study.reference, None)].into_iter().chain(knobs).chain(joint).chain(named),
    )
}

/// Everything as JSON, for programs.
fn json(study: &Study) -> String {
    format!("{:#}\n", serde_json::json!({ "version": env!("CARGO_PKG_VERSION"), "study": study }))
}

/// Lower end of the picture's errors over the reference's uncertainty.
const BELOW_DOUBT: f64 = 0.1;

/// Errors against work and against time; `None` for a study without errors yet.
fn picture<'a>(study: &'a Study, title: &'a str) -> Option<WorkPrecisionPlot<'a>> {
    let drawn = |knob: &&Knob| knob.kind == Kind::Error && knob.anchor.is_none() && !knob.points.is_empty();
    let drawn: Vec<&Knob> = study.knobs.iter().filter(drawn).collect();
    let close = || study.knobs.iter().filter(|knob| knob.kind == Kind::Neighbour).flat_map(|knob| &knob.points);
    let largest = study.points().map(|point| point.difference.worst).fold(0.0, f64::max);
    if largest == 0.0 {
        return None;
    }
    let smallest = (BELOW_DOUBT * study.doubt.worst).clamp(1e-3 * largest, 0.5 * largest);
    let error = Axis::logarithmic("Largest error of a third octave [dB]", smallest..1.3 * largest);
    let panel = |title: &str, cost: fn(&Point) -> f64| {
        let at = |point: &Point| (cost(point), point.difference.worst);
        let costs = study.points().map(cost).filter(|cost| *cost > 0.0);
        WorkPrecisionPanel {
            cost: Axis::logarithmic_around(title, costs, [0.75, 1.35]),
            knobs: drawn.iter().map(|knob| knob.points.iter().map(at).collect()).collect(),
            points: study.joint.iter().map(|joint| &joint.point).chain(close()).map(at).collect(),
            front: study.front.iter().map(at).collect(),
            marks: study.named.iter().map(|point| (point.label.as_str(), at(point))).collect(),
        }
    };
    Some(WorkPrecisionPlot {
        title,
        error,
        knobs: drawn.iter().map(|knob| knob.name.as_str()).collect(),
        doubt: study.doubt.worst,
        panels: vec![
            panel("Multiply-adds in a second rolled", |point| point.cost.multiply_adds),
            panel("Time of the march for a second rolled [s]", |point| point.cost.march),
        ],
    })
}
