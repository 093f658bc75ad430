//! The filter: an extended Kalman filter designed once along a record, then run with its gains
//! frozen.
//!
//! Designing costs one propagation for each state; running costs one in all. Because the gains are
//! frozen, the innovations are a plain function of the parameters, and refitting is a nonlinear
//! least-squares problem with an exact sensitivity by differences. Measurements are taken one
//! channel after the other, which leaves the innovations uncorrelated between channels as well.

use std::borrow::Cow;
use std::ops::Range;

use joint_core::scalar::Scalar;

use crate::estimate::covariance::Covariance;
pub use crate::estimate::gains::{Equation, Gains, Linearisation, Noise, Run, Walk};
use crate::estimate::keep::{Keep, Measured, Passed, Whole};
use crate::estimate::late::Late;
use crate::estimate::record::{CHANNELS, Channel, Record, caught};
use crate::estimate::scales::{Known, Scales};
use crate::estimate::slopes::is_of_a_sensor;
use crate::lanes::Linear;
use crate::model::Model;
use crate::plant::{Layout, Plant, inertias, output_shaft};

/// How much less is known of a joint in motion than at rest.
const UNKNOWN: f64 = 10.0;
/// Samples from which the speed of a joint in motion is taken, at most.
const AHEAD: usize = 65;

/// A joint seen through its sensors.
pub struct Observer<'a> {
    pub(super) plant: &'a dyn Plant,
    pub(super) record: &'a Record,
    pub(super) layout: Layout,
    pub(super) shaft: f64,
    inertia: Vec<f64>,
    known: Known,
    pub(super) late: Late<'a>,
    /// Whether the model's encoders err.
    pub(super) sensor_errors: bool,
    /// Samples after which none of their log is asked for, to the end of that log.
    pub(super) idle: Vec<Range<usize>>,
}

impl<'a> Observer<'a> {
    /// A plant observed over a record.
    pub fn new(model: &Model, plant: &'a dyn Plant, record: &'a Record) -> Self {
        let layout = Layout::of(model);
        let inertia = inertias(model);
        let known = Known::of(model);
        let shaft = output_shaft(model);
        let late = Late::of(model, record);
        let sensor_errors = model.effects.iter().any(|effect| is_of_a_sensor(effect.kind));
        let idle = Vec::new();
        Self { plant, record, layout, shaft, inertia, known, late, sensor_errors, idle }
    }

    /// Designs the gains along the record and runs it.
    pub fn design(&self, noise: &Noise, walks: &[Walk]) -> (Gains, Run) {
        self.design_along(&mut Cow::Owned(Linearisation::default()), noise, walks)
    }

    /// The same along a linearisation, which is made if it is empty.
    pub fn design_along(
        &self,
        along: &mut Cow<'_, Linearisation>,
        noise: &Noise,
        walks: &[Walk],
    ) -> (Gains, Run) {
        self.designed(along, noise, walks, true)
    }

    /// The same, without the states where they are not asked for.
    pub(super) fn designed(
        &self,
        along: &mut Cow<'_, Linearisation>,
        noise: &Noise,
        walks: &[Walk],
        with_states: bool,
    ) -> (Gains, Run) {
        let order = self.layout.len() + walks.len();
        let mut whole = Whole::new(self.record.len(), order, walks, with_states);
        self.run(along, noise, walks, &mut whole);
        whole.results(order)
    }

