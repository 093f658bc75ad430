//! Records on which an observer is designed and judged: the model itself, under loads.
//!
//! A steady-state filter needs no measurement to be designed, only a motion to be linearised along.
//! What it is worth is then found by running it over the same motion seen through the sensors, so
//! the record has what a joint meets: jumps of the load and waves of it, reversals, stops.

use std::f64::consts::TAU;

use joint_core::joint::Drive;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::rating::Rating;
use crate::grid::Grid;
use crate::model::Model;
use crate::plant::{BuildError, Layout, plant};

/// A motion of the joint whose every quantity is known.
#[derive(Clone, Debug)]
pub struct Twin {
    /// Applied drive by sample, V or A.
    pub drive: Vec<f64>,
    /// Load by sample, Nm.
    pub load: Vec<f64>,
    /// States by sample, as a plant has them.
    pub states: Vec<Vec<f64>>,
    /// Samples whose load has jumped.
    pub jumps: Vec<usize>,
}

/// Noise that acts on the joint itself, one sigma held over a sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Felt {
    /// On the drive, V or A.
    pub drive: f64,
    /// On the rotor, Nm.
    pub torque: f64,
}

/// How a joint is moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Style {
    /// Reversals, stops and slow passages through zero as often as may be: where gains are designed.
    Creep,
    /// Trapezoids, a wandering part and steps over the whole of the rating, as a drive at work.
    Duty,
}

impl Style {
    /// Samples that a motion of this style is to have.
    pub const fn samples(self) -> usize {
        match self {
            Self::Creep => 5000,
            Self::Duty => 10_000,
        }
    }
}

/// A motion to be made: which joint, for how long, and how it is driven and loaded.
#[derive(Clone, Copy, Debug)]
pub struct Motion<'a> {
    /// The joint as it is.
    pub truth: &'a Model,
    /// What its drive imposes.
    pub kind: Drive,
    /// Time between samples, s.
    pub step_s: f64,
    /// Within which the drive and the load stay.
    pub rating: &'a Rating,
    /// Noise on the joint.
    pub felt: Felt,
    /// How it moves.
    pub style: Style,
    /// For how many samples.
    pub samples: usize,
    /// Of everything random.
    pub seed: u64,
}

impl Motion<'_> {
    /// Makes it.
    ///
    /// # Errors
    /// The model cannot be built.
    pub fn run(&self) -> Result<Twin, BuildError> {
        let Self { rating, samples, .. } = *self;
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        let (drive, load) = match self.style {
            Style::Creep => {
                (drive(rating, samples, &mut random), load(rating.load_nm, samples, &mut random))
            }
            Style::Duty => {
                let drive = duty(rating, samples, &mut random);
                (drive, duty_load(rating.load_nm, samples, &mut random))
            }
        };
        self.along(drive, load, random)
    }

    /// Makes it under a drive and a load that are given.
    ///
    /// # Errors
    /// The model cannot be built.
    pub fn under(&self, drive: Vec<f64>, load: Vec<f64>) -> Result<Twin, BuildError> {
        self.along(drive, load, ChaCha8Rng::seed_from_u64(self.seed))
    }

    fn along(
        &self,
        mut drive: Vec<f64>,
        load: Vec<f64>,
        mut random: ChaCha8Rng,
    ) -> Result<Twin, BuildError> {
        let Self { truth, kind, step_s, felt, .. } = *self;
        let jumps = super::score::jumps(&load);
        let times: Vec<f64> = (0..drive.len()).map(|k| k as f64 * step_s).collect();
        let grid = Grid::new(&times, None);
        let plant = plant(truth, &grid, kind)?;
        let layout = Layout::of(truth);
        let inertia = crate::plant::inertias(truth)[0];
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        let mut state = vec![0.0; layout.len()];
        let mut states = Vec::with_capacity(drive.len());
        for (k, (drive, load)) in drive.iter_mut().zip(&load).enumerate() {
            if kind == Drive::Current {
                *drive = self.limited(*drive, state[layout.speed(0)]);
                state[Layout::CURRENT] = *drive;
            }
            states.push(state.clone());
            plant.propagate(k, &mut state, *drive + felt.drive * normal(), *load);
            state[layout.speed(0)] += felt.torque * normal() * step_s / inertia;
        }
        Ok(Twin { drive, load, states, jumps })
    }
}

impl Motion<'_> {
    /// A current that falls as the rotor comes to its largest speed: what a drive's own limit does, and
    /// what a voltage does by itself.
    fn limited(&self, current: f64, speed: f64) -> f64 {
        let most = self.rating.drive;
        (current - most * (speed / self.rating.speed).powi(3)).clamp(-most, most)
    }
}

