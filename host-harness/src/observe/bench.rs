//! The observer against truth, with what drives use today beside it.
//!
//! A joint is drawn, its model is made wrong in one way, and both the observer and every baseline
//! are given that wrong model and the same samples. Baselines are tuned on a loaded motion of the
//! model that they are given, never on the one that they are judged by.

use joint_core::joint::Drive;
use joint_core::per_unit::Bases;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::baseline::{self, Baseline, Guess};
use super::design::{Tuning, breakaway_nm, design};
use super::judge::shown;
use super::rating::Rating;
use super::run::{Seen, observer, run};
use super::truth::frictions;
use super::twin::{Felt, Twin, twin};
use crate::demo::actuator;
use crate::model::Model;
use crate::plant::{BuildError, Layout, by_stages};
use crate::scenario::paper;
use crate::synthetic::perturbed;

/// Samples of a simulated joint.
const SAMPLES: usize = 5000;

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

/// How far one method was off on one motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Score {
    /// RMS of the load's error, share of its peak.
    pub load: f64,
    /// RMS of the last wind-up's error, share of its peak; NaN without stages.
    pub windup: f64,
    /// RMS of the friction's error, share of its RMS.
    pub friction: f64,
    /// Median time to 90 % of a step of the load, s; infinite where it is not reached in 50 ms.
    pub t90_s: f64,
    /// Share of load errors within one and two standard deviations; NaN for a baseline.
    pub within: [f64; 2],
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
    /// and those of the baselines that apply.
    pub baselines: Vec<(Baseline, Score)>,
}

/// The sensors' samples with the truth beside them.
#[derive(Clone, Debug)]
pub struct Judged<'a> {
    /// What is given.
    pub seen: &'a [Seen],
    /// What is true.
    pub truth: &'a [Guess],
    /// Samples at which the load steps.
    pub jumps: &'a [usize],
    /// Time between samples, s.
    pub step_s: f64,
}

impl Judged<'_> {
    /// The score of some guesses, with one standard deviation of each load where there is one.
    pub fn score(&self, guesses: &[Guess], sigma: Option<&[f64]>) -> Score {
        let from = self.truth.len() / 10;
        let pairs = || guesses.iter().zip(self.truth).skip(from);
        let count = (self.truth.len() - from) as f64;
        let rms = |of: &dyn Fn(&Guess, &Guess) -> f64| {
            (pairs().map(|(g, t)| of(g, t).powi(2)).sum::<f64>() / count).sqrt()
        };
        let peak =
            |of: &dyn Fn(&Guess) -> f64| self.truth.iter().map(|t| of(t).abs()).fold(0.0, f64::max);
        let within = |many: f64| match sigma {
            Some(sigma) => {
                let inside = pairs().zip(&sigma[from..]);
                let inside = inside.filter(|((g, t), s)| (g.load - t.load).abs() <= many * **s);
                inside.count() as f64 / count
            }
            None => f64::NAN,
        };
        Score {
            load: rms(&|g, t| g.load - t.load) / peak(&|t| t.load),
            windup: rms(&|g, t| g.windup - t.windup) / peak(&|t| t.windup),
            friction: rms(&|g, t| g.friction - t.friction) / rms(&|_, t| t.friction),
            t90_s: self.rise(guesses),
            within: [within(1.0), within(2.0)],
        }
    }

    fn rise(&self, guesses: &[Guess]) -> f64 {
        if guesses.iter().all(|guess| guess.load.is_nan()) {
            return f64::NAN;
        }
        let window = (0.05 / self.step_s) as usize;
        let ends = self.jumps.iter().skip(1).copied().chain([self.truth.len()]);
        let mut times: Vec<f64> = self
            .jumps
            .iter()
            .zip(ends)
            .filter(|(jump, _)| **jump > 0 && **jump >= self.truth.len() / 10)
            .map(|(&jump, end)| {
                let before = self.truth[jump - 1].load;
                let step = self.truth[jump].load - before;
                let until = end.min(jump + window);
                let there = |k: &usize| (guesses[*k].load - before) / step >= 0.9;
                (jump..until).find(there).map_or(f64::INFINITY, |k| (k - jump) as f64 * self.step_s)
            })
            .collect();
        times.sort_by(f64::total_cmp);
        times.get(times.len() / 2).copied().unwrap_or(f64::NAN)
    }
}

