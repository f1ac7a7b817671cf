//! Reads a TOML table key by key and reports the keys that were not asked for.

use serde::Serialize;
use serde_json::{Value as Json, json};
use toml::de::{DeTable, DeValue};

use super::Problem;
use super::document::{Complaints, join};
use super::problem::nearest;

/// Kind of a value at a key: how it is read, described and written.
pub(super) trait Kind {
    /// Type of a value that was read.
    type Output: Serialize;

    /// Describes the wanted value, in words that continue "write ...".
    fn wanted(&self) -> String;

    /// Reads it, or complains and returns `None`.
    fn read(&self, value: &Value<'_>) -> Option<Self::Output>;

    /// JSON Schema of the accepted values.
    fn schema(&self) -> Json;

    /// A value as JSON, in the form in which it is read; null if it is left out.
    fn written(&self, output: &Self::Output) -> Json {
        json!(output)
    }
}

/// A value and its key path.
pub(super) struct Value<'a> {
    complaints: &'a Complaints<'a>,
    key: String,
    pub value: &'a DeValue<'a>,
}

impl<'a> Value<'a> {
    /// Complains about this value; returns `None` for the reader to return.
    pub(super) fn complain<T>(&self, problem: Problem) -> Option<T> {
        self.complaints.add(&self.key, problem);
        None
    }

    /// Complains that a value of another type is expected here.
    pub(super) fn wrong_type<T>(&self, kind: &impl Kind) -> Option<T> {
        let found = match self.value {
            DeValue::String(text) => format!("the text \"{text}\""),
            DeValue::Integer(integer) => format!("the whole number {integer}"),
            DeValue::Float(float) => format!("the number {float}"),
            DeValue::Boolean(flag) => format!("{flag}"),
            DeValue::Datetime(time) => format!("the time {time}"),
            DeValue::Array(_) => "an array".to_owned(),
            DeValue::Table(_) => "a table".to_owned(),
        };
        self.complain(Problem::new(format!("{found} is not allowed here"), format!("write {}", kind.wanted())))
    }

    /// Factor by which the value may lie outside its plausible range.
    pub(super) fn slack(&self) -> f64 {
        self.complaints.slack
    }

    /// Reads an array of at least one item, each of the kind `kind`; complains as `array` otherwise.
    pub(super) fn each<K: Kind>(&self, kind: &K, array: &impl Kind) -> Option<Vec<K::Output>> {
        let Some(items) = self.items() else { return self.wrong_type(array) };
        if items.is_empty() {
            return self.complain(Problem::empty(&array.wanted()));
        }
        // All items are read before the first failure counts, so that every bad one is reported.
        let items: Vec<_> = items.iter().map(|item| kind.read(item)).collect();
        items.into_iter().collect()
    }

    /// The items of an array; `None` for anything else, without a complaint.
    pub(super) fn items(&self) -> Option<Vec<Value<'a>>> {
        let items = self.value.as_array()?;
        let item = |(number, item): (usize, &'a toml::Spanned<DeValue<'a>>)| Value {
            complaints: self.complaints,
            key: format!("{}[{number}]", self.key),
            value: item.get_ref(),
        };
        Some(items.iter().enumerate().map(item).collect())
    }
}

/// A table that is being read.
pub(super) struct Table<'a> {
    complaints: &'a Complaints<'a>,
    key: String,
    /// Description of the table, for complaints.
    title: &'static str,
    entries: &'a DeTable<'a>,
    /// Keys asked for so far.
    known: Vec<&'static str>,
    /// Keys that are not read, since they have no meaning here or their meaning is not known.
    refused: Vec<&'static str>,
    /// True if keys that are not asked for are left alone.
    lenient: bool,
}

impl<'a> Table<'a> {
    /// A table at a key path; "" is the whole file.
    pub(super) fn new(
        complaints: &'a Complaints<'a>,
        key: String,
        title: &'static str,
        entries: &'a DeTable<'a>,
    ) -> Self {
        Self { complaints, key, title, entries, known: Vec::new(), refused: Vec::new(), lenient: false }
    }

