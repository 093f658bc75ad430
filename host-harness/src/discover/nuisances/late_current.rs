//! A current that a log shows late, beside the voltage that drives the joint.
//!
//! Drives report a current some samples after it flowed, or parts of one. That is the log's timing and no effect of the
//! joint, but left out it is named for one: a filter of the current, a late input, a late encoder, a resistance that sags.
//! The refitted nominal, and what a search has found, are asked whether the log is likelier by far with a current of some
//! time before; that stands if no filter of the current in its place explains the log as well, and no late input better by
//! what tells two effects apart: what is left between those two is when the encoder shows the motion. Each is charged for
//! its values by the length of the log (Schwarz, Estimating the dimension of a model, 1978); a whole number of samples is
//! none.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::joint::Drive;
use rayon::prelude::*;

use crate::discover::bounds::{FAR_BEHIND, LEAST_GAIN, SEPARATION};
use crate::discover::candidates::hypothesis::Hypothesis;
use crate::discover::candidates::input_delay;
use crate::discover::candidates::sensor_lag::{is_of_the_current, reports};
use crate::discover::checks::elimination::narrowed;
use crate::discover::state::stage::Stage;
use crate::estimate::coordinates::Coordinate;
use crate::estimate::filter::{Linearisation, Noise};
use crate::estimate::fit::{Fit, Problem};
use crate::estimate::late::is_between_samples;
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
/// Delays that are asked, in every sample.
const STEPS: usize = 2;

/// How late a log shows the current, by a fit of the nominal or of what a search found, s; `None` where it is not late.
///
/// # Errors
/// The model cannot be built.
pub(crate) fn late_current(
    problem: &Problem<'_>,
    nominal: &Model,
    stage: &Stage,
) -> Result<Option<f64>, BuildError> {
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
    let expected = noise::expected(nominal, record);
    let tried = |begun: &Stage, delay: Delay, effect: Option<&Hypothesis>| {
        contender(problem, begun, (delay, effect), (&expected, cost(&stage.fit)))
    };
    let held = |begun: &Stage, delay_s: f64| tried(begun, Delay::Held(delay_s), None);
    let Some((near, begun)) = approached(problem, &plain, held)? else { return Ok(None) };
    let value = problem.mask.iter().sum::<f64>().max(2.0).ln();
    let values = |fit: &Fit| fit.coordinates.len().saturating_sub(plain.fit.coordinates.len());
    let charged = |fit: &Fit| cost(fit) + value * values(fit) as f64;
    // Between two whole numbers of samples, and at both.
    let between = if near.fract() == 0.0 { near - 0.5 / STEPS as f64 } else { near };
    let delays = [between, between.floor(), between.ceil()];
    let delays = delays.into_par_iter().filter(|samples| *samples > 0.0);
    let delayed = delays.map(|samples| tried(&begun, Delay::Free(samples * interval), None));
    let delayed = delayed.collect::<Result<Vec<_>, BuildError>>()?;
    let without = match plain.fit.model.effects.len() == stage.fit.model.effects.len() {
        true => cost(&stage.fit),
        false => cost(&held(&plain, 0.0)?),
    };
    let best = delayed.iter().min_by(|a, b| charged(a).total_cmp(&charged(b)));
    let Some(best) = best.filter(|fit| charged(fit) + LEAST_GAIN + value < without) else {
        return Ok(None);
    };
    let input = input_delay::late(near, interval);
    let rivals: Vec<Hypothesis> = reports(interval).chain([input]).collect();
    let rivals = rivals.par_iter().map(|rival| tried(&begun, Delay::Held(0.0), Some(rival)));
    let rivals = rivals.collect::<Result<Vec<_>, BuildError>>()?;
    let likelier = |rival: &Fit| {
        let input = rival.model.effects[nominal.effects.len()..].iter().any(is_of_the_input);
        charged(rival) + if input { 2.0 * SEPARATION } else { 0.0 } <= charged(best)
    };
    let beaten = rivals.iter().chain([&stage.fit]).any(likelier);
    Ok((!beaten).then_some(best.model.sensor.current_delay_s))
}

/// A nominal with its current shown so late, s, and its refit.
///
/// # Errors
/// The nominal cannot be built.
pub(crate) fn refitted(
    problem: &Problem<'_>,
    nominal: &Model,
    delay_s: f64,
) -> Result<(Model, Fit), BuildError> {
    let mut origin = delayed(nominal, delay_s);
    let moved = refit::coordinates(&origin, problem);
    let fit = refit::resettle(problem, &origin, &origin, &moved)?;
    origin.sensor = fit.model.sensor;
    Ok((origin, fit))
}

