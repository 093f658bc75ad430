//! How far off a fit's values may be.
//!
//! The curvature of the likelihood says it where the model is right and the innovations are white. What disturbs a
//! joint lasts longer than a sample, so that many samples tell the same; and a law that is not quite the joint's own
//! bends the values next to it. So the curvature counts what the scores of whole blocks of the log scatter by (the
//! sandwich of Huber, Proc. 5th Berkeley Symp., 1967, and White, Econometrica 50, 1982), and laws that may differ
//! in shape are set free beside the coordinates, each with a prior.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;
use joint_core::per_unit::Bases;
use nalgebra::{DMatrix, DVector};

use super::coordinates::precision;
use super::fit::{Fit, Problem};
use super::gram::gram;
use super::record::{CHANNELS, Record};
use super::scales::speed_scale;
use joint_simulation::model::Model;

/// Blocks whose scores are compared: few enough to outlast a slow disturbance, many enough for a variance.
const BLOCKS: usize = 20;

impl Problem<'_> {
    /// Covariance of a fit's coordinates.
    pub fn covariance(&self, fit: &Fit) -> DMatrix<f64> {
        let beside = &other_frictions(&fit.model, self.record);
        let own = fit.coordinates.len();
        let count = own + beside.len();
        let jacobian = self.sensitivity(&fit.model, &fit.gains, &fit.coordinates, None);
        let residual = self.residual(&fit.innovations);
        let mut jacobian = jacobian.resize_horizontally(count, 0.0);
        for (k, run) in self.innovations_of(beside, &fit.gains).into_iter().enumerate() {
            // One that diverges tells nothing.
            let Some(run) = run.filter(|run| self.sum_of_squares(run).is_finite()) else {
                continue;
            };
            jacobian.column_mut(own + k).copy_from(&(self.residual(&run) - &residual));
        }
        let mut priors = DMatrix::identity(count, count);
        for (k, precision) in precision(&fit.coordinates).iter().enumerate() {
            priors[(k, k)] = *precision;
        }
        let curvature = gram(&jacobian) + priors;
        let Some(inverse) = curvature.cholesky().map(|c| c.inverse()) else {
            return DMatrix::zeros(own, own);
        };
        let scores = self.scores(&jacobian, &residual);
        let many = scores.len().max(1) as f64;
        let mean = scores.iter().fold(DVector::zeros(count), |sum, score| sum + score) / many;
        let mut moved = DMatrix::<f64>::zeros(count, count);
        for score in &scores {
            let step = &inverse * (score - &mean);
            moved.ger(many / (many - 1.0).max(1.0), &step, &step, 1.0);
        }
        // Scores that scatter less than the curvature says do so by chance.
        let more = (0..own).map(|k| moved[(k, k)] / inverse[(k, k)]);
        let more = more.map(|more| if more.is_finite() { more.max(1.0).sqrt() } else { 1.0 });
        let more = DMatrix::from_diagonal(&DVector::from_iterator(own, more));
        &more * inverse.view((0, 0), (own, own)) * &more
    }

    /// Half the gradient of the sum of squares, block by block of as many samples that are fitted to.
    fn scores(&self, jacobian: &DMatrix<f64>, residual: &DVector<f64>) -> Vec<DVector<f64>> {
        let samples = residual.len() / CHANNELS;
        let fitted: Vec<usize> = (0..samples).filter(|k| self.mask[*k] > 0.0).collect();
        let blocks = fitted.chunks(fitted.len().div_ceil(BLOCKS).max(1));
        let score = |block: &[usize]| {
            let rows = || block.iter().flat_map(|k| k * CHANNELS..(k + 1) * CHANNELS);
            let slope =
                |column: usize| rows().map(|row| jacobian[(row, column)] * residual[row]).sum();
            DVector::from_iterator(jacobian.ncols(), (0..jacobian.ncols()).map(slope))
        };
        blocks.map(score).collect()
    }
}

/// One sigma of the prior of a creep below breakaway, in Stribeck velocities.
const CREEP: f64 = 0.1;

/// Models whose friction is of another shape by one sigma of its prior, on one mass each, where the model does not have
/// that shape already: it creeps below breakaway, or its viscous coefficient is halved at the highest speed.
fn other_frictions(model: &Model, record: &Record) -> Vec<Model> {
    let fastest = speed_scale(record);
    let bases = Bases::si(&model.motor, &model.stages);
    let shapes = model.sticking().flat_map(|(place, friction)| {
        let shaft = bases.mass(place).map_or(1.0, |mass| bases.shaft(mass).abs());
        let creep = CREEP * friction.stribeck_velocity_rad_per_s;
        [(place, "creep_rad_per_s", creep), (place, "thinning_s_per_rad", 1.0 / (fastest * shaft))]
    });
    let possible = shapes.filter(|(_, _, value)| *value > 0.0 && value.is_finite());
    possible.filter_map(|(place, key, value)| shaped(model, place, key, value)).collect()
}

