//! Mistakes in a scene: what is wrong, and what would be right. A mistake with its place in a file, and its display.

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

use crate::storage::input::beginning;
use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet, normalize_untrusted_str};

/// Most characters of either part of a message, which may quote the file.
const MOST: usize = 1000;
/// Begin of the remedy for a key that a table does not have.
const KNOWN_KEYS: &str = "known keys: ";

/// A mistake in a scene: [`Display`](fmt::Display) says what is wrong, [`Problem::right`] what would be right.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Problem {
    wrong: String,
    pub(crate) right: String,
    /// True if the key is at fault, not its value.
    pub(super) at_key: bool,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.wrong)
    }
}

impl Problem {
    /// A problem of a value.
    pub(super) fn new(wrong: impl Into<String>, right: impl Into<String>) -> Self {
        Self { wrong: beginning(&wrong.into(), MOST), right: beginning(&right.into(), MOST), at_key: false }
    }

    /// A problem of a key, whatever its value.
    fn at_key(wrong: impl Into<String>, right: impl Into<String>) -> Self {
        Self { at_key: true, ..Self::new(wrong, right) }
    }

    /// A key that a table, described by `table`, does not have among those `known`; `nearest` was probably meant.
    pub(super) fn unknown_key(table: &str, nearest: Option<&str>, known: &[&str]) -> Self {
        let right = match nearest {
            Some(nearest) => format!("did you mean `{nearest}`?"),
            None => format!("{KNOWN_KEYS}{}", known.join(", ")),
        };
        Self::at_key(format!("this is not a key of {table}"), right)
    }

    /// True for a key that its table does not have, and that resembles none of it.
    pub(super) fn is_foreign_key(&self) -> bool {
        self.right.starts_with(KNOWN_KEYS)
    }

    /// The same problem of a key that stands in other tables, as these paths.
    pub(super) fn elsewhere(&mut self, paths: &[String]) {
        let paths = paths.iter().map(|path| format!("`{path}`")).collect::<Vec<_>>().join(" or ");
        self.right = beginning(&format!("did you mean {paths}? {}", self.right), MOST);
    }

    pub(super) fn missing(wanted: &str) -> Self {
        Self::at_key("this key is missing", format!("add it: {wanted}"))
    }

    /// Nothing where something is needed.
    pub(super) fn empty(wanted: &str) -> Self {
        Self::new("this is empty", format!("write {wanted}"))
    }

    /// A number, as written, that does not fit into 64 bits.
    pub(super) fn too_large(text: &str, wanted: &str) -> Self {
        Self::new(format!("{text} is too large"), format!("write {wanted} that fits into 64 bits"))
    }

    /// A whole number below its least value.
    pub(super) fn too_small(value: i128, least: u64) -> Self {
        Self::new(format!("{value} is too small"), format!("write a whole number of at least {least}"))
    }

    /// A number that is not finite, or outside its bounds.
    pub(super) fn out_of_range(value: f64, wanted: &str) -> Self {
        if value.is_finite() {
            Self::new(format!("{} is out of range", short(value)), format!("write {wanted}"))
        } else {
            Self::new(format!("{value} is not a finite number"), format!("write {wanted}"))
        }
    }

    /// A number that is possible but implausible.
    pub(super) fn implausible(value: f64, [least, most]: [f64; 2], unit: &str) -> Self {
        let (value, least, most) = (short(value), short(least), short(most));
        let space = if unit.is_empty() { "" } else { " " };
        let wrong = format!("{value}{space}{unit} is implausible: from {least} to {most}{space}{unit} is plausible");
        Self::new(wrong, "is it in another unit? `allow_implausible = true` at the top of the scene accepts it")
    }

    /// The same problem; its remedy begins with what was probably meant.
    pub(super) fn with_hint(self, hint: &str) -> Self {
        Self { right: beginning(&format!("{hint}: {}", self.right), MOST), ..self }
    }

