//! Columns between Rust and NumPy.

use crate::errors;
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Names and NumPy arrays, shape `(n,)`.
pub(crate) fn dict<'py>(
    py: Python<'py>,
    columns: impl IntoIterator<Item = (impl AsRef<str>, Vec<f64>)>,
) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    for (name, values) in columns {
        out.set_item(name.as_ref(), PyArray1::from_vec(py, values))?;
    }
    Ok(out)
}

/// The values of a one-dimensional array, whatever its strides.
pub(crate) fn values(name: &str, array: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    let array: PyReadonlyArray1<'_, f64> =
        array.extract().map_err(|_| errors::option(name, "a one-dimensional array of floats is accepted"))?;
    Ok(array.as_array().to_vec())
}

/// A NumPy array, shape `(n,)`.
pub(crate) fn array(py: Python<'_>, values: Vec<f64>) -> Bound<'_, PyArray1<f64>> {
    PyArray1::from_vec(py, values)
}

/// Marks an array read-only: it may be shared between objects.
pub(crate) fn read_only<'py>(array: Bound<'py, PyArray1<f64>>) -> PyResult<Bound<'py, PyArray1<f64>>> {
    array.call_method1("setflags", (false,))?;
    Ok(array)
}
