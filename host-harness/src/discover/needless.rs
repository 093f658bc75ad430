//! Effects that are no longer needed, or no longer believed.

use std::borrow::Cow;

use joint_core::effect::Kind;
use joint_core::joint::Drive;

use super::belief::possible;
use super::borne_out::holds;
use super::contradiction::contradiction;
use super::search::{FAR_BEHIND, LEAST_GAIN, Search, Stage};
use crate::estimate::filter::Linearisation;
use crate::estimate::fit::{Fit, Problem};
use crate::estimate::parameters::Quantity;
use crate::estimate::refit::{self, cost};
use crate::model::Model;
use crate::plant::BuildError;

/// Share of all that was explained which an effect is not suspected of owing to its company.
const MOST: f64 = 0.5;

/// Drops effects, the first added first, that the others have made needless, and those that a channel
/// contradicts at the size that they have got by now; of the first only `weak` ones if that is all that is
/// asked.
pub(super) fn drop_needless(
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
        let sure = (search.rounds.len() == 1 || weak) && search.rounds[k].gain >= enough;
        if against.is_none() && sure {
            k += 1;
            continue;
        }
        let least = search.least_gain(search.rounds[k].name.1);
        let kept = cost(&search.after.fit);
        // What is far behind already is needed, however well the rest may still be fitted.
        let far = |fit: &Fit| against.is_none() && cost(fit) - kept > FAR_BEHIND;
        let mut bare = bare_unless(far, problem, search, k)?;
        let lost = cost(&bare.fit) - kept;
        let most = MOST * (cost(&search.before.fit) - kept);
        if !bare.origin.stages.is_empty() && lost >= least && lost < most {
            // Behind gears the others may have settled in a hollow that only this one's company made.
            let again = refit::cooled(&problem, &bare.origin, &bare.fit, &search.expected)?;
            if cost(&again) < cost(&bare.fit) {
                bare.fit = again;
            }
        }
        let lost = cost(&bare.fit) - kept;
        let needed = lost >= enough
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

/// Drops the effects that their company has driven to where no joint is believed to be, or to where they do
/// nothing.
pub(super) fn drop_idle(problem: Problem<'_>, search: &mut Search) -> Result<(), BuildError> {
    let mut k = 0;
    while k < search.rounds.len() {
        let (fit, place) = (&search.after.fit, search.place(k));
        let believed = possible(&fit.model.effects[place], &fit.model, problem.record);
        if believed && (search.rounds.len() == 1 || works(&problem, fit, place)?) {
            k += 1;
            continue;
        }
        search.after = bare(problem, search, k)?;
        search.rounds.remove(k);
    }
    Ok(())
}

/// Whether a fit is the worse for the loss of an effect if all else stays.
fn works(problem: &Problem<'_>, fit: &Fit, place: usize) -> Result<bool, BuildError> {
    let along = Cow::Owned(Linearisation::default());
    let alone = without(&fit.model, place);
    let left = problem.deviance_along(&along, &alone, &fit.noise)?;
    Ok(left.is_nan() || left - fit.deviance >= LEAST_GAIN)
}

/// What is left without the effect of round `k`, refitted from where its company stands.
pub(super) fn bare(problem: Problem<'_>, search: &Search, k: usize) -> Result<Stage, BuildError> {
    bare_unless(|_| false, problem, search, k)
}

/// The same, content with the first half of the refit where that says enough.
fn bare_unless(
    enough: impl Fn(&Fit) -> bool,
    problem: Problem<'_>,
    search: &Search,
    k: usize,
) -> Result<Stage, BuildError> {
    let place = search.place(k);
    let Stage { fit, origin } = &search.after;
    let mut origin = origin.clone();
    origin.effects.remove(place);
    let start = without(&fit.model, place);
    let moved: Vec<_> = fit.coordinates.iter().filter_map(|c| c.without_effect(place)).collect();
    let (expected, noise) = (&search.expected, &fit.noise);
    let fit = refit::polish_unless(enough, &problem, &origin, &start, &moved, expected, noise)?;
    Ok(Stage { fit, origin })
}

/// A model without one of its effects, as near as parameters can bring it.
pub(super) fn without(model: &Model, place: usize) -> Model {
    let mut left = model.clone();
    let gone = left.effects.remove(place);
    if gone.kind == Kind::CurrentGain {
        // A gain is a symmetry: the same currents are shown by a smaller winding and larger torques.
        let shift = (1.0 + gone.values[0]).ln();
        for quantity in Quantity::of(&left, Drive::Voltage) {
            match quantity {
                Quantity::Resistance | Quantity::Inductance => quantity.shift(&mut left, -shift),
                Quantity::TorqueConstant
                | Quantity::StribeckVelocity(_)
                | Quantity::GravityPhase => {}
                _ => quantity.shift(&mut left, shift),
            }
        }
    }
    left
}
