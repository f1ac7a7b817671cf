//! Columns of tables: which of them are distance and height, their titles and units.

use std::collections::BTreeMap;
use std::path::Path;

use super::missing::is_word_for_none;
use crate::road::error::RoadError;
use crate::road::file_fault::FileFault;
use crate::scene::{LengthUnit, MissingHeight};
use crate::storage::input::excerpt;
use crate::storage::separated::{self, Record, Table};

/// Values that must count before a column is taken for a counter.
const FEWEST_COUNTED: usize = 8;

/// A point of a file: distance and height \[m\], height NaN if missing, and its line from 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Point {
    pub(super) distance: f64,
    pub(super) height: f64,
    pub(super) line: u64,
}

/// Quantity that a column is read as.
#[derive(Clone, Copy, Debug)]
pub(super) struct Role {
    pub(super) name: &'static str,
    /// Words of titles, lower case.
    words: &'static [&'static str],
    /// Key of its unit.
    unit_key: &'static str,
}

pub(super) const DISTANCE: Role = Role {
    name: "distance",
    words: &[
        "distance",
        "dist",
        "x",
        "s",
        "position",
        "pos",
        "chainage",
        "station",
        "length",
        "abscissa",
        "travel",
        "along",
        "abstand",
        "weg",
        "strecke",
        "distanz",
        "longitudinal",
    ],
    unit_key: "distance_unit",
};
pub(super) const ACROSS: Role = Role {
    name: "lateral position",
    words: &["y", "across", "lateral", "transverse", "transversal"],
    unit_key: "distance_unit",
};
pub(super) const HEIGHT: Role = Role {
    name: "height",
    words: &[
        "height",
        "heights",
        "z",
        "elevation",
        "elev",
        "profile",
        "depth",
        "texture",
        "altitude",
        "amplitude",
        "h\u{f6}he",
        "hoehe",
        "tiefe",
        "hauteur",
        "altura",
    ],
    unit_key: "height_unit",
};

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

/// The titles of a table.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Titles {
    /// Line of the titles, from 1, and of what belongs to them.
    pub(super) line: u64,
    pub(super) last: u64,
    pub(super) names: Vec<String>,
    /// Units that they or the row below them state.
    units: Vec<Option<LengthUnit>>,
}

impl Titles {
    /// Returns titles at a line, their units as they say.
    pub(super) fn new(line: u64, names: Vec<String>) -> Self {
        let units = names.iter().map(|name| unit_of(name)).collect();
        Self { line, last: line, names, units }
    }

    /// Finds the titles of so many cells in the records before the numbers, or in a comment.
    pub(super) fn find(table: &Table<'_>, before: &[Record<'_>], first: u64, cells: usize) -> Option<Self> {
        let is_title = |names: &[&str]| {
            names.len() == cells
                && names
                    .iter()
                    .all(|name| !name.starts_with(|sign: char| sign.is_ascii_digit()) && table.number(name).is_none())
                && names.iter().any(|name| name.chars().any(char::is_alphabetic))
        };
        let fitting = |words: &[&str]| -> Option<Vec<String>> {
            let filled = words.iter().rposition(|word| !word.is_empty()).map_or(0, |at| at + 1);
            let mut names = words[..filled].to_vec();
            names.resize(filled.max(cells.min(words.len())), "");
            is_title(&names).then(|| names.into_iter().map(str::to_owned).collect())
        };
        let of_line =
            |text: &str| separated::words(text).find_map(|words| fitting(&words).or_else(|| rejoined(&words, cells)));
        let unit_row = before.last().and_then(|record| {
            let cells: Vec<&str> = record.cells.iter().map(|cell| cell.trim_matches(['(', ')', '[', ']'])).collect();
            let units: Vec<_> = cells.iter().map(|cell| LengthUnit::of_word(cell)).collect();
            let all = cells.iter().zip(&units).all(|(cell, unit)| unit.is_some() || cell.len() <= 3);
            (all && units.iter().any(Option::is_some)).then_some((record.line, units))
        });
        let named = before.len() - usize::from(unit_row.is_some());
        let tells = |names: &[String]| {
            names.iter().any(|name| is_of(name, &DISTANCE) || is_of(name, &HEIGHT) || unit_of(name).is_some())
        };
        // Directly before the numbers any words are titles, farther away those alone that tell of a road.
        let record = (0..named).rev().find_map(|place| {
            let record = &before[place];
            let names = fitting(&record.cells).or_else(|| of_line(table.line(record.line)))?;
            (place + 1 == named || tells(&names)).then_some((record.line, names))
        });
        let comment = || {
            let of_comment = |(line, text)| of_line(text).filter(|names| tells(names)).map(|names| (line, names));
            table.comments_before(first).find_map(of_comment)
        };
        let mut found = match (record.or_else(comment), &unit_row) {
            (Some((line, names)), _) => Self::new(line, names),
            (None, Some((line, units))) => Self::new(*line, vec![String::new(); units.len()]),
            (None, None) => return None,
        };
        if let Some((line, units)) = unit_row {
            found.last = found.last.max(line);
            for (unit, stated) in found.units.iter_mut().zip(units) {
                *unit = stated.or(*unit);
            }
        }
        Some(found)
    }
}

