//! The reference: what the drive's step is judged by.
//!
//! In f64, from its own right-hand side and with methods that know nothing of the joint, it shares
//! no assembly and no integrator with `joint-core`. There are two methods, one explicit at a fixed
//! small step as the paper runs it and one adaptive and implicit, and they check each other. The
//! reference also carries what the drive's model does not: process noise and a Stribeck exponent
//! other than two, so that synthetic logs differ from the model as real ones do.

mod bogacki_shampine;
mod equations;
pub mod friction;
mod rates;
mod report;
mod stepper;
mod stiff;
#[cfg(test)]
mod tests;
mod winding;

pub use equations::{Equations, Held};
pub use stepper::Stepper;

use joint_core::joint::Drive;
use joint_core::params::ParameterError;

use friction::Family;

use crate::acting::at_samples;
use crate::model::Model;
use crate::plant::{Inputs, Snapshot};

/// The paper's step, s: the longest that holds 1 % on its joint.
pub const PAPER_STEP_S: f64 = 1e-7;

/// How the reference integrates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// Explicit, third order, steps of at most this length in s.
    BogackiShampine {
        /// Longest step, s.
        step_s: f64,
    },
    /// Explicit, third order, the step of each sample this share of the fastest relaxation's time
    /// in it: at 0.4 it is as good as converged, and far from top speed much faster.
    Scaled {
        /// Share of the fastest relaxation's time.
        share: f64,
    },
    /// Adaptive and implicit, to this relative tolerance.
    Stiff {
        /// Relative tolerance of a step.
        tolerance: f64,
    },
}

impl Method {
    /// The explicit method at a quarter of the fastest relaxation's time at this speed of the motor,
    /// rad/s, where it is converged.
    ///
    /// # Errors
    /// The first parameter that the equations cannot take.
    pub fn converged(model: &Model, drive: Drive, speed: f64) -> Result<Self, ReferenceError> {
        let rate = Equations::new(model, drive, 2.0)?.rate_at(speed);
        Ok(Self::BogackiShampine { step_s: (0.25 / rate).min(1e-5) })
    }
}

impl Default for Method {
    fn default() -> Self {
        Self::BogackiShampine { step_s: PAPER_STEP_S }
    }
}

/// Process noise: what else acts on the joint, held over each sample.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Disturbance {
    /// Added to the voltage, V (to the current, A, where that is the input).
    pub drive: Vec<f64>,
    /// Added to the torque on the rotor, Nm.
    pub torque_nm: Vec<f64>,
    /// Relative change of the level of all friction.
    pub friction_change: Vec<f64>,
}

impl Disturbance {
    /// What acts over sample `k` beside drive and load; nothing past its end.
    pub fn at(&self, k: usize, drive: f64, load: f64) -> Held {
        let at = |values: &[f64]| values.get(k).copied().unwrap_or(0.0);
        Held {
            drive: drive + at(&self.drive),
            load,
            torque: at(&self.torque_nm),
            friction_change: at(&self.friction_change),
        }
    }
}

/// What a run needs beside model and inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// How to integrate.
    pub method: Method,
    /// Exponent of the Stribeck curve, 2 in the model.
    pub stribeck_exponent: f64,
    /// Family of the friction law, LuGre in the model.
    pub friction: Family,
    /// Process noise.
    pub disturbance: Disturbance,
    /// The state to begin with, as [`Layout`](crate::plant::Layout) has it; `None` begins at rest.
    pub start: Option<Vec<f64>>,
}

impl Default for Options {
    fn default() -> Self {
        Self::of(Method::default())
    }
}

impl Options {
    /// The model's own Stribeck curve, no noise.
    pub fn of(method: Method) -> Self {
        Self {
            method,
            stribeck_exponent: 2.0,
            friction: Family::LuGre,
            disturbance: Disturbance::default(),
            start: None,
        }
    }
}

