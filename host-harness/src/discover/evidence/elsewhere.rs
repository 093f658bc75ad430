//! Whether another record of the joint confirms an effect, given all the others.
//!
//! Nothing is fitted to it but the level of friction and the noise, which are other ones every day. So a name that stands in
//! for what one motion made, or one day, is told from one that is the joint's.

use super::unseen::unseen;
use crate::discover::error::DiscoverError;
use crate::estimate::filter::Noise;
use crate::estimate::fit::{Fit, Problem};
use crate::estimate::noise;
use crate::estimate::record::Record;
use crate::log::Log;
use crate::plant::BuildError;
use crate::transfer::levelled;

/// Another record.
#[derive(Clone, Debug)]
pub(crate) struct Elsewhere {
    log: Log,
    record: Record,
    every: Vec<f64>,
}

impl Elsewhere {
    /// A log as a record of at most so many samples, stepped and timed as `like` is.
    ///
    /// # Errors
    /// The log drives the joint by something else.
    pub(crate) fn new(
        log: &Log,
        like: &Record,
        (most, micro_steps): (usize, u32),
    ) -> Result<Self, DiscoverError> {
        let record = Record::join(std::slice::from_ref(log), None)?.thinned(most);
        if record.drive != like.drive {
            return Err(DiscoverError::Elsewhere);
        }
        let record = record.refined(micro_steps);
        let record = if like.lead_s() > 0.0 { record.centred() } else { record };
        Ok(Self { log: log.clone(), every: vec![1.0; record.len()], record })
    }

    /// What this record says of a fit against the same without one of its effects, refitted: the gain over its
    /// standard error, by blocks. `expected` is the noise that the sensors and the joint's nature lead one to
    /// expect.
    ///
    /// # Errors
    /// A model cannot be built.
    pub(crate) fn asked(
        &self,
        [without, with]: [&Fit; 2],
        expected: &Noise,
    ) -> Result<f64, BuildError> {
        let problem = Problem::new(&self.record, &self.every).rough();
        let own = |fit: &Fit| -> Result<Fit, BuildError> {
            let model = levelled(&fit.model, &self.log)?;
            let noise = noise::refine(&problem, &model, expected, &fit.noise)?;
            Ok(Fit { model, noise, ..fit.clone() })
        };
        let every = vec![true; self.record.len()];
        Ok(unseen(&problem, &own(without)?, &own(with)?, &every)?.t)
    }
}

/// The t of several independent ones together (Stouffer and others 1949).
pub(crate) fn together(all: impl Iterator<Item = f64> + Clone) -> f64 {
    all.clone().sum::<f64>() / (all.count().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discover::trial;
    use crate::estimate::fit::Problem;
    use crate::model::Model;
    use crate::synthetic::{Experiment, record};
    use joint_core::joint::Drive;

    /// What another record, rubbing a tenth harder, says of a line that was fitted to a log which has it, or
    /// whose day alone had it.
    fn told(truth: &Model) -> f64 {
        let nominal = trial::motor();
        let line = trial::line(12.0);
        let log = trial::log(&nominal, line, 4.0);
        let like = Record::new(&log, None);
        let every = vec![1.0; like.len()];
        let problem = Problem::new(&like, &every).rough();
        let without = trial::fitted(&problem, &nominal, &[]);
        let with = trial::fitted(&problem, &Model { effects: vec![line], ..nominal }, &[]);
        let experiment = Experiment { duration_s: 1.0, ..Experiment::default() };
        let other = record(&truth.with_friction(1.1), &experiment, 9).unwrap();
        let elsewhere = Elsewhere::new(&other, &like, (60_000, 2)).unwrap();
        let expected = noise::expected(&trial::motor(), &elsewhere.record);
        elsewhere.asked([&without.fit, &with.fit], &expected).unwrap()
    }

    #[test]
    fn what_is_the_joints_is_borne_out_elsewhere_and_what_is_not_is_refused() {
        let plain = trial::motor();
        let lined = Model { effects: vec![trial::line(12.0)], ..plain.clone() };
        let [there, not] = [told(&lined), told(&plain)];
        assert!(there > 3.0 && not < -3.0, "{there} {not}");
    }

    #[test]
    fn another_record_is_timed_and_driven_as_the_first_one_is() {
        let log = trial::log(&trial::motor(), trial::line(12.0), 4.0);
        let like = Record::new(&log, None);
        let lead = |like: &Record| Elsewhere::new(&log, like, (60_000, 2)).unwrap().record.lead_s();
        assert_eq!(lead(&like), 0.0);
        assert!(lead(&like.centred()) > 0.0);
        let mut driven = like;
        driven.drive = Drive::Current;
        assert!(Elsewhere::new(&log, &driven, (60_000, 2)).is_err());
    }

    #[test]
    fn independent_ones_are_stouffers() {
        assert!((together([3.0, 1.0].into_iter()) - 4.0 / 2.0_f64.sqrt()).abs() < 1e-12);
    }
}
