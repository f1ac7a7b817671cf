//! Measured mobilities: a CSV file with a header, one measured value per line.
//!
//! Columns, in any order: `frequency_hz`, `patch_m` (side of the square patch), and either `re`, `im` \[m/(N s)\], or
//! `level_db` (re 1 m/(N s)) and `phase_deg`; or, without `patch_m`, a pair of columns for each patch, `re_20mm` and
//! `im_20mm`, as `tyrewave mobility` writes. Other columns are ignored. The time factor is exp(+i w t). Columns are
//! separated by commas, semicolons, tabs or blanks, with decimal points or commas; lines that begin with # are skipped.
//! Lines and columns count from 1.

use num_complex::Complex64;
use thiserror::Error;

use crate::storage::separated::{Record, SeparatedTable};

/// Smallest patch that is accepted \[m\]: a smaller number is in another unit, and its sums would not end.
pub(crate) const SMALLEST_PATCH: f64 = 1e-3;
/// Most values that are fitted: a measurement of a mobility has fewer.
pub(super) const MOST_VALUES: usize = 100_000;
const FREQUENCY: &str = "frequency_hz";
const PATCH: &str = "patch_m";
const CARTESIAN: [&str; 2] = ["re", "im"];
const POLAR: [&str; 2] = ["level_db", "phase_deg"];

/// One measured value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredPoint {
    /// Frequency \[Hz\].
    pub frequency: f64,
    /// Side of the square patch \[m\].
    pub patch: f64,
    /// Mobility Y \[m/(N s)\].
    pub mobility: Complex64,
}

/// Faults of a file of mobilities.
#[derive(Debug, Error)]
pub enum MeasuredError {
    /// A needed column is missing.
    #[error(
        "line {line}: no column {name:?}; the columns are: {}; needed: frequency_hz, patch_m, and either re, im or \
         level_db, phase_deg; or frequency_hz and re_20mm, im_20mm for a patch of 20 mm", found.join(", ")
    )]
    NoColumn {
        /// Line of the header.
        line: u64,
        /// Name of the missing column.
        name: &'static str,
        /// The columns there are.
        found: Vec<String>,
    },
    /// A column is there twice, or a value in both forms.
    #[error("line {line}, column {column}: {name:?} says again what a column before says; keep one of the two")]
    Twice {
        /// Line of the header.
        line: u64,
        /// The second column.
        column: usize,
        /// Its title.
        name: String,
    },
    /// A line with too few cells.
    #[error("line {line} has {found} columns, column {needed} ({name}) is needed")]
    MissingCell {
        /// The line.
        line: u64,
        /// Number of its cells.
        found: usize,
        /// Column of the cell.
        needed: usize,
        /// Name of the column.
        name: &'static str,
    },
    /// A cell without a number, or with one out of range.
    #[error("line {line}, column {column} ({name}): {found:?} is not {wanted}")]
    Cell {
        /// The line.
        line: u64,
        /// The cell's column.
        column: usize,
        /// The column's name.
        name: &'static str,
        /// Text found.
        found: String,
        /// Description of a valid cell.
        wanted: String,
    },
    /// A mobility of 0 has no level.
    #[error("line {line}, column {column} (re): a mobility of 0 has no level; remove the line")]
    Zero {
        /// The line.
        line: u64,
        /// Column of the real part.
        column: usize,
    },
    /// No values at all.
    #[error("there is a header, but no line with numbers follows")]
    Empty,
    /// More values than a measurement has.
    #[error("line {line}: more than {MOST_VALUES} values; average them, or leave frequencies out")]
    TooMany {
        /// The first line too many.
        line: u64,
    },
}

/// A column that is read; `number` counts from 0.
#[derive(Clone, Copy)]
struct Column {
    name: &'static str,
    number: usize,
}

struct Columns {
    frequency: Column,
    /// One entry for each value on a line.
    values: Vec<ValueColumns>,
}

struct ValueColumns {
    patch: Patch,
    value: [Column; 2],
    polar: bool,
}

/// Side of the patch \[m\]: from a column, or from the header.
enum Patch {
    Column(Column),
    Given(f64),
}

/// Describes the valid sides of a patch on a tyre of the given width \[m\].
pub(crate) fn sides(width: f64) -> String {
    format!("a length from {SMALLEST_PATCH} m to the tyre's width, {width} m")
}

