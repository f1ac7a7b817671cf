//! `tyrewave slice`: one slice's displacement and pressure at given indentations.

use std::path::PathBuf;

use crate::road::slices::{SliceBuilder, SliceScratch};
use clap::{Args, ValueEnum};
use serde::Serialize;

use super::context::print;
use super::error::CliError;
use super::heights::Heights;
use super::options::{finite, poisson_ratio, positive};

const EXAMPLES: &str = "\
Printed as JSON: indentation [m] past the highest point; S [m], the mean displacement normalised by the flat slice on \
the same grid (S = y for a flat slice; below 0 the gap itself); pressure [Pa] on each cell for Young's modulus 1 Pa. \
The springs of the winkler law are given the stiffness of the flat slice on the half-space, so that both laws press a \
flat slice equally hard.

Examples:
  tyrewave slice --heights across.npy --dx 0.0038 --dy 0.002 --law half-space --at 0.0005,0.001,0.002
  tyrewave slice --heights across.npy --dx 0.0038 --dy 0.002 --law winkler --poisson 0.5 --at 1e-3";

/// Slice laws that can be asked for.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum SliceLaw {
    /// Independent springs across the width.
    Winkler,
    /// Elastic half-space.
    HalfSpace,
}

#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
#[command(allow_negative_numbers = true)]
pub struct SliceArguments {
    /// Heights across the slice, in m: a one-dimensional .npy array.
    #[arg(long, value_name = "FILE.npy")]
    heights: PathBuf,
    /// Length of the cells along the road, in m.
    #[arg(long, value_name = "M", value_parser = positive)]
    dx: f64,
    /// Width of the cells across the road, in m.
    #[arg(long, value_name = "M", value_parser = positive)]
    dy: f64,
    /// Model of the tread that the slice is pressed into.
    #[arg(long)]
    law: SliceLaw,
    /// Poisson's ratio; it scales the pressures only.
    #[arg(long, value_name = "P", default_value = "0.49", value_parser = poisson_ratio)]
    poisson: f64,
    /// Indentations past the highest point in m, separated by commas.
    #[arg(
        long,
        value_name = "Y1,Y2,...",
        value_delimiter = ',',
        required = true,
        allow_hyphen_values = true,
        value_parser = finite
    )]
    at: Vec<f64>,
}

/// Answer of `tyrewave slice`.
#[derive(Clone, Debug, Serialize)]
struct SliceAnswer {
    /// Indentations past the highest point \[m\].
    indentation: Vec<f64>,
    /// S \[m\] at each indentation.
    #[serde(rename = "S")]
    displacement: Vec<f64>,
    /// Pressure \[Pa\] for E = 1 Pa: one row per indentation, one column per cell.
    pressure: Vec<Vec<f64>>,
}

impl SliceArguments {
    pub(crate) fn execute(self) -> Result<(), CliError> {
        let heights = self.heights.clone();
        let answer = self.answer().map_err(|error| match error {
            CliError::Run(_) => error.in_file(&heights),
            named => named,
        })?;
        print(&format!("{:#}\n", serde_json::json!(answer)))
    }

    fn answer(self) -> Result<SliceAnswer, CliError> {
        let Self { heights, dx, dy, law, poisson, at } = self;
        let Heights { values, columns, .. } = Heights::read_row(&heights, [dx, dy])?;
        let builder = match law {
            SliceLaw::Winkler => SliceBuilder::winkler(columns)?,
            SliceLaw::HalfSpace => SliceBuilder::half_space(columns, dx, dy)?,
        };
        let mut scratch = SliceScratch::default();
        let (curve, mut pressure) = builder.build_with_pressures(&values, dx, dy, &at, &mut scratch)?;
        // Pressures are relative to E/(1 - nu^2).
        let modulus = 1.0 / (1.0 - poisson * poisson);
        pressure.iter_mut().flatten().for_each(|pressure| *pressure *= modulus);
        let displacement = at.iter().map(|&y| curve.displacement_at(y)).collect();
        Ok(SliceAnswer { indentation: at, displacement, pressure })
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use clap::Parser;
    use npyz::WriterBuilder;

    use super::super::{Command, CommandLine};
    use super::*;
    use crate::road::slices::SliceError;
    use crate::run::RunError;

    fn write(path: &Path, heights: &[f64]) {
        let mut bytes = Vec::new();
        let options = npyz::WriteOptions::new().default_dtype().shape(&[heights.len() as u64]).writer(&mut bytes);
        let mut writer = options.begin_nd().unwrap();
        writer.extend(heights.iter()).unwrap();
        writer.finish().unwrap();
        std::fs::write(path, bytes).unwrap();
    }

    fn answer(heights: &[f64], law: SliceLaw, at: &[f64]) -> Result<SliceAnswer, CliError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("z.npy");
        write(&path, heights);
        SliceArguments { heights: path, dx: 4e-3, dy: 2e-3, law, poisson: 0.3, at: at.to_vec() }.answer()
    }

