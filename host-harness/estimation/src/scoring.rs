//! How the likelihood of a filter changes with the noise that it is designed for.
//!
//! Beside a filter's covariance and state run their derivatives with the logarithm of each noise, by the
//! same recursions; what they make of the innovations and of their variances gives the slope of the
//! likelihood exactly and its curvature as expected (Fisher's information), so that a few steps find
//! where it is highest.

use nalgebra::{DMatrix, DVector};

use super::covariance::Covariance;
use super::filter::{Disturbed, Noise, Walk};
use super::keep::{Keep, Likelihood, Measured, Passed};
use super::pass::{Pass, dot};
use super::record::Channel;
use super::tape::Tape;

/// Samples over which a filter runs ahead of its derivatives.
const STRETCH: usize = 128;

/// A noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Source {
    /// What the drive does beside what it is told.
    Drive,
    /// What the rotor feels.
    Torque,
    /// What the rotor feels near the reversal.
    Reversal,
    /// What the last mass feels.
    Output,
    /// What a sensor adds.
    Sensor(Channel),
    /// What acts on an equation and is correlated in time.
    Coloured(Disturbed),
}

impl Source {
    /// One sigma of it.
    pub(super) fn sigma(self, noise: &Noise) -> f64 {
        match self {
            Self::Drive => noise.drive,
            Self::Torque => noise.torque,
            Self::Reversal => noise.reversal,
            Self::Output => noise.output,
            Self::Sensor(channel) => noise.sensors[channel as usize],
            Self::Coloured(place) => noise.coloured[place as usize].deviation,
        }
    }

    /// The noise with another one sigma of it.
    pub(super) fn with_sigma(self, noise: &Noise, sigma: f64) -> Noise {
        let mut noise = *noise;
        match self {
            Self::Drive => noise.drive = sigma,
            Self::Torque => noise.torque = sigma,
            Self::Reversal => noise.reversal = sigma,
            Self::Output => noise.output = sigma,
            Self::Sensor(channel) => noise.sensors[channel as usize] = sigma,
            Self::Coloured(place) => noise.coloured[place as usize].deviation = sigma,
        }
        noise
    }
}

/// Derivatives of a filter with the logarithm of one noise.
struct Along {
    source: Source,
    /// Where it stands in the state and what it is, of one that is a state itself.
    own: Option<(usize, Walk)>,
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
    /// Over the samples of a mask, of a filter of so many states before its walks.
    pub(super) fn over(
        mask: &'m [f64],
        noise: &Noise,
        sources: &[Source],
        (states, walks): (usize, &[Walk]),
    ) -> Self {
        let order = states + walks.len();
        let none = || Covariance::independent(std::iter::repeat_n(0.0, order));
        let own = |source: Source| {
            let is = |walk: &&Walk| walk.correlation_s.is_finite();
            let nth = noise.colours().position(|(place, _)| Source::Coloured(place) == source)?;
            let (k, walk) = walks.iter().enumerate().filter(|(_, walk)| is(walk)).nth(nth)?;
            Some((states + k, *walk))
        };
        let along = sources.iter().map(|source| Along {
            source: *source,
            own: own(*source),
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

    /// Follows a filter along its way: a second core takes the derivatives of one stretch while the filter
    /// runs over the next.
    pub(super) fn follow(&mut self, mut pass: Pass<'_, '_, '_>) {
        let (order, samples) = (self.scratch.len(), pass.samples());
        let [mut made, mut seen] = [Tape::default(), Tape::default()];
        for first in (0..samples).step_by(STRETCH) {
            let stretch = first..(first + STRETCH).min(samples);
            made.clear();
            rayon::join(|| pass.over(stretch, &mut made), || seen.play(order, self));
            std::mem::swap(&mut made, &mut seen);
        }
        seen.play(order, self);
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
            if let Some((state, walk)) = along.own {
                along.covariance.add_variance(state, 2.0 * walk.initial * walk.initial);
            }
        }
    }

    fn measured(&mut self, at: &Measured<'_>) {
        let Measured { sample, channel, row, column, innovation, variance } = *at;
        let weight = self.likelihood.mask()[sample];
        let whitened = innovation * innovation / variance;
        for along in &mut self.along {
            let Along { source, state, covariance, column: moved, change, .. } = along;
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
        let Passed { transition, drive, kick, behind, reversing, interval } = *over;
        let order = self.scratch.len();
        for Along { source, state, covariance, own, .. } in &mut self.along {
            for (next, row) in self.scratch.iter_mut().zip(transition.rows().chunks_exact(order)) {
                *next = dot(row, state);
            }
            state.copy_from_slice(&self.scratch);
            covariance.carry(transition);
            let twice = 2.0 * source.sigma(&self.noise).powi(2);
            match source {
                Source::Drive => covariance.add_square(twice, drive),
                Source::Torque => covariance.add_square(twice, kick),
                Source::Reversal => {
                    let [rotor, last] = reversing.map(|share| twice * share);
                    covariance.add_square(rotor, kick);
                    if last > 0.0 {
                        covariance.add_square(last, behind);
                    }
                }
                Source::Output => covariance.add_square(twice, behind),
                Source::Sensor(_) => {}
                Source::Coloured(_) => {
                    if let Some((state, walk)) = own {
                        covariance.add_variance(*state, 2.0 * walk.gained(interval));
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::borrow::Cow;

    use super::*;
    use crate::filter::{Linearisation, Observer};
    use crate::fit::standing_walks;
    use crate::noise::expected;
    use crate::record::Record;
    use joint_simulation::demo::actuator;
    use joint_simulation::plant::plant;

    #[test]
    fn stretches_that_are_followed_give_the_bits_of_a_whole_way() {
        let model = actuator();
        // Two logs, neither of which is as long as some number of stretches.
        let log = |seed| {
            joint_simulation::synthetic::record(
                &model,
                &joint_simulation::synthetic::Experiment::clean(0.05),
                seed,
            )
        };
        let record = Record::join(&[log(5).unwrap(), log(6).unwrap()], None).unwrap();
        assert!(record.len() > 3 * STRETCH && record.starts.len() == 2);
        assert!([record.starts[1], record.len()].iter().all(|end| end % STRETCH != 0));
        let mask = vec![1.0; record.len()];
        let noise = expected(&model, &record);
        let walks = standing_walks(&record);
        let plant = plant(&model, &record.grid, record.drive).unwrap();
        let observer = Observer::new(&model, &*plant, &record);
        let order = (observer.layout.len(), &walks[..]);
        let sources = [Source::Torque, Source::Drive, Source::Sensor(Channel::Motor)];
        let empty = || Cow::Owned(Linearisation::default());
        let mut whole = Scoring::over(&mask, &noise, &sources, order);
        observer.run(&mut empty(), &noise, &walks, &mut whole);
        let mut followed = Scoring::over(&mask, &noise, &sources, order);
        let mut along = empty();
        followed.follow(Pass::new(&observer, &mut along, &noise, &walks));
        assert_eq!(whole.results(), followed.results());
        assert!(along.covers(record.len(), observer.layout.len()));
    }
}
