//! `tyrewave run`: from a scene to contact forces and their spectrum, with views of the run's cost.

use std::path::{Path, PathBuf};

use crate::counters::{Timing, Watch};
use crate::plan::bytes;
use crate::results::cost::{Planned, cost_table};
use crate::results::summary::{FrictionSummary, RollingResistance};
use crate::results::table::Report;
use crate::results::trace::{FOLDED_HEAD, TRACE_HEAD, chrome_trace, folded_stacks};
use crate::run::{self, RunOptions, RunReport};
use clap::Args;

use super::context::{Context, SceneFile, print};
use super::error::{CliError, write_message};
use super::output_file::{OutputFile, begin_both};
use super::report::{beside, check_page, write_page};

const EXAMPLES: &str = "\
Results: summary.json (settings, outcome and cost of the run), time.npy, total_force.npy, patch_force.npy, \
patch_element.npy (plain NumPy arrays, warm-up included), spectra.csv (third-octave levels) and plots in SVG.

An existing results folder is replaced only when the run is complete; a folder with any other files is not touched. \
`tyrewave resume RESULTS` continues a run that was interrupted or killed.

Examples:
  tyrewave run scenes/default.toml                    results in results/default
  tyrewave run scenes/default.toml --out trial        results in trial
  tyrewave run scenes/sound.toml --set numerics.preset=draft --set numerics.fmax=1000
                                                      as if the scene said so
  tyrewave run scenes/default.toml --profile          and a table of the time of each stage
  tyrewave run scenes/default.toml --trace trace.json --folded stacks.txt
                                                      and a time line: for Perfetto, and for flame graphs";

#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct RunArguments {
    #[command(flatten)]
    scene: SceneFile,
    /// Results folder; default: results/NAME, with the name of the scene's file.
    #[arg(long, short, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Make an HTML page of the results beside their folder: see tyrewave help report.
    #[arg(long)]
    report: bool,
    #[command(flatten)]
    profile: ProfileOptions,
}

impl RunArguments {
    /// Runs the scene and prints where the results are.
    pub(crate) fn execute(self, context: &Context) -> Result<(), CliError> {
        let loaded = context.load(&self.scene)?;
        let watch = self.profile.watch(context);
        let options = RunOptions { target: self.results_folder(), threads: context.threads };
        let page = self.report.then(|| beside(&options.target, ".html"));
        page.as_deref().map_or(Ok(()), check_page)?;
        let profile = self.profile.begin()?;
        let report = run::run(&loaded, &options, context.job(&mut context.progress()).watched(watch))?;
        if let Some(page) = page {
            let folders = std::slice::from_ref(&report.folder);
            write_page(folders, loaded.scene.road.file(), &page, context)?;
        }
        end(&report, context, profile.complete(&report)?)
    }

    fn results_folder(&self) -> PathBuf {
        self.out.clone().unwrap_or_else(|| Path::new("results").join(self.scene.name()))
    }
}

/// Prints the outcome of a run, and its cost if `costs` are given; a load that it missed is an error.
pub(super) fn end(report: &RunReport, context: &Context, costs: Option<Report>) -> Result<(), CliError> {
    let mut reported = Report::default();
    if !context.options.quiet {
        reported.text(report_text(report));
    }
    if let Some(costs) = costs {
        reported.text("\n");
        reported.append(costs);
    }
    let printed = if context.options.json {
        print(&report.summary.to_json(&report.folder)?)
    } else {
        context.print_report(&reported)
    };
    let printed = printed.map_err(|error| error.with_results(&report.folder));
    let missed = report.summary.outcome.load.filter(|load| !load.met);
    if report.impossible.is_none() && missed.is_none() {
        return printed;
    }
    if let Err(error) = printed {
        write_message(&error.to_string());
    }
    if let Some(impossible) = &report.impossible {
        let reported = format!("{impossible}; the results are in {} and are meaningless", report.folder.display());
        return Err(CliError::Failed(reported));
    }
    let Some(load) = missed else { return Ok(()) };
    let allowed = match tolerance_for(load.relative_error) {
        Some(tolerance) => format!("and `tolerance = {tolerance}` in rolling.axle allows it"),
        None => "and no tolerance in rolling.axle may be as large".to_owned(),
    };
    Err(CliError::Failed(format!(
        "{load}; the results are in {}; a longer warm_up corrects the height more exactly, a longer duration averages \
         more, {allowed}",
        report.folder.display()
    )))
}

