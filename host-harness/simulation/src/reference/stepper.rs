//! One sample after another by the explicit method, for those who need the state between them.
//!
//! A controller chooses the next voltage by what it has measured, and what an effect changes is
//! seen by starting again from a state on the way: both need the run in their own hands.

use super::Method;
use super::bogacki_shampine::BogackiShampine;
use super::equations::{Equations, Held};

/// How often a sample is done again at a shorter step.
const RETRIES: u32 = 12;

/// The explicit method on a joint's equations.
pub struct Stepper<'a> {
    equations: &'a Equations,
    method: BogackiShampine<'a>,
    step: Method,
    before: Vec<f64>,
}

impl<'a> Stepper<'a> {
    /// Steps of a method; the implicit one is run explicitly at the paper's step.
    pub fn new(equations: &'a Equations, step: Method) -> Self {
        let before = equations.rest();
        Self { equations, method: BogackiShampine::new(equations), step, before }
    }

    /// Advances a state by a sample of `duration` seconds, over which the inputs are held.
    pub fn advance(&mut self, state: &mut [f64], held: &Held, duration: f64) {
        match self.step {
            Method::BogackiShampine { step_s } => {
                self.method.advance(state, held, duration, step_s);
            }
            Method::Stiff { .. } => {
                self.method.advance(state, held, duration, super::PAPER_STEP_S);
            }
            Method::Scaled { share } => {
                // A sample in which the joint gains more speed than was foreseen is done again.
                self.before.copy_from_slice(state);
                let mut rate = self.equations.rate_near(state);
                for _ in 0..RETRIES {
                    state.copy_from_slice(&self.before);
                    self.method.advance(state, held, duration, share / rate);
                    let reached = self.equations.rate_near(state);
                    if reached <= 1.4 * rate {
                        break;
                    }
                    rate = if reached.is_finite() { reached } else { 4.0 * rate };
                }
            }
        }
        self.equations.settle(held, state);
    }
}
