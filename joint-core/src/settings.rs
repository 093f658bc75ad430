//! How a joint is to be stepped.

use crate::effect::EffectParameters;

/// Which quantity the drive imposes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drive {
    /// The voltage on the two conducting phases; the current follows.
    Voltage,
    /// The current itself, as in a drive in torque mode.
    Current,
}

/// How a joint is advanced over a micro-step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// The fourth-order splitting: exact about vibrations that a micro-step resolves.
    Splitting,
    /// The L-stable implicit method: it damps away those that none does.
    Implicit,
}

/// How a joint is to be stepped.
#[derive(Clone, Copy, Debug)]
pub struct Settings<'a> {
    /// What the drive imposes.
    pub drive: Drive,
    /// Length of a step, seconds.
    pub step_s: f64,
    /// Micro-steps in a step; `None` takes what [`Pace::plan`](crate::pace::Pace::plan) finds for the
    /// method.
    pub micro_steps: Option<u32>,
    /// How it is stepped; `None` takes what [`Pace::plan`](crate::pace::Pace::plan) finds. Fixed point
    /// knows the splitting alone.
    pub method: Option<Method>,
    /// Effects beside the plain equations; used by joints with an
    /// [`EffectSet`](crate::effect::EffectSet).
    pub effects: &'a [EffectParameters],
}

impl Settings<'_> {
    /// A step of this length, divided as the parameters ask, without effects.
    pub fn new(drive: Drive, step_s: f64) -> Self {
        Self { drive, step_s, micro_steps: None, method: None, effects: &[] }
    }
}
