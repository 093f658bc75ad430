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

/// The answer. It is unknown where something that matters is left without a name: what is predictable, what exceeds
/// what friction, supply and sensors are believed to scatter by, or what makes a model fail on samples that no fit
/// has seen. A disturbance that is no larger than that is no law that is missing.
pub(crate) fn answered(named: bool, left: &Remainder, weighed: &Weighed) -> Answer {
    let noise = left.complaints(!named).is_empty();
    let unknown = match &weighed.budget {
        Some(budget) => {
            let fails = !noise && left.fails_unseen();
            let large = weighed.is_unbelievable();
            // What a sensor shows beside the truth is no share of what it shows.
            matters(budget) || fails || large && (weighed.of_sensor || budget.left_matters())
        }
        None => !noise,
    };
    match named {
        _ if unknown => Answer::Unknown,
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

impl Budget {
    /// Whether all that is left beside white noise is more than a model is allowed to miss.
    fn left_matters(&self) -> bool {
        self.left_of_drive.is_none_or(|share| share > TOLERANCE)
    }
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
        return Ok((Weighed { shares, ..Weighed::default() }, free_run()?));
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
    fn only_a_remainder_that_matters_and_is_predictable_or_large_or_fails_makes_the_answer_unknown()
    {
        let quiet = Remainder { drive: 1.0, torque: 1.0, unseen: 1.0, ..Remainder::default() };
        let loud = Remainder { torque: 10.0, ..quiet.clone() };
        let failing = Remainder { unseen: 2.0, ..loud.clone() };
        let of = |share: Option<f64>| {
            let budget = Budget {
                unnamed: 0.1,
                unnamed_of_drive: share,
                left_of_drive: share,
                ..Budget::default()
            };
            Weighed { budget: Some(budget), ..Weighed::default() }
        };
        let (little, much) = (of(Some(0.5 * TOLERANCE)), of(Some(2.0 * TOLERANCE)));
        // Of what follows nothing.
        let wandering = |share: f64, over_believable: f64| {
            let budget = Budget { left_of_drive: Some(share * TOLERANCE), ..Budget::default() };
            Weighed { budget: Some(budget), over_believable, ..Weighed::default() }
        };
        let none = Weighed::default();
        for (named, told) in [(true, Answer::Effect), (false, Answer::Adequate)] {
            assert_eq!(answered(named, &quiet, &little), told);
            assert_eq!(answered(named, &quiet, &none), told);
            assert_eq!(answered(named, &loud, &little), told);
            assert_eq!(answered(named, &quiet, &much), Answer::Unknown);
            assert_eq!(answered(named, &loud, &of(None)), Answer::Unknown);
            assert_eq!(answered(named, &loud, &none), Answer::Unknown);
            assert_eq!(answered(named, &failing, &little), Answer::Unknown);
            // Friction wanders by a little; more is a cause that is not known, if it matters.
            assert_eq!(answered(named, &quiet, &wandering(2.0, 0.7)), told);
            assert_eq!(answered(named, &quiet, &wandering(2.0, 2.0)), Answer::Unknown);
            assert_eq!(answered(named, &quiet, &wandering(0.5, 2.0)), told);
            let behind = |share| Weighed { white_behind: 9.0, ..wandering(share, 0.7) };
            assert_eq!(answered(named, &quiet, &behind(2.0)), Answer::Unknown);
            assert_eq!(answered(named, &quiet, &behind(0.5)), told);
            let sensor = |over| Weighed { of_sensor: true, ..wandering(0.5, over) };
            assert_eq!(answered(named, &quiet, &sensor(2.0)), Answer::Unknown);
            assert_eq!(answered(named, &quiet, &sensor(0.7)), told);
            // A share that is no more certain than this might be half as large.
            let mut unsure = much.clone();
            unsure.budget.iter_mut().for_each(|budget| budget.unnamed_error = 0.05);
            assert_eq!(answered(named, &quiet, &unsure), told);
        }
    }
}
