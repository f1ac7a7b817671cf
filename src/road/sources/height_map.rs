//! A measured piece of road on a uniform lattice: the result of every reader.

use std::path::{Path, PathBuf};

use crate::numeric::windowed_sinc::WindowedSinc;
use crate::road::error::RoadError;
use crate::road::file_fault::FileFault;
use crate::road::report::RoadNote;
use crate::road::texture::{HeightOrigin, line_of, rms};

/// Heights that span more than this are more than texture \[m\].
pub(crate) const LARGE_SPAN: f64 = 0.1;
/// Largest span of heights that a texture can have \[m\].
const LARGEST_SPAN: f64 = 0.5;

/// Least root-mean-square heights \[m\]: of anything measured on a road, and of roads in use.
const SMOOTHEST: [f64; 2] = [1e-6, 20e-6];
/// Largest remainder of an exact plane after levelling \[m\].
const ROUNDING: f64 = 1e-12;

/// Least plausible spacing of a measured road \[m\]: well below a laser spot.
const LEAST_SPACING: f64 = 1e-6;

/// Largest plausible spacing \[m\] of a file that states its unit: well above a wheel.
pub(crate) const LARGEST_SPACING: f64 = 10.0;

/// Largest plausible spacing \[m\] where its unit may be mistaken: above a foot, the coarsest of profilers for
/// evenness; 0.5 or 1 mm read as metres lie above.
pub(crate) const LARGEST_SPACING_OF_TABLE: f64 = 0.4;

/// Most lengths of the road that the trend's kernel may span, the road being reflected at its ends.
const MOST_TURNS: f64 = 100.0;
/// Most products for a trend: they take minutes.
const MOST_PRODUCTS: f64 = 1e11;

/// Heights on a uniform lattice. Row r lies at road coordinate r `dx`, column c at y = `first_y` + c `dy` from the
/// tyre's middle. A single column with `dy` = 0 is level across.
#[derive(Clone, Debug, PartialEq)]
pub struct RoadHeightMap {
    /// File that it was read from, for messages.
    pub path: PathBuf,
    /// Row spacing \[m\].
    pub dx: f64,
    /// Column spacing \[m\]; 0: the only column holds for every y.
    pub dy: f64,
    /// Lateral position of column 0 \[m\].
    pub first_y: f64,
    /// Number of columns.
    pub columns: usize,
    /// Row-major heights \[m\], rows x columns, finite.
    pub heights: Vec<f64>,
    /// Origin of each of them; empty if all were measured.
    pub origins: Vec<HeightOrigin>,
}

impl RoadHeightMap {
    /// Heights along the road in each column.
    pub fn rows(&self) -> usize {
        self.heights.len() / self.columns.max(1)
    }

    /// Road coordinate of the last row \[m\]; the first is at 0.
    pub fn end(&self) -> f64 {
        (self.rows() as f64 - 1.0) * self.dx
    }

    /// Heights of one column, along the road \[m\].
    pub fn column(&self, column: usize) -> Vec<f64> {
        self.heights.iter().skip(column).step_by(self.columns).copied().collect()
    }

    /// Origins of the heights of a column; empty if all of the map were measured.
    pub(crate) fn origins_of(&self, column: usize) -> Vec<HeightOrigin> {
        self.origins.iter().skip(column).step_by(self.columns).copied().collect()
    }

    /// Highest minus lowest height \[m\].
    pub fn span(&self) -> f64 {
        let (low, high) = self
            .heights
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &height| (low.min(height), high.max(height)));
        high - low
    }

    /// The span \[m\], refused if it is larger than any texture's: the heights are most likely in millimetres.
    pub fn plausible_span(&self) -> Result<f64, RoadError> {
        plausible_span(&self.path, self.span())
    }

    /// Refuses a road smoother than any, whose heights are in another unit or in another column, and notes one that is
    /// suspiciously smooth. `may_be_plane`: an exact plane is accepted.
    pub(crate) fn check_smoothness(&self, may_be_plane: bool, notes: &mut Vec<RoadNote>) -> Result<(), RoadError> {
        check_smoothness(&self.path, rms(&self.heights), may_be_plane, notes)
    }

    /// Subtracts what varies more slowly along the road than `longest` \[m\]: the low-passed mean and cross slope of
    /// the rows. Wavelengths shorter than 0.8 `longest` are not changed.
    ///
    /// # Errors
    /// [`RoadError::Trend`] for a wavelength so far beyond the road's length or spacing that it would take too long.
    pub fn remove_trend(&mut self, longest: f64) -> Result<(), RoadError> {
        let columns = self.columns;
        // 1. Mean and cross slope of every row.
        let lines: Vec<(f64, f64)> = self.heights.chunks_exact(columns).map(line_of).collect();
        // 2. The kernel blocks from 0.5 cycles per unit on: a unit of half the shortest wavelength that must stay.
        let unit = 0.5 * 0.8 * longest / self.dx;
        if unit < 1.0 {
            return Ok(());
        }
        let kernel = WindowedSinc::resampling();
        let taps = 2.0 * kernel.half_width * unit;
        if taps > MOST_TURNS * lines.len() as f64 || taps * lines.len() as f64 > MOST_PRODUCTS {
            return Err(RoadError::Trend { path: self.path.clone(), longest, length: self.end(), spacing: self.dx });
        }
        // 3. Low-passed along the road, reflected at its ends, and subtracted row by row.
        let mut weights = Vec::new();
        let rows = lines.len() as i64;
        for (r, row) in self.heights.chunks_exact_mut(columns).enumerate() {
            let first = kernel.weights(r as f64, unit, &mut weights);
            let (mut mean, mut slope) = (0.0, 0.0);
            for (tap, weight) in weights.iter().enumerate() {
                let (row_mean, row_slope) = lines[reflected(first + tap as i64, rows)];
                mean += weight * row_mean;
                slope += weight * row_slope;
            }
            for (c, height) in row.iter_mut().enumerate() {
                *height -= mean + slope * (c as f64 - 0.5 * (columns as f64 - 1.0));
            }
        }
        Ok(())
    }
}

