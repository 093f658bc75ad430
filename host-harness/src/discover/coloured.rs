//! The search goes on beside a disturbance: one that is correlated in time, or that reversals bring.
//!
//! A disturbance state takes what the model misses as it comes, so that parameters are not biased by it and a
//! linear step can be believed. Every candidate is refitted with the disturbance's own size: what it gains is what
//! it explains beyond a disturbance without a law. So effects that stood in for others fall, and lines beside them
//! are seen: forward selection, one effect at a time, and backward elimination. The state also takes a part of slow
//! laws with it: of a model that was lost without one, what it shows is asked without it too.

use std::borrow::Cow;

use joint_core::effect::MAX_EFFECTS;
use rayon::prelude::*;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::bootstrap::stays_ahead;
use super::candidates::{self, Scene};
use super::chance::{threshold, told};
use super::evidence::FreeRun;
use super::findings::ScoreRow;
use super::hypothesis::{Hypothesis, first_of_each, run_through};
use super::needless::{bare, drop_needless, without};
use super::order::ask_order;
use super::score_test::{Gain, ScoreTest};
use super::search::{CALM, Contender, LEAST_GAIN, LOST, Round, Search, Stage, excess, title};
use super::whereabouts::{of_push, pushed};
use crate::estimate::colour::coloured;
use crate::estimate::filter::{Equation, Linearisation, Noise, Walk};
use crate::estimate::fit::{Fit, Known, Problem};
use crate::estimate::refit::{self, cost, polish, polish_on};
use crate::interrupt;
use crate::model::Model;
use crate::plant::BuildError;

/// Most effects that are added.
const MOST_EFFECTS: usize = 8;
/// Replicates that tell what a score reaches by chance.
const REPLICATES: u64 = 6;
/// Chance that one of all hypotheses passes where nothing is missing.
const LEVEL: f64 = 0.05;
/// Hypotheses that get a short refit, and how many of these a full one.
const SHORT: usize = 6;
const FULL: usize = 3;
/// Most times as far off as without one that a model found beside a disturbance may run free.
const FARTHEST: f64 = 2.0;
/// Rounds of a short refit.
const ROUNDS: usize = 3;

