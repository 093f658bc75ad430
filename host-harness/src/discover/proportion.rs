//! What was found in proportion: shares of the disagreement, free runs, and effects that are only possible.

use std::collections::BTreeMap;

use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;
use rayon::prelude::*;

use super::bootstrap::stays_ahead;
use super::confidence::SIGMAS;
use super::evidence::{
    Budget, Elsewhere, FreeRun, Share, Unseen, Weighed, together, unseen, weigh,
};
use super::findings::{Answer, Named, knots_of};
use super::gate::Remainder;
use super::needless::bare;
use super::search::{Contender, Search, Stage};
use crate::estimate::filter::{Noise, Walk};
use crate::estimate::fit::Problem;
use crate::interrupt;
use crate::plant::BuildError;

/// Most confidence in an effect that the unseen samples do not confirm: it is as likely as not.
const UNCONFIRMED: f64 = 0.5;

/// Share of the RMS of what drives an equation up to which a predictable remainder does not matter.
const TOLERANCE: f64 = 0.01;

/// The answer. It is unknown where something that matters is left without a name: what is predictable, what exceeds
/// what friction and supply are expected to scatter by, or what makes a model fail on samples that no fit has seen.
/// A disturbance that is no larger than that is no law that is missing.
pub(super) fn answered(named: bool, left: &Remainder, weighed: &Weighed) -> Answer {
    let noise = left.complaints(!named).is_empty();
    let unknown = match &weighed.budget {
        Some(budget) => {
            let fails = !noise && left.fails_unseen();
            matters(budget) || fails || weighed.is_unbelievable() && budget.left_matters()
        }
        None => !noise,
    };
    match named {
        _ if unknown => Answer::Unknown,
        true => Answer::Effect,
        false => Answer::Adequate,
    }
}

/// Whether what is predictable and has no name is more than a model is allowed to miss, beyond its standard error.
pub(super) fn matters(budget: &Budget) -> bool {
    let Budget { unnamed, unnamed_error, unnamed_of_drive, .. } = budget;
    let sure = ((unnamed - SIGMAS * unnamed_error) / unnamed).max(0.0).sqrt();
    *unnamed > 0.0 && unnamed_of_drive.is_none_or(|share| sure * share > TOLERANCE)
}

impl Weighed {
    /// Whether more is left than friction and supply may be disturbed by: it has a cause that is not known.
    pub(super) fn is_unbelievable(&self) -> bool {
        self.over_believable > 1.0
    }
}

impl Budget {
    /// Whether all that is left beside white noise is more than a model is allowed to miss.
    fn left_matters(&self) -> bool {
        self.left_of_drive.is_none_or(|share| share > TOLERANCE)
    }
}

/// What the effects explain in proportion, and how both models run free, on samples that no fit has seen.
pub(super) fn weighed(
    problem: &Problem<'_>,
    found: &Search,
    walk: Option<Walk>,
    noise: &Noise,
    held_out: &[bool],
    effects: &[Witnessed],
) -> Result<(Weighed, FreeRun), BuildError> {
    let models = [&found.before.fit, &found.after.fit];
    let free_run = || FreeRun::of(problem.record, models, noise, held_out);
    let Some(walk) = walk.filter(|_| !interrupt::asked()) else {
        let shares = vec![Share::default(); effects.len()];
        return Ok((Weighed { shares, ..Weighed::default() }, free_run()?));
    };
    let effects: Vec<_> = effects.iter().map(|own| own.unseen.clone()).collect();
    let evidence = || weigh(problem, models, walk, [noise, &found.expected], held_out, &effects);
    let (weighed, free_run) = rayon::join(evidence, free_run);
    Ok((weighed?, free_run?))
}

