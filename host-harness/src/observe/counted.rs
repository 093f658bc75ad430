//! The observer of the assumed joint, and a log of it with everything that a drive may meet: what an
//! emulated chip runs, to be counted and to be compared with the host.

use std::f64::consts::TAU;

use joint_core::joint::{Drive, Joint, Settings};
use joint_core::observer::{Gains, Observer, Sample, Turn};
use joint_core::scalar::Real;

use super::design::{Tuning, design};
use super::judge::shown;
use super::rating::Rating;
use super::run::Seen;
use super::twin::{Felt, Motion, Style};
use crate::model::{Model, Sensor};
use crate::plant::BuildError;
use crate::scenario::paper;

/// Time between samples, s.
pub const STEP_S: f64 = 50e-6;
/// Samples of the log.
pub const SAMPLES: usize = 3001;

/// The paper's joint, with a drive's sensors read that often.
pub fn model(step_s: f64) -> Model {
    let sensor = Sensor {
        sample_time_s: step_s,
        motor_encoder_counts_per_rev: 3000.0,
        output_encoder_counts_per_rev: 65536.0,
        current_noise_a: 1.5e-3,
        ..Sensor::default()
    };
    Model { sensor, ..paper() }
}

fn rating(model: &Model) -> Rating {
    Rating { load_nm: 0.02, ..Rating::of(model, Drive::Voltage) }
}

/// Its observer, without effects and in one micro-step.
///
/// # Errors
/// The model cannot be observed.
pub fn observer<S: Real>() -> Result<Observer<S, 2>, BuildError> {
    let model = model(STEP_S);
    let design = design::<2>(&model, Drive::Voltage, STEP_S, &rating(&model), &Tuning::default())?;
    let stages = [model.stages[0], model.stages[1]];
    let settings = Settings { micro_steps: Some(1), ..Settings::new(Drive::Voltage, STEP_S) };
    let joint = Joint::<S, 2>::new(&model.motor, &stages, &model.load, &settings)?;
    let gains = Gains::new(&design, &model.motor, &stages, Drive::Voltage, STEP_S);
    Ok(Observer { joint, gains })
}

/// What its sensors show of a motion under loads, with samples lost, repeated, off and not a number.
///
/// # Errors
/// The model cannot be built.
pub fn log() -> Result<Vec<Seen>, BuildError> {
    let model = model(STEP_S);
    let felt = Felt { drive: 0.005, torque: 1e-7 };
    let motion = Motion {
        truth: &model,
        kind: Drive::Voltage,
        step_s: STEP_S,
        rating: &rating(&model),
        felt,
        style: Style::Creep,
        samples: SAMPLES,
        seed: 7,
    };
    let motion = motion.run()?;
    let mut seen = shown(&model, Drive::Voltage, &motion, true, 7);
    for k in (900..1000).step_by(7) {
        seen[k].motor = f64::NAN;
    }
    for k in (1100..1300).step_by(9) {
        seen[k] = seen[k - 1];
    }
    seen[1400].motor += 2.0;
    seen[1500].drive = f64::NAN;
    seen[1600].current = f64::NAN;
    seen[1700].current = 50.0;
    Ok(seen)
}

/// A sample as the drive has it; what is missing in fixed point, which has no such number, is zero.
pub fn sample<S: Real>(seen: &Seen) -> Sample<S> {
    let turn = |angle: f64| angle.is_finite().then(|| Turn::from_turns(angle / TAU));
    Sample {
        drive: S::from_f64(seen.drive),
        current: seen.current.is_finite().then(|| S::from_f64(seen.current)),
        motor: turn(seen.motor),
        output: turn(seen.output),
    }
}
