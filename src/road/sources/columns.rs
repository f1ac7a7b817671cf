//! Columns of tables: which of them are distance and height, their titles and units.

use std::collections::BTreeMap;
use std::path::Path;

use super::missing::is_word_for_none;
use crate::road::error::RoadError;
use crate::road::file_fault::FileFault;
use crate::road::report::RoadNote;
use crate::scene::{LengthUnit, MissingHeight};
use crate::storage::input::excerpt;
use crate::storage::separated::{self, Record, SeparatedTable};

/// Least number of counting values for which a column is taken as a counter.
const FEWEST_COUNTED: usize = 8;

/// A point of a file: distance and height \[m\], height NaN if missing, and its line from 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FilePoint {
    pub(super) distance: f64,
    pub(super) height: f64,
    pub(super) line: u64,
}

/// Quantity that a column is read as.
#[derive(Clone, Copy, Debug)]
pub(super) struct Role {
    pub(super) name: &'static str,
    /// Words in titles, lower case.
    words: &'static [&'static str],
    /// Words that name it where no others stand beside them.
    alone: &'static [&'static str],
    unit_key: &'static str,
}

pub(super) const DISTANCE: Role = Role {
    name: "distance",
    words: &[
        "distance",
        "dist",
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
    alone: &["x", "s", "position", "pos", "coordinate"],
    unit_key: "distance_unit",
};
pub(super) const ACROSS: Role = Role {
    name: "lateral position",
    words: &["y", "across", "lateral", "transverse", "transversal"],
    alone: &[],
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
    alone: &["profile"],
    unit_key: "height_unit",
};

/// Words of titles of heights that may count downwards.
const DOWNWARDS: [&str; 2] = ["depth", "tiefe"];
/// Words of titles of columns that count.
const COUNTERS: [&str; 11] =
    ["sample", "samples", "no", "nr", "number", "index", "id", "point", "points", "count", "counter"];
/// Units in titles that are no lengths, or none that is read: as the last word, without brackets.
const OTHER_UNITS: [&str; 12] = ["km", "nm", "dm", "yd", "mi", "s", "ms", "v", "mv", "hz", "db", "deg"];

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

/// Unit of a column, as a title or a row of units gives it.
#[derive(Clone, Debug, PartialEq)]
enum Unit {
    Unsaid,
    Length(LengthUnit),
    /// No length that is read.
    Other(String),
}

impl Unit {
    fn of_word(word: &str) -> Self {
        match LengthUnit::of_word(word) {
            Some(unit) => Self::Length(unit),
            None if word.is_empty() => Self::Unsaid,
            None => Self::Other(word.to_owned()),
        }
    }

    /// Returns the unit in the brackets of a title, or that of its last word before them.
    fn of_title(title: &str) -> Self {
        let (name, brackets) = title.split_at(title.find(['(', '[']).unwrap_or(title.len()));
        let brackets = || {
            let texts = brackets.split(['(', '[']).filter_map(|text| text.split([')', ']']).next());
            texts.map(|text| text.trim().trim_start_matches("in ")).filter(|text| !text.is_empty())
        };
        let mut words = name.split(|sign: char| !sign.is_alphanumeric()).filter(|word| !word.is_empty());
        let word = words.next_back().filter(|_| words.next().is_some());
        if let Some(unit) = brackets().find_map(LengthUnit::of_word).or(word.and_then(LengthUnit::of_word)) {
            return Self::Length(unit);
        }
        let is_other = |word: &&str| OTHER_UNITS.contains(&word.to_lowercase().as_str());
        brackets().next().or(word.filter(is_other)).map_or(Self::Unsaid, |unit| Self::Other(unit.to_owned()))
    }
}

/// The titles of a table.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Titles {
    /// Line of the titles, from 1; `last` is that of the row of units if there is one.
    pub(super) line: u64,
    pub(super) last: u64,
    pub(super) names: Vec<String>,
    /// Units that they and the row below them state.
    units: Vec<[Unit; 2]>,
}

impl Titles {
    /// Titles at a line, with the units that they state.
    pub(super) fn new(line: u64, names: Vec<String>) -> Self {
        let units = names.iter().map(|name| [Unit::of_title(name), Unit::Unsaid]).collect();
        Self { line, last: line, names, units }
    }

