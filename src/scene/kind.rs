//! Kinds of values at a key: types, bounds and lists of words, each with a description of what it accepts.

use std::fmt;
use std::marker::PhantomData;
use std::ops::Bound;
use std::path::PathBuf;

use serde::Serialize;
use serde::de::value::StrDeserializer;
use serde::de::{DeserializeOwned, IntoDeserializer};
use serde_json::{Value as Json, json};
use toml::de::{DeInteger, DeValue};

use super::problem::{at_most, quoted, short};
use super::table::{Kind, Value, array};
use super::{Problem, schema};

/// Characters by which spreadsheets recognise a formula.
const FORMULA: [char; 4] = ['=', '+', '-', '@'];

/// Angle below which degrees may be meant as radians: a right angle is less. Usual angles have two or more decimals in
/// radians (20 degrees are 0.35, 75 are 1.309), small ones in degrees at most one.
const IN_DEGREES: f64 = 1.6;

/// Range of a number, and its unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    low: Bound<f64>,
    high: Bound<f64>,
    unit: &'static str,
    /// Plausible range of its magnitude, unless it is 0.
    plausible: Option<[f64; 2]>,
    /// True if numbers of at most one decimal are plausible below that range, too.
    tenths: bool,
}

impl Bounds {
    const fn new(low: Bound<f64>, high: Bound<f64>, unit: &'static str) -> Self {
        Self { low, high, unit, plausible: None, tenths: false }
    }

    /// Any finite number.
    pub(crate) const fn any(unit: &'static str) -> Self {
        Self::new(Bound::Unbounded, Bound::Unbounded, unit)
    }

    pub(crate) const fn positive(unit: &'static str) -> Self {
        Self::new(Bound::Excluded(0.0), Bound::Unbounded, unit)
    }

    /// Zero and above.
    pub(crate) const fn not_negative(unit: &'static str) -> Self {
        Self::new(Bound::Included(0.0), Bound::Unbounded, unit)
    }

    /// Between two limits that are themselves excluded.
    pub(crate) const fn inside(low: f64, high: f64, unit: &'static str) -> Self {
        Self::new(Bound::Excluded(low), Bound::Excluded(high), unit)
    }

    /// Between two limits that are themselves included.
    pub(crate) const fn between(low: f64, high: f64, unit: &'static str) -> Self {
        Self::new(Bound::Included(low), Bound::Included(high), unit)
    }

    /// Adds a plausible range, from toys to earth movers: numbers of another magnitude, 0 apart, are refused unless the
    /// scene allows them.
    pub(crate) const fn plausible(self, least: f64, most: f64) -> Self {
        Self { plausible: Some([least, most]), ..self }
    }

    /// Adds a plausible range of angles in degrees: what looks like radians is refused.
    pub(crate) const fn no_radians(self, most: f64) -> Self {
        Self { tenths: true, ..self.plausible(IN_DEGREES, most) }
    }

    fn contains(&self, value: f64) -> bool {
        use std::ops::RangeBounds;
        (self.low, self.high).contains(&value)
    }
}

impl fmt::Display for Bounds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let low = match self.low {
            Bound::Unbounded => None,
            Bound::Excluded(low) => Some(format!("above {}", short(low))),
            Bound::Included(low) => Some(format!("of at least {}", short(low))),
        };
        let high = match self.high {
            Bound::Unbounded => None,
            Bound::Excluded(high) => Some(format!("below {}", at_most(high))),
            Bound::Included(high) => Some(format!("at most {}", at_most(high))),
        };
        match (low, high) {
            (None, None) => write!(f, "a finite number")?,
            (Some(only), None) | (None, Some(only)) => write!(f, "a number {only}")?,
            (Some(low), Some(high)) => write!(f, "a number {low} and {high}")?,
        }
        if self.unit.is_empty() { Ok(()) } else { write!(f, " {}", self.unit) }
    }
}

impl Bounds {
    fn inside_or_complain(&self, number: f64, value: &Value<'_>) -> Option<f64> {
        if !(number.is_finite() && self.contains(number)) {
            return value.complain(Problem::out_of_range(number, &self.to_string()));
        }
        let (size, slack) = (number.abs(), value.slack());
        let is_tenth = self.tenths && (10.0 * size - (10.0 * size).round()).abs() < 1e-9;
        match self.plausible {
            Some(range @ [least, most])
                if number != 0.0 && !(is_tenth || (least / slack..=most * slack).contains(&size)) =>
            {
                value.complain(Problem::implausible(number, range, self.unit))
            }
            _ => Some(number),
        }
    }
}

