//! Tables of points: columns chosen, units found, every point with its line.
//!
//! 1. Most records have the same number of cells; the first of them that begins the numbers ends the preamble. Numbers
//!    in another number of cells are refused; empty cells at the end of a line may be left out.
//! 2. Titles are the last record before it without a number, or a comment there; a row of units may follow them.
//! 3. A column is the one that the scene chooses, that a title names, or, in a table that has no more columns than
//!    needed, the one at its place; a column that merely counts is not taken as a length.
//! 4. A unit is that of the title or of the scene; they must not contradict each other.

use std::path::Path;

use super::columns::{self, FileColumns, FilePoint};
use super::erd;
use super::missing::note_words;
use super::signature::refuse_unreadable;
use super::titles::{DISTANCE, HEIGHT, Role, Titles};
use crate::road::error::RoadError;
use crate::road::file_fault::FileFault;
use crate::road::report::RoadNote;
use crate::scene::{LengthUnit, ProfileRoad};
use crate::storage::InputError;
use crate::storage::input::{self, excerpt};
use crate::storage::separated::{Record, SeparatedTable};

/// Bytes in memory for a byte of text, if points have a digit each.
const GROWTH: u64 = 24;
/// Number of records from which the shape of a table is found.
const SAMPLE: usize = 1000;
/// Number of points that may be behind others in the order of a file, and distance in usual steps from which on they
/// are so: more points are another pass.
const DISORDER: (usize, f64) = (8, 10.0);
/// Line of a CAPTIF file between its description and the table.
const CAPTIF_MARK: &str = "*****DATA*****";

/// True if a file has the header of a CAPTIF profile.
pub(super) fn is_captif(bytes: &[u8]) -> bool {
    // The mark ends a short header: megabytes of numbers need not be searched.
    let mark = CAPTIF_MARK.as_bytes();
    bytes[..bytes.len().min(65_536)].windows(mark.len()).any(|window| window == mark)
}

/// The bytes of a table's file; `limit` bounds the memory of its points.
///
/// # Errors
/// A file that cannot be read or is too large.
pub(super) fn bytes(path: &Path, limit: u64) -> Result<Vec<u8>, RoadError> {
    input::read(path, limit / GROWTH).map_err(|error| match error {
        InputError::TooLarge { found, .. } => {
            RoadError::file(path, FileFault::TooLarge { needed: found.saturating_mul(GROWTH), limit })
        }
        other => RoadError::file(path, FileFault::from(other)),
    })
}

/// Points of a profile's file, in its order, and the file's unit of heights \[m\].
///
/// # Errors
/// For no numbers where they should be (with line and column), no units, and unknown columns.
pub(super) fn points(
    spec: &ProfileRoad,
    bytes: &[u8],
    notes: &mut Vec<RoadNote>,
) -> Result<(Vec<FilePoint>, f64), RoadError> {
    let missing = spec.missing.as_deref();
    let fault = |fault| RoadError::file(&spec.file, fault);
    refuse_unreadable(bytes).map_err(fault)?;
    let units = [spec.distance_unit, spec.height_unit];
    let (points, columns, unit, words) = if erd::is_erd(bytes) {
        let (points, used) = erd::points(&spec.file, bytes, units, spec.columns.as_deref(), missing)?;
        let step = points.get(1).map_or(0.0, |point| 1e3 * point.distance);
        let columns = format!("{}, a sample every {step:.4} mm", used.described());
        (points, columns, used.unit(), used.words)
    } else {
        let table = SeparatedTable::of(bytes);
        let layout = Layout::of(&table, 2).map_err(fault)?;
        if layout.first == u64::MAX {
            return Err(fault(FileFault::TooFewPoints { found: 0, needed: 2 }));
        }
        let roles = [DISTANCE, HEIGHT];
        let mut used =
            layout.columns(&table, roles, units, spec.columns.as_deref()).map_err(|error| error.at(&spec.file))?;
        used.missing = missing.map(<[_]>::to_vec);
        let point = |(line, [distance, height]): (u64, [f64; 2])| FilePoint { distance, height, line };
        let points = layout.values(&table, &mut used).map(|values| values.map(point));
        let points: Result<Vec<FilePoint>, _> = points.collect();
        let points = points.map_err(|error| fault(layout.or_passes(&table, error)))?;
        used.refuse_counters(|column| points.iter().map(move |point| [point.distance, point.height][column]), notes)
            .map_err(fault)?;
        refuse_point_count(&table, &points).map_err(fault)?;
        (points, used.described(), used.unit(), used.words)
    };
    refuse_passes(&points).map_err(fault)?;
    notes.push(RoadNote::FileColumns { columns });
    note_words(words, notes);
    Ok((points, unit))
}

