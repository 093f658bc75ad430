//! Measured machines: what is found in their logs, and whether it holds on records that no fit has seen.
//!
//! A machine is a folder with a `nominal.toml`, a `log.csv` (or several logs of one joint under any names),
//! and other records of it in `transfer`. Nothing is known of what its logs hide, so there is nothing to
//! score: what counts is what is named, how much it explains, and the free runs before and after.

use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::discover::findings::{Findings, Verdict};
use crate::log::Log;
use crate::plant::BuildError;
use crate::transfer::{Transfer, transfer};

/// The files of a machine.
#[derive(Clone, Debug, PartialEq)]
pub struct Machine {
    /// Its folder's name.
    pub name: String,
    /// What is known of it.
    pub nominal: PathBuf,
    /// Logs that are fitted to.
    pub logs: Vec<PathBuf>,
    /// Other records.
    pub transfer: Vec<PathBuf>,
}

/// What is told of a machine.
#[derive(Clone, Debug, Serialize)]
pub struct Told {
    /// Its name.
    pub machine: String,
    /// Samples of its logs.
    pub samples: usize,
    /// Length of its logs, s.
    pub duration_s: f64,
    /// What `verdict.json` has.
    pub verdict: Verdict,
    /// Free runs on other records.
    pub transfer: Vec<Other>,
}

/// Free runs of both models on a record that no fit has seen.
#[derive(Clone, Debug, Serialize)]
pub struct Other {
    /// The record's file.
    pub log: String,
    /// Of the refitted nominal.
    pub refitted: Transfer,
    /// Of the improved model.
    pub improved: Transfer,
}

/// The machines in a folder, by name.
///
/// # Errors
/// The folder cannot be read, or has none.
pub fn machines(folder: &Path) -> Result<Vec<Machine>, String> {
    let mut found = Vec::new();
    for path in entries(folder)?.into_iter().filter(|path| path.join("nominal.toml").is_file()) {
        let mut logs = entries(&path)?;
        logs.retain(|file| is_log(file));
        if let Some(one) = logs.iter().find(|file| stem(file) == "log") {
            logs = vec![one.clone()];
        }
        let others = path.join("transfer");
        let mut transfer = if others.is_dir() { entries(&others)? } else { Vec::new() };
        transfer.retain(|file| is_log(file));
        let name = path.file_name().map_or(String::new(), |name| name.to_string_lossy().into());
        if logs.is_empty() {
            return Err(format!("{}: no log; put a log.csv beside nominal.toml", path.display()));
        }
        found.push(Machine { name, nominal: path.join("nominal.toml"), logs, transfer });
    }
    match found.is_empty() {
        true => Err(format!(
            "{}: no machine; each has a folder with nominal.toml and log.csv",
            folder.display()
        )),
        false => Ok(found),
    }
}

fn entries(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let told = |error: std::io::Error| format!("{}: {error}", folder.display());
    let mut all = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(told)? {
        all.push(entry.map_err(told)?.path());
    }
    all.sort();
    Ok(all)
}

fn is_log(path: &Path) -> bool {
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    path.is_file() && (name.ends_with(".csv") || name.ends_with(".csv.gz"))
}

/// A file's name up to its first dot.
fn stem(path: &Path) -> String {
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    name.split('.').next().unwrap_or_default().to_owned()
}

/// What is told of a machine by what was found in its logs.
///
/// # Errors
/// A model cannot be built.
pub fn told(
    machine: &Machine,
    logs: &[Log],
    findings: &Findings,
    others: &[(PathBuf, Log)],
) -> Result<Told, BuildError> {
    let other = |(path, log): &(PathBuf, Log)| -> Result<Other, BuildError> {
        Ok(Other {
            log: stem(path),
            refitted: transfer(&findings.refitted, log)?,
            improved: transfer(&findings.improved, log)?,
        })
    };
    let length = |log: &Log| log.time_s.last().unwrap_or(&0.0) - log.time_s.first().unwrap_or(&0.0);
    Ok(Told {
        machine: machine.name.clone(),
        samples: logs.iter().map(Log::len).sum(),
        duration_s: logs.iter().map(length).sum(),
        verdict: findings.verdict.clone(),
        transfer: others.iter().map(other).collect::<Result<_, _>>()?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_machine_is_a_folder_with_a_nominal_and_logs() {
        let folder = tempfile::tempdir().unwrap();
        let put = |name: &str| {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, "").unwrap();
        };
        assert!(machines(folder.path()).unwrap_err().contains("no machine"));
        for name in
            ["b/nominal.toml", "b/one.csv", "b/two.csv.gz", "b/README.md", "b/old/three.csv"]
        {
            put(name);
        }
        for name in
            ["a/nominal.toml", "a/log.csv", "a/else.csv", "a/transfer/fast.csv", "c/log.csv"]
        {
            put(name);
        }
        let found = machines(folder.path()).unwrap();
        let names = |paths: &[PathBuf]| paths.iter().map(|path| stem(path)).collect::<Vec<_>>();
        assert_eq!(found.len(), 2);
        assert_eq!(
            (names(&found[0].logs), names(&found[0].transfer)),
            (vec!["log".to_owned()], vec!["fast".to_owned()])
        );
        assert_eq!(names(&found[1].logs), ["one", "two"]);
        put("d/nominal.toml");
        assert!(machines(folder.path()).unwrap_err().contains("d: no log"));
    }
}
