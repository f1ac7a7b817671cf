//! Arrays in NumPy's `.npy` format, appended row by row during a run.
//!
//! The number of rows is known only at the end (a run may be interrupted), so the header is written first with spare
//! room and patched in place: format version 1.0, always 128 bytes, the dictionary padded with spaces as the format
//! requires. A header on disk is valid at any moment; it counts the rows of the last [`NpyWriter::checkpoint`]. The
//! crate npyz reads these headers but patches one-dimensional shapes only.
//!
//! Every row goes through a running checksum on its way to the file, which a run's checkpoint stores: a CRC-32 finds
//! every flipped byte and costs some picoseconds per byte. The header needs none: it is rewritten when a run is
//! resumed.

use std::fs::{File, OpenOptions};
use std::io::{self, BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use std::marker::PhantomData;
use std::path::{Path, PathBuf};

use npyz::{NpyHeader, Order};
use serde::{Deserialize, Serialize};

use super::error::ResultsError;

/// Bytes before the data: a multiple of 64, as NumPy aligns, and long enough for any shape of two 20-digit numbers.
const HEADER_BYTES: usize = 128;
/// Size of the write buffer: some hundred rows of a patch.
const BUFFER_BYTES: usize = 1 << 18;

/// A type of numbers in an array.
pub trait NpyNumber: Copy {
    /// NumPy's type descriptor, little-endian.
    const DESCRIPTOR: &'static str;
    /// Array of its bytes.
    type Bytes: AsRef<[u8]>;
    /// Bytes of the number, little-endian.
    fn bytes(self) -> Self::Bytes;
}

impl NpyNumber for f32 {
    const DESCRIPTOR: &'static str = "<f4";
    type Bytes = [u8; 4];
    fn bytes(self) -> [u8; 4] {
        self.to_le_bytes()
    }
}

impl NpyNumber for f64 {
    const DESCRIPTOR: &'static str = "<f8";
    type Bytes = [u8; 8];
    fn bytes(self) -> [u8; 8] {
        self.to_le_bytes()
    }
}

impl NpyNumber for i64 {
    const DESCRIPTOR: &'static str = "<i8";
    type Bytes = [u8; 8];
    fn bytes(self) -> [u8; 8] {
        self.to_le_bytes()
    }
}

/// Shape of one row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ArrayRow {
    /// One number: the array is one-dimensional, \[rows\].
    Scalar,
    /// A row of that many numbers: the array is two-dimensional, \[rows, columns\].
    Columns(usize),
}

impl ArrayRow {
    /// Number of numbers in a row.
    pub fn length(self) -> usize {
        match self {
            Self::Scalar => 1,
            Self::Columns(columns) => columns,
        }
    }

    /// True if an array of that shape has such rows.
    fn fits(self, shape: &[u64]) -> bool {
        match self {
            Self::Scalar => shape.len() == 1,
            Self::Columns(columns) => shape.len() == 2 && shape[1] == columns as u64,
        }
    }
}

/// How far an array has been written, as recorded in a checkpoint.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize)]
pub struct ArrayState {
    /// Number of rows.
    pub rows: u64,
    /// Size of the header before them \[bytes\].
    pub(super) header: u64,
    /// Size of these rows \[bytes\].
    pub(super) bytes: u64,
    /// CRC-32 of these bytes.
    pub(super) checksum: u32,
}

impl ArrayState {
    /// True if a file holds exactly these rows behind its header; further rows do not matter.
    ///
    /// # Errors
    /// Errors of reading it.
    pub fn is_in(&self, path: &Path) -> io::Result<bool> {
        let mut file = File::open(path)?;
        file.seek(SeekFrom::Start(self.header))?;
        let mut found = Checked { inner: io::sink(), checksum: crc32fast::Hasher::new(), bytes: 0 };
        io::copy(&mut BufReader::with_capacity(BUFFER_BYTES, file).take(self.bytes), &mut found)?;
        Ok(found.bytes == self.bytes && found.checksum.finalize() == self.checksum)
    }
}

