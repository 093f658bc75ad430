//! Whether a name that fits is one to believe.
//!
//! A fit takes any value that makes the log likelier; a joint does not. What its law cannot be, and
//! what a channel contradicts which is never fitted to, is no name.

use std::f64::consts::TAU;

use joint_core::effect::EffectParameters;
use joint_core::joint::Drive;
use joint_core::params::Location;
use joint_core::per_unit::Bases;

use super::contradiction::contradiction;
use crate::discover::bounds::{AT_END, MOST_ERROR, MOST_TORQUE};
use crate::discover::candidates::card;
use crate::discover::candidates::channels::largest_current;
use crate::discover::candidates::orders::span;
use crate::discover::state::search::Search;
use crate::estimate::record::{Channel, Record};
use crate::model::Model;

impl Search {
    /// Whether a model's last effect is one that a joint can have and that no channel contradicts;
    /// keeps what does.
    pub(crate) fn believes(&mut self, model: &Model, record: &Record) -> bool {
        if !believable(model, record) {
            return false;
        }
        let Some(against) = contradiction(model, record) else { return true };
        self.contradicted(against);
        false
    }
}

/// Whether a model's last effect is one that a joint can have.
fn believable(model: &Model, record: &Record) -> bool {
    model.effects.last().is_none_or(|effect| possible(effect, model, record))
}

/// Whether an effect is one that a joint can have: no value where its law ends, nothing that its card knows no joint
/// can have (a sensor that sees the future), no line along the rotor whose order was free to leave what the record's
/// travel can show.
pub(crate) fn possible(effect: &EffectParameters, model: &Model, record: &Record) -> bool {
    let mut values = effect.kind.spec().parameters.iter().zip(effect.values);
    let inside = values.all(|(spec, value)| {
        let apart = |end: f64| end == 0.0 || (value - end).abs() > AT_END * end.abs();
        apart(spec.low) && apart(spec.high)
    });
    let impossible = (card(effect.kind).rules.impossible)(effect, model, record);
    inside
        && !impossible
        && !endless(effect, record)
        && !excessive(effect, model, record)
        && !forgetful(effect, record)
}

/// Stretches over which a motion is looked at to see how long it lasts.
const STRETCHES: usize = 200;

/// Whether an effect warms and cools faster than the motion changes: then it follows the present speed or
/// current, and is some other law of these.
fn forgetful(effect: &EffectParameters, record: &Record) -> bool {
    let keys = effect.kind.spec().parameters.iter().map(|spec| spec.key);
    let constant = keys.zip(effect.values).find(|(key, _)| *key == "time_constant_s");
    let thermal = card(effect.kind).reference.is_some();
    thermal && constant.is_some_and(|(_, constant_s)| constant_s < lasting_s(record))
}

/// How long a motion lasts, s: the RMS of the rotor's speed about its mean over that of its change in time; zero
/// of one that is nowhere seen. At a constant speed a temperature changes alone.
fn lasting_s(record: &Record) -> f64 {
    let stretch = (record.len() / STRETCHES).max(1);
    let shown = |k: usize| (record.time_s[k], record.measured[k][Channel::Motor as usize]);
    let places: Vec<_> = (0..record.len()).step_by(stretch).map(shown).collect();
    let speeds: Vec<f64> =
        places.windows(2).map(|at| (at[1].1 - at[0].1) / (at[1].0 - at[0].0)).collect();
    let speeds: Vec<f64> = speeds.into_iter().filter(|speed| speed.is_finite()).collect();
    let mean = speeds.iter().sum::<f64>() / speeds.len().max(1) as f64;
    let speed: f64 = speeds.iter().map(|speed| (speed - mean).powi(2)).sum();
    let change: f64 = speeds.windows(2).map(|at| (at[1] - at[0]).powi(2)).sum();
    let interval = record.grid.typical_interval() * stretch as f64;
    if change > 0.0 { interval * (speed / change).sqrt() } else { 0.0 }
}

/// Whether an amplitude is beyond what a joint can have that its drive moves.
fn excessive(effect: &EffectParameters, model: &Model, record: &Record) -> bool {
    let bases = Bases::si(&model.motor, &model.stages);
    let mass = match effect.location {
        Location::Output | Location::OutputEncoder => model.stages.len(),
        Location::Stage(stage) => stage.into(),
        _ => 0,
    };
    let shaft = bases.shaft(mass).abs();
    let mut parameters = effect.kind.spec().parameters.iter().zip(effect.values);
    parameters.any(|(spec, value)| {
        let amplitude = |unit: &str| spec.key.ends_with(&format!("amplitude_{unit}"));
        let travel = || span(record.measured.iter().map(|row| row[Channel::Motor as usize]));
        amplitude("nm") && !is_moved(value * shaft, model, record)
            || amplitude("rad") && value.abs() > MOST_ERROR * shaft * travel()
    })
}

/// Whether a torque, Nm at the motor, is one against which a drive still moves its joint.
pub(crate) fn is_moved(torque_nm: f64, model: &Model, record: &Record) -> bool {
    let motor = &model.motor;
    let largest = match (record.drive, largest_current(record)) {
        (Drive::Voltage, 0.0) => {
            let volts = record.drive_values.iter().fold(0.0_f64, |most, u| most.max(u.abs()));
            volts / (2.0 * motor.phase_resistance_ohm)
        }
        (_, current) => current,
    };
    let most = MOST_TORQUE * motor.torque_constant_nm_per_a * largest;
    // A drive that rests, or a winding without a resistance, does not tell.
    most.is_nan() || most == 0.0 || torque_nm.abs() <= most
}

