//! One update: predict, compare, correct.
//!
//! What of a sample is rejected does not enter the state; it raises a flag, the estimates stay within
//! their bounds, and the next good sample is taken up without a reset.

use super::acquire::{FIRST, MOST_OUTPUT_COASTED};
use super::adapt::{Adapting, STILL};
use super::column::{CHANNELS, Column};
use super::gains::Regime;
use super::health::Status;
use super::innovation::bounded;
use super::{Observer, Sample, Track};
use crate::effect::Effects;
use crate::joint::{Input, State};
use crate::scalar::Real;

/// Rotor angles that may be off, one after the other, before the estimate is given up.
const MOST_REJECTED: u16 = 4;
/// Samples without a rotor angle after which there is no estimate.
const MOST_COASTED: u16 = 500;

impl<S: Real, const N: usize> Track<S, N> {
    /// What the last update said of itself.
    pub fn status(&self) -> Status {
        self.status
    }
}

impl<S: Real, const N: usize, E: Effects<S>> Observer<S, N, E> {
    /// Takes one sampling instant: moves the estimate to it and corrects it by what was measured.
    pub fn update(&self, track: &mut Track<S, N>, sample: &Sample<S>) -> Status {
        let mut status = Status::OK;
        if track.age < self.gains.settled {
            if track.age < FIRST {
                let status = self.acquire(track, sample);
                return self.taken(track, sample, status);
            }
            track.age += 1;
            status = Status::STARTING;
        }
        let beside = self.predict(track);
        let status = self.correct(track, sample, beside, status);
        self.taken(track, sample, status)
    }

    /// Keeps what the next update asks of this sample.
    #[inline(always)]
    fn taken(&self, track: &mut Track<S, N>, sample: &Sample<S>, status: Status) -> Status {
        let drive = self.joint.input(sample.drive, S::ZERO).drive;
        let known = drive.abs() <= self.gains.most_drive;
        if known {
            track.drive = drive;
        }
        track.last = *sample;
        track.status = status.with_if(!known, Status::NO_DRIVE);
        track.status
    }

    /// One step of the model. Answers with what the rotor's friction took beside its running mean, every
    /// other time.
    #[inline(always)]
    fn predict(&self, track: &mut Track<S, N>) -> S {
        let own = &mut track.disturbance;
        own.load = own.load + own.slope;
        if let Some(leak) = self.gains.leak.get(track.schedule.regime as usize) {
            own.slope = own.slope.times(*leak);
        }
        let (drive, load) = (track.drive + own.bias, own.load);
        let (State { current, rotor, .. }, errors) = (&track.state, &track.parameters);
        let flowing = *current + (drive - rotor.speed - *current).times(self.gains.winding);
        let drive = drive - errors.resistance * flowing - errors.flux * rotor.speed;
        let beside = self.decelerate(track);
        self.joint.step(&mut track.state, Input { drive, load });
        beside
    }

    #[inline(always)]
    fn correct(
        &self,
        track: &mut Track<S, N>,
        sample: &Sample<S>,
        beside: S,
        status: Status,
    ) -> Status {
        let Some((innovations, status)) = self.innovations(track, sample, status) else {
            return self.repeated(track, status);
        };
        let output = N > 0 && track.missing.output < MOST_OUTPUT_COASTED;
        self.detect(track, &innovations, output);
        let held = track.state.rotor.bristle.slipping < S::HALF;
        let (row, status) = self.schedule(track, held, output, status);
        let by = Adapting { innovations: &innovations, beside, held, output };
        let status = self.adapt(track, &by, status);
        if let Some(set) = self.gains.sets.get(row) {
            self.apply(track, set, &innovations);
        }
        let status = self.bound(track, status);
        self.judged(track, status)
    }

    /// What is left out as the sample before once more.
    #[inline(always)]
    fn repeated(&self, track: &mut Track<S, N>, status: Status) -> Status {
        // The slope of the load goes on.
        let status = self.bound(track, status.with(Status::REPEATED));
        let silent = track.missing.motor > MOST_COASTED;
        if silent {
            self.restart(track);
        }
        status.with_if(silent, Status::LOST)
    }

