//! Finding an effect so large that the nominal cannot be refitted around it.
//!
//! Where what is missing is many times the noise, a refit of the plain model bends every parameter
//! to explain it, and no linear step from there can be believed. So the equation that disagrees
//! most is given a push that wanders along with the refit: the push takes what the equation
//! misses, and the parameters stay where they belong. Hypotheses are scored and first fitted beside
//! the push, and only then have to do without it.

use std::borrow::Cow;

use rayon::prelude::*;

use super::bootstrap::stays_ahead;
use super::borne_out::{holds, owed_to_the_rest};
use super::candidates::{self, Scene};
use super::chance::threshold;
use super::comb::{self, comb};
use super::findings::ScoreRow;
use super::followed::{Followed, followed};
use super::hypothesis::{Hypothesis, first_of_each, run_through};
use super::score_test::{Gain, ScoreTest};
use super::search::{
    Contender, LEAST_GAIN, MOST_EFFECTS, Round, Search, Stage, WORTH_ANOTHER, add_settled, bared,
    calm, title,
};
use super::whereabouts::disagreeing;
use crate::estimate::filter::{Linearisation, Noise};
use crate::estimate::fit::{Fit, Known, Problem};
use crate::estimate::refit::{self, cost};
use crate::plant::BuildError;

/// How much less than expected the model is trusted beside the push.
const DISTRUST: f64 = 2.0;
/// Share of the best gain beside the push from which on a name has to do without it.
const RIVALLING: f64 = 0.2;
/// What a base costs that is no number.
const BEYOND: f64 = 1e12;
/// Names that are refitted until they gain nothing more, where none leaves only noise.
const CONVERGED: usize = 3;
/// Hypotheses that are fitted beside the push.
const FITTED: usize = 5;
/// Names that the push follows which are fitted as large as it says.
const FOLLOWED: usize = 3;

/// Adds the effect that explains most beside a push, if it holds without it.
///
/// # Errors
/// The model cannot be built.
pub fn add_protected(
    problem: Problem<'_>,
    search: &mut Search,
    round: usize,
) -> Result<bool, BuildError> {
    let base = search.after.clone();
    let expected = search.expected;
    let wary = Noise { sensors: base.fit.noise.sensors, ..expected.distrusted(DISTRUST) };
    let ahead = problem.ahead();
    let pushes = disagreeing(&ahead, &base, &wary, true)?;
    let Some((walk, protected)) = pushes.first().map(|(walk, fit)| (*walk, fit)) else {
        return Ok(false);
    };
    let beside = ahead.pushed(walk);
    let Some(test) = ScoreTest::new(beside, &base.origin, protected, 3) else {
        return Ok(false);
    };
    let scene = Scene::new(&protected.model, ahead.record, &test);
    let hypotheses: Vec<Hypothesis> = candidates::proposed(&scene, &search.withdrawn);
    let mut ranked = test.ranked(&hypotheses);
    let least = threshold(ranked.iter().map(|(_, gain)| gain)).max(LEAST_GAIN);
    ranked.retain(|(_, gain)| gain.real > least);
    let mut promising = first_of_each(ranked, |(hypothesis, _)| hypothesis.name());
    promising.truncate(FITTED);
    let beside_push = |(hypothesis, score): (&Hypothesis, Gain)| {
        let (origin, coordinates) = base.widened(hypothesis);
        let start = hypothesis.added(&protected.model);
        let near = Some(test.jacobian());
        let known = Known { near, along: &mut Cow::Owned(Linearisation::default()) };
        let fit = beside.fit_from(known, &origin, &start, &coordinates, &wary, 5)?;
        let gain = cost(protected) - cost(&fit);
        Ok((hypothesis.name(), score.real, gain, Stage { fit, origin }))
    };
    let mut fitted = run_through(promising.into_par_iter().map(beside_push));
    let strongest = fitted.iter().map(|(.., gain, _)| *gain).fold(0.0, f64::max);
    fitted.retain(|(.., gain, _)| *gain >= RIVALLING * strongest);
    let alone = |(name, score, _, Stage { fit, origin }): (_, _, _, Stage)| {
        let (model, moved) = (&fit.model, &fit.coordinates);
        let fit = refit::polish(&problem, &origin, model, moved, &expected, &wary)?;
        Ok((name, score, Stage { fit, origin }))
    };
    for Followed { hypothesis, start, beside, .. } in
        followed(&ahead, &pushes, &wary, &hypotheses)?.into_iter().take(FOLLOWED)
    {
        let name = hypothesis.name();
        if fitted.iter().any(|(known, ..)| *known == name) {
            continue;
        }
        let (origin, coordinates) = base.widened(hypothesis);
        let fit = Fit { model: start, coordinates, ..beside.clone() };
        fitted.push((name, 0.0, 0.0, Stage { fit, origin }));
    }
    let alone = run_through(fitted.into_par_iter().map(alone));
    let mut tried: Vec<(Contender, Stage)> = Vec::new();
    for (name, score, stage) in alone {
        let gain = search
            .believes(&stage.fit.model, problem.record)
            .then(|| gained(&base.fit, &stage.fit));
        search.scores.push(ScoreRow { round, name: title(name), score, refitted: gain });
        tried.extend(gain.map(|gain| (Contender { name, gain }, stage)));
    }
    tried.sort_by(|a, b| promise(b, &expected).total_cmp(&promise(a, &expected)));
    let tried = converged(&problem, &base, tried, &expected)?;
    let alone = tried.first().map_or(0.0, |(winner, _)| winner.gain.max(0.0));
    let explained = tried.first().is_some_and(|(_, stage)| calm(&stage.fit.noise, &expected));
    if !explained && !search.withdrawn.contains(&comb::NAME.0) {
        let left = MOST_EFFECTS - search.rounds.len();
        let lines = pushes.iter().find(|(walk, _)| !walk.equation.is_of_a_sensor());
        let lines = lines.map_or((walk, protected), |(walk, fit)| (*walk, fit));
        let found = comb(&problem, &base, lines, [&expected, &wary], left, &search.withdrawn)?;
        if let Some(stage) = found {
            let lines = stage.origin.effects.len() - base.origin.effects.len();
            let gain = cost(&base.fit) - cost(&stage.fit);
            if gain > alone + LEAST_GAIN * lines as f64 {
                let names = stage.origin.effects.iter().skip(base.origin.effects.len());
                let names: Vec<_> = names.map(|line| (line.kind, line.location)).collect();
                let rivals = tried.into_iter().map(|(contender, _)| contender);
                let rivals: Vec<_> = rivals.filter(|rival| !names.contains(&rival.name)).collect();
                let stays_ahead = stays_ahead(&stage.fit, &[&base.fit], problem.mask);
                search.rounds.extend(names.into_iter().map(|name| Round {
                    name,
                    gain: gain / lines as f64,
                    rivals: rivals.clone(),
                    runner_up: None,
                    stays_ahead,
                }));
                search.after = stage;
                return Ok(true);
            }
        }
    }
    conclude(problem, search, round, tried)
}

