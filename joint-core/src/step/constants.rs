//! What a step knows of a joint: constants, which never change.

use crate::angle::{Angle, Ratio};
use crate::batch::{Batch, Numbers, batch};
use crate::friction::Friction;
use crate::gear::Spring;
use crate::motor::RotorKick;
use crate::params::Motor;
use crate::scalar::Scalar;
use crate::settings::Drive;

/// A joint of `N` stages with effects `E`, ready to step.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = "E: crate::number::Wire"))]
pub struct Joint<S: Scalar, const N: usize, E = ()> {
    /// Micro-steps of the splitting; zero where the joint takes the implicit method.
    pub(crate) micro_steps: u32,
    pub(crate) implicit: Implicit<S>,
    /// Deflection per speed over half a micro-step.
    pub(crate) half_drift: S::Gain,
    /// Turns per speed over half a micro-step.
    pub(crate) half_turn: S::Gain,
    /// One; blocks have it here.
    pub(crate) whole_turn: Ratio<S>,
    /// Turns per speed over the first kick; half of what the middle one takes to either side.
    pub(crate) kick_turn: S::Gain,
    /// Turns per unit of deflection.
    pub(crate) turns: S::Gain,
    pub(crate) rotor: Friction<S>,
    pub(crate) rotor_gamma: S::Gain,
    pub(crate) outer: RotorKick<S>,
    pub(crate) middle: RotorKick<S>,
    #[cfg_attr(feature = "serde", serde(with = "serde_big_array::BigArray"))]
    pub(crate) stages: [StageConstants<S>; N],
    pub(crate) effects: E,
    pub(crate) per_drive: S::Gain,
    pub(crate) per_load: S::Gain,
    pub(crate) current_imposed: bool,
    /// Whether any stage has a damper.
    pub(crate) damped: bool,
    pub(crate) output_shaft: f64,
    pub(crate) units: Units<S>,
}

impl<U: Scalar<Gain = U>, const N: usize, E: Batch<U>> Batch<U> for Joint<f64, N, E> {
    type Batched = Joint<U, N, E::Batched>;
    fn batch(&self, numbers: &mut impl Numbers<U>) -> Self::Batched {
        Joint {
            micro_steps: self.micro_steps,
            implicit: self.implicit.batch(numbers),
            half_drift: self.half_drift.batch(numbers),
            half_turn: self.half_turn.batch(numbers),
            whole_turn: self.whole_turn.batch(numbers),
            kick_turn: self.kick_turn.batch(numbers),
            turns: self.turns.batch(numbers),
            rotor: self.rotor.batch(numbers),
            rotor_gamma: self.rotor_gamma.batch(numbers),
            outer: self.outer.batch(numbers),
            middle: self.middle.batch(numbers),
            stages: self.stages.batch(numbers),
            effects: self.effects.batch(numbers),
            per_drive: self.per_drive.batch(numbers),
            per_load: self.per_load.batch(numbers),
            current_imposed: self.current_imposed,
            damped: self.damped,
            output_shaft: numbers.exact(self.output_shaft),
            units: self.units.batch(numbers),
        }
    }
}

/// One stage: the spring, and the mass behind it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub(crate) struct StageConstants<S: Scalar> {
    pub(crate) spring: Spring<S>,
    pub(crate) friction: Friction<S>,
    /// Mobility τ/J of the outer and the middle kick.
    pub(crate) mobility: [S::Gain; 2],
    /// γ = h²/(24 J) of the force gradient.
    pub(crate) gamma: S::Gain,
    /// One over the reduction up to this mass.
    pub(crate) shaft: Ratio<S>,
}

batch!(StageConstants<Scalar>: spring, friction, mobility, gamma, shaft);

impl<S: Scalar> StageConstants<S> {
    /// Angle of this mass modulo its own turns, from its angle at the motor.
    #[inline(always)]
    pub(crate) fn own_angle(&self, at_motor: Angle<S>) -> Angle<S> {
        Angle { part: self.shaft.of(at_motor), ..Angle::default() }
    }
}

/// What one of each state quantity is in SI, at the motor.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub(crate) struct Units<S: Scalar> {
    pub(crate) current: S::Gain,
    pub(crate) speed: S::Gain,
    pub(crate) torque: S::Gain,
    pub(crate) angle: S::Gain,
    pub(crate) per_current: f64,
    pub(crate) per_speed: f64,
    pub(crate) per_angle: f64,
}

impl<U: Scalar<Gain = U>> Batch<U> for Units<f64> {
    type Batched = Units<U>;
    fn batch(&self, numbers: &mut impl Numbers<U>) -> Units<U> {
        Units {
            current: self.current.batch(numbers),
            speed: self.speed.batch(numbers),
            torque: self.torque.batch(numbers),
            angle: self.angle.batch(numbers),
            per_current: numbers.exact(self.per_current),
            per_speed: numbers.exact(self.per_speed),
            per_angle: numbers.exact(self.per_angle),
        }
    }
}

/// Length of a stage of the implicit method over that of its micro-step.
pub(super) const STAGE: f64 = 1.0 - core::f64::consts::FRAC_1_SQRT_2;

/// What the implicit method knows beside the constants of the splitting.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub(crate) struct Implicit<S: Scalar> {
    /// Micro-steps in a step; zero where the joint takes the splitting.
    pub(crate) micro_steps: u32,
    /// γh/J of the rotor.
    pub(super) mobility: S::Gain,
    /// Share of the way to its final value that the current makes in a stage.
    pub(super) followed: S,
}

batch!(Implicit<Scalar>: mobility, followed; micro_steps);

impl<S: Scalar> Implicit<S> {
    /// For micro-steps of `duration` seconds and a rotor of `inertia` kg m²; units are those at the
    /// motor.
    pub(crate) fn new(
        motor: &Motor,
        drive: Drive,
        inertia: f64,
        (micro_steps, duration): (u32, f64),
        [torque, speed]: [f64; 2],
    ) -> Self {
        let stage = STAGE * duration;
        let lag = match drive {
            Drive::Voltage => motor.phase_inductance_h / motor.phase_resistance_ohm,
            Drive::Current => 0.0,
        };
        Self {
            micro_steps,
            mobility: S::gain(stage / inertia * torque / speed),
            followed: S::from_f64(stage / (lag + stage)),
        }
    }
}
