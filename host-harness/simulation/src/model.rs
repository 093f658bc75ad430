//! A joint as its file describes it: parameters, sensors, and the effects added to it.
//!
//! The file is where a person and this program meet: read, refitted, extended, written back and
//! read again. So what is written reads back to the very same numbers, and what cannot be read is
//! shown where it stands. docs/model-format.md describes the file.

mod admissible;
mod effect;
mod read;
mod source;
mod span;
mod write;

use joint_core::effect::EffectParameters;
use joint_core::params::{Load, Motor, Stage};
use serde::{Deserialize, Serialize};

/// What measures the joint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Sensor {
    /// Nominal sample time, s; zero where unknown.
    pub sample_time_s: f64,
    /// Counts per turn of the motor encoder; zero where unknown or absent.
    pub motor_encoder_counts_per_rev: f64,
    /// Counts per turn of the output encoder; zero where unknown or absent.
    pub output_encoder_counts_per_rev: f64,
    /// Standard deviation of the current's noise, A.
    pub current_noise_a: f64,
}

impl Sensor {
    /// The values by key.
    fn entries(&self) -> [(&'static str, f64); 4] {
        [
            ("sample_time_s", self.sample_time_s),
            ("motor_encoder_counts_per_rev", self.motor_encoder_counts_per_rev),
            ("output_encoder_counts_per_rev", self.output_encoder_counts_per_rev),
            ("current_noise_a", self.current_noise_a),
        ]
    }
}

/// A joint: its parameters, its sensors, and the effects added to it.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// Name of the joint.
    pub name: String,
    /// The motor.
    pub motor: Motor,
    /// The stages, from the motor on.
    pub stages: Vec<Stage>,
    /// What hangs on the last mass.
    pub load: Load,
    /// The sensors.
    pub sensor: Sensor,
    /// Effects beside the plain equations.
    pub effects: Vec<EffectParameters>,
}
