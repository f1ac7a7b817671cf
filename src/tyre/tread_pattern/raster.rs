//! Depths of a tread from a file.

use std::path::Path;

use super::PatternFault;
use crate::scene::short;
use crate::storage::array::Array;
use crate::storage::input::{self, TABLE_BYTES};

/// Depths on a raster, row by row along.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Raster {
    /// Rows along.
    pub rows: usize,
    /// Columns across, from the right.
    pub columns: usize,
    /// Depths \[m\], row-major.
    pub depths: Vec<f64>,
}

impl Raster {
    /// Reads an array, or with `black` a picture whose black is that deep \[m\]; refuses depths outside 0 to `deepest`
    /// \[m\].
    pub(super) fn read(path: &Path, black: Option<f64>, deepest: f64) -> Result<Self, PatternFault> {
        let fault = |wrong: String| {
            let right = "name a two-dimensional .npy array of depths in metres, along and across, or a .png";
            PatternFault::new("file", format!("{}: {wrong}", path.display()), right)
        };
        let raster = match black {
            Some(depth) => picture(path, depth).map_err(fault)?,
            None => array(path).map_err(fault)?,
        };
        if raster.depths.is_empty() {
            return Err(fault("it has no cells".to_owned()));
        }
        let place = raster.depths.iter().position(|depth| !(0.0..=deepest).contains(depth));
        if let Some(place) = place {
            let (row, column, depth) = (place / raster.columns, place % raster.columns, raster.depths[place]);
            let wrong = format!("the depth in row {row}, column {column} is {depth} m");
            let right = format!(
                "depths in metres from 0 to {}, none missing: 1 mm of the tread stays under them",
                short((1e6 * deepest).round() / 1e6)
            );
            return Err(PatternFault::new("file", wrong, right));
        }
        Ok(raster)
    }
}

fn array(path: &Path) -> Result<Raster, String> {
    let array = Array::open(path).map_err(|error| error.to_string())?;
    let &[rows, columns] = array.shape() else {
        return Err(format!("it has the shape {:?}", array.shape()));
    };
    let depths = array.into_values().map_err(|error| error.to_string())?;
    Ok(Raster { rows: rows as usize, columns: columns as usize, depths })
}

/// Reads a picture: rows along, white the surface, black `depth` \[m\] deep, grey between; transparent points are
/// white.
fn picture(path: &Path, depth: f64) -> Result<Raster, String> {
    let bytes = input::read(path, TABLE_BYTES).map_err(|error| error.to_string())?;
    let mut decoder = png::Decoder::new(std::io::Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::EXPAND | png::Transformations::STRIP_16);
    let mut reader = decoder.read_info().map_err(|error| error.to_string())?;
    let size = reader.output_buffer_size().filter(|size| *size as u64 <= TABLE_BYTES);
    let mut bytes = vec![0; size.ok_or("it is too large")?];
    let info = reader.next_frame(&mut bytes).map_err(|error| error.to_string())?;
    let samples = info.color_type.samples();
    let (rows, columns) = (info.height as usize, info.width as usize);
    let dark = |pixel: &[u8]| {
        let (colours, alpha) = match pixel {
            [colours @ .., alpha] if samples % 2 == 0 => (colours, f64::from(*alpha) / 255.0),
            all => (all, 1.0),
        };
        let light = colours.iter().map(|part| f64::from(*part)).sum::<f64>() / (255 * colours.len().max(1)) as f64;
        alpha * (1.0 - light)
    };
    let pixels = bytes[..info.buffer_size()].chunks_exact(samples);
    Ok(Raster { rows, columns, depths: pixels.map(|pixel| depth * dark(pixel)).collect() })
}