    fn name(&self, column: usize) -> &str {
        self.names.get(column).map_or("", String::as_str)
    }

    /// Returns the unit of a column, where one is stated.
    ///
    /// # Errors
    /// No length, or two of them.
    fn unit(&self, column: usize) -> Result<Option<LengthUnit>, FileFault> {
        let (line, title) = (self.line, excerpt(self.name(column)));
        match self.units.get(column) {
            None | Some([Unit::Unsaid, Unit::Unsaid]) => Ok(None),
            Some([Unit::Other(found), _] | [_, Unit::Other(found)]) => {
                Err(FileFault::UnknownUnit { line, title, found: excerpt(found) })
            }
            Some([Unit::Length(first), Unit::Length(second)]) if first != second => {
                Err(FileFault::UnitRow { line, title, first: first.word(), second: second.word() })
            }
            Some([Unit::Length(unit), _] | [_, Unit::Length(unit)]) => Ok(Some(*unit)),
        }
    }

    /// Returns the column that alone has a title of a role; one in another unit than a length only if no other has.
    fn column_of(&self, role: &Role) -> Option<usize> {
        let only = |may_be: &dyn Fn(usize) -> bool| {
            let mut found = (0..self.names.len()).filter(|&column| is_of(self.name(column), role) && may_be(column));
            found.next().filter(|_| found.next().is_none())
        };
        only(&|column| self.unit(column).is_ok()).or_else(|| only(&|_| true))
    }

    /// True if a column's title is that of a counter.
    fn is_counter(&self, column: usize) -> bool {
        is_counter(self.name(column)) && matches!(self.unit(column), Ok(None))
    }

    /// Finds the titles of so many cells in the records before the numbers, or in a comment.
    pub(super) fn find(table: &SeparatedTable<'_>, before: &[Record<'_>], first: u64, cells: usize) -> Option<Self> {
        // 1. A line of titles has as many words as there are columns, none of them a number; empty cells at its end do
        //    not
        // count.
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
        // 2. A row of units may stand directly before the numbers.
        let unit_row = before.last().and_then(|record| {
            let words: Vec<&str> = record.cells.iter().map(|cell| cell.trim_matches(['(', ')', '[', ']'])).collect();
            let is_unit = |word: &&str| LengthUnit::of_word(word).is_some();
            let all = words.iter().all(|word| is_unit(word) || word.len() <= 3);
            (all && words.iter().any(is_unit)).then_some((record.line, words))
        });
        let named = before.len() - usize::from(unit_row.is_some());
        let tells = |names: &[String]| {
            let has_unit = |name: &str| matches!(Unit::of_title(name), Unit::Length(_));
            names.iter().any(|name| is_of(name, &DISTANCE) || is_of(name, &HEIGHT) || has_unit(name))
        };
        // 3. Titles: any words directly before the numbers; farther away, or in a comment, only words that name a
        //    quantity or
        // a unit of a road.
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
            (None, Some((line, words))) => Self::new(*line, vec![String::new(); words.len()]),
            (None, None) => return None,
        };
        if let Some((line, words)) = unit_row {
            found.last = found.last.max(line);
            found.units.iter_mut().zip(words).for_each(|(units, word)| units[1] = Unit::of_word(word));
        }
        Some(found)
    }
}

/// Titles from words separated by blanks: brackets belong to the word before them.
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

/// Returns a title in lower case without its unit.
fn bare(title: &str) -> String {
    let name = title.split(['(', '[']).next().unwrap_or_default().trim();
    let words = name.split(|sign: char| !sign.is_alphanumeric()).filter(|word| !word.is_empty());
    let mut words: Vec<&str> = words.collect();
    // Both words of "x in mm" are units.
    while words.len() > 1 && words.last().is_some_and(|word| LengthUnit::of_word(word).is_some()) {
        words.pop();
    }
    words.join(" ").to_lowercase()
}

fn is_of(title: &str, role: &Role) -> bool {
    let name = bare(title);
    let words = || name.split(' ').map(|word| word.trim_end_matches(|sign: char| sign.is_ascii_digit()));
    words().any(|word| role.words.contains(&word)) || words().all(|word| role.alone.contains(&word))
}

fn is_counter(title: &str) -> bool {
    bare(title).split(' ').any(|word| COUNTERS.contains(&word))
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
