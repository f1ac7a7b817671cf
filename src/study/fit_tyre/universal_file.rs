//! Measured mobilities of universal files (UFF, UNV): dataset 58, as text or binary (58b), with the units of dataset
//! 164; format by the Structural Dynamics Research Laboratory, University of Cincinnati. Other datasets are skipped.
//!
//! A file holds what a test bench wrote: its frequency responses at a driving point are read, all other functions are
//! counted and reported. The format has no field for the size of the patch.

use num_complex::Complex64;
use thiserror::Error;

use super::measured::{MOST_VALUES, MeasuredPoint};
use super::quantity::{AxisRecord, FileUnits, Quantity};

/// Records before the values of dataset 58.
const RECORDS: usize = 11;
/// Directions by number: 1 to 3 translations, 4 to 6 rotations.
const DIRECTIONS: [&str; 7] = ["none", "X", "Y", "Z", "X (rotation)", "Y (rotation)", "Z (rotation)"];

#[derive(Debug, Error)]
pub(crate) enum UniversalFileError {
    /// A function that cannot be read.
    #[error("function {function} (dataset 58): {wrong}")]
    Function {
        /// Its number among the functions of the file, from 1.
        function: usize,
        /// Mistake in the file, in words.
        wrong: String,
    },
    /// Units that cannot be read.
    #[error("dataset 164 (units): {0}")]
    Units(String),
    /// No frequency response at a driving point.
    #[error("no frequency response at a driving point in dataset 58; {0}")]
    Nothing(String),
    /// Numbers of sets and patches do not match.
    #[error("{0}")]
    Patches(String),
}

/// Responses that were read, and notes about the file.
#[derive(Debug)]
pub(crate) struct UniversalFile {
    /// Measured values, converted to mobilities.
    pub points: Vec<MeasuredPoint>,
    /// Notes on what was taken, converted and left out, a line each.
    pub notes: Vec<String>,
}

/// True if a file is a universal one: its first line that is not blank is the delimiter -1.
pub(crate) fn is_universal(bytes: &[u8]) -> bool {
    let mut lines = bytes.split(|&byte| byte == b'\n').map(<[u8]>::trim_ascii);
    lines.find(|line| !line.is_empty()) == Some(b"-1")
}

/// Bytes that are read by lines or by blocks.
struct Cursor<'a>(&'a [u8]);

impl<'a> Cursor<'a> {
    fn line(&mut self) -> Option<&'a [u8]> {
        if self.0.is_empty() {
            return None;
        }
        let end = self.0.iter().position(|&byte| byte == b'\n').unwrap_or(self.0.len());
        let (line, rest) = self.0.split_at(end);
        self.0 = rest.get(1..).unwrap_or_default();
        Some(line.strip_suffix(b"\r").unwrap_or(line))
    }

    fn bytes(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    /// Lines up to the next delimiter, which is consumed.
    fn until_delimiter(&mut self) -> Vec<&'a [u8]> {
        std::iter::from_fn(|| self.line()).take_while(|line| line.trim_ascii() != b"-1").collect()
    }
}

/// Encoding of a dataset with binary values (58b).
#[derive(Clone, Copy)]
struct Binary {
    little_endian: bool,
    ieee: bool,
    /// Lines of text before the values.
    lines: usize,
    bytes: usize,
}

/// A dataset's number, and the encoding of its values if that is binary.
fn identifier(line: &[u8]) -> Option<(u32, Option<Binary>)> {
    let text = std::str::from_utf8(line).ok()?.trim();
    let end = text.find(|sign: char| !sign.is_ascii_digit()).unwrap_or(text.len());
    let number = text[..end].parse().ok()?;
    let Some(rest) = text[end..].trim_start().strip_prefix(['b', 'B']) else { return Some((number, None)) };
    let fields: Vec<usize> = rest.split_whitespace().map_while(|field| field.parse().ok()).collect();
    let &[order, format, lines, bytes, ..] = &fields[..] else { return None };
    Some((number, Some(Binary { little_endian: order == 1, ieee: format == 2, lines, bytes })))
}

/// A function of dataset 58: its records as they stand, and its values.
struct Function<'a> {
    records: Vec<&'a [u8]>,
    values: Values<'a>,
}

