//! `tyrewave keys`: every key that a scene may have.

use clap::Args;
use serde_json::Value;
use tyrewave::results::table::{Report, words};
use tyrewave::scene::Scene;
use tyrewave::scene::schema::{Section, sections};

use super::context::{Context, print};
use super::error::CliError;

const EXAMPLES: &str = "\
A key without a default that must be given is marked \"needed\". What has to fit together beyond that, a scene is told \
when it is loaded: tyrewave plan SCENE.

Editors that know JSON Schemas of TOML files (taplo, Even Better TOML) complete and check scenes whose first line is
#:schema ./scene.schema.json

Examples:
  tyrewave keys
  tyrewave keys road
  tyrewave keys tyre.layers
  tyrewave keys --schema > scene.schema.json";

/// Arguments of `tyrewave keys`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct KeysArguments {
    /// Only this table and those in it, such as rolling or tyre.layers.
    pub section: Option<String>,
    /// Print all of it as a JSON Schema (draft 2020-12).
    #[arg(long, conflicts_with = "section")]
    pub schema: bool,
}

impl KeysArguments {
    /// Prints the keys.
    ///
    /// # Errors
    /// [`CliError::Usage`] for a table that scenes do not have.
    pub fn execute(self, context: &Context) -> Result<(), CliError> {
        if self.schema {
            print(&format!("{:#}\n", Scene::json_schema()))
        } else {
            context.print_report(&report(self.section.as_deref())?)
        }
    }
}

/// The keys of a scene's tables, or of one of them and those in it.
fn report(wanted: Option<&str>) -> Result<Report, CliError> {
    let schema = Scene::json_schema();
    let mut all = sections(&schema);
    if let Some(name) = wanted {
        let mut names: Vec<_> =
            all.iter().map(|section| section.path.clone()).filter(|path| !path.is_empty()).collect();
        names.sort_unstable();
        names.dedup();
        all.retain(|section| section.path == name || section.path.starts_with(&format!("{name}.")));
        if all.is_empty() {
            let names = names.join(", ");
            return Err(CliError::Usage(format!("scenes have no table \"{name}\"; they have: {names}")));
        }
    }
    let mut report = Report::default();
    for section in all {
        report.text(format!("{}\n\n", heading(&section)));
        report.table(words(["key", "what stands there", "default", "what it means"], rows(section.schema)));
        report.text("\n");
    }
    Ok(report)
}

/// A table's name as a scene has it, and what it means.
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

/// Its keys: name, what has to stand there, default, meaning.
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
        assert_eq!(headings.len(), 2, "{text}");
        assert!(headings[0].starts_with("[[tyre.layers]]: ") && headings[1].starts_with("[tyre.layers.material]: "));
        assert!(text.contains("thickness") && text.contains("needed") && text.contains("\"power-law\""), "{text}");
        assert!(!text.contains("circumference") && text.lines().all(|line| line.chars().count() <= 80), "{text}");
        assert!(report(None).unwrap().to_string().contains("[road] kind = \"made\": "));
        let error = report(Some("tyre.layer")).unwrap_err();
        assert!(error.exit_code() == 2 && error.to_string().contains("tyre.layers"), "{error}");
    }
}
