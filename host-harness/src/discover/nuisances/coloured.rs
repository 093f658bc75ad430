//! The search goes on beside a disturbance: one that is correlated in time, or that reversals bring.
//!
//! A disturbance state takes what the model misses as it comes, so that parameters are not biased by it and a
//! linear step can be believed. Every candidate is refitted with the disturbance's own size: what it gains is what
//! it explains beyond a disturbance without a law. So effects that stood in for others fall, and lines beside them
//! are seen: forward selection, one effect at a time, and backward elimination. The state also takes a part of slow
//! laws with it: of a model that was inconsistent without one, what it shows is asked without it too.

use std::borrow::Cow;

use rayon::prelude::*;

use super::coloured_effects::{grow, refitted};
use crate::discover::bounds::{CALM, FARTHEST, LEAST_GAIN, LOST};
use crate::discover::checks::elimination::drop_needless;
use crate::discover::checks::needless::{eliminate, needless};
use crate::discover::evidence::budget::FreeRun;
use crate::discover::evidence::disturbance::{disturbance_of, run_beside};
use crate::discover::state::search::Search;
use crate::discover::state::stage::Stage;
use crate::estimate::colour::coloured;
use crate::estimate::filter::{Equation, Linearisation, Noise, Walk};
use crate::estimate::fit::{Fit, Problem};
use crate::estimate::refit::{cost, polish, polish_on};
use crate::interrupt;
use crate::model::Model;
use crate::plant::BuildError;

/// What a search finds beside a disturbance that is correlated in time, or that reversals bring, where the log is
/// likelier with one than the model that was found is: its effects have to earn their place beside that, and
/// others are looked for. Where what is left is `noise` already, only whether one of its effects falls is asked
/// first.
///
/// # Errors
/// A model cannot be built.
pub(crate) fn beside_disturbance(
    problem: Problem<'_>,
    found: &Search,
    noise: bool,
) -> Result<Option<Search>, BuildError> {
    let none = found.rounds.is_empty();
    if interrupt::asked() || noise && none && found.noise_ratio() <= CALM {
        return Ok(None);
    }
    found.bar.set_message("asking whether the joint is disturbed");
    let Stage { fit, .. } = &found.after;
    let disturbance = coloured(&problem, &fit.model, &found.expected, &fit.noise)?;
    // One that is inconsistent may be so by effects that stand in for a disturbance: it goes on to drop them.
    if !disturbance.is_disturbed() && found.noise_ratio() <= LOST {
        return Ok(None);
    }
    let mut other = found.clone();
    if noise && !none {
        // What is needed before the rest is refitted beside the disturbance is needed after that.
        let (along, own) = (Cow::Owned(Linearisation::default()), &mut other.after.fit);
        own.deviance = problem.deviance_along(&along, &own.model, &disturbance)?;
        own.noise = disturbance;
        if needless(&problem, &other)?.is_none() {
            return Ok(None);
        }
        other = found.clone();
    }
    if !none {
        refitted(&problem, &mut other.after, &found.expected, &disturbance)?;
    }
    if noise && !none {
        eliminate(&problem, &mut other)?;
        if other.rounds.len() == found.rounds.len() {
            return Ok(None);
        }
    }
    let Stage { fit, origin } = &found.before;
    other.before = begun(&problem, origin, fit, (&found.expected, &disturbance))?;
    if !other.before.fit.noise.is_disturbed() && found.noise_ratio() <= LOST {
        return Ok(None);
    }
    if other.rounds.is_empty() {
        other.after = other.before.clone();
    } else if !noise {
        eliminate(&problem, &mut other)?;
    }
    grow(&problem, &mut other)?;
    if other.rounds.is_empty() {
        if cost(&other.after.fit) < cost(&other.before.fit) {
            other.before = other.after.clone();
        } else {
            other.after = other.before.clone();
        }
    }
    Ok(Some(other))
}

