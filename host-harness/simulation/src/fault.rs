//! What is wrong with an input file, and where.
//!
//! A file written by hand or by another tool is wrong often, and the person who has to mend it sees
//! only the message. So every error about an input carries the file, the place in it, the line as
//! it stands there, and what to do.

use std::fmt;
use std::ops::Range;
use std::path::Path;

use crate::standard;

/// An error in an input file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InputError {
    file: String,
    place: Option<Place>,
    what: String,
    help: Option<String>,
}

/// Where in the file, with lines and columns from 1.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Place {
    line: u64,
    excerpt: Option<Excerpt>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct Excerpt {
    column: usize,
    text: String,
    width: usize,
}

impl InputError {
    /// An error about a file as a whole.
    pub fn new(file: &Path, what: impl Into<String>) -> Self {
        Self { file: standard::name(file), place: None, what: what.into(), help: None }
    }

    /// The file cannot be read.
    pub fn unreadable(file: &Path, error: &std::io::Error) -> Self {
        let help = match error.kind() {
            std::io::ErrorKind::NotFound => "check the path",
            std::io::ErrorKind::PermissionDenied => "make the file readable",
            _ => "check the file",
        };
        Self::new(file, format!("cannot be read: {error}")).help(help)
    }

    /// Points at a line, counted from 1.
    #[must_use]
    pub fn at_line(mut self, line: u64) -> Self {
        self.place = Some(Place { line, excerpt: None });
        self
    }

    /// Points at a range of bytes of the file's text and shows its line.
    #[must_use]
    pub fn at(mut self, text: &str, range: Range<usize>) -> Self {
        let mut start = range.start.min(text.len());
        while !text.is_char_boundary(start) {
            start -= 1;
        }
        let (before, after) = text.split_at(start);
        let line_start = before.rfind('\n').map_or(0, |at| at + 1);
        let line_end = start + after.find('\n').unwrap_or(after.len());
        let line = &text[line_start..line_end];
        let marked = text.get(start..range.end.clamp(start, line_end)).unwrap_or("");
        self.place = Some(Place {
            line: before.matches('\n').count() as u64 + 1,
            excerpt: Some(Excerpt {
                column: text[line_start..start].chars().count() + 1,
                text: line.trim_end().to_owned(),
                width: marked.trim_end().chars().count().max(1),
            }),
        });
        self
    }

    /// Says what to do.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }
}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.file)?;
        if let Some(place) = &self.place {
            write!(f, ":{}", place.line)?;
            if let Some(excerpt) = &place.excerpt {
                write!(f, ":{}", excerpt.column)?;
            }
        }
        write!(f, ": {}", self.what)?;
        if let Some(Place { line, excerpt: Some(excerpt) }) = &self.place {
            let number = line.to_string();
            let margin = " ".repeat(number.len());
            let indent: String = excerpt
                .text
                .chars()
                .take(excerpt.column - 1)
                .map(|c| if c == '\t' { '\t' } else { ' ' })
                .collect();
            write!(f, "\n {margin} |\n {number} | {}", excerpt.text)?;
            write!(f, "\n {margin} | {indent}{}", "^".repeat(excerpt.width))?;
        }
        if let Some(help) = &self.help {
            write!(f, "\n  help: {help}")?;
        }
        Ok(())
    }
}

impl std::error::Error for InputError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_is_shown_with_its_place_marked() {
        let text = "one\ntwo µ = 3\nthree\n";
        let start = text.find('3').unwrap();
        let error = InputError::new(Path::new("a.toml"), "wrong").at(text, start..start + 1);
        let expected = "a.toml:2:9: wrong\n   |\n 2 | two µ = 3\n   |         ^";
        assert_eq!(error.to_string(), expected);
    }

    #[test]
    fn a_range_past_the_end_or_inside_a_character_is_no_panic() {
        for range in [0..0, 1..2, 2..900, 900..901, Range { start: 3, end: 1 }] {
            let error = InputError::new(Path::new("a"), "wrong").at("aµ", range);
            assert!(error.to_string().starts_with("a:1:"));
        }
    }
}
