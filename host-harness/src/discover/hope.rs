//! Two effects that hide each other: either alone explains next to nothing.
//!
//! A weak name of a lost model that the unseen samples do not bear out is not believed, but kept. If
//! nothing else is found it is tried once more, and stays only if another name beside it explains what
//! is missing; then it is asked for again beside that company, where its rivals can be told from it.

use super::bootstrap::stays_ahead;
use super::needless::bare;
use super::search::{
    Contender, HELPS, Round, Search, Stage, WORTH_ANOTHER, add_settled, excess, look,
};
use crate::estimate::fit::Problem;
use crate::estimate::refit::cost;
use crate::plant::BuildError;

impl Search {
    /// Keeps a weak name that the unseen samples do not bear out, if it is the best of its like.
    pub(super) fn hope(&mut self, contender: Contender, stage: Stage) {
        let best = self.hope.as_ref().is_none_or(|(_, best)| cost(&stage.fit) < cost(&best.fit));
        if best && self.rounds.is_empty() {
            self.hope = Some((contender, stage));
        }
    }
}

/// Adds the name that was hoped for, if another one beside it explains what is missing.
///
/// # Errors
/// The model cannot be built.
pub(super) fn try_hope(last: Problem<'_>, search: &mut Search) -> Result<(), BuildError> {
    let Some((Contender { name, gain }, stage)) = search.hope.clone() else { return Ok(()) };
    let mut other = Search { hope: None, ..search.clone() };
    let stays_ahead = stays_ahead(&stage.fit, &[&search.after.fit], last.mask);
    other.rounds.push(Round { name, gain, rivals: Vec::new(), runner_up: None, stays_ahead });
    other.after = stage;
    look(last, &mut other)?;
    if other.rounds.len() > 1 && excess(&other) < HELPS * excess(search) {
        ask_again(last.rough(), &mut other)?;
        *search = other;
    }
    Ok(())
}

/// Asks for the first name once more beside its company; keeps the answer if it explains as much.
fn ask_again(problem: Problem<'_>, search: &mut Search) -> Result<(), BuildError> {
    let mut again = search.clone();
    again.after = bare(problem, search, 0)?;
    again.rounds.remove(0);
    let round = again.rounds.len() + 1;
    let added = add_settled(problem, &mut again, round)?;
    if added && cost(&again.after.fit) < cost(&search.after.fit) + WORTH_ANOTHER {
        *search = again;
    }
    Ok(())
}
