//! A search, and another at finer steps where those of the first hide what it looks for.
//!
//! Few micro-steps serve a search, but what they leave out of a stiff chain may be as large as an effect behind it: its
//! score is beyond chance, and a refit does not keep it.

use indicatif::ProgressBar;
use joint_core::effect::{EffectParameters, Kind};

use super::explained::{Explained, FINER};
use crate::discover::nuisances::timing::{Timed, search_timed};
use crate::estimate::fit::Problem;
use crate::estimate::record::Record;
use crate::interrupt;
use crate::model::Model;
use crate::plant::{BuildError, micro_steps};

/// What was found in a record.
pub(crate) struct Searched {
    /// The record, with the timing that the log shows.
    pub(crate) record: Record,
    /// How many micro-steps it has.
    pub(crate) micro_steps: u32,
    /// The nominal with the delay of the current that the log shows, where there is one.
    pub(crate) late: Option<Model>,
    /// What was found, and what it leaves.
    pub(crate) explained: Explained,
}

impl Searched {
    /// Of a record by its `fitted` samples.
    ///
    /// # Errors
    /// The nominal cannot be built.
    pub(crate) fn of(
        coarse: &Record,
        fitted: &[f64],
        nominal: &Model,
        known: (&[Kind], &[EffectParameters]),
        bar: &ProgressBar,
    ) -> Result<Self, BuildError> {
        // The filter corrects every sample, so that one interval need be right, not a whole run.
        let fewest = micro_steps(nominal, coarse.grid.typical_interval());
        let micro_steps = (fewest / 2).max(2).min(fewest);
        let at = |micro_steps: u32| {
            let record = coarse.refined(micro_steps);
            let Timed { record, late, found } = search_timed(record, fitted, nominal, known, bar)?;
            let refitted = late.as_ref().unwrap_or(nominal);
            let problem = Problem::new(&record, fitted);
            let explained = Explained::of(problem, refitted, found, known, bar)?;
            Ok::<_, BuildError>(Self { record, micro_steps, late, explained })
        };
        let own = at(micro_steps)?;
        match own.explained.hides_something() && !interrupt::asked() {
            true => at(FINER * micro_steps),
            false => Ok(own),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discover::checks::goodness_of_fit::Remainder;
    use crate::discover::state::rounds::ScoreRow;
    use crate::discover::state::search::Search;
    use crate::discover::trial;
    use crate::estimate::filter::{Colour, Disturbed};
    use crate::estimate::noise;

    #[test]
    fn steps_are_asked_where_a_score_is_beyond_chance_and_nothing_was_found_in_noise() {
        let nominal = trial::motor();
        // Nothing is hidden.
        let line = trial::line(12.0).with("amplitude_nm", 0.0);
        let record = Record::new(&trial::log(&nominal, line, 4.0), None);
        let mask = vec![1.0; record.len()];
        let problem = Problem::new(&record, &mask);
        let expected = noise::expected(&nominal, &record);
        let hidden = |score: f64, change: &dyn Fn(&mut Search)| {
            let mut found = Search::new(trial::fitted(&problem, &nominal, &[]), &[], expected);
            found.chance = vec![40.0];
            let name = "cogging (motor)".to_owned();
            found.scores.push(ScoreRow { round: 1, name, score, refitted: None });
            let left = Remainder::of(&problem, &found.after.fit, &expected, &mask).unwrap();
            change(&mut found);
            Explained { shape: None, found, left }.hides_something()
        };
        assert!(hidden(60.0, &|_| {}));
        assert!(!hidden(30.0, &|_| {}));
        assert!(!hidden(60.0, &|found| found.rounds.push(trial::round(100.0))));
        assert!(!hidden(60.0, &|found| {
            let colour = Colour { deviation: 0.01, correlation_s: 0.02 };
            found.after.fit.noise.coloured[Disturbed::Rotor as usize] = colour;
        }));
    }
}
