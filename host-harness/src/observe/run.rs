//! The observer over a log: the very code that runs in the drive.

use std::f64::consts::TAU;

use joint_core::effect::EffectSet;
use joint_core::fixed::Fixed;
use joint_core::joint::{Drive, Joint, Settings};
use joint_core::observer::{
    Design, Estimate, Gains, Observer, Sample, Spread, Status, Track, Turn,
};
use joint_core::params::ParameterError;
use joint_core::per_unit::Bases;
use joint_core::scalar::Real;

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
pub fn observer<S: Real, const N: usize>(
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
pub fn run<S: Real, const N: usize>(
    observer: &Observer<S, N, EffectSet<S>>,
    samples: &[Seen],
    steps: &[u32],
) -> Vec<Found<N>> {
    run_with(observer, samples, steps, |track| in_f64(&observer.estimate(track)))
}

/// The same in fixed point, whose readings `bases` turn into SI. Voltages and currents beyond 32
/// stop there.
pub fn run_fixed<const N: usize>(
    observer: &Observer<Fixed, N, EffectSet<Fixed>>,
    bases: &Bases<'_>,
    samples: &[Seen],
    steps: &[u32],
) -> Vec<Found<N>> {
    let imposed = observer.joint.is_current_imposed();
    run_with(observer, samples, steps, |track| {
        in_si(in_f64(&observer.reading(track)), bases, imposed)
    })
}

fn run_with<S: Real, const N: usize>(
    observer: &Observer<S, N, EffectSet<S>>,
    samples: &[Seen],
    steps: &[u32],
    read: impl Fn(&Track<S, N>) -> Estimate<f64, N>,
) -> Vec<Found<N>> {
    let turns = |angle: f64| angle / TAU;
    let first = samples.iter().map(|s| s.motor).find(|v| v.is_finite()).unwrap_or(0.0);
    let mut track = observer.start(turns(first).round() as i32);
    let mut found = Vec::with_capacity(samples.len());
    let mut held = S::ZERO;
    let none = S::from_f64(f64::NAN);
    let has_none = none.partial_cmp(&none).is_none();
    for (k, seen) in samples.iter().enumerate() {
        for _ in 1..steps.get(k).copied().unwrap_or(1) {
            observer.update(&mut track, &Sample { drive: held, ..Sample::default() });
        }
        let angle = |value: f64| value.is_finite().then(|| Turn::from_turns(turns(value)));
        let mut drive = S::from_f64(seen.drive);
        let known = seen.drive.is_finite();
        if known {
            held = drive;
        } else if !has_none {
            // Fixed point cannot say that a drive is missing: who feeds it holds the last one, and
            // knows of it.
            drive = held;
        }
        let sample = Sample {
            drive,
            current: seen.current.is_finite().then(|| S::from_f64(seen.current)),
            motor: angle(seen.motor),
            output: angle(seen.output),
        };
        observer.update(&mut track, &sample);
        let mut estimate = read(&track);
        estimate.status = estimate.status.with_if(!known, Status::NO_DRIVE);
        let output_angle = (f64::from(estimate.output_turns) + estimate.output_part) * TAU;
        found.push(Found { estimate, output_angle });
    }
    found
}

fn in_f64<S: Real, const N: usize>(e: &Estimate<S, N>) -> Estimate<f64, N> {
    let s = &e.spread;
    Estimate {
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
        resistance: e.resistance.to_f64(),
        flux: e.flux.to_f64(),
        friction: e.friction.to_f64(),
        spread: Spread {
            motor_velocity: s.motor_velocity.to_f64(),
            total_friction: s.total_friction.to_f64(),
            windup: s.windup.map(S::to_f64),
            output_angle: s.output_angle.to_f64(),
            output_velocity: s.output_velocity.to_f64(),
            load: s.load.to_f64(),
        },
        row: e.row,
        status: e.status,
    }
}

/// A reading in SI.
fn in_si<const N: usize>(
    e: Estimate<f64, N>,
    bases: &Bases<'_>,
    current_imposed: bool,
) -> Estimate<f64, N> {
    let Bases { torque, speed, angle, current, resistance, .. } = *bases;
    let shaft = bases.shaft(N);
    let wound = |values: [f64; N]| -> [f64; N] {
        std::array::from_fn(|k| values[k] * angle * bases.shaft(k + 1))
    };
    let s = &e.spread;
    Estimate {
        motor_velocity: e.motor_velocity * speed,
        motor_friction: e.motor_friction * torque,
        stage_friction: e.stage_friction.map(|value| value * torque),
        total_friction: e.total_friction * torque,
        windup: wound(e.windup),
        output_velocity: e.output_velocity * speed * shaft,
        load: e.load * torque / shaft,
        bias: e.bias * if current_imposed { current } else { resistance * current },
        spread: Spread {
            motor_velocity: s.motor_velocity * speed,
            total_friction: s.total_friction * torque,
            windup: wound(s.windup).map(f64::abs),
            output_angle: s.output_angle * TAU,
            output_velocity: (s.output_velocity * speed * shaft).abs(),
            load: (s.load * torque / shaft).abs(),
        },
        ..e
    }
}
