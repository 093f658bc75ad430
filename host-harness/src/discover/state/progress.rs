//! What a search is at, in plain words, for a person who waits.

use super::search::Search;
use crate::discover::bounds::MOST_EFFECTS;

impl Search {
    /// Tells what is tried in a round.
    pub(crate) fn tell(&self, round: usize, what: &str) {
        self.tell_of(MOST_EFFECTS, round, what);
    }

    /// The same where there may be another number of rounds at most.
    pub(crate) fn tell_of(&self, most: usize, round: usize, what: &str) {
        self.bar.set_message(format!("effect {round} of at most {most}: {what}"));
    }

    /// Tells how many names were scored, and how many of them are fitted next.
    pub(crate) fn tell_scored(&self, round: usize, scored: usize, fitted: usize) {
        let what = match fitted {
            0 => format!("none of {scored} known effects stands out"),
            1 => format!("fitting the best of {scored} known effects"),
            _ => format!("fitting the {fitted} best of {scored} known effects"),
        };
        self.tell(round, &what);
    }
}
