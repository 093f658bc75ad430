//! In which way of writing a table stands in a text: what separates its fields, which row names the
//! columns, which one their units, and where the numbers begin.
//!
//! Told from the text itself, since the person who has it did not choose it: instruments write
//! preambles, spreadsheets of half of Europe write semicolons and decimal commas, serial monitors
//! write no header at all.

use std::collections::BTreeMap;

use super::number::Numbers;
use super::unit::Unit;

/// What separates the fields of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Separator {
    /// One character.
    Character(u8),
    /// Any number of spaces and tabs.
    Blank,
}

impl Separator {
    /// Candidates, the less ambiguous first.
    const ALL: [Self; 5] = [
        Self::Character(b';'),
        Self::Character(b'\t'),
        Self::Character(b','),
        Self::Character(b'|'),
        Self::Blank,
    ];

    /// Its word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Character(b';') => "semicolons",
            Self::Character(b'\t') => "tabs",
            Self::Character(b'|') => "bars",
            Self::Character(_) => "commas",
            Self::Blank => "spaces",
        }
    }

    /// Whether a comma in a field can be a decimal comma.
    pub fn leaves_comma(self) -> bool {
        self != Self::Character(b',')
    }

    /// The fields of a line, quotes and spaces around them taken off.
    pub fn split(self, line: &str) -> Vec<String> {
        match self {
            Self::Blank => line.split_whitespace().map(str::to_owned).collect(),
            Self::Character(byte) => {
                let mut reader = csv::ReaderBuilder::new()
                    .has_headers(false)
                    .delimiter(byte)
                    .trim(csv::Trim::All)
                    .from_reader(line.as_bytes());
                let record = reader.records().next().and_then(Result::ok).unwrap_or_default();
                record.iter().map(str::to_owned).collect()
            }
        }
    }
}

/// A line of the text that is neither empty nor a comment, with its number from 1.
pub type Line<'a> = (u64, &'a str);

/// How a table stands in its text.
#[derive(Clone, Debug, PartialEq)]
pub struct Dialect {
    /// What separates fields.
    pub separator: Separator,
    /// Names of the columns; empty where the text has none.
    pub names: Vec<String>,
    /// Where they stand.
    pub header_line: Option<u64>,
    /// The row of units, empty where there is none.
    pub units: Vec<String>,
    /// Line of the first row of numbers.
    pub first_row: u64,
}

/// How many lines are looked at to tell a dialect.
const LOOKED_AT: usize = 400;

/// Lines that are neither empty nor comments, and the comments.
pub fn lines(text: &str) -> (Vec<Line<'_>>, Vec<Line<'_>>) {
    let numbered = text.lines().enumerate().map(|(k, line)| (k as u64 + 1, line));
    numbered.filter(|(_, line)| !line.trim().is_empty()).partition(|(_, line)| !is_comment(line))
}

fn is_comment(line: &str) -> bool {
    let line = line.trim_start();
    line.starts_with(['#', '%']) || line.starts_with("//")
}

