//! Error over cost: the step in one to eight micro-steps, in f32, f64 and fixed point, beside the
//! implicit method and explicit ones.
//!
//! The error is the worst state's over every scenario at a control period of 50 µs. The cost is
//! instructions of a Cortex-M4 in such a period for a joint of two stages, from what QEMU counts of one
//! micro-step and of one evaluation of the equations in f32 (`firmware/src/bin/prices.rs`); explicit
//! methods are charged for their evaluations alone.

use joint_core::joint::Method as Stepping;
use rayon::prelude::*;
use serde::Serialize;

use super::{CrossCheckError, Quantity, REFERENCE_STEP_S};
use crate::model::Model;
use crate::plant::{self, Layout, ScalarKind, Snapshot};
use crate::plot::{Axis, Ink, Mark, Plot, Series};
use crate::reference::{self, Equations, Held, Method, Options};
use crate::scenario::Scenario;

/// The control period, s.
const PERIOD_S: f64 = 50e-6;
/// Instructions of one evaluation of the equations in f32, two stages.
const EVALUATION: f64 = 268.0;
const MICRO_STEPS: [u32; 6] = [1, 2, 3, 4, 6, 8];

/// A way to compute the joint's own step.
struct Way {
    name: &'static str,
    scalar: ScalarKind,
    method: Stepping,
    /// Instructions of a step in one micro-step, and of each further one; two stages.
    counted: [f64; 2],
}

/// f64 as calls of the compiler's library, since a Cortex-M4F has no double precision.
const WAYS: [Way; 4] = [
    Way {
        name: "step, f32",
        scalar: ScalarKind::F32,
        method: Stepping::Splitting,
        counted: [698.0; 2],
    },
    Way {
        name: "step, f64",
        scalar: ScalarKind::F64,
        method: Stepping::Splitting,
        counted: [53_434.0; 2],
    },
    Way {
        name: "step, fixed point",
        scalar: ScalarKind::Fixed,
        method: Stepping::Splitting,
        counted: [1982.0; 2],
    },
    Way {
        name: "implicit, f32",
        scalar: ScalarKind::F32,
        method: Stepping::Implicit,
        counted: [1893.0, 1708.0],
    },
];
/// Steps of the explicit methods, s.
const EXPLICIT_STEPS_S: [f64; 5] = [0.05e-6, 0.1e-6, 0.25e-6, 0.5e-6, 1e-6];
/// An explicit run this far off is none.
const LOST: f64 = 0.5;

/// One method at one setting.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Point {
    /// The method.
    pub method: &'static str,
    /// Its micro-steps, or its step.
    pub setting: String,
    /// Instructions in a period of 50 µs.
    pub instructions: f64,
    /// Worst relative RMS of a state over all scenarios.
    pub error: f64,
    /// The same but for the scenario on which the step does worst.
    pub error_but_worst: f64,
    /// That scenario.
    pub worst: &'static str,
}

