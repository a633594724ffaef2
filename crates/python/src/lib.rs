//! The native half of the Python package `tribos`: what takes time or must agree with the command to the last digit. Types,
//! pictures and documentation for people are in `python/tribos`.
//!
//! ```text
//! recording    columns as NumPy arrays
//! model        model.toml: predict, simulate, friction
//! results      an identification and a diagnosis, as JSON, HTML and series
//! laws         every law and effect of `friction` over arrays
//! work         long work without the GIL, with progress and Ctrl-C
//! errors       failures as exceptions, in the words of the command
//! ```
#![forbid(unsafe_code)]

mod arrays;
mod errors;
mod laws;
mod model;
mod recording;
mod results;
mod work;

use pyo3::prelude::*;

/// Native half of `tribos`; import `tribos` instead.
#[pymodule]
fn _tribos(m: &Bound<'_, PyModule>) -> PyResult<()> {
    m.add("__version__", env!("CARGO_PKG_VERSION"))?;
    m.add("TribosError", m.py().get_type::<errors::TribosError>())?;
    m.add("RecordingError", m.py().get_type::<errors::RecordingError>())?;
    m.add("ModelError", m.py().get_type::<errors::ModelError>())?;
    m.add_class::<recording::Recording>()?;
    m.add_class::<model::Model>()?;
    m.add_class::<results::Identification>()?;
    m.add_class::<results::Diagnosis>()?;
    m.add_function(wrap_pyfunction!(recording::read, m)?)?;
    m.add_function(wrap_pyfunction!(results::identify_recordings, m)?)?;
    m.add_function(wrap_pyfunction!(results::diagnose_recordings, m)?)?;
    m.add_function(wrap_pyfunction!(laws::laws, m)?)?;
    m.add_function(wrap_pyfunction!(laws::effects, m)?)?;
    m.add_function(wrap_pyfunction!(laws::law_force, m)?)?;
    m.add_function(wrap_pyfunction!(laws::effect_force, m)?)
}
