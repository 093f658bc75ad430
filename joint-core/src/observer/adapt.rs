//! What is slow: the errors of resistance, flux and friction.
//!
//! A current's innovation goes with the current where the resistance is off, with the speed where the
//! flux is; a load shows in neither so. Friction is told from a load by its reversals. Products of
//! innovation and regressor are the gradient of the squared innovation (L. Ljung and T. Söderström,
//! Theory and Practice of Recursive Identification, 1983, section 3.4); the step sizes are the ratios of
//! a Kalman filter's own gains to the regressors.

use core::hint::cold_path;

use super::column::CHANNELS;
use super::gains::{Deceleration, Regime, WITH_OUTPUT, of_sensors};
use super::innovation::{bounded, limited};
use super::{Observer, Schedule, Status, Track};
use crate::effect::Effects;
use crate::joint::{Mass, State};
use crate::scalar::Real;

/// Steps for which friction must have held the rotor before that is a rest and no reversal.
pub(super) const STILL: u16 = 10;

/// A sample by which parameters are adapted.
pub(super) struct Adapting<'a, S> {
    pub(super) innovations: &'a [S; CHANNELS],
    /// What friction takes of the rotor's speed beside its running mean.
    pub(super) beside: S,
    pub(super) held: bool,
    /// Zero or [`WITH_OUTPUT`].
    pub(super) sensors: usize,
}

impl<S: Real, const N: usize, E: Effects<S>> Observer<S, N, E> {
    /// Lets the friction act that the model has not, on the rotor and on what is behind it by turns.
    /// Answers with what the rotor's friction took beside its running mean, every other time.
    #[inline(always)]
    pub(super) fn decelerate(&self, track: &mut Track<S, N>) -> S {
        let (gains, error) = (&self.gains, track.parameters.friction);
        let takes = |own: &Deceleration<S>, mass: &Mass<S>| {
            S::weighed_sum([(mass.bristle.zeta, &own.bristle), (mass.speed, &own.viscous)])
        };
        let State { rotor, stages, .. } = &mut track.state;
        if !track.adapts_friction {
            for (stage, own) in stages.iter_mut().zip(&gains.decelerations) {
                let mass = &mut stage.mass;
                mass.speed = mass.speed - error * takes(own, mass);
            }
            return S::ZERO;
        }
        let taken = takes(&gains.deceleration, rotor);
        rotor.speed = rotor.speed - error * taken;
        let sensors = usize::from(Regime::has_output(usize::from(track.schedule.row)));
        let share = of_sensors(&gains.mean_deceleration, sensors);
        let beside = taken - track.mean_deceleration;
        track.mean_deceleration = track.mean_deceleration + beside.times(*share);
        beside
    }

    /// Half of what is slow, friction or else winding and magnets; nothing of a drive that does not do as
    /// it is told. Current and speed are those that are not yet corrected.
    #[inline(always)]
    pub(super) fn adapt(
        &self,
        track: &mut Track<S, N>,
        friction: bool,
        by: &Adapting<'_, S>,
        status: Status,
    ) -> Status {
        let mut status = status;
        if self.mismatches(track) {
            cold_path();
            status = status.with(Status::MISMATCH);
            if !self.undisturbed(track) && track.electrical.confirmed >= self.gains.confirmed {
                return status;
            }
        }
        if friction {
            self.adapt_friction(track, by, status)
        } else {
            self.adapt_motor(track, by, status)
        }
    }

    /// Whether the innovations stay too large for the design.
    #[inline(always)]
    pub(super) fn mismatches(&self, track: &Track<S, N>) -> bool {
        track.innovation.square > self.gains.inconsistent
    }

    #[inline(always)]
    fn adapt_motor(&self, track: &mut Track<S, N>, by: &Adapting<'_, S>, status: Status) -> Status {
        let gains = &self.gains;
        let [by_current, ..] = by.innovations;
        let own = &mut track.parameters;
        let State { current, rotor, .. } = &track.state;
        own.resistance = own.resistance + *current * by_current.times(gains.ohm);
        own.flux = own.flux + rotor.speed * by_current.times(gains.flux);
        if !by.held && track.electrical.confirmed < gains.most_confirmed {
            track.electrical.confirmed += 1;
        }
        let status = bounded(&mut own.resistance, gains.most_ohm, status);
        bounded(&mut own.flux, gains.most_flux, status)
    }

    #[inline(always)]
    fn adapt_friction(
        &self,
        track: &mut Track<S, N>,
        by: &Adapting<'_, S>,
        status: Status,
    ) -> Status {
        if by.held || by.sensors != WITH_OUTPUT && self.rested(&mut track.schedule) {
            return status;
        }
        let gains = &self.gains;
        let [motor, output] = of_sensors(&gains.friction_projection, by.sensors);
        let gain = of_sensors(&gains.level, by.sensors);
        let [_, by_motor, by_output] = by.innovations;
        let torque = S::weighed_sum([(*by_motor, motor), (*by_output, output)]);
        let torque = limited(torque, gains.most_friction_projection);
        let own = &mut track.parameters.friction;
        *own = *own + by.beside * torque.times(*gain);
        bounded(own, gains.most_level, status)
    }

    /// Whether a reversal, seen from the motor alone, is one after a rest or under a load that changes.
    #[inline(always)]
    fn rested(&self, schedule: &mut Schedule<S>) -> bool {
        schedule.after_rest = schedule.after_rest.saturating_sub(2);
        schedule.after_rest > 0 || Regime::of_row(schedule.row) != Regime::Steady as usize
    }
}