/// A tolerance of the load with some margin above an error, three decimals; `None` if that is not below 1, as the key
/// needs.
fn tolerance_for(relative_error: f64) -> Option<f64> {
    Some((1.2e3 * relative_error.abs()).ceil() / 1e3).filter(|&tolerance| tolerance < 1.0)
}

/// The few lines that a run ends with.
fn report_text(report: &RunReport) -> String {
    let outcome = &report.summary.outcome;
    let mut lines = Vec::new();
    if let (Some(mean), Some(variation)) = (outcome.mean_force, outcome.rms_force_variation) {
        lines.push(format!("mean force          {mean:.1} N, variation {variation:.3e} N rms"));
    }
    if let Some(length) = outcome.mean_contact_length {
        lines.push(format!("contact length      {:.1} mm", 1e3 * length));
    }
    if let Some(RollingResistance { coefficient, force, power }) = outcome.rolling_resistance {
        lines.push(format!("rolling resistance  {coefficient:.5}, {force:.2} N, {power:.1} W"));
    }
    if let Some(friction) = outcome.friction {
        let FrictionSummary { mean_longitudinal_force, mean_lateral_force, mean_slip_power, .. } = friction;
        lines.push(format!("resistance by slip  {:.5}, {mean_slip_power:.1} W", friction.slip_resistance));
        lines.push(format!(
            "tangential forces   {mean_longitudinal_force:.1} N forward, {mean_lateral_force:.1} N to the left"
        ));
        if let Some(free) = friction.free {
            let torque = free.relative_torque;
            lines.push(format!("free rolling        creep {:.5}, torque {torque:.1e} of that of sliding", free.creep));
        }
    }
    let receivers = report.summary.sound.iter().flat_map(|sound| &sound.receivers);
    lines.extend(receivers.map(|receiver| format!("{:18}  {}", receiver.name, receiver.text())));
    let wall = report.wall.as_secs_f64();
    lines.push(format!(
        "{:.2} s rolled in {wall:.1} s ({:.2} x real time), {} steps",
        outcome.simulated_time,
        outcome.simulated_time / wall,
        outcome.steps
    ));
    let cost = &report.summary.cost;
    if let (Some(planned), Some(peak)) = (cost.planned, cost.peak_memory) {
        lines.push(planned_text(planned, wall, peak as f64));
    }
    lines.push(format!("results in {}", report.folder.display()));
    lines.join("\n") + "\n"
}

/// Planned time and memory beside those of the run, in s and bytes.
fn planned_text(planned: Planned, wall: f64, peak: f64) -> String {
    let measured = if planned.measured { "" } else { " by typical costs (`tyrewave plan` measures this machine)" };
    let Planned { wall_seconds, memory, .. } = planned;
    let [memory, peak] = [memory, peak].map(bytes);
    format!("planned {wall_seconds:.1} s and {memory}{measured}, took {wall:.1} s and {peak}")
}

/// How closely the cost of a run is watched, and where it is shown. The results are the same bytes.
#[derive(Clone, Debug, Default, Args)]
pub(super) struct ProfileOptions {
    /// Print the time of every stage, with rates and work counters, at the end; the numbers are also in summary.json.
    #[arg(long)]
    pub profile: bool,
    /// Also write a time line, as Chrome trace events (for ui.perfetto.dev or chrome://tracing), outside of the results
    /// folder. An earlier trace is replaced, any other file is refused.
    #[arg(long, value_name = "FILE")]
    pub trace: Option<PathBuf>,
    /// Also write folded stacks in microseconds, for flame graphs; outside of the results folder. Earlier
    /// ones are replaced, any other file is refused.
    #[arg(long, value_name = "FILE")]
    pub folded: Option<PathBuf>,
}

