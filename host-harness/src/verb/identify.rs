//! `joint identify`: the parameters of a model, refitted to a log.

use std::fmt::Write as _;
use std::path::PathBuf;

use nalgebra::DMatrix;
use serde_json::{Map, json};

use super::load::read_checked;
use super::{Common, Failure, Outcome, read_model};
use crate::discover::DiscoverError;
use crate::discover::findings::ParameterRow;
use crate::estimate::coordinates::Coordinate;
use crate::estimate::fit::{Fit, Problem};
use crate::estimate::record::Record;
use crate::estimate::refit;
use crate::estimate::timing::{self, asked};
use crate::log::Log;
use crate::model::Model;
use crate::output::OutDir;
use crate::plant::micro_steps;
use crate::preflight::LEAST_SAMPLES;
use crate::report::{self, Refit, Source, quoted};

/// Refit a model to a log, with standard errors and what the log cannot determine
///
/// Writes `model.toml`, `identify.json` and `report.html`.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Example:
  joint identify --model arm.toml --log arm.csv --out refit")]
pub struct Args {
    /// Model file
    #[arg(short = 'm', long, value_name = "TOML")]
    pub model: PathBuf,
    /// Log to refit on; - is standard input
    #[arg(short = 'l', long, value_name = "CSV")]
    pub log: PathBuf,
    /// Folder for the result
    #[arg(short = 'o', long, value_name = "DIR")]
    pub out: PathBuf,
    /// Go on where log and model cannot both be right (see `joint check`)
    #[arg(long)]
    pub anyway: bool,
}

/// Runs the verb.
///
/// # Errors
/// Bad input, or a result that may not be overwritten.
pub fn run(args: &Args, common: &Common) -> Result<Outcome, Failure> {
    let out = OutDir::new(&args.out, common.force)?
        .apart_from([&args.model, &args.log], &["model.toml", "identify.json", "report.html"])?;
    let model = read_model(&args.model)?;
    let log = read_checked(&args.log, (&args.model, &model), args.anyway)?;
    let bar = common.progress(0, "refitting");
    let found = identified(&model, &log).map_err(|error| match error {
        DiscoverError::Short(samples) => Failure::input(format!(
            "{}: has {samples} samples; give at least {LEAST_SAMPLES}",
            args.log.display()
        )),
        error => Failure::input(format!("{}: {error}", args.model.display())),
    })?;
    bar.finish_and_clear();
    let json = found.json();
    let pretty =
        serde_json::to_string_pretty(&json).map_err(|error| Failure::check(error.to_string()))?;
    out.write("model.toml", found.model().to_toml())?;
    out.write("identify.json", pretty)?;
    out.write("report.html", found.report(&model, &log, &source(args, &out)))?;
    let said = found.timing().map(|told| format!("{told}\n")).unwrap_or_default();
    let path = out.path().join("model.toml");
    out.finish()?;
    let text = format!("{}{said}model: {}", table(&found.rows), path.display());
    Ok(Outcome::done(json, text))
}

/// A model refitted to a log.
pub struct Identified {
    rows: Vec<Row>,
    fit: Fit,
    record: Record,
}

/// Refits a model to a log.
///
/// # Errors
/// The model cannot be built, or the log is too short.
pub fn identified(model: &Model, log: &Log) -> Result<Identified, DiscoverError> {
    if log.len() < LEAST_SAMPLES {
        return Err(DiscoverError::Short(log.len()));
    }
    let coarse = Record::new(log, None);
    let record = coarse.refined(micro_steps(model, coarse.grid.interval(0)).max(2));
    let mask = vec![1.0; record.len()];
    let fitted = |record: &Record| refit::refit(&Problem::new(record, &mask).cautious(), model);
    let (record, fit) = asked(model, record, fitted)?;
    let problem = Problem::new(&record, &mask).cautious();
    let rows = rows(model, &fit, &problem.covariance(&fit));
    Ok(Identified { rows, fit, record })
}

impl Identified {
    /// The refitted model.
    pub fn model(&self) -> &Model {
        &self.fit.model
    }

    /// `identify.json`.
    pub fn json(&self) -> serde_json::Value {
        result(&self.rows, &self.fit, &self.record)
    }

    /// What was found of the log's timing, in a sentence.
    pub fn timing(&self) -> Option<&'static str> {
        timing::told(&self.record)
    }

    /// The report.
    pub fn report(&self, nominal: &Model, log: &Log, source: &Source) -> String {
        let parameters: Vec<_> = self.rows.iter().map(|row| row.shown.clone()).collect();
        let refit = Refit {
            nominal,
            refitted: &self.fit.model,
            parameters: &parameters,
            timing: self.timing(),
        };
        report::refit(&refit, log, source)
    }
}

/// Where the report comes from.
fn source(args: &Args, out: &OutDir) -> Source {
    let command = format!(
        "joint identify --model {} --log {} --out {}{}",
        quoted(&args.model),
        quoted(&args.log),
        quoted(&args.out),
        if args.anyway { " --anyway" } else { "" }
    );
    Source::new(command, &args.model, std::slice::from_ref(&args.log), out)
}

struct Row {
    shown: ParameterRow,
    sigma: f64,
}

fn rows(nominal: &Model, fit: &Fit, covariance: &DMatrix<f64>) -> Vec<Row> {
    let parameters = fit.coordinates.iter().enumerate();
    parameters
        .filter_map(|(k, coordinate)| {
            let Coordinate::Parameter(quantity) = coordinate else { return None };
            let sigma = covariance[(k, k)].sqrt();
            Some(Row {
                shown: ParameterRow::new([nominal, &fit.model, &fit.model], *quantity, sigma),
                sigma: quantity.sigma_of(&fit.model, sigma),
            })
        })
        .collect()
}

fn result(rows: &[Row], fit: &Fit, record: &Record) -> serde_json::Value {
    let parameters: Map<_, _> = rows
        .iter()
        .map(|Row { shown, sigma }| {
            let value = json!({
                "nominal": shown.nominal,
                "value": shown.improved,
                "standard_error": sigma,
                "determined": shown.determined,
            });
            (shown.key.clone(), value)
        })
        .collect();
    let open = rows.iter().filter(|row| !row.shown.determined);
    let open: Vec<&str> = open.map(|row| row.shown.key.as_str()).collect();
    json!({
        "parameters": parameters,
        "not_determined": open,
        "noise": {
            "drive": fit.noise.drive,
            "rotor_torque_nm": fit.noise.torque,
            "output_torque_at_motor_nm": fit.noise.output,
            "sensors": fit.noise.sensors,
        },
        "current_lead_s": record.lead_s,
        "deviance": fit.deviance,
    })
}

fn table(rows: &[Row]) -> String {
    let mut text = String::new();
    let _ = writeln!(text, "{:44} {:>12} {:>12} {:>10}", "parameter", "nominal", "refitted", "±");
    for Row { shown, sigma } in rows {
        let note = if shown.determined { "" } else { "  not determined by this log" };
        let _ = writeln!(
            text,
            "{:44} {:>12.5e} {:>12.5e} {:>10.1e}{note}",
            shown.key, shown.nominal, shown.improved, sigma
        );
    }
    text
}
