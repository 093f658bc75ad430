//! What the cross-check runs: the paper's joint, and inputs that bring out what is hard about it.
//!
//! The paper prints no parameter table. The numbers of [`paper`] are an assumption: a 6 mm
//! brushless micromotor with a 1024:1 planetary gear in two stages, within what such datasheets
//! say, with stiffness from the paper's wind-up (20 mNm over 1.5 rad at the motor) and friction
//! that the motor breaks at about a hundredth of its stall torque. Inputs are held on a grid of
//! 100 µs, so that every step size is driven by exactly the same signal.

use std::f64::consts::TAU;

use firmware::assumed;
use joint_core::joint::Drive;
use joint_core::params::Load;

use crate::model::{Model, Sensor};
use crate::plant::Inputs;

/// The grid on which inputs are held and states compared, s.
pub const GRID_S: f64 = 100e-6;

/// The paper's joint, in numbers that are ours (see the module).
pub fn paper() -> Model {
    Model {
        name: "paper".to_owned(),
        motor: assumed::MOTOR,
        stages: assumed::STAGES.to_vec(),
        load: Load::default(),
        sensor: Sensor {
            sample_time_s: GRID_S,
            motor_encoder_counts_per_rev: 3000.0,
            output_encoder_counts_per_rev: 65536.0,
            current_noise_a: 1.5e-3,
            ..Sensor::default()
        },
        effects: Vec::new(),
        friction_levels: Vec::new(),
    }
}

/// One run of a joint.
#[derive(Clone, Copy, Debug)]
pub struct Scenario {
    /// Its name in the results.
    pub name: &'static str,
    /// Length, s.
    pub duration_s: f64,
    /// What the drive imposes.
    pub drive: Drive,
    /// Voltage over time, V; where the current is imposed, current, A.
    pub drive_value: fn(f64) -> f64,
    /// Load at the output over time, Nm.
    pub load: fn(f64) -> f64,
}

/// Every scenario of the cross-check.
pub const ALL: [Scenario; 7] = [
    AT_1_V,
    Scenario { name: "trapezoid", drive_value: trapezoid, ..AT_1_V },
    Scenario { name: "sine-load", load: |t| LOAD_NM * (TAU * 50.0 * t).sin(), ..AT_1_V },
    Scenario { name: "step-load", load: |t| if t < 0.01 { 0.0 } else { LOAD_NM }, ..AT_1_V },
    // Breakaway of the whole joint is at 0.12 V.
    Scenario { name: "stick", drive_value: |_| 0.08, ..AT_1_V },
    Scenario { name: "wiggle", drive_value: |t| 0.25 * (TAU * 40.0 * t).sin(), ..AT_1_V },
    // Twice the current that breaks the joint away, then as much against the motion.
    Scenario {
        name: "current-step",
        drive: Drive::Current,
        drive_value: |t| match t {
            t if t < 0.002 => 0.0,
            t if t < 0.03 => 0.026,
            _ => -0.026,
        },
        ..AT_1_V
    },
];

/// The voltage steps to 1 V.
const AT_1_V: Scenario = Scenario {
    name: "step",
    duration_s: 0.1,
    drive: Drive::Voltage,
    drive_value: |_| 1.0,
    load: unloaded,
};

/// The paper's load, Nm.
const LOAD_NM: f64 = 0.02;

fn unloaded(_: f64) -> f64 {
    0.0
}

/// Up to 0.7 V, through zero to −0.42 V and back, in ramps of 10 ms: the paper's 500 and
/// −300 rad/s, each reversal passing standstill under way.
fn trapezoid(t: f64) -> f64 {
    const CORNERS: [(f64, f64); 8] = [
        (0.0, 0.0),
        (0.01, 0.7),
        (0.03, 0.7),
        (0.045, -0.42),
        (0.06, -0.42),
        (0.075, 0.7),
        (0.09, 0.7),
        (0.1, 0.0),
    ];
    let after = CORNERS.iter().position(|(corner, _)| *corner > t).unwrap_or(CORNERS.len() - 1);
    let ((t0, u0), (t1, u1)) = (CORNERS[after.saturating_sub(1)], CORNERS[after]);
    u0 + (u1 - u0) * ((t - t0) / (t1 - t0)).clamp(0.0, 1.0)
}

impl Scenario {
    /// Sample times and held inputs, the last time at the end.
    pub fn inputs(&self) -> Inputs {
        let samples = (self.duration_s / GRID_S).round() as usize + 1;
        let time_s: Vec<f64> = (0..samples).map(|k| k as f64 * GRID_S).collect();
        Inputs {
            drive: self.drive,
            drive_values: time_s.iter().map(|t| (self.drive_value)(*t)).collect(),
            load_nm: time_s.iter().map(|t| (self.load)(*t)).collect(),
            time_s,
        }
    }

    /// The same scenario cut short.
    #[must_use]
    pub fn lasting(self, duration_s: f64) -> Self {
        Self { duration_s, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_trapezoid_meets_its_corners_and_reverses() {
        assert_eq!([0.0, 0.02, 0.05].map(trapezoid), [0.0, 0.7, -0.42]);
        assert!((trapezoid(0.005) - 0.35).abs() < 1e-12);
        assert_eq!(trapezoid(1.0), 0.0);
    }

    #[test]
    fn the_assumed_joint_is_admissible() {
        let model = paper();
        assert_eq!(joint_core::params::validate(&model.motor, &model.stages, &model.load), Ok(()));
    }
}
