//! Tables of points: columns chosen, units found, every point with its line.

use crate::road::error::RoadError;
use crate::road::file_fault::FileFault;
use crate::scene::{LengthUnit, ProfileRoad};
use crate::storage::input::excerpt;
use crate::storage::separated;

/// A point of a file: distance and height \[m\], height NaN if missing, and its line from 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Point {
    pub(super) distance: f64,
    pub(super) height: f64,
    pub(super) line: u64,
}

/// Tells whether a file has the header of a CAPTIF profile.
pub(super) fn is_captif(bytes: &[u8]) -> bool {
    captif_data(bytes).is_some()
}

/// Returns the points of a profile's file, in its order.
///
/// # Errors
/// No numbers where they should be (with line and column), no units.
pub(super) fn points(spec: &ProfileRoad, bytes: &[u8]) -> Result<Vec<Point>, RoadError> {
    match captif_data(bytes) {
        Some((offset, line)) => {
            captif_points(&bytes[offset..], line).map_err(|fault| RoadError::file(&spec.file, fault))
        }
        None => csv_points(spec, bytes),
    }
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
    Ok(Point { distance: number(0, "distance", false)?, height: number(1, "height", true)?, line })
}
