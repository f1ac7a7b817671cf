//! Plans and runs.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::Instant;

use ndarray::Array2;
use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use super::error::Failure;
use super::scene::Scene;
use super::work::{Watched, carried_out};
use crate::counters::process::cpu_time;
use crate::counters::{Stage, Watch};
use crate::plan::{Plan, process_memory};
use crate::report::plan_record;
use crate::results::files::FilesInMemory;
use crate::results::summary::{Cost, Summary};
use crate::run::look_back::LookBack;
use crate::run::prepare::checked;
use crate::run::{self, Progress, Run, RunError, RunOptions, RunReport};
use crate::scene::{Axle, LoadedScene};
use crate::study::calibration::calibrated;

/// Steps between two looks at whether to stop.
const LOOK_EVERY: u64 = 16;

/// Returns the plan of a run with its reasons, as JSON.
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

/// Runs a scene into a folder; its path.
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
        let options = RunOptions { target: out, threads: rayon::current_num_threads(), watch: Watch::default() };
        let RunReport { folder, .. } = run::run(loaded, &options, &watched.stop, &mut watched)?;
        Ok(folder)
    })
}

/// Goes on with an unfinished run; the path of its folder.
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
        let RunReport { folder, .. } = run::resume(&folder, threads, Watch::default(), &watched.stop, &mut watched)?;
        Ok(folder)
    })
}

/// Runs a scene: a dictionary of its arrays, its summary (JSON), and under `files` the content of every other file that
/// a results folder has at its end, pictures excepted.
#[pyfunction]
#[pyo3(signature = (scene, threads=None, progress=None))]
pub(super) fn run_in_memory<'py>(
    py: Python<'py>,
    scene: &Scene,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let loaded = &scene.loaded;
    let InMemory { summary, arrays, files } =
        carried_out(py, threads, progress.as_ref(), |watched| InMemory::of(loaded, watched))?;
    let found = PyDict::new(py);
    let to_json =
        |summary: &Summary| serde_json::to_string(summary).map_err(|error| Failure::Inside(error.to_string()));
    found.set_item("summary", to_json(&summary).map_err(|failure| failure.raised(py))?)?;
    let contents = PyDict::new(py);
    files.into_iter().try_for_each(|(name, content)| contents.set_item(name, PyBytes::new(py, &content)))?;
    found.set_item("files", contents)?;
    let Some(Arrays { columns, time, total_force, patch_force, patch_element, axle }) = arrays else {
        return Ok(found);
    };
    let patch_force = Array2::from_shape_vec((time.len(), columns), patch_force);
    let patch_force = patch_force.map_err(|error| Failure::Inside(error.to_string()).raised(py))?;
    found.set_item("time", time.into_pyarray(py))?;
    found.set_item("total_force", total_force.into_pyarray(py))?;
    found.set_item("patch_force", patch_force.into_pyarray(py))?;
    found.set_item("patch_element", patch_element.into_pyarray(py))?;
    if let Some(axle) = axle {
        found.set_item("axle", axle.into_pyarray(py))?;
    }
    Ok(found)
}

/// Values of every step, as in the files of a results folder.
struct Arrays {
    columns: usize,
    time: Vec<f64>,
    total_force: Vec<f64>,
    /// Row by row.
    patch_force: Vec<f64>,
    patch_element: Vec<i64>,
    /// Heights of an axle that moves.
    axle: Option<Vec<f64>>,
}

impl Arrays {
    /// Room for all steps.
    fn new(plan: &Plan, columns: usize) -> Result<Self, Failure> {
        let moves = matches!(plan.scene.rolling.axle, Axle::Mass { .. });
        let steps = usize::try_from(plan.steps).unwrap_or(usize::MAX);
        let bytes = size_of::<f64>() as f64 * plan.steps as f64 * (columns as f64 + 4.0);
        let (mut time, mut total_force, mut patch_force, mut patch_element) = Default::default();
        let mut axle = moves.then(Vec::new);
        let room = |array: &mut Vec<f64>, rows: usize| array.try_reserve_exact(rows).map_err(|_| Failure::Room(bytes));
        room(&mut patch_force, steps.saturating_mul(columns))?;
        room(&mut time, steps)?;
        room(&mut total_force, steps)?;
        axle.as_mut().map_or(Ok(()), |axle| room(axle, steps))?;
        Vec::try_reserve_exact(&mut patch_element, steps).map_err(|_| Failure::Room(bytes))?;
        Ok(Self { columns, time, total_force, patch_force, patch_element, axle })
    }
}

/// A complete run.
struct InMemory {
    summary: Summary,
    arrays: Option<Arrays>,
    files: BTreeMap<String, Vec<u8>>,
}

impl InMemory {
    fn of(loaded: &LoadedScene, mut watched: &Watched) -> Result<Self, Failure> {
        let (wall, cpu) = (Instant::now(), cpu_time());
        let plan = Plan::of(loaded)?.with_kept_model();
        let loaded = &loaded.clone().settled(plan.scene.clone());
        plan.check(loaded)?;
        watched.stage(Stage::Influence);
        let stop = &watched.stop;
        let mut run = Run::begin_heard(loaded, &plan, stop, Watch::default())?;
        let columns = run.prepared.march.geometry().columns;
        let mut arrays = if plan.scene.outputs.arrays { Some(Arrays::new(&plan, columns)?) } else { None };
        watched.march(0, plan.steps, plan.time_step);
        while run.next_step() < plan.steps {
            let step = run.next_step();
            if step % LOOK_EVERY == 0 {
                watched.step(step);
                if stop.load(Ordering::Relaxed) {
                    return Err(RunError::Interrupted { kept: None }.into());
                }
            }
            let indentation = run.prepared.axle.indentation(step);
            let Some(result) = run.step()? else { break };
            if let Some(arrays) = &mut arrays {
                arrays.time.push(step as f64 * plan.time_step);
                arrays.total_force.push(result.total_force);
                arrays.patch_force.extend_from_slice(run.forces());
                arrays.patch_element.push(result.first_element);
                arrays.axle.iter_mut().for_each(|axle| axle.push(indentation));
            }
        }
        watched.stage(Stage::Response);
        run.settle();
        let Run { prepared, record, meter, .. } = &mut run;
        let mut undrawn = loaded.clone();
        undrawn.scene.outputs.plots = false;
        let files = FilesInMemory::default();
        let written =
            LookBack { loaded: &undrawn, plan: &plan, prepared, record, steps: plan.steps }.write(&files, meter)?;
        let look_back = LookBack { loaded, plan: &plan, prepared, record, steps: plan.steps };
        let spent = cpu.zip(cpu_time()).map(|(before, after)| after.saturating_sub(before));
        let cost = Cost::new(meter, wall.elapsed().as_secs_f64(), rayon::current_num_threads()).with_cpu(spent);
        let summary = Summary { complete: true, ..look_back.summary(cost, written)? };
        Ok(Self { summary, arrays, files: files.into_inner() })
    }
}
