//! Drive efficiency: friction that grows with the torque passed on, by another share where the load
//! drives. It holds load-dependent friction as the case of two equal shares, so it is asked where that was
//! found, and takes its place where the shares differ.

use joint_core::effect::{EffectParameters, Kind};

use super::Scene;
use super::card::{Axis, Bench, Benchmark, EffectCard, Residual};
use super::hypothesis::{Free, Hypothesis};
use super::rules::Rules;

pub(super) const CARD: EffectCard = EffectCard {
    words: "gear loss that differs between driving the load and being driven by it",
    residual: Residual::Torque,
    axis: Axis::Current,
    experiment: "lift and lower a known weight at the same slow speed and log the current: the two \
         differences from the weight's own torque are the two losses",
    reference: None,
    rules: Rules::NONE,
    benchmark: Benchmark::Wide(hidden),
    propose,
};

fn propose(scene: &Scene<'_>) -> Vec<Hypothesis> {
    let behind = scene.masses().skip(1).map(|(_, place)| place);
    behind
        .filter(|place| scene.has(Kind::LoadDependentFriction, *place))
        .filter(|place| !scene.has(Kind::DriveEfficiency, *place))
        .map(|place| Hypothesis {
            start: EffectParameters::new(Kind::DriveEfficiency, place),
            free: [0, 1].map(|value| Free::Value { value, scale: 0.03, sigma: 10.0 }).to_vec(),
        })
        .collect()
}

/// A gear that loses four times as much where it is driven: with less, a log tells no more than that
/// friction follows the load.
fn hidden(joint: &mut Bench<'_>) -> Option<EffectParameters> {
    Some(
        EffectParameters::new(Kind::DriveEfficiency, joint.gear()?)
            .with("driving", 0.08 * joint.size)
            .with("driven", 0.32 * joint.size),
    )
}
