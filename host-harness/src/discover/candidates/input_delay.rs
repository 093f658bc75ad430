//! A drive that acts late. A delay of many samples is out of a linear step's reach, so some are tried
//! outright. Where an encoder is all that is measured, it may as well be the encoder that is late: no law
//! tells them apart, and [`super::sensor_delay`] stands for both.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;

use super::Scene;
use super::card::{Axis, Bench, Benchmark, EffectCard, Residual};
use super::hypothesis::{Free, Hypothesis};
use super::rules::Rules;
use crate::estimate::record::{Channel, Record};
use crate::model::Model;

/// Delays tried, in samples.
const SAMPLES: [f64; 6] = [0.3, 0.8, 1.5, 3.0, 6.0, 12.0];

pub(super) const CARD: EffectCard = EffectCard {
    words: "a drive that acts later than its log says",
    residual: Residual::Torque,
    axis: Axis::Time,
    experiment: "step the input while the joint is at rest and log it at the drive's own rate: what all \
         sensors show late at once is the input's, what one of them shows late is its own",
    reference: None,
    rules: Rules { impossible, ..Rules::NONE },
    benchmark: Benchmark::Wide(hidden),
    propose,
};

fn propose(scene: &Scene<'_>) -> Vec<Hypothesis> {
    let measured = Channel::ALL.into_iter().filter(|channel| scene.record.has(*channel)).count();
    if measured < 2 || scene.has(Kind::InputDelay, Location::Inverter) {
        return Vec::new();
    }
    let interval = scene.record.grid.typical_interval();
    SAMPLES.map(|samples| late(samples, interval)).to_vec()
}

/// An input that acts late by so many intervals of a length in s.
pub(crate) fn late(samples: f64, interval: f64) -> Hypothesis {
    let delay = EffectParameters::new(Kind::InputDelay, Location::Inverter);
    Hypothesis {
        start: delay.with("delay_s", samples * interval),
        free: vec![Free::Value { value: 0, scale: 0.2 * interval, sigma: 300.0 }],
    }
}

/// A drive that acts before it is asked.
fn impossible(effect: &EffectParameters, _: &Model, _: &Record) -> bool {
    effect.values[0] < 0.0
}

fn hidden(joint: &mut Bench<'_>) -> Option<EffectParameters> {
    let delay = EffectParameters::new(Kind::InputDelay, Location::Inverter);
    Some(delay.with("delay_s", 1.5 * joint.size * joint.sample_time_s))
}
