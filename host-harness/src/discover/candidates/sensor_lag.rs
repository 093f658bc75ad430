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
    open.flat_map(|(_, place)| -> Vec<Hypothesis> {
        let lags = SAMPLES.into_iter().map(|samples| lagging(place, samples * interval));
        match place {
            Location::CurrentSensor if imposed => lags.collect(),
            Location::CurrentSensor => reports(interval).collect(),
            _ => lags.take(OF_ENCODERS).collect(),
        }
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

/// The same of a current's report by a drive that samples at this interval, s: a digital filter is ahead of a
/// continuous one by half its period, or as much behind it.
fn reported(constant_s: f64, interval: f64) -> Hypothesis {
    let mut lag = lagging(Location::CurrentSensor, constant_s);
    lag.free.push(Free::Value { value: 1, scale: 0.5 * interval, sigma: 1.0 });
    lag
}

/// The filters of a current's report that are tried.
pub(crate) fn reports(interval: f64) -> impl Iterator<Item = Hypothesis> {
    SAMPLES.into_iter().map(move |samples| reported(samples * interval, interval))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discover::trial;
    use crate::estimate::fit::Problem;
    use crate::estimate::record::Record;
    use crate::log::Log;
    use crate::synthetic::{Experiment, Reported, record};

    #[test]
    fn a_digital_filter_of_the_current_is_found_with_its_time_constant_and_half_a_period_ahead() {
        let nominal = trial::motor();
        let log = record(&nominal, &Experiment::clean(1.0), 4).unwrap();
        let interval = log.time_s[1] - log.time_s[0];
        let constant = 8.0 * interval;
        let flowing = log.current_a.as_ref().unwrap();
        let current_a = Some(Reported::Filtered(constant).of(flowing, &log.time_s));
        let record = Record::new(&Log { current_a, ..log }, Some(2));
        let mask = vec![1.0; record.len()];
        let problem = Problem::new(&record, &mask);
        let fitted = |lag| trial::fitted(&problem, &nominal, &[lag]).fit;
        let plain = fitted(lagging(Location::CurrentSensor, 4.0 * interval));
        let ahead = fitted(reported(4.0 * interval, interval));
        let [found, lead, ..] = ahead.model.effects[0].values;
        assert!((found / constant - 1.0).abs() < 2e-3, "{found} {constant}");
        assert!((lead / (0.5 * interval) - 1.0).abs() < 0.1, "{lead} {interval}");
        assert!(ahead.deviance < plain.deviance - 100.0, "{} {}", ahead.deviance, plain.deviance);
    }
}
