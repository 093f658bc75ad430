//! Refitting: the parameters, and optionally some effects, that make the whitened innovations
//! smallest, with a prior on each.
//!
//! Gauss–Newton with Levenberg's damping on frozen gains; the gains are designed anew at every
//! accepted point. The first rounds trust the model little (large process noise), so that a model
//! wrong by per cents is pulled in by every sample on its own; the last ones use the noise that the
//! record itself shows.

use std::borrow::Cow;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::coordinates::Coordinate;
use super::filter::{Equation, Gains, Linearisation, Noise, Observer, Walk};
use super::record::{CHANNELS, Channel, Record};
use crate::interrupt;
use crate::model::Model;
use crate::plant::{BuildError, plant};

/// A model fitted to a record.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The fitted model.
    pub model: Model,
    /// What was moved.
    pub coordinates: Vec<Coordinate>,
    /// Noise at which it was fitted.
    pub noise: Noise,
    /// The filter's gains at the fitted model.
    pub gains: Gains,
    /// Whitened innovations of the whole record at the fitted model.
    pub innovations: Vec<[f64; CHANNELS]>,
    /// Minus twice the log-likelihood over the samples fitted to, without priors.
    pub deviance: f64,
    /// Sum of the squared distances from the priors, in sigmas.
    pub prior: f64,
}

/// A record, and the part of it that is fitted to.
#[derive(Clone, Copy, Debug)]
pub struct Problem<'a> {
    /// The record.
    pub record: &'a Record,
    /// By sample: one where it is fitted to, zero where it is held out.
    pub mask: &'a [f64],
    /// A push on one equation that wanders and is estimated along, so that what the equation
    /// misses does not bend the parameters; `None` believes the model.
    pub push: Option<Walk>,
    /// Whether a step counts only if the filter designed at its end is better as well: slower, and
    /// for a record in which nothing is missing.
    pub cautious: bool,
}

/// The random constants that every filter carries: an encoder zeroed at the start of a log knows
/// nothing of the wind-up at that moment.
pub fn standing_walks(record: &Record) -> Vec<Walk> {
    if record.has(Channel::Output) {
        vec![Walk { equation: Equation::Sensor(Channel::Output), initial: 1e-2, rate: 0.0 }]
    } else {
        Vec::new()
    }
}

impl<'a> Problem<'a> {
    /// A record fitted to over a mask, with a model that is believed.
    pub fn new(record: &'a Record, mask: &'a [f64]) -> Self {
        Self { record, mask, push: None, cautious: false }
    }

    /// The same with every step proven.
    pub fn cautious(self) -> Self {
        Self { cautious: true, ..self }
    }

    /// The same with a push on one equation.
    pub fn pushed(self, push: Walk) -> Self {
        Self { push: Some(push), ..self }
    }

    /// What a filter of this problem carries beside the joint's states, the push last.
    pub fn walks(&self) -> Vec<Walk> {
        standing_walks(self.record).into_iter().chain(self.push).collect()
    }

    /// Designs the filter at a model and runs it: gains, innovations, masked deviance.
    ///
    /// # Errors
    /// The model cannot be built.
    pub fn design(
        &self,
        model: &Model,
        noise: &Noise,
    ) -> Result<(Gains, Vec<[f64; CHANNELS]>, f64), BuildError> {
        let plant = plant(model, &self.record.grid, self.record.drive)?;
        let observer = Observer::new(model, &*plant, self.record);
        let (gains, run) = observer.design(noise, &self.walks());
        let deviance = self.sum_of_squares(&run.innovations) + gains.log_variance(self.mask);
        Ok((gains, run.innovations, deviance))
    }

    /// Masked deviance of a model at a noise, along a shared linearisation.
    ///
    /// # Errors
    /// The model cannot be built.
    pub fn deviance_along(
        &self,
        along: &mut Cow<'_, Linearisation>,
        model: &Model,
        noise: &Noise,
    ) -> Result<f64, BuildError> {
        let plant = plant(model, &self.record.grid, self.record.drive)?;
        let observer = Observer::new(model, &*plant, self.record);
        let (gains, run) = observer.design_along(along, noise, &self.walks());
        Ok(self.sum_of_squares(&run.innovations) + gains.log_variance(self.mask))
    }

    /// Innovations of a model with frozen gains.
    ///
    /// # Errors
    /// The model cannot be built.
    pub fn innovations(
        &self,
        model: &Model,
        gains: &Gains,
    ) -> Result<Vec<[f64; CHANNELS]>, BuildError> {
        let plant = plant(model, &self.record.grid, self.record.drive)?;
        Ok(Observer::new(model, &*plant, self.record).innovations(gains))
    }

    /// Squared innovations over the samples fitted to; infinite where they are not numbers.
    pub fn sum_of_squares(&self, innovations: &[[f64; CHANNELS]]) -> f64 {
        let sum: f64 = innovations
            .iter()
            .zip(self.mask)
            .map(|(row, weight)| weight * row.iter().map(|e| e * e).sum::<f64>())
            .sum();
        if sum.is_finite() { sum } else { f64::INFINITY }
    }

    /// Innovations of the samples fitted to; zero elsewhere.
    pub fn masked(&self, innovations: &[[f64; CHANNELS]]) -> Vec<[f64; CHANNELS]> {
        let rows = innovations.iter().zip(self.mask);
        rows.map(|(row, weight)| if *weight > 0.0 { *row } else { [0.0; CHANNELS] }).collect()
    }

