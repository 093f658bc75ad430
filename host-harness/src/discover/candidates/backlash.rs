//! Backlash: the stage's spring feels nothing inside a gap. It has no derivative at zero width, so
//! it is tried at widths between a tenth and ten times the wind-up under the joint's breakaway torque.

use joint_core::effect::{EffectParameters, Kind};

use super::Scene;
use super::card::{Axis, Bench, Benchmark, EffectCard, Residual};
use super::hypothesis::{Free, Hypothesis};
use super::rules::Rules;

const WIDTHS: [f64; 7] = [0.1, 0.3, 0.7, 1.5, 3.0, 6.0, 12.0];

pub(super) const CARD: EffectCard = EffectCard {
    words: "a gap between the teeth, in which the stage passes no torque on",
    residual: Residual::Windup,
    axis: Axis::OutputWindup,
    experiment: "repeat a small reversal with and without a constant load on the output",
    reference: None,
    rules: Rules::NONE,
    benchmark: Benchmark::Hidden(hidden),
    propose,
};

fn propose(scene: &Scene<'_>) -> Vec<Hypothesis> {
    let mut all = Vec::new();
    for (mass, place) in scene.masses().skip(1) {
        if scene.has(Kind::Backlash, place) {
            continue;
        }
        let stage = &scene.model.stages[mass - 1];
        let torque = scene.torque_scale() / scene.shaft(mass).abs();
        let windup = torque / stage.stiffness_nm_per_rad;
        for width in WIDTHS.map(|factor| factor * windup).into_iter().filter(|w| *w < 0.5) {
            all.push(Hypothesis {
                start: EffectParameters::new(Kind::Backlash, place).with("width_rad", width),
                free: vec![Free::Value { value: 0, scale: 0.3 * width, sigma: 30.0 }],
            });
        }
    }
    all
}

fn hidden(joint: &mut Bench<'_>) -> Option<EffectParameters> {
    let width = 3.0 * joint.size * joint.windup_rad();
    Some(EffectParameters::new(Kind::Backlash, joint.gear()?).with("width_rad", width))
}
