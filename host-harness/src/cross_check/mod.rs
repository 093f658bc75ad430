//! Whether the step that runs on the drive is right, number by number.
//!
//! Every scenario is run by the explicit reference at a step where it has converged; the embedded
//! method is then compared with it, state by state, in f32 and f64 and at several steps, and so is
//! the implicit reference, which would show a mistake in the explicit one. Inputs are held on the
//! same grid for all, so what differs is the method alone.
//!
//! Bounds are for the step as it is shipped, in as many micro-steps as the joint chooses. What fewer of
//! them cost, where someone sets their number by hand, is a study beside it, without a bound.

mod bound;
mod page;
pub mod pareto;
mod random;
mod speed;
mod table;
#[cfg(test)]
mod tests;

pub use bound::{BETWEEN_REFERENCES, bound, fixed_bound};
pub use joint_simulation::quantity::Quantity;
pub use random::{Plant, Random};
pub use speed::Speed;

use rayon::prelude::*;
use serde::Serialize;

use crate::grid::Grid;
use crate::model::Model;
use crate::plant::{self, BuildError, Inputs, ScalarKind, Snapshot};
use crate::reference::{self, Method, Options, ReferenceError};
use crate::scenario::Scenario;

/// Step of the explicit reference, s: a quarter of the paper's. A step four times longer agrees
/// with it to 1e-6.
pub const REFERENCE_STEP_S: f64 = 25e-9;
/// The same along a log, which is longer.
const LOG_STEP_S: f64 = 100e-9;
/// Tolerance of the implicit reference.
pub const STIFF_TOLERANCE: f64 = 1e-9;

/// The embedded method in as many micro-steps as the joint chooses.
const CHOSEN: &str = "embedded";
/// Steps of the embedded method, µs, its name in the rows, and the micro-steps forced on it.
const RUNS: [(f64, &str, Option<u32>); 7] = [
    (10.0, CHOSEN, None),
    (25.0, CHOSEN, None),
    (50.0, CHOSEN, None),
    (50.0, "embedded-forced-1", Some(1)),
    (50.0, "embedded-forced-2", Some(2)),
    (100.0, CHOSEN, None),
    (100.0, "embedded-forced-2", Some(2)),
];

/// Number formats of the embedded method.
const SCALARS: [(ScalarKind, &str); 3] =
    [(ScalarKind::F32, "f32"), (ScalarKind::F64, "f64"), (ScalarKind::Fixed, "fixed")];

/// One state of one run beside the reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// What was run.
    pub scenario: &'static str,
    /// `embedded`, `embedded-forced-N` with N micro-steps forced on it, or `reference-stiff`.
    pub method: &'static str,
    /// Number format.
    pub scalar: &'static str,
    /// Step, µs; zero for an adaptive one.
    pub step_us: f64,
    /// The state.
    pub state: String,
    /// RMS of the difference over RMS of the reference.
    pub relative_rms: f64,
    /// What it may be at most; null where nothing is promised, as where micro-steps are forced.
    pub bound: Option<f64>,
    /// Micro-steps in a step; zero for a reference.
    pub micro_steps: u32,
    /// Whether the joint chose the micro-steps; a row of the study where it did not.
    pub chosen: bool,
}

impl Row {
    /// Whether it is within its bound, or where it has none a number.
    pub fn holds(&self) -> bool {
        self.relative_rms <= self.bound.unwrap_or(f64::MAX)
    }
}

/// Why there is no cross-check.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CrossCheckError {
    /// The joint cannot be built.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The reference failed.
    #[error("{scenario}: {error}")]
    Reference {
        /// Where.
        scenario: &'static str,
        /// Why.
        error: ReferenceError,
    },
}

/// Every row, and how fast each method is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CrossCheck {
    /// The rows, in the order of the scenarios.
    pub rows: Vec<Row>,
    /// Time of each method, where it was measured.
    pub speed: Option<Speed>,
}

impl CrossCheck {
    /// Rows that break their bound.
    pub fn broken(&self) -> Vec<&Row> {
        self.rows.iter().filter(|row| !row.holds()).collect()
    }

    /// Whether every bound holds.
    pub fn passed(&self) -> bool {
        self.broken().is_empty()
    }
}

