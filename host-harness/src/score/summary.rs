//! The scores over a set, and their table.

use std::fmt::Write as _;

use serde::Serialize;

use super::Row;

/// A name given with this confidence or more is given as certain.
const CERTAIN: f64 = 0.9;

/// The scores.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Summary {
    /// Logs in which an effect was hidden.
    pub effects: usize,
    /// Share of them named rightly first, kind and place.
    pub named_rightly: Option<f64>,
    /// Logs in which nothing was missing.
    pub adequate: usize,
    /// Share of them called anything else.
    pub false_alarms: Option<f64>,
    /// Share of all logs with a wrong first name given as certain.
    pub confident_wrong: Option<f64>,
    /// Logs with an effect of no list.
    pub unknown: usize,
    /// Share of them called unknown.
    pub unknown_recall: Option<f64>,
    /// Median of the gap closed.
    pub gap_closed: Option<f64>,
    /// Median of the main parameter's relative error.
    pub parameter_error: Option<f64>,
    /// Median of the seconds a log.
    pub seconds: Option<f64>,
}

impl Summary {
    /// Of the rows of a set.
    pub fn of(rows: &[Row]) -> Self {
        let nameless = |row: &&Row| row.truth == "adequate" || row.truth == "unknown";
        let effects: Vec<&Row> = rows.iter().filter(|row| !nameless(row)).collect();
        let of_truth =
            |truth: &str| rows.iter().filter(|row| row.truth == truth).collect::<Vec<&Row>>();
        let (adequate, unknown) = (of_truth("adequate"), of_truth("unknown"));
        let certain_wrong = |row: &&Row| {
            let certain = row.confidence.is_some_and(|confidence| confidence >= CERTAIN);
            let own = |named: &String, place: &String| {
                row.truth.split(" + ").any(|name| name == format!("{named} {place}"))
            };
            certain
                && !row.named.as_ref().zip(row.location.as_ref()).is_some_and(|(n, l)| own(n, l))
        };
        let all: Vec<&Row> = rows.iter().collect();
        Self {
            effects: effects.len(),
            named_rightly: share(&effects, |row| row.right),
            adequate: adequate.len(),
            false_alarms: share(&adequate, |row| !row.right),
            confident_wrong: share(&all, |row| certain_wrong(&row)),
            unknown: unknown.len(),
            unknown_recall: share(&unknown, |row| row.right),
            gap_closed: median(effects.iter().filter_map(|row| row.gap_closed).collect()),
            parameter_error: median(effects.iter().filter_map(|row| row.parameter_error).collect()),
            seconds: median(rows.iter().map(|row| row.seconds).collect()),
        }
    }
}

fn share(rows: &[&Row], holds: impl Fn(&Row) -> bool) -> Option<f64> {
    let count = rows.iter().filter(|row| holds(row)).count();
    (!rows.is_empty()).then(|| count as f64 / rows.len() as f64)
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    if values.len() % 2 == 1 {
        values.get(middle).copied()
    } else {
        values.get(middle.checked_sub(1)?).zip(values.get(middle)).map(|(a, b)| (a + b) / 2.0)
    }
}

/// The rows and the scores for a terminal.
pub fn table(rows: &[Row], summary: &Summary) -> String {
    let mut text = String::new();
    let number = |value: Option<f64>| value.map_or("–".to_owned(), |v| format!("{v:.3}"));
    let _ = writeln!(
        text,
        "{:34} {:42} {:9} {:42} {:>6} {:>6} {:>7} {:>6}",
        "case", "truth", "verdict", "named", "conf.", "closed", "error", "s"
    );
    for row in rows {
        let named = match (&row.named, &row.location) {
            (Some(named), Some(location)) => format!("{named} {location}"),
            _ => String::new(),
        };
        let _ = writeln!(
            text,
            "{:34} {:42} {:9} {:42} {:>6} {:>6} {:>7} {:>6.1}{}",
            row.case,
            row.truth,
            row.verdict,
            named,
            number(row.confidence),
            number(row.gap_closed),
            number(row.parameter_error),
            row.seconds,
            if row.right { "" } else { "  wrong" }
        );
    }
    let share =
        |value: Option<f64>| value.map_or("–".to_owned(), |v| format!("{:.1} %", 100.0 * v));
    let _ = writeln!(
        text,
        "named rightly first   {} of {}",
        share(summary.named_rightly),
        summary.effects
    );
    let _ = writeln!(
        text,
        "false alarms          {} of {}",
        share(summary.false_alarms),
        summary.adequate
    );
    let _ = writeln!(
        text,
        "unknown called so     {} of {}",
        share(summary.unknown_recall),
        summary.unknown
    );
    let _ = writeln!(text, "certain wrong names   {}", share(summary.confident_wrong));
    let _ = writeln!(text, "gap closed, median    {}", number(summary.gap_closed));
    let _ = writeln!(text, "main parameter, error {}", number(summary.parameter_error));
    let _ = write!(text, "seconds a log, median {}", number(summary.seconds));
    text
}
