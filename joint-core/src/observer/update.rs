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
        let status = if track.age < FIRST {
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
    fn correct(&self, track: &mut Track<S, N>, sample: &Sample<S>, beside: S) -> Status {
        let (innovations, status) = self.innovations(track, sample);
        if status.has(Status::REPEATED) {
            return self.repeated(track, status);
        }
        let output = N > 0 && track.missing.output < MOST_OUTPUT_COASTED;
        self.detect(track, &innovations, output);
        let row = self.schedule(track, output);
        let held = track.schedule.regime == Regime::Held;
        let running = [track.state.current, track.state.rotor.speed];
        if let Some(set) = self.gains.sets.get(row) {
            self.apply(track, set, &innovations);
        }
        let by = Adapting { innovations: &innovations, running, beside, held, output };
        let status = status.with_if(self.adapt(track, &by), Status::BOUNDED);
        let status = status.with_if(self.bound(track), Status::BOUNDED);
        self.judged(track, status, output)
    }

    /// What is left out as the sample before once more.
    #[inline(always)]
    fn repeated(&self, track: &mut Track<S, N>, status: Status) -> Status {
        let silent = status.has(Status::UNMEASURED) && track.missing.motor > MOST_COASTED;
        // The slope of the load goes on.
        let at_bound = self.bound(track);
        if silent {
            self.restart(track);
        }
        Status::REPEATED
            .with_if(silent, Status::LOST)
            .with_if(at_bound, Status::BOUNDED)
            .with_if(track.age < self.gains.settled, Status::STARTING)
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
        let mean = &mut track.innovation;
        mean.projection = mean.projection + (projection - mean.projection).times(gains.smoothing);
        let own = &mut track.schedule;
        let alarm = mean.projection.abs() > gains.alarm;
        own.transient = if alarm { gains.hold } else { own.transient.saturating_sub(1) };
        // What is slow by turns, as what is learned.
        if track.adapts_friction {
            let square = S::sum_of_squares([by_current, by_motor, by_output]);
            let most = gains.most_mean_square;
            let square = if square > most { most } else { square };
            mean.square = mean.square + (square - mean.square).times(gains.settle);
        } else {
            let alarm = if alarm { S::ONE } else { S::ZERO };
            own.alarm_rate = own.alarm_rate + (alarm - own.alarm_rate).times(gains.alarm_rate);
            let (most, hold) = gains.varying;
            own.varying = if own.alarm_rate > most { hold } else { own.varying.saturating_sub(2) };
        }
    }

    /// The regime and its row of gains.
    #[inline(always)]
    fn schedule(&self, track: &mut Track<S, N>, output: bool) -> usize {
        let held = track.state.rotor.bristle.slipping < S::HALF;
        let last = track.state.stages.last();
        let hardened = last.is_some_and(|stage| stage.deflection.abs() > self.gains.hardened);
        let own = &mut track.schedule;
        own.regime = if held {
            Regime::Held
        } else if own.varying > 0 {
            Regime::Varying
        } else if own.transient > 0 {
            Regime::Transient
        } else {
            Regime::Steady
        };
        own.held = if held { own.held.saturating_add(1) } else { 0 };
        let row = own.regime.row(output, hardened);
        own.row = row as u8;
        row
    }

    /// Holds load and bias to their bounds; answers whether either was past it.
    #[inline(always)]
    fn bound(&self, track: &mut Track<S, N>) -> bool {
        let own = &mut track.disturbance;
        bounded([(&mut own.load, self.gains.most_load), (&mut own.bias, self.gains.most_bias)])
    }

    /// Health, and a new start where there is no estimate.
    #[inline(always)]
    fn judged(&self, track: &mut Track<S, N>, status: Status, output: bool) -> Status {
        let gains = &self.gains;
        let starting = track.age < gains.settled;
        if starting {
            track.age += 1;
        }
        let status = status
            .with_if(starting, Status::STARTING)
            .with_if(track.innovation.square > gains.inconsistent, Status::MISMATCH)
            .with_if(!output && track.schedule.held > STILL, Status::UNOBSERVABLE);
        let mut status = status;
        let mut sound = track.state.rotor.speed.abs() <= gains.most_speed;
        if status.has_any(Status::UNMEASURED.with(Status::BOUNDED).with(Status::GLITCH)) {
            let Missing { motor, rejected, .. } = track.missing;
            let measured = !status.has(Status::UNMEASURED)
                || motor <= MOST_COASTED && rejected <= MOST_REJECTED;
            status = status.without(Status::UNMEASURED);
            sound &= measured && self.is_sound(&track.state);
        }
        if sound { status } else { self.begun_anew(track, status) }
    }

    /// Whether what is behind the rotor moves as a joint may: asked where an angle is not measured, or the
    /// load that would explain it all is at its bound.
    #[inline(always)]
    fn is_sound(&self, state: &State<S, N>) -> bool {
        let most = self.gains.most_speed;
        state.stages.iter().all(|stage| stage.mass.speed.abs() <= most)
    }

    /// A new start where no rotor angle was accepted for too long, or the state is none.
    #[cold]
    #[inline(never)]
    fn begun_anew(&self, track: &mut Track<S, N>, status: Status) -> Status {
        let silent = track.missing.motor > MOST_COASTED;
        self.restart(track);
        status.with_if(silent, Status::LOST)
    }

    /// Adds the gains times the innovations, and to the forces that the step keeps for its first kick what
    /// follows from them by the springs' stiffness.
    #[inline(always)]
    fn apply(
        &self,
        track: &mut Track<S, N>,
        [first, second, third]: &[Column<S::Gain, N>; CHANNELS],
        innovations: &[S; CHANNELS],
    ) {
        let [by_current, by_motor, by_output] = *innovations;
        macro_rules! correct {
            ($value:expr, $a:expr, $b:expr) => {
                $value = $value.corrected([(by_current, $a), (by_motor, $b)])
            };
            ($value:expr, $a:expr, $b:expr, $c:expr) => {
                match N {
                    0 => correct!($value, $a, $b),
                    _ => {
                        let terms = [(by_current, $a), (by_motor, $b), (by_output, $c)];
                        $value = $value.corrected(terms);
                    }
                }
            };
        }
        let State { current, angle, rotor, stages, .. } = &mut track.state;
        // The winding settles faster than an angle tells of it: the output's has no say in what is
        // electrical.
        correct!(*current, &first.current, &second.current);
        // The next step's sum wraps it.
        correct!(angle.part, &first.angle, &second.angle, &third.angle);
        correct!(rotor.speed, &first.speed, &second.speed, &third.speed);
        let rows = first.stages.iter().zip(&second.stages).zip(&third.stages);
        let mut before = &mut rotor.force;
        for ((stage, own), ((a, b), c)) in stages.iter_mut().zip(&self.joint.stages).zip(rows) {
            let wound = S::weighed_sum([
                (by_current, &a.deflection),
                (by_motor, &b.deflection),
                (by_output, &c.deflection),
            ]);
            let torque = own.spring.stiffness() * wound;
            stage.deflection = stage.deflection + wound;
            let mass = &mut stage.mass;
            correct!(mass.speed, &a.speed, &b.speed, &c.speed);
            *before = *before - torque;
            mass.force = mass.force + torque;
            before = &mut mass.force;
        }
        let own = &mut track.disturbance;
        correct!(own.load, &first.load, &second.load, &third.load);
        correct!(own.slope, &first.slope, &second.slope, &third.slope);
        correct!(own.bias, &first.bias, &second.bias);
    }
}
