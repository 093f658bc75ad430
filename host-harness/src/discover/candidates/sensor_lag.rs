//! A sensor that is filtered. How long the filter's memory is, is out of a linear step's reach, so some
//! lengths are tried outright.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::joint::Drive;
use joint_core::params::Location;

use super::Scene;
use super::card::{Axis, Bench, Benchmark, EffectCard, Residual};
use super::hypothesis::{Free, Hypothesis};
use super::rules::Rules;
use crate::estimate::record::Channel;

/// Time constants tried, in samples; of an encoder, whose filter a drive could not live with, the first ones.
const SAMPLES: [f64; 4] = [1.0, 4.0, 16.0, 64.0];
const OF_ENCODERS: usize = 3;

pub(super) const CARD: EffectCard = EffectCard {
    words: "a sensor whose filter lags behind",
    residual: Residual::MeasuredCurrent,
    axis: Axis::Current,
    experiment: "drive a chirp past one over the time constant: what the filter shows falls off in size as \
         well as in phase, where a delay leaves the size alone",
    reference: None,
    rules: Rules::NONE,
    benchmark: Benchmark::Wide(hidden),
    propose,
};

fn propose(scene: &Scene<'_>) -> Vec<Hypothesis> {
    let interval = scene.record.grid.typical_interval();
    let imposed = scene.record.drive == Drive::Current;
    let sensors = [
        (imposed || scene.record.has(Channel::Current), Location::CurrentSensor),
        (scene.record.has(Channel::Motor), Location::Encoder),
        (scene.record.has(Channel::Output), Location::OutputEncoder),
    ];
    let open =
        sensors.into_iter().filter(|(shown, place)| *shown && !scene.has(Kind::SensorLag, *place));
    open.flat_map(|(_, place)| {
        let current = place == Location::CurrentSensor;
        let tried = if current { SAMPLES.len() } else { OF_ENCODERS };
        SAMPLES.into_iter().take(tried).map(move |samples| lagging(place, samples * interval))
    })
    .collect()
}

/// A sensor that is filtered with about this time constant, s.
pub(crate) fn lagging(place: Location, constant_s: f64) -> Hypothesis {
    Hypothesis {
        start: EffectParameters::new(Kind::SensorLag, place).with("time_constant_s", constant_s),
        free: vec![Free::Value { value: 0, scale: 0.2 * constant_s, sigma: 300.0 }],
    }
}

/// Whether an effect is a filter of the current.
pub(crate) fn is_of_the_current(effect: &EffectParameters) -> bool {
    effect.kind == Kind::SensorLag && effect.location == Location::CurrentSensor
}

fn hidden(joint: &mut Bench<'_>) -> Option<EffectParameters> {
    let constant = 8.0 * joint.size * joint.sample_time_s;
    let lag = EffectParameters::new(Kind::SensorLag, Location::CurrentSensor);
    Some(lag.with("time_constant_s", constant))
}
