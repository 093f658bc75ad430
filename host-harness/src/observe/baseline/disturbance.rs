//! Momentum observer: what is left of the torque balance of one inertia.

use std::f64::consts::TAU;

use super::super::run::Seen;
use super::super::score::Guess;
use super::common::{held, laws, speeds, torque, wound};
use crate::model::Model;
use crate::plant::{inertias, output_shaft};

pub(super) fn disturbance(cutoff: f64, model: &Model, step_s: f64, seen: &[Seen]) -> Vec<Guess> {
    let laws = laws(model);
    let inertia: f64 = inertias(model).iter().sum();
    let shaft = output_shaft(model);
    let torque = torque(model, seen);
    let speed = speeds(&held(seen.iter().map(|s| s.motor)), 2.0 * cutoff, step_s);
    let pull = (TAU * cutoff).min(0.5 / step_s);
    let (mut sum, mut left) = (inertia * speed.first().copied().unwrap_or(0.0), 0.0);
    torque
        .iter()
        .zip(&speed)
        .map(|(torque, speed)| {
            let friction: f64 =
                laws.iter().map(|law| law.at(*speed, law.width(step_s, inertia))).sum();
            // The residual of the momentum is the torque that acts beside the known ones.
            left = pull * (inertia * speed - sum);
            sum += step_s * (torque - friction + left);
            // The load is positive against positive motion.
            let load = -left / shaft;
            let [first, windup] = wound(model, -left);
            Guess { load, first, windup, friction }
        })
        .collect()
}
