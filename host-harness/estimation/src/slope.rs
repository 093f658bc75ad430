//! The innovations' derivative, kept from one round of a fit to the next.
//!
//! Taking it costs a run of the record for every coordinate, and near a minimum it hardly changes. So
//! a fit takes it once and corrects it with what every accepted step showed (Broyden's rank-one
//! update, Math. Comp. 19, 1965); when a step does not keep what the derivative promised, it is taken
//! again.

use nalgebra::{DMatrix, DVector};

/// Share of a promised gain that a kept derivative must deliver to be kept on.
const KEPT_PROMISE: f64 = 0.4;
/// Steps that one derivative may serve.
const MOST_STEPS: usize = 8;

/// A derivative and how far it is to be believed.
pub struct Slope {
    /// By row of the residual and coordinate.
    pub jacobian: DMatrix<f64>,
    steps: usize,
    kept: bool,
}

impl Slope {
    /// One just taken.
    pub fn fresh(jacobian: DMatrix<f64>) -> Self {
        Self { jacobian, steps: 0, kept: true }
    }

    /// One taken at another, near model.
    pub fn borrowed(jacobian: DMatrix<f64>) -> Self {
        Self { jacobian, steps: 1, kept: true }
    }

    /// Whether it was taken where it is used.
    pub fn is_fresh(&self) -> bool {
        self.steps == 0
    }

    /// Whether it may serve another step.
    pub fn serves(&self) -> bool {
        self.kept && self.steps < MOST_STEPS
    }

    /// Learns from a step: how the residual changed along it at the same gains, in the metric of the
    /// coordinates' curvature; and which gain had been promised, and which was kept.
    pub fn learn(
        &mut self,
        step: &DVector<f64>,
        change: &DVector<f64>,
        metric: &DVector<f64>,
        [promised, kept]: [f64; 2],
    ) {
        self.steps += 1;
        self.kept = kept > KEPT_PROMISE * promised;
        let along = metric.component_mul(step);
        let length = along.dot(step);
        if length > 0.0 {
            let missed = change - &self.jacobian * step;
            self.jacobian.ger(1.0 / length, &missed, &along, 1.0);
        }
    }
}
