//! An instance of the FMU: what the functions of the standard work on.

use crate::joint::{DRIVE, INPUTS, Joint, JointError, LOAD};
use crate::running::{self, Running};

/// An instance: its values by value reference, and the joint once it is initialised.
pub(crate) struct Component {
    joint: Joint,
    parameters: Vec<f64>,
    inputs: [f64; INPUTS],
    outputs: Vec<f64>,
    running: Option<Box<dyn Running>>,
    start_s: f64,
    /// Steps since the start.
    steps: u64,
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
        let parameters = joint.parameters().into_iter().map(|(_, _, value)| value).collect();
        let outputs = vec![0.0; joint.outputs().len()];
        let (inputs, running) = ([0.0; INPUTS], None);
        Self { joint, parameters, inputs, outputs, running, start_s: 0.0, steps: 0 }
    }

    /// As it was instantiated.
    pub(crate) fn reset(&mut self) {
        *self = Self::new(self.joint.clone());
    }

    pub(crate) fn start_at(&mut self, start_s: f64) {
        self.start_s = start_s;
    }

    /// Builds the joint of the parameters as they are now.
    pub(crate) fn initialise(&mut self) -> Result<(), JointError> {
        let running = running::at_rest(&self.joint.with(&self.parameters)?)?;
        running.outputs(&mut self.outputs);
        self.running = Some(running);
        self.steps = 0;
        Ok(())
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

    /// Steps until this time, on the joint's own grid: what is left of a step waits for the next
    /// call.
    pub(crate) fn advance(&mut self, until_s: f64) -> Result<(), JointError> {
        let running =
            self.running.as_mut().ok_or_else(|| JointError("not initialised".to_owned()))?;
        let [drive, load] = [self.inputs[DRIVE], self.inputs[LOAD]];
        if !(drive.is_finite() && load.is_finite() && until_s.is_finite()) {
            return Err(JointError("an input or the time is no finite number".to_owned()));
        }
        // A millionth of a step forgives what the importing tool's clock rounds.
        let due = ((until_s - self.start_s) / self.joint.period_s + 1e-6).floor() as u64;
        while self.steps < due {
            self.steps += 1;
            if !running.step(drive, load) {
                let at = self.start_s + self.steps as f64 * self.joint.period_s;
                return Err(JointError(format!("the state leaves every number at {at} s")));
            }
        }
        running.outputs(&mut self.outputs);
        Ok(())
    }
}
