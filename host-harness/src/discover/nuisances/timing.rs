//! The search, where the current is the input and may be measured or commanded.
//!
//! An encoder that shows the past by more than half an interval hides from the nominal's refit that a
//! measured current stands for the interval around its sample. The search then names a delay of every
//! encoder, one for the truth and the others for half an interval. An input that acts late by about a quarter
//! of an interval lies as far from the one as from the other: there the refit's score for an input that acts
//! ahead of its stamp says that it was measured.

use indicatif::ProgressBar;
use joint_core::effect::{EffectParameters, Kind};
use joint_core::joint::Drive;

use super::late_current::{late_current, refitted as refitted_late};
use crate::discover::bounds::WEAK;
use crate::discover::candidates::input_delay::late;
use crate::discover::candidates::sensor_delay::late_encoders;
use crate::discover::proposals::score_test::ScoreTest;
use crate::discover::search::search;
use crate::discover::state::search::Search;
use crate::discover::state::stage::Stage;
use crate::estimate::fit::{Fit, Problem};
use crate::estimate::record::Record;
use crate::estimate::refit::{cost, refit};
use crate::estimate::scout::Scout;
use crate::estimate::timing::{LEAST, asked};
use crate::interrupt;
use crate::model::Model;
use crate::plant::BuildError;

/// What a search found, and how it took the log.
pub(crate) struct Timed {
    /// The record as the search took it.
    pub(crate) record: Record,
    /// The nominal with the delay of the current that the log shows, where there is one.
    pub(crate) late: Option<Model>,
    /// What was found.
    pub(crate) found: Search,
}

/// Searches a record by its `fitted` samples, and again with the current taken as measured where the
/// first search names more than one delay; keeps the likelier answer, where a name that is weak beside
/// the other search's answer does not count.
///
/// # Errors
/// The nominal cannot be built.
pub(crate) fn search_timed(
    record: Record,
    fitted: &[f64],
    nominal: &Model,
    known: (&[Kind], &[EffectParameters]),
    bar: &ProgressBar,
) -> Result<Timed, BuildError> {
    bar.set_message("fitting the parameters of the given model");
    let refitted = |record: &Record| {
        let scout = Scout::of(record, fitted, nominal);
        refit(&Problem::new(record, fitted).scouted(scout.as_ref()), nominal)
    };
    let (mut record, mut fit) = asked(nominal, record, fitted, refitted)?;
    if record.drive == Drive::Current
        && record.lead_s() == 0.0
        && acts_ahead(&Problem::new(&record, fitted), nominal, &fit)
    {
        let centred = record.centred();
        let again = refitted(&centred)?;
        if cost(&again).is_finite() {
            (record, fit) = (centred, again);
        }
    }
    if record.drive == Drive::Voltage {
        let scout = Scout::of(&record, fitted, nominal);
        let problem = Problem::new(&record, fitted).scouted(scout.as_ref());
        let (late, found) = searched_late(problem, nominal, fit, known, bar)?;
        return Ok(Timed { record, late, found });
    }
    let searched = |record: &Record, fit| {
        let scout = Scout::of(record, fitted, nominal);
        let problem = Problem::new(record, fitted).scouted(scout.as_ref());
        search(problem, nominal, fit, known, bar)
    };
    let found = searched(&record, fit)?;
    if record.lead_s() > 0.0 || delays(&found) < 2 || interrupt::asked() {
        return Ok(Timed { record, late: None, found });
    }
    let centred = record.centred();
    let fit = refitted(&centred)?;
    let again = searched(&centred, fit)?;
    Ok(match weight(&again) < weight(&found) && !interrupt::asked() {
        true => Timed { record: centred, late: None, found: again },
        false => Timed { record, late: None, found },
    })
}

