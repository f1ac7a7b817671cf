//! `tyrewave rules`: the time rules side by side for a scene.

use std::f64::consts::PI;

use crate::counters::Stage;
use crate::plan::Plan;
use crate::results::plots::{Axis, LinePlot, Series};
use crate::results::table::{Report, aligned, words};
use crate::run::Progress;
use crate::scene::TimeRule;
use crate::study::rules::{RuleReport, WorkPoint, WorkPrecision, compare, work_precision};
use clap::Args;
use num_complex::Complex64;
use serde_json::json;

use super::context::Context;
use super::error::CliError;
use super::options::positive;
use super::side::Place;

const EXAMPLES: &str = "\
Damping and phase error say what a rule makes of a mode: a decay that is not the tyre's, relative to the angular \
frequency, and a shift of its frequency. Unstable: the discrete inverse has zeros inside the unit disk and `run` \
refuses the rule. Results: rules.csv, damping.svg, phase.svg and, with --work, work.csv and work.svg.

Examples:
  tyrewave rules scenes/default.toml                     table and plots at the scene's time step
  tyrewave rules scenes/default.toml --work              and forces against a fine reference
  tyrewave rules scenes/default.toml --work --substeps 1,2,4,8 --highest 3000";

/// Rules whose forces are compared.
const COMPARED: [TimeRule; 5] =
    [TimeRule::Bdf1, TimeRule::Bdf2, TimeRule::Trapezoidal, TimeRule::Sdirk2, TimeRule::Sdirk3];
/// Number of points of the curves.
const POINTS: u32 = 200;

#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct RulesArguments {
    #[command(flatten)]
    place: Place,
    /// Also roll the scene with every rule and compare the forces with a fine reference.
    #[arg(long)]
    work: bool,
    /// Steps per element to compare.
    #[arg(long, value_delimiter = ',', default_value = "1,2,4", value_parser = clap::value_parser!(u16).range(1..))]
    substeps: Vec<u16>,
    /// Steps per element of the reference.
    #[arg(long, default_value_t = 16, value_parser = clap::value_parser!(u16).range(2..))]
    finest: u16,
    /// Highest frequency of the compared forces, in Hz.
    #[arg(long, value_name = "HZ", default_value = "1000", value_parser = positive)]
    highest: f64,
    /// Time compared, in s.
    #[arg(long, value_name = "S", default_value = "0.3", value_parser = positive)]
    duration: f64,
}

impl RulesArguments {
    pub(crate) fn execute(self, context: &Context) -> Result<(), CliError> {
        let Self { place, work, substeps, finest, highest, duration } = self;
        let mut side = place.open("rules", context)?;
        side.loaded.check_time_domain()?;
        let stop = context.interrupt.flag();
        let mut progress = context.progress();
        progress.stage(Stage::Influence);
        let reports = side.meter.time(Stage::Influence, || compare(&side.loaded, stop))?;
        let (title, time_step) = (side.loaded.title(), Plan::new(&side.loaded.scene).time_step);
        side.file("rules.csv", rules_csv(&reports, time_step));
        for (name, quantity, value) in [
            ("damping.svg", "Damping / angular frequency", damping as fn(Complex64) -> f64),
            ("phase.svg", "Relative frequency error", phase_error),
        ] {
            side.file(name, curves(&title, time_step, quantity, value).to_svg());
        }
        let mut report = rules_report(&reports, time_step);
        if work {
            progress.stage(Stage::History);
            let steps: Vec<usize> = substeps.iter().map(|&q| usize::from(q)).collect();
            let finest = usize::from(finest);
            let found = work_precision(&side.loaded, &COMPARED, &steps, finest, highest, duration, stop)?;
            side.file("work.csv", work_csv(&found));
            side.file("work.svg", work_plot(&title, &found).to_svg());
            report.text("\n");
            report.append(work_report(&found, highest));
        }
        drop(progress);
        side.settings = json!({
            "scene": side.settings,
            "work": work,
            "substeps": substeps,
            "finest": finest,
            "highest": highest,
            "duration": duration,
        });
        side.finish(context, &report)
    }
}

/// Frequencies of the table, relative to the sampling frequency.
const PARTS: [f64; 3] = [0.02, 0.05, 0.1];

fn damping(rate: Complex64) -> f64 {
    -rate.im
}

fn phase_error(rate: Complex64) -> f64 {
    rate.re - 1.0
}

fn verdict(report: &RuleReport) -> String {
    match (&report.stability.unstable, report.stability.rings()) {
        (Some(zero), _) => format!(
            "unstable: n = {}, {:.0} Hz, x {:.2} a step",
            zero.wavenumber,
            zero.frequency,
            1.0 / zero.zeta.norm()
        ),
        (None, true) => "marginal: rings at half the sampling frequency".to_owned(),
        (None, false) => "stable".to_owned(),
    }
}

