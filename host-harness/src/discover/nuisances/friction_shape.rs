//! Friction of another shape than the model's, found before anything is called missing.
//!
//! Another simulator's friction gives way below breakaway, and a lubricant thins with the speed. Neither is an effect
//! that is missing: it is how this joint rubs. Where what a search leaves is not noise, the nominal is refitted with
//! friction of such a shape on every mass that rubs, and searched again.

use indicatif::ProgressBar;
use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::{Friction, Location};
use rayon::prelude::*;

use crate::discover::bounds::{HELPS, LEAST_GAIN, LOST};
use crate::discover::candidates::friction_shape;
use crate::discover::search::search;
use crate::discover::state::search::Search;
use crate::discover::state::stage::Stage;
use crate::estimate::coordinates::Coordinate;
use crate::estimate::fit::Problem;
use crate::estimate::refit::{self, cost};
use crate::interrupt;
use crate::model::Model;
use crate::plant::BuildError;
use crate::plot::text::si;

/// A value of the effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Value {
    Creep,
    Thinning,
}

impl Value {
    /// Its place among the effect's.
    fn place(self) -> usize {
        match self {
            Value::Creep => 0,
            Value::Thinning => 1,
        }
    }

    /// Size at which it matters, where friction falls at the speed `slow`.
    fn scale(self, slow: f64) -> f64 {
        match self {
            Value::Creep => 0.1 * slow,
            Value::Thinning => 0.3 / (TYPICAL * slow),
        }
    }
}

/// One sigma of a value's prior, in scales.
const SIGMA: f64 = 10.0;
/// Stribeck velocities that a joint without other knowledge mostly moves at.
const TYPICAL: f64 = 10.0;

/// The nominal with friction of another shape, as it was fitted, and what a search from there finds, where that makes
/// the log likelier by more than its values should and leaves less of the noise.
///
/// # Errors
/// The nominal cannot be built.
pub(crate) fn shaped(
    problem: Problem<'_>,
    nominal: &Model,
    found: &Search,
    known: (&[Kind], &[EffectParameters]),
    bar: &ProgressBar,
) -> Result<Option<(Model, Search)>, BuildError> {
    let rubbing: Vec<_> = nominal.sticking().collect();
    if rubbing.is_empty() || interrupt::asked() {
        return Ok(None);
    }
    bar.set_message("asking whether friction is of another shape");
    let samples = problem.mask.iter().sum::<f64>().max(2.0);
    let price = LEAST_GAIN + samples.ln() * rubbing.len() as f64;
    let expected = &found.expected;
    let plain = &found.before.fit;
    let trials = [Value::Creep, Value::Thinning].into_par_iter().map(|value| {
        let Stage { fit, origin } = with_shape(&found.before, &rubbing, value);
        let fit =
            refit::polish(&problem, &origin, &fit.model, &fit.coordinates, expected, &fit.noise)?;
        Ok(Stage { fit, origin })
    });
    let trials = trials.collect::<Result<Vec<_>, BuildError>>()?;
    let likelier = |Stage { fit, .. }: &Stage| {
        let helps = fit.noise.times(expected) < HELPS * plain.noise.times(expected);
        helps && cost(fit) + price < cost(plain)
    };
    let trials = trials.into_iter().filter(likelier);
    let Some(Stage { fit, mut origin }) =
        trials.min_by(|a, b| cost(&a.fit).total_cmp(&cost(&b.fit)))
    else {
        return Ok(None);
    };
    let fit = refit::converge(&problem, &origin, fit, expected)?;
    origin.effects.clone_from(&fit.model.effects);
    let other = search(problem, &origin, fit, known, bar)?;
    let owed = |search: &Search| cost(&search.after.fit) + LEAST_GAIN * search.rounds.len() as f64;
    // Of a model that is still inconsistent it is not friction that is of another shape.
    let stands = owed(&other) + price < owed(found) && other.noise_ratio() <= LOST;
    Ok(stands.then_some((origin, other)))
}

/// A model with this value free on every mass that rubs.
fn with_shape(stage: &Stage, rubbing: &[(Location, Friction)], value: Value) -> Stage {
    let Stage { mut fit, mut origin } = stage.clone();
    for (place, friction) in rubbing {
        let slow = friction.stribeck_velocity_rad_per_s;
        let scale = value.scale(slow);
        let (effect, value) = (origin.effects.len(), value.place());
        let mut shape = friction_shape::at(*place);
        shape.values[value] = scale;
        fit.coordinates.push(Coordinate::Effect { effect, value, scale, sigma: SIGMA });
        origin.effects.push(shape);
        fit.model.effects.push(shape);
    }
    Stage { fit, origin }
}

/// What the shape of friction is, in sentences.
pub(crate) fn told(model: &Model) -> impl Iterator<Item = String> {
    let shapes = friction_shape::shapes_in(model);
    shapes.flat_map(|shape| {
        let [creep, thinning, ..] = shape.values;
        let place = shape.location.to_string();
        let creeps = (creep > 0.0).then(|| {
            let speed = si(creep, "rad/s", 2);
            format!("friction ({place}) creeps below breakaway: as tanh of the speed over {speed}")
        });
        let thins = (thinning > 0.0).then(|| {
            let speed = si(1.0 / thinning, "rad/s", 2);
            format!("viscous friction ({place}) falls with the speed: its coefficient is halved at {speed}")
        });
        creeps.into_iter().chain(thins)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discover::trial;
    use crate::estimate::noise;
    use crate::estimate::record::Record;

    /// What is asked of a log in which the motor's friction has this shape, and the shape's values.
    fn asked(creep: f64, thinning: f64) -> Option<(Model, Search)> {
        let nominal = trial::motor();
        let shape = EffectParameters::new(Kind::FrictionShape, Location::Motor)
            .with("creep_rad_per_s", creep)
            .with("thinning_s_per_rad", thinning);
        let record = Record::new(&trial::log(&nominal, shape, 4.0), None);
        let mask = vec![1.0; record.len()];
        let problem = Problem::new(&record, &mask).rough();
        let expected = noise::expected(&nominal, &record);
        let found = Search::new(trial::fitted(&problem, &nominal, &[]), &[], expected);
        shaped(problem, &nominal, &found, (&[], &[]), &ProgressBar::hidden()).unwrap()
    }

    #[test]
    fn friction_of_another_shape_is_found_and_nothing_is_missing_then() {
        let slow = trial::motor().motor.friction.stribeck_velocity_rad_per_s;
        for (value, creep, thinning) in [(0, 0.5 * slow, 0.0), (1, 0.0, 0.05 / slow)] {
            let (model, other) = asked(creep, thinning).unwrap();
            assert!(other.rounds.is_empty(), "{:?}", other.rounds);
            let found = model.effects[0].values[value];
            let hidden = [creep, thinning][value];
            assert!((found / hidden - 1.0).abs() < 0.1, "{found} {hidden}");
            assert_eq!(told(&model).count(), 1);
        }
        assert!(asked(0.0, 0.0).is_none());
    }
}
