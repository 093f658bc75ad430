//! Refitting: the parameters, and optionally some effects, that make the whitened innovations
//! smallest, with a prior on each.
//!
//! The first rounds trust the model little (large process noise), so that a model wrong by per cents is
//! pulled in by every sample on its own; the last ones use the noise that the record itself shows.

use std::borrow::Cow;

use nalgebra::{DMatrix, DVector};

use super::coordinates::Coordinate;
use super::filter::{Equation, Gains, Linearisation, Noise, Observer, Walk};
use super::keep::Likelihood;
use super::late::is_between_samples;
use super::pass::Pass;
use super::record::{CHANNELS, Channel, Record};
use super::scoring::{Scoring, Source};
use super::scout::Scout;
use joint_simulation::model::Model;
use joint_simulation::plant::{BuildError, Plant, plant};

/// What a round must gain of minus twice the log-likelihood to be followed by another: where a model
/// is to be known, and where it is only to be compared.
const WORTH: f64 = 0.3;
const ROUGH: f64 = 5.0;
/// A model fitted to a record.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The fitted model.
    pub model: Model,
    /// What was moved.
    pub coordinates: Vec<Coordinate>,
    /// Noise at the fitted model: the rotor's has followed its inertia.
    pub noise: Noise,
    /// The filter's gains at the fitted model.
    pub gains: Gains,
    /// Whitened innovations at the fitted model, of each log as far as it is fitted to.
    pub innovations: Vec<[f64; CHANNELS]>,
    /// Minus twice the log-likelihood over the samples fitted to, without priors.
    pub deviance: f64,
    /// Sum of the squared distances from the priors, in sigmas.
    pub prior: f64,
    /// What it took from minus twice the log-likelihood and the priors since its start.
    pub gained: f64,
    /// Whether it is known that refitting it on from where it is gains little.
    pub rests: bool,
}

impl Fit {
    /// Minus twice the log-likelihood sample by sample, without priors; zero where `mask` is.
    pub fn deviances(&self, mask: &[f64]) -> Vec<f64> {
        let rows = self.innovations.iter().zip(self.gains.log_variances()).zip(mask);
        rows.map(|((row, log), mask)| mask * (row.iter().map(|e| e * e).sum::<f64>() + log))
            .collect()
    }
}

/// A filter designed at a model, and what it makes of the record.
#[derive(Clone, Debug)]
pub struct Design {
    /// Its gains.
    pub gains: Gains,
    /// Whitened innovations, of each log as far as it is fitted to.
    pub innovations: Vec<[f64; CHANNELS]>,
    /// Minus twice the log-likelihood over the samples fitted to.
    pub deviance: f64,
}

/// What is known where a fit starts, and saves the time to find it.
pub struct Known<'l, 'a> {
    /// The joint's linearisation at the start, or none yet; afterwards that of the fitted model.
    pub along: &'l mut Cow<'a, Linearisation>,
    /// The innovations' derivative with the first coordinates, of a model near the start at the same
    /// noise.
    pub near: Option<&'l DMatrix<f64>>,
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
    /// What a round must gain of minus twice the log-likelihood to be followed by another.
    pub worth: f64,
    /// Whether slopes are taken by differences, long enough to see beyond a standstill, instead of at
    /// the place itself: friction behind gears makes a multimodal likelihood.
    pub long_sighted: bool,
    /// Whether a fit is only on the way to another: it may end with gains of a model near its own.
    pub passing: bool,
    /// What fits on the way look at instead.
    pub scout: Option<&'a Scout>,
}

/// The random constants that every filter carries: an encoder zeroed at the start of a log knows
/// nothing of the wind-up at that moment.
pub fn standing_walks(record: &Record) -> Vec<Walk> {
    if record.has(Channel::Output) {
        vec![Walk::random(Equation::Sensor(Channel::Output), 1e-2, 0.0)]
    } else {
        Vec::new()
    }
}

impl<'a> Problem<'a> {
    /// A record fitted to over a mask, with a model that is believed.
    pub fn new(record: &'a Record, mask: &'a [f64]) -> Self {
        Self {
            record,
            mask,
            push: None,
            cautious: false,
            worth: WORTH,
            long_sighted: false,
            passing: false,
            scout: None,
        }
    }

    /// The same with every step proven.
    pub fn cautious(self) -> Self {
        Self { cautious: true, ..self }
    }

    /// The same, content with fits near enough to be told apart.
    pub fn rough(self) -> Self {
        Self { worth: ROUGH, ..self }
    }

    /// Whether it is content with fits near enough to be told apart.
    pub(super) fn is_rough(&self) -> bool {
        self.worth >= ROUGH
    }

    /// The same by differences, or by the slope at a place.
    pub fn long_sighted(self, long_sighted: bool) -> Self {
        Self { long_sighted, ..self }
    }

