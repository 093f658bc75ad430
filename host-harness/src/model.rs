//! The model file.
use joint_core::effect::EffectParameters;
use joint_core::params::{Load, Motor, Stage};

/// What measures the joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensor {
    /// Nominal sample time, s.
    pub sample_time_s: f64,
    /// Counts per turn of the motor encoder; zero where unknown or absent.
    pub motor_encoder_counts_per_rev: f64,
    /// Counts per turn of the output encoder; zero where unknown or absent.
    pub output_encoder_counts_per_rev: f64,
    /// Standard deviation of the current's noise, A.
    pub current_noise_a: f64,
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
