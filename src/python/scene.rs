//! Scenes. Python's dictionaries and numbers as TOML, in which scenes are written.

use std::path::PathBuf;

use crate::scene::{self, LoadedScene, Reach, SceneError, Setting};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyDictMethods, PyFloat, PyInt, PyMapping, PySequence, PyString};
use toml::Value;

use super::error::Failure;

/// A checked scene. See `tyrewave.Scene`.
#[pyclass(module = "tyrewave._native", frozen)]
pub(super) struct Scene {
    pub(super) loaded: LoadedScene,
}

/// A setting that replaces a scene's.
pub(super) fn setting(key: &str, value: &Bound<'_, PyAny>) -> PyResult<Setting> {
    let text = to_toml(value, key)?;
    Setting::parse(&format!("{key}={text}")).map_err(|wrong| Failure::Argument(wrong).raised(value.py()))
}

/// Settings that replace a scene's, by key.
fn settings(given: Option<&Bound<'_, PyDict>>) -> PyResult<Vec<Setting>> {
    let one = |(key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>)| setting(&key.extract::<String>()?, &value);
    given.map_or_else(|| Ok(Vec::new()), |given| given.iter().map(one).collect())
}

fn checked(py: Python<'_>, loaded: Result<LoadedScene, SceneError>) -> PyResult<Scene> {
    loaded.map(|loaded| Scene { loaded }).map_err(|error| Failure::from(error).raised(py))
}

#[pymethods]
impl Scene {
    /// Reads a file; `settings` replace its own.
    #[staticmethod]
    #[pyo3(signature = (path, settings=None, allow_outside=false))]
    fn load(
        py: Python<'_>,
        path: PathBuf,
        settings: Option<&Bound<'_, PyDict>>,
        allow_outside: bool,
    ) -> PyResult<Self> {
        let reach = if allow_outside { Reach::Anywhere } else { Reach::Folder };
        checked(py, scene::Scene::load_with(path, &self::settings(settings)?, reach))
    }

    /// Reads a text; `name` takes the place of a file's name in messages.
    #[staticmethod]
    #[pyo3(signature = (text, name="scene", settings=None))]
    fn from_toml(py: Python<'_>, text: &str, name: &str, settings: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        checked(py, scene::Scene::from_str_with(text, name, &self::settings(settings)?))
    }

    /// Reads a dictionary with the keys of a file.
    #[staticmethod]
    #[pyo3(signature = (keys, name="scene", settings=None))]
    fn from_dict(
        py: Python<'_>,
        keys: &Bound<'_, PyDict>,
        name: &str,
        settings: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let keys = to_toml(keys.as_any(), "")?;
        let no_toml = |source| Failure::from(SceneError::NotToml { source }).raised(py);
        Self::from_toml(py, &toml::to_string(&keys).map_err(no_toml)?, name, settings)
    }

    /// Title, or the name if there is none.
    #[getter]
    fn title(&self) -> String {
        self.loaded.title()
    }

    /// Name of the file, without its ending.
    #[getter]
    fn name(&self) -> String {
        self.loaded.name()
    }

    /// All settings as JSON, defaults filled in, paths as written.
    fn settings(&self, py: Python<'_>) -> PyResult<String> {
        self.loaded.settings().map(|settings| settings.to_string()).map_err(|error| Failure::from(error).raised(py))
    }

    /// All settings as TOML, defaults filled in, paths as used.
    fn to_toml(&self, py: Python<'_>) -> PyResult<String> {
        self.loaded.scene.to_toml().map_err(|error| Failure::from(error).raised(py))
    }

    /// SHA-256 of the settings.
    fn sha256(&self, py: Python<'_>) -> PyResult<String> {
        self.loaded.hash().map_err(|error| Failure::from(error).raised(py))
    }
}

/// Largest nesting of tables: a dictionary may contain itself.
const DEEPEST: usize = 16;

/// A value of a scene from a Python value; `key` names it in a complaint.
///
/// # Errors
/// `TypeError` for types without a counterpart in TOML, `ValueError` for a number that it cannot hold.
pub(super) fn to_toml(value: &Bound<'_, PyAny>, key: &str) -> PyResult<Value> {
    within(value, key, 0)
}

/// As [`to_toml`], at a depth of nesting.
fn within(value: &Bound<'_, PyAny>, key: &str, depth: usize) -> PyResult<Value> {
    if depth > DEEPEST {
        return Err(PyValueError::new_err(format!("{key}: more than {DEEPEST} values within each other")));
    }
    if let Ok(flag) = value.cast::<PyBool>() {
        return Ok(Value::Boolean(flag.is_true()));
    }
    if value.is_instance_of::<PyInt>() {
        let too_large = |_| PyValueError::new_err(format!("{key}: {value} does not fit into 64 bits"));
        return value.extract().map(Value::Integer).map_err(too_large);
    }
    if value.is_instance_of::<PyFloat>() {
        return value.extract().map(Value::Float);
    }
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(Value::String(text.to_str()?.to_owned()));
    }
    if let Ok(table) = value.cast::<PyMapping>() {
        let mut entries = toml::Table::new();
        for item in table.items()?.iter() {
            let (name, value): (String, Bound<'_, PyAny>) = item.extract()?;
            let place = if key.is_empty() { name.clone() } else { format!("{key}.{name}") };
            // None in a dictionary means that the key is not given.
            if !value.is_none() {
                entries.insert(name, within(&value, &place, depth + 1)?);
            }
        }
        return Ok(Value::Table(entries));
    }
    // Paths, and numpy's numbers and arrays, can convert themselves.
    for plain in ["__fspath__", "tolist"] {
        if value.hasattr(plain)? {
            return within(&value.call_method0(plain)?, key, depth + 1);
        }
    }
    if let Ok(items) = value.cast::<PySequence>() {
        let items = items.to_list()?;
        let items = items.iter().enumerate().map(|(place, item)| within(&item, &format!("{key}[{place}]"), depth + 1));
        return Ok(Value::Array(items.collect::<PyResult<_>>()?));
    }
    let kind = value.get_type().qualname()?;
    Err(PyTypeError::new_err(format!("{key}: a {kind} cannot be a value in a scene")))
}
