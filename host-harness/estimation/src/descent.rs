//! The descent of a fit: Gauss–Newton with Levenberg's damping on frozen gains, which are designed anew
//! at every accepted point.
//!
//! A step is tried with the gains that are there, which costs one run; what it promises must hold for
//! the filter designed at its end.

use std::borrow::Cow;

use nalgebra::{DMatrix, DVector};

use super::abreast::Rows;
use super::coordinates::{Coordinate, precision};
use super::filter::{Disturbed, Linearisation, Noise};
use super::fit::{Design, Fit, Known, Problem};
use super::gram::gram;
use super::slope::Slope;
use super::trials::Trials;
use crate::interrupt;
use joint_simulation::model::Model;
use joint_simulation::plant::{BuildError, inertias};

/// Share of the sum of squares that a step must take for the joint to be linearised anew.
const FAR: f64 = 0.1;
/// Damping at the start, and the least.
const DAMPING: [f64; 2] = [1e-3, 1e-9];
/// Attempts with a derivative taken here, and with one that is not of this place: it is replaced rather
/// than damped.
const ATTEMPTS: [usize; 2] = [6, 2];

/// What a fit makes smallest, and what it may move.
struct Descent<'d> {
    problem: &'d Problem<'d>,
    origin: &'d Model,
    coordinates: &'d [Coordinate],
    noise: &'d Noise,
    /// Inertias of the start's rotor and last mass, kg m².
    inertias: [f64; 2],
    precision: DVector<f64>,
}

/// Where a descent stands.
struct Place {
    model: Model,
    design: Design,
    /// Whether the linearisation at hand is this model's own.
    linearised: bool,
    damping: f64,
}

impl Problem<'_> {
    /// The same as [`Problem::fit`] with what is known at the start already. The rotor's noise follows its
    /// inertia: where a current is the input the two can hardly be told apart, and a fit at either would
    /// crawl along both.
    ///
    /// # Errors
    /// The start cannot be built.
    pub fn fit_from(
        &self,
        known: Known<'_, '_>,
        origin: &Model,
        start: &Model,
        coordinates: &[Coordinate],
        noise: &Noise,
        rounds: usize,
    ) -> Result<Fit, BuildError> {
        let Known { along, near } = known;
        let precision = precision(coordinates);
        let inertias = ends(start);
        let descent = Descent { problem: self, origin, coordinates, noise, inertias, precision };
        let design = self.design_along(along, start, noise)?;
        let [damping, _] = DAMPING;
        let mut at = Place { model: start.clone(), design, linearised: true, damping };
        let begun = descent.cost(&at);
        let mut slope = near.map(|near| descent.borrowed(near, &at));
        let mut best: Option<Place> = None;
        for _ in 0..rounds {
            if interrupt::asked() {
                break;
            }
            let residual = self.residual(&at.design.innovations);
            let mut own = slope.take().filter(Slope::serves).unwrap_or_else(|| {
                let here = Some(&residual);
                Slope::fresh(self.sensitivity(&at.model, &at.design.gains, coordinates, here))
            });
            let (gained, left) = descent.step(&mut at, along, &mut own, &residual)?;
            // What frozen gains promise need not hold, and a worse place may lie on the way to a better.
            let likely = best.as_ref().map_or(descent.cost(&at), |best| descent.cost(best));
            best = left.filter(|left| descent.cost(left) < likely).or(best);
            if gained < self.worth && (own.is_fresh() || gained > 0.0) {
                break;
            }
            slope = (gained > 0.0).then_some(own);
        }
        if let Some(best) = best.filter(|best| descent.cost(best) < descent.cost(&at)) {
            at = Place { linearised: false, ..best };
        }
        let Place { model, mut design, linearised, .. } = at;
        if !linearised && !self.passing {
            *along = Cow::Owned(Linearisation::default());
            design = self.design_along(along, &model, &descent.noise_at(&model))?;
        }
        let prior = descent.prior(&model);
        Ok(Fit {
            gained: begun - design.deviance - prior,
            prior,
            noise: descent.noise_at(&model),
            model,
            coordinates: coordinates.to_vec(),
            gains: design.gains,
            innovations: design.innovations,
            deviance: design.deviance,
            rests: false,
        })
    }
}

/// Inertias of the rotor and of the last mass, reflected to the motor, kg m².
fn ends(model: &Model) -> [f64; 2] {
    let all = inertias(model);
    [all[0], all[all.len() - 1]]
}

