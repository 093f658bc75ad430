//! Whether the step itself is what is missing.
//!
//! A record is searched at few micro-steps. Gaps and friction that follows the load may ask for more, and
//! what is left out looks like an effect: a gate that complains, or a weak name that is hidden nowhere.

use super::elimination::drop_needless;
use super::goodness_of_fit::Remainder;
use crate::discover::bounds::{CALMER, LEAST_GAIN, WEAK};
use crate::discover::state::search::Search;
use crate::discover::state::stage::Stage;

use crate::estimate::fit::{Fit, Problem};
use crate::estimate::{noise, refit};
use crate::plant::BuildError;
use joint_core::effect::input_delay::delay_s;

/// Rounds of the fit that shows whether finer steps help.
const ROUNDS: usize = 2;

/// Goes on at finer steps, those of `problem`, if they explain something by themselves, take away what the
/// gate complains of, or make an effect needless. Answers with what is left then.
///
/// # Errors
/// The model cannot be built.
pub(crate) fn ask_finer(
    problem: &Problem<'_>,
    found: &mut Search,
    coarse: &Remainder,
) -> Result<Option<Remainder>, BuildError> {
    if found.has_not_improved_though_near() {
        return Ok(None);
    }
    let Stage { fit, origin } = &found.after;
    let (moved, expected) = (&fit.coordinates, &found.expected);
    let gained = fit.deviance - problem.design(&fit.model, &fit.noise)?.deviance;
    let complaints = coarse.complaints(false).len();
    let names = found.rounds.len();
    let suspect = is_suspect(found);
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
    let (rough, noise) = (problem.rough(), &better.noise);
    // A sound fit is near already, and has its noise.
    let enough = |_: &Fit| complaints == 0;
    let better =
        refit::polish_unless(enough, &rough, origin, &better.model, moved, expected, noise)?;
    let mut other = found.clone();
    other.after = Stage { fit: better, origin: origin.clone() };
    let asked_for_names = gained < LEAST_GAIN && !calmer;
    drop_needless(problem.rough(), &mut other, asked_for_names)?;
    if asked_for_names && other.rounds.len() == names {
        return Ok(None);
    }
    *found = other;
    Ok(Some(Remainder::of(problem, &found.after.fit, &found.expected, problem.mask)?))
}

/// Whether a weak name stands beside others, where coarse steps may have made it, or a model whose input acts
/// late: it divides the intervals, which is a finer step by itself.
pub(crate) fn is_suspect(found: &Search) -> bool {
    let divided = delay_s(&found.after.fit.model.effects) != 0.0;
    divided || found.rounds.len() > 1 && found.rounds.iter().any(|round| round.gain < WEAK)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo::actuator;
    use crate::discover::trial;
    use crate::estimate::record::Record;
    use crate::synthetic::{Experiment, record};

    #[test]
    fn what_coarse_steps_leave_out_is_asked_of_finer_ones() {
        let truth = actuator();
        let experiment = Experiment { sample_time_s: 4e-3, ..Experiment::clean(6.0) };
        let log = record(&truth, &experiment, 3).unwrap();
        let [coarse, fine] = [1, 16].map(|steps| Record::new(&log, Some(steps)));
        let mask = vec![1.0; coarse.len()];
        let [coarse, fine] = [&coarse, &fine].map(|record| Problem::new(record, &mask));
        let expected = noise::expected(&truth, coarse.record);
        let asked = |begun: &Problem<'_>, finer: &Problem<'_>| {
            let stage = trial::fitted(begun, &truth, &[]);
            let mut found = Search::new(stage, &[], expected);
            let left = Remainder::of(begun, &found.after.fit, &expected, &mask).unwrap();
            let better = ask_finer(finer, &mut found, &left).unwrap();
            (left.torque, better.map(|better| better.torque))
        };
        let (begun, ended) = asked(&coarse, &fine);
        assert!(ended.is_some_and(|ended| ended < 0.5 * begun), "{begun} {ended:?}");
        assert!(asked(&fine, &fine).1.is_none());
    }
}