    #[test]
    fn pressures_add_up_to_the_curve_for_both_laws() {
        let heights: Vec<f64> = (0..40).map(|i| 1e-3 * (f64::from(i) * 0.7).sin()).collect();
        let flat = answer(&[0.0; 40], SliceLaw::HalfSpace, &[1.0]).unwrap();
        let stiffness: f64 = flat.pressure[0].iter().sum();
        let at = [-1e-3, 0.0, 2e-4, 1e-3, 5e-3];
        for law in [SliceLaw::Winkler, SliceLaw::HalfSpace] {
            let answer = answer(&heights, law, &at).unwrap();
            assert!((answer.displacement[0] + 1e-3).abs() < 1e-18, "a gap stays a gap");
            for ((y, s), pressure) in at.iter().zip(&answer.displacement).zip(&answer.pressure).skip(1) {
                let force: f64 = pressure.iter().sum();
                assert!((force / stiffness - s).abs() < 1e-15, "{law:?} at {y}");
            }
        }
    }

    #[test]
    fn hard_input_is_answered_or_refused_by_name() {
        for law in [SliceLaw::Winkler, SliceLaw::HalfSpace] {
            let flat = answer(&[1e-3; 30], law, &[2e-3]).unwrap();
            assert!((flat.displacement[0] - 2e-3).abs() < 1e-17);
            let two = answer(&[0.0, -1e-3], law, &[5e-4, 4e-3]).unwrap();
            assert!(two.pressure[0][1].abs() <= 0.0 && two.pressure[1][1] > 0.0);
            let mut spike = vec![0.0; 31];
            spike[15] = 5e-3;
            assert!(answer(&spike, law, &[1e-3]).unwrap().displacement[0] < 3e-4);
            spike[7] = f64::NAN;
            assert!(matches!(
                answer(&spike, law, &[1e-3]),
                Err(CliError::Run(RunError::Slices(SliceError::Hole { cell: 7, .. })))
            ));
            let millimetres: Vec<f64> = (0..40).map(|i| (f64::from(i) * 0.7).sin()).collect();
            let refused = answer(&millimetres, law, &[1e-3]).unwrap_err();
            assert!(refused.to_string().contains("millimetres"), "{refused}");
        }
        for line in ["--at nan", "--at 1e-3 --dx 0", "--at 1e-3 --poisson 0.6", "--at 1e-3 --dx -1"] {
            let line = format!("tyrewave slice --heights z.npy --dy 1e-3 --law winkler {line}");
            let line = if line.contains("--dx") { line } else { format!("{line} --dx 1e-3") };
            assert_eq!(CommandLine::try_parse_from(line.split(' ')).unwrap_err().exit_code(), 2, "{line}");
        }
    }

    #[test]
    fn indentations_may_begin_with_a_gap() {
        let line = "tyrewave slice --heights z.npy --dx 1e-3 --dy 1e-3 --law half-space --at -1e-4,2e-4";
        let parsed = CommandLine::try_parse_from(line.split(' ')).unwrap();
        let Command::Slice(arguments) = parsed.command else { panic!("another command") };
        assert_eq!(arguments.at, [-1e-4, 2e-4]);
    }
}
