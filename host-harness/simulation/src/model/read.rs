//! A model from TOML.
//!
//! The types of `joint-core` say what keys there are and its validation says what values; here both
//! are brought back to the line of the file they are about.

use std::path::Path;

use joint_core::params::{self, Motor, ParameterError, Stage, Table as Place};
use serde::de::DeserializeOwned;
use toml_edit::{Document, Table, TableLike};

use super::source::Source;
use super::span::{Tables, elements, key};
use super::{Model, Sensor};
use crate::fault::InputError;

const KEYS: [&str; 6] = ["name", "motor", "stage", "load", "sensor", "effect"];

impl Model {
    /// Reads a model file.
    ///
    /// # Errors
    /// What is wrong with the file, with line, column and key.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        let bytes = std::fs::read(path).map_err(|error| InputError::unreadable(path, &error))?;
        let text = String::from_utf8(bytes).map_err(|_| {
            InputError::new(path, "is not UTF-8 text").help("a model is a TOML text file")
        })?;
        Self::parse(&text, path)
    }

    /// Reads a model from the text of its file; `path` is what errors call it, and its stem is the
    /// model's name where the text has none.
    ///
    /// # Errors
    /// What is wrong with the text, with line, column and key.
    pub fn parse(text: &str, path: &Path) -> Result<Self, InputError> {
        let source = Source { text, path };
        let document = Document::parse(text).map_err(|error| {
            source.fault(format!("not valid TOML: {}", error.message()), error.span())
        })?;
        let root = document.as_table();
        if let Some((name, _)) = root.iter().find(|(name, _)| !KEYS.contains(name)) {
            return Err(source
                .fault(format!("unknown key `{name}`"), key(root, name))
                .help(format!("a model has: {}", KEYS.join(", "))));
        }
        source.check_sizes(root)?;
        let model = source.model(root)?;
        model.check().map_err(|error| source.inadmissible(&Tables(root), &model, error))?;
        source.check_sensor(root, &model.sensor)?;
        Ok(model)
    }

    /// Checks what the equations ask of the values.
    ///
    /// # Errors
    /// The first value that they cannot take.
    pub fn check(&self) -> Result<(), ParameterError> {
        params::validate(&self.motor, &self.stages, &self.load)?;
        joint_core::effect::validate(&self.effects, self.stages.len())
    }
}

impl Source<'_> {
    fn model(&self, root: &Table) -> Result<Model, InputError> {
        let motor = root.get("motor").ok_or_else(|| {
            self.fault("table [motor] is missing", None)
                .help("a model has at least [motor] with its torque constant and inertia")
        })?;
        let numbered = |name: &str| match root.get(name) {
            Some(item) => elements(item).ok_or_else(|| {
                self.fault(format!("`{name}` must be an array of tables"), key(root, name))
                    .help(format!("write [[{name}]], once for each"))
            }),
            None => Ok(Vec::new()),
        };
        let mut stages = Vec::new();
        for (k, (item, span)) in numbered("stage")?.into_iter().enumerate() {
            let places = [Place::Stage(k + 1), Place::StageFriction(k + 1)];
            stages.push(self.with_friction::<Stage>(&item, places, span)?);
        }
        let mut effects = Vec::new();
        for (k, (item, span)) in numbered("effect")?.into_iter().enumerate() {
            effects.push(self.effect(&item, k + 1, span)?);
        }
        Ok(Model {
            name: self.name(root)?,
            motor: self.with_friction::<Motor>(
                motor,
                [Place::Motor, Place::MotorFriction],
                key(root, "motor"),
            )?,
            stages,
            load: self.optional(root, "load")?,
            sensor: self.optional(root, "sensor")?,
            effects,
            friction_levels: Vec::new(),
        })
    }

    fn name(&self, root: &Table) -> Result<String, InputError> {
        match root.get("name") {
            Some(item) => item.as_str().map(str::to_owned).ok_or_else(|| {
                self.fault("wrong type: `name` must be a text in quotes", item.span())
            }),
            None => {
                let stem = self.path.file_stem().unwrap_or_default();
                Ok(stem.to_string_lossy().into_owned())
            }
        }
    }

    fn optional<T: DeserializeOwned + Default>(
        &self,
        root: &Table,
        name: &str,
    ) -> Result<T, InputError> {
        root.get(name).map_or_else(
            || Ok(T::default()),
            |item| self.table(item, &format!("[{name}]"), key(root, name)),
        )
    }

    /// Refuses numbers that single precision, in which the joint runs on its drive, does not hold.
    fn check_sizes(&self, table: &dyn TableLike) -> Result<(), InputError> {
        for (name, item) in table.iter() {
            if let Some(table) = item.as_table_like() {
                self.check_sizes(table)?;
            }
            for (item, _) in elements(item).into_iter().flatten() {
                if let Some(table) = item.as_table_like() {
                    self.check_sizes(table)?;
                }
            }
            let Some(value) = item.as_float().filter(|v| v.is_finite() && *v != 0.0) else {
                continue;
            };
            let [low, high] = [f64::from(f32::MIN_POSITIVE), f64::from(f32::MAX)];
            if !(low..=high).contains(&value.abs()) {
                let what = format!("{name} = {value:e}: no joint has such a value");
                let help = "it is beyond what single precision holds; check its exponent";
                return Err(self.fault(what, item.span()).help(help));
            }
        }
        Ok(())
    }

    fn check_sensor(&self, root: &Table, sensor: &Sensor) -> Result<(), InputError> {
        let wrong = sensor.entries().into_iter().find(|(_, v)| !v.is_finite() || *v < 0.0);
        let Some((name, value)) = wrong else { return Ok(()) };
        let table = root.get("sensor").and_then(|item| item.as_table_like());
        let span = table.and_then(|table| table.get(name)).and_then(|item| item.span());
        Err(self.fault(format!("[sensor] {name} = {value}: must be a number, zero or more"), span))
    }
}
