//! Effects beside a coloured disturbance: forward selection, one at a time, and backward elimination.
//!
//! Every candidate is refitted with the disturbance's own size, so that what it gains is what it explains beyond a
//! disturbance without a law. The likelihood is one of white residuals then, and chance is its distribution's:
//! chi-squared over all hypotheses that were tried, and what replicates reach.

use joint_core::effect::MAX_EFFECTS;
use rayon::prelude::*;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::discover::bounds::{BY_CHANCE, FAR_BEHIND, MOST_EFFECTS_DISTURBED};
use crate::discover::candidates::hypothesis::{Hypothesis, run_through};
use crate::discover::checks::bootstrap::stays_ahead;
use crate::discover::checks::elimination::{bare_unless, without};
use crate::discover::checks::order::ask_order;
use crate::discover::proposals::refits::{full, short};
use crate::discover::proposals::scored::Scored;
use crate::discover::state::rounds::{Contender, Round};
use crate::discover::state::search::Search;
use crate::discover::state::stage::Stage;
use crate::estimate::colour::coloured;
use crate::estimate::filter::Noise;
use crate::estimate::fit::{Fit, Problem};
use crate::estimate::refit::{self, cost, polish};
use crate::interrupt;
use crate::plant::BuildError;

/// Replicates that tell what a score reaches by chance.
const REPLICATES: u64 = 6;
/// Hypotheses that get a short refit, and how many of these a full one.
const SHORT: usize = 6;
const FULL: usize = 3;
/// Rounds of a short refit.
const ROUNDS: usize = 3;

/// Adds effects until no more is found, and tries to do without each.
pub(crate) fn grow(problem: &Problem<'_>, search: &mut Search) -> Result<(), BuildError> {
    let expected = search.expected;
    // One place is kept for what has no name.
    let full = |search: &Search| search.after.origin.effects.len() + 2 >= MAX_EFFECTS;
    while search.rounds.len() < MOST_EFFECTS_DISTURBED && !full(search) && !interrupt::asked() {
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

/// Adds the effect that explains most of what is left, if one explains more than chance.
fn add(problem: &Problem<'_>, search: &mut Search, round: usize) -> Result<bool, BuildError> {
    let rough = problem.rough();
    let base = search.after.clone();
    let Some(scored) = Scored::on(rough, &base, &search.withdrawn, REPLICATES) else {
        return Ok(false);
    };
    scored.write(search, round);
    let (by_chance, tried) = (scored.by_chance, scored.tried);
    search.chance.push(by_chance);
    let Fitted { mut full, plain } = fitted(&rough, &base, &scored, &search.expected)?;
    full.retain(|(_, stage)| search.believes(&stage.fit.model, problem.record));
    full.sort_by(|a, b| cost(&a.1.fit).total_cmp(&cost(&b.1.fit)));
    let won = full.first().map(|(_, won)| won);
    let plain = refitted_base(&rough, &base, won, plain, &search.expected)?;
    let contenders: Vec<Contender> = full
        .iter()
        .map(|(h, stage)| Contender { name: h.name(), gain: cost(&plain) - cost(&stage.fit) })
        .collect();
    search.write_refits(round, contenders.iter());
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
    let (name, gain, rivals) = (winner.name, winner.gain, rivals.to_vec());
    search.rounds.push(Round { name, gain, rivals, runner_up, stays_ahead });
    search.after = won;
    Ok(true)
}

/// Hypotheses refitted in full, and the base.
struct Fitted<'h> {
    full: Vec<(&'h Hypothesis, Stage)>,
    plain: Fit,
}

/// The hypotheses that score beyond chance refitted in full, and the base with the same last refinement.
fn fitted<'h>(
    rough: &Problem<'_>,
    base: &Stage,
    scored: &'h Scored<'_>,
    expected: &Noise,
) -> Result<Fitted<'h>, BuildError> {
    let least = |free: usize| bound(free, scored.tried, 0.5 * scored.by_chance);
    let promising: Vec<&Hypothesis> = scored
        .best
        .iter()
        .filter(|(_, gain)| gain.real > least(gain.free))
        .map(|(hypothesis, _)| hypothesis)
        .take(SHORT)
        .collect();
    let near = scored.test.jacobian();
    let begun = promising.par_iter().map(|hypothesis| {
        let (start, noise) = (hypothesis.added(&base.fit.model), &base.fit.noise);
        let own = (base, *hypothesis);
        Ok((*hypothesis, short(rough, own, (&start, Some(near)), noise, ROUNDS)?))
    });
    let mut begun = run_through(begun);
    begun.sort_by(|a, b| cost(&a.1.fit).total_cmp(&cost(&b.1.fit)));
    let polished = begun.into_par_iter().take(FULL).map(|(hypothesis, stage)| {
        let noise = stage.fit.noise;
        Ok((hypothesis, full(rough, stage, expected, &noise)?))
    });
    let plain = || {
        let Fit { model, coordinates, noise, .. } = &base.fit;
        polish(rough, &base.origin, model, coordinates, expected, noise)
    };
    let (polished, plain) = rayon::join(|| run_through(polished), plain);
    let plain = plain?;
    let plain = if cost(&plain) < cost(&base.fit) { plain } else { base.fit.clone() };
    Ok(Fitted { full: polished, plain })
}

