//! Destination of results that are written as whole files, tables, pictures, sounds and maps: a folder, or memory.

use std::cell::RefCell;
use std::collections::BTreeMap;

use super::disk::write_file;
use super::error::ResultsError;
use super::folder::ResultsFolder;

/// Destination of whole files.
pub(crate) trait ResultFiles {
    /// Writes a file.
    ///
    /// # Errors
    /// [`ResultsError::Create`], [`ResultsError::Write`].
    fn write(&self, name: &str, bytes: &[u8]) -> Result<(), ResultsError>;

    /// Writes a text file.
    ///
    /// # Errors
    /// As [`Self::write`].
    fn write_text(&self, name: &str, text: &str) -> Result<(), ResultsError> {
        self.write(name, text.as_bytes())
    }

    /// Text of a file that is there; `None` without it.
    fn read_text(&self, name: &str) -> Option<String>;
}

impl ResultFiles for ResultsFolder {
    fn write(&self, name: &str, bytes: &[u8]) -> Result<(), ResultsError> {
        write_file(&self.path(name), bytes)
    }

    fn read_text(&self, name: &str) -> Option<String> {
        std::fs::read_to_string(self.path(name)).ok()
    }
}

/// Files of a run in memory, by name.
impl ResultFiles for RefCell<BTreeMap<String, Vec<u8>>> {
    fn write(&self, name: &str, bytes: &[u8]) -> Result<(), ResultsError> {
        self.borrow_mut().insert(name.to_owned(), bytes.to_vec());
        Ok(())
    }

    fn read_text(&self, name: &str) -> Option<String> {
        self.borrow().get(name).and_then(|bytes| String::from_utf8(bytes.clone()).ok())
    }
}