/// Adds the best of the names that were tried, if it holds and is not owed to a better fit of the rest; what
/// refitting on has driven to where no joint is believed is none of them.
///
/// # Errors
/// The model cannot be built.
pub(super) fn conclude(
    problem: Problem<'_>,
    search: &mut Search,
    round: usize,
    mut tried: Vec<(Contender, Stage)>,
) -> Result<bool, BuildError> {
    let base = search.after.clone();
    let expected = search.expected;
    tried.retain(|(_, stage)| search.believes(&stage.fit.model, problem.record));
    let mut tried = tried.into_iter();
    let Some((winner, stage)) = tried.next() else { return Ok(false) };
    let least = search.least_gain(winner.name.1);
    if winner.gain < least {
        return Ok(false);
    }
    let weak = search.weak_gain(winner.name.1);
    if winner.gain < weak && !holds(problem, &base.fit, &stage.fit, &expected)? {
        search.hope(winner, stage);
        return Ok(false);
    }
    let plain = bared(&problem, &base, &stage, least, &expected)?;
    let owed = gained(&base.fit, &plain.fit).max(0.0);
    if owed > 0.0 && search.rounds.is_empty() {
        search.before = plain.clone();
    }
    let own = winner.gain - owed;
    let gains = [winner.gain, own, weak];
    if own < least || owed_to_the_rest(problem, &plain.fit, &stage.fit, gains, &expected)? {
        search.after = plain;
        return if owed < WORTH_ANOTHER { Ok(false) } else { add_settled(problem, search, round) };
    }
    let less = |contender: Contender| Contender { gain: contender.gain - owed, ..contender };
    let (rivals, mut beaten): (Vec<_>, Vec<_>) =
        tried.map(|(rival, stage)| (less(rival), stage)).unzip();
    let runner_up = (!beaten.is_empty()).then(|| beaten.swap_remove(0));
    let others: Vec<&Fit> = runner_up.iter().map(|stage| &stage.fit).chain([&plain.fit]).collect();
    let stays_ahead = stays_ahead(&stage.fit, &others, problem.mask);
    let name = winner.name;
    search.rounds.push(Round { name, gain: own, rivals, runner_up, stays_ahead });
    search.after = stage;
    Ok(true)
}

/// What a fit gains over a base that may be beyond all numbers.
pub(super) fn gained(base: &Fit, fit: &Fit) -> f64 {
    let gain = cost(base).min(BEYOND) - cost(fit);
    if gain.is_nan() { f64::NEG_INFINITY } else { gain }
}

/// What a name promises: what it has gained, or where it is still far from a fit how little noise it
/// asks for.
fn promise((contender, stage): &(Contender, Stage), expected: &Noise) -> f64 {
    let gain = contender.gain;
    if gain.is_finite() && gain > 0.0 { gain } else { -stage.fit.noise.times(expected) }
}

/// The names refitted until they gain nothing more, the best first: beside a push a name may have
/// looked better than it holds without. One that leaves nothing to explain ends this.
fn converged(
    problem: &Problem<'_>,
    base: &Stage,
    tried: Vec<(Contender, Stage)>,
    expected: &Noise,
) -> Result<Vec<(Contender, Stage)>, BuildError> {
    let mut done: Vec<(Contender, Stage)> = Vec::new();
    let mut explained = false;
    for (contender, Stage { fit, origin }) in tried {
        if explained || done.len() == CONVERGED {
            done.push((contender, Stage { fit, origin }));
            continue;
        }
        let fit = refit::converge(problem, &origin, fit, expected)?;
        explained = calm(&fit.noise, expected);
        let gain = gained(&base.fit, &fit);
        done.push((Contender { gain, ..contender }, Stage { fit, origin }));
    }
    done.sort_by(|a, b| promise(b, expected).total_cmp(&promise(a, expected)));
    Ok(done)
}