/// Why there is no reference.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ReferenceError {
    /// A parameter that the equations cannot take.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// A voltage cannot drive a winding without resistance.
    #[error("phase_resistance_ohm must be more than zero where the voltage is the input")]
    NoResistance,
    /// An effect has no place in this joint.
    #[error("an effect of the model has no place in this joint")]
    Effects,
    /// The inputs contradict themselves.
    #[error("inputs: {0}")]
    Inputs(&'static str),
    /// The state left the finite numbers.
    #[error("the reference diverged at {0} s: its step is too long for this joint")]
    Diverged(f64),
    /// The implicit solver gave up.
    #[error("the implicit reference failed: {0}")]
    Stiff(String),
}

/// Runs a model on inputs, from rest where no other start is given; snapshot `k` is the state at `time_s[k]`.
///
/// # Errors
/// A model or inputs that make no sense, or a method that fails on them.
pub fn simulate(
    model: &Model,
    inputs: &Inputs,
    options: &Options,
) -> Result<Vec<Snapshot>, ReferenceError> {
    check(inputs, options)?;
    if let Some((acting, samples)) = inputs.acting(model) {
        let run = simulate_acting(model, &acting, options, |k| samples[k])?;
        return Ok(at_samples(run, &samples));
    }
    simulate_acting(model, inputs, options, |k| k)
}

/// The same of inputs that act as they are; `sample` is which sample's disturbance does.
fn simulate_acting(
    model: &Model,
    inputs: &Inputs,
    options: &Options,
    sample: impl Fn(usize) -> usize,
) -> Result<Vec<Snapshot>, ReferenceError> {
    let equations = Equations::new(model, inputs.drive, options.stribeck_exponent)?
        .with_friction(options.friction);
    let load = |k: usize| inputs.load_nm.get(k).copied().unwrap_or(0.0);
    let held = |k: usize| options.disturbance.at(sample(k), inputs.drive_values[k], load(k));
    let mut state = equations.rest();
    if let Some(start) = &options.start {
        let known = state.len().min(start.len());
        state[..known].copy_from_slice(&start[..known]);
        // A bristle's stretch in place of its torque over the Coulomb level.
        for (k, mass) in equations.masses.iter().enumerate() {
            let bristle = &mut state[equations.layout().bristle(k)];
            *bristle *= if mass.sigma0 > 0.0 { mass.alpha0 / mass.sigma0 } else { 0.0 };
        }
    }
    if let Method::Stiff { tolerance } = options.method {
        if matches!(options.friction, Family::MaxwellSlip { .. }) {
            return Err(ReferenceError::Inputs(
                "Maxwell-slip friction changes between distinct states: take an explicit method",
            ));
        }
        return stiff::run(&equations, &inputs.time_s, held, tolerance, state);
    }
    let mut stepper = Stepper::new(&equations, options.method);
    let mut snapshots = Vec::with_capacity(inputs.time_s.len());
    snapshots.push(equations.snapshot(&state));
    for (k, pair) in inputs.time_s.windows(2).enumerate() {
        stepper.advance(&mut state, &held(k), pair[1] - pair[0]);
        if state.iter().any(|value| !value.is_finite()) {
            return Err(ReferenceError::Diverged(pair[1]));
        }
        snapshots.push(equations.snapshot(&state));
    }
    Ok(snapshots)
}

fn check(inputs: &Inputs, options: &Options) -> Result<(), ReferenceError> {
    let fail = |what| Err(ReferenceError::Inputs(what));
    if inputs.time_s.is_empty() {
        return fail("there is no sample");
    }
    if inputs.drive_values.len() < inputs.time_s.len() {
        return fail("fewer drive values than times");
    }
    let finite = |values: &[f64]| values.iter().all(|value| value.is_finite());
    if !(finite(&inputs.time_s) && finite(&inputs.drive_values) && finite(&inputs.load_nm)) {
        return fail("a value is not finite");
    }
    if inputs.time_s.windows(2).any(|pair| pair[1] <= pair[0]) {
        return fail("time does not rise");
    }
    let positive = match options.method {
        Method::BogackiShampine { step_s } => step_s,
        Method::Scaled { share } => share,
        Method::Stiff { tolerance } => tolerance,
    };
    if !(positive > 0.0 && positive.is_finite() && options.stribeck_exponent > 0.0) {
        return fail("step, tolerance and Stribeck exponent must be more than zero");
    }
    Ok(())
}
