//! Effects that are no longer needed, or no longer believed.

use std::borrow::Cow;

use super::admissibility::possible;
use super::contradiction::contradiction;
use super::own_gain::holds;
use crate::discover::bounds::{FAR_BEHIND, LEAST_GAIN, OWN_SHARE, STILL_NEEDED};
use crate::discover::candidates::card;
use crate::discover::state::search::Search;
use crate::discover::state::stage::Stage;
use crate::estimate::filter::Linearisation;
use crate::estimate::fit::{Fit, Problem};
use crate::estimate::refit::{self, cost};
use crate::model::Model;
use crate::plant::BuildError;

/// Drops effects, the first added first, that the others have made needless, and those that a channel
/// contradicts at the size that they have got by now; of the first only `weak` ones if that is all that is
/// asked, and those whose loss costs far less than they once explained.
pub(crate) fn drop_needless(
    problem: Problem<'_>,
    search: &mut Search,
    weak: bool,
) -> Result<(), BuildError> {
    let mut k = 0;
    while k < search.rounds.len() {
        let against = {
            let mut last = search.after.fit.model.clone();
            let own = last.effects.remove(search.place(k));
            last.effects.push(own);
            contradiction(&last, problem.record)
        };
        let enough = search.weak_gain(search.rounds[k].name.1);
        let gain = search.rounds[k].gain;
        let sure = against.is_none() && (search.rounds.len() == 1 || weak) && gain >= enough;
        if sure && loss(&problem, &search.after.fit, search.place(k))? >= STILL_NEEDED * gain {
            k += 1;
            continue;
        }
        let least = search.least_gain(search.rounds[k].name.1);
        let kept = cost(&search.after.fit);
        // What is far behind already is needed, however well the rest may still be fitted.
        let far = |fit: &Fit| against.is_none() && cost(fit) - kept > FAR_BEHIND;
        let mut bare = bare_unless(far, problem, search, k)?;
        let lost = cost(&bare.fit) - kept;
        let most = OWN_SHARE * (cost(&search.before.fit) - kept);
        if !bare.origin.stages.is_empty() && lost >= least && lost < most {
            // Behind gears the others may have ended in a local minimum that this one made.
            let again = refit::cooled(&problem, &bare.origin, &bare.fit, &search.expected)?;
            if cost(&again) < cost(&bare.fit) {
                bare.fit = again;
            }
        }
        let lost = cost(&bare.fit) - kept;
        let measured = search.measured.contains(&search.rounds[k].name);
        let needed = lost >= enough
            || measured && lost > 0.0
            || lost >= least && holds(problem, &bare.fit, &search.after.fit, &search.expected)?;
        if against.is_some() || !needed {
            against.into_iter().for_each(|against| search.contradicted(against));
            search.after = bare;
            search.rounds.remove(k);
        } else {
            k += 1;
        }
    }
    Ok(())
}

/// Drops the effects that the others have driven to where no joint is believed to be, or to where they do
/// nothing.
pub(crate) fn drop_inactive(problem: Problem<'_>, search: &mut Search) -> Result<(), BuildError> {
    let mut k = 0;
    while k < search.rounds.len() {
        let (fit, place) = (&search.after.fit, search.place(k));
        let believed = possible(&fit.model.effects[place], &fit.model, problem.record);
        let measured = search.measured.contains(&search.rounds[k].name);
        let alone = measured || search.rounds.len() == 1;
        if believed && (alone || loss(&problem, fit, place)? >= LEAST_GAIN) {
            k += 1;
            continue;
        }
        search.after = bare(problem, search, k)?;
        search.rounds.remove(k);
    }
    Ok(())
}

/// What a fit is the worse by for the loss of an effect if all else stays; without bound where the rest is
/// non-finite.
fn loss(problem: &Problem<'_>, fit: &Fit, place: usize) -> Result<f64, BuildError> {
    let along = Cow::Owned(Linearisation::default());
    let alone = without(&fit.model, place);
    let left = problem.deviance_along(&along, &alone, &fit.noise)?;
    Ok(if left.is_nan() { f64::INFINITY } else { left - fit.deviance })
}

/// What is left without the effect of round `k`, refitted from where the others stand.
pub(crate) fn bare(problem: Problem<'_>, search: &Search, k: usize) -> Result<Stage, BuildError> {
    bare_unless(|_| false, problem, search, k)
}

/// The same, content with the first half of the refit where that says enough.
pub(crate) fn bare_unless(
    enough: impl Fn(&Fit) -> bool,
    problem: Problem<'_>,
    search: &Search,
    k: usize,
) -> Result<Stage, BuildError> {
    let Stage { fit, origin } = narrowed(&search.after, search.place(k));
    let (start, moved) = (&fit.model, &fit.coordinates);
    let (expected, noise) = (&search.expected, &fit.noise);
    let fit = refit::polish_unless(enough, &problem, &origin, start, moved, expected, noise)?;
    Ok(Stage { fit, origin })
}

/// A stage without one of its effects, not refitted.
pub(crate) fn narrowed(stage: &Stage, place: usize) -> Stage {
    let Stage { mut fit, mut origin } = stage.clone();
    origin.effects.remove(place);
    fit.model = without(&fit.model, place);
    fit.coordinates = fit.coordinates.iter().filter_map(|c| c.without_effect(place)).collect();
    Stage { fit, origin }
}

/// A model without one of its effects, as near as parameters can bring it.
pub(crate) fn without(model: &Model, place: usize) -> Model {
    let mut left = model.clone();
    let gone = left.effects.remove(place);
    (card(gone.kind).rules.loss)(&gone, &mut left);
    left
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discover::candidates::cogging;
    use crate::discover::trial;
    use crate::estimate::noise;
    use crate::estimate::record::Record;

    /// Whether a line of order 12, said to have explained this much, is kept where the log holds a line of
    /// that order times `hidden`.
    fn kept(gain: f64, hidden: f64) -> bool {
        let nominal = trial::motor();
        let line = trial::line(12.0).with("amplitude_nm", 0.02 * hidden);
        let record = Record::new(&trial::log(&nominal, line, 4.0), None);
        let mask = vec![1.0; record.measured.len()];
        let problem = Problem::new(&record, &mask).rough();
        let expected = noise::expected(&nominal, &record);
        let before = trial::fitted(&problem, &nominal, &[]);
        let after = trial::fitted(&problem, &nominal, &[cogging::line(12.0, 0.01, false)]);
        let mut search = Search::new(before, &[], expected);
        search.rounds.push(trial::round(gain));
        search.after = after;
        drop_needless(problem, &mut search, true).unwrap();
        search.after.fit.model.effects.len() == 1
    }

    #[test]
    fn what_once_explained_much_goes_where_its_loss_costs_nothing_any_more() {
        assert!(kept(1e5, 1.0), "a line that is there");
        assert!(!kept(1e5, 0.0), "a line that is not");
        assert!(kept(1e12, 1.0), "a line that is there, though it was said to explain more");
    }
}
