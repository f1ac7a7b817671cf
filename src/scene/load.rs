//! From a file or a text to a checked scene.
//!
//! 1. The text is parsed into a tree that knows where each key and value stands; syntax errors end here.
//! 2. A tyre file is read and its table replaces the path; receivers given by a file follow after settings from the
//!    command line.
//! 3. The place of every key is recorded, for these and for later complaints.
//! 4. The tree is read key by key; all mistakes are collected.
//! 5. File paths are made absolute, from the scene's folder, which they may not leave unless [`Reach`] allows it.
//!
//! Settings that the scene leaves open keep their default here: the plan decides about them, and asks
//! [`LoadedScene::gives`].

use std::path::{Path, PathBuf};
use std::sync::Arc;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::document::{Complaints, Document, join};
use super::problem::SourceText;
use super::receiver_file::ReceiverFiles;
use super::schema::{Section, sections};
use super::setting::{Setting, TYRE};
use super::table::{Keys, Table};
use super::{DEFAULT, Diagnostic, Law, Problem, Scene, SceneError, consistency};
use crate::numeric::digest::sha256;
use crate::storage::input::{self, SCENE_BYTES};
use crate::storage::separated;

/// Most syntax errors that are reported; more of them are no help.
const MOST_SYNTAX_ERRORS: usize = 16;
/// Most tables that are named for a key which another one has: more are of a name that says little.
const MOST_ELSEWHERE: usize = 3;
/// Factor by which a scene that allows implausible numbers may go outside the plausible range: what is further off is
/// no tyre, and numbers that follow from it may overflow.
const IMPLAUSIBLE: f64 = 1e3;

/// Keys by which a tyre file is recognised: a scene does not have them.
const TYRE_KEYS: [&str; 2] = ["circumference", "layers"];
/// Table of a tyre file that belongs to the scene, not to the table of the tyre.
const PATTERN: &str = "tread_pattern";
const NO_TYRE_FILE: &str = "name a tyre file, relative to the scene, or give the table [tyre]";
const NO_FILE: &str = "give the table [tyre], as a run writes it";
const NO_ARRAY_FILE: &str = "name a file with the columns name,x,y,z, relative to the scene";
const OUTSIDE: &str = "copy it there, or let this scene name any file: --allow-outside";
const DUPLICATE: &str = "give each key and each [table] once; [[name]] begins one more item of an array";
const DECIMAL_COMMA: &str = "numbers have a decimal point, not a comma";
const NOT_TOML: &str = "write it as TOML: `key = value`, texts in quotes";
const NOT_CAUSAL: [&str; 2] = [
    "the law \"hysteretic\" is not causal: the tread would move before it is touched",
    "use \"power-law\", \"prony\" or \"elastic\" here; \"hysteretic\" serves frequency-domain results only",
];

/// Where the files named by a scene may be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Reach {
    /// In the scene's folder and below, after resolving links: a scene from an untrusted source opens nothing else.
    #[default]
    Folder,
    /// Anywhere.
    Anywhere,
    /// Settings recorded by a run: the road file may be anywhere; the tyre is a table in them and never a file.
    Recorded,
}

/// A checked scene and its origin.
#[derive(Clone, Debug)]
pub struct LoadedScene {
    /// The scene, its file paths absolute.
    pub scene: Scene,
    /// The scene's file as named by the caller; the given name for a scene that was not read from a file.
    pub path: PathBuf,
    /// Folder that the paths in the scene are relative to; empty for a scene that was not read from a file.
    pub folder: PathBuf,
    /// Files of the road and of the tread pattern as written.
    road_file: Option<PathBuf>,
    pattern_file: Option<PathBuf>,
    /// True if all settings are decided; all then count as given.
    settled: bool,
    document: Arc<Document>,
}

