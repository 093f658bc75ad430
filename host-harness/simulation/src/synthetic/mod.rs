//! Logs like a real drive's, made from a model whose truth is known.
//!
//! What finds effects has to be tried on joints where the answer is certain, and a log that is too
//! clean proves nothing. So the joint is run by the reference, with noise on what drives it, a
//! Stribeck curve that is not quite the model's, and sensors that count and round. Everything
//! follows from the seed.

mod controller;
mod excitation;
mod motion;
mod noise;
mod perturbed;
mod sensing;
mod setting;
#[cfg(test)]
mod tests;
mod visible;
mod wide;
#[cfg(test)]
mod wide_tests;

pub use excitation::{amplitude_v, excitation};
pub use motion::Motion;
pub use noise::Colour;
pub use perturbed::{perturbed, perturbed_within};
pub use sensing::{Reported, Stamps};
pub use setting::{Disturbances, Sensing, Setting};
pub use wide::{Recorded, record_wide};

use std::f64::consts::TAU;

use joint_core::joint::Drive;
use joint_core::per_unit::Bases;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::encoders;
use crate::log::Log;
use crate::model::Model;
use crate::plant::{Inputs, Snapshot};
use crate::reference::{self, Disturbance, Method, Options, ReferenceError};

/// What is done to a joint and how it is measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Experiment {
    /// Length of the log, s.
    pub duration_s: f64,
    /// Sample time, s; zero takes the model's sensor's, or 0.1 ms.
    pub sample_time_s: f64,
    /// Voltage sample by sample, held at its last value past its end; `None` takes
    /// [`excitation`].
    pub voltage_v: Option<Vec<f64>>,
    /// Load at the output sample by sample, Nm; it is not logged. Empty: none.
    pub load_nm: Vec<f64>,
    /// Standard deviation of the voltage's process noise as a share of the excitation's amplitude.
    pub voltage_noise: f64,
    /// The same of the rotor torque's, as a share of the joint's breakaway torque.
    pub torque_noise: f64,
    /// Exponent of the Stribeck curve; 2 in the model.
    pub stribeck_exponent: f64,
    /// Rest before the log begins, s: from and to.
    pub rest_s: [f64; 2],
}

impl Default for Experiment {
    /// 1.5 s of the standard excitation, with a little of every imperfection.
    fn default() -> Self {
        Self {
            duration_s: 1.5,
            sample_time_s: 0.0,
            voltage_v: None,
            load_nm: Vec::new(),
            voltage_noise: 2e-3,
            torque_noise: 1e-2,
            stribeck_exponent: 1.85,
            rest_s: [0.05, 0.15],
        }
    }
}

impl Experiment {
    /// No noise, the model's own friction, no rest: what is left is what the sensors do.
    pub fn clean(duration_s: f64) -> Self {
        Self {
            duration_s,
            voltage_noise: 0.0,
            torque_noise: 0.0,
            stribeck_exponent: 2.0,
            rest_s: [0.0, 0.0],
            ..Self::default()
        }
    }

    fn sample_time(&self, model: &Model) -> f64 {
        let given = [self.sample_time_s, model.sensor.sample_time_s];
        given.into_iter().find(|time| *time > 0.0).unwrap_or(1e-4)
    }
}

