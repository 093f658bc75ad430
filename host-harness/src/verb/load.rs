//! Reading what a verb is given.

use std::path::Path;

use clap::ValueEnum;

use super::Failure;
use crate::log::{Log, Need, line_of_row};
use crate::model::Model;
use crate::plant::ScalarKind;
use crate::preflight::{self, Finding, Severity};

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

/// Reads a log, with what is ignored in it and what it shows of its own mistakes on standard error.
///
/// # Errors
/// What is wrong with the file.
pub fn read_log(path: &Path, need: Need) -> Result<Log, Failure> {
    let log = read_plain(path, need)?;
    for finding in preflight::recording(&log) {
        eprintln!("warning: {}", told([path, path], &finding));
    }
    Ok(log)
}

/// Reads a log, with what is ignored in it on standard error.
fn read_plain(path: &Path, need: Need) -> Result<Log, Failure> {
    let loaded = Log::read(path, need)?;
    for warning in &loaded.warnings {
        eprintln!("warning: {}: {warning}", path.display());
    }
    Ok(loaded.log)
}

/// Reads a log and asks whether it and the model can speak of the same joint, before anything is fitted;
/// `anyway` tells errors as warnings.
///
/// # Errors
/// What is wrong with the file, or what log and model cannot both mean.
pub(super) fn read_checked(
    path: &Path,
    (model_path, model): (&Path, &Model),
    anyway: bool,
) -> Result<Log, Failure> {
    let log = read_plain(path, Need::Drive)?;
    let findings = preflight::findings(model, &log);
    let errors = || findings.iter().filter(|finding| finding.severity == Severity::Error);
    if errors().next().is_some() && !anyway {
        let all: Vec<String> = errors().map(|finding| told([model_path, path], finding)).collect();
        return Err(Failure::input(format!(
            "{}\n  (--anyway goes on in spite of it, where there is enough to fit)",
            all.join("\n")
        )));
    }
    for finding in findings.iter().filter(|finding| finding.severity != Severity::Note) {
        eprintln!("warning: {}", told([model_path, path], finding));
    }
    Ok(log)
}

/// A finding with its file, the model's or the log's, its line and what to do.
pub(super) fn told([model, log]: [&Path; 2], finding: &Finding) -> String {
    let path = if finding.of_model { model } else { log };
    let line = finding.row.and_then(|row| line_of_row(path, row));
    let line = line.map(|line| format!(":{line}")).unwrap_or_default();
    let help = match finding.help.as_str() {
        "" => String::new(),
        help => format!("\n  help: {help}"),
    };
    format!("{}{line}: {}{help}", path.display(), finding.message)
}
