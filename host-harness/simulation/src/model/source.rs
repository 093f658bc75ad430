//! The text of a model file, and errors that point into it.

use std::ops::Range;
use std::path::Path;

use joint_core::params::{Friction, Table as Place};
use serde::de::{DeserializeOwned, IntoDeserializer};
use toml_edit::de::Deserializer;
use toml_edit::{DocumentMut, Item, TableLike};

use crate::fault::InputError;

/// A file's text under its name.
pub(super) struct Source<'a> {
    pub(super) text: &'a str,
    pub(super) path: &'a Path,
}

impl Source<'_> {
    /// An error, pointed at its place where that is known.
    pub(super) fn fault(&self, what: impl Into<String>, span: Option<Range<usize>>) -> InputError {
        let error = InputError::new(self.path, what);
        match span {
            Some(span) => error.at(self.text, span),
            None => error,
        }
    }

    /// Reads a table as a type of `joint-core`.
    pub(super) fn table<T: DeserializeOwned>(
        &self,
        item: &Item,
        called: &str,
        span: Option<Range<usize>>,
    ) -> Result<T, InputError> {
        let read = match item {
            Item::Table(table) => {
                T::deserialize(Deserializer::from(DocumentMut::from(table.clone())))
            }
            Item::Value(value) if value.is_inline_table() => {
                T::deserialize(value.clone().into_deserializer())
            }
            _ => return Err(self.fault(format!("{called} must be a table"), span)),
        };
        read.map_err(|error| {
            let named = error.span().and_then(|at| key_of(item.as_table_like()?, &at));
            let called = named.map_or(called.to_owned(), |key| format!("{called} {key}"));
            self.explained(error.message(), error.span().or(span), &called)
        })
    }

    pub(super) fn with_friction<T: DeserializeOwned>(
        &self,
        item: &Item,
        [own, inner]: [Place; 2],
        span: Option<Range<usize>>,
    ) -> Result<T, InputError> {
        if let Some(friction) = item.as_table_like().and_then(|table| table.get("friction")) {
            self.table::<Friction>(friction, &inner.to_string(), friction.span())?;
        }
        self.table(item, &own.to_string(), span)
    }

    /// Puts the deserialiser's message in the words of the file format.
    fn explained(&self, message: &str, span: Option<Range<usize>>, called: &str) -> InputError {
        let first = message.lines().next().unwrap_or(message);
        if let Some(rest) = first.strip_prefix("unknown field ") {
            let (key, known) = rest.split_once(", expected ").unwrap_or((rest, ""));
            let known = known.trim_start_matches("one of ").replace('`', "");
            return self
                .fault(format!("unknown key {key} in {called}"), span)
                .help(format!("its keys are: {known}"));
        }
        let what = first
            .replace("invalid type: ", "wrong type: ")
            .replace("floating point", "number")
            .replace("expected f64", "expected a number")
            .replace("expected u32", "expected a whole number");
        self.fault(format!("{called}: {what}"), span)
    }
}

/// The key whose value stands at this range.
fn key_of(table: &dyn TableLike, span: &Range<usize>) -> Option<String> {
    table.iter().find_map(|(key, item)| {
        if item.span().as_ref() == Some(span) {
            return Some(key.to_owned());
        }
        key_of(item.as_table_like()?, span)
    })
}
