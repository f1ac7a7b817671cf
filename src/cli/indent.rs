//! `tyrewave indent`: a rigid rough body pressed into an elastic half-space.

use std::path::PathBuf;
use std::time::Instant;

use crate::half_space::rough::{IndentationControl, IndentationLimits, indent};
use crate::results::npy::{ArrayRow, NpyWriter};
use clap::Args;
use serde_json::json;

use super::context::{Context, print};
use super::error::CliError;
use super::heights::read_grid;
use super::options::{poisson_ratio, positive};
use super::output_file::{OutputFile, Replaces};

const EXAMPLES: &str = "\
Frictionless contact of the height map (peaks touch first) with a half-space of the given modulus, without \
periodicity. Printed as JSON: load [N], penetration [m] of the highest peak, share of the cells in contact, iterations \
on the finest grid, residual (the largest gap under pressure, or overlap without pressure, relative to the \
penetration) and seconds.

Examples:
  tyrewave indent --heights grid.npy --dx 0.001 --dy 0.001 --modulus 1e7 --poisson 0.45 --penetration 0.002
  tyrewave indent --heights grid.npy --dx 0.001 --dy 0.001 --modulus 1e7 --poisson 0.45 --load 700 --out pressure.npy";

#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
#[command(allow_negative_numbers = true)]
pub(crate) struct IndentArguments {
    /// Heights, in m: a two-dimensional .npy array, rows along x, columns along y.
    #[arg(long, value_name = "GRID.npy")]
    heights: PathBuf,
    /// Spacing of the rows, in m.
    #[arg(long, value_name = "M", value_parser = positive, allow_negative_numbers = true)]
    dx: f64,
    /// Spacing of the columns, in m.
    #[arg(long, value_name = "M", value_parser = positive, allow_negative_numbers = true)]
    dy: f64,
    /// Young's modulus of the half-space, in Pa.
    #[arg(long, value_name = "E", value_parser = positive, allow_negative_numbers = true)]
    modulus: f64,
    /// Poisson's ratio of the half-space.
    #[arg(long, value_name = "P", value_parser = poisson_ratio)]
    poisson: f64,
    /// Normal load, in N.
    #[arg(
        long,
        value_name = "N",
        conflicts_with = "penetration",
        required_unless_present = "penetration",
        value_parser = positive,
        allow_negative_numbers = true
    )]
    load: Option<f64>,
    /// Penetration of the highest peak, in m.
    #[arg(long, value_name = "M", value_parser = positive, allow_negative_numbers = true)]
    penetration: Option<f64>,
    /// Tolerance of the contact conditions, relative to the penetration.
    #[arg(long, value_name = "T", default_value_t = IndentationLimits::default().tolerance)]
    #[arg(value_parser = positive, allow_negative_numbers = true)]
    tolerance: f64,
    /// File for the pressure in Pa, an array of the heights' shape. An existing file is refused without --force.
    #[arg(long, value_name = "PRESSURE.npy")]
    out: Option<PathBuf>,
    /// Replace PRESSURE.npy if it exists; the heights are never replaced.
    #[arg(long, requires = "out")]
    force: bool,
}

impl IndentArguments {
    pub(crate) fn execute(self, _: &Context) -> Result<(), CliError> {
        let Self { dx, dy, modulus, poisson, tolerance, .. } = self;
        let control = match (self.load, self.penetration) {
            (Some(load), _) => IndentationControl::Load(load),
            (None, penetration) => IndentationControl::Penetration(penetration.unwrap_or(f64::NAN)),
        };
        let inputs = [self.heights.as_path()];
        let replaces = if self.force { Replaces::AllBut(&inputs) } else { Replaces::Nothing("--force") };
        let out = self.out.as_deref().map(|path| OutputFile::begin(path, replaces)).transpose()?;
        let map = read_grid(&self.heights, [dx, dy])?;
        let begin = Instant::now();
        let limits = IndentationLimits { tolerance, ..IndentationLimits::default() };
        let contact = indent(&map, modulus / (1.0 - poisson * poisson), control, limits)
            .map_err(|error| CliError::from(error).in_file(&self.heights))?;
        let answer = json!({
            "load": contact.load,
            "penetration": contact.penetration,
            "area_fraction": contact.area_fraction,
            "iterations": contact.iterations,
            "residual": contact.residual,
            "seconds": begin.elapsed().as_secs_f64(),
        });
        if let Some(file) = out {
            let mut writer = NpyWriter::create(file.temporary(), ArrayRow::Columns(map.extent.ny))?;
            for row in contact.pressure.chunks_exact(map.extent.ny) {
                writer.push(row)?;
            }
            writer.finish()?;
            file.publish()?;
        }
        print(&format!("{answer:#}\n"))
    }
}