/// Reads a file's bytes, in its order; patches are at most as wide as the tyre, `width` \[m\].
///
/// # Errors
/// [`MeasuredError`], with line and column.
pub fn read(bytes: &[u8], width: f64) -> Result<Vec<MeasuredPoint>, MeasuredError> {
    let table = SeparatedTable::of(bytes);
    let (mut columns, mut points) = (None, Vec::new());
    for record in table.records() {
        match &columns {
            None => columns = Some(Columns::of(&record, width)?),
            Some(Columns { values, .. }) if points.len() + values.len() > MOST_VALUES => {
                return Err(MeasuredError::TooMany { line: record.line });
            }
            Some(columns) => {
                for value in &columns.values {
                    points.push(columns.point(value, &table, &record, width)?);
                }
            }
        }
    }
    if columns.is_none() {
        return Err(MeasuredError::NoColumn { line: 1, name: FREQUENCY, found: Vec::new() });
    }
    if points.is_empty() { Err(MeasuredError::Empty) } else { Ok(points) }
}

impl Columns {
    fn of(header: &Record<'_>, width: f64) -> Result<Self, MeasuredError> {
        let line = header.line;
        let found: Vec<String> = header.cells.iter().map(|name| name.to_lowercase()).collect();
        let number = |name: &str| found.iter().position(|title| title == name);
        let column = |name: &'static str| {
            let missing = || MeasuredError::NoColumn { line, name, found: found.clone() };
            number(name).map(|number| Column { name, number }).ok_or_else(missing)
        };
        let pairs = if number(PATCH).is_none() { pairs(&found, line, width)? } else { Vec::new() };
        if !pairs.is_empty() {
            return Ok(Self { frequency: column(FREQUENCY)?, values: pairs });
        }
        let polar = number(CARTESIAN[0]).is_none() && POLAR.iter().any(|name| number(name).is_some());
        let [value, other] = if polar { [POLAR, CARTESIAN] } else { [CARTESIAN, POLAR] };
        let used = [FREQUENCY, PATCH, value[0], value[1]];
        let again = found.iter().enumerate().find(|(place, title)| {
            let twice = used.contains(&title.as_str()) && number(title) != Some(*place);
            twice || other.contains(&title.as_str())
        });
        if let Some((place, name)) = again {
            return Err(MeasuredError::Twice { line, column: place + 1, name: name.clone() });
        }
        let value = [column(value[0])?, column(value[1])?];
        let frequency = column(FREQUENCY)?;
        Ok(Self { frequency, values: vec![ValueColumns { patch: Patch::Column(column(PATCH)?), value, polar }] })
    }

    fn point(
        &self,
        ValueColumns { patch, value, polar }: &ValueColumns,
        table: &SeparatedTable<'_>,
        record: &Record<'_>,
        width: f64,
    ) -> Result<MeasuredPoint, MeasuredError> {
        let (polar, line) = (*polar, record.line);
        let number = |Column { name, number }: Column, wanted: &str, fits: &dyn Fn(f64) -> bool| {
            let column = number + 1;
            let Some(cell) = record.cells.get(number) else {
                return Err(MeasuredError::MissingCell { line, found: record.cells.len(), needed: column, name });
            };
            table.number(cell).filter(|&value| fits(value)).ok_or_else(|| {
                let (found, wanted) = ((*cell).to_owned(), wanted.to_owned());
                MeasuredError::Cell { line, column, name, found, wanted }
            })
        };
        let frequency = number(self.frequency, "a frequency above 0 Hz", &|value| value > 0.0)?;
        let patch = match *patch {
            Patch::Given(side) => side,
            Patch::Column(column) => number(column, &sides(width), &|side| (SMALLEST_PATCH..=width).contains(&side))?,
        };
        let wanted = if polar { "a level from -300 to 300 dB" } else { "a number" };
        let first = number(value[0], wanted, &|value| !polar || value.abs() <= 300.0)?;
        let second = number(value[1], if polar { "an angle" } else { "a number" }, &|_| true)?;
        let mobility = if polar {
            Complex64::from_polar(10.0_f64.powf(first / 20.0), second.to_radians())
        } else {
            Complex64::new(first, second)
        };
        // A number so small that its square underflows has no level either.
        if mobility.norm_sqr() > 0.0 && mobility.norm().is_finite() {
            return Ok(MeasuredPoint { frequency, patch, mobility });
        }
        Err(MeasuredError::Zero { line, column: value[0].number + 1 })
    }
}

