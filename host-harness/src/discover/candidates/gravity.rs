//! Gravity: one period per turn of the last mass, at every speed.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;

use super::Scene;
use super::card::{Axis, Bench, Benchmark, EffectCard, Residual};
use super::hypothesis::{Free, Hypothesis};
use super::rules::Rules;
use crate::model::Model;

pub(super) const CARD: EffectCard = EffectCard {
    words: "the weight of the link",
    residual: Residual::Torque,
    axis: Axis::OutputAngle,
    experiment: "turn the mount by a quarter, or move slowly through a full output turn",
    reference: None,
    rules: Rules::NONE,
    benchmark: Benchmark::Hidden(hidden),
    propose,
};

fn propose(scene: &Scene<'_>) -> Vec<Hypothesis> {
    let stages = scene.model.stages.len();
    let place = if stages == 0 { Location::Motor } else { Location::Output };
    if scene.model.load.gravity_nm != 0.0 || scene.has(Kind::Gravity, place) {
        return Vec::new();
    }
    vec![pull(place, 0.1 * scene.torque_scale() / scene.shaft(stages).abs())]
}

fn hidden(joint: &mut Bench<'_>) -> Option<EffectParameters> {
    let place = if joint.stages == 0 { Location::Motor } else { Location::Output };
    let gravity = EffectParameters::new(Kind::Gravity, place)
        .with("amplitude_nm", 1.5 * joint.size * joint.output_torque_nm)
        .with("phase_rad", joint.phase_rad);
    Some(gravity)
}

/// What it is called wherever it hangs.
pub(crate) const KIND: Kind = Kind::Gravity;

/// A pull that is not there yet; it matters from `scale` on, in Nm at its place.
pub(crate) fn pull(place: Location, scale: f64) -> Hypothesis {
    Hypothesis {
        start: EffectParameters::new(Kind::Gravity, place),
        free: vec![Free::Phasor { amplitude: 0, scale, sigma: 100.0 }],
    }
}

/// Whether a line of order one of the rotor's angle is a pull of gravity that the model has not.
pub(crate) fn own_line(model: &Model) -> bool {
    let has = model.effects.iter().any(|effect| effect.kind == Kind::Gravity);
    model.stages.is_empty() && model.load.gravity_nm == 0.0 && !has
}
