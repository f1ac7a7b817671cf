//! Heights given on the command line: a `.npy` array of one or two dimensions.

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use npyz::{DType, NpyFile, Order, TypeChar};
use thiserror::Error;

/// Steepest median slope that is taken for metres: real textures, steps and spikes included, stay below 2.
const STEEPEST: f64 = 20.0;

/// Heights that cannot be used.
#[derive(Debug, Error)]
pub enum HeightsError {
    /// The file cannot be opened.
    #[error("cannot read {}: {source}", path.display())]
    Open {
        /// The file.
        path: PathBuf,
        /// The system's answer.
        source: std::io::Error,
    },
    /// The file is no complete `.npy` array.
    #[error("{} is not a complete .npy array: {source}", path.display())]
    Npy {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: std::io::Error,
    },
    /// The array holds something else than real numbers.
    #[error("{} holds {found}: heights must be real numbers", path.display())]
    Type {
        /// The file.
        path: PathBuf,
        /// Its type descriptor.
        found: String,
    },
    /// The array has another number of dimensions.
    #[error("{} has shape {shape:?}: {wanted} with at least one height is needed", path.display())]
    Shape {
        /// The file.
        path: PathBuf,
        /// Its shape.
        shape: Vec<u64>,
        /// What would do.
        wanted: &'static str,
    },
    /// Heights that are hardly in metres.
    #[error(
        "the median slope of {} is {slope:.0}: heights or cell sizes are not in metres (most likely the heights are in {unit}; they rise \
         from {least} to {greatest})",
        path.display()
    )]
    Unit {
        /// The file.
        path: PathBuf,
        /// Median of the slopes between neighbours.
        slope: f64,
        /// The unit that gives plausible slopes.
        unit: &'static str,
        /// Lowest value.
        least: f64,
        /// Highest value.
        greatest: f64,
    },
    /// A length or constant on the command line that makes no sense.
    #[error("{option} {value}: {wanted}")]
    Value {
        /// The option.
        option: &'static str,
        /// What was given.
        value: f64,
        /// What it must be.
        wanted: &'static str,
    },
}

/// A row (one dimension) or a grid of heights \[m\], row-major.
#[derive(Clone, Debug, PartialEq)]
pub struct Heights {
    /// Heights, rows x columns.
    pub values: Vec<f64>,
    /// Rows; 1 for a one-dimensional array.
    pub rows: usize,
    /// Columns.
    pub columns: usize,
}

/// Reads one row of heights.
///
/// # Errors
/// [`HeightsError`], for an array of more than one dimension too.
pub fn read_row(path: &Path) -> Result<Heights, HeightsError> {
    read(path, "a one-dimensional array", |shape| match *shape {
        [columns] => Some((1, columns)),
        _ => None,
    })
}

/// Reads a grid of heights.
///
/// # Errors
/// [`HeightsError`], for an array of other than two dimensions too.
pub fn read_grid(path: &Path) -> Result<Heights, HeightsError> {
    read(path, "a two-dimensional array", |shape| match *shape {
        [rows, columns] => Some((rows, columns)),
        _ => None,
    })
}

fn read(
    path: &Path,
    wanted: &'static str,
    sizes: impl Fn(&[u64]) -> Option<(u64, u64)>,
) -> Result<Heights, HeightsError> {
    let file = File::open(path).map_err(|source| HeightsError::Open { path: path.to_owned(), source })?;
    let fault = |source| HeightsError::Npy { path: path.to_owned(), source };
    let npy = NpyFile::new(BufReader::new(file)).map_err(fault)?;
    let shape = npy.shape().to_vec();
    let Some((rows, columns)) = sizes(&shape).filter(|&(rows, columns)| rows > 0 && columns > 0) else {
        return Err(HeightsError::Shape { path: path.to_owned(), shape, wanted });
    };
    let (rows, columns) = (rows as usize, columns as usize);
    let kind = npy.dtype();
    let DType::Plain(plain) = &kind else {
        return Err(HeightsError::Type { path: path.to_owned(), found: kind.descr() });
    };
    let order = npy.order();
    let stored: Vec<f64> = match (plain.type_char(), plain.size_field()) {
        (TypeChar::Float, 8) => npy.into_vec().map_err(fault)?,
        (TypeChar::Float, 4) => npy.into_vec::<f32>().map_err(fault)?.into_iter().map(f64::from).collect(),
        (TypeChar::Int, 8) => npy.into_vec::<i64>().map_err(fault)?.into_iter().map(|z| z as f64).collect(),
        (TypeChar::Int, 4) => npy.into_vec::<i32>().map_err(fault)?.into_iter().map(f64::from).collect(),
        _ => return Err(HeightsError::Type { path: path.to_owned(), found: kind.descr() }),
    };
    let values = match order {
        Order::C => stored,
        Order::Fortran => (0..rows * columns).map(|place| stored[place % columns * rows + place / columns]).collect(),
    };
    Ok(Heights { values, rows, columns })
}

