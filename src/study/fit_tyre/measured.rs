//! Measured mobilities: a CSV file with a header, one line a measured value.
//!
//! Columns, in any order: `frequency_hz`, `patch_m` (side of the square patch), and either `re`, `im` \[m/(N s)\], or
//! `level_db` (re 1 m/(N s)) and `phase_deg`. Others are not looked at. The time factor is exp(+i w t). Columns are
//! parted by commas, semicolons or tabs; lines that begin with # are left out. Lines and columns count from 1.

use num_complex::Complex64;
use thiserror::Error;

use crate::storage::separated;

/// The smallest patch that is believed \[m\]: a smaller number is in another unit, and its sums would not end.
const SMALLEST_PATCH: f64 = 1e-3;
/// Most lines that are fitted: more of them are no measurement of a mobility.
const MOST_VALUES: usize = 100_000;
const FREQUENCY: &str = "frequency_hz";
const PATCH: &str = "patch_m";
const CARTESIAN: [&str; 2] = ["re", "im"];
const POLAR: [&str; 2] = ["level_db", "phase_deg"];

/// One measured value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Frequency \[Hz\].
    pub frequency: f64,
    /// Side of the square patch \[m\].
    pub patch: f64,
    /// Mobility Y \[m/(N s)\].
    pub mobility: Complex64,
}

/// What is wrong with a file of mobilities.
#[derive(Debug, Error)]
pub enum MeasuredError {
    /// No records, as the CSV reader says with the position.
    #[error(transparent)]
    Records(#[from] csv::Error),
    /// A column that must be there is not.
    #[error(
        "line {line}: no column {name:?}; the columns are: {}; needed: frequency_hz, patch_m, and either re, im or \
         level_db, phase_deg", found.join(", ")
    )]
    NoColumn {
        /// Line of the header.
        line: u64,
        /// The column's name.
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
        /// Its name.
        name: String,
    },
    /// A line with too few cells.
    #[error("line {line} has {found} columns, column {needed} ({name}) is needed")]
    MissingCell {
        /// The line.
        line: u64,
        /// Its cells.
        found: usize,
        /// Column of the cell.
        needed: usize,
        /// Its name.
        name: &'static str,
    },
    /// A cell without a number, or with one that cannot be.
    #[error("line {line}, column {column} ({name}): {found:?} is not {wanted}")]
    Cell {
        /// The line.
        line: u64,
        /// The cell's column.
        column: usize,
        /// The column's name.
        name: &'static str,
        /// What stands there.
        found: String,
        /// What would be right.
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
    /// More values than anybody measures.
    #[error("line {line}: more than {MOST_VALUES} values; average them, or leave frequencies out")]
    TooMany {
        /// The first line too many.
        line: u64,
    },
}

/// A column that is looked at, its number from 0.
#[derive(Clone, Copy)]
struct Column {
    name: &'static str,
    number: usize,
}

struct Columns {
    frequency: Column,
    patch: Column,
    value: [Column; 2],
    polar: bool,
}

/// Reads a file's bytes, in its order; patches are at most as wide as the tyre \[m\].
///
/// # Errors
/// [`MeasuredError`], with line and column.
pub fn read(bytes: &[u8], width: f64) -> Result<Vec<Point>, MeasuredError> {
    let mut reader = separated::reader(bytes);
    let mut record = csv::ByteRecord::new();
    let (mut columns, mut points) = (None, Vec::new());
    while reader.read_byte_record(&mut record)? {
        let line = separated::line_of(bytes, &record);
        if record.iter().all(<[u8]>::is_empty) {
            continue;
        }
        match &columns {
            None => columns = Some(Columns::of(&record, line)?),
            Some(_) if points.len() == MOST_VALUES => return Err(MeasuredError::TooMany { line }),
            Some(columns) => points.push(columns.point(&record, line, width)?),
        }
    }
    if columns.is_none() {
        return Err(MeasuredError::NoColumn { line: 1, name: FREQUENCY, found: Vec::new() });
    }
    if points.is_empty() { Err(MeasuredError::Empty) } else { Ok(points) }
}

impl Columns {
    fn of(header: &csv::ByteRecord, line: u64) -> Result<Self, MeasuredError> {
        let found: Vec<String> =
            header.iter().map(|name| String::from_utf8_lossy(name).trim().to_lowercase()).collect();
        let number = |name: &str| found.iter().position(|title| title == name);
        let column = |name: &'static str| {
            let missing = || MeasuredError::NoColumn { line, name, found: found.clone() };
            number(name).map(|number| Column { name, number }).ok_or_else(missing)
        };
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
        Ok(Self { frequency: column(FREQUENCY)?, patch: column(PATCH)?, value, polar })
    }

    fn point(&self, record: &csv::ByteRecord, line: u64, width: f64) -> Result<Point, MeasuredError> {
        let number = |Column { name, number }: Column, wanted: &str, fits: &dyn Fn(f64) -> bool| {
            let column = number + 1;
            let Some(cell) = record.get(number) else {
                return Err(MeasuredError::MissingCell { line, found: record.len(), needed: column, name });
            };
            let value = std::str::from_utf8(cell).ok().and_then(|text| text.parse::<f64>().ok());
            value.filter(|&value| value.is_finite() && fits(value)).ok_or_else(|| {
                let found = String::from_utf8_lossy(cell).into_owned();
                MeasuredError::Cell { line, column, name, found, wanted: wanted.to_owned() }
            })
        };
        let frequency = number(self.frequency, "a frequency above 0 Hz", &|value| value > 0.0)?;
        let lies = |side: f64| (SMALLEST_PATCH..=width).contains(&side);
        let wanted = format!("a length from {SMALLEST_PATCH} m to the tyre's width, {width} m");
        let patch = number(self.patch, &wanted, &lies)?;
        let wanted = if self.polar { "a level from -300 to 300 dB" } else { "a number" };
        let first = number(self.value[0], wanted, &|value| !self.polar || value.abs() <= 300.0)?;
        let second = number(self.value[1], if self.polar { "an angle" } else { "a number" }, &|_| true)?;
        let mobility = if self.polar {
            Complex64::from_polar(10.0_f64.powf(first / 20.0), second.to_radians())
        } else {
            Complex64::new(first, second)
        };
        // A number so small that its square is 0 has no level either.
        if mobility.norm_sqr() > 0.0 && mobility.norm().is_finite() {
            return Ok(Point { frequency, patch, mobility });
        }
        Err(MeasuredError::Zero { line, column: self.value[0].number + 1 })
    }
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
        assert_eq!(a, [Point { frequency: 100.0, patch: 0.05, mobility: Complex64::new(0.3, -0.4) }]);
        assert!(a.len() == b.len() && (a[0].mobility - b[0].mobility).norm() < 1e-9, "{b:?}");
        let tabs = cartesian.replace(',', "\t");
        assert_eq!(read(tabs.as_bytes(), 0.2).unwrap(), a);
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
