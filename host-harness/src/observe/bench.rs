//! The observer against truth, with what drives use today beside it.
//!
//! A joint is drawn, its model is made wrong in one way, and both the observer and every baseline
//! are given that wrong model and the same samples. Baselines are tuned on a loaded motion of the
//! model that they are given, of the kind that they are judged by but another one.

use joint_core::joint::Drive;
use joint_core::per_unit::Bases;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::baseline::{self, Baseline};
use super::bound::{Bounds, Known, bounds};
use super::design::Tuning;
use super::judge::shown;
use super::over::Samples;
use super::rating::{Rating, breakaway_nm};
use super::score::{Guess, Judged, Score};
use super::truth::frictions;
use super::twin::{Felt, Motion, Style, Twin};
use crate::demo::actuator;
use crate::model::Model;
use crate::plant::{BuildError, Layout, ScalarKind, by_stages};
use crate::scenario::paper;
use crate::synthetic::perturbed;

/// In what a model is wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Error {
    /// Nothing.
    None,
    /// R 15 % too large.
    Resistance,
    /// Every friction level and viscous coefficient 10 % too large.
    Friction,
    /// k_t 2 % too large.
    TorqueConstant,
    /// Every spring 5 % too stiff.
    Stiffness,
}

impl Error {
    /// All of them.
    pub const ALL: [Error; 5] =
        [Self::None, Self::Resistance, Self::Friction, Self::TorqueConstant, Self::Stiffness];

    /// Its name in a table.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Resistance => "R +15 %",
            Self::Friction => "friction +10 %",
            Self::TorqueConstant => "k_t +2 %",
            Self::Stiffness => "stiffness +5 %",
        }
    }

    /// Whether a model can be wrong so.
    pub fn concerns(self, model: &Model) -> bool {
        self != Self::Stiffness || !model.stages.is_empty()
    }

    /// A model that is wrong so.
    pub fn of(self, model: &Model) -> Model {
        let mut model = model.clone();
        match self {
            Self::None => {}
            Self::Resistance => model.motor.phase_resistance_ohm *= 1.15,
            Self::TorqueConstant => {
                model.motor.torque_constant_nm_per_a *= 1.02;
                model.motor.phase_back_emf_constant_v_s_per_rad = None;
            }
            Self::Stiffness => {
                for stage in &mut model.stages {
                    stage.stiffness_nm_per_rad *= 1.05;
                    stage.cubic_stiffness_nm_per_rad3 *= 1.05;
                }
            }
            Self::Friction => {
                let stages = model.stages.iter_mut().map(|stage| &mut stage.friction);
                for own in std::iter::once(&mut model.motor.friction).chain(stages) {
                    own.coulomb_nm *= 1.1;
                    own.stribeck_nm *= 1.1;
                    own.sigma2_nm_s_per_rad *= 1.1;
                }
            }
        }
        model
    }
}

/// A motion with its truth, and what the sensors showed of it.
#[derive(Clone, Debug)]
pub struct Case {
    /// Which joint.
    pub joint: String,
    /// In what the model is wrong.
    pub error: Error,
    /// Whether there was an output encoder.
    pub output: bool,
    /// The observer's score,
    pub observer: Score,
    /// its load error on the same samples had the model been right,
    pub right: f64,
    /// and the scores of the baselines that apply.
    pub baselines: Vec<(Baseline, Score)>,
    /// The observer's score on a motion that its model made itself, where the joint's is not known.
    pub exact: Option<Score>,
    /// What a filter that knows the joint could reach at best, where the model is right.
    pub bounds: Option<Bounds>,
    /// The observer's estimates over the truth, where the model is right.
    pub plot: Option<String>,
}

/// A motion's load, last wind-up and friction.
pub fn truths(model: &Model, motion: &Twin) -> Vec<Guess> {
    let layout = Layout::of(model);
    let bases = Bases::si(&model.motor, &model.stages);
    let frictions = frictions(model, motion);
    let rows = motion.states.iter().zip(&motion.load).zip(frictions);
    rows.map(|((state, load), friction)| {
        let wound = |stage: Option<usize>| {
            stage.map_or(f64::NAN, |k| state[layout.deflection(k)] * bases.shaft(k + 1))
        };
        let first = wound((layout.stages > 0).then_some(0));
        Guess { load: *load, first, windup: wound(layout.stages.checked_sub(1)), friction }
    })
    .collect()
}

/// Observer and baselines with one model on one motion.
///
/// # Errors
/// The model cannot be observed.
pub fn judge(
    joint: &str,
    style: Style,
    error: Error,
    model: &Model,
    rating: &Rating,
    samples: &Samples,
    judged: &Judged<'_>,
) -> Result<Case, BuildError> {
    let (observer, [found, sigma]) =
        by_stages!(model.stages.len(), N => observed::<N>(model, rating, samples, judged))?;
    let (kind, step_s) = (samples.kind, samples.step_s);
    let output = samples.seen.iter().any(|seen| seen.output.is_finite());
    let felt = Felt { drive: 1e-3 * rating.drive, torque: 0.01 * breakaway_nm(model) };
    let (samples_of, seed) = (style.samples(), 77);
    let trial =
        Motion { truth: model, kind, step_s, rating, felt, style, samples: samples_of, seed };
    let trial = trial.run()?;
    let trial_seen = shown(model, kind, &trial, output, 78);
    let trial_truth = truths(model, &trial);
    let baselines = Baseline::ALL
        .into_iter()
        .filter(|baseline| baseline.applies(model.stages.len(), output))
        .map(|kind| {
            let knobs = baseline::tuned(kind, model, rating, step_s, &trial_seen, &trial_truth);
            let guesses = baseline::run(kind, knobs, model, rating, step_s, &samples.seen);
            (kind, judged.score(&guesses, None))
        })
        .collect();
    let plot = (error == Error::None)
        .then(|| super::plot::plot(joint, step_s, judged.truth, &found, &sigma));
    let right = observer.load;
    let joint = joint.to_owned();
    Ok(Case { joint, error, output, observer, right, baselines, exact: None, bounds: None, plot })
}

