//! The filter: an extended Kalman filter designed once along a record, then run with its gains
//! frozen.
//!
//! Designing costs one propagation for each state; running costs one in all. Because the gains are
//! frozen, the innovations are a plain function of the parameters, and refitting is a nonlinear
//! least-squares problem with an exact sensitivity by differences. Measurements are taken one
//! channel after the other, which leaves the innovations uncorrelated between channels as well.

use std::borrow::Cow;

pub use crate::gains::{Colour, Disturbed, Equation, Gains, Linearisation, Noise, Run, Walk};
use crate::keep::{Keep, Whole};
pub use crate::observer::Observer;
use crate::pass::Pass;
use crate::record::{CHANNELS, Channel};

impl Observer<'_> {
    /// Designs the gains along the record and runs it.
    pub fn design(&self, noise: &Noise, walks: &[Walk]) -> (Gains, Run) {
        self.design_along(&mut Cow::Owned(Linearisation::default()), noise, walks)
    }

    /// The same along a linearisation, which is made if it is empty.
    pub fn design_along(
        &self,
        along: &mut Cow<'_, Linearisation>,
        noise: &Noise,
        walks: &[Walk],
    ) -> (Gains, Run) {
        self.designed(along, noise, walks, true)
    }

    /// The same, without the states where they are not asked for.
    pub(super) fn designed(
        &self,
        along: &mut Cow<'_, Linearisation>,
        noise: &Noise,
        walks: &[Walk],
        with_states: bool,
    ) -> (Gains, Run) {
        let order = self.layout.len() + walks.len();
        let mut whole = Whole::new(self.record.len(), order, walks, with_states);
        self.run(along, noise, walks, &mut whole);
        whole.results(order)
    }

    /// Runs the filter along a linearisation, which is made if it is empty.
    pub(super) fn run(
        &self,
        along: &mut Cow<'_, Linearisation>,
        noise: &Noise,
        walks: &[Walk],
        keep: &mut impl Keep,
    ) {
        let mut pass = Pass::new(self, along, noise, walks);
        pass.over(0..pass.samples(), keep);
    }

    /// Runs the record with frozen gains; only the innovations. The gains may be those of a model
    /// that remembers less: what is added is not corrected.
    pub fn innovations(&self, gains: &Gains) -> Vec<[f64; CHANNELS]> {
        let designed = gains.order - gains.walks.len();
        let own = self.layout.len();
        let common = designed.min(own);
        let mut x = Vec::new();
        let mut innovations = vec![[0.0; CHANNELS]; self.record.len()];
        for (k, row) in innovations.iter_mut().enumerate() {
            if self.is_idle(k) {
                continue;
            }
            if self.record.starts.contains(&k) {
                x = self.start(k, &gains.walks, |state| x.get(state).copied());
            }
            for channel in Channel::ALL {
                let c = channel as usize;
                let weight = gains.weight[k][c];
                if weight == 0.0 {
                    continue;
                }
                let shown = self.shown(channel, &x, &gains.walks);
                let error = (self.late.measured[k][c] - shown) * weight;
                if !error.is_finite() {
                    continue;
                }
                row[c] = error;
                let slot = (k * CHANNELS + c) * gains.order;
                let (states, walks) = gains.gain[slot..slot + gains.order].split_at(designed);
                for (value, gain) in x.iter_mut().zip(&states[..common]) {
                    *value += gain * error;
                }
                for (value, gain) in x[own..].iter_mut().zip(walks) {
                    *value += gain * error;
                }
            }
            self.advance(k, &mut x, &gains.walks);
        }
        innovations
    }
}
