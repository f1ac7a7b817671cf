//! The table of a run's sections, which grows with the road, in a file or in memory.

use std::collections::VecDeque;

use super::Simulation;
use crate::results::ResultsError;
use crate::results::arrays::{ArrayPlace, WrittenArrays};
use crate::results::files::ResultFiles;
use crate::results::growing_table::TableWriter;
use crate::results::sections::{SECTIONS_FILE, SECTIONS_HEADER};

/// The table so far.
pub(super) enum SectionTable {
    File(TableWriter),
    Memory(String),
}

impl SectionTable {
    /// Begins the table, or continues it, in a folder; without one in memory.
    pub(super) fn open(place: Option<&ArrayPlace<'_>>) -> Result<Self, ResultsError> {
        let in_folder = |place: &ArrayPlace<'_>| Ok(Self::File(place.open_table(SECTIONS_FILE, SECTIONS_HEADER)?));
        place.map_or_else(|| Ok(Self::Memory(SECTIONS_HEADER.to_owned())), in_folder)
    }

    fn append(&mut self, rows: &str) -> Result<(), ResultsError> {
        match self {
            Self::File(writer) => writer.append(rows),
            Self::Memory(text) => {
                text.push_str(rows);
                Ok(())
            }
        }
    }

    /// Brings a file to the disk and notes how far it has come.
    pub(super) fn sync(&self, written: &mut WrittenArrays) -> Result<(), ResultsError> {
        if let Self::File(writer) = self { written.sync_table(writer) } else { Ok(()) }
    }

    /// Completes the table: one in memory is written.
    pub(super) fn finish(self, files: &dyn ResultFiles) -> Result<(), ResultsError> {
        match self {
            Self::File(writer) => writer.sync().map(drop),
            Self::Memory(text) => files.write_text(SECTIONS_FILE, &text),
        }
    }
}

impl Simulation {
    /// Appends the sections that all observers have completed; at the end of the run also those that only some have.
    pub(super) fn append_sections(&mut self, at_the_end: bool) -> Result<(), ResultsError> {
        let Some(table) = &mut self.sections else { return Ok(()) };
        let rows = self.observers.iter_mut().filter_map(|(_, observer)| observer.section_rows());
        let mut rows: Vec<&mut VecDeque<String>> = rows.collect();
        let complete = rows.iter().map(|of_observer| of_observer.len());
        let count = if at_the_end { complete.max() } else { complete.min() };
        for _ in 0..count.unwrap_or(0) {
            for of_observer in &mut rows {
                table.append(&of_observer.pop_front().unwrap_or_default())?;
            }
        }
        Ok(())
    }
}
