//! Innovations, and the rejection of what is no measurement.
//!
//! A drive's interrupt meets samples lost or repeated, encoders that jump, current sensors at their end
//! and supplies that dip. What is no measurement is flagged and gives no innovation; a voltage that was
//! not the one asked for is estimated at once.

use core::hint::cold_path;

use super::column::CHANNELS;
use super::gains::{Gains, WITH_OUTPUT, Whiten};
use super::health::Status;
use super::turn::Turn;
use super::{Missing, Observer, Sample, Track};
use crate::effect::Effects;
use crate::joint::State;
use crate::scalar::Real;

/// Samples without an output angle after which the gains are those without that encoder.
pub(super) const MOST_OUTPUT_COASTED: u16 = 3;
/// Outliers after which winding and magnets are no longer taken to be known: a dip under a drive that
/// moves has dozens.
const OUTLIERS: u16 = 64;

/// What a sample shows beside the estimate.
pub(super) struct Seen<S> {
    /// Innovations in units of [`SIGMAS`](super::gains::SIGMAS), zero where there is none.
    pub(super) innovations: [S; CHANNELS],
    /// [`WITH_OUTPUT`] where that encoder is there, else zero.
    pub(super) sensors: usize,
    pub(super) status: Status,
}

impl<S: Real, const N: usize, E: Effects<S>> Observer<S, N, E> {
    /// The innovations and the flags that go with them; `None` where the sample is the last one once more.
    #[inline(always)]
    pub(super) fn innovations(
        &self,
        track: &mut Track<S, N>,
        sample: &Sample<S>,
        status: Status,
    ) -> Option<Seen<S>> {
        let gains = &self.gains;
        let [by_current, by_motor, by_output] = &gains.whiten;
        let mut status = status;
        let [mut current, mut motor, mut output] = [S::ZERO; CHANNELS];

        if let Some(turn) = sample.motor {
            let ahead = motor_ahead(&self.joint.effects, &track.state, turn);
            let deviation = ahead.times(by_motor.per_sigma);
            // Four standard deviations.
            let near = deviation.abs() <= S::HALF.eighth();
            if !near && repeats(sample, &track.last, self.joint.current_imposed) {
                track.missing.motor = track.missing.motor.saturating_add(1);
                return None;
            }
            if near || ahead.abs() <= by_motor.gate {
                motor = deviation;
                track.missing.motor = 0;
                track.missing.rejected = 0;
            } else {
                status = status.with(Status::GLITCH);
                track.missing.rejected = track.missing.rejected.saturating_add(1);
            }
        } else {
            status = status.with(Status::COASTING);
            track.missing.motor = track.missing.motor.saturating_add(1);
        }

        let mut sensors = if N > 0 { WITH_OUTPUT } else { 0 };
        if let Some(turn) = sample.output
            && N > 0
        {
            let ahead =
                output_ahead(&self.joint.effects, gains, self.joint.turns, &track.state, turn);
            if ahead.abs() <= by_output.gate {
                output = ahead.times(by_output.per_sigma);
                track.missing.output = 0;
            } else {
                status = status.with(Status::GLITCH);
                sensors = track.missing.misses_output();
            }
        } else if N > 0 {
            sensors = track.missing.misses_output();
        }

        if !self.joint.current_imposed {
            match sample.current.map(|amperes| amperes.times(gains.per_ampere)) {
                Some(measured) if measured.abs() < gains.most_current => {
                    // Currents are those that give their torque with the model's flux.
                    let measured = measured + measured * track.parameters.flux;
                    let shown =
                        self.joint.effects.shown_current(track.state.current, &track.state.memory);
                    let ahead = measured - shown;
                    let ahead = match ahead.abs() > gains.outlier {
                        true => self.electrical_outlier(track, ahead),
                        false => ahead,
                    };
                    current = ahead.times(by_current.per_sigma);
                }
                _ => status = status.with(Status::NO_CURRENT),
            }
        }

        Some(Seen { innovations: [current, motor, output], sensors, status })
    }

