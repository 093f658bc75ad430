//! From a nominal model to the best one of the same structure.
//!
//! Where friction sticks and slips, the likelihood of a filter that trusts its model is multimodal: a
//! search that begins there ends in the next local minimum, with the scale of a whole stage tens of per
//! cent off. A filter that trusts the model little takes every sample on its own and sees a smooth
//! slope, so the search begins with that one, and trust grows on the way. What even that one hardly
//! sees is the scale of a whole stage: spring, inertia and friction times one factor move the same
//! way and only push differently on the mass ahead. The inertias behind gears, which a drawing gives
//! best, are held until the springs fit them. This holds for a record in which nothing is missing:
//! elsewhere, and where it ends with more noise than one believes, springs are tried stiffer and
//! softer: twenty per cent off puts the chain's modes out of phase with the record.

use std::borrow::Cow;

use rayon::prelude::*;

use super::coordinates::Coordinate;
use super::filter::{Linearisation, Noise};
use super::fit::{Fit, Known, Problem};
use super::late::is_between_samples;
use super::noise;
use super::parameters::Quantity;
use joint_simulation::model::Model;
use joint_simulation::plant::BuildError;

/// How far a spring is tried off its nominal, in the logarithm.
pub const SPRING_TRIAL: f64 = 0.2;
/// How much less the model is trusted at first: times the expected noise.
const COOLING: [f64; 2] = [30.0, 10.0];
/// Most rounds at each of these.
const COOLING_ROUNDS: usize = 6;
/// How much less the model is trusted while the springs are tried.
const DISTRUST: f64 = 3.0;

/// Stages from which on a likelihood is taken to be multimodal, and fits are made by either slope.
pub const MULTIMODAL: usize = 2;

/// Most rounds of converging.
const ATTEMPTS: usize = 4;
/// What another round must gain of minus twice the log-likelihood to be followed by one more.
const WORTHWHILE: f64 = 10.0;
/// Most of its noise that other springs may leave a doubted fit for more to be tried.
const HELPED: f64 = 0.8;
/// Times the expected noise from which on a fit tells nothing, but for want of better.
pub const ADRIFT: f64 = 100.0;
/// Times the expected noise from which on a refitted nominal is lost: no linear step from there can be
/// believed.
pub const LOST: f64 = 10.0;
/// Times the expected noise from which on a fit is doubted: no right model needs more.
pub const DOUBTFUL: f64 = 2.2;
/// The same of a model with effects that were found, whose laws may be slightly other than the joint's.
pub const DOUBTED: f64 = 3.0;

/// Refits every parameter of a model to a record; `origin` centres the priors.
///
/// # Errors
/// The model cannot be built.
pub fn refit(problem: &Problem<'_>, origin: &Model) -> Result<Fit, BuildError> {
    let moved = coordinates(origin, problem);
    let sights = if origin.stages.len() < MULTIMODAL { &[false][..] } else { &[false, true] };
    let fits = sights
        .par_iter()
        .map(|long| resettle(&problem.long_sighted(*long), origin, origin, &moved))
        .collect::<Result<Vec<_>, _>>()?;
    let best = fits.into_iter().min_by(|a, b| cost(a).total_cmp(&cost(b)));
    best.map_or_else(|| resettle(problem, origin, origin, &moved), Ok)
}

