//! Arrays of a run, each defined once: its file, unit, meaning, and how a row of it is read from a step.
//!
//! Folder, memory, MATLAB file, Python package and documentation use these definitions.

use super::error::RunError;
use super::observer::Step;
use crate::plan::Plan;
use crate::results::ResultsError;
use crate::results::arrays::{ArrayPlace, WrittenArrays};
use crate::results::npy::{ArrayRow, NpyNumber, NpyWriter};

/// Definition of an array of a run.
pub struct Channel {
    /// Name of the file without its extension.
    pub name: &'static str,
    /// Unit of its numbers; "1" without a dimension.
    pub unit: &'static str,
    /// Meaning in a few words, for the documentation.
    pub meaning: &'static str,
    /// Size of a row.
    pub row: RowShape,
    /// Steps that have a row.
    pub when: RowTimes,
    /// True for a plan whose run has this array.
    pub wanted: fn(&Plan) -> bool,
    /// Reads a row from a step.
    pub(crate) read: Read,
}

impl Channel {
    /// Defaults of a channel: one number per step, in every run, written at the end.
    pub const BASE: Self = Self {
        name: "",
        unit: "",
        meaning: "",
        row: RowShape::One,
        when: RowTimes::EveryStep,
        wanted: |_| true,
        read: Read::Written,
    };

    /// A channel of one number per step, in every run.
    pub(crate) const fn new(name: &'static str, unit: &'static str, meaning: &'static str, read: Read) -> Self {
        Self { name, unit, meaning, read, ..Self::BASE }
    }

    /// The same with rows of another size.
    pub(crate) const fn rows(self, row: RowShape) -> Self {
        Self { row, ..self }
    }

    /// The same in the runs of some plans.
    pub(crate) const fn only(self, wanted: fn(&Plan) -> bool) -> Self {
        Self { wanted, ..self }
    }

    /// The same at the instants of frames, in the runs of some plans.
    pub(crate) const fn at_instants(self, wanted: fn(&Plan) -> bool) -> Self {
        Self { when: RowTimes::CellsEvery, wanted, ..self }
    }

    /// True if a plan's run writes it row by row.
    fn has_rows(&self, plan: &Plan) -> bool {
        plan.scene.outputs.arrays && !self.is_written_at_the_end() && (self.wanted)(plan)
    }

    /// Numbers per row, for a window of so many columns and so many points across.
    fn length(&self, [columns, across]: [usize; 2]) -> usize {
        match self.row {
            RowShape::One => 1,
            RowShape::Columns => columns,
            RowShape::Across => across,
            RowShape::Points => columns * across,
        }
    }

    /// Number of rows of a plan's run.
    fn rows_in(&self, plan: &Plan) -> u64 {
        match self.when {
            RowTimes::CellsEvery => plan.steps.div_ceil(frame_steps(plan)),
            RowTimes::EveryStep => plan.steps,
        }
    }

    /// True if it is written at the end of a run, not row by row.
    pub fn is_written_at_the_end(&self) -> bool {
        matches!(self.read, Read::Written)
    }
}

/// Size of a row.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum RowShape {
    /// One number.
    One,
    /// One for each column of the window.
    Columns,
    /// One for each row of points along the tyre.
    Across,
    /// One for each point of the window, column by column.
    Points,
}

/// Steps that have a row.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum RowTimes {
    /// Every step.
    EveryStep,
    /// Steps at the interval `outputs.cells_every`.
    CellsEvery,
}

