//! The table of a run's sections, which grows with the road, in a file or in memory.

use crate::results::ResultsError;
use crate::results::arrays::{ArrayPlace, WrittenArrays};
use crate::results::files::ResultFiles;
use crate::results::growing_table::TableWriter;
use crate::results::sections::{SECTIONS_FILE, SECTIONS_HEADER};

/// `sections.csv` so far.
pub(crate) enum SectionTable {
    File(TableWriter),
    Memory(String),
}

impl SectionTable {
    /// Begins the table, or continues it, in a folder; without one in memory.
    pub(crate) fn open(place: Option<&ArrayPlace<'_>>) -> Result<Self, ResultsError> {
        let in_folder = |place: &ArrayPlace<'_>| Ok(Self::File(place.open_table(SECTIONS_FILE, SECTIONS_HEADER)?));
        place.map_or_else(|| Ok(Self::Memory(SECTIONS_HEADER.to_owned())), in_folder)
    }

    /// Appends rows.
    pub(crate) fn append(&mut self, rows: &str) -> Result<(), ResultsError> {
        match self {
            Self::File(writer) => writer.append(rows),
            Self::Memory(text) => {
                text.push_str(rows);
                Ok(())
            }
        }
    }

    /// Brings a file to the disk and notes how far it has come.
    pub(crate) fn sync(&self, written: &mut WrittenArrays) -> Result<(), ResultsError> {
        if let Self::File(writer) = self { written.sync_table(writer) } else { Ok(()) }
    }

    /// Completes the table: one in memory is written.
    pub(crate) fn finish(self, files: &dyn ResultFiles) -> Result<(), ResultsError> {
        match self {
            Self::File(writer) => writer.sync().map(drop),
            Self::Memory(text) => files.write_text(SECTIONS_FILE, &text),
        }
    }
}