/// Refits from a start whose springs may lie in a wrong local minimum.
///
/// # Errors
/// The model cannot be built.
pub fn resettle(
    problem: &Problem<'_>,
    origin: &Model,
    start: &Model,
    coordinates: &[Coordinate],
) -> Result<Fit, BuildError> {
    let expected = noise::expected(origin, problem.record);
    let passing = problem.passing();
    let mut start = start.clone();
    let held = |c: &&Coordinate| !matches!(c, Coordinate::Parameter(Quantity::Inertia(1..)));
    let scaled: Vec<Coordinate> = coordinates.iter().filter(held).copied().collect();
    for distrust in if problem.cautious { &COOLING[..] } else { &[] } {
        let loose = expected.distrusted(*distrust);
        start = passing.fit(origin, &start, &scaled, &loose, COOLING_ROUNDS)?.model;
    }
    // Whatever the model misses is noise at first, or the parameters would bend to explain it.
    let apparent = noise::refine(problem, &start, &expected, &expected)?;
    let wide = Noise {
        drive: apparent.drive.max(DISTRUST * expected.drive),
        torque: apparent.torque.max(DISTRUST * expected.torque),
        output: apparent.output.max(DISTRUST * expected.output),
        ..apparent
    };
    let mut best = passing.fit(origin, &start, coordinates, &wide, 3)?;
    let settled = problem.cautious && !doubtful(&apparent, &expected);
    let trials = if settled { 0 } else { origin.stages.len() };
    for stage in (0..trials).rev() {
        let from = best.model.clone();
        let spring = Quantity::Stiffness(stage);
        let here = spring.distance(origin, &from);
        let trials = [-SPRING_TRIAL, 0.0, SPRING_TRIAL].into_par_iter();
        let fits = trials
            .filter(|trial| (trial - here).abs() >= SPRING_TRIAL / 2.0)
            .map(|trial| {
                let mut start = from.clone();
                spring.shift(&mut start, trial - here);
                passing.fit(origin, &start, coordinates, &wide, 3)
            })
            .collect::<Result<Vec<_>, _>>()?;
        for fit in fits {
            if cost(&fit) < cost(&best) {
                best = fit;
            }
        }
    }
    // Of a model that is adrift the rest tells nothing.
    let adrift = |fit: &Fit| fit.noise.times(&expected) > ADRIFT;
    polish_unless(adrift, problem, origin, &best.model, coordinates, &expected, &wide)
}

/// A fit of the part of the record that fits on the way look at, polished on all of it.
///
/// # Errors
/// The model cannot be built.
pub fn finish(
    problem: &Problem<'_>,
    origin: &Model,
    near: Fit,
    expected: &Noise,
) -> Result<Fit, BuildError> {
    if problem.scout.is_none() {
        return Ok(near);
    }
    let adrift = |fit: &Fit| fit.noise.times(expected) > ADRIFT;
    let Fit { model, coordinates, noise, .. } = &near;
    polish_unless(adrift, problem, origin, model, coordinates, expected, noise)
}

/// Refits from a model that is near already, and the noise with it.
///
/// # Errors
/// The model cannot be built.
pub fn polish(
    problem: &Problem<'_>,
    origin: &Model,
    start: &Model,
    coordinates: &[Coordinate],
    expected: &Noise,
    noise: &Noise,
) -> Result<Fit, BuildError> {
    polish_unless(|_| false, problem, origin, start, coordinates, expected, noise)
}

/// The same, content with the first half of it where that says enough.
///
/// # Errors
/// The model cannot be built.
pub fn polish_unless(
    enough: impl Fn(&Fit) -> bool,
    problem: &Problem<'_>,
    origin: &Model,
    start: &Model,
    coordinates: &[Coordinate],
    expected: &Noise,
    noise: &Noise,
) -> Result<Fit, BuildError> {
    let along = &mut Cow::Owned(Linearisation::default());
    let first = noise::refine_along(problem, along, start, expected, noise)?;
    let known = Known { along, near: None };
    let fit = problem.fit_from(known, origin, start, coordinates, &first, 6)?;
    // Where the model has not moved a second half finds little, though a lost one's noise may be on its way.
    if enough(&fit) || fit.gained.abs() < problem.worth {
        return Ok(fit);
    }
    let second = noise::refine_along(problem, along, &fit.model, expected, &first)?;
    let known = Known { along, near: None };
    problem.fit_from(known, origin, &fit.model, coordinates, &second, 4)
}

