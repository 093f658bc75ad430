//! `joint observe-bench`: the observer beside what drives use today, against truth.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::PathBuf;

use rayon::prelude::*;
use serde_json::{Value, json};

use super::{Common, Failure, Outcome};
use crate::observe::baseline::Baseline;
use crate::observe::bench::{Case, Score, simulated};
use crate::output::OutDir;

/// Measure the observer against truth, with baselines beside it
///
/// Draws joints at random, makes the model of each wrong in one way, and runs the observer (f32) and
/// every baseline on the same samples, with and without output encoder. Writes `observe-bench.json`.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Example:
  joint observe-bench --simulate 200 --out bench")]
pub struct Args {
    /// Number of simulated joints
    #[arg(long, value_name = "N", default_value_t = 200)]
    pub simulate: usize,
    /// Seed of the draw
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Folder for the result
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

/// Runs the verb.
///
/// # Errors
/// A result that may not be overwritten, or a joint that cannot be built.
pub fn run(args: &Args, common: &Common) -> Result<Outcome, Failure> {
    let out = OutDir::new(&args.out, common.force)?;
    let bar = common.progress(args.simulate as u64, "observing");
    let cases: Result<Vec<Vec<Case>>, _> = (0..args.simulate)
        .into_par_iter()
        .map(|number| {
            let cases = simulated(number, args.seed);
            bar.inc(1);
            cases
        })
        .collect();
    bar.finish_and_clear();
    let cases: Vec<Case> =
        cases.map_err(|error| Failure::check(error.to_string()))?.into_iter().flatten().collect();
    let json = json!({
        "joints": args.simulate,
        "seed": args.seed,
        "cases": cases.iter().map(case).collect::<Vec<_>>(),
    });
    let pretty =
        serde_json::to_string_pretty(&json).map_err(|error| Failure::check(error.to_string()))?;
    let path = out.write("observe-bench.json", pretty)?;
    Ok(Outcome::done(json, format!("{}{}", table(&cases), path.display())))
}

fn case(case: &Case) -> Value {
    let baselines: serde_json::Map<_, _> =
        case.baselines.iter().map(|(kind, own)| (kind.name().to_owned(), score(own))).collect();
    json!({
        "joint": case.joint,
        "model_error": case.error.name(),
        "output_encoder": case.output,
        "observer": score(&case.observer),
        "baselines": baselines,
    })
}

fn score(score: &Score) -> Value {
    let known = |value: f64| value.is_finite().then_some(value);
    json!({
        "load_rms_of_peak": known(score.load),
        "windup_rms_of_peak": known(score.windup),
        "friction_rms_of_rms": known(score.friction),
        "t90_s": known(score.t90_s),
        "load_within_1_sigma": known(score.within[0]),
        "load_within_2_sigma": known(score.within[1]),
    })
}

/// Medians over joints, by joint, sensors, model error and method.
fn table(cases: &[Case]) -> String {
    let mut rows: BTreeMap<(String, bool, _, Option<Baseline>), Vec<Score>> = BTreeMap::new();
    for case in cases {
        let mut put = |method, score| {
            let key = (case.joint.clone(), case.output, case.error, method);
            rows.entry(key).or_default().push(score);
        };
        put(None, case.observer);
        case.baselines.iter().for_each(|(kind, score)| put(Some(*kind), *score));
    }
    let mut text = format!(
        "{:9} {:7} {:15} {:30} {:>4} {:>7} {:>8} {:>9} {:>7} {:>5} {:>5}\n",
        "joint",
        "sensors",
        "model error",
        "method",
        "n",
        "load %",
        "windup %",
        "friction %",
        "t90 ms",
        "1 σ %",
        "2 σ %"
    );
    for ((joint, output, error, method), scores) in rows {
        let of = |value: &dyn Fn(&Score) -> f64, scale: f64| {
            let mut values: Vec<f64> =
                scores.iter().map(value).filter(|value| !value.is_nan()).collect();
            values.sort_by(f64::total_cmp);
            match values.get(values.len() / 2) {
                Some(middle) if middle.is_finite() => format!("{:.1}", scale * middle),
                Some(_) => "never".to_owned(),
                None => "–".to_owned(),
            }
        };
        let _ = writeln!(
            text,
            "{:9} {:7} {:15} {:30} {:>4} {:>7} {:>8} {:>9} {:>7} {:>5} {:>5}",
            joint,
            if output { "both" } else { "motor" },
            error.name(),
            method.map_or("observer", Baseline::name),
            scores.len(),
            of(&|s| s.load, 100.0),
            of(&|s| s.windup, 100.0),
            of(&|s| s.friction, 100.0),
            of(&|s| s.t90_s, 1e3),
            of(&|s| s.within[0], 100.0),
            of(&|s| s.within[1], 100.0),
        );
    }
    text
}
