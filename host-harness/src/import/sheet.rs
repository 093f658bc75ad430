//! A table of numbers in a text, read column by column.
//!
//! Only columns that a map asks for are read as numbers: a recording may hold names of states and
//! fault texts beside them.

use std::path::{Path, PathBuf};

use super::dialect::{Dialect, Line, Separator, bare, lines, trimmed};
use super::number::{Decimal, Numbers};
use super::unit::{Quantity, Scaling};
use crate::fault::InputError;

/// What a user states of a text, where it is not to be told from the text itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stated {
    /// What separates fields.
    pub separator: Option<Separator>,
    /// What separates the whole of a number from the rest.
    pub decimal: Option<Decimal>,
    /// Names of the columns, in the place of the text's own.
    pub names: Option<Vec<String>>,
}

/// A table in a text.
#[derive(Clone, Debug)]
pub struct Sheet<'a> {
    path: PathBuf,
    dialect: Dialect,
    decimal: Option<Decimal>,
    rows: Vec<Line<'a>>,
    /// What was noticed, a sentence each.
    pub notes: Vec<String>,
}

/// Columns as numbers, NaN where a value is missing.
#[derive(Clone, Debug, PartialEq)]
pub struct Columns {
    /// The line of each row, from 1.
    pub lines: Vec<u64>,
    /// The columns, in the order in which they were asked for.
    pub columns: Vec<Vec<f64>>,
}

impl<'a> Sheet<'a> {
    /// Finds the table in a text; `path` is what errors call it.
    ///
    /// # Errors
    /// There is none.
    pub fn find(text: &'a str, path: &Path, stated: &Stated) -> Result<Self, InputError> {
        let (rows, comments) = lines(text);
        let fault = |what: &str| InputError::new(path, what);
        if rows.is_empty() {
            return Err(fault("is empty").help("a recording is a header row and then numbers"));
        }
        let dialect = Dialect::told(&rows, &comments, stated.separator).ok_or_else(|| {
            let (line, first) = rows[0];
            let shown: String = first.chars().take(60).collect();
            fault(&format!("holds no row of numbers; it begins `{shown}`"))
                .at_line(line)
                .help("export the recording as a table of numbers, one row a sample; say with --separator what separates its fields")
        })?;
        let mut sheet = Self {
            path: path.to_owned(),
            rows: rows.into_iter().filter(|(line, _)| *line >= dialect.first_row).collect(),
            dialect,
            decimal: stated.decimal,
            notes: Vec::new(),
        };
        if let Some(names) = &stated.names {
            let width = trimmed(&sheet.dialect.separator.split(sheet.rows[0].1));
            if names.len() != width {
                let (named, line) = (names.len(), sheet.dialect.first_row);
                return Err(fault(&format!(
                    "has {width} columns, and --names gives {named} names"
                ))
                .at_line(line)
                .help("name every column; a name that no map uses may be anything"));
            }
            sheet.dialect.names.clone_from(names);
        }
        sheet.drop_a_cut_row();
        Ok(sheet)
    }

    /// A recorder that is switched off leaves half a row.
    fn drop_a_cut_row(&mut self) {
        let separator = self.dialect.separator;
        let width = |line: &Line<'_>| separator.split(line.1).len();
        let [.., before, last] = &self.rows[..] else { return };
        let (before, cut, line) = (width(before), width(last), last.0);
        if self.rows.len() > 2 && cut < before {
            self.notes
                .push(format!("line {line} is cut short ({cut} of {before} fields) and left out"));
            self.rows.pop();
        }
    }

    /// Names the columns of a text without a header by the list that has as many; says whether it did.
    pub fn name(&mut self, lists: &[Vec<String>]) -> bool {
        let width = self.names().len();
        let list = lists.iter().find(|list| list.len() == width);
        if let Some(list) = list.filter(|_| self.dialect.names.is_empty()) {
            self.dialect.names.clone_from(list);
        }
        !self.dialect.names.is_empty()
    }

