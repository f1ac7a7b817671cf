//! Arrays and the table of sections, which a run writes while it rolls, in a folder or in memory.

use std::collections::VecDeque;

use super::Simulation;
use crate::counters::{Counter, Stage, Work};
use crate::effects::{Arrays, KeptArray, RunError, channels};
use crate::results::ResultsError;
use crate::results::arrays::{ArrayPlace, WrittenArrays};
use crate::run::section_table::SectionTable;

impl Simulation {
    /// Begins the arrays that the plan asks for, in a folder or in memory, or continues them.
    ///
    /// # Errors
    /// Errors of the arrays.
    pub(crate) fn open_arrays(&mut self, place: Option<&ArrayPlace<'_>>) -> Result<(), RunError> {
        let shape = self.prepared.contact.shape;
        let arrays = Arrays::open(channels(), &self.plan, [shape.columns, shape.across], place)?;
        self.arrays = Some(arrays).filter(|arrays| !arrays.is_empty());
        self.sections = self.plan.scene.outputs.sections.map(|_| SectionTable::open(place)).transpose()?;
        Ok(())
    }

    /// Completes the arrays; returns those that are in memory.
    ///
    /// # Errors
    /// Errors of the arrays.
    pub(crate) fn finish_arrays(&mut self) -> Result<Vec<KeptArray>, RunError> {
        let Some(arrays) = self.arrays.take() else { return Ok(Vec::new()) };
        let (bytes, in_memory) = self.meter.time(Stage::Output, || arrays.finish())?;
        self.meter.count(Counter::BytesWritten, bytes);
        self.meter.add_work(Stage::Output, Work { multiply_adds: 0, bytes });
        Ok(in_memory)
    }

    /// Flushes all rows of the arrays to the disk; returns how far each has come.
    ///
    /// # Errors
    /// Errors of the arrays.
    pub(crate) fn sync_arrays(&mut self) -> Result<WrittenArrays, ResultsError> {
        let Self { arrays, sections, meter, .. } = self;
        meter.time(Stage::Output, || {
            let mut written = arrays.as_mut().map_or(Ok(WrittenArrays::default()), Arrays::sync)?;
            sections.as_ref().map_or(Ok(()), |sections| sections.sync(&mut written))?;
            Ok(written)
        })
    }

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
