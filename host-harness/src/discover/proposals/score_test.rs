//! The score test: how much a hypothesis would explain, from one linear step.
//!
//! A missing effect leaves its shadow in the whitened innovations; so does a wrong parameter. The
//! sensitivities of all parameters are projected out first, with their priors, and what a
//! hypothesis explains of the rest is its score. A hypothesis may start at a finite size (a gap
//! has no derivative at zero): then its own innovations take the place of the base model's.

use std::borrow::Cow;
use std::ops::Range;

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rayon::prelude::*;

use crate::discover::candidates::Scene;
use crate::discover::candidates::hypothesis::Hypothesis;
use crate::estimate::adjoint::Pull;
use crate::estimate::coordinates::{Coordinate, precision};
use crate::estimate::filter::{Linearisation, Observer};
use crate::estimate::fit::{Fit, Problem};
use crate::estimate::gram::{gram, shared};
use crate::estimate::replicate::null_innovations;
use crate::model::Model;
use crate::plant::plant;

/// A base model with its nuisance parameters ready to be projected out.
pub(crate) struct ScoreTest<'a> {
    problem: Problem<'a>,
    base: &'a Fit,
    jacobian: DMatrix<f64>,
    curvature: Cholesky<f64, Dyn>,
    precision: DVector<f64>,
    offset: DVector<f64>,
    /// What the base model's distance from its priors costs.
    prior: f64,
    /// The record's own innovations, then those of its replicates.
    residuals: Vec<Residual>,
    /// What each of them pulls at.
    pulls: Vec<Pull>,
    /// The base model's states along the record.
    states: Vec<Vec<f64>>,
}

/// Innovations, and what the nuisances make of them.
struct Residual {
    values: DVector<f64>,
    nuisance: DVector<f64>,
}

/// What a hypothesis takes from minus twice the log-likelihood, priors included.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Gain {
    /// On the record.
    pub(crate) real: f64,
    /// On each replicate, where nothing is missing.
    pub(crate) null: Vec<f64>,
    /// Free values.
    pub(crate) free: usize,
}

impl Gain {
    /// How many times more than its free values should a hypothesis explains of the replicates, one at
    /// least: some follow what no linear step sees, and would hide all the others.
    pub(crate) fn luck(&self) -> f64 {
        let mean = self.null.iter().sum::<f64>() / self.null.len().max(1) as f64;
        (mean / self.free.max(1) as f64).max(1.0)
    }
}

impl<'a> ScoreTest<'a> {
    /// Of a fitted model, with that many replicates; `None` if its curvature is not positive.
    pub(crate) fn new(
        problem: Problem<'a>,
        origin: &'a Model,
        base: &'a Fit,
        replicates: u64,
    ) -> Option<Self> {
        let jacobian = problem.sensitivity(&base.model, &base.gains, &base.coordinates, None);
        let precision = precision(&base.coordinates);
        let offset = base.coordinates.iter().map(|c| c.distance(origin, &base.model));
        let offset = DVector::from_iterator(base.coordinates.len(), offset);
        let curvature = gram(&jacobian) + DMatrix::from_diagonal(&precision);
        let curvature = curvature.cholesky()?;
        let (model, noise, gains) = (&base.model, &base.noise, &base.gains);
        let nulls = null_innovations(model, &problem, noise, gains, 0..replicates).ok()?;
        let plant = plant(&base.model, &problem.record.grid, problem.record.drive).ok()?;
        let observer = Observer::new(&base.model, &*plant, problem.record);
        let mut along = Cow::Owned(Linearisation::default());
        let (_, run) = observer.design_along(
            &mut along,
            &base.noise,
            &problem.walks(&base.noise, &base.model),
        );
        let all: Vec<_> = std::iter::once(&base.innovations).chain(&nulls).collect();
        let pulls = all
            .into_par_iter()
            .map(|rows| observer.pull(&base.gains, &along, &problem.masked(rows)))
            .collect();
        let mut test = Self {
            problem,
            base,
            jacobian,
            curvature,
            prior: precision.component_mul(&offset).dot(&offset),
            precision,
            offset,
            residuals: Vec::new(),
            pulls,
            states: run.states,
        };
        let own = problem.residual(&base.innovations);
        test.residuals.push(test.prepared(own, true));
        for null in nulls {
            let values = problem.residual(&null);
            test.residuals.push(test.prepared(values, false));
        }
        Some(test)
    }

