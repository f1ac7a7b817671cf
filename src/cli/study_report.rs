//! What a study found, as tables, CSV, JSON and a picture.

use tyrewave::results::PlotError;
use tyrewave::results::plots::{Axis, Mark, WorkPrecisionPanel, WorkPrecisionPlot};
use tyrewave::results::table::{aligned, words};
use tyrewave::scene::Scene;
use tyrewave::study::accuracy::presets::{LARGEST_EXCESS, Verdict};
use tyrewave::study::accuracy::{Kind, Point, Richardson, Study, Swept};
use tyrewave::study::compare::{Difference, LOWEST_BAND};

const HEADER: [&str; 10] = [
    "",
    "worst [dB]",
    "at [Hz]",
    "rms [dB]",
    "force",
    "mean force",
    "patch",
    "multiply-adds/s",
    "march [s/s]",
    "fit [s]",
];

/// A number, marked where it is below the doubt.
fn told(value: f64, doubt: f64, digits: usize) -> String {
    let mark = if value.abs() < doubt && value != 0.0 { "~" } else { "" };
    format!("{mark}{value:.digits$}")
}

fn small(value: f64, doubt: f64) -> String {
    let mark = if value.abs() < doubt && value != 0.0 { "~" } else { "" };
    format!("{mark}{value:.1e}")
}

fn row(label: String, point: &Point, doubt: &Difference) -> [String; 10] {
    let Point { difference: found, cost, .. } = point;
    [
        label,
        told(found.worst, doubt.worst, 2),
        if found.worst > 0.0 { format!("{}", found.worst_band) } else { String::new() },
        told(found.rms, doubt.rms, 2),
        told(found.force, doubt.force, 3),
        small(found.mean_force, doubt.mean_force),
        small(found.contact_length, doubt.contact_length),
        format!("{:.2e}", cost.multiply_adds),
        format!("{:.3}", cost.march),
        cost.fit.map_or("kept".to_owned(), |fit| format!("{fit:.2}")),
    ]
}

/// The tables.
pub(super) fn text(study: &Study, scene: &Scene) -> String {
    let Study { options, reference, doubt, .. } = study;
    let mut text = format!(
        "Third octaves of the contact force from {LOWEST_BAND} to {} Hz over {} s, axle held; {} threads\n\
         reference: {}\n\nHow sure the reference is: the same with a knob halved and doubled, the order that shows, the error that is left:\n",
        options.highest,
        options.duration,
        study.threads,
        reference.settings.label(scene)
    );
    let refined: Vec<[String; 6]> = study
        .refined
        .iter()
        .flat_map(|refined| {
            let row = |knob: &str, currency: &str, found: &Richardson| {
                let order = match found.order {
                    Some(order) if found.converges => format!("{order:.1}"),
                    Some(order) => format!("{order:.1}, not converged"),
                    None => "exact".to_owned(),
                };
                let [coarse, fine, error] = [found.coarse, found.fine, found.error].map(|value| format!("{value:.2e}"));
                [knob.to_owned(), currency.to_owned(), coarse, fine, order, error]
            };
            [
                row(refined.knob, "worst [dB]", &refined.worst),
                row("", "rms [dB]", &refined.rms),
                row("", "force", &refined.force),
                row("", "mean force", &refined.mean_force),
                row("", "patch", &refined.contact_length),
            ]
        })
        .collect();
    text.push_str(&words(&["", "difference of", "halved", "doubled", "order", "left"], &refined));
    text.push_str(&format!(
        "doubt: {:.2} dB worst, {:.2} dB rms, force {:.2e}, mean force {:.1e}, patch {:.1e}; smaller errors are marked ~\n",
        doubt.worst, doubt.rms, doubt.force, doubt.mean_force, doubt.contact_length
    ));
    for (kind, title) in [
        (Kind::Error, "Knobs of the discretisation, the rest at the reference"),
        (Kind::Neighbour, "Settings around the presets"),
        (Kind::Model, "Laws: another model, not an error"),
    ] {
        if study.knobs.iter().all(|knob| knob.kind != kind) {
            continue;
        }
        let mut rows = Vec::new();
        for knob in study.knobs.iter().filter(|knob| knob.kind == kind) {
            rows.extend(knob.points.iter().map(|point| row(format!("{} {}", knob.name, point.label), point, doubt)));
        }
        text.push_str(&format!("\n{title}:\n{}", aligned(&HEADER, &rows)));
        for Swept { name, missing, anchor, .. } in study.knobs.iter().filter(|knob| knob.kind == kind) {
            if let Some(reason) = missing {
                text.push_str(&format!("{name}: {reason}\n"));
            }
            if let Some(anchor) = anchor {
                text.push_str(&format!("{name}: compared with {}\n", anchor.label(scene)));
            }
        }
    }
    if !study.joint.is_empty() {
        let rows: Vec<[String; 6]> = study
            .joint
            .iter()
            .map(|joint| {
                let Point { settings, difference, cost, .. } = &joint.point;
                [
                    settings.label(scene),
                    format!("{:.2}", joint.expected_error),
                    told(difference.worst, doubt.worst, 2),
                    format!("{:.2e}", joint.expected_multiply_adds),
                    format!("{:.2e}", cost.multiply_adds),
                    format!("{:.3}", cost.march),
                ]
            })
            .collect();
        let header = ["", "expected [dB]", "found [dB]", "expected work/s", "found work/s", "march [s/s]"];
        text.push_str(&format!("\nCombinations, in the order of their choice:\n{}", aligned(&header, &rows)));
    }
    for (title, points) in [("Settings with a name", &study.named), ("Front, by exact work", &study.front)] {
        let rows: Vec<[String; 10]> = points.iter().map(|point| row(point.label.clone(), point, doubt)).collect();
        text.push_str(&format!("\n{title}:\n{}", aligned(&HEADER, &rows)));
        for point in points {
            text.push_str(&format!("{}: {}\n", point.label, point.settings.label(scene)));
        }
    }
    text
}

