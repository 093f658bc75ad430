//! The effects that were found as the verdict tells them: sizes with their errors, confidence, rivals, and what
//! unseen samples say.

use std::collections::BTreeMap;

use joint_core::effect::EffectParameters;
use nalgebra::DMatrix;

use super::confidence::{Left, confidence};
use super::findings::{Named, knots_of};

use crate::discover::bounds::SIGMAS;
use crate::discover::checks::confirmed::Witnessed;
use crate::discover::evidence::budget::{Budget, Weighed};
use crate::discover::state::search::Search;
use crate::estimate::coordinates::Coordinate;
use crate::estimate::fit::Fit;

/// Every effect that was found, in order. `standing` effects are the given model's own; the rest is `clean` where
/// it is noise.
pub(crate) fn named(
    (found, fit): (&Search, &Fit),
    standing: usize,
    clean: bool,
    (weighed, unseen): (&Weighed, &[Witnessed]),
    covariance: &DMatrix<f64>,
) -> Vec<Named> {
    let tried = found.tried();
    let names: Vec<_> = found.rounds.iter().map(|round| round.name).collect();
    // What is more than a disturbance may be has a cause of its own, whether it is predicted or not, of which an effect
    // may be a part; but for one that other records bear out.
    let cause = |budget: &Budget, unseen: &Witnessed| {
        let held = unseen.elsewhere.is_some_and(|t| t > SIGMAS);
        budget.unnamed + if weighed.is_unbelievable() && !held { budget.coloured } else { 0.0 }
    };
    let effects = fit.model.effects.iter().enumerate().skip(standing);
    let rounds = found.rounds.iter().zip(&weighed.shares).zip(unseen);
    effects
        .zip(rounds)
        .map(|((number, effect), ((round, share), unseen))| {
            let unnamed = weighed.budget.as_ref().map_or(f64::NAN, |own| cause(own, unseen));
            let other = found.constant.filter(|constant| round.name.0 == constant.of);
            let other = other.map(|constant| round.gain + constant.lead);
            // Beside a disturbance a likelihood is not all: unseen samples are asked as well. What a regression is certain
            // of stood out from all that is left there.
            let certain = found.measured.contains(&round.name);
            let left = match certain || clean && !fit.noise.is_disturbed() {
                true => Left::Noise,
                false => Left::more(unnamed, [share.value, share.error], unseen.t(clean), tried),
            };
            let (confidence, rivals) = confidence(round, &names, left, other);
            let (parameters, standard_errors) = sizes(fit, covariance, number, effect);
            let [borne_out, borne_out_error] = unseen.unseen.slope.told();
            Named {
                kind: effect.kind.spec().kind.to_owned(),
                location: effect.location.to_string(),
                unnamed: effect.kind.is_unnamed(),
                parameters,
                knots: knots_of(effect),
                standard_errors,
                confidence,
                share: share.value,
                share_error: share.error,
                borne_out,
                borne_out_error,
                unseen_t: unseen.unseen.t,
                transfer_t: unseen.elsewhere,
                gain: round.gain,
                stays_ahead: round.stays_ahead,
                rivals,
            }
        })
        .collect()
}

/// An effect's values by key, and one sigma of those that were fitted.
fn sizes(
    fit: &Fit,
    covariance: &DMatrix<f64>,
    number: usize,
    effect: &EffectParameters,
) -> (BTreeMap<String, f64>, BTreeMap<String, f64>) {
    let specs = effect.kind.spec().parameters;
    let key = |value: usize| specs.get(value).map_or("", |spec| spec.key).to_owned();
    let parameters =
        specs.iter().zip(effect.values).map(|(spec, value)| (spec.key.to_owned(), value)).collect();
    let mut errors = BTreeMap::new();
    for (k, coordinate) in fit.coordinates.iter().enumerate() {
        match *coordinate {
            Coordinate::Effect { effect: own, value, scale, .. } if own == number => {
                errors.insert(key(value), covariance[(k, k)].sqrt() * scale);
            }
            Coordinate::Phasor { effect: own, amplitude, sine: false, scale, .. }
                if own == number =>
            {
                let (size, phase) = (effect.values[amplitude], effect.values[amplitude + 1]);
                let (cc, ss) = (covariance[(k, k)], covariance[(k + 1, k + 1)]);
                let cs = covariance[(k, k + 1)];
                let (cos, sin) = (phase.cos(), phase.sin());
                let along = cc * cos * cos + ss * sin * sin + 2.0 * cs * cos * sin;
                let across = cc * sin * sin + ss * cos * cos - 2.0 * cs * cos * sin;
                errors.insert(key(amplitude), along.max(0.0).sqrt() * scale);
                if size > 0.0 {
                    let turn = across.max(0.0).sqrt() * scale / size;
                    errors.insert(key(amplitude + 1), turn.min(std::f64::consts::PI));
                }
            }
            _ => {}
        }
    }
    (parameters, errors)
}

#[cfg(test)]
mod tests {
    use joint_core::effect::Kind;
    use joint_core::params::Location;

    use super::*;
    use crate::discover::answer::decision::weighed;
    use crate::discover::state::rounds::Name;
    use crate::discover::trial;
    use crate::estimate::fit::Problem;
    use crate::estimate::record::Record;

    #[test]
    fn what_a_regression_is_certain_of_is_no_leak_of_what_is_left() {
        let nominal = trial::motor();
        let record = Record::new(&trial::log(&nominal, trial::line(12.0), 4.0), None);
        let (tested, mask) = trial::split(&record);
        let problem = Problem::new(&record, &mask).rough();
        let mut found = trial::searched(&problem, &nominal);
        // Samples that bear nothing out.
        let unseen = [Witnessed::default()];
        let noise = found.after.fit.noise;
        let (weighed, _) = weighed(&problem, &found, None, &noise, &tested, &unseen).unwrap();
        let sizes = found.after.fit.coordinates.len();
        let mut confidence = |measured: &[Name]| {
            found.measured = measured.to_vec();
            let covariance = DMatrix::identity(sizes, sizes);
            let told = (&weighed, &unseen[..]);
            named((&found, &found.after.fit), 0, false, told, &covariance)[0].confidence
        };
        assert!(confidence(&[]) < 0.51);
        assert!(confidence(&[(Kind::Cogging, Location::Motor)]) > 0.9);
    }
}
