//! What a discovery found: the answer, and everything a reader needs to believe it.

use std::collections::BTreeMap;

use joint_core::effect::EffectParameters;
use serde::Serialize;

use super::experiment::Experiment;
use crate::discover::checks::goodness_of_fit::Remainder;
use crate::discover::evidence::{Budget, FreeRun};
pub use crate::discover::state::rounds::ScoreRow;
use crate::estimate::parameters::Quantity;
use crate::estimate::record::CHANNELS;
use crate::model::Model;

/// The answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Answer {
    /// Something is missing, it has a name, and with it the model explains the log.
    Effect,
    /// Nothing is missing that this log shows.
    Adequate,
    /// Something is missing that no listed effect explains.
    Unknown,
    /// The logs cannot tell.
    Undecided,
}

impl Answer {
    /// Its name in files and tables.
    pub fn name(self) -> &'static str {
        match self {
            Answer::Effect => "effect",
            Answer::Adequate => "adequate",
            Answer::Unknown => "unknown",
            Answer::Undecided => "undecided",
        }
    }
}

/// Another name that was considered.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Rival {
    /// Its kind.
    pub kind: String,
    /// Its place.
    pub location: String,
    /// Its share of the confidence.
    pub confidence: f64,
    /// What its refit took from minus twice the log-likelihood.
    pub gain: f64,
}

/// An effect by name.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Named {
    /// Its kind.
    pub kind: String,
    /// Its place.
    pub location: String,
    /// Whether it says what is there without saying why.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub unnamed: bool,
    /// Its parameters by key.
    pub parameters: BTreeMap<String, f64>,
    /// The knots of its table by key; absent where it has none.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub knots: BTreeMap<String, Vec<f64>>,
    /// One sigma of those that were fitted.
    pub standard_errors: BTreeMap<String, f64>,
    /// Probability that the name is right.
    pub confidence: f64,
    /// Share of what the refitted nominal misses, on samples that no fit has seen, that it explains.
    pub share: f64,
    /// One standard error of that.
    pub share_error: f64,
    /// How much of what it changes of the prediction errors, given all the others, samples that no fit has seen bear
    /// out: one where it is what the fit says. `None` where they were not asked.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub borne_out: Option<f64>,
    /// One standard error of that.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub borne_out_error: Option<f64>,
    /// Its gain there over its standard error, by blocks.
    pub unseen_t: f64,
    /// The same on the other records; `None` where there are none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transfer_t: Option<f64>,
    /// What its refit took from minus twice the log-likelihood.
    pub gain: f64,
    /// Share of the logs drawn from this one, block by block, in which it stays ahead of the best of
    /// the other names and of none.
    pub stays_ahead: f64,
    /// The other names.
    pub rivals: Vec<Rival>,
}

/// The knots of an effect's table by key.
pub(crate) fn knots_of(effect: &EffectParameters) -> BTreeMap<String, Vec<f64>> {
    let curves = effect.kind.spec().table.iter().flat_map(|table| {
        [(table.forward, effect.table.forward()), (table.backward, effect.table.backward())]
    });
    let given = curves.filter(|(_, knots)| !knots.is_empty());
    given.map(|(key, knots)| (key.to_owned(), knots.to_vec())).collect()
}

/// Where the refitted nominal model and the log disagree.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Whereabouts {
    /// The equation that a slow disturbance would help most.
    pub equation: String,
    /// The coordinate that the disturbance follows.
    pub varies_with: String,
    /// Its orders where that coordinate is an angle, strongest first.
    pub orders: Vec<f64>,
    /// Share of the disturbance's variance that the coordinate explains.
    pub explained: f64,
}

/// How far predictions miss, on data that no fit has seen, nor any choice but that of a weak name.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Gap {
    /// The refitted nominal.
    pub before: f64,
    /// With the effects.
    pub after: f64,
    /// What noise alone leaves.
    pub floor: f64,
    /// Unit of the three.
    pub unit: &'static str,
    /// Before, after and floor by log column.
    pub signals: BTreeMap<String, [f64; 3]>,
}

