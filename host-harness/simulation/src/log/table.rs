//! The rows of a CSV file, checked as they come.

use std::path::Path;

use super::{KNOWN, MOTOR_ANGLE, TIME};
use crate::fault::InputError;

/// What single precision holds: no sensor shows more, and no drive computes with it.
const LARGEST: f64 = f32::MAX as f64;
/// Names that are listed, and characters of one that are shown.
const LISTED: usize = 8;
const SHOWN: usize = 40;

/// A text that a message can hold.
pub(super) fn shortened(text: &str) -> String {
    match text.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}

/// Names one after the other, as many as a message can hold.
pub(super) fn listed(names: &[&str]) -> String {
    let first: Vec<String> = names.iter().take(LISTED).map(|name| shortened(name)).collect();
    let more = match names.len().saturating_sub(LISTED) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    format!("{}{more}", first.join(", "))
}

/// The file's columns in the file's order; those that no log has stay empty.
pub(super) struct Table {
    pub(super) names: Vec<String>,
    pub(super) columns: Vec<Vec<f64>>,
}

impl Table {
    /// The line of a row of numbers, rows from 0.
    pub(super) fn line_of_row(bytes: &[u8], row: usize) -> Option<u64> {
        let mut reader = records(bytes);
        let mut record = csv::ByteRecord::new();
        for _ in 0..row + 2 {
            if !reader.read_byte_record(&mut record).ok()? {
                return None;
            }
        }
        Some(line_of(bytes, record.position()))
    }

    pub(super) fn parse(bytes: &[u8], path: &Path) -> Result<Self, InputError> {
        let mut reader = records(bytes);
        let mut table: Option<Table> = None;
        let mut record = csv::StringRecord::new();
        let fault = |what: String| InputError::new(path, what);
        loop {
            let more = reader.read_record(&mut record).map_err(|error| {
                let line = line_of(bytes, error.position());
                fault("is not UTF-8 text".to_owned())
                    .at_line(line)
                    .help("save the log as plain CSV text")
            })?;
            if !more {
                break;
            }
            let row = match &mut table {
                None => Self::header(&record, path).map(|header| table = Some(header)),
                Some(table) => table.row(&record, path),
            };
            row.map_err(|error| error.at_line(line_of(bytes, record.position())))?;
        }
        let table = table.ok_or_else(|| {
            fault("is empty".to_owned()).help("a log is one header row and then numbers")
        })?;
        match table.columns.first().map_or(0, Vec::len) {
            0 => Err(fault("has a header and no rows".to_owned())
                .help("a log needs at least two samples")),
            1 => Err(fault("has only one row".to_owned()).help("a log needs at least two samples")),
            _ => Ok(table),
        }
    }

    fn header(record: &csv::StringRecord, path: &Path) -> Result<Self, InputError> {
        let names: Vec<String> = record.iter().map(str::to_owned).collect();
        let fault = |what: String| InputError::new(path, what);
        for required in [TIME, MOTOR_ANGLE] {
            if names.iter().any(|name| name == required) {
                continue;
            }
            let help = if names.iter().all(|name| name.parse::<f64>().is_ok()) {
                "the first row must name the columns".to_owned()
            } else if names.iter().any(|name| name.contains([';', '\t'])) {
                "columns are separated by commas".to_owned()
            } else {
                let all: Vec<&str> = names.iter().map(String::as_str).collect();
                format!("name the columns as in docs/log-format.md; found: {}", listed(&all))
            };
            return Err(fault(format!("column {required} is missing")).help(help));
        }
        for (k, name) in names.iter().enumerate() {
            if KNOWN.contains(&name.as_str()) && names[..k].contains(name) {
                return Err(
                    fault(format!("column {name} is there twice")).help("rename or remove one")
                );
            }
        }
        let columns = vec![Vec::new(); names.len()];
        Ok(Self { names, columns })
    }

    fn row(&mut self, record: &csv::StringRecord, path: &Path) -> Result<(), InputError> {
        let fault = |what: String| InputError::new(path, what);
        if record.len() != self.names.len() {
            let (has, wants) = (record.len(), self.names.len());
            return Err(fault(format!("the row has {has} fields, the header {wants}"))
                .help("complete the row, with empty fields where values are missing"));
        }
        let columns = self.names.iter().zip(&mut self.columns);
        for ((name, column), text) in columns.zip(record) {
            if !KNOWN.contains(&name.as_str()) {
                continue;
            }
            let value = field(text).map_err(|what| {
                fault(format!("column {name}: `{}` {what}", shortened(text)))
                    .help("write a number with a decimal point, or leave the field empty")
            })?;
            if name == TIME {
                let last = column.last().copied().unwrap_or(f64::NEG_INFINITY);
                if value.is_nan() {
                    return Err(fault(format!("column {TIME}: the time is missing"))
                        .help("every row needs a time; remove the row or give it one"));
                }
                if value <= last {
                    return Err(fault(format!(
                        "column {TIME}: {value} does not rise above {last}"
                    ))
                    .help("time must rise strictly; sort the rows and remove repeated times"));
                }
            }
            column.push(value);
        }
        Ok(())
    }
}

/// The records of a CSV text, the header first.
fn records(bytes: &[u8]) -> csv::Reader<&[u8]> {
    csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .trim(csv::Trim::All)
        .from_reader(bytes)
}

/// A field's value, NaN where it is empty, or what is wrong with it.
fn field(text: &str) -> Result<f64, &'static str> {
    if text.is_empty() {
        return Ok(f64::NAN);
    }
    match text.parse::<f64>() {
        Ok(value) if value.abs() <= LARGEST => Ok(value),
        Ok(value) if value.is_finite() => Err("is larger than any measurement"),
        Ok(_) => Err("is not a finite number"),
        Err(_) => Err("is not a number"),
    }
}

/// The line of a record; what comes before it in its own bytes is the end of the line before.
fn line_of(bytes: &[u8], position: Option<&csv::Position>) -> u64 {
    let mut at = position.map_or(0, |position| position.byte() as usize).min(bytes.len());
    at += bytes[at..].iter().take_while(|byte| matches!(byte, b'\r' | b'\n')).count();
    bytes[..at].iter().filter(|byte| **byte == b'\n').count() as u64 + 1
}
