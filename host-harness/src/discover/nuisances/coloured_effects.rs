//! Effects beside a coloured disturbance: forward selection, one at a time, and backward elimination.
//!
//! Every candidate is refitted with the disturbance's own size, so that what it gains is what it explains beyond a
//! disturbance without a law. The likelihood is one of white residuals then, and chance is its distribution's:
//! chi-squared over all hypotheses that were tried, and what replicates reach. Friction of another law than the model's
//! leaves more than chance all the same, in which some effect fits what it was fitted to: so one is added only if
//! samples that no fit has seen confirm it.

use joint_core::effect::MAX_EFFECTS;
use rayon::prelude::*;

use crate::discover::bounds::MOST_EFFECTS_DISTURBED;
use crate::discover::candidates::hypothesis::{Hypothesis, run_through};
use crate::discover::checks::bootstrap::stays_ahead;
use crate::discover::checks::elimination::without;
use crate::discover::checks::needless::{bound, eliminate};
use crate::discover::checks::order::ask_order;
use crate::discover::evidence::unseen::{Unseen, unseen};
use crate::discover::proposals::refits::{full, short_ahead};
use crate::discover::proposals::scored::Scored;
use crate::discover::state::rounds::{Contender, Round};
use crate::discover::state::search::{Search, Unconfirmed};
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
        let what = "scoring the known effects beside a disturbance";
        search.tell_of(MOST_EFFECTS_DISTURBED, round, what);
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
    let gain = |stage: &Stage| cost(&plain) - cost(&stage.fit);
    let own = |(h, stage): (&Hypothesis, Stage)| {
        let least = bound(h.coordinates(0).len(), tried, by_chance);
        (Contender { name: h.name(), gain: gain(&stage) }, stage, least)
    };
    let contenders: Vec<Contending> = full.into_iter().map(own).collect();
    search.write_refits(round, contenders.iter().map(|(contender, ..)| contender));
    let mut contenders = contenders.into_iter();
    let won = confirmed(&rough, search, &plain, &mut contenders)?;
    let plain = Stage { fit: plain, origin: base.origin.clone() };
    let Some((Contender { name, gain }, won)) = won else {
        search.after = plain;
        return Ok(false);
    };
    let (rivals, stages): (Vec<_>, Vec<_>) = contenders.map(|(rival, own, _)| (rival, own)).unzip();
    let runner_up = stages.into_iter().next();
    let others: Vec<&Fit> = runner_up.iter().map(|stage| &stage.fit).chain([&plain.fit]).collect();
    let stays_ahead = stays_ahead(&won.fit, &others, problem.mask);
    search.rounds.push(Round { name, gain, rivals, runner_up, stays_ahead });
    search.after = won;
    Ok(true)
}

/// An effect, the model with it, and what it has to gain.
type Contending = (Contender, Stage, f64);

/// The likeliest effect that samples which no fit has seen confirm over a `plain` fit, of those that gain more than
/// chance, the likeliest first; what is taken from them lost. Where none is confirmed the likeliest that no sample speaks
/// against is only possible.
fn confirmed(
    problem: &Problem<'_>,
    search: &mut Search,
    plain: &Fit,
    contenders: &mut impl Iterator<Item = Contending>,
) -> Result<Option<(Contender, Stage)>, BuildError> {
    let tested: Vec<bool> = problem.mask.iter().map(|weight| *weight == 0.0).collect();
    let mut refused = None;
    for (contender, stage, least) in contenders {
        if contender.gain.is_nan() || contender.gain < least {
            break;
        }
        let Unseen { t, slope, .. } = unseen(problem, plain, &stage.fit, &tested)?;
        if slope.margin(0.0) > 0.0 {
            return Ok(Some((contender, stage)));
        }
        if slope.nearer() > 0.0 {
            refused.get_or_insert(Unconfirmed {
                contender,
                stage,
                slope,
                unseen_t: t,
                transfer_t: None,
            });
        }
    }
    search.unconfirmed.extend(refused);
    Ok(None)
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
        Ok((*hypothesis, short_ahead(rough, own, (&start, near), noise, ROUNDS)?))
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

#[cfg(test)]
mod tests {
    use joint_core::effect::Kind;
    use joint_core::params::Location;

    use super::*;
    use crate::discover::candidates::cogging;
    use crate::discover::trial;
    use crate::estimate::noise;
    use crate::estimate::record::Record;

    #[test]
    fn the_likeliest_effect_that_unseen_samples_confirm_is_added() {
        let nominal = trial::motor();
        let record = Record::new(&trial::log(&nominal, trial::line(12.0), 4.0), None);
        let mask: Vec<f64> =
            (0..record.len()).map(|k| if k % 500 < 350 { 1.0 } else { 0.0 }).collect();
        let problem = Problem::new(&record, &mask).rough();
        let expected = noise::expected(&nominal, &record);
        let plain = trial::fitted(&problem, &nominal, &[]);
        let there = trial::fitted(&problem, &nominal, &[cogging::line(12.0, 0.01, false)]);
        let mut against = there.clone();
        against.fit.model.effects[0].values[1] *= -1.0;
        let own = |kind: Kind, stage: &Stage, gain: f64| {
            (Contender { name: (kind, Location::Motor), gain }, stage.clone(), 20.0)
        };
        let mut search = Search::new(plain.clone(), &[], expected);
        let mut asked = |all: Vec<Contending>| {
            let mut all = all.into_iter();
            let won = confirmed(&problem, &mut search, &plain.fit, &mut all).unwrap();
            let left: Vec<Kind> = all.map(|(contender, ..)| contender.name.0).collect();
            (won.map(|(contender, _)| contender.name.0), left, search.unconfirmed.len())
        };
        // What fits only where it was fitted is passed over, and is no rival of the next.
        let all = vec![
            own(Kind::Gravity, &against, 90.0),
            own(Kind::Cogging, &there, 80.0),
            own(Kind::QuadraticDrag, &plain, 70.0),
        ];
        assert_eq!(asked(all), (Some(Kind::Cogging), vec![Kind::QuadraticDrag], 0));
        // What gains no more than chance is not asked; a change of nothing is confirmed by nobody.
        assert_eq!(asked(vec![own(Kind::Cogging, &there, 19.0)]).0, None);
        assert_eq!(asked(vec![own(Kind::Gravity, &plain, 90.0)]).0, None);
    }
}
