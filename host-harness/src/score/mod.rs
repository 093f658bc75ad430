//! How often discovery is right, over logs whose truth is known.

pub mod blind;
mod breakdown;
pub mod families;
pub mod misfits;
mod share;
mod summary;
mod tally;
pub mod wide;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use joint_core::effect::Kind;
use serde::{Deserialize, Serialize};

use crate::discover::candidates::card;
use crate::discover::evidence::Budget;
use crate::discover::findings::{Findings, Named, Verdict};
use crate::discover::goodness_of_fit::Remainder;

pub use breakdown::{Breakdown, Reliability};
use misfits::Misfits;
pub use share::Share;
pub use summary::{Summary, table};
pub use tally::Tally;

/// A name given with this confidence or more is given as certain.
const CERTAIN: f64 = 0.9;

/// One effect of a case's truth.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct TrueEffect {
    /// Its kind.
    pub kind: String,
    /// Its place.
    pub location: String,
    /// Its values; those that are numbers are compared.
    #[serde(default)]
    pub parameters: BTreeMap<String, serde_json::Value>,
    /// RMS of what its removal changes in the signals over that of their noise, where it is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub signal_to_noise: Option<f64>,
}

impl TrueEffect {
    fn name(&self) -> String {
        format!("{} {}", self.kind, self.location)
    }
}

/// One case of `truth.json`.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Case {
    /// Its folder.
    pub case: String,
    /// The right answer: effect, adequate, unknown, or unscored.
    pub verdict: String,
    /// What was hidden.
    #[serde(default)]
    pub effects: Vec<TrueEffect>,
    /// Size of the first of them, in units of what is typical of its kind.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size: Option<f64>,
    /// The kind that discovery must do without.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub withdrawn: Option<String>,
    /// In what else the joint differs from the model, where it was drawn so.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub misfits: Option<Misfits>,
}

impl Case {
    /// The kind that discovery must do without.
    pub fn withdrawn_kind(&self) -> Option<Kind> {
        self.withdrawn.as_deref().and_then(Kind::from_name)
    }
}

/// One row of `score.json`.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
#[serde(default)]
pub struct Row {
    /// The case.
    pub case: String,
    /// What was hidden, by kind and place; the verdict where nothing has a name.
    pub truth: String,
    /// The answer given.
    pub verdict: String,
    /// The first name given.
    pub named: Option<String>,
    /// Its place.
    pub location: Option<String>,
    /// How sure it was.
    pub confidence: Option<f64>,
    /// `1 − √((after² − floor²)/(before² − floor²))`.
    pub gap_closed: Option<f64>,
    /// Relative error of the first name's main parameter.
    pub parameter_error: Option<f64>,
    /// What was hidden, kind and place; empty where nothing has a name.
    pub hidden: Vec<String>,
    /// All names given, kind and place, in order.
    pub names: Vec<String>,
    /// How sure each of them was.
    pub confidences: Vec<f64>,
    /// The share of the disagreement that each explains, and its standard error.
    pub shares: Vec<[Option<f64>; 2]>,
    /// What unseen samples say of each: its gain there over its standard error.
    pub unseen_t: Vec<Option<f64>>,
    /// Names that are only possible, kind and place.
    pub possible: Vec<String>,
    /// Where what the refitted nominal misses goes.
    pub budget: Option<Budget>,
    /// The gap on unseen samples before, after, and what noise leaves.
    pub gap: Option<[f64; 3]>,
    /// Parameters of rightly named effects whose 95 % interval holds the truth, and of how many.
    pub intervals: [usize; 2],
    /// The smallest ratio of signal to noise of what was hidden, withdrawn or not.
    pub signal_to_noise: Option<f64>,
    /// In what else the joint differed from the model.
    pub misfits: Option<Misfits>,
    /// How large the first hidden effect was, in units of what is typical of its kind.
    pub size: Option<f64>,
    /// What the first name's refit took from minus twice the log-likelihood.
    pub gain: Option<f64>,
    /// How much more than the best of the other names.
    pub lead: Option<f64>,
    /// Share of the logs drawn from this one in which it stays ahead.
    pub stays_ahead: Option<f64>,
    /// What the improved model leaves, over what it should.
    pub left: Remainder,
    /// Wall time, s.
    pub seconds: f64,
    /// Whether the answer is right: the first name and its place, or adequate, or unknown.
    pub right: bool,
}

