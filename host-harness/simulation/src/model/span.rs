//! Where a table or a key of a model stands in its file, whether it is written as `[table]`,
//! dotted or inline.

use std::ops::Range;

use joint_core::params::Table as Place;
use toml_edit::{Item, Table, TableLike, Value};

/// Where a key stands in a table; for a `[table]`, its header.
pub(super) fn key(table: &dyn TableLike, name: &str) -> Option<Range<usize>> {
    let (key, item) = table.get_key_value(name)?;
    match item {
        Item::Table(table) if !table.is_dotted() => table.span().or_else(|| key.span()),
        _ => key.span(),
    }
}

/// The tables of `[[name]]`, or of an inline array, with where each stands; `None` where it is
/// neither.
pub(super) fn elements(item: &Item) -> Option<Vec<(Item, Option<Range<usize>>)>> {
    match item {
        Item::ArrayOfTables(tables) => {
            Some(tables.iter().map(|table| (Item::Table(table.clone()), table.span())).collect())
        }
        Item::Value(Value::Array(values)) => {
            Some(values.iter().map(|value| (Item::Value(value.clone()), value.span())).collect())
        }
        _ => None,
    }
}

/// The tables of a model file by their place in the joint.
pub(super) struct Tables<'a>(pub(super) &'a Table);

impl Tables<'_> {
    /// The table of a place, with where it stands.
    pub(super) fn find(&self, place: Place) -> Option<(Item, Option<Range<usize>>)> {
        let named =
            |table: &dyn TableLike, name: &str| Some((table.get(name)?.clone(), key(table, name)));
        let inner = |outer: Place| named(self.find(outer)?.0.as_table_like()?, "friction");
        let numbered = |name: &str, number: usize| {
            elements(self.0.get(name)?)?.into_iter().nth(number.checked_sub(1)?)
        };
        match place {
            Place::Motor => named(self.0, "motor"),
            Place::MotorFriction => inner(Place::Motor),
            Place::Stage(number) => numbered("stage", number),
            Place::StageFriction(number) => inner(Place::Stage(number)),
            Place::Load => named(self.0, "load"),
            Place::Effect(number) => numbered("effect", number),
            Place::Amplifier => None,
        }
    }

    /// Where the value of a key stands.
    pub(super) fn value(&self, place: Place, name: &str) -> Option<Range<usize>> {
        self.find(place)?.0.as_table_like()?.get(name)?.span()
    }
}