    /// The line with the names of the columns, or the first of the numbers.
    pub fn header_line(&self) -> u64 {
        self.dialect.header_line.unwrap_or(self.dialect.first_row)
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Names of the columns; `#1`, `#2` where the text gives none.
    pub fn names(&self) -> Vec<String> {
        let width = match trimmed(&self.dialect.names) {
            0 => self.rows.first().map_or(0, |row| trimmed(&self.dialect.separator.split(row.1))),
            named => named,
        };
        (0..width)
            .map(|k| match self.dialect.names.get(k) {
                Some(name) if !name.is_empty() => name.clone(),
                _ => format!("#{}", k + 1),
            })
            .collect()
    }

    /// The columns' names on one line, for a message.
    pub fn listed(&self) -> String {
        let names = self.names();
        let shown =
            names.iter().take(MOST_LISTED).map(String::as_str).collect::<Vec<_>>().join(", ");
        match names.len().saturating_sub(MOST_LISTED) {
            0 => format!("columns are: {shown}"),
            more => format!("columns are: {shown} and {more} more"),
        }
    }

    /// The place of a column: by `#N`, by its name, by its name without a unit in brackets, or by
    /// the end of its path (`axis0.encoder.pos_estimate` of `odrv0.axis0.encoder.pos_estimate`).
    ///
    /// # Errors
    /// What to say where there is none or more than one; `None` where there is none.
    pub fn position(&self, wanted: &str) -> Result<Option<usize>, String> {
        let names = self.names();
        if let Some(number) = wanted.strip_prefix('#').and_then(|text| text.parse::<usize>().ok()) {
            return Ok(number.checked_sub(1).filter(|k| *k < names.len()));
        }
        let ends = |name: &str| {
            let before = name.strip_suffix(wanted).unwrap_or("");
            before.ends_with(['.', '/'])
        };
        let same = |name: &str| name == wanted;
        let apart = |name: &str| without_unit(name).0 == wanted;
        for fits in [&same as &dyn Fn(&str) -> bool, &apart, &ends] {
            let found: Vec<usize> =
                (0..names.len()).filter(|k| names.get(*k).is_some_and(|name| fits(name))).collect();
            match found[..] {
                [] => {}
                [only] => return Ok(Some(only)),
                [first, second, ..] => {
                    return Err(format!(
                        "`{wanted}` fits more than one column: number {} `{}` and number {} `{}`",
                        first + 1,
                        names[first],
                        second + 1,
                        names[second]
                    ));
                }
            }
        }
        Ok(None)
    }

    /// The unit that the file gives a column: in a row of units, in brackets behind the name, or as
    /// the end of the name.
    pub fn unit(&self, at: usize, quantity: Quantity) -> Option<Scaling> {
        let names = self.names();
        let name = names.get(at)?;
        let row = self.dialect.units.get(at).map(|unit| bare(unit));
        let end = name.rsplit_once(['_', ' ']).map(|(_, end)| end);
        let upper = end.and_then(|end| lower_case_unit(quantity, end));
        [row, without_unit(name).1, end, upper]
            .into_iter()
            .flatten()
            .find_map(|unit| Scaling::plain(quantity, unit))
    }

    /// Reads columns as numbers.
    ///
    /// # Errors
    /// A row with another number of fields, or a field that is no number.
    pub fn read(&self, wanted: &[usize]) -> Result<Columns, InputError> {
        let separator = self.dialect.separator;
        let names = self.names();
        let width = names.len();
        let fault = |what: String| InputError::new(&self.path, what);
        let mut numbers =
            Numbers { decimal: self.decimal, comma_is_free: separator.leaves_comma() };
        let mut columns = vec![Vec::with_capacity(self.rows.len()); wanted.len()];
        let mut lines = Vec::with_capacity(self.rows.len());
        let mut text = String::new();
        let mut numbered = Vec::with_capacity(self.rows.len());
        for (line, row) in &self.rows {
            match separator {
                Separator::Blank => {
                    text.push_str(&row.split_whitespace().collect::<Vec<_>>().join("\t"));
                }
                Separator::Character(_) => text.push_str(row),
            }
            text.push('\n');
            numbered.push(*line);
        }
        let delimiter = match separator {
            Separator::Character(byte) => byte,
            Separator::Blank => b'\t',
        };
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .delimiter(delimiter)
            .trim(csv::Trim::All)
            .from_reader(text.as_bytes());
        let mut record = csv::StringRecord::new();
        loop {
            let row = reader.position().line().saturating_sub(1) as usize;
            let line = numbered.get(row).copied().unwrap_or_default();
            let more = reader.read_record(&mut record).map_err(|error| {
                fault(format!("cannot be read: {error}"))
                    .at_line(line)
                    .help("export the recording as CSV again")
            })?;
            if !more {
                break;
            }
            let empty_end = record.len() == width + 1 && record.get(width) == Some("");
            if record.len() != width && !empty_end {
                return Err(self.another_width(record.len(), width).at_line(line));
            }
            for (column, at) in columns.iter_mut().zip(wanted) {
                let field = record.get(*at).unwrap_or("");
                let value = numbers.read(field).map_err(|(what, help)| {
                    fault(format!("column {}: `{field}` {what}", names[*at]))
                        .at_line(line)
                        .help(help)
                })?;
                column.push(value);
            }
            lines.push(line);
        }
        Ok(Columns { lines, columns })
    }

    fn another_width(&self, has: usize, wants: usize) -> InputError {
        let word = self.dialect.separator.word();
        let error = InputError::new(
            &self.path,
            format!("the row has {has} fields between {word}, the table {wants}"),
        );
        let commas = self.dialect.separator == Separator::Character(b',');
        error.help(match has {
            _ if commas && has == 2 * wants => {
                "are these decimal commas between commas? export with semicolons, or with decimal points"
            }
            _ => "complete the row, with empty fields where values are missing, or remove it",
        })
    }
}

/// How many columns a message lists.
const MOST_LISTED: usize = 40;

/// A column's name and the unit in brackets behind it.
fn without_unit(name: &str) -> (&str, Option<&str>) {
    let close = |open: char| if open == '[' { ']' } else { ')' };
    let found = ['[', '('].into_iter().find_map(|open| {
        let (before, unit) = name.strip_suffix(close(open))?.rsplit_once(open)?;
        Some((before.trim(), Some(unit.trim())))
    });
    found.unwrap_or((name, None))
}

/// Units as ends of names in lower case: `i_ma`, `u_mv`, `torque_nm`.
fn lower_case_unit(quantity: Quantity, end: &str) -> Option<&'static str> {
    let unit = match (quantity, end) {
        (Quantity::Voltage, "v") => "V",
        (Quantity::Voltage, "mv") => "mV",
        (Quantity::Current, "a") => "A",
        (Quantity::Current, "ma") => "mA",
        (Quantity::Torque, "nm") => "Nm",
        (Quantity::Torque, "mnm") => "mNm",
        (Quantity::Temperature, "c" | "degc") => "C",
        (Quantity::Temperature, "k") => "K",
        _ => return None,
    };
    Some(unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sheet(text: &str) -> Sheet<'_> {
        Sheet::find(text, Path::new("raw.csv"), &Stated::default())
            .unwrap_or_else(|error| panic!("{error}"))
    }

