//! Relative force error: motor torque against model torque over a record, the figure by which rigid
//! axes are judged in the identification literature.
//!
//! The measured angle is filtered forward and backward (no phase shift) and differenced twice; the
//! model's torque in steady slip is compared with the motor's, both low-passed to a twenty-fifth of
//! the sampling rate as Janot, Gautier and Brunot do with the EMPS record.

use std::f64::consts::PI;

use joint_core::effect::Kind;
use joint_core::joint::Drive;

use crate::estimate::record::{Channel, Record};
use crate::model::Model;

/// Samples at each end that the filters need to settle.
const EDGE: usize = 75;

/// Relative force error of a joint without stages, `None` where the record or the model does not
/// allow one: stages, a voltage, uneven sampling, or missing angles.
pub fn relative_force_error(model: &Model, record: &Record) -> Option<f64> {
    if !model.stages.is_empty() || record.drive != Drive::Current || record.len() < 200 {
        return None;
    }
    let steps = record.time_s.windows(2).map(|pair| pair[1] - pair[0]);
    let (low, high) = steps.fold((f64::INFINITY, 0.0_f64), |(l, h), s| (l.min(s), h.max(s)));
    let step = record.grid.interval(0);
    if high - low > 0.01 * step || record.starts.len() > 1 {
        return None;
    }
    let angle: Vec<f64> = record.measured.iter().map(|row| row[Channel::Motor as usize]).collect();
    if !angle.iter().all(|a| a.is_finite()) {
        return None;
    }
    let smooth = both_ways(&angle, 0.1);
    let speed = difference(&smooth, step);
    let acceleration = difference(&speed, step);
    let offset = model.effects.iter().find(|effect| effect.kind == Kind::CurrentOffset);
    let offset = offset.map_or(0.0, |effect| effect.values[0]);
    let modelled: Vec<f64> =
        (0..angle.len()).map(|k| load(model, angle[k], speed[k], acceleration[k])).collect();
    let constant = model.motor.torque_constant_nm_per_a;
    let motor: Vec<f64> = (0..angle.len())
        .map(|k| constant * ripple(model, angle[k]) * (record.drive_values[k] - offset))
        .collect();
    let (modelled, motor) = (both_ways(&modelled, 0.04), both_ways(&motor, 0.04));
    // The filters' own start and end are no measurement.
    let inner = EDGE..angle.len() - EDGE;
    let missed: f64 = inner.clone().map(|k| (motor[k] - modelled[k]).powi(2)).sum();
    let whole: f64 = inner.map(|k| motor[k].powi(2)).sum();
    (whole > 0.0).then(|| (missed / whole).sqrt())
}

/// What the motor must overcome at a motion in steady slip, Nm.
fn load(model: &Model, angle: f64, speed: f64, acceleration: f64) -> f64 {
    let friction = &model.motor.friction;
    let sign = speed.signum();
    let relative = speed / friction.stribeck_velocity_rad_per_s;
    let mut level = friction.coulomb_nm + friction.stribeck_nm * (-relative * relative).exp();
    let mut viscous = friction.sigma2_nm_s_per_rad;
    let mut position = model.load.gravity_nm * (angle + model.load.gravity_phase_rad).sin();
    for effect in &model.effects {
        let [first, second, third, fourth, fifth, ..] = effect.values;
        match effect.kind {
            Kind::AsymmetricFriction => {
                level *= 1.0 + first * sign;
                viscous *= 1.0 + second * sign;
            }
            Kind::PositionDependentFriction => {
                level *= 1.0 + first * (third * angle + second).sin()
            }
            Kind::QuadraticDrag => viscous += first * speed.abs(),
            Kind::Cogging => {
                position += second * (first * angle + third).sin()
                    + fourth * (2.0 * first * angle + fifth).sin();
            }
            Kind::Gravity => position += first * (angle + second).sin(),
            _ => {}
        }
    }
    let inertia = model.motor.rotor_inertia_kg_m2 + model.load.inertia_kg_m2;
    inertia * acceleration + sign * level + viscous * speed + position
}

/// What torque ripple makes of the torque constant.
fn ripple(model: &Model, angle: f64) -> f64 {
    let ripples = model.effects.iter().filter(|effect| effect.kind == Kind::TorqueRipple);
    ripples.fold(1.0, |gain, effect| {
        let [amplitude, phase, order, ..] = effect.values;
        gain * (1.0 + amplitude * (order * angle + phase).cos())
    })
}

/// A fourth-order Butterworth low-pass run forward and backward; `share` is its corner over the
/// sampling rate.
fn both_ways(values: &[f64], share: f64) -> Vec<f64> {
    let mut out = values.to_vec();
    for quality in [0.541_196_1, 1.306_563] {
        let low_pass = Biquad::low_pass(share, quality);
        out = low_pass.run(out.iter().copied());
        out.reverse();
        out = low_pass.run(out.iter().copied());
        out.reverse();
    }
    out
}

struct Biquad {
    b: [f64; 3],
    a: [f64; 2],
}

impl Biquad {
    fn low_pass(share: f64, quality: f64) -> Self {
        let k = (PI * share).tan();
        let norm = 1.0 / (1.0 + k / quality + k * k);
        let gain = k * k * norm;
        Self {
            b: [gain, 2.0 * gain, gain],
            a: [2.0 * (k * k - 1.0) * norm, (1.0 - k / quality + k * k) * norm],
        }
    }

    /// Starts as if the first value had always been there.
    fn run(&self, values: impl ExactSizeIterator<Item = f64>) -> Vec<f64> {
        let [b0, b1, b2] = self.b;
        let [a1, a2] = self.a;
        let (mut s1, mut s2, mut fresh) = (0.0, 0.0, true);
        values
            .map(|x| {
                if fresh {
                    fresh = false;
                    s2 = (b2 - a2) * x;
                    s1 = (b1 - a1) * x + s2;
                }
                let y = b0 * x + s1;
                s1 = b1 * x - a1 * y + s2;
                s2 = b2 * x - a2 * y;
                y
            })
            .collect()
    }
}

fn difference(values: &[f64], step: f64) -> Vec<f64> {
    let last = values.len() - 1;
    (0..values.len())
        .map(|k| {
            let (low, high) = (k.saturating_sub(1), (k + 1).min(last));
            (values[high] - values[low]) / ((high - low) as f64 * step)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_low_pass_keeps_a_constant_and_a_slow_sine_without_delay() {
        let slow: Vec<f64> = (0..2000).map(|k| 3.0 + (0.01 * f64::from(k)).sin()).collect();
        let out = both_ways(&slow, 0.04);
        for k in 100..1900 {
            assert!((out[k] - slow[k]).abs() < 1e-3);
        }
        let fast: Vec<f64> = (0..2000).map(|k| (2.0 * f64::from(k)).sin()).collect();
        assert!(both_ways(&fast, 0.04)[100..1900].iter().all(|y| y.abs() < 1e-4));
    }
}