    /// A current that is off by more than the design has it: what there is to correct by.
    ///
    /// Until winding and magnets are known it is an error of theirs. Then, the second time, the drive
    /// has put out another voltage than it was told, and that voltage takes all of it: a bus that
    /// dips is neither a load nor a resistance.
    #[cold]
    #[inline(never)]
    fn electrical_outlier(&self, track: &mut Track<S, N>, ahead: S) -> S {
        let gains = &self.gains;
        let second = track.electrical.confirmed == track.electrical.at_outlier;
        track.electrical.confirmed =
            track.electrical.confirmed.saturating_sub(gains.confirmed / OUTLIERS + 1);
        if track.electrical.confirmed < gains.confirmed {
            let [Whiten { gate, .. }, ..] = gains.whiten;
            return limited(ahead, gate);
        }
        let undisturbed = self.undisturbed(track);
        track.innovation.square = gains.most_mean_square;
        track.electrical.at_outlier =
            if undisturbed { track.electrical.confirmed } else { u16::MAX };
        if undisturbed {
            return S::ZERO;
        }
        let ([missing, missing_twice], [push, push_twice]) = (gains.missing, gains.push);
        let (missing, push) = if second { (missing_twice, push_twice) } else { (missing, push) };
        let (before, State { current, rotor, .. }) = (track.disturbance.bias, &mut track.state);
        *current = *current + ahead;
        rotor.speed = rotor.speed + ahead.times(push);
        let bias = before + ahead.times(missing);
        // What little is left of it is what the estimate was off: the dip is over.
        track.disturbance.bias = if bias.abs() < before.abs().eighth() { S::ZERO } else { bias };
        S::ZERO
    }

    /// Whether the current was no outlier a short time ago.
    #[inline(always)]
    pub(super) fn undisturbed(&self, track: &Track<S, N>) -> bool {
        track.innovation.square + track.innovation.square <= self.gains.most_mean_square
    }
}

impl Missing {
    /// Counts an output angle that is missing; answers with the sensors that have been there a short time
    /// ago.
    #[inline(always)]
    fn misses_output(&mut self) -> usize {
        self.output = self.output.saturating_add(1);
        if self.output < MOST_OUTPUT_COASTED { WITH_OUTPUT } else { 0 }
    }
}

/// Whether a sample shows the very same measurements as the one before. Where the drive is the current, that is
/// one of them: angles alone are the same at every rest.
#[cold]
#[inline(never)]
fn repeats<S: Real>(sample: &Sample<S>, last: &Sample<S>, imposed: bool) -> bool {
    sample.motor == last.motor
        && sample.output == last.output
        && sample.current == last.current
        && (!imposed || sample.drive == last.drive)
}

/// By how much the measured rotor angle is ahead of the estimated one, in turns.
#[inline(always)]
pub(super) fn motor_ahead<S: Real, const N: usize, E: Effects<S>>(
    effects: &E,
    state: &State<S, N>,
    turn: Turn,
) -> S {
    let error = effects.encoder_error(false, state.angle, state.rotor.speed, &state.memory);
    (S::from_turn_counts(turn.0 as i32) - state.angle.part - error).split_turns().1
}

/// By how much the measured output angle is ahead of the estimated one, in turns of the output.
#[inline(always)]
fn output_ahead<S: Real, const N: usize, E: Effects<S>>(
    effects: &E,
    gains: &Gains<S, N>,
    turns: S::Gain,
    state: &State<S, N>,
    turn: Turn,
) -> S {
    let deflections = state.stages.iter().map(|stage| stage.deflection);
    let wound = deflections.reduce(|sum, own| sum + own).unwrap_or(S::ZERO);
    let part = (state.angle.part - wound.times(turns)).times(gains.shaft);
    let speed = state.stages.last().map_or(S::ZERO, |stage| stage.mass.speed);
    let angle = crate::angle::Angle { part, ..Default::default() };
    let error = effects.encoder_error(true, angle, speed, &state.memory);
    let beyond = S::from_turn_counts(turn.ahead_of(gains.geared.turn(state.angle.whole)));
    (beyond - part - error).split_turns().1
}

/// A value within a bound.
#[inline(always)]
pub(super) fn limited<S: Real>(value: S, most: S) -> S {
    if value.abs() > most {
        cold_path();
        most.along(value)
    } else {
        value
    }
}

/// Holds a value to its bound; flags one that was past it.
#[inline(always)]
pub(super) fn bounded<S: Real>(value: &mut S, most: S, status: Status) -> Status {
    if value.abs() > most {
        cold_path();
        *value = most.along(*value);
        status.with(Status::BOUNDED)
    } else {
        status
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn where_the_drive_is_the_current_angles_alone_are_no_repeated_sample() {
        let last = Sample { drive: 0.5, motor: Some(Turn(7)), ..Sample::default() };
        let pushed = Sample { drive: 0.6, ..last };
        let moved = Sample { motor: Some(Turn(8)), ..last };
        let told = |imposed| [last, pushed, moved].map(|own| repeats::<f64>(&own, &last, imposed));
        assert_eq!([told(true), told(false)], [[true, false, false], [true, true, false]]);
    }
}
