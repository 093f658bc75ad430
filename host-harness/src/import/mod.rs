//! A log from what a drive, a bench or a script has recorded.
//!
//! The other verbs take one kind of file, in SI units, under fixed names. Recordings come in
//! milliseconds, counts and milliamperes, between semicolons, with names of their own. A map says which column
//! is which signal and in what unit; nothing is guessed that would change what a sample means, and
//! what is assumed is told. docs/import.md has the map's grammar and the units.

pub mod dialect;
#[cfg(feature = "formats")]
mod formats;
pub mod map;
pub mod map_file;
pub mod number;
pub mod preset;
mod resample;
mod resolve;
pub mod settings;
pub mod sheet;
pub mod signal;
pub mod text;
pub mod unit;
mod unwrap;

use std::path::Path;

use crate::fault::InputError;
use crate::log::Log;
use crate::preflight::{recording, wraps};

use map::Map;
use resolve::Source;
use settings::Settings;
use sheet::{Columns, Sheet, Stated};
use signal::Signal;

/// A log made of a recording, and what was done for it.
#[derive(Clone, Debug, PartialEq)]
pub struct Imported {
    /// The log.
    pub log: Log,
    /// Its signals, in the order of a log's columns.
    pub signals: Vec<Told>,
    /// What was assumed or noticed, a sentence each.
    pub notes: Vec<String>,
    /// The map as it was applied: columns by their names in the recording, every unit stated.
    pub map: Map,
}

/// What became a signal.
#[derive(Clone, Debug, PartialEq)]
pub struct Told {
    /// The signal.
    pub signal: Signal,
    /// The column or columns, as in a map.
    pub column: String,
    /// The unit, as in a map.
    pub unit: String,
    /// Smallest value, in the log's unit.
    pub smallest: f64,
    /// Largest value, in the log's unit.
    pub largest: f64,
    /// Samples without a value.
    pub missing: usize,
    /// How many times the angle began anew and was made to go on.
    pub unwrapped: usize,
}

/// Makes a log of a recording's text; `path` is what errors call it. Without a map, columns are
/// taken that are named as a log's.
///
/// # Errors
/// What is wrong with text or map, with line and column, and what to do.
pub fn import(
    text: &str,
    path: &Path,
    map: Option<&Map>,
    settings: &Settings,
) -> Result<Imported, InputError> {
    let stated = Stated {
        separator: settings.separator,
        decimal: settings.decimal,
        names: settings.names.clone(),
    };
    let mut sheet = Sheet::find(text, path, &stated)?;
    if !sheet.name(&settings.headerless) && !settings.headerless.is_empty() {
        let known: Vec<_> = settings.headerless.iter().map(|list| list.len().to_string()).collect();
        return Err(InputError::new(
            path,
            format!(
                "has {} columns without names; the preset knows {}",
                sheet.names().len(),
                known.join(" and ")
            ),
        )
        .at_line(sheet.header_line())
        .help("name the columns in their order with --names a,b,c"));
    }
    let mut notes = sheet.notes.clone();
    let sources = resolve::resolve(map, &sheet, path, settings.rate_hz.is_some(), &mut notes)?;
    let wanted: Vec<usize> =
        sources.iter().flat_map(|source| [Some(source.at), source.times_at]).flatten().collect();
    let columns = sheet.read(&wanted)?;
    let mut series = values(&sources, &columns);
    let rows = Rows { path, sources: &sources, lines: &columns.lines };
    rows.keep(&mut series, settings, &mut notes)?;
    let mut unwrapped = vec![0; series.len()];
    for ((source, values), times) in sources.iter().zip(&mut series).zip(&mut unwrapped) {
        *times = scale(source, values, settings, &mut notes);
    }
    let mut time = match &sources[..] {
        [first, ..] if first.entry.signal == Signal::Time => series[0].clone(),
        _ => {
            let rate = settings.rate_hz.unwrap_or(1.0);
            (0..series.first().map_or(0, Vec::len)).map(|k| k as f64 / rate).collect()
        }
    };
    start(&mut time, settings, &mut notes);
    if let Some(rate_hz) = settings.resample_hz {
        let even = resample::grid(&time, rate_hz);
        if even.len() < time.len() {
            notes.push(format!(
                "{} samples become {}: faster motion than half of {rate_hz} Hz folds into slower",
                time.len(),
                even.len()
            ));
        }
        for (source, values) in sources.iter().zip(&mut series) {
            *values = resample::at(&even, &time, values, source.entry.signal);
        }
        time = even;
    }
    let signals = told(&sources, &series, &unwrapped, &time);
    let map = Map { entries: sources.iter().map(|source| source.entry.clone()).collect() };
    let log = log(path, &sources, series, time, &mut notes)?;
    notes.extend(recording(&log).into_iter().map(|finding| match finding.help.as_str() {
        "" => finding.message,
        help => format!("{}: {help}", finding.message),
    }));
    Ok(Imported { log, signals, notes, map })
}

