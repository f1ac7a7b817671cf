//! Height maps given as a two-dimensional `.npy` array.

use super::height_map::{HeightMap, LARGE_SPAN, fill_missing, missing, plausible_spacing};
use crate::road::error::{RoadError, positive};
use crate::road::file_fault::FileFault;
use crate::road::report::{RoadNote, RoadReport};
use crate::scene::GridRoad;
use crate::storage::array::Array;

/// Largest share of missing heights.
const MISSING_ALLOWED: f64 = 0.2;

/// Returns the number of columns, from the array's header.
///
/// # Errors
/// As [`read`], as far as the header tells.
pub(super) fn columns(spec: &GridRoad) -> Result<usize, RoadError> {
    Ok(open(spec)?.1.1)
}

/// Returns the file behind its header, rows and columns.
fn open(spec: &GridRoad) -> Result<(Array, (usize, usize)), RoadError> {
    let path = &spec.file;
    let fault = |fault: FileFault| RoadError::file(path, fault);
    let found = Array::open(path).map_err(|source| fault(source.into()))?;
    if !found.is_of_floats() {
        return Err(fault(FileFault::NpyType { found: found.type_name() }));
    }
    let &[rows, columns] = found.shape() else {
        return Err(fault(FileFault::NpyShape { shape: found.shape().to_vec() }));
    };
    let shape = (rows as usize, columns as usize);
    if rows < 2 || columns < 1 {
        return Err(fault(FileFault::TooFewPoints { found: shape.0.min(shape.1), needed: 2 }));
    }
    Ok((found, shape))
}

/// Reads a grid, its columns centred on the tyre. `limit` bounds the bytes of the heights in memory.
///
/// # Errors
/// Not a complete two-dimensional array of floating-point numbers; infinite heights, too many missing, or an
/// implausible span; too large.
pub(super) fn read(
    spec: &GridRoad,
    contact_width: f64,
    limit: u64,
    report: &mut RoadReport,
) -> Result<HeightMap, RoadError> {
    let path = &spec.file;
    positive("road.dx", spec.dx)?;
    positive("road.dy", spec.dy)?;
    let (file, (rows, columns)) = open(spec)?;
    let needed = (rows as u64).saturating_mul(columns as u64).saturating_mul(8);
    if needed > limit {
        return Err(RoadError::file(path, FileFault::TooLarge { needed, limit }));
    }
    [spec.dx, spec.dy].into_iter().try_for_each(plausible_spacing).map_err(|fault| RoadError::file(path, fault))?;
    let width = columns as f64 * spec.dy;
    if width < contact_width * (1.0 - 1e-9) {
        return Err(RoadError::Narrow { path: path.clone(), needed: contact_width, available: width });
    }
    let mut heights = file.into_values().map_err(|error| RoadError::file(path, error))?;
    if let Some(place) = heights.iter().position(|height| height.is_infinite()) {
        let (row, column) = (place / columns, place % columns);
        return Err(RoadError::file(path, FileFault::Infinite { row, column, value: heights[place] }));
    }
    report.points = heights.len();
    let missing = missing(&heights);
    report.missing = fill_missing(path, &mut heights, columns, MISSING_ALLOWED, &mut report.notes)?;
    let first_y = -0.5 * (columns as f64 - 1.0) * spec.dy;
    let map = HeightMap { path: path.clone(), dx: spec.dx, dy: spec.dy, first_y, columns, heights, missing };
    let span = map.plausible_span()?;
    if span > LARGE_SPAN {
        report.notes.push(RoadNote::LargeSpan { span });
    }
    Ok(map)
}
