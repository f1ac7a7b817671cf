//! `tyrewave rules`: the time rules side by side for a scene.

use std::f64::consts::PI;
use std::path::PathBuf;

use clap::Args;
use serde_json::json;
use tyrewave::counters::{Meter, Stage};
use tyrewave::plan::{Plan, settled};
use tyrewave::results::folder::ResultsFolder;
use tyrewave::results::plots::{Axis, LinePlot, Series};
use tyrewave::results::summary::{Cost, Summary};
use tyrewave::results::table::{aligned, words};
use tyrewave::run::progress::Progress;
use tyrewave::scene::{Scene, TimeRule};
use tyrewave::study::rules::{RuleReport, WorkPoint, WorkPrecision, compare, work_precision};

use super::options::positive;
use super::{CliError, Context, side_folder};

const EXAMPLES: &str = "\
Damping and phase error say what a rule makes of a mode: a decay that is not the tyre's, relative to the angular frequency, and a shift of its \
frequency. Unstable: the discrete inverse has zeros inside the unit disk and `run` refuses the rule. Results: rules.csv, damping.svg, \
phase.svg and, with --work, work.csv and work.svg.

Examples:
  tyrewave rules scenes/default.toml                     table and plots at the scene's time step
  tyrewave rules scenes/default.toml --work              and forces against a fine reference
  tyrewave rules scenes/default.toml --work --substeps 1,2,4,8 --highest 3000";

/// Rules that a comparison of forces runs with.
const COMPARED: [TimeRule; 5] =
    [TimeRule::Bdf1, TimeRule::Bdf2, TimeRule::Trapezoidal, TimeRule::Sdirk2, TimeRule::Sdirk3];
/// Points of the curves.
const POINTS: u32 = 200;

/// Arguments of `tyrewave rules`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct RulesArguments {
    /// The scene, a TOML file.
    pub scene: PathBuf,
    /// Results folder; default: results/NAME-rules.
    #[arg(long, short, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// Also roll the scene with every rule and compare the forces with a fine reference.
    #[arg(long)]
    pub work: bool,
    /// Steps per element to compare.
    #[arg(long, value_delimiter = ',', default_value = "1,2,4", value_parser = clap::value_parser!(u16).range(1..))]
    pub substeps: Vec<u16>,
    /// Steps per element of the reference.
    #[arg(long, default_value_t = 16, value_parser = clap::value_parser!(u16).range(2..))]
    pub finest: u16,
    /// Highest frequency of the compared forces, in Hz.
    #[arg(long, value_name = "HZ", default_value = "1000", value_parser = positive)]
    pub highest: f64,
    /// Time compared, in s.
    #[arg(long, value_name = "S", default_value = "0.3", value_parser = positive)]
    pub duration: f64,
}

impl RulesArguments {
    /// Compares, writes, prints.
    ///
    /// # Errors
    /// [`CliError`].
    pub fn execute(self, context: &Context) -> Result<(), CliError> {
        let loaded = settled(Scene::load(&self.scene)?)?;
        loaded.check_time_domain()?;
        let target = self.out.clone().unwrap_or_else(|| side_folder(&self.scene, "rules"));
        let folder = ResultsFolder::create(&target)?;
        let begin = std::time::Instant::now();
        let stop = context.interrupt.flag();
        let mut meter = Meter::default();
        let mut progress = context.progress();
        progress.stage(Stage::Influence);
        let reports = meter.time(Stage::Influence, || compare(&loaded, stop))?;
        let work = if self.work {
            progress.stage(Stage::History);
            let substeps: Vec<usize> = self.substeps.iter().map(|&q| usize::from(q)).collect();
            let finest = usize::from(self.finest);
            Some(work_precision(&loaded, &COMPARED, &substeps, finest, self.highest, self.duration, stop)?)
        } else {
            None
        };
        drop(progress);
        let (title, time_step) = (loaded.title(), Plan::new(&loaded.scene).time_step);
        folder.write_text("rules.csv", &rules_csv(&reports, time_step))?;
        folder
            .write_text("damping.svg", &curves(&title, time_step, "Damping / angular frequency", |rate| -rate.im)?)?;
        folder
            .write_text("phase.svg", &curves(&title, time_step, "Relative frequency error", |rate| rate.re - 1.0)?)?;
        let mut text = rules_table(&reports, time_step);
        if let Some(work) = &work {
            folder.write_text("work.csv", &work_csv(work))?;
            folder.write_text("work.svg", &work_plot(&title, work)?)?;
            text.push('\n');
            text.push_str(&work_table(work, self.highest));
        }
        let settings = json!({ "scene": loaded.settings()?, "work": self.work, "substeps": self.substeps, "finest": self.finest, "highest": self.highest, "duration": self.duration });
        let cost = Cost::new(&meter, begin.elapsed().as_secs_f64(), context.threads);
        let place = folder.finish(Summary::begun(&title, settings, cost))?;
        context.answer(&text, &place)
    }
}

