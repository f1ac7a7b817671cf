//! Places of the keys of a scene in its files, so that any complaint, from the reader or from a later stage, points
//! there.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::problem::SourceText;
use super::{Diagnostic, Problem};

/// Place of a key and its value: byte ranges in a source.
#[derive(Clone, Debug)]
struct Place {
    source: Arc<SourceText>,
    key: Range<usize>,
    value: Range<usize>,
}

/// The places of all keys of a scene, its tyre file included, by key path.
#[derive(Clone, Debug)]
pub(super) struct Document {
    root: Arc<SourceText>,
    places: BTreeMap<String, Place>,
}

impl Document {
    /// Document of a scene's main file.
    pub(super) fn new(source: &Arc<SourceText>, table: &DeTable<'_>) -> Self {
        let mut document = Self { root: Arc::clone(source), places: BTreeMap::new() };
        document.index(source, table, "");
        document
    }

    /// Adds the keys of a file that takes the place of the table `prefix`.
    pub(super) fn include(&mut self, source: &Arc<SourceText>, table: &DeTable<'_>, prefix: &str) {
        // The table is the file: a key missing in it is missing in that file.
        let whole = Place { source: Arc::clone(source), key: 0..0, value: 0..0 };
        self.places.insert(prefix.to_owned(), whole);
        self.index(source, table, prefix);
    }

    /// Adds a value that replaces one of the scene, or joins it.
    pub(super) fn set(&mut self, source: &Arc<SourceText>, path: &str, value: &Spanned<DeValue<'_>>) {
        self.forget(path);
        self.index_value(source, value.get_ref(), path);
        let place = || Place { source: Arc::clone(source), key: value.span(), value: value.span() };
        self.places.insert(path.to_owned(), place());
        // Tables on the path that the scene does not have exist from now on.
        for (end, _) in path.match_indices(['.', '[']) {
            self.places.entry(path[..end].to_owned()).or_insert_with(place);
        }
    }

    /// Adds the place of a value whose key is not written in the file.
    pub(super) fn add(&mut self, source: &Arc<SourceText>, path: String, span: Range<usize>) {
        self.places.insert(path, Place { source: Arc::clone(source), key: span.clone(), value: span });
    }

    /// Renumbers the items of an array; `number` gives the new index, or `None` to forget an item.
    pub(super) fn renumber(&mut self, array: &str, number: impl Fn(usize) -> Option<usize>) {
        let renamed = |path: String| -> Option<String> {
            let Some((item, rest)) = path.strip_prefix(array).and_then(|rest| rest.strip_prefix('[')?.split_once(']'))
            else {
                return Some(path);
            };
            Some(format!("{array}[{}]{rest}", number(item.parse().ok()?)?))
        };
        let places = std::mem::take(&mut self.places).into_iter();
        self.places = places.filter_map(|(path, place)| Some((renamed(path)?, place))).collect();
    }

    /// Forgets a key and everything within it.
    pub(super) fn remove(&mut self, path: &str) {
        self.forget(path);
        self.places.remove(path);
    }

    /// Forgets all keys within a table or array.
    pub(super) fn forget(&mut self, path: &str) {
        let within =
            |key: &String| key.starts_with(path) && matches!(key.as_bytes().get(path.len()), Some(b'.' | b'['));
        self.places.retain(|key, _| !within(key));
    }

    fn index(&mut self, source: &Arc<SourceText>, table: &DeTable<'_>, prefix: &str) {
        for (key, value) in table {
            let path = join(prefix, key.get_ref());
            self.index_value(source, value.get_ref(), &path);
            self.places.insert(path, Place { source: Arc::clone(source), key: key.span(), value: value.span() });
        }
    }

    fn index_value(&mut self, source: &Arc<SourceText>, value: &DeValue<'_>, path: &str) {
        match value {
            DeValue::Table(table) => self.index(source, table, path),
            DeValue::Array(items) => {
                for (number, item) in items.iter().enumerate() {
                    let path = format!("{path}[{number}]");
                    self.index_value(source, item.get_ref(), &path);
                    self.places
                        .insert(path, Place { source: Arc::clone(source), key: item.span(), value: item.span() });
                }
            }
            _ => {}
        }
    }

    pub(super) fn has(&self, key: &str) -> bool {
        self.places.contains_key(key)
    }

