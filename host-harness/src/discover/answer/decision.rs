//! The decision: what the evidence makes of a model with or without names.

use super::findings::Answer;
use crate::discover::bounds::{SIGMAS, TOLERANCE};
use crate::discover::checks::confirmed::Witnessed;
use crate::discover::checks::goodness_of_fit::Remainder;
use crate::discover::evidence::blocks::Share;
use crate::discover::evidence::budget::{Budget, FreeRun, Weighed, weigh};
use crate::discover::state::search::Search;
use crate::estimate::filter::{Noise, Walk};
use crate::estimate::fit::Problem;
use crate::interrupt;
use crate::plant::BuildError;

/// The answer. Where nothing has a name, a disturbance that is more than a joint's own makes it unknown: what
/// drives the joint is then not known. So does what is predictable and matters; and a remainder that is no noise,
/// where the model fails on samples that no fit has seen, or where nobody could look. A disturbance that follows
/// nothing is no law that is missing.
pub(crate) fn answered(named: bool, left: &Remainder, budget: Option<&Budget>) -> Answer {
    let noise = left.complaints(!named).is_empty();
    match named {
        false if left.is_driven() => Answer::Unknown,
        _ if budget.is_some_and(matters) => Answer::Unknown,
        _ if !noise && (budget.is_none() || left.fails_unseen()) => Answer::Unknown,
        true => Answer::Effect,
        false => Answer::Adequate,
    }
}

/// Whether what is predictable and has no name is more than a model is allowed to miss, beyond its standard error.
pub(crate) fn matters(budget: &Budget) -> bool {
    let Budget { unnamed, unnamed_error, unnamed_of_drive, .. } = budget;
    let sure = ((unnamed - SIGMAS * unnamed_error) / unnamed).max(0.0).sqrt();
    *unnamed > 0.0 && unnamed_of_drive.is_none_or(|share| sure * share > TOLERANCE)
}

/// What the effects explain in proportion, and how both models run free, on samples that no fit has seen.
pub(crate) fn weighed(
    problem: &Problem<'_>,
    found: &Search,
    walk: Option<Walk>,
    noise: &Noise,
    held_out: &[bool],
    effects: &[Witnessed],
) -> Result<(Weighed, FreeRun), BuildError> {
    let models = [&found.before.fit, &found.after.fit];
    let free_run = || FreeRun::of(problem.record, models, noise, held_out);
    let Some(walk) = walk.filter(|_| !interrupt::asked()) else {
        let shares = vec![Share::default(); effects.len()];
        return Ok((Weighed { budget: None, shares }, free_run()?));
    };
    let effects: Vec<_> = effects.iter().map(|own| own.unseen.clone()).collect();
    let evidence = || weigh(problem, models, walk, [noise, &found.expected], held_out, &effects);
    let (weighed, free_run) = rayon::join(evidence, free_run);
    Ok((weighed?, free_run?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_remainder_that_is_predictable_and_matters_or_fails_makes_the_answer_unknown() {
        let quiet = Remainder { drive: 1.0, torque: 1.0, unseen: 1.0, ..Remainder::default() };
        let loud = Remainder { torque: 10.0, ..quiet.clone() };
        let failing = Remainder { unseen: 2.0, ..loud.clone() };
        let of = |share| Budget { unnamed: 0.1, unnamed_of_drive: share, ..Budget::default() };
        let (little, much) = (of(Some(0.5 * TOLERANCE)), of(Some(2.0 * TOLERANCE)));
        for (named, told) in [(true, Answer::Effect), (false, Answer::Adequate)] {
            assert_eq!(answered(named, &quiet, Some(&little)), told);
            assert_eq!(answered(named, &quiet, None), told);
            assert_eq!(answered(named, &loud, Some(&little)), told);
            assert_eq!(answered(named, &quiet, Some(&much)), Answer::Unknown);
            assert_eq!(answered(named, &loud, Some(&of(None))), Answer::Unknown);
            assert_eq!(answered(named, &failing, Some(&little)), Answer::Unknown);
            assert_eq!(answered(named, &loud, None), Answer::Unknown);
            // A share that is no more certain than this might be half as large.
            let unsure = Budget { unnamed_error: 0.05, ..much.clone() };
            assert_eq!(answered(named, &quiet, Some(&unsure)), told);
        }
        // Where nothing has a name, more than friction wanders by is a cause that is not known.
        let driven = Remainder { disturbed: 20.0, ..quiet };
        assert_eq!(answered(true, &driven, Some(&little)), Answer::Effect);
        assert_eq!(answered(false, &driven, Some(&little)), Answer::Unknown);
    }
}