/// Ramps, holds, reversals, a wandering part, steps and slow passages through zero.
fn drive(rating: &Rating, samples: usize, random: &mut ChaCha8Rng) -> Vec<f64> {
    let most = rating.drive;
    let parts = 20;
    let length = samples.div_ceil(parts).max(1);
    let mut values = Vec::with_capacity(samples);
    let mut now = 0.0;
    let mut sign = 1.0;
    for part in 0..parts {
        let level = most * random.random_range(0.3..1.0);
        let style = part % 5;
        sign = if random.random::<f64>() < 0.75 { -sign } else { sign };
        let target = sign * level;
        let (start, mut wander) = (now, 0.0);
        for k in 0..length {
            let share = k as f64 / length as f64;
            now = match style {
                0 if part == 0 => 0.0,
                0 => start + (0.3 * target - start) * share,
                1 | 3 => start + (target - start) * (3.0 * share).min(1.0),
                2 => {
                    wander = 0.98 * wander + 0.06 * most * random.random_range(-1.0..1.0);
                    0.5 * target * (3.0 * share).min(1.0) + wander
                }
                _ if part % 10 == 9 => 0.15 * most * (TAU * 4.0 * share).sin() * share,
                _ => target,
            };
            values.push(now);
        }
    }
    values.truncate(samples);
    values
}

/// A slow start, trapezoids, a wandering part, steps, and a slow end about zero.
fn duty(rating: &Rating, samples: usize, random: &mut ChaCha8Rng) -> Vec<f64> {
    let most = rating.drive;
    let mut values = Vec::with_capacity(samples);
    let mut now = 0.0_f64;
    let mut part = |share: f64, at: &mut dyn FnMut(f64, f64) -> f64| {
        let length = (share * samples as f64) as usize;
        let start = now;
        for k in 0..length {
            now = at(start, k as f64 / length as f64);
            values.push(now);
        }
    };
    part(0.03, &mut |_, _| 0.0);
    for (share, target) in [(0.07, 0.5), (0.06, -0.5), (0.06, 0.1)] {
        let target = target * most * random.random_range(0.6..1.2);
        part(share, &mut |start, place| start + (target - start) * place);
    }
    let mut sign = if random.random() { 1.0 } else { -1.0 };
    for _ in 0..6 {
        let target = sign * most * random.random_range(0.6..1.0);
        part(0.05, &mut |start, place| start + (target - start) * (2.0 * place).min(1.0));
        sign = if random.random::<f64>() < 0.8 { -sign } else { sign };
    }
    let (mut slow, mut fast, mut hold) = (0.0, 0.0, 0.0);
    part(0.2, &mut |_, place| {
        if (place * 40.0).fract() < 1.0 / (0.005 * samples as f64) {
            hold = most * random.random_range(-0.8..0.8);
        }
        slow += 0.02 * (hold - slow);
        fast = 0.9 * fast + 0.05 * most * random.random_range(-1.0..1.0);
        (slow + fast).clamp(-most, most)
    });
    for _ in 0..8 {
        let target = most * random.random_range(-1.0..1.0);
        part(0.025, &mut |_, _| target);
    }
    let waves = random.random_range(3.0..8.0);
    part(1.0, &mut |_, place| 0.2 * most * place * (TAU * waves * 10.0 * place).sin());
    values.truncate(samples);
    values
}

/// Nothing, jumps, and waves of several lengths.
fn load(most: f64, samples: usize, random: &mut ChaCha8Rng) -> Vec<f64> {
    let parts = 14;
    let length = samples.div_ceil(parts).max(1);
    let mut values: Vec<f64> = Vec::with_capacity(samples);
    let mut held = most;
    for part in 0..parts {
        let sign = if random.random() { 1.0 } else { -1.0 };
        let level = sign * most * random.random_range(0.5..1.0);
        // From half a wave to eight in a part.
        let waves = random.random_range(0.0_f64..4.0).exp2() * 0.5;
        for k in 0..length {
            let share = k as f64 / length as f64;
            values.push(match part % 7 {
                2 | 3 => held,
                5 => level * (TAU * waves * share).sin(),
                _ => 0.0,
            });
        }
        held = if part % 7 == 2 { held } else { level };
    }
    values.truncate(samples);
    values
}

/// Nothing, a load that is put on and taken off, a ramp, and waves of 200 to 2000 samples that end
/// at once.
fn duty_load(most: f64, samples: usize, random: &mut ChaCha8Rng) -> Vec<f64> {
    let mut values: Vec<f64> = Vec::with_capacity(samples);
    let level = |random: &mut ChaCha8Rng| {
        let sign = if random.random() { 1.0 } else { -1.0 };
        sign * most * random.random_range(0.5..1.0)
    };
    let [step, ramp, wave] = [level(random), level(random), level(random)];
    let period = 200.0 * random.random_range(0.0_f64..3.3).exp2();
    let begin = random.random_range(0.15..0.3);
    for k in 0..samples {
        let share = k as f64 / samples as f64 - begin;
        values.push(match share {
            s if s < 0.0 => 0.0,
            s if s < 0.15 => step,
            s if s < 0.2 => 0.0,
            s if s < 0.3 => ramp * (s - 0.2) / 0.1,
            s if s < 0.35 => ramp,
            s if s < 0.6 => wave * (TAU * (s - 0.35) * samples as f64 / period).sin(),
            _ => 0.0,
        });
    }
    values
}
