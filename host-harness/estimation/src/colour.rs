//! Disturbances that are correlated in time: friction that wanders, the load of other axes, a chatter.
//!
//! Measured joints are disturbed over many samples at a time. A filter that takes such a disturbance for
//! white noise counts every sample as a witness of its own: likelihoods, standard errors and bounds are off by
//! the root of twice the correlation length. So the disturbance is a state of the filter (an
//! Ornstein-Uhlenbeck process), beside the white noises, wherever it makes the log likelier.

use std::borrow::Cow;

use joint_core::joint::Drive;
use rayon::prelude::*;

use super::filter::{Colour, Disturbed, Linearisation, Noise};
use super::fit::Problem;
use super::noise::refine_along;
use super::record::{Channel, Record};
use super::scoring::Source;
use crate::interrupt;
use joint_simulation::model::Model;
use joint_simulation::plant::BuildError;

/// Correlation times that are tried: from so many intervals, up to this share of the record, each so many
/// times the one before.
const SHORTEST: f64 = 2.0;
const LONGEST: f64 = 0.1;
const RATIO: f64 = 4.0;
/// Most white noise, over what is expected, that the search for a disturbance begins with.
const WHITE: f64 = 3.0;
/// Share of the white noise's power that the score test's disturbance has: next to none.
const SMALL: f64 = 1e-3;
/// Share of what a disturbance has to gain that the score test has to promise of one, for it to be fitted.
const PROMISING: f64 = 0.25;

/// The noise at a model, with a coloured disturbance on every equation where that makes the record likelier by
/// more than two numbers should (Schwarz, Ann. Stat. 6, 1978). One that `start` has is asked again, near its correlation
/// time.
///
/// # Errors
/// The model cannot be built.
pub fn coloured(
    problem: &Problem<'_>,
    model: &Model,
    expected: &Noise,
    start: &Noise,
) -> Result<Noise, BuildError> {
    let mut along = Cow::Owned(Linearisation::default());
    let mut best = refine_along(problem, &mut along, model, expected, start)?;
    let along = &*along;
    let mut least = problem.deviance_along(along, model, &best)?;
    let samples = problem.mask.iter().sum::<f64>().max(2.0);
    (least, best) = reversing(problem, along, model, expected, (least, best))?;
    for place in places(problem.record) {
        if interrupt::asked() {
            break;
        }
        let plain = without(&best, place);
        let known = best.coloured[place as usize].deviation > 0.0;
        let without = match known {
            false => (least, plain),
            true => tried(problem, along, model, expected, &plain)?,
        };
        // A known one is asked again near its correlation time alone.
        let own = best.coloured[place as usize].correlation_s;
        let near = |time: &f64| !known || (time / own).ln().abs() < 1.5 * RATIO.ln();
        let bound = 2.0 * samples.ln();
        let times: Vec<f64> = times(problem.record).filter(near).collect();
        let trials = times.into_par_iter().map(|correlation_s| {
            let promised = || promised(problem, along, model, &plain, (place, correlation_s));
            if !known && promised()? < PROMISING * bound {
                return Ok(None);
            }
            let begun = begun(problem.record, expected, &best, place, correlation_s);
            tried(problem, along, model, expected, &begun).map(Some)
        });
        let trials = trials.collect::<Result<Vec<_>, BuildError>>()?;
        let with = trials.into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0));
        let Some(with) = with else { continue };
        let better = if without.0 - with.0 > bound { with } else { without };
        if !known || better.0 < least || better.1 == without.1 {
            (least, best) = better;
        }
    }
    Ok(best)
}