impl Scene {
    /// Reads and checks a scene file. The files that it names must lie in its folder or below.
    ///
    /// # Errors
    /// If the file cannot be read; [`SceneError::Invalid`] with all mistakes that could be found in it.
    pub fn load(path: impl AsRef<Path>) -> Result<LoadedScene, SceneError> {
        Self::load_with(path, &[], Reach::Folder)
    }

    /// Loads a scene as [`Self::load`], with settings replacing those of the scene; `reach` is where the files that it
    /// names may be. Paths among the settings are relative to the scene, too.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub(crate) fn load_with(
        path: impl AsRef<Path>,
        settings: &[Setting],
        reach: Reach,
    ) -> Result<LoadedScene, SceneError> {
        let path = path.as_ref();
        let text = read_text(path)?;
        let absolute = std::path::absolute(path).map_err(|source| SceneError::reading(path, source))?;
        let folder = absolute.parent().unwrap_or(&absolute).to_owned();
        LoadedScene::new(text, path.to_owned(), folder, settings, reach)
    }

    /// The default scene with the tyre of a file, with settings replacing its own.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub fn with_tyre(path: impl AsRef<Path>, settings: &[Setting]) -> Result<LoadedScene, SceneError> {
        let path = path.as_ref();
        let absolute = std::path::absolute(path).map_err(|source| SceneError::reading(path, source))?;
        let settings = [&[Setting::file(TYRE, &absolute)], settings].concat();
        let mut loaded = Self::from_str_with(DEFAULT, "default", &settings)?;
        loaded.scene.title = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Ok(loaded)
    }

    /// Checks a scene given as text; `name` takes the place of the file name in messages. Paths in it are used as they
    /// are.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] with all mistakes that could be found.
    pub fn from_str(text: &str, name: &str) -> Result<LoadedScene, SceneError> {
        Self::from_str_with(text, name, &[])
    }

    /// Reads a scene as [`Self::from_str`], with settings replacing those of the scene.
    ///
    /// # Errors
    /// As [`Self::from_str`].
    pub fn from_str_with(text: &str, name: &str, settings: &[Setting]) -> Result<LoadedScene, SceneError> {
        LoadedScene::new(text.to_owned(), PathBuf::from(name), PathBuf::new(), settings, Reach::Anywhere)
    }

    /// JSON Schema (draft 2020-12) of scene files: keys, types, bounds and words; each key has a `title`, which
    /// describes the accepted values, and a `description`. Conditions between keys are not in it; they are checked when
    /// a scene is loaded.
    pub fn json_schema() -> serde_json::Value {
        let mut schema = Self::schema();
        schema["$schema"] = "https://json-schema.org/draft/2020-12/schema".into();
        schema
    }

    /// The scene as TOML, every default spelt out; [`Scene::from_str`] reads it back to an equal scene.
    ///
    /// # Errors
    /// [`SceneError::NotToml`] for numbers or paths that TOML cannot hold.
    pub fn to_toml(&self) -> Result<String, SceneError> {
        toml::to_string(self).map_err(|source| SceneError::NotToml { source })
    }

    /// The scene as JSON, with the keys of the TOML file.
    ///
    /// # Errors
    /// [`SceneError::NotJson`] for paths that are not UTF-8.
    pub fn to_json(&self) -> Result<serde_json::Value, SceneError> {
        serde_json::to_value(self).map_err(|source| SceneError::NotJson { source })
    }
}

impl LoadedScene {
    /// Checks a scene that was assembled in a program, as if it had been written in a file.
    ///
    /// # Errors
    /// As [`Scene::to_toml`] and [`Scene::from_str`]; lines are those of the scene as TOML.
    pub fn from_scene(scene: &Scene, name: &str) -> Result<Self, SceneError> {
        Self::new(scene.to_toml()?, PathBuf::from(name), PathBuf::new(), &[], Reach::Anywhere)
    }