impl Dialect {
    /// What the lines of a text say; `None` where no row of them holds numbers.
    pub fn told(
        rows: &[Line<'_>],
        comments: &[Line<'_>],
        stated: Option<Separator>,
    ) -> Option<Self> {
        let looked = &rows[..rows.len().min(LOOKED_AT)];
        let separator = match stated {
            Some(separator) => separator,
            None => separator_of(looked),
        };
        let split: Vec<Vec<String>> =
            looked.iter().map(|(_, line)| separator.split(line)).collect();
        let first = first_of_numbers(&split, separator.leaves_comma())?;
        let first_row = looked[first].0;
        let none = || Self {
            separator,
            names: Vec::new(),
            header_line: None,
            units: Vec::new(),
            first_row,
        };
        // The header is the row before the numbers, or the one before a row of units.
        if let Some(before) = first.checked_sub(1) {
            let (mut header, mut units) = (before, Vec::new());
            if before > 0 && are_units(&split[before]) && fits(&split[before - 1], &split[before]) {
                (header, units) = (before - 1, split[before].clone());
            }
            let (names, header_line) = (split[header].clone(), Some(looked[header].0));
            if trimmed(&names) < 2 && trimmed(&split[first]) > 1 {
                return Some(none());
            }
            return Some(Self { names, header_line, units, ..none() });
        }
        // Some write the names into a comment, as numpy.savetxt does.
        let uncommented =
            |line: &str| separator.split(line.trim_start_matches(['#', '%', '/', ' ']));
        let named = comments.iter().rev().filter(|(number, _)| *number < first_row);
        let mut named = named.map(|(number, line)| (*number, uncommented(line)));
        let header = named.next().filter(|(_, names)| fits(names, &split[first]));
        Some(match header {
            Some((line, names)) if names.len() > 1 => {
                Self { names, header_line: Some(line), ..none() }
            }
            _ => none(),
        })
    }
}

/// Whether two rows have as many fields, one that ends in a separator counted without it.
fn fits(one: &[String], other: &[String]) -> bool {
    one.len() == other.len() || trimmed(one) == trimmed(other)
}

/// Number of fields, without an empty one at the end.
pub fn trimmed(fields: &[String]) -> usize {
    fields.len() - usize::from(fields.last().is_some_and(String::is_empty))
}

/// The first row of the table's numbers. It is as wide as most rows, and most of what is in it are
/// numbers; where half is, they stand where a late row has them: `Record length,10000` is a preamble.
fn first_of_numbers(split: &[Vec<String>], comma_is_free: bool) -> Option<usize> {
    let (width, _) = commonest_width(split)?;
    let number = |field: &String| Numbers::looks_like(field, comma_is_free);
    let late = split.iter().rev().find(|fields| trimmed(fields) == width)?;
    split.iter().position(|fields| {
        let filled = fields.iter().filter(|field| !Numbers::is_missing(field)).count();
        let numbers = fields.iter().filter(|field| number(field)).count();
        let alike = |(own, late): (&String, &String)| {
            Numbers::is_missing(own) || Numbers::is_missing(late) || number(own) == number(late)
        };
        let as_wide = trimmed(fields) == width || fields.len() == late.len();
        let half = 2 * numbers == filled && fields.iter().zip(late).all(alike);
        numbers > 0 && as_wide && (2 * numbers > filled || half)
    })
}

/// The number of fields that most rows have, and how many rows those are.
fn commonest_width(split: &[Vec<String>]) -> Option<(usize, usize)> {
    let mut widths = BTreeMap::new();
    for fields in split {
        *widths.entry(trimmed(fields)).or_insert(0_usize) += 1;
    }
    widths.into_iter().max_by_key(|(_, rows)| *rows)
}

/// Whether a row is one of units: nothing else in it, and at least one that is known.
fn are_units(fields: &[String]) -> bool {
    let known = |field: &&String| Unit::is_known(bare(field));
    let odd = |field: &&String| {
        let bare = bare(field);
        !bare.is_empty() && bare != "-" && !Unit::is_known(bare) && bare.chars().count() > 6
    };
    fields.iter().any(|field| known(&field)) && !fields.iter().any(|field| odd(&field))
}

/// A unit without the brackets around it.
pub fn bare(unit: &str) -> &str {
    unit.trim().trim_start_matches(['[', '(']).trim_end_matches([']', ')']).trim()
}

/// What separates most rows into the same number of fields: semicolons, tabs and bars where they do,
/// since numbers hold none; else commas or spaces, whichever leaves more fields as numbers.
fn separator_of(rows: &[Line<'_>]) -> Separator {
    let mut best = (0.0, Separator::Character(b','));
    for separator in Separator::ALL {
        let split: Vec<Vec<String>> = rows.iter().map(|(_, line)| separator.split(line)).collect();
        let Some((width, alike)) = commonest_width(&split) else { continue };
        if width < 2 || 2 * alike <= split.len() {
            continue;
        }
        if !matches!(separator, Separator::Character(b',') | Separator::Blank) {
            return separator;
        }
        let (mut numbers, mut filled) = (0_usize, 0_usize);
        for field in split.iter().flatten().filter(|field| !Numbers::is_missing(field)) {
            filled += 1;
            numbers += usize::from(Numbers::looks_like(field, separator.leaves_comma()));
        }
        let share = numbers as f64 / filled.max(1) as f64;
        if share > best.0 {
            best = (share, separator);
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(text: &str) -> Dialect {
        let (rows, comments) = lines(text);
        Dialect::told(&rows, &comments, None).unwrap()
    }

    #[test]
    fn each_separator_is_told_from_the_numbers_between() {
        for (separator, word) in
            [(";", "semicolons"), ("\t", "tabs"), (",", "commas"), ("|", "bars"), ("  ", "spaces")]
        {
            let text = "t,i,pos\n0,1.5,2\n1,2.5,3\n".replace(',', separator);
            let dialect = told(&text);
            assert_eq!(dialect.separator.word(), word);
            assert_eq!(dialect.names, ["t", "i", "pos"]);
            assert_eq!((dialect.header_line, dialect.first_row), (Some(1), 2));
        }
    }

    #[test]
    fn decimal_commas_are_no_separators() {
        assert_eq!(told("t;i\n0,0;1,5\n0,1;2,5\n").separator.word(), "semicolons");
        assert_eq!(told("t\ti\n0,0\t1,5\n0,1\t2,5\n").separator.word(), "tabs");
        assert_eq!(told("t i\n0,0 1,5\n0,1 2,5\n").separator.word(), "spaces");
    }

    #[test]
    fn preambles_comments_blank_lines_and_a_row_of_units_are_seen() {
        let text = "Recorder 7, serial 12\n\n% by hand\nt,i,pos\n[ms],(mA),-\n\n0,1,2\n1,2,3\n";
        let dialect = told(text);
        assert_eq!(dialect.names, ["t", "i", "pos"]);
        assert_eq!(dialect.units, ["[ms]", "(mA)", "-"]);
        assert_eq!((dialect.header_line, dialect.first_row), (Some(4), 7));
    }

    #[test]
    fn numbers_in_a_preamble_are_not_the_table() {
        let scope = "Model,DS1054\nRecord length,3\nInterval,0.001\nt,i\ns,A\n0,1\n1,2\n2,3\n";
        let dialect = told(scope);
        assert_eq!((dialect.names, dialect.first_row), (vec!["t".into(), "i".into()], 6));
        assert_eq!(dialect.units, ["s", "A"]);
        let wide = "Record length,3\nt,i,pos\n0,1,hot\n1,2,3\n2,3,4\n";
        assert_eq!(told(wide).first_row, 3, "a bad field in the first row stays one");
        assert_eq!(told("t,a,i,b\n0,run,1,ok\n1,run,2,ok\n").first_row, 2, "half of it text");
    }

    #[test]
    fn names_in_a_comment_are_taken_where_there_is_no_header() {
        let dialect = told("# made by a script\n# t, i\n0,1\n1,2\n");
        assert_eq!((dialect.names, dialect.header_line), (vec!["t".into(), "i".into()], Some(2)));
        assert!(told("# made by a script\n0,1\n1,2\n").names.is_empty());
        assert!(told("0\t1\n1\t2\n").names.is_empty());
    }

    #[test]
    fn text_columns_do_not_hide_the_numbers() {
        let dialect = told("t;state;i\n0,5;idle;1,5\n0,6;run;2,5\n");
        assert_eq!((dialect.separator.word(), dialect.first_row), ("semicolons", 2));
        let (rows, comments) = lines("a,b\nc,d\n");
        assert_eq!(Dialect::told(&rows, &comments, None), None);
    }
}
