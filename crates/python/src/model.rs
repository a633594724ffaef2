//! Models: files, prediction, simulation, friction.

use crate::recording::{self, Recording};
use crate::{arrays, errors, laws, work};
use numpy::PyArray1;
use procedures::{predicted, simulated};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

/// A model, unchangeable.
#[pyclass(frozen, module = "tribos._tribos")]
pub(crate) struct Model {
    pub(crate) inner: Arc<identify::Model>,
}

impl From<identify::Model> for Model {
    fn from(model: identify::Model) -> Self {
        Self { inner: Arc::new(model) }
    }
}

/// Force of a prediction, notes, and the residual's root mean square and share of the force.
type Predicted<'py> = (Bound<'py, PyArray1<f64>>, Vec<String>, Option<(f64, f64)>);

#[pymethods]
impl Model {
    #[staticmethod]
    fn read(path: PathBuf) -> PyResult<Self> {
        Ok(identify::Model::read(path).map_err(errors::model)?.into())
    }

    #[staticmethod]
    fn from_toml(text: &str, file: &str) -> PyResult<Self> {
        Ok(identify::Model::from_toml(file, text).map_err(errors::model)?.into())
    }

    fn to_toml(&self) -> String {
        self.inner.to_toml()
    }

    fn write(&self, path: PathBuf) -> PyResult<()> {
        self.inner.validate().map_err(errors::model)?;
        recording::write(&path, &self.inner.to_toml())
    }

    #[getter]
    fn name(&self) -> &str {
        &self.inner.name
    }

    #[getter]
    fn geometry(&self) -> &'static str {
        recording::geometry(self.inner.geometry)
    }

    #[getter]
    fn mass(&self) -> f64 {
        self.inner.mass
    }

    #[getter]
    fn law(&self) -> &'static str {
        self.inner.law.id()
    }

    /// What the device takes, by name; numbers as text.
    #[getter]
    fn preset(&self) -> Vec<(String, String)> {
        self.inner.preset_lines()
    }

    #[getter]
    fn std(&self) -> BTreeMap<String, f64> {
        self.inner.std.clone()
    }

    fn predict<'py>(
        &self,
        py: Python<'py>,
        recording: PyRef<'_, Recording>,
        absolute: bool,
    ) -> PyResult<Predicted<'py>> {
        let (model, recording) = (Arc::clone(&self.inner), Arc::clone(&recording.inner));
        let made = work::run(py, None, move |_| {
            predicted::predict(&model, &recording, absolute).map_err(|e| errors::of_procedure(&e))
        })??;
        Ok((arrays::array(py, made.force), made.notes, made.errors.residual()))
    }

    fn simulate(
        &self,
        py: Python<'_>,
        motion: &str,
        seconds: f64,
        seed: u64,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Recording> {
        let motion: client::Move = motion.parse().map_err(|e| errors::option("move", e))?;
        if !(seconds > 0.0 && seconds <= 3600.0) {
            return Err(errors::option("seconds", format!("{seconds}: above 0 and up to 3600 is accepted")));
        }
        self.inner.validate().map_err(errors::model)?;
        let model = Arc::clone(&self.inner);
        let made = work::run(py, progress, move |watched| {
            simulated::recording(&model, &motion, seconds, seed, watched)
                .map_err(|e| errors::of_procedure(&e))
        })??;
        Ok(made.into())
    }

    /// Friction of law, effects and curves along a motion.
    fn friction<'py>(
        &self,
        py: Python<'py>,
        motion: &Bound<'_, PyDict>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let series = laws::Series::of(motion)?;
        let slide = simulated::slide_of(&self.inner).map_err(errors::model)?;
        let force = py.detach(move || series.force(&slide)).map_err(errors::model)?;
        Ok(arrays::array(py, force))
    }
}