/// Runs the experiment on the joint and writes down what its sensors say.
///
/// # Errors
/// The model or the experiment makes no sense to the reference.
pub fn record(model: &Model, experiment: &Experiment, seed: u64) -> Result<Log, ReferenceError> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let sample = experiment.sample_time(model);
    let count = (experiment.duration_s / sample).round();
    let [from, to] = experiment.rest_s;
    let rest = ((from + (to - from) * random.random::<f64>()) / sample).round();
    if !(count >= 1.0 && rest >= 0.0 && count + rest < 1e9) {
        return Err(ReferenceError::Inputs("the experiment has no length, or none that fits"));
    }
    let (count, rest) = (count as usize, rest as usize);
    let voltage = match &experiment.voltage_v {
        Some(given) => {
            let last = given.last().copied().unwrap_or(0.0);
            (0..count).map(|k| given.get(k).copied().unwrap_or(last)).collect()
        }
        None => excitation(model, count, sample, &mut random),
    };
    let inputs = with_rest(&voltage, &experiment.load_nm, rest, sample);
    let highest = voltage.iter().fold(0.0_f64, |highest, u| highest.max(u.abs()));
    let (volts, torque) =
        (experiment.voltage_noise * highest, experiment.torque_noise * breakaway_nm(model));
    let mut white = |deviation: f64| -> Vec<f64> {
        (0..inputs.time_s.len()).map(|_| deviation * normal(&mut random)).collect()
    };
    let disturbance =
        Disturbance { drive: white(volts), torque_nm: white(torque), ..Disturbance::default() };
    let options = Options {
        stribeck_exponent: experiment.stribeck_exponent,
        disturbance,
        ..Options::of(Method::Scaled { share: 0.4 })
    };
    let run = reference::simulate(model, &inputs, &options)?;
    Ok(measured(model, &run[rest..], voltage, sample, &mut random))
}

/// The inputs with a rest before them.
fn with_rest(voltage: &[f64], load: &[f64], rest: usize, sample: f64) -> Inputs {
    let total = rest + voltage.len();
    let after_rest = |values: &[f64]| -> Vec<f64> {
        let moved = |k: usize| k.checked_sub(rest).and_then(|k| values.get(k));
        (0..total).map(|k| moved(k).copied().unwrap_or(0.0)).collect()
    };
    Inputs {
        time_s: (0..total).map(|k| k as f64 * sample).collect(),
        drive: Drive::Voltage,
        drive_values: after_rest(voltage),
        load_nm: after_rest(load),
    }
}

/// What the sensors show of a run: encoders zeroed at its start.
fn measured(
    model: &Model,
    run: &[Snapshot],
    voltage: Vec<f64>,
    sample: f64,
    random: &mut ChaCha8Rng,
) -> Log {
    let sensor = &model.sensor;
    let noise = sensor.current_noise_a;
    let current = run
        .iter()
        .map(|snapshot| rounded(snapshot.measured_current_a + noise * normal(random), 0.5 * noise));
    let current_a = Some(current.collect());
    let time_s: Vec<f64> = (0..run.len()).map(|k| k as f64 * sample).collect();
    let shown = encoders::shown(model, &time_s, run);
    let encoder = |counts: f64, angles: &[f64]| -> Vec<f64> {
        let resolution = if counts > 0.0 { TAU / counts } else { 0.0 };
        let zero = angles.first().copied().unwrap_or(0.0);
        angles.iter().map(|angle| rounded(angle - zero, resolution)).collect()
    };
    let counts = sensor.output_encoder_counts_per_rev;
    Log {
        time_s,
        voltage_v: Some(voltage),
        current_a,
        motor_angle_rad: encoder(sensor.motor_encoder_counts_per_rev, &shown.motor),
        output_angle_rad: (counts > 0.0 && !model.stages.is_empty())
            .then(|| encoder(counts, &shown.output)),
        ..Log::default()
    }
}

fn normal(random: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(random)
}

fn rounded(value: f64, resolution: f64) -> f64 {
    if resolution > 0.0 { (value / resolution).round() * resolution } else { value }
}

/// Torque at the motor that breaks the whole joint away, Nm.
pub fn breakaway_nm(model: &Model) -> f64 {
    let bases = Bases::si(&model.motor, &model.stages);
    let stages = model.stages.iter().enumerate();
    let behind: f64 =
        stages.map(|(k, stage)| stage.friction.breakaway_nm() * bases.shaft(k + 1).abs()).sum();
    model.motor.friction.breakaway_nm() + behind
}
