//! Transmission error: lines in a stage's wind-up at orders of its input, there at no load too.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;

use super::super::hypothesis::{Free, Hypothesis};
use super::Scene;
use crate::estimate::adjoint::Pull;

/// Orders that become hypotheses at each stage.
const KEPT: usize = 2;
/// Highest order looked for.
const HIGHEST: f64 = 64.0;

pub(super) fn propose(scene: &Scene<'_>) -> Vec<Hypothesis> {
    let mut all = Vec::new();
    for (mass, place) in scene.masses().skip(1) {
        let stage = &scene.model.stages[mass - 1];
        let shaft = scene.shaft(mass);
        // Torque of a unit of argument, on the mass behind the spring and against the one before.
        let stiffness = stage.stiffness_nm_per_rad * shaft;
        let shape =
            |pull: &Pull, k: usize| stiffness * (pull.torque[mass][k] - pull.torque[mass - 1][k]);
        let family = scene.family(scene.angle(mass - 1), shape, HIGHEST, 0.7);
        let amplitude = 0.1 * scene.torque_scale() / shaft.abs() / stage.stiffness_nm_per_rad;
        for order in
            family.strongest(KEPT + 4).into_iter().filter(|o| !taken(scene, place, *o)).take(KEPT)
        {
            all.push(Hypothesis {
                start: EffectParameters::new(Kind::TransmissionError, place).with("order", order),
                free: vec![Free::Phasor { amplitude: 0, scale: amplitude, sigma: 100.0 }],
            });
        }
    }
    all
}

fn taken(scene: &Scene<'_>, place: Location, order: f64) -> bool {
    scene.model.effects.iter().any(|effect| {
        effect.kind == Kind::TransmissionError
            && effect.location == place
            && (effect.values[2] - order).abs() < 0.25
    })
}