/// Takes effects back that samples which no fit has seen speak against beyond their standard error, given the
/// others: they are only possible. Where what is left is not noise they have to be the likelier for it, and beside
/// a disturbance, which makes likelihoods of what imitates it, beyond their standard error; not so of an effect
/// that a regression is certain of. Answers with what those samples, and the other records, say of the rest.
///
/// # Errors
/// A model cannot be built.
pub(super) fn keep_borne_out(
    problem: &Problem<'_>,
    found: &mut Search,
    (tested, others): (&[bool], &[Elsewhere]),
    noise: bool,
) -> Result<Vec<Witnessed>, BuildError> {
    loop {
        let asked = asked(problem, found, tested, others)?;
        let disturbed = found.after.fit.noise.is_disturbed();
        let certain = |k: usize| found.measured.contains(&found.rounds[k].name);
        let short = |k: usize, own: &Witnessed| match certain(k) {
            false if disturbed => (own.least() - SIGMAS).min(own.unseen.nearer),
            false if !noise => own.least(),
            _ => own.least() + SIGMAS,
        };
        let all = asked.iter().enumerate().map(|(k, (own, _))| (k, short(k, own)));
        let Some((k, _)) = all.filter(|one| one.1 < 0.0).min_by(|a, b| a.1.total_cmp(&b.1)) else {
            return Ok(asked.into_iter().map(|(own, _)| own).collect());
        };
        let without = asked.into_iter().nth(k).map(|(_, without)| without);
        let round = found.rounds.remove(k);
        let contender = Contender { name: round.name, gain: round.gain };
        found.unconfirmed.push((contender, found.after.clone()));
        found.after = without.unwrap_or_else(|| found.before.clone());
    }
}

/// What samples that no fit has seen say of an effect.
#[derive(Clone, Debug, Default)]
pub(super) struct Witnessed {
    /// Those of the logs themselves.
    pub(super) unseen: Unseen,
    /// The t of the other records together; `None` where there are none.
    pub(super) elsewhere: Option<f64>,
}

impl Witnessed {
    /// The t of whoever speaks against it most.
    fn least(&self) -> f64 {
        self.elsewhere.map_or(self.unseen.t, |other| self.unseen.t.min(other))
    }

