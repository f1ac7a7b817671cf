//! `tyrewave keys`: every key that a scene may have.

use std::collections::BTreeSet;

use crate::results::table::{Report, words};
use crate::scene::Scene;
use crate::scene::schema::{Section, sections};
use clap::Args;
use serde_json::Value;

use super::context::{Context, print};
use super::error::CliError;

const EXAMPLES: &str = "\
A key that must be given is marked \"needed\". tyrewave check SCENE shows whether the values of a scene fit together.

Editors that know JSON Schemas of TOML files (taplo, Even Better TOML) complete and check scenes whose first line is
#:schema ./scene.schema.json

Examples:
  tyrewave keys
  tyrewave keys road
  tyrewave keys tyre.layers
  tyrewave keys rolling.speed_kmh
  tyrewave keys --schema > scene.schema.json";

/// Arguments of `tyrewave keys`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct KeysArguments {
    /// Only this table and those in it, such as rolling or tyre.layers, or one key, such as rolling.speed_kmh.
    pub section: Option<String>,
    /// Print all of it as a JSON Schema (draft 2020-12).
    #[arg(long, conflicts_with = "section")]
    pub schema: bool,
}

impl KeysArguments {
    /// Prints the keys; a table or key that scenes do not have is a [`CliError::Usage`].
    pub(crate) fn execute(self, context: &Context) -> Result<(), CliError> {
        if self.schema {
            print(&format!("{:#}\n", Scene::json_schema()))
        } else {
            context.print_report(&report(self.section.as_deref())?)
        }
    }
}

/// Keys of all tables, or of one of them and those within it, or one key.
fn report(wanted: Option<&str>) -> Result<Report, CliError> {
    let schema = Scene::json_schema();
    let all = sections(&schema);
    let mut report = Report::default();
    let mut add = |section: Section<'_>, key: Option<&str>| {
        let rows: Vec<_> =
            rows(section.schema).into_iter().filter(|[name, ..]| key.is_none_or(|key| name == key)).collect();
        if rows.is_empty() && key.is_some() {
            return;
        }
        report.titled(format!("{}\n\n", heading(&section)), words(["key", "value", "default", "meaning"], rows));
        report.text("\n");
    };
    let within = |path: &str, name: &str| path == name || path.starts_with(&format!("{name}."));
    let paths = all.iter().map(|section| section.path.clone()).filter(|path| !path.is_empty());
    let names = Vec::from_iter(BTreeSet::from_iter(paths));
    match wanted {
        Some(name) if !names.iter().any(|path| within(path, name)) => {
            // No table: a key of one, or of the scene itself.
            let (table, key) = name.rsplit_once('.').unwrap_or(("", name));
            all.into_iter().filter(|section| section.path == table).for_each(|section| add(section, Some(key)));
            if report.parts().is_empty() {
                let names = names.join(", ");
                return Err(CliError::Usage(format!("scenes have no table or key \"{name}\"; their tables: {names}")));
            }
        }
        Some(name) => {
            all.into_iter().filter(|section| within(&section.path, name)).for_each(|section| add(section, None))
        }
        None => all.into_iter().for_each(|section| add(section, None)),
    }
    Ok(report)
}

/// Name of a table as a scene has it, and its meaning.
fn heading(Section { path, repeated, schema }: &Section<'_>) -> String {
    let name = match (path.as_str(), repeated) {
        ("", _) => "scene".to_owned(),
        (path, false) => format!("[{path}]"),
        (path, true) => format!("[[{path}]]"),
    };
    let tags = schema["properties"].as_object().into_iter().flatten();
    let tags = tags.filter_map(|(key, of)| Some(format!(" {key} = {}", of.get("const")?)));
    format!("{name}{}: {}", tags.collect::<String>(), schema["description"].as_str().unwrap_or_default())
}

/// Keys of a table: name, form, default, meaning.
fn rows(schema: &Value) -> Vec<[String; 4]> {
    let keys = schema["properties"].as_object().into_iter().flatten();
    let needed = |key: &str| schema["required"].as_array().is_some_and(|keys| keys.iter().any(|name| name == key));
    let text = |of: &Value, name: &str| of[name].as_str().unwrap_or_default().to_owned();
    keys.map(|(key, of)| {
        let default = of.get("default").map_or_else(String::new, Value::to_string);
        let default = if needed(key) { "needed".to_owned() } else { default };
        [key.clone(), text(of, "title"), default, text(of, "description")]
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_listed_with_those_in_it_and_no_others() {
        let text = report(Some("tyre.layers")).unwrap().within(80);
        let headings: Vec<_> = text.lines().filter(|line| line.starts_with('[')).collect();
        let begins =
            ["[[tyre.layers]]: ", "[[tyre.layers.cords]]: ", "[tyre.layers.material]: ", "[tyre.layers.orthotropic]: "];
        assert_eq!(headings.len(), begins.len(), "{text}");
        assert!(headings.iter().zip(begins).all(|(heading, begin)| heading.starts_with(begin)), "{headings:?}");
        assert!(text.contains("thickness") && text.contains("needed") && text.contains("\"power-law\""), "{text}");
        assert!(!text.contains("contact_width") && text.lines().all(|line| line.chars().count() <= 80), "{text}");
        assert!(report(None).unwrap().to_string().contains("[road] kind = \"made\": "));
        for wanted in [None, Some("receiver"), Some("road")] {
            let text = report(wanted).unwrap().within(80);
            assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
        }
        let key = report(Some("rolling.speed_kmh")).unwrap().to_string();
        assert!(key.starts_with("[rolling]: ") && key.contains("km/h") && !key.contains("warm_up"), "{key}");
        assert!(report(Some("title")).unwrap().to_string().starts_with("scene: "));
        assert_eq!(report(Some("road.file")).unwrap().parts().len(), 9, "of three kinds of road");
        let error = report(Some("tyre.layer")).unwrap_err();
        assert!(error.exit_code() == 2 && error.to_string().contains("tyre.layers"), "{error}");
    }
}
