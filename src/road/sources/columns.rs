//! Columns of tables: which of them are distance and height, and their values.

use std::collections::BTreeMap;
use std::path::Path;

use super::missing::is_word_for_none;
use super::titles::{Role, Titles, bare, is_counter, is_of};
use crate::road::error::RoadError;
use crate::road::file_fault::FileFault;
use crate::road::report::RoadNote;
use crate::scene::{LengthUnit, MissingHeight};
use crate::storage::input::excerpt;
use crate::storage::separated::{Record, SeparatedTable};

/// Least number of counting values for which a column is taken as a counter.
const FEWEST_COUNTED: usize = 8;

/// A point of a file: distance and height \[m\], height NaN if missing, and its line from 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FilePoint {
    pub(super) distance: f64,
    pub(super) height: f64,
    pub(super) line: u64,
}

/// Words of titles of heights that may count downwards.
const DOWNWARDS: [&str; 2] = ["depth", "tiefe"];
/// Why columns cannot be read: a fault of the file, or a unit that nothing states.
#[derive(Debug)]
pub(super) enum Fault {
    File(FileFault),
    Unit(&'static str),
}

impl From<FileFault> for Fault {
    fn from(fault: FileFault) -> Self {
        Self::File(fault)
    }
}

impl Fault {
    pub(super) fn at(self, path: &Path) -> RoadError {
        match self {
            Self::File(fault) => RoadError::file(path, fault),
            Self::Unit(key) => RoadError::MissingUnit { path: path.to_owned(), key },
        }
    }
}

/// Chooses the column (from 0) of each role among `cells`; `line` is the first line of numbers, for the message.
pub(super) fn choose<const N: usize>(
    roles: [Role; N],
    titles: Option<&Titles>,
    cells: usize,
    chosen: Option<&[String]>,
    line: impl Fn() -> String,
) -> Result<[usize; N], FileFault> {
    let names: &[String] = titles.map_or(&[], |titles| &titles.names);
    if let Some(chosen) = chosen {
        let Ok(wanted) = <&[String; N]>::try_from(chosen) else {
            let roles = roles.map(|role| role.name).join(", ");
            return Err(FileFault::ColumnCount { found: chosen.len(), needed: N, roles });
        };
        let mut columns = [0; N];
        for (column, wanted) in columns.iter_mut().zip(wanted) {
            *column = column_of(wanted, names, cells)?;
        }
        return Ok(columns);
    }
    let named = roles.map(|role| titles?.column_of(&role));
    let distinct = (0..N).all(|role| !named[role + 1..].contains(&named[role]));
    if let (Some(columns), true) = (all(named), distinct) {
        return Ok(columns);
    }
    // As many columns as needed are taken in their order, unless a title says otherwise.
    let fits = (0..N).all(|role| named[role].is_none_or(|column| column == role));
    let of_nothing = (0..N).find(|&column| N == 2 && !named.contains(&Some(column)) && is_of_nothing(titles, column));
    match of_nothing {
        _ if cells != N || !fits => {}
        None => return Ok(std::array::from_fn(|role| role)),
        Some(column) if titles.is_some_and(|titles| titles.is_counter(column)) => {
            let title = excerpt(titles.map_or("", |titles| titles.name(column)));
            return Err(FileFault::Counter { column: column + 1, title, role: roles[column].name });
        }
        Some(_) => {}
    }
    let found = if names.is_empty() { line() } else { names.join(", ") };
    let (likely, roles) = (likely(roles, titles, cells), roles.map(|role| role.name).join(", "));
    Err(FileFault::WhichColumns { cells, roles, likely, found: excerpt(&found) })
}

/// True if a column's title is words that name neither distance nor height. Where its unit is no length, that is
/// stated instead.
fn is_of_nothing(titles: Option<&Titles>, column: usize) -> bool {
    titles.is_some_and(|titles| titles.unit(column).is_ok() && bare(titles.name(column)).chars().count() > 1)
}

/// Returns the columns (from 1) that are most likely those of roles: each role's is the first that its title names, or
/// one of the last among the others; without titles, of a cloud the first.
fn likely<const N: usize>(roles: [Role; N], titles: Option<&Titles>, cells: usize) -> Vec<usize> {
    if N == 3 && titles.is_none() {
        return (1..=N).collect();
    }
    let is_length = |column: &usize| titles.is_none_or(|titles| titles.unit(*column).is_ok());
    let is_counter = |column: usize| titles.is_some_and(|titles| titles.is_counter(column));
    let mut free: Vec<usize> = (0..cells).filter(|column| is_length(column) && !is_counter(*column)).collect();
    if free.len() < N {
        free = (0..cells).collect();
    }
    let named = roles.map(|role| {
        let place = free.iter().position(|&column| titles.is_some_and(|titles| is_of(titles.name(column), &role)))?;
        Some(free.remove(place))
    });
    let unnamed = named.iter().filter(|column| column.is_none()).count();
    let mut last = free.split_off(free.len().saturating_sub(unnamed)).into_iter();
    named.into_iter().filter_map(|column| column.or_else(|| last.next())).map(|column| column + 1).collect()
}

fn all<const N: usize>(columns: [Option<usize>; N]) -> Option<[usize; N]> {
    let mut found = [0; N];
    for (place, column) in found.iter_mut().zip(columns) {
        *place = column?;
    }
    Some(found)
}

/// Column (from 0) with a title, with or without its unit, or with a number (from 1).
pub(super) fn column_of(wanted: &str, names: &[String], cells: usize) -> Result<usize, FileFault> {
    let exact = names.iter().position(|name| name == wanted);
    let by_number = || wanted.parse::<usize>().ok()?.checked_sub(1).filter(|&column| column < cells);
    let similar = || {
        let mut found = (0..names.len()).filter(|&column| bare(&names[column]) == bare(wanted));
        found.next().filter(|_| found.next().is_none() && !bare(wanted).is_empty())
    };
    exact.or_else(by_number).or_else(similar).ok_or_else(|| {
        let available = if names.is_empty() { format!("{cells} columns without titles") } else { names.join(", ") };
        FileFault::NoSuchColumn { name: excerpt(wanted), available: excerpt(&available) }
    })
}

/// The columns of some roles, with what is needed to convert their values to metres.
#[derive(Clone, Debug)]
pub(super) struct FileColumns<const N: usize> {
    roles: [Role; N],
    /// Their indices from 0.
    numbers: [usize; N],
    titles: [Option<String>; N],
    units: [LengthUnit; N],
    /// True for those that a length is named for, in a title or by the scene alone, or that the scene chooses: they may
    /// count.
    named: [bool; N],
    /// Values and words that mark missing heights, as the scene says.
    pub(super) missing: Option<Vec<MissingHeight>>,
    /// Words that marked missing heights, and how often.
    pub(super) words: BTreeMap<String, usize>,
}

impl<const N: usize> FileColumns<N> {
    /// Finds the units of columns, in their titles or in the scene; both must agree.
    pub(super) fn with_units(
        roles: [Role; N],
        numbers: [usize; N],
        titles: Option<&Titles>,
        stated: [Option<LengthUnit>; N],
        chosen: bool,
    ) -> Result<Self, Fault> {
        let mut units = [LengthUnit::Metre; N];
        let mut titled = [None; N];
        let name_of =
            |number: usize| titles.and_then(|titles| titles.names.get(number)).filter(|name| !name.is_empty());
        for role in 0..N {
            titled[role] = titles.map_or(Ok(None), |titles| titles.unit(numbers[role]))?;
            units[role] = match (titled[role], stated[role]) {
                (Some(file), Some(scene)) if file != scene => {
                    return Err(FileFault::UnitContradiction {
                        line: titles.map_or(0, |titles| titles.line),
                        title: excerpt(name_of(numbers[role]).map_or("", String::as_str)),
                        file: file.word(),
                        key: roles[role].unit_key,
                        scene: scene.word(),
                    }
                    .into());
                }
                (Some(unit), _) | (None, Some(unit)) => unit,
                (None, None) => return Err(Fault::Unit(roles[role].unit_key)),
            };
        }
        let named = std::array::from_fn(|role| {
            let titled_so = name_of(numbers[role]).is_some_and(|name| is_of(name, &roles[role]));
            chosen || titled_so || titled[role].is_some() || titles.is_none()
        });
        Ok(Self {
            roles,
            numbers,
            titles: numbers.map(|number| name_of(number).cloned()),
            units,
            named,
            missing: None,
            words: BTreeMap::new(),
        })
    }

