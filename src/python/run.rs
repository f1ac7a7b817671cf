//! Plans and runs.

use std::path::PathBuf;

use numpy::{Element, IntoPyArray};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use super::error::Failure;
use super::scene::Scene;
use super::work::{carried_out, of_shape};
use crate::counters::Job;
use crate::effects::channel::{ArrayNumbers, KeptArray, RowShape, RowTimes};
use crate::effects::{self};
use crate::plan::process_memory;
use crate::report::plan_record;
use crate::results::summary::Summary;
use crate::run::prepare::checked;
use crate::run::{self, RunInMemory, RunOptions, RunReport, run_in_memory as roll_in_memory};
use crate::study::calibration::calibrated;

/// Plan of a run with its reasons, as JSON.
#[pyfunction]
#[pyo3(signature = (scene, threads=None))]
pub(super) fn plan(py: Python<'_>, scene: &Scene, threads: Option<usize>) -> PyResult<String> {
    let loaded = &scene.loaded;
    carried_out(py, threads, None, |watched| {
        let process = process_memory();
        let plan = checked(loaded)?;
        let forecast = plan.forecast(&calibrated(&watched.stop)?, rayon::current_num_threads(), process);
        Ok(plan_record(loaded, &plan, &plan.amounts(), &forecast)?.to_string())
    })
}

/// Runs a scene into a folder; returns its path.
#[pyfunction]
#[pyo3(signature = (scene, out, threads=None, progress=None))]
pub(super) fn run_to_folder(
    py: Python<'_>,
    scene: &Scene,
    out: PathBuf,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<PathBuf> {
    let loaded = &scene.loaded;
    carried_out(py, threads, progress.as_ref(), |mut watched| {
        let options = RunOptions { target: out, threads: rayon::current_num_threads() };
        let RunReport { folder, .. } = run::run(loaded, &options, Job::new(&watched.stop, &mut watched))?;
        Ok(folder)
    })
}

/// Continues an unfinished run; returns the path of its folder.
#[pyfunction]
#[pyo3(signature = (folder, threads=None, progress=None))]
pub(super) fn resume(
    py: Python<'_>,
    folder: PathBuf,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<PathBuf> {
    carried_out(py, threads, progress.as_ref(), |mut watched| {
        let threads = rayon::current_num_threads();
        let RunReport { folder, .. } = run::resume(&folder, threads, Job::new(&watched.stop, &mut watched))?;
        Ok(folder)
    })
}

/// Runs a scene: returns a dictionary of its arrays, its summary (JSON), and under `files` the content of every other
/// file that a results folder has at its end, except pictures.
#[pyfunction]
#[pyo3(signature = (scene, threads=None, progress=None))]
pub(super) fn run_in_memory<'py>(
    py: Python<'py>,
    scene: &Scene,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let loaded = &scene.loaded;
    let RunInMemory { summary, arrays, files } = carried_out(py, threads, progress.as_ref(), |mut watched| {
        roll_in_memory(loaded, Job::new(&watched.stop, &mut watched)).map_err(Failure::from)
    })?;
    let found = PyDict::new(py);
    let to_json =
        |summary: &Summary| serde_json::to_string(summary).map_err(|error| Failure::Inside(error.to_string()));
    found.set_item("summary", to_json(&summary).map_err(|failure| failure.raised(py))?)?;
    let contents = PyDict::new(py);
    files.into_iter().try_for_each(|(name, content)| contents.set_item(name, PyBytes::new(py, &content)))?;
    found.set_item("files", contents)?;
    for KeptArray { name, columns, numbers } in arrays {
        let array = match numbers {
            ArrayNumbers::Double(numbers) => handed(py, numbers, columns)?,
            ArrayNumbers::Whole(numbers) => handed(py, numbers, columns)?,
            ArrayNumbers::Single(numbers) => handed(py, numbers, columns)?,
        };
        found.set_item(name, array)?;
    }
    Ok(found)
}

/// Hands over an array of a run, with `columns` numbers per row.
fn handed<'py, T: Element>(py: Python<'py>, numbers: Vec<T>, columns: Option<usize>) -> PyResult<Bound<'py, PyAny>> {
    let Some(columns) = columns else { return Ok(numbers.into_pyarray(py).into_any()) };
    let shape = (numbers.len() / columns.max(1), columns);
    Ok(of_shape(numbers, shape).map_err(|failure| failure.raised(py))?.into_pyarray(py).into_any())
}

/// The arrays that a run may have: name, unit, meaning, and whether a row is one number, or one for each column of the
/// window, row of cells across or point (`""`, `"column"`, `"row"`, `"point"`); last, whether every step has a row.
#[pyfunction]
pub(super) fn channels() -> Vec<(&'static str, &'static str, &'static str, &'static str, bool)> {
    let all = effects::channels().map(|channel| {
        let row = match channel.row {
            RowShape::One => "",
            RowShape::Columns => "column",
            RowShape::Across => "row",
            RowShape::Points => "point",
        };
        (channel.name, channel.unit, channel.meaning, row, channel.when == RowTimes::EveryStep)
    });
    all.collect()
}
