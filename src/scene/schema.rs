//! JSON Schema of a scene, assembled from its keys, table by table.

use serde_json::{Map, Value, json};

use super::document::join;
use super::table::Kind;

/// One table of a schema.
#[derive(Clone, Debug)]
pub struct Section<'a> {
    /// Path of the table, such as `tyre.layers`; empty for the scene itself.
    pub path: String,
    /// True if there may be several of it.
    pub repeated: bool,
    /// Schema of the table itself.
    pub schema: &'a Value,
}

/// All tables of a schema, each before those within it; a table whose keys depend on a word in it once for each word.
pub fn sections(schema: &Value) -> Vec<Section<'_>> {
    let mut sections = Vec::new();
    collect(String::new(), false, schema, &mut sections);
    sections
}

fn collect<'a>(path: String, repeated: bool, schema: &'a Value, sections: &mut Vec<Section<'a>>) {
    for alternative in ["anyOf", "oneOf"].into_iter().filter_map(|key| schema[key].as_array()).flatten() {
        collect(path.clone(), repeated, alternative, sections);
    }
    if schema["items"].is_object() {
        collect(path.clone(), true, &schema["items"], sections);
    }
    if let Some(keys) = schema["properties"].as_object() {
        sections.push(Section { path: path.clone(), repeated, schema });
        keys.iter().for_each(|(name, key)| collect(join(&path, name), false, key, sections));
    }
}

/// Schema of a table, each key with its description and whether it must be given; it accepts no other keys.
pub(super) fn table<const COUNT: usize>(about: &str, keys: [(&str, &str, (Value, bool)); COUNT]) -> Value {
    let required: Vec<&str> = keys.iter().filter(|(_, _, (_, required))| *required).map(|(name, ..)| *name).collect();
    let described = |(name, about, (mut key, _)): (&str, &str, (Value, bool))| {
        key["description"] = plain(about).into();
        (name.to_owned(), key)
    };
    json!({
        "type": "object",
        "description": plain(about),
        "properties": keys.into_iter().map(described).collect::<Map<_, _>>(),
        "required": required,
        "additionalProperties": false,
    })
}

/// Schema of a key, and whether it must be given, which is so without a default.
pub(super) fn key<T>(kind: &impl Kind<Output = T>, default: Option<T>) -> (Value, bool) {
    let mut schema = kind.schema();
    if schema["title"].is_null() {
        schema["title"] = kind.wanted().into();
    }
    let written = default.as_ref().map(|default| kind.written(default));
    // Tables have the defaults of their keys; an absent list is not an empty array, which would be refused.
    if let Some(written) = written.filter(|written| !written.is_null() && !written.is_object() && *written != json!([]))
    {
        schema["default"] = written;
    }
    (schema, default.is_none())
}

/// Schema of a table that is chosen by a word at the key `key`.
pub(super) fn tagged(key: &str, word: &str, about: &str, mut table: Value) -> Value {
    table["properties"][key] = json!({ "const": word, "title": format!("\"{word}\""), "description": about });
    if let Some(required) = table["required"].as_array_mut() {
        required.push(key.into());
    }
    table
}

/// A doc comment as one line of plain text.
fn plain(comment: &str) -> String {
    comment.trim().replace("  ", " ").replace("\\[", "[").replace("\\]", "]")
}