impl Kind for Bounds {
    type Output = f64;

    fn wanted(&self) -> String {
        self.to_string()
    }

    fn read(&self, value: &Value<'_>) -> Option<f64> {
        let (number, text) = match value.value {
            DeValue::Float(float) => (float.as_str().parse::<f64>().ok(), float.to_string()),
            DeValue::Integer(integer) => (whole(integer).map(|whole| whole as f64), integer.to_string()),
            _ => return value.wrong_type(self),
        };
        match number {
            // 1e999 parses to infinity without an error.
            Some(number) if !number.is_infinite() || text.contains("inf") => self.inside_or_complain(number, value),
            _ => value.complain(Problem::too_large(&text, &self.wanted())),
        }
    }

    fn schema(&self) -> Json {
        let mut schema = json!({ "type": "number" });
        for (bound, included, excluded) in
            [(self.low, "minimum", "exclusiveMinimum"), (self.high, "maximum", "exclusiveMaximum")]
        {
            match bound {
                Bound::Included(limit) => schema[included] = limit.into(),
                Bound::Excluded(limit) => schema[excluded] = limit.into(),
                Bound::Unbounded => {}
            }
        }
        if let Some([least, most]) = self.plausible {
            schema["title"] = format!("{self}; from {} to {} is plausible", short(least), short(most)).into();
        }
        schema
    }
}

fn whole(integer: &DeInteger<'_>) -> Option<i128> {
    i128::from_str_radix(integer.as_str(), integer.radix()).ok()
}

/// A whole number within two limits, both included.
#[derive(Clone, Copy, Debug)]
pub(super) struct Whole<T>(u64, u64, PhantomData<T>);

impl<T> Whole<T> {
    pub(super) const fn least(least: u64) -> Self {
        Self::between(least, u64::MAX)
    }

    /// Both limits are accepted.
    pub(super) const fn between(least: u64, most: u64) -> Self {
        Self(least, most, PhantomData)
    }
}

impl<T: TryFrom<i128> + Serialize> Kind for Whole<T> {
    type Output = T;

    fn wanted(&self) -> String {
        let most = if self.1 == u64::MAX { String::new() } else { format!(" and at most {}", self.1) };
        format!("a whole number of at least {}{most}", self.0)
    }

    fn read(&self, value: &Value<'_>) -> Option<T> {
        let DeValue::Integer(integer) = value.value else { return value.wrong_type(self) };
        let number = whole(integer);
        if let Some(small) = number.filter(|&number| number < i128::from(self.0)) {
            return value.complain(Problem::too_small(small, self.0));
        }
        let too_large = || Problem::too_large(&integer.to_string(), &self.wanted());
        if self.1 < u64::MAX && number.is_some_and(|number| number > i128::from(self.1)) {
            return value.complain(Problem::new(format!("{integer} is too large"), format!("write {}", self.wanted())));
        }
        number.and_then(|number| T::try_from(number).ok()).or_else(|| value.complain(too_large()))
    }

    fn schema(&self) -> Json {
        let mut schema = json!({ "type": "integer", "minimum": self.0 });
        if self.1 < u64::MAX {
            schema["maximum"] = self.1.into();
        }
        schema
    }
}

/// A level difference in quotes, such as "0.5 dB"; read as a number of decibels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Decibels(pub(super) Bounds);

impl Decibels {
    /// A difference as it is written in a scene.
    pub(super) fn text(difference: f64) -> String {
        format!("{difference} dB")
    }
}

impl Kind for Decibels {
    type Output = f64;

    fn wanted(&self) -> String {
        format!("{} in quotes, such as \"0.5 dB\"", self.0)
    }

    fn read(&self, value: &Value<'_>) -> Option<f64> {
        let number = value.value.as_str().and_then(|text| text.trim().strip_suffix("dB"));
        let Some(number) = number.and_then(|number| number.trim().parse::<f64>().ok()) else {
            return value.wrong_type(self);
        };
        if !number.is_finite() {
            return value.complain(Problem::out_of_range(number, &self.wanted()));
        }
        self.0.inside_or_complain(number, value)
    }

    fn schema(&self) -> Json {
        json!({ "type": "string", "pattern": r"[0-9.]\s*dB\s*$" })
    }

    fn written(&self, difference: &f64) -> Json {
        Self::text(*difference).into()
    }
}

/// `true` or `false`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flag;

impl Kind for Flag {
    type Output = bool;

    fn wanted(&self) -> String {
        "true or false".to_owned()
    }

