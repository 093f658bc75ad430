//! The assembled joint: constants, state, and how both are read.
//!
//! [`Joint`] is built once from SI parameters and never changes; [`State`] is what moves. One joint
//! drives many states. Masses count from 0 at the rotor. Quantities asked for or given here are SI and
//! reflected to the motor, as the state is in per-unit; the load is the output's own.

use crate::angle::{Angle, Ratio};
use crate::effect::{EffectParameters, EffectSet, Effects, MEMORIES, Memory};
use crate::friction::{Bristle, Friction};
use crate::gear::Spring;
use crate::implicit::Implicit;
use crate::motor::RotorKick;
use crate::params::{self, Load, Motor, ParameterError, Stage};
use crate::per_unit::{Bases, reflected_inertia};
use crate::scalar::Scalar;

pub use crate::motor::Drive;
pub use crate::pace::{IMPLICIT, MAX_MICRO_STEPS, Method, Pace, Plan, micro_steps};

/// How a joint is to be stepped.
#[derive(Clone, Copy, Debug)]
pub struct Settings<'a> {
    /// What the drive imposes.
    pub drive: Drive,
    /// Length of a step, seconds.
    pub step_s: f64,
    /// Micro-steps in a step; `None` takes what [`Pace::plan`] finds for the method.
    pub micro_steps: Option<u32>,
    /// How it is stepped; `None` takes what [`Pace::plan`] finds. Fixed point knows the splitting
    /// alone.
    pub method: Option<Method>,
    /// Effects beside the plain equations; used by joints with an [`EffectSet`].
    pub effects: &'a [EffectParameters],
}

impl Settings<'_> {
    /// A step of this length, divided as the parameters ask, without effects.
    pub fn new(drive: Drive, step_s: f64) -> Self {
        Self { drive, step_s, micro_steps: None, method: None, effects: &[] }
    }
}

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

impl<S: Scalar> StageConstants<S> {
    /// Angle of this mass modulo its own turns, from its angle at the motor.
    #[inline(always)]
    pub(crate) fn own_angle(&self, at_motor: Angle<S>) -> Angle<S> {
        Angle { part: self.shaft.of(at_motor), ..Angle::default() }
    }
}

/// A joint of `N` stages with effects `E`, ready to step.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = "E: crate::scalar::Wire"))]
pub struct Joint<S: Scalar, const N: usize, E = ()> {
    /// Micro-steps of the splitting; zero where the joint takes the implicit method.
    pub(crate) micro_steps: u32,
    pub(crate) implicit: Implicit<S>,
    /// Deflection per speed over half a micro-step.
    pub(crate) half_drift: S::Gain,
    /// Turns per speed over half a micro-step.
    pub(crate) half_turn: S::Gain,
    /// One.
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
    per_drive: S::Gain,
    pub(crate) per_load: S::Gain,
    pub(crate) current_imposed: bool,
    /// Whether any stage has a damper.
    pub(crate) damped: bool,
    pub(crate) output_shaft: f64,
    pub(crate) units: Units<S>,
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

/// One mass: its speed and bristle, and the force and damping it was last found under.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mass<S> {
    /// Speed, reflected to the motor.
    pub speed: S,
    /// Friction state.
    pub bristle: Bristle<S>,
    pub(crate) force: S,
    pub(crate) damping: S,
}

/// One stage: the spring's deflection and the mass behind it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StageState<S> {
    /// Deflection of the spring, reflected to the motor.
    pub deflection: S,
    /// The mass behind it.
    pub mass: Mass<S>,
    /// What rounding has taken of the deflection; see [`Scalar::drifted`].
    pub(crate) lost: S,
}

/// All that moves in a joint of `N` stages.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State<S: Scalar, const N: usize> {
    /// Current in the two conducting phases.
    pub current: S,
    /// Rotor angle.
    pub angle: Angle<S>,
    /// The rotor.
    pub rotor: Mass<S>,
    /// The stages, from the motor on.
    pub stages: [StageState<S>; N],
    /// What effects remember.
    pub memory: Memory<S>,
}

/// What acts on a joint for one step, per-unit: made by [`Joint::input`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Input<S> {
    pub(crate) drive: S,
    pub(crate) load: S,
}

impl<S: Scalar, const N: usize> Joint<S, N> {
    /// A joint without effects.
    ///
    /// # Errors
    /// The first parameter that the equations cannot take; gravity, which is a law of the
    /// [`EffectSet`].
    pub fn new(
        motor: &Motor,
        stages: &[Stage; N],
        load: &Load,
        settings: &Settings<'_>,
    ) -> Result<Self, ParameterError> {
        if load.gravity_nm != 0.0 {
            return Err(params::gravity_without_effects(load));
        }
        Self::with(motor, stages, load, settings, |_| Some(()))
    }
}

