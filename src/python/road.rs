//! Roads: heights, texture, and displacements of slices.

use numpy::{IntoPyArray, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::error::Failure;
use super::scene::Scene;
use super::work::{carried_out, shaped};
use crate::plan::Plan;
use crate::run::road::{described, in_scene, road_limits};
use crate::scene::LoadedScene;
use crate::study::slices::{LAWS, Sample};

/// Largest magnitude of a road coordinate \[m\].
const FURTHEST: f64 = 1e7;

/// Reads `elements` elements of a scene's road from the coordinate `start` \[m\] on.
fn sample(loaded: &LoadedScene, start: f64, elements: f64) -> Result<Sample, Failure> {
    let there = (-FURTHEST..=FURTHEST).contains(&start) && elements >= 1.0;
    if !there {
        let wrong = format!("{elements} elements from {start} m: at least one, from at most {FURTHEST} m, is needed");
        return Err(Failure::Argument(wrong));
    }
    let of_road = |error| in_scene(loaded, error);
    let lattice = Plan::new(&loaded.scene).lattice().map_err(of_road)?;
    road_limits(&loaded.scene).check(elements * lattice.cells() as f64).map_err(of_road)?;
    Ok(Sample::of(loaded, start, elements as usize)?)
}

/// Heights \[m\] with their coordinates along and across \[m\].
#[pyfunction]
pub(super) fn heights<'py>(py: Python<'py>, scene: &Scene, start: f64, length: f64) -> PyResult<Bound<'py, PyDict>> {
    let loaded = &scene.loaded;
    let Sample { lattice, first, heights } = carried_out(py, None, None, |_| {
        let element = loaded.scene.tyre.circumference / loaded.scene.numerics.elements as f64;
        sample(loaded, start, (length / element).ceil())
    })?;
    let rows = heights.len() / lattice.columns;
    let along = (0..rows as i64).map(|row| lattice.place(first * lattice.along as i64 + row, 1.0));
    let across = (0..lattice.columns).map(|column| lattice.y(column));
    let found = PyDict::new(py);
    found.set_item("x", along.collect::<Vec<_>>().into_pyarray(py))?;
    found.set_item("y", across.collect::<Vec<_>>().into_pyarray(py))?;
    found.set_item("heights", heights.into_pyarray(py).reshape((rows, lattice.columns))?)?;
    Ok(found)
}

/// S \[m\] of slices of a scene's road at penetrations \[m\], by law: \[slices, penetrations\].
#[pyfunction]
pub(super) fn slice_displacements<'py>(
    py: Python<'py>,
    scene: &Scene,
    start: f64,
    count: usize,
    at: Vec<f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let loaded = &scene.loaded;
    let by_law = carried_out(py, None, None, |_| {
        let curves = sample(loaded, start, count as f64)?.curves(loaded.scene.contact.slice_tolerance)?;
        let [winkler, half_space] = curves.map(|curves| {
            let row =
                |curve: &crate::road::slices::StiffnessCurve| at.iter().map(|&y| curve.displacement_at(y)).collect();
            shaped(curves.iter().map(row).collect(), at.len())
        });
        Ok([winkler?, half_space?])
    })?;
    let found = PyDict::new(py);
    for ((_, name), rows) in LAWS.iter().zip(by_law) {
        found.set_item(name, rows.into_pyarray(py))?;
    }
    Ok(found)
}

/// Description of a scene's road, as JSON.
#[pyfunction]
pub(super) fn road_description(py: Python<'_>, scene: &Scene) -> PyResult<String> {
    let loaded = &scene.loaded;
    carried_out(py, None, None, |_| {
        let road = described(&Plan::new(&loaded.scene)).map_err(|error| in_scene(loaded, error))?;
        let to_json = serde_json::to_value(road).map_err(|error| Failure::Inside(error.to_string()));
        to_json.map(|mut road| {
            // Heights are given as arrays, not as text.
            road.as_object_mut().map(|road| road.remove("sample"));
            road.to_string()
        })
    })
}