/// A model with this value of the shape of a mass's friction; `None` if it has one already.
fn shaped(model: &Model, place: Location, key: &str, value: f64) -> Option<Model> {
    let mut other = model.clone();
    let is_shape =
        |effect: &EffectParameters| effect.kind == Kind::FrictionShape && effect.location == place;
    let known = other.effects.iter().position(is_shape).unwrap_or_else(|| {
        other.effects.push(EffectParameters::new(Kind::FrictionShape, place));
        other.effects.len() - 1
    });
    let shape = &mut other.effects[known];
    if shape.get(key).is_some_and(|own| own > 0.0) {
        return None;
    }
    *shape = shape.with(key, value);
    Some(other)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::coordinates::Coordinate;
    use crate::filter::{Colour, Disturbed, Noise};
    use crate::gram::gram;
    use crate::parameters::Quantity;
    use crate::{noise, replicate};
    use joint_simulation::demo::actuator;
    use joint_simulation::synthetic::{Experiment, record};

    const SEEDS: u64 = 12;

    /// Mean square of how far a refitted value is off, in the standard errors told and in those of the curvature alone,
    /// over replicates of a joint like `truth` that feels this noise.
    fn surprise(
        quantity: Quantity,
        truth: impl Fn(&mut Model),
        felt: impl Fn(&mut Noise),
    ) -> [f64; 2] {
        let nominal = actuator();
        let log = record(&nominal, &Experiment { duration_s: 2.0, ..Experiment::default() }, 3);
        let blank = Record::new(&log.unwrap(), Some(2));
        let expected = noise::expected(&nominal, &blank);
        let (mut joint, mut noise) = (nominal.clone(), expected);
        truth(&mut joint);
        felt(&mut noise);
        let coordinates = [Coordinate::Parameter(quantity)];
        let mask = vec![1.0; blank.len()];
        let mut sums = [0.0; 2];
        for seed in 0..SEEDS {
            let record = replicate::replicate(&joint, &blank, &noise, seed).unwrap();
            let problem = Problem::new(&record, &mask);
            let fit = problem.fit(&nominal, &nominal, &coordinates, &expected, 4).unwrap();
            let off = coordinates[0].distance(&joint, &fit.model).powi(2);
            let slopes = problem.sensitivity(&fit.model, &fit.gains, &coordinates, None);
            let curvature = gram(&slopes)[(0, 0)] + precision(&coordinates)[0];
            sums[0] += off / problem.covariance(&fit)[(0, 0)];
            sums[1] += off * curvature;
        }
        sums.map(|sum| sum / SEEDS as f64)
    }

    #[test]
    fn errors_hold_in_white_noise_and_beside_a_disturbance_that_nobody_told_of() {
        let [told, _] = surprise(Quantity::Inertia(0), |_| {}, |_| {});
        assert!((0.3..2.0).contains(&told), "{told}");
        let [told, curvature] = surprise(
            Quantity::Inertia(0),
            |_| {},
            |noise| {
                let deviation = 6.0 * noise.torque;
                noise.coloured[Disturbed::Rotor as usize] =
                    Colour { deviation, correlation_s: 0.02 };
            },
        );
        assert!((0.3..2.0).contains(&told) && curvature > 4.0, "{told} {curvature}");
    }

    #[test]
    fn errors_hold_where_friction_is_of_another_shape() {
        let thinner = |joint: &mut Model| {
            let shape = EffectParameters::new(Kind::FrictionShape, Location::Motor);
            joint.effects.push(shape.with("thinning_s_per_rad", 2e-3));
        };
        let [told, curvature] = surprise(Quantity::Viscous(0), thinner, |_| {});
        assert!((0.3..2.0).contains(&told) && curvature > 4.0, "{told} {curvature}");
    }

    #[test]
    fn friction_is_of_another_shape_only_where_the_model_does_not_say_it() {
        let mut model = actuator();
        let log = record(&model, &Experiment { duration_s: 0.2, ..Experiment::default() }, 3);
        let record = Record::new(&log.unwrap(), Some(2));
        let plain = other_frictions(&model, &record).len();
        assert_eq!(plain, 2 * (1 + model.stages.len()));
        let shape = EffectParameters::new(Kind::FrictionShape, Location::Motor);
        model.effects.push(shape.with("thinning_s_per_rad", 1e-3));
        let others = other_frictions(&model, &record);
        assert_eq!(others.len(), plain - 1);
        let [thinning, creep] =
            ["thinning_s_per_rad", "creep_rad_per_s"].map(|key| others[0].effects[0].get(key));
        assert!(thinning == Some(1e-3) && creep > Some(0.0), "{thinning:?} {creep:?}");
    }
}
