//! A current sensor's gain: told from wrong parameters by trust in the nominal alone.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::joint::Drive;
use joint_core::params::Location;

use super::Scene;
use super::card::{Axis, Benchmark, EffectCard, Residual};
use super::hypothesis::{Free, Hypothesis};
use super::rules::Rules;
use crate::estimate::parameters::Quantity;
use crate::estimate::record::Channel;
use crate::model::Model;

pub(super) const CARD: EffectCard = EffectCard {
    words: "a current sensor whose scale is wrong",
    residual: Residual::MeasuredCurrent,
    axis: Axis::Current,
    experiment: "lift a known weight at constant speed, or couple a known inertia and let it coast down: \
         only a torque that is known without the current tells the sensor's gain from the torque \
         constant",
    reference: None,
    rules: Rules { loss, ..Rules::NONE },
    benchmark: Benchmark::Left(
        "a symmetry of the model: only trust in the nominal tells it from other parameters",
    ),
    propose,
};

fn propose(scene: &Scene<'_>) -> Vec<Hypothesis> {
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

/// A gain is a symmetry: the same currents are shown by a smaller winding and larger torques.
fn loss(gain: &EffectParameters, model: &mut Model) {
    let shift = (1.0 + gain.values[0]).ln();
    for quantity in Quantity::of(model, Drive::Voltage) {
        match quantity {
            Quantity::Resistance | Quantity::Inductance => quantity.shift(model, -shift),
            Quantity::TorqueConstant | Quantity::StribeckVelocity(_) | Quantity::GravityPhase => {}
            _ => quantity.shift(model, shift),
        }
    }
}
