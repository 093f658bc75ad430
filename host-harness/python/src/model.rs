//! A model.

use std::path::{Path, PathBuf};

use host_harness::model::Model as Joint;
use pyo3::prelude::*;

use crate::raised;

/// A joint: its parameters, its sensors, and the effects added to it.
#[pyclass(module = "joint_model._native", frozen, eq)]
#[derive(Clone, PartialEq)]
pub(crate) struct Model(pub(crate) Joint);

#[pymethods]
impl Model {
    /// The same as [`from_toml`](Self::from_toml).
    #[new]
    fn new(text: &str) -> PyResult<Self> {
        Self::from_toml(text)
    }

    /// A model from the text of its TOML file.
    #[staticmethod]
    fn from_toml(text: &str) -> PyResult<Self> {
        Joint::parse(text, Path::new("model")).map(Self).map_err(raised)
    }

    /// A model from its TOML file.
    #[staticmethod]
    fn read(path: PathBuf) -> PyResult<Self> {
        Joint::read(&path).map(Self).map_err(raised)
    }

    /// The text of its TOML file.
    fn to_toml(&self) -> String {
        self.0.to_toml()
    }

    /// Name of the joint.
    #[getter]
    fn name(&self) -> &str {
        &self.0.name
    }

    /// Its gear stages.
    #[getter]
    fn stages(&self) -> usize {
        self.0.stages.len()
    }

    /// Kind and location of every effect.
    #[getter]
    fn effects(&self) -> Vec<(String, String)> {
        let effects = self.0.effects.iter();
        effects
            .map(|effect| (effect.kind.spec().kind.to_owned(), effect.location.to_string()))
            .collect()
    }

    fn __repr__(&self) -> String {
        let effects =
            self.effects().into_iter().map(|(kind, location)| format!("{kind} at {location}"));
        let effects: Vec<String> = effects.collect();
        format!(
            "Model({:?}, {} stages, effects: {})",
            self.0.name,
            self.0.stages.len(),
            if effects.is_empty() { "none".to_owned() } else { effects.join(", ") }
        )
    }

    /// For `pickle` and `copy`.
    fn __getnewargs__(&self) -> (String,) {
        (self.0.to_toml(),)
    }
}
