//! Errors of a scene.

use std::fmt;

use crate::storage::input::beginning;

/// Characters of either part of a message, which may quote what stands in the file.
const MOST: usize = 1000;

/// A mistake in a scene: [`Display`](fmt::Display) says what is wrong, [`Problem::right`] what would be right.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Problem {
    wrong: String,
    right: String,
    /// True if the key is at fault, not its value.
    at_key: bool,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.wrong)
    }
}

impl Problem {
    /// Returns a value that is wrong.
    pub(super) fn new(wrong: impl Into<String>, right: impl Into<String>) -> Self {
        Self { wrong: beginning(&wrong.into(), MOST), right: beginning(&right.into(), MOST), at_key: false }
    }

    /// Returns a key that is wrong, whatever its value.
    fn at_key(wrong: impl Into<String>, right: impl Into<String>) -> Self {
        Self { at_key: true, ..Self::new(wrong, right) }
    }

    /// Returns a key that the table, in words, does not have among those `known`; `nearest` was probably meant.
    pub(super) fn unknown_key(table: &str, nearest: Option<&str>, known: &[&str]) -> Self {
        let right = match nearest {
            Some(nearest) => format!("did you mean `{nearest}`?"),
            None => format!("known keys: {}", known.join(", ")),
        };
        Self::at_key(format!("this is not a key of {table}"), right)
    }

    /// Returns a key that must be given and is not.
    pub(super) fn missing(wanted: &str) -> Self {
        Self::at_key("this key is missing", format!("add it: {wanted}"))
    }

    /// Makes the problem of nothing where something is needed.
    pub(super) fn empty(wanted: &str) -> Self {
        Self::new("this is empty", format!("write {wanted}"))
    }

    /// Returns a number that cannot be held, as written.
    pub(super) fn too_large(text: &str, wanted: &str) -> Self {
        Self::new(format!("{text} is too large"), format!("write {wanted} that fits into 64 bits"))
    }

    /// Returns a whole number below the smallest one accepted.
    pub(super) fn too_small(value: i128, least: u64) -> Self {
        Self::new(format!("{value} is too small"), format!("write a whole number of at least {least}"))
    }

    /// Returns a number that is not finite, or outside its bounds.
    pub(super) fn out_of_range(value: f64, wanted: &str) -> Self {
        if value.is_finite() {
            Self::new(format!("{} is out of range", short(value)), format!("write {wanted}"))
        } else {
            Self::new(format!("{value} is not a finite number"), format!("write {wanted}"))
        }
    }

    /// Returns a number that is possible and hardly meant.
    pub(super) fn implausible(value: f64, [least, most]: [f64; 2], unit: &str) -> Self {
        let (value, least, most) = (short(value), short(least), short(most));
        let space = if unit.is_empty() { "" } else { " " };
        let wrong = format!("{value}{space}{unit} is hardly meant: from {least} to {most}{space}{unit} is plausible");
        Self::new(wrong, "is it in another unit? `allow_implausible = true` at the top of the scene lets it be tried")
    }

    /// Returns the same, its remedy led by what was perhaps meant.
    pub(super) fn with_hint(self, hint: &str) -> Self {
        Self { right: beginning(&format!("{hint}: {}", self.right), MOST), ..self }
    }

    /// Returns a word that is not in the list.
    pub(super) fn not_a_choice(given: &str, accepted: &[&'static str]) -> Self {
        let meant = nearest(given, accepted).map(|nearest| format!("did you mean \"{nearest}\"? "));
        let right = format!("{}accepted: {}", meant.unwrap_or_default(), quoted(accepted));
        Self::new(format!("\"{given}\" is not known here"), right)
    }

    /// Returns an array of another length than the one that it belongs to.
    pub(super) fn length_mismatch(length: usize, other: &str, other_length: usize) -> Self {
        let wrong = format!("this has {length} values, `{other}` has {other_length}");
        Self::at_key(wrong, format!("give as many values as in `{other}`"))
    }

    /// Returns a key that means nothing beside a choice, as written in TOML.
    pub(super) fn does_not_belong(owner: &str, right: &str) -> Self {
        Self::at_key(format!("this means nothing with {owner}"), right)
    }

    /// Returns a key that has another place and name now, as a path, in a table described by `wanted`.
    pub(super) fn moved(now: &str, wanted: &str) -> Self {
        let table = now.rsplit_once('.').map_or(now, |(table, _)| table);
        Self::at_key(format!("this key is `{now}` now"), format!("write it there: [{table}] is {wanted}"))
    }

    /// Returns two keys that exclude each other.
    pub(super) fn conflict(other: &str) -> Self {
        Self::at_key(format!("this and `{other}` exclude each other"), format!("give either this or `{other}`"))
    }

    /// Returns a length above another one of the scene \[m\].
    pub(super) fn exceeds(value: f64, limit: f64, name: &str) -> Self {
        let (value, limit) = (short(value), short(limit));
        let right = format!("write at most {limit} m, {name}");
        Self::new(format!("{value} m is more than {name}, {limit} m"), right)
    }

    /// Returns a length that is not below another one of the scene \[m\].
    pub(super) fn not_below(value: f64, limit: f64, name: &str) -> Self {
        let (value, limit) = (short(value), short(limit));
        let right = format!("write less than {limit} m, {name}");
        Self::new(format!("{value} m is not below {name}, {limit} m"), right)
    }

    /// Returns the remedy, as a short request.
    pub(crate) fn right(&self) -> &str {
        &self.right
    }

    /// Tells whether the key is at fault, not its value.
    pub(super) fn points_at_key(&self) -> bool {
        self.at_key
    }
}

/// Returns the words in quotes, separated by commas.
pub(super) fn quoted(words: &[&str]) -> String {
    words.iter().map(|word| format!("\"{word}\"")).collect::<Vec<_>>().join(", ")
}

/// Returns the candidate that a misspelt word was probably meant to be: at most a third of its letters differ.
pub(super) fn nearest(word: &str, candidates: &[&'static str]) -> Option<&'static str> {
    let word = word.to_lowercase();
    let distances = candidates.iter().map(|candidate| (strsim::damerau_levenshtein(&word, candidate), *candidate));
    let (distance, candidate) = distances.min_by_key(|(distance, _)| *distance)?;
    (distance <= (candidate.chars().count() / 3).max(1)).then_some(candidate)
}

/// Returns a number as people write it: no long rows of zeros.
pub(crate) fn short(value: f64) -> String {
    let plain = value == 0.0 || (1e-4..1e7).contains(&value.abs());
    if plain { format!("{value}") } else { format!("{value:e}") }
}
