//! The assembled joint: built from SI parameters, and given its input.
//!
//! [`Joint`] is built once and never changes; [`State`] is what moves. One joint drives many states.
//! Masses count from 0 at the rotor. Quantities asked for or given here are SI and reflected to the
//! motor, as the state is in per-unit; the load is the output's own.

mod read;

use crate::angle::{Angle, Ratio};
use crate::effect::{EffectSet, Effects, MEMORIES};
use crate::friction::Friction;
use crate::gear::Spring;
use crate::motor::RotorKick;
use crate::params::{self, Load, Motor, ParameterError, Stage};
use crate::per_unit::{Bases, reflected_inertia};
use crate::scalar::Scalar;
use crate::step::{Implicit, MIDDLE, OUTER, StageConstants, Units};

pub use crate::pace::{MAX_MICRO_STEPS, Pace, Plan, micro_steps};
pub use crate::settings::{Drive, Method, Settings};
pub use crate::state::{Bristle, Input, Mass, StageState, State};
pub use crate::step::{IMPLICIT, Joint, Torques};

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
            Friction::new(
                friction,
                bases.shaft(mass),
                [half, MIDDLE],
                inertia(mass),
                [torque, speed],
            )
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
}
