//! From a nominal model to the best one of the same structure.
//!
//! A spring that is twenty per cent off puts the chain's modes out of phase with the record, and
//! from there a local search slides into a wrong valley; so the springs are tried stiffer and
//! softer first, with a filter that trusts the model little. The rest follows by itself.

use rayon::prelude::*;

use super::coordinates::Coordinate;
use super::filter::Noise;
use super::fit::{Fit, Problem};
use super::noise;
use super::parameters::Quantity;
use crate::model::Model;
use crate::plant::BuildError;

/// How far a spring is tried off its nominal, in the logarithm.
pub const SPRING_TRIAL: f64 = 0.2;
/// How much less the model is trusted while the springs are tried.
const DISTRUST: f64 = 3.0;

/// Most rounds of converging.
const ATTEMPTS: usize = 4;
/// What another round must gain of minus twice the log-likelihood to be followed by one more.
const WORTHWHILE: f64 = 10.0;
/// Times the expected noise from which on a fit is doubted.
const DOUBTFUL: f64 = 2.0;

/// Refits every parameter of a model to a record; `origin` centres the priors.
///
/// # Errors
/// The model cannot be built.
pub fn refit(problem: &Problem<'_>, origin: &Model) -> Result<Fit, BuildError> {
    resettle(problem, origin, origin, &coordinates(origin, problem))
}

/// Refits from a start whose springs may lie in a wrong valley.
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
    // Whatever the model misses is noise at first, or the parameters would bend to explain it.
    let apparent = noise::refine(problem, start, &expected, &expected)?;
    let wide = Noise {
        drive: apparent.drive.max(DISTRUST * expected.drive),
        torque: apparent.torque.max(DISTRUST * expected.torque),
        ..apparent
    };
    let mut best = problem.fit(origin, start, coordinates, &wide, 3)?;
    for stage in (0..origin.stages.len()).rev() {
        let from = best.model.clone();
        let spring = Quantity::Stiffness(stage);
        let here = spring.distance(origin, &from);
        let trials = [-SPRING_TRIAL, 0.0, SPRING_TRIAL].into_par_iter();
        let fits = trials
            .filter(|trial| (trial - here).abs() >= SPRING_TRIAL / 2.0)
            .map(|trial| {
                let mut start = from.clone();
                spring.shift(&mut start, trial - here);
                problem.fit(origin, &start, coordinates, &wide, 3)
            })
            .collect::<Result<Vec<_>, _>>()?;
        for fit in fits {
            if cost(&fit) < cost(&best) {
                best = fit;
            }
        }
    }
    polish(problem, origin, &best.model, coordinates, &expected, &wide)
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
    let first = noise::refine(problem, start, expected, noise)?;
    let fit = problem.fit(origin, start, coordinates, &first, 6)?;
    let second = noise::refine(problem, &fit.model, expected, &first)?;
    problem.fit(origin, &fit.model, coordinates, &second, 4)
}

/// Refits on until nothing is gained any more: polishing again as long as that helps, and from
/// other springs where the noise is still beyond belief.
///
/// # Errors
/// The model cannot be built.
pub fn converge(
    problem: &Problem<'_>,
    origin: &Model,
    start: Fit,
    expected: &Noise,
) -> Result<Fit, BuildError> {
    let mut best = start;
    for attempt in 0..ATTEMPTS {
        let again = polish(problem, origin, &best.model, &best.coordinates, expected, &best.noise)?;
        let gained = cost(&best) - cost(&again);
        if gained > 0.0 {
            best = again;
        }
        if gained > WORTHWHILE {
            continue;
        }
        let doubtful = best.noise.torque > DOUBTFUL * expected.torque
            || best.noise.drive > DOUBTFUL * expected.drive;
        if attempt + 1 == ATTEMPTS || !doubtful || origin.stages.is_empty() {
            break;
        }
        let moved = resettle(problem, origin, &best.model, &best.coordinates)?;
        if cost(&best) - cost(&moved) <= WORTHWHILE {
            break;
        }
        best = moved;
    }
    Ok(best)
}

/// Deviance and prior together: what fits are compared by.
pub fn cost(fit: &Fit) -> f64 {
    fit.deviance + fit.prior
}

/// The parameters that a refit of this model moves.
pub fn coordinates(model: &Model, problem: &Problem<'_>) -> Vec<Coordinate> {
    let quantities = Quantity::of(model, problem.record.drive);
    quantities.into_iter().map(Coordinate::Parameter).collect()
}