/// A writer with the checksum of everything written to it.
#[derive(Debug)]
pub(super) struct Checked<W> {
    pub inner: W,
    pub checksum: crc32fast::Hasher,
    pub bytes: u64,
}

impl Checked<File> {
    /// Goes on behind the bytes of a state.
    pub(super) fn after(inner: File, ArrayState { bytes, checksum, .. }: ArrayState) -> Self {
        Self { inner, checksum: crc32fast::Hasher::new_with_initial_len(checksum, bytes), bytes }
    }

    /// Brings the data to the disk; returns the state of a file of so many rows behind a header.
    pub(super) fn sync(&self, rows: u64, header: u64) -> io::Result<ArrayState> {
        self.inner.sync_data()?;
        Ok(ArrayState { rows, header, bytes: self.bytes, checksum: self.checksum.clone().finalize() })
    }
}

impl<W: Write> Write for Checked<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.inner.write(bytes)?;
        self.checksum.update(&bytes[..written]);
        self.bytes += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

/// Appends rows to one `.npy` file.
#[derive(Debug)]
pub struct NpyWriter<T> {
    path: PathBuf,
    file: BufWriter<Checked<File>>,
    row: ArrayRow,
    rows: u64,
    number: PhantomData<T>,
}

impl<T: NpyNumber> NpyWriter<T> {
    /// Goes on behind the rows of `state`.
    fn of(path: &Path, file: File, row: ArrayRow, state: ArrayState) -> Result<Self, ResultsError> {
        let file = BufWriter::with_capacity(BUFFER_BYTES, Checked::after(file, state));
        let mut writer = Self { path: path.to_owned(), file, row, rows: state.rows, number: PhantomData };
        writer.checkpoint()?;
        Ok(writer)
    }

    /// Begins the file, or continues it from a state.
    ///
    /// # Errors
    /// As [`Self::create`] and [`Self::reopen`].
    pub fn open(path: &Path, row: ArrayRow, state: Option<ArrayState>) -> Result<Self, ResultsError> {
        state.map_or_else(|| Self::create(path, row), |state| Self::reopen(path, row, state))
    }

    /// Creates the file, with a header of zero rows.
    ///
    /// # Errors
    /// [`ResultsError::Create`], [`ResultsError::Write`].
    pub fn create(path: &Path, row: ArrayRow) -> Result<Self, ResultsError> {
        let file = File::create(path).map_err(ResultsError::creating(path))?;
        Self::of(path, file, row, ArrayState { rows: 0, header: HEADER_BYTES as u64, bytes: 0, checksum: 0 })
    }

    /// Goes on with a file whose first rows are those of `state`, which the caller has checked ([`ArrayState::is_in`]);
    /// anything behind them is cut off.
    ///
    /// # Errors
    /// [`ResultsError::NotThisArray`] for another type or shape of row, or too few rows; [`ResultsError::Write`].
    pub fn reopen(path: &Path, row: ArrayRow, state: ArrayState) -> Result<Self, ResultsError> {
        let writing = || ResultsError::writing(path);
        let ArrayState { rows, bytes, .. } = state;
        let mut file = OpenOptions::new().read(true).write(true).open(path).map_err(writing())?;
        let found = NpyHeader::from_reader(&mut file);
        let at = file.stream_position().map_err(writing())?;
        let length = file.metadata().map_err(writing())?.len();
        // Everything but the number of rows, which the header may not count yet.
        let same = found.is_ok_and(|found| {
            let number = found.dtype().descr().trim_matches('\'') == T::DESCRIPTOR;
            at == HEADER_BYTES as u64 && number && found.order() == Order::C && row.fits(found.shape())
        });
        let row_bytes = size_of::<T>() as u64 * row.length() as u64;
        let end = bytes.checked_add(HEADER_BYTES as u64).filter(|end| *end <= length);
        match end.filter(|_| same && rows.checked_mul(row_bytes) == Some(bytes)) {
            Some(end) => file.set_len(end).map_err(writing())?,
            None => return Err(ResultsError::NotThisArray { path: path.to_owned(), rows }),
        }
        Self::of(path, file, row, state)
    }