/// A base refitted from where its best challenger stands, which may have led the rest to a better fit, where that is
/// likelier than the `plain` one.
fn refitted_base(
    rough: &Problem<'_>,
    base: &Stage,
    won: Option<&Stage>,
    plain: Fit,
    expected: &Noise,
) -> Result<Fit, BuildError> {
    let Some(won) = won else { return Ok(plain) };
    let start = without(&won.fit.model, base.fit.model.effects.len());
    let (moved, noise) = (&base.fit.coordinates, &won.fit.noise);
    let far = |fit: &Fit| cost(fit) > cost(&plain);
    let again = refit::polish_unless(far, rough, &base.origin, &start, moved, expected, noise)?;
    Ok(if cost(&again) < cost(&plain) { again } else { plain })
}

/// What an effect of so many free values must gain where so many hypotheses were tried.
fn bound(free: usize, tried: usize, by_chance: f64) -> f64 {
    let level = 1.0 - BY_CHANCE / tried.max(1) as f64;
    let chance = ChiSquared::new(free.max(1) as f64).map_or(0.0, |law| law.inverse_cdf(level));
    by_chance.max(chance)
}

/// Drops every effect whose loss costs no more than chance, the cheapest first.
pub(crate) fn eliminate(problem: &Problem<'_>, search: &mut Search) -> Result<(), BuildError> {
    while let Some((k, stage)) = needless(problem, search)? {
        search.after = stage;
        search.rounds.remove(k);
    }
    Ok(())
}

/// The effect whose loss costs least, where that is no more than chance, and what is left without it.
pub(crate) fn needless(
    problem: &Problem<'_>,
    search: &Search,
) -> Result<Option<(usize, Stage)>, BuildError> {
    if interrupt::asked() {
        return Ok(None);
    }
    let by_chance = search.chance.last().copied().unwrap_or(0.0);
    let kept = cost(&search.after.fit);
    // What is far behind already is needed, however well the rest may still be fitted.
    let far = |fit: &Fit| cost(fit) - kept > FAR_BEHIND;
    let without = (0..search.rounds.len())
        .into_par_iter()
        .map(|k| Ok((k, bare_unless(far, problem.rough(), search, k)?)))
        .collect::<Result<Vec<_>, BuildError>>()?;
    let cheapest = without.into_iter().min_by(|a, b| cost(&a.1.fit).total_cmp(&cost(&b.1.fit)));
    Ok(cheapest.filter(|(k, stage)| {
        let loss = cost(&stage.fit) - kept;
        let chance = loss.is_nan() || loss < bound(2, 100, by_chance);
        chance && !search.measured.contains(&search.rounds[*k].name)
    }))
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
pub(crate) fn refitted(
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
