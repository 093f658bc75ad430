//! Whether the step itself is what is missing.
//!
//! A record is searched at few micro-steps. Gaps and friction that follows the load may ask for more, and
//! what is left out looks like an effect: a gate that complains, or a weak name that is hidden nowhere.

use super::gate::Remainder;
use super::needless::drop_needless;
use super::search::{LEAST_GAIN, Search, Stage, WEAK};
use crate::estimate::fit::Problem;
use crate::estimate::{noise, refit};
use crate::plant::BuildError;

/// Rounds of the fit that shows whether finer steps help.
const ROUNDS: usize = 2;
/// Share of the noise on the rotor that finer steps have to leave to be worth it by that.
const CALMER: f64 = 0.7;

/// Goes on at finer steps, those of `problem`, if they explain something by themselves, take away what the
/// gate complains of, or make an effect needless. Answers with what is left then.
///
/// # Errors
/// The model cannot be built.
pub(super) fn ask_finer(
    problem: &Problem<'_>,
    found: &mut Search,
    coarse: &Remainder,
) -> Result<Option<Remainder>, BuildError> {
    let Stage { fit, origin } = &found.after;
    let (moved, expected) = (&fit.coordinates, &found.expected);
    let gained = fit.deviance - problem.design(&fit.model, &fit.noise)?.deviance;
    let complaints = coarse.complaints(false).len();
    let names = found.rounds.len();
    let suspect = names > 1 && found.rounds.iter().any(|round| round.gain < WEAK);
    if complaints == 0 && gained < LEAST_GAIN && !suspect {
        return Ok(None);
    }
    let noise = noise::refine(problem, &fit.model, expected, &fit.noise)?;
    let better = problem.rough().fit(origin, &fit.model, moved, &noise, ROUNDS)?;
    let left = Remainder::of(problem, &better, expected, problem.mask)?;
    let calmer = left.complaints(false).len() < complaints || left.torque < CALMER * coarse.torque;
    if gained < LEAST_GAIN && !calmer && !suspect {
        return Ok(None);
    }
    let better = refit::polish(problem, origin, &better.model, moved, expected, &better.noise)?;
    let mut other = found.clone();
    other.after = Stage { fit: better, origin: origin.clone() };
    drop_needless(problem.rough(), &mut other, false)?;
    if gained < LEAST_GAIN && !calmer && other.rounds.len() == names {
        return Ok(None);
    }
    *found = other;
    Ok(Some(Remainder::of(problem, &found.after.fit, &found.expected, problem.mask)?))
}
