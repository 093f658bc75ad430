//! Asymmetric friction: a torque that follows the sign of the speed, with a viscous part of its
//! own. Told from a current offset by the electrical equation and by the viscous part.

use joint_core::effect::{EffectParameters, Kind};

use super::super::hypothesis::{Free, Hypothesis};
use super::Scene;

pub(super) fn propose(scene: &Scene<'_>) -> Vec<Hypothesis> {
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