    /// Restores a scene that was loaded before from its settings as written and as used, both as TOML, and its origin.
    ///
    /// # Errors
    /// As [`Scene::from_str`].
    pub(crate) fn restored(written: &str, used: &str, path: PathBuf, folder: PathBuf) -> Result<Self, SceneError> {
        let used = Self::new(used.to_owned(), path.clone(), PathBuf::new(), &[], Reach::Recorded)?;
        let written = Self::new(written.to_owned(), path, PathBuf::new(), &[], Reach::Recorded)?;
        Ok(Self { scene: used.scene, folder, ..written })
    }

    /// Scene of the settings that a run has recorded, as TOML: no file is read, whatever they name.
    ///
    /// # Errors
    /// As [`Scene::from_str`]; also if the tyre is not a table.
    pub(crate) fn recorded(text: &str, name: &str) -> Result<Self, SceneError> {
        Self::new(text.to_owned(), PathBuf::from(name), PathBuf::new(), &[], Reach::Recorded)
    }

    /// Another scene in this one's folder, from a text and settings that may name files there.
    ///
    /// # Errors
    /// As [`Scene::from_str_with`].
    pub(crate) fn varied(&self, text: String, name: &str, settings: &[Setting]) -> Result<Self, SceneError> {
        Self::new(text, PathBuf::from(name), self.folder.clone(), settings, Reach::Anywhere)
    }

    /// True if a key is given, such as `numerics.elements`; all are if every setting is decided.
    pub(crate) fn gives(&self, key: &str) -> bool {
        self.settled || self.document.has(key)
    }

    /// This scene with settings that are all decided.
    #[must_use]
    pub(crate) fn settled(self, scene: Scene) -> Self {
        Self { scene, settled: true, ..self }
    }

    /// The scene as a TOML table of the given tables and keys, without the defaults.
    ///
    /// # Errors
    /// As [`Scene::to_toml`].
    pub(crate) fn given(&self) -> Result<toml::Table, SceneError> {
        let mut scene = toml::Table::try_from(&self.scene).map_err(|source| SceneError::NotToml { source })?;
        scene.retain(|name, _| self.gives(name));
        for (name, value) in &mut scene {
            if let toml::Value::Table(table) = value {
                table.retain(|key, _| self.gives(&format!("{name}.{key}")));
            }
        }
        Ok(scene)
    }

    /// Settings with paths as written in the file, as [`Scene::to_toml`].
    ///
    /// # Errors
    /// As [`Scene::to_toml`].
    pub(crate) fn written_toml(&self) -> Result<String, SceneError> {
        self.as_written().to_toml()
    }

    fn as_written(&self) -> Scene {
        let mut scene = self.scene.clone();
        if let (Some(file), Some(written)) = (scene.road.file_mut(), &self.road_file) {
            file.clone_from(written);
        }
        if let (Some(file), Some(written)) = (pattern_file(&mut scene), &self.pattern_file) {
            file.clone_from(written);
        }
        scene
    }

    /// The scene's name: its file name without the ending.
    pub fn name(&self) -> String {
        self.path.file_stem().unwrap_or(self.path.as_os_str()).to_string_lossy().into_owned()
    }

    /// Heading of results and plots: the scene's title, or its name if it has none; without control characters.
    pub fn title(&self) -> String {
        let title = if self.scene.title.is_empty() { self.name() } else { self.scene.title.clone() };
        // File names, and titles assembled in a program, may contain anything.
        title.replace(char::is_control, " ")
    }

    /// Settings with paths as written in the file, as [`Scene::to_json`].
    ///
    /// # Errors
    /// As [`Scene::to_json`].
    pub fn settings(&self) -> Result<serde_json::Value, SceneError> {
        self.as_written().to_json()
    }

    /// Hash of the settings: the same for two scenes that differ only in formatting, comments, folder, omitted
    /// defaults, or in whether the tyre has its own file.
    ///
    /// # Errors
    /// As [`Scene::to_json`].
    pub fn hash(&self) -> Result<String, SceneError> {
        Ok(settings_hash(&self.settings()?))
    }

