//! `joint cross-check`: the embedded method against the reference.

use std::path::{Path, PathBuf};

use serde_json::json;

use super::{Common, Failure, Outcome, read_log, read_model};
use crate::cross_check::{self, CrossCheckError, Random, Speed, pareto};
use crate::log::Need;
use crate::output::OutDir;
use crate::plant::Inputs;
use crate::plot::picture;
use crate::scenario;

/// Check f32 in the embedded method against the f64 reference on every scenario
///
/// Writes `cross-check.json`, plots, and error over instructions (`pareto.svg`) where --out is given; exit 1 where a stated bound is broken.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Example:
  joint cross-check --out check
  joint cross-check --random 500 --stiff
  joint cross-check --model found/model.toml --log log.csv")]
pub struct Args {
    /// Folder for the result
    #[arg(short = 'o', long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Run this many random plants instead of the scenarios
    #[arg(long, value_name = "N")]
    pub random: Option<u64>,
    /// Seed of the first random plant
    #[arg(short = 's', long, value_name = "N", default_value_t = 1, requires = "random")]
    pub seed: u64,
    /// Random plants with springs up to a million times stiffer
    #[arg(long, requires = "random")]
    pub stiff: bool,
    /// Run this model, its effects with it, along the inputs of a log instead of the scenarios
    #[arg(short = 'm', long, value_name = "TOML", requires = "log", conflicts_with = "random")]
    pub model: Option<PathBuf>,
    /// The log, of which the first second counts
    #[arg(short = 'l', long, value_name = "CSV", requires = "model")]
    pub log: Option<PathBuf>,
}

/// Seconds of a log that a model is run along.
const LOG_S: f64 = 1.0;

/// Runs the verb.
///
/// # Errors
/// Bad input, or a result that may not be overwritten.
pub fn run(args: &Args, common: &Common) -> Result<Outcome, Failure> {
    let out = args.out.as_deref().map(|path| OutDir::new(path, common.force)).transpose()?;
    let failed = |error: CrossCheckError| Failure::check(error.to_string());
    if let Some(number) = args.random {
        let bar = common.progress(number, "plants");
        let random =
            Random::run(number.max(1), args.seed, args.stiff, || bar.inc(1)).map_err(failed)?;
        bar.finish_and_clear();
        if let Some(out) = out {
            let text = serde_json::to_string_pretty(&random)
                .map_err(|error| Failure::check(error.to_string()))?;
            out.write("random.json", text)?;
            out.finish()?;
        }
        let text = random.to_string();
        return Ok(Outcome::done(json!(random), text));
    }
    if let (Some(model), Some(log)) = (&args.model, &args.log) {
        return along(model, log, out, common);
    }
    let model = scenario::paper();
    let bar = common.progress(scenario::ALL.len() as u64, "scenarios");
    let mut check = cross_check::run(&model, &scenario::ALL, || bar.inc(1)).map_err(failed)?;
    bar.set_message("timing");
    check.speed = Some(Speed::measure(&model, &scenario::ALL[1]).map_err(failed)?);
    bar.finish_and_clear();
    if let Some(out) = out {
        let rows = serde_json::to_string_pretty(&check.rows)
            .map_err(|error| Failure::check(error.to_string()))?;
        out.write("cross-check.json", rows)?;
        let points = pareto::run(&model, &scenario::ALL).map_err(failed)?;
        let text = serde_json::to_string_pretty(&points)
            .map_err(|error| Failure::check(error.to_string()))?;
        out.write("pareto.json", text)?;
        out.write("pareto.svg", picture(&[pareto::plot(&points)]))?;
        out.write("cross-check.html", check.page(&points))?;
        out.finish()?;
    }
    let json = json!({
        "passed": check.passed(), "rows": check.rows, "broken": check.broken(), "speed": check.speed,
    });
    Ok(Outcome { json, text: check.to_string(), passed: check.passed() })
}

/// The check of a model of one's own.
fn along(
    model: &Path,
    log: &Path,
    out: Option<OutDir>,
    common: &Common,
) -> Result<Outcome, Failure> {
    let failed = |error: CrossCheckError| Failure::check(format!("{}: {error}", model.display()));
    let (joint, log) = (read_model(model)?, read_log(log, Need::Drive)?);
    let first = log.time_s.first().copied().unwrap_or(0.0);
    let within: Vec<bool> = log.time_s.iter().map(|time| time - first <= LOG_S).collect();
    let bar = common.progress(0, "along the log");
    let check =
        cross_check::along(&joint, &Inputs::from_log(&log.only(&within))).map_err(failed)?;
    bar.finish_and_clear();
    if let Some(out) = out {
        let rows = serde_json::to_string_pretty(&check.rows)
            .map_err(|error| Failure::check(error.to_string()))?;
        out.write("cross-check.json", rows)?;
        out.finish()?;
    }
    let json = json!({"passed": check.passed(), "rows": check.rows, "broken": check.broken()});
    Ok(Outcome { json, text: check.to_string(), passed: check.passed() })
}
