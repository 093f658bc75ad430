//! Finding what is missing from a nominal that cannot be refitted around it: with little trust first.
//!
//! A filter that trusts its model little takes every sample on its own: what is missing shows as what
//! one interval adds, parameters need not bend to explain it, and a linear step can be believed. So
//! hypotheses are scored and fitted from the nominal with little trust first; then trust grows, and
//! the field narrows.

use std::borrow::Cow;

use rayon::prelude::*;

use super::candidates::{self, Scene};
use super::findings::ScoreRow;
use super::gate::rms;
use super::hypothesis::{Hypothesis, first_of_each, run_through};
use super::protected::{conclude, gained};
use super::score_test::ScoreTest;
use super::search::{Contender, FAR_BEHIND, LEAST_GAIN, LOST, Search, Stage, WEAK, title};
use super::ways::is_hopeless;
use crate::estimate::filter::Linearisation;
use crate::estimate::fit::{Fit, Known, Problem};
use crate::estimate::refit::{self, DOUBTFUL, RUGGED, cost};
use crate::model::Model;
use crate::plant::BuildError;

/// How far a model is trusted, and what is asked of the names there.
struct Trust {
    /// Times the expected noise.
    noise: f64,
    /// Names that get as far.
    names: usize,
    /// Most rounds of their fits.
    rounds: usize,
    /// How far behind one that leaves nothing but noise they are given up.
    behind: f64,
}

const TRUST: [Trust; 3] = [
    Trust { noise: 30.0, names: 10, rounds: 4, behind: 10.0 * FAR_BEHIND },
    Trust { noise: 10.0, names: 4, rounds: 4, behind: FAR_BEHIND },
    Trust { noise: 3.0, names: 3, rounds: 6, behind: FAR_BEHIND },
];
/// Most that errors are of the noise of a trust where they are nothing else, as RMS.
const NOISE: f64 = 1.05;
/// Most that they are in the end where a name beside others explains what is left.
const COMPANY: f64 = 1.3;
/// Share of the best score from which on a name is fitted.
const SHARE: f64 = 0.003;
/// Share of the best gain from which on a name is refitted until it gains nothing more.
const NEAR: f64 = 0.9;
/// Share of the way from the best to the worst within which a name comes near.
const WITHIN: f64 = 0.5;
/// Replicates that tell what a hypothesis explains by luck.
const REPLICATES: u64 = 3;

/// A name on its way: its hypothesis, its score, where it is fitted from and the test that gave it.
struct Entry<'a> {
    hypothesis: &'a Hypothesis,
    score: f64,
    model: Model,
    test: usize,
}

