//! Whether samples that no fit has seen confirm every effect, given all the others.

use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF, Normal};

use super::elimination::bare;
use crate::discover::bounds::{BY_CHANCE, FARTHEST, SIGMAS};
use crate::discover::evidence::budget::FreeRun;
use crate::discover::evidence::elsewhere::{Elsewhere, together};
use crate::discover::evidence::unseen::{Unseen, unseen};
use crate::discover::state::rounds::Contender;
use crate::discover::state::search::{Search, Unconfirmed};
use crate::discover::state::stage::Stage;
use crate::estimate::fit::Problem;
use crate::plant::BuildError;

/// Takes effects back that samples which no fit has seen do not bear out, given the others: they are only possible. An
/// effect has to come nearer there, and no other record may speak against it. Where what is left is no `noise`, or there
/// is a disturbance, likelihoods are made of what imitates an effect as well: it has to come nearer by more standard errors
/// than one of all hypotheses would by chance, there or in other records, or free runs have to. Of an effect that a
/// regression is certain of samples need only not speak against it. None stays with which free runs are far farther off.
/// Answers with what those samples, and the other records, say of the rest.
///
/// # Errors
/// A model cannot be built.
pub(crate) fn keep_confirmed(
    problem: &Problem<'_>,
    found: &mut Search,
    (tested, others): (&[bool], &[Elsewhere]),
    noise: bool,
) -> Result<Vec<Witnessed>, BuildError> {
    let by_chance = by_chance(found);
    loop {
        let asked = asked(problem, found, tested, others)?;
        let certain = |k: usize| found.measured.contains(&found.rounds[k].name);
        let white = noise && !found.after.fit.noise.is_disturbed();
        let level = if white { SIGMAS } else { by_chance };
        let all = asked.iter().enumerate().map(|(k, (own, _))| (k, own.stays(certain(k), level)));
        let Some((k, _)) = all.filter(|one| one.1 < 0.0).min_by(|a, b| a.1.total_cmp(&b.1)) else {
            return Ok(asked.into_iter().map(|(own, _)| own).collect());
        };
        let Some((own, without)) = asked.into_iter().nth(k) else { return Ok(Vec::new()) };
        let round = found.rounds.remove(k);
        found.unconfirmed.push(Unconfirmed {
            contender: Contender { name: round.name, gain: round.gain },
            stage: std::mem::replace(&mut found.after, without),
            slope: own.unseen.slope,
            unseen_t: own.unseen.t,
            transfer_t: own.elsewhere,
        });
    }
}

/// Standard errors that one of all hypotheses exceeds by chance in a twentieth of logs.
fn by_chance(found: &Search) -> f64 {
    let tried = found.tried().max(1);
    Normal::standard().inverse_cdf(1.0 - BY_CHANCE / tried as f64)
}

/// What samples that no fit has seen say of an effect.
#[derive(Clone, Debug)]
pub(crate) struct Witnessed {
    /// Those of the logs themselves.
    pub(crate) unseen: Unseen,
    /// Error of free runs over them with the effect, over that without it.
    pub(crate) free_run: f64,
    /// The t of the other records together; `None` where there are none.
    pub(crate) elsewhere: Option<f64>,
}

impl Default for Witnessed {
    /// Of what changes nothing.
    fn default() -> Self {
        Self { unseen: Unseen::default(), free_run: 1.0, elsewhere: None }
    }
}

impl Witnessed {
    /// Whether free runs come so much nearer that chance has no part in it: what imitates an effect helps from one sample to
    /// the next, but not over hundreds.
    fn runs_nearer(&self) -> bool {
        FARTHEST * self.free_run <= 1.0
    }

    /// By how many standard errors an effect stays, one that a regression is `certain` of or one that has to exceed what
    /// `chance` reaches; below zero where it does not.
    fn stays(&self, certain: bool, chance: f64) -> f64 {
        match certain {
            _ if self.free_run > FARTHEST => f64::NEG_INFINITY,
            true => self.not_against(),
            false => self.margin(chance),
        }
    }

    /// By how many standard errors it is borne out beyond what `chance` reaches; below zero where it is not.
    fn margin(&self, chance: f64) -> f64 {
        let own = self.unseen.slope;
        let chance = if self.runs_nearer() { SIGMAS } else { chance };
        match self.elsewhere {
            // Two witnesses for whom it is there: one of them has to be sure.
            Some(other) => own.margin(SIGMAS).min(own.nearer().max(other) - chance).min(other),
            None => own.margin(chance),
        }
    }

    /// By how many standard errors nobody speaks against it.
    fn not_against(&self) -> f64 {
        self.elsewhere.unwrap_or(f64::INFINITY).min(self.unseen.slope.nearer()) + SIGMAS
    }

