//! A current that a log shows late, beside the voltage that drives the joint.
//!
//! Drives report a current some samples after it flowed, or parts of one. That is the log's timing and no effect of the
//! joint, but left out it is named for one: a filter of the current, a late input, a late encoder, a resistance that sags.
//! The refitted nominal, and what a search has found, are asked whether the log is likelier by far with a current of some
//! time before in the place of a filter or a late input; that stands if neither explains the log as well. A filter that
//! was found with a time constant below one sample has nothing ahead of such a delay but one more number.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::joint::Drive;
use rayon::prelude::*;

use crate::acting::current_left_s;
use crate::discover::bounds::{FAR_BEHIND, LEAST_GAIN};
use crate::discover::candidates::hypothesis::Hypothesis;
use crate::discover::candidates::input_delay;
use crate::discover::candidates::sensor_lag::{is_of_the_current, reports};
use crate::discover::checks::elimination::narrowed;
use crate::discover::state::stage::Stage;
use crate::estimate::coordinates::Coordinate;
use crate::estimate::filter::{Linearisation, Noise};
use crate::estimate::fit::{Fit, Problem};
use crate::estimate::noise;
use crate::estimate::parameters::Quantity;
use crate::estimate::record::Channel;
use crate::estimate::refit::{self, cost};
use crate::interrupt;
use crate::model::Model;
use crate::plant::BuildError;
use crate::plot::text::si;

/// Most samples by which a current is asked to be late.
const MOST: usize = 8;
/// A delay that is fitted begins so much of a sample beside a whole number of them, where it is held.
const OFF: f64 = 0.1;

/// How late a log shows the current.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Late {
    delay_s: f64,
}

/// How late a log shows the current, by a fit of the nominal or of what a search found; `None` where it is not late.
///
/// # Errors
/// The model cannot be built.
pub(crate) fn late_current(
    problem: &Problem<'_>,
    nominal: &Model,
    stage: &Stage,
) -> Result<Option<Late>, BuildError> {
    let record = problem.record;
    let open = record.drive == Drive::Voltage && record.has(Channel::Current);
    let known =
        nominal.sensor.current_delay_s > 0.0 || nominal.effects.iter().any(is_of_the_current);
    if !open || known || interrupt::asked() {
        return Ok(None);
    }
    let mut plain = stage.clone();
    // What the nominal was given with is believed.
    for place in (nominal.effects.len()..stage.fit.model.effects.len()).rev() {
        if stands_in(&stage.fit.model.effects[place]) {
            plain = narrowed(&plain, place);
        }
    }
    let interval = record.grid.typical_interval();
    let Some(begun) = likeliest(problem, &plain.fit)? else { return Ok(None) };
    let expected = noise::expected(nominal, record);
    let known = cost(&stage.fit);
    let tried = |delay_s: f64, effect: Option<&Hypothesis>| {
        let fit = contender(problem, &plain, (delay_s, effect), (&expected, known))?;
        Ok((Late { delay_s: fit.model.sensor.current_delay_s }, cost(&fit)))
    };
    let whole = (begun / interval).round().max(1.0) * interval;
    let delayed = [whole, begun].into_par_iter().map(|delay_s| tried(delay_s, None));
    let delayed = delayed.collect::<Result<Vec<_>, BuildError>>()?;
    let dear = problem.mask.iter().sum::<f64>().max(2.0).ln();
    // A delay by parts of a sample is one number more than one by whole ones.
    let owed = |(late, cost): &(Late, f64)| cost + if late.delay_s == whole { 0.0 } else { dear };
    let delayed = delayed.into_iter().filter(|(late, _)| late.delay_s > 0.0);
    let Some(best) = delayed.min_by(|a, b| owed(a).total_cmp(&owed(b))) else { return Ok(None) };
    let within = stage
        .fit
        .model
        .effects
        .iter()
        .any(|lag| is_of_the_current(lag) && lag.values[0] < interval);
    let ahead = if within { 0.0 } else { LEAST_GAIN + dear };
    if best.1 + ahead >= known {
        return Ok(None);
    }
    let input = input_delay::late(begun / interval, interval);
    let rivals: Vec<Hypothesis> = reports(interval).chain([input]).collect();
    let rivals = rivals.par_iter().map(|rival| tried(0.0, Some(rival)));
    let rivals = rivals.collect::<Result<Vec<_>, BuildError>>()?;
    Ok(rivals.iter().all(|(_, rival)| owed(&best) < *rival).then_some(best.0))
}

impl Late {
    /// The nominal of a log that shows its current so late, refitted.
    ///
    /// # Errors
    /// The nominal cannot be built.
    pub(crate) fn refitted(
        self,
        problem: &Problem<'_>,
        nominal: &Model,
    ) -> Result<(Model, Fit), BuildError> {
        let mut origin = delayed(nominal, self.delay_s);
        let moved = refit::coordinates(&origin, problem);
        let fit = refit::resettle(problem, &origin, &origin, &moved)?;
        origin.sensor.current_delay_s = fit.model.sensor.current_delay_s;
        Ok((origin, fit))
    }
}

/// The delay of the current, by half samples, that makes the log likeliest at a fit, s; `None` where it is not by far
/// likelier with one.
fn likeliest(problem: &Problem<'_>, fit: &Fit) -> Result<Option<f64>, BuildError> {
    let ahead = problem.ahead();
    let interval = problem.record.grid.typical_interval();
    let tried = (0..=2 * MOST).into_par_iter().map(|halves| {
        let delay_s = 0.5 * halves as f64 * interval;
        let model = delayed(&fit.model, delay_s);
        let deviance = ahead.deviance_along(&Linearisation::default(), &model, &fit.noise)?;
        Ok((deviance, delay_s))
    });
    let tried = tried.collect::<Result<Vec<_>, BuildError>>()?;
    let plain = tried[0].0;
    let best = tried.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    let best = best.filter(|(deviance, _)| plain - deviance > LEAST_GAIN);
    Ok(best.map(|(_, delay_s)| delay_s + OFF * interval))
}