    /// The t of all together.
    pub(super) fn t(&self) -> f64 {
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

/// Effects that explain something but not beyond doubt: those that unseen samples did not bear out, and the
/// best of the weak names.
pub(super) fn possible(found: &Search, mask: &[f64]) -> Vec<Named> {
    let mut told: Vec<(Kind, Location)> = found.rounds.iter().map(|round| round.name).collect();
    let mut all = Vec::new();
    for (contender, stage) in found.unconfirmed.iter().chain(&found.hope) {
        let model = &stage.fit.model;
        let named = |effect: &&EffectParameters| (effect.kind, effect.location) == contender.name;
        let Some(effect) = model.effects.iter().rfind(named) else { continue };
        if told.contains(&contender.name) {
            continue;
        }
        told.push(contender.name);
        let keys = effect.kind.spec().parameters.iter().zip(effect.values);
        let stays_ahead = stays_ahead(&stage.fit, &[&found.after.fit], mask);
        all.push(Named {
            kind: effect.kind.spec().kind.to_owned(),
            location: effect.location.to_string(),
            unnamed: effect.kind.is_unnamed(),
            knots: knots_of(effect),
            parameters: keys.map(|(spec, value)| (spec.key.to_owned(), value)).collect(),
            standard_errors: BTreeMap::new(),
            confidence: UNCONFIRMED * stays_ahead,
            share: 0.0,
            share_error: 0.0,
            unseen_t: 0.0,
            transfer_t: None,
            gain: contender.gain,
            stays_ahead,
            rivals: Vec::new(),
        });
    }
    all
}

#[cfg(test)]
mod tests {
    use super::super::candidates::cogging;
    use super::super::trial;
    use super::*;
    use crate::estimate::noise;
    use crate::estimate::record::Record;

    #[test]
    fn only_a_remainder_that_matters_and_is_predictable_or_large_or_fails_makes_the_answer_unknown()
    {
        let quiet = Remainder { drive: 1.0, torque: 1.0, unseen: 1.0, ..Remainder::default() };
        let loud = Remainder { torque: 10.0, ..quiet.clone() };
        let failing = Remainder { unseen: 2.0, ..loud.clone() };
        let of = |share: Option<f64>| {
            let budget = Budget {
                unnamed: 0.1,
                unnamed_of_drive: share,
                left_of_drive: share,
                ..Budget::default()
            };
            Weighed { budget: Some(budget), ..Weighed::default() }
        };
        let (little, much) = (of(Some(0.5 * TOLERANCE)), of(Some(2.0 * TOLERANCE)));
        // Of what follows nothing.
        let wandering = |share: f64, over_believable: f64| {
            let budget = Budget { left_of_drive: Some(share * TOLERANCE), ..Budget::default() };
            Weighed { budget: Some(budget), over_believable, ..Weighed::default() }
        };
        let none = Weighed::default();
        for (named, told) in [(true, Answer::Effect), (false, Answer::Adequate)] {
            assert_eq!(answered(named, &quiet, &little), told);
            assert_eq!(answered(named, &quiet, &none), told);
            assert_eq!(answered(named, &loud, &little), told);
            assert_eq!(answered(named, &quiet, &much), Answer::Unknown);
            assert_eq!(answered(named, &loud, &of(None)), Answer::Unknown);
            assert_eq!(answered(named, &loud, &none), Answer::Unknown);
            assert_eq!(answered(named, &failing, &little), Answer::Unknown);
            // Friction wanders by a little; more is a cause that is not known, if it matters.
            assert_eq!(answered(named, &quiet, &wandering(2.0, 0.7)), told);
            assert_eq!(answered(named, &quiet, &wandering(2.0, 2.0)), Answer::Unknown);
            assert_eq!(answered(named, &quiet, &wandering(0.5, 2.0)), told);
            // A share that is no more certain than this might be half as large.
            let mut unsure = much.clone();
            unsure.budget.iter_mut().for_each(|budget| budget.unnamed_error = 0.05);
            assert_eq!(answered(named, &quiet, &unsure), told);
        }
    }

    #[test]
    fn a_line_that_is_there_is_kept_one_the_wrong_way_round_is_taken_back_and_each_keeps_a_share() {
        let nominal = trial::motor();
        let record = Record::new(&trial::log(&nominal, trial::line(12.0), 4.0), None);
        let tested: Vec<bool> = (0..record.len()).map(|k| k % 1000 >= 700).collect();
        let mask: Vec<f64> = tested.iter().map(|t| if *t { 0.0 } else { 1.0 }).collect();
        let problem = Problem::new(&record, &mask).rough();
        let expected = noise::expected(&nominal, &record);
        let mut found = Search::new(trial::fitted(&problem, &nominal, &[]), &[], expected);
        found.after = trial::fitted(&problem, &nominal, &[cogging::line(12.0, 0.01, false)]);
        found.rounds.push(trial::round(1e4));
        let mut wrong = found.clone();
        let unseen = keep_borne_out(&problem, &mut found, (&tested, &[]), true).unwrap();
        assert!(found.rounds.len() == 1 && unseen[0].t() > 0.0);
        // Where no equation stands out nothing is weighed, and no effect is lost by it.
        let noise = found.after.fit.noise;
        let (weighed, _) = weighed(&problem, &found, None, &noise, &tested, &unseen).unwrap();
        assert_eq!(weighed.shares.len(), 1);
        wrong.after.fit.model.effects[0].values[1] *= -1.0;
        keep_borne_out(&problem, &mut wrong, (&tested, &[]), true).unwrap();
        assert!(wrong.rounds.is_empty() && wrong.after.fit.model.effects.is_empty());
        assert_eq!(possible(&wrong, &mask)[0].kind, "cogging");
    }
}
