//! Quadratic drag: a torque that grows with the square of the speed, where viscous friction is a
//! straight line.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;

use super::Scene;
use super::card::{Axis, Bench, Benchmark, EffectCard, Residual};
use super::hypothesis::{Free, Hypothesis};
use super::rules::Rules;

pub(super) const CARD: EffectCard = EffectCard {
    words: "drag that grows with the square of the speed",
    residual: Residual::Torque,
    axis: Axis::MotorSpeed,
    experiment: "hold constant speeds up to the highest in both directions, many of them and in random \
         order, so that warming does not follow the speed; drag bends the line of current over \
         speed",
    reference: None,
    rules: Rules::NONE,
    benchmark: Benchmark::Hidden(hidden),
    propose,
};

fn propose(scene: &Scene<'_>) -> Vec<Hypothesis> {
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

fn hidden(joint: &mut Bench<'_>) -> Option<EffectParameters> {
    let coefficient =
        0.6 * joint.size * joint.motor_torque_nm / (0.5 * joint.speed_rad_per_s).powi(2);
    Some(
        EffectParameters::new(Kind::QuadraticDrag, Location::Motor)
            .with("coefficient_nm_s2", coefficient),
    )
}