/// Whether what the drive does at a noise beside what it is told is white: no disturbance that is correlated in time
/// makes the record likelier.
///
/// # Errors
/// The model cannot be built.
pub fn drive_is_white(
    problem: &Problem<'_>,
    model: &Model,
    expected: &Noise,
    noise: &Noise,
) -> Result<bool, BuildError> {
    let mut along = Cow::Owned(Linearisation::default());
    let noise = refine_along(problem, &mut along, model, expected, noise)?;
    let white = problem.deviance_along(&along, model, &noise)?;
    let bound = 2.0 * problem.mask.iter().sum::<f64>().max(2.0).ln();
    let coloured = times(problem.record).collect::<Vec<_>>().into_par_iter().map(|correlation_s| {
        let place = Disturbed::Drive;
        if promised(problem, &along, model, &noise, (place, correlation_s))? < PROMISING * bound {
            return Ok(white);
        }
        let begun = begun(problem.record, expected, &noise, place, correlation_s);
        tried(problem, &along, model, expected, &begun).map(|(coloured, _)| coloured)
    });
    let coloured = coloured.collect::<Result<Vec<_>, BuildError>>()?;
    Ok(coloured.into_iter().all(|coloured| white - coloured <= bound))
}

/// What a disturbance of a correlation time promises to take from minus twice the log-likelihood, by its score where it is
/// next to nothing, beside white noises that are free (Rao, Proc. Camb. Phil. Soc. 44, 1948): zero where less than
/// none is asked for.
fn promised(
    problem: &Problem<'_>,
    along: &Linearisation,
    model: &Model,
    noise: &Noise,
    (place, correlation_s): (Disturbed, f64),
) -> Result<f64, BuildError> {
    let mut small = begun(problem.record, noise, &without(noise, place), place, correlation_s);
    small.coloured[place as usize].deviation *= f64::sqrt(SMALL);
    let mut sources = vec![Source::Torque, Source::Coloured(place)];
    if problem.record.drive == Drive::Voltage {
        sources.insert(0, Source::Drive);
    }
    let along = &mut Cow::Borrowed(along);
    let (_, gradient, curvature) = problem.scored_along(along, model, &small, &sources)?;
    let own = sources.len() - 1;
    let across = curvature.view((0, own), (own, 1)).into_owned();
    let Some(free) = curvature.view((0, 0), (own, own)).into_owned().cholesky() else {
        return Ok(f64::INFINITY);
    };
    let beside = free.solve(&across);
    let slope = gradient[own] - beside.dot(&gradient.rows(0, own));
    let curvature = curvature[(own, own)] - beside.dot(&across);
    Ok(match slope < 0.0 && curvature > 0.0 {
        true => 0.5 * slope * slope / curvature,
        false => 0.0,
    })
}

/// The same with a noise of the reversal or without, whichever this record asks for by more than one number
/// should.
fn reversing(
    problem: &Problem<'_>,
    along: &Linearisation,
    model: &Model,
    expected: &Noise,
    (least, best): (f64, Noise),
) -> Result<(f64, Noise), BuildError> {
    let plain = Noise { reversal: 0.0, ..best };
    let known = best.reversal > 0.0;
    let begun = match known {
        true => plain,
        false => Noise { reversal: plain.torque.max(expected.torque), ..plain },
    };
    let other = tried(problem, along, model, expected, &begun)?;
    let [without, with] = if known { [other, (least, best)] } else { [(least, best), other] };
    let samples = problem.mask.iter().sum::<f64>().max(2.0);
    Ok(if without.0 - with.0 > samples.ln() { with } else { without })
}

/// Where a record could tell a disturbance from another.
fn places(record: &Record) -> impl Iterator<Item = Disturbed> {
    let possible = [
        (Disturbed::Rotor, true),
        (Disturbed::Drive, record.drive == Drive::Voltage && record.has(Channel::Current)),
    ];
    possible.into_iter().filter(|(_, possible)| *possible).map(|(place, _)| place)
}

/// Correlation times that are tried, s.
fn times(record: &Record) -> impl Iterator<Item = f64> + use<> {
    let length = match (record.time_s.first(), record.time_s.last()) {
        (Some(first), Some(last)) => last - first,
        _ => 0.0,
    };
    let shortest = SHORTEST * record.grid.typical_interval();
    let longest = LONGEST * length;
    std::iter::successors(Some(shortest), |time| Some(RATIO * time))
        .take_while(move |time| *time <= longest)
}

fn without(noise: &Noise, place: Disturbed) -> Noise {
    let mut noise = *noise;
    noise.coloured[place as usize] = Colour::default();
    noise
}

