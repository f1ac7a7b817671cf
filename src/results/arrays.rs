//! Arrays of a run and its checkpoint: how far each of them has been written, and a check that it still holds that.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::checkpoint::CheckpointError;
use super::error::ResultsError;
use super::folder::ResultsFolder;
use super::growing_table::TableWriter;
use super::npy::{ArrayRow, ArrayState, NpyNumber, NpyWriter};

/// State of a run's arrays, by the names of their files.
#[derive(Clone, Debug, Default, Deserialize, Eq, PartialEq, Serialize)]
pub(crate) struct WrittenArrays(BTreeMap<String, ArrayState>);

impl WrittenArrays {
    /// Brings an array to the disk and notes its state.
    ///
    /// # Errors
    /// [`ResultsError::Write`].
    pub(crate) fn sync<T: NpyNumber>(&mut self, writer: &mut NpyWriter<T>) -> Result<(), ResultsError> {
        let state = writer.sync()?;
        self.note(writer.path(), state);
        Ok(())
    }

    /// As [`Self::sync`], for a table of text.
    ///
    /// # Errors
    /// [`ResultsError::Write`].
    pub(crate) fn sync_table(&mut self, writer: &TableWriter) -> Result<(), ResultsError> {
        let state = writer.sync()?;
        self.note(writer.path(), state);
        Ok(())
    }

    fn note(&mut self, path: &Path, state: ArrayState) {
        self.0.insert(path.file_name().unwrap_or_default().to_string_lossy().into_owned(), state);
    }

    /// Checks that a folder holds all of it: every row that counts, byte by byte.
    ///
    /// # Errors
    /// [`CheckpointError::Array`] for an array that does not hold them, [`CheckpointError::Io`].
    pub(crate) fn check(&self, folder: &Path) -> Result<(), CheckpointError> {
        for (name, state) in &self.0 {
            let path = folder.join(name);
            match state.is_in(&path) {
                Ok(true) => {}
                Ok(false) => return Err(CheckpointError::Array { path, rows: state.rows }),
                Err(source) => return Err(CheckpointError::Io { path, source }),
            }
        }
        Ok(())
    }
}

/// Folder for the arrays of a run that begins or is resumed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ArrayPlace<'a> {
    /// Folder of the run.
    pub folder: &'a ResultsFolder,
    /// State of the arrays; `None` for a run that begins.
    pub written: Option<&'a WrittenArrays>,
}

impl ArrayPlace<'_> {
    /// Begins the array of a file, or continues it.
    ///
    /// # Errors
    /// As [`NpyWriter::open`]; [`ResultsError::NotThisArray`] for one that the run has not written before.
    pub(crate) fn open<T: NpyNumber>(&self, name: &str, row: ArrayRow) -> Result<NpyWriter<T>, ResultsError> {
        NpyWriter::open(&self.folder.path(name), row, self.state_of(name)?)
    }

    /// Begins a table of text with its header, or continues it.
    ///
    /// # Errors
    /// As [`TableWriter::open`]; [`ResultsError::NotThisArray`] for one that the run has not written before.
    pub(crate) fn open_table(&self, name: &str, header: &str) -> Result<TableWriter, ResultsError> {
        TableWriter::open(&self.folder.path(name), header, self.state_of(name)?)
    }

    fn state_of(&self, name: &str) -> Result<Option<ArrayState>, ResultsError> {
        let Some(written) = self.written else { return Ok(None) };
        let unknown = || ResultsError::NotThisArray { path: self.folder.path(name), rows: 0 };
        written.0.get(name).copied().map(Some).ok_or_else(unknown)
    }
}
