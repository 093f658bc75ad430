//! What is read of an observer, in SI.

use super::gains::Spread;
use super::health::Status;
use super::{Observer, Track};
use crate::effect::Effects;
use crate::scalar::Scalar;

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
    /// One standard deviation of each.
    pub spread: Spread<S, N>,
    /// Which row of gains and deviations is in use, as [`Regime::row`](super::Regime::row) counts.
    pub row: usize,
    /// Health.
    pub status: Status,
}

impl<S: Scalar, const N: usize, E: Effects<S>> Observer<S, N, E> {
    /// Reads the estimate that the last [`Observer::update`] left.
    pub fn estimate(&self, track: &Track<S, N>) -> Estimate<S, N> {
        let (joint, gains, state) = (&self.joint, &self.gains, &track.state);
        let torque = joint.units.torque;
        let rotor = &state.rotor;
        let motor_friction = joint.rotor.felt(rotor);
        let mut total = motor_friction;
        let mut wound = S::ZERO;
        let mut stage_friction = [S::ZERO; N];
        let mut windup = [S::ZERO; N];
        let constants = joint.stages.iter().zip(&gains.windup);
        let out = stage_friction.iter_mut().zip(&mut windup);
        for ((stage, (own, gain)), (friction, windup)) in
            state.stages.iter().zip(constants).zip(out)
        {
            let mass = &stage.mass;
            let felt = own.friction.felt(mass);
            total = total + felt;
            *friction = felt.times(torque);
            *windup = stage.deflection.times(*gain);
            wound = wound + stage.deflection;
        }
        let last = state.stages.last().map_or(rotor.speed, |stage| stage.mass.speed);
        let (turns, base) = gains.geared.turns(state.angle.whole);
        let part = (state.angle.part - wound.times(joint.turns)).times(gains.shaft);
        let (more, output_part) = (S::from_turn_counts(base.0 as i32) + part).split_turns();
        // Read as signed, the upper half of a turn counts back from the next.
        let turns = turns.wrapping_add(i32::from(base.0 > i32::MAX as u32));
        Estimate {
            motor_velocity: rotor.speed.times(joint.units.speed),
            motor_friction: motor_friction.times(torque),
            stage_friction,
            total_friction: total.times(torque),
            windup,
            output_turns: turns.wrapping_add(more),
            output_part,
            output_velocity: last.times(gains.output_speed),
            load: track.load.times(gains.load),
            bias: track.bias.times(gains.drive),
            spread: match gains.spread.get(usize::from(track.row)) {
                Some(spread) => *spread,
                None => Spread::filled(S::ZERO),
            },
            row: usize::from(track.row),
            status: track.status,
        }
    }
}