    /// Standard errors by which it comes nearer, here and elsewhere together. Where what is left is no `noise`, errors are
    /// no measure of themselves, and it has to make the samples likelier or free runs come nearer as well.
    pub(crate) fn t(&self, noise: bool) -> f64 {
        let Unseen { slope, t, .. } = self.unseen;
        let enough = noise || self.runs_nearer();
        let own = if enough { slope.nearer() } else { slope.nearer().min(t) };
        together(self.elsewhere.into_iter().chain([own]))
    }
}

/// What unseen samples say of every effect, given the others, and the model without it.
fn asked(
    problem: &Problem<'_>,
    found: &Search,
    tested: &[bool],
    others: &[Elsewhere],
) -> Result<Vec<(Witnessed, Stage)>, BuildError> {
    let rounds = found.rounds.len();
    let one = |k: usize| {
        let without = match rounds {
            1 => found.before.clone(),
            _ => bare(problem.rough(), found, k)?,
        };
        let fits = [&without.fit, &found.after.fit];
        let (unseen, runs) = rayon::join(
            || unseen(problem, fits[0], fits[1], tested),
            || FreeRun::of(problem.record, fits, &found.expected, tested),
        );
        let others: Vec<f64> = others
            .iter()
            .map(|other| other.asked(fits, &found.expected))
            .collect::<Result<_, _>>()?;
        let elsewhere = (!others.is_empty()).then(|| together(others.iter().copied()));
        Ok((Witnessed { unseen: unseen?, free_run: runs?.factor(), elsewhere }, without))
    };
    (0..rounds).into_par_iter().map(one).collect()
}

#[cfg(test)]
mod tests {
    use std::ops::Range;

    use super::*;
    use crate::discover::evidence::blocks::Share;
    use crate::discover::evidence::slope::Slope;
    use crate::discover::state::rounds::ScoreRow;
    use crate::discover::trial;
    use crate::estimate::noise::expected;
    use crate::estimate::record::Record;
    use crate::log::Log;

    fn told(value: f64, error: f64, elsewhere: Option<f64>) -> Witnessed {
        let slope = Slope(Share { value, error });
        let unseen = Unseen { slope, ..Unseen::default() };
        Witnessed { unseen, elsewhere, ..Witnessed::default() }
    }

    #[test]
    fn an_effect_comes_nearer_beyond_chance_and_nobody_speaks_against_it() {
        for (value, error, elsewhere, confirmed) in [
            (1.0, 0.1, None, true),
            (0.6, 0.01, None, false),
            (1.0, 0.2, None, false),
            // Another record bears it out, or speaks against it.
            (1.0, 0.2, Some(9.0), true),
            (1.0, 0.2, Some(2.0), false),
            (0.6, 0.01, Some(9.0), false),
            (1.0, 0.1, Some(-0.1), false),
        ] {
            let own = told(value, error, elsewhere);
            assert_eq!(own.margin(3.3) >= 0.0, confirmed, "{own:?}");
        }
        // Free runs come nearer by a little, by far, and nearer though little of it is borne out.
        for (value, free_run, confirmed) in
            [(1.0, 0.6, false), (1.0, 0.5, true), (0.6, 0.01, false)]
        {
            let own = Witnessed { free_run, ..told(value, 0.2, None) };
            assert_eq!(own.margin(3.3) >= 0.0, confirmed, "{own:?}");
        }
        // Whatever samples say, an effect that runs far farther off does not stay.
        for (free_run, stay) in [(1.9, true), (2.1, false), (f64::INFINITY, false)] {
            let own = Witnessed { free_run, ..told(1.0, 0.01, Some(9.0)) };
            assert!(
                [false, true].into_iter().all(|certain| (own.stays(certain, 3.3) > 0.0) == stay)
            );
        }
    }

    #[test]
    fn whoever_speaks_against_an_effect_most_is_heard_and_all_of_them_count_together() {
        let against = |elsewhere| told(0.3, 0.2, elsewhere).not_against() - SIGMAS;
        let heard = [None, Some(-2.0), Some(2.0)].map(against);
        assert!(
            heard.iter().zip([-1.0, -2.0, -1.0]).all(|(a, b)| (a - b).abs() < 1e-12),
            "{heard:?}"
        );
        assert!((told(1.0, 0.5, None).t(true) - 1.0).abs() < 1e-12);
        assert!((told(1.0, 0.5, Some(2.0)).t(true) - 3.0 / 2.0_f64.sqrt()).abs() < 1e-12);
        // Samples that are no likelier for it count where what is left is no noise.
        let unlikelier = told(1.0, 0.5, None);
        assert_eq!(unlikelier.t(false), 0.0);
        let nearer = Witnessed { free_run: 0.1, ..unlikelier };
        assert!((nearer.t(false) - 1.0).abs() < 1e-12);
        assert_eq!(Witnessed { free_run: 0.7, ..nearer }.t(false), 0.0);
    }

