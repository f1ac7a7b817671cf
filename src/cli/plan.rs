//! `tyrewave plan`: what a run would do, why, and what it would take.

use crate::plan::{Amounts, Forecast, Plan, bytes, process_memory};
use crate::planning::foreseen;
use crate::report::{decision_table, plan_record};
use crate::results::table::{Report, aligned, grouped, row, words};
use crate::run::prepare::checked;
use crate::scene::LoadedScene;
use crate::study::calibration::{calibrate, calibrated};
use clap::Args;

use super::context::{Context, SceneFile, print};
use super::error::CliError;

const EXAMPLES: &str = "\
Nothing is simulated; the road is opened and must be long enough. The plan shows the effects that the scene needs and \
why, the settings that were chosen, the work of each stage, the largest memory, and the time on this machine. \
`tyrewave run` follows exactly this plan. If an inflated tyre has arcs as sidewalls, the plan shows the tension and \
foundation that follow from them beside those that are used; values in the scene have priority.

The first time, the time per unit of work is measured on this machine by short runs (two or three seconds) and kept \
beside the fitted models; --calibrate repeats the measurement.

Examples:
  tyrewave plan scenes/default.toml
  tyrewave plan scenes/default.toml --threads 1
  tyrewave plan scenes/default.toml --json";

/// Arguments of `tyrewave plan`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct PlanArguments {
    #[command(flatten)]
    pub scene: SceneFile,
    /// Repeat the measurement of this machine's speed.
    #[arg(long)]
    pub calibrate: bool,
}

impl PlanArguments {
    pub(crate) fn execute(self, context: &Context) -> Result<(), CliError> {
        let process = process_memory();
        let loaded = context.load(&self.scene)?;
        let plan = checked(&loaded)?;
        let amounts = plan.amounts();
        let stop = context.interrupt.flag();
        let costs = if self.calibrate { calibrate(stop) } else { calibrated(stop) }?;
        let forecast = plan.forecast(&costs, context.threads, process);
        if context.options.json {
            return print(&format!("{:#}\n", plan_record(&loaded, &plan, &amounts, &forecast)?));
        }
        context.print_report(&text(&loaded, &plan, &amounts, &forecast, process))
    }
}

fn text(loaded: &LoadedScene, plan: &Plan, amounts: &Amounts, forecast: &Forecast, process: f64) -> Report {
    let mut text = Report::default();
    text.text(format!(
        "{}\n\n{} elements of {:.2} mm, {} steps of {:.1} us; about {:.0} points in contact\n\n",
        loaded.title(),
        plan.scene.numerics.elements,
        1e3 * plan.element,
        grouped(plan.steps),
        1e6 * plan.time_step,
        amounts.expected.points
    ));
    text.table(decision_table(plan));
    if !plan.choices.is_empty() {
        let choices = plan.choices.iter().map(|choice| row([&choice.key, &choice.value, &choice.reason]));
        text.titled("\n", words(["chosen", "", "why"], choices));
    }
    let timed = |what: &str, seconds: f64, place: &str| row([&what, &format!("{seconds:.3} s"), &place]);
    let stages = forecast
        .stages
        .iter()
        .map(|stage| timed(stage.stage.title(), stage.seconds, if stage.background { "beside the steps" } else { "" }));
    let all = [("everything else", forecast.rest_seconds), ("all cores", forecast.core_seconds())];
    text.text("\n");
    text.table(aligned(["stage", "time", ""], stages.chain(all.map(|(what, seconds)| timed(what, seconds, "")))));
    let counters = amounts.counters.iter().map(|&(counter, amount)| row([&counter.title(), &grouped(amount as u64)]));
    text.titled("\n", aligned(["work", "about"], counters));
    let held = amounts.memory.iter().map(|&(what, size)| row([&what, &bytes(size)]));
    let threads = forecast.threads as f64;
    let others = [
        (format!("work on {threads} threads"), threads * amounts.memory_per_thread),
        ("influence functions, before the steps".to_owned(), amounts.set_up_memory_on(forecast.threads)),
        ("the program, with pictures and a page of the results".to_owned(), process),
    ];
    let others = others.map(|(what, size)| row([&what, &bytes(size)]));
    text.titled("\n", aligned(["memory", "at most"], held.chain(others)));
    for warning in foreseen(plan) {
        text.text(format!("\nwarning: {warning}\n"));
    }
    for note in &plan.decisions.notes {
        text.text(format!("\nnote: {note}\n"));
    }
    let cached = match amounts.cache_bytes {
        cached if cached > 0.0 => format!(", {} in the cache on disk", bytes(cached)),
        _ => String::new(),
    };
    text.text(format!(
        "\nabout {:.2} s on {} threads, at most {} of memory, {} of results{cached}\n",
        forecast.wall_seconds,
        forecast.threads,
        bytes(forecast.memory),
        bytes(amounts.result_bytes)
    ));
    text
}
