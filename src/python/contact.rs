//! Contact of single slices, and of rough bodies with a half-space.

use numpy::{IntoPyArray, PyArrayMethods, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::error::Failure;
use super::work::{carried_out, shaped};
use crate::half_space::rough::{
    Extent, HeightMap, Indentation, IndentationControl, IndentationLimits, indent as press,
};
use crate::road::slices::{SliceBuilder, SliceScratch};
use crate::study::slices::LAWS;

/// Index of a slice law by its name; refuses other names.
fn law_number(law: &str) -> Result<usize, Failure> {
    let names = || LAWS.map(|(_, name)| format!("\"{name}\"")).join(" or ");
    let found = LAWS.iter().position(|(_, name)| *name == law);
    found.ok_or_else(|| Failure::Argument(format!("law is \"{law}\": {} is known", names())))
}

/// S \[m\], s and pressure over E* of one slice at penetrations \[m\].
#[pyfunction]
pub(super) fn slice_curve<'py>(
    py: Python<'py>,
    heights: Vec<f64>,
    cell: [f64; 2],
    law: &str,
    at: Vec<f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let (curve, pressures) = carried_out(py, None, None, |_| {
        let [dx, dy] = cell;
        if let Some(value) = cell.iter().find(|value| !(**value > 0.0 && value.is_finite())) {
            return Err(Failure::Argument(format!("a cell of {value} m: positive lengths are needed")));
        }
        let builder = match law_number(law)? {
            0 => SliceBuilder::winkler(heights.len())?,
            _ => SliceBuilder::half_space(heights.len(), dx, dy)?,
        };
        let (curve, pressures) = builder.build_with_pressures(&heights, dx, dy, &at, &mut SliceScratch::default())?;
        Ok((curve, shaped(pressures, heights.len())?))
    })?;
    let found = PyDict::new(py);
    let displacement: Vec<f64> = at.iter().map(|&y| curve.displacement_at(y)).collect();
    let stiffness: Vec<f64> = at.iter().map(|&y| curve.stiffness_at(y)).collect();
    found.set_item("penetration", at.into_pyarray(py))?;
    found.set_item("displacement", displacement.into_pyarray(py))?;
    found.set_item("stiffness", stiffness.into_pyarray(py))?;
    found.set_item("pressure", pressures.into_pyarray(py))?;
    Ok(found)
}

/// A rough body pressed into a half-space of effective modulus E* \[Pa\].
#[pyfunction]
#[pyo3(signature = (heights, cell, modulus, load=None, penetration=None, tolerance=None))]
pub(super) fn indent<'py>(
    py: Python<'py>,
    heights: PyReadonlyArray2<'py, f64>,
    cell: [f64; 2],
    modulus: f64,
    load: Option<f64>,
    penetration: Option<f64>,
    tolerance: Option<f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let [nx, ny] = [heights.shape()[0], heights.shape()[1]];
    let [dx, dy] = cell;
    let map = HeightMap { heights: heights.as_array().iter().copied().collect(), extent: Extent { nx, ny }, dx, dy };
    let Indentation { pressure, load, penetration, area_fraction, iterations, residual, .. } =
        carried_out(py, None, None, |_| {
            let control = match (load, penetration) {
                (Some(load), None) => IndentationControl::Load(load),
                (None, Some(penetration)) => IndentationControl::Penetration(penetration),
                _ => return Err(Failure::Argument("give either load or penetration".into())),
            };
            let limits = tolerance.map_or_else(IndentationLimits::default, |tolerance| IndentationLimits {
                tolerance,
                ..IndentationLimits::default()
            });
            Ok(press(&map, modulus, control, limits)?)
        })?;
    let found = PyDict::new(py);
    found.set_item("pressure", pressure.into_pyarray(py).reshape((nx, ny))?)?;
    found.set_item("load", load)?;
    found.set_item("penetration", penetration)?;
    found.set_item("area_fraction", area_fraction)?;
    found.set_item("iterations", iterations)?;
    found.set_item("residual", residual)?;
    Ok(found)
}
