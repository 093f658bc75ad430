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
use super::hypothesis::{Hypothesis, first_of_each, run_through};
use super::protected::{conclude, gained};
use super::score_test::{Gain, ScoreTest};
use super::search::{Contender, LEAST_GAIN, Search, Stage, title};
use crate::estimate::filter::Linearisation;
use crate::estimate::fit::{Known, Problem};
use crate::estimate::refit::{self, cost};
use crate::model::Model;
use crate::plant::BuildError;

/// Times the expected noise by which the model is distrusted, names that get as far, and most rounds of
/// their fits.
const TRUST: [(f64, usize, usize); 3] = [(30.0, 10, 4), (10.0, 4, 4), (3.0, 3, 6)];
/// Share of the best score from which on a name is fitted.
const SHARE: f64 = 0.003;
/// Share of the best gain from which on a name is refitted until it gains nothing more.
const NEAR: f64 = 0.9;
/// Twins that tell what a hypothesis explains by luck.
const TWINS: u64 = 3;

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
    let [(first, _, rounds), .., (last, ..)] = TRUST;
    let anew = Model { effects: base.fit.model.effects.clone(), ..base.origin.clone() };
    let from = |rounds: usize| {
        let (moved, noise) = (&base.fit.coordinates, expected.distrusted(first));
        problem.fit(&base.origin, &anew, moved, &noise, rounds)
    };
    // A refit bends to a gap or a knee even with little trust; the nominal may be far off.
    let (bent, nominal) = rayon::join(|| from(rounds), || from(0));
    let starts = [bent?, nominal?];
    let tests: Vec<ScoreTest<'_>> = starts
        .par_iter()
        .filter_map(|start| ScoreTest::new(problem, &base.origin, start, TWINS))
        .collect();
    if tests.len() < starts.len() {
        return Ok(false);
    }
    let proposed: Vec<Vec<Hypothesis>> = tests
        .par_iter()
        .zip(&starts)
        .map(|(test, start)| {
            let scene = Scene::new(&start.model, problem.record, test);
            candidates::proposed(&scene, &search.withdrawn)
        })
        .collect();
    let mut rankings: Vec<_> = tests
        .iter()
        .zip(&proposed)
        .map(|(test, hypotheses)| ranked(test, hypotheses).into_iter())
        .collect();
    let mut field: Vec<Entry<'_>> = Vec::new();
    while rankings.iter().any(|ranked| ranked.len() > 0) {
        for (test, ranked) in rankings.iter_mut().enumerate() {
            field.extend(ranked.next().map(|(hypothesis, score)| {
                let model = hypothesis.added(&starts[test].model);
                Entry { hypothesis, score, model, test }
            }));
        }
    }
    for (distrust, most, rounds) in TRUST {
        field.truncate(most);
        let fitted = field.into_par_iter().map(|entry| {
            let (origin, moved) = base.widened(entry.hypothesis);
            let near = (distrust == first).then(|| tests[entry.test].jacobian());
            let known = Known { near, along: &mut Cow::Owned(Linearisation::default()) };
            let noise = expected.distrusted(distrust);
            let fit = problem.fit_from(known, &origin, &entry.model, &moved, &noise, rounds)?;
            Ok((cost(&fit), Entry { model: fit.model, ..entry }))
        });
        let mut fitted = run_through(fitted);
        fitted.sort_by(|a, b| a.0.total_cmp(&b.0));
        field = fitted.into_iter().map(|(_, entry)| entry).collect();
        field = first_of_each(field, |entry| entry.hypothesis.name());
    }
    let noise = expected.distrusted(last);
    let stages = field.into_par_iter().map(|Entry { hypothesis, score, model, .. }| {
        let (origin, moved) = base.widened(hypothesis);
        let fit = refit::polish(&problem, &origin, &model, &moved, &expected, &noise)?;
        Ok((hypothesis.name(), score, Stage { fit, origin }))
    });
    let mut tried = Vec::new();
    for (name, score, stage) in run_through(stages) {
        let believed = search.believes(&stage.fit.model, problem.record);
        let gain = believed.then(|| gained(&base.fit, &stage.fit));
        search.scores.push(ScoreRow { round, name: title(name), score, refitted: gain });
        tried.extend(gain.map(|gain| (Contender { name, gain }, stage)));
    }
    let best = tried.iter().map(|(contender, _)| contender.gain).fold(0.0, f64::max);
    for (contender, stage) in &mut tried {
        // What is near the best is compared where each gains nothing more.
        if contender.gain >= NEAR * best {
            let fit = stage.fit.clone();
            stage.fit = refit::polish_on(&problem, &stage.origin, fit, &expected)?;
            contender.gain = gained(&base.fit, &stage.fit);
        }
    }
    tried.sort_by(|a, b| b.0.gain.total_cmp(&a.0.gain));
    conclude(problem, search, round, tried)
}

/// The hypotheses that explain more than they would of any record, one for each name, best first.
fn ranked<'a>(test: &ScoreTest<'_>, hypotheses: &'a [Hypothesis]) -> Vec<(&'a Hypothesis, f64)> {
    let gains: Vec<Gain> = hypotheses.par_iter().map(|h| test.gain(h)).collect();
    let mut ranked: Vec<(&Hypothesis, f64)> = hypotheses
        .iter()
        .zip(&gains)
        .filter(|(_, gain)| gain.real > LEAST_GAIN * gain.luck())
        .map(|(hypothesis, gain)| (hypothesis, gain.real))
        .collect();
    ranked.sort_by(|a, b| b.1.total_cmp(&a.1));
    let least = SHARE * ranked.first().map_or(0.0, |(_, best)| *best);
    ranked.retain(|(_, score)| *score > least);
    first_of_each(ranked, |(hypothesis, _)| hypothesis.name())
}
