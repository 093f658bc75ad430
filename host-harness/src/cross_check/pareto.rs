//! Error over cost: the step in one to eight micro-steps, in f32, f64 and fixed point, beside the
//! implicit method and explicit ones.
//!
//! The error is the worst state's over every scenario at a control period of 50 µs. The cost is
//! instructions of a Cortex-M4 in such a period for a joint of two stages, from what QEMU counts of one
//! micro-step and of one evaluation of the equations in f32 (`firmware/src/bin/prices.rs`); explicit
//! methods are charged for their evaluations alone.

use std::fmt::Write;

use joint_core::joint::Method as Stepping;
use rayon::prelude::*;
use serde::Serialize;

use super::chart::Chart;
use super::{CrossCheckError, Quantity, REFERENCE_STEP_S};
use crate::model::Model;
use crate::plant::{self, Layout, ScalarKind, Snapshot};
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
        counted: [2437.0; 2],
    },
    Way {
        name: "implicit, f32",
        scalar: ScalarKind::F32,
        method: Stepping::Implicit,
        counted: [1879.0, 1708.0],
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

const CHART: Chart = Chart {
    width: 760.0,
    height: 460.0,
    left: 70.0,
    right: 180.0,
    top: 40.0,
    bottom: 50.0,
    across: (2.5, 6.2),
    up: (-5.0, -0.3),
};
const COLOURS: [&str; 6] = ["#0072b2", "#e69f00", "#009e73", "#cc79a7", "#555555", "#d55e00"];

/// The plot.
pub fn svg(points: &[Point]) -> String {
    let Chart { width, height, left, top, .. } = CHART;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" \
         font-family=\"system-ui,sans-serif\" font-size=\"12\" fill=\"#333\">\
         <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\
         <text x=\"{left}\" y=\"22\" font-size=\"15\">Worst state over all scenarios, over instructions \
         in 50 µs on a Cortex-M4</text>"
    );
    axes(&mut svg);
    let mut methods: Vec<&str> = points.iter().map(|point| point.method).collect();
    methods.dedup();
    for (k, (method, colour)) in methods.iter().zip(COLOURS.iter().cycle()).enumerate() {
        let own: Vec<&Point> = points.iter().filter(|point| point.method == *method).collect();
        for (of, dash, fill) in [
            ((|p: &Point| p.error) as fn(&Point) -> f64, "", *colour),
            (|p: &Point| p.error_but_worst, " stroke-dasharray=\"3 3\"", "#fff"),
        ] {
            let path = CHART.path(own.iter().map(|point| (point.instructions, of(point))));
            let _ = write!(svg, "<path d=\"{path}\" fill=\"none\" stroke=\"{colour}\"{dash}/>");
            for point in &own {
                let (x, y) = (CHART.x(point.instructions), CHART.y(of(point)));
                let _ = write!(
                    svg,
                    "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3.5\" fill=\"{fill}\" stroke=\"{colour}\"/>"
                );
            }
        }
        for point in &own {
            let (x, y) = (CHART.x(point.instructions) + 6.0, CHART.y(point.error) - 6.0);
            let _ = write!(
                svg,
                "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"10\">{}</text>",
                point.setting
            );
        }
        let (x, y) = (CHART.end() + 14.0, top + 16.0 + 20.0 * k as f64);
        let _ = write!(svg, "<text x=\"{x}\" y=\"{y}\" fill=\"{colour}\">● {method}</text>");
    }
    let (x, y) = (CHART.end() + 14.0, top + 16.0 + 20.0 * methods.len() as f64);
    let _ = writeln!(
        svg,
        "<text x=\"{x}\" y=\"{y}\">○ without each point's</text><text x=\"{x}\" y=\"{}\">worst \
         scenario</text></svg>",
        y + 15.0
    );
    svg
}

fn axes(svg: &mut String) {
    let Chart { left, top, .. } = CHART;
    let (right, bottom) = (CHART.end(), CHART.floor());
    for (error, label) in
        [(1e-5, "0.001 %"), (1e-4, "0.01 %"), (1e-3, "0.1 %"), (1e-2, "1 %"), (1e-1, "10 %")]
    {
        let (y, width) = (CHART.y(error), if error == 1e-2 { 2 } else { 1 });
        let _ = write!(
            svg,
            "<path d=\"M{left} {y:.1}H{right}\" stroke=\"#ddd\" stroke-width=\"{width}\"/>\
             <text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{label}</text>",
            left - 6.0,
            y + 4.0
        );
    }
    for (instructions, label) in [(1e3, "1000"), (1e4, "10 000"), (1e5, "100 000"), (1e6, "10⁶")]
    {
        let x = CHART.x(instructions);
        let _ = write!(
            svg,
            "<path d=\"M{x:.1} {top}V{bottom}\" stroke=\"#ddd\"/>\
             <text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{label}</text>",
            bottom + 18.0
        );
    }
    let _ = write!(
        svg,
        "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">instructions</text>",
        0.5 * (left + right),
        CHART.height - 10.0
    );
}
