//! What is done to a joint while it is recorded.
//!
//! One sequence with everything in it is what a careful engineer runs; most logs are of something
//! else: a multisine of a frequency response, trapezoids, an axis at work under position control, a
//! slow scan there and back, a pendulum that swings.

use std::f64::consts::TAU;

use rand::{Rng, RngExt};
use serde::{Deserialize, Serialize};

use super::controller::{Controller, Law};
use super::excitation::{amplitude_v, breakaway_v, excitation};
use crate::model::Model;

/// What is done to the joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Motion {
    /// The standard sequence ([`excitation`]).
    Sequence,
    /// Many lines of random phase at once, open loop.
    Multisine,
    /// Voltage in trapezoids of random height with stops between them.
    Trapezoids,
    /// Moves from point to point under P-PI control.
    MovesPPi,
    /// The same under PD control.
    MovesPd,
    /// Slowly there and back under P-PI control.
    SlowScans,
    /// A pendulum driven near its own frequency, open loop.
    Swings,
}

impl Motion {
    /// Every motion for a joint without gravity.
    pub const LEVEL: [Self; 6] = [
        Self::Sequence,
        Self::Multisine,
        Self::Trapezoids,
        Self::MovesPPi,
        Self::MovesPd,
        Self::SlowScans,
    ];

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sequence => "sequence",
            Self::Multisine => "multisine",
            Self::Trapezoids => "trapezoids",
            Self::MovesPPi => "moves-p-pi",
            Self::MovesPd => "moves-pd",
            Self::SlowScans => "slow-scans",
            Self::Swings => "swings",
        }
    }
}

/// Where the voltage comes from.
#[derive(Clone, Debug)]
pub enum Driver {
    /// Sample by sample, V.
    Open(Vec<f64>),
    /// From what the motor's encoder shows.
    Closed(Box<Controller>),
}

impl Motion {
    /// The voltage, or what makes it, for `count` samples.
    pub fn driver(
        self,
        model: &Model,
        count: usize,
        sample_s: f64,
        random: &mut impl Rng,
    ) -> Driver {
        let full = amplitude_v(model);
        let moving = breakaway_v(model);
        let free = 0.8 * (full - moving) / model.motor.torque_constant_nm_per_a;
        match self {
            Self::Sequence => Driver::Open(excitation(model, count, sample_s, random)),
            Self::Multisine => Driver::Open(multisine(full, count, sample_s, random)),
            Self::Trapezoids => Driver::Open(trapezoids(full, count, sample_s, random)),
            Self::Swings => {
                let own = swing_rate(model).max(TAU / (count as f64 * sample_s));
                Driver::Open(swings(moving, own, count, sample_s, random))
            }
            Self::MovesPPi | Self::MovesPd | Self::SlowScans => {
                let reference = if self == Self::SlowScans {
                    let speed = free * 0.02 * 7.5_f64.powf(random.random());
                    scans(speed, count, sample_s)
                } else {
                    moves(free, count, sample_s, random)
                };
                let law = if self == Self::MovesPd { Law::Pd } else { Law::PPi };
                let bandwidth = TAU * random.random_range(5.0..15.0);
                let controller = Controller::new(law, model, bandwidth, 1.5 * full, reference);
                Driver::Closed(Box::new(controller))
            }
        }
    }
}

/// Small swings of a pendulum that hangs on the joint, rad/s.
fn swing_rate(model: &Model) -> f64 {
    let reduction: f64 = model.stages.iter().map(|stage| stage.reduction.abs()).product();
    let inertia = model.load.inertia_kg_m2
        + model.motor.rotor_inertia_kg_m2 * reduction * reduction
        + model.stages.last().map_or(0.0, |stage| stage.inertia_kg_m2);
    (model.load.gravity_nm.abs() / inertia).sqrt()
}

fn multisine(full: f64, count: usize, sample_s: f64, random: &mut impl Rng) -> Vec<f64> {
    let duration = count as f64 * sample_s;
    let highest = (0.1 / sample_s).min(200.0);
    let lowest = (2.0 / duration).max(0.5);
    let lines = 30;
    let peak = full * random.random_range(0.7..1.2);
    let all: Vec<[f64; 2]> = (0..lines)
        .map(|k| {
            let hertz = lowest * (highest / lowest).powf(f64::from(k) / f64::from(lines - 1));
            // Whole periods in the record.
            [TAU * (hertz * duration).round() / duration, TAU * random.random::<f64>()]
        })
        .collect();
    let at = |k: usize| -> f64 {
        let time = k as f64 * sample_s;
        // Slow lines carry most of the motion, as in a spectrum that falls with the root of frequency.
        all.iter().map(|[omega, phase]| (omega * time + phase).sin() / omega.sqrt()).sum()
    };
    let series: Vec<f64> = (0..count).map(at).collect();
    let highest = series.iter().fold(f64::MIN_POSITIVE, |highest, u| highest.max(u.abs()));
    series.iter().map(|u| peak * u / highest).collect()
}

