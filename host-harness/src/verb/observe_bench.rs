//! `joint observe-bench`: the observer beside what drives use today, against truth.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::PathBuf;

use rayon::prelude::*;
use serde_json::{Value, json};

use super::{Common, Failure, Outcome};
use crate::observe::baseline::Baseline;
use crate::observe::bench::{Case, Error, simulated};
use crate::observe::bound::Bound;
use crate::observe::score::Score;
use crate::observe::set;
use crate::output::OutDir;

/// Measure the observer against truth, with baselines beside it
///
/// On logs: every folder within `--set` that holds `nominal.toml`, an unloaded `calibration.csv`,
/// `log.csv` and its `truth.csv` is a case; the model is refitted on the calibration first. Else on
/// joints drawn at random. The observer (f32) and every baseline are given the same model, right and
/// wrong in one way after the other, and the same samples, with and without output encoder. Where the
/// model is right, two rows and a column say what the best linear filter could reach, and on logs a third
/// row what the observer does where the refitted model is exact. Writes
/// `observe-bench.json`, and of logs the estimates over the truth as `NAME-SENSORS.svg`.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Example:
  joint observe-bench --simulate 200 --out bench
  joint observe-bench --set logs --out bench")]
pub struct Args {
    /// Folder of cases with truth
    #[arg(long, value_name = "DIR", conflicts_with = "simulate")]
    pub set: Option<PathBuf>,
    /// Number of simulated joints
    #[arg(long, value_name = "N", default_value_t = 200)]
    pub simulate: usize,
    /// Seed of the draw
    #[arg(short = 's', long, default_value_t = 1)]
    pub seed: u64,
    /// Folder for the result
    #[arg(short = 'o', long, value_name = "DIR")]
    pub out: PathBuf,
}

/// Runs the verb.
///
/// # Errors
/// A case that cannot be read, a result that may not be overwritten, or a joint that cannot be
/// built.
pub fn run(args: &Args, common: &Common) -> Result<Outcome, Failure> {
    let folders = args.set.as_deref().map(set::cases).transpose()?;
    let out = OutDir::new(&args.out, common.force)?;
    let count = folders.as_ref().map_or(args.simulate, Vec::len);
    let bar = common.progress(count as u64, "observing");
    let cases: Result<Vec<Vec<Case>>, Failure> = (0..count)
        .into_par_iter()
        .map(|number| {
            let cases = match &folders {
                Some(folders) => set::case(&folders[number])?,
                None => simulated(number, args.seed)
                    .map_err(|error| Failure::check(error.to_string()))?,
            };
            bar.inc(1);
            Ok(cases)
        })
        .collect();
    bar.finish_and_clear();
    let cases: Vec<Case> = cases?.into_iter().flatten().collect();
    let json = json!({
        "joints": count,
        "seed": folders.is_none().then_some(args.seed),
        "cases": cases.iter().map(case).collect::<Vec<_>>(),
    });
    let pretty =
        serde_json::to_string_pretty(&json).map_err(|error| Failure::check(error.to_string()))?;
    if folders.is_some() {
        for case in &cases {
            let Some(plot) = &case.plot else { continue };
            let sensors = if case.output { "both" } else { "motor" };
            out.write(&format!("{}-{sensors}.svg", case.joint), plot)?;
        }
    }
    let path = out.write("observe-bench.json", pretty)?;
    out.finish()?;
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
        "observer_exact_model": case.exact.as_ref().map(score),
        "bound": case.bounds.map(|bounds| bound(&bounds.told)),
        "full_filter": case.bounds.map(|bounds| bound(&bounds.filter)),
        "load_rms_of_peak_with_the_right_model": case.right,
        "baselines": baselines,
    })
}

fn score(score: &Score) -> Value {
    let known = |value: f64| value.is_finite().then_some(value);
    json!({
        "load_rms_of_peak": known(score.load),
        "load_outside_jumps_rms_of_peak": known(score.calm),
        "first_windup_rms_of_peak": known(score.first),
        "windup_rms_of_peak": known(score.windup),
        "friction_rms_of_rms": known(score.friction),
        "friction_and_load_rms_of_rms": known(score.both),
        "t90_s": known(score.t90_s),
        "load_within_sigmas": score.within[0].map(known),
        "windup_within_sigmas": score.within[1].map(known),
        "friction_within_sigmas": score.within[2].map(known),
    })
}