/// Adds the name that explains most when trust in the model grows step by step, if it holds.
///
/// # Errors
/// The model cannot be built.
pub(super) fn add_annealed(
    problem: Problem<'_>,
    search: &mut Search,
    round: usize,
) -> Result<bool, BuildError> {
    let base = search.after.clone();
    let expected = search.expected;
    let ahead = problem.ahead();
    let [Trust { noise: first, rounds, .. }, .., Trust { noise: last, .. }] = TRUST;
    let anew = Model { effects: base.fit.model.effects.clone(), ..base.origin.clone() };
    let from = |rounds: usize| {
        let (moved, noise) = (&base.fit.coordinates, expected.distrusted(first));
        ahead.fit(&base.origin, &anew, moved, &noise, rounds)
    };
    // A refit bends to a gap or a knee even with little trust; the nominal may be far off.
    let (bent, nominal) = rayon::join(|| from(rounds), || from(0));
    let starts = [bent?, nominal?];
    let tests: Vec<ScoreTest<'_>> = starts
        .par_iter()
        .filter_map(|start| ScoreTest::new(ahead, &base.origin, start, REPLICATES))
        .collect();
    if tests.len() < starts.len() {
        return Ok(false);
    }
    let proposed: Vec<Vec<Hypothesis>> = tests
        .par_iter()
        .zip(&starts)
        .map(|(test, start)| {
            let scene = Scene::new(&start.model, ahead.record, test);
            candidates::proposed(&scene, &search.withdrawn)
        })
        .collect();
    let mut field = field(&tests, &starts, &proposed);
    let mut scored: Vec<_> = field.iter().map(|e| (e.hypothesis.name(), e.score)).collect();
    scored.sort_by(|a, b| b.1.total_cmp(&a.1));
    let scored = first_of_each(scored, |(name, _)| *name);
    let (mut near, mut least_left) = (0, f64::INFINITY);
    for Trust { noise: distrust, names, rounds, behind } in TRUST {
        field.truncate(names);
        let fitted = field.into_par_iter().map(|entry| {
            let (origin, moved) = base.widened(entry.hypothesis);
            let near = (distrust == first).then(|| tests[entry.test].jacobian());
            let known = Known { near, along: &mut Cow::Owned(Linearisation::default()) };
            let noise = expected.distrusted(distrust);
            let passing = problem.passing();
            let fit = passing.fit_from(known, &origin, &entry.model, &moved, &noise, rounds)?;
            let left = rms(&fit.innovations, ahead.mask, None);
            Ok((cost(&fit), left, Entry { model: fit.model, ..entry }))
        });
        let mut fitted = run_through(fitted);
        fitted.sort_by(|a, b| a.0.total_cmp(&b.0));
        fitted = first_of_each(fitted, |(.., entry)| entry.hypothesis.name());
        if let Some((best, left, _)) = fitted.first()
            && *left < NOISE
        {
            let most = best + behind;
            fitted.retain(|(cost, ..)| *cost < most);
        }
        least_left = fitted.iter().map(|(_, left, _)| *left).fold(f64::INFINITY, f64::min);
        near = in_reach(&fitted.iter().map(|(cost, ..)| *cost).collect::<Vec<_>>());
        field = fitted.into_iter().map(|(.., entry)| entry).collect();
    }
    // Beside names that explain nothing one has to explain what is left.
    if least_left > COMPANY && is_hopeless(search) {
        return Ok(false);
    }
    let noise = expected.distrusted(last);
    let polished = |Entry { hypothesis, score, model, .. }: Entry<'_>| {
        let (origin, moved) = base.widened(hypothesis);
        let fit = refit::polish(&problem, &origin, &model, &moved, &expected, &noise)?;
        Ok((hypothesis.name(), score, Stage { fit, origin }))
    };
    let far = field.split_off(near.min(field.len()));
    let mut stages = run_through(field.into_par_iter().map(polished));
    // Where the best leaves only noise, what is far behind it at little trust is no rival.
    let explains = |stage: &Stage| stage.fit.noise.times(&expected) < DOUBTFUL;
    if !stages.iter().any(|(.., stage)| explains(stage)) {
        stages.extend(run_through(far.into_par_iter().map(polished)));
    }
    let mut tried = Vec::new();
    for (name, score, stage) in stages {
        let believed = search.believes(&stage.fit.model, problem.record);
        let gain = believed.then(|| gained(&base.fit, &stage.fit));
        search.scores.push(ScoreRow { round, name: title(name), score, refitted: gain });
        tried.extend(gain.map(|gain| (Contender { name, gain }, stage)));
    }
    for (name, score) in scored {
        let row = ScoreRow { round, name: title(name), score, refitted: None };
        if !search.scores.iter().any(|known| known.round == round && known.name == row.name) {
            search.scores.push(row);
        }
    }
    let best = tried.iter().map(|(contender, _)| contender.gain).fold(0.0, f64::max);
    // What is near the best is compared where each gains nothing more; of a base beyond all numbers
    // everything takes nearly all.
    let least = best - ((1.0 - NEAR) * best).min(FAR_BEHIND);
    let near = |(contender, _): &(Contender, Stage)| contender.gain >= least;
    let alone = tried.iter().filter(|tried| near(tried)).count() == 1;
    let settled =
        |(contender, stage): &(Contender, Stage)| contender.gain > WEAK && explains(stage);
    // One that leaves only noise and has no rival is polished in the end.
    if !(alone && tried.iter().filter(|tried| near(tried)).all(settled)) {
        let near = tried.par_iter_mut().filter(|tried| near(tried));
        near.try_for_each(|(contender, stage)| {
            let fit = stage.fit.clone();
            stage.fit = refit::polish_on(&problem, &stage.origin, fit, &expected)?;
            contender.gain = gained(&base.fit, &stage.fit);
            Ok::<(), BuildError>(())
        })?;
    }
    tried.sort_by(|a, b| b.0.gain.total_cmp(&a.0.gain));
    // The right name may stand in a hollow that the nominal's refit has led to, and leave as much noise.
    if let Some((contender, stage)) = tried.first_mut()
        && stage.origin.stages.len() >= RUGGED
        && contender.gain > WEAK
        && stage.fit.noise.times(&expected) > LOST
    {
        let again = refit::cooled(&problem, &stage.origin, &stage.fit, &expected)?;
        if cost(&again) < cost(&stage.fit) {
            contender.gain = gained(&base.fit, &again);
            stage.fit = again;
        }
    }
    conclude(problem, search, round, tried)
}

