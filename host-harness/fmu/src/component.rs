//! An instance of the FMU: what the functions of the standard work on.

use serde::{Deserialize, Serialize};

use crate::joint::{DRIVE, INPUTS, Joint, JointError, LOAD};
use crate::running::{self, Running, Start};

/// An instance: its values by value reference, and the joint once it is initialised.
pub(crate) struct Component {
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
        self.start_s = start_s;
        Ok(())
    }

    /// Builds the joint of the parameters as they are now.
    pub(crate) fn initialise(&mut self) -> Result<(), JointError> {
        let running = self.started()?;
        running.outputs(&mut self.outputs);
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
        // A millionth of a step forgives what the importing tool's clock rounds; so does the rounding of a
        // large time.
        let rounding = 1e-6 * self.joint.period_s + 1e-12 * from_s.abs();
        if (from_s - self.now_s).abs() > rounding {
            return Err(JointError(format!(
                "time jumps: the last communication step ended at {} s, this one begins at {from_s} s",
                self.now_s
            )));
        }
        if step_s < 0.0 {
            return Err(JointError(format!("a communication step of {step_s} s goes back")));
        }
        let due = ((until_s - self.start_s + rounding) / self.joint.period_s).floor() as u64;
        while self.steps < due {
            self.steps += 1;
            if !running.step(drive, load) {
                let at = self.start_s + self.steps as f64 * self.joint.period_s;
                return Err(JointError(format!("the state leaves every number at {at} s")));
            }
        }
        running.outputs(&mut self.outputs);
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
        let mut own = Self {
            parameters: kept.parameters,
            inputs: kept.inputs,
            start_s: kept.start_s,
            ..Self::new(self.joint.clone())
        };
        if let Some(state) = kept.state {
            let mut running = own.started()?;
            running.set_state(&state)?;
            running.outputs(&mut own.outputs);
            own.running = Some(running);
        }
        (own.now_s, own.steps) = (kept.now_s, kept.steps);
        Ok(own)
    }
}