/// Reading of a row from a step, by the type of its numbers.
pub(crate) enum Read {
    /// One number, in double precision.
    Number(fn(&Step<'_>) -> f64),
    /// One integer.
    Count(fn(&Step<'_>) -> i64),
    /// A row that exists already.
    Row(for<'a> fn(&Step<'a>) -> &'a [f64]),
    /// Fills a row of zeros.
    Fill(fn(&Step<'_>, &mut [f64])),
    /// Fills a row in single precision.
    Single(fn(&Step<'_>, &mut [f32])),
    /// No row: written at the end.
    Written,
}

/// Numbers of an array that a run keeps in memory, by type.
#[derive(Clone, Debug, PartialEq)]
pub enum ArrayNumbers {
    /// In double precision.
    Double(Vec<f64>),
    /// Integers.
    Whole(Vec<i64>),
    /// In single precision.
    Single(Vec<f32>),
}

/// An array of a run in memory.
#[derive(Clone, Debug, PartialEq)]
pub struct KeptArray {
    /// Name of the channel.
    pub name: &'static str,
    /// Numbers per row; `None` for one number.
    pub columns: Option<usize>,
    /// Numbers, row after row.
    pub numbers: ArrayNumbers,
}

enum Sink<T> {
    File(NpyWriter<T>),
    Memory(Vec<T>),
}

impl<T: NpyNumber> Sink<T> {
    fn push(&mut self, row: &[T]) -> Result<(), ResultsError> {
        match self {
            Self::File(writer) => writer.push(row),
            Self::Memory(numbers) => {
                numbers.extend_from_slice(row);
                Ok(())
            }
        }
    }
}

/// Sink by the type of its numbers.
enum Rows {
    Double(Sink<f64>),
    Whole(Sink<i64>),
    Single(Sink<f32>),
}

/// The same work for every type of numbers.
macro_rules! for_each_type {
    ($rows:expr, $sink:ident => $work:expr) => {
        match $rows {
            Rows::Double($sink) => $work,
            Rows::Whole($sink) => $work,
            Rows::Single($sink) => $work,
        }
    };
}

/// A channel whose array is being written.
struct Open {
    channel: &'static Channel,
    rows: Rows,
    /// Numbers per row.
    length: usize,
}

/// Steps from one frame of cells to the next.
fn frame_steps(plan: &Plan) -> u64 {
    let every = plan.scene.outputs.cells_every.map(|time| (time / plan.time_step).round().max(1.0) as u64);
    every.unwrap_or(u64::MAX)
}

/// Arrays of a run in progress.
pub(crate) struct Arrays {
    open: Vec<Open>,
    /// Steps from one frame of cells to the next.
    every: u64,
    filled: Vec<f64>,
    singles: Vec<f32>,
}

impl Arrays {
    /// Begins the arrays of a plan, or continues them, in a folder; without one in memory. `window` is the window's
    /// size in points: columns, and points across.
    ///
    /// # Errors
    /// Errors of the arrays; [`ResultsError::OutOfMemory`] if memory does not suffice.
    pub(crate) fn open(
        channels: impl Iterator<Item = &'static Channel>,
        plan: &Plan,
        window: [usize; 2],
        place: Option<&ArrayPlace<'_>>,
    ) -> Result<Self, ResultsError> {
        let every = frame_steps(plan);
        let mut arrays = Self { open: Vec::new(), every, filled: Vec::new(), singles: Vec::new() };
        for channel in channels.filter(|channel| channel.has_rows(plan)) {
            let (length, steps) = (channel.length(window), channel.rows_in(plan));
            let rows = match channel.read {
                Read::Count(_) => Rows::Whole(sink(channel, place, length, steps)?),
                Read::Single(_) => {
                    arrays.singles.resize(arrays.singles.len().max(length), 0.0);
                    Rows::Single(sink(channel, place, length, steps)?)
                }
                Read::Fill(_) => {
                    arrays.filled.resize(arrays.filled.len().max(length), 0.0);
                    Rows::Double(sink(channel, place, length, steps)?)
                }
                Read::Number(_) | Read::Row(_) | Read::Written => Rows::Double(sink(channel, place, length, steps)?),
            };
            arrays.open.push(Open { channel, rows, length });
        }
        Ok(arrays)
    }

    /// Bytes of the arrays of a plan's run over a window.
    pub(crate) fn bytes(channels: impl Iterator<Item = &'static Channel>, plan: &Plan, window: [usize; 2]) -> f64 {
        let of_number = |channel: &Channel| if matches!(channel.read, Read::Single(_)) { 4.0 } else { 8.0 };
        let bytes = |of: &Channel| of_number(of) * of.length(window) as f64 * of.rows_in(plan) as f64;
        channels.filter(|channel| channel.has_rows(plan)).map(bytes).sum()
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.open.is_empty()
    }

    /// Writes a row of each array that has one at this step.
    ///
    /// # Errors
    /// Errors of the arrays.
    pub(crate) fn push(&mut self, step: &Step<'_>) -> Result<(), RunError> {
        let Self { open, every, filled, singles } = self;
        for Open { channel, rows, length } in open {
            if channel.when == RowTimes::CellsEvery && !step.number.is_multiple_of(*every) {
                continue;
            }
            match (rows, &channel.read) {
                (Rows::Double(sink), Read::Number(read)) => sink.push(&[read(step)])?,
                (Rows::Whole(sink), Read::Count(read)) => sink.push(&[read(step)])?,
                (Rows::Double(sink), Read::Row(read)) => sink.push(read(step))?,
                (Rows::Double(sink), Read::Fill(read)) => {
                    let row = &mut filled[..*length];
                    row.fill(0.0);
                    read(step, row);
                    sink.push(row)?;
                }
                (Rows::Single(sink), Read::Single(read)) => {
                    read(step, &mut singles[..*length]);
                    sink.push(&singles[..*length])?;
                }
                // The sink was chosen by the kind of reading, see [`Self::open`].
                _ => {}
            }
        }
        Ok(())
    }

    /// Brings all rows so far to the disk; returns how far each array has come.
    ///
    /// # Errors
    /// Errors of the arrays.
    pub(crate) fn sync(&mut self) -> Result<WrittenArrays, ResultsError> {
        let mut written = WrittenArrays::default();
        for Open { rows, .. } in &mut self.open {
            for_each_type!(rows, sink => if let Sink::File(writer) = sink {
                written.sync(writer)?;
            });
        }
        Ok(written)
    }

    /// Completes the arrays; returns the bytes written to files, and the arrays in memory.
    ///
    /// # Errors
    /// Errors of the arrays.
    pub(crate) fn finish(self) -> Result<(u64, Vec<KeptArray>), ResultsError> {
        let (mut bytes, mut in_memory) = (0, Vec::new());
        for Open { channel, rows, length } in self.open {
            let columns = (channel.row != RowShape::One).then_some(length);
            let keep = |numbers| KeptArray { name: channel.name, columns, numbers };
            match rows {
                Rows::Double(Sink::Memory(numbers)) => in_memory.push(keep(ArrayNumbers::Double(numbers))),
                Rows::Whole(Sink::Memory(numbers)) => in_memory.push(keep(ArrayNumbers::Whole(numbers))),
                Rows::Single(Sink::Memory(numbers)) => in_memory.push(keep(ArrayNumbers::Single(numbers))),
                rows => for_each_type!(rows, sink => if let Sink::File(writer) = sink {
                    bytes += writer.bytes();
                    writer.finish()?;
                }),
            }
        }
        Ok((bytes, in_memory))
    }
}

/// Begins the rows of a channel in its file or in memory, for which memory is reserved at once.
fn sink<T: NpyNumber>(
    channel: &Channel,
    place: Option<&ArrayPlace<'_>>,
    length: usize,
    steps: u64,
) -> Result<Sink<T>, ResultsError> {
    let Some(place) = place else {
        let (mut numbers, rows) = (Vec::new(), usize::try_from(steps).unwrap_or(usize::MAX));
        let bytes = steps as f64 * (length * size_of::<T>()) as f64;
        let reserved = numbers.try_reserve_exact(rows.saturating_mul(length));
        reserved.map_err(|_| ResultsError::OutOfMemory { array: channel.name, bytes })?;
        return Ok(Sink::Memory(numbers));
    };
    let row = if channel.row == RowShape::One { ArrayRow::Scalar } else { ArrayRow::Columns(length) };
    Ok(Sink::File(place.open(&format!("{}.npy", channel.name), row)?))
}
