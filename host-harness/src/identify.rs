//! Refits of a model to logs of its joint, by prediction or by simulation.

use clap::ValueEnum;
use nalgebra::DMatrix;
use serde_json::{Map, json};

use crate::discover::DiscoverError;
use crate::discover::findings::ParameterRow;
use crate::estimate::coordinates::Coordinate;
use crate::estimate::finer::{FINER, finer};
use crate::estimate::fit::{Fit, Problem};
use crate::estimate::record::{Channel, Record};
use crate::estimate::refit;
use crate::estimate::simulation::{self, Simulated};
use crate::estimate::timing::{self, asked};
use crate::log::Log;
use crate::model::Model;
use crate::plant::micro_steps;
use crate::preflight::LEAST_SAMPLES;
use crate::report::{self, Refit, Source};

/// What a refit makes smallest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Criterion {
    /// Errors of predictions from sample to sample: tells each parameter as well as the log can
    Prediction,
    /// Errors of free runs over windows, effects of the model included: transfers best to other records
    Simulation,
}

/// A model refitted to logs.
pub struct Identified {
    rows: Vec<Row>,
    fit: Fit,
    record: Record,
    simulated: Option<(Simulated, f64)>,
}

/// Refits a model to logs of one joint by prediction; by simulation over windows of so many seconds from there
/// where a window is given.
///
/// # Errors
/// The model cannot be built, the logs impose different things, or one is too short.
pub fn identified(
    model: &Model,
    logs: &[Log],
    window_s: Option<f64>,
) -> Result<Identified, DiscoverError> {
    if let Some(short) = logs.iter().map(Log::len).find(|samples| *samples < LEAST_SAMPLES) {
        return Err(DiscoverError::Short(short));
    }
    let coarse = Record::join(logs, None)?;
    let micro_steps = micro_steps(model, coarse.grid.interval(0)).max(2);
    let record = coarse.refined(micro_steps);
    let mask = vec![1.0; record.len()];
    let fitted = |record: &Record| refit::refit(&Problem::new(record, &mask).cautious(), model);
    let (record, mut fit) = asked(model, record, &mask, fitted)?;
    let problem = Problem::new(&record, &mask).cautious();
    let Some(window_s) = window_s else {
        let covariance = problem.covariance(&fit);
        let steps = record.refined(FINER * micro_steps);
        fit = finer(&Problem::new(&steps, &mask), model, &fit)?;
        fit.model = record.timed(fit.model);
        let rows = rows(model, &fit, &covariance);
        return Ok(Identified { rows, fit, record, simulated: None });
    };
    fit.coordinates.extend(simulation::of_effects(model));
    let starts = [fit.model.clone(), model.clone()];
    let simulated = simulation::fit(&record, model, &starts, &fit.coordinates, window_s)?;
    fit.model = record.timed(simulated.model.clone());
    let rows = rows(model, &fit, &simulated.covariance);
    Ok(Identified { rows, fit, record, simulated: Some((simulated, window_s)) })
}

impl Identified {
    /// The refitted model.
    pub fn model(&self) -> &Model {
        &self.fit.model
    }

    /// `identify.json`.
    pub fn json(&self) -> serde_json::Value {
        let mut json = result(&self.rows, &self.fit, &self.record);
        if let Some((simulated, window_s)) = &self.simulated {
            json["simulation"] = json!({
                "window_s": window_s,
                "windows": simulated.windows,
                "rms_error": errors(simulated),
            });
        }
        json
    }

    /// What the refit and the logs' timing are, in sentences.
    pub fn notes(&self) -> Vec<String> {
        let timing = self.timing().map(str::to_owned);
        let Some((simulated, window_s)) = &self.simulated else { return Vec::from_iter(timing) };
        let signals = errors(simulated);
        let told = signals.iter().filter_map(|(column, errors)| {
            let [before, after] = [0, 1].map(|k| errors[k].as_f64());
            Some(format!("{column} {:.3e} before, {:.3e} after", before?, after?))
        });
        let runs = format!(
            "free runs over {} windows of {window_s} s, RMS error of the refit by prediction and of this one: {}",
            simulated.windows,
            told.collect::<Vec<_>>().join("; ")
        );
        timing.into_iter().chain([runs]).collect()
    }

    /// What was found of the logs' timing, in a sentence.
    pub fn timing(&self) -> Option<&'static str> {
        timing::told(&self.record)
    }

    /// Rows of a table: key, nominal, refitted, one standard error, and whether the logs determine it.
    pub fn parameters(&self) -> impl Iterator<Item = (&str, [f64; 3], bool)> {
        self.rows.iter().map(|Row { shown, sigma }| {
            (&*shown.key, [shown.nominal, shown.improved, *sigma], shown.determined)
        })
    }

    /// The report, with runs beside one of the logs.
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

/// RMS errors of free runs before and after, by log column.
fn errors(simulated: &Simulated) -> Map<String, serde_json::Value> {
    let [before, after] = &simulated.errors;
    let of = |channel: Channel| {
        let c = channel as usize;
        Some((channel.column().to_owned(), json!([before[c]?, after[c]?])))
    };
    Channel::ALL.into_iter().filter_map(of).collect()
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
        "current_lead_s": record.lead_s(),
        "deviance": fit.deviance,
    })
}
