//! Settings from a command line, which replace those of a scene.

use std::path::Path;
use std::sync::Arc;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::document::Document;
use super::problem::{Diagnostic, SourceText};
use super::{Problem, SceneError};
use crate::storage::input::beginning;

pub(super) const TYRE: &str = "tyre";
/// Keys on which the other keys of a table depend: one in any table, and one in `[contact]` with its default.
const KIND: &str = "kind";
const ZONE: (&str, &str) = ("contact.zone", "slices");
/// Most letters of a setting that a message quotes.
const MOST_QUOTED: usize = 200;
/// Most parts of a key: no table of a scene is as deep.
const MOST_STEPS: usize = 16;
const NOT_GIVEN: &str = "leave the setting out, or correct the key's name";
const NO_PLACE: &str = "name a key of a table, or an item that the scene's array has: the first is [0]; a whole array, \
                        such as receiver=[{ standard = \"cpx\" }], can be set, too";

/// A key of a scene and its new value; without a value the key is removed.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    key: String,
    steps: Vec<Step>,
    /// The value as TOML, named after its key; empty to remove the key.
    source: Arc<SourceText>,
    /// The value as given if it is not TOML.
    plain: Option<String>,
}

/// One step of a key's path.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Step {
    Key(String),
    Item(usize),
}

impl Setting {
    /// Parses a text such as `rolling.speed_kmh=110`, `receiver[0].height = 1.5` or `numerics.preset=draft`: items from
    /// 0, values as in TOML; a value that is not TOML is taken as text. `numerics.elements=` removes the key from the
    /// scene.
    ///
    /// # Errors
    /// A message, for a text without `=` and for an invalid path.
    pub fn parse(text: &str) -> Result<Self, String> {
        let reported = beginning(text, MOST_QUOTED);
        let form = || format!("\"{reported}\" is not a setting: give it as KEY=VALUE, such as rolling.speed_kmh=110");
        let (key, value) = text.split_once('=').ok_or_else(form)?;
        let (key, value) = (key.trim().to_owned(), value.trim());
        let steps = steps(&key).ok_or_else(form)?;
        if steps.len() > MOST_STEPS {
            return Err(format!(
                "\"{reported}\" has a key of {} parts: no scene has one of more than {MOST_STEPS}",
                steps.len()
            ));
        }
        let plain = (!value.is_empty() && DeValue::parse(value).is_err()).then(|| value.to_owned());
        let text = plain.as_deref().map_or_else(|| value.to_owned(), |text| toml::Value::from(text).to_string());
        Ok(Self { steps, source: Arc::new(SourceText { name: format!("--set {key}"), text }), key, plain })
    }

    /// The key as given, such as `receiver[0].height`.
    pub fn key(&self) -> &str {
        &self.key
    }

    /// The value as given, a text without its quotes.
    pub fn value(&self) -> &str {
        let text = self.plain.as_deref().unwrap_or(&self.source.text);
        text.strip_prefix('"').and_then(|text| text.strip_suffix('"')).unwrap_or(text)
    }

    /// The value as given if it is not TOML: a text without quotes.
    pub fn plain_text(&self) -> Option<&str> {
        self.plain.as_deref()
    }

    /// The setting of a tyre or a road that names its file.
    pub(crate) fn file(key: &str, file: &Path) -> Self {
        let text = toml::Value::from(file.to_string_lossy().as_ref()).to_string();
        let source = Arc::new(SourceText { name: format!("--set {key}"), text });
        let steps = key.split('.').map(|part| Step::Key(part.to_owned())).collect();
        Self { steps, key: key.to_owned(), source, plain: None }
    }

    /// True if it sets the tyre as a whole, which may be a file.
    pub(super) fn is_tyre(&self) -> bool {
        self.key == TYRE
    }

    /// True if it sets the kind of a table, on which the table's other keys depend.
    pub(super) fn is_kind(&self) -> bool {
        self.key == ZONE.0 || self.key.rsplit_once('.').is_some_and(|(_, key)| key == KIND)
    }

