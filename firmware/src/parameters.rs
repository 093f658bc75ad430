//! What a parameter block holds, and how an older one becomes one of today.
//!
//! The host builds the joint's coefficients and designs the observer's gains, the chip only checks
//! them: building them needs double precision, which the chip does not have. Beside the observer
//! stands what the drive must know of its sensors to make a measurement of what a timer and a
//! converter give.

use joint_core::effect::EffectSet;
use joint_core::joint::Joint;
use joint_core::observer::Observer;
use serde::{Deserialize, Serialize};

/// The joint as the drive runs it: its effects are those that the block names.
pub type DriveJoint<const N: usize> = Joint<f32, N, EffectSet<f32>>;

/// The observer as the drive runs it.
pub type DriveObserver<const N: usize> = Observer<f32, N, EffectSet<f32>>;

/// The drive's sensors and their limits.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sensing {
    /// Control period, s.
    pub sample_time_s: f32,
    /// Counts per turn of the motor encoder.
    pub motor_counts_per_turn: u32,
    /// Counts per turn of the output encoder; zero where there is none.
    pub output_counts_per_turn: u32,
    /// Pole pairs of the motor.
    pub pole_pairs: u32,
    /// Largest voltage that the drive can put on the motor, V.
    pub largest_voltage_v: f32,
    /// Largest current that its sensor can show, A.
    pub largest_current_a: f32,
    /// Most counts that the motor encoder can move in one period.
    pub largest_move_counts: u32,
}

impl Sensing {
    /// What a drive without parameters assumes: 20 kHz, an encoder of 4096 counts, no output
    /// encoder, one pole pair, and limits that no small drive reaches.
    pub const DEFAULT: Self = Self {
        sample_time_s: 50e-6,
        motor_counts_per_turn: 4096,
        output_counts_per_turn: 0,
        pole_pairs: 1,
        largest_voltage_v: 100.0,
        largest_current_a: 100.0,
        largest_move_counts: 2048,
    };
}

impl Default for Sensing {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// The payload of a parameter block of the present version, for a joint of `N` stages.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Parameters<const N: usize> {
    /// The observer, the joint's coefficients and its gains: all that a block of version 1 holds.
    pub observer: DriveObserver<N>,
    /// The sensors, since version 2.
    pub sensing: Sensing,
}