    /// Running means of the innovations, and whether the load has changed: an exponentially weighted
    /// mean of their projection on it has left its noise.
    #[inline(always)]
    fn detect(&self, track: &mut Track<S, N>, innovations: &[S; CHANNELS], output: bool) {
        let gains = &self.gains;
        let [without, with] = &gains.projection;
        let [a, b, c] = if output { with } else { without };
        let [by_current, by_motor, by_output] = *innovations;
        let projection = S::weighed_sum([(by_current, a), (by_motor, b), (by_output, c)]);
        let square = by_current * by_current + by_motor * by_motor + by_output * by_output;
        let square = if square > gains.most_mean_square { gains.most_mean_square } else { square };
        let mean = &mut track.innovation;
        mean.projection = mean.projection + (projection - mean.projection).times(gains.smoothing);
        mean.square = mean.square + (square - mean.square).times(gains.settle);
        let own = &mut track.schedule;
        let forgotten = own.alarm_rate.times(gains.alarm_rate);
        if mean.projection.abs() > gains.alarm {
            own.transient = gains.hold;
            own.alarm_rate = own.alarm_rate - forgotten + S::ONE.times(gains.alarm_rate);
        } else {
            own.transient = own.transient.saturating_sub(1);
            own.alarm_rate = own.alarm_rate - forgotten;
        }
        let (most, hold) = gains.varying;
        own.varying = if own.alarm_rate > most { hold } else { own.varying.saturating_sub(1) };
    }

    /// The regime, as its row of gains.
    #[inline(always)]
    fn schedule(
        &self,
        track: &mut Track<S, N>,
        held: bool,
        output: bool,
        status: Status,
    ) -> (usize, Status) {
        let last = track.state.stages.last();
        let hardened = last.is_some_and(|stage| stage.deflection.abs() > self.gains.hardened);
        let own = &mut track.schedule;
        let mut status = status;
        if held {
            own.regime = Regime::Held;
            own.held = own.held.saturating_add(1);
            if own.held > STILL && !output {
                own.after_rest = self.gains.settled;
                status = status.with(Status::UNOBSERVABLE);
            }
        } else {
            own.held = 0;
            own.regime = if own.varying > 0 {
                Regime::Varying
            } else if own.transient > 0 {
                Regime::Transient
            } else {
                Regime::Steady
            };
        }
        let row = own.regime.row(output, hardened);
        own.row = row as u8;
        (row, status)
    }

    /// Holds load and bias to their bounds.
    #[inline(always)]
    fn bound(&self, track: &mut Track<S, N>, status: Status) -> Status {
        let own = &mut track.disturbance;
        let status = bounded(&mut own.load, self.gains.most_load, status);
        bounded(&mut own.bias, self.gains.most_bias, status)
    }

    /// A new start where there is no estimate.
    #[inline(always)]
    fn judged(&self, track: &mut Track<S, N>, status: Status) -> Status {
        let sound = track.state.rotor.speed.abs() <= self.gains.most_speed;
        let (mut lost, mut status) = (!sound, status);
        if status.any(Status::GLITCH.with(Status::COASTING)) {
            let silent = track.missing.motor > MOST_COASTED;
            lost |= silent || track.missing.rejected > MOST_REJECTED;
            status = status.with_if(silent, Status::LOST);
        }
        if lost {
            self.restart(track);
        }
        status
    }

    /// Adds the gains times the innovations, and to the forces that the step keeps what follows from
    /// them by the springs' tangents.
    #[inline(always)]
    fn apply(
        &self,
        track: &mut Track<S, N>,
        [first, second, third]: &[Column<S::Gain, N>; CHANNELS],
        innovations: &[S; CHANNELS],
    ) {
        let [by_current, by_motor, by_output] = *innovations;
        let both = |a, b| S::weighed_sum([(by_current, a), (by_motor, b)]);
        let sum = |a, b, c| match N {
            0 => both(a, b),
            _ => S::weighed_sum([(by_current, a), (by_motor, b), (by_output, c)]),
        };
        macro_rules! sum {
            ($field:ident) => {
                sum(&first.$field, &second.$field, &third.$field)
            };
        }
        let State { current, angle, rotor, stages, .. } = &mut track.state;
        // The winding settles faster than an angle tells of it: the output's has no say in what is
        // electrical.
        *current = *current + both(&first.current, &second.current);
        // The next step's sum wraps it.
        angle.part = angle.part + sum!(angle);
        rotor.speed = rotor.speed + sum!(speed);
        let rows = first.stages.iter().zip(&second.stages).zip(&third.stages);
        let mut before = &mut rotor.force;
        for ((stage, own), ((a, b), c)) in stages.iter_mut().zip(&self.joint.stages).zip(rows) {
            let wound = sum(&a.deflection, &b.deflection, &c.deflection);
            let torque = own.spring.slope(stage.deflection) * wound;
            stage.deflection = stage.deflection + wound;
            let mass = &mut stage.mass;
            mass.speed = mass.speed + sum(&a.speed, &b.speed, &c.speed);
            *before = *before - torque;
            mass.force = mass.force + torque;
            before = &mut mass.force;
        }
        let own = &mut track.disturbance;
        own.load = own.load + sum!(load);
        own.slope = own.slope + sum!(slope);
        own.bias = own.bias + both(&first.bias, &second.bias);
    }
}
