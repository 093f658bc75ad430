//! Reading what a verb is given.

use std::path::Path;

use clap::ValueEnum;

use super::Failure;
use crate::log::{Log, Need};
use crate::model::Model;
use crate::plant::ScalarKind;

/// Which number a verb computes in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Scalar {
    /// Double precision
    F64,
    /// Single precision, bit for bit as on the drive
    F32,
    /// Fixed point, bit for bit as on a drive without a floating-point unit
    Fixed,
}

impl From<Scalar> for ScalarKind {
    fn from(scalar: Scalar) -> Self {
        match scalar {
            Scalar::F64 => Self::F64,
            Scalar::F32 => Self::F32,
            Scalar::Fixed => Self::Fixed,
        }
    }
}

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