    /// Complaint of a later stage about a key, such as `road.file` or `tyre.layers[1].thickness` (items from 0), with
    /// its place in the file. A key that was left out is placed at the table around it.
    pub fn complain(&self, key: &str, wrong: impl Into<String>, right: impl Into<String>) -> Diagnostic {
        self.document.diagnose(key, Problem::new(wrong, right))
    }

    /// Checks that a simulation in the time domain is possible: all material laws are causal.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] with one complaint per layer whose law is `hysteretic`.
    pub fn check_time_domain(&self) -> Result<(), SceneError> {
        let layers = self.scene.tyre.layers.iter().enumerate();
        let acausal = layers.filter(|(_, layer)| layer.material.law == Law::Hysteretic);
        let [wrong, right] = NOT_CAUSAL;
        let complain = |(layer, _)| self.complain(&format!("tyre.layers[{layer}].material.law"), wrong, right);
        let diagnostics: Vec<_> = acausal.map(complain).collect();
        if diagnostics.is_empty() { Ok(()) } else { Err(SceneError::invalid(diagnostics, 0)) }
    }

    fn new(
        text: String,
        path: PathBuf,
        folder: PathBuf,
        settings: &[Setting],
        reach: Reach,
    ) -> Result<Self, SceneError> {
        let source = Arc::new(SourceText { name: path.display().to_string(), text });
        let mut root = parse(&source)?;
        let mut document = Document::new(&source, root.get_ref());
        if TYRE_KEYS.iter().all(|key| root.get_ref().contains_key(*key)) && !root.get_ref().contains_key("tyre") {
            return Err(SceneError::Tyre { path });
        }
        // The setting of a tyre file comes before settings within it, the kind of a table before its keys.
        let (tyre, mut within): (Vec<_>, Vec<_>) = settings.iter().partition(|setting| setting.is_tyre());
        within.sort_by_key(|setting| !setting.is_kind());
        tyre.into_iter().try_for_each(|setting| setting.apply(root.get_mut(), &mut document))?;

        let (tyre_source, tyre_error) = match root.get_ref().get("tyre").map(Spanned::get_ref) {
            Some(DeValue::String(_)) if reach == Reach::Recorded => {
                (None, Some(Problem::new("a recorded scene names a tyre file, which is not read", NO_FILE)))
            }
            Some(DeValue::String(tyre_path)) => match outside(&folder, Path::new(tyre_path.as_ref()), reach) {
                Some(problem) => (None, Some(problem)),
                None => match named_file(&folder, tyre_path, read_text) {
                    Ok(tyre_source) => (Some(tyre_source), None),
                    Err(error) => (None, Some(Problem::new(error.to_string(), NO_TYRE_FILE))),
                },
            },
            _ => (None, None),
        };
        if let Some(tyre_source) = &tyre_source {
            let mut tyre = parse(tyre_source)?;
            let pattern = tyre.get_mut().remove_entry(PATTERN);
            document.include(tyre_source, tyre.get_ref(), "tyre");
            // The pattern in a tyre file becomes the scene's, unless the scene has one itself.
            if let Some((key, value)) = pattern.filter(|_| !root.get_ref().contains_key(PATTERN)) {
                if let DeValue::Table(table) = value.get_ref() {
                    document.include(tyre_source, table, PATTERN);
                }
                root.get_mut().insert(key, value);
            }
            if let Some(entry) = root.get_mut().get_mut("tyre") {
                *entry.get_mut() = DeValue::Table(tyre.into_inner());
            }
        }
        within.into_iter().try_for_each(|setting| setting.apply(root.get_mut(), &mut document))?;
        let receiver_files;
        if reach != Reach::Recorded {
            receiver_files = ReceiverFiles::read(root.get_ref(), &document, |path| {
                let no_file = |error: SceneError| Problem::new(error.to_string(), NO_ARRAY_FILE);
                let read = || named_file(&folder, path, read_table).map_err(no_file);
                outside(&folder, Path::new(path), reach).map_or_else(read, Err)
            })?;
            receiver_files.put_into(root.get_mut(), &mut document);
        }
        let allowed = root.get_ref().get("allow_implausible").and_then(|allowed| allowed.get_ref().as_bool());
        let slack = if allowed == Some(true) { IMPLAUSIBLE } else { 1.0 };
        let complaints = Complaints::new(&document, slack);
        if let Some(problem) = tyre_error {
            complaints.add("tyre", problem);
        }
        let mut table = Table::new(&complaints, String::new(), "a scene", root.get_ref());
        let scene = consistency::scene(&mut table);
        table.finish();
        let (mut diagnostics, more) = complaints.finish();
        look_up(&mut diagnostics);
        let mut scene = match scene {
            Some(scene) if diagnostics.is_empty() => scene,
            _ => return Err(SceneError::invalid(diagnostics, more)),
        };
        let road_file = scene.road.file().map(Path::to_owned);
        let pattern_file = pattern_file(&mut scene).cloned();
        for (key, file) in [("road.file", &road_file), ("tread_pattern.file", &pattern_file)] {
            if let Some(problem) = file.as_ref().and_then(|file| outside(&folder, file, reach)) {
                return Err(document.diagnose(key, problem).into());
            }
        }
        if !folder.as_os_str().is_empty() {
            let Scene { road, tread_pattern, .. } = &mut scene;
            let of_pattern = tread_pattern.as_mut().and_then(|pattern| pattern.file.as_mut());
            for file in road.file_mut().into_iter().chain(of_pattern) {
                let joined = folder.join(&*file);
                *file = std::path::absolute(&joined).map_err(|source| SceneError::reading(&joined, source))?;
            }
        }
        Ok(Self { scene, path, folder, road_file, pattern_file, settled: false, document: Arc::new(document) })
    }
}

