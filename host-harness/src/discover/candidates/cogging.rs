//! Cogging: lines in the rotor's torque at whole orders of its angle, the same at every current
//! and speed. Every order that the record resolves is tried; the best few become hypotheses, each
//! with its double.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;
use rayon::prelude::*;

use super::super::hypothesis::{Free, Hypothesis};
use super::Scene;
use crate::estimate::record::Channel;

/// Highest order tried.
const HIGHEST: u32 = 144;
/// Orders that become hypotheses.
const KEPT: usize = 3;

pub(super) fn propose(scene: &Scene<'_>) -> Vec<Hypothesis> {
    let scale = 0.05 * scene.torque_scale();
    let taken = |order: f64| {
        scene.model.effects.iter().any(|effect| {
            effect.kind == Kind::Cogging
                && [1.0, 2.0].iter().any(|k| (k * effect.values[0] - order).abs() < 0.5)
        })
    };
    let hypothesis = |order: f64, double: bool| {
        let phasor = |amplitude| Free::Phasor { amplitude, scale, sigma: 200.0 };
        Hypothesis {
            start: EffectParameters::new(Kind::Cogging, Location::Motor).with("order", order),
            free: if double { vec![phasor(1), phasor(3)] } else { vec![phasor(1)] },
        }
    };
    let turned = turned(scene);
    let mut scored: Vec<(f64, f64)> = (1..=HIGHEST)
        .into_par_iter()
        .map(f64::from)
        .filter(|order| order * turned > 2.0 && !taken(*order))
        .map(|order| (scene.test.gain(&hypothesis(order, false)), order))
        .collect();
    scored.sort_by(|a, b| b.0.total_cmp(&a.0));
    scored.iter().take(KEPT).map(|(_, order)| hypothesis(*order, !taken(2.0 * order))).collect()
}

/// Turns between the rotor's extremes.
fn turned(scene: &Scene<'_>) -> f64 {
    let angles = scene.record.measured.iter().map(|row| row[Channel::Motor as usize]);
    let (low, high) = angles
        .filter(|angle| angle.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), a| (low.min(a), high.max(a)));
    (high - low) / std::f64::consts::TAU
}
