//! Exceptions of the Python package, and the mapping to built-in ones.

use std::io;
use std::path::Path;

use pyo3::create_exception;
use pyo3::exceptions::{
    PyFileExistsError, PyFileNotFoundError, PyIsADirectoryError, PyKeyboardInterrupt, PyMemoryError, PyOSError,
    PyRuntimeError, PyValueError,
};
use pyo3::prelude::*;
use thiserror::Error;

use crate::half_space::HalfSpaceError;
use crate::radiation::RadiationError;
use crate::response::SpectrumError;
use crate::results::{CheckpointError, ResultsError};
use crate::road::slices::SliceError;
use crate::run;
use crate::scene::{self, Diagnostic};
use crate::study::sweep::SweepError;
use crate::tyre::modes::ModesError;

create_exception!(
    tyrewave,
    SceneError,
    PyValueError,
    "An invalid scene. `complaints` lists its mistakes, each with file, line and key; the message shows \
     them in their places."
);
create_exception!(tyrewave, RunError, PyRuntimeError, "A run that failed, or that cannot be resumed.");

/// A mistake in a scene, with its place.
#[pyclass(module = "tyrewave", frozen, get_all)]
pub(super) struct Complaint {
    /// Name of the file, or of the text in its place.
    file: String,
    /// Line in the file, from 1.
    line: usize,
    /// Column in characters, from 1.
    column: usize,
    /// Path of the key, such as `tyre.layers[1].thickness`; empty where no key is concerned.
    key: String,
    /// Fault.
    message: String,
    /// Remedy.
    hint: String,
    /// All of it in one line.
    text: String,
}

#[pymethods]
impl Complaint {
    fn __str__(&self) -> &str {
        &self.text
    }

    fn __repr__(&self) -> String {
        format!("<tyrewave.Complaint {}>", self.text)
    }
}

impl From<&Diagnostic> for Complaint {
    fn from(diagnostic: &Diagnostic) -> Self {
        Self {
            file: diagnostic.file().to_owned(),
            line: diagnostic.line(),
            column: diagnostic.column(),
            key: diagnostic.key().to_owned(),
            message: diagnostic.problem().to_string(),
            hint: diagnostic.problem().right.clone(),
            text: diagnostic.to_string(),
        }
    }
}

/// An error before it becomes a Python exception.
#[derive(Debug, Error)]
pub(super) enum Failure {
    #[error(transparent)]
    Run(#[from] run::RunError),
    #[error(transparent)]
    HalfSpace(#[from] HalfSpaceError),
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
    #[error(transparent)]
    Radiation(#[from] RadiationError),
    #[error(transparent)]
    Modes(#[from] ModesError),
    #[error(transparent)]
    Sweep(#[from] SweepError),
    /// Variants of a sweep that failed.
    #[error("{0}")]
    Variants(String),
    /// An invalid argument.
    #[error("{0}")]
    Argument(String),
    /// A defect of the package.
    #[error("{0}")]
    Inside(String),
}

impl From<scene::SceneError> for Failure {
    fn from(error: scene::SceneError) -> Self {
        Self::Run(error.into())
    }
}

impl From<SliceError> for Failure {
    fn from(error: SliceError) -> Self {
        Self::Run(error.into())
    }
}

impl Failure {
    /// Folder of a run that was stopped.
    pub(super) fn partial(&self) -> Option<&Path> {
        match self {
            Self::Run(run::RunError::Interrupted { partial }) => partial.as_deref(),
            _ => None,
        }
    }

    pub(super) fn raised(self, py: Python<'_>) -> PyErr {
        let text = self.to_string();
        match self {
            Self::Run(error) => of_a_run(py, error, text),
            Self::Radiation(RadiationError::Interrupted) => PyKeyboardInterrupt::new_err(text),
            Self::HalfSpace(HalfSpaceError::NotConverged { .. })
            | Self::Radiation(_)
            | Self::Modes(_)
            | Self::Variants(_) => RunError::new_err(text),
            Self::Sweep(SweepError::Scene { source, .. }) => of_a_scene(py, source),
            Self::Sweep(SweepError::Road { .. }) => PyValueError::new_err(text),
            Self::HalfSpace(_) | Self::Spectrum(_) | Self::Argument(_) => PyValueError::new_err(text),
            Self::Inside(_) => PyRuntimeError::new_err(text),
        }
    }
}

fn of_a_run(py: Python<'_>, error: run::RunError, text: String) -> PyErr {
    match error {
        run::RunError::Scene(error) => of_a_scene(py, error),
        run::RunError::Road(_) | run::RunError::Slices(_) => PyValueError::new_err(text),
        run::RunError::Results(error) => of_results(&error, text),
        run::RunError::Resumable { source, .. } => of_results(&source, text),
        run::RunError::Checkpoint(CheckpointError::Nothing { .. }) => PyFileNotFoundError::new_err(text),
        run::RunError::Checkpoint(CheckpointError::Io { source, .. }) => of_system(&source, text),
        run::RunError::Interrupted { .. } => PyKeyboardInterrupt::new_err(text),
        run::RunError::Contact(_)
        | run::RunError::Impossible(_)
        | run::RunError::Plot(_)
        | run::RunError::Spectrum(_)
        | run::RunError::State(_)
        | run::RunError::Checkpoint(_) => RunError::new_err(text),
    }
}

fn of_a_scene(py: Python<'_>, error: scene::SceneError) -> PyErr {
    let text = error.render(false);
    match &error {
        scene::SceneError::NotFound { .. } => return PyFileNotFoundError::new_err(error.to_string()),
        scene::SceneError::Folder { .. } => return PyIsADirectoryError::new_err(error.to_string()),
        scene::SceneError::Unreadable { source, .. } => return of_system(source, error.to_string()),
        _ => {}
    }
    let complaints: Vec<Complaint> = error.diagnostics().iter().map(Complaint::from).collect();
    let raised = SceneError::new_err(text);
    // An exception without its list is still the right one.
    let reported = raised.value(py).setattr("complaints", complaints);
    reported.err().unwrap_or(raised)
}

fn of_results(error: &ResultsError, text: String) -> PyErr {
    match error {
        ResultsError::NotOurs { .. } | ResultsError::ForeignEntry { .. } => PyFileExistsError::new_err(text),
        ResultsError::NoFolderName { .. } => PyValueError::new_err(text),
        ResultsError::OutOfMemory { .. } => PyMemoryError::new_err(text),
        ResultsError::Create { source, .. }
        | ResultsError::Write { source, .. }
        | ResultsError::Rename { source, .. } => of_system(source, text),
        _ => PyOSError::new_err(text),
    }
}

/// `OSError` with our message, and the system's error number if there is one.
fn of_system(source: &io::Error, text: String) -> PyErr {
    match source.raw_os_error() {
        // Python chooses the fitting subclass of `OSError` by the number.
        Some(number) => PyOSError::new_err((number, text)),
        None => PyOSError::new_err(text),
    }
}
