//! One update: predict, look, doubt, correct.
//!
//! What a drive's interrupt may meet stands here: samples lost or repeated, an encoder that jumps, a
//! current sensor at its end, a number that is none. Nothing of it enters the state; each raises a
//! flag, the estimates stay within their bounds, and the next good sample is taken up without a
//! reset.

use super::gains::{Brake, CHANNELS, Column, Gains, Regime, Whiten};
use super::health::Status;
use super::turn::Turn;
use super::{Observer, Sample, Track};
use crate::effect::Effects;
use crate::joint::{Input, Mass, State};
use crate::scalar::Scalar;

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

/// Surprises after which winding and magnets are no longer taken to be known: a dip under a drive that
/// moves has dozens.
const SURPRISES: u16 = 64;

/// What an update sees of a sample.
#[derive(Clone, Copy, Debug, Default)]
struct Looked<S> {
    found: [S; CHANNELS],
    status: Status,
    /// Whether no rotor angle was believed.
    blind: bool,
}

impl<S, const N: usize> Track<S, N> {
    /// What the last update said of itself.
    pub fn status(&self) -> Status {
        self.status
    }
}

impl<S: Scalar, const N: usize, E: Effects<S>> Observer<S, N, E> {
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

    /// Innovations in units of [`SIGMAS`](super::gains::SIGMAS), zero where there is none to believe; and the flags that
    /// go with them.
    #[inline(always)]
    fn innovations(&self, track: &mut Track<S, N>, sample: &Sample<S>) -> Looked<S> {
        let gains = &self.gains;
        let [by_current, by_motor, by_output] = &gains.whiten;
        let mut status = Status::OK;
        let mut blind = true;
        let mut found = [S::ZERO; CHANNELS];
        let [current, motor, output] = &mut found;

        let ahead = sample.motor.map(|turn| motor_ahead(&self.joint.effects, &track.state, turn));
        match ahead {
            Some(ahead) if ahead.abs() <= by_motor.gate => {
                *motor = ahead.times(by_motor.per_sigma);
                track.missed = 0;
                track.doubts = 0;
                blind = false;
            }
            Some(_) if repeats(sample, &track.last) => {
                track.missed = track.missed.saturating_add(1);
                return Looked { status: Status::REPEATED, blind: true, ..Looked::default() };
            }
            Some(_) => {
                status = status.with(Status::GLITCH);
                track.doubts = track.doubts.saturating_add(1);
            }
            None => {
                status = status.with(Status::COASTING);
                track.missed = track.missed.saturating_add(1);
            }
        }

        if let Some(turn) = sample.output
            && N > 0
        {
            let ahead =
                output_ahead(&self.joint.effects, gains, self.joint.turns, &track.state, turn);
            if ahead.abs() <= by_output.gate {
                *output = ahead.times(by_output.per_sigma);
                track.output_missed = 0;
            } else {
                status = status.with(Status::GLITCH);
                track.output_missed = track.output_missed.saturating_add(1);
            }
        } else {
            track.output_missed = track.output_missed.saturating_add(1);
        }

        if !self.joint.current_imposed {
            match sample.current.map(|amperes| amperes.times(gains.per_ampere)) {
                Some(measured) if measured.abs() < gains.most_current => {
                    // Currents are those that give their torque with the model's flux.
                    let measured = measured + measured * track.flux;
                    let shown = self.joint.effects.measured_current(track.state.current);
                    let ahead = measured - shown;
                    let ahead = match ahead.abs() > gains.sudden {
                        true => self.surprised(track, ahead),
                        false => ahead,
                    };
                    *current = ahead.times(by_current.per_sigma);
                }
                _ => status = status.with(Status::NO_CURRENT),
            }
        }

        // Four standard deviations.
        let eighth = S::HALF * S::HALF * S::HALF;
        if motor.abs() > eighth * S::HALF && repeats(sample, &track.last) {
            return Looked { status: Status::REPEATED, ..Looked::default() };
        }
        Looked { found, status, blind }
    }