/// Whether an effect is a line along the rotor of which the record holds no whole period: any slow course.
/// Whole orders are not fitted.
fn endless(effect: &EffectParameters, record: &Record) -> bool {
    let parameters = effect.kind.spec().parameters;
    let order = parameters.iter().position(|spec| spec.key == "order");
    order.map(|place| effect.values[place]).is_some_and(|order| {
        let fitted = effect.location == Location::Motor && order.fract() != 0.0;
        let angles = record.measured.iter().map(|row| row[Channel::Motor as usize]);
        fitted && order * span(angles) < TAU
    })
}

#[cfg(test)]
mod tests {
    use joint_core::effect::Kind;

    use super::*;
    use crate::demo::actuator;
    use crate::log::Log;

    /// Whether an effect is believed of a log with currents up to 1 A and one turn of the rotor.
    fn believed(effect: EffectParameters, geared: bool) -> bool {
        let log = Log {
            time_s: (0..400).map(|k| f64::from(k) * 1e-3).collect(),
            voltage_v: Some(vec![1.0; 400]),
            current_a: Some((0..400).map(|k| f64::from(k) / 399.0).collect()),
            motor_angle_rad: (0..400).map(|k| TAU * f64::from(k) / 399.0).collect(),
            ..Log::default()
        };
        let mut model = actuator();
        if !geared {
            model.stages.clear();
        }
        model.effects.push(effect);
        believable(&model, &Record::new(&log, None))
    }

    #[test]
    fn a_torque_may_bend_at_the_largest_current_but_not_fall_over_half_the_range() {
        let knee = |current: f64| {
            let effect = EffectParameters::new(Kind::TorqueSaturation, Location::Motor);
            believed(effect.with("current_a", current), true)
        };
        assert!(knee(2.0) && knee(0.75));
        assert!(!knee(0.4));
    }

    #[test]
    fn a_value_next_to_the_end_of_its_law_is_at_it() {
        let width = |width: f64| {
            let hysteresis = EffectParameters::new(Kind::StructuralHysteresis, Location::Stage(1));
            believed(hysteresis.with("amplitude_nm", 1.0).with("width_rad", width), true)
        };
        assert_eq!([1e-9, 1.0001e-9, 1.1e-9, 999.9].map(width), [false, false, true, false]);
    }

    #[test]
    fn a_fitted_order_has_a_whole_period_on_the_way() {
        let line = |order: f64| {
            let line = EffectParameters::new(Kind::Cogging, Location::Motor);
            believed(line.with("order", order).with("amplitude_nm", 0.01), true)
        };
        assert_eq!([0.6, 1.0, 1.4].map(line), [false, true, true]);
    }

    #[test]
    fn a_sensor_sees_the_future_only_beside_another() {
        let delay = |seconds: f64, geared: bool| {
            let effect = EffectParameters::new(Kind::SensorDelay, Location::Encoder);
            believed(effect.with("delay_s", seconds), geared)
        };
        assert!(delay(1e-3, false) && delay(-1e-3, true));
        assert!(!delay(-1e-3, false));
    }

    #[test]
    fn no_amplitude_is_believed_that_the_drive_could_not_move_or_an_encoder_not_show() {
        let pull = |torque: f64| {
            let gravity = EffectParameters::new(Kind::Gravity, Location::Motor);
            believed(gravity.with("amplitude_nm", torque), false)
        };
        // The largest current is 1 A.
        let most = MOST_TORQUE * actuator().motor.torque_constant_nm_per_a;
        assert!(pull(0.9 * most) && pull(-0.9 * most) && !pull(1.1 * most) && !pull(1e13));
        let off = |radians: f64| {
            let encoder = EffectParameters::new(Kind::EncoderEccentricity, Location::Encoder);
            believed(encoder.with("amplitude_rad", radians).with("order", 1.0), false)
        };
        // Of one turn.
        assert!(off(0.2) && !off(0.3 * TAU));
    }

    #[test]
    fn what_warms_faster_than_the_motion_changes_does_not_warm() {
        // A swing at 10 rad/s for 4 s.
        let log = Log {
            time_s: (0..4000).map(|k| f64::from(k) * 1e-3).collect(),
            voltage_v: Some(vec![1.0; 4000]),
            motor_angle_rad: (0..4000).map(|k| (f64::from(k) * 1e-2).sin()).collect(),
            ..Log::default()
        };
        let record = Record::new(&log, None);
        assert!((lasting_s(&record) * 10.0 - 1.0).abs() < 0.05, "{}", lasting_s(&record));
        let warming = |constant_s: f64| {
            let warming = EffectParameters::new(Kind::LubricantWarming, Location::Motor);
            possible(&warming.with("time_constant_s", constant_s), &actuator(), &record)
        };
        assert_eq!([1e-3, 0.09, 0.12, 100.0].map(warming), [false, false, true, true]);
        // At a constant speed, seen by an encoder that rounds, the drag falls with the temperature alone.
        let turning = Log {
            motor_angle_rad: (0..4000).map(|k| (f64::from(k) * 0.1).round() * 1e-2).collect(),
            ..log
        };
        assert!(lasting_s(&Record::new(&turning, None)) < 0.05);
    }

    #[test]
    fn a_drive_that_rests_does_not_tell_what_it_could_move() {
        let log = Log {
            time_s: (0..400).map(|k| f64::from(k) * 1e-3).collect(),
            voltage_v: Some(vec![0.0; 400]),
            motor_angle_rad: (0..400).map(|k| f64::from(k) * 1e-2).collect(),
            ..Log::default()
        };
        assert!(is_moved(5.0, &actuator(), &Record::new(&log, None)));
    }
}
