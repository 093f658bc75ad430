//! Whether the step itself is what is missing.
//!
//! A record is searched at few micro-steps. Gaps and friction that follows the load may ask for more, and
//! what is left out looks like an effect: a gate that complains, or a weak name that is hidden nowhere.

use super::gate::Remainder;
use super::needless::drop_needless;
use super::search::{LEAST_GAIN, Search, Stage, WEAK};
use super::ways::is_hopeless;
use crate::estimate::abreast::Rows;
use crate::estimate::filter::Noise;
use crate::estimate::fit::{Fit, Problem};
use crate::estimate::record::Record;
use crate::estimate::{noise, refit};
use crate::plant::BuildError;
use joint_core::effect::input_delay::delay_s;

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
    if is_hopeless(found) {
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
pub(super) fn is_suspect(found: &Search) -> bool {
    let divided = delay_s(&found.after.fit.model.effects) != 0.0;
    divided || found.rounds.len() > 1 && found.rounds.iter().any(|round| round.gain < WEAK)
}

/// What a fit makes of every sample at a noise: at the first of two `steps`, or at the finer ones where a moment
/// that no fit has seen throws the filter beyond all numbers; and at which.
///
/// # Errors
/// The model cannot be built.
pub(super) fn run_everywhere<'r>(
    steps: [&'r Record; 2],
    fit: &Fit,
    noise: &Noise,
) -> Result<(&'r Record, Rows), BuildError> {
    let run = |record: &Record| {
        let every = vec![1.0; record.len()];
        let design = Problem::new(record, &every).design(&fit.model, noise)?;
        Ok::<Rows, BuildError>(design.innovations)
    };
    let [coarse, fine] = steps;
    let rows = run(coarse)?;
    match rows.iter().flatten().all(|error| error.is_finite()) {
        true => Ok((coarse, rows)),
        false => Ok((fine, run(fine)?)),
    }
}

#[cfg(test)]
mod tests {
    use super::super::trial;
    use super::*;
    use crate::demo::actuator;
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

    #[test]
    fn a_joint_too_stiff_for_the_step_is_thrown_and_not_at_finer_steps() {
        let truth = actuator();
        let experiment = Experiment { sample_time_s: 4e-3, ..Experiment::clean(6.0) };
        let log = record(&truth, &experiment, 3).unwrap();
        let [coarse, fine] = [1, 64].map(|steps| Record::new(&log, Some(steps)));
        let mask = vec![1.0; fine.len()];
        let problem = Problem::new(&fine, &mask);
        let expected = noise::expected(&truth, &fine);
        let Stage { fit, .. } = trial::fitted(&problem, &truth, &[]);
        let mut stiff = fit.clone();
        stiff.model.stages[0].stiffness_nm_per_rad *= 1e3;
        let at = |fit: &Fit, first| run_everywhere([first, &fine], fit, &expected).unwrap();
        for (fit, first, taken) in [(&fit, &fine, &fine), (&stiff, &coarse, &fine)] {
            let (record, rows) = at(fit, first);
            assert!(std::ptr::eq(record, taken));
            assert!(rows.iter().flatten().all(|error| error.is_finite()));
        }
    }
}