/// Runs every method on every scenario.
///
/// # Errors
/// The joint cannot be built, or the reference fails.
pub fn run(model: &Model, scenarios: &[Scenario]) -> Result<Vec<Point>, CrossCheckError> {
    let columns = scenarios
        .par_iter()
        .map(|scenario| errors(model, scenario))
        .collect::<Result<Vec<_>, _>>()?;
    let settings = settings();
    let points = settings.into_iter().enumerate().map(|(row, (method, setting, instructions))| {
        let mut errors: Vec<(f64, &'static str)> = columns
            .iter()
            .zip(scenarios)
            .map(|(column, scenario)| (column[row], scenario.name))
            .collect();
        errors.sort_by(|a, b| b.0.total_cmp(&a.0));
        let (error, worst) = errors.first().copied().unwrap_or((0.0, ""));
        let error_but_worst = errors.get(1).map_or(error, |next| next.0);
        Point { method, setting, instructions, error, error_but_worst, worst }
    });
    Ok(points.filter(|point| point.error < LOST).collect())
}

/// Method, setting and instructions of every point, in the order of [`errors`].
fn settings() -> Vec<(&'static str, String, f64)> {
    let mut all = Vec::new();
    for Way { name, counted: [first, further], .. } in &WAYS {
        let spent = |n| first + further * f64::from(n - 1);
        all.extend(MICRO_STEPS.map(|n| (*name, n.to_string(), spent(n))));
    }
    for (method, evaluations) in [("Bogacki–Shampine", 3.0), ("explicit Euler", 1.0)] {
        all.extend(EXPLICIT_STEPS_S.map(|step| {
            (method, format!("{:.3} µs", 1e6 * step), EVALUATION * evaluations * PERIOD_S / step)
        }));
    }
    all
}

fn errors(model: &Model, scenario: &Scenario) -> Result<Vec<f64>, CrossCheckError> {
    let inputs = scenario.inputs();
    let refer = |step_s| {
        let method = Method::BogackiShampine { step_s };
        reference::simulate(model, &inputs, &Options::of(method))
            .map_err(|error| CrossCheckError::Reference { scenario: scenario.name, error })
    };
    let exact = refer(REFERENCE_STEP_S)?;
    let worst = |run: &[Snapshot]| {
        Quantity::of(model.stages.len())
            .into_iter()
            .map(|quantity| quantity.relative_rms(&exact, run))
            .fold(0.0, |a: f64, b| if b.is_nan() { f64::INFINITY } else { a.max(b) })
    };
    let mut all = Vec::new();
    for Way { scalar, method, .. } in &WAYS {
        for n in MICRO_STEPS {
            let (method, step) = (Some(*method), Some(PERIOD_S));
            let run = plant::simulate_by(method, model, &inputs, *scalar, step, Some(n))?;
            all.push(worst(&run));
        }
    }
    for step in EXPLICIT_STEPS_S {
        all.push(refer(step).map_or(f64::INFINITY, |run| worst(&run)));
    }
    let equations = Equations::new(model, inputs.drive, 2.0)
        .map_err(|error| CrossCheckError::Reference { scenario: scenario.name, error })?;
    let layout = equations.layout();
    for step in EXPLICIT_STEPS_S {
        let (mut state, mut rate) = (equations.rest(), equations.rest());
        let mut run = Vec::with_capacity(inputs.time_s.len());
        for k in 0..inputs.time_s.len() {
            run.push(equations.snapshot(&state));
            let interval = inputs.time_s.get(k + 1).map_or(0.0, |next| next - inputs.time_s[k]);
            let held =
                Held { drive: inputs.drive_values[k], load: inputs.load_nm[k], ..Held::default() };
            equations.settle(&held, &mut state);
            for _ in 0..(interval / step).round() as u64 {
                equations.derivative(&held, &state, &mut rate);
                state.iter_mut().zip(&rate).for_each(|(value, rate)| *value += step * rate);
                // Angles with the new speeds.
                let gained = |mass| step * step * rate[layout.speed(mass)];
                state[Layout::ANGLE] += gained(0);
                for stage in 0..layout.stages {
                    state[layout.deflection(stage)] += gained(stage) - gained(stage + 1);
                }
            }
        }
        all.push(worst(&run));
    }
    Ok(all)
}

/// The points as a plot: filled with every scenario, rings without each point's worst.
pub fn plot(points: &[Point]) -> Plot<'_> {
    let mut methods: Vec<&str> = points.iter().map(|point| point.method).collect();
    methods.dedup();
    let mut series = Vec::new();
    for (k, method) in methods.into_iter().enumerate() {
        let own = || points.iter().filter(|point| point.method == method);
        let along = |error: fn(&Point) -> f64| -> [Vec<f64>; 2] {
            [own().map(|p| p.instructions).collect(), own().map(|p| 100.0 * error(p)).collect()]
        };
        let [x, y] = along(|point| point.error_but_worst);
        series.push(Series::new("", Ink::Nth(k), Mark::Rings, x, y));
        let [x, y] = along(|point| point.error);
        let labels = own().map(|point| point.setting.clone()).collect();
        let notes = own().map(|p| format!("{}, {}: {:.3} %", method, p.setting, 100.0 * p.error));
        let notes = notes.collect();
        series.push(Series { labels, notes, ..Series::new(method, Ink::Nth(k), Mark::Dots, x, y) });
    }
    let across = Axis::log("instructions in 50 µs on a Cortex-M4", "").within([300.0, 2e6]);
    let up = Axis::log("worst state over all scenarios (ring: without the worst scenario)", "%");
    let plot = Plot::new("", across, up.within([1e-6, 50.0])).sized(860.0, 420.0).explained();
    Plot { series, zoom: false, ..plot }
}
