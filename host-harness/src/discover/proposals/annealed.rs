//! Finding what is missing from a nominal that cannot be refitted around it: at inflated process noise first.
//!
//! A filter that trusts its model little takes every sample on its own: what is missing shows as what
//! one interval adds, parameters need not be biased to explain it, and a linear step can be believed. So
//! hypotheses are scored and fitted from the nominal at inflated process noise first; then the noise falls, and
//! the field narrows.

use rayon::prelude::*;

use super::proposed::{Proposed, Tried};
use super::refits::{Refitted, gained, short, written_refits};
use super::score_test::ScoreTest;
use crate::discover::bounds::{
    ANNEALED_JOINT, ANNEALED_NEAR, ANNEALED_NOISE, ANNEALED_SHARE, ANNEALED_WITHIN, DOUBTFUL,
    FAR_BEHIND, LEAST_GAIN, LOST, MULTIMODAL, WEAK,
};
use crate::discover::candidates;
use crate::discover::candidates::hypothesis::{Hypothesis, first_of_each, run_through};
use crate::discover::checks::goodness_of_fit::rms;
use crate::discover::state::rounds::{Contender, Name, ScoreRow, title};
use crate::discover::state::search::Search;
use crate::discover::state::stage::Stage;
use crate::estimate::filter::Noise;
use crate::estimate::fit::{Fit, Problem};
use crate::estimate::refit::{self, cost};
use crate::model::Model;
use crate::plant::BuildError;

/// How far process noise is inflated, and what is asked of the names there.
struct Rung {
    /// Times the expected noise.
    noise: f64,
    /// Names that get as far.
    names: usize,
    /// Most rounds of their fits.
    rounds: usize,
    /// How far behind one that leaves nothing but noise they are given up.
    behind: f64,
}

const LADDER: [Rung; 3] = [
    Rung { noise: 30.0, names: 10, rounds: 4, behind: 10.0 * FAR_BEHIND },
    Rung { noise: 10.0, names: 4, rounds: 4, behind: FAR_BEHIND },
    Rung { noise: 3.0, names: 3, rounds: 6, behind: FAR_BEHIND },
];
/// Replicates that tell what a hypothesis explains by luck.
const REPLICATES: u64 = 3;

/// A name on its way: its hypothesis, its score, where it is fitted from and the test that gave it.
struct Entry<'a> {
    hypothesis: &'a Hypothesis,
    score: f64,
    model: Model,
    test: usize,
}

/// The field at the end of the ladder.
struct Narrowed<'a> {
    /// The names, the best first.
    field: Vec<Entry<'a>>,
    /// How many of them come near the best.
    near: usize,
    /// RMS of the errors that the best of them leaves.
    least_left: f64,
}

/// The names that explain most when process noise falls step by step.
///
/// # Errors
/// The model cannot be built.
pub(crate) fn annealed(
    problem: Problem<'_>,
    search: &mut Search,
    round: usize,
) -> Result<Option<Proposed>, BuildError> {
    search.tell(round, "fitting the known effects at inflated process noise");
    let base = search.after.clone();
    let expected = search.expected;
    let ahead = problem.ahead();
    let starts = starts(&ahead, &base, &expected)?;
    let tests: Vec<ScoreTest<'_>> = starts
        .par_iter()
        .filter_map(|start| ScoreTest::new(ahead, &base.origin, start, REPLICATES))
        .collect();
    if tests.len() < starts.len() {
        return Ok(None);
    }
    let withdrawn = &search.withdrawn;
    let proposed: Vec<Vec<Hypothesis>> =
        tests.par_iter().map(|test| candidates::proposed(&test.scene(), withdrawn)).collect();
    let field = field(&tests, &starts, &proposed);
    let mut scored: Vec<_> = field.iter().map(|e| (e.hypothesis.name(), e.score)).collect();
    scored.sort_by(|a, b| b.1.total_cmp(&a.1));
    let scored = first_of_each(scored, |(name, _)| *name);
    let narrowed = narrowed(&problem, &base, &expected, &tests, field);
    // Beside names that explain nothing one has to explain what is left.
    if narrowed.least_left > ANNEALED_JOINT && search.has_not_improved_though_near() {
        return Ok(None);
    }
    let stages = polished(&problem, &base, &expected, narrowed);
    let tried = written(&problem, search, round, &base, (stages, scored));
    let tried = compared(&problem, &base, &expected, tried)?;
    drop((proposed, tests));
    Ok(Some(Proposed::Effects(Box::new(Tried::beside(base, tried)))))
}

