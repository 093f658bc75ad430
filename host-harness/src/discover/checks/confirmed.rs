//! Whether samples that no fit has seen confirm every effect, given all the others.

use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF, Normal};

use super::elimination::bare;
use crate::discover::bounds::{BY_CHANCE, SIGMAS};
use crate::discover::evidence::elsewhere::{Elsewhere, together};
use crate::discover::evidence::unseen::{Unseen, unseen};
use crate::discover::state::rounds::Contender;
use crate::discover::state::search::{Search, Unconfirmed};
use crate::discover::state::stage::Stage;
use crate::estimate::fit::Problem;
use crate::plant::BuildError;

/// Takes effects back that samples which no fit has seen speak against beyond their standard error, given the
/// others: they are only possible. Where what is left is not noise they have to be the likelier for it, and beside
/// a disturbance, which makes likelihoods of what imitates it, to come nearer as well, one of the two by more standard
/// errors than one of all hypotheses would by chance; not so of an effect that a regression is certain of. Answers
/// with what those samples, and the other records, say of the rest.
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
        let disturbed = found.after.fit.noise.is_disturbed();
        let certain = |k: usize| found.measured.contains(&found.rounds[k].name);
        let short = |k: usize, own: &Witnessed| match certain(k) {
            false if disturbed => margin(&own.all(), by_chance),
            false if !noise => own.least(),
            _ => own.least() + SIGMAS,
        };
        let all = asked.iter().enumerate().map(|(k, (own, _))| (k, short(k, own)));
        let Some((k, _)) = all.filter(|one| one.1 < 0.0).min_by(|a, b| a.1.total_cmp(&b.1)) else {
            return Ok(asked.into_iter().map(|(own, _)| own).collect());
        };
        let Some((own, without)) = asked.into_iter().nth(k) else { return Ok(Vec::new()) };
        let round = found.rounds.remove(k);
        found.unconfirmed.push(Unconfirmed {
            contender: Contender { name: round.name, gain: round.gain },
            stage: std::mem::replace(&mut found.after, without),
            unseen_t: own.unseen.t,
            transfer_t: own.elsewhere,
        });
    }
}

/// Standard errors that one of all hypotheses exceeds by chance in a twentieth of logs.
fn by_chance(found: &Search) -> f64 {
    let tried = found.scores.iter().filter(|row| row.round == 1).count().max(1);
    Normal::standard().inverse_cdf(1.0 - BY_CHANCE / tried as f64)
}

/// By how many standard errors samples that no fit has seen confirm an effect beside a disturbance, from the t of their
/// likelihood, of their squared errors, and of other records: none may speak against it, and one has to be beyond chance.
pub(crate) fn margin(told: &[f64], by_chance: f64) -> f64 {
    let most = told.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    told.iter().copied().fold(most - by_chance, f64::min)
}

/// What samples that no fit has seen say of an effect.
#[derive(Clone, Debug, Default)]
pub(crate) struct Witnessed {
    /// Those of the logs themselves.
    pub(crate) unseen: Unseen,
    /// The t of the other records together; `None` where there are none.
    pub(crate) elsewhere: Option<f64>,
}

impl Witnessed {
    /// The t of whoever speaks against it most.
    fn least(&self) -> f64 {
        self.elsewhere.map_or(self.unseen.t, |other| self.unseen.t.min(other))
    }

    /// Every t there is.
    fn all(&self) -> Vec<f64> {
        [self.unseen.t, self.unseen.nearer].into_iter().chain(self.elsewhere).collect()
    }

    /// The t of all together.
    pub(crate) fn t(&self) -> f64 {
        together(self.elsewhere.into_iter().chain([self.unseen.t]))
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
        let unseen = unseen(problem, &without.fit, &found.after.fit, tested)?;
        let others: Vec<f64> = others
            .iter()
            .map(|other| other.asked([&without.fit, &found.after.fit], &found.expected))
            .collect::<Result<_, _>>()?;
        let elsewhere = (!others.is_empty()).then(|| together(others.iter().copied()));
        Ok((Witnessed { unseen, elsewhere }, without))
    };
    (0..rounds).into_par_iter().map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discover::state::rounds::ScoreRow;
    use crate::discover::trial;
    use crate::estimate::noise::expected;
    use crate::estimate::record::Record;
    use crate::log::Log;

    #[test]
    fn beside_a_disturbance_nothing_may_speak_against_an_effect_and_one_has_to_be_beyond_chance() {
        for (told, confirmed) in [
            (vec![4.0, 0.1], true),
            (vec![0.1, 4.0], true),
            (vec![4.0, -0.1], false),
            (vec![3.0, 3.0], false),
            // Another record bears it out, or speaks against it.
            (vec![1.7, 0.2, 9.0], true),
            (vec![4.0, 4.0, -0.1], false),
        ] {
            assert_eq!(margin(&told, 3.3) >= 0.0, confirmed, "{told:?}");
        }
        assert_eq!(margin(&[4.0, 0.25], 3.3), 0.25);
    }

