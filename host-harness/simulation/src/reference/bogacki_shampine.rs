//! Bogacki and Shampine's explicit method of third order at a fixed step, as the paper runs it.
//!
//! Slow, simple and easy to trust: nothing in it knows of the joint. Its steps divide every sample
//! evenly, so inputs change only between steps, and the last stage of one step is the first of
//! the next. Source: Bogacki and Shampine, "A 3(2) pair of Runge–Kutta formulas" (1989).

use super::equations::{Equations, Held};

/// The method with its working memory.
pub(super) struct BogackiShampine<'a> {
    equations: &'a Equations,
    rates: [Vec<f64>; 3],
    stage: Vec<f64>,
}

impl<'a> BogackiShampine<'a> {
    pub(super) fn new(equations: &'a Equations) -> Self {
        let zeros = equations.rest();
        Self { equations, rates: [zeros.clone(), zeros.clone(), zeros.clone()], stage: zeros }
    }

    /// Advances the state by `duration` in steps of at most `step`.
    pub(super) fn advance(&mut self, state: &mut [f64], held: &Held, duration: f64, step: f64) {
        let steps = (duration / step - 1e-6).ceil().max(1.0);
        let h = duration / steps;
        let [first, second, third] = &mut self.rates;
        // Once a sample, so that a caller may change the state in between.
        self.equations.derivative(held, state, first);
        for _ in 0..steps as u64 {
            for ((new, old), rate) in self.stage.iter_mut().zip(&*state).zip(&*first) {
                *new = old + 0.5 * h * rate;
            }
            self.equations.derivative(held, &self.stage, second);
            for ((new, old), rate) in self.stage.iter_mut().zip(&*state).zip(&*second) {
                *new = old + 0.75 * h * rate;
            }
            self.equations.derivative(held, &self.stage, third);
            let rates = first.iter().zip(&*second).zip(&*third);
            for (value, ((one, two), three)) in state.iter_mut().zip(rates) {
                *value += h / 9.0 * (2.0 * one + 3.0 * two + 4.0 * three);
            }
            self.equations.derivative(held, state, first);
            if self.equations.end_step(state, first) {
                self.equations.derivative(held, state, first);
            }
        }
    }
}
