//! What a joint and its state are in SI, and how a state is set.

use super::{Joint, Mass, Method, State};
use crate::angle::Angle;
use crate::effect::{Effects, Memory};
use crate::scalar::Scalar;

impl<S: Scalar, const N: usize, E: Effects<S>> Joint<S, N, E> {
    /// Whether the drive imposes the current, else the voltage.
    pub fn is_current_imposed(&self) -> bool {
        self.current_imposed
    }

    /// The effects in the joint's own units.
    pub fn effects(&self) -> &E {
        &self.effects
    }

    /// Micro-steps in a step.
    pub fn micro_steps(&self) -> u32 {
        self.micro_steps.max(self.implicit.micro_steps)
    }

    /// How a step is computed.
    pub fn method(&self) -> Method {
        if self.micro_steps == 0 { Method::Implicit } else { Method::Splitting }
    }

    /// Current in the winding, A.
    pub fn current(&self, state: &State<S, N>) -> S {
        state.current.times(self.units.current)
    }

    /// What the current sensor shows, A.
    pub fn measured_current(&self, state: &State<S, N>) -> S {
        self.effects.shown_current(state.current, &state.memory).times(self.units.current)
    }

    /// What the sensor shows when this current flows, both in A, of what effects remember.
    pub fn measured(&self, amperes: f64, memory: &Memory<S>) -> f64 {
        let current = S::from_f64(amperes * self.units.per_current);
        let shown = self.effects.shown_current(current, memory);
        shown.times(self.units.current).to_f64()
    }

    /// The current that flows where this one is commanded or measured, A.
    pub fn imposed_current(&self, amperes: S) -> S {
        self.effects.true_current(amperes.times(self.per_drive)).times(self.units.current)
    }

    /// Speed of a mass as it is felt at the motor, rad/s; zero for a mass that is not there.
    pub fn speed(&self, state: &State<S, N>, mass: usize) -> S {
        state.mass(mass).map_or(S::ZERO, |mass| mass.speed.times(self.units.speed))
    }

    /// How many of the state's numbers stand at the end of their range, where they stop: none in a
    /// run that means anything. Floats do so where they are infinite or none.
    pub fn saturated(&self, state: &State<S, N>) -> u32 {
        let of = |mass: &Mass<S>| [mass.speed, mass.bristle.zeta, mass.force, mass.damping];
        let count = |values: &[S]| values.iter().filter(|value| value.is_at_limit()).count() as u32;
        state
            .stages
            .iter()
            .fold(count(&of(&state.rotor)) + count(&[state.current]), |sum, stage| {
                sum + count(&of(&stage.mass)) + count(&[stage.deflection])
            })
    }

    /// Current in the winding, A, in double precision; not for a drive.
    pub fn current_a(&self, state: &State<S, N>) -> f64 {
        state.current.to_f64() / self.units.per_current
    }

    /// What the current sensor shows, A, in double precision; not for a drive.
    pub fn measured_current_a(&self, state: &State<S, N>) -> f64 {
        self.effects.shown_current(state.current, &state.memory).to_f64() / self.units.per_current
    }

    /// Speed of a mass as it is felt at the motor, rad/s, in double precision; not for a drive.
    pub fn speed_rad_per_s(&self, state: &State<S, N>, mass: usize) -> f64 {
        state.mass(mass).map_or(0.0, |mass| mass.speed.to_f64() / self.units.per_speed)
    }

    /// Deflection of a stage's spring as it is felt at the motor, rad, in double precision; stages
    /// count from 0; not for a drive.
    pub fn deflection_rad(&self, state: &State<S, N>, stage: usize) -> f64 {
        state.stages.get(stage).map_or(0.0, |s| s.deflection.to_f64() / self.units.per_angle)
    }

    /// Bristle torque of a mass over its Coulomb level, ζ = σ0 z / α0.
    pub fn bristle(&self, state: &State<S, N>, mass: usize) -> S {
        state.mass(mass).map_or(S::ZERO, |mass| mass.bristle.zeta)
    }

    /// Deflection of a stage's spring as it is felt at the motor, rad; stages count from 0.
    pub fn deflection(&self, state: &State<S, N>, stage: usize) -> S {
        state.stages.get(stage).map_or(S::ZERO, |s| s.deflection.times(self.units.angle))
    }

    /// What a deflection of one is, rad at the motor.
    pub fn angle_unit(&self) -> S {
        S::ONE.times(self.units.angle)
    }

    /// Sets the current, A. Call [`Joint::refresh`] after the last change to a state.
    pub fn set_current(&self, state: &mut State<S, N>, amperes: f64) {
        state.current = S::from_f64(amperes * self.units.per_current);
    }

    /// Sets a mass's speed as it is felt at the motor, rad/s.
    pub fn set_speed(&self, state: &mut State<S, N>, mass: usize, rad_per_s: f64) {
        if let Some(mass) = state.mass_mut(mass) {
            mass.speed = S::from_f64(rad_per_s * self.units.per_speed);
        }
    }

    /// Sets a mass's bristle torque over its Coulomb level.
    pub fn set_bristle(&self, state: &mut State<S, N>, mass: usize, zeta: f64) {
        if let Some(mass) = state.mass_mut(mass) {
            mass.bristle.zeta = S::from_f64(zeta);
        }
    }

    /// Sets a spring's deflection as it is felt at the motor, rad; stages count from 0.
    pub fn set_deflection(&self, state: &mut State<S, N>, stage: usize, rad: f64) {
        if let Some(stage) = state.stages.get_mut(stage) {
            stage.deflection = S::from_f64(rad * self.units.per_angle);
        }
    }

    /// What an encoder shows beside the angle of its shaft, rad there: the motor's, or the one
    /// behind the last stage; of its speed, and of what effects remember.
    pub fn encoder_error(
        &self,
        output: bool,
        angle_rad: f64,
        speed_rad_per_s: f64,
        memory: &Memory<S>,
    ) -> f64 {
        let turn = core::f64::consts::TAU;
        let shaft = if output { self.output_shaft } else { 1.0 };
        let speed = S::from_f64(speed_rad_per_s / shaft * self.units.per_speed);
        let angle = Angle::from_turns(angle_rad / turn);
        self.effects.encoder_error(output, angle, speed, memory).to_f64() * turn
    }
}
