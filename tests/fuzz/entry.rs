//! Where files from anywhere come in: what each entry promises of any bytes; `drive.rs` is the drive's side.
//!
//! The fuzz targets beside this file and `host-harness/tests/corpus.rs` call the same functions. A panic is
//! a defect, and so is an assertion here that does not hold.

#![allow(dead_code, reason = "a fuzz target calls one of them")]

use std::path::Path;

use host_harness::import::import;
use host_harness::import::map_file;
use host_harness::import::settings::Settings;
use host_harness::log::Log;
use host_harness::log::Need;
use host_harness::model::Model;

/// Text longer than this says nothing new.
const MOST: usize = 1 << 16;

fn text(bytes: &[u8]) -> Option<&str> {
    std::str::from_utf8(bytes.get(..bytes.len().min(MOST))?).ok()
}

/// A model is refused in words, or is admissible and the same after it was written and read again.
pub(crate) fn model(bytes: &[u8]) {
    let path = Path::new("model.toml");
    let Some(text) = text(bytes) else { return };
    match Model::parse(text, path) {
        Err(error) => assert!(!error.to_string().is_empty()),
        Ok(model) => {
            assert!(model.check().is_ok());
            let again = Model::parse(&model.to_toml(), path);
            assert_eq!(again.as_ref().map(|it| it.to_toml()).ok(), Some(model.to_toml()));
        }
    }
}

/// A log is refused in words, or its columns are as long as its time, which rises.
pub(crate) fn log(bytes: &[u8]) {
    let path = Path::new("log.csv");
    match Log::parse(bytes.get(..bytes.len().min(MOST)).unwrap_or_default(), path, Need::Drive) {
        Err(error) => assert!(!error.to_string().is_empty()),
        Ok(loaded) => {
            let columns = loaded.log.columns();
            assert!(columns.iter().all(|(_, values)| values.len() == loaded.log.len()));
            let time = columns.iter().find(|(name, _)| *name == "t_s").map(|(_, values)| *values);
            assert!(time.unwrap_or_default().is_sorted_by(|a, b| a < b));
        }
    }
}

/// A map is refused in words, or is the same after it was written and read again.
pub(crate) fn import_map(bytes: &[u8]) {
    let path = Path::new("map.toml");
    let Some(text) = text(bytes) else { return };
    match map_file::parse(text, path) {
        Err(error) => assert!(!error.to_string().is_empty()),
        Ok((map, settings)) => {
            let written = map_file::text(&map, &settings);
            let again =
                map_file::parse(&written, path).map(|(map, own)| map_file::text(&map, &own));
            assert_eq!(again.ok().as_deref(), Some(written.as_str()));
        }
    }
}

/// A recording under the map before its first line of dashes is refused in words or becomes a log.
pub(crate) fn recording(bytes: &[u8]) {
    let Some((map, sheet)) = text(bytes).and_then(|text| text.split_once("\n---\n")) else {
        return;
    };
    let (map, settings) = match map_file::parse(map, Path::new("map.toml")) {
        Ok((map, settings)) => (Some(map), settings),
        Err(_) => (None, Settings::default()),
    };
    match import(sheet, Path::new("recording.csv"), map.as_ref(), &settings) {
        Err(error) => assert!(!error.to_string().is_empty()),
        Ok(found) => {
            let columns = found.log.columns();
            assert!(columns.iter().all(|(_, values)| values.len() == found.log.len()));
        }
    }
}
