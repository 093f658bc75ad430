//! Asymmetric friction: a torque that follows the sign of the speed, with a viscous part of its
//! own. Told from a current offset by the electrical equation and by the viscous part.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;

use super::Scene;
use super::card::{Axis, Bench, Benchmark, EffectCard, Residual};
use super::hypothesis::{Free, Hypothesis};
use super::rules::Rules;

pub(super) const CARD: EffectCard = EffectCard {
    words: "friction that differs by direction",
    residual: Residual::Torque,
    axis: Axis::MotorSpeed,
    experiment: "run at equal speeds in both directions at several output angles; read the current at \
         rest",
    reference: None,
    rules: Rules::NONE,
    benchmark: Benchmark::Hidden(hidden),
    propose,
};

fn propose(scene: &Scene<'_>) -> Vec<Hypothesis> {
    let frictional = scene.masses().filter(|(mass, _)| scene.friction(*mass).coulomb_nm > 0.0);
    frictional
        .filter(|(_, place)| !scene.has(Kind::AsymmetricFriction, *place))
        .map(|(_, place)| Hypothesis {
            start: EffectParameters::new(Kind::AsymmetricFriction, place),
            free: vec![
                Free::Value { value: 0, scale: 0.1, sigma: 3.0 },
                Free::Value { value: 1, scale: 0.1, sigma: 3.0 },
            ],
        })
        .collect()
}

fn hidden(joint: &mut Bench<'_>) -> Option<EffectParameters> {
    let asymmetry = joint.sign * joint.share(0.25);
    Some(
        EffectParameters::new(Kind::AsymmetricFriction, Location::Motor)
            .with("asymmetry", asymmetry),
    )
}