/// The names worth fitting, the best of every start by turns.
fn field<'h>(
    tests: &[ScoreTest<'_>],
    starts: &[Fit],
    proposed: &'h [Vec<Hypothesis>],
) -> Vec<Entry<'h>> {
    let mut rankings: Vec<_> = tests
        .iter()
        .zip(proposed)
        .map(|(test, hypotheses)| worth_fitting(test, hypotheses).into_iter())
        .collect();
    let mut field = Vec::new();
    while rankings.iter().any(|ranked| ranked.len() > 0) {
        for (test, ranked) in rankings.iter_mut().enumerate() {
            field.extend(ranked.next().map(|(hypothesis, score)| {
                let model = hypothesis.added(&starts[test].model);
                Entry { hypothesis, score, model, test }
            }));
        }
    }
    field
}

/// How many of a field, by what each costs, the best first, come near: those that are no farther from the
/// best than half the worst.
fn in_reach(costs: &[f64]) -> usize {
    let [best, .., worst] = costs else { return costs.len() };
    let most = best + (WITHIN * (worst - best)).max(WEAK);
    costs.iter().filter(|cost| **cost < most).count().max(1)
}

/// The hypotheses that explain more than they would of any record, one for each name, best first.
fn worth_fitting<'a>(
    test: &ScoreTest<'_>,
    hypotheses: &'a [Hypothesis],
) -> Vec<(&'a Hypothesis, f64)> {
    let mut ranked = test.ranked(hypotheses);
    ranked.retain(|(_, gain)| gain.real > LEAST_GAIN * gain.luck());
    let least = SHARE * ranked.first().map_or(0.0, |(_, best)| best.real);
    ranked.retain(|(_, gain)| gain.real > least);
    let best = first_of_each(ranked, |(hypothesis, _)| hypothesis.name());
    best.into_iter().map(|(hypothesis, gain)| (hypothesis, gain.real)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_comes_near_is_the_best_and_what_is_half_as_far_as_the_worst() {
        assert_eq!(in_reach(&[-9e3, -4e3, -3e3, 0.0]), 1);
        assert_eq!(in_reach(&[-9e3, -8e3, -7e3, 0.0]), 3);
        assert_eq!(in_reach(&[-9e3, -8.9e3, -8.8e3, -8.75e3]), 4);
        assert_eq!(in_reach(&[-9e3, -8e3, f64::NAN]), 1);
        assert_eq!(in_reach(&[-9e3]), 1);
    }
}
