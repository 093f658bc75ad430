//! Which order a line has, asked again once it is named.
//!
//! An order is chosen while parameters are wrong; and over a travel of less than a turn, orders side by
//! side look the same at first. Once the fit has settled around the name, the order is set free for a
//! moment, and tells where it belongs.

use std::f64::consts::TAU;

use joint_core::effect::EffectParameters;
use joint_core::per_unit::Bases;
use rayon::prelude::*;

use crate::discover::bounds::{FAR_BEHIND, NO_LINE, WORTH_ANOTHER};
use crate::discover::candidates::{card, gravity};
use crate::discover::state::search::Search;
use crate::discover::state::stage::Stage;
use crate::estimate::coordinates::Coordinate;
use crate::estimate::filter::Noise;
use crate::estimate::fit::{Fit, Problem};
use crate::estimate::record::{Channel, Record};
use crate::estimate::refit::{self, cost};
use crate::model::Model;
use crate::plant::BuildError;

/// Orders nearer than this are the same line.
const SAME: f64 = 0.25;
/// Order at which a step of a free one matters, and one sigma of its prior in such steps: next to none.
const SCALE: f64 = 0.1;
const SIGMA: f64 = 100.0;
/// Rounds of the fit in which it is free.
const ROUNDS: usize = 4;
/// Times a line is given an order beside its own, or that it tells itself.
const HOPS: usize = 4;

/// Gives the effect of round `k`, if it is a line, the order that makes the fit best; of a line that is all in its
/// double, the double's.
///
/// # Errors
/// The model cannot be built.
pub(crate) fn ask_order(
    problem: Problem<'_>,
    search: &mut Search,
    k: usize,
) -> Result<(), BuildError> {
    let take = |search: &mut Search, better: Option<Stage>| {
        let Some(stage) = better else { return false };
        search.rounds[k].gain += cost(&search.after.fit) - cost(&stage.fit);
        search.after = stage;
        true
    };
    let (place, expected) = (search.place(k), search.expected);
    let better = doubled(&problem, &search.after, place, &expected)?;
    take(search, better);
    for _ in 0..HOPS {
        let better = reordered(&problem, &search.after, place, &expected)?;
        if !take(search, better) {
            break;
        }
    }
    Ok(())
}

/// The fit with a cogging of twice the order of the model's effect number `effect`, if that is one of which
/// there is next to nothing but the double, and as likely so.
fn doubled(
    problem: &Problem<'_>,
    Stage { fit, origin }: &Stage,
    effect: usize,
    expected: &Noise,
) -> Result<Option<Stage>, BuildError> {
    let line = fit.model.effects[effect];
    let [order, amplitude, _, second, phase, ..] = line.values;
    let order = 2.0 * order;
    let most = line.kind.spec().parameters.first().map_or(0.0, |spec| spec.high);
    let doubles = card(line.kind).rules.line.is_rotor_torque;
    if !doubles || amplitude.abs() >= NO_LINE * second.abs() || order > most {
        return Ok(None);
    }
    let (mut start, mut origin) = (fit.model.clone(), origin.clone());
    start.effects[effect].values[..5].copy_from_slice(&[order, second, phase, 0.0, 0.0]);
    origin.effects[effect].values[0] = order;
    let again = refit::polish(problem, &origin, &start, &fit.coordinates, expected, &fit.noise)?;
    let as_likely = cost(&again) < cost(fit) + WORTH_ANOTHER;
    Ok(as_likely.then_some(Stage { fit: again, origin }))
}

