//! The observer over a log: the very code that runs in the drive.

use joint_core::effect::EffectSet;
use joint_core::joint::{Drive, Joint, Settings};
use joint_core::observer::{Design, Estimate, Gains, Observer, Sample, Turn};
use joint_core::params::ParameterError;
use joint_core::scalar::Scalar;

use crate::model::Model;
use crate::plant::micro_steps;

/// What the observer is given at one sampling instant, exactly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// V or A; NaN where it is missing.
    pub drive: f64,
    /// A; NaN where it is missing.
    pub current: f64,
    /// rad; NaN where it is missing.
    pub motor: f64,
    /// rad; NaN where it is missing.
    pub output: f64,
}

/// What is found at one sampling instant.
#[derive(Clone, Debug, PartialEq)]
pub struct Found<const N: usize> {
    /// The estimate.
    pub estimate: Estimate<f64, N>,
    /// Output angle with all its turns, rad.
    pub output_angle: f64,
}

/// How an observer's joint is stepped: measurements correct every sample, so that one step need be
/// right, not a whole run.
pub fn settings(model: &Model, kind: Drive, step_s: f64) -> Settings<'_> {
    Settings {
        micro_steps: Some(micro_steps(model, step_s)),
        effects: &model.effects,
        ..Settings::new(kind, step_s)
    }
}

/// An observer of a model.
///
/// # Errors
/// A parameter that the equations cannot take.
pub fn observer<S: Scalar, const N: usize>(
    model: &Model,
    kind: Drive,
    step_s: f64,
    design: &Design<N>,
) -> Result<Observer<S, N, EffectSet<S>>, ParameterError> {
    let stages: [_; N] = std::array::from_fn(|k| model.stages[k]);
    let settings = settings(model, kind, step_s);
    let joint = Joint::<S, N, EffectSet<S>>::new(&model.motor, &stages, &model.load, &settings)?;
    let gains = Gains::new(design, &model.motor, &stages, kind, step_s);
    Ok(Observer { joint, gains })
}

/// Runs an observer over samples that stand `steps` steps after one another; a sample that is late
/// finds the steps before it without a measurement.
pub fn run<S: Scalar, const N: usize>(
    observer: &Observer<S, N, EffectSet<S>>,
    samples: &[Seen],
    steps: &[u32],
) -> Vec<Found<N>> {
    let turns = |angle: f64| angle / std::f64::consts::TAU;
    let first = samples.iter().map(|s| s.motor).find(|v| v.is_finite()).unwrap_or(0.0);
    let mut track = observer.start(turns(first).round() as i32);
    let mut found = Vec::with_capacity(samples.len());
    let mut held = S::ZERO;
    for (k, seen) in samples.iter().enumerate() {
        for _ in 1..steps.get(k).copied().unwrap_or(1) {
            observer.update(&mut track, &Sample { drive: held, ..Sample::default() });
        }
        let angle = |value: f64| value.is_finite().then(|| Turn::from_turns(turns(value)));
        let drive = S::from_f64(seen.drive);
        if seen.drive.is_finite() {
            held = drive;
        }
        let sample = Sample {
            drive,
            current: seen.current.is_finite().then(|| S::from_f64(seen.current)),
            motor: angle(seen.motor),
            output: angle(seen.output),
        };
        observer.update(&mut track, &sample);
        found.push(read(&observer.estimate(&track)));
    }
    found
}

fn read<S: Scalar, const N: usize>(e: &Estimate<S, N>) -> Found<N> {
    let turn = std::f64::consts::TAU;
    let s = &e.spread;
    let estimate = Estimate {
        motor_velocity: e.motor_velocity.to_f64(),
        motor_friction: e.motor_friction.to_f64(),
        stage_friction: e.stage_friction.map(S::to_f64),
        total_friction: e.total_friction.to_f64(),
        windup: e.windup.map(S::to_f64),
        output_turns: e.output_turns,
        output_part: e.output_part.to_f64(),
        output_velocity: e.output_velocity.to_f64(),
        load: e.load.to_f64(),
        bias: e.bias.to_f64(),
        spread: joint_core::observer::Spread {
            motor_velocity: s.motor_velocity.to_f64(),
            total_friction: s.total_friction.to_f64(),
            windup: s.windup.map(S::to_f64),
            output_angle: s.output_angle.to_f64(),
            output_velocity: s.output_velocity.to_f64(),
            load: s.load.to_f64(),
        },
        row: e.row,
        status: e.status,
    };
    let output_angle = (f64::from(e.output_turns) + estimate.output_part) * turn;
    Found { estimate, output_angle }
}