impl Row {
    /// Whether the first name is one of those hidden.
    pub fn first_is_hidden(&self) -> bool {
        self.names.first().is_some_and(|name| self.hidden.contains(name))
    }

    /// Whether any name that was not hidden is given as certain.
    pub fn has_certain_wrong(&self) -> bool {
        let mut names = self.names.iter().zip(&self.confidences);
        names.any(|(name, sure)| *sure >= CERTAIN && !self.hidden.contains(name))
    }

    /// Whether names were given and the gap is wider with them.
    pub fn is_worse_after(&self) -> bool {
        let wider = |[before, after, _]: [f64; 3]| after > before;
        !self.names.is_empty() && self.gap.is_some_and(wider)
    }
}

/// The cases of a set that are scored: those with one of these kinds only where `kinds` is not
/// empty, and those in which nothing has a name.
///
/// # Errors
/// The set has no readable `truth.json`.
pub fn cases(set: &Path, kinds: &[String]) -> Result<Vec<Case>, String> {
    let path = set.join("truth.json");
    let text = std::fs::read_to_string(&path)
        .map_err(|error| format!("{}: {error}; a set has a truth.json", path.display()))?;
    let all: Vec<Case> =
        serde_json::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))?;
    let listed = |case: &Case| {
        kinds.is_empty()
            || case.verdict != "effect"
            || case.effects.iter().all(|effect| kinds.contains(&effect.kind))
    };
    Ok(all.into_iter().filter(|case| case.verdict != "unscored" && listed(case)).collect())
}

/// The rows of a `score.json` written before, as those of a benchmark shared over machines.
///
/// # Errors
/// The file cannot be read, or is no `score.json`.
pub fn rows(path: &Path) -> Result<Vec<Row>, String> {
    #[derive(Deserialize)]
    struct Written {
        cases: Vec<Row>,
    }
    let told = |error: &dyn std::fmt::Display| {
        format!("{}: {error}; give a score.json that `joint score` wrote", path.display())
    };
    let text = std::fs::read_to_string(path).map_err(|error| told(&error))?;
    let written: Written = serde_json::from_str(&text).map_err(|error| told(&error))?;
    Ok(written.cases)
}

/// A case's model and logs: first the one that is asked about, then those of which the names are asked.
pub fn files(set: &Path, case: &Case) -> (PathBuf, Vec<PathBuf>) {
    let folder = set.join(&case.case);
    let plain = folder.join(log_name(0));
    let first = if plain.exists() { plain } else { folder.join("log.csv.gz") };
    let others = (1..).map(|place| folder.join(log_name(place))).take_while(|path| path.exists());
    let logs = std::iter::once(first).chain(others).collect();
    (folder.join("nominal.toml"), logs)
}

/// File of a case's log: the first is what is asked about.
pub fn log_name(place: usize) -> String {
    if place == 0 { "log.csv".to_owned() } else { format!("log-{}.csv", place + 1) }
}