/// Searches from a nominal's fit, and again from the nominal with a delay of the current that its fit or what was found
/// shows. Gives that nominal, where its answer is the likelier one.
fn searched_late(
    problem: Problem<'_>,
    nominal: &Model,
    fit: Fit,
    known: (&[Kind], &[EffectParameters]),
    bar: &ProgressBar,
) -> Result<(Option<Model>, Search), BuildError> {
    let plain = Stage { fit, origin: nominal.clone() };
    if let Some(late) = late_current(&problem, nominal, &plain)? {
        let (shown, fit) = refitted_late(&problem, nominal, late)?;
        let found = search(problem, &shown, fit, known, bar)?;
        return Ok((Some(shown), found));
    }
    let found = search(problem, nominal, plain.fit, known, bar)?;
    let late = match found.rounds.is_empty() {
        true => None,
        false => late_current(&problem, nominal, &found.after)?,
    };
    if let Some(late) = late {
        let (shown, fit) = refitted_late(&problem, nominal, late)?;
        let again = search(problem, &shown, fit, known, bar)?;
        if weight(&again) < weight(&found) && !interrupt::asked() {
            return Ok((Some(shown), again));
        }
    }
    Ok((None, found))
}

/// Shares of an interval by which an input is tried to act ahead of its stamp.
const AHEAD: [f64; 3] = [-0.4, -0.25, -0.1];
/// And behind it.
const BEHIND: [f64; 2] = [0.1, 0.3];

/// Whether a fit would gain by far where the input acted ahead of its stamp, and more than behind it.
fn acts_ahead(problem: &Problem<'_>, nominal: &Model, fit: &Fit) -> bool {
    let interval = problem.record.grid.typical_interval();
    let Some(test) = ScoreTest::new(*problem, nominal, fit, 0) else { return false };
    let most = |shares: &[f64]| {
        let tried = shares.iter().map(|share| late(*share, interval));
        let gains = test.gains(&tried.collect::<Vec<_>>());
        gains.iter().fold(0.0, |most: f64, gain| most.max(gain.real))
    };
    most(&AHEAD) > most(&BEHIND) + LEAST
}

/// How many encoders were found to be late.
fn delays(found: &Search) -> usize {
    late_encoders(found.rounds.iter().map(|round| round.name))
}

/// What a search's answer costs, its names included.
fn weight(found: &Search) -> f64 {
    cost(&found.after.fit) + WEAK * found.rounds.len() as f64
}

#[cfg(test)]
mod tests {
    use joint_core::params::Location;

    use super::*;
    use crate::demo::actuator;
    use crate::synthetic::{Experiment, record};

    /// What is found in a second of an actuator whose encoders are late, of which the current alone is known; half an
    /// interval, by which a measured current is ahead of its stamp; and by how much it is said to be.
    fn found(encoders: &[Location], delay_s: f64) -> (Search, f64, f64) {
        let nominal = actuator();
        let mut truth = nominal.clone();
        for encoder in encoders {
            let late = EffectParameters::new(Kind::SensorDelay, *encoder);
            truth.effects.push(late.with("delay_s", delay_s));
        }
        let second = Experiment { duration_s: 1.0, ..Experiment::default() };
        let mut log = record(&truth, &second, 3).unwrap();
        log.voltage_v = None;
        let record = Record::new(&log, Some(2));
        let mask = vec![1.0; record.len()];
        let half = 0.5 * record.grid.typical_interval();
        let bar = ProgressBar::hidden();
        let Timed { record, found, .. } =
            search_timed(record, &mask, &nominal, (&[], &[]), &bar).unwrap();
        (found, half, record.lead_s())
    }

    fn names(found: &Search) -> Vec<(Kind, Location)> {
        found.rounds.iter().map(|round| round.name).collect()
    }

    #[test]
    fn a_late_encoder_does_not_hide_that_the_current_was_measured() {
        let (found, half, lead_s) = found(&[Location::Encoder], 7e-4);
        assert_eq!(names(&found), [(Kind::SensorDelay, Location::Encoder)]);
        assert_eq!(lead_s, half);
    }

    #[test]
    fn encoders_that_are_late_alike_are_an_input_that_acts_late() {
        // A third of an interval: as a command it would be ahead of its stamp.
        let wanted = 0.3 * actuator().sensor.sample_time_s;
        let (found, half, lead_s) = found(&[Location::Encoder, Location::OutputEncoder], wanted);
        assert_eq!(names(&found), [(Kind::InputDelay, Location::Inverter)]);
        assert_eq!(lead_s, half);
        // Between samples a measured current is not the step that is taken for it: on a ramp its middle is
        // right, on a bend less so, by a tenth of half an interval at most.
        let found = found.after.fit.model.effects[0].values[0];
        assert!((found - wanted).abs() < 0.1 * half, "{found} {wanted}");
    }
}