    /// Flushes as [`Self::checkpoint`], and brings the data to the disk; returns how far the array has come.
    ///
    /// # Errors
    /// [`ResultsError::Write`].
    pub fn sync(&mut self) -> Result<ArrayState, ResultsError> {
        self.checkpoint()?;
        let synced = self.file.get_ref().sync(self.rows, HEADER_BYTES as u64);
        synced.map_err(ResultsError::writing(&self.path))
    }

    /// Appends one row.
    ///
    /// # Errors
    /// [`ResultsError::RowLength`], and [`ResultsError::Write`] for this or any earlier row (writes are buffered).
    pub fn push(&mut self, row: &[T]) -> Result<(), ResultsError> {
        let expected = self.row.length();
        if row.len() != expected {
            return Err(ResultsError::RowLength { path: self.path.clone(), expected, got: row.len() });
        }
        for &number in row {
            self.file.write_all(number.bytes().as_ref()).map_err(ResultsError::writing(&self.path))?;
        }
        self.rows += 1;
        Ok(())
    }

    /// Path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Size so far, header included \[bytes\].
    pub fn bytes(&self) -> u64 {
        HEADER_BYTES as u64 + size_of::<T>() as u64 * self.rows * self.row.length() as u64
    }

    /// Flushes and patches the header: the file is then a complete array of the rows so far.
    ///
    /// # Errors
    /// [`ResultsError::Write`].
    pub fn checkpoint(&mut self) -> Result<(), ResultsError> {
        let header = header(T::DESCRIPTOR, self.row, self.rows);
        self.file
            .flush()
            .and_then(|()| {
                // Written past the checksum, which is that of the rows.
                let file = &mut self.file.get_mut().inner;
                file.seek(SeekFrom::Start(0))?;
                file.write_all(&header)?;
                file.seek(SeekFrom::End(0)).map(|_| ())
            })
            .map_err(ResultsError::writing(&self.path))
    }

    /// Patches the header a last time and brings the data to the disk; returns the number of rows.
    ///
    /// # Errors
    /// [`ResultsError::Write`].
    pub fn finish(mut self) -> Result<u64, ResultsError> {
        self.sync()?;
        Ok(self.rows)
    }
}

/// A whole array as the content of a file; values row by row.
pub(crate) fn array_file<T: NpyNumber>(values: &[T], row: ArrayRow) -> Vec<u8> {
    let rows = values.len().checked_div(row.length()).unwrap_or_default();
    let mut file = Vec::with_capacity(HEADER_BYTES + size_of_val(values));
    file.extend_from_slice(&header(T::DESCRIPTOR, row, rows as u64));
    values.iter().for_each(|&number| file.extend_from_slice(number.bytes().as_ref()));
    file
}

/// Magic string, version 1.0, length and the dictionary, padded with spaces, a newline last.
fn header(descriptor: &str, row: ArrayRow, rows: u64) -> [u8; HEADER_BYTES] {
    let shape = match row {
        ArrayRow::Scalar => format!("({rows},)"),
        ArrayRow::Columns(columns) => format!("({rows}, {columns})"),
    };
    let dictionary = format!("{{'descr': '{descriptor}', 'fortran_order': False, 'shape': {shape}, }}");
    let mut header = [b' '; HEADER_BYTES];
    header[..8].copy_from_slice(b"\x93NUMPY\x01\x00");
    header[8..10].copy_from_slice(&((HEADER_BYTES - 10) as u16).to_le_bytes());
    header[10..10 + dictionary.len()].copy_from_slice(dictionary.as_bytes());
    header[HEADER_BYTES - 1] = b'\n';
    header
}

#[cfg(test)]
mod tests {
    use std::process::Command;

    use proptest::prelude::*;

    use super::*;

    fn read<T: npyz::Deserialize>(path: &Path) -> (Vec<u64>, Vec<T>) {
        let npy = npyz::NpyFile::new(std::fs::File::open(path).unwrap()).unwrap();
        (npy.shape().to_vec(), npy.into_vec::<T>().unwrap())
    }

