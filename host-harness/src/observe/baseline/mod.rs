//! What drives use today, beside which an observer has to show its worth.
//!
//! All of them get the same model and the same samples. Friction is the Stribeck curve at the
//! estimated speed, springs are linear in the filters' gains; each has one or two free numbers, which
//! [`tuned`] finds by search on a motion of the model itself.

mod common;
mod disturbance;
mod kalman;
mod lugre;
mod spring;

use super::rating::Rating;
use super::run::Seen;
use super::score::Guess;
use crate::model::Model;
use disturbance::disturbance;
use kalman::{Chain, kalman};
use lugre::lugre;
use spring::spring;

/// One of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Baseline {
    /// Momentum observer at the motor: what is left of the torque balance, low-passed.
    Disturbance,
    /// Steady-state Kalman filter of the joint as one inertia.
    Rigid,
    /// The same of the chain with its springs.
    Flexible,
    /// Spring torque from the difference of both encoders, less the output's acceleration.
    Spring,
    /// LuGre run open-loop on the measured speed: friction only.
    LuGre,
}

impl Baseline {
    /// All of them.
    pub const ALL: [Baseline; 5] =
        [Self::Disturbance, Self::Rigid, Self::Flexible, Self::Spring, Self::LuGre];

    /// Its name in a table.
    pub fn name(self) -> &'static str {
        match self {
            Self::Disturbance => "disturbance observer",
            Self::Rigid => "Kalman filter, rigid joint",
            Self::Flexible => "Kalman filter, flexible chain",
            Self::Spring => "spring torque, both encoders",
            Self::LuGre => "LuGre, open loop",
        }
    }

    /// Whether it has something to say of such a joint.
    pub fn applies(self, stages: usize, output: bool) -> bool {
        match self {
            Self::Spring => stages > 0 && output,
            Self::Flexible => stages > 0,
            _ => true,
        }
    }

    fn knobs(self) -> Vec<[f64; 2]> {
        let pairs = |first: &[f64], second: &[f64]| {
            first.iter().flat_map(|a| second.iter().map(|b| [*a, *b])).collect()
        };
        match self {
            Self::Disturbance | Self::Spring => {
                pairs(&[20.0, 40.0, 80.0, 160.0, 320.0, 640.0, 1280.0, 2560.0], &[1.0])
            }
            Self::Rigid | Self::Flexible => pairs(&[0.3, 1.0, 3.0, 10.0, 30.0], &[0.01, 0.1, 1.0]),
            Self::LuGre => pairs(&[100.0, 300.0, 1000.0, 3000.0], &[1.0]),
        }
    }
}

/// The knobs with the smallest error on a motion whose loads (for LuGre: frictions) are known.
pub fn tuned(
    baseline: Baseline,
    model: &Model,
    rating: &Rating,
    step_s: f64,
    seen: &[Seen],
    truth: &[Guess],
) -> [f64; 2] {
    let mut best = (f64::INFINITY, [1.0; 2]);
    for knobs in baseline.knobs() {
        let guesses = run(baseline, knobs, model, rating, step_s, seen);
        let squares = guesses.iter().zip(truth).skip(seen.len() / 10);
        let sum: f64 = squares
            .map(|(guess, truth)| match baseline {
                Baseline::LuGre => (guess.friction - truth.friction).powi(2),
                _ => (guess.load - truth.load).powi(2),
            })
            .sum();
        if sum < best.0 {
            best = (sum, knobs);
        }
    }
    best.1
}

/// Runs a baseline over samples that stand one step apart.
pub fn run(
    baseline: Baseline,
    knobs: [f64; 2],
    model: &Model,
    rating: &Rating,
    step_s: f64,
    seen: &[Seen],
) -> Vec<Guess> {
    match baseline {
        Baseline::Disturbance => disturbance(knobs[0], model, step_s, seen),
        Baseline::Spring => spring(knobs[0], model, step_s, seen),
        Baseline::LuGre => lugre(knobs[0], model, step_s, seen),
        Baseline::Rigid => kalman(&Chain::rigid(model), knobs, model, rating, step_s, seen),
        Baseline::Flexible => kalman(&Chain::flexible(model), knobs, model, rating, step_s, seen),
    }
}
