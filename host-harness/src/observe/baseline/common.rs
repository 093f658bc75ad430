//! What several of them share: friction curves, springs, the channels with nothing missing.

use std::f64::consts::TAU;

use joint_core::params::Friction;
use joint_core::per_unit::Bases;

use super::super::run::Seen;
use crate::model::Model;

/// Friction of one mass, reflected to the motor.
pub(super) struct Law<'a> {
    pub(super) own: &'a Friction,
    pub(super) shaft: f64,
}

impl Law<'_> {
    /// Stribeck curve, smooth over `width` rad/s of the motor about zero.
    pub(super) fn at(&self, motor_speed: f64, width: f64) -> f64 {
        let speed = motor_speed * self.shaft;
        let bell = match self.own.stribeck_velocity_rad_per_s {
            scale if scale > 0.0 => (-(speed / scale).powi(2)).exp(),
            _ => 0.0,
        };
        let level = self.own.coulomb_nm + self.own.stribeck_nm * bell;
        let sign = (motor_speed / width.max(1e-12)).tanh();
        (level * sign + self.own.sigma2_nm_s_per_rad * speed) * self.shaft
    }

    /// A tenth of the Stribeck velocity, and no less than an explicit step bears.
    pub(super) fn width(&self, step_s: f64, inertia: f64) -> f64 {
        let narrow = 0.1 * self.own.stribeck_velocity_rad_per_s / self.shaft;
        narrow.max(2.0 * self.own.breakaway_nm() * self.shaft * step_s / inertia)
    }
}

pub(super) fn laws(model: &Model) -> Vec<Law<'_>> {
    let bases = Bases::si(&model.motor, &model.stages);
    let stages = model.stages.iter().enumerate();
    std::iter::once(Law { own: &model.motor.friction, shaft: 1.0 })
        .chain(
            stages.map(|(k, stage)| Law { own: &stage.friction, shaft: bases.shaft(k + 1).abs() }),
        )
        .collect()
}

/// Linear stiffness of every spring at the motor, and the cubic one of the last.
pub(super) fn stiffness(model: &Model) -> Vec<(f64, f64)> {
    let bases = Bases::si(&model.motor, &model.stages);
    let stages = model.stages.iter().enumerate();
    stages
        .map(|(k, stage)| {
            let square = bases.shaft(k + 1).powi(2);
            let cubic = stage.cubic_stiffness_nm_per_rad3 * square * square;
            (stage.stiffness_nm_per_rad * square, cubic)
        })
        .collect()
}

/// Deflection of a spring under a torque, by Newton's method.
pub(super) fn bent((linear, cubic): (f64, f64), torque: f64) -> f64 {
    let mut x = torque / linear;
    for _ in 0..8 {
        x -= (linear * x + cubic * x.powi(3) - torque) / (linear + 3.0 * cubic * x * x);
    }
    x
}

/// Torque through springs in series that are wound up by so much together.
pub(super) fn series(stiffness: &[(f64, f64)], wound: f64) -> f64 {
    let soft: f64 = stiffness.iter().map(|own| 1.0 / own.0).sum();
    let mut torque = wound / soft;
    for _ in 0..8 {
        let mut left = -wound;
        let mut slope = 0.0;
        for own in stiffness {
            let x = bent(*own, torque);
            left += x;
            slope += 1.0 / (own.0 + 3.0 * own.1 * x * x);
        }
        torque -= left / slope;
    }
    torque
}

/// Holds what is missing.
pub(super) fn held(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut last = 0.0;
    values
        .map(|value| {
            if value.is_finite() {
                last = value;
            }
            last
        })
        .collect()
}

pub(super) fn torque(model: &Model, seen: &[Seen]) -> Vec<f64> {
    let current = seen.iter().map(|s| if s.current.is_finite() { s.current } else { f64::NAN });
    held(current).iter().map(|i| i * model.motor.torque_constant_nm_per_a).collect()
}

/// Speed from an angle by a low-passed difference.
pub(super) fn speeds(angles: &[f64], cutoff: f64, step_s: f64) -> Vec<f64> {
    let share = 1.0 - (-TAU * cutoff * step_s).exp();
    let mut speed = 0.0;
    let mut last = angles.first().copied().unwrap_or(0.0);
    angles
        .iter()
        .map(|angle| {
            speed += share * ((angle - last) / step_s - speed);
            last = *angle;
            speed
        })
        .collect()
}

/// Wind-up of the first and the last stage, rad there, under a torque at the motor.
pub(super) fn wound(model: &Model, torque: f64) -> [f64; 2] {
    let bases = Bases::si(&model.motor, &model.stages);
    let springs = stiffness(model);
    let of = |stage: usize| bent(springs[stage], torque) * bases.shaft(stage + 1);
    match springs.len() {
        0 => [f64::NAN; 2],
        stages => [of(0), of(stages - 1)],
    }
}
