//! Whether a weak name's gain is its own: not that of a better fit of all the rest, nor of samples that
//! happened to be fitted.

use super::noise_ratio::is_as_expected;
use crate::discover::bounds::PLAIN_TORQUE_RATIO;
use crate::estimate::filter::Noise;
use crate::estimate::fit::{Fit, Problem};
use crate::model::Model;
use crate::plant::BuildError;

/// Whether of a strong name, by what it gained and what of that is its own, a better fit of all the rest leaves
/// a `weak` one that nothing confirms: then that fit is the base that names are to be asked for beside.
pub(crate) fn owed_to_the_rest(
    problem: Problem<'_>,
    simpler: &Fit,
    fit: &Fit,
    [gain, own, weak]: [f64; 3],
    expected: &Noise,
) -> Result<bool, BuildError> {
    Ok(gain >= weak && own < weak && !holds(problem, simpler, fit, expected)?)
}

/// Whether what a fit has more than another, the simpler one, is confirmed: by noise that is as expected
/// where the simpler one needs more than any right model, or by samples that none has seen, if it makes them
/// likelier. Both are asked at either's noise: at its own, which is less, the better one would have to
/// answer for that as well.
pub(crate) fn holds(
    problem: Problem<'_>,
    simpler: &Fit,
    fit: &Fit,
    expected: &Noise,
) -> Result<bool, BuildError> {
    if simpler.noise.times(expected) > PLAIN_TORQUE_RATIO && is_as_expected(&fit.noise, expected) {
        return Ok(true);
    }
    let unseen: Vec<f64> = problem.mask.iter().map(|seen| 1.0 - seen).collect();
    let unseen = Problem { mask: &unseen, ..problem };
    let deviance =
        |model: &Model, noise: &Noise| unseen.design(model, noise).map(|run| run.deviance);
    let lost = |noise: &Noise| {
        let (own, other) =
            rayon::join(|| deviance(&fit.model, noise), || deviance(&simpler.model, noise));
        Ok::<f64, BuildError>(own? - other?)
    };
    Ok(lost(&simpler.noise)? + lost(&fit.noise)? <= 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discover::candidates::cogging;
    use crate::discover::trial;
    use crate::estimate::noise;
    use crate::estimate::record::Record;

    /// Share of its noise that a fit is made to claim.
    const SHARE: f64 = 0.1;

    #[test]
    fn a_name_is_not_asked_to_answer_for_its_smaller_noise() {
        let nominal = trial::motor();
        let record = Record::new(&trial::log(&nominal, trial::line(12.0), 4.0), None);
        let seen: Vec<f64> =
            (0..record.len()).map(|k| if k % 1000 < 700 { 1.0 } else { 0.0 }).collect();
        let problem = Problem::new(&record, &seen).rough();
        // Nothing is calm beside this: only the unseen samples count.
        let expected = noise::expected(&nominal, &record);
        let expected = Noise { torque: 1e-3 * expected.torque, ..expected };
        let simpler = trial::fitted(&problem, &nominal, &[]).fit;
        let Fit { model, noise, .. } =
            trial::fitted(&problem, &nominal, &[cogging::line(12.0, 0.01, false)]).fit;
        let noise = Noise {
            drive: SHARE * noise.drive,
            torque: SHARE * noise.torque,
            output: SHARE * noise.output,
            sensors: noise.sensors.map(|sigma| SHARE * sigma),
            ..noise
        };
        let proud = Fit { model, noise, ..simpler.clone() };
        let unseen: Vec<f64> = seen.iter().map(|seen| 1.0 - seen).collect();
        let own = |fit: &Fit| {
            let unseen = Problem { mask: &unseen, ..problem };
            unseen.design(&fit.model, &fit.noise).unwrap().deviance
        };
        assert!(own(&proud) > own(&simpler), "{} {}", own(&proud), own(&simpler));
        assert!(holds(problem, &simpler, &proud, &expected).unwrap());
        let owed = |fit: &Fit, gains: [f64; 3]| {
            owed_to_the_rest(problem, &simpler, fit, gains, &expected).unwrap()
        };
        assert!(!owed(&proud, [2.0, 0.5, 1.0]));
        let wrong = Fit { model: flipped(&proud.model), ..proud };
        assert!(!holds(problem, &simpler, &wrong, &expected).unwrap());
        assert!(owed(&wrong, [2.0, 0.5, 1.0]));
        assert!(!owed(&wrong, [3.0, 2.0, 1.0]));
    }

    /// The same line the other way round.
    fn flipped(model: &Model) -> Model {
        let mut model = model.clone();
        model.effects[0].values[1] *= -1.0;
        model
    }
}
