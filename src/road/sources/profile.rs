//! Measured longitudinal profiles: CAPTIF `.dat`, ERD, and tables of text.
//!
//! 1. Read distance and height; a CAPTIF file states its units, for a CSV the scene does. Missing heights are empty or
//!    `NaN`.
//! 2. Sort by distance, average points at one distance (many of them are refused), cut to `range` (CAPTIF: between the
//!    reference plates).
//! 3. CAPTIF only: points outlandishly far from the median count as dropouts (the laser sensor gives such values).
//! 4. Interpolate linearly to a uniform spacing, the mean of the file's, across dropouts as well.
//!    Road coordinate 0 is the first point used.

use super::columns::FilePoint;
use super::height_map::{LARGEST_SPACING_OF_TABLE, RoadHeightMap, plausible_spacing};
use super::signature::refuse_other_kinds;
use super::{missing, rounded, table};
use crate::road::error::RoadError;
use crate::road::file_fault::FileFault;
use crate::road::report::{RoadNote, RoadReport};
use crate::road::texture::HeightOrigin;
use crate::scene::ProfileRoad;

/// Part between the reference plates of a CAPTIF track \[m\].
const CAPTIF_RANGE: [f64; 2] = [0.0623, 1.8704];
/// Heights so many scaled median deviations away from the median are dropouts: at CAPTIF's station 1, heights of 47 mm
/// remain after the removal of spikes.
const OUTLIER_FACTOR: f64 = 8.0;
/// Largest share of missing heights.
const MISSING_ALLOWED: f64 = 0.25;
/// Distance, in spacings, within which a valid point of the file is needed for a point of the lattice to count as
/// measured: where distances are uneven, half a spacing would not do.
const NEARBY: f64 = 0.75;
/// Largest share of points at the distance of another one and not at its height: more are passes beside each other.
const COINCIDING_ALLOWED: f64 = 0.05;
/// Fewest usable points.
const FEWEST_POINTS: usize = 8;

/// Reads a profile as a map of one column, level across. `limit` bounds the bytes read.
///
/// # Errors
/// For a missing file, no numbers where they should be (with line and column), no units, too few points, too many
/// missing.
pub(crate) fn read(spec: &ProfileRoad, limit: u64, report: &mut RoadReport) -> Result<RoadHeightMap, RoadError> {
    let path = &spec.file;
    let fault = |fault| RoadError::file(path, fault);
    let bytes = table::bytes(path, limit)?;
    refuse_other_kinds(&bytes, "profile").map_err(fault)?;
    let (mut points, unit) = table::points(spec, &bytes, &mut report.notes)?;
    let captif = table::is_captif(&bytes);
    // A kilometre has ten million points: nothing is held longer than it is needed.
    drop(bytes);
    points.shrink_to_fit();
    let total = points.len();
    sort(&mut points, &mut report.notes);
    let mut heights: Vec<f64> = points.iter().map(|point| point.height).collect();
    let place = |index: usize| points[index].distance;
    missing::mark(&mut heights, 1, place, unit, spec.missing.as_deref(), &mut report.notes).map_err(fault)?;
    points.iter_mut().zip(heights).for_each(|(point, height)| point.height = height);
    merge(&mut points, &mut report.notes).map_err(fault)?;
    let whole = (points[0].distance, points[points.len() - 1].distance);
    let range = spec.range.or(captif.then_some(CAPTIF_RANGE));
    if let Some([from, to]) = range {
        // A CAPTIF file of another length is simply used as far as the usual part goes.
        let inside = spec.range.is_none() || (from >= whole.0 - 1e-9 && to <= whole.1 + 1e-9);
        if from.is_nan() || to.is_nan() || from >= to || !inside {
            return Err(RoadError::Range { path: path.clone(), asked: (from, to), available: whole });
        }
        let before = points.len();
        points.retain(|point| point.distance >= from - 1e-9 && point.distance <= to + 1e-9);
        report.notes.push(RoadNote::Cut { from, to, dropped: before - points.len() });
    }
    report.points = points.len().min(total);
    report.missing = points.iter().filter(|point| point.height.is_nan()).count();
    let outliers = if captif { drop_outliers(&mut points, &mut report.notes) } else { 0 };
    let missing = report.missing + outliers;
    if points.len() < FEWEST_POINTS + missing {
        return Err(fault(FileFault::TooFewPoints { found: points.len() - missing, needed: FEWEST_POINTS }));
    }
    if missing as f64 > MISSING_ALLOWED * points.len() as f64 {
        let total = points.len();
        return Err(fault(FileFault::TooManyMissing { missing, total, allowed: MISSING_ALLOWED }));
    }
    if missing > 0 {
        report.notes.push(RoadNote::Filled { missing, total: points.len() });
    }
    rounded::add_notes(points.iter().map(|point| point.height), &mut report.notes);
    let Uniform { dx, heights, origins } = uniform(points, &mut report.notes).map_err(fault)?;
    plausible_spacing(dx, LARGEST_SPACING_OF_TABLE).map_err(fault)?;
    Ok(RoadHeightMap { path: path.clone(), dx, dy: 0.0, first_y: 0.0, columns: 1, heights, origins })
}

fn sort(points: &mut [FilePoint], notes: &mut Vec<RoadNote>) {
    let steps = points.windows(2).filter(|pair| pair[1].distance < pair[0].distance).count();
    if steps > 0 {
        notes.push(RoadNote::Unsorted { steps });
        points.sort_by(|a, b| a.distance.total_cmp(&b.distance));
    }
}

