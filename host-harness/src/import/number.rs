//! A number as recorders write it: with a decimal point or comma, or as a word for none.

use serde::{Deserialize, Serialize};

/// What stands between the whole of a number and the rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Decimal {
    /// A point.
    Point,
    /// A comma.
    Comma,
}

impl Decimal {
    fn word(self) -> &'static str {
        match self {
            Decimal::Point => "a decimal point",
            Decimal::Comma => "a decimal comma",
        }
    }
}

/// Words for a value that is not there.
const MISSING: [&str; 8] = ["", "nan", "na", "n/a", "null", "none", "-", "--"];

/// Reads fields one after another, all with the same decimal sign.
#[derive(Clone, Copy, Debug)]
pub struct Numbers {
    /// What was stated or seen so far.
    pub decimal: Option<Decimal>,
    /// Whether a comma can be one: not where it separates fields.
    pub comma_is_free: bool,
}

impl Numbers {
    /// A field's value, NaN where it is missing, or what is wrong with it and what to do.
    pub fn read(&mut self, text: &str) -> Result<f64, (String, &'static str)> {
        if Self::is_missing(text) {
            return Ok(f64::NAN);
        }
        let used = match (text.contains('.'), text.contains(',') && self.comma_is_free) {
            (true, true) => {
                return Err((
                    "has both a point and a comma".to_owned(),
                    "export without a separator of thousands",
                ));
            }
            (true, false) => Some(Decimal::Point),
            (false, true) => Some(Decimal::Comma),
            (false, false) => None,
        };
        match (self.decimal, used) {
            (Some(before), Some(used)) if before != used => {
                return Err((
                    format!("has {}, and the numbers before it {}", used.word(), before.word()),
                    "say which one it is with --decimal, and export without a separator of thousands",
                ));
            }
            (_, Some(used)) => self.decimal = Some(used),
            (_, None) => {}
        }
        let parsed = match used {
            Some(Decimal::Comma) => text.replacen(',', ".", 1).parse::<f64>(),
            _ => text.parse::<f64>(),
        };
        match parsed {
            Ok(value) if value.is_finite() => Ok(value),
            Ok(_) => Err(("is not a finite number".to_owned(), LEAVE_EMPTY)),
            Err(_) if text.contains(':') => Err((
                "is a time of day".to_owned(),
                "export the time as a number of seconds, milliseconds or microseconds",
            )),
            Err(_) => Err(("is not a number".to_owned(), LEAVE_EMPTY)),
        }
    }

    /// Whether a field is a number in either way of writing, and not a missing one.
    pub fn looks_like(text: &str, comma_is_free: bool) -> bool {
        Self { decimal: None, comma_is_free }.read(text).is_ok_and(f64::is_finite)
    }

    /// Whether a field holds nothing, or a word for nothing.
    pub fn is_missing(text: &str) -> bool {
        MISSING.iter().any(|word| text.eq_ignore_ascii_case(word))
    }
}

const LEAVE_EMPTY: &str = "mend the field, or leave it empty where the value is missing";

#[cfg(test)]
mod tests {
    use super::*;

    fn read(fields: &[&str], comma_is_free: bool) -> Result<Vec<f64>, String> {
        let mut numbers = Numbers { decimal: None, comma_is_free };
        fields.iter().map(|field| numbers.read(field).map_err(|(what, _)| what)).collect()
    }

    #[test]
    fn point_or_comma_is_seen_from_the_first_number_that_has_one() {
        assert_eq!(read(&["1", "-2,5", "3e-3", "1,5e2"], true), Ok(vec![1.0, -2.5, 0.003, 150.0]));
        assert_eq!(read(&["1", "-2.5", "+3"], true), Ok(vec![1.0, -2.5, 3.0]));
    }

    #[test]
    fn thousands_are_not_guessed() {
        assert_eq!(
            read(&["12.5", "1,234"], true),
            Err("has a decimal comma, and the numbers before it a decimal point".to_owned())
        );
        assert_eq!(read(&["1.234,5"], true), Err("has both a point and a comma".to_owned()));
    }

    #[test]
    fn words_for_nothing_are_missing_values_and_infinity_is_an_error() {
        let values = read(&["", "NaN", "NA", "null", "None", "-"], true).unwrap();
        assert!(values.iter().all(|value| value.is_nan()));
        assert!(read(&["inf"], true).is_err() && read(&["1e999"], true).is_err());
        assert_eq!(read(&["12:30:01.5"], true), Err("is a time of day".to_owned()));
        assert_eq!(read(&["0x10"], true), Err("is not a number".to_owned()));
    }
}
