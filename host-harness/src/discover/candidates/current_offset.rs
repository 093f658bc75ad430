//! A current sensor's zero: a constant in the measured current that the voltage equation does not
//! know; where the current is the input, a constant torque.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;

use super::super::hypothesis::{Free, Hypothesis};
use super::Scene;

pub(super) fn propose(scene: &Scene<'_>) -> Vec<Hypothesis> {
    if scene.has(Kind::CurrentOffset, Location::CurrentSensor) {
        return Vec::new();
    }
    let scale = 0.01 * scene.largest_current();
    vec![Hypothesis {
        start: EffectParameters::new(Kind::CurrentOffset, Location::CurrentSensor),
        free: vec![Free::Value { value: 0, scale, sigma: 20.0 }],
    }]
}
