//! Agreement of the schema with the reader.

use serde_json::{Value, json};
use toml::Table;

use super::super::schema::{Section, sections};
use super::super::{DEFAULT, PLATE, Scene};
use super::files::scenes;
use super::{BASE, complaints};

/// True if a value fits a schema, by the keywords that schemas of scenes use.
pub(super) fn fits(value: &Value, schema: &Value) -> bool {
    let beyond = |limit: &Value, wrong: fn(f64, f64) -> bool| {
        value.as_f64().zip(limit.as_f64()).is_some_and(|(value, limit)| wrong(value, limit))
    };
    let table = value.as_object();
    let (items, alternatives) =
        (value.as_array(), |of: &Value| of.as_array().unwrap().iter().filter(|schema| fits(value, schema)).count());
    let is = |kind: &Value| match kind.as_str().unwrap() {
        "number" => value.is_number(),
        "integer" => value.is_u64() || value.is_i64(),
        "boolean" => value.is_boolean(),
        "string" => value.is_string(),
        "array" => value.is_array(),
        "object" => value.is_object(),
        other => panic!("a type {other}"),
    };
    schema.as_object().unwrap().iter().all(|(word, of)| match word.as_str() {
        "$schema" | "title" | "description" | "default" => true,
        "type" => of.as_array().map_or_else(|| is(of), |kinds| kinds.iter().any(is)),
        "const" => value == of,
        "enum" => of.as_array().unwrap().contains(value),
        "minimum" => !beyond(of, |value, limit| value < limit),
        "exclusiveMinimum" => !beyond(of, |value, limit| value <= limit),
        "maximum" => !beyond(of, |value, limit| value > limit),
        "exclusiveMaximum" => !beyond(of, |value, limit| value >= limit),
        "multipleOf" => !beyond(of, |value, unit| value % unit != 0.0),
        "pattern" if of.as_str().unwrap().contains("dB") => value.as_str().is_some_and(|text| text.ends_with("dB")),
        "pattern" => value.as_str().is_some_and(|text| !text.starts_with(['=', '+', '-', '@'])),
        "maxLength" => value.as_str().is_none_or(|text| text.chars().count() as u64 <= of.as_u64().unwrap()),
        "minLength" => value != "",
        "minItems" => items.is_none_or(|items| items.len() as u64 >= of.as_u64().unwrap()),
        "maxItems" => items.is_none_or(|items| items.len() as u64 <= of.as_u64().unwrap()),
        "items" => items.is_none_or(|items| items.iter().all(|item| fits(item, of))),
        "anyOf" => alternatives(of) > 0,
        "oneOf" => alternatives(of) == 1,
        "properties" => {
            table.is_none_or(|table| table.iter().all(|(key, value)| of.get(key).is_none_or(|of| fits(value, of))))
        }
        "required" => {
            table.is_none_or(|table| of.as_array().unwrap().iter().all(|key| table.contains_key(key.as_str().unwrap())))
        }
        "additionalProperties" => {
            assert_eq!(of, false);
            table.is_none_or(|table| table.keys().all(|key| schema["properties"].get(key).is_some()))
        }
        other => panic!("a schema with {other}"),
    })
}

/// A scene's text as the schema validates it.
fn as_json(text: &str) -> Value {
    json!(toml::from_str::<Table>(text).unwrap())
}

fn keys<'a>(section: &Section<'a>) -> impl Iterator<Item = (&'a String, &'a Value)> {
    section.schema["properties"].as_object().unwrap().iter()
}

/// A scene of one table only, with one key beside the word that chooses its kind.
fn alone(key: &str, value: toml::Value, section: &Section<'_>, all: &[Section<'_>]) -> Table {
    let tags = keys(section).filter_map(|(tag, of)| Some((tag.clone(), of.get("const")?.as_str()?.into())));
    let table = tags.chain([(key.to_owned(), value)]).collect();
    let Some(name) = section.path.rsplit('.').next().filter(|name| !name.is_empty()) else { return table };
    let around = section.path[..section.path.len() - name.len()].trim_end_matches('.');
    let around = all.iter().find(|other| other.path == around && keys(other).any(|(key, _)| key == name)).unwrap();
    let table = toml::Value::Table(table);
    alone(name, if section.repeated { toml::Value::Array(vec![table]) } else { table }, around, all)
}

#[test]
fn every_table_of_the_schema_has_the_keys_that_its_reader_knows() {
    let schema = Scene::json_schema();
    let all = sections(&schema);
    for section in &all {
        let text = alone("stranger", 1.into(), section, &all).to_string();
        let found = complaints(&text);
        let unknown = found.iter().find(|complaint| complaint.key.ends_with("stranger")).unwrap();
        let mut known: Vec<_> = unknown.right.strip_prefix("known keys: ").unwrap().split(", ").collect();
        known.sort_unstable();
        assert_eq!(known, keys(section).map(|(key, _)| key).collect::<Vec<_>>(), "{text}");
        for (key, of) in keys(section) {
            let said = ["title", "description"].map(|word| of[word].as_str().unwrap());
            // Links are for the library's documentation.
            assert!(said.iter().all(|text| !text.is_empty() && !text.contains("[`")), "{key}: {of}");
            assert!(of.get("default").is_none_or(|default| fits(default, of)), "{key}: {of}");
        }
    }
    // Every table that a scene can have, each kind of road separately.
    assert_eq!(all.len(), 36, "{:?}", all.iter().map(|section| &section.path).collect::<Vec<_>>());
}

#[test]
fn what_the_schema_refuses_the_reader_refuses() {
    let schema = Scene::json_schema();
    let all = sections(&schema);
    let mut tried = 0;
    for section in &all {
        for (key, of) in keys(section).filter(|(_, of)| of.get("const").is_none()) {
            let limits = ["minimum", "exclusiveMinimum", "maximum", "exclusiveMaximum"];
            let limits = limits.into_iter().filter_map(|limit| of.get(limit)?.as_f64());
            let near = limits.flat_map(|limit| [limit, limit - 1.0, limit + 1.0]).map(toml::Value::Float);
            let others =
                [true.into(), 1.5.into(), (-1).into(), "".into(), "no word".into(), toml::Value::Array(vec![])];
            for value in near.chain(others).filter(|value| !fits(&json!(value), of)) {
                let text = alone(key, value, section, &all).to_string();
                // A tyre given as text is the path of its file.
                let refused = |complaint: &super::Complaint| complaint.key.rsplit('.').next() == Some(key.as_str());
                assert!(complaints(&text).iter().any(refused), "{text}");
                tried += 1;
            }
        }
    }
    assert!(tried > 500, "{tried}");
}

#[test]
fn the_schema_takes_every_shipped_scene() {
    let schema = Scene::json_schema();
    let shipped =
        scenes().into_iter().map(|path| (Scene::load(&path).unwrap(), std::fs::read_to_string(path).unwrap()));
    let embedded = [DEFAULT, PLATE, BASE].map(|text| (Scene::from_str(text, "test").unwrap(), text.to_owned()));
    for (loaded, text) in shipped.chain(embedded) {
        let whole = loaded.scene.to_toml().unwrap();
        assert!(fits(&as_json(&text), &schema) && fits(&as_json(&whole), &schema), "{text}\n{whole}");
        let misspelt = text.replace("speed_kmh", "speed");
        assert!(!fits(&as_json(&misspelt), &schema), "{misspelt}");
    }
}