    /// Value \[m\] of a role in a record; that of the last role may be missing, and is NaN then.
    pub(super) fn value(
        &mut self,
        table: &SeparatedTable<'_>,
        record: &Record<'_>,
        role: usize,
    ) -> Result<f64, FileFault> {
        let (line, column, may_lack) = (record.line, self.numbers[role], role + 1 == N);
        let cell = match record.cells.get(column) {
            Some(cell) => *cell,
            None if may_lack && column == record.cells.len() => "",
            None => return Err(FileFault::MissingCell { line, needed: column + 1, found: record.cells.len() }),
        };
        match table.number(cell) {
            Some(value) => Ok(value * self.units[role].metres()),
            None if may_lack && is_word_for_none(cell, self.missing.as_deref()) => {
                if !cell.is_empty() {
                    *self.words.entry(cell.to_owned()).or_default() += 1;
                }
                Ok(f64::NAN)
            }
            None => {
                let role = self.roles[role].name;
                Err(FileFault::NotANumber { line, column: column + 1, role, found: excerpt(cell) })
            }
        }
    }

    /// Unit of the last role \[m\].
    pub(super) fn unit(&self) -> f64 {
        self.units[N - 1].metres()
    }

    /// Refuses a column that merely counts, 0, 1, 2, 3, and that nothing identifies as a length; notes one without a
    /// title. `values` are those of a role \[m\].
    pub(super) fn refuse_counters<I: Iterator<Item = f64>>(
        &self,
        values: impl Fn(usize) -> I,
        notes: &mut Vec<RoadNote>,
    ) -> Result<(), FileFault> {
        for role in (0..N).filter(|&role| !self.named[role] || self.titles[role].is_none()) {
            let unit = self.units[role].metres();
            let first = values(role).next().map_or(f64::NAN, |first| (first / unit).round());
            let is_count = |(index, value): (usize, f64)| (value / unit - first - index as f64).abs() < 1e-6;
            let begins = (0.0..=1.0).contains(&first) || self.titles[role].as_deref().is_some_and(is_counter);
            let counts = begins && values(role).enumerate().all(is_count);
            if counts && values(role).count() >= FEWEST_COUNTED {
                if self.named[role] {
                    notes.push(RoadNote::Counts { column: self.numbers[role] + 1, unit: self.units[role].word() });
                    continue;
                }
                let (column, title) = (self.numbers[role] + 1, self.titles[role].clone().unwrap_or_default());
                return Err(FileFault::Counter { column, title: excerpt(&title), role: self.roles[role].name });
            }
        }
        Ok(())
    }

    /// Refuses heights whose title says that they may count downwards.
    pub(super) fn refuse_downwards(&self) -> Result<(), FileFault> {
        let title = self.titles[N - 1].as_deref().unwrap_or_default();
        if !bare(title).split(' ').any(|word| DOWNWARDS.contains(&word)) {
            return Ok(());
        }
        let columns: Vec<usize> = self.numbers.iter().map(|number| number + 1).collect();
        Err(FileFault::Downwards { column: self.numbers[N - 1] + 1, title: excerpt(title), columns })
    }

    /// States which columns are used, in words.
    pub(super) fn described(&self) -> String {
        let column = |role: usize| {
            let title = self.titles[role].as_ref().map_or(String::new(), |title| format!(" \"{}\"", excerpt(title)));
            format!(
                "{} from column {}{title} in {}",
                self.roles[role].name,
                self.numbers[role] + 1,
                self.units[role].word()
            )
        };
        (0..N).map(column).collect::<Vec<_>>().join(", ")
    }
}