/// The span of heights \[m\], see [`RoadHeightMap::plausible_span`].
pub(super) fn plausible_span(path: &Path, span: f64) -> Result<f64, RoadError> {
    let allowed = LARGEST_SPAN;
    if span > allowed { Err(RoadError::file(path, FileFault::ImplausibleHeights { span, allowed })) } else { Ok(span) }
}

/// As [`RoadHeightMap::check_smoothness`], for the root mean square of heights \[m\].
pub(super) fn check_smoothness(
    path: &Path,
    rms: f64,
    may_be_plane: bool,
    notes: &mut Vec<RoadNote>,
) -> Result<(), RoadError> {
    let [least, usual] = SMOOTHEST;
    if may_be_plane && rms < ROUNDING {
        return Ok(());
    }
    if rms < least {
        return Err(RoadError::file(path, FileFault::TooFlat { rms }));
    }
    if rms < usual {
        notes.push(RoadNote::AlmostFlat { rms });
    }
    Ok(())
}

/// Refuses a spacing \[m\] that no instrument has, or above `most`: a unit or a scale must be wrong.
pub(crate) fn plausible_spacing(spacing: f64, most: f64) -> Result<(), FileFault> {
    let least = LEAST_SPACING;
    if (least..=most).contains(&spacing) { Ok(()) } else { Err(FileFault::ImplausibleSpacing { spacing, least, most }) }
}

/// Subtracts the least-squares plane from a row-major map; returns its mean and its slopes along and across, per row
/// and column.
pub(crate) fn remove_plane(heights: &mut [f64], columns: usize) -> [f64; 3] {
    let means: Vec<f64> = heights.chunks_exact(columns).map(|row| row.iter().sum::<f64>() / columns as f64).collect();
    let mut across = vec![0.0; columns];
    for row in heights.chunks_exact(columns) {
        for (sum, height) in across.iter_mut().zip(row) {
            *sum += height / means.len() as f64;
        }
    }
    let (mean, along) = line_of(&means);
    let (_, slope) = line_of(&across);
    let middle = (0.5 * (means.len() as f64 - 1.0), 0.5 * (columns as f64 - 1.0));
    for (r, row) in heights.chunks_exact_mut(columns).enumerate() {
        for (c, height) in row.iter_mut().enumerate() {
            *height -= mean + along * (r as f64 - middle.0) + slope * (c as f64 - middle.1);
        }
    }
    [mean, along, slope]
}

/// An index reflected at the ends of 0..count, the end samples not doubled.
pub(crate) fn reflected(index: i64, count: i64) -> usize {
    if (0..count).contains(&index) {
        return index as usize;
    }
    if count <= 1 {
        return 0;
    }
    let period = 2 * (count - 1);
    let folded = index.rem_euclid(period);
    (if folded < count { folded } else { period - folded }) as usize
}

/// Origins of heights of which those that are NaN are missing; empty if none is.
pub(crate) fn origins(heights: &[f64]) -> Vec<HeightOrigin> {
    if !heights.iter().any(|height| height.is_nan()) {
        return Vec::new();
    }
    let origin = |height: &f64| if height.is_nan() { HeightOrigin::Missing } else { HeightOrigin::Measured };
    heights.iter().map(origin).collect()
}

/// Fills missing (NaN) heights of a row-major map by linear interpolation across, then along; at a border the nearest
/// valid height is held. Returns their number.
///
/// # Errors
/// If more than the share `allowed` is missing.
pub(crate) fn fill_missing(
    path: &Path,
    heights: &mut [f64],
    columns: usize,
    allowed: f64,
    notes: &mut Vec<RoadNote>,
) -> Result<usize, RoadError> {
    let missing = heights.iter().filter(|height| height.is_nan()).count();
    note_missing(path, [missing, heights.len()], allowed, notes)?;
    if missing > 0 {
        fill(heights, columns);
    }
    Ok(missing)
}