/// Files that are written when the run is done.
#[derive(Debug)]
pub(super) struct PendingProfile {
    profile: bool,
    trace: Option<OutputFile<'static>>,
    folded: Option<OutputFile<'static>>,
}

impl ProfileOptions {
    /// Extent of the measurements that the requested views need.
    pub(super) fn watch(&self, context: &Context) -> Watch {
        let trace = self.trace.is_some() || self.folded.is_some();
        let timing = match (trace, self.profile) {
            (true, _) => Timing::Every,
            (false, true) => Timing::Closely,
            (false, false) => Timing::Sampled,
        };
        Watch { timing, trace, allocations: context.allocations }
    }

    /// Creates the files before the run: a path that cannot be written to is refused now.
    ///
    /// # Errors
    /// As [`OutputFile::begin`].
    pub(super) fn begin(self) -> Result<PendingProfile, CliError> {
        let Self { profile, trace, folded } = self;
        let [trace, folded] = begin_both([(trace, TRACE_HEAD), (folded, FOLDED_HEAD)])?;
        Ok(PendingProfile { profile, trace, folded })
    }
}

impl PendingProfile {
    /// Completes the files; returns the tables if they are wanted.
    ///
    /// # Errors
    /// Errors of the files.
    pub(super) fn complete(self, report: &RunReport) -> Result<Option<Report>, CliError> {
        if let Some(trace) = report.meter.trace() {
            if let Some(file) = self.trace {
                file.complete(&chrome_trace(trace, &report.summary.title))?;
            }
            if let Some(file) = self.folded {
                file.complete(&folded_stacks(trace))?;
            }
        }
        Ok(self.profile.then(|| cost_table(&report.summary.cost)))
    }
}

#[cfg(test)]
mod tests {
    use crate::scene::{DEFAULT, Scene, Setting};
    use clap::Parser;

    use super::*;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        run: RunArguments,
    }

    #[test]
    fn the_tolerance_that_is_advised_is_one_that_the_key_takes() {
        let advised = [0.0501, -0.8, 0.84, -1.0].map(tolerance_for);
        assert_eq!(advised, [Some(0.061), Some(0.96), None, None]);
        let tolerance = |tolerance: f64| {
            let setting = Setting::parse(&format!("rolling.axle.tolerance={tolerance}")).unwrap();
            Scene::from_str_with(DEFAULT, "default", &[setting])
        };
        assert!(tolerance(0.96).is_ok() && tolerance(1.2).is_err());
    }

    #[test]
    fn a_plan_by_costs_that_were_not_measured_says_so() {
        let planned = Planned { wall_seconds: 7.0, memory: 1.1e9, measured: true };
        assert_eq!(planned_text(planned, 685.0, 1e9), "planned 7.0 s and 1.1 GB, took 685.0 s and 1.0 GB");
        let text = planned_text(Planned { measured: false, ..planned }, 685.0, 1e9);
        assert!(text.contains("1.1 GB by typical costs (`tyrewave plan` measures this machine), took"), "{text}");
    }

    #[test]
    fn results_are_named_after_the_scene() {
        let folder = |line: &[&str]| Line::try_parse_from(line).map(|line| line.run.results_folder());
        assert_eq!(folder(&["run", "scenes/default.toml"]).unwrap(), Path::new("results/default"));
        assert_eq!(folder(&["run", "a.toml", "--out", "x/y"]).unwrap(), Path::new("x/y"));
        assert!(folder(&["run"]).is_err());
    }
}
