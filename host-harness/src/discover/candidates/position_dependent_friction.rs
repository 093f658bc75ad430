//! Position-dependent friction: lines at orders of a mass's own angle whose sign turns with the
//! speed.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;

use super::Scene;
use super::card::{Axis, Bench, Benchmark, EffectCard, Residual};
use super::hypothesis::{Free, Hypothesis};
use super::rules::Rules;
use crate::estimate::adjoint::Pull;

/// Orders that become hypotheses at each mass.
const KEPT: usize = 2;
/// Highest order looked for.
const HIGHEST: f64 = 64.0;

pub(super) const CARD: EffectCard = EffectCard {
    words: "friction that differs from angle to angle",
    residual: Residual::Torque,
    axis: Axis::OutputAngle,
    experiment: "pass every angle slowly in both directions: friction changes its sign with the \
         direction, gravity and cogging do not",
    reference: None,
    rules: Rules::NONE,
    benchmark: Benchmark::Hidden(hidden),
    propose,
};

fn propose(scene: &Scene<'_>) -> Vec<Hypothesis> {
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

fn hidden(joint: &mut Bench<'_>) -> Option<EffectParameters> {
    let place = joint.gear().unwrap_or(Location::Motor);
    let friction = EffectParameters::new(Kind::PositionDependentFriction, place)
        .with("relative_amplitude", joint.share(0.45))
        .with("order", joint.one_of([6.0, 12.0, 24.0]))
        .with("phase_rad", joint.phase_rad);
    Some(friction)
}
