//! What the sensors show of a run: the angles, bent by what is wrong with the encoders, and the current as late as its
//! report.
//!
//! Laws stand in `joint-core`. A delay and a filter need the past, which the drive does not keep and a whole run
//! has: here the run itself is asked, exact but for the interpolation between samples.

use joint_core::angle::Angle;
use joint_core::effect::sensor_delay::delay_s;
use joint_core::effect::sensor_lag::{lead_s, time_constant_s};
use joint_core::effect::{EffectParameters, EffectSet, Effects, Kind, MEMORIES};
use joint_core::params::{Location, Motor};
use joint_core::per_unit::Bases;
use std::f64::consts::TAU;

use crate::model::Model;
use crate::plant::Snapshot;

/// Angles by sample as the encoders show them, rad.
#[derive(Clone, Debug, PartialEq)]
pub struct Shown {
    /// The motor's encoder.
    pub motor: Vec<f64>,
    /// The one behind the last stage; the motor's where there is none.
    pub output: Vec<f64>,
}

/// What the encoders show of a run at these times.
pub fn shown(model: &Model, time_s: &[f64], run: &[Snapshot]) -> Shown {
    let bases = Bases::si(&model.motor, &model.stages);
    let laws: Vec<EffectParameters> =
        model.effects.iter().filter(|e| e.kind == Kind::EncoderEccentricity).copied().collect();
    let laws = EffectSet::<f64>::new(&laws, &Default::default(), &bases).unwrap_or_default();
    let bent = |behind: bool, angle: f64| {
        let turns = Angle::from_turns(angle / TAU);
        angle + laws.encoder_error(behind, turns, 0.0, &[0.0; MEMORIES]) * TAU
    };
    let motor: Vec<f64> = run.iter().map(|s| bent(false, s.motor_angle_rad)).collect();
    let output: Vec<f64> = run
        .iter()
        .map(|s| s.stages.last().map_or(s.motor_angle_rad, |stage| stage.angle_rad))
        .map(|angle| bent(true, angle))
        .collect();
    let shown = |angles: &[f64], encoder: Location| {
        let effects = &model.effects;
        let filter = [time_constant_s(effects, encoder), lead_s(effects, encoder)];
        let filtered = lagging(angles, time_s, filter);
        late(&filtered, time_s, delay_s(effects, encoder))
    };
    Shown {
        motor: shown(&motor, Location::Encoder),
        output: shown(&output, Location::OutputEncoder),
    }
}

/// A series as a first-order lag of this time constant and lead, s, shows it that has followed it for long at
/// its first slope; straight between its times.
pub fn lagging(values: &[f64], time_s: &[f64], [constant_s, lead_s]: [f64; 2]) -> Vec<f64> {
    if constant_s == 0.0 {
        return values.to_vec();
    }
    let left = 1.0 - lead_s / constant_s;
    let slope = |k: usize| (values[k] - values[k - 1]) / (time_s[k] - time_s[k - 1]);
    let mut behind = if values.len() > 1 { constant_s * slope(1) } else { 0.0 };
    let mut shown = Vec::with_capacity(values.len());
    for (k, value) in values.iter().enumerate() {
        if k > 0 {
            let reached = -(-(time_s[k] - time_s[k - 1]) / constant_s).exp_m1();
            behind += (constant_s * slope(k) - behind) * reached;
        }
        shown.push(value - left * behind);
    }
    shown
}

/// A series as it was `delay` seconds before each of its times, held at its ends.
pub fn late(values: &[f64], time_s: &[f64], delay: f64) -> Vec<f64> {
    late_by(values, time_s, delay, |since, interval| since / interval)
}

/// The motor's current as late as a model's sensor reports it: between two samples, over which a drive holds its
/// voltage, the winding goes from the one to the other exponentially.
pub fn late_current(model: &Model, values: &[f64], time_s: &[f64]) -> Vec<f64> {
    let reached = |since: f64, interval: f64| current_reached(&model.motor, since, interval);
    late_by(values, time_s, model.sensor.current_delay_s, reached)
}

/// Share of its way to the end of an interval that a winding's current has gone in so long, s, under a voltage and a
/// back-EMF that are held: `(1 − exp(−t R/L))/(1 − exp(−h R/L))`.
pub fn current_reached(motor: &Motor, since: f64, interval: f64) -> f64 {
    let constant_s = motor.phase_inductance_h / motor.phase_resistance_ohm;
    let share = (-since / constant_s).exp_m1() / (-interval / constant_s).exp_m1();
    if share.is_finite() { share } else { since / interval }
}

