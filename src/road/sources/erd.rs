//! ERD files, the plain-text tables of the University of Michigan (UMTRI) that profilers of roads exchange.
//!
//! 1. `ERDFILEV2.00`; then channels, samples, records, bytes, key of the data's form, step.
//! 2. Lines of a keyword of eight letters and its value, up to `END`; names and units of channels are in fields of
//!    eight letters, long names in fields of 32; a line `&1000` continues the one before.
//! 3. Numbers, those of a sample after each other; the distance of sample n is n steps.

use std::path::Path;

use super::columns::{self, Fault, FileColumns, FilePoint};
use super::titles::{HEIGHT, Titles};
use crate::road::error::RoadError;
use crate::road::file_fault::FileFault;
use crate::scene::{LengthUnit, MissingHeight};
use crate::storage::input::excerpt;
use crate::storage::separated::{self, Record, SeparatedTable};

const MARK: &str = "ERDFILE";
/// Keys of data in text form: free, and by a Fortran format.
const TEXT: [i64; 2] = [5, 15];

/// True if bytes begin like an ERD file.
pub(super) fn is_erd(bytes: &[u8]) -> bool {
    bytes.starts_with(MARK.as_bytes())
}

/// The header: arrangement and meaning of the numbers.
#[derive(Debug, Default)]
struct Header {
    channels: usize,
    /// The promised number, if the file promises any.
    samples: Option<usize>,
    step: f64,
    step_unit: Option<LengthUnit>,
    names: Vec<String>,
    units: Vec<String>,
    /// Number of lines of the header.
    lines: u64,
}

/// Points of a file, and the column of its heights.
///
/// # Errors
/// A header that cannot be understood, binary data, channels or units that are not known.
pub(super) fn points(
    path: &Path,
    bytes: &[u8],
    [distance_unit, height_unit]: [Option<LengthUnit>; 2],
    chosen: Option<&[String]>,
    missing: Option<&[MissingHeight]>,
) -> Result<(Vec<FilePoint>, FileColumns<1>), RoadError> {
    read(bytes, distance_unit, height_unit, chosen, missing).map_err(|fault| fault.at(path))
}

fn read(
    bytes: &[u8],
    distance_unit: Option<LengthUnit>,
    height_unit: Option<LengthUnit>,
    chosen: Option<&[String]>,
    missing: Option<&[MissingHeight]>,
) -> Result<(Vec<FilePoint>, FileColumns<1>), Fault> {
    let text = separated::decoded(bytes);
    let header = header(&text)?;
    let unit = match (header.step_unit, distance_unit) {
        (Some(file), Some(scene)) if file != scene => {
            let (title, key) = ("XUNITS".to_owned(), "distance_unit");
            return Err(
                FileFault::UnitContradiction { line: 2, title, file: file.word(), key, scene: scene.word() }.into()
            );
        }
        (file, scene) => file.or(scene).ok_or(Fault::Unit("distance_unit"))?,
    };
    let names: Vec<String> = (0..header.channels)
        .map(|channel| {
            let name = header.names.get(channel).map_or("", String::as_str);
            let unit = header.units.get(channel).filter(|unit| !unit.is_empty());
            unit.map_or(name.to_owned(), |unit| format!("{name} ({unit})"))
        })
        .collect();
    let titles = Titles::new(header.lines, names);
    let roles = [HEIGHT];
    let channel = columns::choose(roles, Some(&titles), header.channels, chosen, String::new)?;
    let mut columns = FileColumns::with_units(roles, channel, Some(&titles), [height_unit], true)?;
    columns.missing = missing.map(<[_]>::to_vec);
    let table = SeparatedTable::of(b"");
    let step = header.step * unit.metres();
    let rest = (1..).zip(text.lines()).skip(header.lines as usize);
    let cells = rest.flat_map(|(line, text)| {
        text.split([',', ' ', '\t']).filter(|cell| !cell.is_empty()).map(move |cell| (line, cell))
    });
    let mut points = Vec::new();
    let mut sample = Record { line: 0, cells: Vec::with_capacity(header.channels.min(64)) };
    for (line, cell) in cells {
        sample.line = line;
        sample.cells.push(cell);
        if sample.cells.len() == header.channels {
            let height = columns.value(&table, &sample, 0)?;
            points.push(FilePoint { distance: points.len() as f64 * step, height, line });
            sample.cells.clear();
        }
    }
    match header.samples.filter(|&promised| promised != points.len()) {
        Some(expected) => Err(FileFault::Rows { expected: expected as u64, found: points.len() as u64 }.into()),
        None => Ok((points, columns)),
    }
}

fn header(text: &str) -> Result<Header, FileFault> {
    let mut lines = (1..).zip(text.lines());
    let second = lines.nth(1).map_or("", |(_, line)| line);
    let numbers: Vec<f64> =
        second.split([',', ' ', '\t']).filter(|part| !part.is_empty()).map_while(|part| part.parse().ok()).collect();
    let [channels, samples, _, _, form, step, ..] = numbers[..] else {
        return Err(FileFault::ErdHeader { line: 2, found: excerpt(second) });
    };
    if !TEXT.contains(&(form as i64)) {
        return Err(FileFault::ErdBinary { form: form as i64 });
    }
    let sound = (1.0..=1000.0).contains(&channels) && step > 0.0 && step.is_finite();
    if !sound {
        return Err(FileFault::ErdHeader { line: 2, found: excerpt(second) });
    }
    let mut header = Header { channels: channels as usize, step, ..Header::default() };
    header.samples = (samples >= 0.0).then_some(samples as usize);
    let mut keyword = String::new();
    for (line, text) in lines {
        if text.trim_end().eq_ignore_ascii_case("END") {
            header.lines = line;
            return Ok(header);
        }
        let (key, value) = split_after(text, 8);
        if !key.starts_with('&') {
            keyword = key.trim_end().to_uppercase();
        }
        match keyword.as_str() {
            "SHORTNAM" => header.names.extend(fields(value, 8)),
            "LONGNAME" if header.names.is_empty() => header.names.extend(fields(value, 32)),
            "UNITSNAM" => header.units.extend(fields(value, 8)),
            "XUNITS" => {
                header.step_unit = LengthUnit::of_word(value);
                if header.step_unit.is_none() && !value.trim().is_empty() {
                    let (title, found) = ("XUNITS".to_owned(), excerpt(value.trim()));
                    return Err(FileFault::UnknownUnit { line, title, found });
                }
            }
            _ => {}
        }
    }
    Err(FileFault::Missing { what: "line END" })
}

/// The first `letters` letters of a text, and the rest.
fn split_after(text: &str, letters: usize) -> (&str, &str) {
    text.split_at(text.char_indices().nth(letters).map_or(text.len(), |(at, _)| at))
}

/// The fields of `letters` letters each of which a text consists, trimmed.
fn fields(mut text: &str, letters: usize) -> Vec<String> {
    let mut found = Vec::new();
    while !text.is_empty() {
        let (field, rest) = split_after(text, letters);
        found.push(field.trim().to_owned());
        text = rest;
    }
    found
}
