//! What the colours of several plots mean, above them on a page.

use std::fmt::Write;

use super::Ink;
use super::text::escape;

/// The sign of an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Legend {
    /// A field of this colour.
    Of(Ink),
    /// An upright line of this colour.
    Upright(Ink),
    /// A level line of this colour.
    Level(Ink),
    /// A dot, and a ring.
    Dot,
    /// A ring.
    Ring,
    /// A shaded part of a plot.
    Shade,
}

/// A line of entries.
pub fn legend(entries: &[(Legend, &str)]) -> String {
    let mut line = String::from("<p class=\"legend\">");
    for (sign, text) in entries {
        let class = match sign {
            Legend::Of(ink) => ink.class(),
            Legend::Upright(ink) => format!("upright {}", ink.class()),
            Legend::Level(ink) => format!("level {}", ink.class()),
            Legend::Dot => "round soft".to_owned(),
            Legend::Ring => "round ring soft".to_owned(),
            Legend::Shade => "shade".to_owned(),
        };
        let _ = write!(line, "<span><i class=\"key {class}\"></i>{}</span> ", escape(text));
    }
    line.push_str("</p>\n");
    line
}

impl Ink {
    /// Its class in the stylesheet.
    pub(super) fn class(self) -> String {
        match self {
            Ink::Before => "before".to_owned(),
            Ink::After => "after".to_owned(),
            Ink::Text => "ink".to_owned(),
            Ink::Soft => "soft".to_owned(),
            Ink::Faint => "faint".to_owned(),
            Ink::Wrong => "wrong".to_owned(),
            Ink::Nth(n) => format!("nth{}", n % 8),
        }
    }
}
