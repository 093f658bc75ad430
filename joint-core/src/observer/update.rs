//! One update: predict, look, doubt, correct.
//!
//! What of a sample is not believed does not enter the state; it raises a flag, the estimates stay
//! within their bounds, and the next good sample is taken up without a reset.

use super::gains::{Brake, CHANNELS, Column, Regime};
use super::health::Status;
use super::look::{Looked, at_bound, motor_ahead};
use super::{Observer, Sample, Track};
use crate::effect::Effects;
use crate::joint::{Input, Mass, State};
use crate::scalar::Real;

/// Rotor angles that may be off, one after the other, before the estimate is given up.
const DOUBTS: u16 = 4;
/// Samples without a rotor angle after which there is no estimate.
const SILENCE: u16 = 500;
/// Samples without an output angle after which the gains are those without that encoder.
const OUTPUT_SILENCE: u16 = 3;
/// Steps over which the first speed is measured where one step is too short for it.
const FIRST: u16 = 8;
/// Steps for which friction must have held the rotor before that is a rest and no reversal.
const STILL: u16 = 10;

impl<S: Real, const N: usize> Track<S, N> {
    /// What the last update said of itself.
    pub fn status(&self) -> Status {
        self.status
    }
}

impl<S: Real, const N: usize, E: Effects<S>> Observer<S, N, E> {
    /// An observer that knows nothing yet but the rotor's whole turns since both encoders were
    /// zeroed together.
    pub fn start(&self, rotor_turns: i32) -> Track<S, N> {
        let mut state = self.joint.rest();
        state.angle.whole = rotor_turns;
        Track {
            state,
            load: S::ZERO,
            slope: S::ZERO,
            bias: S::ZERO,
            ohm: S::ZERO,
            flux: S::ZERO,
            level: S::ZERO,
            braking: S::ZERO,
            sure: 0,
            unsure: 0,
            drive: S::ZERO,
            lean: S::ZERO,
            alert: 0,
            often: S::ZERO,
            lively: 0,
            held: 0,
            rested: 0,
            even: false,
            energy: S::ZERO,
            doubts: 0,
            missed: 0,
            output_missed: OUTPUT_SILENCE,
            age: 0,
            last: Sample::default(),
            status: Status::LOST,
            row: 0,
            regime: Regime::Steady,
        }
    }

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
        track.load = track.load + track.slope;
        if let Some(leak) = self.gains.leak.get(track.regime as usize) {
            track.slope = track.slope.times(*leak);
        }
        let drive = track.drive + track.bias;
        let State { current, rotor, .. } = &track.state;
        let flowing = *current + (drive - rotor.speed - *current).times(self.gains.winding);
        let drive = drive - track.ohm * flowing - track.flux * rotor.speed;
        let beside = self.brake(track);
        self.joint.step(&mut track.state, Input { drive, load: track.load });
        beside
    }

    /// Lets the friction act that the model has not: on the rotor and on what is behind it by turns.
    #[inline(always)]
    fn brake(&self, track: &mut Track<S, N>) -> S {
        let (gains, level) = (&self.gains, track.level);
        let takes = |brake: &Brake<S>, mass: &Mass<S>| {
            mass.bristle.zeta.times(brake.bristle) + mass.speed.times(brake.viscous)
        };
        let State { rotor, stages, .. } = &mut track.state;
        if !track.even {
            for (stage, brake) in stages.iter_mut().zip(&gains.brakes) {
                let mass = &mut stage.mass;
                mass.speed = mass.speed - level * takes(brake, mass);
            }
            return S::ZERO;
        }
        let taken = takes(&gains.brake, rotor);
        rotor.speed = rotor.speed - level * taken;
        let [without, with] = gains.braking;
        let follow = if Regime::sees(usize::from(track.row)) { with } else { without };
        let beside = taken - track.braking;
        track.braking = track.braking + beside.times(follow);
        beside
    }

    #[inline(always)]
    fn correct(&self, track: &mut Track<S, N>, sample: &Sample<S>, beside: S) -> Status {
        let gains = &self.gains;
        let Looked { found, mut status, blind } = self.innovations(track, sample);
        if status == Status::REPEATED {
            let silent = blind && track.missed > SILENCE;
            if silent {
                self.restart(track);
            }
            return status
                .with_if(silent, Status::LOST)
                .with_if(track.age < gains.settled, Status::STARTING);
        }
        let seen = N > 0 && track.output_missed < OUTPUT_SILENCE;

        let mut lean = S::ZERO;
        let mut energy = S::ZERO;
        let [without, with] = &gains.lean;
        for (innovation, weight) in found.iter().zip(if seen { with } else { without }) {
            lean = lean + innovation.times(*weight);
            energy = energy + *innovation * *innovation;
        }
        track.lean = track.lean + (lean - track.lean).times(gains.follow);
        let energy = if energy > gains.most_energy { gains.most_energy } else { energy };
        track.energy = track.energy + (energy - track.energy).times(gains.settle);
        let alarm = track.lean.abs() > gains.alarm;
        let often = track.often.times(gains.often);
        if alarm {
            track.alert = gains.hold;
            track.often = track.often - often + S::ONE.times(gains.often);
        } else {
            track.alert = track.alert.saturating_sub(1);
            track.often = track.often - often;
        }
        let (most, hold) = gains.lively;
        track.lively = if track.often > most { hold } else { track.lively.saturating_sub(1) };

        let held = track.state.rotor.bristle.slipping < S::HALF;
        let last = track.state.stages.last();
        let bent = last.is_some_and(|stage| stage.deflection.abs() > gains.bent);
        let regime = if held {
            Regime::Held
        } else if track.lively > 0 {
            Regime::Lively
        } else if track.alert > 0 {
            Regime::Alert
        } else {
            Regime::Steady
        };
        track.regime = regime;
        track.held = if held { track.held.saturating_add(1) } else { 0 };
        let row = regime.row(seen, bent);
        let (current, speed) = (track.state.current, track.state.rotor.speed);
        track.row = row as u8;
        if let Some(set) = gains.sets.get(row) {
            self.apply(track, set, &found);
        }

        // Nothing slow is learned of a drive that does not do as it is told, and of the rest one half
        // at a time.
        let learns = self.calm(track) || track.sure < gains.sure;
        let bound = if track.even {
            track.rested =
                if track.held > STILL { gains.settled } else { track.rested.saturating_sub(2) };
            let tells = seen || regime == Regime::Steady && track.rested == 0;
            learns && tells && !held && self.learn_friction(track, beside, seen, &found)
        } else {
            learns && self.learn_motor(track, current, speed, &found, held)
        };
        track.even = !track.even;
        status = status.with_if(bound, Status::BOUNDED);
        for (value, most) in
            [(&mut track.load, gains.most_load), (&mut track.bias, gains.most_bias)]
        {
            status = status.with_if(bounded(value, most), Status::BOUNDED);
        }
        if track.age < gains.settled {
            track.age += 1;
            status = status.with(Status::STARTING);
        }
        status = status
            .with_if(track.energy > gains.strange, Status::MISMATCH)
            .with_if(track.held > STILL && !seen, Status::UNOBSERVABLE);
        let silent = blind && track.missed > SILENCE;
        let lost = silent || blind && track.doubts > DOUBTS;
        let sound = track.state.rotor.speed.abs() <= gains.most_speed;
        if lost || !sound {
            status = status.with_if(silent, Status::LOST);
            self.restart(track);
        }
        status
    }

    /// Winding and magnets, where the current tells of them. Answers whether either is at its bound.
    #[inline(always)]
    fn learn_motor(
        &self,
        track: &mut Track<S, N>,
        current: S,
        speed: S,
        [by_current, ..]: &[S; CHANNELS],
        held: bool,
    ) -> bool {
        let gains = &self.gains;
        track.ohm = track.ohm + current * by_current.times(gains.ohm);
        track.flux = track.flux + speed * by_current.times(gains.flux);
        if !held && track.sure < gains.most_sure {
            track.sure += 1;
        }
        bounded(&mut track.ohm, gains.most_ohm) | bounded(&mut track.flux, gains.most_flux)
    }

    /// Friction's level, from what is `beside` the running mean of it. Answers whether it is at its
    /// bound.
    #[inline(always)]
    fn learn_friction(
        &self,
        track: &mut Track<S, N>,
        beside: S,
        seen: bool,
        [_, by_motor, by_output]: &[S; CHANNELS],
    ) -> bool {
        let gains = &self.gains;
        let ([without, with], [gain, gain_seen]) = (&gains.level_lean, &gains.level);
        let ([motor, output], gain) = if seen { (with, gain_seen) } else { (without, gain) };
        let mut torque = by_motor.times(*motor) + by_output.times(*output);
        bounded(&mut torque, gains.most_level_lean);
        track.level = track.level + beside * torque.times(*gain);
        bounded(&mut track.level, gains.most_level)
    }

    /// Starts anew, with what is slow kept.
    #[cold]
    #[inline(never)]
    fn restart(&self, track: &mut Track<S, N>) {
        let Track { last, drive, ohm, flux, level, sure, .. } = *track;
        *track =
            Track { last, drive, ohm, flux, level, sure, ..self.start(track.state.angle.whole) };
    }

    /// Adds the gains times the innovations, and to the forces that the step keeps what follows from
    /// them by the springs' tangents.
    #[inline(always)]
    fn apply(
        &self,
        track: &mut Track<S, N>,
        [first, second, third]: &[Column<S::Gain, N>; CHANNELS],
        found: &[S; CHANNELS],
    ) {
        let [by_current, by_motor, by_output] = *found;
        let sum = |a: S::Gain, b: S::Gain, c: S::Gain| {
            let both = by_current.times(a) + by_motor.times(b);
            if N > 0 { both + by_output.times(c) } else { both }
        };
        macro_rules! sum {
            ($($field:tt)+) => { sum(first.$($field)+, second.$($field)+, third.$($field)+) };
        }
        let State { current, angle, rotor, stages, .. } = &mut track.state;
        // The winding settles faster than an angle tells of it: the output's has no say in what is
        // electrical.
        *current = *current + (by_current.times(first.current) + by_motor.times(second.current));
        // The next step's sum wraps it.
        angle.part = angle.part + sum!(angle);
        rotor.speed = rotor.speed + sum!(speed);
        let rows = first.stages.iter().zip(&second.stages).zip(&third.stages);
        let mut before = &mut rotor.force;
        for ((stage, own), ((a, b), c)) in stages.iter_mut().zip(&self.joint.stages).zip(rows) {
            let wound = sum(a.deflection, b.deflection, c.deflection);
            let torque = own.spring.slope(stage.deflection) * wound;
            stage.deflection = stage.deflection + wound;
            let mass = &mut stage.mass;
            mass.speed = mass.speed + sum(a.speed, b.speed, c.speed);
            *before = *before - torque;
            mass.force = mass.force + torque;
            before = &mut mass.force;
        }
        track.load = track.load + sum!(load);
        track.slope = track.slope + sum!(slope);
        track.bias = track.bias + (by_current.times(first.bias) + by_motor.times(second.bias));
    }

    /// The first samples: an angle, then a speed.
    #[inline(never)]
    fn acquire(&self, track: &mut Track<S, N>, sample: &Sample<S>) -> Status {
        let status = Status::LOST.with(Status::STARTING);
        let Some(turn) = sample.motor else {
            track.age = 0;
            return status.with(Status::COASTING);
        };
        let moved = motor_ahead(&self.joint.effects, &track.state, turn);
        if track.age == 0 {
            track.state.angle.part = S::ZERO;
            let here = S::from_turn_counts(turn.0 as i32);
            track.state.angle.advance(here);
            track.age = 1;
            return status;
        }
        let [_, motor, _] = &self.gains.whiten;
        let last = track.age == 1;
        let eighth = S::HALF * S::HALF * S::HALF;
        // Eight standard deviations in a step: its speed is measured over that step alone.
        let fast = moved.times(motor.per_sigma).abs() > eighth;
        if !(last && fast) && track.age + 1 < FIRST {
            track.age += 1;
            return status;
        }
        let speed = if last && fast { moved } else { moved * eighth }.times(self.gains.per_turn);
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
        track.alert = self.gains.hold;
        track.age = FIRST;
        Status::STARTING
    }
}

/// Holds a value to its bound; answers whether it was past it.
#[inline(always)]
fn bounded<S: Real>(value: &mut S, most: S) -> bool {
    let past = value.abs() > most;
    if past {
        *value = at_bound(*value, most);
    }
    past
}