/// Polishes a fit until nothing is gained any more.
///
/// # Errors
/// The model cannot be built.
pub fn polish_on(
    problem: &Problem<'_>,
    origin: &Model,
    start: Fit,
    expected: &Noise,
) -> Result<Fit, BuildError> {
    let mut best = start;
    for _ in 0..ATTEMPTS {
        if polished(problem, origin, &mut best, expected)? <= WORTHWHILE {
            break;
        }
    }
    Ok(best)
}

/// Polishes a fit once, if that gains anything; what it gained.
fn polished(
    problem: &Problem<'_>,
    origin: &Model,
    best: &mut Fit,
    expected: &Noise,
) -> Result<f64, BuildError> {
    let again = polish(problem, origin, &best.model, &best.coordinates, expected, &best.noise)?;
    let gained = cost(best) - cost(&again);
    if gained > 0.0 {
        *best = again;
    }
    best.rests = gained <= WORTHWHILE;
    Ok(gained)
}

/// Refits on until nothing is gained any more: polishing again as long as that helps, and from
/// other springs where the noise is still beyond belief, as long as they leave less of it.
///
/// # Errors
/// The model cannot be built.
pub fn converge(
    problem: &Problem<'_>,
    origin: &Model,
    start: Fit,
    expected: &Noise,
) -> Result<Fit, BuildError> {
    converge_unless(|_| false, problem, origin, start, expected)
}

/// The same; a fit that polishing does not improve is not refitted from other springs where it says `enough`. Of a long
/// record all but the last refit look at a part.
///
/// # Errors
/// The model cannot be built.
pub fn converge_unless(
    enough: impl Fn(&Fit) -> bool,
    problem: &Problem<'_>,
    origin: &Model,
    start: Fit,
    expected: &Noise,
) -> Result<Fit, BuildError> {
    if problem.scout.is_none() {
        return converge_on(enough, problem, origin, start, expected);
    }
    if enough(&start) {
        return polish_on(problem, origin, start, expected);
    }
    let (ahead, moved) = (problem.ahead(), &start.coordinates);
    let near = polish(&ahead, origin, &start.model, moved, expected, &start.noise)?;
    let near = converge_on(|_| false, &ahead, origin, near, expected)?;
    let fit = finish(problem, origin, near, expected)?;
    Ok(if cost(&fit) < cost(&start) { fit } else { start })
}

/// The same, every refit on the same samples.
fn converge_on(
    enough: impl Fn(&Fit) -> bool,
    problem: &Problem<'_>,
    origin: &Model,
    start: Fit,
    expected: &Noise,
) -> Result<Fit, BuildError> {
    // A nominal's own effects are not moved, and excuse nothing.
    let found = start.coordinates.iter().any(|c| !matches!(c, Coordinate::Parameter(_)));
    let most = if found { DOUBTED } else { DOUBTFUL };
    let doubtful = |fit: &Fit| fit.noise.times(expected) > most;
    // One that rests need not be polished before it is known whether it stays.
    let mut owed = start.rests && doubtful(&start);
    let mut best = start;
    for attempt in 0..ATTEMPTS {
        if !owed && polished(problem, origin, &mut best, expected)? > WORTHWHILE {
            continue;
        }
        if attempt + 1 == ATTEMPTS || !doubtful(&best) || enough(&best) {
            break;
        }
        let mut moved = cooled(problem, origin, &best, expected)?;
        if doubtful(&moved) && !origin.stages.is_empty() {
            let from = if cost(&moved) < cost(&best) { &moved } else { &best };
            moved = resettle(problem, origin, &from.model, &best.coordinates)?;
        }
        let gained = cost(&best) - cost(&moved);
        // Where other springs leave as much noise, the fit was in no wrong local minimum.
        let helped = moved.noise.times(expected) < HELPED * best.noise.times(expected);
        if gained > 0.0 {
            best = moved;
            owed = false;
        }
        if gained <= WORTHWHILE || !helped {
            break;
        }
    }
    if owed {
        polished(problem, origin, &mut best, expected)?;
    }
    Ok(best)
}

