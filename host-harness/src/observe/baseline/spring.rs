//! Spring torque from both encoders, less what turns the output.

use std::f64::consts::TAU;

use super::super::run::Seen;
use super::super::score::Guess;
use super::common::{held, laws, series, speeds, stiffness, wound};
use crate::model::Model;
use crate::plant::{inertias, output_shaft};

pub(super) fn spring(cutoff: f64, model: &Model, step_s: f64, seen: &[Seen]) -> Vec<Guess> {
    let (laws, shaft) = (laws(model), output_shaft(model));
    let (Some(last), Some(inertia)) = (laws.last(), inertias(model).last().copied()) else {
        return vec![Guess::NOTHING; seen.len()];
    };
    let stiffness = stiffness(model);
    let motor = held(seen.iter().map(|s| s.motor));
    let output = held(seen.iter().map(|s| s.output / shaft));
    let speed = speeds(&output, 2.0 * cutoff, step_s);
    let motor_speed = speeds(&motor, 2.0 * cutoff, step_s);
    let width = last.width(step_s, inertia);
    let pull = (TAU * cutoff).min(0.5 / step_s);
    let mut sum = 0.0;
    (0..seen.len())
        .map(|k| {
            let torque = series(&stiffness, motor[k] - output[k]);
            let left = pull * (inertia * speed[k] - sum);
            sum += step_s * (torque - last.at(speed[k], width) + left);
            let [first, windup] = wound(model, torque);
            let friction = laws.iter().map(|law| law.at(motor_speed[k], width)).sum();
            Guess { load: -left / shaft, first, windup, friction }
        })
        .collect()
}
