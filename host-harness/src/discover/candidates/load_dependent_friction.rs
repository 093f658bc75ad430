//! Load-dependent friction: the Coulomb level grows with the torque passed on, so driving and
//! being driven differ.

use joint_core::effect::{EffectParameters, Kind};

use super::Scene;
use super::card::{Axis, Bench, Benchmark, EffectCard, Residual};
use super::hypothesis::{Free, Hypothesis};
use super::rules::Rules;

pub(super) const CARD: EffectCard = EffectCard {
    words: "friction that grows with the torque passed on",
    residual: Residual::Torque,
    axis: Axis::Current,
    experiment: "drive and brake at constant speed against two loads, in both directions",
    reference: None,
    rules: Rules::NONE,
    benchmark: Benchmark::Hidden(hidden),
    propose,
};

fn propose(scene: &Scene<'_>) -> Vec<Hypothesis> {
    let frictional = scene.masses().filter(|(mass, _)| scene.friction(*mass).coulomb_nm > 0.0);
    frictional
        .filter(|(_, place)| !scene.has(Kind::LoadDependentFriction, *place))
        .flat_map(|(_, place)| {
            [0.0, 0.1].map(|coefficient| Hypothesis {
                start: EffectParameters::new(Kind::LoadDependentFriction, place)
                    .with("coefficient", coefficient),
                free: vec![Free::Value { value: 0, scale: 0.03, sigma: 10.0 }],
            })
        })
        .collect()
}

fn hidden(joint: &mut Bench<'_>) -> Option<EffectParameters> {
    let coefficient = 0.1 * joint.size;
    Some(
        EffectParameters::new(Kind::LoadDependentFriction, joint.gear()?)
            .with("coefficient", coefficient),
    )
}