enum Values<'a> {
    Text(Vec<&'a [u8]>),
    Binary(&'a [u8], Binary),
}

/// Frequency, real and imaginary part.
type Sample = (f64, Complex64);

/// Reads the frequency responses of a file within a range of frequencies \[Hz\]; `patches` are the sides of the patches
/// \[m\]: one for all, or one for each response.
///
/// # Errors
/// [`UniversalFileError`], with the function's number.
pub(crate) fn read(bytes: &[u8], patches: &[f64], range: [f64; 2]) -> Result<UniversalFile, UniversalFileError> {
    let (functions, units) = datasets(bytes)?;
    let (mut responses, mut left_out) = (Vec::new(), Vec::new());
    for (function, number) in functions.iter().zip(1..) {
        let wrong = |wrong| UniversalFileError::Function { function: number, wrong };
        match Response::of(function, units).map_err(wrong)? {
            Ok(response) => responses.push((number, response)),
            Err(why) => left_out.push(why),
        }
    }
    left_out.sort();
    let counted = left_out.chunk_by(|a, b| a == b).map(|same| format!("{} {}", same.len(), same[0]));
    let left_out = counted.collect::<Vec<_>>().join(", ");
    if responses.is_empty() {
        let found = if left_out.is_empty() { "it has none at all".to_owned() } else { format!("found: {left_out}") };
        return Err(UniversalFileError::Nothing(found));
    }
    if let Some((number, other)) = responses.iter().find(|(_, other)| other.axis != responses[0].1.axis) {
        let ([first, second], before) = ([&responses[0].1, other].map(Response::direction), responses[0].0);
        return Err(UniversalFileError::Patches(format!(
            "function {before} is in direction {first}, function {number} in {second}: one alone can be normal to the \
             tread; keep that one"
        )));
    }
    if patches.len() != 1 && patches.len() != responses.len() {
        return Err(UniversalFileError::Patches(format!(
            "{} responses at a driving point and {} patches (--patch): give one side for all of them, or one for each",
            responses.len(),
            patches.len()
        )));
    }
    let mut file = UniversalFile { points: Vec::new(), notes: Vec::new() };
    for (index, (number, response)) in responses.iter().enumerate() {
        let patch = patches[if patches.len() == 1 { 0 } else { index }];
        let wrong = |wrong| UniversalFileError::Function { function: *number, wrong };
        let note = response.add_to(&mut file.points, patch, range).map_err(wrong)?;
        file.notes.push(format!("function {number}: {note}"));
    }
    if !left_out.is_empty() {
        file.notes.push(format!("functions left out: {left_out}"));
    }
    if file.points.is_empty() {
        let [lowest, highest] = range;
        return Err(UniversalFileError::Nothing(format!("none from {lowest} to {highest} Hz")));
    }
    Ok(file)
}

/// Splits a file: its functions, and the units that they have.
fn datasets(bytes: &[u8]) -> Result<(Vec<Function<'_>>, Option<FileUnits>), UniversalFileError> {
    let mut cursor = Cursor(bytes);
    let (mut functions, mut units) = (Vec::new(), None);
    while let Some(line) = cursor.line() {
        if line.trim_ascii() != b"-1" {
            continue;
        }
        let dataset = cursor.0;
        let Some(line) = cursor.line() else { break };
        let wrong = |wrong: String| UniversalFileError::Function { function: functions.len() + 1, wrong };
        match identifier(line) {
            Some((number, Some(binary))) => {
                let records: Vec<&[u8]> = (0..binary.lines).map_while(|_| cursor.line()).collect();
                // Some writers count half of the bytes of complex numbers: the length from record 7 is tried first.
                let lengths = if number == 58 { value_bytes(&records) } else { Vec::new() };
                let length = lengths.into_iter().chain([binary.bytes]).find(|&length| is_followed(cursor.0, length));
                let Some(values) = length.and_then(|length| cursor.bytes(length)) else {
                    return Err(wrong(format!("the file ends before its delimiter, {} bytes on", binary.bytes)));
                };
                if number == 58 {
                    functions.push(Function { records, values: Values::Binary(values, binary) });
                }
                cursor.until_delimiter();
            }
            Some((58, None)) => {
                let mut records = cursor.until_delimiter();
                let values = records.split_off(RECORDS.min(records.len()));
                functions.push(Function { records, values: Values::Text(values) });
            }
            Some((164, None)) => {
                let found = file_units(&cursor.until_delimiter())?;
                if units.is_some_and(|before| before != found) {
                    return Err(UniversalFileError::Units("it is there twice, with other numbers".to_owned()));
                }
                units = Some(found);
            }
            // Two delimiters in a row: the second begins a dataset.
            None if line.trim_ascii() == b"-1" => cursor.0 = dataset,
            None => return Err(wrong(format!("{:?} names no dataset", String::from_utf8_lossy(line)))),
            Some(_) => _ = cursor.until_delimiter(),
        }
    }
    Ok((functions, units))
}

fn file_units(lines: &[&[u8]]) -> Result<FileUnits, UniversalFileError> {
    let factors: Vec<f64> = lines.iter().skip(1).flat_map(|line| numbers(line)).map_while(Result::ok).collect();
    match factors[..] {
        [length, force, ..] if length > 0.0 && force > 0.0 && length.is_finite() && force.is_finite() => {
            Ok(FileUnits { length, force })
        }
        _ => Err(UniversalFileError::Units("its second record is to begin with two factors above 0".to_owned())),
    }
}

/// Numbers of a line; a number that begins with its sign may touch the one before; exponents with D or E.
fn numbers(line: &[u8]) -> Vec<Result<f64, String>> {
    let text = String::from_utf8_lossy(line).replace(['D', 'd'], "E");
    let mut apart = String::with_capacity(text.len());
    let mut last = ' ';
    for sign in text.chars() {
        if matches!(sign, '+' | '-') && (last.is_ascii_digit() || last == '.') {
            apart.push(' ');
        }
        apart.push(sign);
        last = sign;
    }
    let number = |word: &str| word.parse::<f64>().map_err(|_| word.to_owned());
    apart.split_whitespace().map(number).collect()
}

/// Field of a record from column `begin` (counted from 0), trimmed; empty beyond its end.
fn field(record: &[u8], begin: usize, width: usize) -> &[u8] {
    let end = (begin + width).min(record.len());
    record.get(begin..end).unwrap_or_default().trim_ascii()
}

fn number<N: std::str::FromStr>(record: &[u8], begin: usize, width: usize) -> Option<N> {
    std::str::from_utf8(field(record, begin, width)).ok()?.replace(['D', 'd'], "E").parse().ok()
}

/// Axis of a record; missing fields are 0 or empty.
fn axis(record: &[u8]) -> AxisRecord {
    let label = String::from_utf8_lossy(field(record, 46, 21)).into_owned();
    AxisRecord {
        data_type: number(record, 0, 10).unwrap_or(0),
        exponents: [10, 15].map(|begin| number(record, begin, 5).unwrap_or(0)),
        label: if label.eq_ignore_ascii_case("none") { String::new() } else { label },
    }
}

/// A frequency response at a driving point.
struct Response {
    /// The common node; direction numbers, with sign, of response and reference.
    node: i64,
    directions: [i64; 2],
    /// Axis of both, 0 for none.
    axis: u64,
    quantity: Quantity,
    samples: Vec<Sample>,
}

impl Response {
    /// Reads a function; the inner `Err` says what it is if it is no such response.
    fn of(function: &Function<'_>, units: Option<FileUnits>) -> Result<Result<Self, String>, String> {
        let &[_, _, _, _, _, degrees, form, abscissa, numerator, denominator, _] = &function.records[..] else {
            return Err(format!("{} of {RECORDS} records before the values", function.records.len()));
        };
        let kind: i64 = number(degrees, 0, 5).ok_or("record 6: no function type in columns 1 to 5")?;
        if !matches!(kind, 0 | 4) {
            return Ok(Err(kind_name(kind)));
        }
        let whole = |begin, width| number::<i64>(degrees, begin, width).unwrap_or(0);
        let (nodes, directions) = ([whole(41, 10), whole(66, 10)], [whole(51, 4), whole(76, 4)]);
        let [axis_of_response, axis_of_reference] = directions.map(i64::unsigned_abs);
        if nodes[0] != nodes[1] || axis_of_response != axis_of_reference {
            return Ok(Err("responses at another point or in another direction than the force".to_owned()));
        }
        if axis_of_response > 3 {
            return Ok(Err("responses to a moment".to_owned()));
        }
        let unit = axis(abscissa).label.to_lowercase();
        if !matches!(axis(abscissa).data_type, 0 | 1 | 18) || !["", "hz", "1/s", "cps"].contains(&unit.as_str()) {
            return Err(format!("record 8: the abscissa is not a frequency in Hz (units {unit:?})"));
        }
        let quantity = Quantity::of(&axis(numerator), &axis(denominator), units)?;
        let samples = samples(form, &function.values)?;
        Ok(Ok(Self { node: nodes[0], directions, axis: axis_of_response, quantity, samples }))
    }

    fn direction(&self) -> String {
        let sign = if self.directions[0] < 0 { "-" } else { "+" };
        match DIRECTIONS.get(self.axis as usize) {
            Some(name) if self.axis > 0 => format!("{sign}{name}"),
            _ => DIRECTIONS[0].to_owned(),
        }
    }

    /// Adds the values within a range of frequencies as mobilities, and describes what was done.
    fn add_to(
        &self,
        points: &mut Vec<MeasuredPoint>,
        patch: f64,
        [lowest, highest]: [f64; 2],
    ) -> Result<String, String> {
        let turned = self.directions[0].signum() * self.directions[1].signum() < 0;
        let before = points.len();
        for &(frequency, value) in &self.samples {
            // The velocity at 0 Hz says nothing about a displacement.
            if frequency <= 0.0 || !(lowest..=highest).contains(&frequency) {
                continue;
            }
            let mobility = self.quantity.mobility(if turned { -value } else { value }, frequency);
            if mobility.norm_sqr() == 0.0 || !mobility.norm_sqr().is_finite() {
                return Err(format!("its value at {frequency} Hz, {value}, has no level; leave it out (--lowest)"));
            }
            if points.len() == MOST_VALUES {
                return Err(format!("more than {MOST_VALUES} values; narrow the range (--lowest, --highest)"));
            }
            points.push(MeasuredPoint { frequency, patch, mobility });
        }
        let name = self.quantity.name();
        let conversion = if name == "mobility" { "" } else { ", converted to mobility" };
        let sign = if turned { ", sign turned since response and force point against each other" } else { "" };
        let units = if self.quantity.si_assumed { ", in SI units, since the file does not name others" } else { "" };
        Ok(format!(
            "{name} at node {}, direction {}, {} of {} values{conversion}{sign}{units}",
            self.node,
            self.direction(),
            points.len() - before,
            self.samples.len()
        ))
    }
}

fn kind_name(kind: i64) -> String {
    let names = [
        "general",
        "time responses",
        "auto spectra",
        "cross spectra",
        "frequency responses",
        "transmissibilities",
        "coherences",
    ];
    let name = usize::try_from(kind).ok().and_then(|kind| names.get(kind));
    name.map_or_else(|| format!("functions of type {kind}"), |name| (*name).to_owned())
}

/// True if a delimiter follows after `length` bytes.
fn is_followed(rest: &[u8], length: usize) -> bool {
    let after = rest.get(length..).map(<[u8]>::trim_ascii_start).and_then(|after| after.strip_prefix(b"-1"));
    after.is_some_and(|after| after.first().is_none_or(u8::is_ascii_whitespace))
}

/// Lengths in bytes that binary values may have by record 7: abscissas are single, or double in files of some writers,
/// and so are ordinates that record 7 calls single.
fn value_bytes(records: &[&[u8]]) -> Vec<usize> {
    let Some(form) = records.get(6) else { return Vec::new() };
    let [kind, count, even] = [0, 10, 20].map(|begin| number::<usize>(form, begin, 10).unwrap_or(0));
    let ordinates: &[usize] = match kind {
        2 => &[4, 8],
        4 => &[8],
        5 => &[8, 16],
        6 => &[16],
        _ => return Vec::new(),
    };
    let abscissas: &[usize] = if even == 1 { &[0] } else { &[4, 8] };
    let sizes = ordinates.iter().flat_map(|ordinate| abscissas.iter().map(move |abscissa| ordinate + abscissa));
    sizes.filter_map(|size| count.checked_mul(size)).collect()
}

/// Values by frequency; `form` is record 7, which says how they are written.
fn samples(form: &[u8], values: &Values<'_>) -> Result<Vec<Sample>, String> {
    let missing = |what: &str| format!("record 7: no {what}");
    let kind: u32 = number(form, 0, 10).ok_or_else(|| missing("ordinate data type"))?;
    let count: usize = number(form, 10, 10).ok_or_else(|| missing("number of values"))?;
    let even = number::<i64>(form, 20, 10).ok_or_else(|| missing("abscissa spacing"))? == 1;
    match kind {
        5 | 6 => {}
        2 | 4 => return Err("its values are real: a mobility has a phase".to_owned()),
        _ => return Err(format!("record 7: ordinate data type {kind}, not 5 or 6 (complex)")),
    }
    let columns = if even { 2 } else { 3 };
    let wanted = count.checked_mul(columns).ok_or_else(|| missing("plausible number of values"))?;
    let numbers = match values {
        Values::Text(lines) => {
            let read: Result<Vec<f64>, String> = lines.iter().flat_map(|line| numbers(line)).collect();
            read.map_err(|word| format!("{word:?} among its values is not a number"))?
        }
        Values::Binary(..) if count == 0 => Vec::new(),
        Values::Binary(bytes, binary) => binary_numbers(bytes, *binary, count, columns)?,
    };
    if numbers.len() != wanted || count == 0 {
        return Err(format!("{} numbers follow, and record 7 counts {count} values ({wanted} numbers)", numbers.len()));
    }
    if !even {
        return Ok(numbers.chunks_exact(3).map(|row| (row[0], Complex64::new(row[1], row[2]))).collect());
    }
    let start: f64 = number(form, 30, 13).ok_or_else(|| missing("abscissa minimum"))?;
    let step: f64 = number(form, 43, 13).ok_or_else(|| missing("abscissa increment"))?;
    if !(start.is_finite() && step.is_finite() && step > 0.0) {
        return Err(format!("record 7: frequencies from {start} Hz in steps of {step} Hz"));
    }
    let at = |(index, pair): (usize, &[f64])| (start + index as f64 * step, Complex64::new(pair[0], pair[1]));
    Ok(numbers.chunks_exact(2).enumerate().map(at).collect())
}

/// Numbers of a binary block. Its length determines their precision: frequencies are single in the format, and double
/// in files of some writers; these also call values single that are double.
fn binary_numbers(bytes: &[u8], binary: Binary, count: usize, columns: usize) -> Result<Vec<f64>, String> {
    if !binary.ieee {
        return Err("its numbers are not IEEE 754 (field 2 of the identifier)".to_owned());
    }
    let row = bytes.len() / count;
    let (abscissa, ordinate) = match (columns, row) {
        _ if row * count != bytes.len() => (0, 0),
        (2, 8 | 16) => (0, row / 2),
        (3, 12 | 16) => (row - 8, 4),
        (3, 20 | 24) => (row - 16, 8),
        _ => (0, 0),
    };
    if ordinate == 0 {
        return Err(format!("{} bytes of values, and record 7 counts {count} values", bytes.len()));
    }
    let number = |bytes: &[u8]| match (<[u8; 4]>::try_from(bytes), <[u8; 8]>::try_from(bytes)) {
        (Ok(single), _) if binary.little_endian => f64::from(f32::from_le_bytes(single)),
        (Ok(single), _) => f64::from(f32::from_be_bytes(single)),
        (_, Ok(double)) if binary.little_endian => f64::from_le_bytes(double),
        (_, Ok(double)) => f64::from_be_bytes(double),
        _ => f64::NAN,
    };
    let mut numbers = Vec::with_capacity(count * columns);
    for row in bytes.chunks_exact(row) {
        let (frequency, value) = row.split_at(abscissa);
        if abscissa > 0 {
            numbers.push(number(frequency));
        }
        numbers.extend(value.chunks_exact(ordinate).map(number));
    }
    Ok(numbers)
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use super::*;

    const WHOLE: [f64; 2] = [0.0, f64::INFINITY];

    /// Bytes of a file that pyuff 2.5.8 wrote (tests/reference/fit_tyre/write_universal_files.py): one oscillator, as
    /// several quantities.
    fn file(name: &str) -> Vec<u8> {
        fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference/fit_tyre").join(name)).unwrap()
    }

    /// Mobility of the oscillator: spring of 1e5 N/m, mass of 0.1 kg, dashpot of 20 N s/m, on a base with a mobility of
    /// 1 mm/(N s).
    fn oscillator(frequency: f64) -> Complex64 {
        let i_omega = Complex64::new(0.0, std::f64::consts::TAU * frequency);
        (1e5 / i_omega + 20.0 + 0.1 * i_omega).inv() + 1e-3
    }

    #[test]
    fn every_way_of_writing_an_oscillator_gives_its_mobility() {
        for (name, values, words) in [
            ("accelerance_text.uff", 39, &["accelerance at node 12, direction +Z, 39 of 40", "converted"][..]),
            ("accelerance_binary.uff", 39, &["1 coherences", "1 time responses", "at another point"]),
            ("mobility_double_uneven.uff", 40, &["function 1: mobility", "in SI units, since"]),
            ("receptance_mm_kn.uff", 39, &["receptance"]),
            ("two_points_opposite.uff", 78, &["function 1: accelerance", "function 2", "sign turned"]),
        ] {
            let found = read(&file(name), &[0.02], WHOLE).unwrap();
            let reported = found.notes.join("; ");
            assert_eq!(found.points.len(), values, "{name}: {reported}");
            words.iter().for_each(|word| assert!(reported.contains(word), "{name}: {word}: {reported}"));
            for point in &found.points {
                // Single precision has six digits as text.
                let error = (point.mobility - oscillator(point.frequency)).norm() / point.mobility.norm();
                assert!(error < 2e-5 && point.patch.to_bits() == 0.02_f64.to_bits(), "{name}: {point:?}, {error:e}");
            }
        }
        let part = read(&file("accelerance_text.uff"), &[0.02], [100.0, 200.0]).unwrap();
        assert!(part.points.iter().all(|point| (100.0..=200.0).contains(&point.frequency)) && part.points.len() == 5);
        let sides = read(&file("two_points_opposite.uff"), &[0.02, 0.05], WHOLE).unwrap();
        let patches = [0, 77].map(|index| sides.points[index].patch);
        assert_eq!(patches.map(f64::to_bits), [0.02_f64, 0.05].map(f64::to_bits));
    }

    #[test]
    fn files_with_other_contents_are_refused_with_what_they_have() {
        let text = String::from_utf8(file("accelerance_text.uff")).unwrap();
        assert!(is_universal(text.as_bytes()) && !is_universal(b"frequency_hz,patch_m,re,im\n-1,2,3,4\n"));
        let refused = |text: &str| read(text.as_bytes(), &[0.02], WHOLE).unwrap_err().to_string();
        let cut = text[..text.len() - 300].rfind('\n').unwrap();
        for (text, words) in [
            ("    -1\n", "it has none at all"),
            ("    -1\n    58\nNONE\n    -1\n", "function 1 (dataset 58): 1 of 11 records"),
            ("    -1\n    58b     1     2\n", "names no dataset"),
            (
                "    -1\n    58b     1     2    11  99999999     0     0     0     0\n",
                "ends before its delimiter, 99999999 bytes on",
            ),
            (&text[..cut], "record 7 counts 40 values"),
            (&text.replacen("e-0", "x-0", 1), "is not a number"),
            (&text.replacen("         5        40", "         2        40", 1), "a mobility has a phase"),
            (&text.replacen("         5        40", "         5 999999999", 1), "counts 999999999 values"),
            (&text.replacen("    4", "    6", 1), "1 coherences"),
        ] {
            let reported = refused(text);
            assert!(reported.contains(words), "{words}: {reported}");
        }
        let two = read(&file("two_points_opposite.uff"), &[0.02, 0.03, 0.05], WHOLE).unwrap_err().to_string();
        assert!(two.contains("2 responses at a driving point and 3 patches"), "{two}");
        // Cut anywhere, nothing panics.
        for name in ["accelerance_binary.uff", "receptance_mm_kn.uff"] {
            let bytes = file(name);
            (0..bytes.len()).for_each(|end| _ = read(&bytes[..end], &[0.02], WHOLE));
        }
    }
}
