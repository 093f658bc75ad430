//! What joint it is: the file in the FMU's resources, and the variables that follow from it.

use joint_core::effect::EffectParameters;
use joint_core::joint::Drive;
use joint_core::params::{Load, Motor, Stage};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::descriptions::{self, Limits};
pub use crate::effect::{EffectDescription, JointError};

/// What the importing tool puts in first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Input {
    /// The DC-equivalent voltage on the motor.
    Voltage,
    /// The motor's current.
    Current,
}

impl From<Input> for Drive {
    fn from(input: Input) -> Self {
        match input {
            Input::Voltage => Drive::Voltage,
            Input::Current => Drive::Current,
        }
    }
}

/// A joint as `resources/joint.json` has it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Joint {
    /// Its name.
    pub name: String,
    /// What drives it.
    pub input: Input,
    /// Length of its step, s.
    pub period_s: f64,
    /// The motor, SI.
    pub motor: Motor,
    /// The stages, SI, from the motor on.
    pub stage: Vec<Stage>,
    /// The load, SI.
    pub load: Load,
    /// What is beside the plain equations.
    pub effect: Vec<EffectDescription>,
}

/// A variable of the FMU; its value reference is its place in [`Joint::variables`].
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// Its name, with its unit at the end.
    pub name: String,
    /// What it is to the importing tool.
    pub causality: Causality,
    /// Its value at the start; outputs have none.
    pub start: Option<f64>,
    /// What it is, in a sentence.
    pub description: String,
    /// Smallest and largest value, where there is one.
    pub limits: Limits,
}

/// A number of the joint that may be set before it starts.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Parameter {
    pub(crate) name: String,
    /// Its place in the file; none for where the joint starts.
    place: Option<String>,
    pub(crate) value: f64,
}

/// Where the joint starts: the last parameters.
const START: [&str; 2] = ["initial.motor_angle_rad", "initial.motor_speed_rad_per_s"];

/// What a variable is to the importing tool.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Causality {
    /// Held over a communication step.
    Input,
    /// At the end of the last step.
    Output,
    /// May be set until the initialisation ends.
    Parameter,
}

/// Value references of the two inputs.
pub(crate) const DRIVE: usize = 0;
pub(crate) const LOAD: usize = 1;
pub(crate) const INPUTS: usize = 2;

impl Joint {
    /// Reads the file.
    ///
    /// # Errors
    /// It is no joint.
    pub fn read(text: &str) -> Result<Self, JointError> {
        serde_json::from_str(text).map_err(|error| JointError(format!("joint.json: {error}")))
    }

    /// The file's text.
    pub fn text(&self) -> String {
        serde_json::to_string_pretty(self).unwrap_or_default()
    }

    /// The effects.
    ///
    /// # Errors
    /// A name that this version does not know.
    pub fn effects(&self) -> Result<Vec<EffectParameters>, JointError> {
        self.effect.iter().map(EffectDescription::effect).collect()
    }

    /// Names of the outputs, in the order of their value references.
    pub fn outputs(&self) -> Vec<String> {
        let mut names: Vec<String> = [
            "current_a",
            "measured_current_a",
            "motor_angle_rad",
            "motor_speed_rad_per_s",
            "motor_bristle",
            "output_angle_rad",
            "output_speed_rad_per_s",
            "motor_torque_nm",
            "motor_friction_nm",
        ]
        .map(str::to_owned)
        .into();
        for number in 1..=self.stage.len() {
            let quantities = [
                "angle_rad",
                "speed_rad_per_s",
                "windup_rad",
                "bristle",
                "torque_nm",
                "friction_nm",
            ];
            names.extend(quantities.map(|quantity| format!("stage{number}_{quantity}")));
        }
        names
    }