/// The fit with another order of the model's effect number `effect`, if that is a line and the fit the
/// better for it; a whole order where its own is, and none that is gravity's. Those that an eccentric
/// encoder may have are asked one by one, and over less than a turn those beside a line's own: there the
/// free order may stay between them.
fn reordered(
    problem: &Problem<'_>,
    Stage { fit, origin }: &Stage,
    effect: usize,
    expected: &Noise,
) -> Result<Option<Stage>, BuildError> {
    let line = fit.model.effects[effect];
    let parameters = line.kind.spec().parameters;
    let Some(value) = parameters.iter().position(|spec| spec.key == "order") else {
        return Ok(None);
    };
    let own = line.values[value];
    let order = Coordinate::Effect { effect, value, scale: SCALE, sigma: SIGMA };
    if fit.coordinates.iter().any(|moved| moved.is_of(effect, value)) {
        return Ok(None);
    }
    let moved: Vec<_> = fit.coordinates.iter().copied().chain([order]).collect();
    let freed = problem.fit(origin, &fit.model, &moved, &fit.noise, ROUNDS)?;
    let found = freed.model.effects[effect].values[value];
    let new = if own.fract() == 0.0 { found.round().max(1.0) } else { found };
    let mut starts = vec![(&freed.model, new)];
    let rules = card(line.kind).rules.line;
    if !rules.orders.is_empty() {
        let others = rules.orders.iter().copied().filter(|order| *order != new);
        starts.extend(others.map(|order| (&fit.model, order)));
    } else if own.fract() == 0.0 && travel_rad(problem.record, &fit.model, &line) < TAU {
        let beside = [own - 1.0, own + 1.0].into_iter().filter(|order| *order != new);
        starts.extend(beside.map(|order| (&fit.model, order)));
    }
    let possible = parameters[value].low..parameters[value].high;
    let hangs = rules.is_rotor_torque && gravity::own_line(&fit.model);
    let others = starts.into_iter().filter(|(_, order)| {
        possible.contains(order) && (order - own).abs() >= SAME && !(hangs && *order == 1.0)
    });
    let far_behind = |again: &Fit| cost(again) - cost(fit) > FAR_BEHIND;
    let reordered = |(model, order): (&Model, f64)| {
        let (mut start, mut origin) = (model.clone(), origin.clone());
        start.effects[effect].values[value] = order;
        origin.effects[effect].values[value] = order;
        let (moved, noise) = (&fit.coordinates, &fit.noise);
        let again =
            refit::polish_unless(far_behind, problem, &origin, &start, moved, expected, noise)?;
        Ok(Stage { fit: again, origin })
    };
    let others: Vec<_> = others.collect();
    let fitted = others.into_par_iter().map(reordered).collect::<Result<Vec<_>, BuildError>>()?;
    let best = fitted.into_iter().min_by(|a, b| cost(&a.fit).total_cmp(&cost(&b.fit)));
    Ok(best.filter(|best| cost(&best.fit) < cost(fit) - WORTH_ANOTHER))
}

/// How far the shaft of a line travels in a record, by the motor's encoder.
fn travel_rad(record: &Record, model: &Model, line: &EffectParameters) -> f64 {
    let angles = record.measured.iter().map(|row| row[Channel::Motor as usize]);
    let seen = angles.filter(|angle| angle.is_finite());
    let (low, high) = seen.fold((f64::MAX, f64::MIN), |(low, high), q| (low.min(q), high.max(q)));
    let bases = Bases::si(&model.motor, &model.stages);
    let mass = bases.mass(line.location).unwrap_or(0);
    // The teeth of a stage count along the shaft before it.
    let mass = mass.saturating_sub(usize::from(card(line.kind).rules.line.is_of_input));
    (high - low) * bases.shaft(mass).abs()
}

#[cfg(test)]
mod tests {
    use joint_core::effect::Kind;
    use joint_core::params::Location;

    use super::*;
    use crate::demo::actuator;
    use crate::discover::candidates::cogging;
    use crate::discover::candidates::hypothesis::{Free, Hypothesis};
    use crate::discover::trial;
    use crate::estimate::noise;
    use crate::log::Log;
    use crate::model::Model;

    /// The order that is found for a line of order 42 on less than half a turn, begun at another one.
    fn found(begun: f64) -> Option<f64> {
        let log = trial::log(&trial::motor(), trial::line(42.0), 1.8);
        let (low, high) = log
            .motor_angle_rad
            .iter()
            .fold((f64::MAX, f64::MIN), |(low, high), q| (low.min(*q), high.max(*q)));
        assert!((0.2..0.5).contains(&((high - low) / std::f64::consts::TAU)), "{}", high - low);
        of(&trial::motor(), &log, cogging::line(begun, 0.01, false))
    }

