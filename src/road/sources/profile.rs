//! Measured longitudinal profiles: CAPTIF `.dat` and CSV.
//!
//! 1. Read distance and height; a CAPTIF file states its units, for a CSV the scene does. Missing heights are empty or
//!    `NaN`.
//! 2. Sort by distance, average points at one distance, cut to `range` (CAPTIF: between the reference plates).
//! 3. CAPTIF only: points outlandishly far from the median count as dropouts (the laser sensor gives such values).
//! 4. Interpolate linearly to a uniform spacing, the mean of the file's, across dropouts as well.
//! 5. Remove mean and linear slope. Road coordinate 0 is the first point used.

use super::height_map::{HeightMap, plausible_spacing};
use super::signature::refuse_other_kinds;
use crate::road::error::RoadError;
use crate::road::file_fault::FileFault;
use crate::road::report::{RoadNote, RoadReport};
use crate::road::texture::remove_line;
use crate::scene::{LengthUnit, ProfileRoad};
use crate::storage::input::{self, excerpt};
use crate::storage::{InputError, separated};

/// Part between the reference plates of a CAPTIF track \[m\].
const CAPTIF_RANGE: [f64; 2] = [0.0623, 1.8704];
/// A CAPTIF height this many times the scaled median deviation away from the median is no texture.
const SPIKE_FACTOR: f64 = 8.0;
/// Largest share of missing heights.
const MISSING_ALLOWED: f64 = 0.25;
/// A valid point of the file this many spacings away stands for a point of the lattice: where distances are uneven,
/// half a spacing would not do.
const NEARBY: f64 = 0.75;
/// Fewest usable points.
const FEWEST_POINTS: usize = 8;

/// Bytes in memory that come of a byte of text, of points with a digit each.
const GROWTH: u64 = 16;

/// A point of the file: distance and height \[m\], height NaN if missing.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Point {
    distance: f64,
    height: f64,
}

/// Reads a profile as a map of one column, level across. `limit` bounds the bytes read.
///
/// # Errors
/// No such file, no numbers where they should be (with line and column), no units, too few points, too many missing.
pub(crate) fn read(spec: &ProfileRoad, limit: u64, report: &mut RoadReport) -> Result<HeightMap, RoadError> {
    let path = &spec.file;
    let fault = |fault| RoadError::file(path, fault);
    let bytes = input::read(path, limit / GROWTH).map_err(|error| match error {
        InputError::TooLarge { found, .. } => {
            fault(FileFault::TooLarge { needed: found.saturating_mul(GROWTH), limit })
        }
        other => fault(other.into()),
    })?;
    refuse_other_kinds(&bytes, "profile").map_err(fault)?;
    let captif = captif_data(&bytes);
    let points = match captif {
        Some((offset, line)) => captif_points(&bytes[offset..], line).map_err(fault)?,
        None => csv_points(spec, &bytes)?,
    };
    let total = points.len();
    let mut points = sorted(points, &mut report.notes).map_err(fault)?;
    let whole = (points[0].distance, points[points.len() - 1].distance);
    let range = spec.range.or(captif.map(|_| CAPTIF_RANGE));
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
    let spikes = if captif.is_some() { drop_spikes(&mut points, &mut report.notes) } else { 0 };
    let missing = report.missing + spikes;
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
    let Uniform { dx, mut heights, missing } = uniform(&points, &mut report.notes).map_err(fault)?;
    plausible_spacing(dx).map_err(fault)?;
    remove_line(&mut heights);
    report.notes.push(RoadNote::Levelled);
    let map = HeightMap { path: path.clone(), dx, dy: 0.0, first_y: 0.0, columns: 1, heights, missing };
    map.plausible_span()?;
    Ok(map)
}

fn metres(unit: LengthUnit) -> f64 {
    match unit {
        LengthUnit::Metre => 1.0,
        LengthUnit::Millimetre => 1e-3,
        LengthUnit::Micrometre => 1e-6,
    }
}

/// Tells where the column titles of a CAPTIF file start: byte offset and line number (from 1).
fn captif_data(bytes: &[u8]) -> Option<(usize, u64)> {
    let mark = b"*****DATA*****";
    // The mark ends a short header; a search through megabytes of numbers would find nothing.
    let head = &bytes[..bytes.len().min(65_536)];
    let place = head.windows(mark.len()).position(|window| window == mark)?;
    let end = head[place..].iter().position(|&byte| byte == b'\n').map_or(bytes.len(), |length| place + length + 1);
    let line = head[..end.min(head.len())].iter().filter(|&&byte| byte == b'\n').count() as u64 + 1;
    Some((end, line))
}

