//! Fits that are stuck, and how they come free.
//!
//! What is missing holds springs and friction in a wrong local minimum, and they stay there when
//! it is missing no more. Both leave something: noise that no right model needs, or a rest that is none.

use crate::discover::bounds::LOST;
use crate::discover::checks::goodness_of_fit::Remainder;
use crate::discover::checks::noise_ratio::is_as_expected;
use crate::discover::state::search::Search;
use crate::discover::state::stage::Stage;
use crate::estimate::fit::Problem;
use crate::estimate::refit::{self, cost};
use crate::plant::BuildError;

/// Refits a model with effects once more, unless it is the one that this gave last; what leaves a `clean` rest
/// is only polished, and a joint without springs.
///
/// # Errors
/// The model cannot be built.
pub(crate) fn settle(
    problem: &Problem<'_>,
    search: &mut Search,
    clean: bool,
) -> Result<(), BuildError> {
    let Stage { fit, origin } = &search.after;
    if search.settled == Some(cost(fit)) {
        return Ok(());
    }
    let (model, moved, expected) = (&fit.model, &fit.coordinates, &search.expected);
    let quiet = is_as_expected(&fit.noise, expected);
    let settled = if origin.stages.is_empty() || clean && quiet {
        refit::polish(problem, origin, model, moved, expected, &fit.noise)?
    } else if clean {
        refit::polish_on(problem, origin, fit.clone(), expected)?
    } else if quiet {
        refit::cooled(problem, origin, fit, expected)?
    } else if search.noise_ratio() > LOST {
        refit::resettle(problem, origin, model, moved)?
    } else {
        fit.clone()
    };
    let mut best = if cost(&settled) < cost(fit) { settled } else { fit.clone() };
    if !clean && !is_as_expected(&best.noise, expected) {
        best = refit::converge(problem, origin, best, expected)?;
    }
    search.settled = Some(cost(&best));
    search.after = Stage { fit: best, origin: origin.clone() };
    Ok(())
}

/// Whether what the model leaves is noise; of a joint without stages nobody asks, and it is said not to be.
///
/// # Errors
/// The model cannot be built.
pub(crate) fn is_clean(problem: &Problem<'_>, search: &Search) -> Result<bool, BuildError> {
    let Stage { fit, origin } = &search.after;
    if origin.stages.is_empty() {
        return Ok(false);
    }
    let left = Remainder::of(problem, fit, &search.expected, problem.mask)?;
    Ok(left.complaints(search.rounds.is_empty()).is_empty())
}

/// Whether a nominal may be fitted in a wrong local minimum: one that needs more noise than it should, or that of a
/// chain which leaves more than noise.
///
/// # Errors
/// The model cannot be built.
pub(crate) fn may_be_stuck(problem: &Problem<'_>, search: &Search) -> Result<bool, BuildError> {
    let Stage { fit, origin } = &search.after;
    let quiet = is_as_expected(&fit.noise, &search.expected);
    Ok(!quiet || !origin.stages.is_empty() && !is_clean(problem, search)?)
}

/// Refits the nominal from elsewhere, and keeps it if it is likelier; by how much it is.
///
/// # Errors
/// The model cannot be built.
pub(crate) fn fit_from_elsewhere(
    problem: &Problem<'_>,
    search: &mut Search,
) -> Result<f64, BuildError> {
    let Stage { fit, origin } = &search.after;
    let again = match is_as_expected(&fit.noise, &search.expected) {
        true => refit::cooled(problem, origin, fit, &search.expected)?,
        false => refit::converge(problem, origin, fit.clone(), &search.expected)?,
    };
    let gained = cost(fit) - cost(&again);
    if gained > 0.0 {
        let found = Stage { fit: again, origin: origin.clone() };
        search.before = found.clone();
        search.after = found;
    }
    Ok(gained)
}
