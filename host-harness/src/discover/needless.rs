//! Effects that are no longer needed, or no longer believed.

use joint_core::effect::Kind;
use joint_core::joint::Drive;

use super::contradiction::contradiction;
use super::search::{LEAST_GAIN, Search, Stage};
use crate::estimate::fit::Problem;
use crate::estimate::parameters::Quantity;
use crate::estimate::refit::{self, cost};
use crate::model::Model;
use crate::plant::BuildError;

/// Share of all that was explained which an effect is not suspected of owing to its company.
const MOST: f64 = 0.5;

/// Drops effects, the first added first, that the others have made needless, or only those that a
/// channel contradicts at the size that they have got by now.
pub(super) fn drop_needless(
    problem: Problem<'_>,
    search: &mut Search,
    contradicted: bool,
) -> Result<(), BuildError> {
    let added = search.before.origin.effects.len();
    let mut k = 0;
    while k < search.rounds.len() {
        let place = added + k;
        let mut last = search.after.fit.model.clone();
        let own = last.effects.remove(place);
        last.effects.push(own);
        let against = contradiction(&last, problem.record);
        if against.is_none() && (contradicted || search.rounds.len() == 1) {
            k += 1;
            continue;
        }
        let mut origin = search.after.origin.clone();
        origin.effects.remove(place);
        let start = without(&search.after.fit.model, place);
        let coordinates: Vec<_> =
            search.after.fit.coordinates.iter().filter_map(|c| c.without_effect(place)).collect();
        let noise = search.after.fit.noise;
        let expected = &search.expected;
        let kept = cost(&search.after.fit);
        let mut fit = refit::polish(&problem, &origin, &start, &coordinates, expected, &noise)?;
        let lost = cost(&fit) - kept;
        let most = MOST * (cost(&search.before.fit) - kept);
        if !origin.stages.is_empty() && lost >= LEAST_GAIN && lost < most {
            // Behind gears the others may have settled in a hollow that only this one's company made.
            let again = refit::cooled(&problem, &origin, &fit, expected)?;
            if cost(&again) < cost(&fit) {
                fit = again;
            }
        }
        if against.is_some() || cost(&fit) - kept < LEAST_GAIN {
            against.into_iter().for_each(|against| search.contradicted(against));
            search.after = Stage { fit, origin };
            search.rounds.remove(k);
        } else {
            k += 1;
        }
    }
    Ok(())
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
