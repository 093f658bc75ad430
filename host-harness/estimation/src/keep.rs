//! What is kept of a filter's way along a record: all of it, or its likelihood alone, which the search
//! for the noise asks for more often than all else together.

use std::sync::Arc;

use super::covariance::Transition;
use super::gains::{Gains, Run, Walk};
use super::record::{CHANNELS, Channel};

/// One measurement, before it corrects anything.
pub(super) struct Measured<'a> {
    pub(super) sample: usize,
    pub(super) channel: Channel,
    /// What the sensor shows of each state.
    pub(super) row: &'a [f64],
    /// The covariance's product with it.
    pub(super) column: &'a [f64],
    /// What was measured beyond what was expected, and the variance of that.
    pub(super) innovation: f64,
    pub(super) variance: f64,
}

/// One interval.
pub(super) struct Passed<'a> {
    /// Of each state with each.
    pub(super) transition: &'a Transition,
    /// Of each state with the drive, with a torque on the rotor, and with one on the last mass.
    pub(super) drive: &'a [f64],
    pub(super) kick: &'a [f64],
    pub(super) behind: &'a [f64],
    /// Share of its variance that a noise of the reversal has on the rotor and on the last mass.
    pub(super) reversing: [f64; 2],
    /// How long it is, s.
    pub(super) interval: f64,
}

/// Something that watches a filter.
pub(super) trait Keep {
    /// A channel of a sample was taken: the innovation over its sigma, one over that sigma, and what
    /// each state gained by an innovation of one sigma.
    fn taken(&mut self, sample: usize, channel: usize, error: f64, weight: f64, gain: &[f64]);
    /// The states after a sample's measurements.
    fn corrected(&mut self, states: &[f64]);
    /// A log begins.
    fn began(&mut self) {}
    /// A measurement is about to be taken.
    fn measured(&mut self, _at: &Measured<'_>) {}
    /// The filter was carried over an interval.
    fn passed(&mut self, _over: &Passed<'_>) {}
}

/// Gains and innovations, and the states where they are asked for.
pub(super) struct Whole<'w> {
    walks: &'w [Walk],
    gain: Vec<f64>,
    weight: Vec<[f64; CHANNELS]>,
    run: Run,
    with_states: bool,
}

impl<'w> Whole<'w> {
    pub(super) fn new(samples: usize, order: usize, walks: &'w [Walk], with_states: bool) -> Self {
        let states = Vec::with_capacity(if with_states { samples } else { 0 });
        Self {
            walks,
            gain: vec![0.0; samples * CHANNELS * order],
            weight: vec![[0.0; CHANNELS]; samples],
            run: Run { innovations: vec![[0.0; CHANNELS]; samples], states },
            with_states,
        }
    }

    /// The gains of that many states, and the run.
    pub(super) fn results(self, order: usize) -> (Gains, Run) {
        let Self { walks, gain, weight, run, .. } = self;
        let (gain, weight) = (Arc::new(gain), Arc::new(weight));
        (Gains { order, gain, weight, walks: walks.to_vec() }, run)
    }
}

impl Keep for Whole<'_> {
    fn taken(&mut self, sample: usize, channel: usize, error: f64, weight: f64, gain: &[f64]) {
        self.run.innovations[sample][channel] = error;
        self.weight[sample][channel] = weight;
        let slot = (sample * CHANNELS + channel) * gain.len();
        self.gain[slot..slot + gain.len()].copy_from_slice(gain);
    }

    fn corrected(&mut self, states: &[f64]) {
        if self.with_states {
            self.run.states.push(states.to_vec());
        }
    }
}

/// Minus twice the log-likelihood over the samples of a mask.
pub(super) struct Likelihood<'m> {
    mask: &'m [f64],
    squares: f64,
    log_variance: f64,
}

impl<'m> Likelihood<'m> {
    pub(super) fn over(mask: &'m [f64]) -> Self {
        Self { mask, squares: 0.0, log_variance: 0.0 }
    }

    /// Which samples it is of.
    pub(super) fn mask(&self) -> &'m [f64] {
        self.mask
    }

    /// The sum; infinite where the innovations are not numbers.
    pub(super) fn deviance(&self) -> f64 {
        let squares = if self.squares.is_finite() { self.squares } else { f64::INFINITY };
        squares + self.log_variance
    }
}

impl Keep for Likelihood<'_> {
    fn taken(&mut self, sample: usize, _: usize, error: f64, weight: f64, _: &[f64]) {
        if self.mask[sample] > 0.0 {
            self.squares += self.mask[sample] * error * error;
            if weight > 0.0 {
                self.log_variance -= 2.0 * self.mask[sample] * weight.ln();
            }
        }
    }

    fn corrected(&mut self, _: &[f64]) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_likelihood_is_the_sum_over_the_samples_of_a_mask() {
        let mut likelihood = Likelihood::over(&[1.0, 0.0, 1.0]);
        likelihood.taken(0, 0, 2.0, 0.5, &[]);
        likelihood.taken(1, 0, 7.0, 0.1, &[]);
        likelihood.taken(2, 2, 1.0, 4.0, &[]);
        let wanted = 4.0 + 1.0 - 2.0 * (0.5_f64.ln() + 4.0_f64.ln());
        assert!((likelihood.deviance() - wanted).abs() < 1e-12);
        likelihood.taken(2, 1, f64::NAN, 1.0, &[]);
        assert_eq!(likelihood.deviance(), f64::INFINITY);
    }
}
