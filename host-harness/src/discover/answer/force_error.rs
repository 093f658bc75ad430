//! Relative force error: motor torque against model torque over a record, the figure by which rigid
//! axes are judged in the identification literature.
//!
//! The measured angle is filtered forward and backward (no phase shift) and differenced twice; the
//! model's torque in steady slip is compared with the motor's, both low-passed to a twenty-fifth of
//! the sampling rate as Janot, Gautier and Brunot do with the EMPS record.

use std::f64::consts::PI;

use joint_core::joint::Drive;

use crate::estimate::record::{Channel, Record};
use crate::model::Model;
use crate::plant::Layout;
use crate::reference::{Equations, Held};

/// δ of the model's Stribeck curve.
const STRIBECK_EXPONENT: f64 = 2.0;
/// Samples at each end that the filters need to settle.
const EDGE: usize = 75;

/// Relative force error of a joint without stages, `None` where the record or the model does not
/// allow one: stages, a voltage, uneven sampling, or missing angles.
pub(crate) fn relative_force_error(model: &Model, record: &Record) -> Option<f64> {
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
    let equations = Equations::new(model, record.drive, STRIBECK_EXPONENT).ok()?;
    let missed: Vec<f64> = (0..angle.len())
        .map(|k| missing(&equations, record.drive_values[k], angle[k], speed[k], acceleration[k]))
        .collect();
    let inertia = model.motor.rotor_inertia_kg_m2 + model.load.inertia_kg_m2;
    let missed: Vec<f64> = missed.iter().map(|missed| inertia * missed).collect();
    let constant = model.motor.torque_constant_nm_per_a;
    let motor: Vec<f64> = record.drive_values.iter().map(|i| constant * i).collect();
    let (missed, motor) = (both_ways(&missed, 0.04), both_ways(&motor, 0.04));
    // The filters' own start and end are no measurement.
    let inner = EDGE..angle.len() - EDGE;
    let missed: f64 = inner.clone().map(|k| missed[k].powi(2)).sum();
    let whole: f64 = inner.map(|k| motor[k].powi(2)).sum();
    (whole > 0.0).then(|| (missed / whole).sqrt())
}

/// By how much a measured acceleration exceeds the model's in steady slip, rad/s².
fn missing(equations: &Equations, current: f64, angle: f64, speed: f64, acceleration: f64) -> f64 {
    let held = Held { drive: current, ..Held::default() };
    let (at, bristle) = (equations.layout().speed(0), equations.layout().bristle(0));
    let mut state = equations.rest();
    (state[Layout::ANGLE], state[at]) = (angle, speed);
    let mut rate = state.clone();
    let mut slip = |z: f64| {
        state[bristle] = z;
        equations.derivative(&held, &state, &mut rate);
        (rate[bristle], rate[at])
    };
    // The bristle's rate is a straight line in its deflection: where it ends, slip is steady.
    let (relaxed, bent) = (slip(0.0).0, slip(1.0).0);
    let steady = if relaxed == bent { 0.0 } else { relaxed / (relaxed - bent) };
    acceleration - slip(steady).1
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
    use crate::log::Log;

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

    #[test]
    fn the_force_of_a_known_motion_is_the_models_and_lacks_what_the_model_lacks() {
        let text = "[motor]\ntorque_constant_nm_per_a = 2.0\nrotor_inertia_kg_m2 = 3.0\n\
             [motor.friction]\nsigma0_nm_per_rad = 1e5\nsigma1_nm_s_per_rad = 100.0\n\
             sigma2_nm_s_per_rad = 4.0\ncoulomb_nm = 1.5\n\
             [sensor]\nsample_time_s = 1e-3\n\
             [[effect]]\nkind = \"asymmetric-friction\"\nlocation = \"motor\"\n\
             asymmetry = 0.2\nviscous_asymmetry = -0.3\n";
        let model = Model::parse(text, "axis.toml".as_ref()).unwrap();
        let time_s: Vec<f64> = (0..6000).map(|k| f64::from(k) * 1e-3).collect();
        let (turn, pace) = (1.2, 3.0);
        let current = |t: &f64| {
            let (speed, acceleration) =
                (turn * pace * (pace * t).cos(), -turn * pace * pace * (pace * t).sin());
            let (level, viscous) = if speed > 0.0 { (1.8, 2.8) } else { (1.2, 5.2) };
            (3.0 * acceleration + speed.signum() * level + viscous * speed) / 2.0
        };
        let log = Log {
            current_a: Some(time_s.iter().map(current).collect()),
            motor_angle_rad: time_s.iter().map(|t| turn * (pace * t).sin()).collect(),
            time_s,
            ..Log::default()
        };
        let record = Record::new(&log, None);
        let with = relative_force_error(&model, &record).unwrap();
        let without =
            relative_force_error(&Model { effects: Vec::new(), ..model }, &record).unwrap();
        assert!(with < 0.01, "{with}");
        assert!(without > 0.05, "{without}");
    }
}
