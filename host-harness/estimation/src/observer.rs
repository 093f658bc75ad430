//! A joint seen through its sensors: how a state goes on over an interval, what the sensors show of it, and what is known
//! where a log begins.

use std::ops::Range;

use joint_core::effect::sensor_lag::lead_s;
use joint_core::effect::{Kind, MEMORIES, Memory};
use joint_core::params::Location;
use joint_core::scalar::Scalar;

use crate::covariance::Covariance;
use crate::energy::Energy;
use crate::gains::{Equation, Walk};
use crate::late::Late;
use crate::motion::caught;
use crate::record::{CHANNELS, Channel, Motion, Record};
use crate::reversal::Reversal;
use crate::scales::{Known, Scales};
use joint_simulation::layout::remembers;
use joint_simulation::model::Model;
use joint_simulation::plant::{Layout, Plant, inertias, output_shaft};

/// How much less is known of a joint in motion than at rest.
const UNKNOWN: f64 = 10.0;
/// One sigma there of what an effect remembers, which is about one where it has lasted.
const REMEMBERED: f64 = 0.5;
/// Samples from which the speed of a joint in motion is taken, at most.
const AHEAD: usize = 65;

/// What a sensor's filter remembers.
#[derive(Clone, Copy, Debug)]
struct Lag {
    /// Where that stands in the state.
    memory: usize,
    /// What a sensor shows of one of it.
    shown: f64,
    /// What it shows at once of the current itself.
    at_once: f64,
    /// How far what it shows is behind a steady motion, s.
    behind_s: f64,
}

impl Lag {
    /// By channel, of a model.
    fn of(model: &Model, plant: &dyn Plant, layout: Layout) -> [Option<Self>; CHANNELS] {
        let mut lags = [None; CHANNELS];
        let remembering = model.effects.iter().filter(|effect| remembers(effect.kind));
        for (slot, effect) in remembering.enumerate() {
            if effect.kind != Kind::SensorLag || slot >= MEMORIES {
                continue;
            }
            let mut one = [0.0; MEMORIES];
            one[slot] = 1.0;
            let by = |show: &dyn Fn(&Memory<f64>) -> f64| show(&one) - show(&[0.0; MEMORIES]);
            let error = |output: bool| {
                by(&|memory: &Memory<f64>| plant.encoder_error(output, 0.0, 0.0, memory))
            };
            let current = |now, memory: &Memory<f64>| plant.measured_current(now, memory);
            let (channel, shown) = match effect.location {
                Location::CurrentSensor => (Channel::Current, by(&|memory| current(0.0, memory))),
                Location::OutputEncoder => (Channel::Output, error(true)),
                _ => (Channel::Motor, error(false)),
            };
            let nothing = [0.0; MEMORIES];
            let at_once = match channel {
                Channel::Current => current(1.0, &nothing) - current(0.0, &nothing),
                Channel::Motor | Channel::Output => 0.0,
            };
            let one = std::slice::from_ref(effect);
            let behind_s = effect.values[0] - lead_s(one, effect.location);
            let memory = layout.memory(slot);
            lags[channel as usize] = Some(Self { memory, shown, at_once, behind_s });
        }
        lags
    }
}

/// A joint seen through its sensors.
pub struct Observer<'a> {
    pub(super) plant: &'a dyn Plant,
    pub(super) record: &'a Record,
    pub(super) layout: Layout,
    pub(super) shaft: f64,
    inertia: Vec<f64>,
    /// What a derivative is believed by.
    pub(super) energy: Energy,
    /// Of the rotor and of the last mass: how they feel a noise of the reversal.
    reversals: [Reversal; 2],
    pub(super) known: Known,
    pub(super) late: Late<'a>,
    /// Whether the model's encoders err.
    pub(super) sensor_errors: bool,
    /// By channel: time by which what it shows is ahead of the truth, s.
    ahead: [f64; CHANNELS],
    /// By channel: what its sensor's filter remembers, if it has one.
    lags: [Option<Lag>; CHANNELS],
    /// Samples after which none of their log is asked for, to the end of that log.
    pub(super) idle: Vec<Range<usize>>,
}

impl<'a> Observer<'a> {
    /// A plant observed over a record.
    pub fn new(model: &Model, plant: &'a dyn Plant, record: &'a Record) -> Self {
        let layout = Layout::of(model);
        let inertia = inertias(model);
        let reversals = Reversal::of(model, &inertia);
        let interval = record.grid.typical_interval();
        let energy = Energy::of(model, record.drive, &inertia, interval);
        let known = Known::of(model);
        let shaft = output_shaft(model);
        let late = Late::of(model, record);
        let sensor_errors = model.effects.iter().any(|effect| effect.kind.is_of_a_sensor());
        let error = |output, speed| plant.encoder_error(output, 0.0, speed, &[0.0; MEMORIES]);
        let ahead = Channel::ALL.map(|channel| {
            let by = late.by[channel as usize];
            match channel {
                Channel::Current => by,
                _ if !sensor_errors => by,
                _ => {
                    let output = channel == Channel::Output;
                    by + error(output, 1.0) - error(output, 0.0)
                }
            }
        });
        let lags = Lag::of(model, plant, layout);
        let idle = Vec::new();
        Self {
            plant,
            record,
            layout,
            shaft,
            inertia,
            energy,
            reversals,
            known,
            late,
            sensor_errors,
            ahead,
            lags,
            idle,
        }
    }

