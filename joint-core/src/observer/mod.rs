//! The observer: what no sensor on the drive measures.
//!
//! One model step predicts, a few dozen multiply-adds correct: the gains are designed on the host
//! ([`Design`]) and constant within a [`Regime`], so an update costs a fifth of a full Kalman filter
//! and always the same. Beside the joint's own state it carries the load torque and its slope, and a
//! voltage that the drive did not mean to put out, and by how much resistance, flux and friction are
//! larger than the model's, without which every ohm that is off would pass for a load.
//!
//! ```text
//! state ← step(state, u + bias − ohm · R i − flux · k_e ω, load + slope), less level · friction
//! load ← load + slope,  slope ← leak · slope
//! (state, load, slope, bias) ← … + Σ_c K_c(regime) · (y_c − ŷ_c)/σ_c
//! ohm ← ohm + K_ohm · i · (y_i − ŷ_i)/σ_i,  flux ← flux + K_flux · ω · (y_i − ŷ_i)/σ_i
//! level ← level + K_level · (friction − its mean) · Σ_c w_c · (y_c − ŷ_c)/σ_c
//! ```
//!
//! An [`Observer`] never changes; a [`Track`] is what moves. In the drive's interrupt:
//!
//! ```ignore
//! let status = observer.update(&mut track, &Sample { drive, current, motor, output });
//! let estimate = observer.estimate(&track);
//! ```

mod estimate;
mod gains;
mod health;
mod look;
mod turn;
mod update;

pub use estimate::Estimate;
pub use gains::{CHANNELS, Column, Design, Gains, Level, Regime, SETS, Spread, StageRow, winding};
pub use health::Status;
pub use turn::{Encoder, Geared, Turn};

use crate::joint::{Joint, State};
use crate::scalar::Real;

/// What the drive knows at one sampling instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample<S> {
    /// Voltage on the two conducting phases from this instant on, V: duty times bus voltage as
    /// measured. Where the drive imposes the current, that current, A.
    pub drive: S,
    /// Measured current, A; `None` where it was not measured. Not used where it is imposed.
    pub current: Option<S>,
    /// Rotor angle; `None` where the sample was lost.
    pub motor: Option<Turn>,
    /// Output angle; `None` where there is no such encoder, or the sample was lost.
    pub output: Option<Turn>,
}

/// An observer of a joint of `N` stages with effects `E`: constants only.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = "E: crate::number::Wire"))]
pub struct Observer<S: Real, const N: usize, E = ()> {
    /// The model.
    pub joint: Joint<S, N, E>,
    /// What corrects it.
    pub gains: Gains<S, N>,
}

/// What an observer remembers of one joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Track<S: Real, const N: usize> {
    /// The joint's state.
    pub state: State<S, N>,
    /// Load, per-unit at the motor.
    pub load: S,
    /// Its change in a step.
    pub slope: S,
    /// Drive beside the applied one, per-unit.
    pub bias: S,
    /// Share by which the winding's resistance exceeds the model's, less that of the flux.
    pub ohm: S,
    /// Share by which the magnets' flux, and with it k_t and k_e, exceeds the model's.
    pub flux: S,
    /// Share by which friction exceeds the model's.
    pub level: S,
    /// Running mean of what friction takes of the rotor's speed in a step.
    braking: S,
    /// Samples for which the current was as the model has it, and how many it was when first it was
    /// not.
    sure: u16,
    unsure: u16,
    /// Drive that is applied from the last sample on, per-unit.
    drive: S,
    /// Running mean of the innovations' lean.
    lean: S,
    /// Steps left in [`Regime::Alert`].
    alert: u16,
    /// Running share of alarms, and steps left in [`Regime::Lively`].
    often: S,
    lively: u16,
    /// Steps for which friction has held the rotor, and until a rest is forgotten.
    held: u16,
    rested: u16,
    /// Whose turn it is of what is slow: friction's and the rotor's, else the motor's and the gear's.
    even: bool,
    /// Running mean of the innovations' square, and how long it has been too large.
    energy: S,
    /// Rotor angles one after the other that were not believed.
    doubts: u16,
    /// Samples since the last rotor angle that was believed.
    missed: u16,
    /// Samples since the last output angle that was believed.
    output_missed: u16,
    /// Samples since the start.
    age: u16,
    last: Sample<S>,
    status: Status,
    row: u8,
    regime: Regime,
}
