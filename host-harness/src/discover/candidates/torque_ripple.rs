//! Torque ripple: lines in the torque that grow with the current, and the same lines in the back-EMF
//! that grow with the speed.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::joint::Drive;
use joint_core::params::Location;

use super::Scene;
use super::card::{Axis, Bench, Benchmark, EffectCard, Residual};
use super::hypothesis::{Free, Hypothesis};
use super::rules::Rules;

/// Orders that become hypotheses.
const KEPT: usize = 2;

pub(super) const CARD: EffectCard = EffectCard {
    words: "a torque constant that waves over the electrical turn, and the back-EMF with it",
    residual: Residual::Torque,
    axis: Axis::MotorAngle,
    experiment: "scan slowly through a turn at several loads, then let the joint coast: ripple grows with \
         the current and is gone without it, cogging stays",
    reference: None,
    rules: Rules::NONE,
    benchmark: Benchmark::Hidden(hidden),
    propose,
};

fn propose(scene: &Scene<'_>) -> Vec<Hypothesis> {
    let constant = scene.model.motor.torque_constant_nm_per_a;
    let (current, speed) = (scene.current(), scene.speed(0));
    let electrical = if scene.record.drive == Drive::Voltage { constant } else { 0.0 };
    let shape = |pull: &crate::estimate::adjoint::Pull, k: usize| {
        pull.torque[0][k] * constant * current[k] - pull.drive[k] * electrical * speed[k]
    };
    let mut family = scene.family(scene.angle(0), shape, 0.0, 2.0);
    family.highest = scene.highest_order(family.turns()).min(144.0);
    let mut orders = family.strongest(KEPT + 4);
    orders.retain(|order| {
        !scene.model.effects.iter().any(|effect| {
            effect.kind == Kind::TorqueRipple && (effect.values[2] - order).abs() < 0.25
        })
    });
    orders
        .into_iter()
        .take(KEPT)
        .map(|order| Hypothesis {
            start: EffectParameters::new(Kind::TorqueRipple, Location::Motor).with("order", order),
            free: vec![Free::Phasor { amplitude: 0, scale: 0.01, sigma: 30.0 }],
        })
        .collect()
}

fn hidden(joint: &mut Bench<'_>) -> Option<EffectParameters> {
    let ripple = EffectParameters::new(Kind::TorqueRipple, Location::Motor)
        .with("relative_amplitude", joint.share(0.05))
        .with("order", 6.0 * joint.pole_pairs)
        .with("phase_rad", joint.phase_rad);
    Some(ripple)
}
