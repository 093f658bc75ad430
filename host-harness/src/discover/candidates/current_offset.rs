//! A current sensor's zero: a constant in the measured current that the voltage equation does not
//! know; where the current is the input, a constant torque.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;

use super::Scene;
use super::card::{Axis, Bench, Benchmark, EffectCard, Residual};
use super::hypothesis::{Free, Hypothesis};
use super::rules::Rules;

pub(super) const CARD: EffectCard = EffectCard {
    words: "a current sensor whose zero is off",
    residual: Residual::MeasuredCurrent,
    axis: Axis::Time,
    experiment: "read the current sensor with the bridge off",
    reference: None,
    rules: Rules::NONE,
    benchmark: Benchmark::Hidden(hidden),
    propose,
};

fn propose(scene: &Scene<'_>) -> Vec<Hypothesis> {
    if scene.has(Kind::CurrentOffset, Location::CurrentSensor) {
        return Vec::new();
    }
    let scale = 0.01 * scene.largest_current();
    vec![Hypothesis {
        start: EffectParameters::new(Kind::CurrentOffset, Location::CurrentSensor),
        free: vec![Free::Value { value: 0, scale, sigma: 20.0 }],
    }]
}

fn hidden(joint: &mut Bench<'_>) -> Option<EffectParameters> {
    let offset = joint.sign * 0.03 * joint.size * joint.current_a();
    Some(
        EffectParameters::new(Kind::CurrentOffset, Location::CurrentSensor)
            .with("offset_a", offset),
    )
}