/// Runs a model through scenarios; `done` is called after each of them, from any thread.
///
/// # Errors
/// The joint cannot be built, or a reference fails.
pub fn run(
    model: &Model,
    scenarios: &[Scenario],
    done: impl Fn() + Sync,
) -> Result<CrossCheck, CrossCheckError> {
    let rows: Result<Vec<_>, _> = scenarios
        .par_iter()
        .map(|scenario| {
            let rows = check(model, scenario);
            done();
            rows
        })
        .collect();
    Ok(CrossCheck { rows: rows?.into_iter().flatten().collect(), speed: None })
}

/// Runs a model of one's own, its effects with it, along the inputs of a log; of the embedded method nothing
/// is promised there, and fixed point is left out where the model's constants do not fit into it.
///
/// # Errors
/// The joint cannot be built, or a reference fails.
pub fn along(model: &Model, inputs: &Inputs) -> Result<CrossCheck, CrossCheckError> {
    let case = Case { name: "log", inputs, reference_step_s: LOG_STEP_S, promised: false };
    Ok(CrossCheck { rows: compared(model, &case)?, speed: None })
}

fn check(model: &Model, scenario: &Scenario) -> Result<Vec<Row>, CrossCheckError> {
    let (name, inputs) = (scenario.name, &scenario.inputs());
    compared(model, &Case { name, inputs, reference_step_s: REFERENCE_STEP_S, promised: true })
}

/// What a model is run along.
struct Case<'a> {
    name: &'static str,
    inputs: &'a Inputs,
    reference_step_s: f64,
    /// Whether the bounds are for it.
    promised: bool,
}

fn compared(model: &Model, case: &Case<'_>) -> Result<Vec<Row>, CrossCheckError> {
    let Case { name, inputs, reference_step_s, promised } = *case;
    let refer = |method| {
        reference::simulate(model, inputs, &Options::of(method))
            .map_err(|error| CrossCheckError::Reference { scenario: name, error })
    };
    let reference = refer(Method::BogackiShampine { step_s: reference_step_s })?;
    let stiff = refer(Method::Stiff { tolerance: STIFF_TOLERANCE })?;
    let quantities = Quantity::of(model.stages.len());
    let mut rows = Vec::new();
    let mut compare = |other: &[Snapshot], like: &Row, bound: &dyn Fn(Quantity) -> Option<f64>| {
        rows.extend(quantities.iter().map(|quantity| Row {
            state: quantity.to_string(),
            relative_rms: quantity.relative_rms(&reference, other),
            bound: bound(*quantity),
            ..like.clone()
        }));
    };
    let mut like = Row {
        scenario: name,
        method: "reference-stiff",
        scalar: "f64",
        step_us: 0.0,
        state: String::new(),
        relative_rms: 0.0,
        bound: None,
        micro_steps: 0,
        chosen: true,
    };
    compare(&stiff, &like, &|_| Some(BETWEEN_REFERENCES));
    let interval = Grid::new(&inputs.time_s, None).typical_interval();
    for (step_us, method, forced) in RUNS {
        let picked = rule(model, step_us * 1e-6);
        if forced == Some(picked) || step_us * 1e-6 > 1.001 * interval {
            continue;
        }
        like = Row {
            method,
            step_us,
            micro_steps: forced.unwrap_or(picked),
            chosen: forced.is_none(),
            ..like
        };
        for (scalar, name) in SCALARS {
            let step = Some(step_us * 1e-6);
            let run = match plant::simulate(model, inputs, scalar, step, forced) {
                Err(_) if scalar == ScalarKind::Fixed && !promised => continue,
                run => run?,
            };
            like.scalar = name;
            compare(&run, &like, &|quantity| match scalar {
                _ if !promised || !like.chosen => None,
                ScalarKind::Fixed => fixed_bound(step_us),
                _ => bound(step_us, like.micro_steps, quantity),
            });
        }
    }
    Ok(rows)
}

/// The micro-steps that the parameters ask for.
fn rule(model: &Model, step_s: f64) -> u32 {
    joint_core::joint::micro_steps(&model.motor, &model.stages, &model.load, step_s)
}
