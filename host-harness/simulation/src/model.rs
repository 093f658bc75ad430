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

use std::borrow::Cow;

use joint_core::effect::EffectParameters;
use joint_core::params::{Friction, Load, Location, Motor, Stage};
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
    /// Whether a log's current, where it is the input, was measured: it then stands for the interval around its
    /// sample, not for the one behind it.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub current_is_measured: bool,
    /// How late a log shows the current, where a voltage drives the joint, s; refitted where it is no whole number of
    /// samples.
    #[serde(skip_serializing_if = "is_zero")]
    pub current_delay_s: f64,
}

fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

impl Sensor {
    /// The values by key.
    fn entries(&self) -> [(&'static str, f64); 5] {
        [
            ("sample_time_s", self.sample_time_s),
            ("motor_encoder_counts_per_rev", self.motor_encoder_counts_per_rev),
            ("output_encoder_counts_per_rev", self.output_encoder_counts_per_rev),
            ("current_noise_a", self.current_noise_a),
            ("current_delay_s", self.current_delay_s),
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
    /// Of logs that are fitted to together: the level of all friction on the day of each, over that of the first. No
    /// part of the model's file; a log that is not told has the first one's.
    pub friction_levels: Vec<f64>,
}

impl Model {
    /// The level of all friction on the day of a log, over that of the first.
    pub fn friction_level(&self, log: usize) -> f64 {
        self.friction_levels.get(log).copied().unwrap_or(1.0)
    }

    /// The model on the day of a log.
    pub fn on_day(&self, log: usize) -> Cow<'_, Self> {
        match self.friction_level(log) {
            1.0 => Cow::Borrowed(self),
            level => Cow::Owned(self.with_friction(level)),
        }
    }

    /// The same model with all its friction times a scale: levels, viscous coefficients, bristles alike.
    pub fn with_friction(&self, scale: f64) -> Self {
        let mut model = self.clone();
        let stages = model.stages.iter_mut().map(|stage| &mut stage.friction);
        for friction in std::iter::once(&mut model.motor.friction).chain(stages) {
            *friction = Friction {
                sigma0_nm_per_rad: scale * friction.sigma0_nm_per_rad,
                sigma1_nm_s_per_rad: scale * friction.sigma1_nm_s_per_rad,
                sigma2_nm_s_per_rad: scale * friction.sigma2_nm_s_per_rad,
                coulomb_nm: scale * friction.coulomb_nm,
                stribeck_nm: scale * friction.stribeck_nm,
                stribeck_velocity_rad_per_s: friction.stribeck_velocity_rad_per_s,
            };
        }
        model
    }

    /// Whether anything rubs.
    pub fn rubs(&self) -> bool {
        let rubs = |friction: &Friction| friction.coulomb_nm + friction.sigma2_nm_s_per_rad > 0.0;
        rubs(&self.motor.friction) || self.stages.iter().any(|stage| rubs(&stage.friction))
    }

    /// The masses whose friction sticks, and where they are.
    pub fn sticking(&self) -> impl Iterator<Item = (Location, Friction)> {
        let stages = self.stages.iter().zip(1..);
        let stages = stages.map(|(stage, k)| (Location::Stage(k), stage.friction));
        let masses = std::iter::once((Location::Motor, self.motor.friction)).chain(stages);
        masses.filter(|(_, own)| own.coulomb_nm > 0.0 && own.sigma0_nm_per_rad > 0.0)
    }
}
