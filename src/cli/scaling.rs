//! `tyrewave profile scaling`: cost against size and threads, as table, JSON and picture.

use std::path::PathBuf;

use clap::Args;
use serde_json::json;
use tyrewave::performance::scaling::{Ladder, PIECES, Scaling, ThreadLadder};
use tyrewave::results::PlotError;
use tyrewave::results::plots::{Axis, LinePlot, Series};
use tyrewave::results::table::{Report, aligned};
use tyrewave::scene::{PLATE, Scene};

use super::context::Context;
use super::error::CliError;
use super::side::Side;

/// Cores that the limit is stated for.
const WORKSTATION: usize = 64;

/// Arguments of `tyrewave profile scaling`.
#[derive(Clone, Debug, Args)]
pub struct ScalingArguments {
    /// Results folder.
    #[arg(long, value_name = "FOLDER", default_value = "results/scaling")]
    pub out: PathBuf,
}

impl ScalingArguments {
    /// Measures all ladders; a minute or two.
    ///
    /// # Errors
    /// [`CliError`].
    pub fn execute(self, context: &Context) -> Result<(), CliError> {
        let mut loaded = Scene::from_str(PLATE, "scaling")?;
        loaded.scene.title = "Scaling".to_owned();
        let mut side = Side::new(loaded, self.out)?;
        let bar = context.bar("scaling", PIECES);
        let scratch = std::env::temp_dir().join(format!("tyrewave-scaling-{}", std::process::id()));
        let measured = Scaling::measure(&scratch, context.interrupt.flag(), &mut |piece| {
            bar.set_message(piece);
            bar.inc(1);
        });
        let _ = std::fs::remove_dir_all(&scratch);
        bar.finish_and_clear();
        let scaling = measured?;
        let mut text = text(&scaling);
        side.file("scaling.txt", text.to_string());
        side.json("scaling.json", &json!(scaling));
        side.picture("scaling.svg", plot(&scaling))?;
        text.text("\n");
        side.finish(context, &text)
    }
}

/// A time of any size, readably.
fn time(seconds: f64) -> String {
    match seconds {
        s if s >= 1.0 => format!("{s:.2} s"),
        s if s >= 1e-3 => format!("{:.2} ms", 1e3 * s),
        s if s >= 1e-6 => format!("{:.2} us", 1e6 * s),
        s => format!("{:.0} ns", 1e9 * s),
    }
}

fn text(scaling: &Scaling) -> Report {
    let row = |ladder: &Ladder| {
        let exponent = |found: Option<f64>| found.map_or(String::new(), |exponent| format!("{exponent:.2}"));
        let ends = |of: &dyn Fn(usize) -> String| match ladder.rungs.len() {
            0 => String::new(),
            count => format!("{} - {}", of(0), of(count - 1)),
        };
        [
            ladder.axis.to_owned(),
            ladder.cost.to_owned(),
            ends(&|rung| format!("{:.0}", ladder.rungs[rung].size)),
            ends(&|rung| time(ladder.rungs[rung].seconds)),
            exponent(ladder.of_time()),
            exponent(ladder.of_work()),
            format!("{:.0}", ladder.expected),
            ladder.reason.to_owned(),
        ]
    };
    let header = ["size", "cost", "from - to", "time", "exponent", "of the work", "expected", "why"];
    let mut text = Report::default();
    text.table(aligned(header, scaling.ladders.iter().map(row)));
    let row = |ladder: &ThreadLadder| {
        let rung = |((threads, seconds), speedup): (&(usize, f64), f64)| {
            format!("{threads}: {} ({speedup:.2}, efficiency {:.2})", time(*seconds), speedup / *threads as f64)
        };
        let rungs: Vec<String> = ladder.rungs.iter().zip(ladder.speedups()).map(rung).collect();
        [
            ladder.elements.to_string(),
            rungs.join("; "),
            format!("{:.0} %", 100.0 * ladder.serial),
            format!("{:.1}", ladder.limit(WORKSTATION)),
        ]
    };
    let header = ["elements", "threads: time of the steps (times faster)", "stays on one core", "at most, on 64 cores"];
    text.text("\n");
    text.table(aligned(header, scaling.threads.iter().map(row)));
    text
}

/// Times over sizes, both relative to the first, so that slopes are seen side by side.
fn plot(scaling: &Scaling) -> Result<String, PlotError> {
    let names: Vec<String> = scaling.ladders.iter().map(|ladder| format!("{}: {}", ladder.axis, ladder.cost)).collect();
    let series: Vec<Series<'_>> = scaling
        .ladders
        .iter()
        .zip(&names)
        .filter_map(|(ladder, name)| {
            let first = ladder.rungs.first()?;
            let points = ladder.rungs.iter().map(|rung| (rung.size / first.size, rung.seconds / first.seconds));
            Some(Series { name, points: points.collect() })
        })
        .collect();
    let points = || series.iter().flat_map(|series| &series.points);
    let widest = points().fold(2.0_f64, |widest, point| widest.max(point.0));
    let highest = points().fold(2.0_f64, |highest, point| highest.max(point.1));
    let lowest = points().fold(1.0_f64, |lowest, point| lowest.min(point.1));
    let plot = LinePlot {
        title: "Cost against size",
        x: Axis::logarithmic("Size, relative to the smallest [1]", 1.0..widest),
        y: Axis::logarithmic("Time, relative to that of the smallest [1]", 0.8 * lowest..1.2 * highest),
        series,
    };
    plot.to_svg()
}
