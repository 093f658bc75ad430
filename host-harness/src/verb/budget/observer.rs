//! An update of the observer of the assumed joint, without effects and in one micro-step: what the
//! emulated chip needs to count it.

use std::f64::consts::TAU;

use firmware::block;
use firmware::observing::{Observing, to_bytes};
use joint_core::joint::{Drive, Joint, Settings};
use joint_core::observer::{Gains, Observer, Sample, Turn};

use crate::model::{Model, Sensor};
use crate::observe::design::{Tuning, design};
use crate::observe::judge::shown;
use crate::observe::rating::Rating;
use crate::observe::twin::{Felt, twin};
use crate::scenario;
use crate::verb::Failure;

const STEP_S: f64 = 50e-6;
const SAMPLES: usize = 2_001;
/// Samples without a rotor angle: the costly path of a sample that is missed and found again.
const MISSED: std::ops::Range<usize> = 900..1000;

/// The observer as a block, and the log that it is run over.
pub(super) fn files() -> Result<[Vec<u8>; 2], Failure> {
    let failed = |error: &dyn std::fmt::Display| Failure::check(error.to_string());
    let sensor = Sensor {
        sample_time_s: STEP_S,
        motor_encoder_counts_per_rev: 3000.0,
        output_encoder_counts_per_rev: 65536.0,
        current_noise_a: 1.5e-3,
    };
    let model = Model { sensor, ..scenario::paper() };
    let drive = Drive::Voltage;
    let rating = Rating { load_nm: 0.02, ..Rating::of(&model, drive) };
    let [first, second] = model.stages[..] else {
        return Err(Failure::check("the assumed joint has two stages"));
    };
    let stages = [first, second];
    let settings = Settings { micro_steps: Some(1), ..Settings::new(drive, STEP_S) };
    let joint = Joint::<f32, 2>::new(&model.motor, &stages, &model.load, &settings)
        .map_err(|error| failed(&error))?;
    let design = design::<2>(&model, drive, STEP_S, &rating, &Tuning::default())
        .map_err(|error| failed(&error))?;
    let gains = Gains::new(&design, &model.motor, &stages, drive, STEP_S);
    let observer: Observing<2> = Observer { joint, gains };
    let mut parameters = vec![0; 6144];
    let length = block::encode(&observer, 2, &mut parameters).map_err(|error| failed(&error))?;
    parameters.truncate(length);

    let felt = Felt { drive: 0.005, torque: 1e-7 };
    let motion =
        twin(&model, drive, STEP_S, &rating, &felt, SAMPLES, 7).map_err(|error| failed(&error))?;
    let mut seen = shown(&model, drive, &motion, true, 7);
    for sample in seen[MISSED].iter_mut().step_by(7) {
        sample.motor = f64::NAN;
    }
    let turn = |angle: f64| angle.is_finite().then(|| Turn::from_turns(angle / TAU));
    let records = seen.iter().flat_map(|seen| {
        to_bytes(&Sample {
            drive: seen.drive as f32,
            current: seen.current.is_finite().then_some(seen.current as f32),
            motor: turn(seen.motor),
            output: turn(seen.output),
        })
    });
    Ok([parameters, records.collect()])
}
