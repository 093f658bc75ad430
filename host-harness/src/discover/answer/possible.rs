//! Effects that are only possible, and what repeats without a name.

use std::collections::BTreeMap;

use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;

use super::findings::{Named, knots_of};
use crate::discover::bounds::UNCONFIRMED;
use crate::discover::checks::bootstrap::stays_ahead;
use crate::discover::evidence::rest::Rest;
use crate::discover::evidence::slope::Slope;
use crate::discover::state::search::Search;

/// Effects that explain something but not beyond doubt: those that unseen samples did not confirm, and the
/// best of the weak names.
pub(crate) fn possible(found: &Search, mask: &[f64]) -> Vec<Named> {
    let mut told: Vec<(Kind, Location)> = found.rounds.iter().map(|round| round.name).collect();
    let mut all = Vec::new();
    let unconfirmed = found
        .unconfirmed
        .iter()
        .map(|own| (&own.contender, &own.stage, own.slope, own.unseen_t, own.transfer_t));
    let deferred = found
        .deferred
        .iter()
        .map(|(contender, stage)| (contender, stage, Slope::default(), 0.0, None));
    for (contender, stage, slope, unseen_t, transfer_t) in unconfirmed.chain(deferred) {
        let model = &stage.fit.model;
        let named = |effect: &&EffectParameters| (effect.kind, effect.location) == contender.name;
        let Some(effect) = model.effects.iter().rfind(named) else { continue };
        if told.contains(&contender.name) {
            continue;
        }
        told.push(contender.name);
        let keys = effect.kind.spec().parameters.iter().zip(effect.values);
        let stays_ahead = stays_ahead(&stage.fit, &[&found.after.fit], mask);
        let [borne_out, borne_out_error] = slope.told();
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
            borne_out,
            borne_out_error,
            unseen_t,
            transfer_t,
            gain: contender.gain,
            stays_ahead,
            rivals: Vec::new(),
        });
    }
    all
}

/// A map as it is told: it says what is there, and has no name to be sure of. `of` is the share of what the
/// refitted nominal misses that the named effects leave.
pub(crate) fn unnamed(rest: &Rest, of: f64) -> Option<Named> {
    let map = rest.stage.fit.model.effects.last()?;
    let values = map.kind.spec().parameters.iter().zip(map.values);
    let [borne_out, borne_out_error] = rest.unseen.slope.told();
    Some(Named {
        kind: map.kind.spec().kind.to_owned(),
        location: map.location.to_string(),
        unnamed: true,
        parameters: values.map(|(spec, value)| (spec.key.to_owned(), value)).collect(),
        knots: knots_of(map),
        standard_errors: BTreeMap::new(),
        confidence: 0.0,
        share: of * rest.share.value,
        share_error: of * rest.share.error,
        borne_out,
        borne_out_error,
        unseen_t: rest.unseen.t,
        transfer_t: None,
        gain: rest.unseen.series.iter().sum(),
        stays_ahead: 0.0,
        rivals: Vec::new(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discover::answer::decision::weighed;
    use crate::discover::checks::confirmed::keep_confirmed;
    use crate::discover::trial;
    use crate::estimate::fit::Problem;
    use crate::estimate::record::Record;

    #[test]
    fn a_line_that_is_there_is_kept_one_the_wrong_way_round_is_taken_back_and_each_keeps_a_share() {
        let nominal = trial::motor();
        let record = Record::new(&trial::log(&nominal, trial::line(12.0), 4.0), None);
        let (tested, mask) = trial::split(&record);
        let problem = Problem::new(&record, &mask).rough();
        let mut found = trial::searched(&problem, &nominal);
        let mut wrong = found.clone();
        let unseen = keep_confirmed(&problem, &mut found, (&tested, &[]), true).unwrap();
        assert!(found.rounds.len() == 1 && unseen[0].t(true) > 0.0);
        // Where no equation stands out nothing is weighed, and no effect is lost by it.
        let noise = found.after.fit.noise;
        let (weighed, _) = weighed(&problem, &found, None, &noise, &tested, &unseen).unwrap();
        assert_eq!(weighed.shares.len(), 1);
        wrong.after.fit.model.effects[0].values[1] *= -1.0;
        keep_confirmed(&problem, &mut wrong, (&tested, &[]), true).unwrap();
        assert!(wrong.rounds.is_empty() && wrong.after.fit.model.effects.is_empty());
        let possible = possible(&wrong, &mask);
        assert!(possible[0].kind == "cogging" && possible[0].unseen_t < 0.0);
    }
}
