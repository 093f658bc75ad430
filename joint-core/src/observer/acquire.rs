//! The start: an angle, then a speed, and from then on corrections.
//!
//! Gains are those of small errors. A joint that is already turning when the drive wakes up is
//! therefore measured first, over one step where that is enough for its speed and over a few else.

use super::innovation::{MOST_OUTPUT_COASTED, motor_ahead};
use super::{
    Disturbance, Electrical, InnovationMeans, Missing, Observer, ParameterErrors, Sample, Schedule,
    Status, Track,
};
use crate::effect::Effects;
use crate::scalar::Real;

/// Steps over which the first speed is measured where one step is too short for it.
pub(super) const FIRST: u8 = 8;

impl<S: Real, const N: usize, E: Effects<S>> Observer<S, N, E> {
    /// An observer that knows nothing yet but the rotor's whole turns since both encoders were
    /// zeroed together.
    pub fn start(&self, rotor_turns: i32) -> Track<S, N> {
        let mut state = self.joint.rest();
        state.angle.whole = rotor_turns;
        Track {
            state,
            disturbance: Disturbance::default(),
            parameters: ParameterErrors::default(),
            drive: S::ZERO,
            mean_deceleration: S::ZERO,
            innovation: InnovationMeans::default(),
            schedule: Schedule::default(),
            missing: Missing { output: MOST_OUTPUT_COASTED, ..Missing::default() },
            electrical: Electrical::default(),
            first: 0,
            starting: self.gains.settled.saturating_sub(u16::from(FIRST)).max(1),
            adapts_friction: false,
            last: Sample::default(),
            status: Status::LOST,
        }
    }

    /// Starts anew, with what is slow kept; of that what is no number is not.
    #[cold]
    #[inline(never)]
    pub(super) fn restart(&self, track: &mut Track<S, N>) {
        let Track { last, drive, parameters, electrical, .. } = *track;
        let gains = &self.gains;
        let sound = |value: S, most: S| if value.abs() <= most { value } else { S::ZERO };
        let parameters = ParameterErrors {
            resistance: sound(parameters.resistance, gains.most_ohm),
            flux: sound(parameters.flux, gains.most_flux),
            friction: sound(parameters.friction, gains.most_level),
        };
        let drive = sound(drive, gains.most_drive);
        let electrical = Electrical { at_outlier: 0, ..electrical };
        let anew = self.start(track.state.angle.whole);
        *track = Track { last, drive, parameters, electrical, ..anew };
    }

    /// The first samples: an angle, then a speed.
    #[inline(never)]
    pub(super) fn acquire(&self, track: &mut Track<S, N>, sample: &Sample<S>) -> Status {
        let status = Status::LOST.with(Status::STARTING);
        let Some(turn) = sample.motor else {
            track.first = 0;
            return status.with(Status::COASTING);
        };
        let moved = motor_ahead(&self.joint.effects, &track.state, turn);
        if track.first == 0 {
            track.state.angle.part = S::ZERO;
            let here = S::from_turn_counts(turn.0 as i32);
            track.state.angle.advance(here);
            track.first = 1;
            return status;
        }
        let [_, motor, _] = &self.gains.whiten;
        let last = track.first == 1;
        let eighth = S::HALF * S::HALF * S::HALF;
        // Eight standard deviations in a step: its speed is measured over that step alone.
        let fast = moved.times(motor.per_sigma).abs() > eighth;
        if !(last && fast) && track.first + 1 < FIRST {
            track.first += 1;
            return status;
        }
        let speed = if last && fast { moved } else { moved * eighth }.times(self.gains.per_turn);
        if speed.abs() > self.gains.most_speed {
            track.first = 0;
            return status.with(Status::GLITCH);
        }
        let state = &mut track.state;
        state.angle.advance(moved);
        state.rotor.speed = speed;
        let slipping = if speed < S::ZERO { -S::ONE } else { S::ONE };
        let slipping = if fast { slipping } else { S::ZERO };
        state.rotor.bristle.zeta = slipping;
        for stage in &mut state.stages {
            stage.mass.speed = speed;
            stage.mass.bristle.zeta = slipping;
        }
        if let Some(amperes) = sample.current {
            let measured = amperes.times(self.gains.per_ampere);
            if measured.abs() < self.gains.most_current {
                state.current = measured;
            }
        }
        self.joint.refresh(state);
        track.schedule.transient = self.gains.hold;
        track.first = FIRST;
        Status::STARTING
    }
}
