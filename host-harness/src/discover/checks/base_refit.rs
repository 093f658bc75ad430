//! What a base would cost had it the fit that its challenger led to.
//!
//! A name may owe its gain to a better fit of all the rest: then the base is to have that fit as well. Behind gears
//! friction has many local minima, and the refit of the nominal, or a name as long as it was missing, may have led into
//! a wrong one.

use super::elimination::without;
use crate::discover::bounds::{FAR_BEHIND, LOST};
use crate::discover::state::stage::Stage;
use crate::estimate::filter::Noise;
use crate::estimate::fit::{Fit, Problem};
use crate::estimate::refit::{self, cost};
use crate::plant::BuildError;

/// A base refitted from where a model with one more effect stands; in a chain of several stages from elsewhere too,
/// where the name explains the `least` that it must.
///
/// # Errors
/// The model cannot be built.
pub(crate) fn refitted_base(
    problem: &Problem<'_>,
    base: &Stage,
    won: &Stage,
    least: f64,
    expected: &Noise,
) -> Result<Stage, BuildError> {
    let start = without(&won.fit.model, base.fit.model.effects.len());
    let (moved, noise) = (&base.fit.coordinates, &won.fit.noise);
    let origin = &base.origin;
    // A name that is large is not owed to a local minimum.
    let small = base.fit.noise.times(expected) <= LOST || !base.fit.model.effects.is_empty();
    let geared = !origin.stages.is_empty();
    let far = |fit: &Fit| cost(fit) - cost(&won.fit) > FAR_BEHIND;
    let mut fit = refit::polish_unless(far, problem, origin, &start, moved, expected, noise)?;
    if geared && small && !far(&fit) && cost(&fit) - cost(&won.fit) > least {
        let again = refit::cooled(problem, origin, &base.fit, expected)?;
        if cost(&again) < cost(&fit) {
            fit = again;
        }
    }
    Ok(Stage { fit, origin: base.origin.clone() })
}