/// Whether an effect is one that is named for a current that is late.
fn stands_in(effect: &EffectParameters) -> bool {
    effect.kind == Kind::InputDelay || is_of_the_current(effect)
}

fn delayed(model: &Model, delay_s: f64) -> Model {
    let mut model = model.clone();
    model.sensor.current_delay_s = delay_s;
    model
}

/// A fit with the current so late, and with an effect, refitted; a delay by whole samples is held. Content with the first
/// half of that where it is far behind what is `known`.
fn contender(
    problem: &Problem<'_>,
    plain: &Stage,
    (delay_s, effect): (f64, Option<&Hypothesis>),
    (expected, known): (&Noise, f64),
) -> Result<Fit, BuildError> {
    let (mut origin, mut moved) = (plain.origin.clone(), plain.fit.coordinates.clone());
    let mut start = plain.fit.model.clone();
    if let Some(effect) = effect {
        (origin, moved) = plain.widened(effect);
        start = effect.added(&start);
    }
    let [origin, start] = [origin, start].map(|model| delayed(&model, delay_s));
    if current_left_s(&start, &problem.record.grid) != 0.0 {
        moved.push(Coordinate::Parameter(Quantity::CurrentDelay));
    }
    let (rough, noise) = (problem.rough(), &plain.fit.noise);
    let far = |fit: &Fit| cost(fit) - known > FAR_BEHIND;
    refit::polish_unless(far, &rough, &origin, &start, &moved, expected, noise)
}

/// How late a log shows the current by a fitted model, in a sentence, where the nominal that the search began from is
/// `timed` otherwise than the one that was given.
pub(crate) fn told(given: &Model, timed: &Model, model: &Model) -> Option<String> {
    (timed.sensor.current_delay_s != given.sensor.current_delay_s).then(|| {
        format!(
            "i_a is shown {} after it flowed: the model's current sensor has that",
            si(model.sensor.current_delay_s, "s", 2)
        )
    })
}

#[cfg(test)]
mod tests {
    use joint_core::params::Location;

    use super::{late_current as asked, *};
    use crate::discover::candidates::sensor_lag::lagging;
    use crate::discover::trial;
    use crate::encoders::{late, late_current};
    use crate::estimate::record::Record;
    use crate::estimate::refit::refit;
    use crate::log::Log;
    use crate::synthetic::{Experiment, Reported, record};

    /// How late the current is found to be in a second of a motor whose log shows another than flowed, in samples, where a
    /// search found a filter of about as many, or none.
    fn found(
        filter: Option<f64>,
        shows: impl Fn(&[f64], &[f64]) -> Vec<f64>,
    ) -> Option<(f64, String)> {
        let nominal = trial::motor();
        let experiment = Experiment { duration_s: 1.0, ..Experiment::default() };
        let log = record(&nominal, &experiment, 4).unwrap();
        let current_a = log.current_a.as_ref().map(|current| shows(current, &log.time_s));
        let record = Record::new(&Log { current_a, ..log }, Some(2));
        let mask = vec![1.0; record.len()];
        let problem = Problem::new(&record, &mask);
        let mut off = nominal.clone();
        off.motor.phase_resistance_ohm *= 1.1;
        off.motor.phase_inductance_h *= 0.9;
        let fit = refit(&problem, &off).unwrap();
        let stage = match filter {
            Some(samples) => {
                let constant = samples * record.grid.typical_interval();
                trial::fitted(&problem, &off, &[lagging(Location::CurrentSensor, constant)])
            }
            None => Stage { fit, origin: off.clone() },
        };
        let (late, fit) = asked(&problem, &off, &stage).unwrap()?.refitted(&problem, &off).unwrap();
        let resistance = fit.model.motor.phase_resistance_ohm / nominal.motor.phase_resistance_ohm;
        assert!((resistance - 1.0).abs() < 0.01, "{resistance}");
        let samples = late.sensor.current_delay_s / record.grid.typical_interval();
        Some((samples, told(&off, &late, &fit.model).unwrap()))
    }

    #[test]
    fn a_current_that_is_shown_late_is_told_from_one_that_is_filtered_and_from_one_that_is_not() {
        let interval = 2e-4;
        let (samples, told) = found(None, |i, t| late(i, t, 3.0 * interval)).unwrap();
        assert!((samples - 3.0).abs() < 1e-9, "{samples}");
        assert!(told.contains("600 µs"), "{told}");
        let filtered = |i: &[f64], t: &[f64]| Reported::Filtered(8.0 * interval).of(i, t);
        assert!(found(None, filtered).is_none());
        assert!(found(Some(6.0), filtered).is_none());
        // Nor is a filter that is slower than any delay which is asked for.
        let slow = |i: &[f64], t: &[f64]| Reported::Filtered(60.0 * interval).of(i, t);
        assert!(found(None, slow).is_none());
        assert!(found(None, |i, _| i.to_vec()).is_none());
        // By parts of a sample it is told from a filter as well, and one that was found in its place gives way.
        for (filter, samples) in [(None, 2.4), (Some(0.8), 0.5)] {
            let mut shows = trial::motor();
            shows.sensor.current_delay_s = samples * interval;
            let (found, told) = found(filter, |i, t| late_current(&shows, i, t)).unwrap();
            assert!((found - samples).abs() < 0.05, "{samples}: {found}");
            assert!(told.starts_with("i_a is shown"), "{told}");
        }
    }
}