/// A noise with a disturbance of as much power as the white noise there has.
fn begun(
    record: &Record,
    expected: &Noise,
    noise: &Noise,
    place: Disturbed,
    correlation_s: f64,
) -> Noise {
    let mut noise = *noise;
    let share = (record.grid.typical_interval() / (2.0 * correlation_s)).sqrt();
    let (white, most) = match place {
        Disturbed::Drive => (&mut noise.drive, expected.drive),
        _ => (&mut noise.torque, expected.torque),
    };
    let deviation = share * white.max(most);
    *white = white.min(WHITE * most);
    noise.coloured[place as usize] = Colour { deviation, correlation_s };
    noise
}

/// The noise refined from a start, and minus twice the log-likelihood at it.
fn tried(
    problem: &Problem<'_>,
    along: &Linearisation,
    model: &Model,
    expected: &Noise,
    start: &Noise,
) -> Result<(f64, Noise), BuildError> {
    let rough = problem.rough();
    let noise = refine_along(&rough, &mut Cow::Borrowed(along), model, expected, start)?;
    Ok((problem.deviance_along(along, model, &noise)?, noise))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::expected;
    use crate::replicate;
    use joint_simulation::demo::actuator;
    use joint_simulation::synthetic::{Experiment, record};

    /// A second of an actuator's motion, as its own replicate would have shown it at a noise.
    fn replicate(noise: impl Fn(Noise) -> Noise) -> (Model, Record, Noise, Noise) {
        let model = actuator();
        let log = record(&model, &Experiment { duration_s: 2.0, ..Experiment::default() }, 3);
        let record = Record::new(&log.unwrap(), Some(2));
        let expected = expected(&model, &record);
        let noise = noise(expected);
        let record = replicate::replicate(&model, &record, &noise, 7).unwrap();
        (model, record, expected, noise)
    }

    #[test]
    fn a_disturbance_is_found_with_its_size_and_its_time_and_none_where_there_is_none() {
        let colour =
            |expected: Noise| Colour { deviation: 6.0 * expected.torque, correlation_s: 0.02 };
        let with = |expected: Noise| {
            let mut noise = expected;
            noise.coloured[Disturbed::Rotor as usize] = colour(expected);
            noise
        };
        let (model, record, expected, noise) = replicate(with);
        let mask = vec![1.0; record.len()];
        let problem = Problem::new(&record, &mask);
        let found = coloured(&problem, &model, &expected, &expected).unwrap();
        let [_, own, _] = found.coloured;
        let [_, true_, _] = noise.coloured;
        // 100 correlation times tell the deviation to a tenth; times are tried a factor of four apart.
        assert!((own.deviation / true_.deviation).ln().abs() < 0.4, "{own:?} {true_:?}");
        assert!((own.correlation_s / true_.correlation_s).ln().abs() < RATIO.ln(), "{own:?}");
        // Asked again it stays, and from another correlation time it comes nearer.
        let again = coloured(&problem, &model, &expected, &found).unwrap().coloured[1];
        assert!((again.deviation / own.deviation).ln().abs() < 0.1, "{again:?} {own:?}");
        assert_eq!(again.correlation_s, own.correlation_s);
        let mut other = found;
        other.coloured[1].correlation_s *= RATIO * RATIO;
        let again = coloured(&problem, &model, &expected, &other).unwrap().coloured[1];
        assert!(again.correlation_s < 0.5 * other.coloured[1].correlation_s, "{again:?} {own:?}");
        // Most of the power of slow torques is the disturbance's, 2 σ² τ; white noise takes a filter's errors too.
        let interval = record.grid.typical_interval();
        let slow = 2.0 * own.deviation * own.deviation * own.correlation_s;
        assert!(found.torque * found.torque * interval < 0.05 * slow, "{found:?}");

        let (model, record, expected, _) = replicate(|expected| expected);
        let problem = Problem::new(&record, &mask);
        let found = coloured(&problem, &model, &expected, &expected).unwrap();
        assert!(!found.is_disturbed(), "{found:?}");
    }

    #[test]
    fn the_score_promises_a_disturbance_that_is_there_and_none_that_is_not() {
        for (times, there) in [(0.0, false), (2.0, true), (40.0, true)] {
            let (model, record, expected, _) = replicate(|expected| {
                let mut noise = expected;
                let deviation = times * expected.torque;
                noise.coloured[Disturbed::Rotor as usize] =
                    Colour { deviation, correlation_s: 0.02 };
                noise
            });
            let mask = vec![1.0; record.len()];
            let problem = Problem::new(&record, &mask);
            let mut along = Cow::Owned(Linearisation::default());
            let noise = refine_along(&problem, &mut along, &model, &expected, &expected).unwrap();
            let most = super::times(&record)
                .map(|time| {
                    promised(&problem, &along, &model, &noise, (Disturbed::Rotor, time)).unwrap()
                })
                .fold(0.0, f64::max);
            let bound = 2.0 * (record.len() as f64).ln();
            assert_eq!(most > bound, there, "{times}: {most}");
        }
    }

    #[test]
    fn what_reversals_bring_is_found_with_its_size_and_is_no_noise_of_the_rest() {
        let with = |expected: Noise| Noise { reversal: 20.0 * expected.torque, ..expected };
        let (model, record, expected, noise) = replicate(with);
        let mask = vec![1.0; record.len()];
        let problem = Problem::new(&record, &mask);
        let plain = refine_along(
            &problem,
            &mut Cow::Owned(Linearisation::default()),
            &model,
            &expected,
            &expected,
        );
        let found = coloured(&problem, &model, &expected, &expected).unwrap();
        assert!((found.reversal / noise.reversal).ln().abs() < 0.2, "{found:?} {noise:?}");
        assert!(found.torque < 0.5 * plain.unwrap().torque && found.colours().count() == 0);
        // Asked again, it stays.
        let again = coloured(&problem, &model, &expected, &found).unwrap();
        assert!((again.reversal / found.reversal).ln().abs() < 0.1, "{again:?} {found:?}");
    }

    #[test]
    fn the_slope_of_the_likelihood_with_reversals_is_that_of_its_differences() {
        let with = |expected: Noise| Noise { reversal: 20.0 * expected.torque, ..expected };
        let (model, record, _, noise) = replicate(with);
        let mask = vec![1.0; record.len()];
        let problem = Problem::new(&record, &mask);
        let along = &mut Cow::Owned(Linearisation::default());
        let source = Source::Reversal;
        let (_, gradient, _) = problem.scored_along(along, &model, &noise, &[source]).unwrap();
        let at = |step: f64| {
            let noise = source.with_sigma(&noise, source.sigma(&noise) * f64::exp(step));
            problem.deviance_along(along, &model, &noise).unwrap()
        };
        let slope = (at(1e-3) - at(-1e-3)) / 2e-3;
        assert!((gradient[0] - slope).abs() < 1e-2 * slope.abs() + 0.5, "{} {slope}", gradient[0]);
    }

    #[test]
    fn the_slope_of_the_likelihood_with_a_disturbance_is_that_of_its_differences() {
        let place = Disturbed::Rotor;
        let with = |mut noise: Noise| {
            let deviation = 2.0 * noise.torque;
            noise.coloured[place as usize] = Colour { deviation, correlation_s: 0.02 };
            noise
        };
        let (model, record, _, noise) = replicate(with);
        let mask: Vec<f64> =
            (0..record.len()).map(|k| f64::from(u8::from(k % 700 < 500))).collect();
        let problem = Problem::new(&record, &mask);
        let along = &mut Cow::Owned(Linearisation::default());
        let source = Source::Coloured(place);
        let (_, gradient, curvature) =
            problem.scored_along(along, &model, &noise, &[source]).unwrap();
        let at = |step: f64| {
            let noise = source.with_sigma(&noise, source.sigma(&noise) * f64::exp(step));
            problem.deviance_along(along, &model, &noise).unwrap()
        };
        let slope = (at(1e-3) - at(-1e-3)) / 2e-3;
        assert!((gradient[0] - slope).abs() < 1e-3 * slope.abs() + 0.1, "{} {slope}", gradient[0]);
        assert!(curvature[(0, 0)] > 0.0);
    }
}