/// The base refitted at the most inflated noise, and from the nominal as it was: a refit is biased by a gap or a knee
/// even there, and the nominal may be far off.
fn starts(ahead: &Problem<'_>, base: &Stage, expected: &Noise) -> Result<[Fit; 2], BuildError> {
    let [Rung { noise: first, rounds, .. }, ..] = LADDER;
    let anew = Model { effects: base.fit.model.effects.clone(), ..base.origin.clone() };
    let from = |rounds: usize| {
        let (moved, noise) = (&base.fit.coordinates, expected.distrusted(first));
        ahead.fit(&base.origin, &anew, moved, &noise, rounds)
    };
    let (biased, nominal) = rayon::join(|| from(rounds), || from(0));
    Ok([biased?, nominal?])
}

/// The field fitted rung by rung, fewer names on each.
fn narrowed<'h>(
    problem: &Problem<'_>,
    base: &Stage,
    expected: &Noise,
    tests: &[ScoreTest<'_>],
    mut field: Vec<Entry<'h>>,
) -> Narrowed<'h> {
    let (passing, mask) = (problem.passing(), problem.ahead().mask);
    let first = LADDER[0].noise;
    let (mut near, mut least_left) = (0, f64::INFINITY);
    for Rung { noise: inflation, names, rounds, behind } in LADDER {
        field.truncate(names);
        let fitted = field.into_par_iter().map(|entry| {
            let near = (inflation == first).then(|| tests[entry.test].jacobian());
            let noise = expected.distrusted(inflation);
            let (own, start) = ((base, entry.hypothesis), (&entry.model, near));
            let Stage { fit, .. } = short(&passing, own, start, &noise, rounds)?;
            let left = rms(&fit.innovations, mask, None);
            Ok((cost(&fit), left, Entry { model: fit.model, ..entry }))
        });
        let mut fitted = run_through(fitted);
        fitted.sort_by(|a, b| a.0.total_cmp(&b.0));
        fitted = first_of_each(fitted, |(.., entry)| entry.hypothesis.name());
        if let Some((best, left, _)) = fitted.first()
            && *left < ANNEALED_NOISE
        {
            let most = best + behind;
            fitted.retain(|(cost, ..)| *cost < most);
        }
        least_left = fitted.iter().map(|(_, left, _)| *left).fold(f64::INFINITY, f64::min);
        near = in_reach(&fitted.iter().map(|(cost, ..)| *cost).collect::<Vec<_>>());
        field = fitted.into_iter().map(|(.., entry)| entry).collect();
    }
    Narrowed { field, near, least_left }
}

/// The names that come near refitted at their own noise; the others as well where none of these leaves only noise.
fn polished(
    problem: &Problem<'_>,
    base: &Stage,
    expected: &Noise,
    Narrowed { mut field, near, .. }: Narrowed<'_>,
) -> Vec<Refitted> {
    let [.., Rung { noise: last, .. }] = LADDER;
    let noise = expected.distrusted(last);
    let polished = |Entry { hypothesis, score, model, .. }: Entry<'_>| {
        let (origin, moved) = base.widened(hypothesis);
        let fit = refit::polish(&problem.ahead(), &origin, &model, &moved, expected, &noise)?;
        let fit = refit::finish(problem, &origin, fit, expected)?;
        Ok((hypothesis.name(), score, Stage { fit, origin }))
    };
    let far = field.split_off(near.min(field.len()));
    let mut stages = run_through(field.into_par_iter().map(polished));
    // Where the best leaves only noise, what is far behind it at inflated noise is no rival.
    if !stages.iter().any(|(.., stage)| explains(stage, expected)) {
        stages.extend(run_through(far.into_par_iter().map(polished)));
    }
    stages
}

