//! What a measured joint has that the narrow logs of [`super::record`] do not.

use joint_core::joint::Drive;
use serde::{Deserialize, Serialize};

use super::motion::Motion;
use super::noise::Colour;
use super::sensing::{Reported, Stamps};
use crate::model::Model;
use crate::reference::friction::Family;
use crate::reference::{Equations, Method, ReferenceError};

/// How the reference integrates, where a thousandth will do.
pub(super) const METHOD: Method = Method::Scaled { share: 0.6 };

/// How one record of a joint is taken, and what its friction and sensors really are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    /// What is done to it.
    pub motion: Motion,
    /// Length, s.
    pub duration_s: f64,
    /// Sample time, s.
    pub sample_time_s: f64,
    /// Family of its friction.
    pub friction: Family,
    /// Exponent of its Stribeck curve.
    pub stribeck_exponent: f64,
    /// What disturbs it.
    pub disturbance: Disturbances,
    /// What its sensors do.
    pub sensing: Sensing,
}

/// What acts on the joint and stands in no log.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Disturbances {
    /// White torque on the rotor, held over a sample, over breakaway.
    pub white_torque: f64,
    /// Coloured torque on the rotor, over breakaway.
    pub torque: Colour,
    /// Relative change of the level of all friction.
    pub friction: Colour,
    /// White noise of the voltage, over its largest value.
    pub voltage: f64,
}

/// What the sensors and the log do to the signals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sensing {
    /// What the current's report has gone through.
    pub current: Reported,
    /// Standard deviation of the sampling instants, samples.
    pub jitter: f64,
    /// What the stamps say of it.
    pub stamps: Stamps,
    /// Ripple that the bus readings catch, over the bus voltage; `None` without a bus column.
    pub bus_ripple: Option<f64>,
}

/// The equations of a joint in a setting.
pub(super) fn equations(model: &Model, setting: &Setting) -> Result<Equations, ReferenceError> {
    let equations = Equations::new(model, Drive::Voltage, setting.stribeck_exponent)?;
    Ok(equations.with_friction(setting.friction))
}
