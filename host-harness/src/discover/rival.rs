//! A name's rivals: what else was fitted in its place, the best first.

use super::search::{Contender, Round, Stage};

impl Round {
    /// Takes in a rival unless its name is there already and explains as much; the best one's fit is kept
    /// for the next experiment, and the name stays `ahead` of it in that share of the logs drawn anew.
    pub(super) fn rivalled(
        &mut self,
        contender: Contender,
        fitted: Stage,
        ahead: impl FnOnce(&Stage) -> f64,
    ) {
        self.rivals.retain(|known| known.name != contender.name || known.gain > contender.gain);
        if self.rivals.iter().any(|known| known.name == contender.name) {
            return;
        }
        let place = self.rivals.partition_point(|known| known.gain > contender.gain);
        self.rivals.insert(place, contender);
        if place == 0 {
            self.stays_ahead = self.stays_ahead.min(ahead(&fitted));
            self.runner_up = Some(fitted);
        }
    }
}