    /// The same with a part that fits look at on the way to others.
    pub fn scouted(self, scout: Option<&'a Scout>) -> Self {
        Self { scout, ..self }
    }

    /// The same over that part alone, if there is one.
    pub fn ahead(self) -> Self {
        match self.scout {
            Some(Scout { record, mask }) => Self { record, mask, scout: None, ..self },
            None => self,
        }
    }

    /// The same for fits that are on the way to others.
    pub fn passing(self) -> Self {
        Self { passing: true, ..self.ahead() }
    }

    /// The same with a push on one equation.
    pub fn pushed(self, push: Walk) -> Self {
        Self { push: Some(push), ..self }
    }

    /// What a filter of this problem carries beside a joint's states at a noise, the push last.
    pub fn walks(&self, noise: &Noise, model: &Model) -> Vec<Walk> {
        let standing = standing_walks(self.record).into_iter();
        let before = is_between_samples(model, self.record).then_some(Walk::CURRENT_BEFORE);
        standing.chain(before).chain(noise.walks(model.stages.len())).chain(self.push).collect()
    }

    /// A plant observed as far as samples are fitted to.
    pub(super) fn observer<'p>(&self, model: &Model, plant: &'p dyn Plant) -> Observer<'p>
    where
        'a: 'p,
    {
        Observer::new(model, plant, self.record).as_far_as(self.mask)
    }

    /// Designs the filter at a model and runs it.
    ///
    /// # Errors
    /// The model cannot be built.
    pub fn design(&self, model: &Model, noise: &Noise) -> Result<Design, BuildError> {
        self.design_along(&mut Cow::Owned(Linearisation::default()), model, noise)
    }

    /// The same along a linearisation of a model near it, which is made if it is empty.
    ///
    /// # Errors
    /// The model cannot be built.
    pub fn design_along(
        &self,
        along: &mut Cow<'_, Linearisation>,
        model: &Model,
        noise: &Noise,
    ) -> Result<Design, BuildError> {
        let plant = plant(model, &self.record.grid, self.record.drive)?;
        let observer = self.observer(model, &*plant);
        let (gains, run) = observer.designed(along, noise, &self.walks(noise, model), false);
        let deviance = self.sum_of_squares(&run.innovations) + gains.log_variance(self.mask);
        Ok(Design { gains, innovations: run.innovations, deviance })
    }

    /// Minus twice the log-likelihood of the filter designed at a model, along its linearisation.
    ///
    /// # Errors
    /// The model cannot be built.
    pub fn deviance_along(
        &self,
        along: &Linearisation,
        model: &Model,
        noise: &Noise,
    ) -> Result<f64, BuildError> {
        let plant = plant(model, &self.record.grid, self.record.drive)?;
        let observer = self.observer(model, &*plant);
        let mut likelihood = Likelihood::over(self.mask);
        observer.run(&mut Cow::Borrowed(along), noise, &self.walks(noise, model), &mut likelihood);
        Ok(likelihood.deviance())
    }

    /// The same with its gradient in the logarithms of noises and its expected curvature, along a
    /// linearisation, which is made if it is empty.
    ///
    /// # Errors
    /// The model cannot be built.
    pub(super) fn scored_along(
        &self,
        along: &mut Cow<'_, Linearisation>,
        model: &Model,
        noise: &Noise,
        sources: &[Source],
    ) -> Result<(f64, DVector<f64>, DMatrix<f64>), BuildError> {
        let plant = plant(model, &self.record.grid, self.record.drive)?;
        let observer = self.observer(model, &*plant);
        let walks = self.walks(noise, model);
        let order = (observer.layout.len(), &walks[..]);
        let mut scoring = Scoring::over(self.mask, noise, sources, order);
        scoring.follow(Pass::new(&observer, along, noise, &walks));
        Ok(scoring.results())
    }

    /// A design along a model's own linearisation, which is given too.
    pub(super) fn design_anew(
        &self,
        model: &Model,
        noise: &Noise,
    ) -> Result<(Design, Linearisation), BuildError> {
        let mut along = Cow::Owned(Linearisation::default());
        let design = self.design_along(&mut along, model, noise)?;
        Ok((design, along.into_owned()))
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
        Ok(self.observer(model, &*plant).innovations(gains))
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
        let mut values = Vec::with_capacity(innovations.len() * CHANNELS);
        for (row, weight) in innovations.iter().zip(self.mask) {
            values.extend(if *weight > 0.0 { *row } else { [0.0; CHANNELS] });
        }
        DVector::from_vec(values)
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
        let along = &mut Cow::Owned(Linearisation::default());
        self.fit_from(Known { along, near: None }, origin, start, coordinates, noise, rounds)
    }
}
