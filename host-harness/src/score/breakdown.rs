//! Where the scores come from: by what was hidden, by how large it was, and by how sure the answer
//! said it was.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde::Serialize;

use super::Row;
use super::share::Share;

/// Bounds of the classes of size, in units of what is typical of a kind.
const SIZES: [(f64, &str); 3] = [(0.8, "small"), (1.25, "typical"), (f64::INFINITY, "large")];
/// Bounds of the classes of confidence.
const CONFIDENCES: [f64; 5] = [0.3, 0.6, 0.9, 0.97, 1.0];

/// The scores taken apart.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Breakdown {
    /// Named rightly first, by kind, single effects only.
    pub kinds: BTreeMap<String, Share>,
    /// Named rightly first, by size, single effects only.
    pub sizes: BTreeMap<String, Share>,
    /// Pairs of which both were named.
    pub pairs_both: Option<Share>,
    /// Pairs of which one was named first.
    pub pairs_first: Option<Share>,
    /// How often a first name given with some confidence was one that was hidden.
    pub reliability: Vec<Reliability>,
}

/// One point of the reliability curve.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Reliability {
    /// Mean of the confidences given.
    pub confidence: f64,
    /// How often such a name was right.
    pub right: Share,
}

impl Breakdown {
    /// Of the rows of a set.
    pub fn of(rows: &[Row]) -> Self {
        let single = |row: &&Row| row.hidden.len() == 1;
        let mut kinds: BTreeMap<String, Vec<&Row>> = BTreeMap::new();
        let mut sizes: BTreeMap<String, Vec<&Row>> = BTreeMap::new();
        for row in rows.iter().filter(single) {
            let (kind, _) = row.hidden[0].split_once(' ').unwrap_or((&row.hidden[0], ""));
            kinds.entry(kind.to_owned()).or_default().push(row);
            let class = row.size.and_then(|size| SIZES.iter().find(|(most, _)| size < *most));
            if let Some((_, name)) = class {
                sizes.entry((*name).to_owned()).or_default().push(row);
            }
        }
        let share = |rows: BTreeMap<String, Vec<&Row>>| {
            let share = |(key, rows)| Some((key, Share::of(rows, |row: &&Row| row.right)?));
            rows.into_iter().filter_map(share).collect()
        };
        let pairs = || rows.iter().filter(|row| row.hidden.len() > 1);
        let both = |row: &&Row| row.hidden.iter().all(|name| row.names.contains(name));
        Self {
            kinds: share(kinds),
            sizes: share(sizes),
            pairs_both: Share::of(pairs(), both),
            pairs_first: Share::of(pairs(), |row| row.first_is_hidden()),
            reliability: reliability(rows),
        }
    }

    /// As lines for a terminal.
    pub fn told(&self) -> String {
        let mut text = String::new();
        for (title, shares) in [("by kind", &self.kinds), ("by size", &self.sizes)] {
            if shares.len() > 1 {
                let _ = writeln!(text, "named rightly first, {title}");
            }
            for (key, share) in shares.iter().filter(|_| shares.len() > 1) {
                let _ = writeln!(text, "  {key:28} {share}");
            }
        }
        if let (Some(both), Some(first)) = (self.pairs_both, self.pairs_first) {
            let _ = writeln!(text, "pairs, both named     {both}");
            let _ = writeln!(text, "pairs, first name     {first}");
        }
        if !self.reliability.is_empty() {
            let _ = writeln!(text, "a first name given with confidence … was hidden in …");
        }
        for point in &self.reliability {
            let _ =
                writeln!(text, "  {:5.3}                        {}", point.confidence, point.right);
        }
        text
    }
}

fn reliability(rows: &[Row]) -> Vec<Reliability> {
    let mut classes: [Vec<(f64, &Row)>; CONFIDENCES.len()] = Default::default();
    for (row, confidence) in rows.iter().filter_map(|row| Some((row, row.confidence?))) {
        let class = CONFIDENCES.iter().position(|most| confidence < *most);
        classes[class.unwrap_or(CONFIDENCES.len() - 1)].push((confidence, row));
    }
    let point = |class: Vec<(f64, &Row)>| {
        let mean = class.iter().map(|(confidence, _)| confidence).sum::<f64>() / class.len() as f64;
        let right = Share::of(class, |(_, row)| row.first_is_hidden())?;
        Some(Reliability { confidence: mean, right })
    };
    classes.into_iter().filter_map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(hidden: &[&str], names: &[&str], confidence: f64, size: f64) -> Row {
        let own = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
        Row {
            hidden: own(hidden),
            names: own(names),
            confidence: Some(confidence),
            size: Some(size),
            right: names.first().is_some_and(|name| hidden.contains(name)),
            ..Row::default()
        }
    }

    #[test]
    fn rows_fall_into_their_classes() {
        let rows = [
            row(&["cogging motor"], &["cogging motor"], 0.98, 0.6),
            row(&["cogging motor"], &["backlash stage1"], 0.5, 1.9),
            row(&["gravity motor", "cogging motor"], &["cogging motor"], 0.98, 1.0),
            row(
                &["gravity motor", "cogging motor"],
                &["cogging motor", "gravity motor"],
                0.98,
                1.0,
            ),
            row(&[], &["cogging motor"], 0.5, 1.0),
        ];
        let told = Breakdown::of(&rows);
        assert_eq!((told.kinds["cogging"].count, told.kinds["cogging"].of), (1, 2));
        assert_eq!((told.sizes["small"].count, told.sizes["large"].count), (1, 0));
        let (both, first) = (told.pairs_both.unwrap(), told.pairs_first.unwrap());
        assert_eq!((both.count, first.count, first.of), (1, 2, 2));
        let points: Vec<_> =
            told.reliability.iter().map(|point| (point.right.count, point.right.of)).collect();
        assert_eq!(points, [(0, 2), (3, 3)]);
    }
}
