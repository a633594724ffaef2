//! Recordings: files, columns, faults.

use crate::{arrays, errors, work};
use procedures::recordings::read_all_watched;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use signals::{Map, RecordingFault};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

/// A recording, unchangeable.
#[pyclass(frozen, module = "tribos._tribos")]
pub(crate) struct Recording {
    pub(crate) inner: Arc<signals::Recording>,
}

impl From<signals::Recording> for Recording {
    fn from(recording: signals::Recording) -> Self {
        Self { inner: Arc::new(recording) }
    }
}

/// Copies that a job on another thread may keep.
pub(crate) fn owned(recordings: &[PyRef<'_, Recording>]) -> Vec<signals::Recording> {
    recordings.iter().map(|r| (*r.inner).clone()).collect()
}

/// Reads files, each with the map that it needs.
#[pyfunction]
pub(crate) fn read(
    py: Python<'_>,
    paths: Vec<PathBuf>,
    maps: Vec<String>,
    joint: Option<String>,
) -> PyResult<Vec<Recording>> {
    let read = move |watched: &work::Watched| {
        read_all_watched(&paths, &maps, joint.as_deref(), watched).map_err(|e| errors::of_procedure(&e))
    };
    let read = work::run(py, None, read)??;
    Ok(read.into_iter().map(Recording::from).collect())
}

#[pymethods]
impl Recording {
    /// A recording of columns, shape `(n,)` each.
    #[staticmethod]
    fn from_columns(
        name: &str,
        columns: &Bound<'_, PyDict>,
        maps: Vec<String>,
        metadata: BTreeMap<String, String>,
    ) -> PyResult<Self> {
        let parse = |text: &String| text.parse::<Map>().map_err(|e| errors::option("map", e));
        let maps = maps.iter().map(parse).collect::<PyResult<Vec<Map>>>()?;
        let mut named = Vec::with_capacity(columns.len());
        for (column, values) in columns.iter() {
            let column: String = column.extract()?;
            let values = arrays::values(&column, &values)?;
            named.push((column, values));
        }
        let made =
            signals::Recording::from_columns(name, named, &maps).map_err(|e| errors::of_signals(&e))?;
        Ok(signals::Recording { metadata, ..made }.into())
    }

    #[getter]
    fn name(&self) -> &str {
        &self.inner.name
    }

    /// `linear` or `rotary`.
    #[getter]
    fn geometry(&self) -> &'static str {
        geometry(self.inner.geometry)
    }

    #[getter]
    fn metadata(&self) -> BTreeMap<String, String> {
        self.inner.metadata.clone()
    }

    /// What reading did to the numbers.
    #[getter]
    fn remarks(&self) -> Vec<String> {
        self.inner.remarks.clone()
    }

    /// Median time between samples, s.
    #[getter]
    fn sample_period(&self) -> Option<f64> {
        self.inner.sample_period()
    }

    fn __len__(&self) -> usize {
        self.inner.len()
    }

    /// Columns by their names in a CSV file, time first; read-only arrays.
    fn columns<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let out = PyDict::new(py);
        let extra = self.inner.extra.iter().map(|(name, values)| (name.as_str(), values.as_slice()));
        for (name, values) in self.inner.columns().into_iter().chain(extra) {
            out.set_item(name, arrays::read_only(arrays::array(py, values.to_vec()))?)?;
        }
        Ok(out)
    }

    /// Faults that the audit finds, as a JSON list.
    fn faults(&self, py: Python<'_>) -> PyResult<String> {
        let recording = Arc::clone(&self.inner);
        let faults: Vec<RecordingFault> = work::run(py, None, move |_| signals::audit(&recording).faults)?;
        json(&faults)
    }

    /// The text of a CSV file.
    fn to_csv(&self) -> PyResult<String> {
        self.inner.to_csv().map_err(|e| errors::of_signals(&e))
    }

    /// Writes a CSV file, completely or not at all.
    fn write_csv(&self, path: PathBuf) -> PyResult<()> {
        write(&path, &self.to_csv()?)
    }
}

/// Writes a file, completely or not at all.
pub(crate) fn write(path: &std::path::Path, text: &str) -> PyResult<()> {
    signals::files::write(path, text.as_bytes())
        .map_err(|e| pyo3::exceptions::PyOSError::new_err(e.to_string()))
}

/// The JSON of a value.
pub(crate) fn json(value: &impl serde::Serialize) -> PyResult<String> {
    serde_json::to_string_pretty(value).map_err(|e| errors::option("json", e))
}

/// Name in files.
pub(crate) const fn geometry(geometry: signals::Geometry) -> &'static str {
    match geometry {
        signals::Geometry::Linear => "linear",
        signals::Geometry::Rotary => "rotary",
    }
}
