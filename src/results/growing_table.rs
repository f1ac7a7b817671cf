//! A table of text that grows during a run: lines are appended, and a checkpoint stores how far it has come, as for the
//! arrays ([`super::npy`]).

use std::fs::{File, OpenOptions};
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use super::error::ResultsError;
use super::npy::{ArrayState, Checked};

/// Appends text to a file.
#[derive(Debug)]
pub(crate) struct TableWriter {
    path: PathBuf,
    file: Checked<File>,
    lines: u64,
}

impl TableWriter {
    /// Begins the file with its header, or continues it from a state, which the caller has checked
    /// ([`ArrayState::is_in`]); anything behind that is cut off.
    ///
    /// # Errors
    /// [`ResultsError::Create`], [`ResultsError::Write`].
    pub(crate) fn open(path: &Path, header: &str, state: Option<ArrayState>) -> Result<Self, ResultsError> {
        let writing = || ResultsError::writing(path);
        let begun = ArrayState { rows: 0, header: 0, bytes: 0, checksum: 0 };
        let (file, state) = match state {
            None => (File::create(path).map_err(ResultsError::creating(path))?, begun),
            Some(state) => {
                let mut file = OpenOptions::new().write(true).open(path).map_err(writing())?;
                file.set_len(state.bytes).and_then(|()| file.seek(SeekFrom::End(0))).map_err(writing())?;
                (file, state)
            }
        };
        let mut writer = Self { path: path.to_owned(), file: Checked::after(file, state), lines: state.rows };
        if state.bytes == 0 {
            writer.append(header)?;
        }
        Ok(writer)
    }

    /// Appends lines.
    ///
    /// # Errors
    /// [`ResultsError::Write`].
    pub(crate) fn append(&mut self, lines: &str) -> Result<(), ResultsError> {
        self.lines += lines.matches('\n').count() as u64;
        self.file.write_all(lines.as_bytes()).map_err(ResultsError::writing(&self.path))
    }

    /// Brings the data to the disk; returns how far the table has come.
    ///
    /// # Errors
    /// [`ResultsError::Write`].
    pub(crate) fn sync(&self) -> Result<ArrayState, ResultsError> {
        self.file.sync(self.lines, 0).map_err(ResultsError::writing(&self.path))
    }

    /// Path of the file.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_goes_on_where_its_checkpoint_ends() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.csv");
        let mut writer = TableWriter::open(&path, "a,b\n", None).unwrap();
        writer.append("1,2\n").unwrap();
        let state = writer.sync().unwrap();
        writer.append("lost\n").unwrap();
        drop(writer);
        assert!(state.rows == 2 && state.is_in(&path).unwrap());
        let mut writer = TableWriter::open(&path, "a,b\n", Some(state)).unwrap();
        writer.append("3,4\n").unwrap();
        assert_eq!(writer.sync().unwrap().rows, 3);
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "a,b\n1,2\n3,4\n");
        std::fs::write(&path, "a,c\n1,2\n3,4\n").unwrap();
        assert!(!state.is_in(&path).unwrap());
    }
}
