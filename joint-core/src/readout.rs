//! What a joint's state says in SI, in the numbers that a drive reports.

use crate::effect::Effects;
use crate::joint::{Joint, State};
use crate::scalar::Scalar;

impl<S: Scalar, const N: usize, E: Effects<S>> Joint<S, N, E> {
    /// Friction of all masses as it is felt at the motor, Nm, positive against positive motion.
    pub fn total_friction_at_motor(&self, state: &State<S, N>) -> S {
        let own = |friction: &crate::friction::Friction<S>, mass: &crate::joint::Mass<S>| {
            friction.standing(mass) + mass.damping * mass.speed
        };
        let stages = self.stages.iter().zip(&state.stages);
        let sum = stages.fold(own(&self.rotor, &state.rotor), |sum, (constants, stage)| {
            sum + own(&constants.friction, &stage.mass)
        });
        sum.times(self.units.torque)
    }

    /// Deflection of a stage's spring at its own output, rad: input angle over reduction, less
    /// output angle. Stages count from 0; zero for one that is not there.
    pub fn windup(&self, state: &State<S, N>, stage: usize) -> S {
        match self.stages.get(stage) {
            Some(own) => self.deflection(state, stage).times(own.shaft.gain()),
            None => S::ZERO,
        }
    }

    /// Speed of the last mass at its own side, rad/s.
    pub fn output_velocity(&self, state: &State<S, N>) -> S {
        let speed = self.speed(state, N);
        self.stages.last().map_or(speed, |last| speed.times(last.shaft.gain()))
    }

    /// Angle of the last mass at its own side, rad, where the rotor is at this one.
    pub fn output_angle(&self, state: &State<S, N>, motor_rad: S) -> S {
        let lag = (0..N).fold(S::ZERO, |sum, stage| sum + self.deflection(state, stage));
        self.stages.last().map_or(motor_rad, |last| (motor_rad - lag).times(last.shaft.gain()))
    }

    /// Whether the current is imposed, else the voltage.
    pub fn is_current_imposed(&self) -> bool {
        self.current_imposed
    }
}
