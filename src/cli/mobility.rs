//! `tyrewave mobility`: driving-point mobility of the tread surface.

use crate::counters::{Counter, Stage};
use crate::report::tyre::{LEVEL, plot};
use crate::results::table::{Report, csv};
use crate::run::Progress;
use crate::tyre::influence::mobility::{Mobility, driving_point, frequencies, level};
use clap::Args;
use serde_json::json;

use super::context::Context;
use super::error::CliError;
use super::options::{patch_side, positive};
use super::side::Place;

const EXAMPLES: &str = "\
The mobility is the mean velocity of a square patch in the middle of the tread for a unit force spread evenly over it. \
The smaller the patch the higher its level, because the tread deforms locally. Only the scene's tyre is used.

Results: mobility.csv and mobility.svg.

Examples:
  tyrewave mobility scenes/default.toml --patch 5,10,20,50
  tyrewave mobility scenes/default.toml --patch 20 --from 50 --to 2000 --out mobility";

#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct MobilityArguments {
    #[command(flatten)]
    place: Place,
    /// Sides of the square patches, in mm.
    #[arg(long, value_name = "MM", value_delimiter = ',', default_value = "5,10,20,50", value_parser = patch_side)]
    patch: Vec<f64>,
    /// Lowest frequency, in Hz.
    #[arg(long, value_name = "HZ", default_value = "50", value_parser = positive, allow_negative_numbers = true)]
    from: f64,
    /// Highest frequency, in Hz.
    #[arg(long, value_name = "HZ", default_value = "3000", value_parser = positive, allow_negative_numbers = true)]
    to: f64,
    /// Number of frequencies, evenly spaced on a logarithmic axis.
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(2..=100_000))]
    points: u32,
}

/// CSV with one row per frequency: real part, imaginary part and level for each patch.
pub(super) fn to_csv(mobility: &Mobility, patches: &[f64]) -> String {
    let columns = |patch: &f64| [format!("re_{patch}mm"), format!("im_{patch}mm"), format!("level_db_{patch}mm")];
    let header = ["frequency_hz".to_owned()].into_iter().chain(patches.iter().flat_map(columns));
    let rows = mobility.frequencies.iter().zip(&mobility.values).map(|(&frequency, row)| {
        let numbers = row.iter().flat_map(|&value| [value.re, value.im, level(value)]);
        [frequency].into_iter().chain(numbers)
    });
    csv(header, rows)
}

impl MobilityArguments {
    pub(crate) fn execute(self, context: &Context) -> Result<(), CliError> {
        let frequencies = frequencies(self.from, self.to, self.points);
        let Self { place, patch, from, to, points } = self;
        let mut side = place.open_tyre("mobility", context)?;
        let mut progress = context.progress();
        progress.stage(Stage::Influence);
        let sides: Vec<f64> = patch.iter().map(|side| side * 1e-3).collect();
        let tyre = &side.loaded.scene.tyre;
        let mobility = side.meter.time(Stage::Influence, || driving_point(tyre, &sides, &frequencies));
        side.meter.count(Counter::ComplianceEvaluations, mobility.evaluations);
        drop(progress);
        let names: Vec<String> = patch.iter().map(|patch| format!("{patch} mm")).collect();
        side.file("mobility.csv", to_csv(&mobility, &patch));
        let title = format!("Driving-point mobility: {}", side.loaded.title());
        side.file("mobility.svg", plot(&mobility, &title, &names, LEVEL).to_svg());
        side.settings = json!({ "scene": side.settings, "patch_mm": patch, "from": from, "to": to, "points": points });
        side.finish(context, &Report::default())
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
        for patch in ["0", "-5", "five", "5,,10", "nan", "inf", "0.02"] {
            assert!(parse(&["a.toml", &format!("--patch={patch}")]).is_err(), "{patch}");
        }
    }

    #[test]
    fn frequencies_are_evenly_spaced_on_a_logarithmic_axis() {
        for (got, expected) in
            frequencies(100.0, 10_000.0, 5).iter().zip([100.0, 316.227_766, 1000.0, 3_162.277_66, 10_000.0])
        {
            assert!((got / expected - 1.0).abs() < 1e-8, "{got} {expected}");
        }
        assert!(parse(&["a.toml", "--points", "1"]).is_err());
    }
}
