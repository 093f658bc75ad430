//! `joint check`: whether a model and logs can speak of the same joint, before anything is fitted.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use serde_json::json;

use super::load::told;
use super::{Common, Failure, Outcome, read_model};
use crate::log::{Log, Need};
use crate::model::Model;
use crate::preflight::{self, CHECKS, Case, Finding, Severity};

/// Check a model and logs against each other, without a fit
///
/// Units, signs, gear ratio, timing, what the model lacks and what the log can tell: errors are what log and model cannot both mean, warnings what would bias a fit, notes what was
/// measured. `discover` and `identify` ask the same and stop at errors. Exit code 1 where there is an
/// error.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Example:
  joint check --model arm.toml --log arm.csv")]
pub struct Args {
    /// Model file
    #[arg(short = 'm', long, value_name = "TOML")]
    pub model: PathBuf,
    /// Logs of the joint; - is standard input
    #[arg(short = 'l', long, value_name = "CSV", required = true, num_args = 1..)]
    pub log: Vec<PathBuf>,
}

/// Runs the verb.
///
/// # Errors
/// Bad input.
pub fn run(args: &Args, _: &Common) -> Result<Outcome, Failure> {
    let model = read_model(&args.model)?;
    let (mut text, mut logs, mut passed) = (String::new(), Vec::new(), true);
    for path in &args.log {
        let loaded = Log::read(path, Need::Drive)?;
        let findings = preflight::findings(&model, &loaded.log);
        passed &= findings.iter().all(|finding| finding.severity != Severity::Error);
        for warning in &loaded.warnings {
            let _ = writeln!(text, "note: {}: {warning}", path.display());
        }
        for finding in &findings {
            let _ = writeln!(
                text,
                "{}: {}",
                finding.severity.name(),
                told([&args.model, path], finding)
            );
        }
        logs.push(object(path, &model, &loaded.log, &loaded.warnings, &findings));
    }
    let count = |severity: Severity| {
        let of = |log: &serde_json::Value| {
            let findings = log["findings"].as_array().into_iter().flatten();
            findings.filter(|finding| finding["severity"] == severity.name()).count()
        };
        logs.iter().map(of).sum::<usize>()
    };
    let (errors, warnings) = (count(Severity::Error), count(Severity::Warning));
    let _ = write!(
        text,
        "{} checks on {} logs: {errors} errors, {warnings} warnings",
        CHECKS.len(),
        args.log.len()
    );
    let json = json!({"model": args.model, "errors": errors, "warnings": warnings, "logs": logs});
    Ok(Outcome { json, text, passed })
}

fn object(
    path: &Path,
    model: &Model,
    log: &Log,
    ignored: &[String],
    findings: &[Finding],
) -> serde_json::Value {
    json!({
        "log": path,
        "ignored": ignored,
        "findings": findings,
        "excitation": preflight::excitation(&Case::new(model, log)),
    })
}
