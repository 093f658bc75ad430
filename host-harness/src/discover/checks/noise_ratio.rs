//! What a noise ratio says: how far the noise that a fit needs is from what one expects.

use crate::discover::bounds::{ADRIFT, CALM, LOST, NOT_IMPROVED};
use crate::discover::state::search::Search;
use crate::estimate::filter::Noise;

/// Whether a fit needs little more noise than is expected.
pub(crate) fn is_as_expected(noise: &Noise, expected: &Noise) -> bool {
    noise.times(expected) < CALM
}

impl Search {
    /// Whether the names so far leave an inconsistent model as inconsistent as it was.
    pub(crate) fn has_not_improved(&self) -> bool {
        let before = self.before.fit.noise.times(&self.expected);
        !self.rounds.is_empty() && self.noise_ratio() > LOST.max(NOT_IMPROVED * before)
    }

    /// Whether they do so of a nominal that may still be believed to be near: what the annealed refit then finds
    /// none beside is hidden to the other strategies as well.
    pub(crate) fn has_not_improved_though_near(&self) -> bool {
        self.has_not_improved() && self.before.fit.noise.times(&self.expected) <= ADRIFT
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discover::trial;
    use crate::estimate::fit::Problem;
    use crate::estimate::noise;
    use crate::estimate::record::Record;

    #[test]
    fn names_improve_nothing_that_leave_an_inconsistent_model_as_inconsistent() {
        let nominal = trial::motor();
        let record = Record::new(&trial::log(&nominal, trial::line(12.0), 4.0), None);
        let mask = vec![1.0; record.measured.len()];
        let expected = noise::expected(&nominal, &record);
        let before = trial::fitted(&Problem::new(&record, &mask).rough(), &nominal, &[]);
        let mut search = Search::new(before, &[], expected);
        let mut not_improved = |first: f64, left: f64| {
            search.before.fit.noise = expected.distrusted(first);
            search.after.fit.noise = expected.distrusted(left);
            let named = search.has_not_improved();
            let mut other = search.clone();
            other.rounds.push(trial::round(400.0));
            [named, other.has_not_improved()]
        };
        assert_eq!(not_improved(40.0, 36.0), [false, true]);
        assert_eq!(not_improved(40.0, 20.0), [false, false]);
        assert_eq!(not_improved(5.0, 4.8), [false, false]);
        search.rounds.push(trial::round(400.0));
        let though_near = |first: f64| {
            search.before.fit.noise = expected.distrusted(first);
            search.after.fit.noise = expected.distrusted(0.9 * first);
            search.has_not_improved_though_near()
        };
        assert_eq!([ADRIFT / 2.0, 2.0 * ADRIFT].map(though_near), [true, false]);
    }
}