    fn of(rows: u64, bytes: u64) -> ArrayState {
        ArrayState { rows, header: HEADER_BYTES as u64, bytes, checksum: 0 }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]
        #[test]
        fn npyz_reads_what_we_write(rows in 0usize..40, columns in 0usize..9, numbers: [f64; 8]) {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("a.npy");
            let mut writer = NpyWriter::<f64>::create(&path, ArrayRow::Columns(columns)).unwrap();
            let row: Vec<f64> = numbers[..columns.min(8)].iter().copied().cycle().take(columns).collect();
            for _ in 0..rows {
                writer.push(&row).unwrap();
            }
            let bytes = writer.bytes();
            prop_assert_eq!(writer.finish().unwrap(), rows as u64);
            prop_assert_eq!(std::fs::metadata(&path).unwrap().len(), bytes);
            let (shape, data) = read::<f64>(&path);
            prop_assert_eq!(shape, vec![rows as u64, columns as u64]);
            let bits = |x: &[f64]| x.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            prop_assert_eq!(bits(&data), bits(&row.repeat(rows)));
        }
    }

    #[test]
    fn the_file_is_a_valid_array_at_every_checkpoint() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("e.npy");
        let mut writer = NpyWriter::<i64>::create(&path, ArrayRow::Scalar).unwrap();
        writer.checkpoint().unwrap();
        assert_eq!(read::<i64>(&path), (vec![0], vec![]));
        for number in 0..1000 {
            writer.push(&[number - 500]).unwrap();
            if number == 9 {
                writer.checkpoint().unwrap();
                assert_eq!(read::<i64>(&path), (vec![10], (-500..-490).collect()));
            }
        }
        assert_eq!(writer.finish().unwrap(), 1000);
        assert_eq!(read::<i64>(&path), (vec![1000], (-500..500).collect()));
    }

    #[test]
    fn a_file_continues_after_the_rows_that_count() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("p.npy");
        let rows: Vec<[f64; 3]> = (0..50).map(|n| [f64::from(n), 0.5, -1.0]).collect();
        let mut whole = NpyWriter::<f64>::create(&path, ArrayRow::Columns(3)).unwrap();
        rows[..20].iter().for_each(|row| whole.push(row).unwrap());
        let state = whole.sync().unwrap();
        rows[20..].iter().for_each(|row| whole.push(row).unwrap());
        whole.finish().unwrap();
        let expected = std::fs::read(&path).unwrap();
        // A header that counts too many rows, too few, or none, and half a row at the end.
        for counted in [50, 7, 0] {
            let mut bytes = expected[..expected.len() - 5].to_vec();
            bytes[..HEADER_BYTES].copy_from_slice(&header("<f8", ArrayRow::Columns(3), counted));
            std::fs::write(&path, bytes).unwrap();
            assert!(state.is_in(&path).unwrap());
            let mut again = NpyWriter::<f64>::reopen(&path, ArrayRow::Columns(3), state).unwrap();
            assert_eq!(read::<f64>(&path).0, [20, 3]);
            assert_eq!(again.sync().unwrap(), state);
            rows[20..].iter().for_each(|row| again.push(row).unwrap());
            let end = again.sync().unwrap();
            assert_eq!(end, ArrayState { checksum: crc32fast::hash(&expected[HEADER_BYTES..]), ..of(50, 1200) });
            again.finish().unwrap();
            assert_eq!(std::fs::read(&path).unwrap(), expected);
        }
        let refused = |rows: u64, row: ArrayRow| {
            let state = of(rows, rows.wrapping_mul(8 * row.length() as u64));
            NpyWriter::<f64>::reopen(&path, row, state).unwrap_err()
        };
        for error in [
            refused(51, ArrayRow::Columns(3)),
            refused(u64::MAX, ArrayRow::Scalar),
            refused(5, ArrayRow::Columns(4)),
            refused(5, ArrayRow::Scalar),
        ] {
            assert!(matches!(error, ResultsError::NotThisArray { .. }), "{error}");
        }
        assert!(NpyWriter::<i64>::reopen(&path, ArrayRow::Columns(3), state).is_err());
        assert_eq!(std::fs::read(&path).unwrap(), expected, "a refused file is left alone");
    }

    #[test]
    fn every_flipped_byte_of_the_rows_that_count_is_found() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("p.npy");
        let mut writer = NpyWriter::<f64>::create(&path, ArrayRow::Columns(2)).unwrap();
        (0..9).for_each(|row| writer.push(&[f64::from(row), 0.1]).unwrap());
        let state = writer.sync().unwrap();
        writer.push(&[9.0, 0.1]).unwrap();
        writer.finish().unwrap();
        let good = std::fs::read(&path).unwrap();
        let counted = HEADER_BYTES..HEADER_BYTES + 9 * 16;
        for place in HEADER_BYTES..good.len() {
            let mut bytes = good.clone();
            bytes[place] ^= 0x20;
            std::fs::write(&path, bytes).unwrap();
            assert_eq!(state.is_in(&path).unwrap(), !counted.contains(&place), "{place}");
        }
        std::fs::write(&path, &good[..counted.end - 1]).unwrap();
        assert!(!state.is_in(&path).unwrap(), "a byte short");
    }

    #[test]
    fn the_longest_shape_fits_the_header() {
        let bytes = header("<f8", ArrayRow::Columns(usize::MAX), u64::MAX);
        let text = String::from_utf8_lossy(&bytes[10..]);
        assert!(text.trim_end().ends_with("'shape': (18446744073709551615, 18446744073709551615), }"), "{text}");
        assert_eq!(bytes[HEADER_BYTES - 1], b'\n');
    }

    #[test]
    fn plain_numpy_reads_it() {
        if !Command::new("python3").args(["-c", "import numpy"]).status().is_ok_and(|status| status.success()) {
            println!("skipped: no python3 with numpy here");
            return;
        }
        let folder = tempfile::tempdir().unwrap();
        let (real, whole) = (folder.path().join("real.npy"), folder.path().join("whole.npy"));
        let mut writer = NpyWriter::<f64>::create(&real, ArrayRow::Columns(2)).unwrap();
        writer.push(&[0.1, -2.5]).unwrap();
        writer.push(&[f64::NAN, 1e300]).unwrap();
        writer.push(&[3.0, 4.0]).unwrap();
        writer.finish().unwrap();
        let mut writer = NpyWriter::<i64>::create(&whole, ArrayRow::Scalar).unwrap();
        writer.push(&[i64::MIN]).unwrap();
        writer.push(&[7]).unwrap();
        writer.finish().unwrap();
        let check = "import sys, numpy as np\n\
                     a, b = np.load(sys.argv[1]), np.load(sys.argv[2])\n\
                     assert a.shape == (3, 2) and a.dtype == np.float64 and a.flags.c_contiguous, (a.shape, a.dtype)\n\
                     assert a[0, 0] == 0.1 and a[0, 1] == -2.5 and np.isnan(a[1, 0])\n\
                     assert a[1, 1] == 1e300 and a[2, 1] == 4\n\
                     assert b.shape == (2,) and b.dtype == np.int64 and b[0] == -2**63 and b[1] == 7";
        let status = Command::new("python3").arg("-c").arg(check).args([&real, &whole]).status().unwrap();
        assert!(status.success());
    }

    #[test]
    fn a_wrong_row_and_a_full_disk_name_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let mut writer = NpyWriter::<f64>::create(&folder.path().join("p.npy"), ArrayRow::Columns(3)).unwrap();
        let error = writer.push(&[1.0]).unwrap_err();
        assert!(matches!(error, ResultsError::RowLength { expected: 3, got: 1, .. }), "{error}");

        let missing = folder.path().join("no/such/folder.npy");
        assert!(matches!(NpyWriter::<f64>::create(&missing, ArrayRow::Scalar), Err(ResultsError::Create { .. })));

        let full = Path::new("/dev/full");
        if !full.exists() {
            println!("skipped: no /dev/full here");
            return;
        }
        let error = NpyWriter::<f64>::create(full, ArrayRow::Scalar).unwrap_err();
        assert!(
            matches!(&error, ResultsError::Write { source, .. } if source.kind() == std::io::ErrorKind::StorageFull)
        );
        assert!(error.to_string().contains("/dev/full"), "{error}");
    }
}