/// Names the tables that have keys which were given in others.
fn look_up(diagnostics: &mut [Diagnostic]) {
    let mut foreign = diagnostics.iter_mut().filter(|found| found.problem.is_foreign_key()).peekable();
    if foreign.peek().is_none() {
        return;
    }
    let schema = Scene::json_schema();
    let tables = sections(&schema);
    for Diagnostic { key, problem, .. } in foreign {
        let name = key.rsplit('.').next().unwrap_or(key);
        // Without the numbers of items.
        let here: String = key.split('[').map(|part| part.split_once(']').map_or(part, |(_, rest)| rest)).collect();
        let has = |table: &&Section<'_>| table.schema["properties"].get(name).is_some();
        let mut paths: Vec<String> = tables.iter().filter(has).map(|table| join(&table.path, name)).collect();
        paths.retain(|path| *path != here);
        paths.sort_unstable();
        paths.dedup();
        if (1..=MOST_ELSEWHERE).contains(&paths.len()) {
            problem.elsewhere(&paths);
        }
    }
}

fn pattern_file(scene: &mut Scene) -> Option<&mut PathBuf> {
    scene.tread_pattern.as_mut()?.file.as_mut()
}

/// Problem of a file outside the scene's folder, after resolving links. A missing file has none here: it is reported
/// when it is read.
fn outside(folder: &Path, file: &Path, reach: Reach) -> Option<Problem> {
    if reach != Reach::Folder {
        return None;
    }
    let (root, real) = (folder.canonicalize().ok()?, folder.join(file).canonicalize().ok()?);
    let wrong = || format!("\"{}\" is outside the scene's folder, {}", real.display(), root.display());
    (!real.starts_with(&root)).then(|| Problem::new(wrong(), OUTSIDE))
}

fn read_text(path: &Path) -> Result<String, SceneError> {
    String::from_utf8(read_bytes(path)?).map_err(|error| {
        let byte = error.utf8_error().valid_up_to();
        let line = error.as_bytes()[..byte].iter().filter(|&&byte| byte == b'\n').count() + 1;
        SceneError::NotText { path: path.to_owned(), byte, line }
    })
}