    /// The order that is found in a log for a line that is begun at another one.
    fn of(nominal: &Model, log: &Log, begun: Hypothesis) -> Option<f64> {
        let record = Record::new(log, None);
        let mask = vec![1.0; record.measured.len()];
        let problem = Problem::new(&record, &mask);
        let value = begun.start.kind.spec().parameters.iter().position(|spec| spec.key == "order");
        let stage = trial::fitted(&problem, nominal, &[begun]);
        let expected = noise::expected(nominal, &record);
        let better = reordered(&problem, &stage, 0, &expected).unwrap();
        better.map(|stage| stage.fit.model.effects[0].values[value.unwrap()])
    }

    #[test]
    fn an_order_that_a_short_travel_does_not_tell_is_found_from_beside_it() {
        assert_eq!(found(44.0), Some(42.0));
        assert_eq!(found(41.0), Some(42.0));
    }

    #[test]
    fn a_line_that_is_gravitys_is_not_found_for_another_one() {
        let mut nominal = trial::motor();
        let log = trial::log(&nominal, trial::line(1.0), 1.8);
        let begun = || cogging::line(2.0, 0.01, false);
        assert_eq!(of(&nominal, &log, begun()), None);
        // What the model has is not found again: the line is no pull that it lacks.
        nominal.load.gravity_nm = 1e-6;
        assert_eq!(of(&nominal, &log, begun()), Some(1.0));
    }

    #[test]
    fn an_encoder_off_its_centre_is_no_tilted_one_over_a_quarter_turn() {
        let line = EffectParameters::new(Kind::EncoderEccentricity, Location::Encoder);
        let hidden = line.with("amplitude_rad", 0.03).with("phase_rad", 2.0);
        let log = trial::log(&trial::motor(), hidden, 1.8);
        let begun = |order: f64| Hypothesis {
            start: line.with("order", order),
            free: vec![Free::Phasor { amplitude: 0, scale: 1e-3, sigma: 100.0 }],
        };
        assert_eq!(of(&trial::motor(), &log, begun(2.0)), Some(1.0));
        assert_eq!(of(&trial::motor(), &log, begun(1.0)), None);
    }

    #[test]
    fn a_line_that_is_all_in_its_double_gets_the_doubles_order() {
        let nominal = trial::motor();
        let record = Record::new(&trial::log(&nominal, trial::line(14.0), 4.0), None);
        let mask = vec![1.0; record.measured.len()];
        let problem = Problem::new(&record, &mask);
        let expected = noise::expected(&nominal, &record);
        let asked = |order: f64| {
            let stage = trial::fitted(&problem, &nominal, &[cogging::line(order, 0.01, true)]);
            let better = doubled(&problem, &stage, 0, &expected).unwrap();
            better.map(|stage| stage.fit.model.effects[0].values)
        };
        let [order, amplitude, _, second, ..] = asked(7.0).unwrap();
        assert_eq!(order, 14.0);
        assert!(second.abs() < NO_LINE * amplitude.abs(), "{amplitude} {second}");
        assert!(asked(14.0).is_none());
    }

    #[test]
    fn a_line_travels_with_its_own_shaft_and_teeth_with_the_one_before() {
        let model = actuator();
        let record = Record::new(&trial::log(&trial::motor(), trial::line(42.0), 1.8), None);
        let of =
            |kind, location| travel_rad(&record, &model, &EffectParameters::new(kind, location));
        let motor = of(Kind::Cogging, Location::Motor);
        let behind = of(Kind::PositionDependentFriction, Location::Stage(1));
        assert!((behind * model.stages[0].reduction / motor - 1.0).abs() < 1e-12, "{behind}");
        assert_eq!(of(Kind::TransmissionError, Location::Stage(1)), motor);
        assert_eq!(of(Kind::EncoderEccentricity, Location::Encoder), motor);
    }

    #[test]
    fn the_right_order_stays() {
        assert_eq!(found(42.0), None);
    }
}
