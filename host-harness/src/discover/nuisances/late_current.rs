//! A current that a log shows late, beside the voltage that drives the joint.
//!
//! Drives report a current some samples after it flowed. That is the log's timing and no effect of the joint, but left
//! out it is named for one: a filter of the current, a late input, a late encoder, a resistance that sags. The refitted
//! nominal, and what a search has found, are asked whether the log is likelier by far with a current of some samples before
//! in the place of a filter or a late input; that stands if neither explains the log as well. What is left of a sample is a
//! lag with a lead, which is a delay where that is negative: within one, samples do not tell a delay from a filter, so that
//! a filter which was found that fast is the log's timing, too.

use joint_core::effect::{EffectParameters, Kind, sensor_lag};
use joint_core::joint::Drive;
use joint_core::params::Location;
use rayon::prelude::*;

use crate::discover::bounds::{FAR_BEHIND, LEAST_GAIN};
use crate::discover::candidates::hypothesis::Hypothesis;
use crate::discover::candidates::input_delay;
use crate::discover::candidates::sensor_lag::{is_of_the_current, reported, reports};
use crate::discover::checks::elimination::narrowed;
use crate::discover::state::stage::Stage;
use crate::estimate::filter::{Linearisation, Noise};
use crate::estimate::fit::{Fit, Problem};
use crate::estimate::noise;
use crate::estimate::record::Channel;
use crate::estimate::refit::{self, cost};
use crate::interrupt;
use crate::model::Model;
use crate::plant::BuildError;
use crate::plot::text::si;

/// Most samples by which a current is asked to be late.
const MOST: usize = 8;
/// Lag in samples that what is left of one is begun with.
const LEFT: f64 = 0.4;

/// How late a log shows the current.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Late {
    /// Whole samples.
    samples: usize,
    /// The lag that stands for the rest of a sample.
    rest: Option<EffectParameters>,
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
    let interval = record.grid.typical_interval();
    let within = lag_in(&stage.fit.model).filter(|lag| lag.values[0] < interval);
    let within = within.map(|lag| Late { samples: 0, rest: Some(*lag) });
    Ok(by_samples(problem, nominal, stage)?.or(within))
}

/// How many samples late a log shows the current, and a rest; `None` where it is not late by one.
fn by_samples(
    problem: &Problem<'_>,
    nominal: &Model,
    stage: &Stage,
) -> Result<Option<Late>, BuildError> {
    let record = problem.record;
    let mut plain = stage.clone();
    // What the nominal was given with is believed.
    for place in (nominal.effects.len()..stage.fit.model.effects.len()).rev() {
        if stands_in(&stage.fit.model.effects[place]) {
            plain = narrowed(&plain, place);
        }
    }
    let samples = likeliest(problem, &plain.fit)?;
    if samples == 0 {
        return Ok(None);
    }
    let expected = noise::expected(nominal, record);
    let interval = record.grid.typical_interval();
    let known = cost(&stage.fit);
    let tried = |samples: usize, effect: Option<&Hypothesis>| {
        let fit = contender(problem, &plain, (samples, effect), (&expected, known))?;
        Ok((Late { samples, rest: lag_in(&fit.model).copied() }, cost(&fit)))
    };
    let rest = reported(LEFT * interval, interval);
    let delayed = [(samples, None), (samples, Some(&rest)), (samples - 1, Some(&rest))];
    let delayed = delayed.into_par_iter().filter(|(samples, _)| *samples > 0);
    let delayed = delayed.map(|(samples, rest)| tried(samples, rest));
    let delayed = delayed.collect::<Result<Vec<_>, BuildError>>()?;
    // A filter that is slower is none of the timing.
    let within = |late: &Late| late.rest.is_none_or(|rest| rest.values[0] <= interval);
    let delayed = delayed.into_iter().filter(|(late, _)| within(late));
    let dear = problem.mask.iter().sum::<f64>().max(2.0).ln();
    let owed = |(late, cost): &(Late, f64)| if late.rest.is_some() { cost + dear } else { *cost };
    let best = delayed.min_by(|a, b| owed(a).total_cmp(&owed(b)));
    let Some(best) = best.filter(|(_, best)| best + LEAST_GAIN + dear < known) else {
        return Ok(None);
    };
    let input = input_delay::late(samples as f64, interval);
    let rivals: Vec<Hypothesis> = reports(interval).chain([input]).collect();
    let rivals = rivals.par_iter().map(|rival| tried(0, Some(rival)));
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
        let interval = problem.record.grid.typical_interval();
        let mut origin = delayed(nominal, self.samples, interval);
        let mut moved = refit::coordinates(nominal, problem);
        if let Some(own) = self.rest {
            let lag = Hypothesis { start: own, ..reported(own.values[0], interval) };
            moved.extend(lag.coordinates(origin.effects.len()));
            origin = lag.added(&origin);
        }
        let fit = refit::resettle(problem, &origin, &origin, &moved)?;
        origin.effects.clone_from(&fit.model.effects);
        Ok((origin, fit))
    }
}