/// What the presets state and what was found.
pub(super) fn verdict_table(verdicts: &[Verdict]) -> String {
    let row = |verdict: &Verdict| {
        let words = match (verdict.keeps_its_error(), verdict.is_on_the_front()) {
            (true, true) => "holds".to_owned(),
            (false, _) => "does not keep its error".to_owned(),
            (true, false) => format!("more than {LARGEST_EXCESS} times the front's work"),
        };
        let Verdict { preset, stated, found, excess } = verdict;
        [preset.name().to_owned(), format!("{stated:.2}"), format!("{found:.2}"), format!("{excess:.2}"), words]
    };
    let rows: Vec<[String; 5]> = verdicts.iter().map(row).collect();
    format!("\nPresets:\n{}", aligned(&["", "stated [dB]", "found [dB]", "work / front's", ""], &rows))
}

/// All points, one a line.
pub(super) fn csv(study: &Study) -> String {
    let mut text = String::from(
        "group,point,elements,substeps,time_rule,pole_tolerance,cells_across,slice_tolerance_m,worst_db,worst_band_hz,rms_db,force,mean_force,contact_length,\
         multiply_adds_per_s,compliance_evaluations,march_s_per_s,road_s_per_s,fit_s,expected_db,on_front\n",
    );
    let mut line = |group: &str, point: &Point, expected: Option<f64>| {
        let Point { label, settings, difference: found, cost } = point;
        let on_front = study.front.iter().any(|other| other == point);
        let option = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
        text.push_str(&format!(
            "{group},{label},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{on_front}\n",
            settings.elements,
            settings.substeps,
            settings.time_rule.name(),
            settings.pole_tolerance,
            option(settings.cells_across.map(|points| points as f64)),
            settings.slice_tolerance,
            found.worst,
            found.worst_band,
            found.rms,
            found.force,
            found.mean_force,
            found.contact_length,
            cost.multiply_adds,
            cost.compliance_evaluations,
            cost.march,
            cost.road,
            option(cost.fit),
            option(expected),
        ));
    };
    line("reference", &study.reference, None);
    for knob in &study.knobs {
        knob.points.iter().for_each(|point| line(&knob.name, point, None));
    }
    study.joint.iter().for_each(|joint| line("combination", &joint.point, Some(joint.expected_error)));
    study.named.iter().for_each(|point| line("named", point, None));
    text
}

/// Everything, for programs.
pub(super) fn json(study: &Study) -> String {
    format!("{:#}\n", serde_json::json!({ "version": env!("CARGO_PKG_VERSION"), "study": study }))
}

/// How far below the doubt the picture reaches.
const BELOW_DOUBT: f64 = 0.1;

/// Errors against work and against time.
pub(super) fn picture(study: &Study, title: &str) -> Result<String, PlotError> {
    let drawn: Vec<&Swept> = study
        .knobs
        .iter()
        .filter(|knob| knob.kind == Kind::Error && knob.anchor.is_none() && !knob.points.is_empty())
        .collect();
    let close = || study.knobs.iter().filter(|knob| knob.kind == Kind::Neighbour).flat_map(|knob| &knob.points);
    let largest = study.points().map(|point| point.difference.worst).fold(0.0, f64::max);
    let error = Axis::logarithmic(
        "Largest error of a third octave [dB]",
        (BELOW_DOUBT * study.doubt.worst).max(1e-3 * largest)..1.3 * largest,
    );
    let panel = |title: &str, cost: &dyn Fn(&Point) -> f64| {
        let at = |point: &Point| (cost(point), point.difference.worst);
        let costs = || study.points().map(cost).filter(|cost| *cost > 0.0);
        let (low, high) = costs().fold((f64::MAX, 0.0_f64), |(low, high), cost| (low.min(cost), high.max(cost)));
        WorkPrecisionPanel {
            cost: Axis::logarithmic(title, 0.75 * low..1.35 * high),
            knobs: drawn.iter().map(|knob| knob.points.iter().map(at).collect()).collect(),
            points: study.joint.iter().map(|joint| &joint.point).chain(close()).map(at).collect(),
            front: study.front.iter().map(at).collect(),
            marks: study.named.iter().map(|point| Mark { name: &point.label, at: at(point) }).collect(),
        }
    };
    let plot = WorkPrecisionPlot {
        title,
        error,
        knobs: drawn.iter().map(|knob| knob.name.as_str()).collect(),
        doubt: study.doubt.worst,
        panels: vec![
            panel("Multiply-adds in a second rolled", &|point| point.cost.multiply_adds),
            panel("Time of the march for a second rolled [s]", &|point| point.cost.march),
        ],
    };
    plot.to_svg()
}