/// A positive, finite value of an option.
///
/// # Errors
/// [`HeightsError::Value`].
pub fn positive(option: &'static str, value: f64) -> Result<f64, HeightsError> {
    if value > 0.0 && value.is_finite() {
        Ok(value)
    } else {
        Err(HeightsError::Value { option, value, wanted: "must be positive and finite" })
    }
}

/// A Poisson's ratio: in (-1, 0.5\].
///
/// # Errors
/// [`HeightsError::Value`].
pub fn poisson_ratio(value: f64) -> Result<f64, HeightsError> {
    if value > -1.0 && value <= 0.5 {
        Ok(value)
    } else {
        Err(HeightsError::Value {
            option: "--poisson",
            value,
            wanted: "Poisson's ratio lies above -1 and at most at 0.5",
        })
    }
}

impl Heights {
    /// Refuses heights that are plausible in millimetres or micrometres only: the median slope between neighbouring
    /// finite heights, so that a few spikes or walls do not matter.
    ///
    /// # Errors
    /// [`HeightsError::Unit`].
    pub fn check_unit(&self, path: &Path, dx: f64, dy: f64) -> Result<(), HeightsError> {
        let columns = self.columns;
        let across = self.values.chunks_exact(columns).flat_map(|row| row.windows(2)).map(|z| (z[1] - z[0]).abs() / dy);
        let along = self.values.iter().zip(self.values.iter().skip(columns)).map(|(a, b)| (b - a).abs() / dx);
        let mut slopes: Vec<f64> = across.chain(along).filter(|slope| slope.is_finite()).collect();
        if slopes.is_empty() {
            return Ok(());
        }
        let middle = slopes.len() / 2;
        let slope = *slopes.select_nth_unstable_by(middle, f64::total_cmp).1;
        if slope <= STEEPEST {
            return Ok(());
        }
        let finite = || self.values.iter().copied().filter(|z| z.is_finite());
        Err(HeightsError::Unit {
            path: path.to_owned(),
            slope,
            unit: if slope < 1e3 * STEEPEST { "millimetres" } else { "micrometres" },
            least: finite().fold(f64::INFINITY, f64::min),
            greatest: finite().fold(f64::NEG_INFINITY, f64::max),
        })
    }
}

#[cfg(test)]
mod tests {
    use npyz::WriterBuilder;

    use super::*;

    fn grid(values: Vec<f64>, columns: usize) -> Heights {
        Heights { rows: values.len() / columns, columns, values }
    }

    #[test]
    fn millimetres_and_micrometres_are_recognised_and_steps_are_not_mistaken_for_them() {
        let texture = |i: usize| 4e-4 * (i as f64 * 0.9).sin() + 1e-4 * (i as f64 * 2.3).cos();
        let in_unit = |unit: f64| grid((0..600).map(|i| texture(i) * unit).collect(), 20);
        let check = |heights: &Heights| heights.check_unit(Path::new("z.npy"), 4e-3, 2e-3);
        assert!(check(&in_unit(1.0)).is_ok());
        assert!(matches!(check(&in_unit(1e3)), Err(HeightsError::Unit { unit: "millimetres", .. })));
        assert!(matches!(check(&in_unit(1e6)), Err(HeightsError::Unit { unit: "micrometres", .. })));
        // A wall and a spike half a metre high among flat parts; a sphere's cap; a single column.
        let mut steps = vec![0.0; 400];
        steps[..20].fill(0.5);
        steps[130] = 0.5;
        assert!(check(&grid(steps, 20)).is_ok());
        assert!(check(&grid(vec![0.0, f64::NAN, 1e-3], 1)).is_ok());
        assert!(check(&grid(vec![7.0], 1)).is_ok());
    }

    #[test]
    fn arrays_of_either_order_and_type_are_read_alike() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("z.npy");
        let write = |order, values: &[f32]| {
            let mut bytes = Vec::new();
            let options = npyz::WriteOptions::new().default_dtype().order(order).shape(&[2, 3]).writer(&mut bytes);
            let mut writer = options.begin_nd().unwrap();
            writer.extend(values).unwrap();
            writer.finish().unwrap();
            std::fs::write(&path, bytes).unwrap();
            read_grid(&path).unwrap()
        };
        let expected = grid(vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0], 3);
        assert_eq!(write(Order::C, &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0]), expected);
        assert_eq!(write(Order::Fortran, &[0.0, 3.0, 1.0, 4.0, 2.0, 5.0]), expected);
        assert!(matches!(read_row(&path), Err(HeightsError::Shape { .. })));
        std::fs::write(&path, b"heights").unwrap();
        assert!(matches!(read_grid(&path), Err(HeightsError::Npy { .. })));
        assert!(matches!(read_grid(&folder.path().join("none.npy")), Err(HeightsError::Open { .. })));
    }
}
