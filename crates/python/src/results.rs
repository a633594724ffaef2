//! An identification and a diagnosis: JSON as the command writes it, the report, series for pictures.

use crate::model::Model;
use crate::recording::{Recording, json, owned};
use crate::{arrays, errors, work};
use diagnose::{Options, diagnose_watched};
use procedures::identified::{How, Identified};
use procedures::recordings::model_name;
use procedures::{diagnosed, identified};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// What was identified.
#[pyclass(frozen, module = "tribos._tribos")]
pub(crate) struct Identification {
    inner: Identified,
}

/// Identifies recordings as one set of parameters.
#[pyfunction]
#[pyo3(name = "identify")]
pub(crate) fn identify_recordings(
    py: Python<'_>,
    recordings: Vec<PyRef<'_, Recording>>,
    law: &str,
    preprocess: &str,
    cutoff: Option<f64>,
    delta_v: Option<f64>,
    least_squares: bool,
) -> PyResult<Identification> {
    let how = How {
        law: law.parse().map_err(|e| errors::of_procedure(&e))?,
        preprocess: preprocess.parse().map_err(|e| errors::of_procedure(&e))?,
        cutoff_hz: cutoff,
        delta_v,
        least_squares,
    };
    let recordings = owned(&recordings);
    let inner = work::run(py, None, move |watched| {
        identified::identify_watched(&recordings, &how, watched).map_err(|e| errors::of_procedure(&e))
    })??;
    Ok(Identification { inner })
}

#[pymethods]
impl Identification {
    fn json(&self) -> PyResult<String> {
        json(&self.inner.found)
    }

    fn html(&self) -> String {
        self.inner.report()
    }

    #[getter]
    fn name(&self) -> &str {
        &self.inner.name
    }

    fn model(&self) -> Model {
        self.inner.model.clone().into()
    }

    /// `time`, `velocity`, `force`, `predicted` and `friction`, one value a sample.
    fn series<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let shown = self.inner.shown();
        arrays::dict(
            py,
            [
                ("time", shown.time),
                ("velocity", shown.velocity),
                ("force", shown.force),
                ("predicted", shown.predicted),
                ("friction", shown.friction),
            ],
        )
    }
}

/// What was diagnosed.
#[pyclass(frozen, module = "tribos._tribos")]
pub(crate) struct Diagnosis {
    name: String,
    model_name: String,
    inner: diagnose::Diagnosis,
}

/// Diagnoses recordings.
#[pyfunction]
#[pyo3(name = "diagnose")]
#[expect(
    clippy::too_many_arguments,
    reason = "the options of the command; `tribos.diagnose` gives them names"
)]
pub(crate) fn diagnose_recordings(
    py: Python<'_>,
    train: Vec<PyRef<'_, Recording>>,
    validate: Vec<PyRef<'_, Recording>>,
    noise: Option<f64>,
    cutoff: Option<f64>,
    per_recording: Vec<String>,
    absolute: bool,
    exclude: Vec<String>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Diagnosis> {
    let nuisance = |id: &String| {
        diagnosed::nuisance(id).map_err(|e| errors::option("per_recording", format!("`{id}`: {e}")))
    };
    let options = Options {
        declared_noise: noise,
        cutoff_hz: cutoff,
        exclude,
        per_recording: per_recording.iter().map(nuisance).collect::<PyResult<_>>()?,
        absolute,
        ..Options::default()
    };
    diagnosed::check(&options, train.len() + validate.len()).map_err(|e| errors::of_procedure(&e))?;
    let (train, validate) = (owned(&train), owned(&validate));
    let name = train.iter().map(|r| r.name.as_str()).collect::<Vec<_>>().join(", ");
    let model_name = model_name(&train);
    let found = work::run(py, progress, move |watched| {
        diagnose_watched(&train, &validate, &options, &|share, what| watched.tell(share, what))
    })?;
    Ok(Diagnosis { name, model_name, inner: found.map_err(|e| errors::of_diagnosis(&e))? })
}

/// A coordinate, its unit, the samples it is of, and the bins.
type Curve<'py> = (String, String, String, Bound<'py, PyDict>);

#[pymethods]
impl Diagnosis {
    fn json(&self) -> PyResult<String> {
        json(&self.inner)
    }

    fn html(&self) -> String {
        report::diagnosis(&self.inner, &self.name)
    }

    #[getter]
    fn name(&self) -> &str {
        &self.name
    }

    /// None where the recordings cannot be tested.
    fn model(&self) -> Option<Model> {
        let model = self.inner.model.clone()?;
        Some(identify::Model { name: self.model_name.clone(), ..model }.into())
    }

    /// One value a row: behind the filter, without the samples that were left out.
    fn series<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let f = &self.inner.figures;
        arrays::dict(
            py,
            [
                ("time", f.time.clone()),
                ("position", f.position.clone()),
                ("velocity", f.velocity.clone()),
                ("force", f.force.clone()),
                ("before", f.before.clone()),
                ("after", f.after.clone()),
            ],
        )
    }

    /// Mean error over a coordinate: its name, its unit, the samples it is of, and `at`, `before`, `after`, `band`.
    fn curves<'py>(&self, py: Python<'py>) -> PyResult<Vec<Curve<'py>>> {
        let one = |c: &diagnose::Curve| {
            let column = |of: fn(&diagnose::Bin) -> f64| c.bins.iter().map(of).collect::<Vec<f64>>();
            let bins = arrays::dict(
                py,
                [
                    ("at", column(|b| b.at)),
                    ("before", column(|b| b.before)),
                    ("after", column(|b| b.after)),
                    ("band", column(|b| b.band)),
                ],
            )?;
            Ok((c.coordinate.clone(), c.unit.clone(), c.subset.clone(), bins))
        };
        self.inner.figures.curves.iter().map(one).collect()
    }
}
