//! An instance of the FMU: what the functions of the standard work on.

use serde::{Deserialize, Serialize};

use crate::joint::{DRIVE, INPUTS, Joint, JointError, LOAD};
use crate::running::{self, Running, Start};

/// Steps of one communication step: more would look as if the library hung.
const MOST_STEPS: u64 = 1_000_000_000;

/// An instance: its values by value reference, and the joint once it is initialised.
pub struct Component {
    joint: Joint,
    parameters: Vec<f64>,
    inputs: [f64; INPUTS],
    outputs: Vec<f64>,
    running: Option<Box<dyn Running>>,
    start_s: f64,
    /// Where the last communication step ended, s.
    now_s: f64,
    /// Steps since the start.
    steps: u64,
}

/// What is kept of an instance as bytes. Which joint it is stands in its description.
#[derive(Serialize, Deserialize)]
struct Kept {
    parameters: Vec<f64>,
    inputs: [f64; INPUTS],
    start_s: f64,
    now_s: f64,
    steps: u64,
    state: Option<Vec<u8>>,
}

/// What a communication step may begin beside the end of the one before, s: a millionth of a step forgives
/// what the importing tool's clock rounds; so does the rounding of a large time.
fn rounding_s(period_s: f64, from_s: f64) -> f64 {
    1e-6 * period_s + 1e-12 * from_s.abs()
}

/// How many whole steps a duration holds that ends at a time so large.
fn due(duration_s: f64, period_s: f64, from_s: f64) -> u64 {
    // More than half a step would count steps that nobody asked for.
    let rounding = rounding_s(period_s, from_s).min(0.5 * period_s);
    ((duration_s + rounding) / period_s).floor() as u64
}

fn finite_outputs(running: &dyn Running, whose: &str) -> Result<Vec<f64>, JointError> {
    let mut outputs = Vec::new();
    running.outputs(&mut outputs);
    match outputs.iter().all(|output| output.is_finite()) {
        true => Ok(outputs),
        false => Err(JointError(format!("an output {whose} is no finite number"))),
    }
}

impl Clone for Component {
    fn clone(&self) -> Self {
        Self {
            joint: self.joint.clone(),
            parameters: self.parameters.clone(),
            outputs: self.outputs.clone(),
            running: self.running.as_ref().map(|running| running.copy()),
            ..*self
        }
    }
}

impl Component {
    pub(crate) fn new(joint: Joint) -> Self {
        let parameters = joint.parameters().into_iter().map(|own| own.value).collect();
        let outputs = vec![0.0; joint.outputs().len()];
        let (inputs, running) = ([0.0; INPUTS], None);
        let (start_s, now_s, steps) = (0.0, 0.0, 0);
        Self { joint, parameters, inputs, outputs, running, start_s, now_s, steps }
    }

    /// As it was instantiated.
    pub(crate) fn reset(&mut self) {
        *self = Self::new(self.joint.clone());
    }

    pub(crate) fn start_at(&mut self, start_s: f64) -> Result<(), JointError> {
        if !start_s.is_finite() {
            return Err(JointError("the start time is no finite number".to_owned()));
        }
        if self.runs() {
            return Err(JointError("the start time is fixed once initialised".to_owned()));
        }
        self.start_s = start_s;
        Ok(())
    }

    /// Builds the joint of the parameters as they are now.
    pub(crate) fn initialise(&mut self) -> Result<(), JointError> {
        if self.start_s.abs() * f64::EPSILON > 0.1 * self.joint.period_s {
            let (start_s, period_s) = (self.start_s, self.joint.period_s);
            return Err(JointError(format!(
                "a start at {start_s} s is too late to tell steps of {period_s} s apart"
            )));
        }
        let running = self.started()?;
        self.outputs = finite_outputs(running.as_ref(), "of these initial values")?;
        self.running = Some(running);
        (self.now_s, self.steps) = (self.start_s, 0);
        Ok(())
    }

    fn started(&self) -> Result<Box<dyn Running>, JointError> {
        let [motor_angle_rad, motor_speed_rad_per_s] = self.joint.start(&self.parameters);
        if !(motor_angle_rad.is_finite() && motor_speed_rad_per_s.is_finite()) {
            return Err(JointError("the initial angle or speed is no finite number".to_owned()));
        }
        let start = Start { motor_angle_rad, motor_speed_rad_per_s };
        running::started(&self.joint.with(&self.parameters)?, start)
    }

    /// Whether it was initialised.
    pub(crate) fn runs(&self) -> bool {
        self.running.is_some()
    }

    /// Where the last communication step ended, s, or the first will begin.
    pub(crate) fn time_s(&self) -> f64 {
        if self.runs() { self.now_s } else { self.start_s }
    }

    /// Value reference of the time in FMI 3.0, behind those of all variables.
    pub(crate) fn time_reference(&self) -> usize {
        INPUTS + self.outputs.len() + self.parameters.len()
    }

