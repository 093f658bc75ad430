//! Torque saturation: a torque that falls behind the current where the current is large. It has no
//! derivative where it is absent, so two knees are tried.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;

use super::Scene;
use super::card::{Axis, Bench, Benchmark, EffectCard, Residual};
use super::channels::largest_current;
use super::hypothesis::{Free, Hypothesis};
use super::rules::Rules;
use crate::discover::bounds::RISING;
use crate::estimate::record::Record;
use crate::model::Model;

/// Knees that are tried, in largest currents.
const KNEES: [f64; 2] = [2.5, 7.0];

pub(super) const CARD: EffectCard = EffectCard {
    words: "a torque that falls behind the current where the current is large",
    residual: Residual::Torque,
    axis: Axis::Current,
    experiment: "drive and brake up to the highest current in both directions: what saturation takes \
         follows the sign of the current, what friction takes that of the speed",
    reference: None,
    rules: Rules { impossible: falls, ..Rules::NONE },
    benchmark: Benchmark::Hidden(hidden),
    propose,
};

fn propose(scene: &Scene<'_>) -> Vec<Hypothesis> {
    if scene.has(Kind::TorqueSaturation, Location::Motor) {
        return Vec::new();
    }
    let largest = scene.current().iter().fold(1e-9_f64, |most, i| most.max(i.abs()));
    KNEES
        .map(|knee| knee * largest)
        .map(|knee| Hypothesis {
            start: EffectParameters::new(Kind::TorqueSaturation, Location::Motor)
                .with("current_a", knee),
            free: vec![Free::Value { value: 0, scale: 0.1 * knee, sigma: 20.0 }],
        })
        .to_vec()
}

fn hidden(joint: &mut Bench<'_>) -> Option<EffectParameters> {
    let knee = 2.5 * joint.current_a() / joint.size;
    Some(EffectParameters::new(Kind::TorqueSaturation, Location::Motor).with("current_a", knee))
}

/// A torque that falls over half the range of a record's current.
fn falls(effect: &EffectParameters, _: &Model, record: &Record) -> bool {
    effect.values[0] < RISING * largest_current(record)
}