/// The delay of the current in samples from which fits are to begin, and the fit there: a nominal that is off shows less
/// of a delay than its refit with that does. `None` where there is none.
fn approached(
    problem: &Problem<'_>,
    plain: &Stage,
    tried: impl Fn(&Stage, f64) -> Result<Fit, BuildError>,
) -> Result<Option<(f64, Stage)>, BuildError> {
    let step_s = problem.record.grid.typical_interval() / STEPS as f64;
    let (mut begun, mut known) = (plain.clone(), 0);
    let mut least = f64::INFINITY;
    for _ in 0..MOST {
        let steps = likeliest(problem, &begun.fit)?;
        if steps == known || interrupt::asked() {
            break;
        }
        let fit = tried(&begun, steps as f64 * step_s)?;
        if cost(&fit).total_cmp(&least).is_ge() {
            break;
        }
        (known, least) = (steps, cost(&fit));
        begun.fit = fit;
    }
    Ok((known > 0).then_some((known as f64 / STEPS as f64, begun)))
}

/// The delay of the current that makes the log likeliest at a fit, in steps of a sample's parts; zero where that is not by
/// far.
fn likeliest(problem: &Problem<'_>, fit: &Fit) -> Result<usize, BuildError> {
    let ahead = problem.ahead();
    let step_s = problem.record.grid.typical_interval() / STEPS as f64;
    let tried = (0..=MOST * STEPS).into_par_iter().map(|steps| {
        let model = delayed(&fit.model, steps as f64 * step_s);
        let deviance = ahead.deviance_along(&Linearisation::default(), &model, &fit.noise)?;
        Ok((deviance, steps))
    });
    let tried = tried.collect::<Result<Vec<_>, BuildError>>()?;
    let plain = tried[0].0;
    let best = tried.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    Ok(best.filter(|(deviance, _)| plain - deviance > LEAST_GAIN).map_or(0, |(_, steps)| steps))
}

/// Whether an effect is one that is named for a current that is late.
fn stands_in(effect: &EffectParameters) -> bool {
    is_of_the_input(effect) || is_of_the_current(effect)
}

fn is_of_the_input(effect: &EffectParameters) -> bool {
    effect.kind == Kind::InputDelay
}

fn delayed(model: &Model, delay_s: f64) -> Model {
    let mut model = model.clone();
    model.sensor.current_delay_s = delay_s;
    model
}

/// A delay of the current, s.
#[derive(Clone, Copy, Debug)]
enum Delay {
    Held(f64),
    /// Fitted, where it is no whole number of samples.
    Free(f64),
}

/// A fit with the current late, and with an effect, refitted; content with the first half of that where it is far
/// behind what is `known`.
fn contender(
    problem: &Problem<'_>,
    plain: &Stage,
    (delay, effect): (Delay, Option<&Hypothesis>),
    (expected, known): (&Noise, f64),
) -> Result<Fit, BuildError> {
    let (mut origin, mut moved) = (plain.origin.clone(), plain.fit.coordinates.clone());
    let mut start = plain.fit.model.clone();
    if let Some(effect) = effect {
        (origin, moved) = plain.widened(effect);
        start = effect.added(&start);
    }
    let (Delay::Held(delay_s) | Delay::Free(delay_s)) = delay;
    let [origin, start] = [origin, start].map(|model| delayed(&model, delay_s));
    if matches!(delay, Delay::Free(_)) && is_between_samples(&start, problem.record) {
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

    use super::*;
    use crate::discover::candidates::sensor_lag::lagging;
    use crate::discover::trial;
    use crate::encoders::{self, late};
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
        let late = late_current(&problem, &off, &stage).unwrap()?;
        let (late, fit) = refitted(&problem, &off, late).unwrap();
        let resistance = fit.model.motor.phase_resistance_ohm / nominal.motor.phase_resistance_ohm;
        assert!((resistance - 1.0).abs() < 0.01, "{resistance}");
        let samples = fit.model.sensor.current_delay_s / record.grid.typical_interval();
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
        // Parts of a sample are a delay, too, where a search found a filter of them or nothing.
        for (filter, parts) in [(Some(0.8), 0.5), (None, 1.6), (Some(1.4), 2.3)] {
            let shows = |i: &[f64], t: &[f64]| {
                encoders::late_current(&delayed(&trial::motor(), parts * interval), i, t)
            };
            let (samples, told) = found(filter, shows).unwrap();
            assert!((samples - parts).abs() < 0.03, "{samples} {parts}");
            assert!(told.contains("µs after it flowed"), "{told}");
        }
    }
}