    /// All variables: inputs, outputs, parameters.
    pub fn variables(&self) -> Vec<Variable> {
        let drive = match self.input {
            Input::Voltage => "voltage_v",
            Input::Current => "command_current_a",
        };
        let variable = |name: String, causality, start| {
            let (description, limits) = descriptions::of(&self.effect, &name);
            Variable { name, causality, start, description, limits }
        };
        let inputs = [drive, "load_torque_nm"].map(str::to_owned).into_iter();
        let inputs = inputs.map(|name| variable(name, Causality::Input, Some(0.0)));
        let outputs = self.outputs().into_iter();
        let outputs = outputs.map(|name| variable(name, Causality::Output, None));
        let parameters = self.parameters().into_iter();
        let parameters =
            parameters.map(|own| variable(own.name, Causality::Parameter, Some(own.value)));
        inputs.chain(outputs).chain(parameters).collect()
    }

    /// The numbers of motor, stages, load and effects, and where the joint starts.
    pub(crate) fn parameters(&self) -> Vec<Parameter> {
        let mut found = Vec::new();
        let Ok(file) = serde_json::to_value(self) else { return found };
        for table in ["motor", "stage", "load", "effect"] {
            if let Some(value) = file.get(table) {
                numbers(value, table, &format!("/{table}"), &mut found);
            }
        }
        let start = START.map(|name| Parameter { name: name.to_owned(), place: None, value: 0.0 });
        found.extend(start);
        found
    }

    /// Initial angle and speed of the rotor, of values in the order of [`Joint::parameters`].
    pub(crate) fn start(&self, values: &[f64]) -> [f64; 2] {
        values.last_chunk().copied().unwrap_or_default()
    }

    /// The same joint with other numbers, in the order of [`Joint::parameters`].
    pub(crate) fn with(&self, values: &[f64]) -> Result<Self, JointError> {
        let wrong = |what: &dyn std::fmt::Display| JointError(what.to_string());
        let mut file = serde_json::to_value(self).map_err(|error| wrong(&error))?;
        for (own, value) in self.parameters().iter().zip(values) {
            let Some(place) = own.place.as_ref().filter(|_| own.value != *value) else { continue };
            if !value.is_finite() {
                return Err(JointError(format!("{} is no finite number", own.name)));
            }
            if let Some(slot) = file.pointer_mut(place) {
                let whole = slot.is_u64() && value.fract() == 0.0 && *value >= 0.0;
                *slot = if whole { (*value as u64).into() } else { (*value).into() };
            }
        }
        serde_json::from_value(file).map_err(|error| wrong(&error))
    }
}

/// What an FMU of this file is recognised by: FNV-1a of its text, of 64 bits.
pub fn guid(text: &str) -> String {
    let hash = text.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    });
    format!("{{joint-{}-{hash:016x}}}", env!("CARGO_PKG_VERSION"))
}

/// Every number below a value; elements of lists count from 1 in names.
fn numbers(value: &Value, name: &str, place: &str, found: &mut Vec<Parameter>) {
    match value {
        Value::Number(number) => {
            let value = number.as_f64().unwrap_or(f64::NAN);
            found.push(Parameter { name: name.to_owned(), place: Some(place.to_owned()), value });
        }
        Value::Array(list) => {
            for (k, value) in list.iter().enumerate() {
                numbers(value, &format!("{name}{}", k + 1), &format!("{place}/{k}"), found);
            }
        }
        Value::Object(map) => {
            for (key, value) in map {
                let own =
                    if key == "parameters" { name.to_owned() } else { format!("{name}.{key}") };
                numbers(value, &own, &format!("{place}/{key}"), found);
            }
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use joint_core::effect::Kind;

    use super::*;

    #[test]
    fn every_effect_comes_back_from_its_description_its_table_too() {
        for kind in Kind::ALL {
            let effect = EffectParameters::example(*kind);
            let text = serde_json::to_string(&EffectDescription::of(&effect)).unwrap();
            let read: EffectDescription = serde_json::from_str(&text).unwrap();
            assert_eq!(read.effect(), Ok(effect), "{text}");
        }
    }
}
