//! The three-phase motor with its amplifier before a joint: the motor that (10) stands for.
//!
//! Once in a period of the pulse-width modulation the hall sensors pick the phases, the current loop
//! or the caller the duty; the winding is carried through the period's switchings in closed form and
//! its mean torque, (6), imposed on the joint as the current that would give it. Commutation ripple,
//! freewheeling and dead time come out by themselves. Host and chip run the same code.

use crate::angle::Ratio;
use crate::effect::Effects;
use crate::joint::{Drive, Joint, Settings, State};
use crate::motor::back_emf;
use crate::motor::commutation::{self, Conduction};
use crate::motor::inverter::{self, Amplifier, CurrentLoop, clamped};
use crate::motor::three_phase::{Phases, advance};
use crate::params::{Load, Motor, ParameterError, Stage};
use crate::per_unit::Bases;
use crate::scalar::Real;

/// What is asked of the amplifier for one period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Command<S> {
    /// Mean voltage on the two conducting phases, V.
    Voltage(S),
    /// Mean current in them, A.
    Current(S),
}

/// A joint of `N` stages with effects `E` behind its motor's three phases.
#[derive(Clone, Debug, PartialEq)]
pub struct SixStep<S: Real, const N: usize, E = ()> {
    joint: Joint<S, N, E>,
    current_loop: CurrentLoop<S>,
    pole_pairs: Ratio<S>,
    /// A period in lags L/R, and one over it.
    period: S,
    per_period: S::Gain,
    dead: S,
    /// Per-unit of the winding: speed per rad/s, electrical turns per speed over a period,
    /// duty per volt, current per ampere, amperes per current, joules per energy.
    per_speed: S::Gain,
    turns: S::Gain,
    per_volt: S::Gain,
    per_ampere: S::Gain,
    amperes: S::Gain,
    joules: S::Gain,
    limit: S,
}

/// All that moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SixStepState<S: Real, const N: usize> {
    /// The joint.
    pub joint: State<S, N>,
    /// Currents, and what flowed in the last period; per-unit.
    pub phases: Phases<S>,
    /// Duty of the last period, −1 to 1.
    pub duty: S,
    /// The phases that conducted in it.
    pub conduction: Option<Conduction>,
    integral: S,
    /// Mean current of the conducting phases in the last period, per-unit.
    measured: S,
    /// Speed a period before, rad/s.
    before: S,
}