/// Scores one answer.
pub fn row(case: &Case, findings: &Findings) -> Row {
    let verdict = &findings.verdict;
    let first = verdict.effects.first();
    let answer = verdict.verdict.name();
    let named = case.verdict == "effect";
    let hidden: Vec<String> = case.effects.iter().filter(|_| named).map(TrueEffect::name).collect();
    let truth = case.effects.first().filter(|_| case.verdict == "effect");
    let named_right = truth
        .zip(first)
        .is_some_and(|(truth, named)| truth.kind == named.kind && truth.location == named.location);
    let right = match case.verdict.as_str() {
        "effect" => {
            let any = case.effects.iter().any(|truth| {
                first.is_some_and(|n| n.kind == truth.kind && n.location == truth.location)
            });
            answer == "effect" && any
        }
        other => answer == other,
    };
    Row {
        case: case.case.clone(),
        truth: if named { hidden.join(" + ") } else { case.verdict.clone() },
        verdict: answer.to_owned(),
        named: first.map(|effect| effect.kind.clone()),
        location: first.map(|effect| effect.location.clone()),
        confidence: first.map(|effect| effect.confidence),
        gap_closed: (case.verdict == "effect").then(|| gap_closed(verdict)).flatten(),
        parameter_error: truth
            .zip(first)
            .filter(|_| named_right)
            .and_then(|(truth, named)| parameter_error(truth, &named.parameters)),
        hidden,
        names: verdict.effects.iter().map(|e| format!("{} {}", e.kind, e.location)).collect(),
        confidences: verdict.effects.iter().map(|e| e.confidence).collect(),
        shares: verdict.effects.iter().map(|e| [e.share, e.share_error].map(finite)).collect(),
        unseen_t: verdict.effects.iter().map(|e| finite(e.unseen_t)).collect(),
        possible: verdict.possible.iter().map(|e| format!("{} {}", e.kind, e.location)).collect(),
        budget: verdict.budget.clone(),
        gap: Some([verdict.gap.before, verdict.gap.after, verdict.gap.floor])
            .filter(|gap| gap.iter().all(|value| value.is_finite())),
        intervals: intervals(case, verdict),
        signal_to_noise: case
            .effects
            .iter()
            .filter_map(|effect| effect.signal_to_noise)
            .min_by(f64::total_cmp),
        misfits: case.misfits.clone(),
        size: case.size,
        gain: first.map(|effect| effect.gain),
        lead: first.and_then(|effect| Some(effect.gain - effect.rivals.first()?.gain)),
        stays_ahead: first.map(|effect| effect.stays_ahead),
        left: findings.left.clone(),
        seconds: verdict.seconds,
        right,
    }
}

/// A number as JSON has it: none where it is not finite.
fn finite(value: f64) -> Option<f64> {
    Some(value).filter(|value| value.is_finite())
}

/// Standard errors within which 95 % lie.
const SIGMAS: f64 = 1.96;

/// Fitted parameters of rightly named effects whose interval holds the truth, and of how many.
/// Orders and phases are left out, and what only shows together with a value that is assumed.
fn intervals(case: &Case, verdict: &Verdict) -> [usize; 2] {
    let mut counts = [0, 0];
    for truth in case.effects.iter().filter(|_| case.verdict == "effect") {
        let same = |named: &&Named| named.kind == truth.kind && named.location == truth.location;
        let Some(named) = verdict.effects.iter().find(same) else { continue };
        if Kind::from_name(&truth.kind).is_none_or(|kind| card(kind).reference.is_some()) {
            continue;
        }
        for (key, error) in &named.standard_errors {
            let value = truth.parameters.get(key).and_then(serde_json::Value::as_f64);
            let Some((wanted, got)) = value.zip(named.parameters.get(key)) else { continue };
            if key != "order" && !key.contains("phase") && *error > 0.0 {
                counts[0] += usize::from((got - wanted).abs() <= SIGMAS * error);
                counts[1] += 1;
            }
        }
    }
    counts
}

fn gap_closed(verdict: &Verdict) -> Option<f64> {
    let gap = &verdict.gap;
    let before = gap.before.powi(2) - gap.floor.powi(2);
    let after = (gap.after.powi(2) - gap.floor.powi(2)).max(0.0);
    (before > 0.0).then(|| 1.0 - (after / before).sqrt())
}

/// Relative error of an effect's main parameter: the first that is neither an order nor a phase,
/// over the square of its reference where it only shows together with that.
fn parameter_error(truth: &TrueEffect, found: &BTreeMap<String, f64>) -> Option<f64> {
    let kind = Kind::from_name(&truth.kind)?;
    let parameters = kind.spec().parameters;
    let main = parameters.iter().find(|spec| spec.key != "order" && !spec.key.contains("phase"))?;
    let beside = card(kind).reference;
    let true_value = |key: &str| truth.parameters.get(key).and_then(serde_json::Value::as_f64);
    let mut wanted = true_value(main.key)?;
    let mut got = *found.get(main.key)?;
    if let Some(beside) = beside {
        wanted /= true_value(beside)?.powi(2);
        got /= found.get(beside)?.powi(2);
    }
    (wanted != 0.0).then(|| ((got - wanted) / wanted).abs())
}
