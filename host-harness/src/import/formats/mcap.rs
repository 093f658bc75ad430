//! MCAP: messages as JSON, or as ROS 2 sends them. A row for each time of a message; a column for each
//! number in it, under topic and path: `/joint_states.position.0`.

use std::collections::{BTreeMap, HashMap};

use mcap::MessageStream;
use serde_json::Value;

use super::ros::Definitions;
use super::{Table, number};

/// Time since the first message.
const TIME: &str = "log_time [s]";

pub(super) fn read(bytes: &[u8]) -> Result<Table, String> {
    let mut names = vec![TIME.to_owned()];
    let mut columns: HashMap<String, usize> = HashMap::new();
    let mut rows: BTreeMap<u64, Vec<(usize, String)>> = BTreeMap::new();
    let mut schemas: HashMap<u16, Definitions> = HashMap::new();
    let mut unread: Vec<String> = Vec::new();
    for message in MessageStream::new(bytes).map_err(|error| error.to_string())? {
        let message = message.map_err(|error| error.to_string())?;
        let channel = &message.channel;
        let mut fields = Vec::new();
        match (channel.message_encoding.as_str(), &channel.schema) {
            ("json", _) => {
                let value: Value = serde_json::from_slice(&message.data)
                    .map_err(|error| format!("{}: {error}", channel.topic))?;
                flatten(&channel.topic, &value, &mut fields);
            }
            ("cdr", Some(schema)) if schema.encoding == "ros2msg" => {
                let definitions = schemas.entry(schema.id).or_insert_with(|| {
                    Definitions::parse(&schema.name, &String::from_utf8_lossy(&schema.data))
                });
                definitions
                    .read(&channel.topic, &message.data, &mut fields)
                    .map_err(|why| format!("{}: {why}", channel.topic))?;
            }
            (encoding, _) => {
                let what = format!("{} ({encoding})", channel.topic);
                if !unread.contains(&what) {
                    unread.push(what);
                }
                continue;
            }
        }
        let row = rows.entry(message.log_time).or_default();
        for (name, value) in fields {
            let at = *columns.entry(name).or_insert_with_key(|name| {
                names.push(name.clone());
                names.len() - 1
            });
            row.push((at, value));
        }
    }
    if rows.is_empty() {
        return Err(match unread.is_empty() {
            true => "it holds no message".to_owned(),
            false => format!("it holds no JSON or ROS 2 message, but {}", unread.join(", ")),
        });
    }
    let first = rows.keys().next().copied().unwrap_or_default();
    let width = names.len();
    let rows = rows.into_iter().map(|(time, fields)| {
        let mut row = vec![String::new(); width];
        row[0] = number((time - first) as f64 / 1e9);
        for (at, value) in fields {
            row[at] = value;
        }
        row
    });
    let rows = rows.collect();
    Ok(Table { names, rows })
}

/// Every number in a value under its path.
fn flatten(path: &str, value: &Value, fields: &mut Vec<(String, String)>) {
    match value {
        Value::Null => {}
        Value::Bool(value) => fields.push((path.to_owned(), u8::from(*value).to_string())),
        Value::Number(value) => fields.push((path.to_owned(), value.to_string())),
        Value::String(value) => fields.push((path.to_owned(), value.clone())),
        Value::Array(values) => {
            for (k, value) in values.iter().enumerate() {
                flatten(&format!("{path}.{k}"), value, fields);
            }
        }
        Value::Object(values) => {
            for (key, value) in values {
                flatten(&format!("{path}.{key}"), value, fields);
            }
        }
    }
}