/// `verdict.json`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// The answer.
    pub verdict: Answer,
    /// What was found, the most certain name first.
    pub effects: Vec<Named>,
    /// Effects that explain something, but not beyond doubt: they are not in the improved model.
    pub possible: Vec<Named>,
    /// What repeats without a name, and is in the improved model as a table.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub unnamed: Vec<Named>,
    /// Where the refitted nominal and the log disagree.
    #[serde(rename = "where")]
    pub whereabouts: Whereabouts,
    /// How far they disagree.
    pub gap: Gap,
    /// Where what the refitted nominal misses goes; `None` where nothing could be looked at.
    pub budget: Option<Budget>,
    /// Both models run free over samples that no fit has seen.
    pub free_run: FreeRun,
    /// What to measure next.
    pub next_experiment: String,
    /// Wall time, s.
    pub seconds: f64,
    /// Why the answer is what it is, in sentences.
    pub reasons: Vec<String>,
}

/// A slow disturbance on one equation, as the filter estimates it along the log.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Disturbance {
    /// The equation.
    pub equation: String,
    /// Its unit.
    pub unit: &'static str,
    /// Estimate by sample, before the effects were added.
    pub before: Vec<f64>,
    /// Estimate by sample with the effects.
    pub after: Vec<f64>,
}

/// Angles by sample, as a filter has them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Angles {
    /// Of the rotor, rad.
    pub motor_rad: Vec<f64>,
    /// Wind-up of the last stage at its output, rad.
    pub windup_rad: Vec<f64>,
}

/// The disturbance against the coordinate that it follows: means by bin.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shape {
    /// Share of the disturbance's variance that the coordinate explains, before.
    pub explained: f64,
    /// The coordinate, with its unit.
    pub coordinate: String,
    /// Centre of each bin.
    pub centres: Vec<f64>,
    /// Mean disturbance in the bin, before.
    pub before: Vec<f64>,
    /// Mean disturbance in the bin, after.
    pub after: Vec<f64>,
}

/// A parameter's way through the refits.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterRow {
    /// Its place in the model file.
    pub key: String,
    /// As given.
    pub nominal: f64,
    /// After the refit of the nominal structure.
    pub refitted: f64,
    /// In the improved model.
    pub improved: f64,
    /// One sigma in the improved model, relative.
    pub relative_sigma: f64,
    /// Interval of 95 % in the improved model.
    pub interval: [f64; 2],
    /// Whether the logs tell it; if not, it is assumed.
    pub determined: bool,
}

impl ParameterRow {
    /// Of a quantity with one sigma in the coordinate of its prior.
    pub fn new([nominal, refitted, improved]: [&Model; 3], quantity: Quantity, sigma: f64) -> Self {
        Self {
            key: quantity.key(),
            nominal: quantity.get(nominal),
            refitted: quantity.get(refitted),
            improved: quantity.get(improved),
            relative_sigma: sigma,
            interval: quantity.interval(improved, sigma),
            determined: quantity.is_determined(sigma),
        }
    }
}

/// One noise, as expected and as found.
#[derive(Clone, Debug, PartialEq)]
pub struct NoiseRow {
    /// Which.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// What the sensors and the joint's nature lead one to expect.
    pub expected: f64,
    /// What the refitted nominal needs.
    pub before: f64,
    /// What the improved model needs.
    pub after: f64,
}

/// Everything a discovery found.
#[derive(Clone, Debug)]
pub struct Findings {
    /// The answer.
    pub verdict: Verdict,
    /// The model as given.
    pub nominal: Model,
    /// The nominal structure, refitted.
    pub refitted: Model,
    /// The improved model: refitted, with the effects.
    pub improved: Model,
    /// Sample times of the first log, s.
    pub time_s: Vec<f64>,
    /// By sample: whether no fit has seen it.
    pub held_out: Vec<bool>,
    /// Prediction errors in noise sigmas by sample and channel (current, motor angle, output
    /// angle; NaN where not measured): the refitted nominal.
    pub before: Vec<[f64; CHANNELS]>,
    /// The same with the effects.
    pub after: Vec<[f64; CHANNELS]>,
    /// The disturbance on the equation that disagrees most.
    pub disturbance: Disturbance,
    /// What the disturbance follows.
    pub shape: Shape,
    /// The disturbance against everything that it might follow.
    pub courses: Vec<Shape>,
    /// Angle of the rotor and wind-up of the last stage by sample, as the filter of the disturbance has them; empty
    /// where there is none.
    pub angles: Angles,
    /// Orders of the rotor angle that were named, or that explained something.
    pub orders: Vec<f64>,
    /// Parameters.
    pub parameters: Vec<ParameterRow>,
    /// Hypotheses.
    pub scores: Vec<ScoreRow>,
    /// Noises.
    pub noises: Vec<NoiseRow>,
    /// What the improved model leaves, over what it should.
    pub left: Remainder,
    /// What to run next, where that would decide something.
    pub experiment: Option<Experiment>,
}