    /// The value at a key, if given and not refused; the key counts as known.
    pub(super) fn take(&mut self, key: &'static str) -> Option<Value<'a>> {
        self.known.push(key);
        let value = self.entries.get(key).filter(|_| !self.refused.contains(&key))?;
        Some(Value { complaints: self.complaints, key: join(&self.key, key), value: value.get_ref() })
    }

    /// Reads a key without complaints, before or after it is read properly: the inner `None` if it is not given, the
    /// outer one if its value is wrong.
    pub(super) fn peek<K: Kind>(&self, key: &str, kind: &K) -> Option<Option<K::Output>> {
        let Some(value) = self.entries.get(key) else { return Some(None) };
        let unreported = self.complaints.unreported();
        kind.read(&Value { complaints: &unreported, key: join(&self.key, key), value: value.get_ref() }).map(Some)
    }

    /// True if a key within this table is in the file, as a path such as `layers[0].tension`.
    pub(super) fn gives(&self, path: &str) -> bool {
        self.complaints.gives(&self.path(path))
    }

    /// Complains if a length is not below another one of the table, described by `name`; `None` after a complaint.
    pub(super) fn below(&self, key: &str, other: &str, kind: &impl Kind<Output = f64>, name: &str) -> Option<()> {
        match (self.peek(key, kind), self.peek(other, kind)) {
            (Some(Some(value)), Some(Some(limit))) if value >= limit => {
                self.complain(key, Problem::not_below(value, limit, name))
            }
            _ => Some(()),
        }
    }

    /// Factor by which values may lie outside their plausible range.
    pub(super) fn slack(&self) -> f64 {
        self.complaints.slack
    }

    pub(super) fn has(&self, key: &str) -> bool {
        self.entries.contains_key(key)
    }

    /// Reads a key that must be given; `None` after a complaint.
    pub(super) fn required<K: Kind>(&mut self, key: &'static str, kind: &K) -> Option<K::Output> {
        match self.take(key) {
            Some(value) => kind.read(&value),
            None => self.complain_of_missing(key, kind),
        }
    }

    /// Complains that a key must be given; returns `None` for the reader to return.
    pub(super) fn complain_of_missing<T>(&self, key: &'static str, kind: &impl Kind) -> Option<T> {
        self.complain(key, Problem::missing(&kind.wanted()))
    }

    /// Reads a key that has a default; `None` after a complaint.
    pub(super) fn or<K: Kind>(&mut self, key: &'static str, kind: &K, default: K::Output) -> Option<K::Output> {
        match self.take(key) {
            Some(value) => kind.read(&value),
            None => Some(default),
        }
    }

    /// Complains about each of these keys that is given: they have no meaning with `owner`, and are not read.
    pub(super) fn refuse(&mut self, keys: &[&'static str], owner: &str, right: &'static str) {
        for key in keys.iter().filter(|key| self.has(key)) {
            self.complain::<()>(key, Problem::does_not_belong(owner, right));
        }
        self.pass(keys);
    }

    /// Leaves keys unread, without complaints.
    pub(super) fn pass(&mut self, keys: &[&'static str]) {
        self.refused.extend(keys);
    }

    /// Accepts unknown keys from now on: the key that decides which there are is itself wrong.
    pub(super) fn be_lenient(&mut self) {
        self.lenient = true;
    }

    /// Changes the description of the table, once more is known about it.
    pub(super) fn rename(&mut self, title: &'static str) {
        self.title = title;
    }

    /// Complains about a key of this table, or a path within it such as `levels[2]`; returns `None` for the reader to
    /// return.
    pub(super) fn complain<T>(&self, key: &str, problem: Problem) -> Option<T> {
        self.complaints.add(&self.path(key), problem);
        None
    }

    /// Complains about each of these keys that is refused, given with what is wrong and what would be right; `None`
    /// after a complaint.
    pub(super) fn complain_of_each<'b>(
        &self,
        keys: impl IntoIterator<Item = (bool, &'b str, &'b str, &'b str)>,
    ) -> Option<()> {
        let mut sound = Some(());
        for (_, key, wrong, right) in keys.into_iter().filter(|(is_refused, ..)| *is_refused) {
            sound = self.complain(key, Problem::new(wrong, right));
        }
        sound
    }

    fn path(&self, key: &str) -> String {
        let dot = if self.key.is_empty() { "" } else { "." };
        format!("{}{dot}{key}", self.key)
    }

    /// All keys that the table knows, read or refused.
    fn keys(&self) -> Vec<&'static str> {
        let refused = self.refused.iter().filter(|key| !self.known.contains(key));
        self.known.iter().chain(refused).copied().collect()
    }

    /// Complains about the table itself; returns `None` for the reader to return.
    pub(super) fn complain_here<T>(&self, problem: Problem) -> Option<T> {
        self.complaints.add(&self.key, problem);
        None
    }

    /// True if keys are given that were not asked for so far.
    pub(super) fn has_unknown(&self) -> bool {
        let known = self.keys();
        self.entries.keys().any(|key| !known.contains(&key.get_ref().as_ref()))
    }

    /// Complains about the keys that were not asked for.
    pub(super) fn finish(self) {
        if self.lenient {
            return;
        }
        let known = self.keys();
        // A key that is given itself cannot have been meant by a misspelt one.
        let free: Vec<_> = known.iter().copied().filter(|known| !self.has(known)).collect();
        for key in self.entries.keys().map(|key| key.get_ref().as_ref()).filter(|key| !known.contains(key)) {
            let problem = || Problem::unknown_key(self.title, nearest(key, &free), &known);
            self.complaints.add_with(&join(&self.key, key), problem);
        }
    }
}

/// Schema of an array of at least one item of a kind.
pub(super) fn array(kind: &impl Kind) -> Json {
    json!({ "type": "array", "items": kind.schema(), "minItems": 1 })
}

/// Keys of a table, as `keys!` declares them.
pub(super) trait Keys: Sized {
    /// Reads all keys before the first failure counts, so that independent mistakes are reported together.
    fn read(table: &mut Table<'_>) -> Option<Self>;

    /// JSON Schema of the table.
    fn schema() -> Json;
}

/// A table within a table: how it is described and read.
#[derive(Debug)]
pub(super) struct Nested<T> {
    /// Description of the table, for complaints.
    pub(super) title: &'static str,
    /// Description of the wanted value.
    pub(super) wanted: &'static str,
    pub(super) schema: fn() -> Json,
    pub(super) read: fn(&mut Table<'_>) -> Option<T>,
}

impl<T: Keys> Nested<T> {
    pub(super) const fn new(title: &'static str, wanted: &'static str) -> Self {
        Self { title, wanted, schema: T::schema, read: T::read }
    }

    /// The same, read by a function that also compares keys.
    pub(super) const fn read_by(self, read: fn(&mut Table<'_>) -> Option<T>) -> Self {
        Self { read, ..self }
    }
}

impl<T: Serialize> Kind for Nested<T> {
    type Output = T;

    fn wanted(&self) -> String {
        self.wanted.to_owned()
    }

    fn read(&self, value: &Value<'_>) -> Option<T> {
        let Some(entries) = value.value.as_table() else { return value.wrong_type(self) };
        let mut table = Table::new(value.complaints, value.key.clone(), self.title, entries);
        let read = (self.read)(&mut table);
        table.finish();
        read
    }

    fn schema(&self) -> Json {
        (self.schema)()
    }
}

/// An array of tables, at least one.
#[derive(Debug)]
pub(super) struct Each<T>(pub(super) Nested<T>);

impl<T: Serialize> Kind for Each<T> {
    type Output = Vec<T>;

    fn wanted(&self) -> String {
        self.0.wanted()
    }

    fn read(&self, value: &Value<'_>) -> Option<Vec<T>> {
        value.each(&self.0, self)
    }

    fn schema(&self) -> Json {
        array(&self.0)
    }
}
