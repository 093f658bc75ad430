//! The score test: how much a hypothesis would explain, from one linear step.
//!
//! A missing effect leaves its shadow in the whitened innovations; so does a wrong parameter. The
//! sensitivities of all parameters are projected out first, with their priors, and what a
//! hypothesis explains of the rest is its score. A hypothesis may start at a finite size (a gap
//! has no derivative at zero): then its own innovations take the place of the base model's.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::hypothesis::Hypothesis;
use crate::estimate::fit::{Fit, Problem};
use crate::model::Model;

/// A base model with its nuisance parameters ready to be projected out.
pub struct ScoreTest<'a> {
    problem: Problem<'a>,
    origin: &'a Model,
    base: &'a Fit,
    jacobian: DMatrix<f64>,
    curvature: Cholesky<f64, Dyn>,
    residual: DVector<f64>,
    offset: DVector<f64>,
    precision: DVector<f64>,
    cost: f64,
}

impl<'a> ScoreTest<'a> {
    /// Of a fitted model; `None` if its curvature is not positive.
    pub fn new(problem: Problem<'a>, origin: &'a Model, base: &'a Fit) -> Option<Self> {
        let jacobian = problem.sensitivity(&base.model, &base.gains, &base.coordinates);
        let rows = base.coordinates.iter();
        let precision = DVector::from_iterator(
            base.coordinates.len(),
            rows.clone().map(|c| c.prior_sigma().powi(-2)),
        );
        let offset = DVector::from_iterator(
            base.coordinates.len(),
            rows.map(|c| c.distance(origin, &base.model)),
        );
        let curvature = jacobian.tr_mul(&jacobian) + DMatrix::from_diagonal(&precision);
        let curvature = curvature.cholesky()?;
        let residual = problem.residual(&base.innovations);
        let mut test = Self {
            problem,
            origin,
            base,
            jacobian,
            curvature,
            residual,
            offset,
            precision,
            cost: 0.0,
        };
        test.cost = test.after_step(&test.residual, &DMatrix::zeros(test.residual.len(), 0), &[]);
        Some(test)
    }

    /// What the hypothesis would take from the base model's cost (deviance and priors) after one
    /// linear step of everything.
    pub fn gain(&self, hypothesis: &Hypothesis) -> f64 {
        let model = hypothesis.added(&self.base.model);
        let coordinates = hypothesis.coordinates(self.base.model.effects.len());
        let Ok(start) = self.problem.innovations(&model, &self.base.gains) else { return 0.0 };
        let start = self.problem.residual(&start);
        if !start.iter().all(|e| e.is_finite()) {
            return 0.0;
        }
        let columns: Vec<DVector<f64>> = coordinates
            .iter()
            .map(|coordinate| {
                let step = coordinate.difference_step();
                let mut moved = model.clone();
                coordinate.shift(&mut moved, step);
                match self.problem.innovations(&moved, &self.base.gains) {
                    Ok(rows) => (self.problem.residual(&rows) - &start) / step,
                    Err(_) => DVector::zeros(start.len()),
                }
            })
            .collect();
        if columns.is_empty() || columns.iter().any(|c| c.iter().any(|e| !e.is_finite())) {
            return 0.0;
        }
        let sigmas: Vec<f64> = coordinates.iter().map(|c| c.prior_sigma()).collect();
        let gain = self.cost - self.after_step(&start, &DMatrix::from_columns(&columns), &sigmas);
        if gain.is_finite() { gain } else { 0.0 }
    }

    /// Cost after the best linear step of the nuisances and some own columns from a residual.
    fn after_step(&self, residual: &DVector<f64>, own: &DMatrix<f64>, sigmas: &[f64]) -> f64 {
        let nuisance = self.jacobian.tr_mul(residual) + self.precision.component_mul(&self.offset);
        let plain = residual.norm_squared()
            + self.offset.component_mul(&self.offset).component_mul(&self.precision).sum()
            - nuisance.dot(&self.curvature.solve(&nuisance));
        if own.ncols() == 0 {
            return plain;
        }
        let cross = self.jacobian.tr_mul(own);
        let mut schur = own.tr_mul(own) - cross.tr_mul(&self.curvature.solve(&cross));
        for (k, sigma) in sigmas.iter().enumerate() {
            schur[(k, k)] += sigma.powi(-2);
        }
        let left = own.tr_mul(residual) - cross.tr_mul(&self.curvature.solve(&nuisance));
        match schur.cholesky() {
            Some(schur) => plain - left.dot(&schur.solve(&left)),
            None => plain,
        }
    }

    /// Where the priors are centred.
    pub fn origin(&self) -> &Model {
        self.origin
    }

    /// The base model's fit.
    pub fn base(&self) -> &Fit {
        self.base
    }

    /// The record and its mask.
    pub fn problem(&self) -> Problem<'a> {
        self.problem
    }
}