fn bound(bound: &Bound) -> Value {
    let known = |value: f64| value.is_finite().then_some(value);
    json!({
        "load_rms_of_peak": known(bound.load),
        "first_windup_rms_of_peak": known(bound.first),
        "windup_rms_of_peak": known(bound.windup),
        "friction_rms_of_rms": known(bound.friction),
    })
}

/// A row of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Row {
    Observer,
    Exact,
    Bound,
    FullFilter,
    Baseline(Baseline),
}

impl Row {
    fn name(self) -> &'static str {
        match self {
            Self::Observer => "observer",
            Self::Exact => "observer, exact model",
            Self::Bound => "bound, told of the jumps",
            Self::FullFilter => "full filter, best noise",
            Self::Baseline(baseline) => baseline.name(),
        }
    }
}

/// What a row shows: a score, times the error that the right model had, and the bound of the load.
#[derive(Clone, Copy, Debug)]
struct Shown {
    score: Score,
    right: f64,
    bound: f64,
}

impl Shown {
    fn of(score: Score) -> Self {
        Self { score, right: f64::NAN, bound: f64::NAN }
    }

    fn bound(own: &Bound) -> Self {
        let Bound { load, first, windup, friction } = *own;
        Self::of(Score { load, first, windup, friction, ..Score::NONE })
    }
}

/// Medians over joints, by joint, sensors, model error and method.
fn table(cases: &[Case]) -> String {
    type Key = (String, bool, Error, Row);
    let mut rows: BTreeMap<Key, Vec<Shown>> = BTreeMap::new();
    for case in cases {
        let mut put = |row, shown| {
            let key = (case.joint.clone(), case.output, case.error, row);
            rows.entry(key).or_default().push(shown);
        };
        let right = case.observer.load / case.right;
        let bound = case.bounds.map_or(f64::NAN, |bounds| bounds.told.load);
        put(Row::Observer, Shown { score: case.observer, right, bound });
        if let Some(exact) = case.exact {
            put(Row::Exact, Shown::of(exact));
        }
        if let Some(bounds) = &case.bounds {
            put(Row::Bound, Shown::bound(&bounds.told));
            put(Row::FullFilter, Shown::bound(&bounds.filter));
        }
        for (kind, score) in &case.baselines {
            put(Row::Baseline(*kind), Shown::of(*score));
        }
    }
    type Column = (&'static str, f64, fn(&Shown) -> f64);
    const COLUMNS: [Column; 15] = [
        ("load %", 100.0, |s| s.score.load),
        ("bound %", 100.0, |s| s.bound),
        ("× right", 1.0, |s| s.right),
        ("calm %", 100.0, |s| s.score.calm),
        ("t90 ms", 1e3, |s| s.score.t90_s),
        ("first %", 100.0, |s| s.score.first),
        ("last %", 100.0, |s| s.score.windup),
        ("fric %", 100.0, |s| s.score.friction),
        ("both %", 100.0, |s| s.score.both),
        ("load 1σ", 100.0, |s| s.score.within[0][0]),
        ("2σ", 100.0, |s| s.score.within[0][1]),
        ("last 1σ", 100.0, |s| s.score.within[1][0]),
        ("2σ", 100.0, |s| s.score.within[1][1]),
        ("fric 1σ", 100.0, |s| s.score.within[2][0]),
        ("2σ", 100.0, |s| s.score.within[2][1]),
    ];
    let mut text =
        format!("{:12} {:5} {:14} {:29} {:>3}", "joint", "seen", "model error", "method", "n");
    for (name, ..) in COLUMNS {
        let _ = write!(text, " {name:>7}");
    }
    text.push('\n');
    for ((joint, output, error, row), scores) in rows {
        let _ = write!(
            text,
            "{joint:12} {:5} {:14} {:29} {:>3}",
            if output { "both" } else { "motor" },
            error.name(),
            row.name(),
            scores.len(),
        );
        for (_, scale, value) in COLUMNS {
            let mut values: Vec<f64> =
                scores.iter().map(value).filter(|value| !value.is_nan()).collect();
            values.sort_by(f64::total_cmp);
            let _ = match values.get(values.len() / 2) {
                Some(middle) if middle.is_finite() => write!(text, " {:>7.1}", scale * middle),
                Some(_) => write!(text, " {:>7}", "never"),
                None => write!(text, " {:>7}", "–"),
            };
        }
        text.push('\n');
    }
    text
}
