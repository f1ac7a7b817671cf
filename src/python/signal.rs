//! Signals: levels of any, and the sounds of a results folder as pressures.

use hound::{SampleFormat, WavReader};
use numpy::{IntoPyArray, PyArray2, PyArrayMethods, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::error::Failure;
use super::work::carried_out;
use crate::response::{BandLevel, PowerSpectrum};
use crate::sound::wav::full_scale_of;

/// Third-octave levels of a signal: nominal frequency, mid-frequency \[Hz\], mean square, level \[dB\].
#[pyfunction]
#[pyo3(signature = (signal, time_step, reference, lowest, segment=None))]
pub(super) fn third_octaves<'py>(
    py: Python<'py>,
    signal: PyReadonlyArray1<'py, f64>,
    time_step: f64,
    reference: f64,
    lowest: f64,
    segment: Option<f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let signal: Vec<f64> = signal.as_array().to_vec();
    let levels = carried_out(py, None, None, |_| {
        if !(reference > 0.0 && reference.is_finite()) {
            return Err(Failure::Argument(format!("reference is {reference}: a positive number is needed")));
        }
        Ok(PowerSpectrum::of(&signal, time_step, segment)?.third_octaves(lowest, reference))
    })?;
    let found = PyDict::new(py);
    let column = |value: fn(&BandLevel) -> f64| levels.iter().map(value).collect::<Vec<_>>().into_pyarray(py);
    found.set_item("nominal_hz", column(|level| level.band.nominal_frequency()))?;
    found.set_item("mid_frequency_hz", column(|level| level.band.mid_frequency()))?;
    found.set_item("mean_square", column(|level| level.mean_square))?;
    found.set_item("level_db", column(|level| level.level))?;
    Ok(found)
}

/// Content of a sound file that states its full scale in pascals: samples per second, and pressures \[Pa\], \[samples,
/// channels\].
#[pyfunction]
pub(super) fn read_sound<'py>(py: Python<'py>, name: &str, file: &[u8]) -> PyResult<(u32, Bound<'py, PyArray2<f64>>)> {
    let unusable = |what: &dyn std::fmt::Display| Failure::Argument(format!("{name}: {what}")).raised(py);
    let full_scale = full_scale_of(file).ok_or_else(|| unusable(&"a sound file without its full scale in pascals"))?;
    let mut sound = WavReader::new(file).map_err(|error| unusable(&error))?;
    let spec = sound.spec();
    let unit = full_scale * 2.0_f64.powi(1 - i32::from(spec.bits_per_sample));
    let pressures: Result<Vec<f64>, hound::Error> = match spec.sample_format {
        SampleFormat::Int => sound.samples::<i32>().map(|sample| Ok(unit * f64::from(sample?))).collect(),
        SampleFormat::Float => sound.samples::<f32>().map(|sample| Ok(full_scale * f64::from(sample?))).collect(),
    };
    let pressures = pressures.map_err(|error| unusable(&error))?;
    let channels = usize::from(spec.channels);
    let shape = (pressures.len() / channels.max(1), channels);
    Ok((spec.sample_rate, pressures.into_pyarray(py).reshape(shape)?))
}
