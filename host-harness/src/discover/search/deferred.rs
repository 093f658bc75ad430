//! Two effects that hide each other: either alone explains next to nothing.
//!
//! A weak name of an inconsistent model that the unseen samples do not confirm is not believed, but deferred. If
//! nothing else is found it is tried once more, and stays only if another name beside it explains what
//! is missing; then it is asked for again beside that one, where its rivals can be told from it.

use super::acceptance::add_by_linear_step;
use super::rounds::look;
use crate::discover::bounds::{HELPS, WORTH_ANOTHER};
use crate::discover::checks::bootstrap::stays_ahead;
use crate::discover::checks::elimination::bare;
use crate::discover::state::rounds::{Contender, Round};
use crate::discover::state::search::Search;
use crate::estimate::fit::Problem;
use crate::estimate::refit::cost;
use crate::plant::BuildError;

/// Adds the name that was deferred, if another one beside it explains what is missing.
///
/// # Errors
/// The model cannot be built.
pub(crate) fn try_deferred(last: Problem<'_>, search: &mut Search) -> Result<(), BuildError> {
    let Some((Contender { name, gain }, stage)) = search.deferred.clone() else { return Ok(()) };
    let mut other = Search { deferred: None, ..search.clone() };
    let stays_ahead = stays_ahead(&stage.fit, &[&search.after.fit], last.mask);
    other.rounds.push(Round { name, gain, rivals: Vec::new(), runner_up: None, stays_ahead });
    other.after = stage;
    look(last, &mut other)?;
    if other.rounds.len() > 1 && other.noise_ratio() < HELPS * search.noise_ratio() {
        ask_again(last.rough(), &mut other)?;
        *search = other;
    }
    Ok(())
}

/// Asks for the first name once more beside the others; keeps the answer if it explains as much.
fn ask_again(problem: Problem<'_>, search: &mut Search) -> Result<(), BuildError> {
    let mut again = search.clone();
    again.after = bare(problem, search, 0)?;
    again.rounds.remove(0);
    let round = again.rounds.len() + 1;
    let added = add_by_linear_step(problem, &mut again, round)?;
    if added && cost(&again.after.fit) < cost(&search.after.fit) + WORTH_ANOTHER {
        *search = again;
    }
    Ok(())
}