/// Averages sorted points at one distance.
///
/// # Errors
/// Many of them; too few points.
fn merge(points: &mut Vec<FilePoint>, notes: &mut Vec<RoadNote>) -> Result<(), FileFault> {
    let before = points.len();
    let coincide =
        |pair: &&[FilePoint]| pair[1].distance <= pair[0].distance && (pair[1].height - pair[0].height).abs() > 0.0;
    let count = points.windows(2).filter(coincide).count();
    if count as f64 > COINCIDING_ALLOWED * before as f64 {
        return Err(FileFault::Coinciding { count, total: before });
    }
    let known = |point: &FilePoint| if point.height.is_nan() { 0.0 } else { 1.0 };
    let mut valid = points.first().map_or(0.0, known);
    points.dedup_by(|point, last| {
        let coincides = point.distance <= last.distance;
        if !coincides {
            valid = known(point);
        } else if !point.height.is_nan() {
            let sum = if valid > 0.0 { last.height * valid } else { 0.0 };
            valid += 1.0;
            last.height = (sum + point.height) / valid;
        }
        coincides
    });
    if points.len() < before {
        notes.push(RoadNote::Duplicates { merged: before - points.len() });
    }
    if points.len() < FEWEST_POINTS {
        return Err(FileFault::TooFewPoints { found: points.len(), needed: FEWEST_POINTS });
    }
    Ok(())
}

/// Turns points that no road has into dropouts; returns their number.
fn drop_outliers(points: &mut [FilePoint], notes: &mut Vec<RoadNote>) -> usize {
    let mut heights: Vec<f64> = points.iter().map(|point| point.height).filter(|height| !height.is_nan()).collect();
    let Some(centre) = median(&mut heights) else { return 0 };
    let mut deviations: Vec<f64> = heights.iter().map(|height| (height - centre).abs()).collect();
    // 1.4826: the standard deviation of a Gaussian in terms of its median absolute deviation.
    let limit = OUTLIER_FACTOR * 1.4826 * median(&mut deviations).unwrap_or(0.0);
    if limit <= 0.0 {
        return 0;
    }
    let mut count = 0;
    for point in points.iter_mut().filter(|point| (point.height - centre).abs() > limit) {
        point.height = f64::NAN;
        count += 1;
    }
    if count > 0 {
        notes.push(RoadNote::Outliers { count, limit });
    }
    count
}

fn median(values: &mut [f64]) -> Option<f64> {
    if values.is_empty() {
        return None;
    }
    let middle = values.len() / 2;
    Some(*values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// Heights of one spacing.
struct Uniform {
    dx: f64,
    heights: Vec<f64>,
    /// Missing are points without a valid point of the file nearby; empty if all have one.
    origins: Vec<HeightOrigin>,
}

/// Heights on a uniform lattice from the first point to the last, by linear interpolation between valid points. Refuses
/// a profile most of which would be invented, in particular one with a far outlying distance.
fn uniform(mut points: Vec<FilePoint>, notes: &mut Vec<RoadNote>) -> Result<Uniform, FileFault> {
    // 1. Spacing.
    let first = points[0].distance;
    let span = points[points.len() - 1].distance - first;
    let mut gaps: Vec<f64> = points.windows(2).map(|pair| pair[1].distance - pair[0].distance).collect();
    let (smallest, largest) =
        gaps.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), &gap| (low.min(gap), high.max(gap)));
    let typical = median(&mut gaps).unwrap_or(span);
    // The mean of the usual gaps: the median alone is wrong where distances are rounded, the mean of all where lines
    // are missing.
    let (sum, count) =
        gaps.iter().filter(|&&gap| gap < 1.5 * typical).fold((0.0, 0.0), |(sum, count), gap| (sum + gap, count + 1.0));
    drop(gaps);
    let intervals = (span / (sum / count)).round().max(1.0);
    // 2. A lattice with far more points than the file would be invented.
    let total = intervals + 1.0;
    if total.is_nan() || total > points.len() as f64 / (1.0 - MISSING_ALLOWED) + 1.0 {
        let jump = points.windows(2).find(|pair| pair[1].distance - pair[0].distance > 0.5 * span);
        if let Some([before, after]) = jump {
            return Err(FileFault::Jump { line: after.line, from: before.distance, to: after.distance });
        }
        let missing = (total - points.len() as f64) as usize;
        return Err(FileFault::TooManyMissing { missing, total: total as usize, allowed: MISSING_ALLOWED });
    }
    let dx = span / intervals;
    if largest - smallest > 1e-6 * dx {
        notes.push(RoadNote::Resampled { smallest, largest, spacing: dx });
    }
    // 3. Interpolation; `after` is the first valid point not before the current distance.
    points.retain(|point| !point.height.is_nan());
    let valid = points;
    let mut after = 0;
    let mut origins = vec![HeightOrigin::Measured; intervals as usize + 1];
    let heights = (0..=intervals as usize).map(|index| {
        let distance = first + index as f64 * dx;
        while after < valid.len() && valid[after].distance < distance {
            after += 1;
        }
        let neighbours = (after.checked_sub(1).and_then(|before| valid.get(before)), valid.get(after));
        let off = |point: &FilePoint| (point.distance - distance).abs();
        let nearest = neighbours.0.map_or(f64::INFINITY, off).min(neighbours.1.map_or(f64::INFINITY, off));
        if nearest > NEARBY * dx {
            origins[index] = HeightOrigin::Missing;
        }
        match neighbours {
            (Some(a), Some(b)) => {
                a.height + (b.height - a.height) * (distance - a.distance) / (b.distance - a.distance)
            }
            (Some(only), None) | (None, Some(only)) => only.height,
            (None, None) => f64::NAN,
        }
    });
    let heights = heights.collect();
    let origins = if origins.contains(&HeightOrigin::Missing) { origins } else { Vec::new() };
    Ok(Uniform { dx, heights, origins })
}
