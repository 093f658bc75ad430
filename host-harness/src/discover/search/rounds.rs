//! Round by round: the effect that explains most of what is left is added, until none does.

use super::acceptance::{add_by_linear_step, add_proposed};
use super::refits::settle;
use super::strategies::add_to_inconsistent;
use crate::discover::bounds::{DOUBTED, HELPS, LOST, MOST_EFFECTS};
use crate::discover::checks::elimination::drop_inactive;
use crate::discover::checks::goodness_of_fit::Remainder;
use crate::discover::checks::order::ask_order;
use crate::discover::proposals::annealed::annealed;
use crate::discover::proposals::disturbance_state::beside_disturbance_state;
use crate::discover::state::search::Search;
use crate::discover::state::stage::Stage;
use crate::estimate::fit::Problem;
use crate::interrupt;
use crate::plant::BuildError;

/// Adds effects until no more is found.
///
/// # Errors
/// The model cannot be built.
pub(crate) fn look(last: Problem<'_>, search: &mut Search) -> Result<(), BuildError> {
    for round in search.rounds.len() + 1..=MOST_EFFECTS {
        search.tell(round, "scoring the known effects");
        let (before, known) = (search.noise_ratio(), search.rounds.len());
        if interrupt::asked() || !add(last, search, round)? {
            break;
        }
        if known == 0 {
            search.keep_close_second();
        }
        for k in known..search.rounds.len() {
            ask_order(last.rough(), search, k)?;
        }
        drop_inactive(last.rough(), search)?;
        let left = search.noise_ratio();
        // Names that leave a model as inconsistent as it was explain nothing; the first may need another beside it.
        if search.rounds.len() > 1 && left > LOST && left > HELPS * before {
            break;
        }
    }
    Ok(())
}

/// Adds the effect that explains most of what is left, if there is one.
fn add(last: Problem<'_>, search: &mut Search, round: usize) -> Result<bool, BuildError> {
    let problem = last.rough();
    if !search.rounds.is_empty() && doubted(&last, search)? {
        settle(&last, search, false)?;
    }
    let ratio = search.noise_ratio();
    let added = ratio > LOST && add_to_inconsistent(problem, search, round)?
        || ratio <= LOST && add_by_linear_step(problem, search, round)?;
    // Noise that swallows what is missing hides it from the plain test as well.
    if added || !doubted(&last, search)? {
        return Ok(added);
    }
    let proposed = annealed(problem, search, round)?;
    if add_proposed(problem, search, round, proposed)? {
        return Ok(true);
    }
    let proposed = beside_disturbance_state(problem, search, round, None)?;
    add_proposed(problem, search, round, proposed)
}

/// Whether the noise that a model needs says that something is missing even if no score says what; not of
/// one with effects that leaves what such models may.
fn doubted(problem: &Problem<'_>, search: &Search) -> Result<bool, BuildError> {
    let Search { after: Stage { fit, .. }, expected, .. } = search;
    Ok((DOUBTED..=LOST).contains(&search.noise_ratio())
        && (search.rounds.is_empty()
            || !Remainder::of(problem, fit, expected, problem.mask)?.complaints(false).is_empty()))
}