/// Refits with trust that grows step by step, from where a fit is and from where its priors are, each
/// with the effects that were found: noise that had swallowed what was missing holds parameters where
/// they were bent to, and does not let go when it is missing no more.
///
/// # Errors
/// The model cannot be built.
pub fn cooled(
    problem: &Problem<'_>,
    origin: &Model,
    fit: &Fit,
    expected: &Noise,
) -> Result<Fit, BuildError> {
    let anew = Model { effects: fit.model.effects.clone(), ..origin.clone() };
    let fits = [(&fit.model, false), (&anew, origin.stages.len() >= MULTIMODAL)]
        .into_par_iter()
        .map(|(start, long)| {
            let problem = &problem.long_sighted(long);
            let mut start = start.clone();
            let mut loose = *expected;
            for distrust in COOLING.into_iter().chain([DISTRUST]) {
                loose = Noise { sensors: fit.noise.sensors, ..expected.distrusted(distrust) };
                let rounds = COOLING_ROUNDS;
                let passing = problem.passing();
                start = passing.fit(origin, &start, &fit.coordinates, &loose, rounds)?.model;
            }
            polish(&problem.ahead(), origin, &start, &fit.coordinates, expected, &loose)
        })
        .collect::<Result<Vec<_>, _>>()?;
    let best = fits.into_iter().min_by(|a, b| cost(a).total_cmp(&cost(b)));
    best.map_or_else(|| Ok(fit.clone()), |near| finish(problem, origin, near, expected))
}

/// Whether a model asks for more noise than one believes.
fn doubtful(noise: &Noise, expected: &Noise) -> bool {
    noise.times(expected) > DOUBTFUL
}

/// Deviance and prior together: what fits are compared by.
pub fn cost(fit: &Fit) -> f64 {
    fit.deviance + fit.prior
}

