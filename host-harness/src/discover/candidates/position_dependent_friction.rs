//! Position-dependent friction: lines at orders of a mass's own angle whose sign turns with the
//! speed.

use joint_core::effect::{EffectParameters, Kind};

use super::super::hypothesis::{Free, Hypothesis};
use super::Scene;
use crate::estimate::adjoint::Pull;

/// Orders that become hypotheses at each mass.
const KEPT: usize = 2;
/// Highest order looked for.
const HIGHEST: f64 = 64.0;

pub(super) fn propose(scene: &Scene<'_>) -> Vec<Hypothesis> {
    let mut all = Vec::new();
    for (mass, place) in scene.masses() {
        let friction = scene.friction(mass);
        if friction.coulomb_nm <= 0.0 || scene.has(Kind::PositionDependentFriction, place) {
            continue;
        }
        let level = friction.coulomb_nm * scene.shaft(mass).abs();
        let speed = scene.speed(mass);
        // Below the Stribeck velocity the bristle, not the level, has the say.
        let slow = friction.stribeck_velocity_rad_per_s / scene.shaft(mass).abs();
        let shape =
            |pull: &Pull, k: usize| -level * pull.torque[mass][k] * (speed[k] / slow).tanh();
        let family = scene.family(scene.angle(mass), shape, HIGHEST, 0.5);
        for order in family.strongest(KEPT) {
            all.push(Hypothesis {
                start: EffectParameters::new(Kind::PositionDependentFriction, place)
                    .with("order", order),
                free: vec![Free::Phasor { amplitude: 0, scale: 0.05, sigma: 10.0 }],
            });
        }
    }
    all
}
