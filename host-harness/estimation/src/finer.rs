//! The values that are told.
//!
//! A filter corrects every sample, so that few micro-steps serve a search: what they leave out is small beside the
//! noise of any one sample. But it is the same in all of them, and bends values by several of their standard errors.

use super::fit::{Fit, Problem};
use super::interrupt;
use joint_simulation::model::Model;
use joint_simulation::plant::BuildError;

/// How many times as many micro-steps values are told with as a fit needs.
pub const FINER: u32 = 2;

/// Rounds: a fit is near already.
const ROUNDS: usize = 3;

/// A fit with the values that the record of `problem` gives it, whose steps are finer; as it was where they are no
/// better there, and when the work is interrupted.
///
/// # Errors
/// The model cannot be built.
pub fn finer(problem: &Problem<'_>, origin: &Model, fit: &Fit) -> Result<Fit, BuildError> {
    if interrupt::asked() {
        return Ok(fit.clone());
    }
    let Fit { model, coordinates, noise, .. } = fit;
    let settled = problem.cautious().fit(origin, model, coordinates, noise, ROUNDS)?;
    Ok(if settled.gained > 0.0 { settled } else { fit.clone() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::Record;
    use crate::refit::refit;
    use joint_simulation::demo::actuator;
    use joint_simulation::synthetic::{Experiment, record};

    #[test]
    fn values_of_coarse_steps_are_bent_and_those_of_finer_ones_are_not() {
        let truth = actuator();
        let experiment = Experiment { sample_time_s: 1e-3, ..Experiment::clean(3.0) };
        let log = record(&truth, &experiment, 3).unwrap();
        let [coarse, fine] = [1, 8].map(|steps| Record::new(&log, Some(steps)));
        let mask = vec![1.0; coarse.len()];
        let fit = refit(&Problem::new(&coarse, &mask), &truth).unwrap();
        let problem = Problem::new(&fine, &mask);
        let settled = finer(&problem, &truth, &fit).unwrap();
        let covariance = problem.covariance(&settled);
        let off = |fit: &Fit| {
            let moved = fit.coordinates.iter().enumerate();
            let squares = moved
                .map(|(k, moved)| moved.distance(&truth, &fit.model).powi(2) / covariance[(k, k)]);
            squares.sum::<f64>() / fit.coordinates.len() as f64
        };
        assert!(off(&fit) > 4.0 && off(&settled) < 2.0, "{} {}", off(&fit), off(&settled));
        // From where it rests it stays.
        let again = finer(&problem, &truth, &settled).unwrap();
        assert!((off(&again) - off(&settled)).abs() < 0.2);
    }
}