    /// A current that is off by more than the design has it: what there is to correct by.
    ///
    /// Until winding and magnets are known it is an error of theirs. Then, the second time, the drive
    /// has put out another voltage than it was told, and that voltage takes all of it: a bus that
    /// dips is neither a load nor a resistance.
    #[cold]
    #[inline(never)]
    fn surprised(&self, track: &mut Track<S, N>, ahead: S) -> S {
        let gains = &self.gains;
        let second = track.sure == track.unsure;
        track.sure = track.sure.saturating_sub(gains.sure / SURPRISES + 1);
        if track.sure < gains.sure {
            let [Whiten { gate, .. }, ..] = gains.whiten;
            return if ahead.abs() > gate { at_bound(ahead, gate) } else { ahead };
        }
        let calm = self.calm(track);
        track.energy = gains.most_energy;
        track.unsure = if calm { track.sure } else { u16::MAX };
        if calm {
            return S::ZERO;
        }
        let ([missing, missing_twice], [push, push_twice]) = (gains.missing, gains.push);
        let (missing, push) = if second { (missing_twice, push_twice) } else { (missing, push) };
        let (before, State { current, rotor, .. }) = (track.bias, &mut track.state);
        *current = *current + ahead;
        rotor.speed = rotor.speed + ahead.times(push);
        let bias = before + ahead.times(missing);
        // What little is left of it is what the estimate was off: the dip is over.
        track.bias = if bias.abs() < before.abs().eighth() { S::ZERO } else { bias };
        S::ZERO
    }

    /// Whether no surprise was a short time ago.
    #[inline(always)]
    fn calm(&self, track: &Track<S, N>) -> bool {
        track.energy + track.energy <= self.gains.most_energy
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

/// Whether a sample shows the very same measurements as the one before.
#[inline(always)]
fn repeats<S: Scalar>(sample: &Sample<S>, last: &Sample<S>) -> bool {
    sample.motor == last.motor && sample.output == last.output && sample.current == last.current
}

/// By how much the measured rotor angle is ahead of the estimated one, in turns.
#[inline(always)]
fn motor_ahead<S: Scalar, const N: usize, E: Effects<S>>(
    effects: &E,
    state: &State<S, N>,
    turn: Turn,
) -> S {
    let shown = state.angle.part + effects.encoder_error(false, state.angle, state.rotor.speed);
    (S::from_turn_counts(turn.0 as i32) - shown).split_turns().1
}

/// By how much the measured output angle is ahead of the estimated one, in turns of the output.
#[inline(always)]
fn output_ahead<S: Scalar, const N: usize, E: Effects<S>>(
    effects: &E,
    gains: &Gains<S, N>,
    turns: S::Gain,
    state: &State<S, N>,
    turn: Turn,
) -> S {
    let wound = state.stages.iter().fold(S::ZERO, |sum, stage| sum + stage.deflection);
    let part = (state.angle.part - wound.times(turns)).times(gains.shaft);
    let speed = state.stages.last().map_or(S::ZERO, |stage| stage.mass.speed);
    let angle = crate::angle::Angle { part, ..Default::default() };
    let shown = part + effects.encoder_error(true, angle, speed);
    let beyond = S::from_turn_counts(turn.ahead_of(gains.geared.turn(state.angle.whole)));
    (beyond - shown).split_turns().1
}

/// Holds a value to its bound; answers whether it was past it.
#[inline(always)]
fn bounded<S: Scalar>(value: &mut S, most: S) -> bool {
    let past = value.abs() > most;
    if past {
        *value = at_bound(*value, most);
    }
    past
}

/// The bound that a value is past.
#[cold]
#[inline(never)]
fn at_bound<S: Scalar>(value: S, most: S) -> S {
    if value < S::ZERO { -most } else { most }
}
