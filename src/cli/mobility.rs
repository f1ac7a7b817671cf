//! `tyrewave mobility`: driving-point mobility of the tread surface.

use std::path::PathBuf;

use clap::Args;
use serde_json::json;
use tyrewave::counters::{Counter, Meter, Stage};
use tyrewave::plan::settled;
use tyrewave::results::plots::{Axis, LinePlot, Series};
use tyrewave::results::summary::Cost;
use tyrewave::results::{ResultsFolder, Summary};
use tyrewave::run::Progress;
use tyrewave::scene::Scene;
use tyrewave::tyre::mobility::{Mobility, driving_point};

use super::options::positive;
use super::{CliError, Context, print, side_folder};

const EXAMPLES: &str = "\
The mobility is the mean velocity of a square patch in the middle of the tread for a unit force spread evenly over it. The smaller the patch the \
higher its level: the tread gives way locally.

Examples:
  tyrewave mobility scenes/default.toml --patch 5,10,20,50
  tyrewave mobility scenes/default.toml --patch 20 --from 50 --to 2000 --out mobility";

/// Arguments of `tyrewave mobility`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct MobilityArguments {
    /// The scene; only its tyre counts.
    pub scene: PathBuf,
    /// Sides of the square patches, in mm.
    #[arg(long, value_name = "MM", value_delimiter = ',', default_value = "5,10,20,50", value_parser = positive)]
    pub patch: Vec<f64>,
    /// Lowest frequency, in Hz.
    #[arg(long, value_name = "HZ", default_value = "50", value_parser = positive)]
    pub from: f64,
    /// Highest frequency, in Hz.
    #[arg(long, value_name = "HZ", default_value = "3000", value_parser = positive)]
    pub to: f64,
    /// Number of frequencies, evenly spaced on a logarithmic axis.
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(2..=100_000))]
    pub points: u32,
    /// Folder for mobility.csv and mobility.svg; default: results/NAME-mobility, NAME being the scene's.
    #[arg(long, short, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
}

/// Level re 1 m/(N s) \[dB\].
fn level(value: num_complex::Complex64) -> f64 {
    20.0 * value.norm().log10()
}

/// One row per frequency; real part, imaginary part and level for each patch.
fn to_csv(mobility: &Mobility, patches: &[f64]) -> String {
    let mut text = String::from("frequency_hz");
    for patch in patches {
        text.push_str(&format!(",re_{patch}mm,im_{patch}mm,level_db_{patch}mm"));
    }
    text.push('\n');
    for (frequency, row) in mobility.frequencies.iter().zip(&mobility.values) {
        text.push_str(&frequency.to_string());
        for &value in row {
            text.push_str(&format!(",{},{},{}", value.re, value.im, level(value)));
        }
        text.push('\n');
    }
    text
}

fn to_svg(mobility: &Mobility, title: &str, patches: &[f64]) -> Result<String, CliError> {
    let names: Vec<String> = patches.iter().map(|patch| format!("{patch} mm")).collect();
    let curves = names.iter().enumerate().map(|(column, name)| Series {
        name,
        points: mobility.frequencies.iter().zip(&mobility.values).map(|(&f, row)| (f, level(row[column]))).collect(),
    });
    let levels = mobility.values.iter().flatten().map(|&value| level(value));
    let plot = LinePlot {
        title,
        x: Axis::logarithmic(
            "Frequency [Hz]",
            mobility.frequencies[0]..mobility.frequencies[mobility.frequencies.len() - 1],
        ),
        y: Axis::linear_around("Driving-point mobility [dB re 1 m/(N s)]", levels),
        series: curves.collect(),
    };
    Ok(plot.to_svg()?)
}

impl MobilityArguments {
    /// Computes, writes `mobility.csv` and `mobility.svg`.
    ///
    /// # Errors
    /// [`CliError`].
    pub fn execute(self, context: &Context) -> Result<(), CliError> {
        let loaded = settled(Scene::load(&self.scene)?)?;
        let target = self.out.clone().unwrap_or_else(|| side_folder(&self.scene, "mobility"));
        let folder = ResultsFolder::create(&target)?;
        let begin = std::time::Instant::now();
        let mut meter = Meter::default();
        let mut progress = context.progress();
        progress.stage(Stage::Influence);
        let sides: Vec<f64> = self.patch.iter().map(|side| side * 1e-3).collect();
        let mobility = meter.time(Stage::Influence, || driving_point(&loaded.scene.tyre, &sides, &self.frequencies()));
        meter.count(Counter::ComplianceEvaluations, mobility.evaluations);
        drop(progress);
        let title = loaded.title();
        folder.write_text("mobility.csv", &to_csv(&mobility, &self.patch))?;
        folder.write_text("mobility.svg", &to_svg(&mobility, &title, &self.patch)?)?;
        let settings = json!({ "scene": loaded.settings()?, "patch_mm": self.patch, "from": self.from, "to": self.to, "points": self.points });
        let cost = Cost::new(&meter, begin.elapsed().as_secs_f64(), context.threads);
        let place = folder.finish(Summary::begun(&title, settings, cost))?;
        if context.options.quiet { Ok(()) } else { print(&format!("results in {}\n", place.display())) }
    }

    /// The frequencies \[Hz\], lowest first; both ends exact.
    pub fn frequencies(&self) -> Vec<f64> {
        let last = self.points - 1;
        let ratio = self.to / self.from;
        (0..self.points)
            .map(|k| if k == last { self.to } else { self.from * ratio.powf(f64::from(k) / f64::from(last)) })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        mobility: MobilityArguments,
    }

    fn parse(line: &[&str]) -> Result<MobilityArguments, clap::Error> {
        Line::try_parse_from([&["mobility"], line].concat()).map(|line| line.mobility)
    }

    #[test]
    fn patches_are_a_list_of_positive_lengths() {
        assert_eq!(parse(&["a.toml", "--patch", "5,10, 20"]).unwrap().patch, [5.0, 10.0, 20.0]);
        assert_eq!(parse(&["a.toml"]).unwrap().patch, [5.0, 10.0, 20.0, 50.0]);
        for patch in ["0", "-5", "five", "5,,10", "nan", "inf"] {
            assert!(parse(&["a.toml", &format!("--patch={patch}")]).is_err(), "{patch}");
        }
    }

    #[test]
    fn frequencies_are_evenly_spaced_on_a_logarithmic_axis() {
        let frequencies = parse(&["a.toml", "--from", "100", "--to", "10000", "--points", "5"]).unwrap().frequencies();
        for (got, expected) in frequencies.iter().zip([100.0, 316.227_766, 1000.0, 3_162.277_66, 10_000.0]) {
            assert!((got / expected - 1.0).abs() < 1e-8, "{frequencies:?}");
        }
        assert!(parse(&["a.toml", "--points", "1"]).is_err());
    }
}