    /// Runs the filter along a linearisation, which is made if it is empty.
    pub(super) fn run(
        &self,
        along: &mut Cow<'_, Linearisation>,
        noise: &Noise,
        walks: &[Walk],
        keep: &mut impl Keep,
    ) {
        let order = self.layout.len() + walks.len();
        let samples = self.record.len();
        let mut x = Vec::new();
        let mut p = Covariance::independent(std::iter::empty());
        let mut scratch = Scratch::new(order);
        let scales = self.known.scales(self.record, self.layout);
        let made = along.drive.len() >= samples.saturating_sub(1) * self.layout.len();
        let linear = (!made).then(|| self.plant.linear());
        for k in 0..samples {
            if self.is_idle(k) {
                if !made {
                    along.to_mut().skip(self.layout.len());
                }
                keep.corrected(&x);
                continue;
            }
            if self.record.starts.contains(&k) {
                x = self.start(k, order);
                p = self.start_covariance(k, &scales, walks);
                keep.began();
            }
            for channel in Channel::ALL {
                let c = channel as usize;
                let measured = self.late.measured[k][c];
                if !measured.is_finite() {
                    continue;
                }
                let row = &mut scratch.row;
                self.sensitivity(channel, walks, row);
                p.times(row, &mut scratch.column);
                let sensor = noise.sensors[c];
                let variance = dot(row, &scratch.column) + sensor * sensor;
                let weight = 1.0 / variance.sqrt();
                let innovation = measured - self.shown(channel, &x, walks);
                let error = innovation * weight;
                let column = &scratch.column;
                let sample = k;
                keep.measured(&Measured { sample, channel, row, column, innovation, variance });
                let gains = scratch.gain.iter_mut().zip(&mut x).zip(&scratch.column);
                for ((gain, x), column) in gains {
                    *gain = column * weight;
                    *x += *gain * error;
                }
                keep.taken(k, c, error, weight, &scratch.gain);
                p.add_square(-weight * weight, &scratch.column);
            }
            keep.corrected(&x);
            if k + 1 < samples {
                let by = linear.as_deref().map(|linear| (linear, &scales));
                self.linearise(k, &mut x, walks, along, (by, &mut scratch));
                self.predict(k, &mut p, noise, walks, along, &mut scratch);
                let Scratch { transition, column: drive, kick, .. } = &scratch;
                keep.passed(&Passed { transition, drive, kick });
            }
        }
    }

    /// Runs the record with frozen gains; only the innovations. The gains may be those of a model
    /// that remembers less: what is added is not corrected.
    pub fn innovations(&self, gains: &Gains) -> Vec<[f64; CHANNELS]> {
        let designed = gains.order - gains.walks.len();
        let own = self.layout.len();
        let common = designed.min(own);
        let mut x = Vec::new();
        let mut innovations = vec![[0.0; CHANNELS]; self.record.len()];
        for (k, row) in innovations.iter_mut().enumerate() {
            if self.is_idle(k) {
                continue;
            }
            if self.record.starts.contains(&k) {
                x = self.start(k, own + gains.walks.len());
            }
            for channel in Channel::ALL {
                let c = channel as usize;
                let weight = gains.weight[k][c];
                if weight == 0.0 {
                    continue;
                }
                let shown = self.shown(channel, &x, &gains.walks);
                let error = (self.late.measured[k][c] - shown) * weight;
                if !error.is_finite() {
                    continue;
                }
                row[c] = error;
                let slot = (k * CHANNELS + c) * gains.order;
                let (states, walks) = gains.gain[slot..slot + gains.order].split_at(designed);
                for (value, gain) in x.iter_mut().zip(&states[..common]) {
                    *value += gain * error;
                }
                for (value, gain) in x[own..].iter_mut().zip(walks) {
                    *value += gain * error;
                }
            }
            self.advance(k, &mut x, &gains.walks);
        }
        innovations
    }

    /// The joint where a log begins: at rest, or in the motion that its encoder shows.
    pub(super) fn start(&self, k: usize, order: usize) -> Vec<f64> {
        let mut x = vec![0.0; order];
        let angle = self.late.measured[k][Channel::Motor as usize];
        let speed = self.speed_at(k);
        if angle.is_finite() {
            // Where the encoder shows this angle, not where it would stand without its errors.
            let mut there = angle;
            for _ in 0..2 {
                there = angle - self.plant.encoder_error(false, there, speed);
            }
            x[Layout::ANGLE] = there;
        }
        if speed != 0.0 {
            for mass in 0..=self.layout.stages {
                x[self.layout.speed(mass)] = speed;
                x[self.layout.bristle(mass)] = 0.9 * speed.signum();
            }
        }
        x
    }

    /// Speed that the encoder shows of a joint in motion, rad/s; zero where it begins at rest.
    fn speed_at(&self, k: usize) -> f64 {
        if !self.record.cuts.contains(&k) {
            return 0.0;
        }
        let motor = |row: &[f64; CHANNELS]| row[Channel::Motor as usize];
        let angles: Vec<f64> = self.late.measured[k..].iter().take(AHEAD).map(motor).collect();
        let Some(window) = caught(&angles).or((angles.len() > 1).then(|| angles.len() - 1)) else {
            return 0.0;
        };
        let time_s = self.record.time_s[k + window] - self.record.time_s[k];
        let speed = (angles[window] - angles[0]) / time_s;
        if speed.is_finite() { speed } else { 0.0 }
    }