impl Descent<'_> {
    fn offset(&self, from: &Model, to: &Model) -> DVector<f64> {
        let distances = self.coordinates.iter().map(|c| c.distance(from, to));
        DVector::from_iterator(self.coordinates.len(), distances)
    }

    fn prior(&self, model: &Model) -> f64 {
        let at = self.offset(self.origin, model);
        at.component_mul(&at).component_mul(&self.precision).sum()
    }

    /// The noise of a model: a torque's is what the same accelerations are with its inertia.
    fn noise_at(&self, model: &Model) -> Noise {
        let [rotor, last] = ends(model);
        let [rotor, last] = [rotor / self.inertias[0], last / self.inertias[1]];
        let mut noise = *self.noise;
        noise.torque *= rotor;
        noise.reversal *= rotor;
        noise.output *= last;
        noise.coloured[Disturbed::Rotor as usize].deviation *= rotor;
        noise.coloured[Disturbed::Output as usize].deviation *= last;
        noise
    }

    /// Minus twice the log-likelihood and the prior where a descent stands.
    fn cost(&self, at: &Place) -> f64 {
        at.design.deviance + self.prior(&at.model)
    }

    /// The derivative of a near model with the first coordinates, and this place's own with the others.
    fn borrowed(&self, near: &DMatrix<f64>, at: &Place) -> Slope {
        let residual = self.problem.residual(&at.design.innovations);
        let (known, new) = self.coordinates.split_at(near.ncols());
        debug_assert!(known.len() == near.ncols());
        let new = self.problem.sensitivity(&at.model, &at.design.gains, new, Some(&residual));
        let columns: Vec<_> = near.column_iter().chain(new.column_iter()).collect();
        Slope::borrowed(DMatrix::from_columns(&columns))
    }

    /// One step, as far as it helps: what it gained, and the place that it left; nothing where none helped.
    fn step(
        &self,
        at: &mut Place,
        along: &mut Cow<'_, Linearisation>,
        own: &mut Slope,
        residual: &DVector<f64>,
    ) -> Result<(f64, Option<Place>), BuildError> {
        let (problem, precision) = (self.problem, &self.precision);
        let off = self.offset(self.origin, &at.model);
        let gradient = own.jacobian.tr_mul(residual) + precision.component_mul(&off);
        let curvature = gram(&own.jacobian) + DMatrix::from_diagonal(precision);
        let before = problem.sum_of_squares(&at.design.innovations) + self.prior(&at.model);
        let likely = self.cost(at);
        let moves = self.moves(at, &gradient, &curvature, own.is_fresh());
        let gains = at.design.gains.clone();
        let mut trials = Trials::of(problem, &gains, &moves);
        for (attempt, moved) in moves.iter().enumerate() {
            let step = self.offset(&at.model, moved);
            let promised = -step.dot(&(&gradient * 2.0 + &curvature * &step));
            let is_far = |gain: f64| problem.cautious || gain > FAR * before;
            let anew = || problem.design_anew(moved, &self.noise_at(moved));
            // A second core designs at once what is needed if the step keeps its promise, or makes the next ones.
            let (rows, ahead) =
                if attempt == 0 && is_far(promised) && rayon::current_num_threads() > 1 {
                    let (rows, ahead) = rayon::join(|| trials.run(0), anew);
                    (rows, Some(ahead))
                } else if attempt == 0 {
                    let cost = |rows: &Rows| problem.sum_of_squares(rows) + self.prior(moved);
                    (trials.first(|rows| cost(rows) < before), None)
                } else {
                    (trials.run(attempt), None)
                };
            let squares = problem.sum_of_squares(&rows);
            let after = squares + self.prior(moved);
            if after < before {
                let far = is_far(before - after);
                let change = problem.residual(&rows) - residual;
                let (design, made) = if far {
                    // What frozen gains promise must hold for the filter designed at the new point.
                    let (design, made) = ahead.unwrap_or_else(anew)?;
                    (design, Some(made))
                } else {
                    // One designed along the same linearisation at noise that follows the inertia has the same
                    // gains.
                    let deviance = squares + gains.log_variance(problem.mask);
                    (Design { gains: gains.clone(), innovations: rows, deviance }, None)
                };
                let found = design.deviance + self.prior(moved);
                if found < likely || !problem.cautious {
                    if let Some(made) = made {
                        *along = Cow::Owned(made);
                    }
                    let kept = [promised, before - after];
                    own.learn(&step, &change, &curvature.diagonal(), kept);
                    let damping = (at.damping * 0.1).max(DAMPING[1]);
                    let there = Place { model: moved.clone(), design, linearised: far, damping };
                    let left = std::mem::replace(at, there);
                    let gained = if problem.cautious { likely - found } else { before - after };
                    return Ok((gained, Some(left)));
                }
            }
            at.damping *= 10.0;
        }
        Ok((0.0, None))
    }

    /// The models that steps from a place lead to, each more damped than the one before, as many as are tried.
    fn moves(
        &self,
        at: &Place,
        gradient: &DVector<f64>,
        curvature: &DMatrix<f64>,
        fresh: bool,
    ) -> Vec<Model> {
        let [here, elsewhere] = ATTEMPTS;
        let mut damping = at.damping;
        let moved = |_| {
            let mut damped = curvature.clone();
            for k in 0..self.coordinates.len() {
                damped[(k, k)] += damping * curvature[(k, k)];
            }
            damping *= 10.0;
            let step = -damped.cholesky()?.solve(gradient);
            let mut moved = at.model.clone();
            for (coordinate, step) in self.coordinates.iter().zip(step.iter()) {
                coordinate.shift(&mut moved, coordinate.limited(*step));
            }
            Some(moved)
        };
        (0..if fresh { here } else { elsewhere }).map_while(moved).collect()
    }
}