/// The numbers of every source: its sign, and its product with the second column.
fn values(sources: &[Source], columns: &Columns) -> Vec<Vec<f64>> {
    let mut columns = columns.columns.iter();
    sources
        .iter()
        .map(|source| {
            let mut values = columns.next().cloned().unwrap_or_default();
            if source.entry.negative {
                values.iter_mut().for_each(|value| *value = -*value);
            }
            if source.times_at.is_some() {
                let factors = columns.next().into_iter().flatten();
                values.iter_mut().zip(factors).for_each(|(value, factor)| *value *= factor);
            }
            values
        })
        .collect()
}

/// The rows of a recording, for errors that name their line.
struct Rows<'a> {
    path: &'a Path,
    sources: &'a [Source],
    lines: &'a [u64],
}

impl Rows<'_> {
    /// Drops rows that hold nothing, and those that repeat a time where that is asked for.
    ///
    /// # Errors
    /// A time that is missing or does not rise, or fewer than two rows.
    fn keep(
        &self,
        series: &mut [Vec<f64>],
        settings: &Settings,
        notes: &mut Vec<String>,
    ) -> Result<(), InputError> {
        let timed = self.sources.first().filter(|source| source.entry.signal == Signal::Time);
        let fault = |what: String, row: usize| {
            let line = self.lines.get(row).copied().unwrap_or_default();
            InputError::new(self.path, what).at_line(line)
        };
        if let (Some(source), Some(time)) = (timed, series.first_mut())
            && let Some(period) = source.entry.wrap
        {
            unwrap::forward(time, period);
        }
        let first = usize::from(timed.is_some());
        let mut kept = vec![true; self.lines.len()];
        let (mut empty, mut repeated, mut last) = (0, 0, f64::NEG_INFINITY);
        for row in 0..kept.len() {
            // Without a time column, rows count time, and none may be left out.
            let Some(source) = timed else { break };
            if series[first..].iter().all(|values| values[row].is_nan()) {
                (kept[row], empty) = (false, empty + 1);
                continue;
            }
            let (name, time) = (&source.entry.column, series[0][row]);
            if time.is_nan() {
                return Err(fault(format!("column {name}: the time is missing"), row)
                    .help("every row needs a time; remove the row or give it one"));
            }
            if time == last && settings.drop_repeated {
                (kept[row], repeated) = (false, repeated + 1);
                continue;
            }
            if time <= last {
                let help = match time == last {
                    true => {
                        "two rows have the same time; give --drop-repeated to leave out the second, or map a finer clock"
                    }
                    false => {
                        "time must rise strictly; sort the rows, or give the period of a clock that begins anew: t=COLUMN:us wrap=4294967296"
                    }
                };
                let what = format!("column {name}: {time} does not rise above {last}");
                return Err(fault(what, row).help(help));
            }
            last = time;
        }
        for (count, why) in [(empty, "hold no value"), (repeated, "repeat the time before")] {
            if count > 0 {
                notes.push(format!("{count} rows {why} and are left out"));
            }
        }
        if kept.contains(&false) {
            for values in series.iter_mut() {
                let mut row = kept.iter();
                values.retain(|_| row.next().copied().unwrap_or(true));
            }
        }
        match kept.iter().filter(|kept| **kept).count() {
            0 | 1 => Err(InputError::new(self.path, "has fewer than two rows with values")
                .help("a log needs at least two samples")),
            _ => Ok(()),
        }
    }
}