impl<S: Scalar, const N: usize> Joint<S, N, EffectSet<S>> {
    /// A joint with the effects of `settings` and the load's gravity.
    ///
    /// # Errors
    /// The first parameter that the equations cannot take.
    pub fn new(
        motor: &Motor,
        stages: &[Stage; N],
        load: &Load,
        settings: &Settings<'_>,
    ) -> Result<Self, ParameterError> {
        crate::effect::validate(settings.effects, N)?;
        Self::with(motor, stages, load, settings, |bases| {
            EffectSet::new(settings.effects, load, bases)
        })
    }
}

impl<S: Scalar, const N: usize, E: Effects<S>> Joint<S, N, E> {
    /// A joint with effects made in its own units.
    ///
    /// # Errors
    /// The first parameter that the equations cannot take.
    pub fn with(
        motor: &Motor,
        stages: &[Stage; N],
        load: &Load,
        settings: &Settings<'_>,
        effects: impl FnOnce(&Bases<'_>) -> Option<E>,
    ) -> Result<Self, ParameterError> {
        params::validate(motor, stages, load)?;
        params::validate_drive(motor, settings.drive == Drive::Voltage, settings.step_s)?;
        let mut bases = Bases::of(motor, stages, settings.step_s);
        let pace = Pace::with(motor, stages, load, settings.effects);
        let plan = pace.plan_for(settings, IMPLICIT && S::IMPLICIT);
        let micro_steps = plan.micro_steps;
        let step = settings.step_s / f64::from(micro_steps);
        let half = step / 2.0;
        bases.half_step = half;
        crate::range::check::<S>(&bases, stages, step)?;
        let Bases { torque, speed, angle, current, resistance, .. } = bases;
        let inertia = |mass| reflected_inertia(motor, stages, load, mass);
        let gamma = |inertia: f64| S::gain(step * step / (24.0 * inertia) * torque / angle);
        let friction = |mass| {
            let friction = bases.friction(mass);
            Friction::new(friction, bases.shaft(mass), half, inertia(mass), [torque, speed])
        };
        let kick = |weight: f64| {
            let units = [torque, speed, current];
            RotorKick::new(motor, settings.drive, inertia(0), weight * step, units)
        };
        let effects = effects(&bases).ok_or(params::unplaced_effect(settings.effects.len()))?;
        if let Some(error) = params::worm_without_effects(stages)
            && !effects.has_levels()
        {
            return Err(error);
        }
        let mut number = 0;
        let stages = stages.map(|stage| {
            number += 1;
            let (own, shaft) = (inertia(number), bases.shaft(number));
            StageConstants {
                spring: Spring::new(
                    &stage,
                    shaft,
                    half,
                    [torque, speed, angle],
                    [inertia(number - 1), own],
                ),
                friction: friction(number),
                mobility: [OUTER, MIDDLE].map(|w| S::gain(w * step / own * torque / speed)),
                gamma: gamma(own),
                shaft: Ratio::new(shaft),
            }
        });
        let (taken, instead) = match plan.method {
            Method::Splitting => (micro_steps, 0),
            Method::Implicit => (0, micro_steps),
        };
        let implicit = (instead, step);
        Ok(Self {
            micro_steps: taken,
            implicit: Implicit::new(motor, settings.drive, inertia(0), implicit, [torque, speed]),
            half_drift: S::gain(half * speed / angle),
            half_turn: S::gain(half * speed / core::f64::consts::TAU),
            whole_turn: Ratio::new(1.0),
            kick_turn: S::gain(OUTER * step * speed / core::f64::consts::TAU),
            turns: S::gain(angle / core::f64::consts::TAU),
            rotor: friction(0),
            rotor_gamma: gamma(inertia(0)),
            outer: kick(OUTER),
            middle: kick(MIDDLE),
            damped: stages.iter().any(|stage| stage.spring.is_damped()),
            stages,
            effects,
            per_drive: S::gain(match settings.drive {
                Drive::Voltage => 1.0 / (resistance * current),
                Drive::Current => 1.0 / current,
            }),
            per_load: S::gain(bases.shaft(N) / torque),
            current_imposed: settings.drive == Drive::Current,
            output_shaft: bases.shaft(N),
            units: Units {
                current: S::gain(current),
                speed: S::gain(speed),
                torque: S::gain(torque),
                angle: S::gain(angle),
                per_current: 1.0 / current,
                per_speed: 1.0 / speed,
                per_angle: 1.0 / angle,
            },
        })
    }

    /// Whether the drive imposes the current, else the voltage.
    pub fn is_current_imposed(&self) -> bool {
        self.current_imposed
    }

    /// Micro-steps in a step.
    pub fn micro_steps(&self) -> u32 {
        self.micro_steps.max(self.implicit.micro_steps)
    }

    /// How a step is computed.
    pub fn method(&self) -> Method {
        if self.micro_steps == 0 { Method::Implicit } else { Method::Splitting }
    }

    /// The joint at rest, relaxed, at angle zero.
    pub fn rest(&self) -> State<S, N> {
        let mut state = State {
            current: S::ZERO,
            angle: Angle::default(),
            rotor: Mass::default(),
            stages: [StageState::default(); N],
            memory: [S::ZERO; MEMORIES],
        };
        self.refresh(&mut state);
        state
    }

    /// The input of one step: volts, or amperes where the current is imposed, and the load torque
    /// at the output in Nm, positive against positive motion.
    #[inline]
    pub fn input(&self, drive: S, load: S) -> Input<S> {
        let mut drive = drive.times(self.per_drive);
        if self.current_imposed {
            drive = self.effects.true_current(drive);
        }
        Input { drive, load: load.times(self.per_load) }
    }

    /// Current in the winding, A.
    pub fn current(&self, state: &State<S, N>) -> S {
        state.current.times(self.units.current)
    }

    /// What the current sensor shows, A.
    pub fn measured_current(&self, state: &State<S, N>) -> S {
        self.effects.measured_current(state.current).times(self.units.current)
    }

    /// What the sensor shows when this current flows, both in A.
    pub fn measured(&self, amperes: f64) -> f64 {
        let shown = self.effects.measured_current(S::from_f64(amperes * self.units.per_current));
        shown.times(self.units.current).to_f64()
    }

    /// The current that flows where this one is commanded or measured, A.
    pub fn imposed_current(&self, amperes: S) -> S {
        self.effects.true_current(amperes.times(self.per_drive)).times(self.units.current)
    }

    /// Speed of a mass as it is felt at the motor, rad/s; zero for a mass that is not there.
    pub fn speed(&self, state: &State<S, N>, mass: usize) -> S {
        self.mass(state, mass).map_or(S::ZERO, |mass| mass.speed.times(self.units.speed))
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
        self.effects.measured_current(state.current).to_f64() / self.units.per_current
    }

    /// Speed of a mass as it is felt at the motor, rad/s, in double precision; not for a drive.
    pub fn speed_rad_per_s(&self, state: &State<S, N>, mass: usize) -> f64 {
        self.mass(state, mass).map_or(0.0, |mass| mass.speed.to_f64() / self.units.per_speed)
    }

    /// Deflection of a stage's spring as it is felt at the motor, rad, in double precision; stages
    /// count from 0; not for a drive.
    pub fn deflection_rad(&self, state: &State<S, N>, stage: usize) -> f64 {
        state.stages.get(stage).map_or(0.0, |s| s.deflection.to_f64() / self.units.per_angle)
    }

    /// Bristle torque of a mass over its Coulomb level, ζ = σ0 z / α0.
    pub fn bristle(&self, state: &State<S, N>, mass: usize) -> S {
        self.mass(state, mass).map_or(S::ZERO, |mass| mass.bristle.zeta)
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
        if let Some(mass) = mass_mut(state, mass) {
            mass.speed = S::from_f64(rad_per_s * self.units.per_speed);
        }
    }

    /// Sets a mass's bristle torque over its Coulomb level.
    pub fn set_bristle(&self, state: &mut State<S, N>, mass: usize, zeta: f64) {
        if let Some(mass) = mass_mut(state, mass) {
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
    /// behind the last stage.
    pub fn encoder_error(&self, output: bool, angle_rad: f64, speed_rad_per_s: f64) -> f64 {
        let turn = core::f64::consts::TAU;
        let shaft = if output { self.output_shaft } else { 1.0 };
        let speed = S::from_f64(speed_rad_per_s / shaft * self.units.per_speed);
        let angle = Angle::from_turns(angle_rad / turn);
        self.effects.encoder_error(output, angle, speed).to_f64() * turn
    }

    fn mass<'a>(&self, state: &'a State<S, N>, mass: usize) -> Option<&'a Mass<S>> {
        match mass.checked_sub(1) {
            None => Some(&state.rotor),
            Some(k) => state.stages.get(k).map(|stage| &stage.mass),
        }
    }
}

fn mass_mut<S: Scalar, const N: usize>(
    state: &mut State<S, N>,
    mass: usize,
) -> Option<&mut Mass<S>> {
    match mass.checked_sub(1) {
        None => Some(&mut state.rotor),
        Some(k) => state.stages.get_mut(k).map(|stage| &mut stage.mass),
    }
}

/// Weights of the kicks of the fourth-order splitting.
pub(crate) const OUTER: f64 = 1.0 / 6.0;
pub(crate) const MIDDLE: f64 = 2.0 / 3.0;