/// Returns words that blanks part as titles, where brackets belong to the word before them.
fn rejoined(words: &[&str], cells: usize) -> Option<Vec<String>> {
    let mut names: Vec<String> = Vec::new();
    for word in words {
        match names.last_mut() {
            Some(name) if word.starts_with(['(', '[']) => *name += &format!(" {word}"),
            _ => names.push((*word).to_owned()),
        }
    }
    let fits =
        names.len() == cells && names.len() < words.len() && names.iter().all(|name| name.parse::<f64>().is_err());
    fits.then_some(names)
}

/// Returns the unit that a title states: in brackets, or as its last word.
fn unit_of(title: &str) -> Option<LengthUnit> {
    let bracket = title.split(['(', '[']).skip(1).find_map(|rest| LengthUnit::of_word(rest.split([')', ']']).next()?));
    let mut words = title.split(|sign: char| !sign.is_alphanumeric()).filter(|word| !word.is_empty());
    bracket.or_else(|| words.next_back().filter(|_| words.next().is_some()).and_then(LengthUnit::of_word))
}

/// Returns a title in lower case without its unit.
fn bare(title: &str) -> String {
    let name = title.split(['(', '[']).next().unwrap_or_default().trim();
    let words: Vec<&str> = name.split(|sign: char| !sign.is_alphanumeric()).filter(|word| !word.is_empty()).collect();
    let unit = words.len() > 1 && words.last().is_some_and(|word| LengthUnit::of_word(word).is_some());
    words[..words.len() - usize::from(unit)].join(" ").to_lowercase()
}

fn is_of(title: &str, role: &Role) -> bool {
    bare(title).split(' ').any(|word| role.words.contains(&word.trim_end_matches(|sign: char| sign.is_ascii_digit())))
}

/// Chooses the column (from 0) of each role, among so many; `line` is the first of numbers.
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
    let named = roles.map(|role| {
        let mut found = (0..names.len()).filter(|&column| is_of(&names[column], &role));
        found.next().filter(|_| found.next().is_none())
    });
    let distinct = (0..N).all(|role| !named[role + 1..].contains(&named[role]));
    if let (Some(columns), true) = (all(named), distinct) {
        return Ok(columns);
    }
    if cells == N {
        // What titles name keeps its place; the others follow in their order.
        return Ok(std::array::from_fn(|role| role));
    }
    let found = if names.is_empty() { line() } else { names.join(", ") };
    let roles = roles.map(|role| role.name).join(", ");
    Err(FileFault::WhichColumns { cells, roles, needed: N, titled: !names.is_empty(), found: excerpt(&found) })
}

fn all<const N: usize>(columns: [Option<usize>; N]) -> Option<[usize; N]> {
    let mut found = [0; N];
    for (place, column) in found.iter_mut().zip(columns) {
        *place = column?;
    }
    Some(found)
}

/// Returns the column (from 0) of a title, with or without its unit, or a number (from 1).
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

/// The columns of some roles, each with what makes its values metres.
#[derive(Clone, Debug)]
pub(super) struct Columns<const N: usize> {
    roles: [Role; N],
    /// Their numbers from 0.
    numbers: [usize; N],
    titles: [Option<String>; N],
    units: [LengthUnit; N],
    /// True for those that a length is named for, or that the scene chooses: they may count.
    named: [bool; N],
    /// Values and words that stand for no height, as the scene says.
    pub(super) missing: Option<Vec<MissingHeight>>,
    /// Words that stood for no height, and how often.
    pub(super) words: BTreeMap<String, usize>,
}

impl<const N: usize> Columns<N> {
    /// Finds the units of columns, in their titles or in the scene.
    pub(super) fn with_units(
        roles: [Role; N],
        numbers: [usize; N],
        titles: Option<&Titles>,
        stated: [Option<LengthUnit>; N],
        chosen: bool,
    ) -> Result<Self, Fault> {
        let mut units = [LengthUnit::Metre; N];
        let name_of =
            |number: usize| titles.and_then(|titles| titles.names.get(number)).filter(|name| !name.is_empty());
        let titled = numbers.map(|number| titles.and_then(|titles| *titles.units.get(number)?));
        for role in 0..N {
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
            chosen || titled_so || titled[role].is_some()
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

    /// Returns the value \[m\] of a role in a record; that of the last role may be missing, NaN then.
    pub(super) fn value(&mut self, table: &Table<'_>, record: &Record<'_>, role: usize) -> Result<f64, FileFault> {
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

    /// Returns the unit of the last role \[m\].
    pub(super) fn unit(&self) -> f64 {
        self.units[N - 1].metres()
    }

    /// Refuses a column that merely counts, 0, 1, 2, 3, and that nothing calls a length. `values` are those of a role
    /// \[m\].
    pub(super) fn refuse_counters<I: Iterator<Item = f64>>(
        &self,
        values: impl Fn(usize) -> I,
    ) -> Result<(), FileFault> {
        for role in (0..N).filter(|&role| !self.named[role]) {
            let unit = self.units[role].metres();
            let first = values(role).next().map_or(f64::NAN, |first| (first / unit).round());
            let is_count = |(index, value): (usize, f64)| (value / unit - first - index as f64).abs() < 1e-6;
            let counts = (0.0..=1.0).contains(&first) && values(role).enumerate().all(is_count);
            if counts && values(role).count() >= FEWEST_COUNTED {
                let (column, title) = (self.numbers[role] + 1, self.titles[role].clone().unwrap_or_default());
                return Err(FileFault::Counter { column, title: excerpt(&title), role: self.roles[role].name });
            }
        }
        Ok(())
    }

    /// Tells which columns are used, in words.
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
