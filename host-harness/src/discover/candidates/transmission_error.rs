//! Transmission error: lines in a stage's wind-up at orders of its input, there at no load too.
//!
//! Gears off their centre have the low orders, and a large one makes what is behind it stick, so that its
//! doubles and triples stand out in the spectrum instead of itself. So the low orders are all tested.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;

use super::super::hypothesis::{Free, Hypothesis};
use super::Scene;
use crate::estimate::adjoint::Pull;

/// Orders that become hypotheses at each stage.
const KEPT: usize = 2;
/// Highest order looked for.
const HIGHEST: f64 = 64.0;
/// Whole orders that are hypotheses wherever the travel shows so much of a period.
const LOW: u32 = 8;
const PERIODS: f64 = 0.7;

pub(super) fn propose(scene: &Scene<'_>) -> Vec<Hypothesis> {
    let mut all = Vec::new();
    for (mass, place) in scene.masses().skip(1) {
        let stage = &scene.model.stages[mass - 1];
        let shaft = scene.shaft(mass);
        // Torque of a unit of argument, on the mass behind the spring and against the one before.
        let stiffness = stage.stiffness_nm_per_rad * shaft;
        let shape =
            |pull: &Pull, k: usize| stiffness * (pull.torque[mass][k] - pull.torque[mass - 1][k]);
        let family = scene.family(scene.angle(mass - 1), shape, HIGHEST, PERIODS);
        let amplitude = 0.1 * scene.torque_scale() / shaft.abs() / stage.stiffness_nm_per_rad;
        let mut orders = family.strongest(KEPT + 4);
        orders.retain(|order| !taken(scene, place, *order));
        orders.truncate(KEPT);
        let shown = PERIODS / family.turns();
        for order in (1..=LOW).map(f64::from) {
            if order >= shown && !taken(scene, place, order) && !orders.contains(&order) {
                orders.push(order);
            }
        }
        for order in orders {
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