/// What a search finds beside a disturbance that is correlated in time, or that reversals bring, where the log is
/// likelier with one than the model that was found is: its effects have to earn their place beside that, and
/// others are looked for. Where what is left is `noise` already, only whether one of its effects falls is asked
/// first.
///
/// # Errors
/// A model cannot be built.
pub(super) fn beside_disturbance(
    problem: Problem<'_>,
    found: &Search,
    noise: bool,
) -> Result<Option<Search>, BuildError> {
    let none = found.rounds.is_empty();
    if interrupt::asked() || noise && none && excess(found) <= CALM {
        return Ok(None);
    }
    found.bar.set_message("asking whether the joint is disturbed");
    let Stage { fit, .. } = &found.after;
    let disturbance = coloured(&problem, &fit.model, &found.expected, &fit.noise)?;
    // One that is lost may be so by effects that stand in for a disturbance: it goes on to drop them.
    if !disturbance.is_disturbed() && excess(found) <= LOST {
        return Ok(None);
    }
    let mut other = found.clone();
    refitted(&problem, &mut other.after, &found.expected, &disturbance)?;
    if noise && !none {
        eliminate(&problem, &mut other)?;
        if other.rounds.len() == found.rounds.len() {
            return Ok(None);
        }
    }
    let Stage { fit, origin } = &found.before;
    other.before = begun(&problem, origin, fit, &found.expected)?;
    if !other.before.fit.noise.is_disturbed() && excess(found) <= LOST {
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

/// What was found beside a disturbance, refitted without one, where `found` is lost and this makes the log likelier
/// than it: a disturbance state shows structure, but takes a part of slow laws with it.
///
/// # Errors
/// A model cannot be built.
pub(super) fn without_disturbance(
    problem: Problem<'_>,
    found: &Search,
    beside: &Search,
) -> Result<Option<Search>, BuildError> {
    let names = |search: &Search| search.rounds.iter().map(|round| round.name).collect::<Vec<_>>();
    if excess(found) <= LOST || names(beside) == names(found) || interrupt::asked() {
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
pub(super) fn stands(
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
    let torques = of_push(&pushed(problem, &fit.model, expected, walk)?);
    let fitted = torques.iter().zip(problem.mask).filter(|(_, weight)| **weight > 0.0);
    let (sum, count) =
        fitted.fold((0.0, 0.0), |(sum, count), (torque, _)| (sum + torque * torque, count + 1.0));
    Ok(f64::sqrt(sum / f64::max(count, 1.0)))
}

/// Adds effects until no more is found, and tries to do without each.
fn grow(problem: &Problem<'_>, search: &mut Search) -> Result<(), BuildError> {
    let expected = search.expected;
    // One place is kept for what has no name.
    let full = |search: &Search| search.after.origin.effects.len() + 2 >= MAX_EFFECTS;
    while search.rounds.len() < MOST_EFFECTS && !full(search) && !interrupt::asked() {
        let round = search.rounds.len() + 1;
        search.tell(round, "scoring the known effects beside a disturbance");
        if !add(problem, search, round)? {
            break;
        }
        let last = search.rounds.len() - 1;
        ask_order(problem.rough(), search, last)?;
        recoloured(problem, &mut search.after, &expected)?;
    }
    search.bar.set_message("asking whether each effect is needed beside a disturbance");
    eliminate(problem, search)
}

/// The nominal refitted beside a coloured disturbance: from its plain refit and from where it was, since the
/// plain one is bent by what is missing.
fn begun(
    problem: &Problem<'_>,
    nominal: &Model,
    fit: &Fit,
    expected: &Noise,
) -> Result<Stage, BuildError> {
    let coordinates = &fit.coordinates;
    let fits = [&fit.model, nominal].into_par_iter().map(|start| {
        let noise = coloured(problem, start, expected, &fit.noise)?;
        let near = polish(problem, nominal, start, coordinates, expected, &noise)?;
        let noise = coloured(problem, &near.model, expected, &near.noise)?;
        polish(problem, nominal, &near.model, coordinates, expected, &noise)
    });
    let fits = fits.collect::<Result<Vec<_>, BuildError>>()?;
    let likelier = |a: Fit, b: Fit| if cost(&b) < cost(&a) { b } else { a };
    Ok(Stage { fit: fits.into_iter().fold(fit.clone(), likelier), origin: nominal.clone() })
}

/// Asks for the disturbance again, and refits beside it where it has changed.
fn recoloured(
    problem: &Problem<'_>,
    stage: &mut Stage,
    expected: &Noise,
) -> Result<(), BuildError> {
    let fit = &stage.fit;
    let noise = coloured(problem, &fit.model, expected, &fit.noise)?;
    refitted(problem, stage, expected, &noise)
}

/// Refits at a noise, where that makes the log likelier.
fn refitted(
    problem: &Problem<'_>,
    stage: &mut Stage,
    expected: &Noise,
    noise: &Noise,
) -> Result<(), BuildError> {
    let Stage { fit, origin } = &*stage;
    let again = polish(problem, origin, &fit.model, &fit.coordinates, expected, noise)?;
    if cost(&again) < cost(fit) {
        stage.fit = again;
    }
    Ok(())
}

/// Adds the effect that explains most of what is left, if one explains more than chance.
fn add(problem: &Problem<'_>, search: &mut Search, round: usize) -> Result<bool, BuildError> {
    let rough = problem.rough();
    let base = search.after.clone();
    let Some(test) = ScoreTest::new(rough, &base.origin, &base.fit, REPLICATES) else {
        return Ok(false);
    };
    let scene = Scene::new(&base.fit.model, problem.record, &test);
    let hypotheses = candidates::proposed(&scene, &search.withdrawn);
    let ranked = test.ranked(&hypotheses);
    let listed = candidates::listed(&scene);
    let orders = listed.iter().map(|line| line.start.values[0]);
    let lines: Vec<(f64, Gain)> = orders.zip(test.gains(&listed)).collect();
    let gains = ranked.iter().map(|(_, gain)| gain).chain(lines.iter().map(|(_, gain)| gain));
    let by_chance = threshold(gains);
    let tried = ranked.len() + lines.len();
    if round == 1 {
        let best = ranked.first().map_or(0.0, |(_, gain)| gain.real.max(0.0));
        search.orders = told(&lines, best, by_chance);
    }
    search.chance.push(by_chance);
    let best_of_name = first_of_each(ranked, |(hypothesis, _)| hypothesis.name());
    for (hypothesis, gain) in &best_of_name {
        let name = title(hypothesis.name());
        search.scores.push(ScoreRow { round, name, score: gain.real, refitted: None });
    }
    let promising: Vec<(&Hypothesis, &Gain)> = best_of_name
        .iter()
        .filter(|(_, gain)| gain.real > bound(gain.free, tried, 0.5 * by_chance))
        .map(|(hypothesis, gain)| (*hypothesis, gain))
        .take(SHORT)
        .collect();
    let short = promising.par_iter().map(|(hypothesis, _)| {
        let (origin, coordinates) = base.widened(hypothesis);
        let start = hypothesis.added(&base.fit.model);
        let (near, noise) = (Some(test.jacobian()), &base.fit.noise);
        let known = Known { near, along: &mut Cow::Owned(Linearisation::default()) };
        let fit = rough.fit_from(known, &origin, &start, &coordinates, noise, ROUNDS)?;
        Ok((*hypothesis, Stage { fit, origin }))
    });
    let mut short = run_through(short);
    short.sort_by(|a, b| cost(&a.1.fit).total_cmp(&cost(&b.1.fit)));
    let expected = search.expected;
    let full = short.into_par_iter().take(FULL).map(|(hypothesis, Stage { fit, origin })| {
        let Fit { model, coordinates, noise, .. } = fit;
        let fit = polish(&rough, &origin, &model, &coordinates, &expected, &noise)?;
        Ok((hypothesis, Stage { fit, origin }))
    });
    // The base gets the same last refinement as its challengers have.
    let plain = || {
        let Fit { model, coordinates, noise, .. } = &base.fit;
        polish(&rough, &base.origin, model, coordinates, &expected, noise)
    };
    let (mut full, plain) = rayon::join(|| run_through(full), plain);
    let plain = plain?;
    let plain = if cost(&plain) < cost(&base.fit) { plain } else { base.fit.clone() };
    full.retain(|(_, stage)| search.believes(&stage.fit.model, problem.record));
    full.sort_by(|a, b| cost(&a.1.fit).total_cmp(&cost(&b.1.fit)));
    // A challenger may have led the rest to a better fit: then the base gets that one.
    let plain = match full.first() {
        Some((_, won)) => {
            let start = without(&won.fit.model, base.fit.model.effects.len());
            let (moved, noise) = (&base.fit.coordinates, &won.fit.noise);
            let far = |fit: &Fit| cost(fit) > cost(&plain);
            let again =
                refit::polish_unless(far, &rough, &base.origin, &start, moved, &expected, noise)?;
            if cost(&again) < cost(&plain) { again } else { plain }
        }
        None => plain,
    };
    let contenders: Vec<Contender> = full
        .iter()
        .map(|(h, stage)| Contender { name: h.name(), gain: cost(&plain) - cost(&stage.fit) })
        .collect();
    for contender in &contenders {
        let name = title(contender.name);
        let row = search.scores.iter_mut().find(|row| row.round == round && row.name == name);
        if let Some(row) = row {
            row.refitted = Some(contender.gain);
        }
    }
    let plain = Stage { fit: plain, origin: base.origin.clone() };
    let Some((winner, rivals)) = contenders.split_first() else {
        search.after = plain;
        return Ok(false);
    };
    let free = full[0].0.coordinates(0).len();
    if winner.gain.is_nan() || winner.gain < bound(free, tried, by_chance) {
        search.after = plain;
        return Ok(false);
    }
    let mut stages = full.into_iter().map(|(_, stage)| stage);
    let Some(won) = stages.next() else { return Ok(false) };
    let runner_up = stages.next();
    let others: Vec<&Fit> = runner_up.iter().map(|stage| &stage.fit).chain([&plain.fit]).collect();
    let stays_ahead = stays_ahead(&won.fit, &others, problem.mask);
    search.rounds.push(Round {
        name: winner.name,
        gain: winner.gain,
        rivals: rivals.to_vec(),
        runner_up,
        stays_ahead,
    });
    search.after = won;
    Ok(true)
}

/// What an effect of so many free values must gain where so many hypotheses were tried.
fn bound(free: usize, tried: usize, by_chance: f64) -> f64 {
    let level = 1.0 - LEVEL / tried.max(1) as f64;
    let chance = ChiSquared::new(free.max(1) as f64).map_or(0.0, |law| law.inverse_cdf(level));
    by_chance.max(chance)
}

/// Drops every effect whose loss costs no more than chance, the cheapest first.
fn eliminate(problem: &Problem<'_>, search: &mut Search) -> Result<(), BuildError> {
    let by_chance = search.chance.last().copied().unwrap_or(0.0);
    while !search.rounds.is_empty() && !interrupt::asked() {
        let without = (0..search.rounds.len())
            .into_par_iter()
            .map(|k| bare(problem.rough(), search, k))
            .collect::<Result<Vec<_>, BuildError>>()?;
        let kept = cost(&search.after.fit);
        let cheapest = without
            .into_iter()
            .enumerate()
            .min_by(|a, b| cost(&a.1.fit).total_cmp(&cost(&b.1.fit)));
        let Some((k, stage)) = cheapest else { break };
        let loss = cost(&stage.fit) - kept;
        if loss >= bound(2, 100, by_chance) || search.measured.contains(&search.rounds[k].name) {
            break;
        }
        search.after = stage;
        search.rounds.remove(k);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use joint_core::effect::{EffectParameters, Kind};
    use joint_core::params::Location;

    use super::super::candidates::cogging;
    use super::super::hypothesis::Free;
    use super::super::trial;
    use super::*;
    use crate::estimate::filter::{Colour, Disturbed};
    use crate::estimate::noise;
    use crate::estimate::record::Record;
    use crate::estimate::replicate::replicate;

    #[test]
    fn beside_a_disturbance_what_it_imitated_falls_and_what_is_there_stays() {
        let nominal = trial::motor();
        // A fifth of the line that the trials have: the nominal is not lost without it.
        let line = trial::line(12.0).with("amplitude_nm", 0.004);
        let clean = Record::new(&trial::log(&nominal, line, 4.0), None);
        let mask = vec![1.0; clean.measured.len()];
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
        let mask = vec![1.0; record.measured.len()];
        let problem = Problem::new(&record, &mask).rough();
        let expected = noise::expected(&nominal, &record);
        let mut found = Search::new(trial::fitted(&problem, &nominal, &[]), &[], expected);
        let drag = EffectParameters::new(Kind::QuadraticDrag, Location::Motor);
        let free = vec![Free::Value { value: 0, scale: 1e-6, sigma: 30.0 }];
        found.after = trial::fitted(&problem, &nominal, &[Hypothesis { start: drag, free }]);
        let name = (drag.kind, drag.location);
        found.rounds.push(Round { name, ..trial::round(100.0) });
        assert!(excess(&found) > LOST, "{}", excess(&found));
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