/// Writes down the scores of all names, and what those that are believed gained.
fn written(
    problem: &Problem<'_>,
    search: &mut Search,
    round: usize,
    base: &Stage,
    (stages, scored): (Vec<Refitted>, Vec<(Name, f64)>),
) -> Vec<(Contender, Stage)> {
    let tried = written_refits(problem, search, round, base, stages);
    for (name, score) in scored {
        let row = ScoreRow { round, name: title(name), score, refitted: None };
        if !search.scores.iter().any(|known| known.round == round && known.name == row.name) {
            search.scores.push(row);
        }
    }
    tried
}

/// What is near the best, compared where each gains nothing more, the best first.
fn compared(
    problem: &Problem<'_>,
    base: &Stage,
    expected: &Noise,
    mut tried: Vec<(Contender, Stage)>,
) -> Result<Vec<(Contender, Stage)>, BuildError> {
    let best = tried.iter().map(|(contender, _)| contender.gain).fold(0.0, f64::max);
    // Of a base that is non-finite everything takes nearly all.
    let least = best - ((1.0 - ANNEALED_NEAR) * best).min(FAR_BEHIND);
    let near = |(contender, _): &(Contender, Stage)| contender.gain >= least;
    let alone = tried.iter().filter(|tried| near(tried)).count() == 1;
    let settled = |(contender, stage): &(Contender, Stage)| {
        contender.gain > WEAK && explains(stage, expected)
    };
    // One that leaves only noise and has no rival is polished in the end.
    if !(alone && tried.iter().filter(|tried| near(tried)).all(settled)) {
        let near = tried.par_iter_mut().filter(|tried| near(tried));
        near.try_for_each(|(contender, stage)| {
            let fit = stage.fit.clone();
            stage.fit = refit::polish_on(problem, &stage.origin, fit, expected)?;
            contender.gain = gained(&base.fit, &stage.fit);
            Ok::<(), BuildError>(())
        })?;
    }
    tried.sort_by(|a, b| b.0.gain.total_cmp(&a.0.gain));
    // The right name may stand in a local minimum that the nominal's refit has led to, and leave as much noise.
    if let Some((contender, stage)) = tried.first_mut()
        && stage.origin.stages.len() >= MULTIMODAL
        && contender.gain > WEAK
        && stage.fit.noise.times(expected) > LOST
    {
        let again = refit::cooled(problem, &stage.origin, &stage.fit, expected)?;
        if cost(&again) < cost(&stage.fit) {
            contender.gain = gained(&base.fit, &again);
            stage.fit = again;
        }
    }
    Ok(tried)
}

/// Whether a model leaves only noise.
fn explains(stage: &Stage, expected: &Noise) -> bool {
    stage.fit.noise.times(expected) < DOUBTFUL
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
    let most = best + (ANNEALED_WITHIN * (worst - best)).max(WEAK);
    costs.iter().filter(|cost| **cost < most).count().max(1)
}

/// The hypotheses that explain more than they would of any record, one for each name, best first.
fn worth_fitting<'a>(
    test: &ScoreTest<'_>,
    hypotheses: &'a [Hypothesis],
) -> Vec<(&'a Hypothesis, f64)> {
    let mut ranked = test.ranked(hypotheses);
    ranked.retain(|(_, gain)| gain.real > LEAST_GAIN * gain.luck());
    let least = ANNEALED_SHARE * ranked.first().map_or(0.0, |(_, best)| best.real);
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
