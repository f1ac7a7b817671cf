//! Scenes.

use std::path::PathBuf;

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyDictMethods};

use super::error::Failure;
use super::value::to_toml;
use crate::scene::{self, LoadedScene, Reach, SceneError, Setting};

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
