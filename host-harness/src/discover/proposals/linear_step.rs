//! One linear step from a base, then the most promising hypotheses in full.
//!
//! Each hypothesis is scored by one linear step, the best of every name get a short refit, and the best of these a full
//! one with their own noise. The base gets the same last refinement of its noise, so that nothing is gained by that.

use rayon::prelude::*;

use super::proposed::{Proposed, Tried};
use super::refits::{full, level_ahead, short_ahead};
use super::scored::Scored;
use crate::discover::bounds::{LEAST_GAIN, PLAIN_TORQUE_RATIO, RIVALLING, SWALLOWED};
use crate::discover::candidates::hypothesis::{Hypothesis, run_through};
use crate::discover::state::rounds::Contender;
use crate::discover::state::search::Search;
use crate::discover::state::stage::Stage;
use crate::estimate::fit::{Fit, Problem};
use crate::estimate::noise;
use crate::estimate::refit::cost;
use crate::plant::BuildError;

/// Replicates from which a round's threshold is taken.
const REPLICATES: u64 = 6;
/// Hypotheses that get a short refit, and how many of these a full one.
const SHORT: usize = 5;
const FULL: usize = 3;
/// Rounds of a short refit.
const ROUNDS: usize = 3;

/// The names that explain most of what a base leaves.
///
/// # Errors
/// The model cannot be built.
pub(crate) fn linear_step(
    problem: Problem<'_>,
    search: &mut Search,
    round: usize,
) -> Result<Option<Proposed>, BuildError> {
    let base = search.after.clone();
    let Some(scored) = Scored::on(problem, &base, &search.withdrawn, REPLICATES) else {
        return Ok(None);
    };
    search.scores.retain(|row| row.round != round);
    scored.write(search, round);
    let by_chance = scored.by_chance;
    let first = scored.best.first().map(|(hypothesis, _)| hypothesis.start.location);
    let least = first.map_or(by_chance, |place| by_chance.max(search.least_gain(place)));
    search.chance.push(least);
    let promising = promising(&scored, search);
    search.tell_scored(round, scored.best.len(), promising.len());
    let contending = contending(&problem, &base, &scored, &promising)?;

    let expected = search.expected;
    let polished = contending.into_par_iter().map(|(hypothesis, stage)| {
        let noise = stage.fit.noise;
        let stage = full(&problem, stage, &expected, &noise)?;
        // One more effect is never worse: the part of a long record that fits begin with has led this one astray.
        if problem.scout.is_none() || cost(&stage.fit) <= cost(&base.fit) {
            return Ok((hypothesis, stage));
        }
        let whole = Problem { scout: None, ..problem };
        let (start, near) = (hypothesis.added(&base.fit.model), scored.test.jacobian());
        let noise = &base.fit.noise;
        let again = short_ahead(&whole, (&base, hypothesis), (&start, near), noise, ROUNDS)?;
        let again = full(&whole, again, &expected, noise)?;
        let better = cost(&again.fit) < cost(&stage.fit);
        Ok((hypothesis, if better { again } else { stage }))
    });
    // The base gets the same last refinement of its noise as its challengers have.
    let refined = || {
        let noise = noise::refine(&problem, &base.fit.model, &expected, &base.fit.noise)?;
        Ok::<_, BuildError>((noise, problem.design(&base.fit.model, &noise)?.deviance))
    };
    let (mut fitted, refined) = rayon::join(|| run_through(polished), refined);
    let (noise, deviance) = refined?;
    fitted.retain(|(_, stage)| search.believes(&stage.fit.model, problem.record));
    fitted.sort_by(|a, b| cost(&a.1.fit).total_cmp(&cost(&b.1.fit)));
    let level = (deviance + base.fit.prior).min(cost(&base.fit));
    let contender = |(h, stage): (&Hypothesis, Stage)| {
        (Contender { name: h.name(), gain: level - cost(&stage.fit) }, stage)
    };
    let contenders: Vec<(Contender, Stage)> = fitted.into_iter().map(contender).collect();
    search.write_refits(round, contenders.iter().map(|(contender, _)| contender));
    let refined = Fit { noise, ..base.fit.clone() };
    drop(scored);
    let tried = Tried { base, cost: level, refined, by_chance, contenders };
    Ok(Some(Proposed::Effects(Box::new(tried))))
}

/// The names that are worth a short refit, and their scores.
fn promising<'s>(scored: &'s Scored<'_>, search: &Search) -> Vec<(&'s Hypothesis, f64)> {
    // Noise that has swallowed what is missing hides half of it and more from a linear step.
    let swallowed = search.noise_ratio() > PLAIN_TORQUE_RATIO;
    let share = if swallowed { SWALLOWED } else { 1.0 };
    // Whether a stage's law explains what it must is for the full refit to say.
    let asked = |hypothesis: &Hypothesis| {
        let least = scored.by_chance.max(search.least_gain(hypothesis.start.location));
        share * least.min(scored.by_chance.max(LEAST_GAIN))
    };
    let best = scored.best.iter();
    best.filter(|(hypothesis, gain)| gain.real > asked(hypothesis) * gain.luck())
        .map(|(hypothesis, gain)| (hypothesis, gain.real))
        .take(SHORT)
        .collect()
}

/// Those that a short refit leaves, the best first.
fn contending<'h>(
    problem: &Problem<'_>,
    base: &Stage,
    scored: &Scored<'_>,
    promising: &[(&'h Hypothesis, f64)],
) -> Result<Vec<(&'h Hypothesis, Stage)>, BuildError> {
    let (level, times) = level_ahead(problem, &base.fit)?;
    let fitted = promising.par_iter().map(|(hypothesis, score)| {
        let start = hypothesis.added(&base.fit.model);
        let (own, near) = ((base, *hypothesis), scored.test.jacobian());
        let stage = short_ahead(problem, own, (&start, near), &base.fit.noise, ROUNDS)?;
        let gain = times * (level - cost(&stage.fit));
        Ok((*hypothesis, stage, gain.max(*score)))
    });
    let mut fitted = run_through(fitted);
    fitted.sort_by(|a, b| b.2.total_cmp(&a.2));
    let strongest = fitted.first().map_or(0.0, |(.., gain)| *gain);
    let rivals = fitted.into_iter().filter(|(.., gain)| *gain > RIVALLING * strongest).take(FULL);
    Ok(rivals.map(|(hypothesis, stage, _)| (hypothesis, stage)).collect())
}
