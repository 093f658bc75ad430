//! Reading what a verb is given.

use std::path::Path;

use super::Failure;
use crate::log::{Log, Need};
use crate::model::Model;

/// Reads a model file.
///
/// # Errors
/// What is wrong with the file.
pub fn read_model(path: &Path) -> Result<Model, Failure> {
    Ok(Model::read(path)?)
}

/// Reads a log, with what is ignored in it listed once on standard error.
///
/// # Errors
/// What is wrong with the file.
pub fn read_log(path: &Path, need: Need) -> Result<Log, Failure> {
    let loaded = Log::read(path, need)?;
    for warning in &loaded.warnings {
        eprintln!("warning: {}: {warning}", path.display());
    }
    Ok(loaded.log)
}