/// Columns of the real and the imaginary part for each patch that the header names: `re_20mm`, `im_20mm`.
fn pairs(found: &[String], line: u64, width: f64) -> Result<Vec<ValueColumns>, MeasuredError> {
    let mut pairs = Vec::new();
    for (number, title) in found.iter().enumerate() {
        let [re, im] = CARTESIAN;
        let Some(side) = title.strip_prefix(re).and_then(|rest| rest.strip_prefix('_')) else { continue };
        let other = format!("{im}_{side}");
        let Some(other) = found.iter().position(|title| *title == other) else { continue };
        let metres = side.strip_suffix("mm").and_then(|side| side.parse::<f64>().ok()).map(|side| 1e-3 * side);
        // The width itself, in millimetres, must not be lost to rounding.
        let Some(side) = metres.filter(|side| (SMALLEST_PATCH..=width * (1.0 + 1e-9)).contains(side)) else {
            let (found, wanted) = (title.clone(), sides(width));
            return Err(MeasuredError::Cell { line, column: number + 1, name: PATCH, found, wanted });
        };
        let value = [Column { name: re, number }, Column { name: im, number: other }];
        pairs.push(ValueColumns { patch: Patch::Given(side), value, polar: false });
    }
    Ok(pairs)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(text: &str) -> String {
        read(text.as_bytes(), 0.2).unwrap_err().to_string()
    }

    #[test]
    fn both_forms_and_all_delimiters_are_read() {
        let cartesian = "\u{feff}patch_m,frequency_hz,coherence,re,im\r\n# a comment\n0.05,100,1,0.3,-0.4\n\n";
        let polar = "Frequency_Hz; patch_m; level_db; phase_deg\n100; 0.05; -6.020599913; -53.13010235\n";
        let [a, b] = [cartesian, polar].map(|text| read(text.as_bytes(), 0.2).unwrap());
        assert_eq!(a, [MeasuredPoint { frequency: 100.0, patch: 0.05, mobility: Complex64::new(0.3, -0.4) }]);
        assert!(a.len() == b.len() && (a[0].mobility - b[0].mobility).norm() < 1e-9, "{b:?}");
        let tabs = cartesian.replace(',', "\t");
        assert_eq!(read(tabs.as_bytes(), 0.2).unwrap(), a);
        let commas = tabs.replace('.', ",").replace('\t', ";");
        assert_eq!(read(commas.as_bytes(), 0.2).unwrap(), a);
    }

    #[test]
    fn a_pair_of_columns_for_each_patch_is_read() {
        let text = "frequency_hz,re_5mm,im_5mm,level_db_5mm,re_20mm,im_20mm,level_db_20mm\n100,0.3,-0.4,-6,1,2,7\n";
        let read = read(text.as_bytes(), 0.2).unwrap();
        let point = |patch, re, im| MeasuredPoint { frequency: 100.0, patch, mobility: Complex64::new(re, im) };
        assert_eq!(read, [point(0.005, 0.3, -0.4), point(0.02, 1.0, 2.0)]);
        let message = refused(&text.replace("20mm", "500mm"));
        assert!(message.contains("line 1, column 5 (patch_m): \"re_500mm\"") && message.contains("0.2 m"), "{message}");
        assert!(refused(&text.replace("0.3,-0.4", "0.3,x")).contains("line 2, column 3 (im)"));
    }

    #[test]
    fn bad_files_are_refused_with_line_and_column() {
        let good = "frequency_hz,patch_m,re,im\n100,0.05,1,1\n";
        for (text, words) in [
            ("", &["frequency_hz"][..]),
            ("frequency_hz,patch_m,re,im\n", &["no line with numbers"]),
            ("100,0.05,1,1\n", &["line 1", "no column \"re\"", "100, 0.05", "level_db"]),
            (&good.replace("im", "imag"), &["line 1", "no column \"im\""]),
            (&good.replace("im", "level_db"), &["line 1, column 4", "\"level_db\"", "keep one"]),
            (&good.replace("im", "re"), &["line 1, column 4", "\"re\"", "keep one"]),
            (&good.replace("re,im", "level_db"), &["no column \"phase_deg\""]),
            (&format!("{good}200,0.05,1\n"), &["line 3 has 3 columns", "column 4 (im)"]),
            (&format!("{good}\n\nx,0.05,1,1\n"), &["line 5, column 1 (frequency_hz)", "\"x\"", "above 0 Hz"]),
            (&format!("{good}0,0.05,1,1\n"), &["line 3, column 1", "above 0 Hz"]),
            (&format!("{good}100,50,1,1\n"), &["line 3, column 2 (patch_m)", "\"50\"", "0.2 m"]),
            (&format!("{good}100,0.05,1,inf\n"), &["line 3, column 4 (im)", "not a number"]),
            (&format!("{good}100,0.05,0,0\n"), &["line 3, column 3", "no level"]),
        ] {
            let message = refused(text);
            words.iter().for_each(|word| assert!(message.contains(word), "{word}: {message}"));
        }
        let level = "frequency_hz,patch_m,level_db,phase_deg\n100,0.05,1e4,1\n";
        assert!(refused(level).contains("line 2, column 3 (level_db)"), "{}", refused(level));
        let long = format!("{good}{}", "100,0.05,1,1\n".repeat(MOST_VALUES));
        assert!(refused(&long).starts_with(&format!("line {}: more than", MOST_VALUES + 2)), "{}", refused(&long));
    }
}