/// The parameters that a refit of this model moves; a delay of the current by whole samples is held.
pub fn coordinates(model: &Model, problem: &Problem<'_>) -> Vec<Coordinate> {
    let record = problem.record;
    let levels = Quantity::levels(model, record.logs());
    let delay = is_between_samples(model, record).then_some(Quantity::CurrentDelay);
    let all = Quantity::of(model, record.drive).into_iter().chain(levels).chain(delay);
    all.map(Coordinate::Parameter).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::Record;
    use crate::scout::Scout;
    use joint_simulation::demo::actuator;
    use joint_simulation::synthetic::{Experiment, record};

    #[test]
    fn friction_of_another_day_is_another_level_and_no_other_parameter() {
        let truth = actuator();
        let day = |level: f64, seed| {
            record(&truth.with_friction(level), &Experiment::clean(0.5), seed).unwrap()
        };
        let record = Record::join(&[day(1.0, 5), day(1.25, 6), day(0.9, 7)], None).unwrap();
        assert_eq!(record.logs(), 3);
        let mask = vec![1.0; record.len()];
        let problem = Problem::new(&record, &mask).rough();
        let mut nominal = truth.clone();
        nominal.motor.friction.coulomb_nm *= 1.2;
        let fit = refit(&problem, &nominal).unwrap();
        for (log, level) in [1.0, 1.25, 0.9].into_iter().enumerate() {
            let found = fit.model.friction_level(log);
            assert!((found / level - 1.0).abs() < 0.02, "{log}: {found}");
        }
        let coulomb = fit.model.motor.friction.coulomb_nm / truth.motor.friction.coulomb_nm;
        assert!((coulomb - 1.0).abs() < 0.03, "{coulomb}");
        // Thinned, stretched and refined it is of the same days.
        let thinned = record.thinned(1200).refined(2);
        assert_eq!((thinned.logs(), thinned.grid.log(0), thinned.grid.log(1199)), (3, 0, 2));
    }

    #[test]
    fn a_long_record_is_fitted_as_well_from_a_part_of_it_as_from_all() {
        let truth = actuator();
        let experiment =
            Experiment { sample_time_s: 2e-4, duration_s: 1.8, ..Experiment::default() };
        let record = Record::new(&record(&truth, &experiment, 5).unwrap(), Some(2));
        let mask = vec![1.0; record.len()];
        let mut nominal = truth.clone();
        Quantity::Stiffness(0).shift(&mut nominal, 0.1);
        nominal.motor.friction.coulomb_nm *= 1.2;
        let scout = Scout::of(&record, &mask, &nominal).unwrap();
        let whole = Problem::new(&record, &mask);
        let scouted = whole.scouted(Some(&scout));
        let expected = noise::expected(&nominal, &record);
        let [all, part] = [whole, scouted].map(|problem| refit(&problem, &nominal).unwrap());
        assert_eq!(part.innovations.len(), record.len());
        assert!((cost(&part) - cost(&all)).abs() < WORTHWHILE, "{} {}", cost(&part), cost(&all));
        // Refitted on, from where nothing is gained, and from elsewhere.
        let moved = &part.coordinates;
        let begun = whole.fit(&nominal, &nominal, moved, &expected, 1).unwrap();
        let converged = converge(&scouted, &nominal, begun.clone(), &expected).unwrap();
        assert!((cost(&converged) - cost(&all)).abs() < WORTHWHILE, "{}", cost(&converged));
        let cooled = cooled(&scouted, &nominal, &begun, &expected).unwrap();
        assert!((cost(&cooled) - cost(&all)).abs() < WORTHWHILE, "{}", cost(&cooled));
        let stays = converge(&scouted, &nominal, all.clone(), &expected).unwrap();
        assert!(cost(&stays) <= cost(&all));
        let enough = converge_unless(|_| true, &scouted, &nominal, begun.clone(), &expected);
        assert!(cost(&enough.unwrap()) < cost(&begun));
    }

    #[test]
    fn a_fit_that_rests_gains_little_when_it_is_polished_again() {
        let truth = actuator();
        let log = record(&truth, &Experiment::clean(0.4), 5).unwrap();
        let record = Record::new(&log, None);
        let mask = vec![1.0; record.len()];
        let problem = Problem::new(&record, &mask).rough();
        let mut nominal = truth.clone();
        Quantity::Stiffness(0).shift(&mut nominal, 0.1);
        nominal.motor.friction.coulomb_nm *= 1.3;
        let expected = noise::expected(&nominal, &record);
        let moved = coordinates(&nominal, &problem);
        let begun = problem.fit(&nominal, &nominal, &moved, &expected, 1).unwrap();
        assert!(!begun.rests);
        let again = polish(&problem, &nominal, &begun.model, &moved, &expected, &expected).unwrap();
        assert!(cost(&begun) - cost(&again) > WORTHWHILE && !again.rests);
        let rests = polish_on(&problem, &nominal, begun, &expected).unwrap();
        assert!(rests.rests);
        let again = polish(&problem, &nominal, &rests.model, &moved, &expected, &rests.noise);
        assert!(cost(&rests) - cost(&again.unwrap()) <= WORTHWHILE);
        // One that is believed is polished all the same, and gets no worse.
        let converged = converge(&problem, &nominal, rests.clone(), &expected).unwrap();
        assert!(converged.rests && cost(&converged) <= cost(&rests));
        // Of a doubted one that stays where it is nothing is lost either.
        let Noise { drive, torque, .. } = rests.noise;
        let calmer = Noise { drive: 0.2 * drive, torque: 0.2 * torque, ..expected };
        assert!(rests.noise.times(&calmer) > DOUBTFUL);
        let converged = converge(&problem, &nominal, rests.clone(), &calmer).unwrap();
        assert!(cost(&converged) <= cost(&rests));
        // Where it says enough, no other springs are tried, and polishing is all that it gets.
        let once = converge_unless(|_| true, &problem, &nominal, rests.clone(), &calmer).unwrap();
        let mut polished_once = rests.clone();
        polished(&problem, &nominal, &mut polished_once, &calmer).unwrap();
        assert_eq!(cost(&once), cost(&polished_once));
    }
}
