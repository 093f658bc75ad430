//! A coating: a torque that is elastic in the output angle, with a loop of its own.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;

use super::Scene;
use super::card::{Axis, Bench, Benchmark, EffectCard, Residual};
use super::hypothesis::{Free, Hypothesis};
use super::rules::Rules;

/// Widths of the loop that are tried, as shares of the travel.
const WIDTHS: [f64; 3] = [0.01, 0.05, 0.2];

pub(super) const CARD: EffectCard = EffectCard {
    words: "an elastic skin around the joint, which gives some of its torque back late",
    residual: Residual::Torque,
    axis: Axis::OutputAngle,
    experiment: "travel beyond a quarter turn to both sides and hold there: a skin pulls harder the \
         further it is stretched, and gives way while it is held; gravity turns back beyond the \
         quarter",
    reference: None,
    rules: Rules::NONE,
    benchmark: Benchmark::Hidden(hidden),
    propose,
};

fn propose(scene: &Scene<'_>) -> Vec<Hypothesis> {
    let stages = scene.model.stages.len();
    if stages == 0 || scene.has(Kind::Coating, Location::Output) {
        return Vec::new();
    }
    let travel = scene.travel(stages).max(1e-9);
    let torque = 0.05 * scene.torque_scale() / scene.shaft(stages).abs();
    WIDTHS
        .map(|share| share * travel)
        .map(|width| Hypothesis {
            start: EffectParameters::new(Kind::Coating, Location::Output)
                .with("stiffness_nm_per_rad", 0.0)
                .with("width_rad", width),
            free: vec![
                Free::Value { value: 0, scale: torque / travel, sigma: 300.0 },
                Free::Value { value: 1, scale: torque, sigma: 100.0 },
                Free::Value { value: 2, scale: 0.2 * width, sigma: 10.0 },
            ],
        })
        .to_vec()
}

fn hidden(joint: &mut Bench<'_>) -> Option<EffectParameters> {
    joint.gear()?;
    let coating = EffectParameters::new(Kind::Coating, Location::Output)
        .with("stiffness_nm_per_rad", 0.6 * joint.size * joint.output_torque_nm)
        .with("hysteresis_nm", 0.5 * joint.size * joint.output_torque_nm);
    Some(coating)
}
