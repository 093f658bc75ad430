//! Section 5.1: how far the explicit method of the paper goes, and how far the drive's step.
//!
//! Both run the same joint at the motor's nominal voltage; the judge is Bogacki–Shampine at a quarter
//! of the paper's step. Cost is time in the same run of the program, as a ratio.

use std::time::Instant;

use joint_core::joint::Drive;
use serde::{Deserialize, Serialize};

use super::scene::{Profile, read};
use crate::cross_check::{Quantity, REFERENCE_STEP_S};
use crate::model::Model;
use crate::plant::{self, Inputs, ScalarKind, Snapshot};
use crate::reference::{self, Method, Options, ReferenceError};

/// Steps of the explicit method, µs.
const EXPLICIT_US: [f64; 8] = [0.05, 0.08, 0.1, 0.125, 0.16, 0.2, 0.3, 0.5];
/// Steps of the drive's method, µs; divisors of the input's grid.
const EMBEDDED_US: [f64; 8] = [1.0, 2.0, 5.0, 10.0, 25.0, 50.0, 100.0, 200.0];
/// The grid on which the voltage is held, s.
const GRID_S: f64 = 200e-6;
/// How often a short run is timed.
const REPEATS: u32 = 5;
/// The paper's tolerance.
pub const TOLERANCE: f64 = 0.01;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Data {
    voltage: Profile,
}

/// One method at one step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Point {
    /// Step, µs.
    pub step_us: f64,
    /// Largest relative RMS error of any state; infinite where the run left the finite numbers.
    pub error: f64,
    /// Time over that of the explicit method at 0.1 µs.
    pub cost: f64,
}

/// The claim, measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Claim {
    /// Bogacki–Shampine.
    pub explicit: Vec<Point>,
    /// The drive's step, with the micro-steps that its rule picks, in f32.
    pub embedded: Vec<Point>,
    /// The same, never divided into micro-steps.
    pub undivided: Vec<Point>,
}

impl Claim {
    /// The longest explicit step up to which every one tried stays within the tolerance, µs.
    pub fn longest_explicit_us(&self) -> f64 {
        let within = self.explicit.iter().take_while(|point| point.error <= TOLERANCE);
        within.last().map_or(0.0, |point| point.step_us)
    }
}

/// Runs both methods over their steps.
///
/// # Errors
/// The judge fails, or the model is not admissible.
pub fn measure(model: &Model, mut done: impl FnMut()) -> Result<Claim, String> {
    let data: Data = read("claim", include_str!("data/claim.toml"))?;
    let samples = (0.1 / GRID_S).round() as usize + 1;
    let time_s: Vec<f64> = (0..samples).map(|k| k as f64 * GRID_S).collect();
    let inputs = Inputs {
        drive: Drive::Voltage,
        drive_values: time_s.iter().map(|t| data.voltage.at(*t).0).collect(),
        load_nm: vec![0.0; samples],
        time_s,
    };
    let explicit = |step_s: f64| {
        reference::simulate(model, &inputs, &Options::of(Method::BogackiShampine { step_s }))
    };
    let judge = explicit(REFERENCE_STEP_S).map_err(|error| error.to_string())?;
    let worst = |run: &[Snapshot]| {
        let all = Quantity::of(model.stages.len());
        let errors = all.iter().map(|quantity| quantity.relative_rms(&judge, run));
        errors.fold(0.0, |worst, e: f64| if e.is_nan() { f64::INFINITY } else { e.max(worst) })
    };
    let mut claim = Claim { explicit: Vec::new(), embedded: Vec::new(), undivided: Vec::new() };
    let mut paper = 1.0;
    for step_us in EXPLICIT_US {
        let start = Instant::now();
        let error = match explicit(step_us * 1e-6) {
            Ok(run) => worst(&run),
            Err(ReferenceError::Diverged(_)) => f64::INFINITY,
            Err(other) => return Err(other.to_string()),
        };
        let cost = start.elapsed().as_secs_f64();
        if step_us == 0.1 {
            paper = cost;
        }
        claim.explicit.push(Point { step_us, error, cost });
        done();
    }
    for (step_us, micro_steps) in
        EMBEDDED_US.iter().flat_map(|step| [None, Some(1)].map(|micro| (*step, micro)))
    {
        let (mut cost, mut error) = (f64::INFINITY, 0.0);
        // Short runs: the least of a few is the one that nothing interrupted.
        for _ in 0..REPEATS {
            let start = Instant::now();
            let step = Some(step_us * 1e-6);
            let run = plant::simulate(model, &inputs, ScalarKind::F32, step, micro_steps)
                .map_err(|error| error.to_string())?;
            cost = start.elapsed().as_secs_f64().min(cost);
            error = worst(&run);
        }
        let points = if micro_steps.is_none() { &mut claim.embedded } else { &mut claim.undivided };
        points.push(Point { step_us, error, cost });
        done();
    }
    let embedded = claim.embedded.iter_mut().chain(&mut claim.undivided);
    for point in claim.explicit.iter_mut().chain(embedded) {
        point.cost /= paper;
    }
    Ok(claim)
}