/// A table or XML, in any encoding that [`separated::decoded`] knows.
fn read_table(path: &Path) -> Result<String, SceneError> {
    Ok(separated::decoded(&read_bytes(path)?).into_owned())
}

fn read_bytes(path: &Path) -> Result<Vec<u8>, SceneError> {
    input::read(path, SCENE_BYTES).map_err(|error| SceneError::reading(path, error.into()))
}

/// A file that a scene names, by one of the readers above.
fn named_file(
    folder: &Path,
    path: &str,
    read: fn(&Path) -> Result<String, SceneError>,
) -> Result<Arc<SourceText>, SceneError> {
    let path = folder.join(path);
    Ok(Arc::new(SourceText { name: path.display().to_string(), text: read(&path)? }))
}

fn parse(source: &Arc<SourceText>) -> Result<Spanned<DeTable<'_>>, SceneError> {
    let (table, mut errors) = DeTable::parse_recoverable(&source.text);
    if errors.is_empty() {
        return Ok(table);
    }
    let document = Document::new(source, table.get_ref());
    // A file of another format, such as a table of numbers, has an error in each line.
    errors.sort_by_key(|error| error.span().map(|span| span.start));
    let more = errors.len().saturating_sub(MOST_SYNTAX_ERRORS);
    errors.truncate(MOST_SYNTAX_ERRORS);
    let mut diagnostics: Vec<_> = errors.iter().map(|error| syntax(source, &document, error)).collect();
    // After the first error of a line the parser is often out of step: the rest of the line would be noise.
    diagnostics.dedup_by_key(|diagnostic| diagnostic.line());
    Err(SceneError::invalid(diagnostics, more))
}

fn syntax(source: &Arc<SourceText>, document: &Document, error: &toml::de::Error) -> Diagnostic {
    let span = error.span().unwrap_or_default();
    let marked = source.text.get(span.clone()).unwrap_or_default();
    // The tree keeps the first of two equal keys: the place of the second is known from the text only.
    let (key, problem) = if error.message() == "duplicate key" {
        let line = source.text[..span.start].rsplit('\n').next().unwrap_or_default();
        let table = if line.trim_start().starts_with('[') { "" } else { document.table_at(source, span.start) };
        (join(table, marked), Problem::new("this is given twice", DUPLICATE))
    } else {
        let key = document.key_at(source, span.start).unwrap_or_default().to_owned();
        let (before, after) = source.text.split_at_checked(span.start).unwrap_or_default();
        let comma = after.starts_with(',') && before.ends_with(|sign: char| sign.is_ascii_digit());
        (key, Problem::new(error.message(), if comma { DECIMAL_COMMA } else { NOT_TOML }))
    };
    Diagnostic { source: Arc::clone(source), key, span, problem }
}

/// SHA-256 of settings as compact JSON with sorted keys, in hexadecimal: two scenes have the same hash exactly if their
/// settings are equal, however they are written.
pub(crate) fn settings_hash(settings: &serde_json::Value) -> String {
    sha256(&[&settings.to_string()])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::microphone_array::microphones;

    #[test]
    fn microphones_in_latin_1_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let xml =
            "<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?><A><pos Name=\"\u{fc}ber\" x=\"0\" y=\"3\" z=\"1\"/></A>";
        for text in [xml, "name,x,y,z\n\u{fc}ber,0,3,1\n"] {
            let latin: Vec<u8> = text.chars().map(|sign| u8::try_from(u32::from(sign)).unwrap()).collect();
            std::fs::write(folder.path().join("array"), latin).unwrap();
            let source = named_file(folder.path(), "array", read_table).unwrap();
            assert_eq!(microphones(&source).ok().unwrap()[0].name, "\u{fc}ber");
        }
    }
}
