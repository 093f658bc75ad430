//! The same scenarios with the motor's three phases, its amplifier and a speed loop in place of the
//! prescribed speed.

use joint_core::effect::EffectSet;
use joint_core::motor::inverter::Amplifier;
use joint_core::params::ParameterError;
use joint_core::six_step::{Command, SixStep};

use super::scene::{Scene, read};
use super::trace::{SAMPLE_S, Trace};
use crate::model::Model;
use crate::plant::BuildError;

/// Bandwidth of the speed loop, rad/s.
const SPEED_BANDWIDTH: f64 = 1500.0;

/// The amplifier of the paper's joint.
///
/// # Errors
/// The data file does not read.
pub fn amplifier() -> Result<Amplifier, String> {
    read("amplifier", include_str!("data/amplifier.toml"))
}

/// Runs a scenario behind the six-step motor.
///
/// # Errors
/// A model that the equations cannot take, or other than two or three stages.
pub fn run(model: &Model, amplifier: &Amplifier, scene: &Scene) -> Result<Trace, BuildError> {
    match model.stages.len() {
        2 => Ok(chain::<2>(model, amplifier, scene)?),
        3 => Ok(chain::<3>(model, amplifier, scene)?),
        more => Err(BuildError::TooManyStages(more)),
    }
}

/// The joint of a model behind its amplifier.
///
/// # Errors
/// The first parameter that the equations cannot take.
pub fn six_step<const N: usize>(
    model: &Model,
    amplifier: &Amplifier,
) -> Result<SixStep<f64, N, EffectSet<f64>>, ParameterError> {
    let stages = std::array::from_fn(|k| model.stages[k]);
    SixStep::with(&model.motor, &stages, &model.load, amplifier, |bases| {
        EffectSet::new(&model.effects, &model.load, bases)
    })
}

/// A PI speed loop with the acceleration fed forward.
struct SpeedLoop {
    proportional: f64,
    integral: f64,
    forward: f64,
    summed: f64,
    limit: f64,
}

impl SpeedLoop {
    fn new(model: &Model, amplifier: &Amplifier) -> Self {
        let inertia: f64 = crate::plant::inertias(model).iter().sum();
        let forward = inertia / model.motor.torque_constant_nm_per_a;
        let proportional = SPEED_BANDWIDTH * forward;
        let integral = 0.25 * SPEED_BANDWIDTH * proportional * amplifier.pwm_period_s;
        Self { proportional, integral, forward, summed: 0.0, limit: amplifier.current_limit_a }
    }

    fn current(&mut self, (speed, acceleration): (f64, f64), measured: f64) -> f64 {
        let error = speed - measured;
        self.summed = (self.summed + self.integral * error).clamp(-self.limit, self.limit);
        self.proportional * error + self.forward * acceleration + self.summed
    }
}

fn chain<const N: usize>(
    model: &Model,
    amplifier: &Amplifier,
    scene: &Scene,
) -> Result<Trace, ParameterError> {
    let joint = six_step::<N>(model, amplifier)?;
    let mut state = joint.rest();
    let mut control = SpeedLoop::new(model, amplifier);
    let mut trace = Trace::new(N + 1);
    let periods = (scene.duration_s / amplifier.pwm_period_s).round() as usize;
    let keep = (SAMPLE_S / amplifier.pwm_period_s).round().max(1.0) as usize;
    let [mut bus, mut heat, mut shaft] = [0.0; 3];
    for k in 0..=periods {
        let t = k as f64 * amplifier.pwm_period_s;
        let load = scene.load.at(t);
        let speed = joint.joint().speed(&state.joint, 0);
        if k % keep == 0 {
            trace.time_s.push(t);
            trace.reference.push(scene.speed.at(t).0);
            trace.load_nm.push(load);
            let mut angle = state.joint.angle.to_turns() * std::f64::consts::TAU;
            let levels = trace.speed.iter_mut().zip(&mut trace.angle);
            for (level, (speeds, angles)) in levels.enumerate() {
                if let Some(stage) = level.checked_sub(1) {
                    angle -= joint.joint().deflection(&state.joint, stage);
                }
                speeds.push(joint.joint().speed(&state.joint, level));
                angles.push(angle);
            }
            trace.current_a.push(joint.measured_current(&state));
            trace.bus_work_j.push(bus);
            trace.winding_heat_j.push(heat);
            trace.shaft_work_j.push(shaft);
        }
        let current = control.current(scene.speed.at(t), speed);
        joint.step(&mut state, Command::Current(current), load);
        let [supplied, lost] = joint.work_and_heat(&state);
        let mean = 0.5 * (speed + joint.joint().speed(&state.joint, 0));
        let torque = model.motor.torque_constant_nm_per_a * joint.torque_current(&state);
        bus += supplied;
        heat += lost;
        shaft += torque * mean * amplifier.pwm_period_s;
    }
    Ok(trace)
}