    /// The joint where a log begins: at rest, or in the motion that its encoder or somebody's filter shows; in
    /// motion its effects remember what they did `before`.
    pub(super) fn start(
        &self,
        k: usize,
        walks: &[Walk],
        before: impl Fn(usize) -> Option<f64>,
    ) -> Vec<f64> {
        let order = self.layout.len() + walks.len();
        let mut x = vec![0.0; order];
        let motion = self.record.motions.iter().find(|motion| motion.sample == k);
        let speed =
            motion.map_or_else(|| self.speed_at(k), |motion| motion.state[self.layout.speed(0)]);
        if let Some(Motion { state, constants, goes_on, .. }) = motion {
            x[..state.len()].copy_from_slice(state);
            for (place, constant) in (self.layout.len()..order).zip(constants) {
                x[place] = before(place).filter(|_| *goes_on).unwrap_or(*constant);
            }
        } else if speed != 0.0 {
            for mass in 0..=self.layout.stages {
                x[self.layout.speed(mass)] = speed;
                x[self.layout.bristle(mass)] = 0.9 * speed.signum();
            }
        }
        if self.record.cuts.contains(&k) {
            for slot in 0..self.layout.memories {
                let memory = self.layout.memory(slot);
                x[memory] = before(memory).filter(|value| value.is_finite()).unwrap_or(0.0);
            }
        }
        for (channel, lag) in Channel::ALL.into_iter().zip(&self.lags) {
            let Some(Lag { memory, shown, at_once, behind_s }) = lag else { continue };
            x[*memory] = match channel {
                // What is measured is the filter's own output, or that and the current's share.
                Channel::Current => self.late.measured[k][channel as usize] / (shown + at_once),
                Channel::Motor => -behind_s * speed / shown,
                Channel::Output => -behind_s * speed * self.shaft / shown,
            };
            x[*memory] = if x[*memory].is_finite() { x[*memory] } else { 0.0 };
        }
        if let Some(place) = self.current_before(walks) {
            let shown = self.late.measured[k][Channel::Current as usize];
            x[place] = if shown.is_finite() { shown } else { 0.0 };
        }
        let angle = self.late.measured[k][Channel::Motor as usize];
        if angle.is_finite() {
            // Where the encoder shows this angle, not where it would stand without its errors.
            let shown = angle - self.late.by[Channel::Motor as usize] * speed;
            let (mut there, memory) = (shown, self.memory(|state| x[state]));
            for _ in 0..2 {
                there = shown - self.plant.encoder_error(false, there, speed, &memory);
            }
            x[Layout::ANGLE] = there;
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

    /// How well that is known; `before` is how well it was.
    pub(super) fn start_covariance(
        &self,
        k: usize,
        scales: &Scales,
        walks: &[Walk],
        before: &mut Covariance,
    ) -> Covariance {
        let n = self.layout.len();
        // Nothing but the encoder is known of a joint in motion.
        let cut = self.record.cuts.contains(&k);
        let remembered = self.layout.memory(0)..n;
        let reported = self.lags[Channel::Current as usize].map(|lag| lag.memory);
        let shown = self.current_before(walks);
        // What its sensor showed is known as the current is.
        let alike = |state: usize| if shown == Some(state) { Layout::CURRENT } else { state };
        let sigma = |state: usize| match scales.start_sigma.get(alike(state)) {
            Some(_) if reported == Some(state) => REMEMBERED,
            Some(_) if cut && remembered.contains(&state) => REMEMBERED,
            Some(sigma) if cut && state != Layout::ANGLE => UNKNOWN * sigma,
            Some(sigma) => *sigma,
            None => walks[state - n].initial,
        };
        let motion = self.record.motions.iter().find(|motion| motion.sample == k);
        let going_on = n + motion.filter(|motion| motion.goes_on).map_or(0, |m| m.constants.len());
        let sigma = |state: usize| match (n..going_on).contains(&state) {
            true => before.variance(state).max(0.0).sqrt(),
            false => sigma(state),
        };
        let sigmas: Vec<f64> = (0..n + walks.len()).map(sigma).collect();
        Covariance::independent(sigmas.into_iter())
    }

    /// What effects remember in a state.
    fn memory(&self, x: impl Fn(usize) -> f64) -> Memory<f64> {
        let memories = self.layout.memories;
        std::array::from_fn(|slot| if slot < memories { x(self.layout.memory(slot)) } else { 0.0 })
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
        let memory = if self.sensor_errors { self.memory(&x) } else { [0.0; MEMORIES] };
        let [bias, there, speed] = self.seen(channel, &x, walks, self.shaft);
        let caught_up = self.late.by[channel as usize] * speed;
        match channel {
            Channel::Current => {
                let now = self.reported(&x);
                let before = self.current_before(walks).map_or(now, x);
                bias + now + (before - now) * self.late.before
            }
            _ if !self.sensor_errors => bias + there + caught_up,
            Channel::Motor | Channel::Output => {
                let output = channel == Channel::Output;
                let error = self.plant.encoder_error(output, there, speed, &memory);
                bias + there + error + caught_up
            }
        }
    }

    /// What the current's sensor shows at once of a state by its numbers, A.
    #[inline]
    pub(super) fn reported(&self, x: impl Fn(usize) -> f64) -> f64 {
        let current = x(Layout::CURRENT);
        match self.sensor_errors {
            true => self.plant.measured_current(current, &self.memory(x)),
            false => current,
        }
    }

    /// How that changes with each state.
    pub(super) fn reported_by(&self, row: &mut [f64]) {
        row[Layout::CURRENT] = 1.0;
        if let Some(lag) = self.lags[Channel::Current as usize] {
            row[Layout::CURRENT] = lag.at_once;
            row[lag.memory] = lag.shown;
        }
    }

    /// Where a state has what the current's sensor showed a sample ago.
    #[inline]
    fn current_before(&self, walks: &[Walk]) -> Option<usize> {
        let own = walks.iter().position(|walk| walk.equation == Equation::CurrentBefore);
        own.map(|own| self.layout.len() + own)
    }

    /// Keeps what the current's sensor shows, where the next sample asks for it.
    pub(super) fn remember(&self, x: &mut [f64], walks: &[Walk]) {
        if let Some(place) = self.current_before(walks) {
            x[place] = self.reported(|state| x[state]);
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
            Channel::Current => {
                self.reported_by(row);
                if let Some(place) = self.current_before(walks) {
                    row.iter_mut().for_each(|value| *value *= 1.0 - self.late.before);
                    row[place] = self.late.before;
                }
            }
            Channel::Motor => {
                row[Layout::ANGLE] = 1.0;
                row[self.layout.speed(0)] = self.ahead[channel as usize];
            }
            Channel::Output => {
                row[self.layout.speed(self.layout.stages)] =
                    self.ahead[channel as usize] * self.shaft;
                row[Layout::ANGLE] = self.shaft;
                for k in 0..self.layout.stages {
                    row[self.layout.deflection(k)] = -self.shaft;
                }
            }
        }
        if let Some(lag) = self.lags[channel as usize].filter(|_| channel != Channel::Current) {
            row[lag.memory] = lag.shown;
        }
        let n = self.layout.len();
        for (k, walk) in walks.iter().enumerate() {
            if walk.equation == Equation::Sensor(channel) {
                row[n + k] = 1.0;
            }
        }
    }

    /// One interval forward, with the walks' push.
    pub(super) fn advance(&self, k: usize, x: &mut [f64], walks: &[Walk]) {
        let drives = self.driven(k, x, walks);
        self.remember(x, walks);
        let own = &mut x[..self.layout.len()];
        self.plant.propagate_switched(k, own, drives, self.record.load_nm[k]);
        self.kick(k, x, walks);
    }

    /// What drives the joint over the interval after sample `k`, before and after it switches, with the
    /// walks on it.
    pub(super) fn driven(&self, k: usize, x: &[f64], walks: &[Walk]) -> [f64; 2] {
        let pushes = walks.iter().zip(&x[self.layout.len()..]);
        let pushes = pushes.filter(|(walk, _)| walk.equation == Equation::Voltage);
        let push = pushes.map(|(_, value)| value).sum::<f64>();
        self.late.drives(self.record, k).map(|drive| drive + push)
    }

    /// The walks' torques over the interval after sample `k`.
    pub(super) fn kick(&self, k: usize, x: &mut [f64], walks: &[Walk]) {
        let interval = self.record.grid.interval(k);
        for (j, walk) in walks.iter().enumerate() {
            if let Equation::Torque(mass) = walk.equation {
                let torque = x[self.layout.len() + j];
                self.push(x, mass, torque, interval);
            }
            x[self.layout.len() + j] *= walk.kept(interval);
        }
    }

    /// Share of its variance that a noise of the reversal has in a state, on the rotor and on the last mass.
    pub(super) fn reversing(&self, x: &[f64]) -> [f64; 2] {
        let [rotor, last] = self.reversals;
        [rotor.felt(x[self.layout.speed(0)]), last.felt(x[self.layout.speed(self.layout.stages)])]
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
}