/// What was found beside a disturbance, refitted without one, where `found` is inconsistent and this makes the log likelier
/// than it: a disturbance state shows structure, but takes a part of slow laws with it.
///
/// # Errors
/// A model cannot be built.
pub(crate) fn without_disturbance(
    problem: Problem<'_>,
    found: &Search,
    beside: &Search,
) -> Result<Option<Search>, BuildError> {
    let names = |search: &Search| search.rounds.iter().map(|round| round.name).collect::<Vec<_>>();
    if found.noise_ratio() <= LOST || names(beside) == names(found) || interrupt::asked() {
        return Ok(None);
    }
    let mut other = Search { before: found.before.clone(), ..beside.clone() };
    let Stage { fit, origin } = &other.after;
    let (expected, noise) = (&other.expected, found.after.fit.noise);
    let near = polish(&problem, origin, &fit.model, &fit.coordinates, expected, &noise)?;
    other.after.fit = polish_on(&problem, origin, near, expected)?;
    drop_needless(problem, &mut other, true)?;
    // A name has to earn what counts, or the simpler model stands.
    let owed = |search: &Search| cost(&search.after.fit) + LEAST_GAIN * search.rounds.len() as f64;
    if owed(&other) >= owed(found) {
        return Ok(None);
    }
    let left = |fit: &Fit| disturbance(&problem, fit, &found.expected);
    let (own, plain) = rayon::join(|| left(&other.after.fit), || left(&found.after.fit));
    Ok((own? < plain?).then_some(other))
}

/// Whether what was found beside a disturbance stands: a likelihood beside one is one of single steps, and the model
/// has to run by itself as well. Of a nominal that is too far off for one no effect can be asked beside it.
///
/// # Errors
/// A model cannot be built.
pub(crate) fn stands(
    problem: Problem<'_>,
    found: &Search,
    beside: &Search,
) -> Result<bool, BuildError> {
    if !beside.before.fit.noise.is_disturbed() {
        return Ok(false);
    }
    let tested: Vec<bool> = problem.mask.iter().map(|weight| *weight == 0.0).collect();
    let models = [&found.after.fit, &beside.after.fit];
    let runs = FreeRun::of(problem.record, models, &found.expected, &tested)?;
    Ok(runs.factor() <= FARTHEST)
}

/// RMS of the rotor torque that a model misses over the samples fitted to, Nm: a likelihood of many sensors may be
/// won by what hardly moves the joint.
fn disturbance(problem: &Problem<'_>, fit: &Fit, expected: &Noise) -> Result<f64, BuildError> {
    let scale = 20.0 * expected.torque;
    let walk = Walk::random(Equation::Torque(0), scale, 10.0 * scale);
    let torques = disturbance_of(&run_beside(problem, &fit.model, expected, walk)?);
    let fitted = torques.iter().zip(problem.mask).filter(|(_, weight)| **weight > 0.0);
    let (sum, count) =
        fitted.fold((0.0, 0.0), |(sum, count), (torque, _)| (sum + torque * torque, count + 1.0));
    Ok(f64::sqrt(sum / f64::max(count, 1.0)))
}

/// The nominal refitted beside a coloured disturbance: from its plain refit and from where it was, since the
/// plain one is biased by what is missing.
fn begun(
    problem: &Problem<'_>,
    nominal: &Model,
    fit: &Fit,
    (expected, disturbance): (&Noise, &Noise),
) -> Result<Stage, BuildError> {
    let (ahead, coordinates) = (problem.ahead(), &fit.coordinates);
    let starts = [&fit.model, nominal].into_par_iter();
    let fits =
        starts.map(|start| polish(&ahead, nominal, start, coordinates, expected, disturbance));
    let fits = fits.collect::<Result<Vec<_>, BuildError>>()?;
    let near = fits.into_iter().min_by(|a, b| cost(a).total_cmp(&cost(b)));
    let near = near.map_or_else(|| fit.model.clone(), |near| near.model);
    let noise = coloured(problem, &near, expected, disturbance)?;
    let beside = polish(problem, nominal, &near, coordinates, expected, &noise)?;
    let fit = if cost(&beside) < cost(fit) { beside } else { fit.clone() };
    Ok(Stage { fit, origin: nominal.clone() })
}

#[cfg(test)]
mod tests {
    use joint_core::effect::{EffectParameters, Kind};
    use joint_core::params::Location;

    use super::*;
    use crate::discover::candidates::cogging;
    use crate::discover::candidates::hypothesis::{Free, Hypothesis};
    use crate::discover::state::rounds::Round;
    use crate::discover::trial;
    use crate::estimate::filter::{Colour, Disturbed};
    use crate::estimate::noise;
    use crate::estimate::record::Record;
    use crate::estimate::replicate::replicate;

