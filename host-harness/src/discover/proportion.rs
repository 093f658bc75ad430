//! What was found in proportion: shares of the disagreement, free runs, and effects that are only possible.

use std::collections::BTreeMap;

use joint_core::effect::EffectParameters;

use super::bootstrap::stays_ahead;
use super::evidence::{FreeRun, Weighed, weigh};
use super::findings::Named;
use super::search::Search;
use crate::estimate::filter::{Noise, Walk};
use crate::estimate::fit::Problem;
use crate::interrupt;
use crate::plant::BuildError;

/// Most confidence in an effect that the unseen samples do not confirm: it is as likely as not.
const UNCONFIRMED: f64 = 0.5;

/// What the effects explain in proportion, and how both models run free, on samples that no fit has seen.
pub(super) fn weighed(
    problem: &Problem<'_>,
    found: &Search,
    walk: Option<Walk>,
    noise: &Noise,
    held_out: &[bool],
) -> Result<(Weighed, FreeRun), BuildError> {
    let models = [&found.before.fit, &found.after.fit];
    let free_run = || FreeRun::of(problem.record, models, noise, held_out);
    let Some(walk) = walk.filter(|_| !interrupt::asked()) else {
        return Ok((Weighed::default(), free_run()?));
    };
    let places: Vec<usize> = (0..found.rounds.len()).map(|k| found.place(k)).collect();
    let evidence = || weigh(problem, models, walk, [noise, &found.expected], held_out, &places);
    let (weighed, free_run) = rayon::join(evidence, free_run);
    Ok((weighed?, free_run?))
}

/// The best of the weak names that the unseen samples did not confirm.
pub(super) fn possible(found: &Search, mask: &[f64]) -> Vec<Named> {
    let Some((contender, stage)) = &found.hope else { return Vec::new() };
    if found.rounds.iter().any(|round| round.name == contender.name) {
        return Vec::new();
    }
    let model = &stage.fit.model;
    let named = |effect: &&EffectParameters| (effect.kind, effect.location) == contender.name;
    let Some(effect) = model.effects.iter().rfind(named) else { return Vec::new() };
    let keys = effect.kind.spec().parameters.iter().zip(effect.values);
    let stays_ahead = stays_ahead(&stage.fit, &[&found.after.fit], mask);
    vec![Named {
        kind: effect.kind.spec().kind.to_owned(),
        location: effect.location.to_string(),
        parameters: keys.map(|(spec, value)| (spec.key.to_owned(), value)).collect(),
        standard_errors: BTreeMap::new(),
        confidence: UNCONFIRMED * stays_ahead,
        share: 0.0,
        share_error: 0.0,
        gain: contender.gain,
        stays_ahead,
        rivals: Vec::new(),
    }]
}
