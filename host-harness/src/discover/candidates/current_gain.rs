//! A current sensor's gain: told from wrong parameters by trust in the nominal alone.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::joint::Drive;
use joint_core::params::Location;

use super::super::hypothesis::{Free, Hypothesis};
use super::Scene;
use crate::estimate::record::Channel;

pub(super) fn propose(scene: &Scene<'_>) -> Vec<Hypothesis> {
    // Where the current is the input, a gain is the torque constant itself.
    let measured = scene.record.drive == Drive::Voltage && scene.record.has(Channel::Current);
    if !measured || scene.has(Kind::CurrentGain, Location::CurrentSensor) {
        return Vec::new();
    }
    vec![Hypothesis {
        start: EffectParameters::new(Kind::CurrentGain, Location::CurrentSensor),
        free: vec![Free::Value { value: 0, scale: 0.02, sigma: 15.0 }],
    }]
}
