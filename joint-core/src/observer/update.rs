//! One update: predict, compare, correct.
//!
//! What of a sample is rejected does not enter the state; it raises a flag, the estimates stay within
//! their bounds, and the next good sample is taken up without a reset.

use core::hint::cold_path;

use super::acquire::FIRST;
use super::adapt::{Adapting, STILL};
use super::column::{CHANNELS, Column};
use super::gains::{Regime, WITH_OUTPUT, of_sensors};
use super::health::Status;
use super::innovation::{Seen, bounded};
use super::{Missing, Observer, Sample, Track};
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
        let status = if track.first < FIRST {
            self.acquire(track, sample)
        } else {
            let beside = self.predict(track);
            self.correct(track, sample, beside)
        };
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
        if let Some(leak) = self.gains.leak.get(Regime::of_row(track.schedule.row)) {
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
    fn correct(&self, track: &mut Track<S, N>, sample: &Sample<S>, beside: S) -> Status {
        let mut status = Status::OK;
        if track.starting > 0 {
            track.starting -= 1;
            status = Status::STARTING;
        }
        let Some(seen) = self.innovations(track, sample, status) else {
            return self.repeated(track, status);
        };
        let Seen { innovations, sensors, status } = seen;
        let regime = self.detect(track, &innovations, sensors);
        let held = track.state.rotor.bristle.slipping < S::HALF;
        let (row, mut status) = self.schedule(track, regime, held, sensors, status);
        let friction = track.adapts_friction;
        track.adapts_friction = !friction;
        let mut teaches = true;
        if status.any(Status::GLITCH.with(Status::COASTING)) {
            cold_path();
            let Missing { motor, rejected, .. } = track.missing;
            let silent = motor > MOST_COASTED;
            if silent || rejected > MOST_REJECTED {
                self.restart(track);
                return status.with_if(silent, Status::LOST);
            }
            teaches = motor == 0 && rejected == 0;
        }
        status = if teaches {
            let by = Adapting { innovations: &innovations, beside, held, sensors };
            self.adapt(track, friction, &by, status)
        } else {
            status.with_if(self.mismatches(track), Status::MISMATCH)
        };
        if let Some(set) = self.gains.sets.get(row) {
            self.apply(track, set, &innovations);
        }
        // A speed that is no number is not sound either.
        let sound = track.state.rotor.speed.abs() <= self.gains.most_speed;
        let status = self.bound(track, status);
        if !sound {
            self.restart(track);
        }
        status
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
    fn detect(
        &self,
        track: &mut Track<S, N>,
        innovations: &[S; CHANNELS],
        sensors: usize,
    ) -> Regime {
        let gains = &self.gains;
        let [a, b, c] = of_sensors(&gains.projection, sensors);
        let [by_current, by_motor, by_output] = *innovations;
        let projection = S::weighed_sum([(by_current, a), (by_motor, b), (by_output, c)]);
        let square = by_current * by_current + by_motor * by_motor + by_output * by_output;
        let square = if square > gains.most_mean_square { gains.most_mean_square } else { square };
        let mean = &mut track.innovation;
        mean.projection = mean.projection + (projection - mean.projection).times(gains.smoothing);
        mean.square = mean.square + (square - mean.square).times(gains.settle);
        let own = &mut track.schedule;
        own.alarm_rate = own.alarm_rate - own.alarm_rate.times(gains.alarm_rate);
        let mut regime = Regime::Steady;
        if mean.projection.abs() > gains.alarm {
            own.transient = gains.hold;
            own.alarm_rate = own.alarm_rate + S::ONE.times(gains.alarm_rate);
            regime = Regime::Transient;
        } else if own.transient > 1 {
            own.transient -= 1;
            regime = Regime::Transient;
        } else {
            own.transient = 0;
        }
        let (most, hold) = gains.varying;
        if own.alarm_rate > most {
            own.varying = hold;
            regime = Regime::Varying;
        } else if own.varying > 1 {
            own.varying -= 1;
            regime = Regime::Varying;
        } else {
            own.varying = 0;
        }
        regime
    }

    /// The regime, where friction may hold the rotor, as its row of gains.
    #[inline(always)]
    fn schedule(
        &self,
        track: &mut Track<S, N>,
        regime: Regime,
        held: bool,
        sensors: usize,
        status: Status,
    ) -> (usize, Status) {
        let last = track.state.stages.last();
        let hardened = last.is_some_and(|stage| stage.deflection.abs() > self.gains.hardened);
        let own = &mut track.schedule;
        let mut status = status;
        let mut regime = regime;
        if held {
            regime = Regime::Held;
            if own.held < STILL {
                own.held += 1;
            } else if sensors != WITH_OUTPUT {
                own.after_rest = self.gains.settled;
                status = status.with(Status::UNOBSERVABLE);
            }
        } else {
            own.held = 0;
        }
        let row = regime.row_of(sensors, hardened);
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
        // The winding settles faster than an angle tells of it: the output's has no say in what is
        // electrical.
        let electrical = |own: &mut S, a, b| *own = own.corrected([(by_current, a), (by_motor, b)]);
        let all = |a, b, c| [(by_current, a), (by_motor, b), (by_output, c)];
        let correct = |own: &mut S, a, b, c| match N {
            0 => electrical(own, a, b),
            _ => *own = own.corrected(all(a, b, c)),
        };
        macro_rules! correct {
            ($own:expr, $field:ident) => {
                correct($own, &first.$field, &second.$field, &third.$field)
            };
        }
        let State { current, angle, rotor, stages, .. } = &mut track.state;
        electrical(current, &first.current, &second.current);
        // The next step's sum wraps it.
        correct!(&mut angle.part, angle);
        correct!(&mut rotor.speed, speed);
        let rows = first.stages.iter().zip(&second.stages).zip(&third.stages);
        let mut before = &mut rotor.force;
        for ((stage, own), ((a, b), c)) in stages.iter_mut().zip(&self.joint.stages).zip(rows) {
            let wound = S::weighed_sum(all(&a.deflection, &b.deflection, &c.deflection));
            let torque = own.spring.slope(stage.deflection) * wound;
            stage.deflection = stage.deflection + wound;
            let mass = &mut stage.mass;
            correct(&mut mass.speed, &a.speed, &b.speed, &c.speed);
            *before = *before - torque;
            mass.force = mass.force + torque;
            before = &mut mass.force;
        }
        let own = &mut track.disturbance;
        correct!(&mut own.load, load);
        correct!(&mut own.slope, slope);
        electrical(&mut own.bias, &first.bias, &second.bias);
    }
}
