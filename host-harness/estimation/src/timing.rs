//! What a log does not say of itself: whether a current that is the input was commanded or measured, how quiet
//! its drive is, and whether its output feels a disturbance of its own.
//!
//! A command holds from its sample to the next. A measured current is one point of a curve, and stands for
//! the interval around it: taken as a command it is half an interval late, which looks like encoders that
//! run ahead. A log does not say which of both it holds; its likelihood does.

use joint_core::joint::Drive;

use super::colour::drive_is_white;
use super::fit::{Fit, Problem};
use super::noise;
use super::record::{Channel, Record};
use super::refit::{DOUBTED, LOST, cost};
use joint_simulation::model::Model;
use joint_simulation::plant::BuildError;

/// What a measured current must take from minus twice the log-likelihood to be believed.
pub const LEAST: f64 = 60.0;

/// Fits a record by the samples of a mask, of which it is not known what its current, where that is the input,
/// was, how quiet its drive is, nor whether its output feels a disturbance of its own. A filter that takes the
/// last mass to feel nothing believes the equation there to an encoder's step, and bends all others to it: where
/// such a fit is lost and the other one is likelier by far, that one is taken.
///
/// # Errors
/// The model cannot be built.
pub fn asked(
    model: &Model,
    record: Record,
    mask: &[f64],
    fit: impl Fn(&Record) -> Result<Fit, BuildError> + Sync,
) -> Result<(Record, Fit), BuildError> {
    let (record, first) = timed(record, &fit)?;
    let plain = supplied(model, record, first, mask, &fit)?;
    let (record, first) = &plain;
    let own = model.load.inertia_kg_m2 + model.stages.last().map_or(0.0, |it| it.inertia_kg_m2);
    // On a mass that nobody knows a torque noise would be the encoder's.
    let looked_behind = !model.stages.is_empty() && own > 0.0 && record.has(Channel::Output);
    if !looked_behind || first.noise.times(&noise::expected(model, record)) <= LOST {
        return Ok(plain);
    }
    let disturbed = timed(record.disturbed().commanded(), &fit)?;
    Ok(if cost(first) - cost(&disturbed.1) > LEAST { disturbed } else { plain })
}

/// Fits a record, whose current, where it is the input, is taken as measured if that makes the record
/// likelier by far; else as commanded.
///
/// # Errors
/// The model cannot be built.
pub fn timed(
    record: Record,
    fit: impl Fn(&Record) -> Result<Fit, BuildError> + Sync,
) -> Result<(Record, Fit), BuildError> {
    if record.drive == Drive::Voltage {
        let fit = fit(&record)?;
        return Ok((record, fit));
    }
    let centred = record.centred();
    let (commanded, measured) = rayon::join(|| fit(&record), || fit(&centred));
    let (commanded, measured) = (commanded?, measured?);
    Ok(match cost(&commanded) - cost(&measured) > LEAST {
        true => (centred, measured),
        false => (record, commanded),
    })
}

/// The same with the noise of the drive that the record shows, where that is far more than what one expects and
/// white: a supply that is noisy beside what little a log drives. What a model misses is correlated in time.
fn supplied(
    model: &Model,
    record: Record,
    first: Fit,
    mask: &[f64],
    fit: impl Fn(&Record) -> Result<Fit, BuildError>,
) -> Result<(Record, Fit), BuildError> {
    let expected = noise::expected(model, &record);
    let drive_noise = first.noise.drive;
    let looked_at = record.drive == Drive::Voltage && record.has(Channel::Current);
    if !looked_at
        || drive_noise <= DOUBTED * expected.drive
        || !drive_is_white(&Problem::new(&record, mask), &first.model, &expected, &first.noise)?
    {
        return Ok((record, first));
    }
    let noisy = Record { drive_noise, ..record };
    let again = fit(&noisy)?;
    Ok((noisy, again))
}

