//! An effect as the file of a joint names it.

use joint_core::effect::{EffectParameters, Kind};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

/// An effect by its names in the model file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EffectDescription {
    /// Its kind.
    pub kind: String,
    /// Its place.
    pub location: String,
    /// Its parameters by key.
    pub parameters: Map<String, Value>,
}

impl EffectDescription {
    /// Of an effect.
    pub fn of(effect: &EffectParameters) -> Self {
        let spec = effect.kind.spec();
        let values = spec.parameters.iter().zip(effect.values);
        let mut parameters: Map<String, Value> =
            values.map(|(own, value)| (own.key.to_owned(), value.into())).collect();
        if let Some(own) = &spec.table {
            let knots = [effect.table.forward(), effect.table.backward()];
            for (key, knots) in [own.forward, own.backward].into_iter().zip(knots) {
                if !knots.is_empty() {
                    parameters.insert(key.to_owned(), knots.into());
                }
            }
        }
        Self { kind: spec.kind.to_owned(), location: effect.location.to_string(), parameters }
    }

    pub(crate) fn effect(&self) -> Result<EffectParameters, JointError> {
        let unknown = |what: &str| JointError(format!("unknown {what} of an effect"));
        let kind = Kind::from_name(&self.kind).ok_or_else(|| unknown(&self.kind))?;
        let location = self.location.parse().map_err(|()| unknown(&self.location))?;
        let mut effect = EffectParameters::new(kind, location);
        if let Some(own) = &kind.spec().table {
            let knots = |key: &str| -> Result<Vec<f64>, JointError> {
                let Some(value) = self.parameters.get(key) else { return Ok(Vec::new()) };
                let numbers =
                    value.as_array().and_then(|all| all.iter().map(Value::as_f64).collect());
                numbers.ok_or_else(|| unknown(key))
            };
            effect = effect
                .with_table(&knots(own.forward)?, &knots(own.backward)?)
                .ok_or_else(|| unknown(own.forward))?;
        }
        let of_table = |key: &&String| {
            let table = kind.spec().table;
            table.is_some_and(|table| [table.forward, table.backward].contains(&key.as_str()))
        };
        for (key, value) in self.parameters.iter().filter(|(key, _)| !of_table(key)) {
            effect.get(key).ok_or_else(|| unknown(key))?;
            effect = effect.with(key, value.as_f64().ok_or_else(|| unknown(key))?);
        }
        Ok(effect)
    }
}

/// Why a joint cannot be read or run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JointError(pub(crate) String);

impl std::fmt::Display for JointError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for JointError {}
