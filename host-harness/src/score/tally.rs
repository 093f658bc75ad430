//! Scores counted by what was hidden and how large it was, and by what else the joint had.
//!
//! One share over everything hides why a search fails. Here single effects are told from pairs and
//! triples, clear ones from those of 0.4 of it, those that leave a gap from those that do not, and
//! each misfit of the draws has its own line.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde::Serialize;

use super::Row;
use super::share::Share;

/// From this ratio of signal to noise on an effect changes the signals by more than their noise.
const LEAVES_A_GAP: f64 = 1.0;
/// Below this size an effect is small.
const SMALL: f64 = 0.7;

/// The counts.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Tally {
    /// By content and size.
    pub contents: BTreeMap<&'static str, Share>,
    /// Rows with a name that was not hidden and is given as certain, whatever its place among them.
    pub certain_wrong: Option<Share>,
    /// Rows with names whose gap on unseen samples is wider with them.
    pub worse_after: Option<Share>,
    /// Parameters whose 95 % interval holds the truth.
    pub intervals: Option<Share>,
    /// By misfit: what is classed and its class.
    pub misfits: BTreeMap<String, Class>,
    /// 95 % of the logs take no longer, s.
    pub seconds_95: Option<f64>,
}

/// The counts of a class of misfits.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Class {
    /// Effects, single or not, of which one is named first.
    pub named_first: Option<Share>,
    /// Joints with nothing hidden that are called adequate.
    pub adequate: Option<Share>,
    /// Rows with a certain wrong name.
    pub certain_wrong: Option<Share>,
}

