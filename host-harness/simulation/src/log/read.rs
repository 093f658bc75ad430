//! A log from CSV, plain or compressed.
//!
//! Logs come from oscilloscopes, spreadsheets and other people's scripts: a byte order mark, CRLF
//! and padded fields are let pass; anything that would silently change what a sample means is an
//! error that names line and column.

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use super::table::{Table, listed};
use super::{CURRENT, KNOWN, Log, MOTOR_ANGLE, OUTPUT_ANGLE, TIME, VOLTAGE};
use crate::fault::InputError;
use crate::standard;

/// What the reader of a log cannot do without, beside time and rotor angle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Need {
    /// At least one of voltage and current.
    Drive,
    /// Nothing more.
    Nothing,
}

/// A log and what its file holds beside it.
#[derive(Clone, Debug, PartialEq)]
pub struct Loaded {
    /// The log.
    pub log: Log,
    /// What was ignored, a sentence each.
    pub warnings: Vec<String>,
}

impl Log {
    /// Reads a log; compression is told by the content, not by the name.
    ///
    /// # Errors
    /// What is wrong with the file, with line and column.
    pub fn read(path: &Path, need: Need) -> Result<Loaded, InputError> {
        let bytes = unpacked(path)?;
        Self::parse(&bytes, path, need)
    }

    /// Reads a log from the bytes of a CSV file; `path` is what errors call it.
    ///
    /// # Errors
    /// What is wrong with the text, with line and column.
    pub fn parse(bytes: &[u8], path: &Path, need: Need) -> Result<Loaded, InputError> {
        let table = Table::parse(bytes, path)?;
        table.into_log(path, need)
    }
}

/// Most bytes of a log's or recording's text, decompressed: of 10 million rows and ten columns. It is held
/// in memory, and its numbers beside it.
pub const MOST_BYTES: u64 = 1 << 30;

/// The bytes of a file, decompressed where its content says that it is compressed.
///
/// # Errors
/// It cannot be read or decompressed.
pub fn unpacked(path: &Path) -> Result<Vec<u8>, InputError> {
    let unreadable = |error: std::io::Error| InputError::unreadable(path, &error);
    let mut raw: Box<dyn BufRead> = match standard::is(path) {
        true => Box::new(standard::input().map_err(unreadable)?),
        false => Box::new(BufReader::new(File::open(path).map_err(unreadable)?)),
    };
    let mut bytes = Vec::new();
    let most = MOST_BYTES + 1;
    if raw.fill_buf().map_err(unreadable)?.starts_with(&[0x1f, 0x8b]) {
        let unpacking = flate2::bufread::MultiGzDecoder::new(raw);
        unpacking.take(most).read_to_end(&mut bytes).map_err(|error| {
            InputError::new(path, format!("cannot be decompressed: {error}"))
                .help("the .gz file is cut short or damaged; compress it again")
        })?;
    } else {
        raw.take(most).read_to_end(&mut bytes).map_err(unreadable)?;
    }
    if bytes.len() as u64 > MOST_BYTES {
        return Err(InputError::new(path, "has more than 1 GiB of text")
            .help("cut it into several logs; some seconds of motion tell as much"));
    }
    Ok(bytes)
}

/// The line of a log's file on which a row of numbers stands, rows from 0 and lines from 1; `None` where
/// there is no such row.
pub fn line_of_row(path: &Path, row: usize) -> Option<u64> {
    Table::line_of_row(&unpacked(path).ok()?, row)
}

impl Table {
    /// Takes a column out; `None` where it is not there or holds no value.
    fn take(&mut self, name: &str, warnings: &mut Vec<String>) -> Option<Vec<f64>> {
        let at = self.names.iter().position(|own| own == name)?;
        let values = std::mem::take(self.columns.get_mut(at)?);
        if values.iter().all(|value| value.is_nan()) {
            warnings.push(format!("column {name} holds no value and is ignored"));
            return None;
        }
        Some(values)
    }

    fn into_log(mut self, path: &Path, need: Need) -> Result<Loaded, InputError> {
        let mut warnings = Vec::new();
        let unknown: Vec<&str> = self
            .names
            .iter()
            .map(String::as_str)
            .filter(|name| !name.is_empty() && !KNOWN.contains(name))
            .collect();
        if !unknown.is_empty() {
            warnings.push(format!("unknown columns are ignored: {}", listed(&unknown)));
        }
        let mut take = |name: &str| self.take(name, &mut warnings);
        let log = Log {
            time_s: take(TIME).unwrap_or_default(),
            voltage_v: take(VOLTAGE),
            current_a: take(CURRENT),
            motor_angle_rad: take(MOTOR_ANGLE).unwrap_or_default(),
            output_angle_rad: take(OUTPUT_ANGLE),
            load_torque_nm: take("load_torque_nm"),
            bus_v: take("bus_v"),
            temperature_c: take("temperature_c"),
            reference_angle_rad: take("reference_angle_rad"),
        };
        if log.motor_angle_rad.is_empty() {
            return Err(InputError::new(path, format!("column {MOTOR_ANGLE} holds no value"))
                .help("a log needs the rotor angle"));
        }
        if need == Need::Drive && log.voltage_v.is_none() && log.current_a.is_none() {
            return Err(InputError::new(
                path,
                format!(
                    "neither {VOLTAGE} nor {CURRENT} is there, so nothing says what was put in"
                ),
            )
            .help(format!("add the voltage as {VOLTAGE} or the current as {CURRENT}")));
        }
        Ok(Loaded { log, warnings })
    }
}
