//! A model to TOML: the same text for the same model, and numbers in the fewest digits that read
//! back to the same value.

use serde::Serialize;
use toml_edit::ser::ValueSerializer;
use toml_edit::{Array, ArrayOfTables, DocumentMut, InlineTable, Item, Table, Value};

use super::Model;
use super::effect::UNNAMED;

impl Model {
    /// As the text of a model file.
    pub fn to_toml(&self) -> String {
        let mut document = DocumentMut::new();
        let root = document.as_table_mut();
        root.insert("name", toml_edit::value(self.name.as_str()));
        root.insert("motor", Item::Table(table_of(&self.motor)));
        root.insert("stage", tables(self.stages.iter().map(table_of)));
        root.insert("load", Item::Table(table_of(&self.load)));
        root.insert("sensor", Item::Table(table_of(&self.sensor)));
        let effects = self.effects.iter().map(|effect| {
            let mut table = Table::new();
            table.insert("kind", toml_edit::value(effect.kind.spec().kind));
            table.insert("location", toml_edit::value(effect.location.to_string()));
            for (spec, value) in effect.kind.spec().parameters.iter().zip(effect.values) {
                table.insert(spec.key, Item::Value(float(value)));
            }
            if let Some(spec) = &effect.kind.spec().table {
                let knots = [effect.table.forward(), effect.table.backward()];
                for (key, knots) in [spec.forward, spec.backward].into_iter().zip(knots) {
                    if !knots.is_empty() {
                        let knots: Array = knots.iter().map(|knot| float(*knot)).collect();
                        table.insert(key, toml_edit::value(knots));
                    }
                }
            }
            if effect.kind.is_unnamed() {
                table.insert(UNNAMED, toml_edit::value(true));
            }
            table
        });
        root.insert("effect", tables(effects));
        document.to_string()
    }
}

fn tables(tables: impl Iterator<Item = Table>) -> Item {
    Item::ArrayOfTables(tables.collect::<ArrayOfTables>())
}

/// A plain struct as a table; its keys are its fields, so that they stand once.
fn table_of<T: Serialize>(value: &T) -> Table {
    match value.serialize(ValueSerializer::new()) {
        Ok(Value::InlineTable(inline)) => opened(inline),
        _ => Table::new(),
    }
}

fn opened(inline: InlineTable) -> Table {
    let mut table = Table::new();
    for (key, value) in inline {
        let item = match value {
            Value::InlineTable(inner) => Item::Table(opened(inner)),
            Value::Float(number) => Item::Value(float(number.into_value())),
            other => Item::Value(other),
        };
        table.insert(&key, item);
    }
    table
}

/// Rust's shortest form that reads back to the same value, which is TOML for every finite number.
fn float(value: f64) -> Value {
    format!("{value:?}").parse().unwrap_or_else(|_| Value::from(value))
}
