//! The native part of the Python module `joint_model`: columns in and out as bytes, results as JSON.
//!
//! What a Python user sees is in `joint_model/`: data frames, typed results, plots. This part holds what
//! only Rust can do, and no interface of its own: columns are the bytes of f64 in the machine's order, which
//! the stable ABI passes without a copy by element, and results are the very objects that `joint` writes.

#![allow(missing_docs, reason = "the Python side documents what users call")]

mod columns;
mod model;
mod running;
mod verbs;

use pyo3::prelude::*;

pyo3::create_exception!(
    _native,
    JointError,
    pyo3::exceptions::PyValueError,
    "What is wrong with a model or a log, where, and what to do."
);

/// A failure as Python raises it.
fn raised(error: impl std::fmt::Display) -> PyErr {
    JointError::new_err(error.to_string())
}

#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("JointError", module.py().get_type::<JointError>())?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<model::Model>()?;
    module.add_class::<columns::Log>()?;
    module.add_function(wrap_pyfunction!(verbs::check, module)?)?;
    module.add_function(wrap_pyfunction!(verbs::discover, module)?)?;
    module.add_function(wrap_pyfunction!(verbs::identify, module)?)?;
    module.add_function(wrap_pyfunction!(verbs::simulate, module)?)?;
    module.add_function(wrap_pyfunction!(verbs::observe, module)?)
}
