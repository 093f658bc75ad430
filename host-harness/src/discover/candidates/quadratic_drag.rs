//! Quadratic drag: a torque that grows with the square of the speed, where viscous friction is a
//! straight line.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;

use super::super::hypothesis::{Free, Hypothesis};
use super::Scene;

pub(super) fn propose(scene: &Scene<'_>) -> Vec<Hypothesis> {
    if scene.has(Kind::QuadraticDrag, Location::Motor) {
        return Vec::new();
    }
    let speed = scene.largest_speed().max(1e-9);
    let scale = 0.05 * scene.torque_scale() / (speed * speed);
    vec![Hypothesis {
        start: EffectParameters::new(Kind::QuadraticDrag, Location::Motor),
        free: vec![Free::Value { value: 0, scale, sigma: 200.0 }],
    }]
}
