//! What is read of an observer, in SI.

use super::gains::{Regime, Spread};
use super::health::Status;
use super::{Observer, Track};
use crate::effect::Effects;
use crate::scalar::Real;

/// What no sensor measures, at one sampling instant; every quantity at its own side of the gear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate<S, const N: usize> {
    /// Rotor speed, rad/s.
    pub motor_velocity: S,
    /// Friction torque on the rotor, Nm; friction is positive with positive speed.
    pub motor_friction: S,
    /// Friction torque on the mass behind each stage, reflected to the motor, Nm.
    pub stage_friction: [S; N],
    /// Their sum: the friction of the whole joint at the motor, Nm.
    pub total_friction: S,
    /// Wind-up η q_in − q_out of each stage, rad.
    pub windup: [S; N],
    /// Whole turns of the output,
    pub output_turns: i32,
    /// and the part of a turn beside them.
    pub output_part: S,
    /// Output speed, rad/s.
    pub output_velocity: S,
    /// Load torque at the output, Nm, positive against positive motion.
    pub load: S,
    /// Drive that is missing (V, or A where the current is imposed): of the order of what the
    /// resistance is off, times the current.
    pub bias: S,
    /// Share of the model's resistance by which the winding's is larger.
    pub resistance: S,
    /// Share by which the torque constant exceeds the model's.
    pub flux: S,
    /// Share by which friction exceeds the model's.
    pub friction: S,
    /// One standard deviation of each.
    pub spread: Spread<S, N>,
    /// Which row of gains and deviations is in use, as [`Regime::row`](super::Regime::row) counts.
    pub row: usize,
    /// Health.
    pub status: Status,
}

impl<S: Real, const N: usize, E: Effects<S>> Observer<S, N, E> {
    /// Reads the estimate that the last [`Observer::update`] left. In fixed point most of it would
    /// leave the range: read [`Observer::reading`] there.
    pub fn estimate(&self, track: &Track<S, N>) -> Estimate<S, N> {
        let (units, gains) = (&self.joint.units, &self.gains);
        let e = self.reading(track);
        let si = |values: [S; N]| {
            let mut values = values;
            for (value, gain) in values.iter_mut().zip(&gains.windup) {
                *value = value.times(*gain);
            }
            values
        };
        Estimate {
            motor_velocity: e.motor_velocity.times(units.speed),
            motor_friction: e.motor_friction.times(units.torque),
            stage_friction: e.stage_friction.map(|torque| torque.times(units.torque)),
            total_friction: e.total_friction.times(units.torque),
            windup: si(e.windup),
            output_velocity: e.output_velocity.times(gains.output_speed),
            load: e.load.times(gains.load),
            bias: e.bias.times(gains.drive),
            spread: Spread {
                motor_velocity: e.spread.motor_velocity.times(units.speed),
                total_friction: e.spread.total_friction.times(units.torque),
                windup: si(e.spread.windup).map(S::abs),
                output_angle: e.spread.output_angle.times(gains.turn),
                output_velocity: e.spread.output_velocity.times(gains.output_speed).abs(),
                load: e.spread.load.times(gains.load).abs(),
            },
            ..e
        }
    }

    /// The same in the joint's units ([`Bases`](crate::per_unit::Bases)), everything as it is felt at
    /// the motor; the output angle's deviation is in turns of the output.
    pub fn reading(&self, track: &Track<S, N>) -> Estimate<S, N> {
        let (joint, gains, state) = (&self.joint, &self.gains, &track.state);
        let rotor = &state.rotor;
        let all = S::ONE + track.parameters.friction;
        let (motor_friction, mut stage_friction) = joint.friction(state);
        let motor_friction = motor_friction * all;
        let mut total = motor_friction;
        let mut turning = joint.rotor.turning(rotor);
        let mut wound = S::ZERO;
        let mut windup = [S::ZERO; N];
        let out = stage_friction.iter_mut().zip(&mut windup);
        for ((stage, own), (friction, windup)) in state.stages.iter().zip(&joint.stages).zip(out) {
            *friction = *friction * all;
            turning = turning + own.friction.turning(&stage.mass);
            total = total + *friction;
            *windup = stage.deflection;
            wound = wound + stage.deflection;
        }
        let last = state.stages.last().map_or(rotor.speed, |stage| stage.mass.speed);
        let (turns, base) = gains.geared.turns(state.angle.whole);
        let part = (state.angle.part - wound.times(joint.turns)).times(gains.shaft);
        let (more, output_part) = (S::from_turn_counts(base.0 as i32) + part).split_turns();
        // Read as signed, the upper half of a turn counts back from the next.
        let turns = turns.wrapping_add(i32::from(base.0 > i32::MAX as u32));
        let row = usize::from(track.schedule.row);
        let mut spread = match gains.spread.get(row) {
            Some(spread) => *spread,
            None => Spread::filled(S::ZERO),
        };
        let [without, with] = gains.turning;
        let turning = turning * if Regime::has_output(row) { with } else { without };
        spread.total_friction = spread.total_friction + turning;
        Estimate {
            motor_velocity: rotor.speed,
            motor_friction,
            stage_friction,
            total_friction: total,
            windup,
            output_turns: turns.wrapping_add(more),
            output_part,
            output_velocity: last,
            load: track.disturbance.load,
            bias: track.disturbance.bias,
            resistance: track.parameters.resistance + track.parameters.flux,
            flux: track.parameters.flux,
            friction: track.parameters.friction,
            spread,
            row,
            status: track.status,
        }
    }
}
