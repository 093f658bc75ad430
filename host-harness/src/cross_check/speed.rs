//! How much faster the embedded method is than what it is checked by, measured in one run.

use std::hint::black_box;
use std::time::Instant;

use serde::Serialize;

use super::{CrossCheckError, Quantity, REFERENCE_STEP_S};
use crate::model::Model;
use crate::plant::{self, ScalarKind, Snapshot};
use crate::reference::{self, Method, Options, PAPER_STEP_S};
use crate::scenario::Scenario;

/// Step of the embedded method that is timed, s.
const STEP_S: f64 = 50e-6;
/// Times are the best of this many runs: what else the machine does only adds.
const RUNS: usize = 5;

/// Seconds that each method takes for one scenario, and its worst error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Speed {
    /// The embedded method in f64 at 50 µs, s.
    pub embedded_s: f64,
    /// Its worst relative RMS over the states.
    pub embedded_error: f64,
    /// The explicit reference at the paper's step, s.
    pub explicit_s: f64,
    /// The implicit reference, as loose as it is no worse than the embedded method, s.
    pub stiff_s: f64,
    /// Its tolerance.
    pub stiff_tolerance: f64,
    /// Its worst relative RMS.
    pub stiff_error: f64,
}

impl Speed {
    /// Measures on this scenario; keep the machine quiet.
    ///
    /// # Errors
    /// The joint cannot be built, or a reference fails.
    pub fn measure(model: &Model, scenario: &Scenario) -> Result<Self, CrossCheckError> {
        let inputs = scenario.inputs();
        let refer = |method| {
            reference::simulate(model, &inputs, &Options::of(method))
                .map_err(|error| CrossCheckError::Reference { scenario: scenario.name, error })
        };
        let embedded = || plant::simulate(model, &inputs, ScalarKind::F64, Some(STEP_S), None);
        let exact = refer(Method::BogackiShampine { step_s: REFERENCE_STEP_S })?;
        let embedded_error = worst(model, &exact, &embedded()?);
        let embedded_s = best(|| embedded().map(drop))?;
        let explicit_s =
            best(|| refer(Method::BogackiShampine { step_s: PAPER_STEP_S }).map(drop))?;
        let (mut stiff_tolerance, mut stiff_error) = (0.1, f64::INFINITY);
        while stiff_error > embedded_error && stiff_tolerance > 1e-9 {
            stiff_tolerance /= 10.0_f64.sqrt();
            let run = refer(Method::Stiff { tolerance: stiff_tolerance });
            stiff_error = run.map_or(f64::INFINITY, |run| worst(model, &exact, &run));
        }
        let stiff_s = best(|| refer(Method::Stiff { tolerance: stiff_tolerance }).map(drop))?;
        Ok(Self { embedded_s, embedded_error, explicit_s, stiff_s, stiff_tolerance, stiff_error })
    }

    /// How often the embedded method runs in the time of the explicit and of the implicit one.
    pub fn ratios(&self) -> [f64; 2] {
        [self.explicit_s, self.stiff_s].map(|seconds| seconds / self.embedded_s)
    }
}

fn worst(model: &Model, exact: &[Snapshot], run: &[Snapshot]) -> f64 {
    Quantity::of(model.stages.len())
        .into_iter()
        .map(|quantity| quantity.relative_rms(exact, run))
        .fold(0.0, |worst, error| if error > worst || error.is_nan() { error } else { worst })
}

fn best<E>(run: impl Fn() -> Result<(), E>) -> Result<f64, E> {
    let mut best = f64::INFINITY;
    for _ in 0..RUNS {
        let start = Instant::now();
        black_box(run()?);
        best = best.min(start.elapsed().as_secs_f64());
    }
    Ok(best)
}