    /// Diagnostic of a problem with a key, placed at the key or its value; a key that is not in the file is placed at
    /// the nearest enclosing table that is.
    pub(super) fn diagnose(&self, key: &str, problem: Problem) -> Diagnostic {
        let mut around = Some(key);
        while let Some(path) = around {
            if let Some(place) = self.places.get(path) {
                // A value of several lines would be marked from end to end: marking its key is enough.
                let value_is_short =
                    place.source.text.get(place.value.clone()).is_some_and(|text| !text.contains('\n'));
                let at_value = path == key && !problem.at_key && value_is_short;
                let span = if at_value { place.value.clone() } else { place.key.clone() };
                return Diagnostic { source: Arc::clone(&place.source), key: key.to_owned(), span, problem };
            }
            around = parent(path);
        }
        Diagnostic { source: Arc::clone(&self.root), key: key.to_owned(), span: 0..0, problem }
    }

    /// The key whose definition a byte of `source` belongs to: the last one in its line that begins at or before it.
    pub(super) fn key_at(&self, source: &Arc<SourceText>, byte: usize) -> Option<&str> {
        let line = source.line(byte).start;
        let keys = self.places.iter().filter(|(_, place)| Arc::ptr_eq(&place.source, source));
        let (path, _) = keys
            .filter(|(_, place)| (line..=byte).contains(&place.key.start))
            .max_by_key(|(path, place)| (place.key.start, path.len()))?;
        Some(path)
    }

    /// The table whose `[header]` is the last one before a byte of `source`; "" before the first header.
    pub(super) fn table_at(&self, source: &Arc<SourceText>, byte: usize) -> &str {
        // A header's brackets surround its key; those of an array come after it.
        let is_header =
            |place: &Place| place.value.start <= place.key.start && source.text[place.value.start..].starts_with('[');
        let headers =
            self.places.iter().filter(|(_, place)| Arc::ptr_eq(&place.source, source) && place.value.start <= byte);
        let last =
            headers.filter(|(_, place)| is_header(place)).max_by_key(|(path, place)| (place.value.start, path.len()));
        last.map_or("", |(path, _)| path)
    }
}

/// The path `prefix.key`, the key in quotes where TOML needs them.
pub(super) fn join(prefix: &str, key: &str) -> String {
    let bare = !key.is_empty() && key.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-');
    let dot = if prefix.is_empty() { "" } else { "." };
    if bare { format!("{prefix}{dot}{key}") } else { format!("{prefix}{dot}{key:?}") }
}

/// Path of the table or array that a key lies in.
fn parent(path: &str) -> Option<&str> {
    path.rfind(['.', '[']).map(|end| &path[..end])
}

/// Most complaints that are stored while a scene is read; the order of the file is lost beyond them.
const MOST_HELD: usize = 512;

/// The complaints collected while one scene is read.
#[derive(Debug)]
pub(super) struct Complaints<'a> {
    document: &'a Document,
    /// Factor by which values may lie outside their plausible range.
    pub(super) slack: f64,
    found: RefCell<Vec<Diagnostic>>,
    /// Number of complaints that are not stored.
    more: Cell<usize>,
}

impl<'a> Complaints<'a> {
    pub(super) fn new(document: &'a Document, slack: f64) -> Self {
        Self { document, slack, found: RefCell::default(), more: Cell::new(0) }
    }

    /// An empty collection for the same scene, whose complaints are not reported.
    pub(super) fn unreported(&self) -> Self {
        Self::new(self.document, self.slack)
    }

    pub(super) fn gives(&self, key: &str) -> bool {
        self.document.has(key)
    }

    /// Adds a complaint; its problem is made only if it is stored.
    pub(super) fn add_with(&self, key: &str, problem: impl FnOnce() -> Problem) {
        if self.found.borrow().len() < MOST_HELD {
            let diagnostic = self.document.diagnose(key, problem());
            self.found.borrow_mut().push(diagnostic);
        } else {
            self.more.set(self.more.get() + 1);
        }
    }

    pub(super) fn add(&self, key: &str, problem: Problem) {
        self.add_with(key, || problem);
    }

    /// All complaints in the order of the text, those in the scene's main file first, and how many more there were.
    pub(super) fn finish(self) -> (Vec<Diagnostic>, usize) {
        let mut found = self.found.into_inner();
        found.sort_by_key(|diagnostic| (!Arc::ptr_eq(&diagnostic.source, &self.document.root), diagnostic.span.start));
        (found, self.more.get())
    }
}
