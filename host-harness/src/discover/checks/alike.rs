//! Whether something else that shows the same would do in a name's place.
//!
//! Around its largest pull gravity is a constant torque, and a gear's line is one of the encoder behind it: a record
//! may hardly tell them apart. So what an effect's card says to be alike is fitted in its place, and is its rival.

use super::bootstrap::stays_ahead;
use crate::discover::bounds::{FAR_BEHIND, SEPARATION};
use crate::discover::candidates::card;
use crate::discover::candidates::rules::Alike;
use crate::discover::state::constant::Constant;
use crate::discover::state::rounds::Contender;
use crate::discover::state::search::Search;
use crate::discover::state::stage::Stage;
use crate::estimate::filter::Noise;
use crate::estimate::fit::Problem;
use crate::estimate::refit::{cost, polish};
use crate::plant::BuildError;

/// Fits what shows the same in the place of each effect that was named. Where that has a name the likelier of both is
/// named, the one that was found if nothing separates them, and the other is its rival; where it is a constant torque, and
/// comes nearer than any other name, it is what the next experiment is to decide about. Near ones are told apart at the
/// `finest` steps, since what coarser ones leave out may be more than what they differ by. What cannot be fitted is no
/// rival.
pub(crate) fn ask_alike([problem, finest]: [&Problem<'_>; 2], search: &mut Search) {
    for k in 0..search.rounds.len() {
        let place = search.place(k);
        let model = &search.after.fit.model;
        let effect = &model.effects[place];
        let alike = (card(effect.kind).rules.alike)(effect, model, problem.record);
        let Some(alike) = alike else { continue };
        if alike.constant.is_none() && search.withdrawn.contains(&alike.start.kind) {
            continue;
        }
        let expected = &search.expected;
        let at = |problem: &Problem<'_>, named: &Stage| {
            beside(problem, named, expected, (place, &alike)).ok().flatten()
        };
        let Some(Beside { mut lead, mut ahead, stage }) = at(problem, &search.after) else {
            continue;
        };
        if lead.abs() < FAR_BEHIND {
            let Stage { fit, origin } = &search.after;
            let moved = &fit.coordinates;
            let finer = polish(finest, origin, &fit.model, moved, expected, &fit.noise);
            let finer = finer.map(|fit| Stage { fit, origin: origin.clone() });
            if let Some(finer) = finer.ok().and_then(|named| at(finest, &named)) {
                (lead, ahead) = (finer.lead, finer.ahead);
            }
        }
        let round = &mut search.rounds[k];
        let gain = round.gain + lead;
        let Alike { hypothesis, constant, .. } = alike;
        let Some(value) = constant else {
            let contender = Contender { name: hypothesis.name(), gain };
            if lead > SEPARATION {
                let before = std::mem::replace(&mut search.after, stage);
                round.renamed(contender, before, 1.0 - ahead);
            } else {
                // Of two that nothing separates either may be ahead in another draw, which their odds tell already.
                round.rivalled(contender, stage, |_| if lead < -SEPARATION { ahead } else { 1.0 });
            }
            continue;
        };
        let torque_nm = stage.fit.model.effects[place].values[value];
        if round.rivals.first().is_none_or(|rival| rival.gain < gain) {
            round.stays_ahead = round.stays_ahead.min(ahead);
            round.runner_up = Some(stage);
        }
        search.constant = Some(Constant { of: round.name.0, lead, torque_nm });
    }
}

/// What shows the same, in the place of an effect.
struct Beside {
    /// By how much it is the likelier.
    lead: f64,
    /// Share of the logs drawn anew in which the effect stays ahead of it.
    ahead: f64,
    stage: Stage,
}

/// Fits what is `alike` in the place of an effect that was named; `None` where it is non-finite.
fn beside(
    problem: &Problem<'_>,
    named: &Stage,
    expected: &Noise,
    (place, alike): (usize, &Alike),
) -> Result<Option<Beside>, BuildError> {
    let Alike { hypothesis, start, .. } = alike;
    let (both, own) = ([hypothesis.start, *start], hypothesis.coordinates(place));
    let stage = named.instead(problem, expected, place, both, &own)?;
    let lead = cost(&named.fit) - cost(&stage.fit);
    let ahead = stays_ahead(&named.fit, &[&stage.fit], problem.mask);
    Ok(lead.is_finite().then_some(Beside { lead, ahead, stage }))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use joint_core::effect::{EffectParameters, Kind};
    use joint_core::params::Location;

    use super::*;
    use crate::demo::actuator;
    use crate::discover::candidates::gravity;
    use crate::discover::candidates::hypothesis::{Free, Hypothesis};
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
        ask_alike([&problem; 2], &mut search);
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

    #[test]
    fn the_likelier_of_two_that_show_the_same_has_the_name_and_the_other_is_its_rival() {
        let nominal = actuator();
        let gear = EffectParameters::new(Kind::TransmissionError, Location::Stage(1))
            .with("amplitude_rad", 2e-3)
            .with("order", 1.0);
        let shown = EffectParameters::new(Kind::EncoderEccentricity, Location::OutputEncoder)
            .with("amplitude_rad", 2e-3)
            .with("order", 9.0);
        let named = Hypothesis {
            start: gear.with("amplitude_rad", 0.0),
            free: vec![Free::Phasor { amplitude: 0, scale: 1e-3, sigma: 100.0 }],
        };
        let names = [&gear, &shown].map(|effect| (effect.kind, effect.location));
        for (hidden, stays) in [(gear, true), (shown, false)] {
            let record = Record::new(&trial::log(&nominal, hidden, 12.0), None);
            let mask = vec![1.0; record.len()];
            let problem = Problem::new(&record, &mask).rough();
            let before = trial::fitted(&problem, &nominal, &[]);
            let mut search = Search::new(before, &[], noise::expected(&nominal, &record));
            search.after = trial::fitted(&problem, &nominal, std::slice::from_ref(&named));
            search.rounds.push(Round { name: names[0], ..trial::round(100.0) });
            ask_alike([&problem; 2], &mut search);
            let round = &search.rounds[0];
            let [of, other] = if stays { names } else { [names[1], names[0]] };
            assert_eq!((round.name, round.rivals[0].name), (of, other));
            assert_eq!(search.after.fit.model.effects[0].kind, of.0);
            assert!(round.gain > round.rivals[0].gain && round.stays_ahead > 0.5, "{round:?}");
        }
    }
}