/// A motion's load, last wind-up and friction.
pub fn truths(model: &Model, motion: &Twin) -> Vec<Guess> {
    let layout = Layout::of(model);
    let shaft = Bases::si(&model.motor, &model.stages).shaft(layout.stages);
    let last = layout.stages.checked_sub(1).map(|stage| layout.deflection(stage));
    let frictions = frictions(model, motion);
    let rows = motion.states.iter().zip(&motion.load).zip(frictions);
    rows.map(|((state, load), friction)| {
        let windup = last.map_or(f64::NAN, |index| state[index] * shaft);
        Guess { load: *load, windup, friction }
    })
    .collect()
}

/// Observer and baselines with one model on one motion.
///
/// # Errors
/// The model cannot be observed.
pub fn judge(
    model: &Model,
    rating: &Rating,
    judged: &Judged<'_>,
    output: bool,
) -> Result<(Score, Vec<(Baseline, Score)>), BuildError> {
    let own = by_stages!(model.stages.len(), N => observed::<N>(model, rating, judged))?;
    let felt = Felt { drive: 1e-3 * rating.drive, torque: 0.01 * breakaway_nm(model) };
    let trial = twin(model, Drive::Voltage, judged.step_s, rating, &felt, SAMPLES, 77)?;
    let trial_seen = shown(model, Drive::Voltage, &trial, output, 78);
    let trial_truth = truths(model, &trial);
    let baselines = Baseline::ALL
        .into_iter()
        .filter(|baseline| baseline.applies(model.stages.len(), output))
        .map(|kind| {
            let step_s = judged.step_s;
            let knobs = baseline::tuned(kind, model, rating, step_s, &trial_seen, &trial_truth);
            let guesses = baseline::run(kind, knobs, model, rating, step_s, judged.seen);
            (kind, judged.score(&guesses, None))
        })
        .collect();
    Ok((own, baselines))
}

fn observed<const N: usize>(
    model: &Model,
    rating: &Rating,
    judged: &Judged<'_>,
) -> Result<Score, BuildError> {
    let step_s = judged.step_s;
    let design = design::<N>(model, Drive::Voltage, step_s, rating, &Tuning::default())?;
    let observer = observer::<f32, N>(model, Drive::Voltage, step_s, &design)?;
    let found = run(&observer, judged.seen, &[]);
    let guesses: Vec<Guess> = found
        .iter()
        .map(|found| Guess {
            load: found.estimate.load,
            windup: found.estimate.windup.last().copied().unwrap_or(f64::NAN),
            friction: found.estimate.total_friction,
        })
        .collect();
    let sigma: Vec<f64> = found.iter().map(|found| found.estimate.spread.load).collect();
    Ok(judged.score(&guesses, Some(&sigma)))
}

/// A joint drawn at random, seen with and without its output encoder by a model that is wrong in
/// the way whose turn it is.
///
/// # Errors
/// The model cannot be built.
pub fn simulated(number: usize, seed: u64) -> Result<Vec<Case>, BuildError> {
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
    let model = error.of(&truth);
    let step_s = truth.sensor.sample_time_s;
    let mut rating = Rating::of(&truth, Drive::Voltage);
    rating.load_nm *= random.random_range(0.5..1.5);
    let size = random.random_range(0.5..1.5);
    let felt =
        Felt { drive: 1e-3 * size * rating.drive, torque: 0.01 * size * breakaway_nm(&truth) };
    let motion = twin(&truth, Drive::Voltage, step_s, &rating, &felt, SAMPLES, seed)?;
    let truth_rows = truths(&truth, &motion);
    let mut cases = Vec::new();
    for output in [false, true] {
        if output && truth.stages.is_empty() {
            continue;
        }
        let seen = shown(&truth, Drive::Voltage, &motion, output, seed);
        let judged = Judged { seen: &seen, truth: &truth_rows, jumps: &motion.jumps, step_s };
        let (observer, baselines) = judge(&model, &rating, &judged, output)?;
        cases.push(Case { joint: name.to_owned(), error, output, observer, baselines });
    }
    Ok(cases)
}
