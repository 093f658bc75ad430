//! The refits that all proposals make: a short one to choose by, a full one to compare by.

use std::borrow::Cow;

use nalgebra::DMatrix;

use crate::discover::candidates::hypothesis::Hypothesis;
use crate::discover::state::rounds::{Contender, Name, ScoreRow, title};
use crate::discover::state::search::Search;
use crate::discover::state::stage::Stage;
use crate::estimate::filter::{Linearisation, Noise};
use crate::estimate::fit::{Fit, Known, Problem};
use crate::estimate::refit::{cost, finish, polish};
use crate::model::Model;
use crate::plant::BuildError;

/// What a base costs that is no number.
const BEYOND: f64 = 1e12;

/// A name, its score, and the model with it.
pub(crate) type Refitted = (Name, f64, Stage);

/// Writes down the scores of names that were refitted on a base, and what those gained that a joint can have; these,
/// in the same order.
pub(crate) fn written_refits(
    problem: &Problem<'_>,
    search: &mut Search,
    round: usize,
    base: &Stage,
    refitted: Vec<Refitted>,
) -> Vec<(Contender, Stage)> {
    let mut tried = Vec::new();
    for (name, score, stage) in refitted {
        let believed = search.believes(&stage.fit.model, problem.record);
        let gain = believed.then(|| gained(&base.fit, &stage.fit));
        search.scores.push(ScoreRow { round, name: title(name), score, refitted: gain });
        tried.extend(gain.map(|gain| (Contender { name, gain }, stage)));
    }
    tried
}

/// A base with a hypothesis, fitted for some rounds from a model with that effect; `near` is the Jacobian of the
/// base there.
///
/// # Errors
/// The model cannot be built.
pub(crate) fn short(
    problem: &Problem<'_>,
    (base, hypothesis): (&Stage, &Hypothesis),
    (start, near): (&Model, Option<&DMatrix<f64>>),
    noise: &Noise,
    rounds: usize,
) -> Result<Stage, BuildError> {
    let (origin, moved) = base.widened(hypothesis);
    let known = Known { near, along: &mut Cow::Owned(Linearisation::default()) };
    let fit = problem.fit_from(known, &origin, start, &moved, noise, rounds)?;
    Ok(Stage { fit, origin })
}

/// The same on the part of the record that fits on the way look at.
///
/// # Errors
/// The model cannot be built.
pub(crate) fn short_ahead(
    problem: &Problem<'_>,
    own: (&Stage, &Hypothesis),
    (start, near): (&Model, &DMatrix<f64>),
    noise: &Noise,
    rounds: usize,
) -> Result<Stage, BuildError> {
    let near = problem.scout.is_none().then_some(near);
    short(&problem.ahead(), own, (start, near), noise, rounds)
}

/// What a base costs on that part, and how many times as many samples all of the record has.
///
/// # Errors
/// The model cannot be built.
pub(crate) fn level_ahead(problem: &Problem<'_>, base: &Fit) -> Result<(f64, f64), BuildError> {
    let ahead = problem.ahead();
    if problem.scout.is_none() {
        return Ok((cost(base), 1.0));
    }
    let level = ahead.design(&base.model, &base.noise)?.deviance + base.prior;
    let [whole, part] = [problem.mask, ahead.mask].map(|mask| mask.iter().sum::<f64>());
    Ok((level, whole / part))
}

/// The same fit polished, with its own noise, from where it stands and at a noise to begin with.
///
/// # Errors
/// The model cannot be built.
pub(crate) fn full(
    problem: &Problem<'_>,
    stage: Stage,
    expected: &Noise,
    noise: &Noise,
) -> Result<Stage, BuildError> {
    let Stage { fit, origin } = ahead(problem, stage, expected, noise)?;
    let fit = finish(problem, &origin, fit, expected)?;
    Ok(Stage { fit, origin })
}

/// The same on the part of the record that fits on the way look at.
///
/// # Errors
/// The model cannot be built.
pub(crate) fn ahead(
    problem: &Problem<'_>,
    Stage { fit, origin }: Stage,
    expected: &Noise,
    noise: &Noise,
) -> Result<Stage, BuildError> {
    let ahead = problem.ahead();
    let fit = polish(&ahead, &origin, &fit.model, &fit.coordinates, expected, noise)?;
    Ok(Stage { fit, origin })
}

/// What a base costs; one that is no number costs more than any fit.
pub(crate) fn cost_of_base(base: &Fit) -> f64 {
    cost(base).min(BEYOND)
}

/// What a fit gains over a base that may be non-finite.
pub(crate) fn gained(base: &Fit, fit: &Fit) -> f64 {
    let gain = cost_of_base(base) - cost(fit);
    if gain.is_nan() { f64::NEG_INFINITY } else { gain }
}
