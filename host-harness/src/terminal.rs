//! Text for the width of a terminal.
//!
//! A terminal breaks a long line in the middle of a word and a table's row under another column. Lines are
//! broken at spaces instead, with what follows indented below; a shell's command goes on with a backslash,
//! so that it can still be copied. What goes to a file or a pipe stays as it is.

/// Longest line of a help, however wide the terminal.
const WIDEST_HELP: usize = 100;

/// Columns of the terminal that standard output is; `None` where it is none.
pub(crate) fn width() -> Option<usize> {
    let terminal = terminal_size::terminal_size_of(std::io::stdout());
    terminal.map(|(width, _)| usize::from(width.0)).filter(|width| *width > 0)
}

/// Columns of a help: the terminal's, or what `COLUMNS` says where there is none.
pub(crate) fn help_width() -> usize {
    let stated = || std::env::var("COLUMNS").ok().and_then(|text| text.parse().ok());
    width().or_else(stated).filter(|width| *width > 0).unwrap_or(WIDEST_HELP).min(WIDEST_HELP)
}

/// The text with no line longer than a width, where its words are not.
pub(crate) fn wrapped(text: &str, width: usize) -> String {
    each_line(text, |line| broken(line, width, indent_of(line) + 2, ""))
}

/// Commands, each on its line, that go on in a next line where they are longer than a width.
pub(crate) fn commands(text: &str, width: usize) -> String {
    each_line(text, |line| broken(line, width, indent_of(line) + 4, " \\"))
}

/// A name and what is said of it, in two columns.
pub(crate) fn row(name: &str, column: usize, what: &str, width: usize) -> String {
    broken(&format!("  {name:<column$}  {what}"), width, column + 4, "")
}

fn each_line(text: &str, of: impl Fn(&str) -> String) -> String {
    text.split('\n').map(of).collect::<Vec<_>>().join("\n")
}

fn indent_of(line: &str) -> usize {
    line.len() - line.trim_start_matches(' ').len()
}

/// A line broken at spaces outside of quotes, what follows indented, each line but the last ended by a mark.
fn broken(line: &str, width: usize, indent: usize, mark: &str) -> String {
    let length = |text: &str| text.chars().count();
    if length(line) <= width || line.ends_with('\\') {
        return line.to_owned();
    }
    let indent = if indent + 20 > width { 2 } else { indent };
    let (mut text, mut current) = (String::new(), String::new());
    for word in words(line) {
        // A space and the mark come behind it, unless it is the last: then there is one column to spare.
        let fits = length(&current) + length(word) + mark.len() <= width;
        if !fits && !current.trim().is_empty() {
            text.push_str(current.trim_end());
            text.push_str(mark);
            text.push('\n');
            current = " ".repeat(indent);
            current.push_str(word.trim_start());
        } else {
            current.push_str(word);
        }
    }
    text + current.trim_end()
}

/// Pieces of a line, each a word with the spaces before it; what is in quotes is one word.
fn words(line: &str) -> Vec<&str> {
    let (mut all, mut start, mut quoted, mut seen) = (Vec::new(), 0, false, false);
    for (at, own) in line.char_indices() {
        match own {
            '"' => {
                quoted = !quoted;
                seen = true;
            }
            ' ' if seen && !quoted => {
                all.push(&line[start..at]);
                (start, seen) = (at, false);
            }
            ' ' => {}
            _ => seen = true,
        }
    }
    all.push(&line[start..]);
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_fit_the_width_and_lose_no_word() {
        let text = "short\n  a row of a table   with columns  that are wider than that\n\nend";
        for width in 24..80 {
            let wrapped = wrapped(text, width);
            assert!(
                wrapped.lines().all(|line| line.chars().count() <= width),
                "{width}: {wrapped}"
            );
            let words = |text: &str| text.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
            assert_eq!(words(&wrapped), words(text), "{width}");
        }
        assert_eq!(wrapped(text, 200), text);
    }

    #[test]
    fn a_command_goes_on_with_a_backslash_and_not_within_quotes() {
        let command = "  joint import a.csv --map \"t=a:ms, i=b:mA\" --out log.csv";
        assert_eq!(
            commands(command, 40),
            "  joint import a.csv --map \\\n      \"t=a:ms, i=b:mA\" --out log.csv"
        );
        assert_eq!(commands(command, 80), command);
    }

    #[test]
    fn a_word_longer_than_the_width_stays_whole() {
        assert_eq!(
            wrapped("an exceedingly-long-name here", 10),
            "an\n  exceedingly-long-name\n  here"
        );
    }
}
