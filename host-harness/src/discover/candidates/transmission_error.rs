//! Transmission error: lines in a stage's wind-up at orders of its input, there at no load too.
//!
//! Gears off their centre have the low orders, and a large one makes what is behind it stick, so that its
//! doubles and triples stand out in the spectrum instead of itself. So the low orders are all tested.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;

use super::Scene;
use super::card::{Axis, Bench, Benchmark, EffectCard, Residual};
use super::hypothesis::{Free, Hypothesis};
use super::rules::{Line, Rules};
use crate::estimate::adjoint::Pull;

/// Orders that become hypotheses at each stage.
const KEPT: usize = 2;
/// Highest order looked for.
const HIGHEST: f64 = 64.0;
/// Whole orders that are hypotheses wherever the travel shows so much of a period.
const LOW: u32 = 8;
const PERIODS: f64 = 0.7;

pub(super) const CARD: EffectCard = EffectCard {
    words: "gears that do not pass the angle on evenly",
    residual: Residual::Windup,
    axis: Axis::MotorAngle,
    experiment: "turn slowly through full turns without a load, with an encoder behind the last stage: \
         its error repeats with the turn of the stage's input, cogging with the rotor's",
    reference: None,
    rules: Rules { line: Line { is_of_input: true, ..Line::ANY }, ..Rules::NONE },
    benchmark: Benchmark::Hidden(hidden),
    propose,
};

fn propose(scene: &Scene<'_>) -> Vec<Hypothesis> {
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

fn hidden(joint: &mut Bench<'_>) -> Option<EffectParameters> {
    let error = EffectParameters::new(Kind::TransmissionError, joint.gear()?)
        .with("amplitude_rad", joint.size * joint.windup_rad())
        .with("order", joint.one_of([1.0, 3.0, 5.0]))
        .with("phase_rad", joint.phase_rad);
    Some(error)
}

fn taken(scene: &Scene<'_>, place: Location, order: f64) -> bool {
    scene.model.effects.iter().any(|effect| {
        effect.kind == Kind::TransmissionError
            && effect.location == place
            && (effect.values[2] - order).abs() < 0.25
    })
}
