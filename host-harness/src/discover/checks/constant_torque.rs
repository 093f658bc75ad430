//! Whether gravity was seen to change, or a constant torque would do.
//!
//! Around its largest pull a pendulum is a constant torque, and so is much that is no pendulum: a spring,
//! a hose, friction that is stronger one way. Only a travel over which the pull changes tells them apart.
//! So a joint that is said to hang is fitted with a constant torque in gravity's place.

use std::f64::consts::FRAC_PI_2;

use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;
use joint_core::per_unit::Bases;

use super::bootstrap::stays_ahead;
use crate::discover::state::constant::Constant;
use crate::discover::state::rounds::Round;
use crate::discover::state::search::Search;
use crate::discover::state::stage::Stage;
use crate::estimate::coordinates::Coordinate;
use crate::estimate::fit::Problem;
use crate::estimate::record::{Channel, Record};
use crate::estimate::refit::cost;
use crate::model::Model;
use crate::plant::BuildError;

/// Places of order and amplitude among a line's values.
const ORDER: usize = 0;
const AMPLITUDE: usize = 1;
/// One sigma of the prior, in amplitudes of what is replaced.
const SIGMA: f64 = 100.0;

/// Fits a constant torque in the place of gravity, if that was named; where it comes nearer than any other
/// name it is the rival that the next experiment is to decide about.
///
/// # Errors
/// The model cannot be built.
pub(crate) fn ask_constant(problem: &Problem<'_>, search: &mut Search) -> Result<(), BuildError> {
    let hangs = |round: &Round| round.name.0 == Kind::Gravity;
    let Some(k) = search.rounds.iter().position(hangs) else { return Ok(()) };
    let stage = instead(problem, &search.after, search.place(k), search)?;
    let after = &search.after.fit;
    let lead = cost(after) - cost(&stage.fit);
    let torque_nm = stage.fit.model.effects[search.place(k)].values[AMPLITUDE];
    let ahead = stays_ahead(after, &[&stage.fit], problem.mask);
    let round = &mut search.rounds[k];
    if round.rivals.first().is_none_or(|rival| rival.gain < round.gain + lead) {
        round.runner_up = Some(stage);
        round.stays_ahead = round.stays_ahead.min(ahead);
    }
    search.constant = Some(Constant { of: Kind::Gravity, lead, torque_nm });
    Ok(())
}

/// The fit with a constant torque on the rotor in the place of the model's effect number `place`.
fn instead(
    problem: &Problem<'_>,
    after: &Stage,
    place: usize,
    search: &Search,
) -> Result<Stage, BuildError> {
    let model = &after.fit.model;
    // Of a line of the lowest order the record sees no more than its top.
    let constant = EffectParameters::new(Kind::Cogging, Location::Motor)
        .with("order", Kind::Cogging.spec().parameters[ORDER].low)
        .with("phase_rad", -FRAC_PI_2);
    let mean = mean_pull(model, place, problem.record);
    let torques = [0.0, mean].map(|torque| constant.with("amplitude_nm", torque));
    let scale = model.effects[place].values[0] * shaft(model).abs();
    let own = Coordinate::Effect { effect: place, value: AMPLITUDE, scale, sigma: SIGMA };
    after.instead(problem, &search.expected, place, torques, &[own])
}

/// What gravity is on the rotor in the mean over a record, Nm.
fn mean_pull(model: &Model, place: usize, record: &Record) -> f64 {
    let shaft = shaft(model);
    let [amplitude, phase, ..] = model.effects[place].values;
    let angles = record.measured.iter().filter_map(|row| {
        let output = row[Channel::Output as usize];
        let motor = row[Channel::Motor as usize] * shaft;
        [output, motor].into_iter().find(|angle| angle.is_finite())
    });
    let (sum, count) = angles
        .map(|angle| -amplitude * (angle + phase).sin())
        .fold((0.0, 0_u32), |(sum, count), pull| (sum + pull, count + 1));
    shaft * sum / f64::from(count.max(1))
}

/// Angle of the last mass over the rotor's.
fn shaft(model: &Model) -> f64 {
    Bases::si(&model.motor, &model.stages).shaft(model.stages.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discover::candidates::gravity;
    use crate::discover::trial;
    use crate::estimate::noise;

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
        ask_constant(&problem, &mut search).unwrap();
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