    #[test]
    fn whoever_speaks_against_an_effect_most_is_its_least_and_all_of_them_count_together() {
        let told = |elsewhere| {
            let unseen = Unseen { t: 1.0, nearer: 3.0, ..Unseen::default() };
            Witnessed { unseen, elsewhere }
        };
        assert_eq!([None, Some(0.5), Some(2.0)].map(|t| told(t).least()), [1.0, 0.5, 1.0]);
        assert_eq!(
            [told(None).all(), told(Some(2.0)).all()],
            [vec![1.0, 3.0], vec![1.0, 3.0, 2.0]]
        );
        assert_eq!(told(None).t(), 1.0);
        assert!((told(Some(2.0)).t() - 3.0 / 2.0_f64.sqrt()).abs() < 1e-12);
    }

    /// A log of a motor, and a search that has found a line in it which is not there, of a size that unseen samples
    /// speak against by less than [`SIGMAS`].
    struct Doubted {
        log: Log,
        record: Record,
        tested: Vec<bool>,
        mask: Vec<f64>,
        found: Search,
    }

    fn doubted() -> Doubted {
        let (nominal, line) = (trial::motor(), trial::line(12.0).with("amplitude_nm", 0.0));
        let log = trial::log(&nominal, line, 4.0);
        let record = Record::new(&log, None);
        let tested: Vec<bool> = (0..record.len()).map(|k| k % 1000 >= 700).collect();
        let mask: Vec<f64> = tested.iter().map(|tested| f64::from(u8::from(!tested))).collect();
        let problem = Problem::new(&record, &mask).rough();
        let before = trial::fitted(&problem, &nominal, &[]);
        let mut found = Search::new(before, &[], expected(&nominal, &record));
        found.rounds.push(trial::round(100.0));
        let with = (0..60).find_map(|k| {
            let mut with = found.before.clone();
            with.fit.model.effects.push(line.with("amplitude_nm", 1e-3 * 0.8_f64.powi(k)));
            let told = unseen(&problem, &found.before.fit, &with.fit, &tested).unwrap();
            (-0.9 * SIGMAS..-0.1).contains(&told.t).then_some(with)
        });
        found.after = with.unwrap();
        Doubted { log, record, tested, mask, found }
    }

    #[test]
    fn a_doubt_takes_an_effect_back_where_noise_is_left_or_a_disturbance_and_no_regression_is_certain()
     {
        let Doubted { log, record, tested, mask, found } = doubted();
        let problem = Problem::new(&record, &mask).rough();
        let name = trial::round(1.0).name;
        let other = [Elsewhere::new(&log, &record, (60_000, 2)).unwrap()];
        for (noise, disturbed, certain, others, stays) in [
            (true, false, false, &[][..], true),
            (false, false, false, &[], false),
            (false, false, true, &[], true),
            (true, true, false, &[], false),
            (true, true, true, &other, true),
        ] {
            let mut found = found.clone();
            found.after.fit.noise.reversal = if disturbed { 1e-12 } else { 0.0 };
            found.measured = if certain { vec![name] } else { Vec::new() };
            let told = keep_confirmed(&problem, &mut found, (&tested, others), noise).unwrap();
            let count = usize::from(stays);
            assert_eq!([told.len(), found.rounds.len()], [count; 2]);
            assert_eq!(found.after.fit.model.effects.len(), count);
            let taken: Vec<_> = found.unconfirmed.iter().map(|own| own.contender.name).collect();
            assert_eq!(taken, if stays { vec![] } else { vec![name] });
            assert!(told.iter().all(|own| own.elsewhere.is_none() == others.is_empty()));
        }
    }

    #[test]
    fn chance_is_that_of_all_hypotheses_of_the_first_round() {
        let (nominal, line) = (trial::motor(), trial::line(12.0));
        let record = Record::new(&trial::log(&nominal, line, 4.0), None);
        let mask = vec![1.0; record.len()];
        let before = trial::fitted(&Problem::new(&record, &mask).rough(), &nominal, &[]);
        let mut found = Search::new(before, &[], expected(&nominal, &record));
        let row = |round| ScoreRow { round, name: String::new(), score: 0.0, refitted: None };
        found.scores = [1; 10].into_iter().chain([2; 5]).map(row).collect();
        // One in two hundred of a normal deviate, and one in twenty.
        assert!((by_chance(&found) - 2.5758).abs() < 1e-4);
        found.scores.clear();
        assert!((by_chance(&found) - 1.6449).abs() < 1e-4);
    }
}