/// Frequencies of the table: parts of the sampling frequency.
const PARTS: [f64; 3] = [0.02, 0.05, 0.1];

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

fn rules_table(reports: &[RuleReport], time_step: f64) -> String {
    let mut header = vec!["rule".to_owned(), "G0, eigenvalues [m/N]".to_owned()];
    header.extend(PARTS.map(|part| format!("damping, phase error at {:.0} Hz", part / time_step)));
    header.extend(["5 % up to".to_owned(), "inverse".to_owned()]);
    let row = |report: &RuleReport| {
        let (low, high) = report.stability.eigenvalues;
        let mut row = vec![report.rule.name().to_owned(), format!("{low:.2e} .. {high:.2e}")];
        row.extend(PARTS.map(|part| {
            let rate = report.rule.relative_rate(2.0 * PI * part);
            format!("{:.1e}, {:+.1e}", -rate.im, rate.re - 1.0)
        }));
        row.push(format!("{:.0} Hz", report.rule.largest_angle(0.05) / (2.0 * PI * time_step)));
        row.push(verdict(report));
        row
    };
    let rows: Vec<Vec<String>> = reports.iter().map(row).collect();
    format!("dt = {time_step:.3e} s\n{}", words(&header, &rows))
}

fn rules_csv(reports: &[RuleReport], time_step: f64) -> String {
    let mut text = String::from("rule,frequency_hz,damping,phase_error,smallest_g0,largest_g0,inverse\n");
    for report in reports {
        let (low, high) = report.stability.eigenvalues;
        for k in 1..=POINTS {
            let angle = PI * f64::from(k) / f64::from(POINTS);
            let rate = report.rule.relative_rate(angle);
            let frequency = angle / (2.0 * PI * time_step);
            text.push_str(&format!(
                "{},{frequency},{},{},{low},{high},\"{}\"\n",
                report.rule.name(),
                -rate.im,
                rate.re - 1.0,
                verdict(report)
            ));
        }
    }
    text
}

fn curves(
    title: &str,
    time_step: f64,
    quantity: &str,
    value: impl Fn(num_complex::Complex64) -> f64,
) -> Result<String, CliError> {
    let series: Vec<Series<'_>> = COMPARED
        .iter()
        .map(|rule| {
            // Up to a quarter of the sampling frequency: nobody uses what lies above.
            let point = |k: u32| {
                let angle = 0.5 * PI * f64::from(k) / f64::from(POINTS);
                (angle / (2.0 * PI * time_step), value(rule.relative_rate(angle)))
            };
            Series { name: rule.name(), points: (1..=POINTS).map(point).collect() }
        })
        .collect();
    let plot = LinePlot {
        title,
        x: Axis::linear("Frequency [Hz]", 0.0..0.25 / time_step),
        y: Axis::linear_around(quantity, series.iter().flat_map(|series| series.points.iter().map(|point| point.1))),
        series,
    };
    Ok(plot.to_svg()?)
}

fn work_table(work: &WorkPrecision, highest: f64) -> String {
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
    let rows: Vec<[String; 6]> = work.points.iter().map(row).collect();
    format!(
        "Total force up to {highest:.0} Hz, relative to its root mean square; the two fine references differ by {:.1e}\n{}",
        work.doubt,
        aligned(&header, &rows)
    )
}

fn work_csv(work: &WorkPrecision) -> String {
    let mut text = String::from("rule,substeps,error,multiply_adds,solves,seconds\n");
    for point in &work.points {
        text.push_str(&format!(
            "{},{},{},{},{},{}\n",
            point.rule.name(),
            point.substeps,
            point.error,
            point.multiply_adds,
            point.solves,
            point.wall.as_secs_f64()
        ));
    }
    text
}

fn work_plot(title: &str, work: &WorkPrecision) -> Result<String, CliError> {
    let cost = |point: &WorkPoint| point.multiply_adds as f64;
    let costs = work.points.iter().map(cost);
    let (low, high) = costs.fold((f64::INFINITY, 0.0_f64), |(a, b), x| (a.min(x), b.max(x)));
    let errors = work.points.iter().map(|point| point.error);
    let (small, large) = errors.fold((f64::INFINITY, 0.0_f64), |(a, b), x| (a.min(x), b.max(x)));
    let series = COMPARED.iter().map(|rule| Series {
        name: rule.name(),
        points: work
            .points
            .iter()
            .filter(|point| point.rule == *rule)
            .map(|point| (cost(point), point.error))
            .collect(),
    });
    let plot = LinePlot {
        title,
        x: Axis::logarithmic("Multiply-adds of the history", 0.8 * low..1.25 * high),
        y: Axis::logarithmic("Relative error of the force", 0.8 * small..1.25 * large),
        series: series.collect(),
    };
    Ok(plot.to_svg()?)
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
