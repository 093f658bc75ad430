//! A log to CSV. Numbers are written with as few digits as give the same value back.

use std::io::Write;

use super::Log;

impl Log {
    /// As CSV, its columns in a fixed order.
    pub fn to_csv(&self) -> String {
        write_columns(&self.columns())
    }
}

/// Named columns as CSV, as long as the shortest of them; NaN is an empty field.
pub fn write_columns<N: AsRef<str>, V: AsRef<[f64]>>(columns: &[(N, V)]) -> String {
    let rows = columns.iter().map(|(_, values)| values.as_ref().len()).min().unwrap_or(0);
    let mut text = String::new();
    let names: Vec<&str> = columns.iter().map(|(name, _)| name.as_ref()).collect();
    text.push_str(&names.join(","));
    text.push('\n');
    let mut fields = Vec::with_capacity(columns.len());
    for row in 0..rows {
        fields.clear();
        fields.extend(columns.iter().map(|(_, values)| number(values.as_ref()[row])));
        text.push_str(&fields.join(","));
        text.push('\n');
    }
    text
}

/// A CSV's text as gzip.
pub fn compressed(text: &str) -> Vec<u8> {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    // Writing to memory does not fail.
    let _ = encoder.write_all(text.as_bytes());
    encoder.finish().unwrap_or_default()
}

fn number(value: f64) -> String {
    if value.is_nan() { String::new() } else { format!("{value:?}") }
}
