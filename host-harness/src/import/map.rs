//! Which column of a recording becomes which signal of a log.
//!
//! On the command line a map is one text, `t=time_ms:ms, i=-iq:A*1.22, u=duty*vbus:V`; in a file it
//! is TOML ([`super::map_file`]), so that a recorder's map is written once and kept.

use std::ops::Range;
use std::path::Path;

use super::signal::Signal;
use super::unit::{Quantity, Scaling};
use crate::fault::InputError;

/// One signal from one column, or from the product of two.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// What it becomes.
    pub signal: Signal,
    /// The column, by its name or as `#N` by its number from 1.
    pub column: String,
    /// The column that it is multiplied by.
    pub times: Option<String>,
    /// Whether the column's number is turned round.
    pub negative: bool,
    /// Its unit with scale and offset; where left out, what the file says, else the log's.
    pub scaling: Option<Scaling>,
    /// Period after which the column's number begins anew, in the column's own numbers.
    pub wrap: Option<f64>,
    /// Whether a recording may lack it: so in presets, which know more names than one recording has.
    pub optional: bool,
}

/// Which column becomes which signal, in the order in which they are looked for: where a signal
/// stands more than once, the first whose columns are there counts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Map {
    /// The entries.
    pub entries: Vec<Entry>,
}

/// The name under which errors about a map on the command line go.
const ARGUMENT: &str = "--map";

impl Map {
    /// Reads the text of a map.
    ///
    /// # Errors
    /// What is wrong with it, with its place.
    pub fn parse(text: &str) -> Result<Self, InputError> {
        let mut reader = Reader { text, at: 0 };
        let mut map = Self::default();
        loop {
            reader.skip_spaces();
            if reader.rest().is_empty() {
                break;
            }
            let start = reader.at;
            let entry = reader.entry()?;
            if map.entries.iter().any(|own| own.signal == entry.signal) {
                let what = format!("`{}` is mapped twice", entry.signal.key());
                return Err(reader.fault(what, start..reader.at).help("remove one of the two"));
            }
            map.entries.push(entry);
            reader.skip_spaces();
            if !reader.rest().is_empty() && !reader.take(',') {
                let at = reader.at;
                return Err(reader
                    .fault(format!("`{}` is not understood", reader.rest()), at..text.len())
                    .help("entries are separated by commas; put a column's name with :, * or , in quotes"));
            }
        }
        if map.entries.is_empty() {
            return Err(reader.fault("the map is empty".to_owned(), 0..0).help(EXAMPLE));
        }
        Ok(map)
    }

    /// The same, the entries of `other` in the place of those that it has the signals of.
    #[must_use]
    pub fn overlaid(mut self, other: Map) -> Self {
        let replaced = |entry: &Entry| other.entries.iter().any(|new| new.signal == entry.signal);
        self.entries.retain(|entry| !replaced(entry));
        self.entries.extend(other.entries);
        self
    }
}

const EXAMPLE: &str =
    "write for example --map \"t=time_ms:ms, i=iq:A*1.22, motor=pos:counts/4096\"";

/// A place in the text of a map.
struct Reader<'a> {
    text: &'a str,
    at: usize,
}

