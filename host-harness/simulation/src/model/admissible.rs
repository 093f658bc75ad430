//! Values that the equations cannot take, brought back to where they stand in the file.

use joint_core::params::{ParameterError, Reason, Table as Place};

use super::Model;
use super::effect::places;
use super::source::Source;
use super::span::Tables;
use crate::fault::InputError;

impl Source<'_> {
    /// The validation's error as one about the file: at the value, or, where the key was left out,
    /// at the table that lacks it.
    pub(super) fn inadmissible(
        &self,
        tables: &Tables<'_>,
        model: &Model,
        error: ParameterError,
    ) -> InputError {
        let ParameterError { table, key, reason, .. } = error;
        let effect = match table {
            Place::Effect(number) => number.checked_sub(1).and_then(|k| model.effects.get(k)),
            _ => None,
        };
        if let (Some(effect), Reason::NoSuchPlace) = (effect, reason) {
            let (spec, stages) = (effect.kind.spec(), model.stages.len());
            let what = format!("{} cannot sit at `{}` in this joint", spec.kind, effect.location);
            let joint = match stages {
                0 => "no stage".to_owned(),
                1 => "one stage".to_owned(),
                more => format!("{more} stages"),
            };
            let help = format!("it can sit at: {}; this joint has {joint}", places(spec));
            return self.fault(what, tables.value(table, key)).help(help);
        }
        match tables.value(table, key) {
            Some(span) => self.fault(error.to_string(), Some(span)),
            None => {
                let header = tables.find(table).and_then(|(_, span)| span);
                self.fault(format!("key `{key}` is missing in {table}: it {reason}"), header)
                    .help(format!("add {key}"))
            }
        }
    }
}
