//! What `joint` does, on models and logs in memory.

use std::path::PathBuf;

use clap::ValueEnum;
use host_harness::discover::discover_beside;
use host_harness::identify as refit;
use host_harness::model::Model as Joint;
use host_harness::preflight::{self, Severity};
use host_harness::report::{self, Source};
use host_harness::verb::{Scalar, observe as observer, simulate as run};
use indicatif::ProgressBar;
use joint_core::effect::Kind;
use pyo3::prelude::*;

use crate::columns::{Log, Named, named, parsed};
use crate::model::Model;
use crate::raised;
use crate::running::running;

type Columns<'py> = Named<'py>;

/// Stops at what a model and a log cannot both mean, and gives the rest as warnings.
fn checked(model: &Joint, log: &Log, anyway: bool) -> PyResult<Vec<String>> {
    let findings = preflight::findings(model, &log.log);
    let told = |finding: &preflight::Finding| match finding.help.as_str() {
        "" => finding.message.clone(),
        help => format!("{}\n  help: {help}", finding.message),
    };
    let of = |severity| findings.iter().filter(move |own| own.severity == severity).map(told);
    let errors: Vec<String> = of(Severity::Error).collect();
    if !errors.is_empty() && !anyway {
        let errors = errors.join("\n");
        return Err(raised(format!(
            "{errors}\n  (anyway=True goes on in spite of it, where there is enough to fit)"
        )));
    }
    Ok(errors.into_iter().chain(of(Severity::Warning)).collect())
}

/// The findings of the pre-flight and what the log can tell, as JSON.
#[pyfunction]
pub(crate) fn check(py: Python<'_>, model: &Model, log: &Log) -> PyResult<String> {
    let (model, log) = (model.0.clone(), log.log.clone());
    running(py, move || {
        let excitation = preflight::excitation(&preflight::Case::new(&model, &log));
        let findings = preflight::findings(&model, &log);
        serde_json::json!({"findings": findings, "excitation": excitation}).to_string()
    })
}

/// Of logs and other records: `verdict.json`, the improved model, `residuals.csv` as columns, the report, and warnings.
#[pyfunction]
pub(crate) fn discover<'py>(
    py: Python<'py>,
    model: &Model,
    logs: (Vec<PyRef<'py, Log>>, Vec<PyRef<'py, Log>>),
    without: Vec<String>,
    anyway: bool,
) -> PyResult<(String, Model, Columns<'py>, String, Vec<String>)> {
    let kind = |name: &String| {
        Kind::from_name(name).ok_or_else(|| {
            let known: Vec<&str> = Kind::ALL.iter().map(|kind| kind.spec().kind).collect();
            raised(format!(
                "{name}: no such kind of effect\n  help: the kinds are {}",
                known.join(", ")
            ))
        })
    };
    let kinds = without.iter().map(kind).collect::<PyResult<Vec<_>>>()?;
    let (logs, others) = logs;
    let mut warnings = Vec::new();
    for log in logs.iter().chain(&others) {
        warnings.extend(checked(&model.0, log, anyway)?);
    }
    let owned =
        |logs: &[PyRef<'py, Log>]| logs.iter().map(|log| log.log.clone()).collect::<Vec<_>>();
    let (logs, others) = (owned(&logs), owned(&others));
    let model = model.0.clone();
    let (findings, page) = running(py, move || {
        let findings = discover_beside(&model, (&logs, &others), &kinds, &ProgressBar::hidden())?;
        let transfer = if others.is_empty() { "" } else { ", transfer=others" };
        let command = format!("joint_model.discover(logs, model{transfer})");
        let source = Source::in_memory(command, &model, &logs);
        let page = report::html(&findings, &logs, &source);
        Ok((findings, page))
    })?
    .map_err(|error: host_harness::discover::DiscoverError| raised(error))?;
    let verdict = serde_json::to_string(&findings.verdict).map_err(raised)?;
    let residuals = parsed(&report::residuals_csv(&findings))?;
    Ok((verdict, Model(findings.improved), named(py, &residuals), page, warnings))
}

/// `identify.json`, the refitted model, the report, and warnings.
#[pyfunction]
pub(crate) fn identify(
    py: Python<'_>,
    model: &Model,
    log: &Log,
    anyway: bool,
) -> PyResult<(String, Model, String, Vec<String>)> {
    let mut warnings = checked(&model.0, log, anyway)?;
    let (model, log) = (model.0.clone(), log.log.clone());
    let (json, refitted, page, timing) = running(py, move || {
        let found = refit::identified(&model, std::slice::from_ref(&log), None)?;
        let source = Source::in_memory(
            "joint_model.identify(log, model)".to_owned(),
            &model,
            std::slice::from_ref(&log),
        );
        let page = found.report(&model, &log, &source);
        Ok((found.json().to_string(), found.model().clone(), page, found.timing()))
    })?
    .map_err(|error: host_harness::discover::DiscoverError| raised(error))?;
    warnings.extend(timing.map(str::to_owned));
    Ok((json, Model(refitted), page, warnings))
}

/// The columns of the log with every state, and notes.
#[pyfunction]
pub(crate) fn simulate<'py>(
    py: Python<'py>,
    model: &Model,
    log: &Log,
    method: &str,
    scalar: &str,
    step_us: Option<f64>,
    from_rest: bool,
) -> PyResult<(Columns<'py>, Vec<String>)> {
    if step_us.is_some_and(|step| !(step.is_finite() && step > 0.0)) {
        return Err(raised("step_us must be a number above zero"));
    }
    let args = run::Args {
        model: PathBuf::from(&model.0.name),
        input: PathBuf::from("log"),
        out: PathBuf::new(),
        method: choice(method, "method")?,
        scalar: choice(scalar, "scalar")?,
        step_us,
        from_rest,
    };
    let (model, log) = (model.0.clone(), log.log.clone());
    let (columns, notes) = running(py, move || {
        let mut notes = Vec::new();
        let columns = run::simulated(&args, &model, &log, &mut |note| notes.push(note.to_owned()));
        columns.map(|columns| (columns, notes))
    })?
    .map_err(raised)?;
    Ok((named(py, &columns), notes))
}

/// What the observer on a drive makes of the log, as columns, and the flags by sample.
#[pyfunction]
pub(crate) fn observe<'py>(
    py: Python<'py>,
    model: &Model,
    log: &Log,
    scalar: &str,
    rated_load_nm: Option<f64>,
) -> PyResult<(Columns<'py>, Vec<String>)> {
    let scalar: Scalar = choice(scalar, "scalar")?;
    let (model, log) = (model.0.clone(), log.log.clone());
    let text = running(py, move || observer::observed(&model, &log, rated_load_nm, scalar))?
        .map_err(raised)?;
    // The last column is no number.
    let status = |line: &str| line.rsplit(',').next().unwrap_or_default().to_owned();
    let mut columns = parsed(&text)?;
    columns.pop();
    Ok((named(py, &columns), text.lines().skip(1).map(status).collect()))
}

/// A choice by its name on the command line.
fn choice<T: ValueEnum>(name: &str, what: &str) -> PyResult<T> {
    T::from_str(name, false).map_err(|_| {
        let known: Vec<String> = T::value_variants()
            .iter()
            .filter_map(|own| own.to_possible_value().map(|own| own.get_name().to_owned()))
            .collect();
        raised(format!(
            "{what}={name:?}: no such choice\n  help: it is one of {}",
            known.join(", ")
        ))
    })
}