    /// A log of a motor, and a search that has found a line in it which comes nearer on unseen samples by so many standard
    /// errors; the log holds it, or a share of it.
    struct Doubted {
        log: Log,
        record: Record,
        tested: Vec<bool>,
        mask: Vec<f64>,
        found: Search,
    }

    fn doubted(hidden: f64, nearer: Range<f64>) -> Doubted {
        let nominal = trial::motor();
        let size = |k: i32| 0.02 * 0.8_f64.powi(k);
        let tried = |k: i32| {
            let line = trial::line(12.0).with("amplitude_nm", size(k));
            let log = trial::log(&nominal, line.with("amplitude_nm", hidden * size(k)), 4.0);
            let record = Record::new(&log, None);
            let (tested, mask) = trial::split(&record);
            let problem = Problem::new(&record, &mask).rough();
            let before = trial::fitted(&problem, &nominal, &[]);
            let mut found = Search::new(before, &[], expected(&nominal, &record));
            found.rounds.push(trial::round(100.0));
            found.after.fit.model.effects.push(line);
            let fits = [&found.before.fit, &found.after.fit];
            let told = unseen(&problem, fits[0], fits[1], &tested).unwrap();
            let found = nearer.contains(&told.slope.nearer()).then_some(found)?;
            Some(Doubted { log, record, tested, mask, found })
        };
        (0..40).find_map(tried).unwrap()
    }

    #[test]
    fn a_doubt_takes_an_effect_back_but_one_that_a_regression_is_certain_of() {
        let Doubted { log, record, tested, mask, found } = doubted(0.0, -0.9 * SIGMAS..-0.1);
        let problem = Problem::new(&record, &mask).rough();
        let name = trial::round(1.0).name;
        let other = [Elsewhere::new(&log, &record, (60_000, 2)).unwrap()];
        for (certain, others, stays) in
            [(false, &[][..], false), (true, &[], true), (false, &other, false)]
        {
            let mut found = found.clone();
            found.measured = if certain { vec![name] } else { Vec::new() };
            let told = keep_confirmed(&problem, &mut found, (&tested, others), true).unwrap();
            let count = usize::from(stays);
            assert_eq!([told.len(), found.rounds.len()], [count; 2]);
            assert_eq!(found.after.fit.model.effects.len(), count);
            let taken: Vec<_> = found.unconfirmed.iter().map(|own| own.contender.name).collect();
            assert_eq!(taken, if stays { vec![] } else { vec![name] });
            assert!(told.iter().all(|own| own.elsewhere.is_none() == others.is_empty()));
        }
    }

    #[test]
    fn more_is_asked_of_an_effect_where_no_noise_is_left_or_a_disturbance() {
        let Doubted { record, tested, mask, mut found, .. } =
            doubted(1.0, 1.2 * SIGMAS..1.8 * SIGMAS);
        let problem = Problem::new(&record, &mask).rough();
        // One in two thousand of a normal deviate by chance: 3.3 standard errors.
        let row = |_| ScoreRow { round: 1, name: String::new(), score: 0.0, refitted: None };
        found.scores = (0..100).map(row).collect();
        for (noise, reversal, stays) in [(true, 0.0, 1), (false, 0.0, 0), (true, 1e-12, 0)] {
            let mut found = found.clone();
            found.after.fit.noise.reversal = reversal;
            let told = keep_confirmed(&problem, &mut found, (&tested, &[]), noise).unwrap();
            assert_eq!([told.len(), found.rounds.len()], [stays; 2]);
        }
    }

    #[test]
    fn chance_is_that_of_all_hypotheses_that_were_tried_at_once() {
        let (nominal, line) = (trial::motor(), trial::line(12.0));
        let record = Record::new(&trial::log(&nominal, line, 4.0), None);
        let mask = vec![1.0; record.len()];
        let before = trial::fitted(&Problem::new(&record, &mask).rough(), &nominal, &[]);
        let mut found = Search::new(before, &[], expected(&nominal, &record));
        let row = |round| ScoreRow { round, name: String::new(), score: 0.0, refitted: None };
        // A search that went on from what was found has no first round, or one of a few.
        found.scores = [1; 2].into_iter().chain([2; 10]).chain([3; 5]).map(row).collect();
        // One in two hundred of a normal deviate, and one in twenty.
        assert!((by_chance(&found) - 2.5758).abs() < 1e-4);
        found.scores.clear();
        assert!((by_chance(&found) - 1.6449).abs() < 1e-4);
    }
}
