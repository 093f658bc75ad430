//! The observer: what no sensor on the drive measures.
//!
//! One model step predicts, a few dozen multiply-adds correct: the gains are designed on the host
//! ([`Design`]) and constant within a [`Regime`], so an update costs a fifth of a full Kalman filter
//! and always the same. Beside the joint's own state it carries the load torque and its slope, a
//! voltage that the drive did not mean to put out, and the shares by which resistance, flux and
//! friction exceed the model's, without which a wrong resistance would pass for a load.
//!
//! ```text
//! state ← step(state, u + bias − (resistance R i + flux k_e ω), load + slope), less friction_error · friction
//! load ← load + slope,  slope ← leak · slope
//! (state, load, slope, bias) ← … + Σ_c K_c(regime) · (y_c − ŷ_c)/σ_c
//! resistance ← resistance + K_r · i · (y_i − ŷ_i)/σ_i,  flux ← flux + K_f · ω · (y_i − ŷ_i)/σ_i
//! friction_error ← friction_error + K_F · (friction − its mean) · Σ_c w_c · (y_c − ŷ_c)/σ_c
//! ```
//!
//! With [`Drive::Current`](crate::joint::Drive::Current) u is the current that the drive imposes; a
//! measured one corrects nothing then, and resistance and flux stay as they are.
//!
//! Sources: steady-state gains, R. E. Kalman, J. Basic Eng. 82(1), 1960; a disturbance as a state,
//! C. D. Johnson, IEEE Trans. Autom. Control 16(6), 1971, and K. Ohnishi et al., IEEE/ASME Trans.
//! Mechatronics 1(1), 1996 (disturbance observer); the test of the innovations' running mean, S. W.
//! Roberts, Technometrics 1(3), 1959; the friction of the prediction, C. Canudas de Wit et al., IEEE
//! Trans. Autom. Control 40(3), 1995.
//!
//! An [`Observer`] never changes; a [`Track`] is what moves. In the drive's interrupt:
//!
//! ```ignore
//! let status = observer.update(&mut track, &Sample { drive, current, motor, output });
//! let estimate = observer.estimate(&track);
//! ```

mod acquire;
mod adapt;
mod column;
mod estimate;
mod gains;
mod health;
mod innovation;
mod turn;
mod update;

pub use column::{CHANNELS, Column, StageRow};
pub use estimate::Estimate;
pub use gains::{Design, Gains, Level, Regime, SETS, Spread, winding};
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
    /// What acts on the joint and is not measured.
    pub disturbance: Disturbance<S>,
    /// What the parameters are found to be off.
    pub parameters: ParameterErrors<S>,
    /// Drive that is applied from the last sample on, per-unit.
    drive: S,
    /// Running mean of what friction takes of the rotor's speed in a step.
    mean_deceleration: S,
    innovation: InnovationMeans<S>,
    schedule: Schedule<S>,
    missing: Missing,
    electrical: Electrical,
    /// Samples of the first angle and speed, up to [`acquire::FIRST`].
    first: u8,
    /// Samples left of a start.
    starting: u16,
    /// Whether this sample adapts friction, else winding and magnets.
    adapts_friction: bool,
    last: Sample<S>,
    status: Status,
}

/// Disturbance states.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Disturbance<S> {
    /// Load, per-unit at the motor.
    pub load: S,
    /// Its change in a step.
    pub slope: S,
    /// Drive beside the applied one, per-unit.
    pub bias: S,
}

/// Errors of the model's parameters, as shares of them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ParameterErrors<S> {
    /// Of the winding's resistance, less that of the flux.
    pub resistance: S,
    /// Of the magnets' flux, and with it of k_t and k_e.
    pub flux: S,
    /// Of all friction.
    pub friction: S,
}

/// Running means of the innovations.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct InnovationMeans<S> {
    /// Of their projection on the load: it has changed where this leaves its noise.
    projection: S,
    /// Of their square: the model does not hold where this stays too large.
    square: S,
}

/// Which gains are in use, and for how long.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Schedule<S> {
    /// [`Regime::row`].
    row: u8,
    /// Steps left in [`Regime::Transient`].
    transient: u16,
    /// Running share of samples at which the load was found to change.
    alarm_rate: S,
    /// Steps left in [`Regime::Varying`].
    varying: u16,
    /// Steps for which friction has held the rotor.
    held: u16,
    /// Steps until a rest is forgotten.
    after_rest: u16,
}

/// Samples that brought no angle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Missing {
    /// Rotor angles one after the other that were rejected.
    rejected: u16,
    /// Samples since the last rotor angle that was accepted.
    motor: u16,
    /// Samples since the last output angle that was accepted.
    output: u16,
}

/// How well winding and magnets are known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Electrical {
    /// Samples of motion at which the current was as the model has it.
    confirmed: u16,
    /// The same at the last outlier.
    at_outlier: u16,
}
