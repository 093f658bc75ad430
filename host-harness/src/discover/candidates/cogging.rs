//! Cogging: lines in the rotor's torque at orders of its angle, the same at every current and
//! speed. The strongest become hypotheses, each with its double.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;

use super::card::{Axis, Bench, Benchmark, EffectCard, Residual};
use super::hypothesis::{Free, Hypothesis};
use super::rules::{Line, Rules};
use super::{Scene, gravity};
use crate::model::Model;

/// Orders that become hypotheses.
const KEPT: usize = 3;
/// Orders that are looked at to tell the reader where they disagree.
const LISTED: usize = 10;

pub(super) const CARD: EffectCard = EffectCard {
    words: "the magnets' pull on the teeth of the stator",
    residual: Residual::Torque,
    axis: Axis::MotorAngle,
    experiment: "scan slowly through a turn at two loads, in both directions",
    reference: None,
    rules: Rules { line: Line { is_rotor_torque: true, ..Line::ANY }, ..Rules::NONE },
    benchmark: Benchmark::Hidden(hidden),
    propose,
};

fn propose(scene: &Scene<'_>) -> Vec<Hypothesis> {
    orders(scene, KEPT).into_iter().map(|order| hypothesis(scene, order, true)).collect()
}

fn hidden(joint: &mut Bench<'_>) -> Option<EffectParameters> {
    let order = joint.pole_pairs * joint.one_of([2.0, 6.0, 12.0]);
    let cogging = EffectParameters::new(Kind::Cogging, Location::Motor)
        .with("order", order)
        .with("amplitude_nm", 0.3 * joint.size * joint.motor_torque_nm)
        .with("phase_rad", joint.phase_rad);
    Some(cogging)
}

/// What all lines are called.
pub(crate) const NAME: (Kind, Location) = (Kind::Cogging, Location::Motor);

/// Whether a model has lines already.
pub(crate) fn stands_in(model: &Model) -> bool {
    model.effects.iter().any(|effect| effect.kind == Kind::Cogging)
}

/// The orders of the lines that a model has, the strongest first.
pub(crate) fn orders_in(model: &Model) -> Vec<f64> {
    let effects = model.effects.iter();
    let mut lines: Vec<[f64; 2]> = effects
        .filter(|effect| effect.kind == Kind::Cogging)
        .map(|effect| [effect.values[0], effect.values[1].abs()])
        .collect();
    lines.sort_by(|a, b| b[1].total_cmp(&a[1]));
    lines.iter().map(|[order, _]| *order).collect()
}

/// Each of the strongest orders alone, for the list of orders.
pub(crate) fn listed(scene: &Scene<'_>) -> Vec<Hypothesis> {
    orders(scene, LISTED).into_iter().map(|order| hypothesis(scene, order, false)).collect()
}

/// The strongest orders that the model has no line of.
fn orders(scene: &Scene<'_>, count: usize) -> Vec<f64> {
    let angle = scene.angle(0);
    let mut family = scene.family(angle, |pull, k| pull.torque[0][k], 0.0, 2.0);
    family.highest = scene.highest_order(family.turns());
    let resolution = family.resolution();
    let mut orders = family.strongest(count + 8);
    let hangs = gravity::own_line(scene.model);
    orders.retain(|order| !(taken(scene, *order, resolution) || hangs && *order == 1.0));
    orders.truncate(count);
    orders
}

fn hypothesis(scene: &Scene<'_>, order: f64, double: bool) -> Hypothesis {
    let double = double && !taken(scene, 2.0 * order, 0.25);
    let mut line = line(order, 0.05 * scene.torque_scale(), double);
    if order.fract() != 0.0 {
        let turns = (scene.travel(0) / std::f64::consts::TAU).max(1e-9);
        line.free.push(Free::Value { value: 0, scale: 0.05 / turns, sigma: 10.0 });
    }
    line
}

/// A line that is not there yet, with its double or without; it matters from `scale` on, in Nm.
pub(crate) fn line(order: f64, scale: f64, double: bool) -> Hypothesis {
    let phasor = |amplitude| Free::Phasor { amplitude, scale, sigma: 200.0 };
    let free = if double { vec![phasor(1), phasor(3)] } else { vec![phasor(1)] };
    Hypothesis {
        start: EffectParameters::new(Kind::Cogging, Location::Motor).with("order", order),
        free,
    }
}

/// Whether the model has a line within `reach` of this order.
fn taken(scene: &Scene<'_>, order: f64, reach: f64) -> bool {
    let lines = scene.model.effects.iter().filter(|effect| effect.kind == Kind::Cogging);
    let near = |line: f64| (line - order).abs() < reach.max(0.25);
    lines.into_iter().any(|effect| {
        let [order, amplitude, _, second, ..] = effect.values;
        (amplitude != 0.0 && near(order)) || (second != 0.0 && near(2.0 * order))
    })
}