fn trapezoids(full: f64, count: usize, sample_s: f64, random: &mut impl Rng) -> Vec<f64> {
    let duration = count as f64 * sample_s;
    let mut corners = vec![[0.0, 0.0], [0.02 * duration, 0.0]];
    let mut time = 0.02 * duration;
    let mut sign = 1.0;
    while time < duration {
        let level = sign * full * random.random_range(0.2..1.0);
        let length = random.random_range(0.15..0.6) * (0.1 * duration).clamp(0.25, 1.0) * 2.0;
        let ramp = random.random_range(0.05..0.3) * length;
        corners.push([time + ramp, level]);
        corners.push([time + length - ramp, level]);
        corners.push([time + length, 0.0]);
        time += length + random.random_range(0.0..0.2) * length;
        corners.push([time, 0.0]);
        if random.random_range(0..4) > 0 {
            sign = -sign;
        }
    }
    along(&corners, count, sample_s)
}

/// A broken line through corners of time and value.
fn along(corners: &[[f64; 2]], count: usize, sample_s: f64) -> Vec<f64> {
    let mut after = 0;
    (0..count)
        .map(|k| {
            let time = k as f64 * sample_s;
            while after < corners.len() && corners[after][0] <= time {
                after += 1;
            }
            match (after.checked_sub(1).and_then(|k| corners.get(k)), corners.get(after)) {
                (Some([t0, u0]), Some([t1, u1])) => u0 + (u1 - u0) * (time - t0) / (t1 - t0),
                (Some([_, end]), None) | (None, Some([_, end])) => *end,
                (None, None) => 0.0,
            }
        })
        .collect()
}

/// Reference of moves from point to point, rad: speeds up to `free`, rad/s, in trapezoids.
fn moves(free: f64, count: usize, sample_s: f64, random: &mut impl Rng) -> Vec<f64> {
    let duration = count as f64 * sample_s;
    let mut corners = vec![[0.0, 0.0], [0.03 * duration, 0.0]];
    let (mut time, mut angle) = (0.03 * duration, 0.0_f64);
    while time < duration {
        let speed = free * random.random_range(0.1..0.9);
        let length = random.random_range(0.15..0.5) * (0.15 * duration).clamp(0.5, 2.0);
        // Towards the start, mostly, so that the joint keeps a range of work.
        let back = random.random_range(0..4) > 0;
        let sign = if back { -angle.signum() } else { angle.signum() };
        let sign = if angle == 0.0 { 1.0 } else { sign };
        for part in 1..=24 {
            // The way of a speed that rises over 30 % of the time, holds, and falls.
            let share = f64::from(part) / 24.0;
            let way = match share {
                s if s < 0.3 => s * s / 0.6,
                s if s < 0.7 => s - 0.15,
                s => 0.7 - (1.0 - s) * (1.0 - s) / 0.6,
            };
            corners.push([time + share * length, angle + sign * speed * length * way]);
        }
        angle += sign * speed * length * 0.7;
        time += length + random.random_range(0.02..0.3) * length;
        corners.push([time, angle]);
    }
    along(&corners, count, sample_s)
}

/// Reference of a slow way there and back, rad.
fn scans(speed: f64, count: usize, sample_s: f64) -> Vec<f64> {
    let duration = count as f64 * sample_s;
    let far = speed * 0.48 * duration;
    let corners =
        [[0.0, 0.0], [0.02 * duration, 0.0], [0.5 * duration, far], [0.98 * duration, 0.0]];
    along(&corners, count, sample_s)
}

/// Two sines around a pendulum's own rate, that beat, with a growing size.
fn swings(moving: f64, own: f64, count: usize, sample_s: f64, random: &mut impl Rng) -> Vec<f64> {
    let size = moving * random.random_range(0.6..1.4);
    let rates = [own * random.random_range(0.7..0.95), own * random.random_range(1.05..1.4)];
    let phase = TAU * random.random::<f64>();
    (0..count)
        .map(|k| {
            let (time, share) = (k as f64 * sample_s, k as f64 / count as f64);
            let sum = (rates[0] * time).sin() + (rates[1] * time + phase).sin();
            size * (0.3 + 0.7 * share) * sum
        })
        .collect()
}