    fn start_covariance(&self, k: usize, scales: &Scales, walks: &[Walk]) -> Covariance {
        let n = self.layout.len();
        // Nothing but the encoder is known of a joint in motion.
        let cut = self.record.cuts.contains(&k);
        let sigma = |state: usize| match scales.start_sigma.get(state) {
            Some(sigma) if cut && state != Layout::ANGLE => UNKNOWN * sigma,
            Some(sigma) => *sigma,
            None => walks[state - n].initial,
        };
        Covariance::independent((0..n + walks.len()).map(sigma))
    }

    /// What a sensor shows of a state.
    pub(super) fn shown(&self, channel: Channel, x: &[f64], walks: &[Walk]) -> f64 {
        self.shown_of(channel, |state| x[state], walks)
    }

    /// The same of a state by its numbers.
    #[inline]
    pub(super) fn shown_of(
        &self,
        channel: Channel,
        x: impl Fn(usize) -> f64,
        walks: &[Walk],
    ) -> f64 {
        let [bias, there, speed] = self.seen(channel, x, walks, self.shaft);
        let caught_up = self.late.by[channel as usize] * speed;
        match channel {
            _ if !self.sensor_errors => bias + there + caught_up,
            Channel::Current => bias + self.plant.measured_current(there),
            Channel::Motor | Channel::Output => {
                let error = self.plant.encoder_error(channel == Channel::Output, there, speed);
                bias + there + error + caught_up
            }
        }
    }

    /// What a sensor sees of a joint, or of several side by side of which each has its own `shaft` to the
    /// output: what wanders beside it, the current or the angle itself, and the speed of that angle.
    #[inline(always)]
    pub(super) fn seen<S: Scalar>(
        &self,
        channel: Channel,
        x: impl Fn(usize) -> S,
        walks: &[Walk],
        shaft: S,
    ) -> [S; 3] {
        let of_sensor = |walk: &Walk| walk.equation == Equation::Sensor(channel);
        let beside = walks.iter().zip(self.layout.len()..).filter(|(walk, _)| of_sensor(walk));
        let bias = beside.fold(S::ZERO, |sum, (_, state)| sum + x(state));
        match channel {
            Channel::Current => [bias, x(Layout::CURRENT), S::ZERO],
            Channel::Motor => [bias, x(Layout::ANGLE), x(self.layout.speed(0))],
            Channel::Output => {
                let stages = self.layout.stages;
                let wound = (0..stages).fold(S::ZERO, |sum, k| sum + x(self.layout.deflection(k)));
                let speed = x(self.layout.speed(stages)) * shaft;
                [bias, (x(Layout::ANGLE) - wound) * shaft, speed]
            }
        }
    }

    pub(super) fn sensitivity(&self, channel: Channel, walks: &[Walk], row: &mut [f64]) {
        row.fill(0.0);
        match channel {
            Channel::Current => row[Layout::CURRENT] = 1.0,
            Channel::Motor => row[Layout::ANGLE] = 1.0,
            Channel::Output => {
                row[Layout::ANGLE] = self.shaft;
                for k in 0..self.layout.stages {
                    row[self.layout.deflection(k)] = -self.shaft;
                }
            }
        }
        let n = self.layout.len();
        for (k, walk) in walks.iter().enumerate() {
            if walk.equation == Equation::Sensor(channel) {
                row[n + k] = 1.0;
            }
        }
    }

    /// One interval forward, with the walks' push.
    fn advance(&self, k: usize, x: &mut [f64], walks: &[Walk]) {
        let drive = self.driven(k, x, walks);
        self.plant.propagate(k, &mut x[..self.layout.len()], drive, self.record.load_nm[k]);
        self.kick(k, x, walks);
    }

    /// What drives the joint over the interval after sample `k`, with the walks on it.
    fn driven(&self, k: usize, x: &[f64], walks: &[Walk]) -> f64 {
        let pushes = walks.iter().zip(&x[self.layout.len()..]);
        let pushes = pushes.filter(|(walk, _)| walk.equation == Equation::Voltage);
        self.record.drive_values[k] + pushes.map(|(_, value)| value).sum::<f64>()
    }

    /// The walks' torques over the interval after sample `k`.
    fn kick(&self, k: usize, x: &mut [f64], walks: &[Walk]) {
        let interval = self.record.grid.interval(k);
        for (j, walk) in walks.iter().enumerate() {
            if let Equation::Torque(mass) = walk.equation {
                let torque = x[self.layout.len() + j];
                self.push(x, mass, torque, interval);
            }
        }
    }