    #[test]
    fn a_column_is_found_by_number_name_bare_name_and_end_of_path() {
        let sheet = sheet("odrv0.axis0.pos,time [ms],i (A),i\n1,2,3,4\n2,3,4,5\n");
        assert_eq!(sheet.position("#2"), Ok(Some(1)));
        assert_eq!(sheet.position("time [ms]"), Ok(Some(1)));
        assert_eq!(sheet.position("time"), Ok(Some(1)));
        assert_eq!(sheet.position("i"), Ok(Some(3)), "the exact name goes first");
        assert_eq!(sheet.position("axis0.pos"), Ok(Some(0)));
        assert_eq!(sheet.position("xis0.pos"), Ok(None), "not a whole part of the path");
        assert_eq!(sheet.position("#5"), Ok(None));
        assert_eq!(sheet.position("#0"), Ok(None));
    }

    #[test]
    fn a_name_that_fits_twice_is_refused() {
        let two = sheet("a.pos,b.pos\n1,2\n2,3\n").position("pos").unwrap_err();
        assert_eq!(two, "`pos` fits more than one column: number 1 `a.pos` and number 2 `b.pos`");
    }

    #[test]
    fn units_come_from_their_row_from_brackets_and_from_the_end_of_a_name() {
        let text = |at: usize, quantity| {
            let sheet = sheet("t,i [mA],out_deg,u_mv,t_ms\nms,-,-,-,-\n1,2,3,4,5\n2,3,4,5,6\n");
            sheet.unit(at, quantity).map(|unit| unit.text().to_owned())
        };
        assert_eq!(text(0, Quantity::Time).as_deref(), Some("ms"));
        assert_eq!(text(1, Quantity::Current).as_deref(), Some("mA"));
        assert_eq!(text(2, Quantity::Angle).as_deref(), Some("deg"));
        assert_eq!(text(3, Quantity::Voltage).as_deref(), Some("mV"));
        assert_eq!(text(1, Quantity::Voltage), None, "a unit of something else");
    }

    #[test]
    fn a_last_row_that_is_cut_short_is_left_out_and_told() {
        let sheet = sheet("a,b\n1,2\n2,3\n3\n");
        assert_eq!(sheet.len(), 2);
        assert_eq!(sheet.notes, ["line 4 is cut short (1 of 2 fields) and left out"]);
    }

    #[test]
    fn rows_may_end_in_a_separator_and_lines_are_counted_past_comments() {
        let sheet = sheet("a;b;\n1;2;\n\n# here\n2;3,5;\n");
        let columns = sheet.read(&[1]).unwrap();
        assert_eq!((columns.lines, columns.columns), (vec![2, 5], vec![vec![2.0, 3.5]]));
    }
}
