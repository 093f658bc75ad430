//! A map as TOML: kept beside the recordings of a machine, and the form of the presets.
//!
//! ```toml
//! [settings]            # optional, and every key in it: see `Settings`
//! separator = "semicolon"
//!
//! [[signal]]
//! name = "motor"
//! column = "pos"
//! unit = "counts/4096"  # optional, as times, negative and wrap
//! ```

use std::path::Path;

use serde::{Deserialize, Serialize};
use toml_edit::Document;

use super::map::{Entry, Map, wrapping};
use super::settings::Settings;
use super::signal::Signal;
use super::unit::Scaling;
use crate::fault::InputError;

#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct File {
    #[serde(skip_serializing_if = "is_default")]
    settings: Settings,
    signal: Vec<Row>,
}

fn is_default(settings: &Settings) -> bool {
    *settings == Settings::default()
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Row {
    name: String,
    column: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    times: Option<String>,
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    negative: bool,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    unit: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    wrap: Option<f64>,
}

/// Reads the text of a map file; `path` is what errors call it.
///
/// # Errors
/// What is wrong with it, with its place.
pub fn parse(text: &str, path: &Path) -> Result<(Map, Settings), InputError> {
    let fault = |what: String, span: Option<std::ops::Range<usize>>| {
        let error = InputError::new(path, what);
        match span {
            Some(span) => error.at(text, span),
            None => error,
        }
    };
    let document = Document::parse(text).map_err(|error| {
        fault(format!("not valid TOML: {}", error.message()), error.span())
            .help("a map file is TOML with one [[signal]] for each signal")
    })?;
    let File { settings, signal: rows } = toml_edit::de::from_str(text).map_err(|error| {
        let first = error.message().lines().next().unwrap_or_default().to_owned();
        fault(first, error.span()).help("docs/import.md has the keys of a map file")
    })?;
    let place = |k: usize, key: &str| {
        let tables = document.as_table().get("signal")?.as_array_of_tables()?;
        tables.get(k)?.get(key)?.span()
    };
    let mut map = Map::default();
    for (k, row) in rows.into_iter().enumerate() {
        let wrong =
            |key: &str, (what, help): (String, String)| fault(what, place(k, key)).help(help);
        let signal = Signal::named(&row.name).ok_or_else(|| {
            let what = format!("unknown signal `{}`", row.name);
            wrong("name", (what, format!("signals are: {}", Signal::names())))
        })?;
        let scaling = row.unit.map(|unit| Scaling::parse(signal.quantity(), &unit)).transpose();
        let scaling = scaling.map_err(|error| wrong("unit", error))?;
        let wrap = row.wrap.map(|period| match period.is_finite() && period > 0.0 {
            true => wrapping(signal, period),
            false => Err((
                format!("wrap = {period} is not a number above zero"),
                "give the number after which the column begins anew".to_owned(),
            )),
        });
        let wrap = wrap.transpose().map_err(|error| wrong("wrap", error))?;
        let (column, times, negative) = (row.column, row.times, row.negative);
        let optional = false;
        map.entries.push(Entry { signal, column, times, negative, scaling, wrap, optional });
    }
    if map.entries.is_empty() {
        return Err(fault("maps no signal".to_owned(), None)
            .help("write [[signal]] with name and column, once for each signal"));
    }
    Ok((map, settings))
}

/// The text of a map file.
pub fn text(map: &Map, settings: &Settings) -> String {
    let row = |entry: &Entry| Row {
        name: entry.signal.key().to_owned(),
        column: entry.column.clone(),
        times: entry.times.clone(),
        negative: entry.negative,
        unit: entry.scaling.as_ref().map(|scaling| scaling.text().to_owned()),
        wrap: entry.wrap,
    };
    let file = File { settings: settings.clone(), signal: map.entries.iter().map(row).collect() };
    // Plain texts, numbers and switches are always TOML.
    let toml = toml_edit::ser::to_string_pretty(&file).unwrap_or_default();
    format!("# Columns for `joint import --map`; docs/import.md has the keys.\n{toml}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::import::dialect::Separator;

    fn read(text: &str) -> Result<(Map, Settings), String> {
        parse(text, Path::new("map.toml")).map_err(|error| error.to_string())
    }

    #[test]
    fn what_is_written_reads_back_the_same() {
        let map = Map::parse(
            "t=time (ms):ms, i=-'i,q':A*1.22+0.5, u=duty*vbus, motor=pos:counts/4096 wrap=65536",
        );
        let settings = Settings {
            separator: Some(Separator::Blank),
            resample_hz: Some(1000.0),
            unwrap: Some(false),
            zero_time: true,
            ..Settings::default()
        };
        let (map, settings) = (map.unwrap(), settings);
        assert_eq!(read(&text(&map, &settings)), Ok((map.clone(), settings)));
        assert_eq!(read(&text(&map, &Settings::default())), Ok((map, Settings::default())));
    }

    #[test]
    fn an_error_points_at_the_value() {
        let file = "[[signal]]\nname = \"motor\"\ncolumn = \"pos\"\nunit = \"degg\"\n";
        let error = read(file).unwrap_err();
        assert!(error.starts_with("map.toml:4:8: unknown unit `degg`"), "{error}");
        let error = read(&file.replace("motor", "torque").replace("degg", "deg")).unwrap_err();
        assert!(error.starts_with("map.toml:2:8: unknown signal `torque`"), "{error}");
        let error = read(&file.replace("unit", "units")).unwrap_err();
        assert!(error.contains("map.toml:4") && error.contains("units"), "{error}");
        assert!(read("").unwrap_err().contains("maps no signal"));
        assert!(read("signal = 3 4").unwrap_err().contains("not valid TOML"));
    }
}
