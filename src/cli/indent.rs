//! `tyrewave indent`: a rigid rough body pressed into an elastic half-space. Its heights are a `.npy` array of two
//! dimensions.

use std::path::{Path, PathBuf};
use std::time::Instant;

use crate::half_space::rough::{Extent, HeightMap, IndentationControl, IndentationLimits, indent};
use crate::results::npy::{ArrayRow, NpyWriter};
use crate::storage::array::{Array, ArrayError};
use clap::Args;
use serde_json::json;

use super::context::{Context, print};
use super::error::CliError;
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

/// Largest median slope that is accepted as metres per metre: real textures, steps and spikes included, stay below 2.
const STEEPEST: f64 = 20.0;

/// Reads a grid of heights \[m\] above cells of `dx` x `dy` \[m\].
fn read_grid(path: &Path, [dx, dy]: [f64; 2]) -> Result<HeightMap, CliError> {
    let name = path.display();
    let fault = |error| match error {
        ArrayError::Io(source) => CliError::Read { path: path.to_owned(), source },
        other => CliError::Usage(format!("{name}: {other}")),
    };
    let array = Array::open(path).map_err(fault)?;
    let extent = match *array.shape() {
        [rows, columns] if rows > 0 && columns > 0 => Extent { nx: rows as usize, ny: columns as usize },
        ref shape => {
            return Err(CliError::Usage(format!(
                "{name} has shape {shape:?}: a two-dimensional array with at least one height is needed"
            )));
        }
    };
    let map = HeightMap { heights: array.into_values().map_err(fault)?, extent, dx, dy };
    check_unit(&map, path)?;
    Ok(map)
}

/// Refuses heights that are plausible in millimetres or micrometres only, by the median slope between neighbouring
/// finite heights: a few spikes or walls do not matter.
fn check_unit(map: &HeightMap, path: &Path) -> Result<(), CliError> {
    let (heights, columns) = (&map.heights, map.extent.ny);
    let across = heights.chunks_exact(columns).flat_map(|row| row.windows(2)).map(|z| (z[1] - z[0]).abs() / map.dy);
    let along = heights.iter().zip(heights.iter().skip(columns)).map(|(a, b)| (b - a).abs() / map.dx);
    let mut slopes: Vec<f64> = across.chain(along).filter(|slope| slope.is_finite()).collect();
    if slopes.is_empty() {
        return Ok(());
    }
    let middle = slopes.len() / 2;
    let slope = *slopes.select_nth_unstable_by(middle, f64::total_cmp).1;
    if slope <= STEEPEST {
        return Ok(());
    }
    let finite = || heights.iter().copied().filter(|z| z.is_finite());
    let unit = if slope < 1e3 * STEEPEST { "millimetres" } else { "micrometres" };
    let [least, greatest] = [finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max)];
    Err(CliError::Usage(format!(
        "the median slope of {} is {slope:.0}: heights or cell sizes are not in metres (most likely the heights \
         are in {unit}; they rise from {least} to {greatest})",
        path.display()
    )))
}

#[cfg(test)]
mod tests {
    use npyz::WriterBuilder;

    use super::*;

    fn grid(heights: Vec<f64>, columns: usize) -> HeightMap {
        HeightMap { extent: Extent { nx: heights.len() / columns, ny: columns }, heights, dx: 4e-3, dy: 2e-3 }
    }

    #[test]
    fn millimetres_and_micrometres_are_recognised() {
        let texture = |i: usize| 4e-4 * (i as f64 * 0.9).sin() + 1e-4 * (i as f64 * 2.3).cos();
        let in_unit = |unit: f64| grid((0..600).map(|i| texture(i) * unit).collect(), 20);
        let check = |map: &HeightMap| check_unit(map, Path::new("z.npy"));
        let unit = |map: &HeightMap| check(map).unwrap_err().to_string();
        assert!(check(&in_unit(1.0)).is_ok());
        assert!(unit(&in_unit(1e3)).contains("in millimetres"));
        assert!(unit(&in_unit(1e6)).contains("in micrometres"));
        // A wall and a spike half a metre high among flat parts; a sphere's cap; a single column.
        let mut steps = vec![0.0; 400];
        steps[..20].fill(0.5);
        steps[130] = 0.5;
        assert!(check(&grid(steps, 20)).is_ok());
        assert!(check(&grid(vec![0.0, f64::NAN, 1e-3], 1)).is_ok());
        assert!(check(&grid(vec![7.0], 1)).is_ok());
    }

    #[test]
    fn arrays_of_another_shape_or_none_at_all_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("z.npy");
        let mut bytes = Vec::new();
        let options = npyz::WriteOptions::new().default_dtype().shape(&[2, 3]).writer(&mut bytes);
        let mut writer = options.begin_nd().unwrap();
        writer.extend([0.0_f32, 1.0, 2.0, 3.0, 4.0, 5.0]).unwrap();
        writer.finish().unwrap();
        std::fs::write(&path, bytes).unwrap();
        let expected = HeightMap { dx: 1.0, dy: 1.0, ..grid(vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0], 3) };
        assert_eq!(read_grid(&path, [1.0; 2]).unwrap(), expected);
        let wrong = |error: Result<HeightMap, CliError>| error.unwrap_err().to_string();
        let mut bytes = Vec::new();
        let options = npyz::WriteOptions::new().default_dtype().shape(&[3]).writer(&mut bytes);
        let mut writer = options.begin_nd().unwrap();
        writer.extend([0.0_f32, 1.0, 2.0]).unwrap();
        writer.finish().unwrap();
        std::fs::write(&path, bytes).unwrap();
        assert!(wrong(read_grid(&path, [1.0; 2])).contains("has shape [3]"));
        std::fs::write(&path, b"heights").unwrap();
        assert!(wrong(read_grid(&path, [1.0; 2])).contains("is not a complete .npy array"));
        let missing = read_grid(&folder.path().join("none.npy"), [1.0; 2]);
        assert!(matches!(missing, Err(CliError::Read { .. })));
    }
}
