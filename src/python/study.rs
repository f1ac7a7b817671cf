//! Studies of a scene: its tyre, its radiation, the contributions of effects, and sweeps.

use std::path::PathBuf;
use std::sync::atomic::Ordering;

use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::error::Failure;
use super::scene::{Scene, setting};
use super::tyre::{SMALLEST_PATCH, within};
use super::work::carried_out;
use crate::counters::{Job, Stage};
use crate::plan::Plan;
use crate::report::radiation::radiation_record;
use crate::report::tyre::{UnderLoad, tyre_record};
use crate::results::ResultsError;
use crate::results::summary::SUMMARY_FILE;
use crate::run::{Progress, RunError};
use crate::scene::Setting;
use crate::study::calibration::calibrated;
use crate::study::effects::{LONGEST, compare};
use crate::study::loads::{LoadedTyre, rolling};
use crate::study::radiation::{LOWEST, Radiator, asked_frequencies};
use crate::study::sweep::factor::Values;
use crate::study::sweep::table::{csv, sound_csv};
use crate::study::sweep::{
    Axes, Design, Done, Factor, Label, RepeatedTable, Variant, VariantOutcome, blocks, sweep as run_all, variants,
};
use crate::tyre::influence::mobility::{driving_point, frequencies};
use crate::tyre::modes::modes;

/// Highest frequency \[Hz\] and largest number of frequencies that are accepted.
const HIGHEST: f64 = 1e5;
const MOST_POINTS: f64 = 1e5;
/// Lowest and highest frequency of the mobility \[Hz\].
const MOBILITY: (f64, f64) = (50.0, 3000.0);

