//! Whether something else that shows the same would do in a name's place.
//!
//! Around its largest pull gravity is a constant torque, and a gear's line is one of the encoder behind it: a record
//! may hardly tell them apart. So what an effect's card says to be alike is fitted in its place, and is its rival.

use super::bootstrap::stays_ahead;
use crate::discover::candidates::card;
use crate::discover::candidates::rules::Alike;
use crate::discover::state::constant::Constant;
use crate::discover::state::rounds::Contender;
use crate::discover::state::search::Search;
use crate::discover::state::stage::Stage;
use crate::estimate::fit::Problem;
use crate::estimate::refit::cost;

/// Fits what shows the same in the place of each effect that was named. Where that has a name it is a rival; where it
/// is a constant torque, and comes nearer than any other name, it is what the next experiment is to decide about. What
/// cannot be fitted is no rival.
pub(crate) fn ask_alike(problem: &Problem<'_>, search: &mut Search) {
    for k in 0..search.rounds.len() {
        let place = search.place(k);
        let model = &search.after.fit.model;
        let effect = &model.effects[place];
        let alike = (card(effect.kind).rules.alike)(effect, model, problem.record);
        let Some(Alike { hypothesis, start, constant }) = alike else { continue };
        if constant.is_none() && search.withdrawn.contains(&start.kind) {
            continue;
        }
        let (both, own) = ([hypothesis.start, start], hypothesis.coordinates(place));
        let stage = search.after.instead(problem, &search.expected, place, both, &own);
        let Ok(stage) = stage else { continue };
        let after = &search.after.fit;
        let lead = cost(after) - cost(&stage.fit);
        if !lead.is_finite() {
            continue;
        }
        let ahead = |rival: &Stage| stays_ahead(after, &[&rival.fit], problem.mask);
        let round = &mut search.rounds[k];
        let gain = round.gain + lead;
        let Some(value) = constant else {
            round.rivalled(Contender { name: hypothesis.name(), gain }, stage, ahead);
            continue;
        };
        let torque_nm = stage.fit.model.effects[place].values[value];
        if round.rivals.first().is_none_or(|rival| rival.gain < gain) {
            round.stays_ahead = round.stays_ahead.min(ahead(&stage));
            round.runner_up = Some(stage);
        }
        search.constant = Some(Constant { of: round.name.0, lead, torque_nm });
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use joint_core::effect::{EffectParameters, Kind};
    use joint_core::params::Location;

    use super::*;
    use crate::discover::candidates::gravity;
    use crate::discover::state::rounds::Round;
    use crate::discover::trial;
    use crate::estimate::noise;
    use crate::estimate::record::Record;

    /// What a constant explains of a motor's log in which this is hidden and gravity is named.
    fn asked(hidden: EffectParameters, volts: f64) -> Search {
        let nominal = trial::motor();
        let record = Record::new(&trial::log(&nominal, hidden, volts), None);
        let mask = vec![1.0; record.len()];
        let problem = Problem::new(&record, &mask);
        let before = trial::fitted(&problem, &nominal, &[]);
        let gain = cost(&before.fit);
        let mut search = Search::new(before, &[], noise::expected(&nominal, &record));
        search.after =
            trial::fitted(&problem, &nominal, &[gravity::pull(Location::Motor, TORQUE_NM)]);
        search.rounds.push(Round {
            name: (Kind::Gravity, Location::Motor),
            gain: gain - cost(&search.after.fit),
            rivals: Vec::new(),
            runner_up: None,
            stays_ahead: 1.0,
        });
        ask_alike(&problem, &mut search);
        search
    }

    const TORQUE_NM: f64 = 4e-3;

    fn pull() -> EffectParameters {
        EffectParameters::new(Kind::Gravity, Location::Motor)
            .with("amplitude_nm", TORQUE_NM)
            .with("phase_rad", 0.8)
    }

    #[test]
    fn over_whole_turns_a_pull_is_seen_to_change() {
        let search = asked(pull(), 12.0);
        let constant = search.constant.unwrap();
        assert!(search.rounds[0].gain > 300.0, "{}", search.rounds[0].gain);
        assert!(constant.lead < -0.5 * search.rounds[0].gain, "{constant:?}");
        assert!(!constant.undecided() && constant.told(0.0).contains("seen to change"));
        assert!(search.rounds[0].stays_ahead > 0.9);
    }

    #[test]
    fn a_torque_that_does_not_change_is_not_gravity() {
        let line = EffectParameters::new(Kind::Cogging, Location::Motor)
            .with("order", 1e-4)
            .with("amplitude_nm", TORQUE_NM)
            .with("phase_rad", FRAC_PI_2);
        let search = asked(line, 1.8);
        let constant = search.constant.unwrap();
        assert!(search.rounds[0].gain > 300.0, "{}", search.rounds[0].gain);
        assert!(constant.lead >= 0.0 && constant.undecided(), "{constant:?}");
        assert!((constant.torque_nm / -TORQUE_NM - 1.0).abs() < 0.05, "{constant:?}");
        let rival = search.rounds[0].runner_up.as_ref().unwrap();
        assert_eq!(rival.fit.model.effects[0].kind, Kind::Cogging);
    }
}