/// Notes how many heights of all are missing, if any is.
///
/// # Errors
/// If more than the share `allowed` is missing.
pub(super) fn note_missing(
    path: &Path,
    [missing, total]: [usize; 2],
    allowed: f64,
    notes: &mut Vec<RoadNote>,
) -> Result<(), RoadError> {
    if missing as f64 > allowed * total as f64 {
        return Err(RoadError::file(path, FileFault::TooManyMissing { missing, total, allowed }));
    }
    notes.extend((missing > 0).then_some(RoadNote::Filled { missing, total }));
    Ok(())
}

/// Fills missing (NaN) heights as [`fill_missing`] does, however many there are.
pub(crate) fn fill(heights: &mut [f64], columns: usize) {
    let rows = heights.len() / columns;
    let mut line = vec![0.0; columns.max(rows)];
    for row in heights.chunks_exact_mut(columns) {
        // Across only between valid neighbours: towards a border the road is continued along, not level across.
        fill_line(row, false);
    }
    for column in 0..columns {
        for row in 0..rows {
            line[row] = heights[row * columns + column];
        }
        fill_line(&mut line[..rows], true);
        for row in 0..rows {
            heights[row * columns + column] = line[row];
        }
    }
    for row in heights.chunks_exact_mut(columns) {
        // A column without a single valid height is left: it gets its neighbour's heights.
        fill_line(row, true);
    }
}

/// Interpolates runs of NaN linearly; runs at the ends get the nearest valid value if `hold`. A line of NaN only is not
/// changed.
pub(crate) fn fill_line(line: &mut [f64], hold: bool) {
    let mut last: Option<usize> = None;
    for index in 0..line.len() {
        if line[index].is_nan() {
            continue;
        }
        match last {
            Some(before) if before + 1 < index => {
                let (from, to) = (line[before], line[index]);
                let steps = (index - before) as f64;
                for (step, hole) in line[before + 1..index].iter_mut().enumerate() {
                    *hole = from + (to - from) * (step + 1) as f64 / steps;
                }
            }
            None if hold => {
                let value = line[index];
                line[..index].fill(value);
            }
            _ => {}
        }
        last = Some(index);
    }
    if let (true, Some(before)) = (hold, last) {
        let value = line[before];
        line[before + 1..].fill(value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::road::error::RoadFileFault;

    const N: f64 = f64::NAN;

    #[test]
    fn holes_are_interpolated_across_then_along() {
        let mut heights = vec![1.0, N, 3.0, N, 4.0, 5.0, 5.0, 6.0, N];
        let mut notes = Vec::new();
        assert_eq!(fill_missing(Path::new("x"), &mut heights, 3, 0.5, &mut notes).unwrap(), 3);
        assert_eq!(heights, [1.0, 2.0, 3.0, 3.0, 4.0, 5.0, 5.0, 6.0, 5.0]);
        assert_eq!(notes, [RoadNote::Filled { missing: 3, total: 9 }]);
        let refused = fill_missing(Path::new("x"), &mut [1.0, N, N, N], 2, 0.5, &mut notes);
        assert!(matches!(
            refused,
            Err(RoadError::File { fault: RoadFileFault(FileFault::TooManyMissing { missing: 3, total: 4, .. }), .. })
        ));
    }

    #[test]
    fn plane_is_removed_exactly_and_texture_kept() {
        let texture = |r: usize, c: usize| if (r / 2 + c / 2).is_multiple_of(2) { 1e-3 } else { -1e-3 };
        let build = |tilt: f64| -> Vec<f64> {
            let height = |(r, c)| texture(r, c) + tilt * (5.0 + 0.3 * r as f64 - 0.2 * c as f64);
            (0..64).map(|i| height((i / 8, i % 8))).collect()
        };
        let (mut tilted, mut level) = (build(1.0), build(0.0));
        remove_plane(&mut tilted, 8);
        remove_plane(&mut level, 8);
        for (a, b) in tilted.iter().zip(&level) {
            assert!((a - b).abs() < 1e-14);
        }
    }

    #[test]
    fn trend_longer_than_asked_goes_and_shorter_stays() {
        let wave = |r: usize, wavelength: f64| (2.0 * std::f64::consts::PI * r as f64 * 0.01 / wavelength).cos();
        let mut map = RoadHeightMap {
            path: PathBuf::new(),
            dx: 0.01,
            dy: 0.0,
            first_y: 0.0,
            columns: 1,
            heights: (0..2001).map(|r| wave(r, 4.0) + wave(r, 0.2)).collect(),
            origins: Vec::new(),
        };
        map.remove_trend(1.0).unwrap();
        assert!(matches!(map.remove_trend(1e6), Err(RoadError::Trend { .. })), "50 000 times the road's length");
        for (r, height) in map.heights.iter().enumerate() {
            assert!((height - wave(r, 0.2)).abs() < 2e-3, "row {r}: {height}");
        }
    }

    #[test]
    fn reflection_does_not_double_the_ends() {
        let found: Vec<usize> = (-3..7).map(|i| reflected(i, 4)).collect();
        assert_eq!(found, [3, 2, 1, 0, 1, 2, 3, 2, 1, 0]);
        assert_eq!(reflected(-5, 1), 0);
    }
}