/// Positions of the parts of a table.
#[derive(Debug)]
pub(super) struct Layout {
    /// Line of the first record of numbers, from 1; `u64::MAX` in a table without numbers.
    first: u64,
    /// Number of cells in most records, up to the last that is not empty in all of them.
    cells: usize,
    /// Titles, as many as there are cells.
    titles: Option<Titles>,
    /// True if commas separate the cells, and none of these has a decimal point or a title.
    decimals_may_be_parted: bool,
    /// The file is one of CAPTIF, whose depths count upwards.
    captif: bool,
}

impl Layout {
    /// Finds the parts of a table that needs at least `least` columns.
    ///
    /// # Errors
    /// If it is not a table of numbers, or has one column.
    pub(super) fn of(table: &SeparatedTable<'_>, least: usize) -> Result<Self, FileFault> {
        if table.is_binary() {
            return Err(FileFault::NotRead);
        }
        if let Some((line, cell)) = table.ambiguous_comma() {
            return Err(FileFault::AmbiguousComma { line, found: excerpt(cell) });
        }
        let all: Vec<Record<'_>> = table.records().take(SAMPLE).collect();
        let captif = all.iter().rposition(|record| record.cells.first() == Some(&CAPTIF_MARK)).map_or(0, |at| at + 1);
        let sample = &all[captif..];
        let is_number = |cell: &&str| table.number(cell).is_some();
        let numbers = |record: &Record<'_>| record.cells.iter().filter(|cell| is_number(cell)).count();
        let usual = usual(sample.iter().filter(|record| numbers(record) > 0).map(|record| record.cells.len()));
        let begins = |record: &Record<'_>| {
            record.cells.len() == usual
                && (numbers(record) >= 2.min(usual) || numbers(record) == 1 && is_number(&record.cells[0]))
        };
        let Some(start) = sample.iter().position(begins) else {
            return match sample.len() {
                0 | 1 => Ok(Self {
                    first: u64::MAX,
                    cells: least,
                    titles: None,
                    decimals_may_be_parted: false,
                    captif: captif > 0,
                }),
                _ => Err(FileFault::NotRead),
            };
        };
        let full = sample[start..].iter().filter(|record| record.cells.len() == usual).map(Record::filled);
        let cells = full.max().unwrap_or(usual);
        if cells < least {
            return Err(FileFault::OneColumn { line: sample[start].line });
        }
        let before = &sample[..start];
        let is_row = |record: &&Record<'_>| {
            let filled = record.cells.iter().filter(|cell| !cell.is_empty()).count();
            filled >= 2 && numbers(record) == filled
        };
        if let Some(row) = before.iter().find(is_row) {
            return Err(FileFault::Ragged { line: row.line, found: row.filled(), usual: cells });
        }
        let titles = Titles::find(table, before, sample[start].line, cells);
        // A record between titles and numbers that is neither is a fault, found later with its line.
        let after = titles.as_ref().map_or(start, |titles| before.partition_point(|record| record.line <= titles.last));
        let points = sample[start..].iter().flat_map(|record| &record.cells).any(|cell| cell.contains('.'));
        Ok(Self {
            first: sample[after].line,
            cells,
            decimals_may_be_parted: table.is_parted_by_commas() && !points && titles.is_none(),
            titles,
            captif: captif > 0,
        })
    }

    /// Chooses the columns of roles and their units.
    ///
    /// # Errors
    /// Columns that are not there, or of which nothing says which they are; units that are not known, or contradict
    /// each other; heights that may count downwards.
    pub(super) fn columns<const N: usize>(
        &self,
        table: &SeparatedTable<'_>,
        roles: [Role; N],
        units: [Option<LengthUnit>; N],
        chosen: Option<&[String]>,
    ) -> Result<FileColumns<N>, columns::Fault> {
        if self.decimals_may_be_parted && self.cells > N && chosen.is_none() {
            let line = excerpt(table.line(self.first));
            return Err(FileFault::DecimalCommas { line: self.first, found: line, cells: self.cells }.into());
        }
        let titles = self.titles.as_ref();
        let columns = columns::choose(roles, titles, self.cells, chosen, || table.line(self.first).to_owned())?;
        let columns = FileColumns::with_units(roles, columns, titles, units, chosen.is_some())?;
        if chosen.is_none() && !self.captif {
            columns.refuse_downwards()?;
        }
        Ok(columns)
    }

    /// Returns the fault of a line, or several passes if it begins a part that has the titles again.
    fn or_passes(&self, table: &SeparatedTable<'_>, fault: FileFault) -> FileFault {
        let (FileFault::NotANumber { line, .. } | FileFault::Ragged { line, .. }, Some(titles)) =
            (&fault, &self.titles)
        else {
            return fault;
        };
        let is_again = |record: &Record<'_>| record.line >= *line && record.cells == titles.names;
        match table.records().filter(is_again).count() {
            0 => fault,
            again => FileFault::Passes { count: again + 1, line: *line },
        }
    }

    /// Lines of the table's points with the values of their columns \[m\]; the last role may lack a value, and is NaN
    /// then.
    pub(super) fn values<'a, const N: usize>(
        &self,
        table: &'a SeparatedTable<'_>,
        columns: &'a mut FileColumns<N>,
    ) -> impl Iterator<Item = Result<(u64, [f64; N]), FileFault>> {
        let (first, usual) = (self.first, self.cells);
        table.records().skip_while(move |record| record.line < first).map(move |record| {
            let found = record.filled();
            if found > usual || (found < usual && table.is_parted_by_blanks()) {
                return Err(FileFault::Ragged { line: record.line, found, usual });
            }
            let mut values = [f64::NAN; N];
            for (role, value) in values.iter_mut().enumerate() {
                *value = columns.value(table, &record, role)?;
            }
            Ok((record.line, values))
        })
    }
}

