//! `tyrewave indent`: a rigid rough body pressed into an elastic half-space.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use serde::Serialize;
use tyrewave::half_space::rough::{Control, Extent, HeightMap, Indentation, Limits, indent};
use tyrewave::results::npy::{NpyWriter, Row};

use super::heights::{poisson_ratio, positive, read_grid};
use super::{CliError, print};

const EXAMPLES: &str = "\
Frictionless contact of the height map (peaks touch first) with a half-space of the given modulus, without periodicity. Printed as JSON: load [N], \
penetration [m] of the highest peak, share of the cells in contact, iterations on the finest grid, residual (the largest gap under pressure or \
overlap without, relative to the penetration) and seconds.

Examples:
  tyrewave indent --heights grid.npy --dx 0.001 --dy 0.001 --modulus 1e7 --poisson 0.45 --penetration 0.002
  tyrewave indent --heights grid.npy --dx 0.001 --dy 0.001 --modulus 1e7 --poisson 0.45 --load 700 --out pressure.npy";

/// Arguments of `tyrewave indent`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct IndentArguments {
    /// Heights, in m: a two-dimensional .npy array, rows along x, columns along y.
    #[arg(long, value_name = "GRID.npy")]
    pub heights: PathBuf,
    /// Spacing of the rows, in m.
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub dx: f64,
    /// Spacing of the columns, in m.
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub dy: f64,
    /// Young's modulus of the half-space, in Pa.
    #[arg(long, value_name = "E", allow_negative_numbers = true)]
    pub modulus: f64,
    /// Poisson's ratio of the half-space.
    #[arg(long, value_name = "P", allow_negative_numbers = true)]
    pub poisson: f64,
    /// Normal load, in N.
    #[arg(
        long,
        value_name = "N",
        conflicts_with = "penetration",
        required_unless_present = "penetration",
        allow_negative_numbers = true
    )]
    pub load: Option<f64>,
    /// Penetration of the highest peak, in m.
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub penetration: Option<f64>,
    /// Tolerance of the contact conditions, relative to the penetration.
    #[arg(long, value_name = "T", default_value_t = Limits::default().tolerance, allow_negative_numbers = true)]
    pub tolerance: f64,
    /// Where to write the pressure in Pa, an array of the heights' shape.
    #[arg(long, value_name = "PRESSURE.npy")]
    pub out: Option<PathBuf>,
}

/// What `tyrewave indent` answers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct IndentAnswer {
    /// Load \[N\].
    pub load: f64,
    /// Penetration of the highest peak \[m\].
    pub penetration: f64,
    /// Share of the cells in contact.
    pub area_fraction: f64,
    /// Iterations on the finest grid.
    pub iterations: usize,
    /// Largest violation of the contact conditions, relative to the penetration.
    pub residual: f64,
    /// Wall time of the solution \[s\], file access excluded.
    pub seconds: f64,
}

impl IndentArguments {
    /// Solves, writes the pressure if wanted, prints the answer.
    ///
    /// # Errors
    /// [`CliError`].
    pub fn execute(self) -> Result<(), CliError> {
        let (answer, contact, columns) = self.answer()?;
        if let Some(path) = &self.out {
            let mut writer = NpyWriter::create(path, Row::Columns(columns))?;
            for row in contact.pressure.chunks_exact(columns) {
                writer.push(row)?;
            }
            writer.finish()?;
        }
        print(&format!("{:#}\n", serde_json::json!(answer)))
    }

    /// Solves: the answer, the contact and its number of columns.
    ///
    /// # Errors
    /// [`CliError::Heights`] for what is wrong with the file or the options, [`CliError::HalfSpace`] for what the
    /// solver refuses.
    pub fn answer(&self) -> Result<(IndentAnswer, Indentation, usize), CliError> {
        let (dx, dy) = (positive("--dx", self.dx)?, positive("--dy", self.dy)?);
        let modulus = positive("--modulus", self.modulus)?;
        let poisson = poisson_ratio(self.poisson)?;
        let tolerance = positive("--tolerance", self.tolerance)?;
        let control = match (self.load, self.penetration) {
            (Some(load), _) => Control::Load(positive("--load", load)?),
            (None, penetration) => Control::Penetration(positive("--penetration", penetration.unwrap_or(f64::NAN))?),
        };
        let grid = read_grid(&self.heights)?;
        grid.check_unit(&self.heights, dx, dy)?;
        let (rows, columns) = (grid.rows, grid.columns);
        let map = HeightMap { heights: grid.values, extent: Extent { nx: rows, ny: columns }, dx, dy };
        let begin = Instant::now();
        let limits = Limits { tolerance, ..Limits::default() };
        let contact = indent(&map, modulus / (1.0 - poisson * poisson), control, limits)?;
        let answer = IndentAnswer {
            load: contact.load,
            penetration: contact.penetration,
            area_fraction: contact.area_fraction,
            iterations: contact.iterations,
            residual: contact.residual,
            seconds: begin.elapsed().as_secs_f64(),
        };
        Ok((answer, contact, columns))
    }
}