/// Brings a source's numbers to the log's unit, angles made to go on; how many times they began anew.
fn scale(
    source: &Source,
    values: &mut [f64],
    settings: &Settings,
    notes: &mut Vec<String>,
) -> usize {
    let entry = &source.entry;
    let key = entry.signal.key();
    let is_angle = entry.signal.quantity() == unit::Quantity::Angle;
    let stated = entry.wrap.filter(|_| is_angle).map(|period| unwrap::unwrap(values, period));
    values.iter_mut().for_each(|value| *value = source.scaling.si(*value));
    let seen = stated.is_none() && is_angle && settings.unwrap != Some(false);
    let found = match stated {
        Some(found) => Some(found),
        None if seen && !wraps(values).is_empty() => {
            let found = unwrap::unwrap(values, std::f64::consts::TAU);
            notes.push(format!(
                "{key}: jumps by a turn {} times and was made to go on; --unwrap off leaves it as it is",
                found.times
            ));
            Some(found)
        }
        None => None,
    };
    let Some(found) = found else { return 0 };
    if found.times > 0 && found.longest > unwrap::DOUBTFUL {
        notes.push(format!(
            "{key}: moves up to {:.2} of its period between two samples; past 0.5 its turns are lost: record faster",
            found.longest
        ));
    }
    found.times
}

/// A time of day is a long number in front of a short recording.
const LATE_START_S: f64 = 86_400.0;

fn start(time: &mut [f64], settings: &Settings, notes: &mut Vec<String>) {
    let Some(first) = time.first().copied() else { return };
    if settings.zero_time {
        time.iter_mut().for_each(|time| *time -= first);
    } else if first.abs() > LATE_START_S {
        notes.push(format!("t: begins at {first} s; --zero-time lets it begin at zero"));
    }
}

fn told(sources: &[Source], series: &[Vec<f64>], unwrapped: &[usize], time: &[f64]) -> Vec<Told> {
    let rows = sources.iter().zip(series).zip(unwrapped);
    rows.map(|((source, values), unwrapped)| {
        let entry = &source.entry;
        let values = if entry.signal == Signal::Time { time } else { values };
        let sign = if entry.negative { "-" } else { "" };
        let column = match &entry.times {
            Some(times) => format!("{sign}{}*{times}", entry.column),
            None => format!("{sign}{}", entry.column),
        };
        Told {
            signal: entry.signal,
            column,
            unit: source.scaling.text().to_owned(),
            smallest: values.iter().copied().fold(f64::NAN, f64::min),
            largest: values.iter().copied().fold(f64::NAN, f64::max),
            missing: values.iter().filter(|value| value.is_nan()).count(),
            unwrapped: *unwrapped,
        }
    })
    .collect()
}

/// The log of the signals; one without any value is left out.
fn log(
    path: &Path,
    sources: &[Source],
    series: Vec<Vec<f64>>,
    time: Vec<f64>,
    notes: &mut Vec<String>,
) -> Result<Log, InputError> {
    let mut log = Log { time_s: time, ..Log::default() };
    let mut lacking = Vec::new();
    for (source, values) in sources.iter().zip(series) {
        let signal = source.entry.signal;
        if signal != Signal::Time && values.iter().all(|value| value.is_nan()) {
            lacking.push(format!("column {} holds no value", source.entry.column));
            continue;
        }
        match signal {
            Signal::Time => {}
            Signal::Voltage => log.voltage_v = Some(values),
            Signal::Current => log.current_a = Some(values),
            Signal::Motor => log.motor_angle_rad = values,
            Signal::Output => log.output_angle_rad = Some(values),
            Signal::Load => log.load_torque_nm = Some(values),
            Signal::Bus => log.bus_v = Some(values),
            Signal::Temperature => log.temperature_c = Some(values),
            Signal::Reference => log.reference_angle_rad = Some(values),
        }
    }
    let fault = |what: &str| {
        let what = match &lacking[..] {
            [] => what.to_owned(),
            lacking => format!("{what}: {}", lacking.join(", ")),
        };
        InputError::new(path, what)
    };
    if log.motor_angle_rad.is_empty() {
        return Err(
            fault("has no rotor angle").help("a log needs one; map motor to another column")
        );
    }
    if log.voltage_v.is_none() && log.current_a.is_none() {
        return Err(fault("neither u nor i is mapped, so nothing says what was put in")
            .help("add the voltage as u or the current as i to the map"));
    }
    notes.extend(lacking.into_iter().map(|what| format!("{what} and is left out")));
    Ok(log)
}
