//! What was measured before the search: effects that plain regressions over windows are certain of.
//!
//! Noise that differs from sample to sample hides from a filter what a regression over many of them shows
//! plainly. Such an effect is fitted first, from its measured value, and stays if that makes the log likelier.

use joint_core::effect::EffectParameters;

use super::bootstrap::stays_ahead;
use super::candidates::{self, Scene};
use super::hypothesis::Hypothesis;
use super::protected::gained;
use super::score_test::ScoreTest;
use super::search::{MOST_EFFECTS, Round, Search, Stage};
use crate::estimate::fit::Problem;
use crate::estimate::refit;
use crate::interrupt;
use crate::plant::BuildError;

/// Adds those of the measured effects that make the log likelier.
///
/// # Errors
/// The model cannot be built.
pub(super) fn add_measured(
    problem: Problem<'_>,
    search: &mut Search,
    measured: &[EffectParameters],
) -> Result<(), BuildError> {
    for effect in measured {
        let Some(hypothesis) = begun(problem, search, effect) else { continue };
        if search.rounds.len() >= MOST_EFFECTS || interrupt::asked() {
            break;
        }
        let base = &search.after;
        let (origin, moved) = base.widened(&hypothesis);
        let (start, noise) = (hypothesis.added(&base.fit.model), &base.fit.noise);
        let fit = refit::polish(&problem, &origin, &start, &moved, &search.expected, noise)?;
        let gain = gained(&base.fit, &fit);
        // Regressions are certain of it already: the likelihood has only to go along.
        if gain > 0.0 && search.believes(&fit.model, problem.record) {
            let stays_ahead = stays_ahead(&fit, &[&search.after.fit], problem.mask);
            let (name, rivals) = (hypothesis.name(), Vec::new());
            search.rounds.push(Round { name, gain, rivals, runner_up: None, stays_ahead });
            search.measured.push(name);
            search.after = Stage { fit, origin };
        }
    }
    Ok(())
}

/// What candidates propose of an effect, begun at what was measured.
fn begun(problem: Problem<'_>, search: &Search, effect: &EffectParameters) -> Option<Hypothesis> {
    let Stage { fit, origin } = &search.after;
    let test = ScoreTest::new(problem, origin, fit, 0)?;
    let scene = Scene::new(&fit.model, problem.record, &test);
    let proposed = candidates::proposed(&scene, &search.withdrawn);
    let own = proposed.into_iter().find(|it| it.name() == (effect.kind, effect.location))?;
    Some(Hypothesis { start: *effect, ..own })
}
