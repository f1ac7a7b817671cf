//! Python's dictionaries and numbers as TOML, in which scenes are written.

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyFloat, PyInt, PyMapping, PySequence, PyString};
use toml::Value;

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
