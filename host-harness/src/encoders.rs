//! What the encoders show of a run: the angles, bent by what is wrong with the encoders.
//!
//! Laws stand in `joint-core`. A delay needs the past, which the drive does not keep and a whole run
//! has: here the run itself is asked, exact but for the interpolation between samples.

use joint_core::angle::Angle;
use joint_core::effect::sensor_delay::delay_s;
use joint_core::effect::{EffectParameters, EffectSet, Effects, Kind};
use joint_core::params::Location;
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
        angle + laws.encoder_error(behind, Angle::from_turns(angle / TAU), 0.0) * TAU
    };
    let motor: Vec<f64> = run.iter().map(|s| bent(false, s.motor_angle_rad)).collect();
    let output: Vec<f64> = run
        .iter()
        .map(|s| s.stages.last().map_or(s.motor_angle_rad, |stage| stage.angle_rad))
        .map(|angle| bent(true, angle))
        .collect();
    Shown {
        motor: late(&motor, time_s, delay_s(&model.effects, Location::Encoder)),
        output: late(&output, time_s, delay_s(&model.effects, Location::OutputEncoder)),
    }
}

/// A series as it was `delay` seconds before each of its times, held at its ends.
pub(crate) fn late(values: &[f64], time_s: &[f64], delay: f64) -> Vec<f64> {
    if delay == 0.0 {
        return values.to_vec();
    }
    let at = |time: f64| {
        let after = time_s.partition_point(|t| *t < time);
        match (after.checked_sub(1).and_then(|k| values.get(k)), values.get(after)) {
            (Some(before), Some(next)) => {
                let (from, to) = (time_s[after - 1], time_s[after]);
                before + (next - before) * (time - from) / (to - from)
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
