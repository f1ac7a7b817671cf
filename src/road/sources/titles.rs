//! Titles of tables: the quantities that they name, and their units.

use crate::road::file_fault::FileFault;
use crate::scene::LengthUnit;
use crate::storage::input::excerpt;
use crate::storage::separated::{self, Record, SeparatedTable};

/// Quantity that a column is read as.
#[derive(Clone, Copy, Debug)]
pub(super) struct Role {
    pub(super) name: &'static str,
    /// Words in titles, lower case.
    words: &'static [&'static str],
    /// Words that name it where no others stand beside them.
    alone: &'static [&'static str],
    pub(super) unit_key: &'static str,
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

/// Words of titles of columns that count.
const COUNTERS: [&str; 11] =
    ["sample", "samples", "no", "nr", "number", "index", "id", "point", "points", "count", "counter"];
/// Units in titles that are no lengths, or none that is read: as the last word, without brackets.
const OTHER_UNITS: [&str; 12] = ["km", "nm", "dm", "yd", "mi", "s", "ms", "v", "mv", "hz", "db", "deg"];

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

    pub(super) fn name(&self, column: usize) -> &str {
        self.names.get(column).map_or("", String::as_str)
    }

    /// Returns the unit of a column, where one is stated.
    ///
    /// # Errors
    /// No length, or two of them.
    pub(super) fn unit(&self, column: usize) -> Result<Option<LengthUnit>, FileFault> {
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
    pub(super) fn column_of(&self, role: &Role) -> Option<usize> {
        let only = |may_be: &dyn Fn(usize) -> bool| {
            let mut found = (0..self.names.len()).filter(|&column| is_of(self.name(column), role) && may_be(column));
            found.next().filter(|_| found.next().is_none())
        };
        only(&|column| self.unit(column).is_ok()).or_else(|| only(&|_| true))
    }

    /// True if a column's title is that of a counter.
    pub(super) fn is_counter(&self, column: usize) -> bool {
        is_counter(self.name(column)) && matches!(self.unit(column), Ok(None))
    }

    /// Finds the titles of so many cells in the records before the numbers, or in a comment.
    pub(super) fn find(table: &SeparatedTable<'_>, before: &[Record<'_>], first: u64, cells: usize) -> Option<Self> {
        // 1. A line of titles has as many words as there are columns, none of them a number; empty cells at its end do
        //    not count.
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
        //    quantity or a unit of a road.
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
pub(super) fn bare(title: &str) -> String {
    let name = title.split(['(', '[']).next().unwrap_or_default().trim();
    let words = name.split(|sign: char| !sign.is_alphanumeric()).filter(|word| !word.is_empty());
    let mut words: Vec<&str> = words.collect();
    // Both words of "x in mm" are units.
    while words.len() > 1 && words.last().is_some_and(|word| LengthUnit::of_word(word).is_some()) {
        words.pop();
    }
    words.join(" ").to_lowercase()
}

pub(super) fn is_of(title: &str, role: &Role) -> bool {
    let name = bare(title);
    let words = || name.split(' ').map(|word| word.trim_end_matches(|sign: char| sign.is_ascii_digit()));
    words().any(|word| role.words.contains(&word)) || words().all(|word| role.alone.contains(&word))
}

pub(super) fn is_counter(title: &str) -> bool {
    bare(title).split(' ').any(|word| COUNTERS.contains(&word))
}
