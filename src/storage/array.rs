//! `.npy` arrays of numbers, read from files that may be damaged or hostile.
//!
//! The library that knows the format trusts its header: it multiplies lengths that overflow, and parses nested brackets
//! to any depth, in a time that doubles with each. Therefore the header is checked here before: its length, its
//! brackets, and whether the file holds as many numbers as it promises.

use std::fs::File;
use std::io::{BufReader, Cursor, Error, ErrorKind, Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use npyz::{DType, NpyFile, Order, TypeChar};
use thiserror::Error;

use super::input;

/// Longest header of an array of plain numbers \[bytes\]; writers pad theirs to 128 at most.
const LONGEST_HEADER: usize = 4096;

/// More numbers than any file holds, yet so few that their bytes do not overflow.
const MOST_NUMBERS: u64 = 1 << 48;

/// Why an array is not read.
#[derive(Debug, Error)]
pub(crate) enum ArrayError {
    /// The file cannot be read.
    #[error(transparent)]
    Io(#[from] Error),
    /// It is not an array, or an incomplete one.
    #[error("it is not a complete .npy array: {0}")]
    Damaged(String),
    /// It does not hold real numbers.
    #[error("this array holds {found}, and real numbers are needed")]
    Type {
        /// Type of its numbers, as written in the file.
        found: String,
    },
}

/// An open array whose header has been read and checked.
pub(crate) struct Array {
    npy: NpyFile<BufReader<Box<dyn Read>>>,
    kind: (TypeChar, u64),
    /// Size of the header \[bytes\].
    header: u64,
}

/// Rows of an open array. Clones read the same file.
#[derive(Clone, Debug)]
pub(crate) struct ArrayRows {
    file: Arc<Mutex<File>>,
    header: u64,
    pub rows: usize,
    pub columns: usize,
    is_double: bool,
}

impl ArrayRows {
    /// Numbers of some rows, row by row.
    ///
    /// # Errors
    /// Errors of the file.
    pub(crate) fn read(&self, rows: Range<usize>) -> Result<Vec<f64>, Error> {
        let bytes_of_row = self.columns * if self.is_double { 8 } else { 4 };
        let mut bytes = vec![0; rows.len() * bytes_of_row];
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        file.seek(SeekFrom::Start(self.header + (rows.start * bytes_of_row) as u64))?;
        file.read_exact(&mut bytes)?;
        drop(file);
        if self.is_double {
            return Ok(bytes.as_chunks().0.iter().map(|&bytes| f64::from_le_bytes(bytes)).collect());
        }
        Ok(bytes.as_chunks().0.iter().map(|&bytes| f64::from(f32::from_le_bytes(bytes))).collect())
    }
}

impl Array {
    /// Opens a file, and reads and checks its header.
    ///
    /// # Errors
    /// For a file that cannot be read, is not a complete array, or does not hold real numbers.
    pub(crate) fn open(path: &Path) -> Result<Self, ArrayError> {
        let (mut file, size) = input::open(path)?;
        let header = header(&mut file)?;
        let text = String::from_utf8_lossy(&header);
        let promised = promised(&text)?;
        let length = header.len() as u64;
        let found = size.saturating_sub(length);
        let bytes: Box<dyn Read> = Box::new(Cursor::new(header).chain(file));
        let npy = NpyFile::new(BufReader::new(bytes)).map_err(damaged)?;
        let kind = match npy.dtype() {
            DType::Plain(kind) if matches!(kind.type_char(), TypeChar::Float | TypeChar::Int) => {
                (kind.type_char(), kind.size_field())
            }
            other => return Err(ArrayError::Type { found: other.descr() }),
        };
        let promised = promised.saturating_mul(kind.1);
        if promised > found {
            let wrong = format!("its header promises {promised} bytes of numbers, {found} are there");
            return Err(ArrayError::Damaged(wrong));
        }
        Ok(Self { npy, kind, header: length })
    }

    /// Length of each dimension.
    pub(crate) fn shape(&self) -> &[u64] {
        self.npy.shape()
    }

    /// True if its numbers are floating-point, not integers.
    pub(crate) fn is_of_floats(&self) -> bool {
        self.kind.0 == TypeChar::Float
    }

    /// Type of its numbers, as written in the file.
    pub(crate) fn type_name(&self) -> String {
        self.npy.dtype().descr()
    }

    /// Rows of the two-dimensional array of floating-point numbers that a file is, to be read in any order; `None` if
    /// they are not stored row by row.
    ///
    /// # Errors
    /// For a file that cannot be opened again.
    pub(crate) fn into_rows(self, path: &Path) -> Result<Option<ArrayRows>, ArrayError> {
        let (&[rows, columns], Order::C, TypeChar::Float) = (self.shape(), self.npy.order(), self.kind.0) else {
            return Ok(None);
        };
        let is_double = match self.type_name().trim_matches('\'') {
            "<f4" => false,
            "<f8" => true,
            _ => return Ok(None),
        };
        let [rows, columns] = [rows, columns].map(|length| length as usize);
        let file = Arc::new(Mutex::new(input::open(path)?.0));
        Ok(Some(ArrayRows { file, header: self.header, rows, columns, is_double }))
    }

    /// All numbers, row by row if there are two dimensions, whatever the order in the file.
    ///
    /// # Errors
    /// For numbers of another length than 4 or 8 bytes, and errors of the file.
    pub(crate) fn into_values(self) -> Result<Vec<f64>, ArrayError> {
        let (shape, order) = (self.npy.shape().to_vec(), self.npy.order());
        let npy = self.npy;
        let stored: Vec<f64> = match self.kind {
            (TypeChar::Float, 8) => npy.into_vec().map_err(damaged)?,
            (TypeChar::Float, 4) => npy.into_vec::<f32>().map_err(damaged)?.into_iter().map(f64::from).collect(),
            (TypeChar::Int, 8) => npy.into_vec::<i64>().map_err(damaged)?.into_iter().map(|z| z as f64).collect(),
            (TypeChar::Int, 4) => npy.into_vec::<i32>().map_err(damaged)?.into_iter().map(f64::from).collect(),
            _ => return Err(ArrayError::Type { found: npy.dtype().descr() }),
        };
        match (order, &shape[..]) {
            (Order::Fortran, &[rows, columns]) => {
                let (rows, columns) = (rows as usize, columns as usize);
                let place = |place: usize| place % columns * rows + place / columns;
                Ok((0..stored.len()).map(|index| stored[place(index)]).collect())
            }
            _ => Ok(stored),
        }
    }
}

fn damaged(error: Error) -> ArrayError {
    ArrayError::Damaged(error.to_string())
}

/// The bytes of a file before its numbers.
fn header(file: &mut File) -> Result<Vec<u8>, ArrayError> {
    let wrong = |what: &str| ArrayError::Damaged(what.to_owned());
    let mut bytes = Vec::new();
    let mut read = |count: usize| -> Result<Vec<u8>, ArrayError> {
        let before = bytes.len();
        let taken = file.take(count as u64).read_to_end(&mut bytes)?;
        if taken == count { Ok(bytes[before..].to_vec()) } else { Err(damaged(ErrorKind::UnexpectedEof.into())) }
    };
    let magic = read(8)?;
    if !magic.starts_with(b"\x93NUMPY") {
        return Err(wrong("it does not begin as one"));
    }
    let size = read(if magic[6] == 1 { 2 } else { 4 })?;
    let length = size.iter().rev().fold(0, |length, &byte| (length << 8) | usize::from(byte));
    if length > LONGEST_HEADER {
        return Err(wrong("its header is longer than that of an array of plain numbers"));
    }
    read(length)?;
    Ok(bytes)
}

/// Number of values that a header promises: the product of its shape.
fn promised(header: &str) -> Result<u64, ArrayError> {
    let count = |bracket: char| header.matches(bracket).count();
    if [('{', 1), ('(', 1), ('[', 0)].into_iter().any(|(bracket, most)| count(bracket) > most) {
        return Err(ArrayError::Damaged("its header has more brackets than that of an array of plain numbers".into()));
    }
    let shape = header.split_once('(').and_then(|(_, rest)| rest.split_once(')')).map(|(shape, _)| shape);
    let lengths = shape.unwrap_or_default().split(',').map(str::trim).filter(|length| !length.is_empty());
    // Python 2 wrote `3L`.
    let product = lengths
        .map(|length| length.trim_end_matches('L').parse::<u64>())
        .try_fold(1, |product, length| length.ok().and_then(|length| u64::checked_mul(product, length)));
    product
        .filter(|&product| product < MOST_NUMBERS)
        .ok_or_else(|| ArrayError::Damaged("its shape is not one of an array in a file".into()))
}

#[cfg(test)]
mod tests {
    use npyz::WriterBuilder;

    use super::*;

    fn opened(bytes: &[u8]) -> Result<Array, ArrayError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("z.npy");
        std::fs::write(&path, bytes).unwrap();
        Array::open(&path)
    }

    fn with_header(header: &str, numbers: usize) -> Vec<u8> {
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.resize(bytes.len() + 8 * numbers, 0);
        bytes
    }

    fn refusal(header: &str) -> String {
        opened(&with_header(header, 12)).err().unwrap().to_string()
    }

    #[test]
    fn either_order_gives_rows() {
        for (order, values) in
            [(Order::C, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]), (Order::Fortran, [0.0, 3.0, 1.0, 4.0, 2.0, 5.0])]
        {
            let mut bytes = Vec::new();
            let options = npyz::WriteOptions::new().default_dtype().order(order).shape(&[2, 3]).writer(&mut bytes);
            let mut writer = options.begin_nd().unwrap();
            writer.extend(values).unwrap();
            writer.finish().unwrap();
            let array = opened(&bytes).unwrap();
            assert!(array.is_of_floats() && array.shape() == [2, 3]);
            assert_eq!(array.into_values().unwrap(), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
            assert!(opened(&bytes[..bytes.len() - 1]).is_err(), "a number is cut");
        }
    }

    #[test]
    fn a_shape_whose_product_wraps_is_refused() {
        for order in ["True", "False"] {
            let shape = "(6148914691236517206, 3)";
            let header = format!("{{'descr': '<f8', 'fortran_order': {order}, 'shape': {shape}, }}\n");
            assert!(refusal(&header).contains("its shape"), "{}", refusal(&header));
        }
        let header = "{'descr': '<f8', 'fortran_order': False, 'shape': (70368744177664, 3), }\n";
        assert!(refusal(header).contains("promises"), "{}", refusal(header));
    }

    #[test]
    fn brackets_within_brackets_are_refused_at_once() {
        let nested = format!("{{'descr': {}{}, 'shape': (2,), }}", "[".repeat(40), "]".repeat(40));
        let tuples =
            format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {}2{} }}", "(".repeat(40), ")".repeat(40));
        for header in [nested, tuples] {
            assert!(refusal(&header).contains("brackets"), "{}", refusal(&header));
        }
    }

    #[test]
    fn files_without_an_array_of_real_numbers_are_refused() {
        let header = |kind: &str| format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': (3, 4), }}\n");
        assert!(refusal(&header("<c16")).contains("real numbers"), "{}", refusal(&header("<c16")));
        assert!(refusal(&header("|O")).contains("real numbers"), "{}", refusal(&header("|O")));
        assert!(opened(b"heights").err().unwrap().to_string().contains("not a complete .npy array"));
        assert!(opened(b"heights, many of them").err().unwrap().to_string().contains("does not begin"));
        let long = with_header(&" ".repeat(5000), 0);
        assert!(opened(&long).err().unwrap().to_string().contains("longer"));
        assert_eq!(opened(&with_header(&header("<i8"), 12)).unwrap().into_values().unwrap(), [0.0; 12]);
    }
}