fn rules_report(reports: &[RuleReport], time_step: f64) -> Report {
    let mut header = vec!["rule".to_owned(), "G0, eigenvalues [m/N]".to_owned()];
    header.extend(PARTS.map(|part| format!("damping, phase error at {:.0} Hz", part / time_step)));
    header.extend(["5 % up to".to_owned(), "inverse".to_owned()]);
    let row = |report: &RuleReport| {
        let (low, high) = report.stability.eigenvalues;
        let mut row = vec![report.rule.name().to_owned(), format!("{low:.2e} .. {high:.2e}")];
        row.extend(PARTS.map(|part| {
            let rate = report.rule.relative_rate(2.0 * PI * part);
            format!("{:.1e}, {:+.1e}", damping(rate), phase_error(rate))
        }));
        row.push(format!("{:.0} Hz", report.rule.largest_angle(0.05) / (2.0 * PI * time_step)));
        row.push(verdict(report));
        row
    };
    let mut report = Report::default();
    report.text(format!("dt = {time_step:.3e} s\n"));
    report.table(words(header, reports.iter().map(row)));
    report
}

fn rules_csv(reports: &[RuleReport], time_step: f64) -> String {
    let mut text = String::from("rule,frequency_hz,damping,phase_error,smallest_g0,largest_g0,inverse\n");
    for report in reports {
        let ((low, high), name, verdict) = (report.stability.eigenvalues, report.rule.name(), verdict(report));
        for k in 1..=POINTS {
            let angle = PI * f64::from(k) / f64::from(POINTS);
            let rate = report.rule.relative_rate(angle);
            let (frequency, damping, phase) = (angle / (2.0 * PI * time_step), damping(rate), phase_error(rate));
            text.push_str(&format!("{name},{frequency},{damping},{phase},{low},{high},\"{verdict}\"\n"));
        }
    }
    text
}

fn curves<'a>(title: &'a str, time_step: f64, quantity: &str, value: fn(Complex64) -> f64) -> LinePlot<'a> {
    let series = COMPARED.map(|rule| {
        // Up to a quarter of the sampling frequency: higher frequencies are of no practical use.
        let point = |k: u32| {
            let angle = 0.5 * PI * f64::from(k) / f64::from(POINTS);
            (angle / (2.0 * PI * time_step), value(rule.relative_rate(angle)))
        };
        Series { name: rule.name(), points: (1..=POINTS).map(point).collect() }
    });
    LinePlot {
        title,
        x: Axis::linear("Frequency [Hz]", 0.0..0.25 / time_step),
        y: Axis::linear_around(quantity, series.iter().flat_map(|series| series.points.iter().map(|point| point.1))),
        series: series.into(),
    }
}

fn work_report(work: &WorkPrecision, highest: f64) -> Report {
    let header = ["rule", "steps/element", "error of the force", "multiply-adds", "solves", "time / rolled time"];
    let row = |point: &WorkPoint| {
        [
            point.rule.name().to_owned(),
            point.substeps.to_string(),
            format!("{:.2e}", point.error),
            format!("{:.2e}", point.multiply_adds as f64),
            point.solves.to_string(),
            format!("{:.3}", point.wall.as_secs_f64() / work.time),
        ]
    };
    let mut report = Report::default();
    report.text(format!(
        "Total force up to {highest:.0} Hz, relative to its root mean square; \
         the two fine references differ by {:.1e}\n",
        work.doubt
    ));
    report.table(aligned(header, work.points.iter().map(row)));
    report
}

fn work_csv(work: &WorkPrecision) -> String {
    let mut text = String::from("rule,substeps,error,multiply_adds,solves,seconds\n");
    for WorkPoint { rule, substeps, error, multiply_adds, solves, wall } in &work.points {
        let (rule, seconds) = (rule.name(), wall.as_secs_f64());
        text += &format!("{rule},{substeps},{error},{multiply_adds},{solves},{seconds}\n");
    }
    text
}

fn work_plot<'a>(title: &'a str, work: &WorkPrecision) -> LinePlot<'a> {
    let place = |point: &WorkPoint| (point.multiply_adds as f64, point.error);
    let places = || work.points.iter().map(place);
    let of = |rule: TimeRule| work.points.iter().filter(move |point| point.rule == rule).map(place).collect();
    LinePlot {
        title,
        x: Axis::logarithmic_around("Multiply-adds of the history", places().map(|at| at.0), [0.8, 1.25]),
        y: Axis::logarithmic_around("Relative error of the force", places().map(|at| at.1), [0.8, 1.25]),
        series: COMPARED.map(|rule| Series { name: rule.name(), points: of(rule) }).into(),
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        rules: RulesArguments,
    }

    #[test]
    fn substeps_are_a_list_and_numbers_are_positive() {
        let parse = |line: &[&str]| Line::try_parse_from([&["rules", "a.toml"], line].concat()).map(|line| line.rules);
        assert_eq!(parse(&["--substeps", "1,3"]).unwrap().substeps, [1, 3]);
        for wrong in [["--substeps", "0"], ["--finest", "1"], ["--highest", "0"], ["--duration", "-1"]] {
            assert!(parse(&wrong).is_err(), "{wrong:?}");
        }
    }
}