/// Modes, contact under loads and mobility of a scene's tyre, as JSON. `range`: most waves around the tyre, lateral
/// numbers, highest frequency \[Hz\]; `under`: loads \[N\], and whether the tyre is rolled under them; `mobility`:
/// sides of patches \[m\] and number of frequencies.
#[pyfunction]
#[pyo3(signature = (scene, range, under, mobility, threads=None, progress=None))]
pub(super) fn tyre(
    py: Python<'_>,
    scene: &Scene,
    range: (usize, usize, f64),
    under: (Vec<f64>, bool),
    mobility: (Vec<f64>, u32),
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<String> {
    let loaded = &scene.loaded;
    carried_out(py, threads, progress.as_ref(), |mut watched| {
        let scene = &loaded.scene;
        let ((waves, lateral, highest), (loads, rolls), (patches, points)) = (range, under, mobility);
        within("waves", &[waves as f64], 0.0, 500.0)?;
        within("lateral", &[lateral as f64], 1.0, 50.0)?;
        within("highest", &[highest], f64::MIN_POSITIVE, HIGHEST)?;
        within("load", &loads, f64::MIN_POSITIVE, f64::MAX)?;
        within("patch", &patches, SMALLEST_PATCH, scene.tyre.width)?;
        within("points", &[f64::from(points)], 2.0, MOST_POINTS)?;
        if rolls {
            loaded.check_time_domain()?;
        }
        watched.stage(Stage::Influence);
        let standing = LoadedTyre::new(scene);
        let contacts: Result<Vec<_>, _> = loads.iter().map(|&load| standing.under(load)).collect();
        let contacts = contacts.map_err(RunError::from)?;
        let found = modes(&scene.tyre, waves, lateral, highest)?;
        let mobility = driving_point(&scene.tyre, &patches, &frequencies(MOBILITY.0, MOBILITY.1, points));
        let lengths = if rolls { Some(rolling(scene, &loads, Job::new(&watched.stop, &mut watched))?) } else { None };
        let length = |index: usize| lengths.as_ref().map(|lengths| lengths[index]);
        let under: Vec<UnderLoad> = contacts
            .into_iter()
            .enumerate()
            .map(|(index, standing)| UnderLoad { label: String::new(), standing, rolling: length(index) })
            .collect();
        let element = scene.tyre.circumference / scene.numerics.elements as f64;
        Ok(tyre_record(&loaded.title(), element, &found, &under, &mobility).to_string())
    })
}

/// Sound radiation of a scene's tyre that stands on a road, as JSON.
#[pyfunction]
#[pyo3(signature = (scene, highest, points, threads=None, progress=None))]
pub(super) fn radiation(
    py: Python<'_>,
    scene: &Scene,
    highest: f64,
    points: u32,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<String> {
    let loaded = &scene.loaded;
    carried_out(py, threads, progress.as_ref(), |watched| {
        let scene = &loaded.scene;
        within("highest", &[highest], LOWEST, HIGHEST)?;
        within("points", &[f64::from(points)], 2.0, MOST_POINTS)?;
        let standing = LoadedTyre::new(scene).held_by(&scene.rolling.axle).map_err(RunError::from)?;
        let radiator = Radiator::new(scene, &Plan::new(scene), standing.length)?;
        let asked = asked_frequencies(highest, points);
        watched.pieces_of(Stage::Radiation, asked.len());
        let found = radiator.at(&asked, &watched.stop, &|| watched.piece_done())?;
        Ok(radiation_record(&loaded.title(), &radiator, &found).to_string())
    })
}

/// Contribution of each effect, as CSV; runs of at most `duration` \[s\].
#[pyfunction]
#[pyo3(signature = (scene, duration=None, threads=None, progress=None))]
pub(super) fn effects(
    py: Python<'_>,
    scene: &Scene,
    duration: Option<f64>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<String> {
    let loaded = &scene.loaded;
    carried_out(py, threads, progress.as_ref(), |mut watched| {
        loaded.check_time_domain()?;
        let duration = duration.unwrap_or(loaded.scene.rolling.duration.min(LONGEST));
        within("duration", &[duration], f64::MIN_POSITIVE, f64::MAX)?;
        let costs = calibrated(&watched.stop)?;
        Ok(compare(loaded, duration, &costs, Job::new(&watched.stop, &mut watched))?.csv())
    })
}

/// Sweeps over speeds \[km/h\], loads \[N\], road files and other keys, into a folder: returns a dictionary of the
/// names of its variants, of those that missed their load, and of its tables as CSV.
#[pyfunction]
#[pyo3(signature = (scene, out, axes, factors, threads=None, progress=None))]
pub(super) fn sweep<'py>(
    py: Python<'py>,
    scene: &Scene,
    out: PathBuf,
    axes: (Vec<f64>, Vec<f64>, Vec<PathBuf>),
    factors: Vec<(String, Vec<Bound<'py, PyAny>>)>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let factor = |(key, values): (String, Vec<Bound<'py, PyAny>>)| -> PyResult<Factor> {
        let values: PyResult<Vec<Setting>> = values.iter().map(|value| setting(&key, value)).collect();
        Ok(Factor { key, values: Values::Listed(values?) })
    };
    let factors = factors.into_iter().map(factor).collect::<PyResult<Vec<_>>>()?;
    let (loaded, (speeds, loads, roads)) = (&scene.loaded, axes);
    let runs = carried_out(py, threads, progress.as_ref(), |mut watched| {
        let points =
            if factors.is_empty() { Vec::new() } else { Design::Grid.points(&factors).map_err(Failure::Argument)? };
        let variants = variants(loaded, &Axes { speeds, loads, roads, points })?;
        if out.join(SUMMARY_FILE).exists() {
            return Err(RunError::from(ResultsError::NotOurs { path: out }).into());
        }
        std::fs::create_dir_all(&out).map_err(ResultsError::creating(&out)).map_err(RunError::from)?;
        let outcomes = run_all(&variants, &out, rayon::current_num_threads(), &watched.stop, &mut watched);
        if watched.stop.load(Ordering::Relaxed) {
            return Err(RunError::Interrupted { partial: None }.into());
        }
        let failed = |(variant, outcome): (&Variant, &VariantOutcome)| match outcome {
            VariantOutcome::Failed(error) => Some(format!("{}: {error}", variant.label.name)),
            VariantOutcome::Done(_) | VariantOutcome::Stopped => None,
        };
        let failed: Vec<String> = variants.iter().zip(&outcomes).filter_map(failed).collect();
        if !failed.is_empty() {
            let (count, all) = (failed.len(), variants.len());
            let reported = format!("{count} of {all} variants failed, the others are done: {}", failed.join("; "));
            return Err(Failure::Variants(reported));
        }
        let found =
            variants.into_iter().zip(&outcomes).map(|(variant, outcome)| (variant.label, outcome.done().cloned()));
        Ok(found.collect::<Vec<(Label, Option<Done>)>>())
    })?;
    let names = |of: fn(&Done) -> bool| -> Vec<&str> {
        let runs = runs.iter().filter(|(_, done)| done.as_ref().is_some_and(of));
        runs.map(|(label, _)| label.name.as_str()).collect()
    };
    let found = PyDict::new(py);
    found.set_item("names", names(|_| true))?;
    found.set_item("missed", names(|done| done.missed_load().is_some()))?;
    let blocks = blocks(&runs);
    found.set_item("sweep.csv", csv(&blocks))?;
    found.set_item("sweep_sound.csv", sound_csv(&blocks))?;
    found.set_item("design.csv", RepeatedTable::new(&runs).map(|table| table.csv()))?;
    Ok(found)
}