/// The observer on samples: its score, its estimates and its standard deviations.
///
/// # Errors
/// The model cannot be observed.
pub fn observed<const N: usize>(
    model: &Model,
    rating: &Rating,
    samples: &Samples,
    judged: &Judged<'_>,
) -> Result<(Score, [Vec<Guess>; 2]), BuildError> {
    let found = samples.observed::<N>(model, rating, &Tuning::default(), ScalarKind::F32)?;
    let guesses: Vec<Guess> = found.iter().map(Guess::found).collect();
    let sigma: Vec<Guess> = found.iter().map(|f| Guess::spread(&f.estimate.spread)).collect();
    Ok((judged.score(&guesses, Some(&sigma)), [guesses, sigma]))
}

/// A joint drawn at random, and a motion of it.
#[derive(Clone, Debug)]
pub struct Drawn {
    /// Its kind.
    pub name: &'static str,
    /// The joint as it is.
    pub truth: Model,
    /// In what its model is wrong.
    pub error: Error,
    /// For what its observer is designed.
    pub rating: Rating,
    /// How it moves.
    pub style: Style,
    /// The motion,
    pub motion: Twin,
    /// and the noise on the joint in it.
    pub felt: Felt,
    seed: u64,
}

impl Drawn {
    /// The joint of that number.
    ///
    /// # Errors
    /// The model cannot be built.
    pub fn new(number: usize, seed: u64) -> Result<Self, BuildError> {
        let seed = seed.wrapping_mul(1_000_003).wrapping_add(number as u64);
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let (name, mut base) = match number % 3 {
            0 => ("micro", paper()),
            1 => ("actuator", actuator()),
            _ => ("direct", Model { stages: Vec::new(), ..actuator() }),
        };
        let error = Error::ALL[(number / 3) % Error::ALL.len()];
        let sensor = &mut base.sensor;
        for value in
            [&mut sensor.motor_encoder_counts_per_rev, &mut sensor.output_encoder_counts_per_rev]
        {
            *value = (*value * random.random_range(-1.0_f64..1.0).exp2()).round();
        }
        sensor.current_noise_a *= random.random_range(-1.0_f64..1.0).exp2();
        let truth = perturbed(&base, seed);
        let step_s = truth.sensor.sample_time_s;
        let style = if number.is_multiple_of(2) { Style::Creep } else { Style::Duty };
        let mut rating = Rating::of(&truth, Drive::Voltage);
        match style {
            Style::Creep => rating.load_nm *= random.random_range(0.5..1.5),
            Style::Duty => {
                // Up to fifty times the voltage that moves the joint, up to ten times its friction.
                rating.drive *= random.random_range(0.0_f64..3.0).exp2();
                let most = Rating::holds(&truth, Drive::Voltage, rating.drive);
                let held = Rating::held(&truth);
                rating.load_nm = (held * random.random_range(0.0_f64..3.3).exp2()).min(most);
            }
        }
        let size = random.random_range(0.5..1.5);
        let felt =
            Felt { drive: 1e-3 * size * rating.drive, torque: 0.01 * size * breakaway_nm(&truth) };
        let motion = Motion {
            truth: &truth,
            kind: Drive::Voltage,
            step_s,
            rating: &rating,
            felt,
            style,
            samples: style.samples(),
            seed,
        };
        let motion = motion.run()?;
        Ok(Self { name, truth, error, rating, style, motion, felt, seed })
    }

    /// What its sensors show.
    pub fn samples(&self, output: bool) -> Samples {
        let seen = shown(&self.truth, Drive::Voltage, &self.motion, output, self.seed);
        let step_s = self.truth.sensor.sample_time_s;
        Samples { kind: Drive::Voltage, step_s, steps: vec![1; seen.len()], seen }
    }
}

/// A joint drawn at random, seen with and without its output encoder by a model that is wrong in
/// the way whose turn it is.
///
/// # Errors
/// The model cannot be built.
pub fn simulated(number: usize, seed: u64) -> Result<Vec<Case>, BuildError> {
    let drawn = Drawn::new(number, seed)?;
    let Drawn { truth, error, rating, motion, .. } = &drawn;
    let model = error.of(truth);
    let rows = truths(truth, motion);
    let step_s = truth.sensor.sample_time_s;
    let shaft = Bases::si(&truth.motor, &truth.stages).shaft(truth.stages.len());
    let judged = Judged { truth: &rows, jumps: &motion.jumps, step_s, shaft };
    let mut cases = Vec::new();
    for output in [false, true] {
        if output && truth.stages.is_empty() {
            continue;
        }
        let joint = match drawn.style {
            Style::Creep => format!("{}, creep", drawn.name),
            Style::Duty => format!("{}, duty", drawn.name),
        };
        let samples = drawn.samples(output);
        let mut case = judge(&joint, drawn.style, *error, &model, rating, &samples, &judged)?;
        if *error == Error::None {
            let (kind, felt) = (Drive::Voltage, drawn.felt);
            let known = Known { truth, kind, step_s, rating, motion, felt, output };
            case.bounds = Some(bounds(&known)?);
        } else {
            let stages = truth.stages.len();
            let own = by_stages!(stages, N => observed::<N>(truth, rating, &samples, &judged))?;
            case.right = own.0.load;
        }
        cases.push(case);
    }
    Ok(cases)
}