    /// Masked innovations as one vector.
    pub fn residual(&self, innovations: &[[f64; CHANNELS]]) -> DVector<f64> {
        let rows = innovations.iter().zip(self.mask);
        DVector::from_iterator(
            innovations.len() * CHANNELS,
            rows.flat_map(|(row, weight)| row.map(|e| if *weight > 0.0 { e } else { 0.0 })),
        )
    }

    /// Derivative of the residual with each coordinate, by differences: one-sided from the residual
    /// at the model if that is given, else central.
    pub fn sensitivity(
        &self,
        model: &Model,
        gains: &Gains,
        coordinates: &[Coordinate],
        here: Option<&DVector<f64>>,
    ) -> DMatrix<f64> {
        let columns: Vec<DVector<f64>> = coordinates
            .par_iter()
            .map(|coordinate| {
                let step = coordinate.difference_step();
                let side = |step: f64| {
                    let mut moved = model.clone();
                    coordinate.shift(&mut moved, step);
                    self.innovations(&moved, gains).map(|rows| self.residual(&rows))
                };
                let slope = match here {
                    Some(here) => side(step).map(|up| (up - here) / step),
                    None => side(step).and_then(|up| Ok((up - side(-step)?) / (2.0 * step))),
                };
                slope.unwrap_or_else(|_| DVector::zeros(self.record.len() * CHANNELS))
            })
            .collect();
        if columns.is_empty() {
            return DMatrix::zeros(self.record.len() * CHANNELS, 0);
        }
        DMatrix::from_columns(&columns)
    }

    /// Fits from a start; `origin` is where the priors are centred.
    ///
    /// # Errors
    /// The start cannot be built.
    pub fn fit(
        &self,
        origin: &Model,
        start: &Model,
        coordinates: &[Coordinate],
        noise: &Noise,
        rounds: usize,
    ) -> Result<Fit, BuildError> {
        let (mut gains, mut innovations, mut deviance) = self.design(start, noise)?;
        let mut model = start.clone();
        let precision = DVector::from_iterator(
            coordinates.len(),
            coordinates.iter().map(|c| c.prior_sigma().powi(-2)),
        );
        let offset = |model: &Model| {
            DVector::from_iterator(
                coordinates.len(),
                coordinates.iter().map(|c| c.distance(origin, model)),
            )
        };
        let mut damping = 1e-3;
        for _ in 0..rounds {
            if interrupt::asked() {
                break;
            }
            let residual = self.residual(&innovations);
            let jacobian = self.sensitivity(&model, &gains, coordinates, Some(&residual));
            let at = offset(&model);
            let gradient = jacobian.tr_mul(&residual) + precision.component_mul(&at);
            let curvature = jacobian.tr_mul(&jacobian) + DMatrix::from_diagonal(&precision);
            let prior = |model: &Model| {
                let at = offset(model);
                at.component_mul(&at).component_mul(&precision).sum()
            };
            let before = self.sum_of_squares(&innovations) + prior(&model);
            let likely = deviance + prior(&model);
            let mut gained = 0.0;
            for _ in 0..6 {
                let mut damped = curvature.clone();
                for k in 0..coordinates.len() {
                    damped[(k, k)] += damping * curvature[(k, k)];
                }
                let Some(step) = damped.cholesky().map(|c| -c.solve(&gradient)) else { break };
                let mut moved = model.clone();
                for (coordinate, step) in coordinates.iter().zip(step.iter()) {
                    coordinate.shift(&mut moved, coordinate.limited(*step));
                }
                let after = match self.innovations(&moved, &gains) {
                    Ok(rows) => self.sum_of_squares(&rows) + prior(&moved),
                    Err(_) => f64::INFINITY,
                };
                if after < before {
                    // What frozen gains promise must hold for the filter designed at the new point.
                    let (g, i, d) = self.design(&moved, noise)?;
                    let found = d + prior(&moved);
                    if found < likely || !self.cautious {
                        (gains, innovations, deviance) = (g, i, d);
                        model = moved;
                        gained = if self.cautious { likely - found } else { before - after };
                        damping = (damping * 0.1).max(1e-9);
                        break;
                    }
                }
                damping *= 10.0;
            }
            if gained < 0.3 {
                break;
            }
        }
        let at = offset(&model);
        Ok(Fit {
            prior: at.component_mul(&at).component_mul(&precision).sum(),
            model,
            coordinates: coordinates.to_vec(),
            noise: *noise,
            gains,
            innovations,
            deviance,
        })
    }

    /// Inverse of the posterior's curvature at a fit: covariance of its coordinates.
    pub fn covariance(&self, fit: &Fit) -> DMatrix<f64> {
        let jacobian = self.sensitivity(&fit.model, &fit.gains, &fit.coordinates, None);
        let precision = fit.coordinates.iter().map(|c| c.prior_sigma().powi(-2));
        let count = fit.coordinates.len();
        let precision = DVector::from_iterator(count, precision);
        let curvature = jacobian.tr_mul(&jacobian) + DMatrix::from_diagonal(&precision);
        curvature.cholesky().map_or_else(|| DMatrix::zeros(count, count), |c| c.inverse())
    }
}