    /// A torque held over an interval, on a mass that is otherwise free.
    pub(super) fn push(&self, x: &mut [f64], mass: usize, torque: f64, interval: f64) {
        self.pushed(mass, torque, interval, |state, change| x[state] += change);
    }

    /// The same by what it changes.
    pub(super) fn pushed(
        &self,
        mass: usize,
        torque: f64,
        interval: f64,
        mut change: impl FnMut(usize, f64),
    ) {
        let gained = torque * interval / self.inertia[mass];
        let moved = 0.5 * gained * interval;
        change(self.layout.speed(mass), gained);
        match mass.checked_sub(1) {
            None => change(Layout::ANGLE, moved),
            Some(before) => change(self.layout.deflection(before), -moved),
        }
        if mass < self.layout.stages {
            change(self.layout.deflection(mass), moved);
        }
    }

    /// One interval forward, and its derivatives where they are not known.
    fn linearise(
        &self,
        k: usize,
        x: &mut [f64],
        walks: &[Walk],
        along: &mut Cow<'_, Linearisation>,
        (linear, scratch): (Option<(&dyn Linear, &Scales)>, &mut Scratch),
    ) {
        let Some((linear, Scales { steps, .. })) = linear else {
            return self.advance(k, x, walks);
        };
        let n = self.layout.len();
        // Away from the reversal: friction's derivative is taken on the side it moves to.
        let away = |step: &f64, x: &f64| if *x < 0.0 { -step } else { *step };
        scratch.steps.clear();
        scratch.steps.extend(steps.iter().zip(&x[..n]).map(|(step, x)| away(step, x)));
        scratch.steps.extend(steps.last());
        let inputs = [self.driven(k, x, walks), self.record.load_nm[k]];
        let Linearisation { transition, drive } = along.to_mut();
        linear.propagate(k, &mut x[..n], inputs, &scratch.steps, (transition, drive));
        self.kick(k, x, walks);
    }

    /// The covariance one interval forward.
    fn predict(
        &self,
        k: usize,
        p: &mut Covariance,
        noise: &Noise,
        walks: &[Walk],
        along: &Linearisation,
        scratch: &mut Scratch,
    ) {
        let n = self.layout.len();
        let order = n + walks.len();
        let interval = self.record.grid.interval(k);
        let by_drive = &along.drive[k * n..(k + 1) * n];
        let f = &mut scratch.transition;
        f.fill(0.0);
        for i in 0..n {
            let row = &along.transition[(k * n + i) * n..(k * n + i + 1) * n];
            f[i * order..i * order + n].copy_from_slice(row);
        }
        let kick = &mut scratch.kick;
        kick.fill(0.0);
        self.push(kick, 0, 1.0, interval);
        for (j, walk) in walks.iter().enumerate() {
            match walk.equation {
                Equation::Voltage => {
                    for i in 0..n {
                        f[i * order + n + j] = by_drive[i];
                    }
                }
                Equation::Torque(mass) => {
                    let own = &mut scratch.column;
                    own.fill(0.0);
                    self.push(own, mass, 1.0, interval);
                    for i in 0..n {
                        f[i * order + n + j] = own[i];
                    }
                }
                Equation::Sensor(_) => {}
            }
            f[(n + j) * order + n + j] = 1.0;
        }
        p.carry(f);
        scratch.column.fill(0.0);
        scratch.column[..n].copy_from_slice(by_drive);
        p.add_square(noise.drive * noise.drive, &scratch.column);
        p.add_square(noise.torque * noise.torque, kick);
        for (j, walk) in walks.iter().enumerate() {
            p.add_variance(n + j, walk.rate * walk.rate * interval);
        }
    }
}

struct Scratch {
    row: Vec<f64>,
    column: Vec<f64>,
    gain: Vec<f64>,
    steps: Vec<f64>,
    kick: Vec<f64>,
    transition: Vec<f64>,
}

impl Scratch {
    fn new(order: usize) -> Self {
        Self {
            row: vec![0.0; order],
            column: vec![0.0; order],
            gain: vec![0.0; order],
            steps: Vec::with_capacity(order + 1),
            kick: vec![0.0; order],
            transition: vec![0.0; order * order],
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
