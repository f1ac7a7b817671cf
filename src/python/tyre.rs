//! Responses of a scene's tyre: compliance, mobility, influence functions.

use std::f64::consts::TAU;

use ndarray::Array2;
use num_complex::Complex64;
use numpy::{IntoPyArray, PyArray2, PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;

use super::error::Failure;
use super::scene::Scene;
use super::work::{Watched, carried_out, shaped};
use crate::numeric::in_parallel;
use crate::plan::models::{fetch, refused};
use crate::plan::{Decisions, fit_options};
use crate::run::RunError;
use crate::scene::LoadedScene;
use crate::tyre::impulse_response::impulse_responses;
use crate::tyre::influence::Field;
use crate::tyre::influence::mobility::driving_point;
use crate::tyre::poles::{Direction, RationalModel};
use crate::tyre::wave_compliance;

/// Highest frequency that is accepted \[Hz\]: far above the audible range.
const HIGHEST: f64 = 1e5;
/// Largest number of a wave: far beyond the resolution of a tread of millimetres.
const MOST_WAVES: u32 = 1_000_000;
/// Smallest patch whose mobility is summed \[m\]: the smaller, the more waves.
pub(super) const SMALLEST_PATCH: f64 = 1e-3;

pub(super) fn within(what: &str, values: &[f64], least: f64, most: f64) -> Result<(), Failure> {
    match values.iter().find(|value| !(least..=most).contains(*value)) {
        Some(value) => Err(Failure::Argument(format!("{what} {value}: {least} to {most} can be answered"))),
        None => Ok(()),
    }
}

fn waves_within(what: &str, waves: &[u32], most: u32) -> Result<(), Failure> {
    match waves.iter().find(|wave| **wave > most) {
        Some(wave) => Err(Failure::Argument(format!("{what} {wave}: 0 to {most} can be answered"))),
        None => Ok(()),
    }
}

/// C \[m/Pa\], \[waves, frequencies, 3, 3\].
#[pyfunction]
pub(super) fn compliance<'py>(
    py: Python<'py>,
    scene: &Scene,
    around: Vec<u32>,
    lateral: u32,
    frequencies: Vec<f64>,
) -> PyResult<Bound<'py, PyArrayDyn<Complex64>>> {
    let shape = [around.len(), frequencies.len(), 3, 3];
    let found = carried_out(py, None, None, |_| {
        within("frequency", &frequencies, 0.0, HIGHEST)?;
        waves_within("wave", &around, MOST_WAVES)?;
        waves_within("lateral number", &[lateral], MOST_WAVES)?;
        Ok(wave_compliance(&scene.loaded.scene.tyre, &around, lateral as usize, &frequencies))
    })?;
    let values: Vec<Complex64> = found.into_iter().flatten().flatten().collect();
    values.into_pyarray(py).reshape(shape).map(|array| array.to_dyn().clone())
}

/// Driving-point mobility \[m/(N s)\], \[frequencies, patches\].
#[pyfunction]
pub(super) fn mobility<'py>(
    py: Python<'py>,
    scene: &Scene,
    patches: Vec<f64>,
    frequencies: Vec<f64>,
) -> PyResult<Bound<'py, PyArray2<Complex64>>> {
    let tyre = &scene.loaded.scene.tyre;
    let rows = carried_out(py, None, None, |_| {
        within("patch", &patches, SMALLEST_PATCH, tyre.width)?;
        within("frequency", &frequencies, f64::MIN_POSITIVE, HIGHEST)?;
        shaped(driving_point(tyre, &patches, &frequencies).values, patches.len())
    })?;
    Ok(rows.into_pyarray(py))
}

/// Model of the influence functions of a scene's rolling tyre, from the cache or fitted.
fn model(loaded: &LoadedScene, watched: &Watched) -> Result<RationalModel, Failure> {
    let options = fit_options(&loaded.scene, Field::Surface);
    let fetched = fetch(&Decisions::new(&loaded.scene).tyre, &options, &watched.stop);
    Ok(fetched.map_err(|error| RunError::from(refused(loaded, error, "another tolerance")))?.model)
}

/// g \[m/(N s)\] over distance and time, \[distances, times\].
#[pyfunction]
pub(super) fn influence<'py>(
    py: Python<'py>,
    scene: &Scene,
    distances: Vec<usize>,
    times: Vec<f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let rows = carried_out(py, None, None, |watched| {
        within("time", &times, 0.0, f64::MAX)?;
        let model = model(&scene.loaded, watched)?;
        // Distances repeat after one revolution.
        let distances: Vec<usize> = distances.iter().map(|distance| distance % model.elements).collect();
        let rows = impulse_responses(&model, Field::Surface, &distances, &times).unwrap_or_default();
        shaped(rows, times.len())
    })?;
    Ok(rows.into_pyarray(py))
}

/// H_n \[m/N\] over wavenumber and frequency, \[wavenumbers, frequencies\]; n < 0 against the rotation.
#[pyfunction]
pub(super) fn influence_spectrum<'py>(
    py: Python<'py>,
    scene: &Scene,
    wavenumbers: Vec<i64>,
    frequencies: Vec<f64>,
) -> PyResult<Bound<'py, PyArray2<Complex64>>> {
    let rows: Array2<Complex64> = carried_out(py, None, None, |watched| {
        within("frequency", &frequencies, 0.0, HIGHEST)?;
        let model = model(&scene.loaded, watched)?;
        let last = model.largest_wavenumber();
        if let Some(n) = wavenumbers.iter().find(|n| n.unsigned_abs() > last as u64) {
            return Err(Failure::Argument(format!("wavenumber {n}: the elements carry -{last} to {last}")));
        }
        let row = |&n: &i64| -> Vec<Complex64> {
            let direction = if n < 0 { Direction::Backwards } else { Direction::Forwards };
            let modes = model.modes(n.unsigned_abs() as usize, Field::Surface);
            let value = |&f: &f64| modes.map(|modes| modes.evaluate_wave(direction, Complex64::new(0.0, TAU * f)));
            frequencies.iter().map(|f| value(f).unwrap_or_default()).collect()
        };
        shaped(in_parallel::map(&wavenumbers, row), frequencies.len())
    })?;
    Ok(rows.into_pyarray(py))
}
