//! Keys for the conditioning of measured heights, whatever their file format.

use serde::{Deserialize, Serialize};
use serde_json::{Value as Json, json};
use toml::de::DeValue;

use crate::scene::Problem;
use crate::scene::kind::Bounds;
use crate::scene::table::{Kind, Value};

/// A value that marks a missing height.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(untagged)]
pub enum MissingHeight {
    /// A number in the file's unit of heights.
    Number(f64),
    /// A word in a table of text.
    Word(String),
}

/// Mean or plane that is subtracted from all heights of a road.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Levelling {
    /// Mean and least-squares slope, along and across.
    #[default]
    Slope,
    /// The mean alone.
    Mean,
    /// Nothing.
    Off,
}

/// Values that mark missing heights: one, or an array that may be empty.
#[derive(Clone, Copy, Debug)]
pub(super) struct MissingHeights;

const HEIGHT: Bounds = Bounds::any("the file's unit of heights");

impl MissingHeights {
    fn one(self, value: &Value<'_>) -> Option<MissingHeight> {
        match value.value {
            DeValue::String(word) if word.trim().is_empty() => value.complain(Problem::empty(&self.wanted())),
            DeValue::String(word) => Some(MissingHeight::Word(word.trim().to_owned())),
            DeValue::Float(_) | DeValue::Integer(_) => HEIGHT.read(value).map(MissingHeight::Number),
            _ => value.wrong_type(&self),
        }
    }
}

impl Kind for MissingHeights {
    type Output = Vec<MissingHeight>;

    fn wanted(&self) -> String {
        "a number in the file's unit of heights, a word in quotes, or an array of them".to_owned()
    }

    fn read(&self, value: &Value<'_>) -> Option<Vec<MissingHeight>> {
        match value.items() {
            // All items are read before the first failure counts, so that every bad one is reported.
            Some(items) => items.iter().map(|item| self.one(item)).collect::<Vec<_>>().into_iter().collect(),
            None => self.one(value).map(|missing| vec![missing]),
        }
    }

    fn schema(&self) -> Json {
        let one = json!({ "type": ["number", "string"] });
        json!({ "type": ["number", "string", "array"], "items": one })
    }
}
