//! Noise that a joint's sensors and drive are expected to have.

use firmware::parameters::Sensing;
use joint_core::joint::Drive;
use joint_core::observer::CHANNELS;

use super::rating::Rating;
use crate::model::Model;

/// One sigma of the sensors: A, rad, rad; infinite where the model has none. A rotor encoder of unknown
/// counts is the firmware's default.
pub fn sensors(model: &Model) -> [f64; CHANNELS] {
    let count = |counts: f64| {
        if counts > 0.0 { std::f64::consts::TAU / counts / 12.0_f64.sqrt() } else { f64::INFINITY }
    };
    let sensor = &model.sensor;
    let current = if sensor.current_noise_a > 0.0 { sensor.current_noise_a } else { f64::INFINITY };
    let output = if model.stages.is_empty() {
        f64::INFINITY
    } else {
        count(sensor.output_encoder_counts_per_rev)
    };
    let motor = match sensor.motor_encoder_counts_per_rev {
        counts if counts > 0.0 => counts,
        _ => f64::from(Sensing::DEFAULT.motor_counts_per_turn),
    };
    [current, count(motor), output]
}

/// Noise on the drive, one sigma held over a sample, V or A: a share of the rated one, and of a current
/// that is the input what its sensor adds.
pub fn drive_noise(model: &Model, kind: Drive, rating: &Rating, share: f64) -> f64 {
    let sensor = match kind {
        Drive::Voltage => 0.0,
        Drive::Current => model.sensor.current_noise_a,
    };
    sensor.hypot(share * rating.drive)
}