    /// A word that is not in the list.
    pub(super) fn not_a_choice(given: &str, accepted: &[&'static str]) -> Self {
        let meant = nearest(given, accepted).map(|nearest| format!("did you mean \"{nearest}\"? "));
        let right = format!("{}accepted: {}", meant.unwrap_or_default(), quoted(accepted));
        Self::new(format!("\"{given}\" is not known here"), right)
    }

    /// A word that was in the list once.
    pub(super) fn former_choice(given: &str, instead: &str) -> Self {
        Self::new(format!("\"{given}\" is no longer a choice"), instead)
    }

    /// An array of another length than the one that it belongs to.
    pub(super) fn length_mismatch(length: usize, other: &str, other_length: usize) -> Self {
        let wrong = format!("this has {length} values, `{other}` has {other_length}");
        Self::at_key(wrong, format!("give as many values as in `{other}`"))
    }

    /// A key that has no meaning with `owner`, another setting as written in TOML.
    pub(super) fn does_not_belong(owner: &str, right: &str) -> Self {
        Self::at_key(format!("this does not apply with {owner}"), right)
    }

    /// A key that has another path now, `now`, in a table described by `wanted`.
    pub(super) fn moved(now: &str, wanted: &str) -> Self {
        let table = now.rsplit_once('.').map_or(now, |(table, _)| table);
        Self::at_key(format!("this key is `{now}` now"), format!("write it there: [{table}] is {wanted}"))
    }

    /// A key that excludes another one.
    pub(super) fn conflict(other: &str) -> Self {
        Self::at_key(format!("this and `{other}` exclude each other"), format!("give either this or `{other}`"))
    }

    /// A length above another one of the scene, called `name` \[m\].
    pub(super) fn exceeds(value: f64, limit: f64, name: &str) -> Self {
        let (value, limit) = (short(value), at_most(limit));
        let right = format!("write at most {limit} m, {name}");
        Self::new(format!("{value} m is more than {name}, {limit} m"), right)
    }

    /// A length that is not below another one of the scene, called `name` \[m\].
    pub(super) fn not_below(value: f64, limit: f64, name: &str) -> Self {
        let (value, limit) = (short(value), at_most(limit));
        let right = format!("write less than {limit} m, {name}");
        Self::new(format!("{value} m is not below {name}, {limit} m"), right)
    }
}

/// The words in quotes, separated by commas.
pub(super) fn quoted(words: &[&str]) -> String {
    words.iter().map(|word| format!("\"{word}\"")).collect::<Vec<_>>().join(", ")
}

/// The candidate that a misspelt word was probably meant to be: at most a third of its letters differ.
pub(super) fn nearest(word: &str, candidates: &[&'static str]) -> Option<&'static str> {
    let word = word.to_lowercase();
    let distances = candidates.iter().map(|candidate| (strsim::damerau_levenshtein(&word, candidate), *candidate));
    let (distance, candidate) = distances.min_by_key(|(distance, _)| *distance)?;
    (distance <= (candidate.chars().count() / 3).max(1)).then_some(candidate)
}

/// A number without long rows of zeros.
pub(crate) fn short(value: f64) -> String {
    let plain = value == 0.0 || (1e-4..1e7).contains(&value.abs());
    if plain { format!("{value}") } else { format!("{value:e}") }
}

/// An upper limit; one of many digits is rounded down to three.
pub(super) fn at_most(limit: f64) -> String {
    let exact = short(limit);
    if exact.len() <= 8 || limit <= 0.0 || exact.contains('e') {
        return exact;
    }
    let digits = 2 - limit.log10().floor() as i32;
    let unit = 10_f64.powi(-digits);
    format!("{:.*}", digits.max(0) as usize, (limit / unit).floor() * unit)
}

/// A text and where it comes from.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct SourceText {
    /// The file's path as the user gave it, or any other name.
    pub name: String,
    /// The whole text.
    pub text: String,
}

impl SourceText {
    /// Line and column of a byte, both from 1, the column in characters.
    pub(crate) fn position(&self, byte: usize) -> (usize, usize) {
        let before = self.text.get(..byte).unwrap_or(&self.text);
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().unwrap_or(before).chars().count() + 1;
        (line, column)
    }

    /// Byte range of the line that a byte lies in, without its line end.
    pub(crate) fn line(&self, byte: usize) -> Range<usize> {
        let (before, after) = self.text.split_at_checked(byte).unwrap_or((&self.text, ""));
        let begin = before.rfind('\n').map_or(0, |end| end + 1);
        begin..before.len() + after.find('\n').unwrap_or(after.len())
    }
}

/// A mistake, the key it concerns, and its place in a file.
#[derive(Debug)]
pub struct Diagnostic {
    pub(super) source: Arc<SourceText>,
    pub(super) key: String,
    pub(super) span: Range<usize>,
    pub(super) problem: Problem,
}

impl Diagnostic {
    /// Name of the file, as the user gave it.
    pub fn file(&self) -> &str {
        &self.source.name
    }

    /// Line in the file, from 1.
    pub fn line(&self) -> usize {
        self.source.position(self.span.start).0
    }

    /// Column in characters, from 1.
    pub fn column(&self) -> usize {
        self.source.position(self.span.start).1
    }

    /// Path of the key, such as `tyre.layers[1].thickness`, array items from 0; empty where the mistake concerns no
    /// key.
    pub fn key(&self) -> &str {
        &self.key
    }

    pub(crate) fn problem(&self) -> &Problem {
        &self.problem
    }

    /// The key and what is wrong with it.
    fn title(&self) -> String {
        if self.key.is_empty() { self.problem.to_string() } else { format!("{}: {}", self.key, self.problem) }
    }

    /// Message with the lines concerned, the place marked, and what would be right; `colour` for terminals.
    pub fn render(&self, colour: bool) -> String {
        let renderer = if colour { Renderer::styled() } else { Renderer::plain() };
        // A range from a quote that is never closed would mark the rest of the file: it ends with the line.
        let end = self.span.end.min(self.source.line(self.span.start).end).max(self.span.start);
        let annotation = AnnotationKind::Primary.span(self.span.start..end).label(&self.problem.right);
        let snippet = Snippet::source(self.source.text.as_str()).path(self.file()).annotation(annotation);
        renderer.render(&[Level::ERROR.primary_title(self.title()).element(snippet)])
    }
}

/// One line: file:line:column: key: what is wrong (what would be right).
impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (line, column) = self.source.position(self.span.start);
        // Keys and texts come from the file: control characters must not reach a terminal.
        let message = normalize_untrusted_str(&format!("{} ({})", self.title(), self.problem.right));
        write!(f, "{}:{line}:{column}: {message}", self.file())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_of_many_digits_are_rounded_down() {
        let bounds = [std::f64::consts::PI, 0.09867606471697511, 1234.567891, 0.2, 1e-9, 0.49999].map(at_most);
        assert_eq!(bounds, ["3.14", "0.0986", "1230", "0.2", "1e-9", "0.49999"]);
    }
}