    fn read(&self, value: &Value<'_>) -> Option<bool> {
        value.value.as_bool().or_else(|| value.wrong_type(self))
    }

    fn schema(&self) -> Json {
        json!({ "type": "boolean" })
    }
}

/// A text in one line, possibly empty.
#[derive(Clone, Copy, Debug)]
pub(super) struct Text;

/// True for characters that break a line, control a terminal, or are not allowed in XML.
fn is_no_text(sign: char) -> bool {
    sign.is_control() || matches!(sign, '\u{fffe}' | '\u{ffff}')
}

impl Kind for Text {
    type Output = String;

    fn wanted(&self) -> String {
        "a text in quotes, in one line and without control characters".to_owned()
    }

    fn read(&self, value: &Value<'_>) -> Option<String> {
        let Some(text) = value.value.as_str() else { return value.wrong_type(self) };
        match text.chars().find(|&sign| is_no_text(sign)) {
            Some(sign) => {
                let wrong = format!("this text holds the control character U+{:04X}", u32::from(sign));
                value.complain(Problem::new(wrong, format!("write {}", self.wanted())))
            }
            None => Some(text.to_owned()),
        }
    }

    fn schema(&self) -> Json {
        json!({ "type": "string" })
    }
}

/// A name, possibly empty, that can be used in file names and in cells of tables.
#[derive(Clone, Copy, Debug)]
pub(super) struct Name;

impl Name {
    /// Most letters of a name: file names have room for as many bytes besides prefix and ending.
    const LETTERS: usize = 80;
}

impl Kind for Name {
    type Output = String;

    fn wanted(&self) -> String {
        format!("a text of at most {} letters in quotes, which does not begin with =, +, - or @", Self::LETTERS)
    }

    fn read(&self, value: &Value<'_>) -> Option<String> {
        let name = Text.read(value)?;
        let wrong = if name.starts_with(FORMULA) {
            "spreadsheets take a text that begins like this for a formula".to_owned()
        } else {
            match name.chars().count() {
                letters if letters > Self::LETTERS => format!("this name has {letters} letters"),
                _ => return Some(name),
            }
        };
        value.complain(Problem::new(wrong, format!("write {}", self.wanted())))
    }

    fn schema(&self) -> Json {
        json!({ "type": "string", "maxLength": Self::LETTERS, "pattern": "^[^=+@-]|^$" })
    }
}

/// The path of a file.
#[derive(Clone, Copy, Debug)]
pub(super) struct File;

impl Kind for File {
    type Output = PathBuf;

    fn wanted(&self) -> String {
        "the path of a file, relative to the scene, in quotes".to_owned()
    }

    fn read(&self, value: &Value<'_>) -> Option<PathBuf> {
        match value.value.as_str() {
            Some("") => value.complain(Problem::empty(&self.wanted())),
            Some(path) => Some(PathBuf::from(path)),
            None => value.wrong_type(self),
        }
    }

    fn schema(&self) -> Json {
        json!({ "type": "string", "minLength": 1 })
    }
}

/// A column of a table: its name or its number from 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Column;

impl Kind for Column {
    type Output = String;

    fn wanted(&self) -> String {
        "the name of a column in quotes, or its number from 1".to_owned()
    }

    fn read(&self, value: &Value<'_>) -> Option<String> {
        match value.value {
            DeValue::Integer(_) => Whole::<u64>::least(1).read(value).map(|number| number.to_string()),
            DeValue::String(name) if name.is_empty() => value.complain(Problem::empty(&self.wanted())),
            DeValue::String(name) if name == "0" => value.complain(Problem::too_small(0, 1)),
            DeValue::String(name) => Some(name.to_string()),
            _ => value.wrong_type(self),
        }
    }

    fn schema(&self) -> Json {
        json!({ "type": ["integer", "string"], "minimum": 1, "minLength": 1 })
    }
}

/// An array of columns.
#[derive(Clone, Copy, Debug)]
pub(super) struct Columns;

impl Kind for Columns {
    type Output = Vec<String>;

    fn wanted(&self) -> String {
        format!("an array of columns, [\"distance\", \"height\"] or [1, 2], each {}", Column.wanted())
    }

    fn read(&self, value: &Value<'_>) -> Option<Vec<String>> {
        value.each(&Column, self)
    }

    fn schema(&self) -> Json {
        array(&Column)
    }
}

/// Kind of a value that may be left out.
#[derive(Clone, Copy, Debug)]
pub(super) struct Optional<K>(pub(super) K);

impl<K: Kind> Kind for Optional<K> {
    type Output = Option<K::Output>;

