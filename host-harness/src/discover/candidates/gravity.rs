//! Gravity: one period per turn of the last mass, at every speed.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;

use super::super::hypothesis::{Free, Hypothesis};
use super::Scene;

pub(super) fn propose(scene: &Scene<'_>) -> Vec<Hypothesis> {
    let stages = scene.model.stages.len();
    let place = if stages == 0 { Location::Motor } else { Location::Output };
    if scene.model.load.gravity_nm != 0.0 || scene.has(Kind::Gravity, place) {
        return Vec::new();
    }
    let scale = 0.1 * scene.torque_scale() / scene.shaft(stages).abs();
    vec![Hypothesis {
        start: EffectParameters::new(Kind::Gravity, place),
        free: vec![Free::Phasor { amplitude: 0, scale, sigma: 100.0 }],
    }]
}
