//! Questions for what was not given, on a terminal.

use std::io::{BufRead, Write};

/// Takes an answer, or says what is wrong with it.
pub type Take<'a> = Box<dyn FnMut(&str) -> Result<(), String> + 'a>;

/// A question about one number of a datasheet, and where its answer goes.
pub struct Question<'a> {
    /// What is asked, with its unit.
    pub what: &'a str,
    /// Whether a model needs it.
    pub needed: bool,
    /// Takes the answer.
    pub take: Take<'a>,
}

/// Asks each question until it is answered; an empty answer passes over what is not needed.
///
/// # Errors
/// The terminal is closed.
pub fn ask(
    questions: &mut [Question<'_>],
    input: &mut impl BufRead,
    output: &mut impl Write,
) -> std::io::Result<()> {
    for question in questions {
        loop {
            let skip = if question.needed { "" } else { " [unknown]" };
            write!(output, "{}{skip}: ", question.what)?;
            output.flush()?;
            let mut line = String::new();
            if input.read_line(&mut line)? == 0 {
                return Err(std::io::Error::from(std::io::ErrorKind::UnexpectedEof));
            }
            let answer = line.trim();
            if answer.is_empty() {
                if question.needed {
                    writeln!(output, "  a model needs it")?;
                    continue;
                }
                break;
            }
            match (question.take)(answer) {
                Ok(()) => break,
                Err(why) => writeln!(output, "  {why}")?,
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answers(text: &str) -> (std::io::Result<()>, Vec<f64>, String) {
        let mut values = Vec::new();
        let mut output = Vec::new();
        let result = {
            let values = std::cell::RefCell::new(&mut values);
            let question = |needed| Question {
                what: "resistance, ohm",
                needed,
                take: Box::new(|answer: &str| {
                    let value = answer.parse::<f64>().map_err(|error| error.to_string())?;
                    values.borrow_mut().push(value);
                    Ok(())
                }),
            };
            ask(&mut [question(true), question(false)], &mut text.as_bytes(), &mut output)
        };
        (result, values, String::from_utf8(output).unwrap())
    }

    #[test]
    fn a_needed_answer_is_asked_for_until_it_is_one() {
        let (result, values, told) = answers("\nmany\n0.5\n\n");
        assert!(result.is_ok());
        assert_eq!(values, [0.5]);
        assert_eq!(told.matches("resistance, ohm:").count(), 3);
        assert!(told.contains("a model needs it") && told.contains("invalid float"), "{told}");
        assert_eq!(told.matches("resistance, ohm [unknown]:").count(), 1);
    }

    #[test]
    fn a_closed_terminal_is_an_error() {
        assert!(answers("0.5\n").0.is_err());
    }
}