    fn wanted(&self) -> String {
        self.0.wanted()
    }

    fn read(&self, value: &Value<'_>) -> Option<Option<K::Output>> {
        self.0.read(value).map(Some)
    }

    fn schema(&self) -> Json {
        self.0.schema()
    }
}

/// An array of numbers, at least one.
#[derive(Clone, Copy, Debug)]
pub(super) struct NumberList<K = Bounds>(pub(super) K);

impl<K: Kind> Kind for NumberList<K> {
    type Output = Vec<K::Output>;

    fn wanted(&self) -> String {
        format!("an array, [ ... ], each item {}", self.0.wanted())
    }

    fn read(&self, value: &Value<'_>) -> Option<Vec<K::Output>> {
        value.each(&self.0, self)
    }

    fn schema(&self) -> Json {
        array(&self.0)
    }
}

/// An array of exactly so many numbers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Exactly<const COUNT: usize>(pub(super) Bounds);

impl<const COUNT: usize> Kind for Exactly<COUNT>
where
    [f64; COUNT]: Serialize,
{
    type Output = [f64; COUNT];

    fn wanted(&self) -> String {
        let names: Vec<_> = ('a'..).take(COUNT).map(String::from).collect();
        format!("an array of {COUNT}, [{}], each {}", names.join(", "), self.0)
    }

    fn read(&self, value: &Value<'_>) -> Option<[f64; COUNT]> {
        if let Some(items) = value.items().filter(|items| items.len() != COUNT) {
            let wrong = format!("this has {} values", items.len());
            return value.complain(Problem::new(wrong, format!("write {COUNT} values")));
        }
        value.each(&self.0, self)?.try_into().ok()
    }

    fn schema(&self) -> Json {
        let mut schema = array(&self.0);
        (schema["minItems"], schema["maxItems"]) = (COUNT.into(), COUNT.into());
        schema
    }
}

/// One of the words that serde accepts as the variants of `T`.
#[derive(Clone, Copy, Debug)]
pub(super) struct OneOf<T> {
    /// Former words, each with what to write instead.
    former: &'static [[&'static str; 2]],
    words: PhantomData<T>,
}

impl<T: DeserializeOwned> OneOf<T> {
    pub(super) const fn new() -> Self {
        Self::instead_of(&[])
    }

    /// As [`Self::new`]; `former` words are refused with what to write instead of each.
    pub(super) const fn instead_of(former: &'static [[&'static str; 2]]) -> Self {
        Self { former, words: PhantomData }
    }

    fn parse(word: &str) -> Result<T, UnknownVariant> {
        let deserializer: StrDeserializer<'_, UnknownVariant> = word.into_deserializer();
        T::deserialize(deserializer)
    }

    pub(super) fn words() -> &'static [&'static str] {
        // No variant is called "": the error of serde carries the list.
        Self::parse("").err().map_or(&[], |refused| refused.0)
    }

    /// Schema of one table or another, depending on the word of the key `tag`.
    pub(super) fn tables(tag: &'static str, about: &str, table: fn(T) -> Json) -> Json {
        let alternative = |&word: &&str| Some(schema::tagged(tag, word, about, table(Self::parse(word).ok()?)));
        json!({ "oneOf": Self::words().iter().filter_map(alternative).collect::<Vec<_>>() })
    }
}

impl<T: DeserializeOwned + Serialize> Kind for OneOf<T> {
    type Output = T;

    fn wanted(&self) -> String {
        format!("one of {}", quoted(Self::words()))
    }

    fn read(&self, value: &Value<'_>) -> Option<T> {
        let Some(word) = value.value.as_str() else { return value.wrong_type(self) };
        Self::parse(word).map_or_else(
            |UnknownVariant(accepted)| {
                let former = self.former.iter().find(|[former, _]| *former == word);
                value.complain(former.map_or_else(
                    || Problem::not_a_choice(word, accepted),
                    |[_, instead]| Problem::former_choice(word, instead),
                ))
            },
            Some,
        )
    }

    fn schema(&self) -> Json {
        json!({ "type": "string", "enum": Self::words() })
    }
}

/// Serde's error about an unknown variant: the list of the known ones.
#[derive(Debug, thiserror::Error)]
#[error("one of {}", quoted(.0))]
struct UnknownVariant(&'static [&'static str]);

impl serde::de::Error for UnknownVariant {
    fn custom<T: fmt::Display>(_message: T) -> Self {
        Self(&[])
    }

    fn unknown_variant(_variant: &str, expected: &'static [&'static str]) -> Self {
        Self(expected)
    }
}