/// The samples by which a current that is late makes the log likeliest at a fit; zero where that is not by far.
fn likeliest(problem: &Problem<'_>, fit: &Fit) -> Result<usize, BuildError> {
    let ahead = problem.ahead();
    let interval = problem.record.grid.typical_interval();
    let tried = (0..=MOST).into_par_iter().map(|samples| {
        let model = delayed(&fit.model, samples, interval);
        let deviance = ahead.deviance_along(&Linearisation::default(), &model, &fit.noise)?;
        Ok((deviance, samples))
    });
    let tried = tried.collect::<Result<Vec<_>, BuildError>>()?;
    let plain = tried[0].0;
    let best = tried.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    Ok(best.filter(|(deviance, _)| plain - deviance > LEAST_GAIN).map_or(0, |(_, samples)| samples))
}

/// Whether an effect is one that is named for a current that is late.
fn stands_in(effect: &EffectParameters) -> bool {
    effect.kind == Kind::InputDelay || is_of_the_current(effect)
}

/// The current's filter in a model.
fn lag_in(model: &Model) -> Option<&EffectParameters> {
    model.effects.iter().find(|effect| is_of_the_current(effect))
}

fn delayed(model: &Model, samples: usize, interval: f64) -> Model {
    let mut model = model.clone();
    model.sensor.current_delay_s = samples as f64 * interval;
    model
}

/// A fit with the current so many samples late, and with an effect, refitted; content with the first half of that where
/// it is far behind what is `known`.
fn contender(
    problem: &Problem<'_>,
    plain: &Stage,
    (samples, effect): (usize, Option<&Hypothesis>),
    (expected, known): (&Noise, f64),
) -> Result<Fit, BuildError> {
    let interval = problem.record.grid.typical_interval();
    let (mut origin, mut moved) = (plain.origin.clone(), plain.fit.coordinates.clone());
    let mut start = plain.fit.model.clone();
    if let Some(effect) = effect {
        (origin, moved) = plain.widened(effect);
        start = effect.added(&start);
    }
    let [origin, start] = [origin, start].map(|model| delayed(&model, samples, interval));
    let (rough, noise) = (problem.rough(), &plain.fit.noise);
    let far = |fit: &Fit| cost(fit) - known > FAR_BEHIND;
    refit::polish_unless(far, &rough, &origin, &start, &moved, expected, noise)
}

/// How late a log shows the current by a fitted model, in a sentence, where the nominal that the search began from is
/// `timed` otherwise than the one that was given.
pub(crate) fn told(given: &Model, timed: &Model, model: &Model) -> Option<String> {
    let timing =
        |model: &Model| (model.sensor.current_delay_s, model.effects.iter().any(is_of_the_current));
    (timing(timed) != timing(given)).then(|| {
        let [lag, ahead] = [sensor_lag::time_constant_s, sensor_lag::lead_s]
            .map(|of| of(&model.effects, Location::CurrentSensor));
        format!(
            "i_a is shown {} after it flowed: the model's current sensor has that",
            si(model.sensor.current_delay_s + lag - ahead, "s", 2)
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discover::candidates::sensor_lag::lagging;
    use crate::discover::trial;
    use crate::encoders::late;
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
        let (late, fit) =
            late_current(&problem, &off, &stage).unwrap()?.refitted(&problem, &off).unwrap();
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
        // Within a sample a filter that was found is a delay.
        let (samples, told) = found(Some(0.8), |i, t| late(i, t, 0.5 * interval)).unwrap();
        assert_eq!(samples, 0.0);
        let words: Vec<&str> = told.split(' ').collect();
        let [_, _, _, value, "µs", ..] = words[..] else { panic!("{told}") };
        assert!((value.parse::<f64>().unwrap() - 100.0).abs() < 20.0, "{told}");
    }
}