/// What a user should know of how the current was taken.
pub fn told(record: &Record) -> Option<&'static str> {
    (record.lead_s() > 0.0).then_some(
        "i_a is taken as measured, not as a command: held from half an interval before its sample, it \
         makes the log likelier",
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::{Colour, Disturbed, Noise};
    use crate::fit::Problem;
    use crate::refit::refit;
    use crate::replicate;
    use joint_simulation::demo::actuator;
    use joint_simulation::log::Log;
    use joint_simulation::synthetic::{Experiment, record};

    /// How long before its sample the current is taken to hold, in intervals, and the current's log.
    fn lead(log: &Log) -> f64 {
        let record = Record::new(log, Some(2));
        let mask = vec![1.0; record.len()];
        let (record, _) =
            timed(record, |record| refit(&Problem::new(record, &mask), &actuator())).unwrap();
        record.lead_s() / record.grid.typical_interval()
    }

    #[test]
    fn a_current_that_was_measured_is_told_from_one_that_was_commanded() {
        let model = actuator();
        let mut log = record(&model, &Experiment::default(), 3).unwrap();
        log.voltage_v = None;
        assert_eq!(lead(&log), 0.5);

        let commanded = Record::new(&log, Some(2));
        let noise = noise::expected(&model, &commanded);
        let replicate = replicate::replicate(&model, &commanded, &noise, 1).unwrap();
        log.motor_angle_rad = replicate.measured.iter().map(|row| row[1]).collect();
        log.output_angle_rad = Some(replicate.measured.iter().map(|row| row[2]).collect());
        assert_eq!(lead(&log), 0.0);
    }

    #[test]
    fn a_drive_that_is_noisy_is_told_from_one_that_is_disturbed() {
        let model = actuator();
        let log = record(&model, &Experiment { duration_s: 1.0, ..Experiment::default() }, 3);
        let quiet = Record::new(&log.unwrap(), Some(2));
        let mask = vec![1.0; quiet.len()];
        let expected = noise::expected(&model, &quiet);
        let asked = |noise: &Noise| {
            let record = replicate::replicate(&model, &quiet, noise, 1).unwrap();
            let fit = |record: &Record| refit(&Problem::new(record, &mask), &model);
            super::asked(&model, record, &mask, fit).unwrap().0.drive_noise
        };
        assert_eq!(asked(&expected), 0.0);
        let noise = Noise { drive: 20.0 * expected.drive, ..expected };
        assert!((asked(&noise) / noise.drive - 1.0).abs() < 0.2);
        let mut noise = expected;
        let deviation = 20.0 * expected.drive;
        noise.coloured[Disturbed::Drive as usize] = Colour { deviation, correlation_s: 5e-3 };
        assert_eq!(asked(&noise), 0.0);
    }

    #[test]
    fn an_output_that_feels_a_disturbance_of_its_own_is_told_from_one_that_does_not() {
        let model = actuator();
        let log = record(&model, &Experiment::default(), 3).unwrap();
        let quiet = Record::new(&log, Some(2));
        let mask = vec![1.0; quiet.len()];
        let asked = |record: Record| {
            let fit = |record: &Record| refit(&Problem::new(record, &mask), &model);
            super::asked(&model, record, &mask, fit).unwrap()
        };
        assert!(!asked(quiet.clone()).0.output_disturbed);
        let expected = noise::expected(&model, &quiet.disturbed());
        let noise = Noise { output: 300.0 * expected.output, ..expected };
        let (record, fit) = asked(replicate::replicate(&model, &quiet, &noise, 1).unwrap());
        assert!(record.output_disturbed);
        assert!((fit.noise.output / noise.output - 1.0).abs() < 0.2, "{:?} {noise:?}", fit.noise);
        let stiffness = |model: &Model| model.stages[0].stiffness_nm_per_rad;
        assert!((stiffness(&fit.model) / stiffness(&model) - 1.0).abs() < 0.05, "{:?}", fit.model);
    }
}
