//! The scores over a set, and their table.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde::Serialize;

use super::CERTAIN;
use super::Row;
use super::breakdown::Breakdown;
use super::share::Share;
use super::tally::Tally;

/// Names of the shares.
const NAMED_RIGHTLY: &str = "named_rightly";
const FALSE_ALARMS: &str = "false_alarms";
const UNKNOWN_RECALL: &str = "unknown_recall";
const CONFIDENT_WRONG: &str = "confident_wrong";

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
    /// The shares above by name, with counts and confidence intervals.
    pub shares: BTreeMap<&'static str, Share>,
    /// Where they come from.
    pub breakdown: Breakdown,
    /// Counts by content and size, and by misfit where there are any.
    pub tally: Tally,
}

impl Summary {
    /// Of the rows of a set.
    pub fn of(rows: &[Row]) -> Self {
        let nameless = |row: &&Row| row.truth == "adequate" || row.truth == "unknown";
        let effects: Vec<&Row> = rows.iter().filter(|row| !nameless(row)).collect();
        let of_truth =
            |truth: &str| rows.iter().filter(|row| row.truth == truth).collect::<Vec<&Row>>();
        let (adequate, unknown) = (of_truth("adequate"), of_truth("unknown"));
        let certain_wrong = |row: &Row| {
            let certain = row.confidence.is_some_and(|confidence| confidence >= CERTAIN);
            let own = |named: &String, place: &String| {
                row.truth.split(" + ").any(|name| name == format!("{named} {place}"))
            };
            certain
                && !row.named.as_ref().zip(row.location.as_ref()).is_some_and(|(n, l)| own(n, l))
        };
        let shares: BTreeMap<&'static str, Share> = [
            (NAMED_RIGHTLY, Share::of(&effects, |row| row.right)),
            (FALSE_ALARMS, Share::of(&adequate, |row| !row.right)),
            (UNKNOWN_RECALL, Share::of(&unknown, |row| row.right)),
            (CONFIDENT_WRONG, Share::of(rows, |row| certain_wrong(row))),
        ]
        .into_iter()
        .filter_map(|(name, share)| Some((name, share?)))
        .collect();
        let value = |name| shares.get(name).map(Share::value);
        Self {
            effects: effects.len(),
            named_rightly: value(NAMED_RIGHTLY),
            adequate: adequate.len(),
            false_alarms: value(FALSE_ALARMS),
            confident_wrong: value(CONFIDENT_WRONG),
            unknown: unknown.len(),
            unknown_recall: value(UNKNOWN_RECALL),
            gap_closed: median(effects.iter().filter_map(|row| row.gap_closed).collect()),
            parameter_error: median(effects.iter().filter_map(|row| row.parameter_error).collect()),
            seconds: median(rows.iter().map(|row| row.seconds).collect()),
            shares,
            breakdown: Breakdown::of(rows),
            tally: Tally::of(rows),
        }
    }
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
    let titles = [
        ("named rightly first", NAMED_RIGHTLY),
        ("false alarms", FALSE_ALARMS),
        ("unknown called so", UNKNOWN_RECALL),
        ("certain wrong names", CONFIDENT_WRONG),
    ];
    for (title, name) in titles {
        let share = summary.shares.get(name).map_or("–".to_owned(), Share::to_string);
        let _ = writeln!(text, "{title:21} {share}");
    }
    text += &summary.breakdown.told();
    text += &summary.tally.told();
    let _ = writeln!(text, "gap closed, median    {}", number(summary.gap_closed));
    let _ = writeln!(text, "main parameter, error {}", number(summary.parameter_error));
    let _ = write!(text, "seconds a log, median {}", number(summary.seconds));
    text
}
