//! What a search is at, in plain words, for a person who waits.

use super::search::{MOST_EFFECTS, Search};

impl Search {
    /// Tells what is tried in a round.
    pub(super) fn tell(&self, round: usize, what: &str) {
        self.bar.set_message(format!("effect {round} of at most {MOST_EFFECTS}: {what}"));
    }

    /// Tells how many names were scored, and how many of them are fitted next.
    pub(super) fn tell_scored(&self, round: usize, scored: usize, fitted: usize) {
        let what = match fitted {
            0 => format!("none of {scored} known effects stands out"),
            1 => format!("fitting the best of {scored} known effects"),
            _ => format!("fitting the {fitted} best of {scored} known effects"),
        };
        self.tell(round, &what);
    }
}

#[cfg(test)]
mod tests {
    use super::super::search::{MOST_EFFECTS, Search, add_settled};
    use super::super::trial;
    use crate::estimate::fit::Problem;
    use crate::estimate::noise;
    use crate::estimate::record::Record;

    #[test]
    fn a_person_who_waits_reads_what_is_tried_and_of_how_many() {
        let nominal = trial::motor();
        let record = Record::new(&trial::log(&nominal, trial::line(12.0), 4.0), None);
        let mask = vec![1.0; record.len()];
        let problem = Problem::new(&record, &mask).rough();
        let expected = noise::expected(&nominal, &record);
        let mut search = Search::new(trial::fitted(&problem, &nominal, &[]), &[], expected);
        add_settled(problem, &mut search, 1).unwrap();
        let message = search.bar.message();
        let start = format!("effect 1 of at most {MOST_EFFECTS}: fitting the ");
        assert!(message.starts_with(&start), "{message}");
        assert!(message.ends_with(" known effects"), "{message}");
    }
}
