//! Tables in files that are no text, made into one.
//!
//! A table of another format becomes CSV text, so that names, units, missing values and errors are
//! the same whatever the file was: line N of an error is its row N - 1.

mod mat;
mod mcap;
mod parquet;
mod ros;

use std::path::Path;

use crate::fault::InputError;

/// A table on its way to text.
struct Table {
    names: Vec<String>,
    /// One text for each name; shorter rows end in missing values.
    rows: Vec<Vec<String>>,
}

impl Table {
    fn text(self) -> String {
        let mut writer = csv::WriterBuilder::new().flexible(true).from_writer(Vec::new());
        let width = self.names.len();
        let mut write = |mut row: Vec<String>| {
            row.resize(width, String::new());
            // Writing to memory does not fail.
            let _ = writer.write_record(&row);
        };
        write(self.names);
        self.rows.into_iter().for_each(&mut write);
        String::from_utf8(writer.into_inner().unwrap_or_default()).unwrap_or_default()
    }
}

/// The text of a file of a known format; `None` where it is none.
///
/// # Errors
/// It is damaged, or it holds no table.
pub(super) fn text(bytes: &[u8], path: &Path) -> Result<Option<String>, InputError> {
    type Read = fn(&[u8]) -> Result<Table, String>;
    let known: [(&[u8], &str, Read); 3] = [
        (b"PAR1", "Parquet", parquet::read),
        (b"MATLAB 5.0 MAT-file", "MATLAB", mat::read),
        (b"\x89MCAP0\r\n", "MCAP", mcap::read),
    ];
    let Some((_, name, read)) = known.iter().find(|(magic, ..)| bytes.starts_with(magic)) else {
        return Ok(None);
    };
    let table = read(bytes).map_err(|why| {
        InputError::new(path, format!("cannot be read as a {name} file: {why}"))
            .help("write the file again, or export the recording as CSV")
    })?;
    Ok(Some(table.text()))
}

/// A number in the fewest digits that read back to the same value.
fn number(value: f64) -> String {
    if value.is_nan() { String::new() } else { format!("{value:?}") }
}