    /// Clears a table that changes its kind: its keys belong to the former kind.
    fn begin_anew<'a>(&'a self, value: &DeValue<'a>, root: &mut DeTable<'a>, document: &mut Document) {
        let Some((table, key)) = self.key.split_once('.').filter(|_| self.is_kind()) else { return };
        let Some(DeValue::Table(entries)) = root.get_mut(table).map(Spanned::get_mut) else { return };
        let default = (self.key == ZONE.0).then_some(ZONE.1);
        let kind = entries.get(key).map_or(default, |kind| kind.get_ref().as_str());
        if kind.is_some() && kind != value.as_str() {
            entries.clear();
            document.forget(table);
        }
    }

    /// Puts the value into a scene's tree and records its place; missing tables on the path are made. A key without a
    /// value is removed.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] if the path leads through something that is not a table, or to an item that does not
    /// exist, or if a key to be removed does not exist.
    pub(super) fn apply<'a>(&'a self, root: &mut DeTable<'a>, document: &mut Document) -> Result<(), SceneError> {
        let invalid = |problem| {
            let span = 0..self.source.text.len();
            let diagnostic = Diagnostic { source: Arc::clone(&self.source), key: self.key.clone(), span, problem };
            SceneError::invalid(vec![diagnostic], 0)
        };
        if self.source.text.is_empty() {
            if !remove(root, &self.steps) {
                return Err(invalid(Problem::new("the scene does not give this key", NOT_GIVEN)));
            }
            document.remove(&self.key);
            return Ok(());
        }
        let no_toml = |error: toml::de::Error| invalid(Problem::new(error.message(), "write it as TOML"));
        let value = DeValue::parse(&self.source.text).map_err(no_toml)?;
        self.begin_anew(value.get_ref(), root, document);
        document.set(&self.source, &self.key, &value);
        match place(root, &self.steps) {
            Some(place) => *place = value,
            None => return Err(invalid(Problem::new("there is no such place in the scene", NO_PLACE))),
        }
        Ok(())
    }
}

/// Splits a path into its steps; `None` if a part is empty or an index is not a number.
fn steps(key: &str) -> Option<Vec<Step>> {
    let mut steps = Vec::new();
    for part in key.split('.') {
        let mut rest = part.split('[');
        let name = rest.next().map(str::trim).filter(|name| !name.is_empty())?;
        steps.push(Step::Key(name.to_owned()));
        for item in rest {
            steps.push(Step::Item(item.strip_suffix(']')?.trim().parse().ok()?));
        }
    }
    Some(steps)
}

/// The value that a path leads to, in a tree of tables and arrays. Its last key, and tables on the path, are made if
/// missing; `None` for a path through anything else.
fn place<'t, 'a>(root: &'t mut DeTable<'a>, steps: &'a [Step]) -> Option<&'t mut Spanned<DeValue<'a>>> {
    let (Step::Key(first), rest) = steps.split_first()? else { return None };
    let made = || Spanned::new(0..0, DeValue::Table(DeTable::new()));
    let key = |name: &'a str| Spanned::new(0..0, name.into());
    let mut at = root.entry(key(first)).or_insert_with(made);
    for step in rest {
        at = match (at.get_mut(), step) {
            (DeValue::Table(table), Step::Key(name)) => table.entry(key(name)).or_insert_with(made),
            (DeValue::Array(items), Step::Item(item)) => items.get_mut(*item)?,
            _ => return None,
        };
    }
    Some(at)
}

/// Removes the key at the end of a path from its table; false if it did not exist.
fn remove(root: &mut DeTable<'_>, steps: &[Step]) -> bool {
    let Some((Step::Key(last), path)) = steps.split_last() else { return false };
    let mut steps = path.iter();
    let table = match steps.next() {
        None => root,
        Some(Step::Item(_)) => return false,
        Some(Step::Key(first)) => {
            let found = steps.try_fold(root.get_mut(first.as_str()), |at, step| {
                Some(match (at?.get_mut(), step) {
                    (DeValue::Table(table), Step::Key(name)) => table.get_mut(name.as_str()),
                    (DeValue::Array(items), Step::Item(item)) => items.get_mut(*item),
                    _ => None,
                })
            });
            match found.flatten().map(Spanned::get_mut) {
                Some(DeValue::Table(table)) => table,
                _ => return false,
            }
        }
    };
    table.remove(last.as_str()).is_some()
}

#[cfg(test)]
mod tests {
    use super::super::{DEFAULT, Scene};
    use super::*;

    fn set(texts: &[&str]) -> Result<super::super::LoadedScene, SceneError> {
        let settings: Vec<Setting> = texts.iter().map(|text| Setting::parse(text).unwrap()).collect();
        Scene::from_str_with(DEFAULT, "default", &settings)
    }

