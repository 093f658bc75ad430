//! A voltage that shows what is in a joint.
//!
//! Each part of a model speaks up elsewhere: inertia and the winding in steps, elasticity in a
//! chirp, everything that depends on the angle in long even runs, friction in slow reversals, the
//! sensors' zeros at a stop. The sequence has them all, at a size that the joint's own friction,
//! gravity and back-EMF set.

use std::f64::consts::TAU;

use joint_core::per_unit::Bases;
use rand::{Rng, RngExt};

use super::breakaway_nm;
use crate::model::Model;

/// Lines of the multisine, Hz.
const LINES_HZ: [f64; 8] = [1.3, 2.9, 5.3, 11.0, 19.0, 37.0, 61.0, 97.0];

/// The voltage that just moves the joint, V: friction and the highest gravity torque.
pub(super) fn breakaway_v(model: &Model) -> f64 {
    let bases = Bases::si(&model.motor, &model.stages);
    let gravity = (model.load.gravity_nm * bases.shaft(model.stages.len())).abs();
    bases.resistance * (breakaway_nm(model) + gravity) / model.motor.torque_constant_nm_per_a
}

/// Amplitude of [`excitation`], V: six times what moves the joint, and enough to run at fifteen
/// times the highest Stribeck velocity, where friction has left its curve.
pub fn amplitude_v(model: &Model) -> f64 {
    let bases = Bases::si(&model.motor, &model.stages);
    let stages =
        model.stages.iter().enumerate().map(|(k, stage)| {
            stage.friction.stribeck_velocity_rad_per_s / bases.shaft(k + 1).abs()
        });
    let velocity = stages.fold(model.motor.friction.stribeck_velocity_rad_per_s, f64::max);
    let running = 15.0 * velocity * model.motor.torque_constant_nm_per_a;
    let moving = breakaway_v(model);
    (6.0 * moving).max(moving + running)
}

/// The voltage of `count` samples, V: stop, steps, an even run each way, chirp, multisine, slow
/// reversals across breakaway, stop. Phases and sizes are drawn from `random`.
pub fn excitation(model: &Model, count: usize, sample_s: f64, random: &mut impl Rng) -> Vec<f64> {
    let full = amplitude_v(model);
    let slow = (2.5 * breakaway_v(model)).min(full);
    let duration = count as f64 * sample_s;
    let steps: Vec<f64> = (0..6)
        .map(|k| if k % 2 == 0 { 1.0 } else { -1.0 } * random.random_range(0.4..1.0))
        .collect();
    let phases: Vec<f64> = LINES_HZ.iter().map(|_| TAU * random.random::<f64>()).collect();
    let run = random.random_range(0.5..0.9);
    let (low, high): (f64, f64) = (2.0 / duration, 60.0);
    let at = |k: usize| {
        let share = k as f64 / count as f64;
        // Place in a part from `from` to `to`, 0 to 1.
        let within = |from: f64, to: f64| (share - from) / (to - from);
        match share {
            s if s < 0.04 => 0.0,
            s if s < 0.22 => {
                let step = (within(0.04, 0.22) * steps.len() as f64) as usize;
                full * steps.get(step).copied().unwrap_or(0.0)
            }
            s if s < 0.32 => full * run,
            s if s < 0.42 => -full * run,
            s if s < 0.60 => {
                let (place, length) = (within(0.42, 0.60), 0.18 * duration);
                let rate = (high / low).ln();
                0.8 * full * (TAU * low * length * ((place * rate).exp() - 1.0) / rate).sin()
            }
            s if s < 0.76 => {
                let time = k as f64 * sample_s;
                let lines = LINES_HZ.iter().zip(&phases);
                let sum: f64 = lines.map(|(line, phase)| (TAU * line * time + phase).sin()).sum();
                full * sum / 4.0
            }
            s if s < 0.95 => slow * (TAU * 3.0 * within(0.76, 0.95)).sin(),
            _ => 0.0,
        }
    };
    (0..count).map(at).collect()
}