/// What a content is called, and which rows have it.
type Content = (&'static str, fn(&Row) -> bool);

fn single(row: &Row) -> bool {
    row.hidden.len() == 1
}

fn small(row: &Row) -> bool {
    row.size.is_some_and(|size| size < SMALL)
}

fn leaves_a_gap(row: &Row) -> bool {
    row.signal_to_noise.is_some_and(|ratio| ratio >= LEAVES_A_GAP)
}

const CONTENTS: [Content; 11] = [
    ("singles, clear", |row| single(row) && !small(row)),
    ("singles, clear, that leave a gap", |row| single(row) && !small(row) && leaves_a_gap(row)),
    ("singles, small", |row| single(row) && small(row)),
    ("singles, small, that leave a gap", |row| single(row) && small(row) && leaves_a_gap(row)),
    ("pairs", |row| row.hidden.len() == 2),
    ("pairs that leave two gaps", |row| row.hidden.len() == 2 && leaves_a_gap(row)),
    ("triples", |row| row.hidden.len() == 3),
    ("triples that leave three gaps", |row| row.hidden.len() == 3 && leaves_a_gap(row)),
    ("nothing hidden, called adequate", |row| row.truth == "adequate"),
    ("withdrawn, called unknown", |row| row.truth == "unknown"),
    ("withdrawn that leave a gap", |row| row.truth == "unknown" && leaves_a_gap(row)),
];

impl Tally {
    /// Of the rows of a set.
    pub fn of(rows: &[Row]) -> Self {
        let mut contents = BTreeMap::new();
        for (name, has) in CONTENTS {
            let own = || rows.iter().filter(|row| has(row));
            contents.extend(Share::of(own(), |row: &&Row| row.right).map(|share| (name, share)));
        }
        let several = |count: usize| rows.iter().filter(move |row| row.hidden.len() == count);
        let all = |row: &&Row| row.hidden.iter().all(|name| row.names.contains(name));
        contents.extend(Share::of(several(2), all).map(|share| ("pairs, both named", share)));
        contents.extend(Share::of(several(3), all).map(|share| ("triples, all named", share)));
        let mut classes: BTreeMap<String, Vec<&Row>> = BTreeMap::new();
        for row in rows {
            for (what, class) in row.misfits.iter().flat_map(|misfits| misfits.classes()) {
                classes.entry(format!("{what}: {class}")).or_default().push(row);
            }
        }
        let named = rows.iter().filter(|row| !row.names.is_empty() && row.gap.is_some());
        let [held, of] =
            rows.iter().fold([0, 0], |[a, b], row| [a + row.intervals[0], b + row.intervals[1]]);
        let mut seconds: Vec<f64> = rows.iter().map(|row| row.seconds).collect();
        seconds.sort_by(f64::total_cmp);
        Self {
            contents,
            certain_wrong: Share::of(rows, |row| row.has_certain_wrong()),
            worse_after: Share::of(named, |row| row.is_worse_after()),
            intervals: Share::of(0..of, |place| *place < held),
            misfits: classes.into_iter().map(|(key, rows)| (key, Class::of(&rows))).collect(),
            seconds_95: seconds.get((0.95 * seconds.len() as f64) as usize).copied(),
        }
    }

    /// As lines for a terminal.
    pub fn told(&self) -> String {
        let mut text = String::new();
        for (name, share) in &self.contents {
            let _ = writeln!(text, "{name:34} {share}");
        }
        let shares = [
            ("a certain wrong name among all", &self.certain_wrong),
            ("gap after wider than before", &self.worse_after),
            ("95 % intervals holding the truth", &self.intervals),
        ];
        for (title, share) in shares {
            if let Some(share) = share {
                let _ = writeln!(text, "{title:34} {share}");
            }
        }
        if let Some(seconds) = self.seconds_95 {
            let _ = writeln!(text, "seconds a log, 95 % below          {seconds:.1}");
        }
        if !self.misfits.is_empty() {
            let head = ["by misfit", "named first", "adequate called so", "certain wrong"];
            let [by, named, adequate, wrong] = head;
            let _ = writeln!(text, "{by:44} {named:>14} {adequate:>20} {wrong:>14}");
        }
        let brief = |share: &Option<Share>| {
            share.map_or("–".to_owned(), |share| format!("{} of {}", share.count, share.of))
        };
        for (key, class) in &self.misfits {
            let [named, adequate, wrong] =
                [&class.named_first, &class.adequate, &class.certain_wrong].map(brief);
            let _ = writeln!(text, "{key:44} {named:>14} {adequate:>20} {wrong:>14}");
        }
        text
    }
}

impl Class {
    fn of(rows: &[&Row]) -> Self {
        let hidden = rows.iter().filter(|row| !row.hidden.is_empty());
        let nothing = rows.iter().filter(|row| row.truth == "adequate");
        Self {
            named_first: Share::of(hidden, |row| row.right),
            adequate: Share::of(nothing, |row| row.right),
            certain_wrong: Share::of(rows, |row| row.has_certain_wrong()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(hidden: &[&str], names: &[(&str, f64)], size: f64, ratio: f64) -> Row {
        Row {
            truth: if hidden.is_empty() { "adequate".to_owned() } else { hidden.join(" + ") },
            hidden: hidden.iter().map(|name| (*name).to_owned()).collect(),
            names: names.iter().map(|(name, _)| (*name).to_owned()).collect(),
            confidences: names.iter().map(|(_, sure)| *sure).collect(),
            gap: Some([2.0, if names.len() > 1 { 2.5 } else { 1.0 }, 1.0]),
            size: (!hidden.is_empty()).then_some(size),
            signal_to_noise: (!hidden.is_empty()).then_some(ratio),
            right: names.first().map_or(hidden.is_empty(), |(name, _)| hidden.contains(name)),
            ..Row::default()
        }
    }

    #[test]
    fn every_row_is_counted_where_it_belongs() {
        let (cogging, gravity) = ("cogging motor", "gravity motor");
        let rows = [
            row(&[cogging], &[(cogging, 0.98)], 1.0, 5.0),
            row(&[cogging], &[], 0.4, 0.2),
            row(&[cogging], &[(gravity, 0.95)], 0.4, 3.0),
            row(&[cogging, gravity], &[(cogging, 0.98), ("backlash stage1", 0.97)], 1.0, 2.0),
            row(&[], &[], 0.0, 0.0),
            row(&[], &[(gravity, 0.5)], 0.0, 0.0),
        ];
        let tally = Tally::of(&rows);
        let count = |name: &str| {
            let share = tally.contents[name];
            (share.count, share.of)
        };
        assert_eq!((count("singles, clear"), count("singles, small")), ((1, 1), (0, 2)));
        assert_eq!(count("singles, small, that leave a gap"), (0, 1));
        assert_eq!((count("pairs"), count("pairs, both named")), ((1, 1), (0, 1)));
        assert_eq!(count("nothing hidden, called adequate"), (1, 2));
        // The second name of the pair is wrong and certain as well, and it widens the gap.
        assert_eq!(tally.certain_wrong.map(|share| share.count), Some(2));
        assert_eq!(tally.worse_after.map(|share| (share.count, share.of)), Some((1, 4)));
    }
}
