//! The gear behind a prescribed motion of the motor, as figures 6 to 10 have it.
//!
//! The reference's equations with the rotor's replaced by the motion: what the gear asks of the motor
//! does not come back to it. Bogacki–Shampine at the paper's step.

use super::scene::Scene;
use super::trace::{SAMPLE_S, Trace};
use crate::model::Model;
use crate::plant::Layout;
use crate::reference::{Equations, Held, PAPER_STEP_S, ReferenceError};
use joint_core::joint::Drive;

/// The equations of a joint whose rotor is moved from outside.
struct Moved<'a> {
    equations: Equations,
    layout: Layout,
    scene: &'a Scene,
}

impl Moved<'_> {
    fn rates(&self, t: f64, state: &mut [f64], rate: &mut [f64]) {
        let (speed, acceleration) = self.scene.speed.at(t);
        state[self.layout.speed(0)] = speed;
        let held = Held { load: self.scene.load.at(t), ..Held::default() };
        self.equations.derivative(&held, state, rate);
        rate[self.layout.speed(0)] = acceleration;
    }
}

/// Runs a scenario with the motor prescribed.
///
/// # Errors
/// A model that the equations cannot take.
pub fn run(model: &Model, scene: &Scene) -> Result<Trace, ReferenceError> {
    watched(model, scene, |_, _| ())
}

/// The same, with every step's time and state shown, the reference's state vector.
///
/// # Errors
/// As [`run`].
pub fn watched(
    model: &Model,
    scene: &Scene,
    mut each: impl FnMut(f64, &[f64]),
) -> Result<Trace, ReferenceError> {
    let equations = Equations::new(model, Drive::Current, 2.0)?;
    let layout = equations.layout();
    let mut state = equations.rest();
    let moved = Moved { equations, layout, scene };
    let mut rates = [state.clone(), state.clone(), state.clone()];
    let mut stage = state.clone();
    let mut trace = Trace::new(model.stages.len() + 1);
    let samples = (scene.duration_s / SAMPLE_S).round() as usize;
    let steps = (SAMPLE_S / PAPER_STEP_S).round() as usize;
    let h = SAMPLE_S / steps as f64;
    for sample in 0..=samples {
        let start = sample as f64 * SAMPLE_S;
        state[layout.speed(0)] = scene.speed.at(start).0;
        record(&mut trace, scene, start, &state, layout);
        for step in 0..steps {
            let t = start + step as f64 * h;
            state[layout.speed(0)] = scene.speed.at(t).0;
            each(t, &state);
            let [first, second, third] = &mut rates;
            moved.rates(t, &mut state, first);
            for ((new, old), rate) in stage.iter_mut().zip(&state).zip(&*first) {
                *new = old + 0.5 * h * rate;
            }
            moved.rates(t + 0.5 * h, &mut stage, second);
            for ((new, old), rate) in stage.iter_mut().zip(&state).zip(&*second) {
                *new = old + 0.75 * h * rate;
            }
            moved.rates(t + 0.75 * h, &mut stage, third);
            let slopes = first.iter().zip(&*second).zip(&*third);
            for (value, ((one, two), three)) in state.iter_mut().zip(slopes) {
                *value += h / 9.0 * (2.0 * one + 3.0 * two + 4.0 * three);
            }
        }
        if state.iter().any(|value| !value.is_finite()) {
            return Err(ReferenceError::Diverged(start));
        }
    }
    Ok(trace)
}

fn record(trace: &mut Trace, scene: &Scene, t: f64, state: &[f64], layout: Layout) {
    trace.time_s.push(t);
    trace.reference.push(scene.speed.at(t).0);
    trace.load_nm.push(scene.load.at(t));
    let mut angle = state[Layout::ANGLE];
    let levels = trace.speed.iter_mut().zip(&mut trace.angle);
    for (level, (speeds, angles)) in levels.enumerate() {
        if let Some(stage) = level.checked_sub(1) {
            angle -= state[layout.deflection(stage)];
        }
        speeds.push(state[layout.speed(level)]);
        angles.push(angle);
    }
}
