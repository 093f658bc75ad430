//! Columns between Python and Rust: the bytes of f64 in the machine's order.

use std::path::{Path, PathBuf};

use host_harness::log::{Log as Recorded, Need, write_columns};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::raised;

/// A log, checked as `joint` checks its file.
#[pyclass(module = "joint_model._native", frozen)]
pub(crate) struct Log {
    pub(crate) log: Recorded,
    /// What was ignored, a sentence each.
    #[pyo3(get)]
    warnings: Vec<String>,
}

#[pymethods]
impl Log {
    /// A log from its file.
    #[staticmethod]
    fn read(path: PathBuf) -> PyResult<Self> {
        let loaded = Recorded::read(&path, Need::Drive).map_err(raised)?;
        Ok(Self { log: loaded.log, warnings: loaded.warnings })
    }

    /// A log from named columns. They pass through the text of a file, so that they are held to the same
    /// rules and told by line: row 0 is line 2.
    #[staticmethod]
    fn of(columns: Vec<(String, Vec<u8>)>) -> PyResult<Self> {
        let columns: Vec<(String, Vec<f64>)> = columns
            .into_iter()
            .map(|(name, bytes)| {
                let values = bytes.as_chunks::<8>().0.iter().map(|own| f64::from_ne_bytes(*own));
                (name, values.collect())
            })
            .collect();
        let text = write_columns(&columns);
        let loaded =
            Recorded::parse(text.as_bytes(), Path::new("log"), Need::Drive).map_err(raised)?;
        Ok(Self { log: loaded.log, warnings: loaded.warnings })
    }

    fn __len__(&self) -> usize {
        self.log.len()
    }

    /// Its columns by name.
    fn columns<'py>(&self, py: Python<'py>) -> Named<'py> {
        named(py, &self.log.columns())
    }
}

/// Columns as Python is given them.
pub(crate) type Named<'py> = Vec<(String, Bound<'py, PyBytes>)>;

pub(crate) fn named<'py, N: AsRef<str>, V: AsRef<[f64]>>(
    py: Python<'py>,
    columns: &[(N, V)],
) -> Named<'py> {
    let bytes = |values: &[f64]| -> Vec<u8> {
        values.iter().flat_map(|value| value.to_ne_bytes()).collect()
    };
    let columns = columns.iter();
    columns
        .map(|(name, values)| (name.as_ref().to_owned(), PyBytes::new(py, &bytes(values.as_ref()))))
        .collect()
}

/// Columns from the text of a file that this program writes; an empty field is no number.
pub(crate) fn parsed(text: &str) -> PyResult<Vec<(String, Vec<f64>)>> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let names = reader.headers().map_err(raised)?.clone();
    let mut columns: Vec<(String, Vec<f64>)> =
        names.iter().map(|name| (name.to_owned(), Vec::new())).collect();
    for record in reader.records() {
        let record = record.map_err(raised)?;
        for ((_, values), field) in columns.iter_mut().zip(&record) {
            values.push(field.parse().unwrap_or(f64::NAN));
        }
    }
    Ok(columns)
}
