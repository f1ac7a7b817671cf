//! A MATLAB file of all arrays and tables of a run; `scipy.io.loadmat` and Octave read it as well.
//!
//! An array is a matrix named after its file, a table a struct of its columns, whose names contain their units. A sound
//! is a matrix of pressures over time, a column per channel, at `run.sample_rate`. The struct `units` has the units of
//! the arrays and of the figures in the struct `run`.
//!
//! MATLAB's files, level 5, not compressed: a header, then variables, each an element of nested elements with a type
//! and a length. The layout is that of "MAT-File Format" by MathWorks, little-endian.

use crate::effects::channel;
use crate::effects::stored::Stored;
use crate::results::table::StoredColumn;
use crate::sound::wav;

use super::error::ExportError;

/// Begin of every exported file, by which an earlier export is recognised.
pub const MAT_HEAD: &str = "MATLAB 5.0 MAT-file, Platform: tyrewave,";

/// Content of the file.
///
/// # Errors
/// [`ExportError`].
pub(crate) fn mat(stored: &Stored) -> Result<Vec<u8>, ExportError> {
    let mut variables = Vec::new();
    let (mut run, mut units) = figures(stored);
    let mut sample_rate = None;
    for file in &stored.summary.files {
        let (stem, extension) = file.rsplit_once('.').unwrap_or((file, ""));
        match extension {
            "npy" => {
                let Some(array) = stored.array(file)? else { continue };
                let name = free(&variables, stem);
                let unit = channel(stem).map_or("", |channel| channel.unit);
                let shape = [array.shape.first().copied().unwrap_or(1), array.shape.iter().skip(1).product()];
                units.push((name.clone(), Value::Text(unit.into())));
                variables.push((name, Value::Numbers(array.values, shape)));
            }
            "csv" => {
                let Some(table) = stored.table(file)? else { continue };
                let mut fields = Vec::new();
                for (column, cells) in table.columns {
                    let value = match cells {
                        StoredColumn::Numbers(numbers) => Value::column(numbers),
                        StoredColumn::Words(words) => Value::Cells(words.into_iter().map(Value::Text).collect()),
                    };
                    fields.push((free(&fields, &column), value));
                }
                variables.push((free(&variables, stem), Value::Struct(fields)));
            }
            "wav" => {
                let Some(sound) = wav::recording(&stored.bytes(file)?) else { continue };
                let name = free(&variables, stem);
                let shape = [sound.channels.first().map_or(0, Vec::len), sound.channels.len()];
                let row = |sample: usize| sound.channels.iter().map(move |channel| channel[sample]);
                let values = (0..shape[0]).flat_map(row).collect();
                units.push((name.clone(), Value::Text("Pa".into())));
                variables.push((name, Value::Numbers(values, shape)));
                sample_rate = Some(f64::from(sound.rate));
            }
            _ => {}
        }
    }
    if let Some(rate) = sample_rate {
        run.push(("sample_rate".into(), Value::column(vec![rate])));
        units.push(("sample_rate".into(), Value::Text("Hz".into())));
    }
    variables.push(("run".into(), Value::Struct(run)));
    variables.push(("units".into(), Value::Struct(units)));
    let about = format!("{} {}, {}", "version", stored.summary.version, stored.name());
    file(MAT_HEAD, &about, &variables)
}

type Fields = Vec<(String, Value)>;

/// Single numbers and texts beside the arrays, and their units.
fn figures(stored: &Stored) -> (Fields, Fields) {
    let plan = &stored.plan;
    let mut run: Fields = [
        ("name", stored.name()),
        ("title", stored.summary.title.clone()),
        ("version", stored.summary.version.clone().into_owned()),
    ]
    .map(|(name, text)| (name.to_owned(), Value::Text(text)))
    .into();
    let mut units = Fields::new();
    for (name, unit, number) in [
        ("time_step", "s", plan.time_step),
        ("warm_up", "s", plan.scene.rolling.warm_up),
        ("speed", "m/s", plan.speed),
        ("element_length", "m", plan.element),
        ("circumference", "m", plan.scene.tyre.circumference),
        ("contact_width", "m", plan.scene.tyre.contact_width),
        ("mean_force", "N", stored.summary.outcome.mean_force.unwrap_or(f64::NAN)),
    ] {
        run.push((name.into(), Value::column(vec![number])));
        units.push((name.into(), Value::Text(unit.into())));
    }
    (run, units)
}