impl<'a> Reader<'a> {
    fn rest(&self) -> &'a str {
        self.text.get(self.at..).unwrap_or("")
    }

    fn skip_spaces(&mut self) {
        self.at += self.rest().len() - self.rest().trim_start().len();
    }

    fn take(&mut self, wanted: char) -> bool {
        self.skip_spaces();
        let there = self.rest().starts_with(wanted);
        self.at += if there { wanted.len_utf8() } else { 0 };
        there
    }

    fn fault(&self, what: String, range: Range<usize>) -> InputError {
        InputError::new(Path::new(ARGUMENT), what).at(self.text, range)
    }

    fn entry(&mut self) -> Result<Entry, InputError> {
        let start = self.at;
        let end = self.rest().find(['=', ',', ':']).unwrap_or(self.rest().len());
        let name = self.rest()[..end].trim();
        let signal = Signal::named(name).ok_or_else(|| {
            let what = match name {
                "" => "the name of a signal is missing".to_owned(),
                name => format!("unknown signal `{name}`"),
            };
            self.fault(what, start..start + end).help(format!("signals are: {}", Signal::names()))
        })?;
        self.at += end;
        if !self.take('=') {
            let what = format!("`{name}` has no column");
            let help = format!("write {name}=COLUMN or {name}=COLUMN:UNIT");
            return Err(self.fault(what, start..self.at).help(help));
        }
        let negative = self.take('-');
        let column = self.column(signal)?;
        let times = if self.take('*') { Some(self.column(signal)?) } else { None };
        let scaling = if self.take(':') { Some(self.scaling(signal)?) } else { None };
        let wrap = self.wrap(signal)?;
        Ok(Entry { signal, column, times, negative, scaling, wrap, optional: false })
    }

    /// A column's name: in quotes, or up to what ends it.
    fn column(&mut self, signal: Signal) -> Result<String, InputError> {
        self.skip_spaces();
        let start = self.at;
        let quote = self.rest().chars().next().filter(|c| matches!(c, '"' | '\'' | '`'));
        let name = match quote {
            Some(quote) => {
                let inner = &self.rest()[1..];
                let Some(end) = inner.find(quote) else {
                    let what = format!("the quote {quote} is not closed");
                    let help = "close the name of the column with the same quote";
                    return Err(self.fault(what, start..self.text.len()).help(help));
                };
                self.at += end + 2;
                inner[..end].to_owned()
            }
            None => {
                let end = self.rest().find([':', ',', '*']).unwrap_or(self.rest().len());
                let end = self.rest().find(WRAP).map_or(end, |wrap| wrap.min(end));
                let name = self.rest()[..end].trim_end();
                self.at += name.len();
                name.to_owned()
            }
        };
        if name.is_empty() {
            let what = format!("`{}` has no column", signal.key());
            let help = format!("write {0}=COLUMN or {0}=COLUMN:UNIT", signal.key());
            return Err(self.fault(what, start..self.at).help(help));
        }
        Ok(name)
    }

    fn scaling(&mut self, signal: Signal) -> Result<Scaling, InputError> {
        self.skip_spaces();
        let start = self.at;
        let end = self.rest().find(',').unwrap_or(self.rest().len());
        let end = self.rest().find(WRAP).map_or(end, |wrap| wrap.min(end));
        let text = self.rest()[..end].trim_end();
        self.at += text.len();
        Scaling::parse(signal.quantity(), text)
            .map_err(|(what, help)| self.fault(what, start..start + text.len()).help(help))
    }

    /// The period of an angle that wraps, behind everything else.
    fn wrap(&mut self, signal: Signal) -> Result<Option<f64>, InputError> {
        self.skip_spaces();
        let word = WRAP.trim_start();
        let Some(behind) = self.rest().strip_prefix(word) else { return Ok(None) };
        let start = self.at;
        let end = behind.find(',').unwrap_or(behind.len());
        self.at += word.len() + end;
        let range = start..self.at;
        let period = behind[..end].trim();
        match period.parse::<f64>() {
            Ok(period) if period.is_finite() && period > 0.0 => wrapping(signal, period)
                .map(Some)
                .map_err(|(what, help)| self.fault(what, range).help(help)),
            _ => Err(self
                .fault(format!("the period `{period}` is not a number above zero"), range)
                .help("write the number after which the column begins anew: wrap=65536")),
        }
    }
}

/// What stands before a period.
const WRAP: &str = " wrap=";

/// A period, where the signal is one that may begin anew.
pub(super) fn wrapping(signal: Signal, period: f64) -> Result<f64, (String, String)> {
    match signal.quantity() {
        Quantity::Angle | Quantity::Time => Ok(period),
        _ => Err((
            format!("`{}` is neither an angle nor a time and does not begin anew", signal.key()),
            "leave wrap out".to_owned(),
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(text: &str) -> Entry {
        Map::parse(text).unwrap_or_else(|error| panic!("{error}")).entries.remove(0)
    }

    #[test]
    fn an_entry_names_signal_column_unit_and_sign() {
        let map = Map::parse("t=time_ms:ms, i = -iq : A*1.22,motor=pos").unwrap();
        assert_eq!(
            map.entries.iter().map(|e| e.signal.key()).collect::<Vec<_>>(),
            ["t", "i", "motor"]
        );
        let current = &map.entries[1];
        assert_eq!((current.column.as_str(), current.negative), ("iq", true));
        assert_eq!(current.scaling.as_ref().unwrap().text(), "A*1.22");
        assert_eq!(map.entries[2].scaling, None);
    }

    #[test]
    fn a_column_is_quoted_where_its_name_has_signs_of_the_map() {
        assert_eq!(entry("i='I_q: filtered, 2*':A").column, "I_q: filtered, 2*");
        assert_eq!(entry("motor=\"-pos\":deg").column, "-pos");
        assert_eq!(entry("motor=position (deg):deg").column, "position (deg)");
        assert_eq!(
            entry("motor=axis0.encoder.pos_estimate:rev").column,
            "axis0.encoder.pos_estimate"
        );
        assert_eq!(entry("motor=#3:rev").column, "#3");
        assert_eq!(entry("motor_angle_rad=pos").signal, Signal::Motor);
    }

    #[test]
    fn a_product_and_a_period_are_read() {
        let product = entry("u=duty*vbus:V/100");
        assert_eq!((product.column.as_str(), product.times.as_deref()), ("duty", Some("vbus")));
        assert_eq!(entry("motor=pos:counts/4096 wrap=65536").wrap, Some(65536.0));
        assert_eq!(entry("motor=pos wrap=360").wrap, Some(360.0));
    }

    #[test]
    fn an_error_points_into_the_map() {
        let error = Map::parse("t=time, motor=pos:degg").unwrap_err().to_string();
        let expected = "--map:1:19: unknown unit `degg`\n   |\n 1 | t=time, motor=pos:degg\n   |                   ^^^^\n  help: units of angle are: rad, mrad, deg, arcmin, arcsec, rev, counts";
        assert_eq!(error, expected);
    }

    #[test]
    fn a_later_map_takes_the_place_of_an_earlier_ones_signals() {
        let first = Map::parse("t=a, i=b").unwrap();
        let both = first.overlaid(Map::parse("i=c, u=d").unwrap());
        let columns: Vec<&str> = both.entries.iter().map(|e| e.column.as_str()).collect();
        assert_eq!(columns, ["a", "c", "d"]);
    }
}