    /// One where a sample is fitted to, in blocks of which three tenths are not.
    fn held_out(samples: usize) -> Vec<f64> {
        (0..samples).map(|k| if k % 500 < 350 { 1.0 } else { 0.0 }).collect()
    }

    #[test]
    fn beside_a_disturbance_what_it_imitated_falls_and_what_is_there_stays() {
        let nominal = trial::motor();
        // A fifth of the line that the trials have: the nominal is not inconsistent without it.
        let line = trial::line(12.0).with("amplitude_nm", 0.004);
        let clean = Record::new(&trial::log(&nominal, line, 4.0), None);
        let mask = held_out(clean.len());
        let expected = noise::expected(&nominal, &clean);
        let truth = Model { effects: vec![line], ..nominal.clone() };
        let mut noise = expected;
        noise.coloured[Disturbed::Rotor as usize] =
            Colour { deviation: 6.0 * expected.torque, correlation_s: 0.02 };
        let record = replicate(&truth, &clean, &noise, 3).unwrap();
        let problem = Problem::new(&record, &mask).rough();
        let free = vec![Free::Value { value: 0, scale: 0.02, sigma: 30.0 }];
        let drag = EffectParameters::new(Kind::QuadraticDrag, Location::Motor);
        let drag = Hypothesis { start: drag, free };
        let mut found = Search::new(trial::fitted(&problem, &nominal, &[]), &[], expected);
        found.after =
            trial::fitted(&problem, &nominal, &[drag.clone(), cogging::line(12.0, 0.004, false)]);
        let names = [(drag.start.kind, drag.start.location), (Kind::Cogging, Location::Motor)];
        found.rounds.extend(names.map(|name| Round { name, ..trial::round(100.0) }));
        let other = beside_disturbance(problem, &found, false).unwrap().unwrap();
        assert!(stands(problem, &found, &other).unwrap());
        let left: Vec<_> = other.rounds.iter().map(|round| round.name).collect();
        assert_eq!(left, [(Kind::Cogging, Location::Motor)]);
        let [_, own, _] = other.after.fit.noise.coloured;
        assert!((own.deviation / (6.0 * expected.torque)).ln().abs() < 0.5, "{own:?}");

        // Where nothing disturbs, nothing is asked again.
        let plain = replicate(&truth, &clean, &expected, 3).unwrap();
        let problem = Problem::new(&plain, &mask).rough();
        let mut found = Search::new(trial::fitted(&problem, &nominal, &[]), &[], expected);
        found.after = trial::fitted(&problem, &nominal, &[cogging::line(12.0, 0.004, false)]);
        assert!(beside_disturbance(problem, &found, false).unwrap().is_none());
    }

    #[test]
    fn an_effect_that_stood_in_for_a_line_falls_and_the_line_is_found() {
        let nominal = trial::motor();
        let record = Record::new(&trial::log(&nominal, trial::line(12.0), 4.0), None);
        let mask = held_out(record.len());
        let problem = Problem::new(&record, &mask).rough();
        let expected = noise::expected(&nominal, &record);
        let mut found = Search::new(trial::fitted(&problem, &nominal, &[]), &[], expected);
        let drag = EffectParameters::new(Kind::QuadraticDrag, Location::Motor);
        let free = vec![Free::Value { value: 0, scale: 1e-6, sigma: 30.0 }];
        found.after = trial::fitted(&problem, &nominal, &[Hypothesis { start: drag, free }]);
        let name = (drag.kind, drag.location);
        found.rounds.push(Round { name, ..trial::round(100.0) });
        assert!(found.noise_ratio() > LOST, "{}", found.noise_ratio());
        let beside = beside_disturbance(problem, &found, false).unwrap().unwrap();
        let other = without_disturbance(problem, &found, &beside).unwrap().unwrap();
        let names: Vec<_> = other.rounds.iter().map(|round| round.name).collect();
        assert_eq!(names, [(Kind::Cogging, Location::Motor)]);
        let line = other.after.fit.model.effects[0];
        assert_eq!(line.values[0], 12.0);
        assert!((line.values[1] / 0.02 - 1.0).abs() < 0.05, "{line:?}");
        assert_eq!(other.after.fit.noise.colours().count(), 0);
    }
}
