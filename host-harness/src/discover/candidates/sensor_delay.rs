//! A late encoder: an error that grows with the speed. A delay of many samples is out of reach of
//! a linear step, so some are tried outright.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;

use super::Scene;
use super::card::{Axis, Bench, Benchmark, EffectCard, Residual};
use super::hypothesis::{Free, Hypothesis};
use super::rules::Rules;
use crate::estimate::record::{Channel, Record};
use crate::model::Model;

/// Delays tried, in samples.
const SAMPLES: [f64; 6] = [0.0, 2.0, 4.0, 8.0, 16.0, -2.0];

pub(super) const CARD: EffectCard = EffectCard {
    words: "an encoder that shows the past",
    residual: Residual::MeasuredAngle,
    axis: Axis::MotorSpeed,
    experiment: "drive a chirp up to a tenth of the sample rate: the phase of a delay grows in proportion \
         to the frequency, that of inductance and damping levels off",
    reference: None,
    rules: Rules { impossible: sees_the_future, ..Rules::NONE },
    benchmark: Benchmark::Hidden(hidden),
    propose,
};

fn propose(scene: &Scene<'_>) -> Vec<Hypothesis> {
    let interval = scene.record.grid.interval(0);
    let mut all = Vec::new();
    for (channel, place) in
        [(Channel::Motor, Location::Encoder), (Channel::Output, Location::OutputEncoder)]
    {
        if !scene.record.has(channel) || scene.has(Kind::SensorDelay, place) {
            continue;
        }
        all.extend(SAMPLES.map(|samples| Hypothesis {
            start:
                EffectParameters::new(Kind::SensorDelay, place).with("delay_s", samples * interval),
            free: vec![Free::Value { value: 0, scale: 0.2 * interval, sigma: 300.0 }],
        }));
    }
    all
}

fn hidden(joint: &mut Bench<'_>) -> Option<EffectParameters> {
    let samples = (3.0 * joint.size).round().max(1.0);
    Some(
        EffectParameters::new(Kind::SensorDelay, Location::Encoder)
            .with("delay_s", samples * joint.sample_time_s),
    )
}

/// A joint with one encoder that sees the future. Behind gears two may stand, of which only the difference is known.
fn sees_the_future(effect: &EffectParameters, model: &Model, _: &Record) -> bool {
    model.stages.is_empty() && effect.values[0] < 0.0
}

/// How many encoders are late by these names.
pub(crate) fn late_encoders(names: impl Iterator<Item = (Kind, Location)>) -> usize {
    names.filter(|(kind, _)| *kind == Kind::SensorDelay).count()
}