impl<S: Real, const N: usize, E: Effects<S>> SixStep<S, N, E> {
    /// A joint behind its motor; `effects` are made in the joint's units.
    ///
    /// # Errors
    /// The first parameter that the equations cannot take.
    pub fn with(
        motor: &Motor,
        stages: &[Stage; N],
        load: &Load,
        amplifier: &Amplifier,
        effects: impl FnOnce(&Bases<'_>) -> Option<E>,
    ) -> Result<Self, ParameterError> {
        amplifier.validate(motor)?;
        let settings = Settings::new(Drive::Current, amplifier.pwm_period_s);
        let joint = Joint::with(motor, stages, load, &settings, effects)?;
        let lag = motor.phase_inductance_h / motor.phase_resistance_ohm;
        let period = amplifier.pwm_period_s / lag;
        let amperes = amplifier.bus_v / motor.phase_resistance_ohm;
        let speed = amplifier.bus_v / motor.back_emf_constant();
        let pole_pairs = f64::from(motor.pole_pairs);
        Ok(Self {
            joint,
            current_loop: CurrentLoop::new(amplifier, lag),
            pole_pairs: Ratio::new(pole_pairs),
            period: S::from_f64(period),
            per_period: S::gain(1.0 / period),
            dead: S::from_f64(amplifier.dead_time_s / amplifier.pwm_period_s),
            per_speed: S::gain(1.0 / speed),
            turns: S::gain(pole_pairs * amplifier.pwm_period_s * speed / core::f64::consts::TAU),
            per_volt: S::gain(1.0 / amplifier.bus_v),
            per_ampere: S::gain(1.0 / amperes),
            amperes: S::gain(amperes),
            joules: S::gain(amplifier.bus_v * amperes * lag),
            limit: S::from_f64(amplifier.current_limit_a / amperes),
        })
    }

    /// The joint behind the motor, for reading its state.
    pub fn joint(&self) -> &Joint<S, N, E> {
        &self.joint
    }

    /// Everything at rest.
    pub fn rest(&self) -> SixStepState<S, N> {
        SixStepState {
            joint: self.joint.rest(),
            phases: Phases::default(),
            duty: S::ZERO,
            conduction: None,
            integral: S::ZERO,
            measured: S::ZERO,
            before: S::ZERO,
        }
    }

    /// Advances everything by one period, under a load at the output in Nm.
    pub fn step(&self, state: &mut SixStepState<S, N>, command: Command<S>, load: S) {
        state.duty = match command {
            Command::Voltage(volts) => clamped(volts.times(self.per_volt)),
            Command::Current(amperes) => {
                let wanted = limited(amperes.times(self.per_ampere), self.limit);
                self.current_loop.duty(&mut state.integral, wanted - state.measured)
            }
        };
        let turns = self.pole_pairs.of(state.joint.angle);
        state.conduction = commutation::from_hall(commutation::hall(turns));
        let speed = self.joint.speed(&state.joint, 0);
        // The speed in the middle of the period, so that (5) and the joint see the same one.
        let middle = (speed + (speed - state.before) * S::HALF).times(self.per_speed);
        state.before = speed;
        self.flow(state, turns, middle);
        let mean = state.phases.impulse.times(self.per_period) * S::HALF;
        self.joint.step(&mut state.joint, self.joint.input(mean.times(self.amperes), load));
    }

    /// Carries the phases through the parts of one period.
    fn flow(&self, state: &mut SixStepState<S, N>, turns: S, speed: S) {
        state.phases.clear();
        let Some(conduction) = state.conduction else { return };
        let turned = speed.times(self.turns);
        let mut passed = S::ZERO;
        for part in inverter::period(conduction, state.duty, self.dead) {
            if part.share > S::ZERO {
                let middle = turns + turned * (passed + part.share * S::HALF);
                let (_, middle) = middle.split_turns();
                let duration = part.share * self.period;
                advance(&mut state.phases, part.legs, middle, speed, duration);
                passed = passed + part.share;
            }
        }
        let of = |phase: usize| state.phases.charge.get(phase).copied().unwrap_or(S::ZERO);
        let flowed = of(conduction.high) - of(conduction.low);
        state.measured = flowed.times(self.per_period) * S::HALF;
    }

    /// Mean current of the conducting phases in the last period, what the loop measures, A.
    pub fn measured_current(&self, state: &SixStepState<S, N>) -> S {
        state.measured.times(self.amperes)
    }

    /// Current that would give the last period's mean torque as `k_t i`, A.
    pub fn torque_current(&self, state: &SixStepState<S, N>) -> S {
        (state.phases.impulse.times(self.per_period) * S::HALF).times(self.amperes)
    }

    /// Currents into the phases a, b and c, A.
    pub fn phase_currents(&self, state: &SixStepState<S, N>) -> [S; 3] {
        state.phases.current.map(|current| current.times(self.amperes))
    }

    /// Back-EMF of the phases over its amplitude, f(θe).
    pub fn back_emf(&self, state: &SixStepState<S, N>) -> [S; 3] {
        back_emf::of_phases(self.pole_pairs.of(state.joint.angle))
    }

    /// Work taken from the bus in the last period, and heat of the winding, J.
    pub fn work_and_heat(&self, state: &SixStepState<S, N>) -> [S; 2] {
        [state.phases.supplied, state.phases.heat].map(|energy| energy.times(self.joules))
    }

    /// Energy in the inductances, J.
    pub fn stored(&self, state: &SixStepState<S, N>) -> S {
        state.phases.stored().times(self.joules)
    }
}

fn limited<S: Real>(value: S, limit: S) -> S {
    if value > limit {
        limit
    } else if value < -limit {
        -limit
    } else {
        value
    }
}
