//! The search: refit, look for what is missing, add the best name, and look again.
//!
//! Each round asks the proposals of the base as it stands (`rounds`; of a base that is inconsistent in several ways,
//! `strategies`), and adds the best name if it holds (`acceptance`). A nominal without names may be stuck in a local
//! minimum, and is refitted from elsewhere (`refits`); one that is inconsistent may miss two effects that hide each
//! other (`deferred`); and the way that a close second leads is gone as well (`beam`). At the end every effect has to
//! prove that it is still needed.

pub(crate) mod acceptance;
mod beam;
mod deferred;
mod measured;
mod refits;
mod rounds;
mod strategies;

use indicatif::ProgressBar;
use joint_core::effect::{EffectParameters, Kind};

use self::beam::try_close_second;
use self::deferred::try_deferred;
use self::measured::add_measured;
use self::refits::{fit_from_elsewhere, is_clean, may_be_stuck, settle};
use self::rounds::look;
use crate::discover::bounds::{DOUBTED, LEAST_GAIN, LOST};
use crate::discover::checks::elimination::drop_needless;
use crate::discover::state::search::Search;
use crate::discover::state::stage::Stage;
use crate::estimate::fit::{Fit, Problem};
use crate::estimate::noise;
use crate::interrupt;
use crate::model::Model;
use crate::plant::BuildError;

/// Runs the search from the nominal's refit; kinds that are `withdrawn` are not on the list, and effects that
/// were `measured` are asked first.
///
/// # Errors
/// The nominal cannot be built.
pub(crate) fn search(
    problem: Problem<'_>,
    nominal: &Model,
    fit: Fit,
    (withdrawn, measured): (&[Kind], &[EffectParameters]),
    bar: &ProgressBar,
) -> Result<Search, BuildError> {
    let expected = noise::expected(nominal, problem.record);
    let before = Stage { fit, origin: nominal.clone() };
    // Contenders are told apart by tens; the model that is left in the end is polished.
    let last = problem;
    let mut search = Search::new(before, withdrawn, expected);
    search.bar = bar.clone();
    add_measured(last.rough(), &mut search, measured)?;
    look(last, &mut search)?;
    if search.rounds.is_empty() && may_be_stuck(&last, &search)? {
        look_from_elsewhere(last, &mut search)?;
    }
    if search.rounds.is_empty() && search.noise_ratio() > LOST {
        try_deferred(last, &mut search)?;
    }
    try_close_second(last, &mut search)?;
    if interrupt::asked() {
        return Ok(search);
    }
    if !search.rounds.is_empty() {
        prove(last, &mut search)?;
        if search.rounds.is_empty() && !interrupt::asked() {
            // All was owed to a fit of the nominal that was stuck.
            search.before = search.after.clone();
            look_from_elsewhere(last, &mut search)?;
            prove(last, &mut search)?;
        }
    }
    Ok(search)
}

/// Looks again from a nominal fitted from elsewhere, where that one is likelier.
fn look_from_elsewhere(last: Problem<'_>, search: &mut Search) -> Result<(), BuildError> {
    search.bar.set_message("fitting the given model from other starts");
    if fit_from_elsewhere(&last, search)? > LEAST_GAIN {
        search.deferred = None;
        look(last, search)?;
    }
    Ok(())
}

/// Lets every effect that was found prove that it is needed, now and when the springs are settled.
fn prove(last: Problem<'_>, search: &mut Search) -> Result<(), BuildError> {
    let problem = last.rough();
    search.bar.set_message("asking whether each effect is needed");
    let found = search.rounds.len();
    drop_needless(problem, search, false)?;
    if (1..found).contains(&search.rounds.len()) && search.noise_ratio() > DOUBTED {
        look(last, search)?;
        drop_needless(problem, search, false)?;
    }
    if search.rounds.is_empty() {
        return Ok(());
    }
    search.bar.set_message("fitting the springs of the gear again");
    if !search.has_not_improved() {
        let clean = is_clean(&last, search)?;
        settle(&last, search, clean)?;
    }
    drop_needless(last, search, true)
}