    /// What candidates may look at.
    pub(crate) fn scene(&self) -> Scene<'_> {
        Scene::new(&self.base.model, self.problem.record, &self.pulls, &self.states)
    }

    /// The nuisances' derivative at the base model.
    pub(crate) fn jacobian(&self) -> &DMatrix<f64> {
        &self.jacobian
    }

    fn prepared(&self, values: DVector<f64>, with_prior: bool) -> Residual {
        let mut nuisance = self.jacobian.tr_mul(&values);
        if with_prior {
            nuisance += self.precision.component_mul(&self.offset);
        }
        Residual { values, nuisance }
    }

    /// What each hypothesis would take, the best first.
    pub(crate) fn ranked<'h>(&self, hypotheses: &'h [Hypothesis]) -> Vec<(&'h Hypothesis, Gain)> {
        let gains = self.gains(hypotheses);
        let mut ranked: Vec<_> = hypotheses.iter().zip(gains).collect();
        ranked.sort_by(|a, b| b.1.real.total_cmp(&a.1.real));
        ranked
    }

    /// What each hypothesis would take after one linear step of everything.
    pub(crate) fn gains(&self, hypotheses: &[Hypothesis]) -> Vec<Gain> {
        // Those of one name are run side by side.
        let alike: Vec<_> = hypotheses.chunk_by(|a, b| a.name() == b.name()).collect();
        alike.into_par_iter().flat_map_iter(|own| self.gains_of_one_name(own)).collect()
    }

    fn gains_of_one_name(&self, hypotheses: &[Hypothesis]) -> Vec<Gain> {
        let (mut trials, mut models) = (Vec::new(), Vec::new());
        for hypothesis in hypotheses {
            let model = hypothesis.added(&self.base.model);
            let coordinates = hypothesis.coordinates(self.base.model.effects.len());
            let finite = !hypothesis.starts_at_nothing();
            let first = models.len();
            models.extend(finite.then(|| model.clone()));
            models.extend(coordinates.iter().map(|coordinate| {
                let mut moved = model.clone();
                coordinate.shift(&mut moved, coordinate.difference_step());
                moved
            }));
            trials.push((coordinates, finite, first..models.len()));
        }
        let runs = self.problem.innovations_of(&models, &self.base.gains);
        let run = |number: usize| {
            let rows = self.problem.residual(runs[number].as_ref()?);
            rows.iter().all(|e| e.is_finite()).then_some(rows)
        };
        let gain = |(coordinates, finite, mut numbers): (Vec<Coordinate>, bool, Range<usize>)| {
            // From a finite start, the start's own innovations take the place of the base model's.
            let start =
                if finite { Some(self.prepared(run(numbers.next()?)?, true)) } else { None };
            let moved = numbers.map(run).collect::<Option<Vec<_>>>()?;
            self.gain(&coordinates, start.as_ref(), moved)
        };
        trials.into_iter().map(|trial| gain(trial).unwrap_or_default()).collect()
    }

    /// What a hypothesis would take, from its start if that is finite and from where each of its values
    /// has moved by a step.
    fn gain(
        &self,
        coordinates: &[Coordinate],
        start: Option<&Residual>,
        moved: Vec<DVector<f64>>,
    ) -> Option<Gain> {
        let (real, replicates) = self.residuals.split_first()?;
        let from = start.unwrap_or(real);
        let columns: Vec<_> = coordinates
            .iter()
            .zip(moved)
            .map(|(coordinate, moved)| (moved - &from.values) / coordinate.difference_step())
            .collect();
        if columns.is_empty() {
            return None;
        }
        let own = DMatrix::from_columns(&columns);
        let cross = shared(&self.jacobian, &own);
        let mut schur = gram(&own) - cross.tr_mul(&self.curvature.solve(&cross));
        for (k, coordinate) in coordinates.iter().enumerate() {
            schur[(k, k)] += coordinate.prior_sigma().powi(-2);
        }
        let schur = schur.cholesky()?;
        let explained = |residual: &Residual| {
            let solved = self.curvature.solve(&residual.nuisance);
            let left = own.tr_mul(&residual.values) - cross.tr_mul(&solved);
            left.dot(&schur.solve(&left))
        };
        let cost = |residual: &Residual| {
            residual.values.norm_squared()
                - residual.nuisance.dot(&self.curvature.solve(&residual.nuisance))
        };
        let gain = cost(real) - cost(from) + explained(from);
        // A start from which the filter flies off shows rounding alone, of whatever size.
        let possible = gain.is_finite() && gain <= cost(real) + self.prior;
        possible.then(|| Gain {
            real: gain,
            null: replicates.iter().map(explained).collect(),
            free: coordinates.len(),
        })
    }
}

#[cfg(test)]
mod tests {
    use joint_core::effect::{EffectParameters, Kind};
    use joint_core::params::Location;

    use super::*;
    use crate::demo::actuator;
    use crate::discover::candidates::hypothesis::Free;
    use crate::discover::trial;
    use crate::estimate::record::Record;

    #[test]
    fn no_start_explains_more_than_there_is() {
        let nominal = actuator();
        let record = Record::new(&trial::log(&nominal, trial::line(12.0), 4.0), None);
        let mask = vec![1.0; record.measured.len()];
        let problem = Problem::new(&record, &mask);
        let base = trial::fitted(&problem, &nominal, &[]);
        let test = ScoreTest::new(problem, &base.origin, &base.fit, 1).unwrap();
        let there = problem.sum_of_squares(&base.fit.innovations) + base.fit.prior;
        let drag = EffectParameters::new(Kind::QuadraticDrag, Location::Motor);
        // Beyond some tenths the step cannot follow, and the filter flies off.
        for power in -20..80 {
            let size = 10.0_f64.powf(0.05 * f64::from(power));
            let start = drag.with("coefficient_nm_s2", size);
            let free = vec![Free::Value { value: 0, scale: 0.1 * size, sigma: 10.0 }];
            let [gain] = &test.gains(&[Hypothesis { start, free }])[..] else { panic!("one") };
            assert!(gain.real <= there, "{} of {there} at {size}", gain.real);
        }
    }
}
