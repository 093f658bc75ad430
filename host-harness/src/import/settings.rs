//! How a recording is read, beside which column is which.

use std::str::FromStr;

use serde::{Deserialize, Serialize};

use super::dialect::Separator;
use super::number::Decimal;

/// How a recording is read; everything may be left out.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// What separates fields, where the text does not tell.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub separator: Option<Separator>,
    /// The decimal sign, where the text does not tell.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub decimal: Option<Decimal>,
    /// Names of the columns, in the place of the text's own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub names: Option<Vec<String>>,
    /// Names of the columns of a text without a header: the list of as many names as it has columns.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub headerless: Vec<Vec<String>>,
    /// Rate of the rows, Hz, where no column is the time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate_hz: Option<f64>,
    /// Rate to interpolate to, Hz; as recorded where left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub resample_hz: Option<f64>,
    /// Whether an angle that jumps by a turn is made to go on; it is where left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unwrap: Option<bool>,
    /// Whether time begins at zero instead of as recorded.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub zero_time: bool,
    /// Whether a row with the time of the row before is left out instead of refused.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub drop_repeated: bool,
}

impl Settings {
    /// The same, with what `other` states in its place.
    #[must_use]
    pub fn overlaid(self, other: Settings) -> Self {
        Self {
            separator: other.separator.or(self.separator),
            decimal: other.decimal.or(self.decimal),
            names: other.names.or(self.names),
            headerless: if other.headerless.is_empty() {
                self.headerless
            } else {
                other.headerless
            },
            rate_hz: other.rate_hz.or(self.rate_hz),
            resample_hz: other.resample_hz.or(self.resample_hz),
            unwrap: other.unwrap.or(self.unwrap),
            zero_time: other.zero_time || self.zero_time,
            drop_repeated: other.drop_repeated || self.drop_repeated,
        }
    }
}

/// The words of separators in maps and on the command line.
const SEPARATORS: [(&str, Separator); 5] = [
    ("comma", Separator::Character(b',')),
    ("semicolon", Separator::Character(b';')),
    ("tab", Separator::Character(b'\t')),
    ("bar", Separator::Character(b'|')),
    ("space", Separator::Blank),
];

impl FromStr for Separator {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let named = SEPARATORS.iter().find(|(word, _)| *word == text);
        named.map(|(_, separator)| *separator).ok_or_else(|| {
            format!("a separator is one of {}", SEPARATORS.map(|(word, _)| word).join(", "))
        })
    }
}

impl Serialize for Separator {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let named = SEPARATORS.iter().find(|(_, separator)| separator == self);
        serializer.serialize_str(named.map_or("comma", |(word, _)| word))
    }
}

impl<'de> Deserialize<'de> for Separator {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(serde::de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_stated_later_counts_and_the_rest_stays() {
        let first = Settings { rate_hz: Some(1.0), unwrap: Some(true), ..Settings::default() };
        let later = Settings { unwrap: Some(false), zero_time: true, ..Settings::default() };
        let both = first.overlaid(later);
        assert_eq!((both.rate_hz, both.unwrap, both.zero_time), (Some(1.0), Some(false), true));
    }
}
