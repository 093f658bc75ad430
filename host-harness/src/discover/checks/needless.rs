//! Effects that are needless beside a disturbance: whose loss costs no more than chance.
//!
//! Every effect is asked anew after each that falls, and asking is a refit without it. Of a long record a part says which
//! one to ask first, and which ones are needed however well the rest may still be fitted.

use rayon::prelude::*;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::elimination::bare_unless;
use crate::discover::bounds::{BY_CHANCE, FAR_BEHIND, WEAK};
use crate::discover::state::search::Search;
use crate::discover::state::stage::Stage;
use crate::estimate::fit::{Fit, Problem};
use crate::estimate::refit::cost;
use crate::interrupt;
use crate::plant::BuildError;

/// What the loss of an effect costs.
struct Loss {
    /// Its round.
    round: usize,
    /// By how much the log is the unlikelier without it.
    cost: f64,
    /// What is left.
    left: Stage,
}

/// Drops every effect whose loss costs no more than chance, the cheapest first.
///
/// # Errors
/// A model cannot be built.
pub(crate) fn eliminate(problem: &Problem<'_>, search: &mut Search) -> Result<(), BuildError> {
    while let Some((k, stage)) = needless(problem, search)? {
        search.after = stage;
        search.rounds.remove(k);
    }
    Ok(())
}

/// An effect whose loss costs no more than chance, and what is left without it.
///
/// # Errors
/// A model cannot be built.
pub(crate) fn needless(
    problem: &Problem<'_>,
    search: &Search,
) -> Result<Option<(usize, Stage)>, BuildError> {
    let (whole, part) = (problem.rough(), problem.ahead().rough());
    if interrupt::asked() {
        return Ok(None);
    }
    let Stage { fit, .. } = &search.after;
    let kept = match problem.scout {
        Some(_) => part.design(&fit.model, &fit.noise)?.deviance + fit.prior,
        None => cost(fit),
    };
    let lost = (0..search.rounds.len()).into_par_iter().map(|k| loss(part, search, k, kept));
    let mut lost = lost.collect::<Result<Vec<_>, BuildError>>()?;
    lost.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let by_chance = search.chance.last().copied().unwrap_or(0.0);
    for ahead in lost {
        let own = match problem.scout {
            None => ahead,
            Some(_) if ahead.cost > WEAK => break,
            Some(_) => loss(whole, search, ahead.round, cost(fit))?,
        };
        let chance = own.cost.is_nan() || own.cost < bound(2, 100, by_chance);
        if chance && !search.measured.contains(&search.rounds[own.round].name) {
            return Ok(Some((own.round, own.left)));
        }
    }
    Ok(None)
}

/// What the loss of the effect of a round costs where the model with it costs `kept`.
fn loss(
    problem: Problem<'_>,
    search: &Search,
    round: usize,
    kept: f64,
) -> Result<Loss, BuildError> {
    // What is far behind already is needed, however well the rest may still be fitted.
    let far = |fit: &Fit| cost(fit) - kept > FAR_BEHIND;
    let left = bare_unless(far, problem, search, round)?;
    Ok(Loss { round, cost: cost(&left.fit) - kept, left })
}

/// What an effect of so many free values must gain where so many hypotheses were tried.
pub(crate) fn bound(free: usize, tried: usize, by_chance: f64) -> f64 {
    let level = 1.0 - BY_CHANCE / tried.max(1) as f64;
    let chance = ChiSquared::new(free.max(1) as f64).map_or(0.0, |law| law.inverse_cdf(level));
    by_chance.max(chance)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discover::candidates::cogging;
    use crate::discover::trial;
    use crate::estimate::noise;
    use crate::estimate::record::Record;
    use crate::estimate::scout::Scout;
    use crate::model::Model;
    use crate::synthetic::{Experiment, record};

    #[test]
    fn what_is_not_there_is_needless_in_a_part_and_in_all_of_a_long_record() {
        let nominal = trial::motor();
        let truth = Model { effects: vec![trial::line(12.0)], ..nominal.clone() };
        let push = |k: i32| 4.0 * (f64::from(k) * 4e-3).sin();
        let voltage_v = Some((0..12_000).map(push).collect());
        let log = record(&truth, &Experiment { voltage_v, ..Experiment::clean(2.4) }, 5).unwrap();
        let record = Record::new(&log, None);
        let mask: Vec<f64> =
            (0..record.len()).map(|k| if k % 500 < 350 { 1.0 } else { 0.0 }).collect();
        let scout = Scout::of(&record, &mask, &nominal);
        assert!(scout.is_some(), "{} samples are no long record", record.len());
        let expected = noise::expected(&nominal, &record);
        let lines = [cogging::line(12.0, 0.01, false), cogging::line(7.0, 0.001, false)];
        for scout in [None, scout.as_ref()] {
            let problem = Problem::new(&record, &mask).rough().scouted(scout);
            let plain = trial::fitted(&problem, &nominal, &[]);
            let mut search = Search::new(plain, &[], expected);
            search.after = trial::fitted(&problem, &nominal, &lines);
            search.rounds = vec![trial::round(1e4), trial::round(40.0)];
            let (falls, left) = needless(&problem, &search).unwrap().unwrap();
            assert_eq!((falls, left.fit.model.effects.len()), (1, 1));
            search.after = left;
            search.rounds.truncate(1);
            assert!(needless(&problem, &search).unwrap().is_none());
        }
    }
}