/// A valid name made from the text that none of the others has.
fn free(taken: &[(String, Value)], text: &str) -> String {
    let is_free = |name: &String| taken.iter().all(|(other, _)| other != name);
    let first = name(text);
    let more = (2_usize..).map(|count| name(&format!("x{count}_{text}")));
    std::iter::once(first.clone()).chain(more).find(is_free).unwrap_or(first)
}

/// Types of elements in the format.
mod element {
    pub(super) const INT8: u32 = 1;
    pub(super) const UINT16: u32 = 4;
    pub(super) const INT32: u32 = 5;
    pub(super) const UINT32: u32 = 6;
    pub(super) const DOUBLE: u32 = 9;
    pub(super) const MATRIX: u32 = 14;
}

/// Bytes of the text that a file begins with, and of its whole header.
const TEXT_BYTES: usize = 116;
const HEADER_BYTES: usize = 128;
/// Longest name of a variable or field; the format also stores a terminating zero.
const LONGEST_NAME: usize = 63;
/// A reader may use signed 32-bit lengths.
const MOST_BYTES: usize = i32::MAX as usize;

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    /// Numbers row by row, and their numbers of rows and columns.
    Numbers(Vec<f64>, [usize; 2]),
    /// UTF-16 in the file.
    Text(String),
    /// A column of values of any kind.
    Cells(Vec<Value>),
    /// Values with names, in this order.
    Struct(Vec<(String, Value)>),
}

impl Value {
    pub(super) fn column(numbers: Vec<f64>) -> Self {
        let rows = numbers.len();
        Self::Numbers(numbers, [rows, 1])
    }
}

/// Bytes of a file; its text begins with `head`, followed by `about`.
///
/// # Errors
/// [`ExportError::TooLarge`] for a variable beyond 2 GiB.
pub(super) fn file(head: &str, about: &str, variables: &[(String, Value)]) -> Result<Vec<u8>, ExportError> {
    let text = format!("{head} {about}").replace(|letter: char| !letter.is_ascii() || letter.is_ascii_control(), "?");
    let mut bytes = text.into_bytes();
    bytes.resize(TEXT_BYTES, b' ');
    // No offset of subsystem data.
    bytes.resize(HEADER_BYTES - 4, 0);
    // Version 1, and the mark by which a reader recognises the byte order.
    bytes.extend(0x0100_u16.to_le_bytes());
    bytes.extend(b"IM");
    for (name, value) in variables {
        let begin = bytes.len();
        matrix(&mut bytes, &short(name), value);
        if bytes.len() - begin > MOST_BYTES {
            return Err(ExportError::TooLarge { name: name.clone() });
        }
    }
    Ok(bytes)
}

/// A valid name from any text: a letter first, then letters, digits and underscores, 63 at most.
pub(super) fn name(text: &str) -> String {
    let mut name: String = text.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if !name.starts_with(|first: char| first.is_ascii_alphabetic()) {
        name.insert(0, 'x');
    }
    short(&name)
}

fn short(name: &str) -> String {
    name.chars().take(LONGEST_NAME).collect()
}

fn matrix(bytes: &mut Vec<u8>, name: &str, value: &Value) {
    let (class, shape) = match value {
        Value::Cells(cells) => (1_u32, [cells.len(), 1]),
        Value::Struct(_) => (2, [1, 1]),
        Value::Text(text) => (4, [usize::from(!text.is_empty()), text.encode_utf16().count()]),
        Value::Numbers(_, shape) => (6, *shape),
    };
    nested(bytes, element::MATRIX, |bytes| {
        nested(bytes, element::UINT32, |bytes| bytes.extend([class, 0].map(u32::to_le_bytes).as_flattened()));
        nested(bytes, element::INT32, |bytes| {
            bytes.extend(shape.map(|length| (length as u32).to_le_bytes()).as_flattened());
        });
        nested(bytes, element::INT8, |bytes| bytes.extend(name.as_bytes()));
        match value {
            Value::Numbers(numbers, [rows, columns]) => nested(bytes, element::DOUBLE, |bytes| {
                // MATLAB stores columns.
                bytes.reserve(8 * numbers.len());
                for column in 0..*columns {
                    let column = (0..*rows).map(|row| numbers[row * columns + column]);
                    column.for_each(|number| bytes.extend(number.to_le_bytes()));
                }
            }),
            Value::Text(text) => nested(bytes, element::UINT16, |bytes| {
                text.encode_utf16().for_each(|unit| bytes.extend(unit.to_le_bytes()));
            }),
            Value::Cells(cells) => cells.iter().for_each(|cell| matrix(bytes, "", cell)),
            Value::Struct(fields) => {
                let room = LONGEST_NAME + 1;
                nested(bytes, element::INT32, |bytes| bytes.extend((room as u32).to_le_bytes()));
                nested(bytes, element::INT8, |bytes| {
                    for (name, _) in fields {
                        let end = bytes.len() + room;
                        bytes.extend(short(name).as_bytes());
                        bytes.resize(end, 0);
                    }
                });
                fields.iter().for_each(|(_, value)| matrix(bytes, "", value));
            }
        }
    });
}