    #[test]
    fn settings_replace_and_add_to_what_the_scene_says() {
        let loaded = set(&[
            "rolling.speed_kmh=110",
            "numerics.preset=draft",
            "numerics.fmax=1000.0",
            "title = a new one",
            "tyre.layers[1].thickness = 0.011",
            "outputs.plots=false",
            "road = { kind = \"smooth\" }",
        ]);
        let loaded = loaded.unwrap();
        let scene = &loaded.scene;
        assert!((scene.rolling.speed_kmh - 110.0).abs() < 1e-12 && !scene.outputs.plots);
        assert!((scene.tyre.layers[1].thickness - 0.011).abs() < 1e-12);
        assert_eq!((scene.title.as_str(), scene.road.clone()), ("a new one", super::super::Road::Smooth));
        assert!(loaded.gives("numerics.preset") && loaded.gives("outputs.plots"));
    }

    #[test]
    fn a_road_of_another_kind_begins_anew_whatever_is_set_first() {
        let file = "road.file=stone.crg";
        for order in [["road.kind=opencrg", file], [file, "road.kind=opencrg"]] {
            let loaded = set(&order).unwrap();
            assert!(
                matches!(&loaded.scene.road, super::super::Road::OpenCrg(road) if road.file.ends_with("stone.crg"))
            );
            assert!(!loaded.gives("road.seed") && loaded.gives("road.file"));
        }
        let super::super::Road::Made(road) = set(&["road.kind=made"]).unwrap().scene.road else { panic!() };
        assert_eq!(road.seed, 1, "the same kind keeps what the scene says");
        let error = set(&["road.kind=opencrg"]).unwrap_err().render(false);
        assert!(error.contains("road.file: this key is missing") && !error.contains("road.seed"), "{error}");
        let error = set(&["road.kind=opencgr", file]).unwrap_err().render(false);
        assert!(error.contains("did you mean \"opencrg\"?"), "{error}");
    }

    #[test]
    fn a_contact_of_another_zone_begins_anew() {
        use super::super::{Slices, Zone};
        let cells = set(&["contact.cells_across=30", "contact.zone=cells"]).unwrap();
        assert_eq!((cells.scene.contact.zone, cells.scene.contact.cells_across), (Zone::Cells, Some(30)));
        assert!(!cells.gives("contact.slices"));
        let slices = set(&["contact.slices=half-space", "contact.zone=slices"]).unwrap();
        assert_eq!(slices.scene.contact.slices, Slices::HalfSpace);
        let error = set(&["contact.zone=cells", "contact.slices=half-space"]).unwrap_err().render(false);
        assert!(error.contains("contact.slices"), "{error}");
    }

    #[test]
    fn a_setting_without_a_value_takes_the_key_out() {
        let loaded = set(&["numerics.elements=", "title= ", "numerics.preset=draft", "numerics.fmax=1000"]).unwrap();
        assert!(!loaded.gives("numerics.elements") && loaded.gives("numerics.preset"));
        assert!(loaded.scene.title.is_empty() && !loaded.gives("title"));
        let layers = set(&["tyre.layers[1].cords="]).unwrap().scene.tyre.layers;
        assert!(layers[1].cords.is_empty());
        let error = set(&["rolling.speed_kmh="]).unwrap_err().render(false);
        assert!(error.contains("rolling.speed_kmh: this key is missing"), "{error}");
        for text in ["numerics.elemnts=", "tyre.layers[7].cords=", "tyre.layers[0]=", "no.such.table=", "title.x="] {
            let error = set(&[text]).unwrap_err().render(false);
            assert!(error.contains("does not give this key") && error.contains("leave the setting out"), "{error}");
        }
    }

    #[test]
    fn mistakes_are_reported_with_their_setting() {
        for (text, reported) in [
            ("rolling.speed_kmh=-3", "--set rolling.speed_kmh:1:1"),
            ("rolling.sped_kmh=30", "speed_kmh"),
            ("rolling.speed_kmh=fast", "\"fast\""),
            ("rolling.speed_kmh.x=1", "no such place"),
            ("tyre.layers[7].thickness=1", "no such place"),
        ] {
            let error = set(&[text]).unwrap_err().render(false);
            assert!(error.contains("--set ") && error.contains(reported), "{text}: {error}");
        }
        for text in ["", "speed", "=3", "a..b=1", "a[x]=1", "a[0=1", ".a=1"] {
            assert!(Setting::parse(text).is_err(), "{text}");
        }
        for text in [format!("{}=1", vec!["a"; 16_000].join(".")), format!("a{}=1", "[0]".repeat(16_000))] {
            let reported = Setting::parse(&text).unwrap_err();
            assert!(reported.contains("more than 16") && reported.len() < 400, "{reported}");
        }
    }
}
