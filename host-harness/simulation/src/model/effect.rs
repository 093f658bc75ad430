//! The `[[effect]]` tables of a model: kind, location, and the parameters of that kind.

use std::ops::Range;

use joint_core::effect::{EffectParameters, Kind, MAX_KNOTS, Spec};
use joint_core::params::Location;
use toml_edit::{Item, TableLike};

use super::source::Source;
use super::span::key;
use crate::fault::InputError;

/// Marks an effect that says what is there, not why; written of every such kind, and not asked for.
pub(super) const UNNAMED: &str = "unnamed";

impl Source<'_> {
    /// Reads one effect; `number` is its place in the file, from 1.
    pub(super) fn effect(
        &self,
        item: &Item,
        number: usize,
        span: Option<Range<usize>>,
    ) -> Result<EffectParameters, InputError> {
        let Some(table) = item.as_table_like() else {
            return Err(self.fault(format!("[[effect]] number {number} must be a table"), span));
        };
        let kind = self.kind(table, number, span.clone())?;
        let spec = kind.spec();
        let (text, place) = self.text(table, "location", number, span.clone())?;
        let location: Location = text.parse().map_err(|()| {
            self.fault(format!("unknown location `{text}`"), place).help(format!(
                "{} can sit at: {}",
                spec.kind,
                places(spec)
            ))
        })?;
        for (name, _) in table.iter() {
            let known = spec.parameters.iter().any(|parameter| parameter.key == name)
                || spec.table.is_some_and(|table| [table.forward, table.backward].contains(&name))
                || kind.is_unnamed() && name == UNNAMED;
            if !known && name != "kind" && name != "location" {
                return Err(self
                    .fault(
                        format!("unknown key `{name}` in effect {}", spec.kind),
                        key(table, name),
                    )
                    .help(format!("its keys are: kind, location, {}", keys(spec))));
            }
        }
        let mut effect = EffectParameters::new(kind, location);
        for (slot, parameter) in effect.values.iter_mut().zip(spec.parameters) {
            *slot = match (table.get(parameter.key), parameter.default) {
                (Some(item), _) => number_of(item).ok_or_else(|| {
                    let what = format!("wrong type: `{}` must be a number", parameter.key);
                    self.fault(what, item.span())
                })?,
                (None, Some(default)) => default,
                (None, None) => {
                    let what =
                        format!("key `{}` is missing in effect {}", parameter.key, spec.kind);
                    return Err(self
                        .fault(what, span)
                        .help(format!("its keys are: kind, location, {}", keys(spec))));
                }
            };
        }
        if kind.is_unnamed()
            && let Some(item) = table.get(UNNAMED)
            && item.as_bool() != Some(true)
        {
            let what = format!("wrong value: `{UNNAMED}` of {} is true", spec.kind);
            return Err(self.fault(what, item.span()));
        }
        if let Some(keys) = spec.table {
            let [forward, backward] = [keys.forward, keys.backward];
            if table.get(forward).is_none() {
                let what = format!("key `{forward}` is missing in effect {}", spec.kind);
                return Err(self.fault(what, span).help(format!(
                    "it is a list of numbers, the knots; `{backward}` has those of the negative direction"
                )));
            }
            let [forward, backward] = [self.knots(table, forward)?, self.knots(table, backward)?];
            effect = effect.with_table(&forward, &backward).ok_or_else(|| {
                let count = forward.len();
                let what = match backward.len() {
                    0 => format!("`{}` has {count} knots", keys.forward),
                    other => {
                        format!("`{}` has {count} knots, `{}` {other}", keys.forward, keys.backward)
                    }
                };
                self.fault(what, table.get(keys.forward).and_then(Item::span)).help(format!(
                    "both directions have the same number, and a table {MAX_KNOTS} at most"
                ))
            })?;
        }
        Ok(effect)
    }

    /// The numbers of a list; none where it is left out.
    fn knots(&self, table: &dyn TableLike, name: &str) -> Result<Vec<f64>, InputError> {
        let Some(item) = table.get(name) else { return Ok(Vec::new()) };
        let number = |value: &toml_edit::Value| {
            value.as_float().or_else(|| value.as_integer().map(|value| value as f64))
        };
        let knots = item.as_array().and_then(|array| array.iter().map(number).collect());
        knots.ok_or_else(|| {
            self.fault(format!("wrong type: `{name}` must be a list of numbers"), item.span())
        })
    }

    fn kind(
        &self,
        table: &dyn TableLike,
        number: usize,
        span: Option<Range<usize>>,
    ) -> Result<Kind, InputError> {
        let (text, place) = self.text(table, "kind", number, span)?;
        Kind::from_name(text).ok_or_else(|| {
            let names: Vec<&str> = Kind::ALL.iter().map(|kind| kind.spec().kind).collect();
            self.fault(format!("unknown kind `{text}` of effect"), place)
                .help(format!("the kinds are: {}", names.join(", ")))
        })
    }

    fn text<'a>(
        &self,
        table: &'a dyn TableLike,
        name: &str,
        number: usize,
        span: Option<Range<usize>>,
    ) -> Result<(&'a str, Option<Range<usize>>), InputError> {
        let item = table.get(name).ok_or_else(|| {
            self.fault(format!("key `{name}` is missing in [[effect]] number {number}"), span)
                .help("an effect has a kind, a location and its parameters")
        })?;
        let text = item.as_str().ok_or_else(|| {
            self.fault(format!("wrong type: `{name}` must be a text in quotes"), item.span())
        })?;
        Ok((text, item.span()))
    }
}

/// The places where an effect can sit, as they are written.
pub(super) fn places(spec: &Spec) -> String {
    let name = |place: &Location| match place {
        Location::Stage(_) => "stageK (K = 1 at the motor)".to_owned(),
        place => place.to_string(),
    };
    spec.locations.iter().map(name).collect::<Vec<_>>().join(", ")
}

fn keys(spec: &Spec) -> String {
    let table = spec.table.iter().flat_map(|table| [table.forward, table.backward]);
    let parameters = spec.parameters.iter().map(|parameter| parameter.key);
    parameters.chain(table).collect::<Vec<_>>().join(", ")
}

fn number_of(item: &Item) -> Option<f64> {
    item.as_float().or_else(|| item.as_integer().map(|value| value as f64))
}
