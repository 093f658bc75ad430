//! The observer and the baselines on logs whose truth stands beside them.
//!
//! A case is a folder with `nominal.toml`, an unloaded `calibration.csv` that it is refitted on,
//! the `log.csv` to observe and its `truth.csv`.

use std::path::{Path, PathBuf};

use joint_core::per_unit::Bases;

use super::bench::{Case, Error, judge, observed, truths as truths_of};
use super::bound::{Bounds, Known, bounds};
use super::judge::shown;
use super::noise::drive_noise;
use super::over::Samples;
use super::rating::{Rating, breakaway_nm};
use super::score::{Guess, Judged, Score, jumps};
use super::twin::{Felt, Motion, Style};
use crate::estimate::fit::Problem;
use crate::estimate::record::Record;
use crate::estimate::refit;
use crate::fault::InputError;
use crate::log::{Log, Need};
use crate::model::Model;
use crate::plant::{BuildError, by_stages, micro_steps};

/// The files of a case.
const FILES: [&str; 4] = ["nominal.toml", "calibration.csv", "log.csv", "truth.csv"];

/// Folders within `folder` that hold all files of a case, by name.
///
/// # Errors
/// The folder cannot be read, or holds no case.
pub fn cases(folder: &Path) -> Result<Vec<PathBuf>, InputError> {
    let unreadable = |error: std::io::Error| InputError::unreadable(folder, &error);
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        if FILES.iter().all(|file| path.join(file).is_file()) {
            found.push(path);
        }
    }
    found.sort();
    if found.is_empty() {
        return Err(InputError::new(folder, "holds no case".to_owned())
            .help(format!("a case is a folder with {}", FILES.join(", "))));
    }
    Ok(found)
}

/// A model refitted to an unloaded log.
///
/// # Errors
/// The model cannot be built.
pub fn refitted(model: &Model, calibration: &Log) -> Result<Model, BuildError> {
    let coarse = Record::new(calibration, None);
    let record = coarse.refined(micro_steps(model, coarse.grid.interval(0)).max(2));
    let mask = vec![1.0; record.len()];
    let problem = Problem::new(&record, &mask).cautious();
    Ok(refit::refit(&problem, model)?.model)
}

/// Judges the observer and the baselines on the case in a folder, motor only and with the output
/// encoder, with the refitted model and with one that is wrong in each way.
///
/// # Errors
/// A file that cannot be read, or a model that cannot be observed.
pub fn case(folder: &Path) -> Result<Vec<Case>, InputError> {
    let [nominal, calibration, log, truth] = FILES.map(|file| folder.join(file));
    let model = Model::read(&nominal)?;
    let unbuilt = |error: BuildError| InputError::new(&nominal, error.to_string());
    let model = refitted(&model, &Log::read(&calibration, Need::Drive)?.log).map_err(unbuilt)?;
    let samples = Samples::of(&Log::read(&log, Need::Drive)?.log);
    let truth = truths(&truth, model.stages.len(), samples.seen.len())?;
    let loads: Vec<f64> = truth.iter().map(|truth| truth.load).collect();
    let jumps = jumps(&loads);
    let shaft = Bases::si(&model.motor, &model.stages).shaft(model.stages.len());
    let judged = Judged { truth: &truth, jumps: &jumps, step_s: samples.step_s, shaft };
    let joint = folder.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    let mut cases = Vec::new();
    for output in [false, true] {
        if output && !samples.seen.iter().any(|seen| seen.output.is_finite()) {
            continue;
        }
        let samples = if output { samples.clone() } else { samples.motor_only() };
        let mut right = f64::NAN;
        for error in Error::ALL.into_iter().filter(|error| error.concerns(&model)) {
            let model = error.of(&model);
            let rating = by_stages!(model.stages.len(), N => samples.rating::<N>(&model, None))
                .map_err(unbuilt)?;
            let case = judge(&joint, Style::Duty, error, &model, &rating, &samples, &judged);
            let case = case.map_err(unbuilt)?;
            let (exact, bounds) = if error == Error::None {
                right = case.observer.load;
                let made = exactly(&model, &rating, &samples, &loads, output).map_err(unbuilt)?;
                (Some(made.0), Some(made.1))
            } else {
                (None, None)
            };
            cases.push(Case { right, exact, bounds, ..case });
        }
    }
    Ok(cases)
}

/// What the observer reaches where the refitted model is exact, and what any filter could at best: along
/// the motion that this model makes under the log's drive and its true load.
fn exactly(
    model: &Model,
    rating: &Rating,
    samples: &Samples,
    loads: &[f64],
    output: bool,
) -> Result<(Score, Bounds), BuildError> {
    let (kind, step_s) = (samples.kind, samples.step_s);
    let felt =
        Felt { drive: drive_noise(model, kind, rating, 1e-3), torque: 0.01 * breakaway_nm(model) };
    let made = Motion {
        truth: model,
        kind,
        step_s,
        rating,
        felt,
        style: Style::Duty,
        samples: loads.len(),
        seed: 79,
    };
    let mut held = 0.0;
    let drive = samples.seen.iter().map(|seen| {
        held = if seen.drive.is_finite() { seen.drive } else { held };
        held
    });
    let motion = made.under(drive.collect(), loads.to_vec())?;
    let seen = shown(model, kind, &motion, output, made.seed + 1);
    let shown = Samples { kind, step_s, steps: vec![1; seen.len()], seen };
    let rows = truths_of(model, &motion);
    let shaft = Bases::si(&model.motor, &model.stages).shaft(model.stages.len());
    let judged = Judged { truth: &rows, jumps: &motion.jumps, step_s, shaft };
    let (score, _) =
        by_stages!(model.stages.len(), N => observed::<N>(model, rating, &shown, &judged))?;
    let known = Known { truth: model, kind, step_s, rating, motion: &motion, felt, output };
    Ok((score, bounds(&known)?))
}

/// The truth of a case: load, wind-up and friction by sample.
///
/// # Errors
/// The file cannot be read, or has not that many rows.
pub fn truths(path: &Path, stages: usize, samples: usize) -> Result<Vec<Guess>, InputError> {
    let fault = |what: String| InputError::new(path, what);
    let mut reader = csv::Reader::from_path(path).map_err(|error| fault(error.to_string()))?;
    let header = reader.headers().map_err(|error| fault(error.to_string()))?.clone();
    let at = |name: String| {
        let found = header.iter().position(|own| own == name);
        found.ok_or_else(|| fault(format!("has no column {name}")))
    };
    let load = at("load_torque_nm".to_owned())?;
    let friction = at("total_friction_at_motor_nm".to_owned())?;
    let wound = match stages {
        0 => None,
        _ => Some([at("stage1_windup_rad".to_owned())?, at(format!("stage{stages}_windup_rad"))?]),
    };
    let mut rows = Vec::with_capacity(samples);
    for record in reader.records() {
        let record = record.map_err(|error| fault(error.to_string()))?;
        let value = |column: usize| {
            let text = record.get(column).unwrap_or_default().trim();
            text.parse::<f64>().map_err(|_| {
                let line = record.position().map_or(0, csv::Position::line);
                fault(format!("line {line}: {text:?} is no number"))
            })
        };
        let (first, windup) = match wound {
            Some([first, last]) => (value(first)?, value(last)?),
            None => (f64::NAN, f64::NAN),
        };
        rows.push(Guess { load: value(load)?, first, windup, friction: value(friction)? });
    }
    if rows.len() != samples {
        return Err(fault(format!("has {} rows where the log has {samples}", rows.len())));
    }
    Ok(rows)
}