/// The same where a series has gone a share of its way to the next value by then.
fn late_by(
    values: &[f64],
    time_s: &[f64],
    delay: f64,
    share: impl Fn(f64, f64) -> f64,
) -> Vec<f64> {
    if delay == 0.0 {
        return values.to_vec();
    }
    let at = |time: f64| {
        let after = time_s.partition_point(|t| *t < time);
        match (after.checked_sub(1).and_then(|k| values.get(k)), values.get(after)) {
            (Some(before), Some(next)) => {
                let (from, to) = (time_s[after - 1], time_s[after]);
                before + (next - before) * share(time - from, to - from)
            }
            (Some(end), None) | (None, Some(end)) => *end,
            (None, None) => f64::NAN,
        }
    };
    time_s.iter().take(values.len()).map(|time| at(time - delay)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo::actuator;

    fn run(count: usize) -> (Vec<f64>, Vec<Snapshot>) {
        let time_s: Vec<f64> = (0..count).map(|k| 1e-3 * k as f64).collect();
        let at = |t: &f64| Snapshot { motor_angle_rad: 50.0 * t, ..Snapshot::default() };
        let run = time_s.iter().map(at).collect();
        (time_s, run)
    }

    #[test]
    fn a_late_encoder_shows_the_past() {
        let (time_s, run) = run(100);
        let delay = EffectParameters::new(Kind::SensorDelay, Location::Encoder);
        let model = Model { effects: vec![delay.with("delay_s", 2.5e-3)], ..actuator() };
        let shown = shown(&model, &time_s, &run);
        assert!((shown.motor[50] - 50.0 * (0.05 - 2.5e-3)).abs() < 1e-9);
        assert_eq!((shown.motor[1], shown.output[50]), (0.0, 2.5));
    }

    #[test]
    fn a_late_current_is_what_flowed_in_the_winding_between_samples() {
        let mut model = actuator();
        model.motor.phase_inductance_h = 2e-3 * model.motor.phase_resistance_ohm;
        model.sensor.current_delay_s = 0.4e-3;
        let time_s: Vec<f64> = (0..20).map(|k| 1e-3 * f64::from(k)).collect();
        let flows = |t: f64| 3.0 * (1.0 - (-t / 2e-3).exp());
        let values: Vec<f64> = time_s.iter().map(|t| flows(*t)).collect();
        let shown = late_current(&model, &values, &time_s);
        assert!((5..20).all(|k| (shown[k] - flows(time_s[k] - 0.4e-3)).abs() < 1e-12));
        assert!((late(&values, &time_s, 0.4e-3)[1] - shown[1]).abs() > 0.05);
        // A winding without resistance goes straight.
        model.motor.phase_resistance_ohm = 0.0;
        assert_eq!(late_current(&model, &values, &time_s), late(&values, &time_s, 0.4e-3));
    }

    #[test]
    fn a_filtered_encoder_is_behind_a_ramp_by_its_time_constant_and_answers_a_bend_exponentially() {
        let time_s: Vec<f64> = (0..100).map(|k| 1e-3 * f64::from(k)).collect();
        // At rest to 20 ms, then 50 rad/s.
        let angles: Vec<f64> = time_s.iter().map(|t| 50.0 * (t - 0.02).max(0.0)).collect();
        let shown = lagging(&angles, &time_s, [0.01, 0.0]);
        let wanted = |t: f64| 50.0 * (t - 0.01 * (1.0 - (-t / 0.01).exp()));
        assert!((shown[60] - wanted(0.04)).abs() < 1e-12 && shown[20] == 0.0);
        // In even motion what it shows is behind by the time constant less the lead.
        for (lead, behind) in [(0.0, 0.5), (4e-3, 0.3), (-2e-3, 0.6)] {
            let moving = lagging(&angles[30..], &time_s[30..], [0.01, lead]);
            assert!(moving.iter().zip(&angles[30..]).all(|(a, b)| (b - a - behind).abs() < 1e-12));
        }
    }

    #[test]
    fn an_eccentric_encoder_swings_once_a_turn() {
        let (time_s, run) = run(400);
        let bent = EffectParameters::new(Kind::EncoderEccentricity, Location::Encoder);
        let model = Model { effects: vec![bent.with("amplitude_rad", 0.02)], ..actuator() };
        let shown = shown(&model, &time_s, &run);
        for (shown, snapshot) in shown.motor.iter().zip(&run) {
            let angle = snapshot.motor_angle_rad;
            assert!((shown - angle - 0.02 * angle.sin()).abs() < 1e-7);
        }
    }
}
