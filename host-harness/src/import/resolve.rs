//! A map brought to the columns that a recording has.

use std::path::Path;

use super::map::{Entry, Map};
use super::sheet::Sheet;
use super::signal::Signal;
use super::unit::Scaling;
use crate::fault::InputError;

/// Where a signal comes from in a recording.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Source {
    /// The entry of the map, with the column's name as the recording has it and its unit.
    pub entry: Entry,
    /// Its unit.
    pub scaling: Scaling,
    /// The column.
    pub at: usize,
    /// The column that it is multiplied by.
    pub times_at: Option<usize>,
}

/// The sources of all signals that a map finds, in the order of a log's columns; what was assumed
/// goes to `notes`. Without a map, columns are taken that are named as a log's.
///
/// # Errors
/// A column that is not there, or a signal that a log needs and the map does not have.
pub(super) fn resolve(
    map: Option<&Map>,
    sheet: &Sheet<'_>,
    path: &Path,
    rows_are_times: bool,
    notes: &mut Vec<String>,
) -> Result<Vec<Source>, InputError> {
    let fault = |what: String| InputError::new(path, what).at_line(sheet.header_line());
    let own = own_names(sheet);
    let map = map.unwrap_or(&own);
    if map.entries.is_empty() {
        return Err(fault("no column is named as a log's, and no map is given".to_owned()).help(
            format!(
                "say which column is what, for example --map \"t=COLUMN:ms, i=COLUMN:A, motor=COLUMN:deg\"; {}",
                sheet.listed()
            ),
        ));
    }
    let mut sources = Vec::new();
    for signal in Signal::ALL {
        let entries: Vec<&Entry> = map.entries.iter().filter(|e| e.signal == signal).collect();
        let mut missing = Vec::new();
        for entry in &entries {
            match source(entry, sheet, notes).map_err(|what| fault(what).help(sheet.listed()))? {
                Ok(source) => {
                    sources.push(source);
                    missing.clear();
                    break;
                }
                Err(column) => missing.push(column),
            }
        }
        let needed = match signal {
            Signal::Time => !rows_are_times,
            Signal::Motor => true,
            _ => false,
        };
        match &missing[..] {
            [] if entries.is_empty() && needed => {
                let (key, quantity) = (signal.key(), signal.quantity());
                let more = match signal {
                    Signal::Time => {
                        "; where no column is the time, give the rate of the rows with --rate"
                    }
                    _ => "",
                };
                return Err(fault(format!("the map has no `{key}`, and a log needs it")).help(
                    format!(
                        "add {key}=COLUMN:{}{more}; {}",
                        quantity.of_the_log().names[0],
                        sheet.listed()
                    ),
                ));
            }
            [] => {}
            [only] if needed || !entries[0].optional => {
                let rate = match signal {
                    Signal::Time => {
                        "; where no column is the time, give the rate of the rows with --rate"
                    }
                    _ => "",
                };
                return Err(fault(format!("column `{only}` is not there, for `{}`", signal.key()))
                    .help(format!("{}{rate}", like(only, sheet))));
            }
            [_] => {}
            several if needed || !entries[0].optional => {
                let several = several.join("`, `");
                return Err(fault(format!("none of `{several}` is there, for `{}`", signal.key()))
                    .help(format!("add {}=COLUMN to --map; {}", signal.key(), sheet.listed())));
            }
            _ => {}
        }
    }
    if rows_are_times && sources.iter().any(|source| source.entry.signal == Signal::Time) {
        return Err(fault("has a time column, and --rate is given too".to_owned())
            .help("leave --rate out, or take `t` out of the map"));
    }
    Ok(sources)
}

/// A map of the columns that have the names of a log's.
fn own_names(sheet: &Sheet<'_>) -> Map {
    let names = sheet.names();
    let there = |signal: &Signal| names.iter().any(|name| name == signal.column());
    let entry = |signal: Signal| Entry {
        signal,
        column: signal.column().to_owned(),
        times: None,
        negative: false,
        scaling: None,
        wrap: None,
        optional: false,
    };
    Map { entries: Signal::ALL.into_iter().filter(there).map(entry).collect() }
}

/// The source of an entry; `Ok(Err)` with the column that is not there.
fn source(
    entry: &Entry,
    sheet: &Sheet<'_>,
    notes: &mut Vec<String>,
) -> Result<Result<Source, String>, String> {
    let Some(at) = sheet.position(&entry.column)? else { return Ok(Err(entry.column.clone())) };
    let times_at = match &entry.times {
        None => None,
        Some(times) => match sheet.position(times)? {
            None => return Ok(Err(times.clone())),
            at => at,
        },
    };
    let names = sheet.names();
    let name = |at: usize| names.get(at).cloned().unwrap_or_default();
    let (key, column) = (entry.signal.key(), name(at));
    let quantity = entry.signal.quantity();
    // A product has no unit of its own in the file.
    let told = if times_at.is_none() { sheet.unit(at, quantity) } else { None };
    let scaling = match (&entry.scaling, told) {
        (Some(stated), told) => {
            if let (Some(own), Some(told)) =
                (stated.unit_alone(), told.as_ref().and_then(Scaling::unit_alone))
                && own != told
            {
                notes.push(format!(
                    "{key}: the map says {}, the file {} for column {column}; the map counts",
                    own.names[0], told.names[0]
                ));
            }
            stated.clone()
        }
        (None, Some(told)) => told,
        (None, None) => {
            let scaling = Scaling::of_the_log(quantity);
            notes.push(format!(
                "{key}: neither map nor file gives the unit of column {column}; taken as {}",
                scaling.text()
            ));
            scaling
        }
    };
    let mut entry = entry.clone();
    entry.column = column;
    entry.times = times_at.map(name);
    entry.scaling = Some(scaling.clone());
    entry.optional = false;
    Ok(Ok(Source { entry, scaling, at, times_at }))
}

/// What to say of a column that is not there: the one that is spelled nearly so, and all.
fn like(wanted: &str, sheet: &Sheet<'_>) -> String {
    let plain = |text: &str| -> String {
        text.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
    };
    let same = |name: &String| plain(name) == plain(wanted);
    let within = |name: &String| plain(name).contains(&plain(wanted));
    let names = sheet.names();
    let near = names.iter().find(|name| same(name)).or(names.iter().find(|name| within(name)));
    match near {
        Some(near) => format!("there is a column `{near}`; {}", sheet.listed()),
        None => sheet.listed(),
    }
}