    /// Whether a communication step ends later than that, s, by more than rounding.
    pub(crate) fn exceeds(&self, until_s: f64, stop_s: f64) -> bool {
        until_s > stop_s + rounding_s(self.joint.period_s, stop_s)
    }

    pub(crate) fn get(&self, reference: usize) -> Option<f64> {
        let output = reference.checked_sub(INPUTS);
        let parameter = output.and_then(|own| own.checked_sub(self.outputs.len()));
        match (output, parameter) {
            (None, _) => self.inputs.get(reference).copied(),
            (Some(own), None) => self.outputs.get(own).copied(),
            (_, Some(own)) => self.parameters.get(own).copied(),
        }
    }

    pub(crate) fn set(&mut self, reference: usize, value: f64) -> Result<(), JointError> {
        if let Some(input) = self.inputs.get_mut(reference) {
            *input = value;
            return Ok(());
        }
        let parameter = reference
            .checked_sub(INPUTS + self.outputs.len())
            .and_then(|own| self.parameters.get_mut(own))
            .ok_or_else(|| JointError(format!("{reference} is neither input nor parameter")))?;
        if self.running.is_some() {
            return Err(JointError("parameters are fixed once initialised".to_owned()));
        }
        *parameter = value;
        Ok(())
    }

    /// A communication step: steps until its end, on the joint's own grid: what is left of a step waits for
    /// the next call.
    pub(crate) fn advance(&mut self, from_s: f64, step_s: f64) -> Result<(), JointError> {
        let running =
            self.running.as_mut().ok_or_else(|| JointError("not initialised".to_owned()))?;
        let [drive, load] = [self.inputs[DRIVE], self.inputs[LOAD]];
        let until_s = from_s + step_s;
        if !(drive.is_finite() && load.is_finite() && until_s.is_finite()) {
            return Err(JointError("an input or the time is no finite number".to_owned()));
        }
        if (from_s - self.now_s).abs() > rounding_s(self.joint.period_s, from_s) {
            return Err(JointError(format!(
                "time jumps: the last communication step ended at {} s, this one begins at {from_s} s",
                self.now_s
            )));
        }
        if step_s < 0.0 {
            return Err(JointError(format!("a communication step of {step_s} s goes back")));
        }
        let due = due(until_s - self.start_s, self.joint.period_s, from_s);
        if due.saturating_sub(self.steps) > MOST_STEPS {
            let period_s = self.joint.period_s;
            return Err(JointError(format!(
                "a communication step of {step_s} s is more than {MOST_STEPS} steps of {period_s} s"
            )));
        }
        while self.steps < due {
            self.steps += 1;
            if !running.step(drive, load) {
                let at = self.start_s + self.steps as f64 * self.joint.period_s;
                return Err(JointError(format!("the state leaves every number at {at} s")));
            }
        }
        self.outputs = finite_outputs(running.as_ref(), "of this state")?;
        self.now_s = until_s;
        Ok(())
    }

    /// The instance's state as bytes.
    pub(crate) fn bytes(&self) -> Result<Vec<u8>, JointError> {
        let state = self.running.as_ref().map(|running| running.state()).transpose()?;
        let kept = Kept {
            parameters: self.parameters.clone(),
            inputs: self.inputs,
            start_s: self.start_s,
            now_s: self.now_s,
            steps: self.steps,
            state,
        };
        postcard::to_stdvec(&kept).map_err(|error| JointError(error.to_string()))
    }

    /// An instance of the same joint in a state from its bytes.
    pub(crate) fn restored(&self, bytes: &[u8]) -> Result<Self, JointError> {
        let unreadable = |error| JointError(format!("these bytes are no state of it: {error}"));
        let kept: Kept = postcard::from_bytes(bytes).map_err(unreadable)?;
        if kept.parameters.len() != self.parameters.len() {
            return Err(JointError("these bytes are the state of another joint".to_owned()));
        }
        let due = due(kept.now_s - kept.start_s, self.joint.period_s, kept.now_s);
        // A start that is set before the instance runs has no steps behind it yet.
        let made = kept.state.is_none() || kept.steps.abs_diff(due) <= 1;
        if !(kept.start_s.is_finite() && kept.now_s.is_finite() && made) {
            return Err(JointError("these bytes hold a time that no such state has".to_owned()));
        }
        let mut own = Self {
            parameters: kept.parameters,
            inputs: kept.inputs,
            start_s: kept.start_s,
            ..Self::new(self.joint.clone())
        };
        if let Some(state) = kept.state {
            let mut running = own.started()?;
            running.set_state(&state)?;
            own.outputs = finite_outputs(running.as_ref(), "of the state in these bytes")?;
            own.running = Some(running);
        }
        (own.now_s, own.steps) = (kept.now_s, kept.steps);
        Ok(own)
    }
}
