//! How the likelihood of a filter changes with the noise that it is designed for.
//!
//! Beside a filter's covariance and state run their derivatives with the logarithm of each noise, by the
//! same recursions; what they make of the innovations and of their variances gives the slope of the
//! likelihood exactly and its curvature as expected (Fisher's information), so that a few steps find
//! where it is highest.

use nalgebra::{DMatrix, DVector};

use super::covariance::Covariance;
use super::filter::Noise;
use super::keep::{Keep, Likelihood, Measured, Passed};
use super::record::Channel;

/// A noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Source {
    /// What the drive does beside what it is told.
    Drive,
    /// What the rotor feels.
    Torque,
    /// What a sensor adds.
    Sensor(Channel),
}

impl Source {
    /// One sigma of it.
    pub(super) fn sigma(self, noise: &Noise) -> f64 {
        match self {
            Self::Drive => noise.drive,
            Self::Torque => noise.torque,
            Self::Sensor(channel) => noise.sensors[channel as usize],
        }
    }

    /// The noise with another one sigma of it.
    pub(super) fn with_sigma(self, noise: &Noise, sigma: f64) -> Noise {
        let mut noise = *noise;
        match self {
            Self::Drive => noise.drive = sigma,
            Self::Torque => noise.torque = sigma,
            Self::Sensor(channel) => noise.sensors[channel as usize] = sigma,
        }
        noise
    }
}

/// Derivatives of a filter with the logarithm of one noise.
struct Along {
    source: Source,
    state: Vec<f64>,
    covariance: Covariance,
    /// Of the covariance's product with a sensor's row.
    column: Vec<f64>,
    /// Of an innovation and of its variance.
    change: [f64; 2],
}

/// Minus twice the log-likelihood over the samples of a mask, its gradient with the logarithms of noises,
/// and its expected curvature.
pub(super) struct Scoring<'m> {
    likelihood: Likelihood<'m>,
    noise: Noise,
    along: Vec<Along>,
    gradient: DVector<f64>,
    information: DMatrix<f64>,
    scratch: Vec<f64>,
}

impl<'m> Scoring<'m> {
    pub(super) fn over(mask: &'m [f64], noise: &Noise, sources: &[Source], order: usize) -> Self {
        let none = || Covariance::independent(std::iter::repeat_n(0.0, order));
        let along = sources.iter().map(|source| Along {
            source: *source,
            state: vec![0.0; order],
            covariance: none(),
            column: vec![0.0; order],
            change: [0.0; 2],
        });
        Self {
            likelihood: Likelihood::over(mask),
            noise: *noise,
            along: along.collect(),
            gradient: DVector::zeros(sources.len()),
            information: DMatrix::zeros(sources.len(), sources.len()),
            scratch: vec![0.0; order],
        }
    }

    /// Minus twice the log-likelihood, its gradient and its curvature.
    pub(super) fn results(self) -> (f64, DVector<f64>, DMatrix<f64>) {
        (self.likelihood.deviance(), self.gradient, self.information)
    }
}

impl Keep for Scoring<'_> {
    fn taken(&mut self, sample: usize, channel: usize, error: f64, weight: f64, gain: &[f64]) {
        self.likelihood.taken(sample, channel, error, weight, gain);
    }

    fn corrected(&mut self, _: &[f64]) {}

    fn began(&mut self) {
        for along in &mut self.along {
            along.state.fill(0.0);
            along.covariance.clear();
        }
    }

    fn measured(&mut self, at: &Measured<'_>) {
        let Measured { sample, channel, row, column, innovation, variance } = *at;
        let weight = self.likelihood.mask()[sample];
        let whitened = innovation * innovation / variance;
        for along in &mut self.along {
            let Along { source, state, covariance, column: moved, change } = along;
            covariance.times(row, moved);
            let own = match *source == Source::Sensor(channel) {
                true => 2.0 * source.sigma(&self.noise).powi(2),
                false => 0.0,
            };
            let spread = dot(row, moved) + own;
            let shift = -dot(row, state);
            *change = [shift, spread];
            for ((state, moved), column) in state.iter_mut().zip(&*moved).zip(column) {
                let gain = (moved - column * spread / variance) / variance;
                *state += gain * innovation + column / variance * shift;
            }
            covariance.add_both_ways(-1.0 / variance, moved, column);
            covariance.add_square(spread / (variance * variance), column);
        }
        if weight == 0.0 || !whitened.is_finite() {
            return;
        }
        for (i, one) in self.along.iter().enumerate() {
            let [shift, spread] = one.change;
            self.gradient[i] +=
                weight * (2.0 * innovation * shift + (1.0 - whitened) * spread) / variance;
            for (j, other) in self.along.iter().enumerate() {
                let [other_shift, other_spread] = other.change;
                self.information[(i, j)] += weight
                    * (2.0 * shift * other_shift + spread * other_spread / variance)
                    / variance;
            }
        }
    }

    fn passed(&mut self, over: &Passed<'_>) {
        let Passed { transition, drive, kick } = *over;
        let order = self.scratch.len();
        for Along { source, state, covariance, .. } in &mut self.along {
            for (next, row) in self.scratch.iter_mut().zip(transition.chunks_exact(order)) {
                *next = dot(row, state);
            }
            state.copy_from_slice(&self.scratch);
            covariance.carry(transition);
            let twice = 2.0 * source.sigma(&self.noise).powi(2);
            match source {
                Source::Drive => covariance.add_square(twice, drive),
                Source::Torque => covariance.add_square(twice, kick),
                Source::Sensor(_) => {}
            }
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