/// Refuses a first line of spacing and number of the points: a number in it is that of the points after it, and its
/// distance is none that they continue.
fn refuse_point_count(table: &SeparatedTable<'_>, points: &[FilePoint]) -> Result<(), FileFault> {
    let [first, second, third, ..] = points else { return Ok(()) };
    let step = third.distance - second.distance;
    if (second.distance - first.distance - step).abs() <= 0.5 * step.abs() {
        return Ok(());
    }
    let after = (points.len() - 1) as f64;
    let is_count = |cell: &str| table.number(cell).is_some_and(|number| (number - after).abs() < 1e-6);
    match table.records().find(|record| record.line == first.line) {
        Some(record) if record.cells.iter().any(|cell| is_count(cell)) => {
            Err(FileFault::PointCount { line: first.line, found: excerpt(table.line(first.line)) })
        }
        _ => Ok(()),
    }
}

/// Refuses points of more than one pass over the road; a small disorder is none.
fn refuse_passes(points: &[FilePoint]) -> Result<(), FileFault> {
    let steps = points.windows(2).map(|pair| (pair[1].distance - pair[0].distance).abs());
    let mut steps: Vec<f64> = steps.filter(|&step| step > 0.0).collect();
    if steps.is_empty() {
        return Ok(());
    }
    let middle = steps.len() / 2;
    let allowed = DISORDER.1 * *steps.select_nth_unstable_by(middle, f64::total_cmp).1;
    // Number of points behind the furthest so far, number of jumps back of the distance, and line of the first such
    // point.
    let behind = |direction: f64| {
        let (mut count, mut jumps, mut line) = (0, 0, 0);
        let (mut furthest, mut last) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
        for point in points {
            let place = direction * point.distance;
            if place < furthest - allowed {
                count += 1;
                line = if line == 0 { point.line } else { line };
            }
            jumps += usize::from(place < last - allowed);
            (furthest, last) = (furthest.max(place), place);
        }
        (count, jumps, line)
    };
    // The direction in which fewer points are out of order is that of the road.
    let (count, jumps, line) = behind(1.0).min(behind(-1.0));
    if count < DISORDER.0 { Ok(()) } else { Err(FileFault::Passes { count: (jumps + 1).max(2), line }) }
}

/// The most frequent of some counts, the larger of two that are equally frequent.
fn usual(counts: impl Iterator<Item = usize>) -> usize {
    let mut occurrences = std::collections::BTreeMap::new();
    counts.for_each(|count| *occurrences.entry(count).or_insert(0) += 1);
    occurrences.into_iter().max_by_key(|&(count, times)| (times, count)).map_or(0, |(count, _)| count)
}
