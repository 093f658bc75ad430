//! Gravity: one period per turn of the last mass, at every speed.
//!
//! Around its largest pull a pendulum is a constant torque, and so is much that is no pendulum: a spring, a hose,
//! friction that is stronger one way. Only a travel over which the pull changes tells them apart.

use std::f64::consts::FRAC_PI_2;

use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;
use joint_core::per_unit::Bases;

use super::Scene;
use super::card::{Axis, Bench, Benchmark, EffectCard, Residual};
use super::hypothesis::{Free, Hypothesis};
use super::rules::{Alike, Rules};
use crate::estimate::record::{Channel, Record};
use crate::model::Model;

pub(super) const CARD: EffectCard = EffectCard {
    words: "the weight of the link",
    residual: Residual::Torque,
    axis: Axis::OutputAngle,
    experiment: "turn the mount by a quarter, or move slowly through a full output turn",
    reference: None,
    rules: Rules { alike: constant, ..Rules::NONE },
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

/// Places of order and amplitude among a line's values.
const ORDER: usize = 0;
const AMPLITUDE: usize = 1;
/// One sigma of a constant torque's prior, in amplitudes of what it stands for.
const SIGMA: f64 = 100.0;

/// A constant torque on the rotor, as large as the pull is in the mean over a record.
fn constant(gravity: &EffectParameters, model: &Model, record: &Record) -> Option<Alike> {
    let shaft = Bases::si(&model.motor, &model.stages).shaft(model.stages.len());
    let [size, phase, ..] = gravity.values;
    let angles = record.measured.iter().filter_map(|row| {
        let output = row[Channel::Output as usize];
        let motor = row[Channel::Motor as usize] * shaft;
        [output, motor].into_iter().find(|angle| angle.is_finite())
    });
    let (sum, count) = angles
        .map(|angle| -size * (angle + phase).sin())
        .fold((0.0, 0_u32), |(sum, count), pull| (sum + pull, count + 1));
    // Of a line of the lowest order the record sees no more than its top.
    let start = EffectParameters::new(Kind::Cogging, Location::Motor)
        .with("order", Kind::Cogging.spec().parameters[ORDER].low)
        .with("phase_rad", -FRAC_PI_2);
    let free = Free::Value { value: AMPLITUDE, scale: size * shaft.abs(), sigma: SIGMA };
    Some(Alike {
        hypothesis: Hypothesis { start, free: vec![free] },
        start: start.with("amplitude_nm", shaft * sum / f64::from(count.max(1))),
        constant: Some(AMPLITUDE),
    })
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
