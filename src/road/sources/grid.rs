//! Height maps given as a two-dimensional `.npy` array, or as text.

use std::collections::BTreeMap;

use super::height_map::{LARGEST_SPACING_OF_TABLE, RoadHeightMap, fill_missing, origins, plausible_spacing};
use super::raster::{self, HeightRaster};
use super::{missing, rounded, table};
use crate::road::error::{RoadError, positive};
use crate::road::file_fault::FileFault;
use crate::road::report::{RoadNote, RoadReport};
use crate::scene::{GridRoad, LengthUnit, Widen};
use crate::storage::array::Array;

/// Largest share of missing heights.
pub(super) const MISSING_ALLOWED: f64 = 0.2;

/// Columns and spacings \[m\] of an array, from its header; `None` for text, whose lattice is not known before it is
/// read.
///
/// # Errors
/// As [`read`], as far as the header can show.
pub(super) fn lattice(spec: &GridRoad) -> Result<Option<(usize, f64, f64)>, RoadError> {
    if !spec.is_array() {
        return Ok(None);
    }
    let (dx, dy) = spacings(spec)?;
    Ok(Some((open(spec)?.1.1, dx, dy)))
}

/// The spacings dx and dy given in the scene \[m\].
pub(super) fn spacings(spec: &GridRoad) -> Result<(f64, f64), RoadError> {
    let (Some(dx), Some(dy)) = (spec.dx, spec.dy) else {
        return Err(RoadError::file(&spec.file, FileFault::NoSpacing));
    };
    positive("road.dx", dx)?;
    positive("road.dy", dy)?;
    Ok((dx, dy))
}

/// The array, positioned behind its header, with its rows and columns.
pub(super) fn open(spec: &GridRoad) -> Result<(Array, (usize, usize)), RoadError> {
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

/// Reads an array, within a limit of bytes.
fn array(spec: &GridRoad, limit: u64) -> Result<HeightRaster, RoadError> {
    let path = &spec.file;
    let (dx, dy) = spacings(spec)?;
    let (file, (rows, columns)) = open(spec)?;
    let needed = (rows as u64).saturating_mul(columns as u64).saturating_mul(8);
    if needed > limit {
        return Err(RoadError::file(path, FileFault::TooLarge { needed, limit }));
    }
    let unit = spec.height_unit.map_or(1.0, LengthUnit::metres);
    let mut heights = file.into_values().map_err(|error| RoadError::file(path, error))?;
    if let Some(place) = heights.iter().position(|height| height.is_infinite()) {
        let (row, column) = (place / columns, place % columns);
        return Err(RoadError::file(path, FileFault::Infinite { row, column, value: heights[place] }));
    }
    heights.iter_mut().for_each(|height| *height *= unit);
    Ok(HeightRaster { dx, dy, columns, heights, unit, described: None, words: BTreeMap::new() })
}

/// Reads text, within a limit of bytes.
fn text(spec: &GridRoad, limit: u64) -> Result<HeightRaster, RoadError> {
    let bytes = table::bytes(&spec.file, limit)?;
    raster::read(spec, &bytes)
}

/// Refuses a grid narrower than the contact \[m\], unless it is to be mirrored.
pub(super) fn check_width(
    spec: &GridRoad,
    width: f64,
    contact_width: f64,
    notes: &mut Vec<RoadNote>,
) -> Result<(), RoadError> {
    if width < contact_width * (1.0 - 1e-9) {
        if spec.widen == Widen::Refuse {
            return Err(RoadError::Narrow { path: spec.file.clone(), needed: contact_width, available: width });
        }
        notes.push(RoadNote::Mirrored { measured: width, needed: contact_width });
    }
    Ok(())
}

/// Reads a grid, its columns centred on the tyre. `limit` bounds the bytes of the heights in memory.
///
/// # Errors
/// For a file that is neither a complete two-dimensional array of floating-point numbers nor text of a grid; for
/// infinite heights, too many missing ones, and a file that is too large.
pub(super) fn read(
    spec: &GridRoad,
    contact_width: f64,
    limit: u64,
    report: &mut RoadReport,
) -> Result<RoadHeightMap, RoadError> {
    let path = &spec.file;
    let fault = |fault| RoadError::file(path, fault);
    let raster = if spec.is_array() { array(spec, limit)? } else { text(spec, limit)? };
    let HeightRaster { dx, dy, columns, mut heights, .. } = raster;
    let plausible = |spacing| plausible_spacing(spacing, LARGEST_SPACING_OF_TABLE).map_err(fault);
    [dx, dy].into_iter().try_for_each(plausible)?;
    check_width(spec, columns as f64 * dy, contact_width, &mut report.notes)?;
    report.notes.extend(raster.described.map(|columns| RoadNote::FileColumns { columns }));
    report.points = heights.len();
    let given = spec.missing.as_deref();
    missing::note_words(raster.words, &mut report.notes);
    missing::mark(&mut heights, columns, |row| row as f64 * dx, raster.unit, given, &mut report.notes)
        .map_err(fault)?;
    rounded::add_notes(heights.iter().copied(), &mut report.notes);
    let origins = origins(&heights);
    report.missing = fill_missing(path, &mut heights, columns, MISSING_ALLOWED, &mut report.notes)?;
    let first_y = -0.5 * (columns as f64 - 1.0) * dy;
    Ok(RoadHeightMap { path: path.clone(), dx, dy, first_y, columns, heights, origins })
}