/// Writes an element: its type, its length, its content, and zeros up to a multiple of eight bytes.
fn nested(bytes: &mut Vec<u8>, kind: u32, content: impl FnOnce(&mut Vec<u8>)) {
    bytes.extend(kind.to_le_bytes());
    let place = bytes.len();
    bytes.extend([0; 4]);
    content(bytes);
    let length = (bytes.len() - place - 4) as u32;
    bytes[place..place + 4].copy_from_slice(&length.to_le_bytes());
    bytes.resize(bytes.len().next_multiple_of(8), 0);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(bytes: &[u8]) -> Vec<u32> {
        bytes.chunks_exact(4).map(|word| u32::from_le_bytes(word.try_into().unwrap())).collect()
    }

    #[test]
    fn header_and_tags_are_those_of_the_format() {
        let numbers = Value::Numbers(vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0], [2, 3]);
        let bytes = file("MATLAB 5.0 MAT-file", "of \u{e4} run", &[("force".into(), numbers)]).unwrap();
        assert!(bytes.starts_with(b"MATLAB 5.0 MAT-file of ? run  ") && bytes[115] == b' ');
        assert_eq!(bytes[116..128], [0, 0, 0, 0, 0, 0, 0, 0, 0, 1, b'I', b'M']);
        // Matrix; flags with the class of doubles; two dimensions; five letters, padded; six doubles.
        let tags = words(&bytes[128..184]);
        assert_eq!(tags[..10], [14, 16 + 16 + 16 + 56, 6, 8, 6, 0, 5, 8, 2, 3]);
        assert_eq!((tags[10], tags[11], &bytes[176..184]), (1, 5, &b"force\0\0\0"[..]));
        assert_eq!(words(&bytes[184..192]), [9, 48]);
        let found: Vec<f64> = bytes[192..].chunks_exact(8).map(|n| f64::from_le_bytes(n.try_into().unwrap())).collect();
        assert_eq!(found, [1.0, 4.0, 2.0, 5.0, 3.0, 6.0], "column by column");
    }

    #[test]
    fn text_cells_and_structs_are_nested() {
        let cells = Value::Cells(vec![Value::Text("\u{b5}".into()), Value::column(vec![])]);
        let bytes = file("", "", &[("s".into(), Value::Struct(vec![("a".into(), cells)]))]).unwrap();
        let words = words(&bytes[128..]);
        assert_eq!(words[1] as usize, bytes.len() - 136);
        assert_eq!(words[4], 2, "a struct");
        // After flags and dimensions: length of a field name and the names.
        assert_eq!((&words[14..17], &words[18..20]), (&[5, 4, 64][..], &[1, 64][..]));
        let inner = &words[36..];
        assert_eq!((inner[0], inner[4], &inner[8..10]), (14, 1, &[2, 1][..]), "cells");
        assert_eq!((inner[12], inner[16], &inner[20..22]), (14, 4, &[1, 1][..]), "text");
        assert_eq!(inner[24..27], [4, 2, 0xb5]);
    }

    #[test]
    fn names_are_those_that_matlab_takes() {
        assert_eq!(name("vibration_map_tread_non-rotating"), "vibration_map_tread_non_rotating");
        assert_eq!((name("7.5 m"), name("")), ("x7_5_m".to_owned(), "x".to_owned()));
        assert_eq!(name(&"a".repeat(80)).len(), 63);
    }
}