fn captif_points(data: &[u8], first_line: u64) -> Result<Vec<Point>, FileFault> {
    let mut reader = csv::ReaderBuilder::new().delimiter(b'\t').has_headers(false).flexible(true).from_reader(data);
    let mut record = csv::ByteRecord::new();
    let mut factors = [0.0; 2];
    let mut points = Vec::new();
    let mut titles = true;
    while reader.read_byte_record(&mut record)? {
        let line = first_line - 1 + record.position().map_or(0, csv::Position::line);
        if titles {
            for (factor, column) in factors.iter_mut().zip([1, 2]) {
                let title = String::from_utf8_lossy(record.get(column).unwrap_or_default()).into_owned();
                let unit = title.split(['(', ')']).nth(1).map(str::trim);
                *factor = match unit {
                    Some("mm") => 1e-3,
                    Some("m") => 1.0,
                    Some("um") => 1e-6,
                    _ => return Err(FileFault::UnknownUnit { line, found: excerpt(&title) }),
                };
            }
            titles = false;
            continue;
        }
        if record.iter().all(|cell| cell.trim_ascii().is_empty()) {
            continue;
        }
        points.push(point(&record, line, [1, 2], factors)?);
    }
    Ok(points)
}

fn csv_points(spec: &ProfileRoad, bytes: &[u8]) -> Result<Vec<Point>, RoadError> {
    let path = &spec.file;
    let unit = |unit: Option<LengthUnit>, key| {
        unit.map(metres).ok_or_else(|| RoadError::MissingUnit { path: path.clone(), key })
    };
    let mut reader = separated::reader(bytes);
    let mut record = csv::ByteRecord::new();
    let fault = |fault| RoadError::file(path, fault);
    let mut columns = [0, 1];
    let mut factors = [1.0; 2];
    let mut points = Vec::new();
    let mut first = true;
    while reader.read_byte_record(&mut record).map_err(|error| fault(error.into()))? {
        if record.iter().all(|cell| cell.is_empty()) {
            continue;
        }
        let line = separated::line_of(bytes, &record);
        if first {
            first = false;
            factors = [unit(spec.distance_unit, "distance_unit")?, unit(spec.height_unit, "height_unit")?];
            columns = [
                column_number(spec.distance_column.as_deref(), 0, &record).map_err(fault)?,
                column_number(spec.height_column.as_deref(), 1, &record).map_err(fault)?,
            ];
            // Titles: neither cell of the first line is a number. One alone is a fault, found below.
            let titled = columns
                .iter()
                .all(|&column| record.get(column).is_some_and(|cell| !cell.is_empty() && parse(cell).is_none()));
            if titled {
                continue;
            }
        }
        points.push(point(&record, line, columns, factors).map_err(fault)?);
    }
    Ok(points)
}

/// Returns the column (from 0) of a name or number (from 1), looked up in the file's first line.
fn column_number(wanted: Option<&str>, default: usize, titles: &csv::ByteRecord) -> Result<usize, FileFault> {
    let Some(wanted) = wanted else { return Ok(default) };
    let names: Vec<String> = titles.iter().map(|title| String::from_utf8_lossy(title).into_owned()).collect();
    names
        .iter()
        .position(|name| name == wanted)
        .or_else(|| wanted.parse::<usize>().ok().and_then(|number| number.checked_sub(1)).filter(|&n| n < names.len()))
        .ok_or_else(|| FileFault::NoSuchColumn { name: excerpt(wanted), available: excerpt(&names.join(", ")) })
}

fn parse(cell: &[u8]) -> Option<f64> {
    std::str::from_utf8(cell.trim_ascii()).ok()?.parse().ok()
}

fn point(record: &csv::ByteRecord, line: u64, columns: [usize; 2], factors: [f64; 2]) -> Result<Point, FileFault> {
    let number = |index: usize, role: &'static str, may_lack: bool| {
        let column = columns[index];
        let cell = match record.get(column) {
            Some(cell) => cell,
            None if may_lack && column == record.len() => b"",
            None => return Err(FileFault::MissingCell { line, needed: column + 1, found: record.len() }),
        };
        if may_lack && cell.trim_ascii().is_empty() {
            return Ok(f64::NAN);
        }
        match parse(cell) {
            Some(value) if value.is_finite() || (may_lack && value.is_nan()) => Ok(value * factors[index]),
            _ => {
                let found = excerpt(&String::from_utf8_lossy(cell));
                Err(FileFault::NotANumber { line, column: column + 1, role, found })
            }
        }
    };
    Ok(Point { distance: number(0, "distance", false)?, height: number(1, "height", true)? })
}

/// Returns the sorted by distance, points at one distance averaged.
fn sorted(mut points: Vec<Point>, notes: &mut Vec<RoadNote>) -> Result<Vec<Point>, FileFault> {
    let steps = points.windows(2).filter(|pair| pair[1].distance < pair[0].distance).count();
    if steps > 0 {
        notes.push(RoadNote::Unsorted { steps });
        points.sort_by(|a, b| a.distance.total_cmp(&b.distance));
    }
    let before = points.len();
    let mut merged: Vec<Point> = Vec::with_capacity(points.len());
    let mut valid = 0.0;
    for point in points {
        match merged.last_mut() {
            Some(last) if point.distance <= last.distance => {
                if !point.height.is_nan() {
                    let sum = if valid > 0.0 { last.height * valid } else { 0.0 };
                    valid += 1.0;
                    last.height = (sum + point.height) / valid;
                }
            }
            _ => {
                valid = if point.height.is_nan() { 0.0 } else { 1.0 };
                merged.push(point);
            }
        }
    }
    if merged.len() < before {
        notes.push(RoadNote::Duplicates { merged: before - merged.len() });
    }
    if merged.len() < FEWEST_POINTS {
        return Err(FileFault::TooFewPoints { found: merged.len(), needed: FEWEST_POINTS });
    }
    Ok(merged)
}

/// Turns spikes into dropouts; returns how many.
fn drop_spikes(points: &mut [Point], notes: &mut Vec<RoadNote>) -> usize {
    let mut heights: Vec<f64> = points.iter().map(|point| point.height).filter(|height| !height.is_nan()).collect();
    let Some(centre) = median(&mut heights) else { return 0 };
    let mut deviations: Vec<f64> = heights.iter().map(|height| (height - centre).abs()).collect();
    // 1.4826: the standard deviation of a Gaussian in terms of its median absolute deviation.
    let limit = SPIKE_FACTOR * 1.4826 * median(&mut deviations).unwrap_or(0.0);
    if limit <= 0.0 {
        return 0;
    }
    let mut count = 0;
    for point in points.iter_mut().filter(|point| (point.height - centre).abs() > limit) {
        point.height = f64::NAN;
        count += 1;
    }
    if count > 0 {
        notes.push(RoadNote::Spikes { count, limit });
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

/// Heights on a lattice of one spacing.
struct Uniform {
    dx: f64,
    heights: Vec<f64>,
    /// Which of them have no valid point of the file nearby; empty where all have.
    missing: Vec<bool>,
}

/// Returns the spacing and heights on a uniform lattice from the first point to the last: linear interpolation between
/// valid points. Refuses a profile most of which would be invented, in particular one with a far outlying distance.
fn uniform(points: &[Point], notes: &mut Vec<RoadNote>) -> Result<Uniform, FileFault> {
    let first = points[0].distance;
    let span = points[points.len() - 1].distance - first;
    let mut gaps: Vec<f64> = points.windows(2).map(|pair| pair[1].distance - pair[0].distance).collect();
    let (smallest, largest) =
        gaps.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), &gap| (low.min(gap), high.max(gap)));
    let typical = median(&mut gaps).unwrap_or(span);
    // The mean of the usual gaps: the median alone is off where distances are rounded, the mean of all where lines are
    // missing.
    let (sum, count) =
        gaps.iter().filter(|&&gap| gap < 1.5 * typical).fold((0.0, 0.0), |(sum, count), gap| (sum + gap, count + 1.0));
    let intervals = (span / (sum / count)).round().max(1.0);
    let total = intervals + 1.0;
    if total.is_nan() || total > points.len() as f64 / (1.0 - MISSING_ALLOWED) + 1.0 {
        let missing = (total - points.len() as f64) as usize;
        return Err(FileFault::TooManyMissing { missing, total: total as usize, allowed: MISSING_ALLOWED });
    }
    let dx = span / intervals;
    if largest - smallest > 1e-6 * dx {
        notes.push(RoadNote::Resampled { smallest, largest, spacing: dx });
    }
    let valid: Vec<Point> = points.iter().filter(|point| !point.height.is_nan()).copied().collect();
    let mut after = 0;
    let mut missing = vec![false; intervals as usize + 1];
    let heights = (0..=intervals as usize).map(|index| {
        let distance = first + index as f64 * dx;
        while after < valid.len() && valid[after].distance < distance {
            after += 1;
        }
        let neighbours = (after.checked_sub(1).and_then(|before| valid.get(before)), valid.get(after));
        let off = |point: &Point| (point.distance - distance).abs();
        let nearest = neighbours.0.map_or(f64::INFINITY, off).min(neighbours.1.map_or(f64::INFINITY, off));
        missing[index] = nearest > NEARBY * dx;
        match neighbours {
            (Some(a), Some(b)) => {
                a.height + (b.height - a.height) * (distance - a.distance) / (b.distance - a.distance)
            }
            (Some(only), None) | (None, Some(only)) => only.height,
            (None, None) => f64::NAN,
        }
    });
    let heights = heights.collect();
    missing = if missing.contains(&true) { missing } else { Vec::new() };
    Ok(Uniform { dx, heights, missing })
}
